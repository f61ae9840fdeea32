// See pieces.h.
#include <core/geometry/decompose/pieces.h>

#include <algorithm>
#include <numeric>

namespace scree::decomposition {

namespace {

// Sets of numbers: trees whose root is the lowest one of a set.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  // For each number that of its set; sets are numbered by their lowest member.
  std::vector<std::uint32_t> numbers(std::uint32_t& count) {
    std::vector<std::uint32_t> number(parent_.size());
    count = 0;
    for (std::uint32_t i = 0; i < parent_.size(); ++i) number[i] = root(i) == i ? count++ : number[root(i)];
    return number;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// Triangles with a number each -> a piece for each number.
std::vector<Piece> collect(const Surface& surface, const std::vector<std::uint32_t>& number,
                           std::uint32_t count) {
  std::vector<Piece> pieces(count);
  constexpr auto kNone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> place(surface.points.size(), kNone);
  std::vector<std::uint32_t> owner(surface.points.size(), kNone);
  std::vector<std::uint32_t> order(surface.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return number[a] != number[b] ? number[a] < number[b] : a < b;
  });
  for (const std::uint32_t t : order) {
    Surface& own = pieces[number[t]].surface;
    Triangle& corners = own.triangles.emplace_back(surface.triangles[t]);
    for (std::uint32_t& corner : corners) {
      if (owner[corner] != number[t]) {
        owner[corner] = number[t];
        place[corner] = static_cast<std::uint32_t>(own.points.size());
        own.points.push_back(surface.points[corner]);
      }
      corner = place[corner];
    }
  }
  for (Piece& piece : pieces) piece.inside_out = piece.surface.volume() < 0.0;
  return pieces;
}

bool overlap(const Bounds& a, const Bounds& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (a.lower[k] > b.upper[k] || b.lower[k] > a.upper[k]) return false;
  }
  return true;
}

// Numbers of the groups in which pieces stay together.
std::vector<std::uint32_t> keep_hollows(const std::vector<Piece>& pieces, bool inside_out,
                                        std::uint32_t& count) {
  std::vector<Bounds> bounds;
  std::vector<std::uint32_t> outer;
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    bounds.push_back(pieces[i].surface.bounds());
    if (pieces[i].inside_out == inside_out) outer.push_back(i);
  }
  std::sort(outer.begin(), outer.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = bounds[a].lower[0], y = bounds[b].lower[0];
    return x != y ? x < y : a < b;
  });
  Sets sets(pieces.size());
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].inside_out == inside_out) continue;
    for (const std::uint32_t j : outer) {
      if (bounds[j].lower[0] > bounds[i].upper[0]) break;
      if (overlap(bounds[i], bounds[j])) sets.join(i, j);
    }
  }
  return sets.numbers(count);
}

// Halves the groups at their median along the longest axis until there are `limit`.
void bisect(const std::vector<Vector>& middles, std::span<std::uint32_t> groups, std::size_t limit,
            std::vector<std::uint32_t>& number, std::uint32_t& count) {
  if (limit <= 1 || groups.size() <= 1) {
    for (const std::uint32_t group : groups) number[group] = count;
    ++count;
    return;
  }
  Bounds spread{middles[groups[0]], middles[groups[0]]};
  for (const std::uint32_t group : groups) spread.include(middles[group]);
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (spread.upper[k] - spread.lower[k] > spread.upper[axis] - spread.lower[axis]) axis = k;
  }
  std::sort(groups.begin(), groups.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = middles[a][axis], y = middles[b][axis];
    return x != y ? x < y : a < b;
  });
  const std::size_t half = groups.size() / 2;
  bisect(middles, groups.first(half), limit / 2, number, count);
  bisect(middles, groups.subspan(half), limit - limit / 2, number, count);
}

}  // namespace

std::vector<Piece> find_pieces(const Surface& surface, std::size_t limit, std::size_t& joined) {
  Sets sets(surface.points.size());
  for (const auto& [a, b, c] : surface.triangles) {
    sets.join(a, b);
    sets.join(b, c);
  }
  std::uint32_t count = 0;
  std::vector<std::uint32_t> of_point = sets.numbers(count);
  // Numbered anew by the lowest triangle, because some points have none.
  std::vector<std::uint32_t> number, seen(count, static_cast<std::uint32_t>(-1));
  count = 0;
  for (const Triangle& triangle : surface.triangles) {
    std::uint32_t& known = seen[of_point[triangle[0]]];
    if (known == static_cast<std::uint32_t>(-1)) known = count++;
    number.push_back(known);
  }
  std::vector<Piece> pieces = collect(surface, number, count);
  const bool inside_out = surface.volume() < 0.0;
  std::vector<std::uint32_t> group = keep_hollows(pieces, inside_out, count);
  if (count > limit) {
    joined = count - limit;
    std::vector<Bounds> bounds(count);
    std::vector<bool> known(count, false);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Bounds own = pieces[i].surface.bounds();
      if (!known[group[i]]) bounds[group[i]] = own;
      known[group[i]] = true;
      bounds[group[i]].include(own.lower);
      bounds[group[i]].include(own.upper);
    }
    std::vector<Vector> middles;
    for (const Bounds& own : bounds) middles.push_back(0.5 * (own.lower + own.upper));
    std::vector<std::uint32_t> order(count), of_group(count);
    std::iota(order.begin(), order.end(), 0u);
    count = 0;
    bisect(middles, order, limit, of_group, count);
    for (std::uint32_t& own : group) own = of_group[own];
  }
  for (std::uint32_t& own : number) own = group[own];
  return collect(surface, number, count);
}

}  // namespace scree::decomposition
