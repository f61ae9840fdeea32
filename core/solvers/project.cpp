// Bounds of impulses, and how far impulses are from a solution. See constraint_system.h.
#include <core/solvers/constraint_system.h>

#include <algorithm>
#include <cmath>

namespace scree {

Eigen::VectorXd project(const ConstraintSystem& system, const Eigen::VectorXd& p,
                        const Eigen::VectorXd& impulses) {
  const Eigen::VectorXd more = system.bound_by * p;
  Eigen::VectorXd result = impulses;
  for (const SystemBlock& block : system.blocks) {
    if (block.bounds_length) {
      const double radius = std::max(system.upper[block.first] + more[block.first], 0.0);
      const double length = result.segment(block.first, block.count).norm();
      if (length > radius) result.segment(block.first, block.count) *= radius / length;
    } else {
      const double least = system.lower[block.first] - more[block.first],
                   most = system.upper[block.first] + more[block.first];
      result[block.first] = std::max(std::min(result[block.first], most), std::min(least, most));
    }
  }
  return result;
}

namespace {

// Of the impulses p. `w`: what rows have with them, with bias and compliance.
double residual_at(const ConstraintSystem& system, const Eigen::VectorXd& p, const Eigen::VectorXd& w) {
  if (system.rows() == 0) return 0;
  Eigen::VectorXd step(system.rows());
  for (const SystemBlock& block : system.blocks) {
    double response = 0;  // one for the block, so that its step has the direction of w
    for (int i = 0; i < block.count; ++i)
      response = std::max(response, system.matrix.coeff(block.first + i, block.first + i));
    for (int i = block.first; i < block.first + block.count; ++i) step[i] = response;
  }
  const auto divided = [&](int i) { return step[i] > 0 ? w[i] / step[i] : 0.0; };
  Eigen::VectorXd asked = p;
  for (int i = 0; i < system.rows(); ++i) asked[i] -= divided(i);
  const Eigen::VectorXd off = p - project(system, p, asked);
  return off.cwiseProduct(step).cwiseAbs().maxCoeff();
}

}  // namespace

double residual(const ConstraintSystem& system, const Eigen::VectorXd& p) {
  return residual_at(system, p, system.matrix * p + system.free_speed);
}

double residual_of_stored(const ConstraintSystem& system) {
  return residual_at(system, system.stored, system.compliance * system.stored + system.free_speed);
}

Eigen::VectorXd velocities(const ConstraintSystem& system, std::span<const SystemBody> bodies,
                           const Eigen::VectorXd& p) {
  Eigen::VectorXd v =
      system.push.transpose() * Eigen::VectorXd(system.stored_has_acted ? p - system.stored : p);
  for (int body = 0; body < system.bodies; ++body) {
    const VelocityRow& u = bodies[static_cast<std::size_t>(body)].velocity;
    for (int i = 0; i < 3; ++i) {
      v[6 * body + i] += double{u.linear[i]};
      v[6 * body + 3 + i] += double{u.angular[i]};
    }
  }
  return v;
}

}  // namespace scree
