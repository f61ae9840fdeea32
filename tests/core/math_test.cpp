// Vectors, rotations and poses of the public interface.
#include <scree/eigen.h>
#include <scree/math.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace scree::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

void expect_near(Vec3 a, Vec3 b, float tolerance) { EXPECT_LE(distance(a, b), tolerance) << a.x << b.x; }
// As rotations: q and -q are the same.
void expect_same_turn(Quat a, Quat b, float tolerance) { EXPECT_NEAR(std::abs(dot(a, b)), 1.0f, tolerance); }

const Quat kTurns[] = {{},
                       {1, 0, 0, 0},
                       normalize(Quat{0.1f, 0.7f, -0.3f, 0.5f}),
                       normalize(Quat{-0.9f, 0.2f, 0.4f, -0.1f}),
                       normalize(Quat{0.001f, 0, 0, 1})};

TEST(VectorArithmetic, IsThatOfItsComponentsAlsoInConstants) {
  constexpr Vec3 a{1, 2, 3}, b{-4, 5, 0.5f};
  static_assert(a + b == Vec3{-3, 7, 3.5f} && a - b == Vec3{5, -3, 2.5f} && -a == Vec3{-1, -2, -3});
  static_assert(a * 2.0f == Vec3{2, 4, 6} && 2.0f * a == a * 2.0f && a / 2.0f == Vec3{0.5f, 1, 1.5f});
  static_assert(dot(a, b) == 7.5f && length_squared(a) == 14.0f && lerp(a, b, 0.5f) == 0.5f * (a + b));
  static_assert(cross(Vec3{1, 0, 0}, Vec3{0, 1, 0}) == Vec3{0, 0, 1});
  static_assert(a[0] == 1 && a[1] == 2 && a[2] == 3);
  Vec3 c = a;
  c += b;
  c -= a;
  EXPECT_EQ(c, b);
  c *= 4.0f;
  c /= 2.0f;
  EXPECT_EQ(c, 2.0f * b);
  c[1] = 9;
  EXPECT_EQ(c, (Vec3{-8, 9, 1}));
}

TEST(VectorArithmetic, AUnitVectorHasLengthOneAndNoneComesFromZero) {
  EXPECT_EQ(length(Vec3{2, 3, 6}), 7.0f);
  expect_near(normalize(Vec3{2, 3, 6}), {2.0f / 7, 3.0f / 7, 6.0f / 7}, 1e-7f);
  EXPECT_EQ(normalize(Vec3{}), Vec3{});
  EXPECT_EQ(distance({1, 1, 1}, {1, 3, 1}), 2.0f);
}

TEST(Rotations, ActAsThoseOfEigen) {
  const Vec3 v{0.3f, -0.9f, 1.4f};
  for (const Quat a : kTurns) {
    expect_near(rotate(a, v), from_eigen(Eigen::Vector3f(to_eigen(a) * to_eigen(v))), 1e-6f);
    expect_near(rotate_back(a, rotate(a, v)), v, 1e-6f);
    for (const Quat b : kTurns) {
      expect_same_turn(a * b, from_eigen(to_eigen(a) * to_eigen(b)), 1e-6f);
      expect_near(rotate(a * b, v), rotate(a, rotate(b, v)), 1e-6f);
      expect_same_turn(slerp(a, b, 0.3f), from_eigen(to_eigen(a).slerp(0.3f, to_eigen(b))), 1e-6f);
    }
  }
}

TEST(Rotations, AnAxisAndAnAngleComeBack) {
  const Vec3 axis = normalize(Vec3{2, -3, 6});
  for (const float angle : {1e-4f, 0.1f, 1.0f, 0.5f * kPi, 2.0f, 3.1f}) {
    const Quat q = from_axis_angle(5.0f * axis, angle);
    const Eigen::Quaternionf expected(Eigen::AngleAxisf(angle, to_eigen(axis)));
    EXPECT_LE(length(to_eigen(q).coeffs() == expected.coeffs()
                         ? Vec3{}
                         : Vec3{q.x, q.y, q.z} - Vec3{expected.x(), expected.y(), expected.z()}),
              2e-7f);
    for (const Quat same : {q, Quat{-q.x, -q.y, -q.z, -q.w}}) {
      expect_near(to_axis_angle(same).axis, axis, 2e-7f);
      EXPECT_NEAR(to_axis_angle(same).angle, angle, 3e-7f);
      EXPECT_EQ(angle_of(same), to_axis_angle(same).angle);
    }
  }
  EXPECT_EQ(from_axis_angle({}, 1.0f), Quat{});
  EXPECT_EQ(to_axis_angle(Quat{}), AxisAngle{});
  // The longer way round is the shorter one about the opposite axis.
  expect_near(to_axis_angle(from_axis_angle(axis, 2.0f * kPi - 1.0f)).axis, -axis, 1e-6f);
  EXPECT_NEAR(angle_of(from_axis_angle(axis, 2.0f * kPi - 1.0f)), 1.0f, 1e-6f);
}

TEST(Rotations, SinesAreRightToTheLastBitsUpToManyTurns) {
  for (int i = -2000; i <= 2000; ++i) {
    const float angle = static_cast<float>(i) * 37.123f;
    const Quat q = from_axis_angle({1, 0, 0}, angle);
    const double half = 0.5 * static_cast<double>(angle);
    EXPECT_NEAR(static_cast<double>(q.x), std::sin(half), 6e-8) << angle;
    EXPECT_NEAR(static_cast<double>(q.w), std::cos(half), 6e-8) << angle;
  }
}

TEST(Rotations, AnInterpolationTurnsAtAnEvenPaceByTheShorterWay) {
  const Quat a = kTurns[2], b = a * from_axis_angle({0, 1, 0}, 2.0f);
  for (const float t : {0.0f, 0.25f, 0.5f, 1.0f}) {
    for (const Quat to : {b, Quat{-b.x, -b.y, -b.z, -b.w}}) {
      EXPECT_NEAR(angle_of(conjugate(a) * slerp(a, to, t)), 2.0f * t, 1e-6f);
      EXPECT_NEAR(dot(slerp(a, to, t), slerp(a, to, t)), 1.0f, 4e-7f);
    }
  }
  const Quat near = normalize(a * Quat{1e-7f, 0, 0, 1});
  expect_same_turn(slerp(a, near, 0.5f), a, 1e-6f);
}

TEST(Poses, ComposeAsMotions) {
  const Pose a{{1, -2, 3}, kTurns[2]}, b{{-5, 0.5f, 2}, kTurns[3]};
  const Vec3 point{0.3f, 0.9f, -1.4f};
  expect_near(transform(a * b, point), transform(a, transform(b, point)), 3e-6f);
  expect_near(transform(a, point), from_eigen(Eigen::Vector3f(to_eigen(a) * to_eigen(point))), 2e-6f);
  expect_near(transform_back(a, transform(a, point)), point, 2e-6f);
  expect_near(transform(inverse(a), point), transform_back(a, point), 2e-6f);
  expect_near((inverse(a) * a).position, {}, 2e-6f);
  expect_same_turn((inverse(a) * a).rotation, {}, 1e-6f);
}

}  // namespace
}  // namespace scree::test
