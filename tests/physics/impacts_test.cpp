// Impacts of several bodies at once: in the order of time, symmetric, and without a gain of energy.
#include <tests/physics/lab.h>

#include <algorithm>
#include <limits>

namespace scree::physics {
namespace {

WorldSettings empty_space(int substeps, float threshold = 1.0f) {
  WorldSettings settings = without_gravity();
  settings.substeps = substeps;
  settings.restitution_threshold = threshold;
  return settings;
}

Material smooth(float restitution) {
  return {.friction = 0.0f, .restitution = restitution, .patch_radius = 0.0f};
}

struct Disk {
  Eigen::Vector2d position, velocity;
};

// A rack of fifteen balls with gaps between them, and the ball that breaks it as the first.
constexpr double kBallRadius = 0.0285;  // m
std::vector<Disk> rack(double gap, double offset, double speed) {
  std::vector<Disk> balls{{{-0.3, offset}, {speed, 0}}};
  const double distance = 2 * kBallRadius + gap;
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i <= row; ++i)
      balls.push_back({{row * distance * std::sqrt(0.75), (i - 0.5 * row) * distance}, {0, 0}});
  }
  return balls;
}

std::vector<BodyId> add_balls(Lab& lab, const std::vector<Disk>& balls, const Material& material) {
  std::vector<BodyId> bodies;
  for (const Disk& ball : balls) {
    const Eigen::Vector2f at = ball.position.cast<float>(), v = ball.velocity.cast<float>();
    bodies.push_back(lab.add({.position = {at.x(), at.y(), 0}, .linear_velocity = {v.x(), v.y(), 0}},
                             Sphere{static_cast<float>(kBallRadius)}, material));
  }
  return bodies;
}

// The time until two disks meet; infinite if they do not.
double meeting(const Disk& a, const Disk& b) {
  const Eigen::Vector2d apart = b.position - a.position, speed = b.velocity - a.velocity;
  const double closing = apart.dot(speed);
  const double gap = apart.squaredNorm() - 4 * kBallRadius * kBallRadius;
  const double square = closing * closing - speed.squaredNorm() * gap;
  if (closing > -1e-9 || square < 0) return std::numeric_limits<double>::infinity();
  return std::max(gap, 0.0) / (std::sqrt(square) - closing);
}

// Elastic disks after `seconds`, impact by impact.
std::vector<Disk> play_events(std::vector<Disk> disks, double seconds) {
  for (double left = seconds; left > 0;) {
    double next = left;
    std::size_t first = 0, second = 0;
    for (std::size_t i = 0; i < disks.size(); ++i) {
      for (std::size_t j = i + 1; j < disks.size(); ++j) {
        if (const double time = meeting(disks[i], disks[j]); time < next) next = time, first = i, second = j;
      }
    }
    for (Disk& disk : disks) disk.position += disk.velocity * next;
    left -= next;
    if (first == second) break;
    Disk &a = disks[first], &b = disks[second];
    const Eigen::Vector2d normal = (b.position - a.position).normalized();
    const double speed = (b.velocity - a.velocity).dot(normal);
    a.velocity += speed * normal;
    b.velocity -= speed * normal;
  }
  return disks;
}

double energy_of(const Lab& lab, const std::vector<BodyId>& bodies) {
  double sum = 0;
  for (const BodyId body : bodies) sum += lab.kinetic_energy(body);
  return sum;
}

TEST(Impacts, OfABallOnTwoAtOnceAreThoseOfTheEquations) {
  // Two balls that touch, hit along their line of symmetry: P (1 + 2 cos^2 30) = (1 + e) m u cos 30.
  for (const float e : {0.3f, 0.7f, 1.0f}) {
    for (const int substeps : {1, 4}) {
      Lab lab(empty_space(substeps));
      const double u = 5, cosine = std::sqrt(0.75), touching = 1.000001 * kBallRadius;
      const std::vector<BodyId> bodies = add_balls(lab,
                                                   {{{-1e-4, 0}, {u, 0}},
                                                    {{2 * cosine * kBallRadius, touching}, {0, 0}},
                                                    {{2 * cosine * kBallRadius, -touching}, {0, 0}}},
                                                   smooth(e));
      lab.run(30);
      const double after = (1 + static_cast<double>(e)) * u * cosine / 2.5;
      EXPECT_NEAR(lab.velocity(bodies[0]).x(), u - 2 * after * cosine, 1e-3 * u) << e;
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(lab.velocity(bodies[1 + static_cast<std::size_t>(i)]).x(), after * cosine, 1e-3 * u) << e;
        EXPECT_NEAR(lab.velocity(bodies[1 + static_cast<std::size_t>(i)]).y(), after * (i == 0 ? 0.5 : -0.5),
                    1e-3 * u)
            << e;
      }
    }
  }
}

