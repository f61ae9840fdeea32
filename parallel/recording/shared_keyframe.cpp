// See shared_keyframe.h. In the file, rank 0's chunk comes first; its head says how many bytes the chunks of
// the other ranks take behind it. Where a rank dies meanwhile, readers find that not all of these are there,
// and drop the keyframe.
#include <core/state/recording_format/recorded_state.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/no_file_signal.h>
#include <parallel/distributed/world_parts.h>
#include <parallel/recording/shared_keyframe.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

constexpr std::int32_t kNoProblem = -1;
constexpr std::size_t kMostText = 1000;  // of what ranks say

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

// All ranks go on alike where some have a problem, and with all that these say: who could have done its part
// knows little.
std::optional<Error> agree(CountedTransport& transport, const std::optional<Error>& problem) {
  if (transport.holds_everywhere(!problem)) return {};
  const std::vector<std::int32_t> codes =
      gather_rows(transport, problem ? static_cast<std::int32_t>(problem->code()) : kNoProblem);
  std::string own;
  if (problem) own = "rank " + std::to_string(transport.rank()) + ": " + problem->what() + "; ";
  const std::vector<char> all =
      gather_lists<char>(transport, std::vector<char>(own.begin(), own.end()), [](char) { return true; });
  std::string text(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), kMostText)));
  if (text.ends_with("; ")) text.resize(text.size() - 2);
  const auto has_failed = [](std::int32_t code) { return code != kNoProblem; };
  return Error(text, static_cast<ErrorCode>(*std::find_if(codes.begin(), codes.end(), has_failed)));
}

// Where the parts of ranks begin; rank 0's is the first.
std::uint64_t begin_of(const std::vector<PartPlace>& places, std::size_t rank) {
  std::uint64_t begin = places[0].begin;
  for (std::size_t i = 0; i < rank; ++i) begin += places[i].bytes;
  return begin;
}

std::optional<Error> write_own_part(World& world, SharedRecorder::Impl* recorder, const std::string& file,
                                    int compression_level, Crew& crew) {
  CountedTransport& transport = border_of(internals(world))->transport;
  const NoFileSignal guard;
  ByteWriter content;
  std::optional<ChunkPacker> packer;
  std::optional<Error> problem = agree(transport, attempt([&] {
                                         packer.emplace(compression_level);
                                         if (recorder != nullptr)
                                           return pack_state(world, *recorder, content, *packer);
                                         pack_messages(world, crew, content, *packer);
                                       }));
  if (problem) return problem;
  PartPlace own{packer->packed().bytes(), 0, 0};
  if (recorder != nullptr) own = {own.bytes, recorder->position(), recorder->writer.bytes_written()};
  const std::vector<PartPlace> places = gather_rows(transport, own);
  const std::uint64_t behind_first = begin_of(places, places.size()) - begin_of(places, 1);
  std::vector<std::byte> part;
  problem = agree(transport, attempt([&] {
                    const ChunkPacker::Packed packed =
                        packer->place(places[0].step, recorder != nullptr ? behind_first : places.size());
                    if (recorder == nullptr) {
                      part.assign(packed.head.begin(), packed.head.end());
                      part.insert(part.end(), packed.stored.begin(), packed.stored.end());
                      return;
                    }
                    recorder->writer.write_packed(packed);
                    if (behind_first > 0) recorder->writer.share(file);
                  }));
  if (problem || places.size() == 1) return problem;
  const std::uint64_t begin = begin_of(places, static_cast<std::size_t>(transport.rank()));
  problem = attempt([&] { transport.write_together(file, begin, part); });
  return agree(transport, attempt([&] {
                 if (problem) throw Error(*problem);
                 if (recorder != nullptr) recorder->writer.take_back(file, behind_first);
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
