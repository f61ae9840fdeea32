// Shared by the tests of recordings: temporary files, sample worlds, and tools that take recordings apart and
// reassemble them.
#pragma once

#include <core/state/recording_format/call_bytes.h>
#include <core/state/recording_format/recording_chunks.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree::test {

using Bytes = std::vector<std::byte>;

inline constexpr float kDt = 1.0f / 60.0f;  // s

// A temporary file; the destructor deletes it.
class TemporaryFile {
 public:
  TemporaryFile() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("scree_recording_" + std::to_string(getpid()) + "_" + std::to_string(++count));
    remove();  // an earlier process of the same number may have been killed and left one
  }
  ~TemporaryFile() { remove(); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  std::string path() const { return path_.string(); }
  Bytes bytes() const {
    std::ifstream stream(path_, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
  }

 private:
  void remove() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  std::filesystem::path path_;
};

inline Hull wedge() {
  const Vec3 points[] = {{0.5f, -0.3f, 0.4f},   {0.5f, -0.3f, -0.4f}, {-0.5f, -0.3f, 0.4f},
                         {-0.5f, -0.3f, -0.4f}, {0.0f, 0.5f, 0.3f},   {0.1f, 0.5f, -0.3f}};
  return Hull(points);
}

// A floor, and some of every shape falling on it.
struct Heap {
  World world{WorldSettings{.contact_events = ContactEvents::begin_end}};
  std::vector<BodyId> bodies;
  std::vector<ShapeId> shapes;
  Workers workers{1};

  explicit Heap(int size = 12) {
    add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{20, 1, 20}});
    add({.type = BodyType::kinematic, .position = {2, 0.2f, 0}}, Box{{0.5f, 0.2f, 0.5f}});
    for (int i = 0; i < size; ++i) {
      const BodyDef def{.position = {0.3f * static_cast<float>(i % 3), 0.6f + 0.5f * static_cast<float>(i),
                                     0.2f * static_cast<float>(i % 2)}};
      switch (i % 4) {
        case 0:
          add(def, Sphere{0.3f});
          break;
        case 1:
          add(def, Capsule{0.3f, 0.2f});
          break;
        case 2:
          add(def, Box{{0.3f, 0.2f, 0.4f}});
          break;
        default:
          add(def, ConvexHull{wedge(), {0.8f, 1.0f, 0.9f}});
          break;
      }
    }
  }
  BodyId add(const BodyDef& def, const Geometry& geometry) {
    bodies.push_back(world.create_body(def));
    shapes.push_back(world.add_shape(bodies.back(), geometry));
    return bodies.back();
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kDt, workers);
  }
};

// A recording as its chunks, with contents that can be changed.
struct TakenApart {
  struct Chunk {
    ChunkHead head;
    Bytes content;
    std::size_t offset;  // as it was read
  };
  Bytes head;
  std::vector<Chunk> chunks;

