// Laws of angles without the platform's functions: against double precision. wide_test.cpp tests that all
// instruction sets have the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <numbers>
#include <random>
#include <vector>

#include "wide_cases.h"

namespace scree::simd {
namespace {

constexpr double kPi = std::numbers::pi;

// The outputs of a case for one set of inputs.
std::vector<float> run(const char* name, std::initializer_list<float> inputs) {
  constexpr int kCount = 16;
  const WideCases set = scalar::wide_cases();
  const WideCase* end = set.cases + set.count;
  const WideCase& wide_case =
      *std::find_if(set.cases, end, [&](const WideCase& c) { return std::strcmp(c.name, name) == 0; });
  std::vector<std::vector<Bits>> in,
      out(static_cast<std::size_t>(wide_case.outputs), std::vector<Bits>(kCount));
  for (const float input : inputs) in.emplace_back(kCount, std::bit_cast<Bits>(input));
  std::vector<const Bits*> from;
  std::vector<Bits*> to;
  for (const auto& column : in) from.push_back(column.data());
  for (auto& column : out) to.push_back(column.data());
  wide_case.run(from.data(), to.data(), kCount);
  std::vector<float> result;
  for (const auto& column : out) result.push_back(std::bit_cast<float>(column[0]));
  return result;
}

TEST(WideAngles, Atan2IsThatOfDoublesAllAround) {
  double worst = 0;
  for (int i = 0; i <= 40000; ++i) {
    const double angle = kPi * (i / 20000.0 - 1.0), size = std::pow(10.0, i % 13 - 6);
    const float x = static_cast<float>(size * std::cos(angle)),
                y = static_cast<float>(size * std::sin(angle));
    const double exact = std::atan2(static_cast<double>(y), static_cast<double>(x));
    worst = std::max(worst, std::abs(std::remainder(run("atan2", {y, x})[0] - exact, 2 * kPi)));
  }
  EXPECT_LT(worst, 4e-7);
}

TEST(WideAngles, Atan2OfAxesAndOfZeroHasItsDefinedValue) {
  EXPECT_EQ(run("atan2", {0, 0})[0], 0.0f);
  EXPECT_EQ(run("atan2", {0, 1})[0], 0.0f);
  EXPECT_NEAR(run("atan2", {1, 0})[0], kPi / 2, 2e-7);
  EXPECT_NEAR(run("atan2", {-1, 0})[0], -kPi / 2, 2e-7);
  EXPECT_NEAR(run("atan2", {0, -1})[0], kPi, 2e-7);
  EXPECT_EQ(run("atan2", {1e-30f, 1})[0], 1e-30f * 0.999999344f);  // the polynomial's first term
}

// Angles of all sizes, from those whose sines are mostly rounding error to half a turn.
TEST(WideAngles, RotationVectorsAreThoseOfDoubles) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20000; ++i) {
    double axis[3] = {normal(engine), normal(engine), normal(engine)};
    const double size = std::hypot(axis[0], axis[1], axis[2]);
    const double angle = kPi * std::pow(10.0, -7.0 * (i % 1000) / 1000.0);
    const double sign = i % 2 == 0 ? 1 : -1;  // q and -q are one rotation
    float q[4];
    for (int k = 0; k < 3; ++k) q[k] = static_cast<float>(sign * axis[k] / size * std::sin(angle / 2));
    q[3] = static_cast<float>(sign * std::cos(angle / 2));
    const std::vector<float> v = run("rotation_vector", {q[0], q[1], q[2], q[3]});
    double off = 0, off_back = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double exact = axis[k] / size * angle;
      off = std::max(off, std::abs(v[k] - exact));
      off_back = std::max(off_back, std::abs(v[k] + exact));
    }
    const double bound = 1e-6 * angle + 1e-12;
    if (angle > kPi - 1e-6) {
      EXPECT_LT(std::min(off, off_back), 4e-6);  // half a turn goes either way
    } else {
      EXPECT_LT(off, bound) << angle;
    }
  }
}

TEST(WideAngles, RotationsByVectorsAreThoseOfDoubles) {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::pow(10.0, i % 9 - 6);  // to hundreds of turns
    float v[3];
    for (float& x : v) x = static_cast<float>(scale * normal(engine));
    const double angle =
        std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
    const std::vector<float> q = run("rotation_by", {v[0], v[1], v[2]});
    const double bound = 1e-6 + 1.5e-7 * angle;  // the angle itself is rounded
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(q[k], v[k] / angle * std::sin(angle / 2), bound) << angle;
    EXPECT_NEAR(q[3], std::cos(angle / 2), bound) << angle;
  }
}

TEST(WideAngles, TwistIsTheTurnAboutXBeforeTheShortestSwing) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    // Swing about an axis square to x, by less than half a turn, after a turn about x.
    const double about = kPi * uniform(engine), swing = 3.0 * uniform(engine), twist = kPi * uniform(engine);
    const double s = std::sin(swing / 2), c = std::cos(swing / 2);
    const double sy = s * std::cos(about), sz = s * std::sin(about);
    const double tx = std::sin(twist / 2), tw = std::cos(twist / 2);
    const float sign = i % 2 == 0 ? 1.0f : -1.0f;
    const float x = sign * static_cast<float>(c * tx), w = sign * static_cast<float>(c * tw);
    const float y = sign * static_cast<float>(sy * tw + sz * tx),
                z = sign * static_cast<float>(sz * tw - sy * tx);
    const float found = run("twist_angle", {x, y, z, w})[0];
    EXPECT_NEAR(std::remainder(found - twist, 2 * kPi), 0.0, 1e-6 / c);
    EXPECT_LE(std::abs(found), static_cast<float>(kPi));
  }
  EXPECT_GT(run("twist_angle", {-1, 0, 0, 0})[0], 3.14f);  // in (-pi, pi]
  EXPECT_GT(run("twist_angle", {1, 0, 0, 0})[0], 3.14f);
}

TEST(WideAngles, TheShorterWayIsWithinHalfATurn) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const float angle = static_cast<float>(std::pow(10.0, i % 7) * uniform(engine));
    const float found = run("shorter_way", {angle})[0];
    EXPECT_NEAR(std::remainder(found - static_cast<double>(angle), 2 * kPi), 0.0,
                1e-6 + 1e-7 * std::abs(angle));
    EXPECT_LE(std::abs(found), 3.14160f + 1e-7f * std::abs(angle));
  }
}

// The inverse if there is one; if rows are zero, the inverse of the other rows.
TEST(WideAngles, SemidefiniteMatricesAreInvertedWhereTheyCanBe) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int i = 0; i < 3000; ++i) {
    float b[3][3], m[3][3];
    for (auto& row : b) {
      for (float& x : row) x = uniform(engine);
    }
    const int locked = i % 8;  // bits: axes whose rows are zero
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        m[r][c] = r == c ? 0.3f : 0.0f;
        for (int k = 0; k < 3; ++k) m[r][c] += b[r][k] * b[c][k];
        if ((locked >> r & 1) != 0 || (locked >> c & 1) != 0) m[r][c] = 0.0f;
      }
    }
    const std::vector<float> n =
        run("invert_semidefinite", {m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]});
    const float inverse[3][3] = {{n[0], n[1], n[2]}, {n[1], n[3], n[4]}, {n[2], n[4], n[5]}};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        float product = 0;
        for (int k = 0; k < 3; ++k) product += m[r][k] * inverse[k][c];
        EXPECT_NEAR(product, r == c && (locked >> r & 1) == 0 ? 1.0f : 0.0f, 2e-5f) << locked;
      }
    }
  }
}

}  // namespace
}  // namespace scree::simd
