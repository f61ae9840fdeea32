// Plays recordings on many ranks. What a rank makes of calls and steps is its part of the world; all of them
// read the same file.
#include <parallel/crew/crew.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/checkpoint.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/messages.h>
#include <parallel/recording/part_chunks.h>
#include <parallel/recording/recording_file.h>
#include <parallel/recording/rows_in_order.h>
#include <scree/distributed_player.h>
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

// Of what was read: as a rank refuses messages, which says nothing of files.
Error as_damage(const Error& error) {
  if (error.code() != ErrorCode::invalid_value) return error;
  return Error(std::string("the parts of a keyframe do not fit: ") + error.what(), ErrorCode::corrupt_data);
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

// What all ranks say, of which the first one that is not empty.
std::string first_of(Transport& transport, const std::string& text) {
  const std::optional<Error> all =
      agree(transport, text.empty() ? std::nullopt : std::optional<Error>(Error(text)));
  return all ? all->what() : std::string();
}

// Where two worlds have other bodies, or others that are shared out: what all ranks should find alike.
std::string difference_of_rows(const WorldData& recorded, const WorldData& world) {
  if (recorded.bodies.flags.size() != world.bodies.flags.size()) return "the number of body rows";
  for (std::size_t row = 0; row < recorded.bodies.flags.size(); ++row) {
    if (is_shared_out(recorded.bodies, row) != is_shared_out(world.bodies, row) ||
        ((recorded.bodies.flags[row] ^ world.bodies.flags[row]) & kBodyAlive) != 0)
      return "body " + std::to_string(row) + ", whether it is alive, or its type";
  }
  return {};
}

}  // namespace

struct DistributedPlayer::Impl {
  const char* call;  // for errors
  std::string file;
  Transport& transport;
  DistributedOptions options;
  std::optional<RecordingFile> recording = {};
  std::optional<RecordStream> stream = {};
  std::optional<DistributedWorld> world = {};
  std::uint64_t position = 0, identity = 0;
  std::optional<std::uint64_t> hash = {};  // recorded, of the last step
  bool is_lost = false;

  [[noreturn]] void refuse(const Error& problem) const {
    throw Error(std::string(call) + ": " + file + ": " + problem.what(), problem.code());
  }
  // Does the work on all ranks, or throws on all of them, with the name of the file.
  template <class Work>
  void do_together(Work&& work) {
    if (const std::optional<Error> problem = agree(transport, attempt(work))) refuse(*problem);
  }

  // Returns the step to begin at. `to`: what is played until there, if that is known, must be the same on all
  // ranks.
  std::uint64_t open(std::optional<std::uint64_t> first, std::optional<std::uint64_t> to) {
    std::uint64_t from = 0;
    do_together([&] {
      recording.emplace(file);
      from = first.value_or(recording->info().first_step);
      recording->check_step(from, "");
      if (!to) return;
      recording->check_step(*to, "");
      if (from > *to)
        throw Error("step " + std::to_string(from) + " comes after step " + std::to_string(*to));
    });
    const std::uint64_t last = to.value_or(recording->info().last_step);
    identity = identity_of(*recording, last);
    struct Played {
      std::uint64_t identity, from, to;
    };
    const std::vector<Played> all = gather_rows(transport, Played{identity, from, last});
    for (const Played& one : all) {
      if (one.identity != all[0].identity || one.from != all[0].from || one.to != all[0].to)
        refuse(Error("ranks play other recordings, or other steps"));
    }
    return from;
  }

