// Laws of the proofs that shapes stay clear of each other: they are never wrong, and see what is plain.
#include <core/geometry/balls.h>
#include <core/world/edit.h>
#include <parallel/continuous/sweep_clear.h>
#include <parallel/continuous/sweep_convex.h>
#include <parallel/continuous/sweep_path.h>
#include <tests/parallel/queries/query_fixture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace scree::testing {
namespace {

using sweeps::Course;
using sweeps::Leg;

// Two bodies that turn about other points than their first shapes' centers.
struct TwoMovers {
  World world;
  std::int32_t body[2] = {}, shape[2] = {};

  // `kinds`: of shapes, as Dice::geometry() numbers them.
  TwoMovers(Dice& dice, float size, float apart, std::uint32_t kinds = 8) {
    for (int i = 0; i < 2; ++i) {
      const Vec3 place = dice.within({apart, apart, apart});
      const BodyId id = world.create_body({.position = place, .rotation = dice.rotation()});
      const Vec3 aside = dice.within({size, size, size});
      const ShapeId first = world.add_shape(id, dice.geometry(size, dice.below(kinds)), {},
                                            {.local_pose = {aside, dice.rotation()}});
      world.add_shape(id, Sphere{size}, {}, {.local_pose = {-1.0f * aside, {}}});
      body[i] = static_cast<std::int32_t>(id.index);
      shape[i] = static_cast<std::int32_t>(first.index);
    }
    Workers workers(1);
    step(world, 1e-6f, workers);
  }
  WorldData& data() { return internals(world); }
  Course course(int i, Vec3 way, Quat turn) {
    DeltaRow& delta = data().bodies.delta[body[i]];
    store(delta.position, way);
    store(delta.rotation, turn);
    return sweeps::course_of(data(), body[i]);
  }
};

constexpr std::size_t kMoments = 12;

// Where a ball's center is at moments of its way, in the obstacle's frame.
std::array<Point, kMoments + 1> way_of(const TwoMovers& two, const WorldData& data, int side,
                                       const Ball& ball, const sweeps::Mover (&movers)[2], float from) {
  const std::int32_t shape = two.shape[side], obstacle = two.shape[1 - side];
  const sweeps::Mover &mover = movers[side], &other = movers[1 - side];
  const Point arm = to_point(sweeps::arm_of(data, two.body[side], shape, ball.center));
  const PoseRow& pose = data.shapes.pose[obstacle];
  std::array<Point, kMoments + 1> way;
  for (std::size_t i = 0; i <= kMoments; ++i) {
    const float t = from + (1.0f - from) * static_cast<float>(i) / kMoments;
    const DeltaRow delta = mover.delta_at(t), other_delta = other.delta_at(t);
    const Point there =
        to_point(mover.start) + to_point(to_vec3(delta.position)) + turn(to_quat(delta.rotation), arm);
    const Point seen =
        to_point(other.start) + turn(back(to_quat(other_delta.rotation)),
                                     there - to_point(other.start) - to_point(to_vec3(other_delta.position)));
    way[i] = turn(back(to_quat(pose.rotation)), seen - to_point(to_vec3(pose.position)));
  }
  return way;
}

float distance_of(const WorldData& data, std::int32_t obstacle, Point p) {
  const Vec3 point{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  return sweeps::ConvexObstacle{data, obstacle}.distance_at({point, {}}, 0.0f).value;
}

// m, that a ball's way leaves between the ball and the obstacle at least.
float least_way(const TwoMovers& two, const WorldData& data, int side, const Ball& ball,
                const sweeps::Mover (&movers)[2], float from) {
  float least = std::numeric_limits<float>::infinity();
  for (const Point& p : way_of(two, data, side, ball, movers, from)) {
    least = std::min(least, distance_of(data, two.shape[1 - side], p));
  }
  return least - ball.radius;
}

// The same of chords of its way, as sweeps measure it.
float least_room(const TwoMovers& two, const WorldData& data, int side, const Ball& ball,
                 const sweeps::Mover (&movers)[2], float from) {
  const std::array<Point, kMoments + 1> way = way_of(two, data, side, ball, movers, from);
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i <= kMoments; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      for (const double share : {0.0, 0.25, 0.5, 0.75}) {
        const Point p = way[i] + share * (way[j] - way[i]);
        least = std::min(least, distance_of(data, two.shape[1 - side], p));
      }
    }
  }
  return least - ball.radius;
}

