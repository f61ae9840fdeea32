// Rebound: the first bounce of a drop from height h reaches e^2 h, no rebound is lost, and none adds energy.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

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

TEST(Restitution, FirstBounceFromTenMetersReachesItsHeight) { check_bounces(10.0, 0.01); }

TEST(Restitution, FirstBounceFromOneMeterReachesItsHeight) { check_bounces(1.0, 0.01); }

TEST(Restitution, FirstBounceDoesNotDependOnWhenInAStepItHappens) {
  // The same law for impacts at other moments of a step.
  for (const double height : {9.7, 9.8, 9.9, 10.05, 10.1, 10.2}) {
    const double expected = 0.25 * height;
    EXPECT_NEAR(first_bounce(Sphere{0.5f}, 0.5, height, 0.5f), expected, 0.03 * expected) << height << " m";
  }
}

TEST(Restitution, FirstBounceIsNeverLostBetweenTwoSteps) {
  // Heights spaced so closely that the surfaces meet in every substep, and between the last substep of one
  // step and the first of the next.
  for (int millimeters = 0; millimeters < 120; millimeters += 3) {
    const double height = 1.5 + 0.001 * millimeters, expected = 0.25 * height;
    EXPECT_NEAR(first_bounce(Sphere{0.5f}, 0.5, height, 0.5f), expected, 0.08 * expected) << height << " m";
  }
}

// The largest share by which a ball that falls from `height` misses the heights of its bounces, down to the
// threshold of rebounds. Between two steps it may be higher by g dt^2 / 8.
double worst_bounce(const WorldSettings& settings, double height, float restitution, float dt, int bounces) {
  Lab lab(settings);
  lab.add_ground();
  constexpr float kRadius = 0.5f;
  const BodyId ball = lab.add({.position = {0, kRadius + static_cast<float>(height), 0}}, Sphere{kRadius},
                              {.friction = 0.0f, .restitution = restitution});
  const double e = static_cast<double>(restitution), slowest = 1.1;  // m/s; the threshold is 1
  double expected = height, top = 0, worst = 0, before = 0;
  for (int bounce = 0; bounce <= bounces && 2 * kGravity * expected > slowest * slowest;) {
    lab.run(1, dt);
    const double speed = lab.velocity(ball).y();
    if (before <= 0 && speed > 0) {
      if (bounce > 0) worst = std::max(worst, std::abs(top / expected - 1));
      ++bounce;
      expected *= e * e;
      top = 0;
    }
    top = std::max(top, lab.height(ball) - static_cast<double>(kRadius));
    before = speed;
  }
  return worst;
}

TEST(Restitution, AnElasticBallKeepsItsHeightForAHundredBounces) {
  EXPECT_LT(worst_bounce(without_sleep(), 1.0, 1.0f, kStep, 100), 0.01);
  EXPECT_LT(worst_bounce(without_sleep(), 10.0, 1.0f, kStep, 100), 0.01);
  EXPECT_LT(worst_bounce(without_sleep(), 1.0, 1.0f, 1.0f / 240, 100), 0.001);
}

TEST(Restitution, HeightsFallByItsSquareForTenBouncesDownToTheThreshold) {
  for (const float restitution : {0.95f, 0.9f, 0.8f, 0.7f, 0.5f}) {
    EXPECT_LT(worst_bounce(without_sleep(), 1.0, restitution, kStep, 10), 0.01) << "e = " << restitution;
    EXPECT_LT(worst_bounce(without_sleep(), 5.0, restitution, kStep, 10), 0.01) << "e = " << restitution;
  }
}

TEST(Restitution, HeightsAreRightInStepsOfOneSubstepToo) {
  WorldSettings settings = without_sleep();
  settings.substeps = 1;
  for (const float dt : {0.001f, 1.0f / 240, 0.01f}) {
    EXPECT_LT(worst_bounce(settings, 1.0, 1.0f, dt, 100), 0.01) << dt << " s";
    EXPECT_LT(worst_bounce(settings, 1.0, 0.8f, dt, 10), 0.015) << dt << " s";
  }
}

TEST(Restitution, SlowImpactsDoNotRebound) {
  // 1 cm: 0.44 m/s, below the threshold of 1 m/s.
  EXPECT_LT(first_bounce(Sphere{0.5f}, 0.5, 0.01, 0.9f), 1e-3);
}

