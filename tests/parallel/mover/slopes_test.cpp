// Laws of slopes and steps: what can be walked on, what is climbed, and what is followed down.
#include <tests/parallel/mover/mover_fixture.h>

#include <vector>

namespace scree::testing {
namespace {

// A slope that rises along x through the origin.
void add_slope(MoverLab& lab, double degrees) {
  const Quat turn = from_axis_angle({0, 0, 1}, static_cast<float>(degrees * kDegree));
  lab.add_box(BodyType::fixed, rotate(turn, {0, -1, 0}), {200, 1, 50}, turn);
}

// The height of a mover that touches the slope with its skin, above the slope's surface at its place.
float on_slope(const MoverLab& lab, double degrees) {
  return lab.settings.half_height + (lab.settings.radius + lab.settings.skin) / cosine_of(degrees);
}

TEST(MoverSlopes, BelowTheLimitAMoverKeepsItsWholeLevelSpeedUpAndDown) {
  for (const double limit : {30.0, 45.0, 60.0}) {
    for (const double degrees : {5.0, 0.5 * limit, limit - 1.0}) {
      for (const float speed : {3.0f, -3.0f}) {
        MoverLab lab;
        lab.settings.slope_cosine = cosine_of(limit);
        lab.settings.snap_distance = 0.2f;
        add_slope(lab, degrees);
        lab.place({0, on_slope(lab, degrees), 0});
        ASSERT_EQ(lab.mover.ground, MoverGround::firm) << limit << " " << degrees;
        lab.walk({speed, 0, 1}, 120);
        EXPECT_EQ(lab.mover.ground, MoverGround::firm);
        EXPECT_NEAR(lab.mover.position.x, 2.0f * speed, 1e-3f) << limit << " " << degrees;
        EXPECT_NEAR(lab.mover.position.z, 2.0f, 1e-3f);
        const float rise = 2.0f * speed * static_cast<float>(std::tan(degrees * kDegree));
        EXPECT_NEAR(lab.mover.position.y, rise + on_slope(lab, degrees), 5e-3f);
        EXPECT_NEAR(lab.mover.velocity.x, speed, 1e-4f);
        EXPECT_NEAR(lab.mover.velocity.y, 0.0f, 1e-4f);
      }
    }
  }
}

TEST(MoverSlopes, AboveTheLimitAMoverSlidesDownAsFrictionlessBodiesDo) {
  for (const double limit : {30.0, 45.0, 60.0}) {
    MoverLab lab;
    lab.settings.slope_cosine = cosine_of(limit);
    const double degrees = limit + 1.0;
    add_slope(lab, degrees);
    lab.place({0, on_slope(lab, degrees), 0});
    EXPECT_EQ(lab.mover.ground, MoverGround::steep);
    lab.wait(60);
    EXPECT_EQ(lab.mover.ground, MoverGround::steep);
    // The acceleration g sin(a) along the slope, for a second: the speed at once, the way half a step late.
    const double speed = 9.81 * std::sin(degrees * kDegree), way = 0.5 * speed * (61.0 / 60.0);
    EXPECT_NEAR(static_cast<double>(length(lab.mover.velocity)), speed, 0.01 * speed);
    EXPECT_NEAR(lab.mover.position.x, -way * std::cos(degrees * kDegree), 0.02 * way);
  }
}

TEST(MoverSlopes, AboveTheLimitNoMoverClimbs) {
  for (const double degrees : {46.0, 60.0, 80.0, 89.0}) {
    MoverLab lab;
    lab.add_floor();
    add_slope(lab, degrees);
    lab.place({-2.0f, lab.standing(), 0});
    ASSERT_EQ(lab.mover.ground, MoverGround::firm);
    float highest = 0.0f;
    for (int i = 0; i < 300; ++i) {
      lab.walk({5, 0, 0.5f}, 1);
      highest = std::max(highest, lab.mover.position.y);
    }
    EXPECT_LT(highest, lab.standing() + 0.05f) << degrees;
    EXPECT_NEAR(lab.mover.position.z, 2.5f, 0.1f);
  }
}

// From the air it must not climb either, however it pushes.
TEST(MoverSlopes, AMoverThatFallsOntoASteepSlopeIsDeflectedDown) {
  MoverLab lab;
  add_slope(lab, 60.0);
  lab.place({0, 4, 0});
  float before = lab.mover.position.y;
  for (int i = 0; i < 120; ++i) {
    lab.walk({5, 0, 0}, 1);
    EXPECT_LE(lab.mover.position.y, before + 1e-4f);
    before = lab.mover.position.y;
  }
  // The caller takes the slope's push away in each move, so that it comes down slowly.
  EXPECT_LT(lab.mover.position.y, 3.0f);
}

TEST(MoverSlopes, SteepSlopesOnAllSidesAreFirmGround) {
  MoverLab lab;
  for (const float side : {-1.0f, 1.0f}) {
    const Quat turn = from_axis_angle({0, 0, 1}, side * static_cast<float>(60.0 * kDegree));
    lab.add_box(BodyType::fixed, rotate(turn, {0, -1, 0}), {20, 1, 20}, turn);
  }
  lab.place({0, 3, 0});
  lab.wait(120);
  EXPECT_EQ(lab.mover.ground, MoverGround::firm);
  const Vec3 before = lab.mover.position;
  lab.walk({0, 0, 2}, 60);
  EXPECT_NEAR(lab.mover.position.z - before.z, 2.0f, 1e-2f);
  EXPECT_NEAR(lab.mover.position.y, before.y, 1e-3f);
}

// Stairs along x, of boxes that reach to the ground.
void add_stairs(MoverLab& lab, float rise, float run, int count) {
  for (int i = 0; i < count; ++i) {
    const float top = rise * static_cast<float>(i + 1), x = 1.0f + run * static_cast<float>(i);
    lab.add_box(BodyType::fixed, {x + 10.0f, top - 5.0f, 0}, {10, 5, 5});
  }
}

TEST(MoverSteps, StairsUpToTheStepHeightAreClimbedAtFullSpeed) {
  for (const float rise : {0.05f, 0.2f, 0.3f, 0.35f}) {
    for (const float speed : {0.2f, 1.0f, 4.0f}) {
      MoverLab lab;
      lab.add_floor();
      add_stairs(lab, rise, 0.8f, 4);
      lab.place({0.2f, lab.standing(), 0});
      const int moves = static_cast<int>(60.0f * 4.6f / speed);
      double least = 1.0;
      for (int i = 0; i < moves; ++i) {
        lab.walk({speed, 0, 0}, 1);
        ASSERT_EQ(lab.mover.ground, MoverGround::firm) << rise << " " << speed << " " << lab.mover.position.x;
        least = std::min(least, lab.gap());
      }
      EXPECT_GT(least, 0.0);
      // Steps may bring it ahead a little: by what their reach adds.
      EXPECT_GT(lab.mover.position.x, 0.2f + 4.6f - 0.1f) << rise << " " << speed;
      EXPECT_LT(lab.mover.position.x, 0.2f + 4.6f + 0.15f) << rise << " " << speed;
      EXPECT_NEAR(lab.mover.position.y, lab.standing(4.0f * rise), 1e-3f) << rise << " " << speed;
    }
  }
}

TEST(MoverSteps, AStepAboveTheStepHeightStopsAMover) {
  for (const float rise : {0.355f, 0.45f, 0.6f, 1.5f}) {
    for (const float speed : {0.2f, 1.0f, 4.0f, 20.0f}) {
      MoverLab lab;
      lab.add_floor();
      add_stairs(lab, rise, 5.0f, 1);
      lab.place({0, lab.standing(), 0});
      lab.walk({speed, 0, 0}, static_cast<int>(60.0f * 3.0f / speed) + 120);
      EXPECT_NEAR(lab.mover.position.y, lab.standing(), 1e-3f) << rise << " " << speed;
      EXPECT_LT(lab.mover.position.x, 1.0f) << rise << " " << speed;
      EXPECT_TRUE(lab.mover.touches_wall);
    }
  }
}

TEST(MoverSteps, ThereAreNoStepsWithoutStepHeight) {
  MoverLab lab;
  lab.settings.step_height = 0.0f;
  lab.add_floor();
  add_stairs(lab, 0.25f, 5.0f, 1);
  lab.place({0, lab.standing(), 0});
  lab.walk({2, 0, 0}, 180);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(), 1e-3f);
  EXPECT_LT(lab.mover.position.x, 1.0f);
}

TEST(MoverSteps, AWallBesideTheStairsDoesNotHinder) {
  MoverLab lab;
  lab.add_floor();
  add_stairs(lab, 0.3f, 0.8f, 4);
  lab.add_box(BodyType::fixed, {0, 5, 1.5f}, {20, 10, 1});  // its face at z = 0.5
  lab.place({0.2f, lab.standing(), 0});
  lab.walk({2, 0, 1}, 150);
  EXPECT_GT(lab.mover.position.x, 0.2f + 5.0f - 0.2f);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(1.2f), 1e-3f);
}

