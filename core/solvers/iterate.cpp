// The iterative methods. See reference_solvers.h and README.md.
#include <core/solvers/reference_solvers.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace scree {

namespace {

// The largest diagonal element of a block, by row: one for all its rows, so that steps keep the direction of
// w.
Eigen::VectorXd block_responses(const ConstraintSystem& system) {
  const Eigen::VectorXd diagonal = system.matrix.diagonal();
  Eigen::VectorXd responses(system.rows());
  for (const SystemBlock& block : system.blocks) {
    responses.segment(block.first, block.count)
        .setConstant(diagonal.segment(block.first, block.count).maxCoeff());
  }
  return responses;
}

// Steps of rows that nothing can push are none.
Eigen::VectorXd inverse_of(const Eigen::VectorXd& responses) {
  return responses.unaryExpr([](double x) { return x > 0 ? 1 / x : 0.0; });
}

// The largest eigenvalue of D^-1 A is at most this (Gershgorin, of D^-1/2 A D^-1/2).
double largest_eigenvalue_bound(const ConstraintSystem& system, const Eigen::VectorXd& inverse) {
  double largest = 0;
  for (int row = 0; row < system.rows(); ++row) {
    double sum = 0;
    for (SystemMatrix::InnerIterator it(system.matrix, row); it; ++it)
      sum += std::abs(it.value()) * std::sqrt(inverse[row] * inverse[it.col()]);
    largest = std::max(largest, sum);
  }
  return largest;
}

// Runs iterations from the first guess until the residual is below the tolerance, and keeps the best.
class Loop {
 public:
  Loop(const ConstraintSystem& system, const ReferenceOptions& options) : system_(system), options_(options) {
    p = Eigen::VectorXd::Zero(system.rows());
    if (options.warm_start) p = project(system, system.stored, system.stored);
    take(p);
  }

  // Whether another iteration is due, after taking what `p` is now.
  bool goes_on() {
    if (has_begun_) {
      ++best_.iterations;
      take(p);
    }
    has_begun_ = true;
    return best_.iterations < options_.max_iterations && !(best_.residual <= options_.tolerance);
  }
  ReferenceSolution solution() { return std::move(best_); }

  Eigen::VectorXd p;

 private:
  void take(const Eigen::VectorXd& now) {
    const double left = residual(system_, now);
    best_.history.push_back(left);
    if (best_.history.size() == 1 || left < best_.residual) {
      best_.impulses = now;
      best_.residual = left;
    }
  }

