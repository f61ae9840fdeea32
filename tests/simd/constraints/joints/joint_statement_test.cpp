// Stated rows and kernels are the same joints: a slow solver over what a kind states comes to the velocities
// and the impulses of its kernels, which are written by hand for speed.
#include "joint_world_fixture.h"

#include <tests/simd/constraints/row_solver.h>

namespace scree::joint_tests {
namespace {

using row_tests::Pass;
using row_tests::RowSolver;

constexpr JointType kAllKinds[] = {
#define SCREE_JOINT_TYPE(kind, Struct) JointType::kind,
    SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE
};

// Frame b in frame a, somewhere among what the kind leaves free.
Pose stated_pose(JointType type, Random& random) {
  const float angle = random.uniform(-1, 1), other = random.uniform(-1, 1);
  const Quat any = about(random.vector(1) + 0.1f * kX, 2 * angle);
  switch (type) {
    case JointType::ball:
      return {{0, 0, 0}, any};
    case JointType::hinge:
      return {{0, 0, 0}, about(kX, 3 * angle)};
    case JointType::slider:
      return {{other, 0, 0}, {}};
    case JointType::weld:
      return {};
    case JointType::wheel:
      return {{0.2f * other, 0, 0}, about(kX, angle) * about(kZ, 3 * other)};
    case JointType::universal:
      return {{0, 0, 0}, about(kX, 3 * angle) * about(kY, other)};
    case JointType::planar:
      return {{0, random.uniform(-1, 1), other}, about(kX, 3 * angle)};
    default:
      return {random.vector(1), any};
  }
}

JointAxisRow stated_axis(Random& random) {
  JointAxisRow axis{-kNoLimit,
                    kNoLimit,
                    random.uniform(-1, 1),
                    random.uniform(-2, 2),
                    random.uniform(0.5f, 80),  // some above what the step allows
                    random.uniform(0, 2),
                    random.uniform(0, 1) < 0.7f ? random.uniform(0.1f, 100) : kNoLimit,
                    kDriveNone};
  const float limits = random.uniform(0, 5), drive = random.uniform(0, 3);
  if (limits > 1) axis.lower = random.uniform(-1, 0.2f);
  if (limits > 2) axis.upper = axis.lower + random.uniform(0, 1);
  if (limits > 3) axis.upper = axis.lower;
  if (limits > 4) axis.lower = -kNoLimit;
  if (drive > 1) axis.drive = drive > 2 ? kDriveMotor : kDriveSpring;
  return axis;
}

void put_rotation_drive(JointParameters& p, Random& random) {
  const Quat target = random.rotation();
  for (int i = 0; i < 3; ++i) p.axis[i].speed = random.uniform(-2, 2);
  const JointAxisRow drive = stated_axis(random);
  p.axis[2].hertz = drive.hertz;
  p.axis[2].damping_ratio = drive.damping_ratio;
  p.axis[2].max_force = drive.max_force;
  p.axis[2].drive = drive.drive;
  p.axis[3] = {target.x, target.y, target.z, target.w, 0, 0, 0, kDriveNone};
}

void put_point(JointAxisRow& axis, Vec3 point) {
  axis.lower = point.x;
  axis.upper = point.y;
  axis.target = point.z;
}

void put_rich(JointType type, Random& random, JointParameters& p) {
  switch (type) {
    case JointType::ball:
      put_rotation_drive(p, random);
      if (random.uniform(0, 1) < 0.7f) p.axis[0].lower = random.uniform(-1.5f, 0);
      if (random.uniform(0, 1) < 0.7f) p.axis[0].upper = random.uniform(0, 1.5f);
      if (random.uniform(0, 1) < 0.7f) p.axis[1].upper = random.uniform(0, 2);
      break;
    case JointType::six_degree:
      for (JointAxisRow& axis : p.axis) axis = stated_axis(random);
      break;
    case JointType::distance:
      p.axis[0] = stated_axis(random);
      p.axis[0].target = random.uniform(0, 2);
      if (p.axis[0].lower > -kNoLimit)
        p.axis[0].lower = random.uniform(0, 1) < 0.3f ? 0 : random.uniform(0, 1);
      if (p.axis[0].upper < kNoLimit) {
        p.axis[0].upper =
            random.uniform(0, 1) < 0.3f ? std::max(p.axis[0].lower, 0.0f) : random.uniform(1, 2);
      }
      break;
    default:
      for (int i = 0; i < 3; ++i) p.axis[i] = stated_axis(random);
      if (type == JointType::wheel && p.axis[2].drive == kDriveSpring) p.axis[2].drive = kDriveMotor;
      if (type == JointType::wheel) p.axis[2].lower = -kNoLimit, p.axis[2].upper = kNoLimit;
  }
}

// Rows of any kind at first and no row behind them; plain joints have three held ones at most.
void put_row_kinds(UserParameters& user, bool rich, Random& random) {
  const float most = rich ? 6.99f : 3.99f, count = random.uniform(1, most);
  for (int i = 0; i < kUserRows; ++i) {
    const RowKind kind = rich ? static_cast<RowKind>(random.uniform(1, 4.99f)) : RowKind::held;
    user.row[i] = static_cast<std::uint32_t>(static_cast<float>(i + 1) <= count ? kind : RowKind::none);
  }
}

// Where both bodies of a joint lie, rows meet all of their velocities; of joints with the world those of b.
void put_user_numbers(JointWorld& world, std::size_t joint, Random& random) {
  const UserParameters& user = world.parameters[joint].user;
  for (int i = 0; i < kUserRows; ++i) {
    if (user.row[i] == static_cast<std::uint32_t>(RowKind::none)) continue;
    // Most of a row is an axis of b of its own: rows that nearly say the same would be worse conditioned than
    // those of all other kinds.
    for (float& x : world.user_jacobians[joint].row[i]) x = random.uniform(-0.5f, 0.5f);
    world.user_jacobians[joint].row[i][6 + i] += 2;
    const float slip = random.uniform(-0.2f, 0.2f), speed = random.uniform(-2, 2);
    const float hertz = random.uniform(0.5f, 80), damping_ratio = random.uniform(0, 2);
    const float target[4] = {slip, speed, hertz, damping_ratio};
    std::copy(std::begin(target), std::end(target), world.user_targets[joint].row[i]);
    const bool bounded = random.uniform(0, 1) < 0.7f;
    world.user_bounds[joint].row[i][0] = bounded ? random.uniform(-100, 1) : -kNoLimit;
    world.user_bounds[joint].row[i][1] = bounded ? random.uniform(1, 100) : kNoLimit;
  }
}

bool has_rotation_drive(JointType type) { return type == JointType::ball || type == JointType::motor; }

JointParameters random_parameters(JointType type, bool rich, Random& random) {
  JointParameters p = has_rotation_drive(type) ? free_rotation() : free_parameters();
  if (random.uniform(0, 1) > 0.5f) {
    p.hertz = p.angular_hertz = random.uniform(1, 80);
    p.damping_ratio = p.angular_damping_ratio = random.uniform(0, 2);
  }
  if (type == JointType::weld && random.uniform(0, 1) > 0.5f) p.angular_hertz = random.uniform(1, 80);
  switch (type) {
    case JointType::gear:
    case JointType::rack_and_pinion:
      p.axis[0].target = random.uniform(0.2f, 3);
      break;
    case JointType::pulley:
      p.axis[0].target = random.uniform(0.3f, 3);
      p.axis[0].upper = random.uniform(1, 8);
      if (random.uniform(0, 1) > 0.5f) p.axis[0].lower = p.axis[0].upper;
      put_point(p.axis[1], random.vector(3));
      put_point(p.axis[2], random.vector(3));
      break;
    case JointType::motor:
      put_rotation_drive(p, random);
      p.axis[4] = stated_axis(random);
      put_point(p.axis[4], random.vector(1));
      put_point(p.axis[5], random.vector(1));
      break;
    case JointType::mouse:
      p.axis[0] = stated_axis(random);
      p.axis[0].drive = kDriveSpring;
      put_point(p.axis[1], random.vector(3));
      break;
    case JointType::user:
      put_row_kinds(p.user, rich, random);
      break;
    default:
      if (rich) put_rich(type, random, p);
  }
  return p;
}

// Pairs of bodies that fly about and turn; every fifth joint has the world for its body a. Some anchors lie
// far from their bodies' centers. Every third body a is locked along and about some axes.
JointWorld random_world(JointType type, bool rich, int joints) {
  Random random(static_cast<unsigned>(type) * 2 + (rich ? 1 : 0));
  JointWorld world;
  world.gravity = kWeight;
  const auto moments = [&] {
    // A wheel's suspension asks for the response of its bodies when the step began; that of balls stays.
    if (type == JointType::wheel) return random.uniform(0.1f, 0.3f) * Vec3{1, 1, 1};
    return Vec3{random.uniform(0.1f, 0.3f), random.uniform(0.1f, 0.3f), random.uniform(0.15f, 0.3f)};
  };
  for (int i = 0; i < joints; ++i) {
    const float slip = i % 2 == 0 ? 0.02f : 0.2f;
    add_random_joint(
        world, random, type == JointType::mouse || i % 5 == 0, slip, moments,
        [&] { return stated_pose(type, random); }, [&] { return random_parameters(type, rich, random); });
    if (type == JointType::user) put_user_numbers(world, world.frames.size() - 1, random);
    const std::int32_t a = world.frames.back().row_a;
    if (i % 3 != 0 || a == kFixedRow) continue;
    const auto locks = static_cast<std::uint32_t>(random.uniform(1, 64));
    world.motion[static_cast<std::size_t>(a)].flags |= locks & kMotionLocksMask;
  }
  return world;
}

// The substeps of a step, sweep by sweep, with the rows stated beside them.
class Sweeps {
 public:
  Sweeps(JointWorld& world, const simd::Kernels& kernels, JointType type, bool rich)
      : world_(world),
        kernels_(kernels),
        type_(type),
        joints_(kernels.joint.variant[simd::joint_variant(type, rich)]) {
    const int count = static_cast<int>(world.frames.size());
    const int blocks = (count + kernels.lanes - 1) / kernels.lanes;
    world.rows.resize(0);
    for (int lane = 0; lane < blocks * kernels.lanes; ++lane) world.rows.push_back(std::min(lane, count - 1));
    world.blocks.resize(joints_.block_bytes * static_cast<std::size_t>(blocks));
    world.residual.resize(1);
    world.shared.resize(1);
    world.parts_a.resize(world.rows.size());
    world.parts_b.resize(world.rows.size());
    chunk_ = {simd::joint_variant(type, rich),
              blocks,
              count,
              0,
              0,
              0,
              simd::BodySide::none,
              simd::BodySide::none,
              false};
    body = world.body_args();
    joint = world.joint_args();
    joint.warm_start_scale = 0.75f;
    body.first_substep = true;
    kernels_.body.prepare(body, 0, moved());
    joints_.prepare(joint, chunk_);
    kernels_.body.integrate_velocities(body, 0, moved());
  }

