// Pairs of which one shape is a cylinder, a cone, a rounded box or a rounded hull, for the tests of their
// kernels; and the gap of any two convex shapes by brute force.
#pragma once

#include <tests/simd/collide/hull_fixture.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>

namespace scree::collide_tests::smooth {

using Eigen::Vector3d;

struct Solid {
  ShapeType type;
  ExtentRow extent;
  std::shared_ptr<const HullData> hull{};  // with the rounding in it
  Hull owner{};
};
inline Solid solid_of(const Shape& shape) { return {shape.type, shape.extent}; }
inline Solid cylinder(float radius, float half_height) {
  return {ShapeType::cylinder, {{radius, half_height, radius}, 0}};
}
inline Solid cone(float radius, float half_height) {
  return {ShapeType::cone, {{radius, half_height, radius}, 0}};
}
inline Solid rounded_box(float x, float y, float z, float rounding) {
  return {ShapeType::rounded_box, {{x, y, z}, rounding}};
}
inline Solid rounded_hull(const Hull& hull, float rounding) {
  HullData data = *HullAccess::solid(hull)->columns.data;
  data.rounding = rounding;
  Solid solid{rounding > 0.0f ? ShapeType::rounded_hull : ShapeType::hull, {}, nullptr, hull};
  for (int v = 0; v < data.vertex_count; ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      solid.extent.half[axis] = std::max(solid.extent.half[axis], std::abs(data.vertex[axis][v]) + rounding);
    }
  }
  solid.extent.radius = data.outer_radius + rounding;
  solid.hull = std::make_shared<const HullData>(data);
  return solid;
}

// A solid at a place, in double precision.
struct Placed {
  const Solid* solid;
  Vector3d position;
  Eigen::Matrix3d rotation;
};
inline Placed placed(const Solid& solid, const PoseRow& pose) {
  const float* q = pose.rotation;
  return {&solid, Vector3d(pose.position[0], pose.position[1], pose.position[2]),
          Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix()};
}
// How far a solid reaches along a unit direction.
inline double reach_along(const Placed& body, const Vector3d& along) {
  const Vector3d d = body.rotation.transpose() * along;
  const ExtentRow& e = body.solid->extent;
  const Vector3d half(e.half[0], e.half[1], e.half[2]);
  double reach = body.position.dot(along);
  switch (body.solid->type) {
    case ShapeType::sphere:
      return reach + e.radius;
    case ShapeType::capsule:
      return reach + half.y() * std::abs(d.y()) + e.radius;
    case ShapeType::cylinder:
      return reach + half.y() * std::abs(d.y()) + half.x() * std::hypot(d.x(), d.z());
    case ShapeType::cone:
      return reach + std::max(half.y() * d.y(), half.x() * std::hypot(d.x(), d.z()) - half.y() * d.y());
    case ShapeType::hull:
    case ShapeType::rounded_hull: {
      const HullData& hull = *body.solid->hull;
      double most = -1e300;
      for (int v = 0; v < hull.vertex_count; ++v) {
        most = std::max(most, Vector3d(hull.vertex[0][v], hull.vertex[1][v], hull.vertex[2][v]).dot(d));
      }
      return reach + most + double(hull.rounding);
    }
    default:
      return reach + half.dot(d.cwiseAbs()) + (body.solid->type == ShapeType::rounded_box ? e.radius : 0.0f);
  }
}
// The gap of two solids along a unit direction from the first to the second.
inline double gap_along(const Placed& a, const Placed& b, const Vector3d& n) {
  return -reach_along(b, -n) - reach_along(a, n);
}

