// Impulses go from joints to stated rows and back: what every kind of joint states of the numbers that it
// stores, it gets back.
#include <core/world/edit.h>
#include <parallel/solvers/whole_system/state_system.h>
#include <parallel/stages.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <cmath>
#include <random>

namespace scree {
namespace {

// Pairs of bodies, far from each other, each joined by another kind.
World joined_pairs(const std::vector<Joint>& joints) {
  World world(physics::without_sleep());
  float x = 0;
  for (const Joint& joint : joints) {
    const BodyId a = world.create_body({.position = {x, 0, 0}}),
                 b = world.create_body({.position = {x, 1, 0}});
    for (const BodyId body : {a, b}) world.add_shape(body, Sphere{0.2f});
    const bool is_mouse = std::holds_alternative<MouseJoint>(joint);
    world.create_joint({.body_a = is_mouse ? kWorld : a,
                        .body_b = b,
                        .frame_a = {is_mouse ? Vec3{x, 0.5f, 0} : Vec3{0, 0.5f, 0}, {}},
                        .frame_b = {{0, -0.5f, 0}, physics::rotation_about({1, 2, 3}, 0.1)}},
                       joint);
    x += 10;
  }
  return world;
}

void expect_round_trip(const std::vector<Joint>& joints) {
  WorldSettings settings = physics::without_sleep();
  World world = joined_pairs(joints);
  settings.solver = Solver::direct;
  world.set_settings(settings);
  Workers workers{1};
  step(world, physics::kStep, workers);
  WorldData& data = internals(world);
  Crew crew(workers);
  Constraints& constraints = constraints_of(data);
  SolveStep at{data,
               constraints,
               crew,
               static_cast<int>(data.bodies.awake.size()),
               static_cast<int>(data.bodies.awake.size()),
               body_args(data, physics::kStep),
               contact_args(data, constraints, physics::kStep),
               joint_args(data, constraints, physics::kStep)};
  std::mt19937 engine(1);
  StatedWorld stated = state_world(data, at.contact, at.joint, crew);
  int rows = 0;
  for (StatedConstraint& constraint : stated.constraints) {
    for (ConstraintRow& row : constraint.rows.row) {
      if (row.kind == kRowNone) continue;
      row.impulse = std::uniform_real_distribution<float>(1, 9)(engine);
      ++rows;
    }
  }
  ASSERT_GT(rows, 10);
  store_stated_impulses(at, stated);
  const StatedWorld again = state_world(data, at.contact, at.joint, crew);
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
      const ConstraintRow& row = stated.constraints[i].rows.row[slot];
      if (row.kind == kRowNone) continue;
      EXPECT_NEAR(again.constraints[i].rows.row[slot].impulse, row.impulse, 1e-4)
          << "joint " << stated.item[i] << ", slot " << slot << ", kind of row " << row.kind;
    }
  }
}

TEST(StatedImpulses, OfEveryKindOfJointComeBackFromWhatItStores) {
  expect_round_trip(test::sound_joints());
  expect_round_trip(test::plain_joints());
}

}  // namespace
}  // namespace scree