  void warm_start() { joints_.warm_start(joint, chunk_); }
  void solve() { joints_.solve(joint, chunk_); }
  void relax() { joints_.relax(joint, chunk_); }
  // Stores impulses in the middle of a step. The last number of gears is their error at the poses of the
  // step's beginning: it stays.
  void store() {
    constexpr std::size_t kLast = kJointImpulses - 1;
    std::vector<float> last;
    for (const JointImpulses& each : world_.impulses) last.push_back(each.impulse[kLast]);
    joints_.store(joint, chunk_);
    if (type_ != JointType::gear && type_ != JointType::rack_and_pinion) return;
    for (std::size_t i = 0; i < last.size(); ++i) world_.impulses[i].impulse[kLast] = last[i];
  }
  void move() {
    kernels_.body.integrate_poses(body, 0, moved());
    joint.elapsed += joint.substep;
  }
  void begin_next_substep() {
    body.first_substep = false;
    kernels_.body.integrate_velocities(body, 0, moved());
  }
  std::vector<ConstraintRows> state() {
    std::vector<ConstraintRows> rows(world_.frames.size());
    joints_.state_rows(joint, chunk_, rows.data());
    return rows;
  }
  row_tests::StepConstants constants() const {
    const double substep = double{joint.substep}, stiffest = 0.25 / substep;
    return {substep, stiffest, row_tests::soften(stiffest, 2, substep), row_tests::kRigid,
            double{joint.push_speed}};
  }

