// Laws of kinematic targets: one step moves the body to its target.
#include <tests/physics/lab.h>

#include <limits>
#include <numbers>

namespace scree::physics {
namespace {

// rad between two rotations.
double angle_between(Quat a, Quat b) { return to_eigen(a).angularDistance(to_eigen(b)); }

TEST(KinematicTarget, IsReachedInOneStep) {
  Random random(4);
  for (const int substeps : {1, 2, 3, 4, 7, 64}) {
    WorldSettings settings = without_sleep();
    settings.substeps = substeps;
    Lab lab(settings);
    const BodyId body = lab.add({.type = BodyType::kinematic}, Box{});
    for (int i = 0; i < 20; ++i) {
      const Quat turn = rotation_about(random.vector(1), static_cast<double>(random.uniform(-3.0f, 3.0f)));
      const Pose from = lab.world.pose(body);
      const Eigen::Quaterniond there = to_eigen(turn) * to_eigen(from.rotation);
      const Pose target{random.vector(10),
                        {static_cast<float>(there.x()), static_cast<float>(there.y()),
                         static_cast<float>(there.z()), static_cast<float>(there.w())}};
      const float dt = i % 2 == 0 ? kStep : 0.01f;
      lab.world.set_kinematic_target(body, target, dt);
      lab.run(1, dt);
      const double way = (to_eigen(target.position) - to_eigen(from.position)).norm();
      EXPECT_LT((to_eigen(lab.world.pose(body).position) - to_eigen(target.position)).norm(),
                1e-6 * way + 1e-6);
      EXPECT_LT(angle_between(lab.world.pose(body).rotation, target.rotation), 3e-6) << substeps;
    }
  }
}

TEST(KinematicTarget, OfABodyWithItsCenterElsewhereIsThatOfItsOrigin) {
  Lab lab;
  const BodyId body = lab.add({.type = BodyType::kinematic, .position = {1, 2, 3}}, Box{});
  lab.world.set_mass_properties(body, {.center = {2, 0, 0}});
  const Pose target{{1, 2, 4}, rotation_about({0, 1, 0}, 2.0)};
  lab.world.set_kinematic_target(body, target, kStep);
  lab.run(1);
  EXPECT_LT((to_eigen(lab.world.pose(body).position) - to_eigen(target.position)).norm(), 3e-6);
  EXPECT_LT(angle_between(lab.world.pose(body).rotation, target.rotation), 1e-6);
}

TEST(KinematicTarget, HalfATurnNeedsTwoSubsteps) {
  for (const int substeps : {1, 2, 4}) {
    WorldSettings settings = without_sleep();
    settings.substeps = substeps;
    Lab lab(settings);
    const BodyId body = lab.add({.type = BodyType::kinematic}, Box{});
    const Pose target{{}, {0, 1, 0, 0}};
    if (substeps == 1) {
      EXPECT_THROW(lab.world.set_kinematic_target(body, target, kStep), Error);
      EXPECT_EQ(lab.spin(body).norm(), 0.0);
      continue;
    }
    lab.world.set_kinematic_target(body, target, kStep);
    lab.run(1);
    EXPECT_LT(angle_between(lab.world.pose(body).rotation, target.rotation), 3e-6);
  }
}

TEST(KinematicTarget, CarriesAndPushesTheBodiesItTouches) {
  Lab lab;
  lab.add_ground();
  const BodyId lift = lab.add({.type = BodyType::kinematic, .position = {0, 0.5f, 0}}, Box{{2, 0.5f, 2}});
  const BodyId crate = lab.add({.position = {0, 1.5f, 0}}, Box{});
  for (int i = 1; i <= 120; ++i) {
    const float height = 0.5f + 0.01f * static_cast<float>(i);
    lab.world.set_kinematic_target(lift, {{0.5f * (height - 0.5f), height, 0}, {}}, kStep);
    lab.run(1);
  }
  EXPECT_NEAR(lab.height(lift), 1.7, 1e-5);
  EXPECT_NEAR(lab.height(crate), 2.7, 0.02);
  EXPECT_NEAR(lab.position(crate).x(), 0.6, 0.05);
}

TEST(KinematicTarget, OfABodyAlreadyThereWakesNoBody) {
  Lab lab{WorldSettings{}};
  const BodyId table = lab.add({.type = BodyType::kinematic}, Box{{5, 0.5f, 5}});
  const BodyId crate = lab.add({.position = {0, 1, 0}}, Box{});
  lab.run(120);
  ASSERT_FALSE(lab.world.is_awake(crate));
  lab.world.set_kinematic_target(table, lab.world.pose(table), kStep);
  EXPECT_FALSE(lab.world.is_awake(crate));
  lab.run(1);
  EXPECT_FALSE(lab.world.is_awake(crate));
  lab.world.set_kinematic_target(table, {{0.1f, 0, 0}, {}}, kStep);
  EXPECT_TRUE(lab.world.is_awake(crate));
}

TEST(KinematicTarget, ThatIsImpossibleIsAnErrorThatChangesNothing) {
  Lab lab;
  const BodyId body = lab.add({.type = BodyType::kinematic, .linear_velocity = {1, 0, 0}}, Box{});
  const BodyId crate = lab.add({.position = {5, 0, 0}}, Box{});
  const BodyId rock = lab.add({.type = BodyType::fixed, .position = {9, 0, 0}}, Box{});
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const std::uint64_t hash = lab.world.hash();
  const auto refuses = [&](BodyId who, const Pose& target, float dt) {
    EXPECT_THROW(lab.world.set_kinematic_target(who, target, dt), Error);
    EXPECT_EQ(lab.world.hash(), hash);
  };
  refuses(crate, {}, kStep);
  refuses(rock, {}, kStep);
  refuses(BodyId{}, {}, kStep);
  refuses(body, {{nan, 0, 0}, {}}, kStep);
  refuses(body, {{0, infinity, 0}, {}}, kStep);
  refuses(body, {{0, 2e7f, 0}, {}}, kStep);
  refuses(body, {{}, {0, 0, 0, 0}}, kStep);
  refuses(body, {{}, {0, nan, 0, 1}}, kStep);
  for (const float dt : {0.0f, -kStep, nan, infinity, 1.5f}) refuses(body, {}, dt);
  refuses(body, {{1e6f, 0, 0}, {}}, 1e-4f);
  refuses(body, {{1, 0, 0}, {}}, 1e-40f);
}

}  // namespace
}  // namespace scree::physics