// The largest gap along any direction: the distance of solids that are apart, and minus the depth of others.
// By a grid of directions, and shrinking steps from the best ones.
struct TrueGap {
  double separation;
  Vector3d normal;
};
inline TrueGap true_gap(const Placed& a, const Placed& b) {
  constexpr int kDirections = 1500, kStarts = 10;
  std::vector<std::pair<double, Vector3d>> found;
  for (int k = 0; k < kDirections; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / kDirections, r = std::sqrt(1.0 - z * z),
                 t = 2.39996322972865332 * k;
    const Vector3d n(r * std::cos(t), r * std::sin(t), z);
    found.emplace_back(gap_along(a, b, n), n);
  }
  for (const Placed* body : {&a, &b}) {
    for (int k = 0; k < 6; ++k) {
      const Vector3d n = (k < 3 ? 1.0 : -1.0) * body->rotation.col(k % 3);
      found.emplace_back(gap_along(a, b, n), n);
    }
  }
  std::partial_sort(found.begin(), found.begin() + kStarts, found.end(),
                    [](const auto& x, const auto& y) { return x.first > y.first; });
  TrueGap best{-1e300, Vector3d::UnitY()};
  for (int k = 0; k < kStarts; ++k) {
    auto [gap, n] = found[static_cast<std::size_t>(k)];
    double step = 0.06;
    for (int round = 0; step > 1e-7; ++round) {
      const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
      bool improved = false;
      for (int i = 0; i < 24; ++i) {
        const double angle = 0.37 * round + 6.283185307179586 * i / 24;
        const Vector3d next = (n + step * (std::cos(angle) * u + std::sin(angle) * v)).normalized();
        const double value = gap_along(a, b, next);
        if (value > gap) {
          gap = value;
          n = next;
          improved = true;
        }
      }
      if (!improved) step *= 0.6;
    }
    if (gap > best.separation) best = {gap, n};
  }
  return best;
}

struct SmoothPairs {
  Column<PoseRow> pose;  // of shapes; bodies are in the same place
  Column<VelocityRow> velocity;
  Column<ExtentRow> extent;
  Column<MaterialRow> material;
  std::vector<Solid> solids;
  std::vector<const HullData*> hulls;
  std::vector<std::int32_t> shape_hull;
  std::vector<std::uint8_t> type;
  std::vector<simd::CollideItem> items;
  float dt = 0.0f;

  void add_shape(const Solid& solid, const PoseRow& at) {
    solids.push_back(solid);
    type.push_back(static_cast<std::uint8_t>(solid.type));
    shape_hull.push_back(solid.hull ? static_cast<std::int32_t>(hulls.size()) : -1);
    hulls.push_back(solid.hull.get());
    pose.push_back(at);
    velocity.resize(pose.size());
    extent.push_back(solid.extent);
    material.push_back({0.5f, 0.0f, 0.0f, 3u | 4u << 8, {0, 0, 0}, kAutomaticPatch});
  }
  void add(const Solid& a, const PoseRow& pose_a, const Solid& b, const PoseRow& pose_b,
           std::int32_t flags = 0) {
    const auto first = static_cast<std::int32_t>(pose.size()), row = static_cast<std::int32_t>(items.size());
    add_shape(a, pose_a);
    add_shape(b, pose_b);
    items.push_back({first, first + 1, first, first + 1, row, flags, 0});
  }
  Placed solid(std::size_t row, int side) const {
    const auto shape = static_cast<std::size_t>(side == 0 ? items[row].shape_1 : items[row].shape_2);
    return placed(solids[shape], pose[shape]);
  }
  // With `previous`, its manifolds are those of the last step.
  Rows run(const simd::Kernels& kernels, const Rows* previous = nullptr,
           simd::CollideType collide_type = simd::kSmooth) const {
    Rows rows;
    rows.resize(items.size());
    if (previous != nullptr) rows.take(*previous);
    std::vector<simd::CollideItem> known = items;
    for (simd::CollideItem& item : known) item.flags |= previous != nullptr ? simd::kItemKnown : 0;
    const simd::CollideColumns columns{.shape_pose = pose.data(),
                                       .shape_extent = extent.data(),
                                       .shape_material = material.data(),
                                       .shape_hull = shape_hull.data(),
                                       .hulls = hulls.data(),
                                       .shape_type = type.data(),
                                       .body_pose = pose.data(),
                                       .body_velocity = velocity.data(),
                                       .dt = dt,
                                       .manifold = rows.manifold.data(),
                                       .features = rows.features.data(),
                                       .surface = rows.surface.data(),
                                       .anchor = rows.anchor.data(),
                                       .points = rows.points.data()};
    for (std::size_t begin = 0; begin < known.size(); begin += simd::kCollideChunk) {
      const int count = static_cast<int>(std::min<std::size_t>(known.size() - begin, simd::kCollideChunk));
      kernels.collide.collide[collide_type](columns, known.data() + begin, count);
    }
    rows.clear_lost();
    return rows;
  }
};

