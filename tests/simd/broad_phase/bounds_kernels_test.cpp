// The kernel of bounds by itself: the parts of a list that threads hand to it, and what it writes.
// tests/parallel/broad_phase/bounds_test.cpp has the laws of the bounds.
#include <core/world/column.h>
#include <core/world/edit.h>
#include <simd/dispatch/kernels.h>
#include <tests/simd/all_kernels.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace scree::kernel_tests {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

struct Numbers {
  std::mt19937 engine;
  explicit Numbers(unsigned seed) : engine(seed) {}
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine); }
  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); }
};

std::vector<std::int32_t> numbered(int first, int last) {
  std::vector<std::int32_t> shapes(static_cast<std::size_t>(last - first));
  std::iota(shapes.begin(), shapes.end(), first);
  return shapes;
}
std::vector<std::int32_t> shuffled(std::vector<std::int32_t> members, unsigned seed) {
  std::mt19937 engine(seed);
  std::shuffle(members.begin(), members.end(), engine);
  return members;
}

constexpr int kBoundedShapes = 256;

struct Placed {
  std::vector<std::int32_t> body;
  std::vector<std::uint8_t> type, body_type;
  std::vector<ExtentRow> extent;
  Column<PoseRow> local_pose, body_pose, shape_pose;
  Column<VelocityRow> velocity;
  Column<BoundsRow> fat;
  Column<StepMotion> motion;

  explicit Placed(unsigned seed) {
    Numbers numbers(seed);
    const auto turn = [&](float(&q)[4]) {
      float size = 0.0f;
      for (float& part : q) {
        part = numbers.between(-1, 1);
        size += part * part;
      }
      for (float& part : q) part /= std::sqrt(size);
    };
    for (int i = 0; i < kBoundedShapes; ++i) {
      body.push_back(i);
      type.push_back(static_cast<std::uint8_t>(numbers.pick(4)));
      body_type.push_back(static_cast<std::uint8_t>(numbers.pick(3)));
      ExtentRow size{{numbers.between(0.1f, 2), numbers.between(0.1f, 2), numbers.between(0.1f, 2)},
                     numbers.between(0.1f, 2)};
      if (type.back() == simd::kBoundsHull) {
        size.radius = numbers.between(0.6f, 1.0f) * std::hypot(size.half[0], size.half[1], size.half[2]);
      }
      extent.push_back(size);
      PoseRow local{}, pose{};
      VelocityRow speed{};
      const float way = numbers.pick(3) == 0 ? 40.0f : 0.1f;
      for (int axis = 0; axis < 3; ++axis) {
        local.position[axis] = numbers.between(-2, 2);
        pose.position[axis] = numbers.between(-50, 50);
        speed.linear[axis] = numbers.between(-way, way);
        speed.angular[axis] = numbers.between(-0.2f, 0.2f);
      }
      turn(local.rotation);
      turn(pose.rotation);
      constexpr float kRare[] = {1e17f, 1e19f, std::numeric_limits<float>::infinity(),
                                 std::numeric_limits<float>::quiet_NaN()};
      if (numbers.pick(16) == 0) pose.position[numbers.pick(3)] = kRare[numbers.pick(4)];
      if (numbers.pick(16) == 0) speed.linear[numbers.pick(3)] = kRare[numbers.pick(4)];
      local_pose.push_back(local);
      body_pose.push_back(pose);
      velocity.push_back(speed);
    }
    shape_pose.resize(kBoundedShapes);
    fat.resize(kBoundedShapes);
    motion.resize(kBoundedShapes);
    for (PoseRow& row : shape_pose) std::memset(&row, 0x55, sizeof row);
    // Empty, as those of new shapes.
    for (BoundsRow& row : fat) {
      row = {{kLargest, kLargest, kLargest}, 0.0f, {-kLargest, -kLargest, -kLargest}, 0.0f};
    }
  }

