// Stated rows and kernels describe the same contacts: a slow solver over the stated rows gives the velocities
// and the impulses of the sweeps in constraint space.
#include <core/plain/manifold.h>
#include <tests/simd/all_kernels.h>
#include <tests/simd/constraints/joints/joint_fixture.h>
#include <tests/simd/constraints/row_solver.h>

#include <string>

namespace scree::contact_tests {
namespace {

using joint_tests::Random;
using kernel_tests::all_kernels;
using row_tests::Pass;
using row_tests::RowSolver;

// The variants of blocks, see contact_kernels.h.
struct Variant {
  int bucket;
  bool rich, is_static;
};

constexpr int kMostPoints[simd::kPointBuckets] = {1, 2, 4};

// Contacts of two bodies each, in one chunk.
struct ContactWorld {
  Column<Manifold> manifolds;
  Column<ContactSurface> surfaces;
  Column<VelocityRow> velocity;
  Column<DeltaRow> delta;
  Column<InertiaRow> inertia;
  Column<std::uint8_t> step_notes;
  Column<std::int32_t> rows;
  Column<char> blocks;
  Column<float> residual;

  std::int32_t add_body(Random& random, bool moves) {
    InertiaRow body{};
    if (moves) {
      // Symmetric and positive: a diagonal that outweighs the rest.
      const auto diagonal = [&] { return random.uniform(3, 9); };
      const auto other = [&] { return random.uniform(-1, 1); };
      body = {{diagonal(), other(), other(), diagonal(), other(), diagonal()}, random.uniform(0.2f, 2), 0};
    }
    const Vec3 v = random.vector(2), w = random.vector(3);
    velocity.push_back(moves ? VelocityRow{{v.x, v.y, v.z}, {w.x, w.y, w.z}, 0, 0} : VelocityRow{});
    delta.push_back({{0, 0, 0}, {0, 0, 0, 1}, 0});
    inertia.push_back(body);
    step_notes.push_back(0);
    return static_cast<std::int32_t>(velocity.size()) - 1;
  }

  // Moves every body of a contact a little, as a substep does.
  void move(Random& random) {
    for (std::size_t body = 0; body < delta.size(); ++body) {
      if (inertia[body].inverse_mass == 0) continue;
      const Vec3 p = random.vector(0.01f), turn = random.vector(0.01f);
      const Quat q = normalize(Quat{turn.x, turn.y, turn.z, 1});
      delta[body] = {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}, 0};
    }
  }

  void add_contact(Random& random, const Variant& variant) {
    Manifold m{};
    Vec3 normal = random.vector(1);
    while (length(normal) < 0.1f) normal = random.vector(1);
    normal = normal * (1 / length(normal));
    const Vec3 arm_a = random.vector(0.5f), arm_b = random.vector(0.5f);
    store(m.normal, normal);
    store(m.arm_a, arm_a);
    store(m.arm_b, arm_b);
    m.row_a = variant.is_static ? kFixedRow : add_body(random, true);
    m.row_b = add_body(random, true);
    m.friction = random.uniform(0, 1);
    const int most = kMostPoints[variant.bucket];
    const int points = most == 4 ? (random.uniform(0, 1) < 0.5f ? 3 : 4) : most;
    for (int k = 0; k < kMaxManifoldPoints; ++k) m.separation[k] = kAbsentSeparation;
    for (int k = 0; k < points; ++k) {
      m.point_u[k] = random.uniform(-0.4f, 0.4f);
      m.point_v[k] = random.uniform(-0.4f, 0.4f);
      m.separation[k] = random.uniform(-0.03f, 0.02f);
      // Deep enough that the push speed bounds the bias.
      if (random.uniform(0, 1) < 0.1f) m.separation[k] *= 30;
      m.normal_impulse[k] = std::max(random.uniform(-0.5f, 1), 0.0f);
    }
    if (most < 4) {
      m.point_v[kTwistArm] = random.uniform(0, 0.5f);
      m.point_u[kCoreA] = random.uniform(0, 0.3f);
      m.point_u[kCoreB] = random.uniform(0, 0.3f);
    }
    for (float& impulse : m.friction_impulse) impulse = random.uniform(-0.3f, 0.3f);
    m.twist_impulse = random.uniform(-0.1f, 0.1f);
    m.info = static_cast<std::uint32_t>(points);
    if (variant.rich) m.info |= kManifoldRich;
    if (variant.is_static) m.info |= kManifoldStatic;
    manifolds.push_back(m);
    ContactSurface surface{};
    if (variant.rich) {
      surface.rolling_resistance = random.uniform(0, 0.2f);
      store(surface.surface_velocity, cross(normal, random.vector(2)));
      store(surface.rolling_impulse, random.vector(0.1f));
    }
    surfaces.push_back(surface);
  }

