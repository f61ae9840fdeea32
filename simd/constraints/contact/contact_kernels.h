// Kernels over contact blocks: prepare, rebound, warm start, solve, relax, store, and those of sequential
// impulses. A lane is one manifold.
//
// The form is constraint space: a manifold's points are two coordinates each in the tangent plane through the
// friction center, so that one sweep needs the two bodies once and the points' couplings as a small matrix.
// Run by parallel/solvers/solve.cpp, color after color; blocks of one color touch no dynamic body twice.
#pragma once

#include <core/plain/constraint_row.h>
#include <core/plain/manifold.h>
#include <core/plain/rows.h>
#include <simd/constraints/constraint_chunk.h>
#include <simd/constraints/softness.h>

#include <cstddef>

namespace scree::simd {

// Blocks come in variants: how many points a lane has room for, whether the rare surface terms are there, and
// whether body A can be pushed.
inline constexpr int kPointBuckets = 3;  // 1, 2 and 4 points
inline constexpr int kContactVariants = kPointBuckets * 2 * 2;
inline constexpr int contact_variant(int bucket, bool rich, bool is_static) {
  return (bucket * 2 + (rich ? 1 : 0)) * 2 + (is_static ? 1 : 0);
}
inline constexpr int bucket_of(int contact_variant) { return contact_variant / 4; }
inline constexpr bool is_rich(int contact_variant) { return contact_variant / 2 % 2 != 0; }

// Floats of each lane in force_sum, beginning with the normal impulses.
inline constexpr int kFrictionField = kMaxManifoldPoints;
inline constexpr int kTwistField = kFrictionField + 2;
inline constexpr int kRollingField = kTwistField + 1;
inline constexpr int kForceFields = kRollingField + 3;

inline constexpr float kNoImpact = 3e38f;  // s
// s, from the substep's beginning: of the two earliest impacts of a body, or kNoImpact.
struct ImpactTimes {
  float first, second;
};
// What impacts a chunk has.
enum ImpactState : std::uint8_t { kNoImpacts, kImpactsFound, kImpactsChange, kImpactsStay };

struct ContactArgs {
  const std::int32_t* rows;  // contact rows in lane order; unused lanes repeat a used one
  char* blocks;
  Manifold* manifolds;
  ContactSurface* surfaces;
  VelocityRow* velocity;
  VelocityRow* free_velocity;  // without the impulses of the step so far; takes part in rebounds
  DeltaRow* delta;
  const MotionRow* motion;
  const InertiaRow* inertia;
  std::uint8_t* step_notes;   // by body; prepare marks those that it finds, any thread may
  SoftConstants soft;         // between dynamic bodies
  SoftConstants soft_static;  // against bodies that cannot be pushed
  float gravity[3];           // m/s^2
  float substep;              // s
  float inverse_substep;      // 1/s
  float push_speed;           // m/s
  float restitution_threshold;
  float slop;                 // m, overlap that sequential impulses leave alone
  float warm_start_scale;     // times the stored impulses: ratio of time steps, 0: none
  float impulse_keep;         // times the impulses at each solve: 1, or 0 without warm start
  float* residual;            // m/s, by chunk number; where relax_measured leaves its largest error
  float* impulse_sum;         // N s, by lane: normal impulses of all substeps and points; null: not asked for
  std::uint8_t* impacts;      // ImpactState by chunk number, of those of a rich variant
  ImpactTimes* impact_times;  // by body
  bool first_sweep;           // over these impacts
  const VelocityRow* velocity_before;  // before the impacts of the substep
  bool first_substep;
  float* force_sum;  // N s and N m s, impulses of all substeps, see contact_forces.h; null: not asked for
  ContactForceRow* forces;  // by contact row; where store_forces leaves these sums
  const PoseRow* pose;
  float* depth;  // m, by lane; where measure_depth leaves the deepest point's overlap, at least 0
};

struct ContactKernels {
  std::size_t block_bytes[kContactVariants];
  void (*prepare)(const ContactArgs& args, const ConstraintChunk& chunk);     // manifolds -> blocks
  void (*warm_start)(const ContactArgs& args, const ConstraintChunk& chunk);  // stored impulses -> velocity
  void (*solve)(const ContactArgs& args, const ConstraintChunk& chunk);       // normals with soft bias
  void (*relax)(const ContactArgs& args, const ConstraintChunk& chunk);       // normals, friction; no bias
  void (*relax_measured)(const ContactArgs& args, const ConstraintChunk& chunk);
  // The same with the normal impulses of a contact solved together; this relax always measures.
  void (*solve_together)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*relax_together)(const ContactArgs& args, const ConstraintChunk& chunk);
  // Sequential impulses: biases of a step, and an iteration, see contact_sequential.cpp.
  void (*begin_impulses)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*sweep_impulses)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*sweep_impulses_together)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*find_separations)(const ContactArgs& args, const ConstraintChunk& chunk);  // at the present poses
  // Restitution, of rich variants only: which contacts meet and when; normal impulses, and friction, of those
  // that act in this pass; their bodies' ways until then. See contact_rebound.cpp.
  void (*find_impacts)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*push_impacts)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*rub_impacts)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*finish_impacts)(const ContactArgs& args, const ConstraintChunk& chunk);
  void (*store)(const ContactArgs& args, const ConstraintChunk& chunk);         // blocks -> manifolds
  void (*store_forces)(const ContactArgs& args, const ConstraintChunk& chunk);  // force_sum -> forces
  void (*measure_depth)(const ContactArgs& args, const ConstraintChunk& chunk);
  // What the contacts are, for solvers of any kind: rows at the present poses, by lane; needs no blocks. Of
  // the arguments it reads `rows`, `manifolds`, `surfaces` and `delta`.
  void (*state_rows)(const ContactArgs& args, const ConstraintChunk& chunk, ConstraintRows* rows);
};

}  // namespace scree::simd
