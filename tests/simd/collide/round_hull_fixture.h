// Spheres and capsules on hulls for the tests of the collide kernels: hulls of every kind, and pairs of them
// with round shapes, one body a shape.
#pragma once

#include <core/geometry/hull/hull_build.h>
#include <core/geometry/reference/collide_hull_round.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>
#include <vector>

#include "collide_fixture.h"

namespace scree::collide_tests {

// A hull with everything that kernels and reference read of it.
struct TestHull {
  std::shared_ptr<const HullSolid> solid;
  HullData data;
  std::vector<reference::Vector> corners;
  std::vector<std::vector<int>> faces;
  Vec3 half{0, 0, 0};  // of the box about the centroid

  explicit TestHull(const std::vector<Vec3>& points)
      : solid(build_hull("test", points, {})), data(*solid->columns.data) {
    const HullTopology& topology = solid->topology;
    for (const Vec3& v : topology.vertices) {
      corners.emplace_back(v.x, v.y, v.z);
      half = {std::max(half.x, std::abs(v.x)), std::max(half.y, std::abs(v.y)),
              std::max(half.z, std::abs(v.z))};
    }
    for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
      faces.emplace_back(topology.loops.begin() + topology.begin[f],
                         topology.loops.begin() + topology.begin[f + 1]);
    }
  }
  ExtentRow extent() const { return {{half.x, half.y, half.z}, data.outer_radius}; }
};

inline std::vector<Vec3> scaled(std::vector<Vec3> points, Vec3 scale) {
  for (Vec3& p : points) p = {p.x * scale.x, p.y * scale.y, p.z * scale.z};
  return points;
}
inline std::vector<Vec3> box_points() {
  std::vector<Vec3> points;
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      for (const float z : {-1.0f, 1.0f}) points.push_back({x, y, z});
    }
  }
  return points;
}
inline std::vector<Vec3> prism_points(int sides) {
  std::vector<Vec3> points;
  for (int k = 0; k < sides; ++k) {
    const float angle = 2.0f * std::numbers::pi_v<float> * float(k) / float(sides);
    for (const float y : {-1.0f, 1.0f}) points.push_back({std::cos(angle), y, std::sin(angle)});
  }
  return points;
}
// On the unit sphere, nearly even.
inline std::vector<Vec3> ball_points(int count) {
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k) {
    const float y = 1.0f - 2.0f * (float(k) + 0.5f) / float(count), angle = 2.3999632f * float(k);
    const float r = std::sqrt(1.0f - y * y);
    points.push_back({r * std::cos(angle), y, r * std::sin(angle)});
  }
  return points;
}

