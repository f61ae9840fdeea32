// Solvers of a whole ConstraintSystem: what the fast solver is compared with. README.md says for each which
// equation it solves, from which source, and when to choose it.
#pragma once

#include <core/solvers/constraint_system.h>

#include <vector>

namespace scree {

enum class ReferenceMethod {
  jacobi,                // all rows at once, each from the same impulses
  gauss_seidel,          // row after row (projected Gauss-Seidel)
  over_relaxation,       // the same with steps times `relaxation`
  conjugate_gradient,    // nonsmooth, nonlinear: sweeps of Gauss-Seidel, accelerated
  accelerated_gradient,  // Nesterov's, projected, at fixed bounds of friction that follow
  direct,                // nonsmooth Newton; of equalities alone, one factorization
};

struct ReferenceOptions {
  ReferenceMethod method = ReferenceMethod::gauss_seidel;
  int max_iterations = 1000;
  double tolerance = 1e-9;  // m/s or rad/s, of residual()
  // Of jacobi in (0, 2), 0: as much as surely converges. Of over_relaxation in (0, 2).
  double relaxation = 0;
  bool warm_start = false;  // begin with the stored impulses, else with none
};

struct ReferenceSolution {
  Eigen::VectorXd impulses;
  int iterations = 0;
  double residual = 0;          // of the impulses
  std::vector<double> history;  // residual before the first and after each iteration
  bool is_singular = false;     // direct: rows contradict each other, and the residual stays
};

// The best impulses that were met; never NaN for a system that is finite.
ReferenceSolution solve(const ConstraintSystem& system, const ReferenceOptions& options);

// What the methods share. In the files of their names.
void sweep(const ConstraintSystem& system, double relaxation, Eigen::VectorXd& p);
ReferenceSolution solve_direct(const ConstraintSystem& system, const ReferenceOptions& options);
// Whether rows contradict each other by more than the tolerance, m/s or rad/s; p are the best impulses found.
bool rows_contradict(const ConstraintSystem& system, const Eigen::VectorXd& p, double tolerance);

}  // namespace scree
