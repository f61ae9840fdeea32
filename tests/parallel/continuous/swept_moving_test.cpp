// Laws of sweeps against what moves, and of the time that a stopped body makes up for.
#include <tests/physics/lab.h>

#include <cmath>
#include <vector>

namespace scree::physics {
namespace {

constexpr float kMovingBullet = 1000.0f;  // m/s: 16.7 m a step
constexpr Material kElastic{.friction = 0, .restitution = 1};

WorldSettings for_bullets() {
  WorldSettings settings = without_gravity();
  settings.max_linear_speed = 2000;
  settings.max_angular_speed = 2000;
  return settings;
}

const Geometry kMovingBullets[] = {Sphere{0.01f}, Capsule{0.02f, 0.01f}, Box{{0.01f, 0.015f, 0.012f}},
                                   Sphere{0.5f}};

TEST(SweptMoving, BulletsThatFlyAtEachOtherChangeTheirVelocities) {
  for (const float distance : {1.0f, 5.0f, 16.0f, 40.0f}) {
    Lab lab(for_bullets());
    const BodyId a = lab.add({.position = {-distance, 0, 0}, .linear_velocity = {kMovingBullet, 0, 0}},
                             Sphere{0.01f}, kElastic);
    const BodyId b = lab.add({.position = {distance, 0, 0}, .linear_velocity = {-0.5f * kMovingBullet, 0, 0}},
                             Sphere{0.01f}, kElastic);
    for (int i = 0; i < 12; ++i) {
      lab.run(1);
      ASSERT_LT(lab.position(a).x(), lab.position(b).x()) << distance << ", step " << i;
    }
    EXPECT_NEAR(lab.velocity(a).x(), -0.5 * double{kMovingBullet}, 1e-4 * double{kMovingBullet}) << distance;
    EXPECT_NEAR(lab.velocity(b).x(), double{kMovingBullet}, 1e-4 * double{kMovingBullet}) << distance;
  }
}

TEST(SweptMoving, NoBulletPassesAThinPlateThatFloats) {
  for (const Geometry& bullet : kMovingBullets) {
    Random random(5);
    for (int shot = 0; shot < 20; ++shot) {
      Lab lab(for_bullets());
      // It moves and turns slowly, so that it does not sleep.
      const BodyId plate = lab.add({.position = {random.uniform(5, 30), 0, 0},
                                    .linear_velocity = random.vector(1),
                                    .angular_velocity = random.vector(1)},
                                   Box{{0.005f, 3, 3}}, {.density = 1e6f});
      const BodyId body = lab.add({.position = {0, random.uniform(-1, 1), random.uniform(-1, 1)},
                                   .rotation = random.rotation(),
                                   .linear_velocity = {kMovingBullet, 0, 0},
                                   .angular_velocity = random.vector(20)},
                                  bullet);
      for (int i = 0; i < 6; ++i) {
        lab.run(1);
        const Pose pose = lab.world.pose(plate);
        const Eigen::Vector3d local =
            to_eigen(pose.rotation).conjugate() * (lab.position(body) - to_eigen(pose.position));
        ASSERT_LT(local.x(), 0.0) << "bullet " << bullet.index() << ", shot " << shot << ", step " << i;
      }
    }
  }
}

// The parts are swept from different speeds on. Whichever goes ahead, none passes a plate that is fixed or
// floats.
TEST(SweptMoving, NoPartOfACompoundPassesAPlate) {
  for (const float speed : {3.0f, 14.0f, 29.0f, 31.0f, 59.0f, 61.0f, 300.0f, 1000.0f}) {
    for (const float thin_at : {0.9f, -0.9f}) {
      for (const BodyType type : {BodyType::fixed, BodyType::dynamic}) {
        Lab lab(for_bullets());
        const BodyId plate = lab.add({.type = type, .position = {20, 0, 0}, .linear_velocity = {-0.1f, 0, 0}},
                                     Box{{0.005f, 3, 3}}, {.density = 1e6f});
        const BodyId body = lab.add({.linear_velocity = {speed, 0, 0}}, Sphere{0.5f});
        lab.world.add_shape(body, Box{{0.01f, 0.3f, 0.3f}}, {}, {.local_pose = {{thin_at, 0, 0}, {}}});
        for (int i = 0; i < 8 + static_cast<int>(1200.0f / speed); ++i) {
          lab.run(1);
          const double at = to_eigen(lab.world.pose(plate).position).x();
          const Pose pose = lab.world.pose(body);
          for (const float part : {0.0f, thin_at}) {
            const Eigen::Vector3d place =
                to_eigen(pose.position) + to_eigen(pose.rotation) * Eigen::Vector3d(double{part}, 0, 0);
            ASSERT_LT(place.x(), at) << speed << " m/s, part " << part << " of " << thin_at << ", step " << i;
          }
        }
      }
    }
  }
}

TEST(SweptMoving, MomentumIsConserved) {
  Lab lab(for_bullets());
  Random random(6);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d place = to_eigen(random.vector(1)).normalized() * double{random.uniform(4, 12)};
    const Eigen::Vector3d velocity = -place.normalized() * double{random.uniform(50, 500)};
    const auto to_vec3 = [](const Eigen::Vector3d& v) {
      return Vec3{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    };
    bodies.push_back(lab.add({.position = to_vec3(place), .linear_velocity = to_vec3(velocity)},
                             kMovingBullets[i % 3], {.friction = 0, .restitution = 0.5f}));
  }
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const BodyId body : bodies) sum += lab.velocity(body) * lab.mass(body);
    return sum;
  };
  const auto size = [&] {
    double sum = 0;
    for (const BodyId body : bodies) sum += lab.velocity(body).norm() * lab.mass(body);
    return sum;
  };
  const Eigen::Vector3d before = momentum();
  const double scale = size();
  lab.run(10);
  EXPECT_LT((momentum() - before).norm(), 1e-5 * scale);
}