  int update(const simd::PairKernels& kernels, const std::vector<std::int32_t>& list, int begin, int end,
             bool force) {
    std::vector<std::uint8_t> left(list.size(), 2);
    const std::vector<BoundsRow> before(fat.begin(), fat.end());
    const simd::BoundsTask task{list.data(),       body.data(),
                                type.data(),       body_type.data(),
                                extent.data(),     local_pose.data(),
                                body_pose.data(),  velocity.data(),
                                shape_pose.data(), fat.data(),
                                motion.data(),     left.data(),
                                1.0f / 60.0f,      force};
    const int count = kernels.update_bounds(task, begin, end);
    expect_marks(list, left, before, begin, end, count);
    return count;
  }
  // Whoever has new bounds is marked, and nothing is written for others than [begin, end).
  void expect_marks(const std::vector<std::int32_t>& list, const std::vector<std::uint8_t>& left,
                    const std::vector<BoundsRow>& before, int begin, int end, int count) const {
    int marked = 0;
    for (int i = 0; i < static_cast<int>(list.size()); ++i) {
      const auto place = static_cast<std::size_t>(i);
      const auto shape = static_cast<std::size_t>(list[place]);
      const bool listed = i >= begin && i < end;
      EXPECT_EQ(left[place] < 2, listed);
      marked += left[place] == 1 ? 1 : 0;
      if (left[place] != 1) {
        EXPECT_EQ(std::memcmp(&before[shape], &fat[shape], sizeof(BoundsRow)), 0);
      }
    }
    EXPECT_EQ(marked, count);
  }
};

