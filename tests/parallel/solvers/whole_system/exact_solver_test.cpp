// The wide kernels against the exact solution of the same rows: repeated often enough, sweeps over the colors
// of a world come to the velocities that its constraints ask for together.
#include <core/constraints/joint_parameters.h>
#include <core/solvers/reference_solvers.h>
#include <core/world/edit.h>
#include <core/world/wake.h>
#include <parallel/solvers/over_blocks.h>
#include <parallel/solvers/whole_system/state_system.h>
#include <parallel/stages.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <random>

namespace scree {
namespace {

using physics::kStep;
using Pass = SystemPolicy::Pass;

// The first substep of a step, sweep by sweep, without warm start.
class OpenStep {
 public:
  OpenStep(World& world, Isa isa)
      : data_(internals(world)), workers_({.threads = 1, .isa = isa}), crew_(workers_) {
    place_matter(data_);
    wake_neighbors(data_);
    refresh_lists(data_, crew_);
    find_pairs(data_, crew_);
    collide(data_, crew_);
    wake_touched_islands(data_, crew_);
    put_islands_to_sleep(data_, crew_);
    refresh_joints(data_, crew_);
    color_constraints(data_, crew_);
    pack_blocks(data_, crew_);
    Constraints& constraints = constraints_of(data_);
    const std::size_t chunks = constraints.contact_chunks.size() + constraints.joint_chunks.size();
    constraints.moving_bodies.clear();
    constraints.moving_bodies.append(
        std::span<const std::int32_t>(data_.bodies.awake.begin(), data_.bodies.awake.end()));
    constraints.moving_bodies.resize(data_.bodies.awake.size() + 32);
    constraints.residual.resize(chunks);
    constraints.shared.resize(chunks);
    constraints.parts_a.resize(constraints.joint_lanes.size());
    constraints.parts_b.resize(constraints.joint_lanes.size());
    body_ = body_args(data_, kStep);
    contact_ = contact_args(data_, constraints, kStep);
    joint_ = joint_args(data_, constraints, kStep);
    contact_.warm_start_scale = joint_.warm_start_scale = 0;
    const simd::Kernels& kernels = crew_.kernels();
    const int count = static_cast<int>(data_.bodies.awake.size());
    kernels.body.prepare(body_, 0, count);
    over_blocks(
        constraints, crew_,
        [&](const simd::ConstraintChunk& chunk) { kernels.contact.prepare(contact_, chunk); },
        [&](const simd::ConstraintChunk& chunk) {
          kernels.joint.variant[chunk.variant].prepare(joint_, chunk);
        });
    body_.first_substep = true;
    kernels.body.integrate_velocities(body_, 0, count);
  }

  // `together`: the normal impulses of a contact at once.
  void sweep(Pass pass, bool together) {
    const simd::Kernels& kernels = crew_.kernels();
    const simd::ContactKernels& contact = kernels.contact;
    const auto sweep_contacts = pass == Pass::solve ? (together ? contact.solve_together : contact.solve)
                                                    : (together ? contact.relax_together : contact.relax);
    const Constraints& constraints = constraints_of(data_);
    for (const ColorStage& stage : constraints.stages) {
      for (int i = 0; i < stage.joint_chunk_count; ++i) {
        const simd::ConstraintChunk& chunk = constraints.joint_chunks[stage.first_joint_chunk + i];
        const simd::JointVariantKernels& variant = kernels.joint.variant[chunk.variant];
        (pass == Pass::solve ? variant.solve : variant.relax)(joint_, chunk);
      }
      for (int i = 0; i < stage.contact_chunk_count; ++i) {
        const simd::ConstraintChunk& chunk = constraints.contact_chunks[stage.first_contact_chunk + i];
        sweep_contacts(contact_, chunk);
      }
    }
  }

  // Moves the bodies, and keeps the impulses so far where rows are stated from.
  void move() {
    const simd::Kernels& kernels = crew_.kernels();
    kernels.body.integrate_poses(body_, 0, static_cast<int>(data_.bodies.awake.size()));
    joint_.elapsed = joint_.substep;
    store();
  }
  void store() {
    const simd::Kernels& kernels = crew_.kernels();
    over_blocks(
        constraints_of(data_), crew_,
        [&](const simd::ConstraintChunk& chunk) { kernels.contact.store(contact_, chunk); },
        [&](const simd::ConstraintChunk& chunk) {
          kernels.joint.variant[chunk.variant].store(joint_, chunk);
        });
  }

