// Random worlds of all shapes, and the answers of queries by brute force over all of them, in double
// precision and by other methods: distances from points, which are convex functions along lines.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace scree::testing {

struct Point {
  double x = 0.0, y = 0.0, z = 0.0;
};
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator*(double s, Point a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Point a) { return std::sqrt(dot(a, a)); }
inline Point to_point(Vec3 v) { return {v.x, v.y, v.z}; }
inline Point turn(Quat q, Point v) {
  const Point r{q.x, q.y, q.z};
  const double size = dot(r, r) + static_cast<double>(q.w) * q.w;
  const Point t = (2.0 / size) * cross(r, v);
  return v + static_cast<double>(q.w) * t + cross(r, t);
}
inline Quat back(Quat q) { return {-q.x, -q.y, -q.z, q.w}; }

// A shape as its owner gave it, in the world.
struct Placed {
  Geometry geometry;
  Point position;
  Quat rotation;
};

inline Point to_local(const Placed& placed, Point p) {
  return turn(back(placed.rotation), p - placed.position);
}

inline std::vector<Point> hull_corners(const ConvexHull& convex) {
  std::vector<Point> corners;
  for (const Vec3& v : convex.hull.vertices()) {
    corners.push_back(
        {double{v.x} * convex.scale.x, double{v.y} * convex.scale.y, double{v.z} * convex.scale.z});
  }
  return corners;
}

// How far a point lies beyond a hull's planes at most; below zero within it.
inline double beyond_planes(const ConvexHull& convex, Point p) {
  const std::vector<Point> corners = hull_corners(convex);
  double most = -1e300;
  for (std::size_t f = 0; f < convex.hull.face_count(); ++f) {
    const auto loop = convex.hull.face(f);
    Point normal;
    const Point first = corners[loop[0]];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      normal = normal + cross(corners[loop[i]] - first, corners[loop[(i + 1) % loop.size()]] - first);
    }
    most = std::max(most, dot(normal, p - first) / norm(normal));
  }
  return most;
}

inline double to_triangle(Point p, Point a, Point b, Point c) {
  const Point normal = cross(b - a, c - a);
  const auto to_edge = [&p](Point from, Point to) {
    const double t = dot(p - from, to - from) / std::max(dot(to - from, to - from), 1e-300);
    return norm(p - (from + std::clamp(t, 0.0, 1.0) * (to - from)));
  };
  const bool within = dot(cross(normal, b - a), p - a) >= 0.0 && dot(cross(normal, c - b), p - b) >= 0.0 &&
                      dot(cross(normal, a - c), p - c) >= 0.0;
  if (within && norm(normal) > 0.0) return std::abs(dot(normal, p - a)) / norm(normal);
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

// The distance from a hull without its rounding; within it, minus that to the nearest plane.
inline double beyond_core(const ConvexHull& convex, Point p) {
  const double planes = beyond_planes(convex, p);
  if (planes <= 0.0) return planes;
  const std::vector<Point> corners = hull_corners(convex);
  double least = 1e300;
  for (std::size_t f = 0; f < convex.hull.face_count(); ++f) {
    const auto loop = convex.hull.face(f);
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      least = std::min(least, to_triangle(p, corners[loop[0]], corners[loop[i]], corners[loop[i + 1]]));
  }
  return least;
}

// A convex function that is zero on the shape's surface, below zero within and above it outside; near the
// surface of round shapes and beside faces it is the distance.
inline double beyond(const Placed& placed, Point world_point) {
  const Point p = to_local(placed, world_point);
  if (const auto* sphere = std::get_if<Sphere>(&placed.geometry)) return norm(p) - sphere->radius;
  if (const auto* capsule = std::get_if<Capsule>(&placed.geometry)) {
    const double half = capsule->half_height;
    return norm(p - Point{0.0, std::clamp(p.y, -half, half), 0.0}) - capsule->radius;
  }
  if (const auto* box = std::get_if<Box>(&placed.geometry)) {
    const Vec3 h = box->half_extents;
    const Point out{std::abs(p.x) - h.x, std::abs(p.y) - h.y, std::abs(p.z) - h.z};
    const double most = std::max({out.x, out.y, out.z});
    if (box->rounding == 0.0f || most <= 0.0) return most - box->rounding;
    return norm({std::max(out.x, 0.0), std::max(out.y, 0.0), std::max(out.z, 0.0)}) - box->rounding;
  }
  const double across = std::sqrt(p.x * p.x + p.z * p.z);
  if (const auto* cylinder = std::get_if<Cylinder>(&placed.geometry))
    return std::max(across - cylinder->radius, std::abs(p.y) - cylinder->half_height);
  if (const auto* cone = std::get_if<Cone>(&placed.geometry)) {
    const double half = cone->half_height, height = 2.0 * half, radius = cone->radius;
    const double side = (height * across - radius * (half - p.y)) / std::hypot(height, radius);
    return std::max(side, -half - p.y);
  }
  const ConvexHull& convex = std::get<ConvexHull>(placed.geometry);
  return convex.rounding > 0.0f ? beyond_core(convex, p) - convex.rounding : beyond_planes(convex, p);
}

// How far the shape reaches along a unit vector.
inline double reach_along(const Placed& placed, Point along) {
  const Point local = turn(back(placed.rotation), along);
  double reach = 0.0;
  if (const auto* sphere = std::get_if<Sphere>(&placed.geometry)) {
    reach = sphere->radius;
  } else if (const auto* capsule = std::get_if<Capsule>(&placed.geometry)) {
    reach = double{capsule->half_height} * std::abs(local.y) + capsule->radius;
  } else if (const auto* box = std::get_if<Box>(&placed.geometry)) {
    const Vec3 half = box->half_extents;
    reach =
        half.x * std::abs(local.x) + half.y * std::abs(local.y) + half.z * std::abs(local.z) + box->rounding;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&placed.geometry)) {
    reach = cylinder->half_height * std::abs(local.y) + cylinder->radius * std::hypot(local.x, local.z);
  } else if (const auto* cone = std::get_if<Cone>(&placed.geometry)) {
    const double top = cone->half_height * local.y;
    reach = std::max(top, cone->radius * std::hypot(local.x, local.z) - top);
  } else {
    const ConvexHull& convex = std::get<ConvexHull>(placed.geometry);
    reach = -1e300;
    for (const Point& corner : hull_corners(convex)) reach = std::max(reach, dot(corner, local));
    reach += convex.rounding;
  }
  return dot(placed.position, along) + reach;
}

