// What lies behind the edges of triangles, as core/plain/mesh.h states it.
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/mesh/mesh_stages.h>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

constexpr EdgeTurn kRim{0, kTurnUnit};

Vector unit(const Vector& v) { return (1.0 / std::sqrt(dot(v, v))) * v; }

// Cosine and sine of the angle by which the surface turns down, of any common length.
struct Turn {
  double cosine, sine;
};

// Ascends with the angle from -pi, where the neighbor rises back over the triangle, to pi, where it lies on
// the triangle's back. A sine of 0 with a negative cosine is taken for pi.
double height_order(const Turn& turn) {
  const double sine = std::abs(turn.sine), cosine = turn.cosine;
  const double from_flat = cosine >= 0.0 ? sine / (cosine + sine) : 1.0 - cosine / (sine - cosine);
  return turn.sine < 0.0 ? -from_flat : from_flat;
}

EdgeTurn rounded(const Turn& turn) {
  const double scale = kTurnUnit / std::sqrt(turn.cosine * turn.cosine + turn.sine * turn.sine);
  const auto whole = [&](double value) { return static_cast<std::int16_t>(std::lrint(scale * value)); };
  EdgeTurn result{whole(turn.cosine), whole(turn.sine)};
  // Only a flat seam has a sine of 0: a neighbor that is folded back is a ridge or a valley.
  if (result.sine == 0 && result.cosine < 0) result.sine = turn.sine < 0.0 ? -1 : 1;
  return result;
}

// Of the points of a plane that is not along the axes, rounding leaves no plane. What lies no farther off
// than some roundings is flat, so that things slide over it as over one triangle.
constexpr double kFlatness = 0x1p-21;  // of the largest coordinate; 8 times what one rounding may be

struct Surface {
  std::span<const Vec3> points;
  std::span<const Corners> triangles;
  std::vector<Vector> normals;  // unit

  Vector point(std::uint32_t pass, std::size_t step) const {
    return to_vector(points[triangles[pass / 3][(pass % 3 + step) % 3]]);
  }
  const Vector& normal(std::uint32_t pass) const { return normals[pass / 3]; }
};

// Whether one of the two triangles at an edge reaches into the plane of the other one.
bool is_flat(const Surface& surface, std::uint32_t own, std::uint32_t other) {
  const Vector begin = surface.point(own, 0), end = surface.point(own, 1);
  const Vector tip = surface.point(own, 2), other_tip = surface.point(other, 2);
  double largest = 0.0;
  for (const Vector& point : {begin, end, tip, other_tip}) {
    for (const double coordinate : point) largest = std::max(largest, std::abs(coordinate));
  }
  const double height = std::min(std::abs(dot(surface.normal(own), other_tip - begin)),
                                 std::abs(dot(surface.normal(other), tip - begin)));
  return height <= kFlatness * largest;
}

Turn turn_between(const Surface& surface, std::uint32_t own, std::uint32_t other) {
  const Vector along = unit(surface.point(own, 1) - surface.point(own, 0));
  const Vector &normal = surface.normal(own), &behind = surface.normal(other);
  const Turn turn{dot(normal, behind), dot(along, cross(normal, behind))};
  return turn.cosine > 0.0 && is_flat(surface, own, other) ? Turn{1.0, 0.0} : turn;
}

// Unit normals of all triangles.
std::vector<Vector> find_normals(std::span<const Vec3> points, std::span<const Corners> triangles) {
  std::vector<Vector> normals;
  normals.reserve(triangles.size());
  for (const Corners& corner : triangles) {
    const Vector a = to_vector(points[corner[0]]);
    normals.push_back(unit(cross(to_vector(points[corner[1]]) - a, to_vector(points[corner[2]]) - a)));
  }
  return normals;
}

}  // namespace

std::vector<MeshTurns> find_turns(std::span<const Vec3> points, std::span<const Corners> triangles) {
  const Surface surface{points, triangles, find_normals(points, triangles)};
  std::vector<MeshTurns> turns(triangles.size(), MeshTurns{{kRim, kRim, kRim}});
  each_edge(sort_edges(triangles, points.size()), [&](std::span<const EdgePass> passes) {
    for (const EdgePass& own : passes) {
      bool found = false;
      Turn highest{};
      for (const EdgePass& other : passes) {
        // Neighbors that pass the edge the same way look to the other side.
        if (goes_down(triangles, other.pass) == goes_down(triangles, own.pass)) continue;
        const Turn turn = turn_between(surface, own.pass, other.pass);
        if (found && height_order(turn) >= height_order(highest)) continue;
        highest = turn;
        found = true;
      }
      if (found) turns[own.pass / 3].edge[own.pass % 3] = rounded(highest);
    }
  });
  return turns;
}

}  // namespace scree
