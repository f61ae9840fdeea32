// Rebound: the first bounce of a drop from height h reaches e^2 h.
#include <tests/physics/lab.h>

#include <algorithm>

namespace scree::physics {
namespace {

// How high the lowest point rises after the first impact, its gap at the start being `height`.
double first_bounce(const Geometry& geometry, double half_height, double height, float restitution) {
  Lab lab;
  lab.add_ground();
  const BodyDef def{.position = {0, static_cast<float>(half_height + height), 0}};
  const BodyId body = lab.add(def, geometry, {.restitution = restitution});
  double top = 0.0;
  bool rising = false;
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    const double speed = lab.velocity(body).y();
    if (rising && speed <= 0.0) break;
    rising = rising || speed > 0.0;
    if (rising) top = std::max(top, lab.height(body) - half_height);
  }
  return top;
}

void check_bounces(double height, double tolerance) {
  for (int tenths = 2; tenths <= 9; ++tenths) {
    const float restitution = 0.1f * static_cast<float>(tenths);
    const double e = static_cast<double>(restitution), expected = e * e * height;
    EXPECT_NEAR(first_bounce(Sphere{0.5f}, 0.5, height, restitution), expected, tolerance * expected)
        << "sphere from " << height << " m, e = " << e;
    EXPECT_NEAR(first_bounce(Box{{0.4f, 0.3f, 0.5f}}, 0.3, height, restitution), expected,
                tolerance * expected)
        << "box from " << height << " m, e = " << e;
  }
}

TEST(Restitution, FirstBounceFromTenMetersReachesItsHeight) { check_bounces(10.0, 0.03); }

TEST(Restitution, FirstBounceFromOneMeterReachesItsHeight) { check_bounces(1.0, 0.08); }

TEST(Restitution, FirstBounceDoesNotDependOnWhenInAStepItHappens) {
  // The same law where the impact comes at other moments of a step.
  for (const double height : {9.7, 9.8, 9.9, 10.05, 10.1, 10.2}) {
    const double expected = 0.25 * height;
    EXPECT_NEAR(first_bounce(Sphere{0.5f}, 0.5, height, 0.5f), expected, 0.03 * expected) << height << " m";
  }
}

TEST(Restitution, FirstBounceIsNeverLostBetweenTwoSteps) {
  // Heights so close that the surfaces meet in every substep, and between the last of one step and the first
  // of the next.
  for (int millimeters = 0; millimeters < 120; millimeters += 3) {
    const double height = 1.5 + 0.001 * millimeters, expected = 0.25 * height;
    EXPECT_NEAR(first_bounce(Sphere{0.5f}, 0.5, height, 0.5f), expected, 0.08 * expected) << height << " m";
  }
}

TEST(Restitution, SlowImpactsDoNotRebound) {
  // 1 cm: 0.44 m/s, below the threshold of 1 m/s.
  EXPECT_LT(first_bounce(Sphere{0.5f}, 0.5, 0.01, 0.9f), 1e-3);
}

TEST(Restitution, ElasticSpheresSwapTheirVelocities) {
  Lab lab(without_gravity());
  const Material elastic{.friction = 0.0f, .restitution = 1.0f};
  const BodyId a = lab.add({.position = {-2, 0, 0}, .linear_velocity = {5, 0, 0}}, Sphere{0.5f}, elastic);
  const BodyId b = lab.add({.position = {0, 0, 0}}, Sphere{0.5f}, elastic);
  lab.run(60);
  EXPECT_NEAR(lab.velocity(a).x(), 0.0, 0.01);
  EXPECT_NEAR(lab.velocity(b).x(), 5.0, 0.01);
}

}  // namespace
}  // namespace scree::physics
