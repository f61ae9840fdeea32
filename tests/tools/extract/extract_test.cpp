// Laws of what is extracted from recordings: it is what the recorded world had, bit for bit and on every
// backend, and forces and energies are those of mechanics, whether or not anything asked for them in the run.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>
#include <tools/extract/extract.h>
#include <tools/extract/tables.h>
#include <tools/files/recordings.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace scree::extract {
namespace {

using test::kDt;
using test::TemporaryFile;

Extract extract_all(const std::string& file, std::vector<std::string> signals, int threads = 1,
                    Isa isa = Isa::automatic, std::uint64_t every = 1, Choice choice = {}) {
  Plan plan;
  plan.file = file;
  plan.wanted = read_signals(signals);
  plan.choice = std::move(choice);
  const Player player = files::open_recording(file);
  plan.from = player.info().first_step;
  plan.to = player.info().last_step;
  plan.every = every;
  plan.threads = threads;
  plan.isa = isa;
  return extract(plan, [](std::uint64_t, std::uint64_t) {});
}

const Values& values_of(const Extract& extract, Signal signal) {
  return extract.values[static_cast<std::size_t>(signal)];
}

double value(const Extract& extract, Signal signal, std::size_t sample, std::size_t row = 0,
             std::size_t part = 0) {
  const SignalInfo& info = info_of(signal);
  return values_of(
      extract,
      signal)[(sample * extract.rows_of(info.owner) + row) * static_cast<std::size_t>(info.width) + part];
}

bool same_bits(const Extract& a, const Extract& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  bool all = a.steps == b.steps && a.times == b.times && a.bodies == b.bodies && a.joints == b.joints;
  for (int i = 0; i < kSignalCount; ++i) {
    const auto at = static_cast<std::size_t>(i);
    all = all && same(a.values[at].single, b.values[at].single) && same(a.values[at].wide, b.values[at].wide);
  }
  return all && std::equal(a.events.begin(), a.events.end(), b.events.begin(), b.events.end(),
                           [](const EventRow& x, const EventRow& y) {
                             return x.step == y.step && x.time == y.time && x.kind == y.kind &&
                                    x.body_a == y.body_a && x.body_b == y.body_b && x.shape_a == y.shape_a &&
                                    x.shape_b == y.shape_b && x.joint == y.joint && x.value == y.value;
                           });
}

std::size_t row_of(const Extract& extract, BodyId body) {
  return static_cast<std::size_t>(std::find(extract.bodies.begin(), extract.bodies.end(), body.index) -
                                  extract.bodies.begin());
}

TEST(Extract, IsWhatTheRecordedWorldHad) {
  TemporaryFile file;
  test::Heap heap;
  std::vector<std::vector<Pose>> poses;
  std::vector<std::vector<Velocity>> velocities;
  const auto note = [&] {
    poses.emplace_back(heap.world.poses().begin(), heap.world.poses().end());
    velocities.emplace_back(heap.world.velocities().begin(), heap.world.velocities().end());
  };
  {
    Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 13});
    note();
    for (int i = 0; i < 60; ++i) {
      step(heap.world, kDt, heap.workers);
      note();
    }
    recorder.finish();
  }
  const Extract all = extract_all(file.path(), {"pose", "velocity"});
  ASSERT_EQ(all.steps.size(), 61u);
  ASSERT_EQ(all.bodies.size(), heap.world.body_count());
  for (std::size_t sample = 0; sample < all.steps.size(); ++sample) {
    EXPECT_NEAR(all.times[sample], static_cast<double>(sample) * double{kDt}, 1e-6);
    for (std::size_t row = 0; row < all.bodies.size(); ++row) {
      const Pose& pose = poses[sample][all.bodies[row]];
      const Velocity& velocity = velocities[sample][all.bodies[row]];
      for (int axis = 0; axis < 3; ++axis) {
        const auto part = static_cast<std::size_t>(axis);
        ASSERT_EQ(value(all, Signal::position, sample, row, part), double{pose.position[axis]});
        ASSERT_EQ(value(all, Signal::linear_velocity, sample, row, part), double{velocity.linear[axis]});
        ASSERT_EQ(value(all, Signal::angular_velocity, sample, row, part), double{velocity.angular[axis]});
      }
      ASSERT_EQ(value(all, Signal::rotation, sample, row, 3), double{pose.rotation.w});
    }
  }
}