template <class Row>
bool same_bits(const Row& a, const Row& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

TEST(BoundsKernels, BoundsHaveTheSameBitsForAnySetAndAnyPartOfTheList) {
  const std::vector<std::int32_t> list = shuffled(numbered(0, kBoundedShapes), 5);
  for (const bool force : {true, false}) {
    Placed expected(6);
    int left = 0;
    for (int i = 0; i < kBoundedShapes; ++i)
      left += expected.update(scalar_kernels().pair, list, i, i + 1, force);
    EXPECT_GT(left, kBoundedShapes / 2);
    for (const simd::Kernels* kernels : all_kernels()) {
      for (int part = 1; part <= 40; ++part) {
        Placed placed(6);
        int left_here = 0;
        for (int begin = 0; begin < kBoundedShapes; begin += part) {
          left_here +=
              placed.update(kernels->pair, list, begin, std::min(begin + part, kBoundedShapes), force);
        }
        EXPECT_EQ(left_here, left) << kernels->name;
        for (std::size_t shape = 0; shape < kBoundedShapes; ++shape) {
          ASSERT_TRUE(same_bits(placed.fat[shape], expected.fat[shape])) << kernels->name << ' ' << shape;
          // A pose that is not a number may be one of several.
          for (int k = 0; k < 3; ++k) {
            const float a = placed.shape_pose[shape].position[k], b = expected.shape_pose[shape].position[k];
            ASSERT_TRUE(same_bits(a, b) || (std::isnan(a) && std::isnan(b))) << kernels->name;
          }
          ASSERT_TRUE(same_bits(placed.shape_pose[shape].rotation, expected.shape_pose[shape].rotation));
        }
      }
    }
  }
}

TEST(BoundsKernels, BoundsOfShapesOutsideThePartOfTheListStayAsTheyAre) {
  const std::vector<std::int32_t> list = shuffled(numbered(0, kBoundedShapes), 5);
  for (const simd::Kernels* kernels : all_kernels()) {
    for (int count = 0; count <= 40; ++count) {
      constexpr int kBegin = 7;
      Placed placed(6);
      const Placed before(6);
      placed.update(kernels->pair, list, kBegin, kBegin + count, true);
      for (int i = 0; i < kBoundedShapes; ++i) {
        const auto shape = static_cast<std::size_t>(list[static_cast<std::size_t>(i)]);
        const bool listed = i >= kBegin && i < kBegin + count;
        EXPECT_EQ(same_bits(placed.shape_pose[shape], before.shape_pose[shape]), !listed) << kernels->name;
        if (!listed) {
          EXPECT_TRUE(same_bits(placed.fat[shape], before.fat[shape])) << kernels->name;
        }
      }
    }
  }
}

// Of bodies at rest near the origin: bounds without a margin, or whose margin is less than an ulp, are given
// up for the rounding of their center alone.
TEST(BoundsKernels, OnlyShapesThatLeaveTheirFatBoundsAreCountedAndGetNewOnes) {
  const std::vector<std::int32_t> list = numbered(0, kBoundedShapes);
  for (const simd::Kernels* kernels : all_kernels()) {
    Placed placed(6);
    for (VelocityRow& row : placed.velocity) row = {};
    for (std::uint8_t& type : placed.body_type) {
      if (type == simd::kBoundsFixedBody) ++type;
    }
    for (PoseRow& pose : placed.body_pose) {
      for (float& place : pose.position) {
        if (place == 1e17f) place = 0.0f;
      }
    }
    placed.update(kernels->pair, list, 0, kBoundedShapes, true);
    const Placed& now = placed;
    std::vector<BoundsRow> fat(now.fat.begin(), now.fat.end());
    EXPECT_EQ(placed.update(kernels->pair, list, 0, kBoundedShapes, false), 0) << kernels->name;
    for (std::size_t shape = 0; shape < kBoundedShapes; ++shape) {
      EXPECT_TRUE(same_bits(placed.fat[shape], fat[shape]));
      if (shape % 3 == 0) placed.body_pose[shape].position[1] += 3.0f;
    }
    int changed = 0;
    const int left = placed.update(kernels->pair, list, 0, kBoundedShapes, false);
    for (std::size_t shape = 0; shape < kBoundedShapes; ++shape) {
      const bool moved = !same_bits(placed.fat[shape], fat[shape]);
      changed += moved ? 1 : 0;
      if (moved) {
        EXPECT_EQ(shape % 3, 0u);
      }
    }
    EXPECT_EQ(left, changed) << kernels->name;
    EXPECT_GT(left, kBoundedShapes / 4);
  }
}

Vec3 place(const PoseRow& pose, Vec3 point) {
  return to_vec3(pose.position) + rotate(to_quat(pose.rotation), point);
}

TEST(BoundsKernels, PointsMoveAtMostAsFarAsTheMotionOfTheirShapeTells) {
  const std::vector<std::int32_t> list = numbered(0, kBoundedShapes);
  for (const simd::Kernels* kernels : all_kernels()) {
    Placed placed(7);
    Numbers numbers(8);
    for (PoseRow& pose : placed.body_pose) {
      for (float& x : pose.position) x = numbers.between(-5, 5);
    }
    placed.update(kernels->pair, list, 0, kBoundedShapes, true);
    for (const StepMotion& motion : placed.motion) EXPECT_TRUE(std::isinf(motion.turn)) << kernels->name;
    for (VelocityRow& row : placed.velocity) row = {};
    const std::vector<PoseRow> before(placed.shape_pose.begin(), placed.shape_pose.end());
    for (PoseRow& pose : placed.body_pose) {
      for (float& x : pose.position) x += numbers.between(-0.1f, 0.1f);
      Quat turned = to_quat(pose.rotation);
      for (float* part : {&turned.x, &turned.y, &turned.z, &turned.w}) *part += numbers.between(-0.1f, 0.1f);
      turned = normalize(turned);
      const float q[4] = {turned.x, turned.y, turned.z, turned.w};
      std::copy(std::begin(q), std::end(q), pose.rotation);
    }
    placed.update(kernels->pair, list, 0, kBoundedShapes, false);
    float tightest = 0.0f;
    for (std::size_t shape = 0; shape < kBoundedShapes; ++shape) {
      const StepMotion& motion = placed.motion[shape];
      for (int k = 0; k < 32; ++k) {
        const Vec3 point{numbers.between(-1, 1), numbers.between(-1, 1), numbers.between(-1, 1)};
        const Vec3 way = place(placed.shape_pose[shape], point) - place(before[shape], point);
        const float beside = length(way - to_vec3(motion.offset)), most = motion.turn * length(point);
        EXPECT_LE(beside, most + 4e-6f) << kernels->name;
        tightest = std::max(tightest, beside / most);
      }
    }
    EXPECT_GT(tightest, 0.99f);
  }
}

TEST(BoundsKernels, NoMotionBoundsFastShapes) {
  const std::vector<std::int32_t> list = numbered(0, kBoundedShapes);
  for (const simd::Kernels* kernels : all_kernels()) {
    Placed placed(9);
    for (int k = 0; k < 2; ++k) placed.update(kernels->pair, list, 0, kBoundedShapes, k == 0);
    int fast = 0;
    for (std::size_t shape = 0; shape < kBoundedShapes; ++shape) {
      const bool is_fast = placed.shape_pose[shape].padding > 0.0f;
      EXPECT_EQ(std::isinf(placed.motion[shape].turn), is_fast) << kernels->name;
      fast += is_fast ? 1 : 0;
    }
    EXPECT_GT(fast, kBoundedShapes / 8);
  }
}

}  // namespace
}  // namespace scree::kernel_tests
