// Laws of update_bounds: content of fat bounds, when they are updated, and that bits depend on nothing else.
#include <tests/parallel/hand_made_world.h>

#include <core/state/hash.h>
#include <gtest/gtest.h>
#include <parallel/broad_phase/broad_phase.h>

#include <array>
#include <cstring>
#include <limits>

namespace scree {
namespace {

using testing::HandMadeWorld;
using testing::Random;

constexpr float kDt = 1.0f / 60.0f;

struct Extremes {
  double lower[3], upper[3];
};

// In double precision, straight from the definitions.
Extremes tight_box(const WorldData& data, std::size_t shape) {
  const PoseRow& pose = data.shapes.pose[shape];
  const ExtentRow& extent = data.shapes.extent[shape];
  const double x = pose.rotation[0], y = pose.rotation[1], z = pose.rotation[2], w = pose.rotation[3];
  const double axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  Extremes result{};
  for (int row = 0; row < 3; ++row) {
    double reach = extent.radius;
    for (int column = 0; column < 3; ++column) reach += std::abs(axes[row][column]) * extent.half[column];
    result.lower[row] = pose.position[row] - reach;
    result.upper[row] = pose.position[row] + reach;
  }
  return result;
}

HandMadeWorld random_world(std::uint64_t seed, int bodies, float half_size, float speed) {
  HandMadeWorld world;
  Random random(seed);
  for (int i = 0; i < bodies; ++i) {
    const std::int32_t body =
        world.add_body(BodyType::dynamic, random.point({half_size, half_size, half_size}), random.rotation());
    VelocityRow& velocity = world.data.bodies.velocity[static_cast<std::size_t>(body)];
    for (int axis = 0; axis < 3; ++axis) {
      velocity.linear[axis] = random.uniform(-speed, speed);
      velocity.angular[axis] = random.uniform(-speed, speed);
    }
    world.add_random_shape(body, random, {random.point({0.3f, 0.3f, 0.3f}), random.rotation()});
  }
  world.refresh();
  return world;
}

struct SilentSink final : CallSink {
  void called(const MadeCall&) noexcept override {}
  void restored(const WorldData&) noexcept override {}
  void stepped(const WorldData&, float, std::uint64_t) noexcept override {}
  void world_ended() noexcept override {}
  void step_failed() noexcept override {}
};

// A single chunk is not worth a helper, and neither is it in a recorded world.
TEST(Bounds, AreUpdatedInParallelWithTheHashOfARecordedWorld) {
  Workers workers(2);
  Crew crew(workers);
  SilentSink sink;
  for (const int bodies : {1, 256, 257, 600}) {
    HandMadeWorld world = random_world(6, bodies, 20.0f, 1.0f);
    update_bounds(world.data, kDt, crew);
    EXPECT_FALSE(world.data.recording.hash) << "no recorder requests it";
    world.data.recording.sink = &sink;
    update_bounds(world.data, kDt, crew);
    ASSERT_EQ(world.data.recording.hash.has_value(), bodies > 256) << bodies;
    if (bodies > 256) {
      EXPECT_EQ(*world.data.recording.hash, hash_of(world.data.bodies));
    }
  }
}

TEST(Bounds, FatBoundsHoldTheShapeAndHalfTheSpeculativeDistance) {
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    for (const float size : {10.0f, 1e3f, 1e6f}) {
      HandMadeWorld world = random_world(7, 300, size, 2.0f);
      for (int step = 0; step < 20; ++step) {
        Crew crew(workers);
        update_bounds(world.data, kDt, crew);
        for (std::size_t shape = 0; shape < world.data.shapes.type.size(); ++shape) {
          const Extremes tight = tight_box(world.data, shape);
          const BoundsRow& fat = world.data.shapes.fat_bounds[shape];
          const ExtentRow& extent = world.data.shapes.extent[shape];
          double reach = 0.0, distance = 0.0;
          for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(fat.lower[axis], tight.lower[axis] - 0.5 * kSpeculativeDistance);
            EXPECT_GE(fat.upper[axis], tight.upper[axis] + 0.5 * kSpeculativeDistance);
            reach += double{extent.half[axis]} * extent.half[axis];
            const double offset =
                0.5 * (fat.lower[axis] + fat.upper[axis]) - world.data.shapes.pose[shape].position[axis];
            distance += offset * offset;
          }
          EXPECT_GE(fat.sphere_radius,
                    std::sqrt(reach) + extent.radius + 0.5 * kSpeculativeDistance + std::sqrt(distance));
        }
        world.integrate(kDt);
      }
    }
  }
}

TEST(Bounds, ShapePoseIsBodyPoseTimesLocalPose) {
  HandMadeWorld world = random_world(3, 50, 10.0f, 0.0f);
  Workers workers(1);
  Crew crew(workers);
  update_bounds(world.data, kDt, crew);
  for (std::size_t shape = 0; shape < world.data.shapes.type.size(); ++shape) {
    const PoseRow& body = world.data.bodies.pose[static_cast<std::size_t>(world.data.shapes.body[shape])];
    const PoseRow& local = world.data.shapes.local_pose[shape];
    const Quat q{body.rotation[0], body.rotation[1], body.rotation[2], body.rotation[3]};
    const Vec3 offset = rotate(q, {local.position[0], local.position[1], local.position[2]});
    const Quat turn = q * Quat{local.rotation[0], local.rotation[1], local.rotation[2], local.rotation[3]};
    const PoseRow& pose = world.data.shapes.pose[shape];
    EXPECT_FLOAT_EQ(pose.position[0], body.position[0] + offset.x);
    EXPECT_FLOAT_EQ(pose.position[1], body.position[1] + offset.y);
    EXPECT_FLOAT_EQ(pose.position[2], body.position[2] + offset.z);
    EXPECT_NEAR(pose.rotation[0], turn.x, 1e-6);
    EXPECT_NEAR(pose.rotation[3], turn.w, 1e-6);
  }
}