inline constexpr int kSmoothKinds = 8;
inline const char* kind_name(int kind) {
  constexpr const char* kNames[kSmoothKinds] = {"sphere",       "capsule",     "box",      "hull",
                                                "rounded_hull", "rounded_box", "cylinder", "cone"};
  return kNames[kind];
}
inline bool is_smooth_kind(int kind) { return kind >= 4; }
// A random solid of a kind, of any proportions.
inline Solid random_solid(int kind, Random& random, const std::vector<ZooHull>& zoo) {
  switch (kind) {
    case 0:
      return solid_of(sphere(random.size()));
    case 1:
      return solid_of(capsule(random.size(), random.size()));
    case 2:
      return solid_of(box(random.size(), random.size(), random.size()));
    case 3:
    case 4: {
      const auto which = static_cast<std::size_t>(random.uniform(0.0f, float(zoo.size()) - 0.01f));
      return rounded_hull(zoo[which].hull, kind == 3 ? 0.0f : 0.2f * random.size());
    }
    case 5:
      return rounded_box(random.size(), random.size(), random.size(), 0.3f * random.size());
    case 6:
      return cylinder(random.size(), random.size());
    default:
      return cone(random.size(), random.size());
  }
}

// Random pairs of two kinds whose gaps are about uniform in a range of meters.
inline SmoothPairs random_smooth_pairs(int kind_a, int kind_b, int count, unsigned seed, float least_gap,
                                       float largest_gap) {
  Random random(seed);
  static const std::vector<ZooHull> zoo = small_zoo();
  SmoothPairs pairs;
  for (int k = 0; k < count; ++k) {
    const Solid a = random_solid(kind_a, random, zoo), b = random_solid(kind_b, random, zoo);
    const Vec3 place = 3.0f * random.vector(), way = random.unit();
    const PoseRow pose_a = pose_row(place, random.rotation());
    PoseRow pose_b = pose_row(place, random.rotation());
    const double wanted = random.uniform(least_gap, largest_gap);
    const auto gap_at = [&](float distance) {
      const Vec3 p = place + distance * way;
      pose_b.position[0] = p.x;
      pose_b.position[1] = p.y;
      pose_b.position[2] = p.z;
      // Coarse: directions of a grid alone.
      const Placed one = placed(a, pose_a), two = placed(b, pose_b);
      double gap = -1e300;
      for (int i = 0; i < 300; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / 300, r = std::sqrt(1.0 - z * z), t = 2.39996322972865332 * i;
        gap = std::max(gap, gap_along(one, two, {r * std::cos(t), r * std::sin(t), z}));
      }
      return gap;
    };
    float low = 0.0f, high = 20.0f;
    for (int step = 0; step < 16; ++step) {
      const float middle = 0.5f * (low + high);
      (gap_at(middle) < wanted ? low : high) = middle;
    }
    pairs.add(a, pose_a, b, pose_b);
  }
  return pairs;
}

inline Vector3d normal_of(const Manifold& manifold) {
  return {manifold.normal[0], manifold.normal[1], manifold.normal[2]};
}

}  // namespace scree::collide_tests::smooth
