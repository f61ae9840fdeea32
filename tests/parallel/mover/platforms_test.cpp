// Laws of movers among bodies that move: they ride, they push, they are pushed.
#include <tests/parallel/mover/mover_fixture.h>

#include <cstdio>
#include <string>

namespace scree::testing {
namespace {

Vec3 place_on(const MoverLab& lab, BodyId body) {
  return transform_back(lab.world.pose(body), lab.mover.position);
}

TEST(MoverPlatforms, AMoverKeepsItsPlaceOnAPlatformThatMovesAndTurns) {
  MoverLab lab;
  const BodyId platform = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {4, 0.5f, 4});
  lab.place({2.5f, lab.standing(), 1.0f});
  ASSERT_EQ(lab.mover.ground, MoverGround::firm);
  lab.world.set_linear_velocity(platform, {1.5f, 0.7f, -0.4f});
  lab.world.set_angular_velocity(platform, {0, 0.8f, 0});
  const Vec3 before = place_on(lab, platform);
  for (int i = 0; i < 600; ++i) {
    lab.walk({}, 1);
    ASSERT_EQ(lab.mover.ground, MoverGround::firm) << i;
    ASSERT_LT(distance(place_on(lab, platform), before), 1e-3f) << i;
  }
  EXPECT_EQ(lab.mover.ground_body, platform);
  const Vec3 expected = lab.world.velocity_at(platform, lab.mover.position);
  EXPECT_EQ(lab.mover.ground_velocity, expected);
  EXPECT_EQ(lab.mover.velocity, Vec3{});
}

TEST(MoverPlatforms, AMoverWalksOnAMovingPlatformAsOnFirmGround) {
  MoverLab lab;
  const BodyId platform = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {10, 0.5f, 10});
  lab.place({0, lab.standing(), 0});
  lab.world.set_linear_velocity(platform, {3, 0, 0});
  lab.walk({-1, 0, 2}, 120);
  const Vec3 place = place_on(lab, platform);
  EXPECT_NEAR(place.x, -2.0f, 1e-3f);
  EXPECT_NEAR(place.z, 4.0f, 1e-3f);
}

TEST(MoverPlatforms, AnElevatorIsRiddenUpAndDownWithoutHopping) {
  for (const float speed : {2.0f, -2.0f, -6.0f, -15.0f}) {
    MoverLab lab;
    const BodyId elevator = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {2, 0.5f, 2});
    lab.place({0.3f, lab.standing(), 0});
    lab.world.set_linear_velocity(elevator, {0, speed, 0});
    for (int i = 0; i < 300; ++i) {
      lab.walk({}, 1);
      ASSERT_EQ(lab.mover.ground, MoverGround::firm) << speed << " " << i;
      ASSERT_NEAR(place_on(lab, elevator).y, lab.standing(0.5f), 3e-3f) << speed << " " << i;
    }
  }
}

TEST(MoverPlatforms, WhoJumpsOffAPlatformTakesItsVelocityAlong) {
  for (const float rise : {0.0f, -3.0f, 2.0f}) {
    MoverLab lab;
    const BodyId platform = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {10, 0.5f, 10});
    lab.place({0, lab.standing(), 0});
    lab.world.set_linear_velocity(platform, {2, rise, 0});
    lab.walk({}, 30);
    const Vec3 before = place_on(lab, platform);
    step(lab.world, kMoverStep, lab.workers);
    lab.move({0, 2, 0}, 1);
    ASSERT_EQ(lab.mover.ground, MoverGround::none) << rise;
    EXPECT_NEAR(lab.mover.velocity.x, 2.0f, 1e-4f);
    EXPECT_NEAR(lab.mover.velocity.y, 2.0f + rise, 1e-4f);
    // As seen from the platform it flies up and comes down where it was.
    float highest = 0.0f;
    int moves = 0;
    for (; moves < 120 && lab.mover.ground != MoverGround::firm; ++moves) {
      lab.wait(1);
      highest = std::max(highest, place_on(lab, platform).y - before.y);
    }
    EXPECT_NEAR(highest, 2.0f * (2.0f + 9.81f * kMoverStep) / (2.0f * 9.81f), 6e-3f) << rise;
    EXPECT_NEAR(static_cast<float>(moves) * kMoverStep, 2.0f * 2.0f / 9.81f, 0.05f);
    EXPECT_NEAR(place_on(lab, platform).x, before.x, 0.05f);
    EXPECT_NEAR(lab.mover.velocity.x, 0.0f, 1e-3f);
  }
}

TEST(MoverPlatforms, APlatformThatIsDestroyedLetsTheMoverFall) {
  MoverLab lab;
  const BodyId platform = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {4, 0.5f, 4});
  lab.place({0, lab.standing(), 0});
  lab.world.destroy_body(platform);
  lab.walk({}, 30);
  EXPECT_EQ(lab.mover.ground, MoverGround::none);
  EXPECT_EQ(lab.mover.ground_body, BodyId{});
  EXPECT_LT(lab.mover.position.y, lab.standing() - 1.0f);
}

