// Laws of random calls: no sequence of legal calls gives results that depend on the backend, or breaks a
// promise.
#include <core/state/recording_format/recorded_calls.h>
#include <gtest/gtest.h>
#include <tests/determinism/golden.h>
#include <tests/determinism/many_threads.h>
#include <tests/determinism/player.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>

namespace scree::determinism {
namespace {

struct DrawnSequence {
  std::uint64_t seed;
  int calls;
  int bodies;

  friend std::ostream& operator<<(std::ostream& out, const DrawnSequence& draw) {
    return out << "seed " << draw.seed;
  }
};

// The number of small worlds, and the number of calls in the longest sequence. A quarter of the calls are
// steps.
std::uint64_t small_draws() { return wish("SCREE_RANDOM_SEQUENCES", wants_all_sequences() ? 40 : 10); }
int most_calls() { return static_cast<int>(wish("SCREE_RANDOM_CALLS", wants_all_sequences() ? 4000 : 2000)); }

std::vector<DrawnSequence> draws() {
  // Failures in small worlds take fewer calls. Large worlds give several threads work at once.
  std::vector<DrawnSequence> all;
  const std::uint64_t few = small_draws();
  for (std::uint64_t seed = 1; seed <= few; ++seed) all.push_back({seed, 250, 24});
  all.push_back({few + 1, most_calls(), 24});
  all.push_back({few + 2, 60, 600});
  if (wants_all_sequences()) all.push_back({few + 3, 80, 1000});
  return all;
}

// Each instruction set with 1, 2 and 4 threads.
std::vector<Schedule> compared_schedules() {
  if (!wants_full_matrix()) return schedules(false);
  std::vector<Schedule> all;
  for (const Isa isa : supported_isas()) {
    for (const int threads : {1, 2, 4}) all.push_back({{isa, threads}});
  }
  return all;
}

class RandomCalls : public ManyThreads, public ::testing::WithParamInterface<DrawnSequence> {};

TEST_P(RandomCalls, KeepTheirPromisesWithTheSameBitsOnEveryBackend) {
  const DrawnSequence& draw = GetParam();
  report_unsupported_isas();
  const Sequence sequence = with_meshes(random_sequence(draw.seed, draw.calls, draw.bodies));
  const std::optional<Failure> failure = find_failure(sequence, compared_schedules());
  if (!failure) return;
  const std::vector<Schedule> suspect{failure->schedule};
  const Sequence shortest =
      shrunk(sequence, [&](const Sequence& shorter) { return find_failure(shorter, suspect).has_value(); });
  const std::optional<Failure> rest = find_failure(shortest, suspect);
  FAIL() << "seed " << draw.seed << ", " << failure->what
         << "\nshrunk: " << (rest ? describe(shortest, *rest) : "results change from run to run\n");
}

std::string seed_name(const ::testing::TestParamInfo<DrawnSequence>& info) {
  return "seed_" + std::to_string(info.param.seed);
}
INSTANTIATE_TEST_SUITE_P(Seeds, RandomCalls, ::testing::ValuesIn(draws()), seed_name);

class RecordedRandomCalls : public ManyThreads, public ::testing::WithParamInterface<std::uint64_t> {};

TEST_P(RecordedRandomCalls, VerifyOnEveryBackend) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() /
      ("scree_random_" + std::to_string(GetParam()) + "_" + std::to_string(getpid()) + ".recording");
  const Sequence sequence = with_meshes(random_sequence(GetParam(), 250, 24));
  const auto find = [&](const Sequence& calls) {
    return find_recording_failure(calls, schedules(false).back(), compared_schedules(), file.string());
  };
  if (const std::optional<Failure> failure = find(sequence)) {
    const Sequence shortest =
        shrunk(sequence, [&](const Sequence& shorter) { return find(shorter).has_value(); });
    const std::optional<Failure> rest = find(shortest);
    ADD_FAILURE() << "seed " << GetParam() << ", " << failure->what
                  << "\nshrunk: " << (rest ? describe(shortest, *rest) : "results change from run to run\n");
  }
  std::filesystem::remove(file);
}
std::uint64_t recordings() { return wish("SCREE_RANDOM_SEQUENCES", wants_all_sequences() ? 10 : 3); }
INSTANTIATE_TEST_SUITE_P(Seeds, RecordedRandomCalls, ::testing::Range(std::uint64_t{1}, recordings() + 1),
                         ::testing::PrintToStringParamName());

TEST(RandomCallsGolden, GiveTheGoldenHash) {
  int runs = 0;
  for (const Golden& golden : scenes::read_goldens(golden_path())) {
    if (is_scene(golden.what)) continue;
    EXPECT_EQ(digest_of(play_run(golden.what, {kReference})), golden.digest) << golden;
    ++runs;
  }
  EXPECT_GT(runs, 0);
}

TEST(RandomCallsThemselves, AreTheSameForTheSameSeed) {
  const Sequence once = random_sequence(5, 200, 20);
  const Sequence again = random_sequence(5, 200, 20);
  const auto same = [](const Call& left, const Call& right) {
    return left.kind == right.kind && left.slot == right.slot && left.seed == right.seed;
  };
  EXPECT_TRUE(std::equal(once.begin(), once.end(), again.begin(), again.end(), same));
  const Sequence other = random_sequence(6, 200, 20);
  EXPECT_FALSE(std::equal(once.begin(), once.end(), other.begin(), other.end(), same));
}

TEST(RandomCallsThemselves, ContainEveryKindOfCall) {
  std::vector<int> drawn(kCallKindCount);
  for (const Call& call : with_meshes(random_sequence(1, 5000, 20)))
    ++drawn[static_cast<std::size_t>(call.kind)];
  for (int kind = 0; kind < kCallKindCount; ++kind) {
    EXPECT_GT(drawn[static_cast<std::size_t>(kind)], 0) << name_of(static_cast<CallKind>(kind));
  }
}

// Counts the calls that a recorder would record.
class CountingSink final : public CallSink {
 public:
  void called(const MadeCall& made) noexcept override { ++calls_[static_cast<std::size_t>(made.call)]; }
  void restored(const WorldData&) noexcept override { ++restored_; }
  void stepped(const WorldData&, float, std::uint64_t) noexcept override {}
  void world_ended() noexcept override {}
  void step_failed() noexcept override {}

