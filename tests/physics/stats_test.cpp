// Laws of the statistics of a step: each figure has its documented meaning.
#include <core/world/world_data.h>
#include <tests/physics/lab.h>

#include <limits>

namespace scree::physics {
namespace {

WorldSettings measured_settings() {
  WorldSettings settings = without_sleep();
  settings.measure_penetration = true;
  return settings;
}

TEST(Stats, ThePercentileOfFewPenetrationsIsTheLargest) {
  Lab lab(measured_settings());
  lab.add_ground();
  for (int i = 0; i < 5; ++i) {  // the heavier lie deeper
    lab.add(
        {.position = {3.0f * static_cast<float>(i), 0.5f, 0}, .gravity_factor = 1.0f + static_cast<float>(i)},
        Sphere{0.5f});
  }
  lab.run(60);
  const StepStats& stats = lab.world.stats();
  EXPECT_EQ(stats.overlaps, 5);
  EXPECT_GT(stats.penetration_mean, 0.0);
  EXPECT_GT(stats.penetration_max, stats.penetration_mean);
  EXPECT_EQ(stats.penetration_p999, stats.penetration_max);
}

TEST(Stats, ContactsThatDoNotOverlapAreLeftOutOfThePenetration) {
  WorldSettings settings = measured_settings();
  settings.gravity = {};
  Lab lab(settings);
  lab.add_ground();
  lab.add({.position = {0, 0.499f, 0}}, Sphere{0.5f});
  lab.add({.position = {3, 0.5005f, 0}}, Sphere{0.5f});
  lab.run(1);
  const StepStats& stats = lab.world.stats();
  EXPECT_EQ(stats.contacts, 2);
  EXPECT_EQ(stats.overlaps, 1);
  EXPECT_EQ(stats.penetration_mean, stats.penetration_max);
}

TEST(Stats, PointsAreThoseOfSolvedContacts) {
  Lab lab{WorldSettings{}};
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  const BodyId ball = lab.add({.position = {5, 0.5f, 0}, .can_sleep = false}, Sphere{0.5f});
  lab.run(1);
  EXPECT_EQ(lab.world.stats().contacts, 2);
  EXPECT_EQ(lab.world.stats().contact_points, 5);
  lab.run(240);
  ASSERT_FALSE(lab.world.is_awake(box));
  ASSERT_TRUE(lab.world.is_awake(ball));
  EXPECT_EQ(lab.world.stats().contacts, 2);
  EXPECT_EQ(lab.world.stats().contact_points, 1);
  lab.run(1, 0.0f);
  EXPECT_EQ(lab.world.stats().contacts, 2);
  EXPECT_EQ(lab.world.stats().contact_points, 0);
}

TEST(Stats, TheKineticEnergyIsThatOfAllDynamicBodies) {
  Lab lab(without_gravity());
  // More than a chunk of bodies, and the last chunk has bodies of both types.
  double expected = 0.0;
  for (int i = 0; i < 1300; ++i) {
    const BodyType type = i % 3 == 2 ? BodyType::kinematic : BodyType::dynamic;
    const float speed = 0.001f * static_cast<float>(i);
    const BodyId body = lab.add(
        {.type = type, .position = {3.0f * static_cast<float>(i), 0, 0}, .linear_velocity = {0, speed, 0}},
        Sphere{0.5f});
    if (type == BodyType::dynamic) expected += 0.5 * lab.mass(body) * double{speed} * double{speed};
  }
  lab.run(1);
  EXPECT_NEAR(lab.world.stats().kinetic_energy, expected, 1e-6 * expected);
}

TEST(Stats, AStepOfNoLengthSolvesNothing) {
  WorldSettings settings = measured_settings();
  settings.measure_residual = true;
  Lab lab(settings);
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.45f, 0}}, Box{});
  const BodyId upper = lab.add({.position = {0, 1.6f, 0}}, Box{});
  lab.world.create_joint({.body_a = box, .body_b = upper, .frame_a = {{0, 1.15f, 0}, {}}}, BallJoint{});
  lab.run(2);
  const StepStats solved = lab.world.stats();
  ASSERT_GT(solved.colors, 0);
  ASSERT_EQ(solved.joints, 1);
  ASSERT_GT(solved.overlaps, 0);
  ASSERT_GT(solved.residual, 0.0);
  ASSERT_GT(solved.kinetic_energy, 0.0);
  lab.run(1, 0.0f);
  const StepStats& still = lab.world.stats();
  EXPECT_EQ(still.step, 3u);
  EXPECT_EQ(still.contacts, solved.contacts);
  EXPECT_EQ(still.awake_bodies, 2);
  EXPECT_EQ(still.kinetic_energy, solved.kinetic_energy);
  EXPECT_EQ(still.colors, 0);
  EXPECT_EQ(still.joints, 0);
  EXPECT_EQ(still.overlaps, 0);
  EXPECT_EQ(still.penetration_max, 0.0);
  EXPECT_EQ(still.residual, 0.0);
}

TEST(Stats, FiguresAreEmptyOnceTheyAreNoLongerRequested) {
  WorldSettings settings = measured_settings();
  settings.measure_residual = true;
  Lab lab(settings);
  lab.add_ground();
  lab.add({.position = {0, 0.45f, 0}}, Box{});
  lab.run(1);
  ASSERT_GT(lab.world.stats().residual, 0.0);
  ASSERT_GT(lab.world.stats().penetration_max, 0.0);
  settings.measure_residual = settings.measure_penetration = false;
  lab.world.set_settings(settings);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().residual, 0.0);
  EXPECT_EQ(lab.world.stats().penetration_max, 0.0);
}

TEST(Stats, BodiesPutBackFromANonFiniteStateAreCounted) {
  Lab lab;
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 3; ++i)
    boxes.push_back(lab.add({.position = {5.0f * static_cast<float>(i), 3, 0}}, Box{}));
  lab.run(5);
  EXPECT_EQ(lab.world.stats().restored_bodies, 0);
  // No call accepts such a force; a step must stay sound all the same.
  const float infinity = std::numeric_limits<float>::infinity();
  for (const int lost : {0, 2}) {
    internals(lab.world).bodies.force[boxes[static_cast<std::size_t>(lost)].index].force[0] = infinity;
    internals(lab.world).bodies.force[boxes[static_cast<std::size_t>(lost)].index].force[1] = -infinity;
  }
  lab.run(1);
  EXPECT_EQ(lab.world.stats().restored_bodies, 2);
  EXPECT_TRUE(lab.all_finite());
  EXPECT_EQ(lab.velocity(boxes[0]).norm(), 0.0);
  EXPECT_LT(lab.velocity(boxes[1]).y(), 0.0);
  lab.run(1);
  EXPECT_EQ(lab.world.stats().restored_bodies, 0);
  lab.run(1, 0.0f);
  EXPECT_EQ(lab.world.stats().restored_bodies, 0);
}

}  // namespace
}  // namespace scree::physics