 private:
  static void store(float (&to)[3], Vec3 v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
};

ContactWorld random_world(const Variant& variant, int contacts) {
  Random random(
      static_cast<unsigned>(simd::contact_variant(variant.bucket, variant.rich, variant.is_static)));
  ContactWorld world;
  for (int row = 0; row < kFirstBody; ++row) world.add_body(random, false);
  for (int i = 0; i < contacts; ++i) world.add_contact(random, variant);
  return world;
}

constexpr float kSubstep = 1.0f / 240;
constexpr float kHertz = 30, kDampingRatio = 10;

class Sweeps {
 public:
  Sweeps(ContactWorld& world, const simd::Kernels& kernels, const Variant& variant)
      : world_(world), kernels_(kernels.contact) {
    const int count = static_cast<int>(world.manifolds.size());
    const int blocks = (count + kernels.lanes - 1) / kernels.lanes;
    chunk_.variant = simd::contact_variant(variant.bucket, variant.rich, variant.is_static);
    chunk_.blocks = blocks;
    chunk_.lanes = count;
    for (int lane = 0; lane < blocks * kernels.lanes; ++lane) world.rows.push_back(std::min(lane, count - 1));
    world.blocks.resize(kernels_.block_bytes[chunk_.variant] * static_cast<std::size_t>(blocks));
    world.residual.resize(1);
    args_.rows = world.rows.data();
    args_.blocks = world.blocks.data();
    args_.manifolds = world.manifolds.data();
    args_.surfaces = world.surfaces.data();
    args_.velocity = world.velocity.data();
    args_.delta = world.delta.data();
    args_.inertia = world.inertia.data();
    args_.step_notes = world.step_notes.data();
    args_.soft = simd::soften(kHertz, kDampingRatio, kSubstep);
    args_.soft_static = simd::soften(2 * kHertz, 0.5f * kDampingRatio, kSubstep);
    args_.substep = kSubstep;
    args_.inverse_substep = 1 / kSubstep;
    args_.push_speed = 3;
    args_.restitution_threshold = 1;
    args_.warm_start_scale = 0.75f;
    args_.impulse_keep = 1;
    args_.residual = world.residual.data();
    kernels_.prepare(args_, chunk_);
  }
  void warm_start() { kernels_.warm_start(args_, chunk_); }
  void solve() { kernels_.solve(args_, chunk_); }
  void relax() { kernels_.relax(args_, chunk_); }
  std::vector<ConstraintRows> state() {
    std::vector<ConstraintRows> rows(world_.manifolds.size());
    kernels_.state_rows(args_, chunk_, rows.data());
    return rows;
  }
  // With the impulses after the sweeps.
  std::vector<ConstraintRows> state_with_impulses() {
    kernels_.store(args_, chunk_);
    return state();
  }

