// Kernels over bodies: prepare, integrate, finish. A lane is one body of a list.
//
// Called by parallel/solvers/solve.cpp and parallel/bodies/finish_step.cpp.
#pragma once

#include <core/plain/rows.h>

namespace scree::simd {

// What all body kernels read; pointers are columns of Bodies.
struct BodyArgs {
  const std::int32_t* list;  // bodies in lane order, padded so that kLanes may be read past the end
  PoseRow* pose;
  VelocityRow* velocity;
  VelocityRow* free_velocity;
  const VelocityRow* velocity_before;  // before the impacts of the substep
  DeltaRow* delta;
  InertiaRow* inertia;
  const InertiaRow* local_mass;
  const LocalInertiaRow* local_inertia;
  const MotionRow* motion;
  std::uint8_t* step_notes;  // StepNote
  const std::uint8_t* flags;
  std::uint8_t may_sleep;  // the flag of bodies that may sleep; 0: none may
  const ForceRow* force;
  const float* center;  // Vec3 rows: center of mass in the body's frame
  float* transform;     // Pose rows
  float* sleep_timer;   // s
  DriftRow* drift;
  const float* mass;         // kg
  float* kinetic_energy;     // J, by place in the list
  std::uint8_t* non_finite;  // by place in the list: 1 where the state became non-finite and was restored
  float gravity[3];
  float substep;  // s
  float step;     // s
  float elapsed;  // s, of the step before this substep
  float max_linear_speed;
  float max_angular_speed;
  float sleep_time;  // s, that a timer runs to
  float sleep_linear_speed;
  float sleep_angular_speed;
  bool first_substep;
  bool warm_start;
  bool flies_on_parabolas;  // bodies on which no impulse acts; else semi-implicit Euler moves them all
};

// All of them work on list[begin .. end).
struct BodyKernels {
  void (*prepare)(const BodyArgs& args, int begin, int end);  // pose -> inertia, delta; clears step_notes
  void (*integrate_velocities)(const BodyArgs& args, int begin, int end);  // force -> velocity, free_velocity
  void (*integrate_poses)(const BodyArgs& args, int begin,
                          int end);  // velocity -> delta, velocity (gyroscopic)
  void (*finish)(const BodyArgs& args, int begin,
                 int end);  // delta -> pose, transform, drift, sleep_time, energy
};

}  // namespace scree::simd
