// Ball joints; see simd/joint_kernels.h.
#include <simd/joint_point.h>
#include <simd/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Impulses: 0 to 2 at the anchor, in world axes.
struct PlainBall {
  struct alignas(64) Block {
    LaneInts row_a, row_b;
    PointLanes point;
  };

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodies& bodies,
                      const JointPlacement& at, Block& block) {
    V3 impulse;
    F unused;
    load_impulses(args, joint, 0, impulse.x, impulse.y, impulse.z, unused);
    prepare_point(args, joint, bodies, at, impulse, block.point);
  }
  static void warm_start(const Block& block, JointBodies& bodies) { warm_start_point(block.point, bodies); }
  static void solve(const JointArgs& args, Block& block, JointBodies& bodies) {
    const F keep(args.impulse_keep);
    turn_point(block.point, bodies, keep);
    solve_point(block.point, bodies, load_softness(block.point.held), keep);
  }
  static F relax(const JointArgs&, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodies& bodies) {
    move_point(block.point, delta_a, delta_b, bodies);
    return relax_point(block.point, bodies);
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const V3 none{F(0.0f), F(0.0f), F(0.0f)};
    V3 impulse = load3(block.point.impulse);
    impulse = select(is_finite(impulse), impulse, none);  // a broken one would break its bodies again
    store_impulses(args, joint, count, 0, impulse.x, impulse.y, impulse.z, F(0.0f));
    store_reaction(args, joint, count, impulse, none);
  }
};

}  // namespace

void add_ball_kernels(JointKernels& kernels) {
  kernels.variant[joint_variant(0, false)] = make_joint_kernels_of<PlainBall>();
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
