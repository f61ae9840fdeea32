// Pairs of hulls, or of a box and a hull, for the tests of the hull kernels: one body a shape, rows filled by
// hand. And a zoo of hulls.
#pragma once

#include <core/geometry/hull/hull_build.h>
#include <core/geometry/reference/collide_hull.h>

#include "collide_fixture.h"

namespace scree::collide_tests {

inline Hull hull_of(const std::vector<Vec3>& points) { return Hull(points); }

inline std::vector<Vec3> box_points(float x, float y, float z) {
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k) points.push_back({k & 1 ? x : -x, k & 2 ? y : -y, k & 4 ? z : -z});
  return points;
}
inline std::vector<Vec3> sphere_points(int count, float radius, unsigned seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k) points.push_back(radius * random.unit());
  return points;
}
// A standing prism over a regular polygon.
inline std::vector<Vec3> prism_points(int sides, float radius, float half_height) {
  std::vector<Vec3> points;
  for (int k = 0; k < sides; ++k) {
    const float angle = 6.2831853f * float(k) / float(sides);
    const float x = radius * std::cos(angle), z = radius * std::sin(angle);
    points.push_back({x, half_height, z});
    points.push_back({x, -half_height, z});
  }
  return points;
}

struct ZooHull {
  const char* name;
  Hull hull;
};
inline std::vector<ZooHull> small_zoo() {
  return {
      {"tetrahedron", hull_of({{0.5f, 0, 0}, {-0.3f, 0.5f, 0}, {-0.3f, -0.4f, 0.5f}, {-0.2f, -0.3f, -0.6f}})},
      {"cube", hull_of(box_points(0.5f, 0.5f, 0.5f))},
      {"octahedron", hull_of({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})},
      {"rock_8", hull_of(sphere_points(8, 0.7f, 1))},
      {"rock_32", hull_of(sphere_points(32, 1.0f, 2))},
      {"prism_6", hull_of(prism_points(6, 0.4f, 0.8f))},
      {"prism_16", hull_of(prism_points(16, 0.8f, 0.3f))},
      {"sliver", hull_of({{1, 0, 0}, {-1, 0.02f, 0}, {0, 0.01f, 0.8f}, {0.1f, 0.05f, -0.5f}})},
      {"plate", hull_of(prism_points(7, 1.0f, 0.02f))},
      {"needle", hull_of(box_points(0.02f, 1.5f, 0.03f))}};
}
inline std::vector<ZooHull> large_zoo() {
  return {{"rock_128", hull_of(sphere_points(128, 1.2f, 3))},
          {"rock_256", hull_of(sphere_points(256, 0.9f, 4))},
          {"prism_64", hull_of(prism_points(64, 0.6f, 0.6f))}};
}
inline std::vector<ZooHull> whole_zoo() {
  std::vector<ZooHull> zoo = small_zoo();
  for (ZooHull& entry : large_zoo()) zoo.push_back(entry);
  return zoo;
}

inline const HullTopology& topology_of(const Hull& hull) { return HullAccess::solid(hull)->topology; }

struct HullRows : Rows {
  Column<ContactAxis> axis;
  Column<PairClearance> clearance;
};

// A hull, or a box if there is no hull. The reference uses `solid`.
struct Body {
  Hull hull;
  Vec3 half{};
  Hull solid;
};
inline Body hull_body(const Hull& hull) { return {hull, {}, hull}; }
inline Body box_body(float x, float y, float z) { return {Hull(), {x, y, z}, Hull(box_points(x, y, z))}; }

struct HullPairs {
  Column<PoseRow> pose;  // of shapes; bodies are in the same place
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  std::vector<Body> bodies;
  std::vector<const HullData*> hulls;  // of each shape
  std::vector<std::int32_t> shape_hull;
  std::vector<simd::CollideItem> items;

  void add_shape(const Body& body, const PoseRow& at) {
    const bool is_box = body.hull.is_empty();
    bodies.push_back(body);
    shape_hull.push_back(is_box ? -1 : static_cast<std::int32_t>(hulls.size()));
    hulls.push_back(is_box ? nullptr : HullAccess::solid(body.hull)->columns.data);
    pose.push_back(at);
    velocity.resize(pose.size());
    ExtentRow row{{body.half.x, body.half.y, body.half.z}, 0};
    if (!is_box) {
      row.radius = hulls.back()->outer_radius;
      for (const Vec3& v : topology_of(body.hull).vertices) {
        row.half[0] = std::max(row.half[0], std::abs(v.x));
        row.half[1] = std::max(row.half[1], std::abs(v.y));
        row.half[2] = std::max(row.half[2], std::abs(v.z));
      }
    }
    extent.push_back(row);
    material.push_back({0.5f, 0.0f, 0.0f, 3u | 4u << 8, {0, 0, 0}, kAutomaticPatch});
  }
  // A box comes first.
  void add(const Body& a, const PoseRow& pose_a, const Body& b, const PoseRow& pose_b) {
    const std::int32_t first = static_cast<std::int32_t>(pose.size());
    const std::int32_t row = static_cast<std::int32_t>(items.size());
    add_shape(a, pose_a);
    add_shape(b, pose_b);
    items.push_back({first, first + 1, first, first + 1, row, 0, row});
  }
  reference::Polyhedron solid(std::size_t row, int side) const {
    const std::size_t one = static_cast<std::size_t>(items[row].shape_1);
    const std::size_t shape = static_cast<std::size_t>(side == 0 ? items[row].shape_1 : items[row].shape_2);
    const float* p = pose[one].position;
    return reference::make_polyhedron(topology_of(bodies[shape].solid), pose[shape],
                                      reference::Vector(p[0], p[1], p[2]));
  }
  reference::Gap gap(std::size_t row) const { return reference::polyhedra_gap(solid(row, 0), solid(row, 1)); }
  bool has_box(std::size_t row) const { return shape_hull[static_cast<std::size_t>(items[row].shape_1)] < 0; }
  double size(std::size_t row) const { return std::min(solid(row, 0).radius, solid(row, 1).radius); }