TEST(Extract, HasTheSameBitsOnEveryBackendHoweverManyKeyframesThereAre) {
  const std::vector<std::string> states = {"pose",        "velocity", "awake",    "energy",
                                           "joint_force", "contacts", "residual", "penetration"};
  const std::vector<std::string> history = {"contact_force", "contact_torque", "events", "joint_torque"};
  Extract expected_states, expected_history;
  for (const int spacing : {1, 7, 1000}) {
    TemporaryFile file;
    const scenes::Scene scene = scenes::build("ragdolls", {{"ragdolls", 4}}).front();
    World world(scene.settings);
    scenes::populate(world, scene);
    Workers workers(1);
    Recorder recorder(world, file.path(), {.keyframe_spacing = spacing});
    for (int i = 0; i < 40; ++i) step(world, kDt, workers);
    recorder.finish();
    for (const auto& [isa, threads] : {std::pair{Isa::scalar, 1}, {Isa::automatic, 2}, {Isa::automatic, 5}}) {
      const Extract some = extract_all(file.path(), states, threads, isa);
      const Extract other = extract_all(file.path(), history, threads, isa);
      if (expected_states.steps.empty()) {
        expected_states = some;
        expected_history = other;
        EXPECT_GT(some.joints.size(), 10u);
        EXPECT_GT(other.events.size(), 10u);
      }
      EXPECT_TRUE(same_bits(some, expected_states)) << spacing << " " << threads;
      EXPECT_TRUE(same_bits(other, expected_history)) << spacing << " " << threads;
    }
  }
}

// A box of 2 kg that comes to rest on a floor and falls asleep, and one of 3 kg that hangs from the world.
struct Balance {
  TemporaryFile file;
  BodyId box, weight;

  explicit Balance(int steps = 200) {
    World world;
    const BodyId floor = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
    world.add_shape(floor, Box{{10.0f, 1.0f, 10.0f}});
    box = world.create_body({.position = {0.0f, 0.6f, 0.0f}, .mass = 2.0f});
    world.add_shape(box, Box{});
    weight = world.create_body({.position = {5.0f, 3.0f, 0.0f}, .mass = 3.0f, .can_sleep = false});
    world.add_shape(weight, Sphere{0.3f});
    world.create_joint({.body_a = kWorld,
                        .body_b = weight,
                        .frame_a = {{5.0f, 4.0f, 0.0f}, {}},
                        .frame_b = {{0.0f, 1.0f, 0.0f}, {}}},
                       BallJoint{});
    Workers workers(1);
    Recorder recorder(world, file.path(), {.keyframe_spacing = 50});
    for (int i = 0; i < steps; ++i) step(world, kDt, workers);
    EXPECT_FALSE(world.is_awake(box));
    recorder.finish();
  }
};

TEST(Extract, ForcesBalanceWeights) {
  constexpr double kGravity = 9.81;
  const Balance balance;
  const Extract all = extract_all(balance.file.path(),
                                  {"contact_force", "contact_torque", "joint_force", "awake", "velocity"});
  const std::size_t box = row_of(all, balance.box), weight = row_of(all, balance.weight);
  ASSERT_EQ(all.joints.size(), 1u);
  EXPECT_TRUE(std::isnan(value(all, Signal::contact_force, 0, box, 1)));  // no step was played yet
  const std::size_t last = all.steps.size() - 1;
  ASSERT_EQ(value(all, Signal::awake, last, box), 0.0);
  for (std::size_t sample = 100; sample <= last; ++sample) {
    // Asleep, it keeps what it bore as it fell asleep.
    EXPECT_NEAR(value(all, Signal::contact_force, sample, box, 1), 2.0 * kGravity, 0.2) << sample;
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(value(all, Signal::contact_torque, sample, box, axis), 0.0, 0.05) << sample;
    EXPECT_NEAR(value(all, Signal::joint_force, sample, 0, 1), 3.0 * kGravity, 0.3);
    EXPECT_EQ(value(all, Signal::contact_force, sample, weight, 1), 0.0);
  }
  // While it lands, momentum changes by what acts.
  for (std::size_t sample = 1; sample < 60; ++sample) {
    const double change = value(all, Signal::linear_velocity, sample, box, 1) -
                          value(all, Signal::linear_velocity, sample - 1, box, 1);
    EXPECT_NEAR(2.0 * change / double{kDt},
                value(all, Signal::contact_force, sample, box, 1) - 2.0 * kGravity, 0.05)
        << sample;
  }
}

