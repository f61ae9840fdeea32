// Laws of movers beside fixed shapes: they never enter them, slide along walls and stop in corners.
#include <tests/parallel/mover/mover_fixture.h>
#include <tools/scenes/random.h>

#include <vector>

namespace scree::testing {
namespace {

TEST(MoverWalls, AMoverSlidesAlongAWallWithItsWholeTangentialSpeed) {
  for (const double degrees : {5.0, 30.0, 60.0, 85.0}) {
    MoverLab lab;
    lab.add_floor();
    lab.add_box(BodyType::fixed, {11, 2, 0}, {10, 5, 500});  // its face at x = 1
    lab.place({0, lab.standing(), 0});
    const float speed = 4.0f;
    const float into = speed * static_cast<float>(std::sin(degrees * kDegree));
    const float along = speed * static_cast<float>(std::cos(degrees * kDegree));
    const int moves = 240;
    lab.move({into, 0, along}, moves);
    EXPECT_NEAR(lab.mover.position.z, along * static_cast<float>(moves) * kMoverStep, 2e-4f) << degrees;
    EXPECT_NEAR(lab.mover.position.x, 1.0f - lab.settings.radius - lab.settings.skin, 1e-4f);
    EXPECT_NEAR(lab.mover.velocity.z, along, 1e-4f);
    EXPECT_NEAR(lab.mover.velocity.x, 0.0f, 1e-4f);
    EXPECT_TRUE(lab.mover.touches_wall);
  }
}

TEST(MoverWalls, AMoverSlidesAlongAWallAboveNoGround) {
  MoverLab lab;
  lab.add_box(BodyType::fixed, {11, 0, 0}, {10, 50, 500});
  lab.place({0, 0, 0});
  lab.move({3, -2, 1}, 120);
  EXPECT_NEAR(lab.mover.position.z, 2.0f, 1e-4f);
  EXPECT_NEAR(lab.mover.position.y, -4.0f, 1e-4f);
  EXPECT_NEAR(lab.mover.position.x, 1.0f - 0.32f, 1e-4f);
}

TEST(MoverWalls, AMoverStopsInACornerAndStaysThere) {
  for (const double degrees : {0.0, 20.0, 45.0}) {
    MoverLab lab;
    lab.add_floor();
    const Quat turned = from_axis_angle({0, 1, 0}, static_cast<float>(degrees * kDegree));
    for (const Vec3 outward : {Vec3{1, 0, 0}, Vec3{0, 0, 1}}) {
      const Vec3 to = rotate(turned, outward);
      lab.add_box(BodyType::fixed, 3.0f * to, {1, 5, 20},
                  outward.x > 0.5f ? turned : turned * from_axis_angle({0, 1, 0}, 1.5707964f));
    }
    lab.place({0, lab.standing(), 0});
    lab.move(rotate(turned, {3, 0, 2}), 120);
    const Vec3 stopped = lab.mover.position;
    const Vec3 corner = rotate_back(turned, stopped);
    EXPECT_NEAR(corner.x, 2.0f - 0.32f, 2e-4f);
    EXPECT_NEAR(corner.z, 2.0f - 0.32f, 2e-4f);
    EXPECT_LT(length(lab.mover.velocity), 1e-4f);
    lab.move(rotate(turned, {3, 0, 2}), 600);
    EXPECT_LT(distance(lab.mover.position, stopped), 1e-4f);
    // And out again at full speed.
    lab.move(rotate(turned, {-3, 0, -3}), 30);
    EXPECT_NEAR(distance(lab.mover.position, stopped), 3.0f * std::sqrt(2.0f) * 0.5f, 1e-3f);
  }
}

TEST(MoverWalls, AnAcuteWedgeStopsAMoverWithoutTrembling) {
  MoverLab lab;
  lab.add_floor();
  const Quat left = from_axis_angle({0, 1, 0}, 0.2f), right = from_axis_angle({0, 1, 0}, -0.2f);
  lab.add_box(BodyType::fixed, rotate(left, {0, 0, 2}), {20, 5, 1}, left);
  lab.add_box(BodyType::fixed, rotate(right, {0, 0, -2}), {20, 5, 1}, right);
  lab.place({0, lab.standing(), 0});
  lab.move({5, 0, 0.3f}, 300);
  const Vec3 stopped = lab.mover.position;
  for (int i = 0; i < 100; ++i) {
    lab.move({5, 0, 0.3f}, 1);
    EXPECT_LT(distance(lab.mover.position, stopped), 1e-4f);
  }
  EXPECT_GT(lab.gap(), 0.9 * lab.settings.skin);
}

TEST(MoverWalls, FastMoversStopAtThinWalls) {
  MoverLab lab;
  lab.add_floor();
  lab.add_box(BodyType::fixed, {30, 2, 0}, {0.01f, 5, 50});
  lab.place({0, lab.standing(), 0});
  lab.move({10000, 0, 0}, 3);
  EXPECT_NEAR(lab.mover.position.x, 30.0f - 0.01f - 0.32f, 1e-3f);
}

TEST(MoverWalls, AMoverThatStandsStaysToTheBit) {
  MoverLab lab;
  lab.add_box(BodyType::fixed, {0, -1, 0}, {100, 1, 100}, from_axis_angle({0, 0, 1}, 0.3f));
  lab.place({3, 5, 2});
  lab.wait(120);
  ASSERT_EQ(lab.mover.ground, MoverGround::firm);
  const MoverState before = lab.mover;
  lab.wait(600);
  EXPECT_EQ(lab.mover, before);
}

// A room with random boxes, hulls, balls and capsules, some of which overlap.
void fill_room(MoverLab& lab, scenes::Random& random) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      Vec3 center{}, half{6, 6, 6};
      center[axis] = side * 6.0f;
      half[axis] = 1.0f;
      lab.add_box(BodyType::fixed, center, half);
    }
  }
  const auto within = [&](float reach) {
    const float x = random.between(-reach, reach);
    const float y = random.between(-reach, reach);
    const float z = random.between(-reach, reach);
    return Vec3{x, y, z};
  };
  for (int i = 0; i < 40; ++i) {
    const Vec3 place = within(5.0f);
    const Quat turn = from_axis_angle(within(1.0f) + Vec3{0, 1.5f, 0}, random.between(-3.0f, 3.0f));
    if (length(place) < 2.0f) continue;  // room to begin in
    const BodyId body = lab.world.create_body({.type = BodyType::fixed, .position = place, .rotation = turn});
    switch (random.below(4)) {
      case 0:
        lab.world.add_shape(body, Sphere{random.between(0.1f, 0.8f)});
        break;
      case 1:
        lab.world.add_shape(body, Capsule{random.between(0.1f, 1.0f), random.between(0.05f, 0.4f)});
        break;
      case 2:
        lab.world.add_shape(body, Box{Vec3{0.6f, 0.6f, 0.6f} + 0.5f * within(1.0f)});
        break;
      default: {
        std::vector<Vec3> points;
        for (int k = 0; k < 16; ++k) points.push_back(within(0.9f));
        lab.world.add_shape(body, ConvexHull{Hull(points)});
      }
    }
  }
}

