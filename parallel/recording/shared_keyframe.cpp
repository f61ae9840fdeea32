// See shared_keyframe.h. In the file, what all ranks have in common comes first; the head of that chunk says
// how many bytes the ranks' chunks take behind it. Where a rank dies meanwhile, readers find that not all of
// these are there, and drop the keyframe.
#include <core/state/recording_format/recorded_state.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/no_file_signal.h>
#include <parallel/distributed/world_parts.h>
#include <parallel/recording/shared_keyframe.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

// What all ranks must know of each one's part.
struct PartPlace {
  std::uint64_t bytes;  // with its head
  std::uint64_t step;   // of the recording; rank 0 knows
  std::uint64_t begin;  // of the parts in the file; rank 0 knows
};

// Packs what all ranks have in common, on rank 0. What happened before it is in the file then.
void pack_state(World& world, SharedRecorder::Impl& recorder, ByteWriter& content, ChunkPacker& packer) {
  SnapshotData state;
  save_common(world, state);
  const SlotNumbers numbers = recorder.solids.numbers_of(state.hulls, state.meshes);
  SolidVectors new_solids;
  recorder.append_new_solids(new_solids);
  recorder.writer.add_solids(recorder.position(), std::move(new_solids));
  write_state(state, numbers, content);
  packer.pack({.kind = ChunkKind::keyframe}, content.bytes());
  recorder.writer.wait_until_written();
  if (recorder.writer.has_failed()) recorder.writer.throw_error("");
}

void pack_messages(World& world, Crew& crew, ByteWriter& content, ChunkPacker& packer) {
  content.put(layout_of_parts());
  const std::vector<std::byte> messages = messages_of_part(world, crew);
  content.put_bytes(messages.data(), messages.size());
  packer.pack({.kind = ChunkKind::part}, content.bytes());
}

// A chunk before it is known where in the recording it stands.
struct Chunk {
  explicit Chunk(int compression_level) : packer(compression_level) {}
  ByteWriter content;
  ChunkPacker packer;
};

// Where a rank's part begins; rank 0's is the first, behind the keyframe.
std::uint64_t begin_of(const std::vector<PartPlace>& places, std::size_t rank) {
  std::uint64_t begin = places[0].begin;
  for (std::size_t i = 0; i < rank; ++i) begin += places[i].bytes;
  return begin;
}

std::vector<std::byte> bytes_of(const ChunkPacker::Packed& packed) {
  std::vector<std::byte> bytes(packed.head.begin(), packed.head.end());
  bytes.insert(bytes.end(), packed.stored.begin(), packed.stored.end());
  return bytes;
}

std::optional<Error> write_own_part(World& world, SharedRecorder::Impl* recorder, const std::string& file,
                                    int compression_level, Crew& crew) {
  CountedTransport& transport = border_of(internals(world))->transport;
  const NoFileSignal guard;
  std::optional<Chunk> common, own;
  std::optional<Error> problem = agree(transport, attempt([&] {
                                         if (recorder != nullptr) {
                                           common.emplace(compression_level);
                                           pack_state(world, *recorder, common->content, common->packer);
                                         }
                                         if (!has_parts(world)) return;
                                         own.emplace(compression_level);
                                         pack_messages(world, crew, own->content, own->packer);
                                       }));
  if (problem) return problem;
  PartPlace place{own ? own->packer.packed().bytes() : 0, 0, 0};
  if (recorder != nullptr) {
    place.step = recorder->position();
    place.begin = recorder->writer.bytes_written() + common->packer.packed().bytes();
  }
  const std::vector<PartPlace> places = gather_rows(transport, place);
  const std::uint64_t all_parts = begin_of(places, places.size()) - places[0].begin;
  std::vector<std::byte> part;
  problem = agree(transport, attempt([&] {
                    if (own) part = bytes_of(own->packer.place(places[0].step, places.size()));
                    own.reset();
                    if (recorder == nullptr) return;
                    recorder->writer.write_packed(common->packer.place(places[0].step, all_parts));
                    if (all_parts > 0) recorder->writer.share(file);
                  }));
  if (problem || all_parts == 0) return problem;
  const std::uint64_t begin = begin_of(places, static_cast<std::size_t>(transport.rank()));
  problem = attempt([&] { transport.write_together(file, begin, part); });
  return agree(transport, attempt([&] {
                 if (problem) throw Error(*problem);
                 if (recorder != nullptr) recorder->writer.take_back(file, all_parts);
               }));
}

}  // namespace

std::optional<Error> write_shared_keyframe(World& world, SharedRecorder::Impl* recorder,
                                           const std::string& file, int compression_level, Crew& crew) {
  CountedTransport& transport = border_of(internals(world))->transport;
  const bool can = recorder == nullptr || (recorder->data != nullptr && recorder->can_add_keyframe());
  if (!transport.holds_everywhere(can)) return {};
  std::optional<Error> problem = write_own_part(world, recorder, file, compression_level, crew);
  if (recorder == nullptr) return problem;
  if (problem) {
    recorder->writer.fail(problem->what(), problem->code());
    recorder->end(false);
  } else {
    recorder->note_keyframe();
  }
  return problem;
}

}  // namespace scree