TEST(Extract, TorquesAreThoseAboutWhereTheStepFoundTheBody) {
  TemporaryFile file;
  World world({.sleeping = false});
  const BodyId floor = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
  world.add_shape(floor, Box{{200.0f, 1.0f, 200.0f}});
  const BodyId moved = world.create_body({.position = {100.0f, 20.0f, 0.0f}});
  world.add_shape(moved, Box{});
  BodyId born;
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    for (int i = 0; i < 40; ++i) {
      if (i == 10) {
        world.set_pose(moved, {{0.0f, 0.55f, 0.0f}, from_axis_angle({1.0f, 0.0f, 0.3f}, 0.1f)});
        born = world.create_body(
            {.position = {-50.0f, 0.55f, 30.0f}, .rotation = from_axis_angle({0.0f, 0.0f, 1.0f}, 0.1f)});
        world.add_shape(born, Box{});
      }
      step(world, kDt, workers);
    }
    recorder.finish();
  }
  const Extract all = extract_all(file.path(), {"contact_torque", "angular_velocity"});
  constexpr double kInertia = 1000.0 / 6.0;  // kg m^2, of a cube of 1 m and 1000 kg/m^3 about any axis
  for (const BodyId body : {moved, born}) {
    const std::size_t row = row_of(all, body);
    double largest = 0.0;
    for (std::size_t sample = 11; sample <= 40; ++sample) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double before = value(all, Signal::angular_velocity, sample - 1, row, axis);
        const double change =
            value(all, Signal::angular_velocity, sample, row, axis) - (std::isnan(before) ? 0.0 : before);
        const double torque = value(all, Signal::contact_torque, sample, row, axis);
        EXPECT_NEAR(torque * double{kDt}, kInertia * change, 0.02) << sample;
        largest = std::max(largest, std::abs(torque));
      }
    }
    EXPECT_GT(largest, 1.0);
  }
}

TEST(Extract, SleepersKeepTheirForcesWhateverTheTimeStep) {
  TemporaryFile file;
  World world;
  const BodyId floor = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
  world.add_shape(floor, Box{{10.0f, 1.0f, 10.0f}});
  const BodyId box = world.create_body({.position = {0.0f, 0.5f, 0.0f}, .mass = 2.0f});
  world.add_shape(box, Box{});
  Workers workers(1);
  {
    Recorder recorder(world, file.path());
    for (int i = 0; i < 120; ++i) step(world, i < 90 ? kDt : 0.25f * kDt, workers);
    recorder.finish();
  }
  const Extract all = extract_all(file.path(), {"contact_force", "awake"});
  const std::size_t row = row_of(all, box);
  ASSERT_EQ(value(all, Signal::awake, 80, row), 0.0);
  for (std::size_t sample = 80; sample <= 120; ++sample)
    EXPECT_NEAR(value(all, Signal::contact_force, sample, row, 1), 2.0 * 9.81, 0.2) << sample;
}

TEST(Extract, SignalsOfStepsDoNotDependOnKeyframes) {
  const Balance balance;
  const std::vector<std::string> names = {"contacts", "residual", "joint_force"};
  const Extract all = extract_all(balance.file.path(), names);
  for (const std::uint64_t from : {50u, 51u, 100u, 137u}) {
    Plan plan;
    plan.file = balance.file.path();
    plan.wanted = read_signals(names);
    plan.from = from;
    plan.to = 160;
    plan.threads = 2;
    const Extract some = extract(plan, [](std::uint64_t, std::uint64_t) {});
    for (std::size_t i = 0; i < some.steps.size(); ++i) {
      EXPECT_EQ(value(some, Signal::contacts, i), value(all, Signal::contacts, from + i)) << from;
      EXPECT_EQ(value(some, Signal::residual, i), value(all, Signal::residual, from + i)) << from;
      EXPECT_EQ(value(some, Signal::joint_force, i, 0, 1), value(all, Signal::joint_force, from + i, 0, 1));
    }
  }
}

TEST(Extract, FindsADamagedKeyframeHoweverManyThreadsPlay) {
  const Balance balance;
  const test::Bytes bytes = balance.file.bytes();
  int refused = 0;
  for (std::size_t at = bytes.size() / 4; at < bytes.size(); at += bytes.size() / 16) {
    TemporaryFile damaged;
    test::Bytes wrong = bytes;
    wrong[at] ^= std::byte{0x55};
    std::ofstream(damaged.path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(wrong.data()), static_cast<std::streamsize>(wrong.size()));
    std::vector<bool> throws;
    for (const int threads : {1, 2, 2, 2}) {
      try {
        extract_all(damaged.path(), {"pose"}, threads);
        throws.push_back(false);
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(damaged.path()), std::string::npos) << error.what();
        throws.push_back(true);
      }
    }
    EXPECT_EQ(throws, std::vector<bool>(4, throws.front())) << at;
    refused += throws.front() ? 1 : 0;
  }
  EXPECT_GT(refused, 5);
}

