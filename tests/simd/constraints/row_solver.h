// A slow solver over stated rows, in double precision: the reference of the wide kernels of joints and
// contacts. It is the soft step written once for all kinds. It uses only the rows that
// core/plain/constraint_row.h describes, and knows nothing of hinges, wheels or contacts.
#pragma once

#include <core/plain/constraint_row.h>
#include <core/plain/rows.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace scree::row_tests {

// With the soft bias of a solve, or without it, after the poses have moved.
enum class Pass { solve, relax };

struct Softness {
  double bias_rate, mass_scale, impulse_scale;
};
inline constexpr Softness kRigid{0, 1, 0};

// Catto, "Soft Constraints", GDC 2011.
inline Softness soften(double hertz, double damping_ratio, double substep) {
  const double omega = 2 * std::numbers::pi * hertz;
  const double a1 = 2 * damping_ratio + substep * omega, a2 = substep * omega * a1;
  return {omega / a1, a2 / (1 + a2), 1 / (1 + a2)};
}

struct StepConstants {
  double substep;
  double max_hertz;   // of springs
  Softness stiff;     // of what joints hold and limit with hertz 0, in a solve
  Softness contact;   // of contact points, in a solve
  double push_speed;  // of limits and contacts
};

// v_a, w_a, v_b, w_b and rows of their kind.
using Twelve = std::array<double, 12>;
inline double dot(const Twelve& x, const Twelve& y) {
  double sum = 0;
  for (std::size_t i = 0; i < 12; ++i) sum += x[i] * y[i];
  return sum;
}

inline Twelve velocities(const VelocityRow& a, const VelocityRow& b) {
  Twelve v{};
  for (std::size_t i = 0; i < 3; ++i) {
    v[i] = double{a.linear[i]}, v[3 + i] = double{a.angular[i]};
    v[6 + i] = double{b.linear[i]}, v[9 + i] = double{b.angular[i]};
  }
  return v;
}

inline Twelve jacobian(const ConstraintRow& row) {
  Twelve j{};
  for (std::size_t i = 0; i < 3; ++i) {
    j[i] = double{row.linear_a[i]}, j[3 + i] = double{row.angular_a[i]};
    j[6 + i] = double{row.linear_b[i]}, j[9 + i] = double{row.angular_b[i]};
  }
  return j;
}

// M^-1 times a row.
inline Twelve respond(const InertiaRow& a, const InertiaRow& b, const Twelve& j) {
  Twelve push{};
  const auto turn = [&](const InertiaRow& body, std::size_t at) {
    const float* s = body.inverse_inertia;
    const std::size_t place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (std::size_t i = 0; i < 3; ++i) {
      push[at + i] = double{body.inverse_mass} * j[at + i];
      for (std::size_t k = 0; k < 3; ++k) push[at + 3 + i] += double{s[place[i][k]]} * j[at + 3 + k];
    }
  };
  turn(a, 0);
  turn(b, 6);
  return push;
}

using Matrix = std::vector<std::vector<double>>;

class RowSolver {
 public:
  // Impulses begin with those that the rows state, times `scale`.
  RowSolver(const ConstraintRows& rows, const InertiaRow& a, const InertiaRow& b,
            const StepConstants& constants, double scale)
      : constants_(constants), inertia_a_(a), inertia_b_(b) {
    for (std::size_t slot = 0; slot < kMaxConstraintRows; ++slot) {
      const ConstraintRow& said = rows.row[slot];
      const Twelve j = jacobian(said);
      rows_.push_back({said, j, respond(a, b, j), double{said.impulse} * scale});
    }
  }

  Twelve v{};  // of the bodies

  // The stored impulses.
  void warm_start() {
    for (const Solved& row : rows_) {
      if (row.said.kind != kRowNone) push(row, row.impulse);
    }
  }

