// The direct method: impulses to the last digits. See reference_solvers.h and README.md.
//
// Of equalities alone, A p = -b by a sparse factorization L D L^T. With bounds, Newton's method for
//
//   F(p) = p - project(p - w / R) = 0
//
// with R the largest response of a row's block: where a bound acts the row of the matrix is that bound, where
// none does it is A / R, and where friction slides it is the derivative of a point on a circle whose radius
// follows the normal impulses (Alart and Curnier, "A mixed formulation for frictional contact problems prone
// to Newton like solution methods", 1991). A step that does not bring F closer to zero is shortened; where
// that does not help, the bounds of friction rest for a while, and then sweeps of Gauss-Seidel choose other
// rows that are bounded.
#include <core/solvers/reference_solvers.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree {

namespace {

// Of the diagonal: what is added to it, so that rows which say the same twice share their impulse. F itself
// is exact, so that this costs iterations, no digits.
constexpr double kShare = 1e-9;

using Triplets = std::vector<Eigen::Triplet<double>>;

bool has_bounds(const ConstraintSystem& system) {
  for (const SystemBlock& block : system.blocks) {
    if (block.bounds_length || std::isfinite(system.lower[block.first]) ||
        std::isfinite(system.upper[block.first])) {
      return true;
    }
  }
  return false;
}

ReferenceSolution solve_equalities(const ConstraintSystem& system, const ReferenceOptions& options) {
  ReferenceSolution solution;
  solution.impulses = Eigen::VectorXd::Zero(system.rows());
  Eigen::SparseMatrix<double> matrix = system.matrix;
  const Eigen::VectorXd diagonal = system.matrix.diagonal();
  for (int row = 0; row < system.rows(); ++row)
    matrix.coeffRef(row, row) += diagonal[row] > 0 ? kShare * diagonal[row] : 1;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(matrix);
  solution.residual = residual(system, solution.impulses);
  solution.history.push_back(solution.residual);
  // Iterative refinement takes away what was added to the diagonal.
  while (factors.info() == Eigen::Success && solution.iterations < options.max_iterations &&
         solution.residual > options.tolerance) {
    const Eigen::VectorXd better =
        solution.impulses -
        factors.solve(Eigen::VectorXd(system.matrix * solution.impulses + system.free_speed));
    const double left = residual(system, better);
    ++solution.iterations;
    if (!(left < 0.9 * solution.residual)) {
      if (left < solution.residual) {
        solution.impulses = better;
        solution.residual = left;
        solution.history.push_back(left);
      }
      break;
    }
    solution.impulses = better;
    solution.residual = left;
    solution.history.push_back(left);
  }
  solution.is_singular = solution.residual > options.tolerance;
  return solution;
}

// F, and its derivative by p.
class Newton {
 public:
  explicit Newton(const ConstraintSystem& system) : system_(system), response_(system.rows()) {
    const Eigen::VectorXd diagonal = system.matrix.diagonal();
    for (const SystemBlock& block : system.blocks) {
      const double largest = diagonal.segment(block.first, block.count).maxCoeff();
      response_.segment(block.first, block.count).setConstant(largest > 0 ? largest : 1);
    }
  }

  // In speeds, so that light and heavy bodies count alike.
  double merit(const Eigen::VectorXd& p) const { return difference(p).cwiseProduct(response_).norm(); }

  Eigen::VectorXd difference(const Eigen::VectorXd& p) const { return p - project(system_, p, target(p)); }

  // The step of Newton's method, drawn to p by `share` of the diagonal of free rows; empty where the matrix
  // has no inverse.
  Eigen::VectorXd step(const Eigen::VectorXd& p, double share) const;

 private:
  Eigen::VectorXd target(const Eigen::VectorXd& p) const {
    return p - (system_.matrix * p + system_.free_speed).cwiseQuotient(response_);
  }
  void add_free_row(int row, double scale, Triplets& to) const {
    for (SystemMatrix::InnerIterator it(system_.matrix, row); it; ++it)
      to.emplace_back(row, it.col(), scale * it.value() / response_[row]);
  }
  void add_bound_row(int row, double sign, Triplets& to) const {
    to.emplace_back(row, row, 1);
    for (SystemMatrix::InnerIterator it(system_.bound_by, row); it; ++it)
      to.emplace_back(row, it.col(), sign * it.value());
  }
  void add_sliding(const SystemBlock& block, const Eigen::VectorXd& towards, double radius,
                   Triplets& to) const;

