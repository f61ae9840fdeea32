// See scree/distributed_world.h: shares a world out, and shares it out anew as bodies move.
#define XXH_INLINE_ALL
#include <core/state/snapshot/snapshot_columns.h>
#include <core/world/edit.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/agree.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/checkpoint.h>
#include <parallel/distributed/give_calls.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/partition.h>
#include <parallel/distributed/send_bodies.h>
#include <parallel/distributed/world_parts.h>
#include <parallel/recording/shared_keyframe.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <scree/step.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace scree {

namespace {

constexpr int kMostStepsPerLook = 1'000'000;
constexpr std::int32_t kBodyLoad = 4;  // of a body without constraints, relative to a constraint

WeightedPoint weigh(const WorldData& data, std::int32_t body) {
  const PoseRow& pose = data.bodies.pose[body];
  WeightedPoint point{{pose.position[0], pose.position[1], pose.position[2]}, kBodyLoad};
  if ((data.bodies.flags[body] & kBodyAsleep) != 0)
    return {{point.position[0], point.position[1], point.position[2]}, 1};
  if (data.constraints == nullptr) return point;
  const auto& colors = static_cast<const Constraints&>(*data.constraints).body_colors;
  if (std::cmp_less(body, colors.size())) point.weight += colors[body].degree;
  return point;
}

std::uint64_t digest_of(std::span<const std::byte> bytes, std::uint64_t before) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), before);
}

// Of the state of the whole world.
std::uint64_t digest_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  std::uint64_t digest = 0;
  detail::write_snapshot(
      snapshot,
      [](void* context, std::span<const std::byte> part, std::size_t) {
        auto& all = *static_cast<std::uint64_t*>(context);
        all = digest_of(part, all);
      },
      &digest);
  return digest;
}

// Throws on all ranks unless all of them were built alike and have the same options, and the same of what is
// called `what`.
void check_alike(Transport& transport, const DistributedOptions& options, const char* what,
                 std::uint64_t state) {
  struct Digest {
    std::uint64_t build, state;
    std::int64_t steps_per_look;
    std::uint64_t imbalance;
  };
  const std::string_view version = SCREE_VERSION;
  const Digest own{digest_of(std::as_bytes(std::span(version)), layout_of_columns()), state,
                   options.steps_per_look, std::bit_cast<std::uint32_t>(options.imbalance)};
  const std::vector<Digest> digests = gather_rows<Digest>(transport, own);
  for (std::size_t rank = 1; rank < digests.size(); ++rank) {
    const Digest &one = digests[rank], &first = digests[0];
    const char* other = one.build != first.build                     ? "build"
                        : one.state != first.state                   ? what
                        : one.steps_per_look != first.steps_per_look ? "option steps_per_look"
                        : one.imbalance != first.imbalance           ? "option imbalance"
                                                                     : nullptr;
    if (other == nullptr) continue;
    throw Error("DistributedWorld: the " + std::string(other) + " of rank " + std::to_string(rank) +
                " is not that of rank 0");
  }
}

void check_options(const DistributedOptions& options) {
  if (options.steps_per_look < 0 || options.steps_per_look > kMostStepsPerLook) {
    throw Error("DistributedOptions: steps_per_look is " + std::to_string(options.steps_per_look) +
                "; it must be in [0, " + std::to_string(kMostStepsPerLook) + "]");
  }
  if (!(options.imbalance >= 1.0f)) {
    throw Error("DistributedOptions: imbalance is " + std::to_string(options.imbalance) +
                "; it must be at least 1");
  }
}

// Of bodies that nobody owns yet, each rank weighs as many as the others.
Partition first_partition(const WorldData& data, Transport& transport) {
  const std::size_t rows = data.bodies.flags.size();
  const auto rank = static_cast<std::size_t>(transport.rank()),
             ranks = static_cast<std::size_t>(transport.ranks());
  std::vector<WeightedPoint> points;
  for (std::size_t body = rows * rank / ranks; body < rows * (rank + 1) / ranks; ++body) {
    if (is_shared_out(data.bodies, body)) points.push_back(weigh(data, static_cast<std::int32_t>(body)));
  }
  return cut_space(transport, points);
}