  simd::BodyArgs body;
  simd::JointArgs joint;

 private:
  int moved() const { return static_cast<int>(world_.moving.size()); }
  JointWorld& world_;
  const simd::Kernels& kernels_;
  JointType type_;
  const simd::JointVariantKernels& joints_;
  simd::ConstraintChunk chunk_{};
};

row_tests::Twelve velocities_of(const JointWorld& world, std::size_t joint) {
  const JointFrames& f = world.frames[joint];
  return row_tests::velocities(world.velocity[static_cast<std::size_t>(f.row_a)],
                               world.velocity[static_cast<std::size_t>(f.row_b)]);
}

// Rotation vector of frame b in frame a, where the sweeps have moved them.
Vec3 angles_now(const JointWorld& world, std::size_t joint) {
  const auto moved = [&](std::int32_t body) {
    const float* q = world.delta[static_cast<std::size_t>(body)].rotation;
    return Quat{q[0], q[1], q[2], q[3]};
  };
  const JointFrames& f = world.frames[joint];
  Quat q = conjugate(moved(f.row_a) * world.frame_a(joint).rotation) *
           (moved(f.row_b) * world.frame_b(joint).rotation);
  if (q.w < 0) q = {-q.x, -q.y, -q.z, -q.w};
  const Vec3 v{q.x, q.y, q.z};
  const float sine = length(v);
  return sine > 0 ? v * (2 * std::atan2(sine, q.w) / sine) : v;
}

// A float has 24 bits. A sweep multiplies speeds by matrices that it has inverted in floats: each of these
// operations adds a rounding, times the condition of the matrices, which is up to about a hundred here.
constexpr double kRounding = 6e-8, kConditions = 300;

constexpr int kJoints = 400;
constexpr double kWarmStart = 0.75;  // of the impulses of the step before

// What became of all joints of a world in one sweep.
struct Outcome {
  const char* sweep;
  double worst = 0;  // difference to the kernels, in parts of what rounding may make
  std::size_t joint = 0;
  int moved = 0;   // joints that the sweep changed
  int apart = 0;   // joints whose kernels came to something else
  int turned = 0;  // joints that passed half a turn, and count for nothing
};

struct Solving {
  RowSolver solver;
  row_tests::Twelve before;
};

using Rows = std::vector<ConstraintRows>;

std::vector<Solving> begin(const JointWorld& world, const Rows& rows,
                           const row_tests::StepConstants& constants, double scale) {
  std::vector<Solving> all;
  for (std::size_t joint = 0; joint < rows.size(); ++joint) {
    const JointFrames& f = world.frames[joint];
    RowSolver solver(rows[joint], world.inertia[static_cast<std::size_t>(f.row_a)],
                     world.inertia[static_cast<std::size_t>(f.row_b)], constants, scale);
    solver.v = velocities_of(world, joint);
    all.push_back({solver, solver.v});
  }
  return all;
}

// Velocities and, where rows of after the sweep are given, impulses: as the speeds that they make.
void compare(const JointWorld& world, const std::vector<Solving>& all, const Rows* after,
             const std::vector<bool>& turned, Outcome& outcome) {
  for (std::size_t joint = 0; joint < all.size(); ++joint) {
    if (turned[joint]) {
      ++outcome.turned;
      continue;
    }
    const auto& [solver, before] = all[joint];
    const row_tests::Twelve v = velocities_of(world, joint);
    double fastest = 1 + solver.largest_speed(), change = 0, difference = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      fastest = std::max({fastest, std::abs(v[i]), std::abs(before[i])});
      change = std::max(change, std::abs(v[i] - before[i]));
      difference = std::max(difference, std::abs(v[i] - solver.v[i]));
    }
    for (std::size_t slot = 0; after != nullptr && slot < kMaxConstraintRows; ++slot) {
      const ConstraintRow& row = (*after)[joint].row[slot];
      if (row.kind == kRowNone) continue;
      const double off = double{row.impulse} - solver.impulse(slot);
      difference = std::max(difference, std::abs(off) * solver.response(slot));
      fastest = std::max(fastest, std::abs(double{row.impulse}) * solver.response(slot));
    }
    if (change > 1e-3) ++outcome.moved;
    const double part = difference / (kRounding * kConditions * fastest);
    if (!(part <= 1)) ++outcome.apart;
    if (!(part <= outcome.worst)) {
      outcome.worst = part;
      outcome.joint = joint;
    }
  }
}

using Spoil = void (*)(ConstraintRow& row);

// Runs kernels and solver through two substeps, from the same velocities and impulses in each sweep. `spoil`:
// what is wrong with the rows that the solver gets.
std::vector<Outcome> run_sweeps(JointType type, bool rich, const simd::Kernels& kernels,
                                Spoil spoil = nullptr) {
  JointWorld world = random_world(type, rich, kJoints);
  world.step(kernels, type, rich);  // so that there are impulses
  Sweeps sweeps(world, kernels, type, rich);
  const row_tests::StepConstants constants = sweeps.constants();
  const auto told = [spoil](Rows rows) {
    for (ConstraintRows& each : rows) {
      for (ConstraintRow& row : each.row) {
        if (spoil != nullptr && row.kind != kRowNone) spoil(row);
      }
    }
    return rows;
  };
  std::vector<Outcome> outcomes{
      {"warm start"}, {"solve"}, {"relax"}, {"solve of substep 2"}, {"relax of substep 2"}};
  std::vector<bool> turned(kJoints, false);
  const Rows rows = told(sweeps.state());

  std::vector<Solving> all = begin(world, rows, constants, kWarmStart);
  for (Solving& each : all) each.solver.warm_start();
  sweeps.warm_start();
  compare(world, all, nullptr, turned, outcomes[0]);

  Rows solved, moved;
  const auto sweep = [&](Pass pass, double scale, Outcome& outcome) {
    all = begin(world, told(sweeps.state()), constants, scale);
    for (std::size_t joint = 0; joint < all.size(); ++joint) {
      RowSolver& solver = all[joint].solver;
      if (pass == Pass::solve && !moved.empty()) solver.turn_inherited(solved[joint], moved[joint]);
      solver.run(pass);
    }
    pass == Pass::solve ? sweeps.solve() : sweeps.relax();
    sweeps.store();
    const Rows after = sweeps.state();
    compare(world, all, &after, turned, outcome);
    if (pass == Pass::solve) solved = after;
  };
  // Past half a turn a rotation vector points the other way: the impulses that were stored before belong to
  // rows that have turned over.
  const auto move = [&] {
    std::vector<Vec3> angles;
    for (std::size_t joint = 0; joint < kJoints; ++joint) angles.push_back(angles_now(world, joint));
    sweeps.move();
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      if (type == JointType::six_degree && dot(angles[joint], angles_now(world, joint)) < -1)
        turned[joint] = true;
    }
    moved = sweeps.state();
  };
  sweep(Pass::solve, kWarmStart, outcomes[1]);
  move();
  sweep(Pass::relax, 1, outcomes[2]);
  sweeps.begin_next_substep();
  sweep(Pass::solve, 1, outcomes[3]);
  move();
  sweep(Pass::relax, 1, outcomes[4]);
  return outcomes;
}

