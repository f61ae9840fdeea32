// Laws of principal axes.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <scree/math.h>
#include <scree/mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace scree {
namespace {

MassProperties with_inertia(float xx, float yy, float zz, float xy = 0, float xz = 0, float yz = 0) {
  MassProperties mass;
  const float inertia[6] = {xx, yy, zz, xy, xz, yz};
  std::copy_n(inertia, 6, mass.inertia);
  return mass;
}

// Rows of the tensor.
void multiply(const MassProperties& mass, Vec3 v, double (&out)[3]) {
  const float* i = mass.inertia;
  const double rows[3][3] = {{i[0], i[3], i[4]}, {i[3], i[1], i[5]}, {i[4], i[5], i[2]}};
  for (int r = 0; r < 3; ++r) out[r] = rows[r][0] * v.x + rows[r][1] * v.y + rows[r][2] * v.z;
}

TEST(PrincipalAxes, AreEigenvectorsInAscendingOrder) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> part(-1.0f, 1.0f);
  for (int trial = 0; trial < 2000; ++trial) {
    float entry[6];
    for (float& value : entry) value = std::ldexp(part(random), static_cast<int>(random() % 20));
    const MassProperties mass = with_inertia(entry[0], entry[1], entry[2], entry[3], entry[4], entry[5]);
    const PrincipalAxes axes = principal_axes(mass);
    EXPECT_LE(axes.moments.x, axes.moments.y);
    EXPECT_LE(axes.moments.y, axes.moments.z);
    EXPECT_NEAR(dot(axes.rotation, axes.rotation), 1.0f, 1e-6f);
    EXPECT_GE(axes.rotation.w, 0.0f);
    const double size = std::max(std::abs(axes.moments.x), std::abs(axes.moments.z));
    for (int i = 0; i < 3; ++i) {
      Vec3 unit{};
      unit[i] = 1.0f;
      const Vec3 axis = rotate(axes.rotation, unit);
      double turned[3];
      multiply(mass, axis, turned);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(turned[k], axes.moments[i] * axis[k], 2e-6 * size);
    }
    EXPECT_NEAR(axes.moments.x + axes.moments.y + axes.moments.z, entry[0] + entry[1] + entry[2],
                1e-6 * size);
  }
}

TEST(PrincipalAxes, OfADiagonalInertiaAreTheBodysOwn) {
  const PrincipalAxes sorted = principal_axes(with_inertia(1, 2, 3));
  EXPECT_EQ(sorted.rotation, Quat{});
  EXPECT_EQ(sorted.moments, (Vec3{1, 2, 3}));
  EXPECT_EQ(principal_axes(with_inertia(2, 2, 2)).rotation, Quat{});
  const PrincipalAxes turned = principal_axes(with_inertia(3, 1, 2));
  EXPECT_EQ(turned.moments, (Vec3{1, 2, 3}));
  EXPECT_EQ(rotate(turned.rotation, {1, 0, 0}), (Vec3{0, 1, 0}));
  EXPECT_EQ(rotate(turned.rotation, {0, 1, 0}), (Vec3{0, 0, 1}));
  EXPECT_EQ(rotate(turned.rotation, {0, 0, 1}), (Vec3{1, 0, 0}));
}

TEST(PrincipalAxes, HoldFromTinyToHugeInertias) {
  for (const float scale : {1e-30f, 1e-10f, 1.0f, 1e20f, 1e35f}) {
    const PrincipalAxes axes =
        principal_axes(with_inertia(2 * scale, 2 * scale, 3 * scale, scale, 0.0f, 0.0f));
    EXPECT_NEAR(axes.moments.x / scale, 1.0, 1e-6);
    EXPECT_NEAR(axes.moments.y / scale, 3.0, 1e-6);
    EXPECT_NEAR(axes.moments.z / scale, 3.0, 1e-6);
    const Vec3 first = rotate(axes.rotation, {1, 0, 0});
    EXPECT_NEAR(std::abs(first.x - first.y), std::sqrt(2.0), 1e-6);
  }
}

TEST(PrincipalAxes, RefuseWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  try {
    principal_axes(with_inertia(1, 1, 1, 0, nan, 0));
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "principal_axes: entry 4 of the inertia is nan, must be finite");
  }
}

}  // namespace
}  // namespace scree
