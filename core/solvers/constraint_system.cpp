// From stated rows to a system. See constraint_system.h.
#include <core/solvers/constraint_system.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace scree {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

// Of a spring as it acts over a substep h, with the response K of its row: the bias is a share of the error,
// and the compliance a share of K (Catto, "Soft Constraints", GDC 2011).
struct Spring {
  double bias_rate, compliance;  // 1/s; times K
};
constexpr Spring kRigid{0, 0};

Spring spring_of(double hertz, double damping_ratio, double substep) {
  const double omega = 2 * std::numbers::pi * hertz;
  const double a1 = 2 * damping_ratio + substep * omega;
  return {omega / a1, 1 / (substep * omega * a1)};
}

// Speeds of two bodies, or a row of their Jacobian: v_a, w_a, v_b, w_b.
using Twelve = Eigen::Matrix<double, 12, 1>;

// A row that takes part.
struct Entry {
  const ConstraintRow* said;
  Twelve jacobian, push;  // push = M^-1 J^T
  double bias = 0;
  Spring spring = kRigid;
  double yield = 0;  // compliance by itself, where the row has a reference response
};

class Assembler {
 public:
  Assembler(std::span<const SystemBody> bodies, const SystemPolicy& policy)
      : bodies_(bodies), policy_(policy) {}

  void add(std::int32_t number, const StatedConstraint& constraint);
  ConstraintSystem finish();

 private:
  const SystemBody& body(std::int32_t index) const { return bodies_[static_cast<std::size_t>(index)]; }
  bool is_idle(const ConstraintRow& row) const;
  Spring stiffness(const ConstraintRow& row) const;
  void set_stiffness(bool against_static, Entry& entry) const;
  Entry entry_of(const StatedConstraint& constraint, const ConstraintRow& row) const;
  void add_compliance(const std::vector<Entry>& entries, const std::vector<int>& block, int first_row);
  void add_row(const StatedConstraint& constraint, const Entry& entry,
               const int (&place)[kMaxConstraintRows]);

  std::span<const SystemBody> bodies_;
  const SystemPolicy& policy_;
  int rows_ = 0;
  Triplets jacobian_, push_, compliance_, bound_by_;
  std::vector<double> bias_, lower_, upper_, stored_, target_;
  ConstraintSystem system_;
};

bool Assembler::is_idle(const ConstraintRow& row) const {
  const bool rubs = row.kind == kRowTwist || row.kind == kRowFriction || row.kind == kRowRolling;
  return row.kind == kRowNone || (rubs && policy_.pass == SystemPolicy::Pass::solve);
}

Spring Assembler::stiffness(const ConstraintRow& row) const {
  if (row.hertz > 0)
    return spring_of(std::min<double>(row.hertz, policy_.max_hertz), row.damping_ratio, policy_.substep);
  if (policy_.pass == SystemPolicy::Pass::relax) return kRigid;
  if (policy_.pass == SystemPolicy::Pass::rigid) return {policy_.baumgarte / policy_.substep, 0};
  return spring_of(policy_.joint_hertz, policy_.joint_damping_ratio, policy_.substep);
}

void Assembler::set_stiffness(bool against_static, Entry& entry) const {
  const ConstraintRow& row = *entry.said;
  const double error = row.error, most = policy_.push_speed;
  switch (row.kind) {
    case kRowHeld:
      entry.spring = stiffness(row);
      entry.bias = entry.spring.bias_rate * error;
      break;
    case kRowSpring:
      entry.spring = stiffness(row);
      entry.bias = entry.spring.bias_rate * error;
      if (row.reference_response > 0) {
        entry.yield = row.reference_response * entry.spring.compliance;
        entry.spring = kRigid;
      }
      break;
    case kRowLimit:
      // Apart: the end may be reached within the substep and no farther.
      if (row.lower == 0 && error > 0) {
        entry.bias = error / policy_.substep;
        break;
      }
      entry.spring = stiffness(row);
      entry.bias = entry.spring.bias_rate * error;
      if (row.hertz == 0 || (row.flags & kRowOneEndOfCircle) != 0)
        entry.bias = std::clamp(entry.bias, -most, most);
      break;
    case kRowContact:
      if (error > 0) {
        entry.bias = error / policy_.substep;
      } else if (policy_.pass == SystemPolicy::Pass::rigid) {
        entry.bias =
            std::max(policy_.baumgarte / policy_.substep * std::min(error + policy_.slop, 0.0), -most);
      } else if (policy_.pass == SystemPolicy::Pass::solve) {
        entry.spring = against_static
                           ? spring_of(policy_.static_contact_hertz, policy_.static_contact_damping_ratio,
                                       policy_.substep)
                           : spring_of(policy_.contact_hertz, policy_.contact_damping_ratio, policy_.substep);
        entry.bias = std::max(entry.spring.bias_rate * error, -most);
      }
      break;
    default:
      break;
  }
}

