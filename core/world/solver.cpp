// Names of solvers.
#include <scree/solver.h>

namespace scree {

const char* solver_name(Solver solver) {
  constexpr const char* kNames[kSolverCount] = {
      "soft_step",          "sequential_impulse",   "jacobi", "gauss_seidel", "over_relaxation",
      "conjugate_gradient", "accelerated_gradient", "direct"};
  const auto index = static_cast<int>(solver);
  return index < kSolverCount ? kNames[index] : "unknown";
}

}  // namespace scree