TEST(Impacts, OfABreakAreSymmetricAndKeepTheEnergy) {
  for (const double gap : {0.0, 1e-4, 1e-3, 1e-2}) {
    for (const int substeps : {1, 4}) {
      for (const int rate : {60, 240}) {
        Lab lab(empty_space(substeps, 0.01f));
        const std::vector<BodyId> bodies = add_balls(lab, rack(gap, 0, 10), smooth(1));
        const double start = energy_of(lab, bodies);
        lab.run(rate / 3, 1.0f / static_cast<float>(rate));
        SCOPED_TRACE(testing::Message()
                     << gap << " m, " << substeps << " substeps, " << rate << " steps a second");
        EXPECT_NEAR(energy_of(lab, bodies) / start, 1, 1e-4);
        for (int row = 0, first = 1; row < 5; first += ++row) {
          for (int i = 0; i <= row; ++i) {
            const Eigen::Vector3d one = lab.velocity(bodies[static_cast<std::size_t>(first + i)]);
            const Eigen::Vector3d other = lab.velocity(bodies[static_cast<std::size_t>(first + row - i)]);
            EXPECT_NEAR(one.x(), other.x(), 1e-4) << "row " << row;
            EXPECT_NEAR(one.y(), -other.y(), 1e-4) << "row " << row;
          }
        }
      }
    }
  }
}

TEST(Impacts, OfABreakWithGapsAreThoseOfAnEventDrivenSimulation) {
  constexpr double kOffset = 0.007;  // m, so that no two impacts come at the same moment
  const std::vector<Disk> truth = play_events(rack(1e-3, kOffset, 10), 0.1);
  Lab lab(empty_space(4, 0.01f));
  const std::vector<BodyId> bodies = add_balls(lab, rack(1e-3, kOffset, 10), smooth(1));
  lab.run(1600, 1.0f / 16000);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Vector2d velocity = lab.velocity(bodies[i]).head<2>();
    EXPECT_LT((velocity - truth[i].velocity).norm(), 0.1) << "ball " << i;
  }
}

TEST(Impacts, OfRandomClustersKeepMomentumAndNeverAddEnergy) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const float e = seed % 4 == 0 ? 1.0f : 0.25f * static_cast<float>(seed % 4);
    const float friction = seed % 3 == 0 ? 0.0f : 0.5f;
    Lab lab(empty_space(seed % 2 == 0 ? 1 : 4, 0.01f));
    std::vector<BodyId> bodies;
    // A grid of boxes and balls that nearly touch, of densities that differ, and bodies that fly into it.
    for (int i = 0; i < 27; ++i) {
      const Vec3 at{0.401f * static_cast<float>(i % 3), 0.401f * static_cast<float>(i / 3 % 3),
                    0.401f * static_cast<float>(i / 9)};
      const Material material{.friction = friction, .restitution = e};
      const float mass = random.uniform(1.0f, 10.0f);
      bodies.push_back(i % 2 == 0
                           ? lab.add({.position = at, .mass = mass}, Sphere{0.2f}, material)
                           : lab.add({.position = at, .mass = mass}, Box{{0.2f, 0.2f, 0.2f}}, material));
    }
    for (int i = 0; i < 4; ++i) {
      const Vec3 at{0.4f, -1.0f - static_cast<float>(i), random.uniform(0.3f, 0.5f)};
      const Vec3 velocity{random.uniform(0.0f, 0.3f), 8, 0};
      bodies.push_back(lab.add({.position = at, .linear_velocity = velocity}, Sphere{0.2f},
                               {.friction = friction, .restitution = e}));
    }
    const auto momentum = [&] {
      Eigen::Vector3d sum(0, 0, 0);
      for (const BodyId body : bodies) sum += lab.mass(body) * lab.velocity(body);
      return sum;
    };
    const Eigen::Vector3d before = momentum();
    double last = energy_of(lab, bodies);
    for (int step = 0; step < 60; ++step) {
      lab.run(1);
      const double energy = energy_of(lab, bodies);
      ASSERT_LT(energy, 1.005 * last) << "seed " << seed << ", step " << step;
      last = energy;
    }
    EXPECT_LT((momentum() - before).norm(), 1e-3 * before.norm()) << "seed " << seed;
  }
}

