// Laws of rays against hulls: the kernel leaves out only stretches and faces that double precision says do
// not matter, and few others stay, for every instruction set.
#include <core/geometry/hull/hull_build.h>
#include <core/world/math.h>
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace scree {
namespace {

using kernel_tests::all_kernels;

struct Solved {
  double begin = 0.0, end = 1.0;      // of what lies in the hull; none if the begin is the later one
  std::vector<std::int32_t> cutting;  // faces whose planes meet that part
};

// By the columns' planes, in double precision.
Solved solve(const HullData& hull, const simd::HullStretch& stretch) {
  Solved solved;
  std::vector<double> distance, rise;
  for (int face = 0; face < hull.face_count; ++face) {
    double d = -double{hull.offset[face]}, s = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      d += double{hull.normal[axis][face]} * double{stretch.base[axis]};
      s += double{hull.normal[axis][face]} * double{stretch.way[axis]};
    }
    distance.push_back(d);
    rise.push_back(s);
    if (s < 0.0) {
      solved.begin = std::max(solved.begin, -d / s);
    } else if (s > 0.0) {
      solved.end = std::min(solved.end, -d / s);
    } else if (d > 0.0) {
      solved.end = -1.0;
    }
  }
  for (std::size_t face = 0; face < distance.size(); ++face) {
    if (std::max(distance[face] + solved.begin * rise[face], distance[face] + solved.end * rise[face]) >= 0.0)
      solved.cutting.push_back(static_cast<std::int32_t>(face));
  }
  return solved;
}

Hull rock(std::mt19937& random, int points, Vec3 size) {
  std::normal_distribution<float> normal;
  std::vector<Vec3> corners;
  for (int i = 0; i < points; ++i) {
    const Vec3 way = normalize(Vec3{normal(random), normal(random), normal(random)});
    corners.push_back({way.x * size.x, way.y * size.y, way.z * size.z});
  }
  return Hull(corners);
}

TEST(HullRay, KeepsWhatMayLieInTheHullAndTheFacesThatMayCutIt) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  int met = 0, missed = 0, listed = 0, needed = 0;
  for (const Vec3 size :
       {Vec3{1, 1, 1}, Vec3{0.001f, 0.001f, 0.001f}, Vec3{300, 300, 300}, Vec3{2, 0.01f, 0.5f}}) {
    for (const int points : {4, 17, 60, 256}) {
      const Hull shape = rock(random, points, size);
      const HullData& hull = *HullAccess::solid(shape)->columns.data;
      const auto in_ball = [&] {
        const Vec3 way = normalize(Vec3{normal(random), normal(random), normal(random)});
        return hull.outer_radius * std::cbrt(share(random)) * way;
      };
      for (int i = 0; i < 300; ++i) {
        Vec3 from = in_ball(), to = in_ball();
        // Along a face, within one, and points.
        if (i % 5 == 1) {
          const int face = i % hull.face_count;
          const Vec3 n{hull.normal[0][face], hull.normal[1][face], hull.normal[2][face]};
          from = from + (hull.offset[face] - dot(n, from)) * n;
          if (i % 2 == 0) to = to + (hull.offset[face] - dot(n, to)) * n;
        }
        if (i % 7 == 3) to = from;
        const simd::HullStretch stretch{{from.x, from.y, from.z},
                                        {to.x - from.x, to.y - from.y, to.z - from.z},
                                        4e-6f * hull.outer_radius};
        const Solved truth = solve(hull, stretch);
        const bool meets = truth.begin <= truth.end;
        (meets ? met : missed) += 1;
        for (const simd::Kernels* kernels : all_kernels()) {
          std::vector<std::int32_t> faces(static_cast<std::size_t>(hull.padded_faces), -1);
          const int count = kernels->query.cut_hull(hull, stretch, faces.data());
          if (meets) {
            ASSERT_GE(count, 0);
          }
          if (count < 0) continue;
          faces.resize(static_cast<std::size_t>(count));
          EXPECT_TRUE(std::is_sorted(faces.begin(), faces.end()));
          for (const std::int32_t face : faces) {
            EXPECT_GE(face, 0);
            EXPECT_LT(face, hull.face_count);
          }
          if (!meets) continue;
          EXPECT_TRUE(std::includes(faces.begin(), faces.end(), truth.cutting.begin(), truth.cutting.end()));
          listed += count;
          needed += static_cast<int>(truth.cutting.size());
        }
      }
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(missed, 1000);
  EXPECT_LT(listed, 2 * needed);
}

TEST(HullRay, LeavesOutWhatPassesBeside) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  const Hull shape = rock(random, 80, {1, 1, 1});
  const HullData& hull = *HullAccess::solid(shape)->columns.data;
  int passed = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 from = normalize(Vec3{normal(random), normal(random), normal(random)}),
               to = normalize(Vec3{normal(random), normal(random), normal(random)});
    const simd::HullStretch stretch{
        {from.x, from.y, from.z}, {to.x - from.x, to.y - from.y, to.z - from.z}, 4e-6f};
    const Solved truth = solve(hull, stretch);
    if (!(truth.begin > truth.end + 1e-3)) continue;
    ++passed;
    for (const simd::Kernels* kernels : all_kernels()) {
      std::vector<std::int32_t> faces(static_cast<std::size_t>(hull.padded_faces));
      EXPECT_EQ(kernels->query.cut_hull(hull, stretch, faces.data()), -1);
    }
  }
  EXPECT_GT(passed, 20);
}

}  // namespace
}  // namespace scree
