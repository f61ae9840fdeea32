// Kernels over joint blocks: prepare, warm start, solve, relax, store. A lane is one joint.
//
// Run by parallel/solvers/solve.cpp in the colors that joints share with contacts. In a substep
//
//   solve   works at the poses of the last relax with the velocities after gravity, holding with soft bias
//   relax   after the poses have moved: turns arms and axes, measures the errors, and solves without bias;
//           drives act in both
//
// The velocities that a substep inherits hold the impulses of the last one as they acted, J^T lambda. As the
// bodies have turned since, they should act as J'^T lambda: relax notes the difference, and the next solve
// applies it first.
#pragma once

#include <core/plain/constraint_row.h>
#include <core/plain/joint.h>
#include <core/plain/rows.h>
#include <scree/joint_type.h>
#include <simd/constraints/constraint_chunk.h>
#include <simd/constraints/softness.h>

#include <cstddef>
#include <cstdint>

namespace scree::simd {

// Of each kind there are two variants: plain joints have neither limits nor drives.
inline constexpr int kJointVariants = kJointTypeCount * 2;
inline constexpr int joint_variant(JointType type, bool rich) {
  return static_cast<int>(type) * 2 + (rich ? 1 : 0);
}

inline constexpr int kRememberedCoordinate = 15;  // see JointImpulses

struct JointArgs {
  const std::int32_t* rows;  // joint rows in lane order; unused lanes repeat a used one
  char* blocks;
  const JointFrames* frames;
  const JointParameters* parameters;
  const std::int32_t* user;  // by joint row: where the numbers of a user joint stand in the columns below
  const std::uint32_t* user_state;
  const UserJacobians* user_jacobians;
  const UserTargets* user_targets;
  const UserBounds* user_bounds;
  JointImpulses* impulses;
  JointReactionRow* reactions;
  const PoseRow* pose;  // at the step's beginning
  VelocityRow* velocity;
  const DeltaRow* delta;
  const std::int32_t*
      joint_count;             // by body that can be pushed: how many joints it has with other such bodies
  const InertiaRow* inertia;   // turns with bodies that are no part of a contact
  SoftConstants stiff;         // of what is held as stiffly as the step allows
  SoftConstants stiff_shared;  // the same at bodies that are shared, see joint_shares.h
  float substep;               // s
  float inverse_substep;       // 1/s
  float elapsed;               // s, since the step began, at the present poses: of solve, or of relax
  float max_hertz;             // Hz, of what is held and of springs
  float max_hertz_shared;      // the same at bodies that are shared; below max_hertz
  float push_speed;            // m/s, rad/s: largest speed at which a limit that was passed is restored
  float warm_start_scale;      // times the stored impulses: ratio of time steps, 0: none
  float impulse_keep;          // times the impulses at each solve: 1, or 0 without warm start
  float *parts_a, *parts_b;    // by lane; how many parts the joints' bodies have, see joint_shares.h
  std::uint8_t* shared;        // by chunk number; whether prepare has divided any body of the chunk
  float* residual;             // m/s, by chunk number; where relax_measured leaves its largest error
};

// The functions that work on chunks of one variant.
struct JointVariantKernels {
  std::size_t block_bytes;
  // Whether impulse kRememberedCoordinate of a joint is the error of its first held row, not an impulse.
  bool remembers;
  void (*prepare)(const JointArgs& args, const ConstraintChunk& chunk);     // rows -> blocks
  void (*warm_start)(const JointArgs& args, const ConstraintChunk& chunk);  // stored impulses -> velocity
  void (*solve)(const JointArgs& args, const ConstraintChunk& chunk);
  void (*relax)(const JointArgs& args, const ConstraintChunk& chunk);
  void (*relax_measured)(const JointArgs& args, const ConstraintChunk& chunk);
  void (*store)(const JointArgs& args, const ConstraintChunk& chunk);  // blocks -> impulses, reactions
  // Of chunks with `peaks`, after solve: relax does it by itself.
  void (*note_peaks)(const JointArgs& args, const ConstraintChunk& chunk);
  // What the joints are, for solvers of any kind: rows at the present poses, by lane; needs no blocks. Of the
  // arguments it reads `rows`, `frames`, `parameters`, the columns of user joints, `impulses`, `elapsed` and
  // the columns of bodies.
  void (*state_rows)(const JointArgs& args, const ConstraintChunk& chunk, ConstraintRows* rows);
};

struct JointKernels {
  JointVariantKernels variant[kJointVariants];
};

}  // namespace scree::simd