// Cubes that lie face to face overlap by what rounding makes of it, so that points meet which part already.
TEST(Impacts, OfCubesFaceToFaceKeepTheEnergy) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    for (const int substeps : {1, 4}) {
      Random random(seed);
      Lab lab(empty_space(substeps, 0.01f));
      std::vector<BodyId> bodies;
      const auto add_cube = [&](Vec3 at, Vec3 velocity, float mass, float half) {
        bodies.push_back(lab.add({.position = at, .linear_velocity = velocity, .mass = mass},
                                 Box{{half, half, half}}, smooth(1)));
      };
      for (int i = 0; i < 27; ++i) {
        const Vec3 at{static_cast<float>(i % 3), static_cast<float>(i / 3 % 3), static_cast<float>(i / 9)};
        const float scale = random.uniform(-1.0f, 1.0f);
        add_cube(at, {}, scale < 0 ? 1 / (1 - 9 * scale) : 1 + 9 * scale, 0.5f);
      }
      for (const float side : {-1.0f, 1.0f}) {
        const float y = random.uniform(0, 2), z = random.uniform(0, 2), along = random.uniform(-1, 1);
        add_cube({side < 0 ? -3.0f : 6.0f, y, z}, {side < 0 ? 6.0f : -9.0f, along, -along},
                 side < 0 ? 1.0f : 20.0f, 0.4f);
      }
      const double before = energy_of(lab, bodies);
      for (int step = 0; step < 240; ++step) {
        lab.run(1, 1.0f / 240);
        const double energy = energy_of(lab, bodies);
        ASSERT_TRUE(energy > 0.99 * before && energy < 1.002 * before)
            << energy / before << ", seed " << seed << ", " << substeps << " substeps, step " << step;
      }
    }
  }
}

// A slab, and above it a layer of balls that all come at it at once, `side` times `side` of them.
std::vector<BodyId> add_rain(Lab& lab, int side, const Material& material) {
  const float half = 0.15f * static_cast<float>(side);
  std::vector<BodyId> bodies{lab.add({.position = {0, 0, 0}, .mass = 50}, Box{{half, 0.1f, half}}, material)};
  for (int i = 0; i < side * side; ++i) {
    const Vec3 at{0.3f * static_cast<float>(i % side) - half + 0.15f, 0.6f,
                  0.3f * static_cast<float>(i / side) - half + 0.15f};
    bodies.push_back(
        lab.add({.position = at, .linear_velocity = {0, -5, 0}, .mass = 0.5f}, Sphere{0.1f}, material));
  }
  return bodies;
}

TEST(Impacts, OfHundredsOnOneBodyAtOnceAreThatOfTheirMassAndKeepTheEnergy) {
  for (const int side : {2, 7, 20}) {
    Lab lab(empty_space(4, 0.01f));
    const std::vector<BodyId> bodies = add_rain(lab, side, smooth(1));
    const double mass = 50, rain = 0.5 * side * side, start = energy_of(lab, bodies);
    lab.run(12);
    SCOPED_TRACE(side * side);
    EXPECT_NEAR(energy_of(lab, bodies) / start, 1, 1e-3);
    const double slab = -5 * 2 * rain / (mass + rain);
    EXPECT_NEAR(lab.velocity(bodies[0]).y(), slab, 1e-2 * std::abs(slab));
    EXPECT_LT(lab.spin(bodies[0]).norm(), 1e-2);
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      EXPECT_NEAR(lab.velocity(bodies[i]).y(), 5 + slab, 0.05) << "ball " << i;
    }
  }
}

TEST(Impacts, HaveTheSameBitsOnEveryInstructionSetAndThreadCount) {
  std::uint64_t expected = 0;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Lab lab;
      lab.workers = Workers(WorkersOptions{.threads = threads, .isa = isa});
      const Material material{.friction = 0.3f, .restitution = 0.8f};
      lab.add({.type = BodyType::fixed, .position = {0, -2, 0}}, Box{{20, 1, 20}}, material);
      add_rain(lab, 16, material);
      Random random(5);
      for (int i = 0; i < 200; ++i) {
        const Quat rotation = random.rotation();
        const Vec3 at{random.uniform(-2, 2), random.uniform(1, 4), random.uniform(-2, 2)};
        lab.add({.position = at, .rotation = rotation}, Box{{0.1f, 0.05f, 0.15f}}, material);
      }
      lab.run(150);
      if (expected == 0) expected = lab.world.hash();
      EXPECT_EQ(lab.world.hash(), expected) << isa_name(isa) << ", " << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace scree::physics