TEST(MoverSteps, AStepUnderALowCeilingIsNotClimbed) {
  MoverLab lab;
  lab.add_floor();
  add_stairs(lab, 0.3f, 5.0f, 1);
  const float head = 2.0f * (lab.settings.half_height + lab.settings.radius);
  lab.add_box(BodyType::fixed, {3, head + 0.2f + 1.0f, 0}, {2.5f, 1, 5});  // from x = 0.5
  lab.place({0, lab.standing(), 0});
  for (int i = 0; i < 180; ++i) {
    lab.walk({2, 0, 0}, 1);
    ASSERT_GT(lab.gap(), 0.0);
  }
  EXPECT_LT(lab.mover.position.x, 1.0f);
}

TEST(MoverSteps, StairsAreFollowedDownWithoutLeavingTheGround) {
  MoverLab lab;
  lab.add_floor();
  add_stairs(lab, 0.3f, 0.8f, 4);
  lab.place({6.0f, lab.standing(1.2f), 0});
  for (int i = 0; i < 180; ++i) {
    lab.walk({-2.5f, 0, 0}, 1);
    ASSERT_EQ(lab.mover.ground, MoverGround::firm) << lab.mover.position.x;
  }
  EXPECT_NEAR(lab.mover.position.x, -1.5f, 1e-2f);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(), 1e-3f);
}

