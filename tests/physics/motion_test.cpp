// Axis locks and kinematic bodies.
#include <tests/physics/lab.h>

namespace scree::physics {
namespace {

constexpr AxisLocks kPlanar = AxisLocks::translation_z | AxisLocks::rotation_x | AxisLocks::rotation_y;

TEST(Planar, BodiesStayInTheirPlaneExactly) {
  Lab lab;
  lab.add_ground();
  for (const float side : {-1.0f, 1.0f}) {
    lab.add({.type = BodyType::fixed, .position = {4.0f * side, 5, 0}}, Box{{1, 5, 5}});
  }
  Random random(11);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 60; ++i) {
    const BodyDef def{.position = {static_cast<float>(i % 6) - 2.5f, 1.0f + static_cast<float>(i / 6), 0.25f},
                      .rotation = rotation_about({0, 0, 1}, static_cast<double>(random.uniform(0, 6))),
                      .angular_velocity = {0, 0, random.uniform(-5, 5)},
                      .locks = kPlanar};
    // Off the plane's middle, so that contacts pull sideways.
    const ShapeOptions options{.local_pose = {{0, 0, i % 2 == 0 ? 0.1f : -0.07f}, {}}};
    const BodyId body = lab.world.create_body(def);
    if (i % 3 == 0) {
      lab.world.add_shape(body, Sphere{0.4f}, {}, options);
    } else {
      lab.world.add_shape(body, Box{{0.4f, random.uniform(0.2f, 0.4f), 0.3f}}, {}, options);
    }
    bodies.push_back(body);
  }
  std::vector<float> plane;
  for (const BodyId body : bodies) plane.push_back(lab.world.center_of_mass(body).z);
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Quat q = lab.world.pose(bodies[k]).rotation;
      ASSERT_EQ(lab.world.center_of_mass(bodies[k]).z, plane[k]) << "step " << i;
      ASSERT_TRUE(q.x == 0.0f && q.y == 0.0f) << "step " << i;
    }
  }
  for (const BodyId body : bodies) {
    EXPECT_GT(lab.height(body), 0.0);
    EXPECT_EQ(lab.world.linear_velocity(body).z, 0.0f);
    EXPECT_EQ(lab.world.angular_velocity(body).x, 0.0f);
    EXPECT_EQ(lab.world.angular_velocity(body).y, 0.0f);
  }
}

TEST(Locks, ABodyLockedInTranslationTurnsInPlace) {
  Lab lab;
  const AxisLocks fixed_center =
      AxisLocks::translation_x | AxisLocks::translation_y | AxisLocks::translation_z;
  const BodyId wheel =
      lab.add({.position = {1, 2, 3}, .angular_velocity = {0, 0, 4}, .locks = fixed_center}, Box{});
  lab.run(120);
  EXPECT_EQ(lab.world.center_of_mass(wheel), (Vec3{1, 2, 3}));
  EXPECT_NEAR(lab.spin(wheel).z(), 4.0, 1e-3);
}

TEST(Locks, ABodyLockedInRotationDoesNotTip) {
  Lab lab;
  lab.add_ground();
  const AxisLocks upright = AxisLocks::rotation_x | AxisLocks::rotation_y | AxisLocks::rotation_z;
  const BodyId post = lab.add({.position = {0, 1, 0}, .linear_velocity = {3, 0, 1}, .locks = upright},
                              Box{{0.1f, 1.0f, 0.1f}}, {.friction = 1.0f});
  lab.run(240);
  EXPECT_EQ(lab.world.pose(post).rotation, Quat{});
  EXPECT_LT(lab.velocity(post).norm(), 1e-3);
  EXPECT_NEAR(lab.height(post), 1.0, 0.02);
}

TEST(Locks, DoNotHoldKinematicBodies) {
  Lab lab;
  const BodyId body = lab.add({.type = BodyType::kinematic,
                               .linear_velocity = {1, 0, 0},
                               .angular_velocity = {0, 0.5f, 0},
                               .locks = AxisLocks::translation_x | AxisLocks::rotation_y},
                              Box{});
  lab.run(60);
  EXPECT_NEAR(lab.position(body).x(), 1.0, 1e-4);
  EXPECT_NEAR(lab.velocity(body).x(), 1.0, 1e-6);
  EXPECT_NEAR(static_cast<double>(lab.world.pose(body).rotation.y), std::sin(0.25), 1e-4);
  lab.world.set_body_type(body, BodyType::dynamic);
  lab.run(60);
  EXPECT_NEAR(lab.position(body).x(), 1.0, 1e-4);
  EXPECT_EQ(lab.spin(body).y(), 0.0);
}

TEST(Kinematic, APlatformCarriesABox) {
  Lab lab;
  const BodyId platform =
      lab.add({.type = BodyType::kinematic, .linear_velocity = {2, 0, 0.5f}}, Box{{3, 0.2f, 3}});
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{{0.3f, 0.3f, 0.3f}});
  lab.run(60);
  const Eigen::Vector3d apart = lab.position(box) - lab.position(platform);
  lab.run(240);
  EXPECT_LT((lab.velocity(box) - Eigen::Vector3d(2, 0, 0.5)).norm(), 0.02);
  EXPECT_LT((lab.position(box) - lab.position(platform) - apart).norm(), 0.01);
  EXPECT_NEAR(lab.position(platform).x(), 2.0 * 300 / 60.0, 0.01);
}

TEST(Kinematic, ALiftCarriesAStack) {
  Lab lab;
  const BodyId lift =
      lab.add({.type = BodyType::kinematic, .linear_velocity = {0, 1.5f, 0}}, Box{{3, 0.2f, 3}});
  std::vector<BodyId> boxes;
  for (int i = 0; i < 4; ++i) {
    boxes.push_back(
        lab.add({.position = {0, 0.5f + 0.6f * static_cast<float>(i), 0}}, Box{{0.3f, 0.3f, 0.3f}}));
  }
  lab.run(240);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_NEAR(lab.height(boxes[i]) - lab.height(lift), 0.5 + 0.6 * static_cast<double>(i), 0.03);
    EXPECT_NEAR(lab.velocity(boxes[i]).y(), 1.5, 0.02);
  }
}

TEST(Kinematic, ATurntableCarriesABoxAround) {
  Lab lab;
  const BodyId table = lab.add({.type = BodyType::kinematic, .angular_velocity = {0, 1, 0}},
                               Box{{3, 0.2f, 3}}, {.friction = 1.0f});
  const BodyId box =
      lab.add({.position = {1, 0.5f, 0}, .linear_velocity = {0, 0, -1}, .angular_velocity = {0, 1, 0}},
              Box{{0.3f, 0.3f, 0.3f}}, {.friction = 1.0f});
  lab.run(377);
  const Eigen::Vector3d at = lab.position(box);
  // Contact points stay at their positions of the step's beginning, so the body drifts outward by w dt / 2 of
  // its path, 5 % a turn.
  EXPECT_NEAR(std::hypot(at.x(), at.z()), 1.0, 0.08);
  EXPECT_NEAR(std::hypot(lab.velocity(box).x(), lab.velocity(box).z()), 1.0, 0.08);
  EXPECT_NEAR(lab.spin(box).y(), 1.0, 0.02);
  EXPECT_NEAR(lab.spin(table).y(), 1.0, 0.0);
}

}  // namespace
}  // namespace scree::physics