// Half of the body's extent, so that one which lies across a cut stays where it is.
float margin_of(const WorldData& data, std::int32_t body) {
  const std::int32_t shape = data.bodies.first_shape[body];
  if (shape < 0) return 0.0f;
  const BoundsRow& bounds = data.shapes.fat_bounds[shape];
  float extent = 0.0f;
  for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, bounds.upper[axis] - bounds.lower[axis]);
  return std::isfinite(extent) ? 0.5f * extent : 0.0f;
}

double mean_of(const std::vector<std::int64_t>& loads) {
  std::int64_t all = 0;
  for (const std::int64_t load : loads) all += load;
  return static_cast<double>(all) / static_cast<double>(loads.size());
}

bool is_outside(const PartitionBox& box, const float (&point)[3], float margin) {
  for (int axis = 0; axis < 3; ++axis) {
    if (point[axis] < box.lower[axis] - margin || point[axis] >= box.upper[axis] + margin) return true;
  }
  return false;
}

// While ranks take turns: new bodies are for the rank that creates them.
class Giving {
 public:
  explicit Giving(Border& border) : border_(border), by_place_(border.owner_of_new) {
    border.is_giving = true;
    border.dirty_before = 0;
  }
  ~Giving() {
    border_.is_giving = false;
    border_.owner_of_new = std::move(by_place_);
  }
  Giving(const Giving&) = delete;
  Giving& operator=(const Giving&) = delete;

 private:
  Border& border_;
  std::function<std::int32_t(std::int32_t)> by_place_;
};

}  // namespace

struct DistributedWorld::Impl {
  World world;
  Transport& transport;
  DistributedOptions options;
  Partition partition = {};
  std::int64_t steps = 0;       // since the world was shared out
  std::size_t bodies_seen = 0;  // when it was looked at last
  RankStats stats = {};
  std::optional<Recorder> recorder = {};  // on rank 0
  std::string recording_file = {};
  int compression_level = 0;  // of the recording, as is the spacing
  int keyframe_spacing = 0;   // steps
  int steps_to_keyframe = 0;

  WorldData& data() { return internals(world); }
  Border& border() { return *border_of(data()); }

  std::vector<WeightedPoint> weigh_own() {
    std::vector<WeightedPoint> points;
    for_each_own([&](std::int32_t body) { points.push_back(weigh(data(), body)); });
    return points;
  }

  // Cuts the space anew where the loads, of this rank's points by the rank that rank_of(point) says, are
  // uneven. All ranks decide alike.
  template <class RankOf>
  void cut_if_uneven(RankOf&& rank_of) {
    const std::vector<WeightedPoint> points = weigh_own();
    std::vector<std::int64_t> loads(static_cast<std::size_t>(transport.ranks()), 0);
    for (const WeightedPoint& point : points) loads[static_cast<std::size_t>(rank_of(point))] += point.weight;
    border().transport.add_up(loads);
    const auto most = static_cast<double>(*std::max_element(loads.begin(), loads.end()));
    if (most > static_cast<double>(options.imbalance) * mean_of(loads))
      partition = cut_space(border().transport, points);
  }

  // Whether calls have created so many bodies that it cannot wait, as in a world that was empty: all ranks
  // find the same.
  bool has_grown() {
    constexpr std::size_t kFew = 64;
    bodies_seen = std::min(bodies_seen, data().bodies.alive);  // some may have gone
    return data().bodies.alive > bodies_seen + bodies_seen / 4 + kFew;
  }

  // Looks whether bodies should change owners.
  void look(Workers& workers) {
    cut_if_uneven([this](const WeightedPoint&) { return here(); });
    give_strays(workers);
  }

  // What each rank has created lies where it does, not where the space was cut before.
  void settle(Workers& workers) {
    cut_if_uneven([this](const WeightedPoint& point) { return partition.rank_of(point.position); });
    give_strays(workers);
  }

  // Of this object, which stays where it is.
  void own_new_bodies() {
    border().owner_of_new = [this](std::int32_t body) {
      return partition.rank_of(data().bodies.pose[body].position);
    };
  }