struct NamedHull {
  const char* name;
  TestHull hull;
};
// From tetrahedron to 256 corners, with slivers, plates and needles.
inline std::deque<NamedHull> all_hulls(float scale) {
  std::deque<NamedHull> hulls;
  const auto add = [&](const char* name, const std::vector<Vec3>& points, Vec3 size) {
    constexpr float kThinnest = 3e-4f;  // m; thinner ones are no hulls
    if (std::min({size.x, size.y, size.z}) * scale < kThinnest) return;
    hulls.push_back({name, TestHull(scaled(points, scale * size))});
  };
  const std::vector<Vec3> tetrahedron{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  add("tetrahedron", tetrahedron, {0.5f, 0.5f, 0.5f});
  add("box", box_points(), {0.5f, 0.4f, 0.3f});
  add("prism", prism_points(6), {0.5f, 0.4f, 0.5f});
  add("cylinder", prism_points(40), {0.5f, 0.4f, 0.5f});
  add("ball32", ball_points(32), {0.5f, 0.5f, 0.5f});
  add("ball128", ball_points(128), {0.5f, 0.5f, 0.5f});
  add("ball256", ball_points(256), {0.6f, 0.5f, 0.4f});
  add("sliver", tetrahedron, {1.0f, 0.01f, 0.3f});
  add("plate", prism_points(8), {2.0f, 0.01f, 2.0f});
  add("needle", prism_points(3), {0.01f, 1.5f, 0.01f});
  add("tip", {{0, 1, 0}, {1, -1, 0}, {-1, -1, 1}, {-1, -1, -1}}, {0.01f, 1.0f, 0.01f});
  return hulls;
}

// Pairs of a round shape and a hull.
struct RoundHullPairs {
  Pairs pairs;
  std::vector<const TestHull*> hull;  // of each row
  Column<std::int32_t> shape_hull;
  Column<const HullData*> data;

  void add(const Shape& round, const PoseRow& pose, const TestHull& with, const PoseRow& hull_pose,
           std::int32_t flags = 0) {
    pairs.add(round, pose, {ShapeType::hull, with.extent()}, hull_pose, flags);
    shape_hull.push_back(-1);
    shape_hull.push_back(static_cast<std::int32_t>(hull.size()));
    hull.push_back(&with);
    data.push_back(&with.data);
  }
  std::size_t size() const { return hull.size(); }
  bool is_sphere(std::size_t row) const { return pairs.type[2 * row] == ShapeType::sphere; }
  reference::Solid solid(std::size_t row) const { return pairs.solid(pairs.items[row].shape_1); }
  reference::FacedHull polyhedron(std::size_t row) const {
    return reference::make_faced_hull(hull[row]->corners, hull[row]->faces, pairs.pose[2 * row + 1]);
  }

  // Collides the rows in the order given, all where it is empty.
  Rows run(const simd::Kernels& kernels, const Rows* previous = nullptr,
           const std::vector<std::size_t>& order = {}, int chunk = simd::kCollideChunk) const {
    Rows rows;
    rows.resize(size());
    if (previous != nullptr) rows.take(*previous);
    simd::CollideColumns columns{};
    columns.shape_pose = columns.body_pose = pairs.pose.data();
    columns.shape_extent = pairs.extent.data();
    columns.shape_material = pairs.material.data();
    columns.shape_hull = shape_hull.data();
    columns.hulls = data.data();
    columns.body_velocity = pairs.velocity.data();
    columns.manifold = rows.manifold.data();
    columns.features = rows.features.data();
    columns.surface = rows.surface.data();
    columns.anchor = rows.anchor.data();
    columns.points = rows.points.data();
    for (const simd::CollideType type : {simd::kSphereHull, simd::kCapsuleHull}) {
      Column<simd::CollideItem> group;
      for (std::size_t k = 0; k < size(); ++k) {
        const std::size_t row = order.empty() ? k : order[k];
        if (is_sphere(row) != (type == simd::kSphereHull)) continue;
        group.push_back(pairs.items[row]);
        if (previous != nullptr) group.back().flags |= simd::kItemKnown;
      }
      for (std::size_t begin = 0; begin < group.size(); begin += static_cast<std::size_t>(chunk)) {
        const int count = static_cast<int>(std::min(group.size() - begin, static_cast<std::size_t>(chunk)));
        kernels.collide.collide[type](columns, group.data() + begin, count);
      }
    }
    rows.clear_lost();
    return rows;
  }
};

// A round shape of about a hull's size, turned at random.
inline Shape round_shape(Random& random, bool is_sphere, float size) {
  const float radius = size * random.size() * 0.3f;
  return is_sphere ? sphere(radius) : capsule(size * random.size() * 0.5f, radius);
}

// Moves a round shape along the way out of a hull until the gap is about the one wanted.
inline PoseRow place_at_gap(const Shape& round, const PoseRow& start, const TestHull& hull,
                            const PoseRow& hull_pose, double gap) {
  PoseRow pose = start;
  const reference::FacedHull solid = reference::make_faced_hull(hull.corners, hull.faces, hull_pose);
  for (int step = 0; step < 4; ++step) {
    double core;
    const reference::Gap now =
        reference::gap_to_hull(reference::make_solid(round.type, round.extent, pose), solid, core);
    for (int k = 0; k < 3; ++k) pose.position[k] += float((now.separation - gap) * now.normal[k]);
  }
  return pose;
}

}  // namespace scree::collide_tests