TEST(SweptMoving, ASpinningRodHitsABallInItsWay) {
  for (const float spin : {20.0f, 60.0f, 180.0f}) {
    Lab lab(for_bullets());
    lab.add({.angular_velocity = {0, 0, spin}}, Box{{1, 0.01f, 0.01f}}, {.friction = 0});
    // The ball moves slowly where the rod's end passes.
    const BodyId ball =
        lab.add({.position = {0, 0.9f, 0}, .linear_velocity = {0, 0.1f, 0}}, Sphere{0.05f}, {.friction = 0});
    lab.run(20);
    EXPECT_GT(lab.velocity(ball).norm(), 0.1 * double{spin}) << spin;
  }
}

TEST(SweptMoving, AFastPaddleTakesABallAlong) {
  Lab lab(for_bullets());
  const BodyId paddle = lab.add(
      {.type = BodyType::kinematic, .position = {-5, 0, 0}, .linear_velocity = {0.5f * kMovingBullet, 0, 0}},
      Box{{0.01f, 1, 1}});
  const BodyId ball = lab.add({.linear_velocity = {0, 0.1f, 0}}, Sphere{0.1f}, {.friction = 0});
  for (int i = 0; i < 5; ++i) {
    lab.run(1);
    ASSERT_GT(lab.position(ball).x(), lab.position(paddle).x()) << i;
  }
  EXPECT_NEAR(lab.velocity(ball).x(), 0.5 * double{kMovingBullet}, 0.01 * double{kMovingBullet});
}

TEST(SweptMoving, AStoppedBodyMakesUpForTheTimeThatItHasNotMoved) {
  for (const float wall : {3.0f, 8.0f, 12.0f, 15.0f}) {
    Lab lab(for_bullets());
    lab.add({.type = BodyType::fixed, .position = {wall + 0.5f, 0, 0}}, Box{{0.5f, 20, 20}}, kElastic);
    const BodyId ball = lab.add({.linear_velocity = {kMovingBullet, 3, 0}, .angular_velocity = {7, 0, 0}},
                                Sphere{0.1f}, kElastic);
    lab.run(2);
    const double way = 2.0 * double{kMovingBullet} / 60.0, there = double{wall} - 0.1;
    EXPECT_NEAR(lab.position(ball).x(), there - (way - there), 2e-3 * way) << wall;
    EXPECT_NEAR(lab.position(ball).y(), 3.0 * 2.0 / 60.0, 1e-4) << wall;
    EXPECT_NEAR(lab.velocity(ball).x(), -double{kMovingBullet}, 1e-3) << wall;
    const double turn = 2.0 * std::acos(std::abs(double{lab.world.pose(ball).rotation.w}));
    EXPECT_NEAR(turn, 7.0 * 2.0 / 60.0, 1e-3) << wall;
  }
}

