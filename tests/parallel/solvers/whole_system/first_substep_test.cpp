// Laws of contact problems with friction at each point: the matrix and the free speeds are those of
// mechanics, the solution obeys Coulomb's law, and rows without a place are named.
#include <parallel/solvers/whole_system/first_substep.h>
#include <tests/physics/lab.h>

#include <Eigen/Eigenvalues>

namespace scree {
namespace {

constexpr double kSubstep = 1.0 / 60 / 4;

Eigen::MatrixXd dense(const SparseColumns& from) {
  Eigen::MatrixXd to = Eigen::MatrixXd::Zero(from.rows, from.columns);
  for (int column = 0; column < from.columns; ++column) {
    const auto c = static_cast<std::size_t>(column);
    for (int at = from.start[c]; at < from.start[c + 1]; ++at)
      to(from.row[static_cast<std::size_t>(at)], column) = from.value[static_cast<std::size_t>(at)];
  }
  return to;
}

Eigen::VectorXd vector(const std::vector<double>& from) {
  return Eigen::Map<const Eigen::VectorXd>(from.data(), static_cast<Eigen::Index>(from.size()));
}

ContactProblem problem_of(const World& world) {
  Workers workers{1};
  return contact_problem_of(world, physics::kStep, workers);
}

// A cube of 1 m, 2 t, on the ground.
struct Cube {
  physics::Lab lab;
  BodyId body;
  explicit Cube(float friction, Vec3 velocity = {}) {
    lab.add_ground({.friction = friction});
    body = lab.add({.position = {0, 0.5f, 0}, .linear_velocity = velocity}, Box{{0.5f, 0.5f, 0.5f}},
                   {.friction = friction, .density = 2000.0f});
  }
};

TEST(ContactProblem, OfABallOnAPlaneIsTheAnalyticOne) {
  physics::Lab lab;
  lab.add_ground({.friction = 0.5f});
  const float radius = 0.5f, gap = 0.001f;
  const BodyId ball = lab.add({.position = {0, radius + gap, 0}}, Sphere{radius}, {.friction = 0.5f});
  const double mass = lab.world.mass_properties(ball).mass;
  const ContactProblem problem = problem_of(lab.world);
  ASSERT_EQ(problem.points(), 1);
  EXPECT_EQ(problem.held(), 0);
  EXPECT_NEAR(problem.friction[0], 0.5, 1e-6);
  // I = 2/5 m r^2; the arm is r, and half of the gap as points lie between the surfaces.
  const double arm = radius + 0.5 * gap, along = 1 + arm * arm / (0.4 * radius * radius);
  const Eigen::Vector3d expected(1, along, along);
  const Eigen::MatrixXd w = dense(problem.response) * mass;
  EXPECT_LT((w - Eigen::MatrixXd(expected.asDiagonal())).norm(), 1e-2);
  EXPECT_NEAR(problem.free_speed[0], gap / kSubstep - physics::kGravity * kSubstep, 1e-4);
  EXPECT_NEAR(problem.free_speed[1], 0, 1e-6);
  EXPECT_NEAR(problem.free_speed[2], 0, 1e-6);
}

// Free speeds are linear in the velocities: their differences are J, and W must be J M^-1 J^T.
TEST(ContactProblem, OfABoxHasTheMatrixOfItsFiniteDifferences) {
  Cube cube(0.6f);
  World& world = cube.lab.world;
  const ContactProblem problem = problem_of(world);
  ASSERT_EQ(problem.points(), 4);
  Eigen::MatrixXd jacobian(12, 6);
  for (int i = 0; i < 6; ++i) {
    float v[6]{};
    v[i] = 0.125f;
    world.set_linear_velocity(cube.body, {v[0], v[1], v[2]});
    world.set_angular_velocity(cube.body, {v[3], v[4], v[5]});
    jacobian.col(i) = (vector(problem_of(world).free_speed) - vector(problem.free_speed)) / 0.125;
  }
  const double mass = world.mass_properties(cube.body).mass;
  Eigen::VectorXd inverse = Eigen::VectorXd::Constant(6, 1 / mass);
  inverse.tail<3>().setConstant(6 / mass);  // I = m a^2 / 6
  const Eigen::MatrixXd w = dense(problem.response),
                        expected = jacobian * inverse.asDiagonal() * jacobian.transpose();
  EXPECT_LT((w - expected).norm(), 1e-4 * w.norm());
  for (int point = 0; point < 4; ++point) {
    const Eigen::MatrixXd rows = jacobian.middleRows(3 * point, 3);
    const Eigen::Vector3d normal = rows.row(0).head<3>();
    EXPECT_LT((normal - Eigen::Vector3d::UnitY()).norm(), 1e-4);
    const Eigen::Vector3d turn = rows.row(0).tail<3>();  // arm x (0, 1, 0)
    const Eigen::Vector3d arm(turn.z(), -0.5, -turn.x());
    EXPECT_NEAR(std::abs(arm.x()), 0.5, 1e-3);
    EXPECT_NEAR(std::abs(arm.z()), 0.5, 1e-3);
    for (int k = 1; k < 3; ++k) {
      const Eigen::Vector3d tangent = rows.row(k).head<3>(), lever = rows.row(k).tail<3>();
      EXPECT_LT((lever - arm.cross(tangent)).norm(), 1e-3);
    }
  }
}

TEST(ContactProblem, HasASymmetricPositiveSemiDefiniteMatrix) {
  physics::Lab lab;
  lab.add_ground();
  for (int i = 0; i < 4; ++i) {
    lab.add({.position = {0.1f * static_cast<float>(i), 0.5f + static_cast<float>(i), 0}},
            Box{{0.5f, 0.5f, 0.5f}});
  }
  const Eigen::MatrixXd w = dense(problem_of(lab.world).response);
  ASSERT_EQ(w.rows(), 48);
  EXPECT_LT((w - w.transpose()).norm(), 1e-12 * w.norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(w);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-6 * eigen.eigenvalues().maxCoeff());
}

TEST(ContactProblem, IsSolvedByTheFrictionOfCoulomb) {
  Cube cube(0.5f, {1, 0, 0});
  const ContactProblem problem = problem_of(cube.lab.world);
  const ContactSolution solution = solve_contact_problem(problem, 1000, 1e-12);
  EXPECT_LT(solution.natural_error, 1e-9);
  const double mass = cube.lab.world.mass_properties(cube.body).mass;
  double normal = 0;
  for (int point = 0; point < 4; ++point) {
    const std::size_t at = 3 * static_cast<std::size_t>(point);
    normal += solution.impulses[at];
    EXPECT_NEAR(std::hypot(solution.speeds[at + 1], solution.speeds[at + 2]),
                1 - 0.5 * physics::kGravity * kSubstep, 1e-5);
  }
  EXPECT_NEAR(normal, mass * physics::kGravity * kSubstep, 1e-4 * normal);
  // No impulses are none: the box would fall into the ground.
  const std::vector<double> none(12, 0.0);
  EXPECT_GT(natural_map_error(problem, none, problem.free_speed), 1e-2);
}

TEST(ContactProblem, LeavesTheWorldAsItIs) {
  Cube cube(0.5f, {1, 0, 0});
  const std::uint64_t hash = cube.lab.world.hash();
  problem_of(cube.lab.world);
  EXPECT_EQ(cube.lab.world.hash(), hash);
}

TEST(ContactProblem, KeepsWhatJointsHold) {
  Cube cube(0.5f);
  const BodyId other = cube.lab.add({.position = {0, 1.6f, 0}}, Sphere{0.2f});
  cube.lab.world.create_joint(
      {.body_a = cube.body, .body_b = other, .frame_a = {{0, 0.6f, 0}, {}}, .frame_b = {{0, -0.5f, 0}, {}}},
      BallJoint{});
  const ContactProblem problem = problem_of(cube.lab.world);
  EXPECT_EQ(problem.held(), 3);
  const ContactSolution solution = solve_contact_problem(problem, 1000, 1e-12);
  EXPECT_LT(solution.held_error, 1e-9);
  EXPECT_LT(solution.natural_error, 1e-9);
}

TEST(ContactProblem, RefusesRowsWithoutAPlaceByKindAndNumber) {
  Cube cube(0.5f);
  const BodyId other = cube.lab.add({.position = {0, 1.6f, 0}}, Sphere{0.2f});
  HingeJoint hinge;
  hinge.angle.drive = Drive::motor;
  hinge.angle.max_force = 10.0f;
  cube.lab.world.create_joint({.body_a = cube.body, .body_b = other}, hinge);
  try {
    problem_of(cube.lab.world);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("1 of motors"), std::string::npos) << error.what();
  }
  Workers workers{1};
  EXPECT_THROW(contact_problem_of(cube.lab.world, 0.0f, workers), Error);
}

}  // namespace
}  // namespace scree
