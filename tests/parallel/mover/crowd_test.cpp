// Laws of movers among moving bodies of all types and shapes: whatever pushes, carries or swallows them, they
// do not enter what is fixed.
#include <tests/parallel/mover/mover_fixture.h>
#include <tests/parallel/queries/query_fixture.h>

#include <vector>

namespace scree::testing {
namespace {

// A room full of bodies, many of which overlap at first, some of them compounds.
struct Crowd {
  MixedWorld mixed;
  MoverSettings settings;
  std::vector<MoverState> movers;

  explicit Crowd(std::uint64_t seed) : mixed(seed, 150, 5.0f) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float place : {-13.0f, 13.0f}) {  // walls from 6 m on
        Vec3 center{};
        center[axis] = place;
        const BodyId wall = mixed.world.create_body({.type = BodyType::fixed, .position = center});
        mixed.world.add_shape(wall, Box{{7, 7, 7}});
      }
    }
    settings.radius = 0.25f;
    settings.half_height = 0.35f;
    Dice dice(seed + 100);
    for (int i = 0; i < 4; ++i) movers.push_back({.position = dice.within({4, 4, 4})});
  }
  double gap_to_fixed(const MoverState& mover) const {
    constexpr float kThin = 1e-4f;
    const auto hit =
        closest_to_shape(mixed.world, {Capsule{settings.half_height, kThin}, {mover.position, {}}}, 1.0f,
                         {.types = BodyTypes::fixed});
    return hit ? double{hit->distance} + kThin - settings.radius : 1.0;
  }
};

class MoverCrowds : public ::testing::TestWithParam<int> {};

TEST_P(MoverCrowds, NothingDrivesAMoverIntoWhatIsFixed) {
  Crowd crowd(static_cast<std::uint64_t>(GetParam()));
  World& world = crowd.mixed.world;
  Dice dice(static_cast<std::uint64_t>(GetParam()));
  std::vector<Vec3> wishes(crowd.movers.size());
  for (int i = 0; i < 300; ++i) {
    step(world, kMoverStep, crowd.mixed.workers);
    if (i % 40 == 39) crowd.mixed.change_something();
    for (std::size_t k = 0; k < crowd.movers.size(); ++k) {
      MoverState& mover = crowd.movers[k];
      if (i % 25 == 0) wishes[k] = dice.within({6, 0, 6});
      Vec3 wanted = wishes[k];
      if (mover.ground != MoverGround::firm) {
        wanted.y = mover.velocity.y - 9.81f * kMoverStep;
      } else if (i % 70 == 9) {
        wanted.y = 5.0f;
      }
      const double before = crowd.gap_to_fixed(mover);
      move(world, mover, crowd.settings, wanted, kMoverStep);
      const double after = crowd.gap_to_fixed(mover);
      // Those that begin in a shape, or that one was put on, come out of it; nobody else is ever in one.
      ASSERT_TRUE(after > -1e-4 || after > before - 1e-5)
          << "step " << i << ", mover " << k << ": " << before << " to " << after;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, MoverCrowds, ::testing::Range(1, 7));

TEST(MoverCrowds, ManyMoversDoNotMatterToOneAnother) {
  Crowd crowd(3);
  crowd.settings.push_force = crowd.settings.mass = 0.0f;
  for (int i = 0; i < 60; ++i) step(crowd.mixed.world, kMoverStep, crowd.mixed.workers);
  MoverState alone = crowd.movers[2];
  for (int i = 0; i < 60; ++i) {
    for (MoverState& mover : crowd.movers)
      move(crowd.mixed.world, mover, crowd.settings, {2, -3, 1}, kMoverStep);
  }
  for (int i = 0; i < 60; ++i) move(crowd.mixed.world, alone, crowd.settings, {2, -3, 1}, kMoverStep);
  EXPECT_EQ(alone, crowd.movers[2]);
}

// Positions are floats: far away from the origin they are rounded by more than movers usually leave.
TEST(MoverFarAway, AMoverWalksAndClimbsAtAHundredKilometers) {
  MoverLab lab;
  const Vec3 origin{1e5f, 0, -1e5f};
  lab.settings.skin = 0.03f;
  lab.add_box(BodyType::fixed, origin + Vec3{0, -1, 0}, {50, 1, 50});
  lab.add_box(BodyType::fixed, origin + Vec3{12, -0.75f, 0}, {10, 1, 10});  // a step of 0.25 m at x = 2
  lab.add_box(BodyType::fixed, origin + Vec3{6, 5, 0}, {1, 5, 10});         // a wall at x = 5
  lab.place(origin + Vec3{0, lab.standing(), 0});
  for (int i = 0; i < 240; ++i) {
    lab.walk({3, 0, 0.5f}, 1);
    ASSERT_GT(lab.gap(), 0.0) << i;
    ASSERT_EQ(lab.mover.ground, MoverGround::firm) << i;
  }
  EXPECT_NEAR(lab.mover.position.x - origin.x, 5.0f - 0.33f, 0.02f);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(0.25f), 0.01f);
}

}  // namespace
}  // namespace scree::testing