  int calls(RecordedCall call) const { return calls_[static_cast<std::size_t>(call)]; }
  int restored() const { return restored_; }

 private:
  std::array<int, static_cast<std::size_t>(RecordedCall::count)> calls_{};
  int restored_ = 0;
};

TEST(RandomCallsThemselves, MakeEveryCallThatChangesAWorld) {
  // The table of recorded calls lists all of them.
  CountingSink sink;
  Shift shift({kReference});
  Player player(shift, true, nullptr);
  player.stay_in_one_world();
  internals(player.world()).recording.sink = &sink;
  for (const Call& call : random_sequence(3, 4000, 20)) player.make(call);
  internals(player.world()).recording.sink = nullptr;
  for (int number = 1; number < static_cast<int>(RecordedCall::count); ++number) {
    const auto call = static_cast<RecordedCall>(number);
    EXPECT_GT(sink.calls(call), 0) << name_of(call);
  }
  EXPECT_GT(sink.restored(), 0);
  EXPECT_GT(player.hashes().size(), 1000u);
}

TEST(RandomCallsThemselves, PileBodiesUpAndLetThemSleep) {
  bool somebody_slept = false;
  std::size_t events = 0, hits = 0, joint_events = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Played played = play(random_sequence(seed, 250, 30), {kReference}, true);
    EXPECT_GT(played.most_contacts, 10) << seed;
    EXPECT_GT(played.hashes.size(), 100u) << seed;
    EXPECT_GT(played.events, 0u) << seed;
    events += played.events;
    hits += played.hits;
    joint_events += played.joint_events;
    EXPECT_GT(played.sweep_hits, 0) << seed;
    somebody_slept = somebody_slept || played.somebody_slept;
  }
  EXPECT_GT(events, 100u);
  EXPECT_GT(hits, 20u);
  EXPECT_GT(joint_events, 20u);
  EXPECT_TRUE(somebody_slept);
  const Played large = play(random_sequence(1, 60, 600), {kReference}, true);
  EXPECT_GT(large.most_contacts, 512) << "several chunks are needed to share work among threads";
}

TEST(RandomCallsThemselves, ShrinkToTheCallsThatMatter) {
  const Sequence sequence = random_sequence(7, 300, 20);
  // Treats a wake after a destroy_shape as the failure.
  const auto fails = [](const Sequence& calls) {
    const auto is = [](CallKind kind) { return [kind](const Call& call) { return call.kind == kind; }; };
    const auto destroy = std::find_if(calls.begin(), calls.end(), is(CallKind::destroy_shape));
    return std::find_if(destroy, calls.end(), is(CallKind::wake)) != calls.end();
  };
  ASSERT_TRUE(fails(sequence));
  const Sequence shortest = shrunk(sequence, fails);
  ASSERT_EQ(shortest.size(), 2u);
  EXPECT_EQ(shortest[0].kind, CallKind::destroy_shape);
  EXPECT_EQ(shortest[1].kind, CallKind::wake);
}

// Treats a step as a failure if one of at least four bodies is faster than 60 m/s.
void refuse_speed(World& world) {
  constexpr float kTooFast = 60.0f;
  if (world.body_count() < 4) return;
  for (std::uint32_t index = 0; index < world.velocities().size(); ++index) {
    if (!world.is_alive(world.body_at(index))) continue;
    const Vec3 v = world.velocities()[index].linear;
    if (v.x * v.x + v.y * v.y + v.z * v.z > kTooFast * kTooFast) throw BrokenPromise("a body is too fast");
  }
}

TEST(RandomCallsThemselves, ShrinkToCallsThatStillFailWhenPlayed) {
  const auto fails = [](const Sequence& calls) {
    Shift shift({kReference});
    Player player(shift, false, nullptr);
    player.before_steps(refuse_speed);
    try {
      for (const Call& call : calls) player.make(call);
    } catch (const BrokenPromise&) {
      return true;
    }
    return false;
  };
  const Sequence sequence = random_sequence(10, 300, 20);
  ASSERT_TRUE(fails(sequence));
  const Sequence shortest = shrunk(sequence, fails);
  ASSERT_TRUE(fails(shortest));
  EXPECT_LE(shortest.size(), 5u) << "bodies, a shot, a step";
  const std::string text = describe(shortest, {"too fast", {kReference}});
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 20) << text;
  EXPECT_NE(text.find("set_linear_velocity(body "), std::string::npos) << text;
}

TEST(RandomCallsThemselves, AreDescribedCallByCall) {
  const Failure failure{"the reason", {kReference}};
  const std::string text = describe(random_sequence(8, 60, 8), failure);
  EXPECT_NE(text.find("the reason\n60 calls suffice:\n  destroy_bodies(0)\n  create_bodies("),
            std::string::npos)
      << text.substr(0, 300);
  EXPECT_NE(text.find("\n  step(0.0166666675)\n"), std::string::npos);
}

}  // namespace
}  // namespace scree::determinism