Entry Assembler::entry_of(const StatedConstraint& constraint, const ConstraintRow& row) const {
  Entry entry{&row, Twelve::Zero(), Twelve::Zero()};
  const auto put = [&entry](const InertiaRow& inverse, const float(&linear)[3], const float(&angular)[3],
                            int at) {
    const float* s = inverse.inverse_inertia;
    const std::size_t place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (int i = 0; i < 3; ++i) {
      entry.jacobian[at + i] = linear[i];
      entry.jacobian[at + 3 + i] = angular[i];
      entry.push[at + i] = double{inverse.inverse_mass} * double{linear[i]};
      for (int k = 0; k < 3; ++k) entry.push[at + 3 + i] += double{s[place[i][k]]} * double{angular[k]};
    }
  };
  put(body(constraint.body_a).inverse, row.linear_a, row.angular_a, 0);
  put(body(constraint.body_b).inverse, row.linear_b, row.angular_b, 6);
  const bool against_static =
      body(constraint.body_a).inverse.inverse_mass == 0 || body(constraint.body_b).inverse.inverse_mass == 0;
  set_stiffness(against_static, entry);
  return entry;
}

// The matrix of the responses of some rows to each other.
Eigen::MatrixXd responses(const std::vector<Entry>& entries, const std::vector<int>& rows,
                          const std::vector<int>& columns) {
  Eigen::MatrixXd k(rows.size(), columns.size());
  for (Eigen::Index i = 0; i < k.rows(); ++i) {
    for (Eigen::Index j = 0; j < k.cols(); ++j) {
      k(i, j) = entries[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])].jacobian.dot(
          entries[static_cast<std::size_t>(columns[static_cast<std::size_t>(j)])].push);
    }
  }
  return k;
}

std::vector<int> held_rows(const std::vector<Entry>& entries) {
  std::vector<int> held;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].said->kind == kRowHeld) held.push_back(static_cast<int>(i));
  }
  return held;
}

// Rows that are solved as one are soft as one: with their responses K = L D L^T, they are independent as L^T
// p and L^-1 w, and there each has its own share s of compliance. So C = L D S L^T. Of rows that keep what is
// held, K is the response that is left while it is held.
void Assembler::add_compliance(const std::vector<Entry>& entries, const std::vector<int>& block,
                               int first_row) {
  const auto entry = [&](Eigen::Index i) -> const Entry& {
    return entries[static_cast<std::size_t>(block[static_cast<std::size_t>(i)])];
  };
  const auto n = static_cast<Eigen::Index>(block.size());
  double softest = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    softest = std::max({softest, entry(i).spring.compliance, entry(i).yield});
  if (!(softest > 0)) return;
  Eigen::MatrixXd k = responses(entries, block, block);
  const std::vector<int> held = held_rows(entries);
  if ((entry(0).said->flags & kRowKeepsHeld) != 0 && !held.empty()) {
    // What is soft gives way, and holds so much less.
    const double hold = 1 / (1 + entries[static_cast<std::size_t>(held[0])].spring.compliance);
    k -= hold * responses(entries, block, held) *
         responses(entries, held, held).ldlt().solve(responses(entries, held, block));
  }
  Eigen::MatrixXd lower = Eigen::MatrixXd::Identity(n, n), rest = k;
  for (Eigen::Index i = 0; i < n; ++i) rest(i, i) += entry(i).yield;
  Eigen::VectorXd soft(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    soft[i] = entry(i).spring.compliance * rest(i, i);
    for (Eigen::Index r = i + 1; r < n && rest(i, i) > 0; ++r) {
      lower(r, i) = rest(r, i) / rest(i, i);
      rest.row(r) -= lower(r, i) * rest.row(i);
    }
  }
  Eigen::MatrixXd compliance = lower * soft.asDiagonal() * lower.transpose();
  for (Eigen::Index i = 0; i < n; ++i) compliance(i, i) += entry(i).yield;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      compliance_.emplace_back(first_row + block[static_cast<std::size_t>(i)],
                               first_row + block[static_cast<std::size_t>(j)], compliance(i, j));
    }
  }
}