TEST(SweptMoving, SmallFastBallsKeepTheirEnergy) {
  struct Case {
    float radius, height, step;
  };
  for (const Case& c : {Case{0.05f, 5, 1.0f / 60}, Case{0.1f, 10, 1.0f / 60}, Case{0.02f, 2, 1.0f / 60},
                        Case{0.01f, 20, 1.0f / 60}, Case{0.1f, 5, 1.0f / 30}, Case{0.02f, 20, 1.0f / 30},
                        Case{0.05f, 5, 1.0f / 240}}) {
    Lab lab;
    lab.add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{50, 1, 50}}, kElastic);
    const BodyId ball = lab.add({.position = {0, c.radius + c.height, 0}}, Sphere{c.radius}, kElastic);
    const double gravity = -double{lab.world.settings().gravity.y};
    const double before = gravity * double{c.height};
    double least = 1e9, most = 0;
    int bounces = 0;
    for (double last = 0; bounces < 100;) {
      step(lab.world, c.step, lab.workers);
      const double v = lab.velocity(ball).y();
      const double energy = 0.5 * v * v + gravity * (lab.position(ball).y() - double{c.radius});
      least = std::min(least, energy);
      most = std::max(most, energy);
      if (last < 0 && v > 0) ++bounces;
      last = v;
    }
    EXPECT_GT(least, 0.99 * before) << c.radius << " " << c.height;
    EXPECT_LT(most, 1.01 * before) << c.radius << " " << c.height;
  }
}

// A ball that a wall has just stopped, and lags.
struct Stopped {
  Lab lab{for_bullets()};
  BodyId ball;

  Stopped() {
    lab.add({.type = BodyType::fixed, .position = {3, 0, 0}}, Box{{0.5f, 20, 20}}, kElastic);
    ball = lab.add({.linear_velocity = {kMovingBullet, 0, 0}}, Sphere{0.1f}, kElastic);
    lab.run(1);
  }
};

// Who moves a stopped body, or gives it a velocity, finds it where that takes it.
TEST(SweptMoving, APlaceOrAVelocityEndsTheLag) {
  Stopped placed;
  placed.lab.world.set_pose(placed.ball, {{-50, 0, 0}, {}});
  placed.lab.run(1);
  EXPECT_NEAR(placed.lab.position(placed.ball).x(), -50 + double{kMovingBullet} / 60.0, 1e-3);
  Stopped pushed;
  const double start = pushed.lab.position(pushed.ball).x();
  pushed.lab.world.set_linear_velocity(pushed.ball, {-60, 0, 0});
  pushed.lab.run(1);
  EXPECT_NEAR(pushed.lab.position(pushed.ball).x(), start - 1.0, 1e-3);
}

TEST(SweptMoving, ABodyThatTurnsOffSweepsOrChangesItsTypeLosesItsLag) {
  for (const bool by_settings : {true, false}) {
    Stopped stopped;
    WorldSettings settings = stopped.lab.world.settings();
    const double start = stopped.lab.position(stopped.ball).x();
    if (by_settings) {
      settings.continuous = false;
      stopped.lab.world.set_settings(settings);
      settings.continuous = true;
      stopped.lab.world.set_settings(settings);
    } else {
      stopped.lab.world.set_body_type(stopped.ball, BodyType::kinematic);
      stopped.lab.world.set_body_type(stopped.ball, BodyType::dynamic);
    }
    stopped.lab.run(1);
    EXPECT_NEAR(stopped.lab.position(stopped.ball).x(), start - double{kMovingBullet} / 60.0, 1e-2)
        << by_settings;
  }
}

TEST(SweptMoving, WhatIsMadeUpForKeepsLockedAxes) {
  for (const float tilt : {0.2f, 0.5f, -0.7f}) {
    Lab lab(for_bullets());
    lab.add({.type = BodyType::fixed,
             .position = {8, 0, 0},
             .rotation = {0, std::sin(0.5f * tilt), 0, std::cos(0.5f * tilt)}},
            Box{{0.5f, 50, 50}}, kElastic);
    BodyDef def{.linear_velocity = {kMovingBullet, 0, 0}};
    def.locks = AxisLocks::translation_z;
    const BodyId ball = lab.add(def, Sphere{0.1f}, kElastic);
    for (int i = 0; i < 4; ++i) {
      lab.run(1);
      ASSERT_EQ(lab.position(ball).z(), 0.0) << tilt << ", step " << i;
    }
    EXPECT_LT(lab.velocity(ball).x(), 0.0);
  }
}

