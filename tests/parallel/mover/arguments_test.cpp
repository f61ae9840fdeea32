// Laws of what move() is given: it refuses what is out of range, and changes nothing then.
#include <tests/parallel/mover/mover_fixture.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

namespace scree::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Standing : MoverLab {
  Standing() {
    add_floor();
    add_box(BodyType::dynamic, {0.9f, 0.5f, 0}, {0.5f, 0.5f, 0.5f});
    place({0, standing(), 0});
  }
};

// The call throws, names what is wrong, and neither the state nor the world changes.
void expect_refused(Standing& lab, const MoverSettings& settings, const MoverState& state, Vec3 velocity,
                    float dt, const char* named, ErrorCode code = ErrorCode::invalid_value) {
  MoverState given = state;
  const std::uint64_t before = lab.world.hash();
  try {
    scree::move(lab.world, given, settings, velocity, dt);
    ADD_FAILURE() << named << " was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_EQ(std::string(error.what()).rfind("move: ", 0), 0u) << error.what();
    EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
  }
  EXPECT_EQ(lab.world.hash(), before);
  if (state.position == state.position) {
    EXPECT_EQ(given, state);
  }
}

TEST(MoverArguments, SettingsOutOfRangeAreRefused) {
  Standing lab;
  struct Case {
    const char* named;
    std::function<void(MoverSettings&, float)> set;
    std::vector<float> bad;
  };
  const std::vector<Case> cases{
      {"radius", [](MoverSettings& s, float v) { s.radius = v; }, {0.0f, -0.3f, 9e-4f, 1001.0f}},
      {"half_height", [](MoverSettings& s, float v) { s.half_height = v; }, {0.0f, -1.0f, 9e-5f, 1001.0f}},
      {"up",
       [](MoverSettings& s, float v) {
         s.up = {0, v, 0};
       },
       {0.0f, 0.99f, 1.01f, 3.0f}},
      {"skin", [](MoverSettings& s, float v) { s.skin = v; }, {0.0f, -0.02f, 1e-4f, 0.31f}},
      {"slope_cosine", [](MoverSettings& s, float v) { s.slope_cosine = v; }, {0.0f, -0.5f, 0.09f, 1.01f}},
      {"step_height", [](MoverSettings& s, float v) { s.step_height = v; }, {-0.1f, 1001.0f}},
      {"snap_distance", [](MoverSettings& s, float v) { s.snap_distance = v; }, {-0.1f, 1001.0f}},
      {"push_force", [](MoverSettings& s, float v) { s.push_force = v; }, {-1.0f, 1.1e9f}},
      {"mass", [](MoverSettings& s, float v) { s.mass = v; }, {-1.0f, 1.1e6f}},
  };
  for (const Case& one : cases) {
    std::vector<float> bad = one.bad;
    bad.insert(bad.end(), {kNan, kInfinity, -kInfinity});
    for (const float value : bad) {
      MoverSettings settings;
      one.set(settings, value);
      expect_refused(lab, settings, lab.mover, {1, 0, 0}, kMoverStep, one.named);
    }
  }
  MoverSettings settings;
  settings.types = static_cast<BodyTypes>(8);
  expect_refused(lab, settings, lab.mover, {}, kMoverStep, "types");
}

TEST(MoverArguments, VelocitiesTimesAndStatesOutOfRangeAreRefused) {
  Standing lab;
  for (const float bad : {kNan, kInfinity, -kInfinity, 1.1e6f}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 velocity{};
      velocity[axis] = bad;
      expect_refused(lab, lab.settings, lab.mover, velocity, kMoverStep, "velocity");
    }
  }
  for (const float dt : {0.0f, -0.1f, 1.1f, kNan, kInfinity}) {
    expect_refused(lab, lab.settings, lab.mover, {1, 0, 0}, dt, "dt");
  }
  for (const float bad : {kNan, kInfinity, 1.1e7f}) {
    MoverState state = lab.mover;
    state.position.y = bad;
    expect_refused(lab, lab.settings, state, {1, 0, 0}, kMoverStep, "position");
  }
  MoverState state = lab.mover;
  state.place_on_ground.x = 1e9f;
  expect_refused(lab, lab.settings, state, {1, 0, 0}, kMoverStep, "place_on_ground");
  state = lab.mover;
  state.ground_normal.x = 3.0f;
  expect_refused(lab, lab.settings, state, {1, 0, 0}, kMoverStep, "ground_normal");
  state = lab.mover;
  state.ground = static_cast<MoverGround>(3);
  expect_refused(lab, lab.settings, state, {1, 0, 0}, kMoverStep, "ground");
}

