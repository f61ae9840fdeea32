// Joint kernels on chains: 100 chains of 100 bodies, 9,900 joints of one kind, or 10,000 with the world. One
// thread; time per joint and pass, per kind, with and without limits and drives, and per instruction set.
#include <benchmark/benchmark.h>
#include <parallel/constraints/constraints.h>
#include <parallel/stages.h>
#include <scree/scree.h>

#include <string>
#include <utility>
#include <vector>

namespace {

using namespace scree;

constexpr int kChains = 100;
constexpr int kLinks = 100;
constexpr float kStep = 1.0f / 60.0f;  // s

// Limits on both sides and a spring, all of them active.
constexpr JointAxis kBusyAxis{.lower = -0.5f, .upper = 0.5f, .drive = Drive::spring, .target = 0.1f};
const RotationDrive kBusyRotation{.drive = Drive::spring, .velocity = {0.1f, 0.1f, 0.1f}};

struct Kind {
  const char* name;
  Joint joint;
};
const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = {
      {"ball", BallJoint{}},
      {"ball_limits",
       BallJoint{.cone_limit = 0.5f, .twist_lower = -0.3f, .twist_upper = 0.3f, .drive = kBusyRotation}},
      {"hinge", HingeJoint{}},
      {"hinge_limits", HingeJoint{kBusyAxis}},
      {"slider", SliderJoint{}},
      {"slider_limits", SliderJoint{kBusyAxis}},
      {"distance", DistanceJoint{{.lower = 1.0f, .upper = 1.0f}}},
      {"distance_spring", DistanceJoint{{.lower = 0.5f, .drive = Drive::spring, .target = 1.0f}}},
      {"weld", WeldJoint{}},
      {"six_degree", SixDegreeJoint{.offset = {kBusyAxis, kBusyAxis, kBusyAxis},
                                    .angle = {kBusyAxis, kBusyAxis, kBusyAxis}}},
      {"wheel", WheelJoint{}},
      {"universal", UniversalJoint{}},
      {"universal_limits", UniversalJoint{kBusyAxis, kBusyAxis}},
      {"planar", PlanarJoint{}},
      {"planar_limits", PlanarJoint{kBusyAxis, kBusyAxis, kBusyAxis}},
      {"gear", GearJoint{}},
      {"rack_and_pinion", RackAndPinionJoint{}},
      {"pulley", PulleyJoint{.point_a = {0.0f, 10.0f, 0.0f}, .point_b = {0.0f, 10.0f, 0.0f}}},
      {"motor", MotorJoint{}},
      {"mouse", MouseJoint{}},
      {"user", UserJoint{{RowKind::held, RowKind::held, RowKind::held}}},
      {"user_rich", UserJoint{{RowKind::held, RowKind::held, RowKind::limit, RowKind::motor, RowKind::spring,
                               RowKind::held}}},
  };
  return kKinds;
}

// Parallel chains along x, at different z, under gravity: every joint carries a load.
void populate(World& world, const Joint& joint) {
  const bool to_world = std::holds_alternative<MouseJoint>(joint);
  std::vector<JointDef> defs;
  for (int chain = 0; chain < kChains; ++chain) {
    BodyId last;
    for (int link = 0; link < kLinks; ++link) {
      const Vec3 position{static_cast<float>(link), 0.0f, static_cast<float>(chain)};
      const BodyId body = world.create_body(
          {.type = link == 0 && !to_world ? BodyType::fixed : BodyType::dynamic, .position = position});
      JointDef def{.body_a = kWorld, .body_b = body};
      if (to_world) {
        defs.push_back(def);
      } else if (link > 0) {
        def.body_a = last;
        def.frame_a.position = {0.5f, 0.0f, 0.0f};
        def.frame_b.position = {-0.5f, 0.0f, 0.0f};
        defs.push_back(def);
      }
      last = body;
    }
  }
  std::vector<JointId> ids(defs.size());
  world.create_joints(defs, std::vector<Joint>(defs.size(), joint), ids);
  if (!std::holds_alternative<UserJoint>(joint)) return;
  // Rows 0 to 2 hold the anchors together as a ball joint does, the others turn about the axes.
  constexpr Vec3 kAxes[] = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  constexpr Vec3 kTurns[] = {{}, {0.0f, 0.0f, -0.5f}, {0.0f, 0.5f, 0.0f}};  // of both bodies
  std::vector<UserRow> rows(world.user_rows(ids[0], {}));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vec3 axis = kAxes[i % 3], back = -1.0f * axis;
    rows[i].jacobian =
        i < 3 ? RowJacobian{back, kTurns[i], axis, kTurns[i]} : RowJacobian{{}, back, {}, axis};
  }
  for (const JointId id : ids) world.set_user_rows(id, rows);
}

constexpr std::pair<const char*, void (*simd::JointVariantKernels::*)(const simd::JointArgs&,
                                                                      const simd::ConstraintChunk&)>
    kPasses[] = {{"prepare", &simd::JointVariantKernels::prepare},
                 {"warm_start", &simd::JointVariantKernels::warm_start},
                 {"solve", &simd::JointVariantKernels::solve},
                 {"relax", &simd::JointVariantKernels::relax},
                 {"store", &simd::JointVariantKernels::store}};

void run_pass(benchmark::State& state, const Joint& joint, Isa isa, std::size_t pass) {
  if (!is_supported(isa)) {
    state.SkipWithError("not supported here");
    return;
  }
  Workers workers(WorkersOptions{.threads = 1, .isa = isa});
  World world({.sleeping = false});
  populate(world, joint);
  // These steps lay out and fill the blocks of joints that have started to move.
  for (int i = 0; i < 3; ++i) step(world, kStep, workers);
  WorldData& data = internals(world, "joint_bench");
  Crew crew(workers);
  Constraints& constraints = constraints_of(data);
  const simd::JointArgs args = joint_args(data, constraints, kStep);
  const simd::JointKernels& kernels = crew.kernels().joint;
  for (auto _ : state) {
    for (const simd::ConstraintChunk& chunk : constraints.joint_chunks) {
      (kernels.variant[chunk.variant].*kPasses[pass].second)(args, chunk);
    }
  }
  state.counters["ns_per_joint"] =
      benchmark::Counter(static_cast<double>(world.joint_count()) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["block_bytes_per_joint"] =
      static_cast<double>(constraints.blocks.size()) / static_cast<double>(world.joint_count());
}

const bool kRegistered = [] {
  for (const Kind& kind : kinds()) {
    for (std::size_t pass = 0; pass < std::size(kPasses); ++pass) {
      for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
        benchmark::RegisterBenchmark(
            (std::string(kind.name) + "/" + kPasses[pass].first + "/" + isa_name(isa)).c_str(),
            [&kind, isa, pass](benchmark::State& state) { run_pass(state, kind.joint, isa, pass); })
            ->Unit(benchmark::kMicrosecond);
      }
    }
  }
  return true;
}();

}  // namespace