  simd::CollideColumns columns(HullRows& rows) const {
    return {.shape_pose = pose.data(),
            .shape_extent = extent.data(),
            .shape_material = material.data(),
            .shape_hull = shape_hull.data(),
            .hulls = hulls.data(),
            .body_pose = pose.data(),
            .body_velocity = velocity.data(),
            .dt = 0.0f,
            .manifold = rows.manifold.data(),
            .features = rows.features.data(),
            .surface = rows.surface.data(),
            .anchor = rows.anchor.data(),
            .axis = rows.axis.data(),
            .points = rows.points.data(),
            .clearance = rows.clearance.data()};
  }
  // Collides all pairs; with `previous`, their impulses and axes carry over. `recycle` also recycles
  // manifolds.
  HullRows run(const simd::Kernels& kernels, const HullRows* previous = nullptr, bool recycle = false) const {
    HullRows rows;
    rows.resize(items.size());
    rows.axis.resize(items.size());
    rows.clearance.resize(items.size());
    if (previous != nullptr) {
      rows.take(*previous);
      std::copy(previous->axis.begin(), previous->axis.end(), rows.axis.begin());
    }
    const simd::CollideColumns all = columns(rows);
    for (const bool boxes : {false, true}) {
      Column<simd::CollideItem> group;
      for (std::size_t row = 0; row < items.size(); ++row) {
        if (has_box(row) != boxes) continue;
        group.push_back(items[row]);
        if (previous != nullptr) group.back().flags |= simd::kItemKnown;
      }
      for (std::size_t begin = 0; begin < group.size(); begin += simd::kCollideChunk) {
        int count = static_cast<int>(std::min<std::size_t>(group.size() - begin, simd::kCollideChunk));
        const simd::CollideItem* from = group.data() + begin;
        simd::CollideItem left[simd::kCollideChunk];
        if (recycle) {
          count = kernels.collide.recycle_hulls(all, from, count, left);
          from = left;
        }
        if (count > 0) kernels.collide.collide[boxes ? simd::kBoxHull : simd::kHullHull](all, from, count);
      }
    }
    rows.clear_lost();
    return rows;
  }
};

// Moves the second shape of a pair along `way` until the gap is as given.
inline PoseRow pose_at_gap(const Body& a, const PoseRow& pose_a, const Body& b, Quat turn_b, Vec3 way,
                           double gap) {
  double low = 0.0, high = 6.0;
  const reference::Vector origin(pose_a.position[0], pose_a.position[1], pose_a.position[2]);
  const reference::Polyhedron fixed = reference::make_polyhedron(topology_of(a.solid), pose_a, origin);
  PoseRow result{};
  for (int step = 0; step < 18; ++step) {
    const float middle = static_cast<float>(0.5 * (low + high));
    result =
        pose_row(Vec3{pose_a.position[0], pose_a.position[1], pose_a.position[2]} + middle * way, turn_b);
    const reference::Polyhedron moved = reference::make_polyhedron(topology_of(b.solid), result, origin);
    (polyhedra_gap(fixed, moved).separation < gap ? low : high) = 0.5 * (low + high);
  }
  return result;
}

// Random pairs of the zoo at about the distance where they begin to touch.
inline HullPairs random_hull_pairs(const std::vector<ZooHull>& zoo, int count, unsigned seed, float least_gap,
                                   float largest_gap, bool boxes) {
  Random random(seed);
  HullPairs pairs;
  for (int k = 0; k < count; ++k) {
    const std::size_t one = static_cast<std::size_t>(k) % zoo.size();
    const std::size_t two = (static_cast<std::size_t>(k) / zoo.size() + one) % zoo.size();
    const Body a = boxes ? box_body(random.size(), random.size(), random.size()) : hull_body(zoo[one].hull);
    const Body b = hull_body(zoo[two].hull);
    const PoseRow pose_a = pose_row(10.0f * random.vector(), random.rotation());
    const Quat turn_b = random.rotation();
    const Vec3 way = random.unit();
    pairs.add(a, pose_a, b, pose_at_gap(a, pose_a, b, turn_b, way, random.uniform(least_gap, largest_gap)));
  }
  return pairs;
}

}  // namespace scree::collide_tests