TEST(Extract, EnergyIsConservedInFreeFlight) {
  TemporaryFile file;
  World world;
  const BodyId body =
      world.create_body({.linear_velocity = {3.0f, 4.0f, 0.0f}, .angular_velocity = {1.0f, 5.0f, 2.0f}});
  world.add_shape(body, Box{{0.1f, 0.3f, 0.6f}}, {}, {.local_pose = {{0.2f, 0.1f, 0.0f}, {}}});
  Workers workers(1);
  {
    Recorder recorder(world, file.path(), {.keyframe_spacing = 10});
    for (int i = 0; i < 60; ++i) step(world, kDt / 4.0f, workers);
    recorder.finish();
  }
  const Extract all = extract_all(file.path(), {"energy"});
  EXPECT_NEAR(value(all, Signal::total_kinetic_energy, 60), world.stats().kinetic_energy,
              1e-5 * world.stats().kinetic_energy);
  const double first =
      value(all, Signal::total_kinetic_energy, 0) + value(all, Signal::total_potential_energy, 0);
  for (std::size_t sample = 0; sample < all.steps.size(); ++sample) {
    const double now =
        value(all, Signal::kinetic_energy, sample) + value(all, Signal::potential_energy, sample);
    EXPECT_NEAR(now, first, 0.02 * value(all, Signal::total_kinetic_energy, 0)) << sample;
    EXPECT_EQ(now, value(all, Signal::total_kinetic_energy, sample) +
                       value(all, Signal::total_potential_energy, sample));
  }
}

TEST(Extract, BodiesThatComeAndGoHaveNoNumbersMeanwhile) {
  TemporaryFile file;
  World world({.gravity = {}});
  const BodyId first = world.create_body({}), second = world.create_body({});
  BodyId third;
  Workers workers(1);
  {
    Recorder recorder(world, file.path(), {.keyframe_spacing = 4});
    for (int i = 0; i < 12; ++i) {
      if (i == 3) world.destroy_body(first);
      if (i == 6) {
        third = world.create_body({.position = {1.0f, 0.0f, 0.0f}});  // in the first one's place
        world.create_body({.position = {2.0f, 0.0f, 0.0f}});
      }
      step(world, kDt, workers);
    }
    recorder.finish();
  }
  ASSERT_EQ(third.index, first.index);
  const Extract all = extract_all(file.path(), {"position"});
  ASSERT_EQ(all.bodies.size(), 3u);
  const std::size_t row = row_of(all, first), other = row_of(all, second);
  for (std::size_t sample = 0; sample < 13; ++sample) {
    const double x = value(all, Signal::position, sample, row);
    if (sample <= 3) {
      EXPECT_EQ(x, 0.0);
    } else if (sample <= 6) {
      EXPECT_TRUE(std::isnan(x));
    } else {
      EXPECT_EQ(x, 1.0);
    }
    EXPECT_EQ(value(all, Signal::position, sample, other), 0.0);
    EXPECT_EQ(std::isnan(value(all, Signal::position, sample, 2)), sample <= 6);
  }
  const Extract chosen =
      extract_all(file.path(), {"position"}, 2, Isa::automatic, 1, {false, {second.index, 77}});
  ASSERT_EQ(chosen.bodies, (std::vector<std::uint32_t>{second.index}));  // there never was a body 77
  for (std::size_t sample = 0; sample < 13; ++sample)
    EXPECT_EQ(value(chosen, Signal::position, sample, 0), 0.0);
}

TEST(Extract, SamplesEveryKStepsFromTheFirst) {
  const Balance balance;
  const Extract all = extract_all(balance.file.path(), {"position"});
  for (const auto& [from, to, every] :
       {std::tuple{0u, 200u, 7u}, {13u, 177u, 10u}, {50u, 150u, 50u}, {150u, 150u, 1u}, {200u, 200u, 3u}}) {
    for (const bool with_history : {false, true}) {
      Plan plan;
      plan.file = balance.file.path();
      const std::vector<std::string> names = {"position", with_history ? "contact_force" : "awake"};
      plan.wanted = read_signals(names);
      plan.from = from;
      plan.to = to;
      plan.every = every;
      plan.threads = 2;
      const Extract some = extract(plan, [](std::uint64_t, std::uint64_t) {});
      ASSERT_EQ(some.steps.size(), (to - from) / every + 1);
      for (std::size_t i = 0; i < some.steps.size(); ++i) {
        EXPECT_EQ(some.steps[i], from + i * every);
        EXPECT_NEAR(some.times[i], static_cast<double>(i * every) * double{kDt}, 1e-6);
        EXPECT_EQ(value(some, Signal::position, i, 1, 1), value(all, Signal::position, some.steps[i], 1, 1));
      }
    }
  }
}

