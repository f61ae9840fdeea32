// From stated rows to a problem of points, its solution and its residual. See contact_problem.h.
#include <core/solvers/contact_problem.h>
#include <core/solvers/reference_solvers.h>
#include <scree/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace scree {

namespace {

// Slots of a contact, see simd/constraints/contact/contact_statement.cpp.
constexpr int kPoints = 4, kFrictionSlot = 5;

bool is_contact(const StatedConstraint& constraint) {
  return std::any_of(std::begin(constraint.rows.row), std::begin(constraint.rows.row) + kPoints,
                     [](const ConstraintRow& row) { return row.kind == kRowContact; });
}

// Rows that have no place, by kind.
class Refusal {
 public:
  void look_at(const StatedConstraint& constraint) {
    for (const ConstraintRow& row : constraint.rows.row) {
      if (row.kind == kRowLimit) ++count_[0];
      if (row.kind == kRowMotor) ++count_[1];
      if (row.kind == kRowSpring) ++count_[2];
      if (row.kind == kRowHeld && row.hertz > 0) ++count_[3];
      const bool resists = std::any_of(std::begin(row.bound_by), std::end(row.bound_by),
                                       [](float bound) { return bound != 0.0f; });
      if (row.kind == kRowRolling && resists && is_contact(constraint)) ++count_[4];
    }
  }
  void throw_if_any() const {
    static constexpr const char* kNames[] = {"limits", "motors", "springs", "soft held rows",
                                             "rolling resistance"};
    std::string list;
    for (std::size_t i = 0; i < count_.size(); ++i) {
      if (count_[i] > 0) list += (list.empty() ? "" : ", ") + std::to_string(count_[i]) + " of " + kNames[i];
    }
    if (!list.empty())
      throw Error("contact_problem: a problem of contact points has no place for these rows: " + list);
  }

 private:
  std::array<int, 5> count_{};
};

Eigen::Vector3d vec(const float (&v)[3]) { return Eigen::Vector3f(v[0], v[1], v[2]).cast<double>(); }

void put(const Eigen::Vector3d& from, float (&to)[3]) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from[k]);
}

// The point of a contact with the tangents of its friction: with the tangents t1, t2 and n = t1 x t2, and the
// angular row f_i = c x t_i at the friction center, c x n = -(f_1 . n) t_1 - (f_2 . n) t_2. The angular row
// of the point, (c + r) x n, then tells r in the plane, and so (c + r) x t_i.
StatedConstraint point_of(const StatedConstraint& contact, int point) {
  const ConstraintRow* const row = contact.rows.row;
  const Eigen::Vector3d normal = vec(row[point].linear_b);
  Eigen::Vector3d lever = vec(row[point].angular_b);  // (c + r) x n
  for (int i = 0; i < 2; ++i) {
    const ConstraintRow& slip = row[kFrictionSlot + i];
    lever += vec(slip.angular_b).dot(normal) * vec(slip.linear_b);
  }
  const Eigen::Vector3d arm = normal.cross(lever);
  StatedConstraint stated{ConstraintRows{}, contact.body_a, contact.body_b};
  stated.rows.row[0] = row[point];
  stated.rows.row[0].block = 0;
  stated.rows.row[0].impulse = 0;
  for (int i = 0; i < 2; ++i) {
    ConstraintRow& slip = stated.rows.row[1 + i];
    slip = row[kFrictionSlot + i];
    const Eigen::Vector3d turn = arm.cross(vec(slip.linear_b));
    put(vec(slip.angular_a) - turn, slip.angular_a);
    put(vec(slip.angular_b) + turn, slip.angular_b);
    const float friction = slip.bound_by[point];
    for (float& bound : slip.bound_by) bound = 0;
    slip.bound_by[0] = friction;
    slip.block = 1;
    slip.impulse = 0;
  }
  return stated;
}

using ColumnMatrix = Eigen::SparseMatrix<double>;