class MoverRooms : public ::testing::TestWithParam<int> {};

TEST_P(MoverRooms, NoMoveEntersAFixedShape) {
  scenes::Random random(static_cast<std::uint64_t>(GetParam()));
  MoverLab lab;
  fill_room(lab, random);
  lab.settings.radius = 0.25f;
  lab.settings.half_height = 0.35f;
  lab.place({0, 0, 0});
  double least = 1.0, way = 0.0;
  Vec3 wish{};
  for (int i = 0; i < 1500; ++i) {
    if (i % 20 == 0) {
      const float x = random.between(-8.0f, 8.0f);
      const float z = random.between(-8.0f, 8.0f);
      const float y = random.between(-4.0f, 6.0f);
      wish = {x, y, z};
    }
    Vec3 wanted = wish;
    if (lab.mover.ground != MoverGround::firm) wanted.y = lab.mover.velocity.y - 9.81f * kMoverStep;
    const Vec3 before = lab.mover.position;
    lab.move(wanted, 1);
    way += double{distance(before, lab.mover.position)};
    least = std::min(least, lab.gap());
    ASSERT_GT(lab.gap(), -1e-4) << "move " << i;
    ASSERT_FALSE(lab.mover.squeezed);
    ASSERT_LT(std::abs(lab.mover.position.x) + lab.settings.radius, 5.0f);
    ASSERT_LT(std::abs(lab.mover.position.z) + lab.settings.radius, 5.0f);
    ASSERT_LT(std::abs(lab.mover.position.y) + lab.settings.radius + lab.settings.half_height, 5.0f);
  }
  EXPECT_GT(way, 20.0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MoverRooms, ::testing::Range(1, 9));

// Movers that begin within shapes come out of them.
TEST(MoverWalls, AMoverThatBeginsInABoxLeavesItByTheNearestSide) {
  MoverLab lab;
  lab.add_box(BodyType::fixed, {0, 0, 0}, {2, 5, 2});
  lab.place({1.5f, 0, 0.2f});
  EXPECT_FALSE(lab.mover.squeezed);
  EXPECT_GT(lab.gap(), 0.0);
  EXPECT_NEAR(lab.mover.position.x, 2.32f, 1e-3f);
  EXPECT_NEAR(lab.mover.position.z, 0.2f, 1e-3f);
}

TEST(MoverWalls, AMoverBetweenWallsThatAreTooNarrowStaysInTheMiddle) {
  MoverLab lab;
  for (const float side : {-1.0f, 1.0f}) lab.add_box(BodyType::fixed, {side * 1.31f, 0, 0}, {1, 5, 5});
  lab.place({0.005f, 0, 0});  // 10 mm on each side, where it wants 20
  EXPECT_NEAR(lab.mover.position.x, 0.0f, 1e-3f);
  EXPECT_FALSE(lab.mover.squeezed);
  lab.move({0, 0, 1}, 60);
  EXPECT_NEAR(lab.mover.position.z, 1.0f, 1e-3f);
  EXPECT_NEAR(lab.mover.position.x, 0.0f, 1e-3f);
}

TEST(MoverWalls, FiltersTypesAndThePredicateChooseWhatCounts) {
  for (int kind = 0; kind < 4; ++kind) {
    MoverLab lab;
    lab.add_floor();
    const BodyId wall = lab.world.create_body({.type = BodyType::kinematic, .position = {2, 2, 0}});
    const ShapeId shape =
        lab.world.add_shape(wall, Box{{0.5f, 5, 50}}, {}, {.filter = {.category = 2u, .mask = 2u}});
    lab.place({0, lab.standing(), 0});
    if (kind == 0) lab.settings.filter = Filter{.category = 1u, .mask = 1u};
    if (kind == 1) lab.settings.types = BodyTypes::fixed;
    if (kind == 2) lab.settings.ignored = wall;
    if (kind == 3) lab.settings.predicate = [shape](ShapeId asked, BodyId) { return asked != shape; };
    lab.settings.step_height = 0.0f;
    lab.move({4, 0, 0}, 60);
    EXPECT_EQ(lab.mover.ground, MoverGround::firm);
    EXPECT_NEAR(lab.mover.position.x, 4.0f, 1e-3f) << kind;
  }
}

}  // namespace
}  // namespace scree::testing