  FileShare read_keyframe(std::size_t keyframe, Workers& workers);
  // Makes the world that of the last keyframe at or before a step.
  void go_to_keyframe(std::uint64_t step, Workers& workers) {
    const std::size_t keyframe = recording->keyframe_before(step), chunk = recording->keyframes()[keyframe];
    world.emplace(
        SharedReader::make(read_keyframe(keyframe, workers), "recording", transport, workers, options));
    do_together([&] { stream.emplace(*recording).go_behind(chunk); });
    position = recording->keyframe_steps()[keyframe];
    hash.reset();
  }
  // The calls up to the next step. What it throws is the same on all ranks.
  RecordStream::Step make_calls(Workers& workers) {
    constexpr std::uint64_t kCallsAtOnce = 1 << 16;
    WorldData& data = internals(world->world());
    Border& border = *border_of(data);
    std::optional<RecordStream::Step> next;
    border.dirty_before = 0;
    is_lost = true;  // until all calls are made
    while (!next) {
      do_together([&] { next = stream->next_step_within(&world->world(), kCallsAtOnce); });
      // Before more bodies come; not while there is one that step() would refuse and a later call destroys.
      if (!next && !attempt([&] { check_new_bodies(data, border); })) world->take_up_calls(workers);
    }
    is_lost = false;
    return *next;
  }
  // What a hook throws on one rank comes after the step, which all ranks have taken. What else is thrown
  // keeps the step from being taken.
  void take_step(const RecordStream::Step& next, Workers& workers) {
    Border& border = *border_of(internals(world->world()));
    border.has_ended = false;
    is_lost = true;
    try {
      world->step(next.dt, workers);
    } catch (...) {
      if (border.has_ended) note_step(next);
      throw;
    }
    note_step(next);
  }
  void note_step(const RecordStream::Step& step) {
    is_lost = false;
    ++position;
    hash = step.hash;
  }
  void take_step(Workers& workers) { take_step(make_calls(workers), workers); }
  // Where a difference was found, or calls or a step were refused, the world is not what was recorded.
  void find_back(Workers& workers) {
    if (!is_lost) return;
    const std::uint64_t step = position;
    try {
      go_to_keyframe(step, workers);
      while (position < step) take_step(workers);
    } catch (...) {
      position = step;
      is_lost = true;
      throw;
    }
    is_lost = false;
  }

  std::optional<Divergence> compare_step() {
    const std::uint64_t actual = world->hash();
    if (!hash || actual == *hash) return {};
    return Divergence{.step = position, .expected_hash = *hash, .actual_hash = actual};
  }
  std::string difference_from(std::size_t keyframe, Workers& workers);
  std::optional<Divergence> compare_state(Workers& workers);
  void find_difference(Divergence& divergence, Workers& workers);
};

// This rank's share.
FileShare DistributedPlayer::Impl::read_keyframe(std::size_t keyframe, Workers& workers) {
  const std::size_t chunk = recording->keyframes()[keyframe];
  FileShare share{World{}, !recording->is_shared(chunk), identity};
  do_together([&] { restore(share.world, recording->first_state(chunk)); });
  if (share.is_whole) return share;
  std::optional<PartChunks> parts;
  do_together([&] { parts.emplace(*recording, chunk); });
  std::vector<std::int32_t> owners;
  if (const auto problem = attempt([&] { owners = find_owners(share.world, *parts, transport); }))
    refuse(as_damage(*problem));  // as all ranks do
  do_together([&] {
    Crew crew(workers);  // ends here: steps call helpers of their own
    try {
      share.world = read_share(std::move(share.world), *parts, owners, transport, crew);
    } catch (const Error& error) {
      throw as_damage(error);
    }
  });
  return share;
}

// The recorded bodies go to those who have them here. Then each rank compares its own.
std::string DistributedPlayer::Impl::difference_from(std::size_t keyframe, Workers& workers) {
  FileShare recorded = read_keyframe(keyframe, workers);
  WorldData& data = internals(recorded.world);
  const WorldData& played = internals(world->world());
  std::string difference = first_of(transport, difference_of_rows(data, played));
  if (!difference.empty()) return difference;
  const std::vector<std::int32_t>& owners = border_of(played)->owner;
  Crew crew(workers);
  if (recorded.is_whole) {
    divide_world(data, transport, owners);
  } else {
    Border& border = *border_of(data);
    std::vector<GivenBody> given;
    for (std::size_t row = 0; row < owners.size(); ++row) {
      const auto body = static_cast<std::int32_t>(row);
      if (border.owns(body) && is_shared_out(data.bodies, row)) given.push_back({body, owners[row]});
    }
    share_common_events(data, border);
    give_bodies(data, given, crew);
  }
  std::string own;
  do_together([&] { own = first_difference_of_parts(recorded.world, world->world(), crew); });
  return first_of(transport, own);
}