  const ConstraintSystem& system_;
  Eigen::VectorXd response_;
};

// p = radius n with n = t / |t| and t = p - w / R: (1 - S) dp + S A dp / R - n dradius, S = radius / |t| (1 -
// n n^T).
void Newton::add_sliding(const SystemBlock& block, const Eigen::VectorXd& towards, double radius,
                         Triplets& to) const {
  const double length = towards.norm(), share = radius / length;
  const Eigen::VectorXd n = towards / length;
  for (int i = 0; i < block.count; ++i) {
    const int row = block.first + i;
    to.emplace_back(row, row, 1);
    for (SystemMatrix::InnerIterator it(system_.bound_by, block.first); it; ++it)
      to.emplace_back(row, it.col(), -n[i] * it.value());
    for (int k = 0; k < block.count; ++k) {
      const double s = share * ((i == k ? 1.0 : 0.0) - n[i] * n[k]);
      const int other = block.first + k;
      to.emplace_back(row, other, -s);
      for (SystemMatrix::InnerIterator it(system_.matrix, other); it; ++it)
        to.emplace_back(row, it.col(), s * it.value() / response_[other]);
    }
  }
}

Eigen::VectorXd Newton::step(const Eigen::VectorXd& p, double share) const {
  const Eigen::VectorXd towards = target(p), more = system_.bound_by * p;
  Triplets triplets;
  for (const SystemBlock& block : system_.blocks) {
    const int row = block.first;
    if (block.bounds_length) {
      const double radius = std::max(system_.upper[row] + more[row], 0.0);
      const Eigen::VectorXd t = towards.segment(row, block.count);
      if (t.norm() > radius) {
        add_sliding(block, t, radius, triplets);
        continue;
      }
    } else if (towards[row] < system_.lower[row] - more[row]) {
      add_bound_row(row, 1, triplets);
      continue;
    } else if (towards[row] > system_.upper[row] + more[row]) {
      add_bound_row(row, -1, triplets);
      continue;
    }
    for (int i = row; i < row + block.count; ++i) {
      add_free_row(i, 1, triplets);
      triplets.emplace_back(i, i, share);
    }
  }
  Eigen::SparseMatrix<double> matrix(system_.rows(), system_.rows());
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factors;
  factors.compute(matrix);
  if (factors.info() != Eigen::Success) return {};
  Eigen::VectorXd change = factors.solve(Eigen::VectorXd(-difference(p)));
  if (factors.info() != Eigen::Success || !change.allFinite()) return {};
  return change;
}

constexpr int kHalvings = 12;
constexpr double kMostShare = 1, kShareRatio = 100;
// Newton's method finds the solution in 3 to 8 steps or not at all from where it begins.
constexpr int kStepsFromOnePlace = 30;
constexpr int kFirstSweeps = 20, kMostSweeps = 2560;
constexpr double kLeastGain = 0.999;  // of the merit in a round; else nothing more is to be had of it

constexpr int kMostRounds = 15;
constexpr double kInnerTolerance = 1e-3;

// Keeps the best of the impulses that it is shown: by the residual, and by F, in whose square all rows count.
class Best {
 public:
  Best(const ConstraintSystem& system, const ReferenceOptions& options)
      : newton_(system), system_(system), options_(options) {}

  // Whether a solution is found, or no iteration is left.
  bool is_done(const Eigen::VectorXd& p) {
    const Eigen::VectorXd within = project(system_, p, p);
    const double left = residual(system_, within), merit = newton_.merit(within);
    if (solution.history.empty() || left < solution.residual) {
      solution.impulses = within;
      solution.residual = left;
    }
    if (solution.history.empty() || merit < merit_) {
      closest_ = within;
      merit_ = merit;
    }
    solution.history.push_back(left);
    return solution.residual <= options_.tolerance || solution.iterations >= options_.max_iterations;
  }