void Assembler::add_row(const StatedConstraint& constraint, const Entry& entry,
                        const int (&place)[kMaxConstraintRows]) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const ConstraintRow& row = *entry.said;
  for (int i = 0; i < 6; ++i) {
    jacobian_.emplace_back(rows_, 6 * constraint.body_a + i, entry.jacobian[i]);
    jacobian_.emplace_back(rows_, 6 * constraint.body_b + i, entry.jacobian[6 + i]);
    push_.emplace_back(rows_, 6 * constraint.body_a + i, entry.push[i]);
    push_.emplace_back(rows_, 6 * constraint.body_b + i, entry.push[6 + i]);
  }
  // A limit that is a spring pulls where it has been passed, and not before.
  const bool gives_nothing = row.kind == kRowLimit && row.lower == 0 && row.hertz > 0 && row.error > 0;
  const bool is_free = row.kind == kRowHeld;
  bias_.push_back(entry.bias);
  target_.push_back(row.target_speed);
  lower_.push_back(is_free ? -kNone : gives_nothing ? 0 : double{row.lower} * policy_.substep);
  upper_.push_back(is_free ? kNone : gives_nothing ? 0 : double{row.upper} * policy_.substep);
  stored_.push_back(row.impulse);
  for (int by = 0; by < 4; ++by) {
    if (row.bound_by[by] != 0 && place[by] >= 0)
      bound_by_.emplace_back(rows_, place[by], double{row.bound_by[by]});
  }
  ++rows_;
}

void Assembler::add(std::int32_t number, const StatedConstraint& constraint) {
  std::vector<Entry> entries;
  int place[kMaxConstraintRows];
  std::vector<std::vector<int>> blocks;  // of entries, by block
  std::vector<std::uint32_t> numbers;
  const int first_row = rows_;
  for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
    const ConstraintRow& row = constraint.rows.row[slot];
    place[slot] = -1;
    if (is_idle(row)) continue;
    place[slot] = rows_;
    entries.push_back(entry_of(constraint, row));
    const bool bounds_length = (row.flags & kRowBoundsLength) != 0;
    const auto block =
        static_cast<std::size_t>(std::find(numbers.begin(), numbers.end(), row.block) - numbers.begin());
    if (bounds_length && !numbers.empty() && numbers.back() == row.block) {
      ++system_.blocks.back().count;
    } else {
      system_.blocks.push_back({rows_, 1, bounds_length});
    }
    if (block == numbers.size()) {
      numbers.push_back(row.block);
      blocks.emplace_back();
    }
    blocks[block].push_back(static_cast<int>(entries.size()) - 1);
    system_.constraint.push_back(number);
    system_.slot.push_back(slot);
    add_row(constraint, entries.back(), place);
  }
  for (const std::vector<int>& block : blocks) add_compliance(entries, block, first_row);
}

Eigen::VectorXd vector_of(const std::vector<double>& from) {
  return Eigen::Map<const Eigen::VectorXd>(from.data(), static_cast<Eigen::Index>(from.size()));
}

SystemMatrix matrix_of(int rows, int columns, const Triplets& triplets) {
  SystemMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

ConstraintSystem Assembler::finish() {
  const int bodies = static_cast<int>(bodies_.size());
  Eigen::VectorXd u(6 * bodies);
  for (int body = 0; body < bodies; ++body) {
    const VelocityRow& v = bodies_[static_cast<std::size_t>(body)].velocity;
    for (int i = 0; i < 3; ++i) {
      u[6 * body + i] = v.linear[i];
      u[6 * body + 3 + i] = v.angular[i];
    }
  }
  system_.bodies = bodies;
  system_.stored_has_acted = policy_.stored_has_acted;
  system_.jacobian = matrix_of(rows_, 6 * bodies, jacobian_);
  system_.push = matrix_of(rows_, 6 * bodies, push_);
  system_.compliance = matrix_of(rows_, rows_, compliance_);
  const SystemMatrix response = system_.push * SystemMatrix(system_.jacobian.transpose());
  system_.matrix = response + system_.compliance;
  system_.matrix.makeCompressed();
  system_.free_speed = system_.jacobian * u - vector_of(target_) + vector_of(bias_);
  system_.lower = vector_of(lower_);
  system_.upper = vector_of(upper_);
  system_.stored = vector_of(stored_);
  if (policy_.stored_has_acted)
    system_.free_speed -= system_.jacobian * (system_.push.transpose() * system_.stored);
  system_.bound_by = matrix_of(rows_, rows_, bound_by_);
  return std::move(system_);
}

}  // namespace

ConstraintSystem assemble(std::span<const SystemBody> bodies, std::span<const StatedConstraint> constraints,
                          const SystemPolicy& policy) {
  Assembler assembler(bodies, policy);
  std::int32_t number = 0;
  for (const StatedConstraint& constraint : constraints) assembler.add(number++, constraint);
  return assembler.finish();
}

}  // namespace scree
