// What the tests of hulls' masses share.
#pragma once

#include <core/world/edit.h>
#include <core/world/mass.h>
#include <tests/core/geometry/hull/hull_clouds.h>

#include <cmath>
#include <numbers>

namespace scree::test {

inline constexpr double kPi = std::numbers::pi;

inline MassSum sum_of(const Geometry& geometry, double density = 1.0, const Pose& pose = {}) {
  return part_of(geometry, density, pose);
}

inline void expect_near(const MassSum& found, const MassSum& expected, double relative) {
  EXPECT_NEAR(found.mass, expected.mass, relative * expected.mass);
  const double trace = expected.inertia.m[0] + expected.inertia.m[3] + expected.inertia.m[5];
  const double size = std::sqrt(trace / expected.mass);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.center[i], expected.center[i], relative * size) << i;
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(found.inertia.m[i], expected.inertia.m[i], relative * trace) << i;
}

}  // namespace scree::test
