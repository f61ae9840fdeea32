// Laws of the solvers that look at all of a system: each comes to the same velocities, which are the exact
// ones where these are known.
#include <core/solvers/reference_solvers.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace scree::test {
namespace {

constexpr float kNoBound = std::numeric_limits<float>::infinity();
constexpr double kStep = 1.0 / 240, kWeight = 9.81;

constexpr ReferenceMethod kAll[] = {ReferenceMethod::jacobi,
                                    ReferenceMethod::gauss_seidel,
                                    ReferenceMethod::over_relaxation,
                                    ReferenceMethod::conjugate_gradient,
                                    ReferenceMethod::accelerated_gradient,
                                    ReferenceMethod::direct};
constexpr ReferenceMethod kIterative[] = {
    ReferenceMethod::jacobi, ReferenceMethod::gauss_seidel, ReferenceMethod::over_relaxation,
    ReferenceMethod::conjugate_gradient, ReferenceMethod::accelerated_gradient};

struct Bodies {
  std::vector<SystemBody> bodies{{}};  // row 0 is the fixed world
  std::vector<StatedConstraint> constraints;
  SystemPolicy policy;

  Bodies() {
    policy.pass = SystemPolicy::Pass::relax;
    policy.substep = kStep;
  }

  // A ball that has fallen for a step.
  std::int32_t add_body(double kilograms, double inertia, std::array<float, 3> velocity = {}) {
    const float turn = static_cast<float>(1 / inertia);
    SystemBody body{{{turn, 0, 0, turn, 0, turn}, static_cast<float>(1 / kilograms), 0}, {}};
    for (std::size_t i = 0; i < 3; ++i) body.velocity.linear[i] = velocity[i];
    body.velocity.linear[1] -= static_cast<float>(kWeight * kStep);
    bodies.push_back(body);
    return static_cast<std::int32_t>(bodies.size()) - 1;
  }

  StatedConstraint& add(std::int32_t a, std::int32_t b) {
    constraints.push_back({ConstraintRows{}, a, b});
    return constraints.back();
  }

  // Contact points of b on a below it, at these arms, with friction of Coulomb under each.
  void add_contact(std::int32_t a, std::int32_t b, std::vector<std::array<float, 3>> arms, float half_height,
                   float friction) {
    for (const std::array<float, 3>& arm : arms) {
      StatedConstraint& constraint = add(a, b);
      const float axes[3][3] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
      const std::uint32_t kinds[3] = {kRowContact, kRowFriction, kRowFriction};
      for (std::size_t slot = 0; slot < 3; ++slot) {
        ConstraintRow& row = constraint.rows.row[slot];
        const float* n = axes[slot];
        const float at_a[3] = {arm[0], half_height, arm[2]}, at_b[3] = {arm[0], -half_height, arm[2]};
        put(row, n, a == 0 ? nullptr : at_a, at_b);
        row.kind = kinds[slot];
        row.block = slot == 0 ? 0 : 1;
        if (slot == 0) {
          row.upper = kNoBound;
        } else {
          row.flags = kRowBoundsLength;
          row.bound_by[0] = friction;
        }
      }
    }
  }

  // A point of b stays at a point of a.
  void add_ball(std::int32_t a, std::int32_t b, std::array<float, 3> at_a, std::array<float, 3> at_b) {
    StatedConstraint& constraint = add(a, b);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float n[3] = {};
      n[axis] = 1;
      put(constraint.rows.row[axis], n, at_a.data(), at_b.data());
      constraint.rows.row[axis].kind = kRowHeld;
    }
  }

  ConstraintSystem system() const { return assemble(bodies, constraints, policy); }

 private:
  static void put(ConstraintRow& row, const float* n, const float* at_a, const float* at_b) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      row.linear_a[i] = -n[i];
      row.linear_b[i] = n[i];
      row.angular_a[i] = at_a == nullptr ? 0 : -(at_a[j] * n[k] - at_a[k] * n[j]);
      row.angular_b[i] = at_b[j] * n[k] - at_b[k] * n[j];
    }
  }
};