TEST(SweptMoving, ABallOnASlidingPlatformGainsNoEnergy) {
  Lab lab;
  lab.add({.type = BodyType::kinematic, .position = {0, -1, 0}, .linear_velocity = {1, 0, 0}},
          Box{{900, 1, 50}}, kElastic);
  const BodyId ball = lab.add({.position = {0, 3.3f, 0}}, Sphere{0.05f}, kElastic);
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    lab.run(1);
    most = std::max(most, lab.height(ball));
  }
  EXPECT_LT(most, 3.3 * 1.01);
}

TEST(SweptMoving, NoPaddleDrivesABallThroughAWall) {
  for (const float restitution : {0.0f, 1.0f}) {
    Lab lab(for_bullets());
    const Material material{.friction = 0, .restitution = restitution};
    lab.add({.type = BodyType::fixed, .position = {0.5f, 0, 0}}, Box{{0.01f, 5, 5}}, material);
    lab.add({.type = BodyType::kinematic, .position = {-0.4f, 0, 0}, .linear_velocity = {60, 0, 0}},
            Box{{0.05f, 1, 1}}, material);
    const BodyId ball = lab.add({.linear_velocity = {0, 0.1f, 0}}, Sphere{0.05f}, material);
    lab.run(1);
    EXPECT_LT(lab.position(ball).x(), 0.5) << restitution;
  }
}

TEST(SweptMoving, BulletsDoNotPassAKinematicMesh) {
  for (const float speed : {0.0f, 3.0f}) {
    Lab lab(for_bullets());
    const std::vector<Vec3> points{{0, -5, -5}, {0, 5, -5}, {0, 5, 5}, {0, -5, 5}};
    const std::vector<MeshTriangle> triangles{{0, 2, 1}, {0, 3, 2}};  // its front looks against the bullet
    lab.add({.type = BodyType::kinematic, .position = {8, 0, 0}, .linear_velocity = {0, 0, speed}},
            TriangleMesh(points, triangles), kElastic);
    const BodyId bullet = lab.add({.linear_velocity = {kMovingBullet, 0, 0}}, Sphere{0.05f}, kElastic);
    lab.run(3);
    EXPECT_LT(lab.position(bullet).x(), 8.0) << speed;
    EXPECT_LT(lab.velocity(bullet).x(), 0.0) << speed;
  }
}

// What rounds in the direction of the flight is not made up for across it.
TEST(SweptMoving, AFastFlightFallsAsASlowOneDoes) {
  Lab fast, slow;
  const BodyId a = fast.add({.position = {-9000, 0, 0}, .linear_velocity = {300, 0, 0}}, Sphere{0.1f});
  const BodyId b = slow.add({}, Sphere{0.1f});
  for (int i = 0; i < 120; ++i) {
    fast.world.add_force(a, {static_cast<float>(0.1 * fast.mass(a)), 0, 0});
    fast.run(1);
    slow.run(1);
  }
  EXPECT_NEAR(fast.position(a).y(), slow.position(b).y(), 2e-3);
}

TEST(SweptMoving, DoTheSameForEveryInstructionSetAndThreadCount) {
  std::uint64_t first = 0;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      World world(for_bullets());
      Workers workers({.threads = threads, .isa = isa});
      Random random(8);
      for (int i = 0; i < 300; ++i) {
        const BodyId body = world.create_body({.position = random.vector(3),
                                               .rotation = random.rotation(),
                                               .linear_velocity = random.vector(300),
                                               .angular_velocity = random.vector(100)});
        world.add_shape(body, kMovingBullets[i % 3], {.restitution = 0.5f});
      }
      std::int64_t hits = 0;
      for (int i = 0; i < 30; ++i) {
        step(world, 1.0f / 60.0f, workers);
        hits += world.stats().sweep_hits;
      }
      EXPECT_GT(hits, 0);
      if (first == 0) first = world.hash();
      EXPECT_EQ(world.hash(), first);
    }
  }
}

}  // namespace
}  // namespace scree::physics
