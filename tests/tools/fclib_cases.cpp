// Laws of files in the FCLIB format: they hold the problem bit for bit, and Siconos finds in them the
// velocities that Scree finds.
extern "C" {
#include <fclib.h>
}
#include <gtest/gtest.h>
#include <parallel/solvers/whole_system/first_substep.h>
#include <tests/physics/lab.h>
#include <tools/fclib/fclib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>

#ifdef SCREE_HAS_SICONOS
extern "C" {
#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <fc3d_compute_error.h>
}
#endif

namespace scree {
namespace {

namespace fs = std::filesystem;

struct Built {
  const char* name;
  std::function<void(physics::Lab&)> build;
  int steps;  // before the one that is compared
};

void add_box(physics::Lab& lab, Vec3 at, float half = 0.5f, float density = 1000.0f, Vec3 velocity = {}) {
  lab.add({.position = at, .linear_velocity = velocity}, Box{{half, half, half}},
          {.friction = 0.5f, .density = density});
}

std::vector<Built> scenes() {
  return {{"stack",
           [](physics::Lab& lab) {
             for (int i = 0; i < 5; ++i) add_box(lab, {0, 0.5f + static_cast<float>(i), 0});
           },
           20},
          {"heavy box on a light one",
           [](physics::Lab& lab) {
             add_box(lab, {0, 0.5f, 0}, 0.5f, 10.0f);
             add_box(lab, {0, 1.5f, 0}, 0.5f, 10000.0f);
           },
           5},
          {"sliding box",
           [](physics::Lab& lab) {
             add_box(lab, {0, 0.5f, 0}, 0.5f, 1000.0f, {3, 0, 1});
           },
           2},
          {"balls",
           [](physics::Lab& lab) {
             for (int i = 0; i < 4; ++i) {
               const auto x = static_cast<float>(i % 2), z = static_cast<float>(i / 2);
               lab.add({.position = {0.98f * x, 0.5f, 0.98f * z}}, Sphere{0.5f}, {.friction = 0.5f});
             }
             lab.add({.position = {0.49f, 1.2f, 0.49f}}, Sphere{0.5f}, {.friction = 0.5f});
           },
           3},
          {"bricks",
           [](physics::Lab& lab) {
             add_box(lab, {-0.55f, 0.5f, 0});
             add_box(lab, {0.55f, 0.5f, 0});
             add_box(lab, {0.1f, 1.5f, 0.1f});
           },
           10}};
}

ContactProblem problem_of(const Built& scene) {
  physics::Lab lab;
  lab.add_ground({.friction = 0.5f});
  scene.build(lab);
  Workers workers{1};
  for (int i = 0; i < scene.steps; ++i) step(lab.world, physics::kStep, workers);
  return contact_problem_of(lab.world, physics::kStep, workers);
}

class Fclib : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "scree-test-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  using Local = std::unique_ptr<fclib_local, void (*)(fclib_local*)>;
  Local write_and_read(const ContactProblem& problem) {
    const std::string file = (folder_ / "problem.hdf5").string();
    fclib::write(problem, {"title", "description", "math"}, file);
    return {fclib_read_local(file.c_str()), fclib_delete_local};
  }

  fs::path folder_;
};

void expect_same(const SparseColumns& is, const fclib_matrix* read) {
  ASSERT_NE(read, nullptr);
  ASSERT_EQ(read->m, is.rows);
  ASSERT_EQ(read->n, is.columns);
  ASSERT_EQ(read->nz, -1);
  for (std::size_t i = 0; i < is.start.size(); ++i) ASSERT_EQ(read->p[i], is.start[i]);
  for (std::size_t i = 0; i < is.value.size(); ++i) {
    ASSERT_EQ(read->i[i], is.row[i]);
    ASSERT_EQ(read->x[i], is.value[i]);
  }
}

TEST_F(Fclib, FilesHoldTheProblemBitForBit) {
  physics::Lab lab;
  lab.add_ground();
  const BodyId a = lab.add({.position = {0, 0.5f, 0}}, Box{{0.5f, 0.5f, 0.5f}}),
               b = lab.add({.position = {0.1f, 1.6f, 0}}, Sphere{0.2f});
  lab.world.create_joint(
      {.body_a = a, .body_b = b, .frame_a = {{0, 0.6f, 0}, {}}, .frame_b = {{0, -0.5f, 0}, {}}}, BallJoint{});
  Workers workers{1};
  const ContactProblem problem = contact_problem_of(lab.world, physics::kStep, workers);
  for (int again = 0; again < 2; ++again) {  // the second one replaces the first one
    const Local read = write_and_read(problem);
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->spacedim, 3);
    EXPECT_STREQ(read->info->title, "title");
    EXPECT_STREQ(read->info->description, "description");
    expect_same(problem.response, read->W);
    expect_same(problem.coupling, read->V);
    expect_same(problem.held_response, read->R);
    for (std::size_t i = 0; i < problem.free_speed.size(); ++i) ASSERT_EQ(read->q[i], problem.free_speed[i]);
    for (std::size_t i = 0; i < problem.held_speed.size(); ++i) ASSERT_EQ(read->s[i], problem.held_speed[i]);
    for (std::size_t i = 0; i < problem.friction.size(); ++i) ASSERT_EQ(read->mu[i], problem.friction[i]);
  }
}

