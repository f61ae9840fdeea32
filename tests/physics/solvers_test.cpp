// Laws that every solver of WorldSettings::solver keeps, and those of each.
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

namespace scree::physics {
namespace {

constexpr int kEnough = 60;  // iterations for a handful of bodies

WorldSettings settings_of(Solver solver, int iterations = kEnough) {
  WorldSettings settings = without_sleep();
  settings.solver = solver;
  settings.solver_options.iterations = iterations;
  return settings;
}

class EverySolver : public ::testing::TestWithParam<Solver> {};

TEST_P(EverySolver, AStackOfBoxesStands) {
  Lab lab(settings_of(GetParam()));
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 4; ++i)
    boxes.push_back(lab.add({.position = {0, 0.5f + static_cast<float>(i), 0}}, Box{{0.5f, 0.5f, 0.5f}}));
  lab.run(300);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d at = lab.position(boxes[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(at.y(), 0.5 + i, 0.03) << "box " << i;
    EXPECT_LT(std::hypot(at.x(), at.z()), 0.01) << "box " << i;
  }
}

TEST_P(EverySolver, ABoxThatSlidesIsSlowedByFrictionTimesGravity) {
  Lab lab(settings_of(GetParam()));
  lab.add_ground({.friction = 0.3f});
  const BodyId box = lab.add({.position = {0, 0.2f, 0}, .linear_velocity = {3, 0, 4}},
                             Box{{0.5f, 0.2f, 0.5f}}, {.friction = 0.3f});
  lab.run(60);
  EXPECT_NEAR(lab.velocity(box).norm(), 5 - 0.3 * kGravity, 0.05);
  EXPECT_NEAR(lab.velocity(box).x() / lab.velocity(box).z(), 0.75, 0.01);
}

TEST_P(EverySolver, APendulumSwingsAtItsPeriod) {
  Lab lab(settings_of(GetParam()));
  // A ball of radius r on a rod of length l: T = 2 pi sqrt((l^2 + 2/5 r^2) / (g l)) for small angles.
  constexpr double kLength = 1, kRadius = 0.2;
  const double angle = 0.1;
  const BodyId ball = lab.add({.position = {static_cast<float>(kLength * std::sin(angle)),
                                            static_cast<float>(-kLength * std::cos(angle)), 0},
                               .rotation = rotation_about({0, 0, 1}, angle)},
                              Sphere{static_cast<float>(kRadius)});
  lab.world.create_joint(
      {.body_a = kWorld, .body_b = ball, .frame_b = {{0, static_cast<float>(kLength), 0}, {}}}, BallJoint{});
  const double period =
      2 * std::numbers::pi * std::sqrt((kLength * kLength + 0.4 * kRadius * kRadius) / (kGravity * kLength));
  std::vector<double> crossings;
  double before = lab.position(ball).x();
  for (int i = 1; i <= 600; ++i) {
    lab.run(1);
    const double now = lab.position(ball).x();
    if (before > 0 && now <= 0) crossings.push_back(i - now / (now - before));
    before = now;
  }
  ASSERT_GE(crossings.size(), 3u);
  const double measured =
      (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1) / 60;
  EXPECT_NEAR(measured, period, 0.01 * period);
  EXPECT_NEAR(lab.position(ball).norm(), kLength, 0.01);
}

TEST_P(EverySolver, ContactForcesAndReactionsCarryTheWeight) {
  WorldSettings settings = settings_of(GetParam());
  settings.contact_forces = true;
  Lab lab(settings);
  lab.add_ground();
  const BodyId lying = lab.add({.position = {0, 0.3f, 0}}, Box{{0.5f, 0.3f, 0.4f}});
  const BodyId hanging = lab.add({.position = {5, 5, 0}}, Box{{0.5f, 0.3f, 0.4f}});
  const JointId joint = lab.world.create_joint(
      {.body_a = kWorld, .body_b = hanging, .frame_a = {{5, 5.3f, 0}, {}}, .frame_b = {{0, 0.3f, 0}, {}}},
      WeldJoint{});
  lab.run(180);
  const double weight = lab.mass(lying) * kGravity;
  ContactForces contact;
  ASSERT_EQ(lab.world.contact_forces_of(lying, {&contact, 1}), 1u);
  const double force = static_cast<double>(normal_impulse(contact)) * 60;
  EXPECT_NEAR(force, weight, 0.01 * weight);
  EXPECT_NEAR(to_eigen(lab.world.joint_reaction(joint).force).y(), weight, 0.01 * weight);
}

TEST_P(EverySolver, AJointBreaksUnderMoreThanItsStrength) {
  for (const double share : {0.5, 2.0}) {
    Lab lab(settings_of(GetParam()));
    const BodyId box = lab.add({.position = {0, 0, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    const auto strength = static_cast<float>(share * lab.mass(box) * kGravity);
    const JointId joint = lab.world.create_joint({.body_a = kWorld,
                                                  .body_b = box,
                                                  .frame_a = {{0, 0.5f, 0}, {}},
                                                  .frame_b = {{0, 0.5f, 0}, {}},
                                                  .break_force = strength},
                                                 BallJoint{});
    lab.run(60);
    EXPECT_EQ(lab.world.is_enabled(joint), share > 1) << share << " times the weight";
  }
}

TEST_P(EverySolver, ABallReboundsWithItsRestitution) {
  Lab lab(settings_of(GetParam()));
  lab.add_ground();
  const BodyId ball = lab.add({.position = {0, 5.5f, 0}}, Sphere{0.5f}, {.restitution = 0.5f});
  double top = 0;
  bool has_bounced = false;
  for (int i = 0; i < 180; ++i) {
    lab.run(1);
    has_bounced = has_bounced || lab.velocity(ball).y() > 0;
    if (has_bounced) top = std::max(top, lab.height(ball) - 0.5);
  }
  EXPECT_NEAR(top, 0.25 * 5, 0.1 * 0.25 * 5);
}

// A box that hangs on a joint, pushed so that squares of its speed are beyond floats.
TEST_P(EverySolver, ABodyThatBecomesNonFiniteHarmsNoOther) {
  for (const float mass : {1e-4f, 1e-8f}) {
    Lab lab(settings_of(GetParam()));
    lab.add_ground();
    const BodyId lower = lab.add({.position = {0, 0.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    const BodyId upper = lab.add({.position = {0, 1.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    const BodyId wild = lab.add({.position = {20, 0.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    lab.world.create_joint({.body_a = kWorld, .body_b = wild, .frame_a = {{20, 0.5f, 0}, {}}}, BallJoint{});
    for (int i = 0; i < 60; ++i) {
      // The force is allowed for a mass that is not.
      if (!lab.world.is_quarantined(wild)) {
        lab.world.set_mass_properties(wild, {.mass = 1e16f, .inertia = {1e16f, 1e16f, 1e16f}});
        lab.world.add_force(wild, {1e30f, 0, 0});
        lab.world.set_mass_properties(wild, {.mass = mass, .inertia = {mass, mass, mass}});
      }
      lab.run(1);
    }
    EXPECT_TRUE(lab.all_finite()) << mass << " kg";
    EXPECT_TRUE(lab.world.is_quarantined(wild)) << mass << " kg";
    EXPECT_NEAR(lab.height(lower), 0.5, 0.02) << mass << " kg";
    EXPECT_NEAR(lab.height(upper), 1.5, 0.03) << mass << " kg";
  }
}

TEST_P(EverySolver, GoesOnFromASnapshotWithTheSameBits) {
  WorldSettings settings = settings_of(GetParam(), 15);
  settings.solver_options.tolerance = 1e-5f;
  Lab lab(settings);
  lab.add_ground();
  BodyId last = kWorld;
  for (int i = 0; i < 4; ++i) {
    const BodyId body = lab.add({.position = {static_cast<float>(i), 0.6f + 0.3f * static_cast<float>(i), 0}},
                                Box{{0.4f, 0.2f, 0.3f}}, {.rolling_resistance = 0.01f});
    if (i > 0) {
      lab.world.create_joint({.body_a = last,
                              .body_b = body,
                              .frame_a = {{0.5f, 0.15f, 0}, {}},
                              .frame_b = {{-0.5f, -0.15f, 0}, {}}},
                             HingeJoint{});
    }
    last = body;
  }
  lab.run(40);
  Snapshot snapshot;
  save(lab.world, snapshot);
  lab.run(20);
  const std::uint64_t expected = lab.world.hash();
  restore(lab.world, snapshot);
  lab.run(20);
  EXPECT_EQ(lab.world.hash(), expected);
}

std::vector<Solver> all_solvers() {
  std::vector<Solver> solvers;
  for (int i = 0; i < kSolverCount; ++i) solvers.push_back(static_cast<Solver>(i));
  return solvers;
}
std::string name_of_solver(const ::testing::TestParamInfo<Solver>& solver) {
  return solver_name(solver.param);
}
INSTANTIATE_TEST_SUITE_P(Solvers, EverySolver, ::testing::ValuesIn(all_solvers()), name_of_solver);

// A chain of links of 0.5 m that hangs straight down; returns by which share it is longer than at rest.
double stretch_of_chain(const WorldSettings& settings, int links, float weight) {
  Lab lab(settings);
  constexpr float kPitch = 0.5f;
  BodyId last = kWorld;
  for (int i = 0; i < links; ++i) {
    const BodyId link =
        lab.add({.position = {0, -kPitch * (0.5f + static_cast<float>(i)), 0}}, Capsule{0.15f, 0.05f});
    lab.world.create_joint({.body_a = last,
                            .body_b = link,
                            .frame_a = {{0, i > 0 ? -0.5f * kPitch : 0.0f, 0}, {}},
                            .frame_b = {{0, 0.5f * kPitch, 0}, {}}},
                           BallJoint{});
    last = link;
  }
  if (weight > 0) {
    const BodyId ball = lab.add({.position = {0, -kPitch * static_cast<float>(links) - 0.5f, 0},
                                 .mass = weight * static_cast<float>(lab.mass(last))},
                                Sphere{0.4f});
    lab.world.create_joint({.body_a = last,
                            .body_b = ball,
                            .frame_a = {{0, -0.5f * kPitch, 0}, {}},
                            .frame_b = {{0, 0.5f, 0}, {}}},
                           BallJoint{});
  }
  lab.run(300);
  const double end = lab.height(last) - 0.5 * static_cast<double>(kPitch);
  EXPECT_TRUE(lab.all_finite());
  return -end / (static_cast<double>(kPitch) * links) - 1;
}

TEST(DirectSolver, AChainOf100LinksStretchesByLessThanAThousandth) {
  EXPECT_NEAR(stretch_of_chain(settings_of(Solver::direct), 100, 0), 0, 1e-3);
}

TEST(DirectSolver, AChainUnder1000TimesTheWeightOfALinkStretchesByLessThanAThousandth) {
  EXPECT_NEAR(stretch_of_chain(settings_of(Solver::direct), 10, 1000), 0, 1e-3);
}

TEST(DirectSolver, AHeavyBoxStandsOnBoxesOfAThousandthOfItsMass) {
  Lab lab(settings_of(Solver::direct));
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 6; ++i) {
    boxes.push_back(lab.add({.position = {0, 0.5f + static_cast<float>(i), 0}}, Box{{0.5f, 0.5f, 0.5f}},
                            {.density = i == 5 ? 1e6f : 1e3f}));
  }
  lab.run(600);
  EXPECT_NEAR(lab.height(boxes.back()), 5.5, 5e-3);
  EXPECT_LT(std::hypot(lab.position(boxes.back()).x(), lab.position(boxes.back()).z()), 5e-3);
}

TEST(DirectSolver, LeavesNoResidual) {
  WorldSettings settings = settings_of(Solver::direct);
  settings.solver_options.tolerance = 1e-9f;
  Lab lab(settings);
  lab.add_ground();
  for (int i = 0; i < 6; ++i)
    lab.add({.position = {0.2f * static_cast<float>(i), 0.6f + 0.9f * static_cast<float>(i), 0}},
            Box{{0.5f, 0.4f, 0.5f}});
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    EXPECT_LT(lab.world.stats().residual, 1e-5) << "step " << i;
    EXPECT_FALSE(lab.world.stats().solver_singular) << "step " << i;
  }
}

TEST(DirectSolver, RowsThatSayTheSameTwiceShareTheLoad) {
  Lab lab(settings_of(Solver::direct));
  const BodyId box = lab.add({.position = {0, 0, 0}}, Box{{0.5f, 0.5f, 0.5f}});
  const JointDef def{.body_a = kWorld, .body_b = box};
  const JointId first = lab.world.create_joint(def, WeldJoint{}),
                second = lab.world.create_joint(def, WeldJoint{});
  lab.run(120);
  const double weight = lab.mass(box) * kGravity;
  EXPECT_NEAR(to_eigen(lab.world.joint_reaction(first).force).y() +
                  to_eigen(lab.world.joint_reaction(second).force).y(),
              weight, 1e-3 * weight);
  EXPECT_LT(lab.position(box).norm(), 1e-4);
  EXPECT_FALSE(lab.world.stats().solver_singular);
}

TEST(DirectSolver, ReportsRowsThatContradictEachOther) {
  Lab lab(settings_of(Solver::direct));
  lab.add_ground({}, {}, 1.0f);
  const BodyId standing = lab.add({.position = {0, 0.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
  const BodyId box = lab.add({.position = {5, -1.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
  for (const float length : {1.0f, 2.0f}) {
    lab.world.create_joint({.body_a = kWorld, .body_b = box, .frame_a = {{5, 0, 0}, {}}},
                           DistanceJoint{.length = {.lower = length, .upper = length}});
  }
  lab.run(120);
  EXPECT_TRUE(lab.world.stats().solver_singular);
  EXPECT_GT(lab.world.stats().residual, 1e-3);
  EXPECT_TRUE(lab.all_finite());
  EXPECT_LT((lab.position(box) - Eigen::Vector3d(5, 0, 0)).norm(), 3);
  EXPECT_NEAR(lab.height(standing), 0.5, 0.01);
}

TEST(SequentialImpulse, BaumgarteTakesItsShareOfTheErrorAStep) {
  for (const float factor : {0.1f, 0.5f, 1.0f}) {
    WorldSettings settings = settings_of(Solver::sequential_impulse);
    settings.gravity = {};
    settings.solver_options.baumgarte = factor;
    settings.push_speed = 100;
    Lab lab(settings);
    const BodyId box = lab.add({.position = {0.1f, 0, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    lab.world.create_joint({.body_a = kWorld, .body_b = box}, BallJoint{});
    lab.run(1);
    EXPECT_NEAR(lab.position(box).x(), 0.1 * (1 - static_cast<double>(factor)), 1e-5) << "factor " << factor;
  }
}

TEST(SequentialImpulse, LeavesTheSlopAlone) {
  for (const float slop : {0.0f, 0.01f, 0.05f}) {
    WorldSettings settings = settings_of(Solver::sequential_impulse);
    settings.solver_options.slop = slop;
    Lab lab(settings);
    lab.add_ground();
    const BodyId box = lab.add({.position = {0, 0.4f, 0}}, Box{{0.5f, 0.5f, 0.5f}});
    lab.run(300);
    EXPECT_NEAR(lab.height(box), 0.5 - static_cast<double>(slop), 1e-3) << "slop " << slop;
  }
}

TEST(SequentialImpulse, MoreIterationsLeaveLess) {
  double before = 1e9;
  for (const int iterations : {5, 50, 500, 5000}) {
    WorldSettings settings = settings_of(Solver::sequential_impulse, iterations);
    settings.warm_start = false;
    settings.measure_residual = true;
    Lab lab(settings);
    lab.add_ground();
    for (int i = 0; i < 6; ++i)
      lab.add({.position = {0, 0.5f + static_cast<float>(i), 0}}, Box{{0.5f, 0.5f, 0.5f}});
    lab.run(2);
    EXPECT_LT(lab.world.stats().residual, 0.5 * before) << iterations << " iterations";
    before = lab.world.stats().residual;
  }
  EXPECT_LT(before, 1e-5);
}

TEST(SequentialImpulse, AShuffleIsMadeOfItsSeedAlone) {
  const auto hash = [](std::uint32_t seed) {
    WorldSettings settings = settings_of(Solver::sequential_impulse, 8);
    settings.solver_options.shuffle_seed = seed;
    Lab lab(settings);
    lab.add_ground();
    for (int i = 0; i < 12; ++i)
      lab.add({.position = {0.3f * static_cast<float>(i % 3), 0.6f + 0.5f * static_cast<float>(i), 0}},
              Box{{0.5f, 0.2f, 0.5f}});
    lab.run(60);
    return lab.world.hash();
  };
  EXPECT_EQ(hash(0), hash(0));
  EXPECT_EQ(hash(7), hash(7));
  EXPECT_NE(hash(7), hash(0));
  EXPECT_NE(hash(7), hash(8));
}

// A plate that lands askew: the speed that one pass leaves at its corners.
double speed_left_by_one_pass(Solver solver, bool together) {
  WorldSettings settings = settings_of(solver, 1);
  settings.gravity = {};
  settings.substeps = 1;
  settings.warm_start = false;
  settings.solver_options.points_together = together;
  Lab lab(settings);
  lab.add_ground({.friction = 0});
  const BodyId plate =
      lab.add({.position = {0, 0.05f, 0}, .linear_velocity = {0, -2, 0}, .angular_velocity = {0.7f, 0, 0.4f}},
              Box{{1.0f, 0.05f, 0.6f}}, {.friction = 0});
  lab.run(1);
  double left = 0;
  for (const float x : {-1.0f, 1.0f}) {
    for (const float z : {-0.6f, 0.6f})
      left = std::max(left, -static_cast<double>(lab.world.velocity_at(plate, {x, 0, z}).y));
  }
  return left;
}

TEST(PointsTogether, OnePassBringsAllPointsOfAContactToRest) {
  for (const Solver solver : {Solver::soft_step, Solver::sequential_impulse}) {
    EXPECT_LT(speed_left_by_one_pass(solver, true), 2e-3) << solver_name(solver);
    EXPECT_GT(speed_left_by_one_pass(solver, false), 2e-2) << solver_name(solver);
  }
}

}  // namespace
}  // namespace scree::physics