  void give_strays(Workers& workers) {
    bodies_seen = data().bodies.alive;
    const PartitionBox box = box_of(partition, transport.rank());
    std::vector<GivenBody> given;
    for_each_own([&](std::int32_t body) {
      const float(&position)[3] = data().bodies.pose[body].position;
      if (is_outside(box, position, margin_of(data(), body)))
        given.push_back({body, partition.rank_of(position)});
    });
    Crew crew(workers);
    give_bodies(data(), given, crew);
  }

  // Rank 0 works. All ranks get what it has thrown.
  template <class Work>
  std::optional<Error> on_first(Work&& work) {
    return tell_all(transport, here() == 0 ? attempt(work) : std::nullopt);
  }

  // The world goes on where a keyframe cannot be written: the recorder has ended then.
  void keep_up_recording(Workers& workers) {
    if (!border().is_recorded || --steps_to_keyframe > 0) return;
    steps_to_keyframe = keyframe_spacing;
    add_keyframe(workers);
  }
  std::optional<Error> add_keyframe(Workers& workers) {
    check_not_giving(border());
    adopt_calls(data(), border());
    Crew crew(workers);
    SharedRecorder::Impl* const of_first = recorder ? SharedRecorder::impl(*recorder) : nullptr;
    return write_shared_keyframe(world, of_first, recording_file, compression_level, crew);
  }

  // What it takes a search to know.
  void count(RankStats& of_rank) {
    const Bodies& bodies = data().bodies;
    for_each_own([&](std::int32_t body) {
      ++of_rank.bodies;
      of_rank.awake_bodies += (bodies.flags[body] & kBodyAsleep) == 0 ? 1 : 0;
    });
    of_rank.ghosts = static_cast<std::int64_t>(border().ghosts.size());
    const Contacts& contacts = data().contacts;
    for (const PairRows* const pairs : {&contacts.pairs, &contacts.resting}) {
      for (std::size_t row = 0; row < pairs->pair.size(); ++row) {
        const ShapePair pair = pairs->pair[row];
        if (has_changed(data().shapes, pair.a) || has_changed(data().shapes, pair.b)) continue;
        const std::int32_t owner_a = border().owner_of(data().shapes.body[pair.a]);
        const std::int32_t owner_b = border().owner_of(data().shapes.body[pair.b]);
        if (owner_a != here() && owner_b != here()) continue;
        const bool across = owner_a != owner_b && owner_a != kEveryRank && owner_b != kEveryRank;
        for_each_contact(contacts, pairs->contact[row], [&](std::int32_t) {
          ++of_rank.contacts;
          of_rank.border_contacts += across ? 1 : 0;
        });
      }
    }
  }
  std::int32_t here() const { return transport.rank(); }

  template <class Work>
  void for_each_own(Work&& work) {
    const std::vector<std::int32_t>& owner = border().owner;
    const Bodies& bodies = data().bodies;
    const std::int32_t own = here();
    for (std::size_t body = 0; body < owner.size(); ++body) {
      if (owner[body] == own && is_shared_out(bodies, body)) work(static_cast<std::int32_t>(body));
    }
  }
};

DistributedWorld::DistributedWorld(World world, Transport& transport, const DistributedOptions& options) {
  check_alike(transport, options, "world", digest_of(world));
  check_options(options);
  check_positions(internals(world, "DistributedWorld"));
  share_out(std::move(world), transport, options);
}

void DistributedWorld::share_out(World world, Transport& transport, const DistributedOptions& options) {
  impl_.reset(new Impl{std::move(world), transport, options});
  WorldData& data = internals(impl_->world, "DistributedWorld");
  impl_->partition = first_partition(data, transport);
  std::vector<std::int32_t> owners(data.bodies.flags.size(), 0);
  for (std::size_t body = 0; body < owners.size(); ++body) {
    if (is_shared_out(data.bodies, body))
      owners[body] = impl_->partition.rank_of(data.bodies.pose[body].position);
  }
  divide_world(data, transport, std::move(owners));
  impl_->bodies_seen = data.bodies.alive;
  impl_->own_new_bodies();
}

