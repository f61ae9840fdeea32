// Spheres, capsules, boxes and hulls against half-spaces: depths and normals against closed forms, which
// points there are, and the same bits on every instruction set.
#include <tests/simd/same_bits.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "round_hull_fixture.h"

namespace scree::collide_tests {
namespace {

using reference::Vector;

constexpr ShapeType kFirstTypes[] = {ShapeType::sphere, ShapeType::capsule, ShapeType::box, ShapeType::hull};

// One convex shape and one half-space a row.
struct OnHalfSpace {
  Pairs pairs;
  std::vector<const TestHull*> hull;  // of each row; null: no hull
  Column<std::int32_t> shape_hull;
  Column<const HullData*> data;

  void add(const Shape& shape, const PoseRow& pose, const PoseRow& plane, const TestHull* with = nullptr) {
    pairs.add(shape, pose, {ShapeType::half_space, kHalfSpaceExtent}, plane);
    shape_hull.push_back(with != nullptr ? static_cast<std::int32_t>(data.size()) : -1);
    shape_hull.push_back(-1);
    if (with != nullptr) data.push_back(&with->data);
    hull.push_back(with);
  }
  Rows run(const simd::Kernels& kernels, const Rows* previous = nullptr) const {
    Rows rows;
    rows.resize(pairs.items.size());
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
    for (std::size_t type = 0; type < std::size(kFirstTypes); ++type) {
      Column<simd::CollideItem> group;
      for (std::size_t row = 0; row < pairs.items.size(); ++row) {
        if (pairs.type[2 * row] != kFirstTypes[type]) continue;
        group.push_back(pairs.items[row]);
        if (previous != nullptr) group.back().flags |= simd::kItemKnown;
      }
      for (std::size_t begin = 0; begin < group.size(); begin += simd::kCollideChunk) {
        const int count = static_cast<int>(std::min<std::size_t>(group.size() - begin, simd::kCollideChunk));
        kernels.collide.collide[simd::kSphereHalfSpace + static_cast<int>(type)](columns,
                                                                                 group.data() + begin, count);
      }
    }
    rows.clear_lost();
    return rows;
  }
};

Vector up_of(const PoseRow& plane) {
  return reference::make_solid(ShapeType::box, {}, plane).rotation.col(1);
}
Vector place_of(const PoseRow& pose) {
  return {double{pose.position[0]}, double{pose.position[1]}, double{pose.position[2]}};
}

// Points whose lowest, less the radius, is the shape's lowest.
std::vector<Vector> core_of(const OnHalfSpace& all, std::size_t row) {
  const PoseRow& pose = all.pairs.pose[2 * row];
  std::vector<Vector> points;
  if (all.hull[row] != nullptr) {
    const reference::Solid frame = reference::make_solid(ShapeType::box, {}, pose);
    for (const Vector& corner : all.hull[row]->corners)
      points.push_back(frame.position + frame.rotation * corner);
    return points;
  }
  const reference::Solid solid =
      reference::make_solid(all.pairs.type[2 * row], all.pairs.extent[2 * row], pose);
  for (int k = 0; k < 8; ++k) {
    const Vector sign((k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0, (k & 4) != 0 ? 1.0 : -1.0);
    points.push_back(solid.position + solid.rotation * Vector(solid.half.cwiseProduct(sign)));
  }
  return points;
}
double radius_of(const OnHalfSpace& all, std::size_t row) {
  const ShapeType type = all.pairs.type[2 * row];
  return type == ShapeType::sphere || type == ShapeType::capsule ? double{all.pairs.extent[2 * row].radius}
                                                                 : 0.0;
}
double gap_of(const OnHalfSpace& all, std::size_t row) {
  const PoseRow& plane = all.pairs.pose[2 * row + 1];
  double lowest = 1e300;
  for (const Vector& point : core_of(all, row))
    lowest = std::min(lowest, up_of(plane).dot(point - place_of(plane)));
  return lowest - radius_of(all, row);
}

// Shapes of all types and sizes near half-spaces that lie anyhow; `hulls` must outlive them.
OnHalfSpace random_encounters(const std::deque<NamedHull>& hulls, float scale, unsigned seed) {
  Random random(seed);
  OnHalfSpace all;
  for (int k = 0; k < 800; ++k) {
    const ShapeType type = kFirstTypes[k % 4];
    const TestHull* hull =
        type == ShapeType::hull ? &hulls[static_cast<std::size_t>(k / 4) % hulls.size()].hull : nullptr;
    Shape shape = hull != nullptr ? Shape{ShapeType::hull, hull->extent()} : random.shape(type);
    if (hull == nullptr) {
      for (float& half : shape.extent.half) half *= scale;
      shape.extent.radius *= scale;
    }
    const PoseRow plane = pose_row(scale * random.vector(), k % 3 == 0 ? Quat{} : random.rotation());
    PoseRow pose = pose_row(scale * 5.0f * random.vector(), k % 5 == 0 ? Quat{} : random.rotation());
    all.add(shape, pose, plane, hull);
    const double wanted = double{scale * random.uniform(-0.5f, 0.05f)},
                 gap = gap_of(all, all.hull.size() - 1);
    for (int axis = 0; axis < 3; ++axis) {
      all.pairs.pose[2 * all.hull.size() - 2].position[axis] +=
          static_cast<float>((wanted - gap) * up_of(plane)[axis]);
    }
  }
  return all;
}

TEST(CollideHalfSpace, TheDeepestPointIsTheLowestOfTheShapeAtAnyScale) {
  for (const float scale : {1e-3f, 1.0f, 300.0f}) {
    const std::deque<NamedHull> hulls = all_hulls(scale);
    const OnHalfSpace all = random_encounters(hulls, scale, 31);
    const double tolerance = 2e-5 * double{scale} + 1e-9;
    for (const simd::Kernels* kernels : all_kernels()) {
      const Rows rows = all.run(*kernels);
      int touching = 0;
      for (std::size_t row = 0; row < rows.points.size(); ++row) {
        const double gap = gap_of(all, row);
        SCOPED_TRACE(testing::Message() << kernels->name << ", scale " << scale << ", row " << row);
        if (rows.points[row] == 0) {
          EXPECT_GT(gap, double{kSpeculativeDistance} - tolerance);
          continue;
        }
        ++touching;
        const Manifold& m = rows.manifold[row];
        float deepest = kAbsentSeparation;
        for (int k = 0; k < points_of(m); ++k) deepest = std::min(deepest, m.separation[k]);
        // A corner that is hardly deeper than those chosen may be left out.
        const double slack =
            all.hull[row] != nullptr ? std::min(5e-4, 0.01 * double{all.hull[row]->data.inner_radius}) : 0.0;
        EXPECT_NEAR(double{deepest}, gap, tolerance + slack);
        const Vector up = up_of(all.pairs.pose[2 * row + 1]);
        for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(double{m.normal[axis]}, -up[axis], 1e-6);
      }
      EXPECT_GT(touching, 600);
    }
  }
}

TEST(CollideHalfSpace, EveryPointLiesHalfwayBetweenThePlaneAndTheSurface) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  const OnHalfSpace all = random_encounters(hulls, 1.0f, 32);
  const Rows rows = all.run(scalar_kernels());
  for (std::size_t row = 0; row < rows.points.size(); ++row) {
    const Manifold& m = rows.manifold[row];
    const PoseRow& plane = all.pairs.pose[2 * row + 1];
    const Vector normal(double{m.normal[0]}, double{m.normal[1]}, double{m.normal[2]});
    const Vec3 tangent = tangent_of({m.normal[0], m.normal[1], m.normal[2]});
    const Vector t1(double{tangent.x}, double{tangent.y}, double{tangent.z}), t2 = normal.cross(t1);
    const Vector center = place_of(all.pairs.pose[2 * row]) +
                          Vector(double{m.arm_a[0]}, double{m.arm_a[1]}, double{m.arm_a[2]});
    for (int k = 0; k < points_of(m); ++k) {
      const Vector point = center + double{m.point_u[k]} * t1 + double{m.point_v[k]} * t2;
      // Along the normal a point's place does not matter. Across, it is below a point of the core.
      double nearest = 1e300;
      for (const Vector& core : core_of(all, row)) {
        const Vector way = core - point;
        nearest = std::min(nearest, (way - way.dot(normal) * normal).norm());
      }
      EXPECT_LT(nearest, 2e-5) << "row " << row << ", point " << k;
      const double height = up_of(plane).dot(point - place_of(plane));
      EXPECT_TRUE(std::isfinite(height));
    }
  }
}

TEST(CollideHalfSpace, FlatFacesHaveFourPointsThatSpanThem) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  OnHalfSpace all;
  all.add(box(1, 0.5f, 2), pose_row({0, 0.499f, 0}), pose_row({}));
  for (const NamedHull& named : hulls) {
    if (std::string(named.name) == "prism" || std::string(named.name) == "cylinder")
      all.add({ShapeType::hull, named.hull.extent()}, pose_row({0, 0.399f, 0}), pose_row({}), &named.hull);
  }
  const Rows rows = all.run(scalar_kernels());
  ASSERT_EQ(rows.points.size(), 3u);
  const double wanted[] = {8.0, 0.0, 0.0};
  for (std::size_t row = 0; row < rows.points.size(); ++row) {
    ASSERT_EQ(rows.points[row], 4);
    const Manifold& m = rows.manifold[row];
    // Twice the area of the quadrangle in the order of its corners about the center.
    std::vector<std::pair<double, int>> order;
    for (int k = 0; k < 4; ++k) order.push_back({std::atan2(double{m.point_v[k]}, double{m.point_u[k]}), k});
    std::sort(order.begin(), order.end());
    double area = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const int i = order[k].second, j = order[(k + 1) % 4].second;
      area +=
          0.5 * (double{m.point_u[i]} * double{m.point_v[j]} - double{m.point_u[j]} * double{m.point_v[i]});
    }
    if (wanted[row] > 0.0) {
      EXPECT_NEAR(area, wanted[row], 1e-5);
    } else {
      // Of a round face with radius 0.5 the largest quadrangle has the area 0.5.
      EXPECT_GT(area, 0.4);
    }
  }
}