  const ConstraintSystem& system_;
  const ReferenceOptions& options_;
  ReferenceSolution best_;
  bool has_begun_ = false;
};

// p <- project(p - r D^-1 (A p + b))
ReferenceSolution solve_jacobi(const ConstraintSystem& system, const ReferenceOptions& options) {
  const Eigen::VectorXd inverse = inverse_of(block_responses(system));
  const double relaxation = options.relaxation > 0
                                ? options.relaxation
                                : 1 / std::max(largest_eigenvalue_bound(system, inverse), 1.0);
  Loop loop(system, options);
  while (loop.goes_on()) {
    const Eigen::VectorXd w = system.matrix * loop.p + system.free_speed;
    loop.p = project(system, loop.p, loop.p - relaxation * inverse.cwiseProduct(w));
  }
  return loop.solution();
}

ReferenceSolution solve_by_sweeps(const ConstraintSystem& system, const ReferenceOptions& options,
                                  double relaxation) {
  Loop loop(system, options);
  while (loop.goes_on()) sweep(system, relaxation, loop.p);
  return loop.solution();
}

// What a sweep of Gauss-Seidel changes serves as the gradient of Fletcher and Reeves (Silcowitz, Niebe and
// Erleben, "A nonsmooth nonlinear conjugate gradient method for interactive contact force problems", 2010).
ReferenceSolution solve_conjugate_gradient(const ConstraintSystem& system, const ReferenceOptions& options) {
  Loop loop(system, options);
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(system.rows());
  double last_square = 0;
  while (loop.goes_on()) {
    const Eigen::VectorXd before = loop.p;
    sweep(system, 1, loop.p);
    const Eigen::VectorXd change = loop.p - before;
    const double square = change.squaredNorm();
    const double share = last_square > 0 ? square / last_square : 0;
    last_square = square;
    if (share > 1) {
      direction.setZero();
      continue;
    }
    loop.p = project(system, loop.p, loop.p + share * direction);
    direction = share * direction + change;
  }
  return loop.solution();
}

// Nesterov's gradient with restarts where it would go back (Mazhar, Heyn, Negrut and Tasora, "Using
// Nesterov's method to accelerate multibody dynamics with friction and contact", 2015), in the metric of D.
// At fixed bounds of friction the problem is convex; the bounds follow the normal impulses from step to step
// (Haslinger's fixed point).
ReferenceSolution solve_accelerated_gradient(const ConstraintSystem& system,
                                             const ReferenceOptions& options) {
  const Eigen::VectorXd responses = block_responses(system), inverse = inverse_of(responses);
  const double step = 1 / std::max(largest_eigenvalue_bound(system, inverse), 1.0);
  Loop loop(system, options);
  Eigen::VectorXd ahead = loop.p;
  double theta = 1;
  while (loop.goes_on()) {
    const Eigen::VectorXd before = loop.p;
    const Eigen::VectorXd w = system.matrix * ahead + system.free_speed;
    loop.p = project(system, before, ahead - step * inverse.cwiseProduct(w));
    const Eigen::VectorXd change = loop.p - before;
    if ((ahead - loop.p).cwiseProduct(responses).dot(change) > 0) {  // overshot: begin anew
      theta = 1;
      ahead = loop.p;
      continue;
    }
    const double next = 0.5 * (1 + std::sqrt(1 + 4 * theta * theta));
    ahead = loop.p + (theta - 1) / next * change;
    theta = next;
  }
  return loop.solution();
}

}  // namespace

// Row after row, each with what those before it have changed (Cottle, Pang and Stone 1992, chapter 5).
void sweep(const ConstraintSystem& system, double relaxation, Eigen::VectorXd& p) {
  for (const SystemBlock& block : system.blocks) {
    double response = 0, more = 0;
    Eigen::VectorXd w(block.count);
    for (int i = 0; i < block.count; ++i) {
      const int row = block.first + i;
      w[i] = system.free_speed[row];
      for (SystemMatrix::InnerIterator it(system.matrix, row); it; ++it) {
        w[i] += it.value() * p[it.col()];
        if (it.col() == row) response = std::max(response, it.value());
      }
    }
    if (!(response > 0)) continue;
    for (SystemMatrix::InnerIterator it(system.bound_by, block.first); it; ++it)
      more += it.value() * p[it.col()];
    auto of_block = p.segment(block.first, block.count);
    of_block -= relaxation / response * w;
    if (block.bounds_length) {
      const double radius = std::max(system.upper[block.first] + more, 0.0), length = of_block.norm();
      if (length > radius) of_block *= radius / length;
    } else {
      const double most = system.upper[block.first] + more,
                   least = std::min(system.lower[block.first] - more, most);
      of_block[0] = std::max(std::min(of_block[0], most), least);
    }
  }
}

ReferenceSolution solve(const ConstraintSystem& system, const ReferenceOptions& options) {
  switch (options.method) {
    case ReferenceMethod::jacobi:
      return solve_jacobi(system, options);
    case ReferenceMethod::gauss_seidel:
      return solve_by_sweeps(system, options, 1);
    case ReferenceMethod::over_relaxation:
      return solve_by_sweeps(system, options, options.relaxation > 0 ? options.relaxation : 1.3);
    case ReferenceMethod::conjugate_gradient:
      return solve_conjugate_gradient(system, options);
    case ReferenceMethod::accelerated_gradient:
      return solve_accelerated_gradient(system, options);
    case ReferenceMethod::direct:
      break;
  }
  return solve_direct(system, options);
}

}  // namespace scree