std::optional<Divergence> DistributedPlayer::Impl::compare_state(Workers& workers) {
  const std::size_t keyframe = recording->keyframe_after(position);
  if (keyframe == recording->keyframes().size() || recording->keyframe_steps()[keyframe] != position)
    return {};
  const std::uint64_t actual = world->hash();  // takes up what calls have done
  std::string difference = difference_from(keyframe, workers);
  if (difference.empty()) return {};
  return Divergence{.step = position,
                    .expected_hash = hash.value_or(actual),
                    .actual_hash = actual,
                    .compared_at = position,
                    .difference = std::move(difference)};
}

void DistributedPlayer::Impl::find_difference(Divergence& divergence, Workers& workers) {
  const std::size_t keyframe = recording->keyframe_after(position);
  if (keyframe == recording->keyframes().size()) return;
  while (position < recording->keyframe_steps()[keyframe]) {
    RecordStream::Step next{};
    try {
      next = make_calls(workers);
    } catch (const Error& error) {
      divergence.difference = error.what();  // a call that only the world that was recorded could take
      return;
    }
    take_step(next, workers);
  }
  divergence.difference = difference_from(keyframe, workers);
  divergence.compared_at = position;
}

DistributedPlayer::DistributedPlayer(const std::string& file, std::optional<std::uint64_t> from,
                                     Transport& transport, Workers& workers,
                                     const DistributedOptions& options)
    : impl_(new Impl{"DistributedPlayer", file, transport, options}) {
  const std::uint64_t begin = impl_->open(from, {});
  impl_->go_to_keyframe(begin, workers);
  while (impl_->position < begin) impl_->take_step(workers);
}

DistributedPlayer::~DistributedPlayer() = default;
DistributedPlayer::DistributedPlayer(DistributedPlayer&&) noexcept = default;
DistributedPlayer& DistributedPlayer::operator=(DistributedPlayer&&) noexcept = default;

const RecordingInfo& DistributedPlayer::info() const noexcept { return impl_->recording->info(); }
std::span<const std::uint64_t> DistributedPlayer::keyframe_steps() const noexcept {
  return impl_->recording->keyframe_steps();
}
DistributedWorld& DistributedPlayer::world() noexcept { return *impl_->world; }
std::uint64_t DistributedPlayer::position() const noexcept { return impl_->position; }
std::optional<std::uint64_t> DistributedPlayer::recorded_hash() const noexcept { return impl_->hash; }

bool DistributedPlayer::step(Workers& workers) {
  impl_->find_back(workers);
  if (impl_->position == impl_->recording->info().last_step) return false;
  impl_->take_step(workers);
  return true;
}

std::optional<Divergence> DistributedPlayer::verify(std::uint64_t to, Workers& workers) {
  Impl& impl = *impl_;
  impl.do_together([&] {
    impl.recording->check_step(to, "");
    if (impl.position > to) {
      throw Error("step " + std::to_string(to) + " is behind: the player is at step " +
                  std::to_string(impl.position));
    }
  });
  impl.find_back(workers);
  std::optional<Divergence> divergence = impl.compare_state(workers);
  while (!divergence && impl.position < to) {
    impl.take_step(workers);
    divergence = impl.compare_step();
    if (divergence) {
      try {
        impl.find_difference(*divergence, workers);
      } catch (...) {  // steps of it have found nothing wrong, but the world is another one by now
        impl.is_lost = true;
        throw;
      }
    } else {
      divergence = impl.compare_state(workers);
    }
  }
  impl.is_lost = divergence.has_value();
  return divergence;
}

DistributedWorld play_recording(const std::string& file, std::uint64_t from, std::uint64_t to,
                                Transport& transport, Workers& workers, const DistributedOptions& options) {
  DistributedPlayer::Impl impl{"play_recording", file, transport, options};
  impl.open(from, to);
  impl.go_to_keyframe(from, workers);
  while (impl.position < to) {
    impl.take_step(workers);
    if (impl.compare_step()) {
      impl.refuse(Error("step " + std::to_string(impl.position) + " has another hash than the recorded one",
                        ErrorCode::corrupt_data));
    }
  }
  return std::move(*impl.world);
}

}  // namespace scree
