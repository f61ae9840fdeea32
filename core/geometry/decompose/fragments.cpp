// See fragments.h.
#include <core/geometry/decompose/fragments.h>

#include <algorithm>
#include <cmath>

namespace scree::decomposition {

namespace {

constexpr auto kNone = static_cast<std::uint32_t>(-1);

// One side of a cut while it is filled.
struct Side {
  Fragments fragments;
  std::vector<std::uint32_t> place;  // of the points of the whole, or kNone

  void corner(const Fragments& all, std::uint32_t point) {
    if (place[point] == kNone) {
      place[point] = static_cast<std::uint32_t>(fragments.points.size());
      fragments.points.push_back(all.points[point]);
    }
    fragments.corners.push_back(place[point]);
  }
  void corner(const Vector& point) {
    fragments.corners.push_back(static_cast<std::uint32_t>(fragments.points.size()));
    fragments.points.push_back(point);
  }
  void end_polygon() {
    std::vector<std::uint32_t>& corners = fragments.corners;
    if (corners.size() - fragments.begin.back() < 3) {
      corners.resize(fragments.begin.back());
    } else {
      fragments.begin.push_back(static_cast<std::uint32_t>(corners.size()));
    }
  }
};

// Where the edge passes the plane: the same for both polygons of an edge, which pass it in opposite
// directions.
Vector crossing(const Vector& a, double height_a, const Vector& b, double height_b) {
  if (height_a > height_b) return crossing(b, height_b, a, height_a);
  return a + (height_a / (height_a - height_b)) * (b - a);
}

Vector area_of(const Fragments& all, std::size_t polygon) {
  Vector sum{};
  const std::uint32_t first = all.begin[polygon], end = all.begin[polygon + 1];
  const Vector& origin = all.points[all.corners[first]];
  for (std::uint32_t i = first + 2; i < end; ++i) {
    sum = sum + cross(all.points[all.corners[i - 1]] - origin, all.points[all.corners[i]] - origin);
  }
  return sum;
}

}  // namespace

Fragments make_fragments(const Surface& surface) {
  Fragments all;
  all.points = surface.points;
  for (const Triangle& triangle : surface.triangles) {
    all.corners.insert(all.corners.end(), triangle.begin(), triangle.end());
    all.begin.push_back(static_cast<std::uint32_t>(all.corners.size()));
  }
  return all;
}

std::array<Fragments, 2> divide(const Fragments& all, const Plane& plane, bool inside_out, double tolerance) {
  std::vector<double> heights;
  heights.reserve(all.points.size());
  for (const Vector& point : all.points) heights.push_back(plane.height(point));
  Side sides[2];
  for (Side& side : sides) side.place.assign(all.points.size(), kNone);
  for (std::size_t polygon = 0; polygon < all.size(); ++polygon) {
    const std::uint32_t first = all.begin[polygon], end = all.begin[polygon + 1];
    bool below = false, above = false;
    for (std::uint32_t i = first; i < end; ++i) {
      below = below || heights[all.corners[i]] < -tolerance;
      above = above || heights[all.corners[i]] > tolerance;
    }
    if (!below && !above) {
      const double facing = dot(area_of(all, polygon), plane.normal);
      if (facing == 0.0) continue;
      below = (facing > 0.0) != inside_out;
      above = !below;
    }
    if (below != above) {
      Side& side = sides[above ? 1 : 0];
      for (std::uint32_t i = first; i < end; ++i) side.corner(all, all.corners[i]);
      side.end_polygon();
      continue;
    }
    for (std::uint32_t i = first; i < end; ++i) {
      const std::uint32_t a = all.corners[i], b = all.corners[i + 1 < end ? i + 1 : first];
      if (heights[a] <= tolerance) sides[0].corner(all, a);
      if (heights[a] >= -tolerance) sides[1].corner(all, a);
      const bool passes = (heights[a] < -tolerance && heights[b] > tolerance) ||
                          (heights[a] > tolerance && heights[b] < -tolerance);
      if (!passes) continue;
      const Vector point = crossing(all.points[a], heights[a], all.points[b], heights[b]);
      for (Side& side : sides) side.corner(point);
    }
    for (Side& side : sides) side.end_polygon();
  }
  return {std::move(sides[0].fragments), std::move(sides[1].fragments)};
}

Fragments simplify(const Fragments& all, double cells) {
  constexpr std::size_t kSmall = 600;  // polygons
  if (all.size() <= kSmall) return all;
  Bounds bounds{all.points[0], all.points[0]};
  for (const Vector& point : all.points) bounds.include(point);
  const Vector middle = 0.5 * (bounds.lower + bounds.upper);
  const double scale = cells / bounds.extent();
  struct Entry {
    std::array<std::int32_t, 3> cube;
    double distance;  // m^2, from the middle: the outermost point of a cube stays
    std::uint32_t point;
  };
  std::vector<Entry> entries;
  for (std::uint32_t i = 0; i < all.points.size(); ++i) {
    const Vector way = all.points[i] - middle;
    Entry entry{{}, dot(way, way), i};
    for (std::size_t k = 0; k < 3; ++k) {
      entry.cube[k] = static_cast<std::int32_t>((all.points[i][k] - bounds.lower[k]) * scale);
    }
    entries.push_back(entry);
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    if (a.cube != b.cube) return a.cube < b.cube;
    return a.distance != b.distance ? a.distance > b.distance : a.point < b.point;
  });
  std::vector<std::uint32_t> kept(all.points.size());
  Fragments few;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].cube != entries[i - 1].cube) few.points.push_back(all.points[entries[i].point]);
    kept[entries[i].point] = static_cast<std::uint32_t>(few.points.size() - 1);
  }
  for (std::size_t polygon = 0; polygon < all.size(); ++polygon) {
    const std::uint32_t start = few.begin.back();
    for (std::uint32_t i = all.begin[polygon]; i < all.begin[polygon + 1]; ++i) {
      const std::uint32_t point = kept[all.corners[i]];
      if (few.corners.size() > start && few.corners.back() == point) continue;
      few.corners.push_back(point);
    }
    while (few.corners.size() > start + 1 && few.corners.back() == few.corners[start]) few.corners.pop_back();
    if (few.corners.size() - start < 3) {
      few.corners.resize(start);
    } else {
      few.begin.push_back(static_cast<std::uint32_t>(few.corners.size()));
    }
  }
  return few;
}

}  // namespace scree::decomposition
