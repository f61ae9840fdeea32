// libFuzzer's program for recordings. It changes the content of chunks and packs them again: random changes
// of compressed and sealed bytes would hardly get past the checksums.
#include <core/state/recording_format/recorded_state.h>
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <tests/fuzz/mutation.h>

#include <algorithm>
#include <string>

namespace scree::fuzz {

namespace {

constexpr std::size_t kMostContent = 64 << 10;

struct Chunk {
  ChunkHead head;
  Buffer content;
};

struct Recording {
  std::string writer;
  std::vector<Chunk> chunks;
};

// Reads the part of a recording that is intact. Throws Error if the bytes are no recording.
Recording unpack(std::span<const std::byte> bytes) {
  Recording recording;
  const RecordingHead head = read_recording_head(bytes);
  recording.writer = head.writer;
  for (std::size_t at = head.bytes; bytes.size() - at >= kChunkHeadBytes;) {
    const ChunkHead chunk = read_chunk_head(bytes.subspan(at, kChunkHeadBytes));
    at += kChunkHeadBytes;
    if (chunk.stored_bytes > bytes.size() - at || chunk.content_bytes > kMostContent) break;
    const auto stored = bytes.subspan(at, static_cast<std::size_t>(chunk.stored_bytes));
    at += stored.size();
    recording.chunks.push_back({chunk, unpack_chunk(chunk, Buffer(stored.begin(), stored.end()))});
  }
  return recording;
}

Buffer pack(const Recording& recording) {
  ChunkPacker packer(1);
  std::vector<Buffer> packed_chunks;  // from the last one on
  std::uint64_t part_bytes = 0;       // of the parts behind a keyframe
  for (auto chunk = recording.chunks.rbegin(); chunk != recording.chunks.rend(); ++chunk) {
    ChunkHead head = chunk->head;
    head.flags &= kChunkMayBeSkipped;
    if (head.kind == ChunkKind::keyframe && head.count > 0) head.count = part_bytes;
    const ChunkPacker::Packed packed = packer.pack(head, chunk->content);
    part_bytes = head.kind == ChunkKind::part ? part_bytes + packed.bytes() : 0;
    Buffer& bytes = packed_chunks.emplace_back(packed.head.begin(), packed.head.end());
    bytes.insert(bytes.end(), packed.stored.begin(), packed.stored.end());
  }
  Buffer bytes = write_recording_head(recording.writer);
  for (auto chunk = packed_chunks.rbegin(); chunk != packed_chunks.rend(); ++chunk)
    bytes.insert(bytes.end(), chunk->begin(), chunk->end());
  return bytes;
}

// Gives a changed state the hash that belongs to it, as far as the state can be read.
void seal_state(Buffer& content, const SolidVectors& solids) {
  try {
    ByteReader reader(content, "the state");
    reader.take<std::uint64_t>();
    SnapshotData data;
    read_world(reader, data.world);
    data.hulls = read_slots(reader, solids.hulls);
    data.meshes = read_mesh_slots(reader, solids.meshes);
    read_columns(reader, data);
    const std::uint64_t hash = hash_of_state(data);
    std::memcpy(content.data(), &hash, sizeof hash);
  } catch (const Error&) {
    // The reader will refuse it before it compares the hash.
  }
}

SolidVectors solids_of(const Recording& recording) {
  SolidVectors solids;
  for (const Chunk& chunk : recording.chunks) {
    try {
      ByteReader reader(chunk.content, "the chunk");
      if (chunk.head.kind == ChunkKind::hulls) read_solids(reader, solids.hulls);
      if (chunk.head.kind == ChunkKind::meshes) read_mesh_solids(reader, solids.meshes);
    } catch (const Error&) {
      break;
    }
  }
  return solids;
}

void mutate_head(ChunkHead& head, scenes::Random& random) {
  const std::uint32_t what = random.below(8);
  if (what == 0) {
    head.kind = static_cast<ChunkKind>(random.below(9));
  } else if (what == 1) {
    head.flags ^= kChunkMayBeSkipped;
  } else {
    std::uint64_t& number = what < 4 ? head.step : what < 6 ? head.steps : head.count;
    constexpr std::uint64_t kNumbers[] = {0, 1, 2, 300, 0x7fffffff, 0xffffffff, ~std::uint64_t{0}};
    number = random.below(2) == 0 ? number + (random.below(2) == 0 ? 1 : ~std::uint64_t{0})
                                  : kNumbers[random.below(7)];
  }
}

void mutate_content(Buffer& content, scenes::Random& random) {
  const std::uint32_t how = random.below(8);
  if (how < 3) return put_a_word(content, random);
  if (how < 5) return mutate_in_place(content);
  if (how < 7 || content.size() < 2)
    return mutate_freely(content, std::min(content.size() + 256, kMostContent));
  // A part of it once more: a call that is made twice.
  const std::size_t begin = random.below(static_cast<std::uint32_t>(content.size()));
  const std::size_t count = std::min<std::size_t>(1 + random.below(128), content.size() - begin);
  const Buffer part(content.begin() + static_cast<std::ptrdiff_t>(begin),
                    content.begin() + static_cast<std::ptrdiff_t>(begin + count));
  content.insert(content.begin() + static_cast<std::ptrdiff_t>(begin), part.begin(), part.end());
}

void mutate(Recording& recording, scenes::Random& random) {
  std::vector<Chunk>& chunks = recording.chunks;
  const auto count = static_cast<std::uint32_t>(chunks.size());
  const std::size_t place = random.below(count);
  const auto at = chunks.begin() + static_cast<std::ptrdiff_t>(place);
  switch (random.below(16)) {
    case 0:
      chunks.erase(at);
      return;
    case 1: {
      const Chunk copy = *at;
      chunks.insert(chunks.begin() + random.below(count + 1), copy);
      return;
    }
    case 2:
      std::swap(*at, chunks[random.below(count)]);
      return;
    case 3:
    case 4:
      mutate_head(at->head, random);
      return;
    default:
      mutate_content(at->content, random);
      break;
  }
  const bool is_state = at->head.kind == ChunkKind::keyframe || at->head.kind == ChunkKind::restored;
  if (is_state && random.below(16) != 0) seal_state(at->content, solids_of(recording));
}

Buffer mutated(std::span<const std::byte> bytes, std::size_t most, scenes::Random& random) {
  Buffer result(bytes.begin(), bytes.end());
  try {
    Recording recording = unpack(bytes);
    for (std::uint32_t left = 1 + random.below(3); left > 0 && !recording.chunks.empty(); --left) {
      mutate(recording, random);
    }
    result = pack(recording);
    if (random.below(32) != 0 && result.size() <= most) return result;
  } catch (const Error&) {
    // No recording: mutates the plain bytes.
  }
  if (result.size() > most) result.resize(most);
  mutate_freely(result, most);
  return result;
}

}  // namespace

}  // namespace scree::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  scree::fuzz::recording_target({data, bytes});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t bytes, std::size_t most,
                                               unsigned seed) {
  scree::scenes::Random random(seed);
  const std::span<const std::byte> input(reinterpret_cast<const std::byte*>(data), bytes);
  const scree::fuzz::Buffer result = scree::fuzz::mutated(input, most, random);
  std::copy(result.begin(), result.end(), reinterpret_cast<std::byte*>(data));
  return result.size();
}
