// See parts.h. Joining takes the pair whose common hull adds least, as Mamou and Ghorbel (2009) do.
#include <core/geometry/decompose/parts.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace scree::decomposition {

namespace {

// Times the volume of the parts before any was joined: hulls that only overlap keep the concavity, too, but
// then count twice.
constexpr double kMostGrowth = 1.15;

struct Pair {
  std::size_t a = 0, b = 0;  // parts, a < b
  double growth = 0.0;       // m^3, that their common hull has beyond theirs
  double concavity = 0.0;    // m, of the common hull; at least this where it is above what is asked for
  bool is_good = false;      // keeps the concavity, and does not grow too much
};

// m, between bounds.
double gap(const Bounds& a, const Bounds& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double apart = std::max({a.lower[k] - b.upper[k], b.lower[k] - a.upper[k], 0.0});
    sum += apart * apart;
  }
  return std::sqrt(sum);
}

Shell common_shell(const CellPart& a, const CellPart& b, const Workshop& workshop) {
  std::vector<Vector> corners = a.shell.corners;
  corners.insert(corners.end(), b.shell.corners.begin(), b.shell.corners.end());
  return workshop.shell_of(corners);
}

class Joiner {
 public:
  Joiner(std::vector<CellPart>& parts, Workshop& workshop) : parts_(parts), workshop_(workshop) {
    gone_.assign(parts.size(), false);
    left_ = parts.size();
    for (std::size_t b = 0; b < parts.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) add_if_near(a, b);
    }
  }

  std::size_t left() const { return left_; }

  // The pair that adds least of those that keep the concavity.
  bool join_best() {
    const Pair* best = nullptr;
    for (const Pair& pair : pairs_) {
      if (!pair.is_good) continue;
      if (best == nullptr || before(pair, *best)) best = &pair;
    }
    if (best == nullptr) return false;
    join(*best);
    return true;
  }

  // The neighbors that reach out least, and grow least of those that keep the concavity; or the nearest parts
  // where there are no neighbors.
  void join_any() {
    const auto before_other = [&](const Pair& a, const Pair& b) {
      const double reach_a = std::max(a.concavity, workshop_.concavity);
      const double reach_b = std::max(b.concavity, workshop_.concavity);
      return reach_a != reach_b ? reach_a < reach_b : before(a, b);
    };
    const auto best = std::min_element(pairs_.begin(), pairs_.end(), before_other);
    join(best != pairs_.end() ? *best : nearest());
  }

  void remove_gone() {
    std::vector<CellPart> left;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (!gone_[i]) left.push_back(std::move(parts_[i]));
    }
    parts_ = std::move(left);
  }

 private:
  static bool before(const Pair& a, const Pair& b) {
    return std::tie(a.growth, a.a, a.b) < std::tie(b.growth, b.a, b.b);
  }

  void add_if_near(std::size_t a, std::size_t b) {
    if (gone_[a] || gone_[b] || !parts_[a].shell.is_solid() || !parts_[b].shell.is_solid()) return;
    if (gap(parts_[a].shell.bounds, parts_[b].shell.bounds) > workshop_.concavity) return;
    pairs_.push_back(measure(a, b));
  }

  Pair measure(std::size_t a, std::size_t b) {
    const Shell shell = common_shell(parts_[a], parts_[b], workshop_);
    Pair pair{a, b, shell.volume - parts_[a].shell.volume - parts_[b].shell.volume, 0.0, false};
    pair.concavity = workshop_.lattice.concavity(shell, workshop_.concavity);
    pair.is_good = pair.concavity <= workshop_.concavity &&
                   shell.volume <= kMostGrowth * (parts_[a].own_volume + parts_[b].own_volume);
    return pair;
  }

  Pair nearest() {
    Pair best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < parts_.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (gone_[a] || gone_[b]) continue;
        const double apart = gap(parts_[a].shell.bounds, parts_[b].shell.bounds);
        if (!(apart < least)) continue;
        least = apart;
        best.a = a;
        best.b = b;
      }
    }
    return measure(best.a, best.b);
  }

  // Both become a new part at the place of the first.
  void join(Pair pair) {
    CellPart& part = parts_[pair.a];
    CellPart& other = parts_[pair.b];
    part.shell = common_shell(part, other, workshop_);
    part.points.insert(part.points.end(), other.points.begin(), other.points.end());
    part.concavity = pair.concavity;
    part.own_volume += other.own_volume;
    part.solid = nullptr;
    part.fragments = {};
    other = {};
    gone_[pair.b] = true;
    --left_;
    std::erase_if(pairs_, [&](const Pair& old) {
      return old.a == pair.a || old.b == pair.a || old.a == pair.b || old.b == pair.b;
    });
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (i != pair.a) add_if_near(std::min(i, pair.a), std::max(i, pair.a));
    }
  }

  std::vector<CellPart>& parts_;
  Workshop& workshop_;
  std::vector<bool> gone_;
  std::vector<Pair> pairs_;
  std::size_t left_ = 0;
};

}  // namespace

std::size_t join_parts(std::vector<CellPart>& parts, std::size_t max_parts, Workshop& workshop,
                       std::size_t& merges) {
  Joiner joiner(parts, workshop);
  std::size_t against = 0;
  while (joiner.join_best()) ++merges;
  while (joiner.left() > max_parts) {
    joiner.join_any();
    ++merges;
    ++against;
  }
  joiner.remove_gone();
  return against;
}

}  // namespace scree::decomposition