  double merit() const { return merit_; }
  const Eigen::VectorXd& closest() const { return closest_; }
  // Where rows contradict each other the largest residual is theirs whatever the others do.
  void take_closest() {
    solution.impulses = closest_;
    solution.residual = residual(system_, closest_);
  }

  ReferenceSolution solution;

 private:
  const Newton newton_;
  Eigen::VectorXd closest_;
  double merit_ = 0;
  const ConstraintSystem& system_;
  const ReferenceOptions& options_;
};

// Takes steps from p until none brings F closer to zero. Where a step does not, it is drawn to p the more
// (Levenberg 1944, Marquardt 1963): impulses that no speed tells apart would move without bounds. Returns
// whether that is all there is to do.
bool run_newton(const Newton& newton, Eigen::VectorXd p, Best& best) {
  double share = kShare;
  for (int i = 0; i < kStepsFromOnePlace && share <= kMostShare; ++i) {
    const Eigen::VectorXd change = newton.step(p, share);
    ++best.solution.iterations;
    const double merit = newton.merit(p);
    bool is_better = false;
    double length = 1;
    for (int k = 0; k < kHalvings && change.size() > 0 && !is_better; ++k, length *= 0.5) {
      const Eigen::VectorXd trial = p + length * change;
      is_better = newton.merit(trial) < (1 - 1e-4 * length) * merit;
      if (is_better) p = trial;
    }
    if (best.is_done(p)) return true;
    share = is_better ? std::max(share / kShareRatio, kShare) : share * kShareRatio;
  }
  return false;
}

// Where the bounds of friction and its impulses chase each other, the bounds rest while Newton's method finds
// the impulses, and then follow these (Haslinger, "Approximation of the Signorini problem with friction,
// obeying the Coulomb law", 1983). With bounds at rest the problem is convex.
bool run_with_resting_bounds(const ConstraintSystem& system, Eigen::VectorXd p, Best& best,
                             const ReferenceOptions& options) {
  ConstraintSystem resting = system;
  resting.bound_by.setZero();
  ReferenceOptions inner = options;
  inner.tolerance *= kInnerTolerance;
  for (int round = 0; round < kMostRounds; ++round) {
    const Eigen::VectorXd more = system.bound_by * p;
    resting.upper = system.upper + more;
    resting.lower = system.lower - more;
    Best found(resting, inner);
    if (!found.is_done(p)) run_newton(Newton(resting), p, found);
    best.solution.iterations += found.solution.iterations;
    const bool has_moved = (p - found.solution.impulses).cwiseAbs().maxCoeff() > 0;
    p = found.solution.impulses;
    if (best.is_done(p)) return true;
    if (!has_moved) return false;
  }
  return false;
}

// Sweeps of Gauss-Seidel come closer and closer to a solution, and Newton's method is tried from there, after
// twice as many each time. That ends where rows contradict each other and all others are solved, or, after
// the last sweeps, where doubles end.
ReferenceSolution solve_bounded(const ConstraintSystem& system, const ReferenceOptions& options) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(system.rows());
  if (options.warm_start) p = project(system, system.stored, system.stored);
  Best best(system, options);
  const Newton newton(system);
  bool is_done = best.is_done(p);
  for (int sweeps = kFirstSweeps; !is_done && sweeps <= kMostSweeps; sweeps *= 2) {
    const double before = best.merit();
    for (int i = 0; i < sweeps; ++i) sweep(system, 1, p);
    is_done =
        best.is_done(p) || run_newton(newton, p, best) || run_with_resting_bounds(system, p, best, options);
    if (is_done || best.merit() < kLeastGain * before) continue;
    is_done = rows_contradict(system, best.closest(), options.tolerance);
  }
  best.solution.is_singular = best.solution.residual > options.tolerance &&
                              rows_contradict(system, best.closest(), options.tolerance);
  if (best.solution.is_singular) best.take_closest();
  return std::move(best.solution);
}

}  // namespace

ReferenceSolution solve_direct(const ConstraintSystem& system, const ReferenceOptions& options) {
  if (system.rows() == 0) return {};
  return has_bounds(system) ? solve_bounded(system, options) : solve_equalities(system, options);
}

}  // namespace scree
