// Whether rows contradict each other, so that no impulses satisfy all of them. See reference_solvers.h.
//
// Impulses y that move nothing, A y = 0, change no speed: w y = b y for w = A p + b, whatever p is. Where b y
// < 0, although each row of y wants w y >= 0 (held rows w = 0, rows that push w >= 0 and have y >= 0), no p
// is a solution (Farkas 1902). So this finds contradictions for certain, and may overlook some. What is soft,
// or has bounds on both sides, as friction and motors, contradicts nothing.
#include <core/solvers/reference_solvers.h>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

constexpr double kShare = 1e-9;  // of the diagonal: what is added to it, so that A has an inverse
constexpr int kRefinements = 10;
constexpr int kMostRounds = 30;
constexpr double kSmall = 1e-6;  // of the largest: counts as none

// A row that may take part: 0 is held, 1 and -1 have impulses of that sign without a bound.
struct Candidate {
  int row;
  double sign;
};

std::vector<Candidate> find_candidates(const ConstraintSystem& system, const Eigen::VectorXd& p, bool held) {
  std::vector<Candidate> candidates;
  for (const SystemBlock& block : system.blocks) {
    if (block.bounds_length) continue;
    for (int row = block.first; row < block.first + block.count; ++row) {
      if (!(system.matrix.coeff(row, row) > 0)) continue;
      const bool below = std::isinf(system.lower[row]), above = std::isinf(system.upper[row]);
      if (below && above) {
        candidates.push_back({row, 0});
      } else if (!held && above && p[row] > system.lower[row]) {
        candidates.push_back({row, 1});
      } else if (!held && below && p[row] < system.upper[row]) {
        candidates.push_back({row, -1});
      }
    }
  }
  return candidates;
}

Eigen::SparseMatrix<double> matrix_of(const ConstraintSystem& system,
                                      const std::vector<Candidate>& candidates) {
  std::vector<int> place(static_cast<std::size_t>(system.rows()), -1);
  const auto count = static_cast<int>(candidates.size());
  for (int i = 0; i < count; ++i)
    place[static_cast<std::size_t>(candidates[static_cast<std::size_t>(i)].row)] = i;
  std::vector<Eigen::Triplet<double>> triplets;
  for (int i = 0; i < count; ++i) {
    for (SystemMatrix::InnerIterator it(system.matrix, candidates[static_cast<std::size_t>(i)].row); it; ++it)
      if (const int column = place[static_cast<std::size_t>(it.col())]; column >= 0)
        triplets.emplace_back(i, column, it.value());
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

// Takes from w what impulses can bring about: what is left, by the diagonal, moves nothing.
Eigen::VectorXd rest_of(const Eigen::SparseMatrix<double>& matrix, Eigen::VectorXd w) {
  Eigen::SparseMatrix<double> shifted = matrix;
  for (int i = 0; i < matrix.rows(); ++i) shifted.coeffRef(i, i) *= 1 + kShare;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(shifted);
  if (factors.info() != Eigen::Success) return Eigen::VectorXd::Zero(w.size());
  for (int i = 0; i < kRefinements; ++i) w -= matrix * Eigen::VectorXd(factors.solve(w));
  return w;
}

// Leaves out, round by round, what would have to pull where it pushes.
bool contradict(const ConstraintSystem& system, const Eigen::VectorXd& w, std::vector<Candidate> candidates,
                double tolerance) {
  for (int round = 0; round < kMostRounds && !candidates.empty(); ++round) {
    const Eigen::SparseMatrix<double> matrix = matrix_of(system, candidates);
    const Eigen::VectorXd diagonal = matrix.diagonal();
    Eigen::VectorXd speeds(matrix.rows());
    for (int i = 0; i < matrix.rows(); ++i) speeds[i] = w[candidates[static_cast<std::size_t>(i)].row];
    const Eigen::VectorXd rest = rest_of(matrix, speeds);
    if (!(rest.cwiseAbs().maxCoeff() > tolerance)) return false;
    const Eigen::VectorXd y = -rest.cwiseQuotient(diagonal);
    const double least = -kSmall * y.cwiseAbs().maxCoeff();
    std::vector<Candidate> left;
    for (int i = 0; i < matrix.rows(); ++i) {
      const Candidate& candidate = candidates[static_cast<std::size_t>(i)];
      if (candidate.sign * y[i] >= least) left.push_back(candidate);
    }
    if (left.size() == candidates.size())
      return y.dot(matrix * y) <= kSmall * y.dot(diagonal.cwiseProduct(y));
    candidates = std::move(left);
  }
  return false;
}

}  // namespace

bool rows_contradict(const ConstraintSystem& system, const Eigen::VectorXd& p, double tolerance) {
  const Eigen::VectorXd w = system.matrix * p + system.free_speed;
  return contradict(system, w, find_candidates(system, p, true), tolerance) ||
         contradict(system, w, find_candidates(system, p, false), tolerance);
}

}  // namespace scree
