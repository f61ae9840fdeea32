// Contact with Coulomb's friction at each point, as the literature compares its solvers on it: the form in
// which the collection FCLIB keeps problems (Acary, Bremond, Koziara, Perignon, "FCLIB: a collection of
// discrete 3D frictional contact problems", 2014).
//
// With three impulses r and three speeds u a point, the normal first, and the impulses l of what joints hold,
//
//   u = W r + V l + q,   0 = V^T r + R l + s,
//   K* contains (u_n + mu |u_t|, u_t), square to r in K = { |r_t| <= mu r_n }
//
// at every point. This states and solves it; Scree's own contacts share the friction of their points at one
// center, see README.md. No framework shows here: tools read it, too.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

struct StatedConstraint;
struct SystemBody;
struct SystemPolicy;

// A sparse matrix in compressed columns: column c has the entries [start[c], start[c + 1]), by ascending row.
struct SparseColumns {
  int rows = 0, columns = 0;
  std::vector<int> start{0};
  std::vector<int> row;
  std::vector<double> value;
};

struct ContactProblem {
  SparseColumns response;          // W, 1/kg; symmetric, positive semi-definite
  SparseColumns coupling;          // V
  SparseColumns held_response;     // R
  std::vector<double> free_speed;  // q, m/s, with the bias of separations
  std::vector<double> held_speed;  // s, m/s or rad/s
  std::vector<double> friction;    // mu of each point
  std::vector<int> constraint;     // of each point: its place in the list that it was stated from
  std::vector<int> slot;           // ... and its slot there
  double substep = 0;              // s

  int points() const { return static_cast<int>(friction.size()); }
  int held() const { return static_cast<int>(held_speed.size()); }
};

// From stated rows: three rows at each point of a contact, where the manifold has it, and what joints hold
// rigidly. Throws Error for rows that the form has no place for, with their kinds and numbers: limits,
// motors, springs, held rows that give way, rolling resistance. The twist of contacts is left out: points
// away from each other resist it by themselves.
ContactProblem contact_problem(std::span<const SystemBody> bodies,
                               std::span<const StatedConstraint> constraints, const SystemPolicy& policy);

struct ContactSolution {
  std::vector<double> impulses;       // r, N s
  std::vector<double> held_impulses;  // l, N s or N m s
  std::vector<double> speeds;         // u, m/s
  int iterations = 0;
  double residual = 0;       // m/s: see residual() of constraint_system.h
  double natural_error = 0;  // see natural_map_error
  double held_error = 0;     // m/s or rad/s: the largest speed of what is held
};

// By the direct solver; the best impulses that it met.
ContactSolution solve_contact_problem(const ContactProblem& problem, int max_iterations, double tolerance);

// u = W r + V l + q.
std::vector<double> speeds_of(const ContactProblem& problem, std::span<const double> impulses,
                              std::span<const double> held_impulses);

// |r - P_K(r - (u + mu |u_t| n))| over all points, by |q|: the residual of the natural map, as Siconos has it
// (Acary, Bremond, Huber, "On solving contact problems with Coulomb friction: formulations and numerical
// comparisons", 2018). 0 at a solution and nowhere else.
double natural_map_error(const ContactProblem& problem, std::span<const double> impulses,
                         std::span<const double> speeds);

}  // namespace scree