TEST_F(Fclib, RefusesProblemsWithoutPointsAndFoldersThatAreNone) {
  EXPECT_THROW(fclib::write(ContactProblem{}, {}, (folder_ / "none.hdf5").string()), Error);
  EXPECT_FALSE(fs::exists(folder_ / "none.hdf5"));
  EXPECT_THROW(fclib::write(problem_of(scenes()[2]), {}, (folder_ / "no" / "folder.hdf5").string()),
               std::runtime_error);
}

TEST_F(Fclib, FindsNoMeritLeftAtOurSolutions) {
  for (const Built& scene : scenes()) {
    const ContactProblem problem = problem_of(scene);
    ContactSolution ours = solve_contact_problem(problem, 1000, 1e-13);
    const Local read = write_and_read(problem);
    ASSERT_NE(read, nullptr);
    fclib_solution solution{nullptr, ours.speeds.data(), ours.impulses.data(), nullptr};
    EXPECT_LT(fclib_merit_local(read.get(), MERIT_1, &solution), 1e-9) << scene.name;
    std::vector<double> none(ours.impulses.size(), 0.0);
    solution.r = none.data();
    EXPECT_GT(fclib_merit_local(read.get(), MERIT_1, &solution), 1e-3) << scene.name;
  }
}

#ifdef SCREE_HAS_SICONOS
// The residual of the natural map, in the terms of Siconos, by |q|.
double error_by_siconos(const fclib_local& read, const std::vector<double>& impulses,
                        const std::vector<double>& speeds) {
  double sum = 0, free = 0;
  for (std::size_t point = 0; point < impulses.size() / 3; ++point) {
    double r[3], u[3], work[3];
    for (std::size_t k = 0; k < 3; ++k) {
      r[k] = impulses[3 * point + k];
      u[k] = speeds[3 * point + k];
      free += read.q[3 * point + k] * read.q[3 * point + k];
    }
    fc3d_unitary_compute_and_add_error(r, u, read.mu[point], &sum, work);
  }
  return std::sqrt(sum / free);
}

struct Found {
  std::vector<double> impulses, speeds;
};

Found solve_by_siconos(const fclib_local& read) {
  const int rows = read.W->m;
  NumericsMatrix* matrix = NM_create(NM_DENSE, rows, rows);
  std::fill(matrix->matrix0, matrix->matrix0 + rows * rows, 0.0);
  for (int column = 0; column < rows; ++column) {
    for (int at = read.W->p[column]; at < read.W->p[column + 1]; ++at)
      matrix->matrix0[read.W->i[at] + column * rows] = read.W->x[at];
  }
  FrictionContactProblem problem{3, rows / 3, matrix, read.q, read.mu};
  auto* const options = solver_options_create(SICONOS_FRICTION_3D_NSGS);
  options->iparam[SICONOS_IPARAM_MAX_ITER] = 200000;
  options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
  const auto size = static_cast<std::size_t>(rows);
  Found found{std::vector<double>(size, 0.0), std::vector<double>(size, 0.0)};
  EXPECT_EQ(fc3d_driver(&problem, found.impulses.data(), found.speeds.data(), options), 0);
  solver_options_delete(options);
  NM_clear(matrix);
  std::free(matrix);
  return found;
}
#endif

TEST_F(Fclib, SiconosFindsTheVelocitiesThatWeFind) {
#ifdef SCREE_HAS_SICONOS
  for (const Built& scene : scenes()) {
    const ContactProblem problem = problem_of(scene);
    ASSERT_GT(problem.points(), 0) << scene.name;
    const Local read = write_and_read(problem);
    ASSERT_NE(read, nullptr);
    const ContactSolution ours = solve_contact_problem(problem, 1000, 1e-13);
    const Found found = solve_by_siconos(*read);
    double off = 0;
    for (std::size_t i = 0; i < ours.speeds.size(); ++i)
      off = std::max(off, std::abs(ours.speeds[i] - found.speeds[i]));
    const double error = error_by_siconos(*read, found.impulses, found.speeds);
    std::printf("%-25s %2d points: natural map %7.1e, of Siconos %7.1e, speeds differ by %7.1e m/s\n",
                scene.name, problem.points(), ours.natural_error, error, off);
    EXPECT_LT(ours.natural_error, 1e-9) << scene.name;
    EXPECT_NEAR(error_by_siconos(*read, ours.impulses, ours.speeds), ours.natural_error, 1e-12) << scene.name;
    EXPECT_LT(error, 1e-8) << scene.name;
    EXPECT_LT(off, 1e-7) << scene.name;
    // Where nothing is solved yet, both figures are large and the same.
    const std::vector<double> guess(ours.impulses.size(), 0.25), speeds = speeds_of(problem, guess, {});
    const double unsolved = natural_map_error(problem, guess, speeds);
    EXPECT_GT(unsolved, 1e-2) << scene.name;
    EXPECT_NEAR(error_by_siconos(*read, guess, speeds), unsolved, 1e-9 * unsolved) << scene.name;
  }
#else
  GTEST_SKIP() << "libsiconos-numerics-dev is not installed";
#endif
}

}  // namespace
}  // namespace scree