DistributedWorld::DistributedWorld(FileShare share, const char* what, Transport& transport, Workers& workers,
                                   const DistributedOptions& options) {
  check_alike(transport, options, what, share.identity);
  check_options(options);
  if (share.is_whole) {
    share_out(std::move(share.world), transport, options);
    return;
  }
  impl_.reset(new Impl{std::move(share.world), transport, options});
  impl_->partition = cut_space(impl_->border().transport, impl_->weigh_own());
  share_common_events(impl_->data(), impl_->border());
  impl_->give_strays(workers);
  impl_->own_new_bodies();
}

DistributedWorld::~DistributedWorld() = default;
DistributedWorld::DistributedWorld(DistributedWorld&&) noexcept = default;
DistributedWorld& DistributedWorld::operator=(DistributedWorld&&) noexcept = default;

int DistributedWorld::rank() const noexcept { return impl_->transport.rank(); }
int DistributedWorld::ranks() const noexcept { return impl_->transport.ranks(); }
World& DistributedWorld::world() noexcept { return impl_->world; }
const World& DistributedWorld::world() const noexcept { return impl_->world; }

bool DistributedWorld::owns(BodyId body) const {
  const Border& border = impl_->border();
  return impl_->world.is_alive(body) && body.index < border.owner.size() &&
         border.generation[body.index] == body.generation &&
         is_shared_out(impl_->data().bodies, body.index) &&
         border.owns(static_cast<std::int32_t>(body.index));
}

void DistributedWorld::give(const std::function<void(World&)>& calls, Workers& workers) {
  Impl& impl = *impl_;
  Border& border = impl.border();
  check_not_giving(border);
  adopt_calls(impl.data(), border);
  const std::vector<std::int32_t> owners = border.owner;
  // Ranks make all calls alike, also those that follow what all of them refuse.
  std::optional<Error> problem, refusal;
  const AfterCalls after = [&] {
    try {
      check_new_bodies(impl.data(), border);
    } catch (const Error& error) {
      refusal = error;
      return;
    }
    refusal.reset();  // later calls have destroyed the body
    let_go_of_given(impl.data(), border);
  };
  {
    const Giving giving(border);
    for (int from = 0; from < ranks() && !problem; ++from) {
      border.owner_of_new = [from](std::int32_t) { return from; };
      problem = from == rank() ? send_calls(impl.world, border.transport, calls, after)
                               : take_calls(impl.world, border.transport, from, after);
    }
  }
  if (!refusal && border.owner != owners) impl.settle(workers);
  if (problem) throw *problem;
  if (refusal) throw *refusal;
}

// In the middle of many calls that all ranks make: lets go of new bodies before more come, and shares them
// out.
void DistributedWorld::take_up_calls(Workers& workers) {
  let_go_of_given(impl_->data(), impl_->border());
  impl_->settle(workers);
}

void DistributedWorld::step(float dt, Workers& workers) {
  Impl& impl = *impl_;
  check_border(impl.data());
  const auto begin = std::chrono::steady_clock::now();
  impl.border().transport.begin_step();
  const int spacing = impl.options.steps_per_look;
  const std::int64_t steps = impl.steps++;  // on all ranks, even where a hook throws in this step
  if (spacing > 0 && ((steps > 0 && steps % spacing == 0) || impl.has_grown())) {
    adopt_calls(impl.data(), impl.border());
    impl.look(workers);
  }
  // A hook that throws does not keep the step from its end, nor this rank from what all do after it.
  impl.border().has_ended = false;
  std::exception_ptr thrown;
  try {
    scree::step(impl.world, dt, workers);
  } catch (...) {
    if (!impl.border().has_ended) throw;
    thrown = std::current_exception();
  }
  impl.keep_up_recording(workers);
  const Border& border = impl.border();
  const CountedTransport::Sent& sent = border.transport.sent();
  impl.stats = {
      .messages = sent.messages,
      .bytes = sent.bytes,
      .step_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count(),
      .waiting_ms = sent.waiting_ms,
  };
  if (thrown != nullptr) std::rethrow_exception(thrown);
}

std::uint64_t DistributedWorld::hash() {
  check_not_giving(impl_->border());
  adopt_calls(impl_->data(), impl_->border());
  return hash_of_all(impl_->data(), impl_->border());
}