  explicit TakenApart(const Bytes& bytes) {
    head.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(read_recording_head(bytes).bytes));
    for (std::size_t at = head.size(); at < bytes.size();) {
      const std::span<const std::byte> rest = std::span(bytes).subspan(at);
      const ChunkHead chunk = read_chunk_head(rest);
      const std::span<const std::byte> stored =
          rest.subspan(kChunkHeadBytes, static_cast<std::size_t>(chunk.stored_bytes));
      chunks.push_back({chunk, unpack_chunk(chunk, Bytes(stored.begin(), stored.end())), at});
      at += kChunkHeadBytes + stored.size();
    }
  }
  // Recomputes every checksum, and how many bytes the parts behind a keyframe, or what may be skipped, have.
  Bytes put_together() const {
    std::vector<Bytes> packed_chunks;  // from the last one on
    ChunkPacker packer(1);
    std::uint64_t part_bytes = 0;
    for (auto chunk = chunks.rbegin(); chunk != chunks.rend(); ++chunk) {
      ChunkHead plain = chunk->head;
      plain.flags &= kChunkMayBeSkipped;
      if (plain.kind == ChunkKind::keyframe && plain.count > 0) plain.count = part_bytes;
      const ChunkPacker::Packed packed = packer.pack(plain, chunk->content);
      const bool is_part = plain.kind == ChunkKind::part || (plain.flags & kChunkMayBeSkipped) != 0;
      part_bytes = is_part ? part_bytes + packed.bytes() : 0;
      Bytes& bytes = packed_chunks.emplace_back(packed.head.begin(), packed.head.end());
      bytes.insert(bytes.end(), packed.stored.begin(), packed.stored.end());
    }
    Bytes all = head;
    for (auto bytes = packed_chunks.rbegin(); bytes != packed_chunks.rend(); ++bytes)
      all.insert(all.end(), bytes->begin(), bytes->end());
    return all;
  }
  // Contents of the chunks that do not depend on the clock.
  std::vector<Bytes> states() const {
    std::vector<Bytes> contents;
    for (const Chunk& chunk : chunks) {
      if (chunk.head.kind != ChunkKind::calls) contents.push_back(chunk.content);
    }
    return contents;
  }
  Chunk* find(ChunkKind kind) {
    for (Chunk& chunk : chunks) {
      if (chunk.head.kind == kind) return &chunk;
    }
    return nullptr;
  }
};

// Visits the records of steps in a chunk. Calls `see` with the index of each record.
template <class See>
std::vector<std::size_t> places_of_steps(const Bytes& content, See&& see) {
  std::vector<std::size_t> places;
  CallReader reader(content, std::nullopt);
  while (reader.left() > 0) {
    const std::size_t at = reader.at();
    const auto call = static_cast<RecordedCall>(reader.take<std::uint8_t>());
    see(call);
    if (call == RecordedCall::step) {
      places.push_back(at);
      reader.take_bytes(kStepRecordBytes - 1);
    } else {
      take_call(call, reader, nullptr);
    }
  }
  return places;
}

// Changes the hash of a step that is not the recording's last; false if the chunk holds no such step.
inline bool change_hash(TakenApart::Chunk& chunk, std::uint64_t step) {
  if (chunk.head.kind != ChunkKind::calls || step <= chunk.head.step ||
      step > chunk.head.step + chunk.head.steps) {
    return false;
  }
  const std::vector<std::size_t> places = places_of_steps(chunk.content, [](RecordedCall) {});
  const std::size_t place = places[static_cast<std::size_t>(step - chunk.head.step - 1)];
  chunk.content[place + kStepRecordBytes - 1] ^= std::byte{1};
  return true;
}

template <class Work>
std::string error_of_call(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

// Empty if the whole recording verifies.
inline std::string verified(Player& player, Workers& workers) {
  const std::optional<Divergence> found =
      player.verify(player.info().first_step, player.info().last_step, workers);
  return found ? "step " + std::to_string(found->step) + ": " + found->difference : std::string();
}

inline std::vector<std::uint64_t> keyframe_steps(const Player& player) {
  return {player.keyframe_steps().begin(), player.keyframe_steps().end()};
}

// Keyframes and chunks frequent enough for short recordings to have some.
inline constexpr RecorderOptions kOften{.keyframe_spacing = 15, .flush_interval = 0.01f};

inline Bytes cut(const Bytes& bytes, std::size_t length) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)};
}

// Small, and of many chunks: the file is made here, without a clock.
inline Bytes small_recording(bool finished = true) {
  const TemporaryFile file;
  Heap heap(5);
  Recorder recorder(heap.world, file.path(), kOften);
  for (int i = 0; i < 40; ++i) {
    if (i % 8 == 3) heap.add({.position = {0, 3, 0.1f * static_cast<float>(i)}}, ConvexHull{wedge()});
    heap.world.add_force(heap.bodies[3], {0.5f, 0.0f, static_cast<float>(i)});
    heap.run(1);
    if (i % 10 == 9) std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  recorder.finish();
  const Bytes bytes = file.bytes();
  return finished ? bytes : cut(bytes, bytes.size() - kChunkHeadBytes);
}

}  // namespace scree::test