  // What a substep after the first one adds to velocities: the impulses so far acted along the rows at the
  // poses before the last move, `before`, and are to act along those after it, `after`.
  void turn_inherited(const ConstraintRows& before, const ConstraintRows& after) {
    for (std::size_t slot = 0; slot < kMaxConstraintRows; ++slot) {
      const ConstraintRow &old = before.row[slot], &now = after.row[slot];
      if (old.kind == kRowNone) continue;
      const Twelve from = jacobian(old), to = jacobian(now);
      Twelve change{};
      for (std::size_t i = 0; i < 12; ++i)
        change[i] = to[i] * double{now.impulse} - from[i] * double{old.impulse};
      const Twelve turned = respond(inertia_a_, inertia_b_, change);
      for (std::size_t i = 0; i < 12; ++i) v[i] += turned[i];
    }
  }

  // Block after block, in the order of their first rows; what is held comes where its first row stands, or
  // before all if others keep it.
  void run(Pass pass) {
    pass_ = pass;
    std::vector<std::uint32_t> done;
    const auto solve_once = [&](std::uint32_t block) {
      if (std::find(done.begin(), done.end(), block) != done.end()) return;
      done.push_back(block);
      solve_block(members([block](const ConstraintRow& row) { return row.block == block; }));
    };
    for (const Solved& row : rows_) {
      if (row.said.kind == kRowNone || (row.said.flags & kRowKeepsHeld) == 0) continue;
      for (const std::size_t held : held_rows()) solve_once(rows_[held].said.block);
    }
    for (const Solved& row : rows_) {
      if (row.said.kind != kRowNone) solve_once(row.said.block);
    }
  }

  double impulse(std::size_t slot) const { return rows_[slot].impulse; }
  // Speed along a row by a unit impulse along it.
  double response(std::size_t slot) const { return response(slot, slot); }
  // The largest speed at which any row moved or aimed: the scale of rounding errors.
  double largest_speed() const { return largest_speed_; }

 private:
  struct Solved {
    ConstraintRow said;
    Twelve j, push;
    double impulse;
  };
  // The impulse of a row in this pass: change = -(mass_scale (J v - target + bias) / K + impulse_scale
  // impulse), with K larger by `yield` and `yield` impulse beside the bias.
  struct Wish {
    double bias;
    Softness soft;
    double yield;
  };

  template <class Which>
  std::vector<std::size_t> members(Which which) const {
    std::vector<std::size_t> slots;
    for (std::size_t slot = 0; slot < rows_.size(); ++slot) {
      if (rows_[slot].said.kind != kRowNone && which(rows_[slot].said)) slots.push_back(slot);
    }
    return slots;
  }
  std::vector<std::size_t> held_rows() const {
    return members([](const ConstraintRow& row) { return row.kind == kRowHeld; });
  }

  Softness spring(const ConstraintRow& row) const {
    return soften(std::min(double{row.hertz}, constants_.max_hertz), double{row.damping_ratio},
                  constants_.substep);
  }
  // Relax is rigid and without bias, except for what the user made soft.
  Softness held_softness(const ConstraintRow& row) const {
    if (row.hertz > 0) return spring(row);
    return pass_ == Pass::solve ? constants_.stiff : kRigid;
  }

  Wish wish_of(const ConstraintRow& row) const {
    const double error = double{row.error}, bounded = constants_.push_speed;
    switch (row.kind) {
      case kRowHeld: {
        const Softness soft = held_softness(row);
        return {soft.bias_rate * error, soft, 0};
      }
      case kRowLimit: {
        const bool both_ways = row.lower < 0;
        // Apart: the end may be reached within the substep and no farther.
        if (!both_ways && error > 0) return {error / constants_.substep, kRigid, 0};
        const Softness soft = held_softness(row);
        const bool is_bounded = row.hertz == 0 || (row.flags & kRowOneEndOfCircle) != 0;
        const double back = soft.bias_rate * error;
        return {is_bounded ? std::clamp(back, -bounded, bounded) : back, soft, 0};
      }
      case kRowSpring: {
        const Softness soft = spring(row);
        if (!(row.reference_response > 0)) return {soft.bias_rate * error, soft, 0};
        return {soft.bias_rate * error, kRigid,
                double{row.reference_response} * soft.impulse_scale / soft.mass_scale};
      }
      case kRowContact: {
        if (error > 0) return {error / constants_.substep, kRigid, 0};
        if (pass_ == Pass::relax) return {0, kRigid, 0};
        const Softness& soft = constants_.contact;
        return {std::max(soft.bias_rate * error, -bounded), soft, 0};
      }
      default:
        return {0, kRigid, 0};
    }
  }