TEST(CollideHalfSpace, CornersOfARestingHullKeepTheirNamesWhileItTrembles) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  Random random(5);
  for (const NamedHull& named : hulls) {
    if (std::string(named.name) != "cylinder" && std::string(named.name) != "prism") continue;
    std::set<std::vector<std::uint32_t>> names;
    for (int k = 0; k < 200; ++k) {
      OnHalfSpace all;
      const Quat tilt = turn(random.unit(), random.uniform(0.0f, 3e-4f));
      all.add({ShapeType::hull, named.hull.extent()}, pose_row({0, 0.399f, 0}, tilt), pose_row({}),
              &named.hull);
      const Rows rows = all.run(scalar_kernels());
      names.insert({rows.features[0].id, rows.features[0].id + 4});
    }
    EXPECT_EQ(names.size(), 1u) << named.name;
  }
}

TEST(CollideHalfSpace, EveryInstructionSetGivesTheBitsOfScalar) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  const auto make = [&](bool moves) {
    OnHalfSpace all = random_encounters(hulls, 1.0f, 33);
    Random random(34);
    for (std::size_t row = 0; row < all.pairs.items.size(); ++row) {
      if (row % 3 == 1) all.pairs.items[row].flags = simd::kItemFlip | simd::kItemStatic | simd::kItemFixed;
      if (row % 7 == 2) all.pairs.items[row].flags = simd::kItemFlip | simd::kItemStatic;
      if (row % 4 == 1) all.pairs.material[2 * row].restitution = 0.5f;
    }
    for (PoseRow& pose : all.pairs.pose) pose.position[1] += moves ? random.uniform(-1e-3f, 1e-3f) : 0.0f;
    return all;
  };
  const OnHalfSpace all = make(false), moved = make(true);
  Rows before = all.run(scalar_kernels());
  fill_impulses(before);
  const Rows after = moved.run(scalar_kernels(), &before);
  for (const simd::Kernels* kernels : all_kernels()) {
    Rows wide = all.run(*kernels);
    fill_impulses(wide);
    expect_same_bits(before, wide, kernels->name, 600);
    expect_same_bits(after, moved.run(*kernels, &wide), kernels->name, 600);
  }
}

TEST(CollideHalfSpace, NonFiniteShapesDoNotTouch) {
  const std::deque<NamedHull> hulls = all_hulls(1.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const bool of_plane : {false, true}) {
    OnHalfSpace all = random_encounters(hulls, 1.0f, 35);
    for (std::size_t row = 0; row < all.pairs.items.size(); ++row) {
      PoseRow& pose = all.pairs.pose[2 * row + (of_plane ? 1 : 0)];
      (row % 2 == 0 ? pose.position[1] : pose.rotation[2]) = nan;
    }
    for (const simd::Kernels* kernels : all_kernels()) {
      const Rows rows = all.run(*kernels);
      for (std::size_t row = 0; row < rows.points.size(); ++row) EXPECT_EQ(rows.points[row], 0) << row;
    }
  }
}

}  // namespace
}  // namespace scree::collide_tests