TEST(MoverSteps, BehindALedgeDeeperThanTheSnapDistanceAMoverFalls) {
  MoverLab lab;
  lab.add_floor();
  add_stairs(lab, 1.5f, 5.0f, 1);
  lab.place({3.0f, lab.standing(1.5f), 0});
  bool fell = false;
  for (int i = 0; i < 90; ++i) {
    lab.walk({-3, 0, 0}, 1);
    fell = fell || lab.mover.ground == MoverGround::none;
  }
  EXPECT_TRUE(fell);
  lab.walk({}, 60);
  EXPECT_EQ(lab.mover.ground, MoverGround::firm);
  EXPECT_NEAR(lab.mover.position.y, lab.standing(), 3e-3f);
}

TEST(MoverSteps, AJumpFollowsTheParabolaAndLands) {
  MoverLab lab;
  lab.add_floor();
  lab.place({0, lab.standing(), 0});
  const float start = lab.mover.position.y;
  Vec3 wanted{2, 5, 0};
  float highest = 0.0f;
  int in_air = 0;
  for (int i = 0; i < 120; ++i) {
    lab.move(wanted, 1);
    if (lab.mover.ground == MoverGround::firm) break;
    ++in_air;
    highest = std::max(highest, lab.mover.position.y - start);
    wanted = lab.mover.velocity + Vec3{0, -9.81f * kMoverStep, 0};
  }
  // Semi-implicit: v (v + g dt) / (2 g) at the top.
  EXPECT_NEAR(highest, 5.0f * (5.0f + 9.81f * kMoverStep) / (2.0f * 9.81f), 5e-3f);
  EXPECT_NEAR(static_cast<float>(in_air) * kMoverStep, 2.0f * 5.0f / 9.81f, 0.05f);
  EXPECT_NEAR(lab.mover.position.y, start, 3e-3f);
}

TEST(MoverSteps, UpMayBeAnyDirection) {
  for (const Vec3 up : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, normalize(Vec3{1, 2, -3})}) {
    MoverLab lab;
    lab.settings.up = up;
    const Quat turn = up.y < -0.9f ? Quat{1, 0, 0, 0} : MoverLab::turn_of(up);
    lab.add_box(BodyType::fixed, rotate(turn, {0, -1, 0}), {50, 1, 50}, turn);
    lab.add_box(BodyType::fixed, rotate(turn, {3, -0.7f, 0}), {2, 1, 5}, turn);  // a step of 0.3 m
    lab.place(rotate(turn, {0, lab.standing(), 0}));
    ASSERT_EQ(lab.mover.ground, MoverGround::firm);
    lab.move(rotate(turn, {2, 0, 0}), 90);
    const Vec3 place = rotate_back(turn, lab.mover.position);
    EXPECT_NEAR(place.x, 3.0f, 0.05f);
    EXPECT_NEAR(place.y, lab.standing(0.3f), 1e-3f);
    EXPECT_EQ(lab.mover.ground, MoverGround::firm);
  }
}

}  // namespace
}  // namespace scree::testing