TEST(Restitution, TheSpeedOfTheImpactDecidesWhetherThereIsARebound) {
  WorldSettings settings = without_sleep();
  settings.substeps = 1;
  for (int percent = 80; percent <= 130; ++percent) {
    if (percent == 100) continue;
    const double speed = 0.01 * percent, height = 0.5 * speed * speed / 9.81;
    Lab lab(settings);
    lab.add_ground();
    const BodyId ball =
        lab.add({.position = {0, 0.5f + static_cast<float>(height), 0}}, Sphere{0.5f}, {.restitution = 1.0f});
    double fastest = 0.0;
    for (int step = 0; step < 30; ++step) {
      lab.run(1, 1.0f / 60);
      fastest = std::max(fastest, lab.velocity(ball).y());
    }
    if (percent > 100) {
      EXPECT_GT(fastest, speed - 9.81 / 60 - 0.01) << speed << " m/s";
    } else {
      EXPECT_LT(fastest, 0.05) << speed << " m/s";
    }
  }
}

TEST(Restitution, WhatGravityDoesNotPullReboundsFromACeiling) {
  WorldSettings settings = without_sleep();
  settings.substeps = 1;
  for (int millimeters = 1; millimeters < 40; millimeters += 2) {
    Lab lab(settings);
    lab.add({.type = BodyType::fixed, .position = {0, 2, 0}}, Box{{5, 0.5f, 5}}, {.restitution = 1.0f});
    const float gap = 0.001f * static_cast<float>(millimeters);
    const BodyId ball =
        lab.add({.position = {0, 1.0f - gap, 0}, .linear_velocity = {0, 1.05f, 0}, .gravity_factor = 0},
                Sphere{0.5f}, {.restitution = 1.0f});
    lab.run(6, 1.0f / 60);
    EXPECT_NEAR(lab.velocity(ball).y(), -1.05, 1e-3) << gap << " m";
  }
}

WorldSettings space_of_bounces(int substeps) {
  WorldSettings settings = without_gravity();
  settings.substeps = substeps;
  return settings;
}

// Two equal bodies meet at 2 m/s each, `gap` apart; returns the speed at which they part.
double parting_speed(const Geometry& geometry, float reach, float gap, const Material& material,
                     int substeps) {
  Lab lab(space_of_bounces(substeps));
  const float start = reach + 0.5f * gap;
  const BodyId a = lab.add({.position = {-start, 0, 0}, .linear_velocity = {2, 0, 0}}, geometry, material);
  const BodyId b = lab.add({.position = {start, 0, 0}, .linear_velocity = {-2, 0, 0}}, geometry, material);
  lab.run(60);
  return lab.velocity(b).x() - lab.velocity(a).x();
}

TEST(Restitution, CollidingBodiesAlwaysSeparateByNewtonsLaw) {
  // So many gaps that the surfaces meet at every moment of a step and of a substep.
  for (const int substeps : {1, 2, 4, 16}) {
    for (int i = 0; i < 200; ++i) {
      const float gap = 0.3f + 0.0031f * static_cast<float>(i);
      const float e = 0.3f + 0.1f * static_cast<float>(i % 8);
      const Material material{.friction = 0.3f, .restitution = e};
      const double expected = 4.0 * static_cast<double>(e);
      ASSERT_NEAR(parting_speed(Sphere{0.5f}, 0.5f, gap, material, substeps), expected, 1e-3)
          << "balls, gap " << gap << ", " << substeps << " substeps";
      ASSERT_NEAR(parting_speed(Sphere{0.0286f}, 0.0286f, gap, material, substeps), expected, 1e-3)
          << "pool balls, gap " << gap << ", " << substeps << " substeps";
      ASSERT_NEAR(parting_speed(Box{{0.5f, 0.3f, 0.4f}}, 0.5f, gap, material, substeps), expected, 0.02)
          << "boxes, gap " << gap << ", " << substeps << " substeps";
    }
  }
}

TEST(Restitution, ACradleOfFreeBallsPassesTheWholeSpeedOn) {
  constexpr int kBalls = 7;
  const Material elastic{.friction = 0.0f, .restitution = 1.0f};
  for (const float gap : {0.0f, 1e-4f, 1e-3f, 0.01f, 0.1f}) {
    for (const int substeps : {1, 4, 16}) {
      Lab lab(space_of_bounces(substeps));
      BodyId balls[kBalls];
      for (int i = 0; i < kBalls; ++i) {
        const float x = i == 0 ? -0.6f : (0.2f + gap) * static_cast<float>(i);
        balls[i] = lab.add({.position = {x, 0, 0}, .linear_velocity = {i == 0 ? 3.0f : 0.0f, 0, 0}},
                           Sphere{0.1f}, elastic);
      }
      lab.run(90);
      for (int i = 0; i < kBalls; ++i) {
        EXPECT_NEAR(lab.velocity(balls[i]).x(), i == kBalls - 1 ? 3.0 : 0.0, 0.01)
            << "ball " << i << ", gap " << gap << ", " << substeps << " substeps";
      }
    }
  }
}