TEST(MoverArguments, DeadAndForeignHandlesAndMovedWorldsAreRefused) {
  Standing lab;
  const BodyId dead = lab.world.create_body({});
  lab.world.destroy_body(dead);
  MoverSettings settings;
  settings.ignored = dead;
  expect_refused(lab, settings, lab.mover, {}, kMoverStep, "body", ErrorCode::dead_handle);
  World other;
  settings.ignored = other.create_body({});
  expect_refused(lab, settings, lab.mover, {}, kMoverStep, "body", ErrorCode::foreign_handle);
  World gone;
  const World taken = std::move(gone);
  MoverState state;
  try {
    scree::move(gone, state, {}, {}, kMoverStep);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::moved_from);
  }
}

TEST(MoverArguments, WhatThePredicateThrowsLeavesEverythingAsItWas) {
  for (int calls = 0; calls < 12; ++calls) {
    Standing lab;
    const MoverState before = lab.mover;
    const std::uint64_t hash = lab.world.hash();
    int left = calls;
    lab.settings.predicate = [&left](ShapeId, BodyId) {
      if (left-- == 0) throw std::runtime_error("no more");
      return true;
    };
    try {
      lab.move({5, 0, 0.5f}, 1);
    } catch (const std::runtime_error&) {
      EXPECT_EQ(lab.mover, before) << calls;
      EXPECT_EQ(lab.world.hash(), hash) << calls;
    }
  }
}

// Ranges end where they say: at their ends everything is taken.
TEST(MoverArguments, TheEndsOfTheRangesAreTaken) {
  Standing lab;
  MoverSettings least;
  least.radius = 1e-3f;
  least.half_height = 1e-4f;
  least.skin = 1e-3f * least.radius;
  least.slope_cosine = 0.1f;
  least.step_height = least.snap_distance = least.push_force = least.mass = 0.0f;
  MoverSettings most;
  most.radius = most.half_height = most.skin = 1e3f;
  most.slope_cosine = 1.0f;
  most.step_height = most.snap_distance = 1e3f;
  most.push_force = 1e9f;
  most.mass = 1e6f;
  for (const MoverSettings& settings : {least, most}) {
    for (const Vec3 place : {Vec3{0, 3, 0}, Vec3{1e7f, 1e7f, -1e7f}}) {
      for (const Vec3 velocity : {Vec3{}, Vec3{1e6f, 1e6f, 1e6f}, Vec3{-1e6f, -1e6f, 0}}) {
        for (const MoverGround ground : {MoverGround::none, MoverGround::firm}) {
          MoverState state{.position = place, .ground = ground};
          EXPECT_NO_THROW(scree::move(lab.world, state, settings, velocity, 1.0f));
          EXPECT_LE(std::abs(state.position.x), 1e7f);
        }
      }
    }
  }
}

TEST(MoverArguments, AnEmptyWorldStopsNobody) {
  MoverLab lab;
  lab.move({1, 2, 3}, 60);
  EXPECT_NEAR(distance(lab.mover.position, {1, 2, 3}), 0.0f, 1e-4f);
  EXPECT_EQ(lab.mover.ground, MoverGround::none);
  EXPECT_EQ(lab.mover.velocity, (Vec3{1, 2, 3}));
}

}  // namespace
}  // namespace scree::testing
