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

double distance_from_chord(Point p, Point from, Point to) {
  const Point chord = to - from;
  const double square = dot(chord, chord);
  const double part = square > 0.0 ? std::clamp(dot(p - from, chord) / square, 0.0, 1.0) : 0.0;
  return norm(from + part * chord - p);
}

// Two bodies that turn about other points than their first shapes' centers.
struct TwoMovers {
  World world;
  std::int32_t body[2] = {}, shape[2] = {};

  TwoMovers(Dice& dice, float size, float apart) {
    for (int i = 0; i < 2; ++i) {
      const Vec3 place = dice.within({apart, apart, apart});
      const BodyId id = world.create_body({.position = place, .rotation = dice.rotation()});
      const Vec3 aside = dice.within({size, size, size});
      const ShapeId first =
          world.add_shape(id, dice.geometry(size), {}, {.local_pose = {aside, dice.rotation()}});
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

// m, of the smallest chord's distance from the obstacle's center, beyond the radii of its bounding ball and
// the ball of the shape that is nearest to it.
double least_room(const WorldData& data, const TwoMovers& two, int side, const sweeps::Mover (&movers)[2],
                  float from) {
  constexpr std::size_t kMoments = 24;
  const std::int32_t shape = two.shape[side], obstacle = two.shape[1 - side];
  const sweeps::Mover &mover = movers[side], &other = movers[1 - side];
  const Point center = to_point(to_vec3(data.shapes.pose[obstacle].position));
  const Balls balls = balls_of(data, shape);
  double least = std::numeric_limits<double>::infinity();
  for (int b = 0; b < balls.count; ++b) {
    const Point arm = to_point(sweeps::arm_of(data, two.body[side], shape, balls.ball[b].center));
    std::array<Point, kMoments + 1> way;
    for (std::size_t i = 0; i <= kMoments; ++i) {
      const float t = from + (1.0f - from) * static_cast<float>(i) / kMoments;
      const DeltaRow delta = mover.delta_at(t), other_delta = other.delta_at(t);
      const Point there =
          to_point(mover.start) + to_point(to_vec3(delta.position)) + turn(to_quat(delta.rotation), arm);
      way[i] = to_point(other.start) +
               turn(back(to_quat(other_delta.rotation)),
                    there - to_point(other.start) - to_point(to_vec3(other_delta.position)));
    }
    for (std::size_t i = 0; i <= kMoments; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const double distance = distance_from_chord(center, way[i], way[j]);
        least = std::min(least, distance - double{balls.ball[b].radius});
      }
    }
  }
  return least - double{sweeps::outer_radius_of(data, obstacle)};
}

TEST(SweepClear, NoChordOfWhatIsClearComesNear) {
  Dice dice(71);
  int clear = 0, plain = 0, missed = 0;
  for (int round = 0; round < 1500; ++round) {
    const float size = round % 3 == 0 ? 0.05f : 0.5f, far = round % 4 == 0 ? 20.0f : 3.0f * size;
    TwoMovers two(dice, size, far);
    const float most = round % 2 == 0 ? 0.3f : 3.1f;  // rad
    const auto course = [&](int i) {
      const Vec3 axis = Vec3{0, 0, 1e-3f} + dice.within({1, 1, 1});
      return two.course(i, dice.within({far, far, far}), from_axis_angle(axis, dice.uniform(-most, most)));
    };
    const Course courses[2] = {course(0), course(1)};
    const float from = round % 5 < 3 ? 0.0f : dice.uniform(0.0f, 0.9f);
    const int stopped = round % 5 == 4 ? static_cast<int>(dice.below(2)) : -1;
    sweeps::Mover movers[2] = {courses[0].mover, courses[1].mover};
    if (stopped >= 0) movers[stopped].stop = dice.uniform(0.5f, 1.0f) * from;
    const Leg legs[2] = {sweeps::leg_of(courses[0], movers[0].stop, from),
                         sweeps::leg_of(courses[1], movers[1].stop, from)};
    for (int side = 0; side < 2; ++side) {
      const bool is_clear =
          sweeps::stays_clear(two.data(), two.shape[side], legs[side], two.shape[1 - side], legs[1 - side]);
      const double room = least_room(two.data(), two, side, movers, from);
      if (is_clear) {
        ++clear;
        ASSERT_GT(room, double{kLinearSlop} + double{sweeps::kMostBend})
            << "round " << round << ", side " << side;
      }
      if (most > 1.0f) continue;
      // The shape's bounding ball, and ways that bend by some of the obstacle's distance.
      const double shape_size = sweeps::outer_radius_of(two.data(), two.shape[side]);
      if (!(room > 2.0 * shape_size + 0.2 * double{far + size})) continue;
      ++plain;
      missed += is_clear ? 0 : 1;
    }
  }
  EXPECT_GT(clear, 500);
  EXPECT_GT(plain, 200);
  EXPECT_EQ(missed, 0);
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
  TwoMovers two(dice, 0.1f, 50.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf, 1e30f, 3e38f}) {
    const Leg a = sweeps::leg_of(two.course(0, {bad, 0, 0}, {}), sweeps::kNever, 0.0f);
    const Leg b = sweeps::leg_of(two.course(1, {}, {}), sweeps::kNever, 0.0f);
    EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[0], a, two.shape[1], b)) << bad;
    EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[1], b, two.shape[0], a)) << bad;
  }
  // A way that ends in the middle of the time has no straight line.
  const Leg halting = sweeps::leg_of(two.course(0, {}, {}), 0.5f, 0.0f);
  const Leg other = sweeps::leg_of(two.course(1, {}, {}), sweeps::kNever, 0.0f);
  EXPECT_FALSE(sweeps::stays_clear(two.data(), two.shape[0], halting, two.shape[1], other));
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