std::vector<std::array<float, 3>> corners(float half) {
  return {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
}

// Boxes of 1 m on each other, the lowest on the ground.
Bodies stack(std::vector<double> kilograms, float friction = 0.6f) {
  Bodies world;
  std::int32_t below = 0;
  for (const double mass : kilograms) {
    const std::int32_t box = world.add_body(mass, mass / 6);
    world.add_contact(below, box, corners(0.5f), 0.5f, friction);
    below = box;
  }
  return world;
}

Bodies chain(int links, double last_kilograms) {
  Bodies world;
  std::int32_t above = 0;
  for (int i = 0; i < links; ++i) {
    const double mass = i + 1 < links ? 1 : last_kilograms;
    const std::int32_t link = world.add_body(mass, 0.01 * mass, {0.3f, 0, 0});
    world.add_ball(above, link, {0, above == 0 ? 0.0f : -0.1f, 0}, {0, 0.1f, 0});
    above = link;
  }
  return world;
}

// Balls, joints and contacts between random bodies.
Bodies random_world(unsigned seed) {
  std::mt19937 engine(seed);
  const auto within = [&engine](float size) {
    return std::uniform_real_distribution<float>(-size, size)(engine);
  };
  Bodies world;
  const int bodies = 12;
  // Each number in a statement of its own: compilers take arguments in orders of their own.
  const auto vector = [&within](float size) -> std::array<float, 3> {
    return {within(size), within(size), within(size)};
  };
  for (int i = 0; i < bodies; ++i) {
    const std::array<float, 3> velocity = vector(2);
    world.add_body(1 + std::abs(double{within(3)}), 0.3, velocity);
  }
  for (int i = 0; i < 14; ++i) {
    const int a = static_cast<int>(engine() % (bodies + 1)), b = 1 + static_cast<int>(engine() % bodies);
    if (a == b) continue;
    if (i % 3 == 0) {
      const std::array<float, 3> arm_b = vector(0.5f), arm_a = vector(0.5f);
      world.add_ball(a, b, arm_a, arm_b);
    } else {
      world.add_contact(a, b, {{within(0.5f), 0, within(0.5f)}, {within(0.5f), 0, within(0.5f)}}, 0.5f, 0.5f);
    }
  }
  return world;
}

void without_friction(Bodies& world) {
  for (StatedConstraint& constraint : world.constraints) {
    for (ConstraintRow& row : constraint.rows.row) {
      if (row.kind == kRowFriction) row.kind = kRowNone;
    }
  }
}

// Signorini's and Coulomb's laws, row by row: normal impulses push, and only where the points would come
// closer; friction is within its cone, and on its edge where the points slide, against the way that they do.
void expect_laws(const ConstraintSystem& system, const Eigen::VectorXd& p, double tolerance) {
  const Eigen::VectorXd w = system.matrix * p + system.free_speed;
  for (const SystemBlock& block : system.blocks) {
    const int row = block.first;
    if (!block.bounds_length) {
      if (std::isinf(system.lower[row])) {
        EXPECT_NEAR(w[row], 0, tolerance);
      } else {
        EXPECT_GE(p[row], 0);
        EXPECT_GT(w[row], -tolerance);
        EXPECT_LT(std::min(w[row], p[row]), tolerance);
      }
      continue;
    }
    const double radius = (system.bound_by * p)[row], push = p.segment(row, 2).norm();
    const double slip = w.segment(row, 2).norm();
    EXPECT_LT(push, radius + tolerance);
    if (slip > 10 * tolerance) {
      EXPECT_GT(push, radius - 10 * tolerance);
      EXPECT_NEAR(p.segment(row, 2).dot(w.segment(row, 2)), -radius * slip, 10 * tolerance);
    }
  }
}

ReferenceSolution direct(const ConstraintSystem& system) {
  ReferenceOptions options;
  options.method = ReferenceMethod::direct;
  options.max_iterations = 200;
  options.tolerance = 1e-11;
  return solve(system, options);
}

TEST(ReferenceSolvers, AStackAtRestCarriesItsWeight) {
  const Bodies world = stack({1, 2, 3});
  const ConstraintSystem system = world.system();
  const ReferenceSolution solution = direct(system);
  EXPECT_LT(solution.residual, 1e-10);
  const Eigen::VectorXd v = velocities(system, world.bodies, solution.impulses);
  EXPECT_LT(v.tail(system.bodies * 6 - 6).cwiseAbs().maxCoeff(), 1e-9);
  double carried = 0;  // by the ground
  for (int row = 0; row < system.rows(); ++row) {
    if (system.constraint[static_cast<std::size_t>(row)] < 4 &&
        system.slot[static_cast<std::size_t>(row)] == 0)
      carried += solution.impulses[row];
  }
  EXPECT_NEAR(carried, 6 * kWeight * kStep, 1e-8);
}

TEST(ReferenceSolvers, ASlidingBoxIsSlowedByCoulombsLaw) {
  Bodies world;
  const std::int32_t box = world.add_body(2, 1, {3, 0, 4});
  world.add_contact(0, box, {{0, 0, 0}}, 0, 0.5f);
  const ConstraintSystem system = world.system();
  const ReferenceSolution solution = direct(system);
  EXPECT_LT(solution.residual, 1e-10);
  const Eigen::VectorXd v = velocities(system, world.bodies, solution.impulses);
  const double slower = 5 - 0.5 * kWeight * kStep;  // along the way, not along the axes
  EXPECT_NEAR(v[6], 0.6 * slower, 1e-7);
  EXPECT_NEAR(v[7], 0, 1e-9);
  EXPECT_NEAR(v[8], 0.8 * slower, 1e-7);
}

// Without friction velocities are unique, as those of a convex problem; impulses of a box on four points are
// not.
TEST(ReferenceSolvers, EachMethodComesToTheDirectOnesVelocitiesWithoutFriction) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Bodies world = random_world(seed);
    without_friction(world);
    const ConstraintSystem system = world.system();
    const ReferenceSolution exact = direct(system);
    ASSERT_LT(exact.residual, 1e-10) << "seed " << seed;
    const Eigen::VectorXd v = velocities(system, world.bodies, exact.impulses);
    for (const ReferenceMethod method : kIterative) {
      const ReferenceSolution found = solve(system, {.method = method, .max_iterations = 30000});
      const Eigen::VectorXd off = velocities(system, world.bodies, found.impulses) - v;
      // Jacobi's steps are a tenth of the others'.
      EXPECT_LT(off.cwiseAbs().maxCoeff(), method == ReferenceMethod::jacobi ? 1e-3 : 1e-6)
          << "seed " << seed << ", method " << static_cast<int>(method);
    }
  }
}