void DistributedWorld::stats(std::span<RankStats> by_rank) {
  if (std::cmp_not_equal(by_rank.size(), ranks())) {
    throw Error("DistributedWorld::stats: there are " + std::to_string(ranks()) + " ranks, and room for " +
                std::to_string(by_rank.size()));
  }
  check_not_giving(impl_->border());
  adopt_calls(impl_->data(), impl_->border());
  RankStats own = impl_->stats;
  impl_->count(own);
  std::vector<std::int64_t> loads(by_rank.size(), 0);
  impl_->for_each_own([&](std::int32_t body) {
    loads[static_cast<std::size_t>(rank())] += weigh(impl_->data(), body).weight;
  });
  const auto own_load = static_cast<double>(loads[static_cast<std::size_t>(rank())]);
  impl_->transport.add_up(loads);
  own.load = mean_of(loads) > 0.0 ? own_load / mean_of(loads) : 1.0;
  const std::vector<RankStats> rows = gather_rows<RankStats>(impl_->transport, own);
  std::copy(rows.begin(), rows.end(), by_rank.begin());
}

void DistributedWorld::save(Snapshot& snapshot, Workers& workers) {
  check_not_giving(impl_->border());
  adopt_calls(impl_->data(), impl_->border());
  Crew crew(workers);
  const std::optional<Error> problem = save_whole(impl_->world, snapshot, crew);
  if (problem) throw *problem;
}

void DistributedWorld::checkpoint(const std::string& file, Workers& workers) {
  check_not_giving(impl_->border());
  adopt_calls(impl_->data(), impl_->border());
  Crew crew(workers);
  OwnParts parts;
  const std::optional<Error> problem =
      agree(impl_->transport, attempt([&] { parts = checkpoint_parts(impl_->world, crew); }));
  if (problem) throw Error(file + ": cannot be written: " + problem->what(), problem->code());
  write_parts(impl_->transport, file, std::move(parts));
}

void DistributedWorld::record(const std::string& file, Workers& workers, const RecorderOptions& options) {
  Impl& impl = *impl_;
  if (impl.border().is_recorded)
    throw Error("DistributedWorld: the world is being recorded already", ErrorCode::already_recording);
  check_not_giving(impl.border());
  adopt_calls(impl.data(), impl.border());  // before a file is opened, as this may refuse them
  impl.recording_file = file;
  impl.compression_level = options.compression_level;
  std::optional<Error> problem = impl.on_first([&] {
    impl.recorder.emplace(SharedRecorder::record_part(impl.world, file, options));
    impl.recording_file = std::filesystem::absolute(file).string();  // whatever folder others are in
  });
  try {
    if (!problem) {
      impl.recording_file = tell_all(impl.transport, impl.recording_file);
      problem = impl.add_keyframe(workers);
    }
    if (problem) throw *problem;
  } catch (...) {
    impl.recorder.reset();
    throw;
  }
  impl.border().is_recorded = true;
  impl.keyframe_spacing = impl.steps_to_keyframe = options.keyframe_spacing;
}

void DistributedWorld::finish_recording(Workers& workers) {
  Impl& impl = *impl_;
  if (!impl.border().is_recorded) return;
  impl.add_keyframe(workers);
  impl.border().is_recorded = false;
  const std::optional<Error> problem = impl.on_first([&] { impl.recorder->finish(); });
  if (problem) throw *problem;
}

const Recorder* DistributedWorld::recorder() const noexcept {
  return impl_->recorder ? &*impl_->recorder : nullptr;
}

DistributedWorld SharedReader::make(FileShare share, const char* what, Transport& transport, Workers& workers,
                                    const DistributedOptions& options) {
  return DistributedWorld(std::move(share), what, transport, workers, options);
}

DistributedWorld read_checkpoint(const std::string& file, Transport& transport, Workers& workers,
                                 const DistributedOptions& options) {
  std::optional<FileShare> share;
  const std::optional<Error> problem = agree(transport, attempt([&] {
                                               Crew crew(workers);
                                               share = read_file_share(file, transport, crew);
                                             }));
  if (problem) throw *problem;
  return SharedReader::make(std::move(*share), "checkpoint", transport, workers, options);
}

}  // namespace scree