TEST(SweepClear, NoChordOfWhatIsClearComesNear) {
  // What first_within() adds to the radius: bend and tolerance, and the tolerance once more.
  constexpr float kLook = sweeps::kMostBend + 2.0f * 0.1f * kLinearSlop;
  Dice dice(71);
  int clear = 0, clear_balls = 0, plain = 0, missed = 0;
  for (int round = 0; round < 5000; ++round) {
    const float size = round % 3 == 0 ? 0.2f : 1.0f, far = round % 4 == 0 ? 20.0f : 2.0f * size;
    const float way = round % 4 == 1 ? 0.1f * size : far;
    TwoMovers two(dice, size, far);
    const float most = round % 2 == 0 ? 0.3f : 3.1f;  // rad
    const auto place = [&](int i) { return to_vec3(two.data().bodies.pose[two.body[i]].position); };
    const auto course = [&](int i) {
      const Vec3 axis = Vec3{0, 0, 1e-3f} + dice.within({1, 1, 1});
      Vec3 moved = dice.within({way, way, way});
      if (round % 4 == 0) {  // the first one flies past the other one in the middle of the step
        moved = dice.within({2.0f * size, 2.0f * size, 2.0f * size});
        if (i == 0) moved += 2.0f * (place(1) - place(0));
      }
      return two.course(i, moved, from_axis_angle(axis, dice.uniform(-most, most)));
    };
    const Course courses[2] = {course(0), course(1)};
    const float from = round % 5 < 3 ? 0.0f : dice.uniform(0.0f, 0.9f);
    sweeps::Mover movers[2] = {courses[0].mover, courses[1].mover};
    if (round % 5 == 4) movers[dice.below(2)].stop = dice.uniform(0.5f, 1.0f) * from;
    const Leg legs[2] = {sweeps::leg_of(courses[0], movers[0].stop, from),
                         sweeps::leg_of(courses[1], movers[1].stop, from)};
    const WorldData& data = two.data();
    for (int side = 0; side < 2; ++side) {
      const std::int32_t shape = two.shape[side], obstacle = two.shape[1 - side];
      sweeps::Passage passage;
      const bool is_clear = sweeps::stays_clear(data, shape, legs[side], obstacle, legs[1 - side], passage);
      clear += is_clear ? 1 : 0;
      float room = std::numeric_limits<float>::infinity();
      const Balls balls = balls_of(data, shape);
      for (int b = 0; b < balls.count; ++b) {
        const float of_ball = least_room(two, data, side, balls.ball[b], movers, from);
        room = std::min(room, of_ball);
        const bool is_ball_clear = !is_clear && sweeps::stays_clear(passage, balls.ball[b]);
        clear_balls += is_ball_clear ? 1 : 0;
        if (!is_clear && !is_ball_clear) continue;
        ASSERT_GT(of_ball, kLook) << "round " << round << ", side " << side << ", ball " << b;
      }
      // Slow turns and far away, as the sizes of the shapes and ways go.
      if (most > 1.0f || !(room > 4.0f * size + far)) continue;
      ++plain;
      missed += is_clear ? 0 : 1;
    }
  }
  EXPECT_GT(clear, 1500);
  EXPECT_GT(clear_balls, 500);
  EXPECT_GT(plain, 30);
  EXPECT_EQ(missed, 0);
}