class JointStatement : public ::testing::TestWithParam<JointType> {};

TEST_P(JointStatement, ASolverOfTheStatedRowsComesToTheVelocitiesAndImpulsesOfTheKernels) {
  for (const bool rich : {false, true}) {
    for (const simd::Kernels* kernels : {all_kernels().front(), all_kernels().back()}) {
      for (const Outcome& outcome : run_sweeps(GetParam(), rich, *kernels)) {
        EXPECT_EQ(outcome.apart, 0) << kernels->name << (rich ? ", rich, " : ", plain, ") << outcome.sweep
                                    << ", joint " << outcome.joint << ": " << outcome.worst
                                    << " times what is allowed";
        EXPECT_LE(outcome.turned, kJoints / 20);
        // Nothing moves what is neither held, limited nor driven.
        const bool acts = rich || (GetParam() != JointType::distance && GetParam() != JointType::six_degree);
        EXPECT_GT(outcome.moved, acts ? kJoints / 3 : -1) << outcome.sweep;
      }
    }
  }
}

struct Fault {
  const char* what;
  Spoil spoil;
};
constexpr Fault kFaults[] = {
    {"the sign of a row's part", [](ConstraintRow& row) { row.angular_b[0] = -row.angular_b[0]; }},
    {"a lever", [](ConstraintRow& row) { row.angular_b[1] *= 1.01f; }},
    {"the error", [](ConstraintRow& row) { row.error += 0.002f; }},
    {"the stiffness", [](ConstraintRow& row) { row.hertz *= 0.9f; }},
    {"the damping", [](ConstraintRow& row) { row.damping_ratio = row.damping_ratio * 1.1f + 0.01f; }},
    {"the target's speed", [](ConstraintRow& row) { row.target_speed += 0.01f; }},
    {"the upper bound", [](ConstraintRow& row) { row.upper *= 0.98f; }},
    {"the impulse", [](ConstraintRow& row) { row.impulse = row.impulse * 0.98f + 0.001f; }},
    {"what is held meanwhile", [](ConstraintRow& row) { row.flags ^= kRowKeepsHeld; }},
    {"what is bounded together", [](ConstraintRow& row) { row.flags ^= kRowBoundsLength; }},
    {"the response for which hertz are meant", [](ConstraintRow& row) { row.reference_response *= 1.05f; }},
};