SparseColumns columns_of(const ColumnMatrix& from) {
  SparseColumns to{static_cast<int>(from.rows()), static_cast<int>(from.cols()), {0}, {}, {}};
  for (int column = 0; column < to.columns; ++column) {
    for (ColumnMatrix::InnerIterator it(from, column); it; ++it) {
      if (it.value() == 0) continue;
      to.row.push_back(static_cast<int>(it.row()));
      to.value.push_back(it.value());
    }
    to.start.push_back(static_cast<int>(to.row.size()));
  }
  return to;
}

template <class Put>
void for_entries(const SparseColumns& matrix, Put&& put_entry) {
  for (int column = 0; column < matrix.columns; ++column) {
    const auto c = static_cast<std::size_t>(column);
    for (int at = matrix.start[c]; at < matrix.start[c + 1]; ++at) {
      const auto i = static_cast<std::size_t>(at);
      put_entry(matrix.row[i], column, matrix.value[i]);
    }
  }
}

// As the solvers of this folder take it: what is held first, then point by point.
ConstraintSystem system_of(const ContactProblem& problem) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const int held = problem.held(), rows = held + 3 * problem.points();
  std::vector<Eigen::Triplet<double>> entries, bounds;
  for_entries(problem.held_response, [&](int i, int k, double x) { entries.emplace_back(i, k, x); });
  for_entries(problem.response, [&](int i, int k, double x) { entries.emplace_back(held + i, held + k, x); });
  for_entries(problem.coupling, [&](int i, int k, double x) {
    entries.emplace_back(held + i, k, x);
    entries.emplace_back(k, held + i, x);
  });
  ConstraintSystem system;
  system.free_speed.resize(rows);
  system.lower = Eigen::VectorXd::Zero(rows);
  system.upper = Eigen::VectorXd::Zero(rows);
  system.stored = Eigen::VectorXd::Zero(rows);
  for (int i = 0; i < held; ++i) {
    system.free_speed[i] = problem.held_speed[static_cast<std::size_t>(i)];
    system.lower[i] = -kNone;
    system.upper[i] = kNone;
    system.blocks.push_back({i, 1, false});
  }
  for (int i = held; i < rows; ++i)
    system.free_speed[i] = problem.free_speed[static_cast<std::size_t>(i - held)];
  for (int point = 0; point < problem.points(); ++point) {
    const int normal = held + 3 * point;
    system.upper[normal] = kNone;
    system.blocks.push_back({normal, 1, false});
    system.blocks.push_back({normal + 1, 2, true});
    for (int i = 1; i < 3; ++i)
      bounds.emplace_back(normal + i, normal, problem.friction[static_cast<std::size_t>(point)]);
  }
  system.matrix.resize(rows, rows);
  system.matrix.setFromTriplets(entries.begin(), entries.end());
  system.compliance.resize(rows, rows);
  system.bound_by.resize(rows, rows);
  system.bound_by.setFromTriplets(bounds.begin(), bounds.end());
  return system;
}

// The nearest of the cone |r_t| <= mu r_n.
Eigen::Vector3d project_on_cone(const Eigen::Vector3d& r, double friction) {
  const double along = r[0], across = r.tail<2>().norm();
  if (across <= friction * along) return r;
  if (friction * across <= -along) return Eigen::Vector3d::Zero();
  const double normal = (along + friction * across) / (1 + friction * friction);
  Eigen::Vector3d nearest;
  nearest << normal, r.tail<2>() * (friction * normal / across);
  return nearest;
}

}  // namespace

