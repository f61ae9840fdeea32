// Which method solves a world's constraints, and how it is tuned. See WorldSettings::solver.
#pragma once

#include <scree/export.h>

#include <cstdint>

namespace scree {

/// Methods for the constraints of a step. All give the same bits for every thread count and instruction set.
///
/// The first two are wide kernels that work on the colors of constraints in parallel. The others assemble one
/// system of all rows, in double precision, and solve it on one thread: slow, for comparison, verification
/// and pre-rendered work. core/solvers/README.md says of each which equation it solves, and when to choose
/// it.
enum class Solver : std::uint8_t {
  soft_step,             ///< soft constraints over substeps, each followed by a pass without bias
  sequential_impulse,    ///< velocity iterations of one step, with Baumgarte's bias
  jacobi,                ///< all rows at once, each from the same impulses
  gauss_seidel,          ///< row after row: projected Gauss-Seidel
  over_relaxation,       ///< the same with longer steps
  conjugate_gradient,    ///< nonsmooth and nonlinear: sweeps of Gauss-Seidel, accelerated
  accelerated_gradient,  ///< Nesterov's projected gradient with restarts
  direct,                ///< exact: a sparse factorization, with bounds a nonsmooth Newton method
};
/// The number of methods.
inline constexpr int kSolverCount = 8;

/// As the enumerator is called: "soft_step". "unknown" for what is none.
SCREE_API const char* solver_name(Solver solver);

/// Tuning of solvers. soft_step uses `points_together` alone.
struct SolverOptions {
  /// In [1, 1e6]. sequential_impulse: velocity iterations of a step, all of which are done. Iterative methods
  /// over the whole system: the most of a substep. direct: not used.
  int iterations = 10;
  /// m/s or rad/s, in [0, 1]: methods over the whole system end when no row asks for a larger change of its
  /// speed.
  float tolerance = 1e-6f;
  /// In [0, 2): times a step of jacobi and over_relaxation. 0: for jacobi as much as surely converges, for
  /// over_relaxation 1.3.
  float relaxation = 0.0f;
  /// Baumgarte's factor, in [0, 1]: the share of an error that a substep takes away through its velocities.
  float baumgarte = 0.2f;
  /// m, in [0, 1e3]: overlap that contacts leave alone.
  float slop = 0.005f;
  /// sequential_impulse: 0 keeps the order of colors; others shuffle it once a step, by this and the number
  /// of the step.
  std::uint32_t shuffle_seed = 0;
  /// soft_step and sequential_impulse: the normal impulses of a contact are solved together (a linear
  /// complementarity problem of up to 4 points), not one after the other.
  bool points_together = false;

  friend bool operator==(const SolverOptions&, const SolverOptions&) = default;
};

}  // namespace scree
