// Laws of rays against hulls whose faces are nearly, but not quite, flat: the answer is that of the exact
// planes of all faces, for every instruction set.
#include <core/geometry/hull/hull_build.h>
#include <core/world/world_data.h>
#include <parallel/queries/query_ray.h>
#include <scree/scree.h>
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

namespace scree {
namespace {

using queries::Vector;

struct Truth {
  bool hits;
  double begin, width;  // fractions: where the ray enters, and for how long it stays, below zero if it misses
};

Vector corner_of(const HullData& hull, int corner) {
  return {hull.vertex[0][corner], hull.vertex[1][corner], hull.vertex[2][corner]};
}

// The outward normal, of any length, of the plane through the face's corners by M. E. Newell's formula.
Vector normal_of(const HullData& hull, int face) {
  const int begin = hull.loop_begin[face], end = hull.loop_begin[face + 1];
  Vector normal;
  for (int i = begin; i < end; ++i) {
    const Vector a = corner_of(hull, hull.loop[i]) - corner_of(hull, hull.loop[begin]),
                 b = corner_of(hull, hull.loop[i + 1 < end ? i + 1 : begin]) -
                     corner_of(hull, hull.loop[begin]);
    normal = normal + cross(a, b);
  }
  return normalize(normal);
}

Truth solve(const HullData& hull, const queries::Line& line) {
  double begin = -std::numeric_limits<double>::infinity(), end = 1.0;
  for (int face = 0; face < hull.face_count; ++face) {
    const Vector normal = normal_of(hull, face);
    double offset = -std::numeric_limits<double>::infinity();
    for (int i = hull.loop_begin[face]; i < hull.loop_begin[face + 1]; ++i)
      offset = std::max(offset, dot(normal, corner_of(hull, hull.loop[i])));
    const double distance = dot(normal, line.origin) - offset, speed = dot(normal, line.translation);
    if (speed < 0.0) {
      begin = std::max(begin, -distance / speed);
    } else if (speed > 0.0) {
      end = std::min(end, -distance / speed);
    } else if (distance > 0.0) {
      end = -std::numeric_limits<double>::infinity();
    }
  }
  return {begin <= end && begin > 0.0, begin, end - std::max(begin, 0.0)};
}

// A box whose faces bulge by less than the tolerance of hulls that are built so far from their origin.
Hull bulging_box(std::mt19937& random, float size, float away) {
  std::uniform_real_distribution<float> within(-0.9f, 0.9f), bulge(0.0f, 1.0f);
  const float step = std::max(away, size) * 6e-8f;  // of floats there
  std::vector<Vec3> points;
  for (int corner = 0; corner < 8; ++corner) {
    points.push_back({(corner & 1) != 0 ? size : -size, (corner & 2) != 0 ? size : -size,
                      (corner & 4) != 0 ? size : -size});
  }
  for (int i = 0; i < 60; ++i) {
    float place[3] = {size * within(random), size * within(random), size * within(random)};
    place[i % 3] = (i % 2 == 0 ? 1.0f : -1.0f) * (size + 3.0f * step * bulge(random));
    points.push_back({place[0], place[1], place[2]});
  }
  for (Vec3& point : points) point.x += away, point.y += away, point.z += away;
  return Hull(points);
}

TEST(HullRayQueries, MeetWhatTheExactPlanesBound) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int hits = 0, misses = 0;
  for (const float size : {0.1f, 1.0f, 30.0f}) {
    for (const float away : {0.0f, 10.0f, 1000.0f}) {
      World world;
      const Hull hull = bulging_box(random, size, away);
      world.add_shape(world.create_body({}), ConvexHull{hull});
      const HullData& data = *HullAccess::solid(hull)->columns.data;
      queries::Solid solid;
      solid.type = ShapeType::hull;
      solid.hull = &data;
      for (int i = 0; i < 2000; ++i) {
        // Passes a face's plane by a few times what it may be off by, and nearly along it.
        const int face = i % data.face_count;
        const Vector normal = normal_of(data, face), at = corner_of(data, data.loop[data.loop_begin[face]]);
        const Vector inward = -1.0 * normalize(at);
        const double room = 4e-6 * double{data.outer_radius};
        const Vector target = at + (double{size} * (0.1 + 0.4 * std::abs(uniform(random)))) * inward;
        const double above = dot(normal, target - at);
        const Vector through = target + (2.0 * room * uniform(random) - above) * normal;
        Vector way{uniform(random), uniform(random), uniform(random)};
        way = way - dot(way, normal) * normal;
        if (!(queries::length(way) > 0.1)) continue;
        way = (6.0 * size / queries::length(way)) * way + (room * uniform(random)) * normal;
        const queries::Line line{through - 0.5 * way, way};
        const Truth truth = solve(data, line);
        // What decides by less than rounding does is either.
        if (std::abs(truth.width) < 1e-9 || std::abs(truth.begin) < 1e-9) continue;
        (truth.hits ? hits : misses) += 1;
        for (const simd::Kernels* kernels : kernel_tests::all_kernels()) {
          queries::Entry entry;
          ASSERT_EQ(queries::meet(kernels->query, solid, line, entry), truth.hits && truth.width > 0.0)
              << size << " " << away << " " << truth.begin << " " << truth.width;
          if (truth.hits && truth.width > 0.0) {
            EXPECT_NEAR(entry.fraction, truth.begin, 1e-9);
          }
        }
      }
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 1000);
}

}  // namespace
}  // namespace scree