// With friction there may be several solutions. Each must satisfy what a contact asks for.
TEST(ReferenceSolvers, EveryMethodEndsWithinTheLawsOfContactAndFriction) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const Bodies world = random_world(seed);
    const ConstraintSystem system = world.system();
    for (const ReferenceMethod method : kAll) {
      const ReferenceSolution found = solve(system, {.method = method, .max_iterations = 30000});
      const double tolerance = method == ReferenceMethod::jacobi ? 1e-3 : 1e-7;
      EXPECT_LT(found.residual, tolerance) << "seed " << seed << ", method " << static_cast<int>(method);
      expect_laws(system, found.impulses, tolerance);
    }
  }
}

// p A p / 2 + b p, which the solution without friction makes least.
TEST(ReferenceSolvers, NoSweepOfGaussSeidelRaisesTheObjective) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Bodies world = random_world(seed);
    without_friction(world);
    const ConstraintSystem system = world.system();
    Eigen::VectorXd p = Eigen::VectorXd::Zero(system.rows());
    double last = 0;
    for (int i = 0; i < 100; ++i) {
      sweep(system, 1, p);
      const double now = 0.5 * p.dot(system.matrix * p) + system.free_speed.dot(p);
      ASSERT_LE(now, last + 1e-12) << "seed " << seed << ", sweep " << i;
      last = now;
    }
    EXPECT_LT(last, 0);
  }
}

TEST(ReferenceSolvers, AHeavyWeightHangsOnAChainOfAHundredLinks) {
  for (const double weight : {1.0, 1000.0}) {
    const Bodies world = chain(100, weight);
    const ConstraintSystem system = world.system();
    const ReferenceSolution solution = direct(system);
    EXPECT_LE(solution.iterations, 4);
    EXPECT_LT(solution.residual, 1e-10);
    EXPECT_FALSE(solution.is_singular);
    EXPECT_NEAR(solution.impulses[1], (99 + weight) * kWeight * kStep, 1e-6 * weight) << "of the uppermost";
  }
}

TEST(ReferenceSolvers, AHeavyBoxStandsOnLightOnes) {
  const Bodies world = stack({1, 1, 1, 1000});
  const ReferenceSolution solution = direct(world.system());
  EXPECT_LT(solution.residual, 1e-9);
  EXPECT_LT(solution.iterations, 40);
}

