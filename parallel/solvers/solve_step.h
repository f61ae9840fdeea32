// What the solvers of a step share: arguments of kernels, and passes over bodies and colors.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>
#include <parallel/distributed/border.h>

#include <span>

namespace scree {

// A step that is being solved. Written by the solvers: `elapsed` and `first_substep` of the arguments.
struct SolveStep {
  WorldData& data;
  Constraints& constraints;
  Crew& crew;
  int dynamic_count, moving_count;  // of Constraints::moving_bodies, dynamic ones first
  simd::BodyArgs body;
  simd::ContactArgs contact;
  simd::JointArgs joint;
  bool may_rebound = false;  // some contact may have restitution
};

// After pack_blocks(): inertia into world axes, blocks from manifolds.
SolveStep prepare_solve(WorldData& data, float dt, Crew& crew);

// The solvers, each in the file of its name. Bodies and blocks are prepared.
void solve_soft_step(SolveStep& step);
void solve_sequential_impulses(SolveStep& step);
void solve_whole_system(SolveStep& step);

// What is left of the rows of all constraints, at velocities that hold the blocks' impulses: stores these.
double residual_of_rows(SolveStep& step);

// Restitution, before a substep, and what it needs once a step.
void begin_rebounds(SolveStep& step);
void rebound(SolveStep& step);

inline constexpr int kSolveBodyChunk = 256;  // bodies of one task

// `name`: of the zones, see scree/zones.h.
template <class Kernel>
void over_bodies(const SolveStep& step, int count, Kernel kernel, const char* name) {
  step.crew.run_ranges(
      count, kSolveBodyChunk, [&](int begin, int end, int) { kernel(step.body, begin, end); }, name);
}

// One stage. Where one thread runs it, joints come first, so that contacts have the last word.
template <class ContactWork, class JointWork>
void over_stage(const SolveStep& step, const ColorStage& stage, ContactWork&& contact_work,
                JointWork&& joint_work, const char* name) {
  const simd::ConstraintChunk* contacts = step.constraints.contact_chunks.data() + stage.first_contact_chunk;
  const simd::ConstraintChunk* joints = step.constraints.joint_chunks.data() + stage.first_joint_chunk;
  const auto run_chunk = [&](int chunk) {
    if (chunk < stage.joint_chunk_count) {
      joint_work(joints[chunk]);
    } else {
      contact_work(contacts[chunk - stage.joint_chunk_count]);
    }
  };
  const int chunks = stage.joint_chunk_count + stage.contact_chunk_count;
  if (stage.serial) {
    step.crew.run_alone(chunks, run_chunk, name);
  } else {
    const std::int32_t* order =
        step.constraints.chunk_order.data() + stage.first_joint_chunk + stage.first_contact_chunk;
    step.crew.run(
        chunks, [&](int chunk, int) { run_chunk(order[chunk]); }, name);
  }
}

using ContactPass = void (*simd::ContactKernels::*)(const simd::ContactArgs&, const simd::ConstraintChunk&);
using JointPass = void (*simd::JointVariantKernels::*)(const simd::JointArgs&, const simd::ConstraintChunk&);

inline void over_stage(const SolveStep& step, const ColorStage& stage, ContactPass contact_pass,
                       JointPass joint_pass, const char* name) {
  const simd::Kernels& kernels = step.crew.kernels();
  over_stage(
      step, stage,
      [&](const simd::ConstraintChunk& chunk) { (kernels.contact.*contact_pass)(step.contact, chunk); },
      [&](const simd::ConstraintChunk& chunk) {
        (kernels.joint.variant[chunk.variant].*joint_pass)(step.joint, chunk);
      },
      name);
}

inline void over_colors(const SolveStep& step, ContactPass contact_pass, JointPass joint_pass,
                        const char* name) {
  RefreshedPass pass(border_of(step.data), step.data.bodies, Refreshed::velocity);
  for (const ColorStage& stage : step.constraints.stages) {
    pass.before(stage.turn);
    over_stage(step, stage, contact_pass, joint_pass, name);
  }
  pass.finish();
}

}  // namespace scree
