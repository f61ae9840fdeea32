// See shared_keyframe.h. In the file, rank 0's chunk comes first; its head says how many bytes the chunks of
// the other ranks take behind it. Where a rank dies meanwhile, readers find that not all of these are there,
// and drop the keyframe.
#include <core/state/recording_format/recorded_state.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/world_parts.h>
#include <parallel/recording/shared_keyframe.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace scree {

namespace {

// What all ranks must know of each one's part.
struct PartPlace {
  std::uint64_t bytes;  // with its head
  std::uint64_t step;   // of the recording; rank 0 knows
  std::uint64_t begin;  // of the keyframe in the file; rank 0 knows
};

// Packs rank 0's state. What happened before it is in the file then.
void pack_state(World& world, SharedRecorder::Impl& recorder, ByteWriter& content, ChunkPacker& packer) {
  SnapshotData state;
  save_first_part(world, state);
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

// What work() throws, as an Error.
template <class Work>
std::optional<Error> attempt(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return Error("memory ran out", ErrorCode::out_of_memory);
  } catch (const std::exception& error) {
    return Error(error.what(), ErrorCode::io_failure);
  }
  return {};
}

// All ranks go on alike where one has a problem.
std::optional<Error> agree(CountedTransport& transport, std::optional<Error> problem,
                           const std::string& file) {
  if (transport.holds_everywhere(!problem) || problem) return problem;
  return Error(file + ": another rank cannot write its part of a keyframe", ErrorCode::io_failure);
}

std::optional<Error> write_own_part(World& world, SharedRecorder::Impl* recorder, const std::string& file,
                                    int compression_level, Crew& crew) {
  CountedTransport& transport = border_of(internals(world))->transport;
  ByteWriter content;
  std::optional<ChunkPacker> packer;
  std::optional<Error> problem = attempt([&] {
    packer.emplace(compression_level);
    if (recorder != nullptr) return pack_state(world, *recorder, content, *packer);
    pack_messages(world, crew, content, *packer);
  });
  problem = agree(transport, std::move(problem), file);
  if (problem) return problem;
  PartPlace own{packer->packed().bytes(), 0, 0};
  if (recorder != nullptr) own = {own.bytes, recorder->position(), recorder->writer.bytes_written()};
  const std::vector<PartPlace> places = gather_rows(transport, own);
  std::uint64_t begin = places[0].begin, behind_first = 0;
  for (std::size_t rank = 0; rank < places.size(); ++rank) {
    if (std::cmp_less(rank, transport.rank())) begin += places[rank].bytes;
    if (rank > 0) behind_first += places[rank].bytes;
  }
  const ChunkPacker::Packed packed =
      packer->place(places[0].step, recorder != nullptr ? behind_first : places.size());
  std::vector<std::byte> part;
  problem = attempt([&] {
    if (recorder != nullptr) return recorder->writer.write_packed(packed);
    part.assign(packed.head.begin(), packed.head.end());
    part.insert(part.end(), packed.stored.begin(), packed.stored.end());
  });
  problem = agree(transport, std::move(problem), file);
  if (problem || places.size() == 1) return problem;
  problem = attempt([&] { transport.write_together(file, begin, part); });
  if (recorder != nullptr && !problem) problem = attempt([&] { recorder->writer.skip(behind_first); });
  return agree(transport, std::move(problem), file);
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