// So that the law above means something: of each kind of fault there are joints that tell it.
TEST(JointStatements, ThatAreWrongAreNoticed) {
  for (const Fault& fault : kFaults) {
    int apart = 0;
    for (const JointType type : kAllKinds) {
      for (const Outcome& outcome : run_sweeps(type, true, simd::widest_kernels(), fault.spoil)) {
        apart += outcome.apart;
      }
    }
    EXPECT_GT(apart, 100) << fault.what;
  }
}

std::string name_of_kind(const testing::TestParamInfo<JointType>& of) {
#define SCREE_JOINT_TYPE(kind, Struct) #kind,
  constexpr const char* kNames[] = {SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)};
#undef SCREE_JOINT_TYPE
  return kNames[static_cast<std::size_t>(of.param)];
}
INSTANTIATE_TEST_SUITE_P(Every, JointStatement, testing::ValuesIn(kAllKinds), name_of_kind);

TEST(JointStatements, HaveTheSameBitsOnEveryInstructionSet) {
  for (const JointType type : kAllKinds) {
    const auto run = [&](const simd::Kernels& kernels) {
      JointWorld world = random_world(type, true, 37);
      world.step(kernels, type, true);
      Sweeps sweeps(world, kernels, type, true);
      sweeps.move();
      return sweeps.state();
    };
    const std::vector<const simd::Kernels*> sets = all_kernels();
    const std::vector<ConstraintRows> expected = run(*sets[0]);
    for (const simd::Kernels* kernels : sets) {
      const std::vector<ConstraintRows> rows = run(*kernels);
      for (std::size_t joint = 0; joint < rows.size(); ++joint) {
        for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
          EXPECT_EQ(std::memcmp(&expected[joint].row[slot], &rows[joint].row[slot], sizeof(ConstraintRow)), 0)
              << kernels->name << " kind " << static_cast<int>(type) << " joint " << joint << " slot "
              << slot;
        }
      }
    }
  }
}

}  // namespace
}  // namespace scree::joint_tests
