// Plays recordings on many ranks. What a rank makes of calls and steps is its part of the world; all of them
// read the same file.
#include <parallel/crew/crew.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/checkpoint.h>
#include <parallel/distributed/messages.h>
#include <parallel/recording/part_chunks.h>
#include <parallel/recording/recording_file.h>
#include <scree/distributed_world.h>
#include <scree/error.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

[[noreturn]] void refuse(const std::string& file, const Error& problem) {
  throw Error("play_recording: " + file + ": " + problem.what(), problem.code());
}

// Of what was read: as a rank refuses messages, which says nothing of files.
Error as_damage(const Error& error) {
  if (error.code() != ErrorCode::invalid_value) return error;
  return Error(std::string("the parts of a keyframe do not fit: ") + error.what(), ErrorCode::corrupt_data);
}

// Does the work on all ranks, or throws on all of them, with the name of the file.
template <class Work>
void do_together(Transport& transport, const std::string& file, Work&& work) {
  if (const std::optional<Error> problem = agree(transport, attempt(work))) refuse(file, *problem);
}

// Throws Error where the recording has no such steps.
void check_steps(const RecordingInfo& info, std::uint64_t from, std::uint64_t to) {
  for (const std::uint64_t step : {from, to}) {
    if (step >= info.first_step && step <= info.last_step) continue;
    throw Error("step is " + std::to_string(step) + ", must lie in [" + std::to_string(info.first_step) +
                ", " + std::to_string(info.last_step) + "]");
  }
  if (from > to) throw Error("step " + std::to_string(from) + " comes after step " + std::to_string(to));
}

// The number of the last keyframe at or before a step.
std::size_t keyframe_before(const RecordingFile& recording, std::uint64_t step) {
  const std::span<const std::uint64_t> steps = recording.keyframe_steps();
  return static_cast<std::size_t>(std::upper_bound(steps.begin(), steps.end(), step) - steps.begin()) - 1;
}

// Of all chunks until those in which the last step may lie: what is played depends on no others.
std::uint64_t identity_of(const RecordingFile& recording, std::uint64_t to) {
  std::vector<std::uint64_t> hashes;
  for (const RecordedChunk& chunk : recording.chunks()) {
    if (chunk.head.step > to) break;
    hashes.push_back(chunk.head.stored_hash);
  }
  return hash_of_bytes(std::as_bytes(std::span(hashes)));
}

// Before ranks do together what depends on it.
void check_same(Transport& transport, const std::string& file, std::uint64_t identity, std::uint64_t step) {
  struct Played {
    std::uint64_t identity, step;
  };
  const std::vector<Played> all = gather_rows(transport, Played{identity, step});
  for (const Played& one : all) {
    if (one.identity != all[0].identity || one.step != all[0].step)
      throw Error("play_recording: " + file + ": ranks play other recordings, or to other steps");
  }
}

FileShare read_keyframe(RecordingFile& recording, std::size_t chunk, const std::string& file,
                        std::uint64_t identity, Transport& transport, Workers& workers) {
  FileShare share{World{}, !recording.is_shared(chunk), identity};
  do_together(transport, file, [&] { restore(share.world, recording.first_state(chunk)); });
  if (share.is_whole) return share;
  std::optional<PartChunks> parts;
  do_together(transport, file, [&] { parts.emplace(recording, chunk); });
  std::vector<std::int32_t> owners;
  if (const auto problem = attempt([&] { owners = find_owners(share.world, *parts, transport); }))
    refuse(file, as_damage(*problem));  // as all ranks do
  do_together(transport, file, [&] {
    Crew crew(workers);  // ends here: steps call helpers of their own
    try {
      share.world = read_share(std::move(share.world), *parts, owners, transport, crew);
    } catch (const Error& error) {
      throw as_damage(error);
    }
  });
  return share;
}

}  // namespace

DistributedWorld play_recording(const std::string& file, std::uint64_t from, std::uint64_t to,
                                Transport& transport, Workers& workers, const DistributedOptions& options) {
  std::optional<RecordingFile> recording;
  do_together(transport, file, [&] {
    recording.emplace(file);
    check_steps(recording->info(), from, to);
  });
  const std::size_t keyframe = keyframe_before(*recording, from);
  const std::size_t chunk = recording->keyframes()[keyframe];
  const std::uint64_t identity = identity_of(*recording, to);
  check_same(transport, file, identity, to);
  DistributedWorld world =
      SharedReader::make(read_keyframe(*recording, chunk, file, identity, transport, workers), "recording",
                         transport, workers, options);
  std::optional<RecordStream> stream;
  do_together(transport, file, [&] { stream.emplace(*recording).go_behind(chunk); });
  for (std::uint64_t done = recording->keyframe_steps()[keyframe]; done < to; ++done) {
    RecordStream::Step next{};
    do_together(transport, file, [&] { next = stream->next_step(&world.world()); });
    world.step(next.dt, workers);
    if (world.hash() != next.hash) {
      throw Error("play_recording: " + file + ": step " + std::to_string(done + 1) +
                  " has another hash than the recorded one");
    }
  }
  return world;
}

}  // namespace scree