TEST(ReferenceSolvers, RowsThatSayTheSameTwiceAreSolved) {
  Bodies world = chain(10, 1);
  for (int i = 0; i < 10; ++i) world.constraints.push_back(world.constraints[static_cast<std::size_t>(i)]);
  const ConstraintSystem system = world.system();
  for (const ReferenceMethod method : kAll) {
    const ReferenceSolution solution = solve(system, {.method = method, .max_iterations = 30000});
    EXPECT_LT(solution.residual, 1e-6) << static_cast<int>(method);
    EXPECT_FALSE(solution.is_singular);
  }
}

TEST(ReferenceSolvers, RowsThatContradictEachOtherAreReportedAndStayFinite) {
  Bodies world;
  const std::int32_t ball = world.add_body(1, 1);
  for (const float speed : {1.0f, -1.0f}) {
    ConstraintRow& row = world.add(0, ball).rows.row[0];
    row.kind = kRowHeld;
    row.linear_b[0] = 1;
    row.target_speed = speed;
  }
  for (const ReferenceMethod method : kAll) {
    const ReferenceSolution solution = solve(world.system(), {.method = method});
    EXPECT_TRUE(solution.impulses.allFinite()) << static_cast<int>(method);
    EXPECT_GT(solution.residual, 0.1) << static_cast<int>(method);
    EXPECT_EQ(solution.is_singular, method == ReferenceMethod::direct);
  }
}

// Held rows beside contacts, and a box that is pressed between the ground and a lid that comes down.
TEST(ReferenceSolvers, ContradictionsAreReportedBesideContactsAndOfContacts) {
  Bodies held = stack({1, 2}), pressed = stack({1, 2});
  const std::int32_t ball = held.add_body(1, 1);
  for (const float speed : {1.0f, -1.0f}) {
    ConstraintRow& row = held.add(0, ball).rows.row[0];
    row.kind = kRowHeld;
    row.linear_b[0] = 1;
    row.target_speed = speed;
  }
  const std::int32_t box = pressed.add_body(1, 1.0 / 6);
  pressed.bodies.push_back({});
  const auto lid = static_cast<std::int32_t>(pressed.bodies.size()) - 1;
  pressed.bodies.back().velocity.linear[1] = -1;
  pressed.add_contact(0, box, corners(0.5f), 0.5f, 0.6f);
  pressed.add_contact(box, lid, corners(0.5f), 0.5f, 0.6f);
  for (const Bodies* world : {&held, &pressed}) {
    const ConstraintSystem system = world->system();
    const ReferenceSolution solution = direct(system);
    EXPECT_TRUE(solution.is_singular);
    EXPECT_GT(solution.residual, 0.1);
    ASSERT_TRUE(solution.impulses.allFinite());
    // The stack stands.
    const Eigen::VectorXd v = velocities(system, world->bodies, solution.impulses);
    EXPECT_LT(v.segment(6, 12).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(ReferenceSolvers, WhatIsNotSolvedYetIsNoContradiction) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const ConstraintSystem system = random_world(seed).system();
    const ReferenceSolution solution = solve(
        system,
        {.method = ReferenceMethod::direct, .max_iterations = static_cast<int>(seed % 3), .tolerance = 0});
    EXPECT_GT(solution.residual, 0) << "seed " << seed;
    EXPECT_FALSE(solution.is_singular) << "seed " << seed;
  }
}

TEST(ReferenceSolvers, RowsBetweenBodiesThatCannotBePushedChangeNothing) {
  Bodies world = stack({1});
  world.add_contact(0, 0, {{0, 0, 0}}, 0, 0.5f);
  for (const ReferenceMethod method : kAll) {
    const ReferenceSolution solution = solve(world.system(), {.method = method, .max_iterations = 5000});
    EXPECT_TRUE(solution.impulses.allFinite());
    EXPECT_LT(solution.residual, 1e-8) << static_cast<int>(method);
  }
}

TEST(ReferenceSolvers, NothingIsSolvedWithoutConstraints) {
  Bodies world;
  world.add_body(1, 1);
  for (const ReferenceMethod method : kAll) {
    const ReferenceSolution solution = solve(world.system(), {.method = method});
    EXPECT_EQ(solution.impulses.size(), 0);
    EXPECT_EQ(solution.residual, 0);
  }
}

}  // namespace
}  // namespace scree::test