TEST(Restitution, ALongRowOfBallsPassesTheWholeSpeedOnWithinAStep) {
  const Material elastic{.friction = 0.0f, .restitution = 1.0f};
  Lab lab(space_of_bounces(4));
  std::vector<BodyId> balls;
  for (int i = 0; i < 60; ++i) {
    const float x = i == 0 ? -0.5f : 0.04f * static_cast<float>(i);
    balls.push_back(lab.add({.position = {x, 0, 0}, .linear_velocity = {i == 0 ? 5.0f : 0.0f, 0, 0}},
                            Sphere{0.02f}, elastic));
  }
  lab.run(60);
  EXPECT_NEAR(lab.velocity(balls.back()).x(), 5.0, 0.05);
  for (std::size_t i = 0; i + 1 < balls.size(); ++i) EXPECT_NEAR(lab.velocity(balls[i]).x(), 0.0, 0.05) << i;
}

// The highest position of the uppermost of equal balls of radius r within `seconds`, by event-driven
// simulation: they fall above each other from the heights y, and hit each other and the ground at y = 0 with
// restitution e.
double highest_by_events(std::vector<double> y, double r, double e, double seconds) {
  const std::size_t count = y.size();
  std::vector<double> v(count, 0.0);
  constexpr int kEvents = 1000;  // balls that come to rest collide infinitely often
  double highest = 0.0, now = 0.0;
  for (int event = 0; event < kEvents && now < seconds; ++event) {
    // All balls fall alike, so that pairs approach each other at constant speed.
    double next = seconds - now;
    std::size_t which = count;
    for (std::size_t i = 0; i < count; ++i) {
      double time = std::numeric_limits<double>::infinity();
      if (i == 0) {
        time = (v[0] + std::sqrt(v[0] * v[0] + 2.0 * kGravity * std::max(y[0] - r, 0.0))) / kGravity;
      } else if (v[i] < v[i - 1]) {
        time = std::max(y[i] - y[i - 1] - 2.0 * r, 0.0) / (v[i - 1] - v[i]);
      }
      if (time < next) next = time, which = i;
    }
    const double top = v[count - 1] / kGravity;  // s, until the uppermost turns
    if (v[count - 1] > 0.0) {
      const double rise = std::min(top, next);
      highest = std::max(highest, y[count - 1] + (v[count - 1] - 0.5 * kGravity * rise) * rise);
    }
    for (std::size_t i = 0; i < count; ++i) {
      y[i] += v[i] * next - 0.5 * kGravity * next * next;
      v[i] -= kGravity * next;
    }
    now += next;
    if (which == 0) v[0] = -e * v[0];
    if (which > 0 && which < count) {
      const double mean = 0.5 * (v[which] + v[which - 1]), half = 0.5 * e * (v[which - 1] - v[which]);
      v[which] = mean + half, v[which - 1] = mean - half;
    }
  }
  return highest;
}

// At `rate` steps a second. `tolerance`: of the height.
void check_falls_of_many(int rate, int most, double tolerance) {
  for (int count = 1; count <= most; ++count) {
    for (const float e : {0.7f, 0.9f, 1.0f}) {
      for (const float gap : {0.01f, 0.03f, 0.1f}) {
        WorldSettings settings = without_sleep();
        settings.restitution_threshold = 0.0f;
        Lab lab(settings);
        lab.add_ground({.friction = 0.0f, .restitution = e});
        std::vector<BodyId> balls;
        std::vector<double> heights;
        for (int i = 0; i < count; ++i) {
          heights.push_back(1.1 + static_cast<double>(i) * (0.2 + static_cast<double>(gap)));
          balls.push_back(lab.add({.position = {0, static_cast<float>(heights.back()), 0}}, Sphere{0.1f},
                                  {.friction = 0.0f, .restitution = e}));
        }
        double highest = 0.0;
        for (int i = 0; i < rate; ++i) {
          lab.run(1, 1.0f / static_cast<float>(rate));
          if (lab.velocity(balls.back()).y() > 0.0) highest = std::max(highest, lab.height(balls.back()));
        }
        const double expected = highest_by_events(heights, 0.1, static_cast<double>(e), 1.0);
        EXPECT_NEAR(highest, expected, tolerance * expected)
            << count << " balls, e = " << e << ", gap " << gap << ", " << rate << " steps a second";
      }
    }
  }
}