TEST(MoverPlatforms, AWallStopsWhoRidesAgainstIt) {
  MoverLab lab;
  const BodyId platform = lab.add_box(BodyType::kinematic, {0, -0.5f, 0}, {10, 0.5f, 10});
  lab.add_box(BodyType::fixed, {4, 5, 0}, {1, 4.9f, 20});
  lab.place({0, lab.standing(), 0});
  lab.world.set_linear_velocity(platform, {2, 0, 0});
  for (int i = 0; i < 180; ++i) {
    lab.walk({}, 1);
    ASSERT_GT(lab.gap(), 0.0);
  }
  EXPECT_NEAR(lab.mover.position.x, 3.0f - 0.32f, 1e-3f);
  EXPECT_EQ(lab.mover.ground, MoverGround::firm);
}

TEST(MoverPlatforms, AMovingWallPushesAMoverAheadAndDoesNotPassThroughIt) {
  for (const float speed : {0.5f, 5.0f, 15.0f, 40.0f}) {
    MoverLab lab;
    lab.add_floor();
    const BodyId wall = lab.add_box(BodyType::kinematic, {-2, 2, 0}, {0.5f, 1.9f, 5});
    lab.place({0, lab.standing(), 0});
    lab.world.set_linear_velocity(wall, {speed, 0, 0});
    const int steps = static_cast<int>(60.0f * 6.0f / speed) + 1;
    for (int i = 0; i < steps; ++i) {
      lab.walk({}, 1);
      ASSERT_GT(lab.mover.position.x, lab.world.pose(wall).position.x + 0.5f + 0.29f) << speed << " " << i;
      ASSERT_GT(lab.gap(), -1e-4);
      ASSERT_EQ(lab.mover.ground, MoverGround::firm);
    }
    EXPECT_NEAR(lab.mover.position.x, lab.world.pose(wall).position.x + 0.5f + 0.32f, 2e-3f) << speed;
    EXPECT_NEAR(lab.mover.position.y, lab.standing(), 2e-3f);
  }
}

TEST(MoverPlatforms, BetweenAMovingAndAFixedWallAMoverStaysOutOfTheFixedOneAndSaysSo) {
  MoverLab lab;
  lab.add_floor();
  lab.add_box(BodyType::fixed, {3, 5, 0}, {1, 5, 5});
  const BodyId wall = lab.add_box(BodyType::kinematic, {-2, 2, 0}, {0.5f, 1.9f, 5});
  lab.place({1, lab.standing(), 0});
  lab.world.set_linear_velocity(wall, {2, 0, 0});
  bool squeezed = false;
  for (int i = 0; i < 110; ++i) {
    lab.walk({}, 1);
    ASSERT_GT(lab.gap(BodyTypes::fixed), -1e-4) << i;
    squeezed = squeezed || lab.mover.squeezed;
  }
  EXPECT_TRUE(squeezed);
  lab.world.set_linear_velocity(wall, {-2, 0, 0});
  lab.walk({}, 60);
  EXPECT_FALSE(lab.mover.squeezed);
  EXPECT_GT(lab.gap(), 0.0);
}

// A box that is too high to step on.
BodyId add_load(MoverLab& lab, float friction, float mass) {
  const BodyId box = lab.world.create_body({.position = {1.5f, 0.5f, 0}, .mass = mass});
  lab.world.add_shape(box, Box{{0.5f, 0.5f, 0.5f}}, {.friction = friction, .friction_mix = MixRule::minimum});
  return box;
}

TEST(MoverPushes, ABoxOnIceIsPushedWithAtMostTheForce) {
  for (const float mass : {20.0f, 100.0f, 1000.0f}) {
    for (const float force : {50.0f, 400.0f}) {
      MoverLab lab;
      lab.settings.push_force = force;
      lab.settings.step_height = 0.1f;
      lab.add_floor();
      const BodyId box = add_load(lab, 0.0f, mass);
      lab.place({0.3f, lab.standing(), 0});
      lab.walk({}, 30);
      float fastest = 0.0f;
      for (int i = 0; i < 240; ++i) {
        const float before = lab.world.linear_velocity(box).x;
        lab.walk({3, 0, 0}, 1);
        const float gain = lab.world.linear_velocity(box).x - before;
        ASSERT_LE(gain * mass, 1.01f * force * kMoverStep + 1e-4f * mass) << mass << " " << force << " " << i;
        fastest = std::max(fastest, lab.world.linear_velocity(box).x);
        ASSERT_GT(lab.gap(), 0.0);
      }
      // As fast as the mover, unless the force cannot bring it there in this time.
      EXPECT_LT(fastest, 3.05f);
      EXPECT_GT(fastest, 0.9f * std::min(3.0f, 3.0f * force / mass)) << mass << " " << force;
    }
  }
}