// How far two shapes are apart along a unit vector from the first to the second; at most their distance, and
// not above zero along any vector where they overlap.
inline double apart_along(const Placed& a, const Placed& b, Point along) {
  return -reach_along(b, -1.0 * along) - reach_along(a, along);
}

struct RayAnswer {
  double fraction;
  double depth;  // how far `beyond` goes below zero along the ray, at most: near zero the ray grazes
};

// Where a convex function of t in [0, 1] first comes to zero: its minimum by golden section, then bisection.
template <class Function>
std::optional<RayAnswer> first_zero(Function&& at) {
  if (at(0.0) <= 0.0) return RayAnswer{0.0, -at(0.0)};
  const double ratio = (std::sqrt(5.0) - 1.0) / 2.0;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 90; ++i) {
    const double left = high - ratio * (high - low), right = low + ratio * (high - low);
    if (at(left) <= at(right)) {
      high = right;
    } else {
      low = left;
    }
  }
  double best = 0.5 * (low + high);
  if (at(1.0) < at(best)) best = 1.0;
  const double depth = -at(best);
  if (depth < 0.0) return std::nullopt;
  low = 0.0, high = best;
  for (int i = 0; i < 90; ++i) {
    const double middle = 0.5 * (low + high);
    (at(middle) <= 0.0 ? high : low) = middle;
  }
  return RayAnswer{high, depth};
}

inline Placed placed_of(const World& world, ShapeId shape) {
  const Pose pose = world.pose(world.body_of(shape)), local = world.local_pose(shape);
  Placed placed{world.geometry(shape),
                to_point(pose.position) + turn(pose.rotation, to_point(local.position)),
                pose.rotation * local.rotation};
  return placed;
}

inline std::optional<RayAnswer> ray_answer(const Placed& placed, const Ray& ray) {
  return first_zero(
      [&](double t) { return beyond(placed, to_point(ray.origin) + t * to_point(ray.translation)); });
}

// Random values; each call draws in an order of its own.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  float uniform(float low, float high) { return random_.between(low, high); }
  std::uint32_t below(std::uint32_t count) { return random_.below(count); }
  Vec3 within(Vec3 reach) {
    const float x = uniform(-reach.x, reach.x);
    const float y = uniform(-reach.y, reach.y);
    const float z = uniform(-reach.z, reach.z);
    return {x, y, z};
  }
  Quat rotation() {
    const Vec3 axis = within({1, 1, 1});
    const float angle = uniform(-3.0f, 3.0f);
    return length(axis) > 0.01f ? from_axis_angle(axis, angle) : Quat{};
  }
  Geometry geometry(float size) { return geometry(size, below(8)); }
  // A ball, or the sum of a ball and a segment, or a polytope.
  Geometry plain_geometry(float size) { return geometry(size, below(4)); }
  Geometry geometry(float size, std::uint32_t kind) {
    const Vec3 cube = Vec3{size, size, size};
    switch (kind) {
      case 0:
        return Sphere{size * uniform(0.2f, 1.0f)};
      case 1: {
        const float half = size * uniform(0.1f, 1.0f);
        return Capsule{half, size * uniform(0.05f, 0.5f)};
      }
      case 2:
        return Box{0.55f * cube + within(0.5f * cube)};
      case 3:
        return ConvexHull{hull(below(3)), 0.6f * cube + within(0.5f * cube)};
      case 4: {
        const Vec3 half = 0.4f * cube + within(0.35f * cube);
        return Box{half, size * uniform(0.01f, 0.4f)};
      }
      case 5: {
        const float half = size * uniform(0.1f, 1.0f);
        return Cylinder{half, size * uniform(0.1f, 1.0f)};
      }
      case 6: {
        const float half = size * uniform(0.1f, 1.0f);
        return Cone{half, size * uniform(0.1f, 1.0f)};
      }
      default: {
        const Hull& which = hull(below(3));
        const Vec3 scale = 0.6f * cube + within(0.5f * cube);
        return ConvexHull{which, scale, size * uniform(0.01f, 0.3f)};
      }
    }
  }
  // Of 3 hulls, one of them with its points far from their origin, and one a needle.
  static const Hull& hull(std::uint32_t which) {
    static const std::vector<Hull> kHulls = [] {
      std::vector<Hull> hulls;
      Dice dice(7);
      std::vector<Vec3> points;
      for (int i = 0; i < 30; ++i) points.push_back(dice.within({1, 1, 1}));
      hulls.emplace_back(points);
      for (Vec3& point : points) point = point + Vec3{3, -1, 2};
      hulls.emplace_back(points);
      const std::vector<Vec3> needle{
          {-2, 0, 0}, {2, 0.01f, 0}, {0, 0.02f, 0.01f}, {0, 0, 0.02f}, {1, 0.01f, -0.01f}};
      hulls.emplace_back(needle);
      return hulls;
    }();
    return kHulls[which];
  }
  Ray ray(float reach) {
    const Vec3 origin = within({reach, reach, reach});
    const Vec3 end = within({reach, reach, reach});
    return {origin, end - origin};
  }

 private:
  scenes::Random random_;
};