TEST(Restitution, BallsThatFallTogetherRiseAsInAnEventDrivenSimulation) {
  check_falls_of_many(60, 2, 0.08);
  check_falls_of_many(1920, 3, 0.02);
}

double total_energy(const Lab& lab, const std::vector<BodyId>& bodies) {
  double sum = 0.0;
  for (const BodyId body : bodies)
    sum += lab.kinetic_energy(body) + lab.mass(body) * kGravity * lab.height(body);
  return sum;
}

TEST(Restitution, AnElasticPitNeverGainsEnergy) {
  for (const float friction : {0.0f, 0.5f}) {
    const Material elastic{.friction = friction, .restitution = 1.0f};
    Lab lab;
    const std::vector<BodyId> bodies = add_heap(lab, 200, 7, elastic);
    const double start = total_energy(lab, bodies);
    for (int step = 0; step < 300; ++step) {
      lab.run(1);
      ASSERT_LT(total_energy(lab, bodies), 1.001 * start) << "friction " << friction << ", step " << step;
    }
  }
}

// Energies of bodies that tumble and bounce for ten seconds, in parts of those at the start: the largest of
// any, and the mean at the end of the shape for which it is the smallest.
struct BounceEnergy {
  double most = 0, least_mean = 1e9;
};

BounceEnergy bounce(std::span<const Geometry> geometries, float dt, int substeps) {
  const Material elastic{.friction = 0.0f, .restitution = 1.0f};
  constexpr int kBodies = 25;
  WorldSettings settings = without_sleep();
  settings.substeps = substeps;
  settings.restitution_threshold = 0.01f;
  BounceEnergy result;
  std::uint64_t number = 0;
  for (const Geometry& geometry : geometries) {
    Random random(++number);
    double sum = 0;
    for (int i = 0; i < kBodies; ++i) {
      Lab lab(settings);
      lab.add_ground(elastic);
      const Quat rotation = random.rotation();
      const std::vector<BodyId> body{lab.add({.position = {0, 2.5f, 0},
                                              .rotation = rotation,
                                              .angular_velocity = random.vector(i % 2 == 0 ? 0.0f : 5.0f)},
                                             geometry, elastic)};
      const double start = total_energy(lab, body);
      double now = 1;
      for (int step = 0; static_cast<float>(step) * dt < 10; ++step) {
        lab.run(1, dt);
        now = total_energy(lab, body) / start;
        if (!std::isfinite(now)) {
          ADD_FAILURE() << "step " << step;
          return result;
        }
        result.most = std::max(result.most, now);
      }
      sum += now;
    }
    result.least_mean = std::min(result.least_mean, sum / kBodies);
  }
  return result;
}

TEST(Restitution, BodiesThatTumbleKeepTheirEnergyButForTheTimeStep) {
  // Contacts act by the inertia and the arms of the step's beginning, and what overlaps is pushed apart. What
  // that adds falls with the time step, and not with more substeps.
  const Geometry geometries[] = {Box{{0.5f, 0.1f, 0.1f}}, Box{{0.5f, 0.5f, 0.01f}}, Box{{0.3f, 0.3f, 0.3f}},
                                 Capsule{0.5f, 0.01f}, Capsule{0.2f, 0.1f}};
  const struct {
    float dt;
    int substeps;
    double most;
  } cases[] = {{kStep, 4, 1.01}, {kStep, 1, 1.015}, {kStep, 16, 1.015}, {1.0f / 240, 4, 1.004}};
  for (const auto& [dt, substeps, most] : cases) {
    const BounceEnergy energy = bounce(geometries, dt, substeps);
    EXPECT_LT(energy.most, most) << dt << " s, " << substeps << " substeps";
    EXPECT_GT(energy.least_mean, 0.99) << dt << " s, " << substeps << " substeps";
  }
}

// Sticks that come to turn by several radians a step, and by then lose more than they gain.
TEST(Restitution, SticksThatTumbleGainNoEnergyButByTheTimeStep) {
  const Geometry stick[] = {Box{{0.5f, 0.01f, 0.01f}}};
  const struct {
    float dt;
    int substeps;
    double most, least_mean;
  } cases[] = {
      {kStep, 1, 1.015, 0.9}, {kStep, 4, 1.01, 0.8}, {kStep, 16, 1.015, 0.6}, {1.0f / 240, 4, 1.004, 0.6}};
  for (const auto& [dt, substeps, most, least_mean] : cases) {
    const BounceEnergy energy = bounce(stick, dt, substeps);
    EXPECT_LT(energy.most, most) << dt << " s, " << substeps << " substeps";
    EXPECT_GT(energy.least_mean, least_mean) << dt << " s, " << substeps << " substeps";
  }
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