  StatedWorld state() { return state_world(data_, contact_, joint_, crew_); }
  SystemPolicy policy(Pass pass) const { return policy_of(data_, kStep, pass); }

  // Of the bodies of the system.
  double largest_difference(const StatedWorld& stated, const Eigen::VectorXd& v) const {
    double largest = 0;
    for (std::size_t i = 1; i < stated.row.size(); ++i) {
      const VelocityRow& now = data_.bodies.velocity[stated.row[i]];
      for (int k = 0; k < 3; ++k) {
        const auto first = 6 * static_cast<Eigen::Index>(i) + k;
        largest = std::max({largest, std::abs(double{now.linear[k]} - v[first]),
                            std::abs(double{now.angular[k]} - v[first + 3])});
      }
    }
    return largest;
  }

 private:
  WorldData& data_;
  Workers workers_;
  Crew crew_;
  simd::BodyArgs body_{};
  simd::ContactArgs contact_{};
  simd::JointArgs joint_{};
};

// The rope of a pulley is as long as it must be: what is wrong by meters is restored at any speed.
Joint fit(const Joint& joint, Vec3 anchor_a, Vec3 anchor_b) {
  Joint fitted = joint;
  if (auto* pulley = std::get_if<PulleyJoint>(&fitted))
    pulley->length = length(anchor_a - pulley->point_a) + pulley->ratio * length(anchor_b - pulley->point_b);
  return fitted;
}

// Rows in whatever directions: of all kinds, or the first kind alone, as the joint has them.
template <class Within>
void state_rows(World& world, JointId joint, Within&& within) {
  const auto vector = [&] { return Vec3{within(1), within(1), within(1)}; };
  std::vector<UserRow> rows(world.user_rows(joint, {}));
  for (UserRow& row : rows) {
    row.jacobian = {vector(), vector(), vector(), vector()};
    row.target = {.error = within(0.01f), .speed = within(1), .hertz = 3, .damping_ratio = 0.5f};
    row.bounds = {-1e5f, 2e4f};
  }
  world.set_user_rows(joint, rows);
}

// Joins each pair by another kind of joint, whose frames meet; `frame` makes one of body b.
template <class Within, class Frame>
void join_pairs(World& world, unsigned seed, const std::vector<BodyId>& bodies, Within&& within,
                Frame&& frame) {
  const std::vector<Joint> kinds = seed % 2 == 0 ? test::sound_joints() : test::plain_joints();
  for (std::size_t pair = 0; 2 * pair + 1 < bodies.size(); ++pair) {
    const BodyId a = bodies[2 * pair], b = bodies[2 * pair + 1];
    const Joint& joint = kinds[(pair + seed / 2) % kJointTypeCount];
    const bool is_mouse = std::holds_alternative<MouseJoint>(joint);
    JointDef def{.body_a = is_mouse ? kWorld : a, .body_b = b, .frame_b = frame()};
    const Pose pose = world.pose(b) * def.frame_b;
    def.frame_a = is_mouse ? Pose{pose.position, {}} : inverse(world.pose(a)) * pose;
    const JointId id = world.create_joint(def, fit(joint, pose.position, pose.position));
    if (std::holds_alternative<UserJoint>(joint)) state_rows(world, id, within);
  }
}

// Six pairs of bodies, one on the ground, the other on top of it.
World random_world(unsigned seed, bool jointed, const WorldSettings& settings = physics::without_sleep()) {
  std::mt19937 engine(seed);
  const auto within = [&engine](float size) {
    return std::uniform_real_distribution<float>(-size, size)(engine);
  };
  const auto turn = [&] { return normalize(Quat{within(1), within(1), within(1), 1.2f}); };
  World world(settings);
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(ground, Box{{20, 1, 20}});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 12; ++i) {
    const float x = 3.0f * static_cast<float>(i / 2), y = i % 2 == 0 ? 0.45f : 1.4f;
    const BodyId body =
        bodies.emplace_back(world.create_body({.position = {x + within(0.1f), y, within(0.1f)},
                                               .linear_velocity = {within(1), within(1), within(1)},
                                               .angular_velocity = {within(1), within(1), within(1)}}));
    if (i % 2 == 0) {
      world.add_shape(body, Box{{0.5f, 0.5f, 0.5f}});
    } else {
      world.add_shape(body, Sphere{0.5f}, {.rolling_resistance = i % 4 == 1 ? 0.05f : 0.0f});
    }
  }
  if (jointed) {
    join_pairs(world, seed, bodies, within, [&] {
      return Pose{{within(0.4f), within(0.4f), within(0.4f)}, turn()};
    });
  }
  return world;
}

constexpr double kTolerance = 1e-4;  // m/s and rad/s; above 1, of the largest speed, as floats round by it
constexpr int kSweeps = 1000;

void expect_exact(unsigned seed, bool jointed, bool together, Isa isa) {
  World world = random_world(seed, jointed);
  OpenStep open(world, isa);
  for (const Pass pass : {Pass::solve, Pass::relax}) {
    if (pass == Pass::relax) open.move();
    const StatedWorld stated = open.state();
    SystemPolicy policy = open.policy(pass);
    policy.stored_has_acted = pass == Pass::relax;
    const ConstraintSystem system = assemble(stated.bodies, stated.constraints, policy);
    const ReferenceSolution exact = solve(system, {.method = ReferenceMethod::direct, .tolerance = 1e-11});
    const Eigen::VectorXd v = velocities(system, stated.bodies, exact.impulses);
    ASSERT_LE(exact.residual, 1e-9) << "seed " << seed;
    EXPECT_GT(open.largest_difference(stated, v), 1) << "seed " << seed << ": there is nothing to solve";
    for (int i = 0; i < kSweeps; ++i) open.sweep(pass, together);
    const double speed = std::max(v.cwiseAbs().maxCoeff(), 1.0);
    EXPECT_LE(open.largest_difference(stated, v), kTolerance * speed)
        << "seed " << seed << (jointed ? ", with joints, " : ", ") << (together ? "points together, " : "")
        << (pass == Pass::solve ? "solve" : "relax") << " on " << isa_name(isa);
  }
}

// The same of sequential impulses, whose contacts have kernels of their own, while joints have those of the
// sweeps above: 1,000 iterations of a step against the exact solution of its rows.
void expect_exact_impulses(unsigned seed, bool together, Isa isa) {
  WorldSettings settings = physics::without_sleep();
  settings.substeps = 1;
  settings.warm_start = false;
  settings.solver = Solver::sequential_impulse;
  settings.solver_options.iterations = kSweeps;
  settings.solver_options.points_together = together;
  World world = random_world(seed, false, settings);
  settings.solver = Solver::direct;
  settings.solver_options.tolerance = 1e-9f;
  World exact = random_world(seed, false, settings);
  Workers workers({.threads = 1, .isa = isa});
  step(world, kStep, workers);
  step(exact, kStep, workers);
  ASSERT_LE(exact.stats().residual, 1e-8) << "seed " << seed;
  double speed = 1, difference = 0;
  const auto compare = [&](Vec3 now, Vec3 then) {
    for (const auto& [x, y] : {std::pair{now.x, then.x}, {now.y, then.y}, {now.z, then.z}}) {
      speed = std::max(speed, std::abs(double{y}));
      difference = std::max(difference, std::abs(double{x} - double{y}));
    }
  };
  for (std::uint32_t i = 0; i <= world.body_count(); ++i) {
    const BodyId one = world.body_at(i), other = exact.body_at(i);
    if (!world.is_alive(one)) continue;
    compare(world.linear_velocity(one), exact.linear_velocity(other));
    compare(world.angular_velocity(one), exact.angular_velocity(other));
  }
  EXPECT_LE(difference, kTolerance * speed)
      << "seed " << seed << (together ? ", points together, " : ", ") << "on " << isa_name(isa);
}

// On every instruction set: `expect` of the seed, of whether points go together, and of the set.
template <class Expect>
void on_every_set(unsigned seeds, Expect&& expect) {
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      for (const bool together : {false, true}) expect(seed, together, isa);
    }
  }
}

TEST(ExactSolver, SweepsOverContactsComeToTheExactVelocitiesOnEverySet) {
  on_every_set(20, [](unsigned seed, bool together, Isa isa) { expect_exact(seed, false, together, isa); });
}

TEST(ExactSolver, SweepsOverJointsAndContactsComeToTheExactVelocitiesOnEverySet) {
  on_every_set(40, [](unsigned seed, bool together, Isa isa) { expect_exact(seed, true, together, isa); });
}

TEST(ExactSolver, SequentialImpulsesOfContactsComeToTheExactVelocitiesOnEverySet) {
  on_every_set(20, [](unsigned seed, bool together, Isa isa) { expect_exact_impulses(seed, together, isa); });
}

}  // namespace
}  // namespace scree