// Balls and capsules that pass close by each other.
TEST(SweepClear, NoChordOfWhatIsPartedComesNear) {
  constexpr float kLook = sweeps::kMostBend + 2.0f * 0.1f * kLinearSlop;
  constexpr std::uint32_t kRound = 2;
  Dice dice(75);
  int parted = 0, only_parted = 0, near = 0;
  for (int round = 0; round < 6000; ++round) {
    const float size = round % 3 == 0 ? 0.1f : 1.0f, far = (round % 2 == 0 ? 0.5f : 1.5f) * size;
    TwoMovers two(dice, size, far, kRound);
    const float most = round % 4 == 0 ? 3.1f : round % 4 == 1 ? 0.5f : 0.1f;  // rad
    const Vec3 shared = dice.within({size, size, size});
    const auto course = [&](int i) {
      const Vec3 axis = Vec3{0, 0, 1e-3f} + dice.within({1, 1, 1});
      const Vec3 own = dice.within({far, far, far});
      return two.course(i, shared + own, from_axis_angle(axis, dice.uniform(-most, most)));
    };
    const Course courses[2] = {course(0), course(1)};
    const float from = round % 5 < 3 ? 0.0f : dice.uniform(0.0f, 0.9f);
    sweeps::Mover movers[2] = {courses[0].mover, courses[1].mover};
    if (round % 5 == 4) movers[dice.below(2)].stop = dice.uniform(0.5f, 1.0f) * from;
    const Leg legs[2] = {sweeps::leg_of(courses[0], movers[0].stop, from),
                         sweeps::leg_of(courses[1], movers[1].stop, from)};
    const WorldData& data = two.data();
    const bool is_parted = sweeps::stay_parted(data, two.shape, legs);
    parted += is_parted ? 1 : 0;
    for (int side = 0; side < 2; ++side) {
      const std::int32_t shape = two.shape[side], obstacle = two.shape[1 - side];
      sweeps::Passage passage;
      const bool is_clear = sweeps::stays_clear(data, shape, legs[side], obstacle, legs[1 - side], passage);
      only_parted += is_parted && !is_clear ? 1 : 0;
      const Balls balls = balls_of(data, shape);
      for (int b = 0; b < balls.count; ++b) {
        const float room = least_way(two, data, side, balls.ball[b], movers, from);
        near += room < 0.02f * size ? 1 : 0;
        ASSERT_TRUE(!is_parted || room > kLook + sweeps::kMostBend)
            << "round " << round << ", side " << side << ", ball " << b << ": " << room;
      }
    }
  }
  EXPECT_GT(parted, 1000);
  EXPECT_GT(only_parted, 500);
  EXPECT_GT(near, 500);
}

TEST(SweepClear, OnlyRoundShapesThatMoveToTheEndAreParted) {
  Dice dice(76);
  for (int round = 0; round < 100; ++round) {
    TwoMovers two(dice, 0.1f, 50.0f);
    const Leg legs[2] = {sweeps::leg_of(two.course(0, {}, {}), sweeps::kNever, 0.0f),
                         sweeps::leg_of(two.course(1, {}, {}), sweeps::kNever, 0.0f)};
    const auto is_round = [&](int i) {
      const ShapeType type = two.data().shapes.type[two.shape[i]];
      return type == ShapeType::sphere || type == ShapeType::capsule;
    };
    EXPECT_EQ(sweeps::stay_parted(two.data(), two.shape, legs), is_round(0) && is_round(1));
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, inf, -inf, 1e30f, 3e38f}) {
      const Leg lost[2] = {sweeps::leg_of(two.course(0, {bad, 0, 0}, {}), sweeps::kNever, 0.0f), legs[1]};
      EXPECT_FALSE(sweeps::stay_parted(two.data(), two.shape, lost)) << bad;
    }
    const Leg halting[2] = {legs[0], sweeps::leg_of(two.course(1, {}, {}), 0.5f, 0.0f)};
    EXPECT_FALSE(sweeps::stay_parted(two.data(), two.shape, halting));
  }
}

TEST(SweepClear, NoPointOfALineBesideTheBoxIsNear) {
  Dice dice(73);
  int beside = 0, near = 0;
  for (int round = 0; round < 3000; ++round) {
    const float size = round % 3 == 0 ? 0.2f : 1.0f;
    TwoMovers two(dice, size, round % 4 == 0 ? 1000.0f : size);
    const WorldData& data = two.data();
    const PoseRow& pose = data.shapes.pose[two.shape[1]];
    const auto start = [&](int i) { return to_vec3(data.bodies.pose[two.body[i]].position); };
    const sweeps::ObstacleBox box = sweeps::box_about(data, two.shape[1], start(0), start(1));
    ASSERT_TRUE(box.is_there);
    const float wide = 3.0f * size, room = dice.uniform(0.0f, 0.2f) * size;
    const Vec3 from = box.origin + dice.within({wide, wide, wide}),
               to = box.origin + dice.within({wide, wide, wide});
    float least = std::numeric_limits<float>::infinity();
    for (int i = 0; i <= 32; ++i) {
      const Vec3 point = from + static_cast<float>(i) / 32.0f * (to - from);
      const Vec3 there = rotate_back(to_quat(pose.rotation), point - to_vec3(pose.position));
      least =
          std::min(least, sweeps::ConvexObstacle{data, two.shape[1]}.distance_at({there, {}}, 0.0f).value);
    }
    const bool is_beside = sweeps::stays_beside(box, from, to, room);
    beside += is_beside ? 1 : 0;
    near += least <= room ? 1 : 0;
    ASSERT_TRUE(!is_beside || least > room) << "round " << round;
  }
  EXPECT_GT(beside, 300);
  EXPECT_GT(near, 200);
}