inline Placed placed_of(const Geometry& geometry, const Pose& pose) {
  return {geometry, to_point(pose.position), pose.rotation};
}

// Bodies of all types and of one to three shapes in a cube, some of them asleep after a few steps.
class MixedWorld {
 public:
  explicit MixedWorld(std::uint64_t seed, int body_count = 120, float half_side = 8.0f)
      : reach(half_side), dice(seed) {
    WorldSettings settings;
    settings.sleep_time = 0.1f;
    world = World(settings);
    world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -reach - 1, 0}}),
                    Box{{2 * reach, 1, 2 * reach}});
    for (int i = 0; i < body_count; ++i) add_body();
  }

  BodyId add_body() {
    BodyDef def;
    const std::uint32_t kind = dice.below(6);
    def.type = kind < 2 ? BodyType::fixed : kind == 2 ? BodyType::kinematic : BodyType::dynamic;
    def.position = dice.within({reach, reach, reach});
    def.rotation = dice.rotation();
    def.angular_velocity = dice.within({1, 1, 1});
    const BodyId body = world.create_body(def);
    const std::uint32_t count = 1 + dice.below(3) / 2 * 2;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Geometry geometry = dice.geometry(0.8f);
      const Vec3 place = dice.within({0.5f, 0.5f, 0.5f});
      const Quat rotation = dice.rotation();
      const std::uint32_t category = 1u << dice.below(3);
      world.add_shape(body, geometry, {},
                      {.local_pose = {place, rotation}, .filter = {.category = category}});
    }
    bodies.push_back(body);
    return body;
  }
  void step(int count) {
    for (int i = 0; i < count; ++i) scree::step(world, 1.0f / 60.0f, workers);
  }
  // One of the calls that move, change, create or destroy shapes.
  void change_something() {
    const std::size_t which = dice.below(static_cast<std::uint32_t>(bodies.size()));
    const BodyId body = bodies[which];
    std::vector<ShapeId> shapes(world.shapes_of(body, {}));
    world.shapes_of(body, shapes);
    switch (dice.below(7)) {
      case 0:
        add_body();
        return;
      case 1:
        world.destroy_body(body);
        bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(which));
        return;
      case 2: {
        const Vec3 place = dice.within({reach, reach, reach});
        world.set_pose(body, {place, dice.rotation()});
        return;
      }
      case 3:
        if (!shapes.empty()) world.set_geometry(shapes[0], dice.geometry(0.8f));
        return;
      case 4:
        if (!shapes.empty()) world.set_local_pose(shapes.back(), {dice.within({1, 1, 1}), {}});
        return;
      case 5:
        if (shapes.size() > 1) world.destroy_shape(shapes[1]);
        return;
      default:
        world.set_body_type(body, static_cast<BodyType>(dice.below(3)));
    }
  }
  PlacedShape placed_shape() {
    const Geometry geometry = dice.geometry(1.0f);
    const Vec3 place = dice.within({reach, reach, reach});
    return {geometry, {place, dice.rotation()}};
  }
  std::vector<ShapeId> all_shapes() const {
    std::vector<ShapeId> all;
    std::vector<ShapeId> of_body;
    for (std::uint32_t index = 0; index < world.poses().size(); ++index) {
      const BodyId body = world.body_at(index);
      if (!world.is_alive(body)) continue;
      of_body.resize(world.shapes_of(body, {}));
      world.shapes_of(body, of_body);
      all.insert(all.end(), of_body.begin(), of_body.end());
    }
    std::sort(all.begin(), all.end());
    return all;
  }

  const float reach;
  Dice dice;
  World world;
  std::vector<BodyId> bodies;
  Workers workers{2};
};

}  // namespace scree::testing
