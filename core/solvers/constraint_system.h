// The constraints of a world as one system of equations and inequalities, for solvers that look at all of it.
//
// With the rows J of all constraints, the masses M, the velocities u that bodies have without constraints and
// the impulses p of the rows, velocities are u + M^-1 J^T p, and the rows ask of their speeds
//
//   w = A p + b,   A = J M^-1 J^T + C,   b = J u - target + bias
//
// with the compliance C of what is soft. Each p lies between its bounds; w is 0 where p
// lies between them, not negative at the lower bound and not positive at the upper one. Friction bounds the
// length of p in a plane or in space by a multiple of normal impulses, and w then opposes p (Coulomb's law).
// Without friction this is a mixed linear complementarity problem (Cottle, Pang and Stone, "The Linear
// Complementarity Problem", 1992; Stewart and Trinkle, "An Implicit Time-Stepping Scheme for Rigid Body
// Dynamics with Inelastic Collisions and Coulomb Friction", 1996).
//
// Slow and in double precision: for verification, comparison and teaching. The step's own solver uses nothing
// of this folder.
#pragma once

#include <core/plain/constraint_row.h>
#include <core/plain/rows.h>

#include <Eigen/SparseCore>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// The rows of a constraint and the bodies that it acts on, as indices into a list of bodies.
struct StatedConstraint {
  ConstraintRows rows;
  std::int32_t body_a, body_b;
};

// A body as the system sees it: inverse mass and inertia in world axes, and u.
struct SystemBody {
  InertiaRow inverse;
  VelocityRow velocity;
};

// How errors and stiffness become biases and compliances.
struct SystemPolicy {
  // solve: soft constraints push their errors apart, friction rests. relax: what is as stiff as it can be is
  // rigid and without bias, as in the soft step. rigid: the same with Baumgarte's bias.
  enum class Pass { solve, relax, rigid };
  Pass pass = Pass::solve;
  bool stored_has_acted = false;  // the bodies' velocities hold the stored impulses already
  double substep = 1.0 / 240;     // s
  double push_speed = 3;          // m/s, largest bias of limits and contacts
  double max_hertz = 60;          // Hz, of springs
  double joint_hertz = 60;        // Hz and damping ratio of what joints hold as stiffly as possible
  double joint_damping_ratio = 2;
  double contact_hertz = 30;  // Hz and damping ratio of contacts between bodies that can be pushed ...
  double contact_damping_ratio = 10;
  double static_contact_hertz = 60;  // ... and against others
  double static_contact_damping_ratio = 5;
  double baumgarte = 0.2;  // of rigid: the share of errors that goes in a substep, but for
  double slop = 0.005;     // m of overlap
};

// Rows [first, first + count) of the system that are bounded together.
struct SystemBlock {
  int first, count;
  bool bounds_length;  // the length of their impulses; else each row on its own
};

using SystemMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

struct ConstraintSystem {
  int bodies = 0;
  bool stored_has_acted = false;  // see SystemPolicy
  SystemMatrix jacobian;          // J, rows x 6 bodies: v, w of each body
  SystemMatrix push;              // J M^-1
  SystemMatrix matrix;            // A
  Eigen::VectorXd free_speed;     // b, m/s or rad/s
  SystemMatrix compliance;        // C
  Eigen::VectorXd lower, upper;   // N s or N m s; of blocks that bound lengths, `upper` is the radius
  SystemMatrix bound_by;          // upper grows by this times p, and lower shrinks
  Eigen::VectorXd stored;         // p of the last substep, a guess to start from
  std::vector<SystemBlock> blocks;
  std::vector<std::int32_t> constraint, slot;  // of each row, where it comes from

  int rows() const { return static_cast<int>(free_speed.size()); }
};

// Rows that are empty or idle in the pass are left out.
ConstraintSystem assemble(std::span<const SystemBody> bodies, std::span<const StatedConstraint> constraints,
                          const SystemPolicy& policy);

// What the rows' bounds make of impulses: the nearest ones within, with `p` for the normal impulses that
// bound friction.
Eigen::VectorXd project(const ConstraintSystem& system, const Eigen::VectorXd& p,
                        const Eigen::VectorXd& impulses);

// m/s or rad/s: the largest change of speed that any row still asks for, alone. 0 at a solution. Of a row
// with the response A_ii it is A_ii |p - project(p - w / A_ii)|.
double residual(const ConstraintSystem& system, const Eigen::VectorXd& p);

// The same of the stored impulses, of bodies whose velocities include what these have done. The system must
// have been assembled without SystemPolicy::stored_has_acted. What a row asks for depends on its constraint
// and two bodies alone, down to the last bit.
double residual_of_stored(const ConstraintSystem& system);

// Velocities after the impulses p: six numbers a body.
Eigen::VectorXd velocities(const ConstraintSystem& system, std::span<const SystemBody> bodies,
                           const Eigen::VectorXd& p);

}  // namespace scree
