// Laws of automatic cameras: all of the subject is in the picture, and the camera is no farther than it must
// be.
#include <gtest/gtest.h>
#include <tools/render/camera.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace scree::render {
namespace {

constexpr Side kSides[] = {Side::corner, Side::front, Side::side, Side::top};

struct Dice {
  std::mt19937 random;
  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }
  Vec3 point(float reach) { return {between(-reach, reach), between(-reach, reach), between(-reach, reach)}; }
};

Geometry any_shape(Dice& dice) {
  const auto size = [&] { return dice.between(0.05f, 3.0f); };
  switch (dice.random() % 6) {
    case 0:
      return Sphere{size()};
    case 1:
      return Capsule{size(), size()};
    case 2:
      return Box{{size(), size(), size()}, 0.1f};
    case 3:
      return Cylinder{size(), size()};
    case 4:
      return Cone{size(), size()};
    default:
      break;
  }
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i) points.push_back(dice.point(2.0f));
  return ConvexHull{Hull(points), {1.0f, 2.0f, 0.5f}, 0.1f};
}

// How far out the corners lie: 1 at the edges of the picture; and the least depth.
struct Seen {
  double across = 0.0, upright = 0.0, nearest = 1e30;
};

Seen look(const Camera& camera, double aspect, const std::vector<Vec3>& corners) {
  const Axes axes = axes_of(camera);
  const double tangent = std::tan(camera.view * std::numbers::pi / 360.0);
  Seen seen;
  for (const Vec3& corner : corners) {
    const Vec3 offset = corner - camera.eye;
    const double depth = -double{dot(offset, axes.backward)};
    seen.nearest = std::min(seen.nearest, depth);
    seen.across =
        std::max(seen.across, std::abs(double{dot(offset, axes.right)}) / (depth * tangent * aspect));
    seen.upright = std::max(seen.upright, std::abs(double{dot(offset, axes.up)}) / (depth * tangent));
  }
  return seen;
}

TEST(Camera, HasAllOfTheSubjectInItsPictureAndIsAsNearAsItCanBe) {
  Dice dice{std::mt19937(1)};
  for (int round = 0; round < 60; ++round) {
    World world;
    const float spread = std::pow(10.0f, dice.between(-1.0f, 3.0f));
    const int count = 1 + static_cast<int>(dice.random() % 30);
    const Vec3 middle = dice.point(1000.0f);
    for (int i = 0; i < count; ++i) {
      const Quat turn = normalize(
          Quat{dice.between(-1.0f, 1.0f), dice.between(-1.0f, 1.0f), dice.between(-1.0f, 1.0f), 1.5f});
      const BodyId body = world.create_body({.position = middle + dice.point(spread), .rotation = turn});
      world.add_shape(body, any_shape(dice), {}, {.local_pose = {dice.point(1.0f), turn}});
    }
    const Subject subject = subject_of(world);
    const double view = double{dice.between(10.0f, 120.0f)}, aspect = double{dice.between(0.3f, 3.0f)};
    for (const Side side : kSides) {
      const Camera camera = look_from(side, subject, view, aspect);
      const Seen seen = look(camera, aspect, subject.corners);
      EXPECT_GT(seen.nearest, 0.0);
      EXPECT_LE(seen.across, 0.945) << round;
      EXPECT_LE(seen.upright, 0.945) << round;
      const bool fills = std::max(seen.across, seen.upright) > 0.935;
      const bool near = distance(camera.eye, subject.middle) < 1.9f * subject.reach;
      EXPECT_TRUE(fills || near) << round;
    }
  }
}

TEST(Camera, SidesAreWhereTheirNamesSay) {
  World world;
  world.add_shape(world.create_body({}), Box{});
  const Subject subject = subject_of(world);
  const auto from = [&](Side side) {
    const Camera camera = look_from(side, subject, kDefaultView, 1.0);
    return normalize(camera.eye - camera.target);
  };
  EXPECT_NEAR(from(Side::front).z, 1.0f, 1e-5f);
  EXPECT_NEAR(from(Side::side).x, 1.0f, 1e-5f);
  EXPECT_NEAR(from(Side::top).y, 1.0f, 1e-5f);
  for (int axis = 0; axis < 3; ++axis) EXPECT_GT(from(Side::corner)[axis], 0.3f);
}

TEST(Camera, IsUprightAgainstGravity) {
  for (const Vec3 gravity : {Vec3{0.0f, -9.81f, 0.0f}, Vec3{0.0f, 0.0f, -9.81f}, Vec3{5.0f, 0.0f, 0.0f},
                             Vec3{}, Vec3{0.0f, 1e-30f, 0.0f}}) {
    World world({.gravity = gravity});
    world.add_shape(world.create_body({}), Box{});
    const Subject subject = subject_of(world);
    EXPECT_NEAR(length(subject.up), 1.0f, 1e-6f);
    if (length(gravity) > 0.0f) {
      EXPECT_NEAR(dot(subject.up, normalize(gravity)), -1.0f, 1e-6f);
    }
    for (const Side side : kSides) {
      const Axes axes = axes_of(look_from(side, subject, kDefaultView, 1.0));
      EXPECT_NEAR(dot(axes.right, subject.up), 0.0f, 1e-6f);  // the horizon is level
      EXPECT_NEAR(dot(cross(axes.right, axes.up), axes.backward), 1.0f, 1e-5f);
    }
  }
}

TEST(Subject, LeavesOutWhatHasFallenOff) {
  World world;
  for (int i = 0; i < 40; ++i)
    world.add_shape(world.create_body({.position = {static_cast<float>(i), 0.0f, 0.0f}}), Sphere{});
  const Subject before = subject_of(world);
  world.add_shape(world.create_body({.position = {0.0f, -5000.0f, 0.0f}}), Sphere{});
  const Subject after = subject_of(world);
  EXPECT_EQ(after.corners.size(), before.corners.size());
  EXPECT_EQ(after.reach, before.reach);
}

TEST(Subject, OfTwoBodiesIsBoth) {
  World world;
  world.add_shape(world.create_body({.position = {-1000.0f, 0.0f, 0.0f}}), Sphere{});
  world.add_shape(world.create_body({.position = {1000.0f, 0.0f, 0.0f}}), Sphere{});
  EXPECT_GT(subject_of(world).reach, 1000.0f);
}

TEST(Subject, IsWhatMovesAndElseWhatStands) {
  World world;
  EXPECT_EQ(subject_of(world).reach, std::sqrt(3.0f));
  const BodyId floor = world.create_body({.type = BodyType::fixed});
  world.add_shape(floor, HalfSpace{});
  EXPECT_EQ(subject_of(world).reach, std::sqrt(3.0f));  // half-spaces have no end
  world.add_shape(floor, Box{{50.0f, 1.0f, 50.0f}});
  EXPECT_GT(subject_of(world).reach, 60.0f);
  world.add_shape(world.create_body({}), Sphere{1.0f});
  EXPECT_LT(subject_of(world).reach, 2.0f);
  const BodyId belt = world.create_body({.type = BodyType::kinematic});
  world.add_shape(belt, Box{{1000.0f, 1.0f, 1000.0f}});  // too large to be part of it
  EXPECT_LT(subject_of(world).reach, 2.0f);
}

}  // namespace
}  // namespace scree::render
