// Pairs of shapes for the tests of the collide kernels: one body a shape, rows filled by hand.
#pragma once

#include <core/geometry/reference/collide.h>
#include <core/world/column.h>
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>
#include <tests/simd/all_kernels.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace scree::collide_tests {

using kernel_tests::all_kernels;
using kernel_tests::scalar_kernels;

struct Shape {
  ShapeType type;
  ExtentRow extent;
};
inline Shape sphere(float radius) { return {ShapeType::sphere, {{0, 0, 0}, radius}}; }
inline Shape capsule(float half_height, float radius) {
  return {ShapeType::capsule, {{0, half_height, 0}, radius}};
}
inline Shape box(float x, float y, float z) { return {ShapeType::box, {{x, y, z}, 0}}; }

inline PoseRow pose_row(Vec3 p, Quat q = {}) { return {{p.x, p.y, p.z}, 0, {q.x, q.y, q.z, q.w}}; }
inline Quat turn(Vec3 axis, float angle) {
  const float s = std::sin(angle / 2) / length(axis);
  return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle / 2)};
}

struct Rows {
  Column<Manifold> manifold;
  Column<ManifoldFeatures> features;
  Column<ContactSurface> surface;
  Column<ContactAnchor> anchor;
  Column<std::uint8_t> points;

  void resize(std::size_t count) {
    manifold.resize(count);
    features.resize(count);
    surface.resize(count);
    anchor.resize(count);
    points.resize(count);
  }
  // Contacts stay in their rows from step to step.
  void take(const Rows& last) {
    const auto copy = [](const auto& from, auto& to) { std::copy(from.begin(), from.end(), to.begin()); };
    copy(last.manifold, manifold);
    copy(last.features, features);
    copy(last.surface, surface);
    copy(last.anchor, anchor);
    copy(last.points, points);
  }
  // A pair that no longer touches has no row.
  void clear_lost() {
    for (std::size_t row = 0; row < points.size(); ++row) {
      if (points[row] == 0) manifold[row] = {};
    }
  }
};

// Pairs with one contact row each, in the order in which they were added.
struct Pairs {
  Column<PoseRow> pose;  // of shapes; bodies are in the same place
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  std::vector<ShapeType> type;
  std::vector<simd::CollideItem> items;

  void add(const Shape& a, const PoseRow& pose_a, const Shape& b, const PoseRow& pose_b,
           std::int32_t flags = 0) {
    const std::int32_t first = static_cast<std::int32_t>(pose.size());
    pose.push_back(pose_a);
    pose.push_back(pose_b);
    velocity.resize(pose.size());
    extent.push_back(a.extent);
    extent.push_back(b.extent);
    type.push_back(a.type);
    type.push_back(b.type);
    for (int k = 0; k < 2; ++k)
      material.push_back({0.5f, 0.0f, 0.0f, 3u | 4u << 8, {0, 0, 0}, kAutomaticPatch});
    const bool swapped = a.type > b.type;
    const std::int32_t row = static_cast<std::int32_t>(items.size());
    const std::int32_t one = swapped ? first + 1 : first, two = swapped ? first : first + 1;
    items.push_back({one, two, one, two, row, flags, 0});
  }
  reference::Solid solid(std::int32_t shape) const {
    const std::size_t s = static_cast<std::size_t>(shape);
    return reference::make_solid(type[s], extent[s], pose[s]);
  }
  simd::CollideType kind(std::size_t row) const {
    constexpr simd::CollideType kTypes[3][3] = {
        {simd::kSphereSphere, simd::kSphereCapsule, simd::kSphereBox},
        {simd::kSphereCapsule, simd::kCapsuleCapsule, simd::kCapsuleBox},
        {simd::kSphereBox, simd::kCapsuleBox, simd::kBoxBox}};
    return kTypes[static_cast<int>(type[static_cast<std::size_t>(items[row].shape_1)])]
                 [static_cast<int>(type[static_cast<std::size_t>(items[row].shape_2)])];
  }