TEST(MoverPushes, FrictionAboveTheForceHoldsABoxAndBelowItDoesNot) {
  for (const bool moves : {false, true}) {
    MoverLab lab;
    const float mass = 100.0f, friction = 0.5f;
    lab.settings.push_force = (moves ? 1.3f : 0.7f) * friction * mass * 9.81f;
    lab.add_floor();
    const BodyId box = add_load(lab, friction, mass);
    lab.place({0.3f, lab.standing(), 0});
    lab.walk({2, 0, 0}, 240);
    const float way = lab.world.pose(box).position.x - 1.5f;
    if (moves) {
      EXPECT_GT(way, 1.0f);
    } else {
      EXPECT_LT(way, 0.02f);
    }
  }
}

TEST(MoverPushes, WithoutForceNothingIsPushed) {
  MoverLab lab;
  lab.settings.push_force = 0.0f;
  lab.add_floor();
  const BodyId box = add_load(lab, 0.0f, 10.0f);
  lab.place({0.3f, lab.standing(), 0});
  lab.walk({2, 0, 0}, 120);
  EXPECT_NEAR(lab.world.pose(box).position.x, 1.5f, 1e-3f);
  EXPECT_LT(lab.mover.position.x, 0.7f);
}

// A cart with a wall on it: who stands in it and walks against the wall does not drive it.
TEST(MoverPushes, WhatAMoverStandsOnItDoesNotPush) {
  MoverLab lab;
  lab.add_floor();
  const BodyId cart = lab.world.create_body({.position = {0, 0.25f, 0}});
  const Material ice{.friction = 0.0f, .friction_mix = MixRule::minimum};
  lab.world.add_shape(cart, Box{{2, 0.2f, 2}}, ice);
  lab.world.add_shape(cart, Box{{0.2f, 1, 2}}, ice, {.local_pose = {{1.8f, 1.2f, 0}, {}}});
  lab.place({0, lab.standing(0.45f), 0});
  lab.walk({}, 20);
  ASSERT_EQ(lab.mover.ground_body, cart);
  lab.walk({2, 0, 0}, 120);
  EXPECT_EQ(lab.mover.ground_body, cart);
  EXPECT_NEAR(lab.world.linear_velocity(cart).x, 0.0f, 0.02f);
  EXPECT_NEAR(place_on(lab, cart).x, 1.6f - 0.32f, 5e-3f);
}

TEST(MoverPushes, AMoverWeighsOnWhatItStandsOn) {
  // A seesaw: a plank that a hinge holds in its middle.
  const auto tilt = [](float mass) {
    MoverLab lab;
    lab.settings.mass = mass;
    const BodyId plank = lab.add_box(BodyType::dynamic, {0, 1, 0}, {0.5f, 0.1f, 2});
    lab.world.create_joint({.body_a = kWorld, .body_b = plank, .frame_a = {{0, 1, 0}, {}}}, HingeJoint{});
    lab.place({0, lab.standing(1.1f), 1.5f});
    lab.walk({}, 20);
    return lab.world.pose(plank).rotation.x;
  };
  EXPECT_GT(tilt(70.0f), 0.02f);
  EXPECT_EQ(tilt(0.0f), 0.0f);
}

TEST(MoverPushes, ALightBoxDoesNotPassThroughAMoverItFallsOn) {
  MoverLab lab;
  lab.add_floor();
  lab.place({0, lab.standing(), 0});
  const BodyId box = lab.world.create_body({.position = {0.05f, 2.4f, 0}, .mass = 5.0f});
  lab.world.add_shape(box, Box{{0.3f, 0.3f, 0.3f}});
  int squeezed = 0;
  for (int i = 0; i < 240; ++i) {
    lab.walk({}, 1);
    squeezed += lab.mover.squeezed ? 1 : 0;
    ASSERT_EQ(lab.mover.ground, MoverGround::firm);
    // 2.3 m/s, which 500 N take away on 27 mm, after a step of 39 mm.
    ASSERT_GT(lab.gap(), -0.07);
  }
  EXPECT_LT(squeezed, 30);
  EXPECT_FALSE(lab.mover.squeezed);
  EXPECT_LT(distance(lab.mover.position, {0, lab.standing(), 0}), 1.0f);
}

TEST(MoverPushes, RecordingsOfPushesReplayToTheSameBits) {
  const std::string path = ::testing::TempDir() + "mover_recording.scree";
  std::uint64_t hash = 0;
  std::uint64_t steps = 0;
  {
    MoverLab lab;
    lab.add_floor();
    add_load(lab, 0.3f, 50.0f);
    add_load(lab, 0.3f, 50.0f);
    lab.place({0.3f, lab.standing(), 0});
    Recorder recorder(lab.world, path);
    lab.walk({2, 0, 0.1f}, 120);
    step(lab.world, kMoverStep, lab.workers);
    hash = lab.world.hash();
    steps = lab.world.stats().step;
    recorder.finish();
  }
  Workers workers(2);
  Player player(path);
  EXPECT_FALSE(player.verify(player.info().first_step, player.info().last_step, workers).has_value());
  player.seek(steps, workers);
  EXPECT_EQ(player.world().hash(), hash);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace scree::testing
