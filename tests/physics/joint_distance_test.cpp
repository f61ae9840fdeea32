// Distance joints: rods, ropes, springs.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>

namespace scree::physics {
namespace {

// A ball that a joint ties to the origin.
struct Tied {
  Lab lab;
  BodyId ball;
  JointId joint;

  Tied(const JointAxis& length, Vec3 position, const WorldSettings& settings = without_sleep())
      : lab(settings) {
    ball = lab.add({.position = position}, Sphere{0.1f});
    joint = lab.world.create_joint({.body_a = kWorld, .body_b = ball}, DistanceJoint{length});
  }
  double length() const { return lab.position(ball).norm(); }
};

TEST(DistanceJoint, ARodKeepsItsLengthWhileItSwings) {
  Tied rod({.lower = 2, .upper = 2}, {2, 0, 0});
  double worst = 0.0, highest = 0.0;
  for (int i = 0; i < 600; ++i) {
    rod.lab.run(1);
    worst = std::max(worst, std::abs(rod.length() - 2));
    if (i > 60) highest = std::max(highest, rod.lab.height(rod.ball) + 2);
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_NEAR(highest, 2.0, 0.02);  // it rises to its initial height again
}

TEST(DistanceJoint, ARodPushesAndPulls) {
  for (const float end : {-2.0f, 2.0f}) {
    Tied rod({.lower = 2, .upper = 2}, {0, end, 0});
    rod.lab.run(120);
    EXPECT_NEAR(rod.lab.height(rod.ball), static_cast<double>(end), 1e-4);
    EXPECT_NEAR(rod.lab.world.joint_reaction(rod.joint).force.y / (rod.lab.mass(rod.ball) * kGravity), 1.0,
                1e-3);
  }
}

TEST(DistanceJoint, ARopeIsSlackUntilItsLength) {
  Tied rope({.lower = 0, .upper = 2}, {0, -0.5f, 0});
  rope.lab.run(20);
  const double t = 20.0 / 60.0;
  EXPECT_NEAR(rope.lab.height(rope.ball), -0.5 - 0.5 * kGravity * t * t, 1e-5);  // free fall
  EXPECT_EQ(rope.lab.world.joint_reaction(rope.joint).force, (Vec3{0, 0, 0}));
  double longest = 0.0;
  for (int i = 0; i < 240; ++i) {
    rope.lab.run(1);
    longest = std::max(longest, rope.length());
  }
  EXPECT_LT(longest, 2.002);
  EXPECT_NEAR(rope.length(), 2.0, 1e-3);
}

TEST(DistanceJoint, ASlackRopeLetsItsAnchorsPassEachOther) {
  Tied rope({.lower = 0, .upper = 2}, {0.5f, 0, 0}, without_gravity());
  rope.lab.world.set_linear_velocity(rope.ball, {-1, 0, 0});
  rope.lab.run(60);
  EXPECT_NEAR(rope.lab.position(rope.ball).x(), -0.5, 1e-4);
}

TEST(DistanceJoint, ASoftRodGivesWayAtRestAsASpringOfItsFrequency) {
  Tied rod({.lower = 1, .upper = 1}, {0, -1, 0});
  rod.lab.world.set_joint_stiffness(rod.joint, 2.0f, 1.0f);
  rod.lab.run(1800);
  const double omega = 2 * 3.14159265358979 * 2;
  EXPECT_NEAR(rod.length() - 1, kGravity / (omega * omega), 1e-3);
}

TEST(DistanceJoint, ItsSpringHasItsFrequency) {
  for (const float target : {1.0f, 0.0f}) {
    Tied spring({.lower = 0, .drive = Drive::spring, .target = target, .hertz = 2.0f, .damping_ratio = 0.0f},
                {0, -target - 0.3f, 0}, without_gravity());
    double first = 0.0, last = 0.0, before = -0.3;
    int count = -1;
    for (int i = 0; i < 300; ++i) {
      spring.lab.run(1);
      const double now = spring.lab.height(spring.ball) + static_cast<double>(target);
      if (before < 0.0 && now >= 0.0) {
        last = (i + before / (before - now)) * static_cast<double>(kStep);
        if (++count == 0) first = last;
      }
      before = now;
    }
    ASSERT_GT(count, 5);
    EXPECT_NEAR(count / (last - first), 2.0, 0.04) << target;
  }
}

}  // namespace
}  // namespace scree::physics