  // Collides all pairs; with `previous`, their impulses carry over.
  Rows run(const simd::Kernels& kernels, const Rows* previous = nullptr) const {
    Rows rows;
    rows.resize(items.size());
    if (previous != nullptr) rows.take(*previous);
    const simd::CollideColumns columns{.shape_pose = pose.data(),
                                       .shape_extent = extent.data(),
                                       .shape_material = material.data(),
                                       .body_pose = pose.data(),
                                       .body_velocity = velocity.data(),
                                       .dt = 0.0f,
                                       .manifold = rows.manifold.data(),
                                       .features = rows.features.data(),
                                       .surface = rows.surface.data(),
                                       .anchor = rows.anchor.data(),
                                       .points = rows.points.data()};
    for (int t = 0; t < simd::kCollideTypes; ++t) {
      Column<simd::CollideItem> group;
      for (std::size_t row = 0; row < items.size(); ++row) {
        if (kind(row) != t) continue;
        group.push_back(items[row]);
        if (previous != nullptr) group.back().flags |= simd::kItemKnown;
      }
      for (std::size_t begin = 0; begin < group.size(); begin += simd::kCollideChunk) {
        const int count = static_cast<int>(std::min<std::size_t>(group.size() - begin, simd::kCollideChunk));
        kernels.collide.collide[t](columns, group.data() + begin, count);
      }
    }
    rows.clear_lost();
    return rows;
  }
};

// One random pair of each pair of types, between deep overlap and a gap of a few centimeters.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  float uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  Vec3 vector() { return {normal_(engine_), normal_(engine_), normal_(engine_)}; }
  Vec3 unit() {
    const Vec3 v = vector();
    return v * (1.0f / length(v));
  }
  Quat rotation() {
    const Vec3 v = vector();
    return normalize(Quat{v.x, v.y, v.z, normal_(engine_)});
  }
  // Log-uniform, so that slender shapes are common.
  float size() { return std::exp(uniform(std::log(0.1f), std::log(2.0f))); }
  Shape shape(ShapeType type) {
    if (type == ShapeType::sphere) return sphere(size());
    if (type == ShapeType::capsule) return capsule(size(), size());
    return box(size(), size(), size());
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<float> normal_;
};

// Random pairs of two types at about the distance where they begin to touch, plus `depth`.
inline Pairs random_pairs(ShapeType a, ShapeType b, int count, unsigned seed, float least_gap,
                          float largest_gap) {
  Random random(seed);
  Pairs pairs;
  for (int k = 0; k < count; ++k) {
    const Shape shape_a = random.shape(a), shape_b = random.shape(b);
    const Vec3 place = 10.0f * random.vector(), way = random.unit();
    const PoseRow pose_a = pose_row(place, random.rotation());
    PoseRow pose_b = pose_row(place, random.rotation());
    const float gap = random.uniform(least_gap, largest_gap);
    // Bisect for the distance along `way` that gives the gap.
    float low = 0.0f, high = 20.0f;
    for (int step = 0; step < 30; ++step) {
      const float middle = 0.5f * (low + high);
      const Vec3 p = place + middle * way;
      pose_b.position[0] = p.x;
      pose_b.position[1] = p.y;
      pose_b.position[2] = p.z;
      const double separation = reference::find_gap(reference::make_solid(a, shape_a.extent, pose_a),
                                                    reference::make_solid(b, shape_b.extent, pose_b))
                                    .separation;
      (separation < gap ? low : high) = middle;
    }
    pairs.add(shape_a, pose_a, shape_b, pose_b);
  }
  return pairs;
}

inline int points_of(const Manifold& manifold) {
  return static_cast<int>(manifold.info & kManifoldPointMask);
}
inline reference::Vector to_vector(const float v[3]) { return {v[0], v[1], v[2]}; }

// A manifold's frame in double precision.
struct Frame {
  reference::Vector normal, tangent_1, tangent_2, center;  // center: the friction center in the world
};
inline Frame frame_of(const Manifold& m, const PoseRow& body_a) {
  Frame frame;
  frame.normal = to_vector(m.normal);
  const double sign = std::copysign(1.0, frame.normal.z()), a = -1.0 / (sign + frame.normal.z());
  const double b = frame.normal.x() * frame.normal.y() * a;
  frame.tangent_1 = {1.0 + sign * frame.normal.x() * frame.normal.x() * a, sign * b,
                     -sign * frame.normal.x()};
  frame.tangent_2 = frame.normal.cross(frame.tangent_1);
  frame.center = to_vector(body_a.position) + to_vector(m.arm_a);
  return frame;
}
inline reference::Vector point_of(const Manifold& m, const Frame& frame, int k) {
  return frame.center + double(m.point_u[k]) * frame.tangent_1 + double(m.point_v[k]) * frame.tangent_2;
}
inline float deepest(const Manifold& m) {
  float result = kAbsentSeparation;
  for (int k = 0; k < points_of(m); ++k) result = std::min(result, m.separation[k]);
  return result;
}

}  // namespace scree::collide_tests
