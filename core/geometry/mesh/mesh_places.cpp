// See mesh_places.h.
#include <core/geometry/mesh/mesh_places.h>

#include <algorithm>
#include <bit>

namespace scree {

namespace {

// Ascends with the number; zeros of both signs are one.
std::uint32_t ascending_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0f);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

struct Point {
  std::uint64_t xy;
  std::uint32_t z, index;
};

bool is_before(const Point& a, const Point& b) { return a.xy != b.xy ? a.xy < b.xy : a.z < b.z; }

}  // namespace

Places find_places(std::span<const Vec3> points) {
  std::vector<Point> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint64_t x = ascending_bits(points[i].x);
    order[i] = {x << 32 | ascending_bits(points[i].y), ascending_bits(points[i].z),
                static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end(), is_before);
  Places places{std::vector<std::uint32_t>(points.size()), 0};
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || is_before(order[i - 1], order[i])) ++places.count;
    places.of_point[order[i].index] = places.count - 1;
  }
  return places;
}

}  // namespace scree