TEST(Bounds, BitsAreEqualForEveryInstructionSetAndThreadCount) {
  std::vector<std::vector<char>> results;
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    HandMadeWorld world = random_world(11, 333, 20.0f, 3.0f);
    for (int step = 0; step < 10; ++step) {
      Crew crew(workers);
      update_bounds(world.data, kDt, crew);
      world.integrate(kDt);
    }
    std::vector<char> bytes;
    const auto append = [&](const auto& column) {
      const auto* begin = reinterpret_cast<const char*>(column.data());
      bytes.insert(bytes.end(), begin, begin + column.size() * sizeof(*column.data()));
    };
    append(world.data.shapes.fat_bounds);
    append(world.data.shapes.pose);
    results.push_back(std::move(bytes));
  }
  for (const std::vector<char>& result : results) EXPECT_EQ(result, results.front());
}

TEST(Bounds, ASlowBodyKeepsItsFatBoundsAndAFastOneDoesNot) {
  HandMadeWorld world;
  const auto slow = static_cast<std::size_t>(world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f));
  const auto fast = static_cast<std::size_t>(world.add_sphere(BodyType::dynamic, {5, 0, 0}, 0.5f));
  const auto fixed = static_cast<std::size_t>(world.add_sphere(BodyType::fixed, {9, 0, 0}, 0.5f));
  world.data.bodies.velocity[kFirstBody].linear[0] = 0.1f;
  world.data.bodies.velocity[kFirstBody + 1].linear[0] = 10.0f;
  world.refresh();
  Workers workers(1);
  Crew crew(workers);
  update_bounds(world.data, kDt, crew);
  const auto width = [&](std::size_t shape) {
    const BoundsRow& fat = world.data.shapes.fat_bounds[shape];
    return fat.upper[1] - fat.lower[1];
  };
  EXPECT_NEAR(width(slow), 1.12f, 1e-4);
  EXPECT_NEAR(width(fast), 1.02f, 1e-4);
  EXPECT_NEAR(width(fixed), 1.02f, 1e-4);
  BroadPhase& broad_phase = broad_phase_of(world.data);
  EXPECT_TRUE(broad_phase.bounds_left);
  EXPECT_TRUE(world.data.shapes.dirty.empty());
  EXPECT_EQ(world.data.shapes.flags[slow] & kShapeDirty, 0);

  world.data.bodies.velocity[kFirstBody + 1].linear[0] = 0.0f;
  broad_phase.bounds_left = false;
  update_bounds(world.data, kDt,
                crew);  // the second body has stopped in its tight box: it gets a margin or stays
  broad_phase.bounds_left = false;
  for (int step = 0; step < 20; ++step) {  // 3 cm
    world.integrate(kDt);
    update_bounds(world.data, kDt, crew);
    EXPECT_FALSE(broad_phase.bounds_left) << step;
  }
  for (int step = 0; step < 20; ++step) {  // 3 cm more
    world.integrate(kDt);
    update_bounds(world.data, kDt, crew);
  }
  EXPECT_TRUE(broad_phase.bounds_left);
}

TEST(Bounds, AShapeWithoutFiniteBoundsHasEmptyBounds) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const WorkersOptions& options : testing::all_workers()) {
    Workers workers(options);
    Crew crew(workers);
    for (const float bad : {kNan, kInfinity, -kInfinity, 3e38f}) {
      HandMadeWorld world;
      for (int i = 0; i < 20; ++i) world.add_sphere(BodyType::dynamic, {float(i), 0, 0}, 0.5f);
      world.refresh();
      update_bounds(world.data, kDt, crew);
      world.data.bodies.pose[kFirstBody + 3].position[1] = bad;
      world.data.bodies.pose[kFirstBody + 4].rotation[1] = bad;
      update_bounds(world.data, kDt, crew);
      for (std::size_t shape = 0; shape < 20; ++shape) {
        const BoundsRow& fat = world.data.shapes.fat_bounds[shape];
        const bool non_finite = shape == 3 || shape == 4;
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_TRUE(std::isfinite(fat.lower[axis]) && std::isfinite(fat.upper[axis]));
          EXPECT_EQ(fat.lower[axis] > fat.upper[axis], non_finite) << shape << " " << bad;
        }
      }
      // Nothing changes while it stays non-finite.
      broad_phase_of(world.data).bounds_left = false;
      update_bounds(world.data, kDt, crew);
      EXPECT_FALSE(broad_phase_of(world.data).bounds_left);
    }
  }
}

TEST(Bounds, DestroyedShapesThatWereMarkedDirtyAreSkipped) {
  HandMadeWorld world;
  world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  const std::int32_t shape = world.add_sphere(BodyType::dynamic, {0, 0, 0}, 0.5f);
  world.destroy_body(kFirstBody);
  world.destroy_body(kFirstBody + 1);
  world.add_sphere(BodyType::dynamic, {3, 0, 0}, 0.5f);  // reuses the second sphere's slot
  world.refresh();
  EXPECT_EQ(world.data.shapes.dirty.size(), 2u);
  Workers workers(1);
  Crew crew(workers);
  update_bounds(world.data, kDt, crew);
  EXPECT_GT(world.data.shapes.fat_bounds[static_cast<std::size_t>(shape)].lower[0], 2.0f);
  EXPECT_EQ(broad_phase_of(world.data).dirty.size(), 1u);
}

}  // namespace
}  // namespace scree
