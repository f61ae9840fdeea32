// Rows of constraints, as every kind of joint and every contact states them for any solver: what is measured,
// and nothing of how it is solved. Plain memory that knows nothing of lanes or instruction sets; written by
// the state_rows kernels of simd/constraints, see simd/constraints/README.md.
//
// A row is an equation or an inequality C(x) = 0, C(x) >= 0 of the poses of two bodies. Its Jacobian J turns
// their velocities into the rate of C,
//
//   J v = linear_a . v_a + angular_a . w_a + linear_b . v_b + angular_b . w_b
//
// and an impulse along the row changes them by M^-1 J^T times the impulse (Catto, "Iterative Dynamics with
// Temporal Coherence", GDC 2005).
#pragma once

#include <cstdint>

namespace scree {

enum ConstraintRowKind : std::uint32_t {
  kRowNone,      // the slot is empty, and the rest of it means nothing
  kRowHeld,      // C = 0. C's rate is J v - target_speed, which is 0 except in rows of users
  kRowLimit,     // C >= 0, the distance from the nearer end; C = 0 where `lower` is below 0, as both ends are
                 // one. C's rate is as above; `upper` is infinite except in rows of users
  kRowMotor,     // J v = target_speed
  kRowSpring,    // a spring on C and a damper on J v - target_speed
  kRowContact,   // C >= 0, the separation of a contact point
  kRowTwist,     // friction: J v = target_speed about the normal
  kRowFriction,  // friction: as above, along a tangent
  kRowRolling,   // as above, of a component of the relative spin
};

enum ConstraintRowFlag : std::uint32_t {
  // The force of the row's block is bounded by its length, a disk or a ball of radius `upper`; not row by
  // row.
  kRowBoundsLength = 1 << 0,
  // The row is solved as if what its joint holds were held meanwhile; its hertz are those of what is free
  // then.
  kRowKeepsHeld = 1 << 1,
  // A limit of an angle that has one end alone, which is come to from behind, too.
  kRowOneEndOfCircle = 1 << 2,
};

// In groups of 16 bytes, as kernels store them.
struct alignas(16) ConstraintRow {
  float linear_a[3];
  float error;  // C; m or rad. Of a spring: how far it is ahead of its target now
  float angular_a[3];
  float target_speed;  // m/s or rad/s
  float linear_b[3];
  float lower;  // N or N m: least and largest force along the row
  float angular_b[3];
  float upper;
  float hertz;               // Hz; 0: as stiff as the solver can, and no spring at all
  float damping_ratio;       // of the spring
  float reference_response;  // 1/kg: J M^-1 J^T for which hertz are meant; 0: the row's own
  float impulse;             // N s or N m s, of the last substep: a guess to start from
  float bound_by[4];    // `upper` grows by this times the force of the constraint's rows 0 to 3, -`lower` too
  std::uint32_t kind;   // ConstraintRowKind
  std::uint32_t block;  // rows of a constraint with the same number are solved as one
  std::uint32_t flags;  // ConstraintRowFlag
  float padding;
};

// Of one constraint, in the order in which the solver of this engine takes them.
inline constexpr int kMaxConstraintRows = 12;
struct ConstraintRows {
  ConstraintRow row[kMaxConstraintRows];
};

}  // namespace scree
