// From points to the finished hull; see hull_build.h.
#define XXH_INLINE_ALL
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_stages.h>
#include <core/geometry/hull/hull_topology.h>
#include <core/world/fp_environment.h>
#include <core/world/limits.h>
#include <core/world/number_text.h>
#include <scree/error.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace scree {

namespace {

using Point = std::array<double, 3>;

// Largest ratio of half extent to grid step. With so many bits a coordinate relative to the centroid is a
// float.
constexpr int kGridBits = 23;
constexpr int kMostFlatBits = 24;  // how much finer than the largest one the step of a thin axis may be
// Share of the largest extent. The build drops points that stick out less, and the corners of one face lie
// this close to a plane. A few times the rounding of points that a program has turned in single precision.
constexpr double kTolerance = 5e-7;
constexpr double kToleranceUlps = 4.0;  // of the largest coordinate, for hulls far from their origin
constexpr double kToleranceOfThickness = 0.125;
// A thin tip can reach far although it lies close to every plane. The build repeats with a smaller tolerance
// if the hull misses a point by more than this many tolerances.
constexpr double kMostDeviation = 20.0;
constexpr double kSmallerTolerance = 0.125;
constexpr int kToleranceTries = 5;
constexpr double kMinThicknessOfExtent = 2e-6;  // sixteen grid steps: a thinner hull has no sides left
// Qhull takes 2 seconds for this many points on a sphere. Scans of bodies that are not round need fewer.
constexpr std::size_t kManyPoints = 100'000;
constexpr std::size_t kMaxPoints = std::numeric_limits<std::int32_t>::max();

std::string text_of(double value) { return number_text(value, 7); }

[[noreturn]] void fail(const std::string& who, const std::string& problem) {
  throw Error(who + ": " + problem);
}

void check_count(const std::string& who, std::size_t count) {
  if (count >= 4 && count <= kMaxPoints) return;
  fail(who, std::to_string(count) + " points, must be in [4, " + std::to_string(kMaxPoints) + "]");
}

void check_point(const std::string& who, std::size_t index, const Point& point) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (point[k] >= -double{kMaxExtent} && point[k] <= double{kMaxExtent}) continue;
    const double limit = double{kMaxExtent};
    fail(who, "point " + std::to_string(index) + ": " + "xyz"[k] + " is " + text_of(point[k]) +
                  ", must lie in [" + text_of(-limit) + ", " + text_of(limit) + "]");
  }
}

// Location of the points, and the resolution of their grid.
struct Grid {
  Point origin;     // m
  GridSteps step;   // m, powers of two
  double extent;    // m, the largest one of the points' box
  double farthest;  // m, the largest coordinate of the points
};

Grid make_grid(const std::string& who, const std::vector<Point>& points) {
  Point low = points[0], high = points[0];
  for (const Point& p : points) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  Grid grid{};
  for (std::size_t k = 0; k < 3; ++k) {
    grid.extent = std::max(grid.extent, high[k] - low[k]);
    grid.farthest = std::max({grid.farthest, -low[k], high[k]});
  }
  if (grid.extent < double{kMinExtent}) {
    fail(who, "the points' extent is " + text_of(grid.extent) + " m, must be at least " +
                  text_of(double{kMinExtent}) + " m");
  }
  int coarsest = 0;
  std::frexp(0.5 * grid.extent, &coarsest);
  for (std::size_t k = 0; k < 3; ++k) {
    int exponent = coarsest - kMostFlatBits;
    if (high[k] > low[k]) std::frexp(0.5 * (high[k] - low[k]), &exponent);
    grid.step[k] = std::ldexp(1.0, std::max(exponent, coarsest - kMostFlatBits) - kGridBits);
    grid.origin[k] = std::nearbyint(0.5 * (low[k] + high[k]) / grid.step[k]) * grid.step[k];
  }
  return grid;
}

// The points' places on the grid in ascending order, without duplicates, each with the first point that has
// it.
struct GridPoints {
  std::vector<GridPoint> places;
  std::vector<std::int32_t> point;
};

GridPoints place_on(const Grid& grid, const std::vector<Point>& points) {
  struct Entry {
    GridPoint place;
    std::int32_t point;
  };
  std::vector<Entry> entries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      // Round before subtracting the origin, so that half a step rounds the same way for every origin.
      const double place = std::nearbyint(points[i][k] / grid.step[k]) - grid.origin[k] / grid.step[k];
      entries[i].place[k] = static_cast<std::int32_t>(place);
    }
    entries[i].point = static_cast<std::int32_t>(i);
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.place != b.place ? a.place < b.place : a.point < b.point;
  });
  GridPoints result;
  for (const Entry& entry : entries) {
    if (!result.places.empty() && result.places.back() == entry.place) continue;
    result.places.push_back(entry.place);
    result.point.push_back(entry.point);
  }
  return result;
}