TEST(Extract, EventsAreThoseThatTheRunWouldHaveListed) {
  const auto run = [](const WorldSettings& settings, const std::string& file) {
    World world(settings);
    const BodyId floor = world.create_body({.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}});
    world.add_shape(floor, Box{{10.0f, 1.0f, 10.0f}});
    for (int i = 0; i < 6; ++i) {
      const BodyId ball =
          world.create_body({.position = {0.3f * static_cast<float>(i), 1.0f + static_cast<float>(i), 0.0f}});
      world.add_shape(ball, Sphere{0.3f}, {.restitution = 0.5f});
    }
    Workers workers(1);
    Recorder recorder(world, file, {.keyframe_spacing = 11});
    std::vector<EventRow> events;
    for (int i = 1; i <= 120; ++i) {
      step(world, kDt, workers);
      add_events(world, {}, static_cast<std::uint64_t>(i), 0.0, events);
    }
    recorder.finish();
    return events;
  };
  TemporaryFile silent, logged;
  run({}, silent.path());
  const std::vector<EventRow> expected = run({.contact_events = ContactEvents::all}, logged.path());
  const Extract all = extract_all(silent.path(), {"events"}, 2);
  ASSERT_EQ(all.events.size(), expected.size());
  EXPECT_GT(expected.size(), 20u);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(all.events[i].step, expected[i].step);
    EXPECT_EQ(all.events[i].kind, expected[i].kind);
    EXPECT_EQ(all.events[i].body_a, expected[i].body_a);
    EXPECT_EQ(all.events[i].body_b, expected[i].body_b);
    EXPECT_EQ(all.events[i].value, expected[i].value);
    EXPECT_NEAR(all.events[i].time, static_cast<double>(expected[i].step) * double{kDt}, 1e-6);
  }
}

TEST(Extract, RefusesARecordingThatDoesNotRepeat) {
  TemporaryFile file;
  {
    test::Heap heap;
    Recorder recorder(heap.world, file.path(), {.keyframe_spacing = 10});
    for (int i = 0; i < 30; ++i) {
      if (i == 17) internals(heap.world).bodies.velocity[heap.bodies.back().index].linear[0] += 1.0f;
      step(heap.world, kDt, heap.workers);
    }
    recorder.finish();
  }
  EXPECT_THROW(extract_all(file.path(), {"pose"}, 2), std::runtime_error);
}

TEST(ExtractTables, HoldWhatWasExtracted) {
  const Balance balance;
  const Choice choice{false, {balance.box.index}};
  const Extract all =
      extract_all(balance.file.path(), {"linear_velocity", "awake"}, 1, Isa::automatic, 100, choice);
  const std::string table = to_csv(all);
  EXPECT_TRUE(
      table.starts_with("step,time,body,linear_velocity_x,linear_velocity_y,linear_velocity_z,awake\n0,0," +
                        std::to_string(balance.box.index) + ",0,0,0,1\n100,"))
      << table;
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 4);
  const Extract none = extract_all(balance.file.path(), {"contact_force"}, 1, Isa::automatic, 200, choice);
  EXPECT_NE(to_csv(none).find("0,0," + std::to_string(balance.box.index) + ",,,\n"), std::string::npos)
      << to_csv(none);
  EXPECT_THROW(to_csv(extract_all(balance.file.path(), {"position", "contacts"})), Error);
  EXPECT_THROW(check_fits_csv(read_signals(std::vector<std::string>{"energy"})), Error);
  EXPECT_TRUE(to_npz(all).starts_with("PK"));
  EXPECT_EQ(to_npz(all), to_npz(extract_all(balance.file.path(), {"linear_velocity", "awake"}, 2, Isa::scalar,
                                            100, choice)));
}

TEST(ExtractSignals, AreReadByNameEachOnce) {
  const std::vector<std::string> names = {"pose", "position", "events", "velocity"};
  const Wanted wanted = read_signals(names);
  EXPECT_EQ(wanted.signals, (std::vector<Signal>{Signal::position, Signal::rotation, Signal::linear_velocity,
                                                 Signal::angular_velocity}));
  EXPECT_TRUE(wanted.events);
  const std::vector<std::string> wrong = {"charm"};
  EXPECT_THROW(read_signals(wrong), Error);
}

}  // namespace
}  // namespace scree::extract