TEST(SweepClear, BowsHoldAndAreTight) {
  Dice dice(72);
  for (int round = 0; round < 2000; ++round) {
    const float most = round % 2 == 0 ? 0.1f : 3.14f;
    const auto part = [&] {
      const Vec3 axis = Vec3{0, 0, 1e-3f} + dice.within({1, 1, 1});
      const Quat q = from_axis_angle(axis, dice.uniform(-most, most));
      return q.w < 0.0f ? Quat{-q.x, -q.y, -q.z, -q.w} : q;
    };
    const sweeps::Motion motion{{}, part(), round % 3 == 0 ? Quat{} : part()};
    const double bow = sweeps::bow_of(motion);
    const Point arm = to_point(dice.within({1, 1, 1}));
    const auto at = [&](float t) { return turn(to_quat(sweeps::part_of(motion, t).rotation), arm); };
    const Point end = at(1.0f);
    for (const float t : {0.1f, 0.25f, 0.5f, 0.6f, 0.9f}) {
      const Point line = arm + double{t} * (end - arm);
      ASSERT_LE(norm(at(t) - line), bow * norm(arm) + 1e-7) << "round " << round << " at " << t;
    }
  }
  // Half a turn: the middle is an arm's length away from the line.
  EXPECT_NEAR(sweeps::bow_of({{}, Quat{0, 0, 1, 0}, Quat{}}), 1.0f, 1e-3f);
  // A small turn's sagitta.
  const Quat small = from_axis_angle({1, 0, 0}, 0.1f);
  EXPECT_NEAR(sweeps::bow_of({{}, small, Quat{}}), 0.1f * 0.1f / 8.0f, 1e-4f);
  EXPECT_TRUE(std::isinf(sweeps::bow_of({{}, Quat{0, 0, 0, 1.1f}, Quat{}})));
}

TEST(SweepClear, NothingIsKnownOfWhatIsNotFinite) {
  Dice dice(73);
  TwoMovers two(dice, 0.3f, 50.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 1e30f, 3e38f}) {
    const Leg a = sweeps::leg_of(two.course(0, {bad, 0, 0}, {}), sweeps::kNever, 0.0f);
    const Leg b = sweeps::leg_of(two.course(1, {}, {}), sweeps::kNever, 0.0f);
    sweeps::Passage passage;
    EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[0], a, two.shape[1], b, passage)) << bad;
    EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[1], b, two.shape[0], a, passage)) << bad;
  }
  // A way that ends in the middle of the time has no straight line.
  const Leg halting = sweeps::leg_of(two.course(0, {}, {}), 0.5f, 0.0f);
  const Leg other = sweeps::leg_of(two.course(1, {}, {}), sweeps::kNever, 0.0f);
  sweeps::Passage passage;
  EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[0], halting, two.shape[1], other, passage));
}

TEST(SweepClear, WhatStartsClearHasNoBallThatTouches) {
  Dice dice(74);
  int clear = 0;
  for (int round = 0; round < 500; ++round) {
    TwoMovers two(dice, 0.3f, 0.6f);
    const WorldData& data = two.data();
    if (!sweeps::starts_clear(data, two.shape[0], two.shape[1])) continue;
    ++clear;
    for (int side = 0; side < 2; ++side) {
      const std::int32_t shape = two.shape[side], obstacle = two.shape[1 - side];
      const Balls balls = balls_of(data, shape);
      const PoseRow& pose = data.shapes.pose[obstacle];
      for (int b = 0; b < balls.count; ++b) {
        const Vec3 center = to_vec3(data.bodies.pose[two.body[side]].position) +
                            sweeps::arm_of(data, two.body[side], shape, balls.ball[b].center);
        const Vec3 local = rotate_back(to_quat(pose.rotation), center - to_vec3(pose.position));
        const float gap = sweeps::ConvexObstacle{data, obstacle}.distance_at({local, {}}, 0.0f).value;
        ASSERT_GT(gap - balls.ball[b].radius, kLinearSlop) << "round " << round;
      }
    }
  }
  EXPECT_GT(clear, 50);
}

}  // namespace
}  // namespace scree::testing