GridPoints subset(const GridPoints& all, const std::vector<std::int32_t>& indices) {
  GridPoints result;
  for (const std::int32_t index : indices) {
    result.places.push_back(all.places[static_cast<std::size_t>(index)]);
    result.point.push_back(all.point[static_cast<std::size_t>(index)]);
  }
  return result;
}

// Finds the points that can be corners of their hull. If there are very many, first drops those within a hull
// of the largest number of vertices. If very many remain even then, keeps all of them.
GridPoints find_extreme(const Grid& grid, const GridPoints& all) {
  if (all.places.size() <= kManyPoints) return subset(all, find_extreme_points(all.places));
  const TriangleHull hull = find_triangles(all.places, grid.step, {kMaxHullVertices, 0.0});
  if (hull.triangles.empty()) return all;
  std::vector<std::int32_t> candidates = hull.outside;
  for (const HullTriangle& triangle : hull.triangles) {
    candidates.insert(candidates.end(), triangle.vertex.begin(), triangle.vertex.end());
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  const GridPoints outer = subset(all, candidates);
  return outer.places.size() <= kManyPoints ? subset(outer, find_extreme_points(outer.places)) : outer;
}

// Least distance between two parallel planes that enclose the hull, one of them the plane of a triangle.
double thickness_of(const Grid& grid, std::span<const GridPoint> places, const TriangleHull& hull) {
  std::vector<std::int32_t> corners;
  for (const HullTriangle& triangle : hull.triangles) {
    corners.insert(corners.end(), triangle.vertex.begin(), triangle.vertex.end());
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const auto place = [&](std::int32_t i) -> const GridPoint& { return places[static_cast<std::size_t>(i)]; };
  double thickness = std::numeric_limits<double>::infinity();
  for (const HullTriangle& triangle : hull.triangles) {
    const GridPlane plane =
        plane_of(place(triangle.vertex[0]), place(triangle.vertex[1]), place(triangle.vertex[2]), grid.step);
    double depth = 0.0;
    for (const std::int32_t corner : corners) depth = std::max(depth, -plane.distance(place(corner)));
    thickness = std::min(thickness, depth);
  }
  return thickness;
}

bool is_line(const Grid& grid, std::span<const GridPoint> places) {
  return std::all_of(places.begin(), places.end(), [&](const GridPoint& p) {
    return plane_of(places.front(), places.back(), p, grid.step).inverse_length == 0.0;
  });
}

// In m.
double checked_thickness(const std::string& who, const Grid& grid, std::span<const GridPoint> places,
                         const TriangleHull& hull) {
  const double least = std::max(double{kMinExtent}, kMinThicknessOfExtent * grid.extent);
  const std::string limit = ": a hull must be at least " + text_of(least) + " m thick";
  if (hull.triangles.empty()) {
    fail(who, std::string("the points lie within a ") + (is_line(grid, places) ? "line" : "plane") + limit);
  }
  const double thickness = thickness_of(grid, places, hull);
  if (thickness < least * (1.0 - 1e-6)) {  // allows for the rounding of a hull of exactly that thickness
    fail(who, "the points' hull is " + text_of(thickness) + " m thick" + limit);
  }
  return thickness;
}

double tolerance_of(const Grid& grid) {
  const float farthest = static_cast<float>(grid.farthest);
  const double ulp = double{std::nextafter(farthest, std::numeric_limits<float>::infinity())} - farthest;
  return std::max(kTolerance * grid.extent, kToleranceUlps * ulp);
}

std::vector<Vec3> to_corners(const Grid& grid, const std::vector<GridPoint>& places,
                             const GridPoint& origin) {
  std::vector<Vec3> corners;
  const auto coordinate = [&](const GridPoint& place, std::size_t k) {
    return static_cast<float>((place[k] - origin[k]) * grid.step[k]);  // exact
  };
  for (const GridPoint& place : places) {
    corners.push_back({coordinate(place, 0), coordinate(place, 1), coordinate(place, 2)});
  }
  return corners;
}

std::uint64_t hash_of(const HullSolid& solid) {
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  const auto add = [&state](const auto& rows) {
    XXH64_update(&state, rows.data(), rows.size() * sizeof rows[0]);
  };
  add(solid.points);
  add(solid.topology.vertices);
  add(solid.topology.begin);
  add(solid.topology.loops);
  return XXH64_digest(&state);
}

// Intermediate results of hull building.
struct HullDraft {
  const std::vector<Point>& points;
  Grid grid;
  GridPoints all;
  GridPoints extreme;
};

HullReport make_report(const HullDraft& from, const TriangleHull& hull, const HullSolid& solid) {
  HullReport report;
  report.given_points = from.points.size();
  report.merged_points = from.points.size() - from.all.places.size();
  report.cut_vertices = hull.outside.size();
  report.inner_points = from.all.places.size() - hull.outside.size() - solid.points.size();
  std::vector<Point> outer;
  for (const std::int32_t index : from.extreme.point) {
    Point p = from.points[static_cast<std::size_t>(index)];
    for (std::size_t k = 0; k < 3; ++k) p[k] -= solid.origin[k];
    outer.push_back(p);
  }
  report.deviation = static_cast<float>(find_deviation(solid.topology, outer));
  return report;
}

// Makes all of the solid that complete_solid does not make.
std::shared_ptr<HullSolid> try_solid(const std::string& who, const HullDraft& from, int max_vertices,
                                     double tolerance) {
  const Grid& grid = from.grid;
  const TriangleHull hull = find_triangles(from.extreme.places, grid.step, {max_vertices, tolerance});
  const double thickness = checked_thickness(who, grid, from.extreme.places, hull);
  const HullPolygons polygons = find_polygons(who, from.extreme.places, grid.step, hull,
                                              std::min(tolerance, kToleranceOfThickness * thickness));
  const GridPoints corners = subset(from.extreme, polygons.corners);

  auto solid = std::make_shared<HullSolid>();
  // Build once about the grid's origin to find the centroid, and then once about the centroid.
  const HullIntegrals first = integrate(make_topology(to_corners(grid, corners.places, {}), polygons.loops));
  GridPoint center;
  for (std::size_t k = 0; k < 3; ++k) {
    center[k] = static_cast<std::int32_t>(std::lrint(first.center[k] / grid.step[k]));
    solid->origin[k] = grid.origin[k] + center[k] * grid.step[k];
  }
  solid->topology = make_topology(to_corners(grid, corners.places, center), polygons.loops);
  for (const std::int32_t index : corners.point) {
    const Point& p = from.points[static_cast<std::size_t>(index)];
    solid->points.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  solid->report = make_report(from, hull, *solid);
  return solid;
}

// Expects ascending points without duplicates; the report refers to these points, too.
std::shared_ptr<HullSolid> make_solid(const std::string& who, const std::vector<Point>& points,
                                      int max_vertices) {
  const Grid grid = make_grid(who, points);
  GridPoints all = place_on(grid, points);
  GridPoints extreme = find_extreme(grid, all);
  const HullDraft from{points, grid, std::move(all), std::move(extreme)};
  double tolerance = tolerance_of(grid);
  const double most = kMostDeviation * tolerance;
  std::shared_ptr<HullSolid> solid;
  for (int attempt = 0; attempt < kToleranceTries; ++attempt) {
    solid = try_solid(who, from, max_vertices, tolerance);
    if (solid->report.simplified() || solid->report.deviation <= most) break;
    tolerance *= kSmallerTolerance;
  }
  complete_solid(*solid);
  return solid;
}

// Sorts points and removes duplicates. Zero has one sign.
std::vector<Point> sorted(std::vector<Point> points) {
  for (Point& p : points) {
    for (double& x : p) x += 0.0;
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

}  // namespace

void complete_solid(HullSolid& solid) {
  solid.integrals = integrate(solid.topology);
  solid.columns = make_hull_columns(solid.topology);
  solid.balls = balls_of(*solid.columns.data);
  solid.content_hash = hash_of(solid);
}

std::size_t HullSolid::bytes() const {
  return sizeof *this + topology.vertices.capacity() * sizeof(Vec3) + topology.loops.capacity() +
         topology.begin.capacity() * sizeof(std::uint16_t) +
         topology.planes.capacity() * sizeof(HullTopology::Plane) +
         topology.edges.capacity() * sizeof(HullTopology::Edge) + points.capacity() * sizeof(Vec3) +
         columns.bytes;
}

std::shared_ptr<const HullSolid> build_hull(const std::string& who, std::span<const Vec3> points,
                                            const HullOptions& options) {
  const FpEnvironment environment;
  check_count(who, points.size());
  if (options.max_vertices < 4 || options.max_vertices > kMaxHullVertices) {
    fail(who, "max_vertices is " + std::to_string(options.max_vertices) + ", must lie in [4, " +
                  std::to_string(kMaxHullVertices) + "]");
  }
  std::vector<Point> all;
  all.reserve(points.size());
  for (const Vec3& p : points) {
    all.push_back({p.x, p.y, p.z});
    check_point(who, all.size() - 1, all.back());
  }
  auto solid = make_solid(who, sorted(std::move(all)), options.max_vertices);
  solid->report.merged_points += points.size() - solid->report.given_points;
  solid->report.given_points = points.size();
  return solid;
}

std::shared_ptr<const HullSolid> scale_hull(const std::string& who, const HullSolid& hull, Vec3 scale) {
  const FpEnvironment environment;
  std::vector<Point> points;
  for (const Vec3& p : hull.points) {
    points.push_back({double{p.x} * scale.x, double{p.y} * scale.y, double{p.z} * scale.z});
    check_point(who, points.size() - 1, points.back());
  }
  return make_solid(who, sorted(std::move(points)), kMaxHullVertices);
}

}  // namespace scree
