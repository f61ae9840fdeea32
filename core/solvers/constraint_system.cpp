// From stated rows to a system. See constraint_system.h.
#include <core/solvers/constraint_system.h>

#include <algorithm>
#include <cmath>
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

// Writes one constraint's rows.
class Assembler {
 public:
  Assembler(std::span<const SystemBody> bodies, const SystemPolicy& policy)
      : bodies_(bodies), policy_(policy) {}

  void add(std::int32_t number, const StatedConstraint& constraint);
  ConstraintSystem finish();

 private:
  struct Entry {
    double bias = 0, compliance = 0;
  };
  bool is_idle(const ConstraintRow& row) const {
    return row.kind == kRowNone ||
           (policy_.pass == SystemPolicy::Pass::solve &&
            (row.kind == kRowTwist || row.kind == kRowFriction || row.kind == kRowRolling));
  }
  bool is_rigid_now() const { return policy_.pass == SystemPolicy::Pass::relax; }
  Spring stiffness(const ConstraintRow& row) const;
  Entry entry_of(const ConstraintRow& row, double response, bool against_static) const;
  // J and J M^-1 of a row on one of its bodies.
  double put(int row, std::int32_t body, const float (&linear)[3], const float (&angular)[3]);

  std::span<const SystemBody> bodies_;
  const SystemPolicy& policy_;
  int rows_ = 0;
  Triplets jacobian_, push_, bound_by_;
  std::vector<double> bias_, compliance_, lower_, upper_, stored_, target_;
  ConstraintSystem system_;
};

Spring Assembler::stiffness(const ConstraintRow& row) const {
  if (row.hertz > 0)
    return spring_of(std::min<double>(row.hertz, policy_.max_hertz), row.damping_ratio, policy_.substep);
  if (is_rigid_now()) return kRigid;
  return spring_of(policy_.joint_hertz, policy_.joint_damping_ratio, policy_.substep);
}

Assembler::Entry Assembler::entry_of(const ConstraintRow& row, double response, bool against_static) const {
  const double error = row.error, most = policy_.push_speed;
  const auto soft = [&](const Spring& spring) {
    const double unit = row.reference_response > 0 ? double{row.reference_response} : response;
    return Entry{spring.bias_rate * error, spring.compliance * unit};
  };
  switch (row.kind) {
    case kRowHeld:
      return soft(stiffness(row));
    case kRowSpring:
      return soft(
          spring_of(std::min<double>(row.hertz, policy_.max_hertz), row.damping_ratio, policy_.substep));
    case kRowLimit: {
      // Apart: the end may be reached within the substep and no farther.
      if (row.lower == 0 && error > 0) return {error / policy_.substep, 0};
      Entry entry = soft(stiffness(row));
      if (row.hertz == 0 || (row.flags & kRowOneEndOfCircle) != 0)
        entry.bias = std::clamp(entry.bias, -most, most);
      return entry;
    }
    case kRowContact: {
      if (error > 0) return {error / policy_.substep, 0};
      if (is_rigid_now()) return {};
      Entry entry = soft(
          against_static
              ? spring_of(policy_.static_contact_hertz, policy_.static_contact_damping_ratio, policy_.substep)
              : spring_of(policy_.contact_hertz, policy_.contact_damping_ratio, policy_.substep));
      entry.bias = std::max(entry.bias, -most);
      return entry;
    }
    default:
      return {};
  }
}

double Assembler::put(int row, std::int32_t body, const float (&linear)[3], const float (&angular)[3]) {
  const InertiaRow& inverse = bodies_[static_cast<std::size_t>(body)].inverse;
  const float* s = inverse.inverse_inertia;
  const std::size_t place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  double response = 0;
  for (int i = 0; i < 3; ++i) {
    const double along = linear[i], about = angular[i];
    double turn = 0;
    for (int k = 0; k < 3; ++k) turn += double{s[place[i][k]]} * double{angular[k]};
    const double pushes = double{inverse.inverse_mass} * along;
    response += along * pushes + about * turn;
    jacobian_.emplace_back(row, 6 * body + i, along);
    jacobian_.emplace_back(row, 6 * body + 3 + i, about);
    push_.emplace_back(row, 6 * body + i, pushes);
    push_.emplace_back(row, 6 * body + 3 + i, turn);
  }
  return response;
}

void Assembler::add(std::int32_t number, const StatedConstraint& constraint) {
  int place[kMaxConstraintRows];
  std::uint32_t last_block = ~0u;
  const bool against_static =
      bodies_[static_cast<std::size_t>(constraint.body_a)].inverse.inverse_mass == 0 ||
      bodies_[static_cast<std::size_t>(constraint.body_b)].inverse.inverse_mass == 0;
  for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
    const ConstraintRow& row = constraint.rows.row[slot];
    place[slot] = -1;
    if (is_idle(row)) continue;
    place[slot] = rows_;
    const double response = put(rows_, constraint.body_a, row.linear_a, row.angular_a) +
                            put(rows_, constraint.body_b, row.linear_b, row.angular_b);
    const Entry entry = entry_of(row, response, against_static);
    bias_.push_back(entry.bias);
    compliance_.push_back(entry.compliance);
    target_.push_back(row.kind == kRowContact || row.kind == kRowLimit ? 0.0 : double{row.target_speed});
    const bool is_free = row.kind == kRowHeld;
    const bool gives_nothing = row.kind == kRowLimit && row.lower == 0 && row.hertz > 0 && row.error > 0;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    lower_.push_back(is_free ? -kNone : gives_nothing ? 0 : double{row.lower} * policy_.substep);
    upper_.push_back(is_free ? kNone : gives_nothing ? 0 : double{row.upper} * policy_.substep);
    stored_.push_back(row.impulse);
    for (int by = 0; by < 4 && by < slot; ++by) {
      if (row.bound_by[by] != 0 && place[by] >= 0)
        bound_by_.emplace_back(rows_, place[by], double{row.bound_by[by]});
    }
    const bool bounds_length = (row.flags & kRowBoundsLength) != 0;
    if (bounds_length && row.block == last_block) {
      ++system_.blocks.back().count;
    } else {
      system_.blocks.push_back({rows_, 1, bounds_length});
    }
    last_block = bounds_length ? row.block : ~0u;
    system_.constraint.push_back(number);
    system_.slot.push_back(slot);
    ++rows_;
  }
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
  system_.jacobian = matrix_of(rows_, 6 * bodies, jacobian_);
  system_.push = matrix_of(rows_, 6 * bodies, push_);
  system_.compliance = vector_of(compliance_);
  system_.matrix = system_.push * SystemMatrix(system_.jacobian.transpose());
  for (int row = 0; row < rows_; ++row)
    system_.matrix.coeffRef(row, row) += compliance_[static_cast<std::size_t>(row)];
  system_.matrix.makeCompressed();
  system_.free_speed = system_.jacobian * u - vector_of(target_) + vector_of(bias_);
  system_.lower = vector_of(lower_);
  system_.upper = vector_of(upper_);
  system_.stored = vector_of(stored_);
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
