// Conversions to and from Eigen lose nothing.
#include <core/world/math.h>
#include <scree/eigen.h>

#include <gtest/gtest.h>

namespace scree::test {
namespace {

TEST(Eigen, VectorsAndRotationsSurviveTheRoundTrip) {
  const Vec3 v{1, 2, 3};
  const Quat q{0.6f, 0, 0, 0.8f};
  EXPECT_EQ(from_eigen(to_eigen(v)), v);
  EXPECT_EQ(from_eigen(to_eigen(q)), q);
}

TEST(Eigen, APoseMovesPointsAsItsTransformDoes) {
  const Pose pose{{1, -2, 3}, normalize(Quat{0.1f, 0.7f, -0.3f, 0.5f})};
  const Vec3 point{0.3f, 0.9f, -1.4f};
  const Vec3 moved = pose.position + rotate(pose.rotation, point);
  EXPECT_LT(length(from_eigen(Eigen::Vector3f(to_eigen(pose) * to_eigen(point))) - moved), 1e-5f);
  const Pose back = from_eigen(to_eigen(pose));
  EXPECT_LT(length(back.position - pose.position), 1e-6f);
  EXPECT_NEAR(back.rotation.x * pose.rotation.x + back.rotation.y * pose.rotation.y +
                  back.rotation.z * pose.rotation.z + back.rotation.w * pose.rotation.w,
              1.0f, 1e-6f);
}

TEST(Eigen, InertiaKeepsTheOrderOfItsComponents) {
  Eigen::Matrix3f matrix;
  matrix << 10, 1, 2, 1, 11, 3, 2, 3, 12;
  const MassProperties properties = mass_properties(5.0f, {1, 2, 3}, matrix);
  EXPECT_EQ(properties.center, (Vec3{1, 2, 3}));
  EXPECT_EQ(properties.inertia[3], 1.0f);
  EXPECT_EQ(inertia_matrix(properties), matrix);
}

}  // namespace
}  // namespace scree::test