 private:
  ContactWorld& world_;
  const simd::ContactKernels& kernels_;
  simd::ContactArgs args_{};
  simd::ConstraintChunk chunk_{};
};

row_tests::StepConstants constants_of(const Variant& variant) {
  const double substep = double{kSubstep};
  const row_tests::Softness soft =
      variant.is_static ? row_tests::soften(2.0 * double{kHertz}, 0.5 * double{kDampingRatio}, substep)
                        : row_tests::soften(double{kHertz}, double{kDampingRatio}, substep);
  return {substep, 0.25 / substep, row_tests::kRigid, soft, 3};
}

// See joint_statement_test.cpp; what contacts invert has a condition of about ten.
constexpr double kRounding = 6e-8, kConditions = 100;

struct Outcome {
  const char* sweep;
  double worst = 0;  // difference to the kernels, in parts of what rounding may make
  int moved = 0;     // contacts that the sweep changed
  int apart = 0;     // contacts whose kernels gave another result
};

using Spoil = void (*)(ConstraintRow& row);

constexpr int kContacts = 300;

std::vector<Outcome> run_sweeps(const Variant& variant, const simd::Kernels& kernels, Spoil spoil = nullptr) {
  ContactWorld world = random_world(variant, kContacts);
  Sweeps sweeps(world, kernels, variant);
  const row_tests::StepConstants constants = constants_of(variant);
  std::vector<Outcome> outcomes;
  const auto velocities_of = [&](std::size_t contact) {
    const Manifold& m = world.manifolds[contact];
    return row_tests::velocities(world.velocity[static_cast<std::size_t>(m.row_a)],
                                 world.velocity[static_cast<std::size_t>(m.row_b)]);
  };
  const auto run = [&](const char* sweep, double scale, auto of_solver, auto of_kernels, bool has_impulses) {
    std::vector<ConstraintRows> rows = sweeps.state();
    std::vector<RowSolver> solvers;
    std::vector<row_tests::Twelve> before;
    for (std::size_t contact = 0; contact < kContacts; ++contact) {
      for (ConstraintRow& row : rows[contact].row) {
        if (spoil != nullptr && row.kind != kRowNone) spoil(row);
      }
      const Manifold& m = world.manifolds[contact];
      solvers.emplace_back(rows[contact], world.inertia[static_cast<std::size_t>(m.row_a)],
                           world.inertia[static_cast<std::size_t>(m.row_b)], constants, scale);
      before.push_back(velocities_of(contact));
      solvers.back().v = before.back();
      of_solver(solvers.back());
    }
    of_kernels();
    Outcome outcome{sweep};
    const std::vector<ConstraintRows> after =
        has_impulses ? sweeps.state_with_impulses() : std::vector<ConstraintRows>{};
    for (std::size_t contact = 0; contact < kContacts; ++contact) {
      const row_tests::Twelve v = velocities_of(contact);
      double fastest = 1 + solvers[contact].largest_speed(), change = 0, difference = 0;
      for (std::size_t i = 0; i < 12; ++i) {
        fastest = std::max({fastest, std::abs(v[i]), std::abs(before[contact][i])});
        change = std::max(change, std::abs(v[i] - before[contact][i]));
        difference = std::max(difference, std::abs(v[i] - solvers[contact].v[i]));
      }
      for (std::size_t slot = 0; has_impulses && slot < kMaxConstraintRows; ++slot) {
        const ConstraintRow& row = after[contact].row[slot];
        if (row.kind == kRowNone) continue;
        const double off = double{row.impulse} - solvers[contact].impulse(slot);
        difference = std::max(difference, std::abs(off) * solvers[contact].response(slot));
      }
      const double part = difference / (kRounding * kConditions * fastest);
      if (change > 1e-3) ++outcome.moved;
      if (!(part <= 1)) ++outcome.apart;
      outcome.worst = std::max(outcome.worst, part);
    }
    outcomes.push_back(outcome);
  };
  run(
      "warm start", 0.75, [](RowSolver& s) { s.warm_start(); }, [&] { sweeps.warm_start(); }, false);
  run(
      "solve", 0.75, [](RowSolver& s) { s.run(Pass::solve); }, [&] { sweeps.solve(); }, true);
  Random random(7);
  world.move(random);
  run(
      "relax", 1, [](RowSolver& s) { s.run(Pass::relax); }, [&] { sweeps.relax(); }, true);
  run(
      "solve of substep 2", 1, [](RowSolver& s) { s.run(Pass::solve); }, [&] { sweeps.solve(); }, true);
  world.move(random);
  run(
      "relax of substep 2", 1, [](RowSolver& s) { s.run(Pass::relax); }, [&] { sweeps.relax(); }, true);
  return outcomes;
}

template <class Visit>
void for_each_variant(Visit&& visit) {
  for (int bucket = 0; bucket < simd::kPointBuckets; ++bucket) {
    for (const bool rich : {false, true}) {
      for (const bool is_static : {false, true}) visit(Variant{bucket, rich, is_static});
    }
  }
}

TEST(ContactStatement, ASolverOfTheStatedRowsGivesTheVelocitiesAndImpulsesOfTheKernels) {
  for_each_variant([](const Variant& variant) {
    for (const simd::Kernels* kernels : {all_kernels().front(), all_kernels().back()}) {
      for (const Outcome& outcome : run_sweeps(variant, *kernels)) {
        EXPECT_EQ(outcome.apart, 0) << kernels->name << ", up to " << kMostPoints[variant.bucket] << " points"
                                    << (variant.rich ? ", rich" : "") << (variant.is_static ? ", static" : "")
                                    << ", " << outcome.sweep << ": " << outcome.worst
                                    << " times what is allowed";
        EXPECT_GT(outcome.moved, kContacts / 3) << outcome.sweep;
      }
    }
  });
}

struct Fault {
  const char* what;
  Spoil spoil;
};
constexpr Fault kFaults[] = {
    {"the sign of a row's part", [](ConstraintRow& row) { row.angular_b[0] = -row.angular_b[0]; }},
    {"a lever", [](ConstraintRow& row) { row.angular_a[1] *= 1.01f; }},
    {"the separation", [](ConstraintRow& row) { row.error += 0.001f; }},
    {"the speed of a surface", [](ConstraintRow& row) { row.target_speed -= 0.01f; }},
    {"what bounds friction", [](ConstraintRow& row) { row.bound_by[0] *= 0.98f; }},
    {"that the bound is that of a length", [](ConstraintRow& row) { row.flags ^= kRowBoundsLength; }},
    {"the impulse", [](ConstraintRow& row) { row.impulse = row.impulse * 0.98f + 0.001f; }},
};

TEST(ContactStatement, WrongStatementsAreDetected) {
  for (const Fault& fault : kFaults) {
    int apart = 0;
    for_each_variant([&](const Variant& variant) {
      for (const Outcome& outcome : run_sweeps(variant, simd::widest_kernels(), fault.spoil)) {
        apart += outcome.apart;
      }
    });
    EXPECT_GT(apart, 100) << fault.what;
  }
}

TEST(ContactStatement, HasTheSameBitsOnEveryInstructionSet) {
  for_each_variant([](const Variant& variant) {
    const auto run = [&](const simd::Kernels& kernels) {
      ContactWorld world = random_world(variant, 37);
      Sweeps sweeps(world, kernels, variant);
      Random random(7);
      world.move(random);
      return sweeps.state();
    };
    const std::vector<ConstraintRows> expected = run(*all_kernels().front());
    for (const simd::Kernels* kernels : all_kernels()) {
      const std::vector<ConstraintRows> rows = run(*kernels);
      for (std::size_t contact = 0; contact < rows.size(); ++contact) {
        EXPECT_EQ(std::memcmp(&expected[contact], &rows[contact], sizeof(ConstraintRows)), 0)
            << kernels->name << " contact " << contact;
      }
    }
  });
}

}  // namespace
}  // namespace scree::contact_tests