  // A spring limit pulls only after it has been passed. Friction acts only in relax.
  bool is_idle(const ConstraintRow& row) const {
    if (pass_ == Pass::solve)
      return row.kind == kRowTwist || row.kind == kRowFriction || row.kind == kRowRolling;
    return false;
  }
  bool gives_nothing(const ConstraintRow& row) const {
    return row.kind == kRowLimit && row.lower == 0 && row.hertz > 0 && row.error > 0;
  }

  double response(std::size_t x, std::size_t y) const { return dot(rows_[x].j, rows_[y].push); }

  // x = K^-1 x of the held rows.
  std::vector<double> divide(const std::vector<std::size_t>& slots, std::vector<double> x) const {
    const std::size_t n = slots.size();
    Matrix k(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) k[i][j] = response(slots[i], slots[j]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t r = i + 1; r < n; ++r) {
        const double part = k[r][i] / k[i][i];
        for (std::size_t c = i; c < n; ++c) k[r][c] -= part * k[i][c];
        x[r] -= part * x[i];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t c = i + 1; c < n; ++c) x[i] -= k[i][c] * x[c];
      x[i] /= k[i][i];
    }
    return x;
  }

  void push(const Solved& row, double by) {
    for (std::size_t i = 0; i < 12; ++i) v[i] += row.push[i] * by;
  }

  void solve_block(const std::vector<std::size_t>& slots) {
    if (is_idle(rows_[slots[0]].said)) return;
    const bool keeps = (rows_[slots[0]].said.flags & kRowKeepsHeld) != 0;
    const std::vector<std::size_t> held = keeps ? held_rows() : std::vector<std::size_t>{};
    const std::size_t n = slots.size();
    // By free row: impulses on the held ones that keep their speeds.
    Matrix keeping(n);
    // A soft row yields, and answers to a rigid hold with more than was taken from it.
    const double hold = held.empty() ? 0.0 : held_softness(rows_[held[0]].said).mass_scale;
    Matrix k(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<double> met(held.size());
      for (std::size_t h = 0; h < held.size(); ++h) met[h] = response(held[h], slots[i]);
      keeping[i] = held.empty() ? met : divide(held, met);
    }
    std::vector<Wish> wish;
    std::vector<double> wanted(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Solved& row = rows_[slots[i]];
      wish.push_back(wish_of(row.said));
      for (std::size_t j = 0; j < n; ++j) {
        k[i][j] = response(slots[i], slots[j]);
        for (std::size_t h = 0; h < held.size(); ++h)
          k[i][j] -= hold * response(slots[i], held[h]) * keeping[j][h];
      }
      k[i][i] += wish[i].yield;
      const double speed = dot(row.j, v);
      largest_speed_ = std::max({largest_speed_, std::abs(speed), std::abs(wish[i].bias)});
      wanted[i] = speed - double{row.said.target_speed} + wish[i].bias + wish[i].yield * row.impulse;
    }
    const std::vector<double> change = bounded(slots, k, changes(slots, k, wanted, wish));
    for (std::size_t i = 0; i < n; ++i) {
      Solved& row = rows_[slots[i]];
      row.impulse += change[i];
      push(row, change[i]);
      for (std::size_t h = 0; h < held.size(); ++h) {
        const double by = -hold * keeping[i][h] * change[i];
        rows_[held[h]].impulse += by;
        push(rows_[held[h]], by);
      }
    }
  }

  // With K = L D L^T, in coordinates in which rows are independent: L^T impulse and L^-1 speed. There each
  // row may have a softness of its own; of equal ones the order does not matter.
  std::vector<double> changes(const std::vector<std::size_t>& slots, Matrix k, std::vector<double> wanted,
                              const std::vector<Wish>& wish) const {
    const std::size_t n = slots.size();
    Matrix lower(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t r = i + 1; r < n; ++r) {
        lower[r][i] = k[r][i] / k[i][i];
        for (std::size_t c = i; c < n; ++c) k[r][c] -= lower[r][i] * k[i][c];
        wanted[r] -= lower[r][i] * wanted[i];
      }
    }
    std::vector<double> change(n);
    for (std::size_t i = n; i-- > 0;) {
      double old = rows_[slots[i]].impulse;
      for (std::size_t r = i + 1; r < n; ++r) old += lower[r][i] * rows_[slots[r]].impulse;
      change[i] = -(wish[i].soft.mass_scale * wanted[i] / k[i][i] + wish[i].soft.impulse_scale * old);
      for (std::size_t r = i + 1; r < n; ++r) change[i] -= lower[r][i] * change[r];
    }
    return change;
  }

  // `k`: the response of the slots to each other.
  std::vector<double> bounded(const std::vector<std::size_t>& slots, const Matrix& k,
                              std::vector<double> change) const {
    const ConstraintRow& first = rows_[slots[0]].said;
    if (first.kind == kRowHeld) return change;
    double more = 0;  // that other rows' impulses allow
    for (std::size_t i = 0; i < 4; ++i) more += double{first.bound_by[i]} * rows_[i].impulse;
    const auto most = [&](const ConstraintRow& row) { return double{row.upper} * constants_.substep + more; };
    const auto least = [&](const ConstraintRow& row) {
      return double{row.lower} * constants_.substep - more;
    };
    if ((first.flags & kRowBoundsLength) != 0) {
      double square = 0;
      for (std::size_t i = 0; i < slots.size(); ++i) {
        const double free = rows_[slots[i]].impulse + change[i];
        square += free * free;
      }
      return std::sqrt(square) > most(first) ? opposed(slots, k, change, most(first)) : change;
    }
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const Solved& row = rows_[slots[i]];
      const double next =
          gives_nothing(row.said) ? 0 : std::clamp(row.impulse + change[i], least(row.said), most(row.said));
      change[i] = next - row.impulse;
    }
    return change;
  }

  // Coulomb's law: friction that slides opposes the slip w, and so does a drive at its largest force. The old
  // impulses go against it by the largest eigenvalue of K, of three rows by its trace: that stops w along no
  // axis too far. `change` would stop all of it: w = -K change.
  std::vector<double> opposed(const std::vector<std::size_t>& slots, const Matrix& k,
                              std::vector<double> change, double limit) const {
    const std::size_t n = slots.size();
    double most = 0, square = 0;
    for (std::size_t i = 0; i < n; ++i) most += k[i][i];
    if (n == 2) most = 0.5 * most + std::hypot(0.5 * (k[0][0] - k[1][1]), k[0][1]);
    std::vector<double> next(n);
    for (std::size_t i = 0; i < n; ++i) {
      next[i] = rows_[slots[i]].impulse;
      for (std::size_t j = 0; j < n; ++j) next[i] += k[i][j] * change[j] / most;
      square += next[i] * next[i];
    }
    const double scale = std::min(limit / std::sqrt(square), 1.0);
    for (std::size_t i = 0; i < n; ++i) change[i] = next[i] * scale - rows_[slots[i]].impulse;
    return change;
  }

  std::vector<Solved> rows_;
  StepConstants constants_;
  InertiaRow inertia_a_, inertia_b_;
  Pass pass_ = Pass::solve;
  double largest_speed_ = 0;
};

}  // namespace scree::row_tests