ContactProblem contact_problem(std::span<const SystemBody> bodies,
                               std::span<const StatedConstraint> constraints, const SystemPolicy& policy) {
  Refusal refusal;
  for (const StatedConstraint& constraint : constraints) refusal.look_at(constraint);
  refusal.throw_if_any();

  ContactProblem problem;
  problem.substep = policy.substep;
  std::vector<StatedConstraint> stated;  // what is held, then points
  for (const StatedConstraint& constraint : constraints) {
    if (!is_contact(constraint)) stated.push_back(constraint);
  }
  for (StatedConstraint& constraint : stated) {
    // What rubs in a contact without points does nothing.
    for (ConstraintRow& row : constraint.rows.row) {
      if (row.kind != kRowHeld) row.kind = kRowNone;
    }
  }
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    if (!is_contact(constraints[i])) continue;
    for (int point = 0; point < kPoints; ++point) {
      if (constraints[i].rows.row[point].kind != kRowContact) continue;
      stated.push_back(point_of(constraints[i], point));
      problem.friction.push_back(double{stated.back().rows.row[1].bound_by[0]});
      problem.constraint.push_back(static_cast<int>(i));
      problem.slot.push_back(point);
    }
  }
  const ConstraintSystem system = assemble(bodies, stated, policy);
  const int rows = system.rows(), contact = 3 * problem.points(), held = rows - contact;
  const ColumnMatrix matrix = system.matrix;
  problem.response = columns_of(matrix.block(held, held, contact, contact));
  problem.coupling = columns_of(matrix.block(held, 0, contact, held));
  problem.held_response = columns_of(matrix.block(0, 0, held, held));
  problem.held_speed.assign(system.free_speed.data(), system.free_speed.data() + held);
  problem.free_speed.assign(system.free_speed.data() + held, system.free_speed.data() + rows);
  return problem;
}

ContactSolution solve_contact_problem(const ContactProblem& problem, int max_iterations, double tolerance) {
  ReferenceOptions options;
  options.method = ReferenceMethod::direct;
  options.max_iterations = max_iterations;
  options.tolerance = tolerance;
  ContactSolution solution;
  if (problem.points() + problem.held() == 0) return solution;
  const ConstraintSystem system = system_of(problem);
  const ReferenceSolution found = solve(system, options);
  const double* const p = found.impulses.data();
  solution.held_impulses.assign(p, p + problem.held());
  solution.impulses.assign(p + problem.held(), p + system.rows());
  solution.speeds = speeds_of(problem, solution.impulses, solution.held_impulses);
  solution.iterations = found.iterations;
  solution.residual = found.residual;
  solution.natural_error = natural_map_error(problem, solution.impulses, solution.speeds);
  const Eigen::VectorXd w = system.matrix * found.impulses + system.free_speed;
  for (int i = 0; i < problem.held(); ++i)
    solution.held_error = std::max(solution.held_error, std::abs(w[i]));
  return solution;
}

std::vector<double> speeds_of(const ContactProblem& problem, std::span<const double> impulses,
                              std::span<const double> held_impulses) {
  std::vector<double> speeds = problem.free_speed;
  const auto add = [&speeds](std::span<const double> by) {
    return [&speeds, by](int row, int column, double x) {
      speeds[static_cast<std::size_t>(row)] += x * by[static_cast<std::size_t>(column)];
    };
  };
  for_entries(problem.response, add(impulses));
  for_entries(problem.coupling, add(held_impulses));
  return speeds;
}

double natural_map_error(const ContactProblem& problem, std::span<const double> impulses,
                         std::span<const double> speeds) {
  double sum = 0, free = 0;
  for (int point = 0; point < problem.points(); ++point) {
    const std::size_t at = 3 * static_cast<std::size_t>(point);
    const double friction = problem.friction[static_cast<std::size_t>(point)];
    const Eigen::Vector3d r(impulses[at], impulses[at + 1], impulses[at + 2]);
    Eigen::Vector3d u(speeds[at], speeds[at + 1], speeds[at + 2]);
    u[0] += friction * u.tail<2>().norm();
    sum += (r - project_on_cone(r - u, friction)).squaredNorm();
  }
  for (const double speed : problem.free_speed) free += speed * speed;
  return free > 0 ? std::sqrt(sum / free) : std::sqrt(sum);
}

}  // namespace scree
