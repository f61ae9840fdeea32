// The course of the mover's example; see course.h. It leads along x:
// 0 floor, 2 stairs to 1.5 m, 8 a slope down, 12 a pit with a ferry, 18 floor with crates, 26 an elevator to
// 3 m.
#include <tools/mover/course.h>

#include <algorithm>
#include <cmath>

namespace scree::course {

namespace {

constexpr float kSpeed = 1.8f;                          // m/s, of the walker
constexpr float kPierEnd = 12.0f, kShore = 18.0f;       // m, of the pit
constexpr float kShaft = 26.0f, kTop = 28.0f;           // m, the elevator is between
constexpr float kTopHeight = 3.0f;                      // m
constexpr float kFerryHalf = 1.0f, kFerrySpeed = 0.8f;  // m, m/s
constexpr float kPushed = 1.2f;                         // m, how far the crates are pushed
constexpr float kLiftSpeed = 1.2f;                      // m/s

BodyId add_box(World& world, BodyType type, Vec3 lower, Vec3 upper) {
  const BodyId body = world.create_body({.type = type, .position = 0.5f * (lower + upper)});
  world.add_shape(body, Box{0.5f * (upper - lower)});
  return body;
}

// A way there and back at an even pace, with a pause of a second at both ends: 0 to 1.
float shuttle(float seconds, float travel) {
  const float lap = 2.0f * (travel + 1.0f), time = std::fmod(seconds, lap);
  if (time < 1.0f) return 0.0f;
  if (time < 1.0f + travel) return (time - 1.0f) / travel;
  if (time < 2.0f + travel) return 1.0f;
  return 1.0f - (time - 2.0f - travel) / travel;
}

// It turns once on each way.
Pose ferry_at(float seconds) {
  constexpr float kTravel = (kShore - kPierEnd - 2.0f * kFerryHalf) / kFerrySpeed;
  const float share = shuttle(seconds, kTravel);
  const float x = kPierEnd + kFerryHalf + share * (kShore - kPierEnd - 2.0f * kFerryHalf);
  return {{x, -0.25f, 0}, from_axis_angle({0, 1, 0}, 6.2831853f * share)};
}
Pose elevator_at(float seconds) {
  const float share = shuttle(seconds, kTopHeight / kLiftSpeed);
  return {{0.5f * (kShaft + kTop), kTopHeight * share - 0.25f, 0}, {}};
}

float feet_of(const Course& course) {
  return course.walker.position.y - course.settings.half_height - course.settings.radius;
}

// The level velocity that the walker wants, relative to what it stands on.
Vec3 will_of(const Course& course) {
  const Vec3 place = course.walker.position;
  const auto towards = [&](Vec3 goal) {
    const Vec3 way{goal.x - place.x, 0, goal.z - place.z};
    const float size = length(way);
    return size > 1e-3f ? std::min(kSpeed, size / kStep) / size * way : Vec3{};
  };
  const float ferry = course.world.pose(course.ferry).position.x;
  const float lift = course.world.pose(course.elevator).position.y + 0.25f;
  switch (course.part()) {
    case Part::pier:  // waits for the ferry
      if (ferry < kPierEnd + kFerryHalf + 0.01f) return towards({ferry, 0, 0});
      return towards({kPierEnd - 0.6f, 0, 0});
    case Part::ferry:
      if (ferry > kShore - kFerryHalf - 0.01f) return towards({kShore + 2.0f, 0, 0});
      return {};
    case Part::crates:
      if (course.crates_moved() < kPushed) return towards({place.x + 1.0f, 0, 0});
      if (place.x < kShaft - 2.0f) {  // around the crates
        return place.z < 1.7f ? towards({place.x, 0, 1.8f}) : towards({kShaft - 1.0f, 0, 1.8f});
      }
      if (lift > 0.01f) return towards({kShaft - 1.0f, 0, 0});  // and waits for the elevator
      return towards({kShaft + 1.0f, 0, 0});
    case Part::elevator:
      if (lift > kTopHeight - 0.01f || course.walker.ground_body != course.elevator)
        return towards({kTop + 2.0f, 0, 0});
      return towards({0.5f * (kShaft + kTop), 0, 0});
    case Part::arrived:
      return {};
    default:
      return towards({kPierEnd - 0.6f, 0, 0});
  }
}

void measure(Course& course) {
  constexpr float kThin = 1e-4f;  // m
  const MoverSettings& settings = course.settings;
  const auto nearest = closest_to_shape(
      course.world, {Capsule{settings.half_height, kThin}, {course.walker.position, {}}}, 1.0f);
  if (nearest) {
    const double gap = static_cast<double>(nearest->distance + kThin - settings.radius);
    course.figures.nearest = std::min(course.figures.nearest, gap);
  }
  if (course.walker.ground != MoverGround::firm) ++course.figures.steps_in_air;
}

}  // namespace

Course::Course() {
  add_box(world, BodyType::fixed, {-3, -1, -3}, {kPierEnd, 0, 3});
  for (int i = 0; i < 6; ++i) {  // stairs, and a terrace behind them
    const float x = 2.0f + 0.5f * static_cast<float>(i), y = 0.25f * static_cast<float>(i);
    add_box(world, BodyType::fixed, {x, y, -3}, {8, y + 0.25f, 3});
  }
  // A slope of 30 degrees from the terrace down.
  const BodyId slope = world.create_body({.type = BodyType::fixed, .position = {8, 0, 0}});
  const Vec3 wedge[] = {{0, 0, -3}, {0, 0, 3}, {0, 1.5f, -3}, {0, 1.5f, 3}, {2.598f, 0, -3}, {2.598f, 0, 3}};
  world.add_shape(slope, ConvexHull{Hull(wedge)});
  ferry = add_box(world, BodyType::kinematic, {-kFerryHalf, -0.25f, -kFerryHalf},
                  {kFerryHalf, 0.25f, kFerryHalf});
  world.set_pose(ferry, ferry_at(0));
  add_box(world, BodyType::fixed, {kShore, -1, -3}, {kShaft, 0, 3});
  for (int i = 0; i < 3; ++i) {
    const float x = 20.0f + 0.85f * static_cast<float>(i);
    crates[i] = world.create_body({.position = {x, 0.4f, 0}, .mass = 25.0f});
    world.add_shape(crates[i], Box{{0.4f, 0.4f, 0.4f}}, {.friction = 0.4f});
  }
  elevator = add_box(world, BodyType::kinematic, {-1, -0.25f, -1}, {1, 0.25f, 1});
  world.set_pose(elevator, elevator_at(0));
  add_box(world, BodyType::fixed, {kTop, -1, -3}, {kTop + 6, kTopHeight, 3});
  walker.position = {0, settings.half_height + settings.radius + settings.skin, 0};
  move(world, walker, settings, {}, kStep);
}

Part Course::part() const {
  const float x = walker.position.x;
  if (x < 7.0f) return Part::stairs;
  if (walker.ground_body == ferry) return Part::ferry;
  if (walker.ground_body == elevator) return Part::elevator;
  if (x < 10.6f) return Part::slope;
  if (x < kPierEnd + kFerryHalf) return Part::pier;
  if (x < kShaft) return Part::crates;
  return x < kTop + 1.0f || feet_of(*this) < kTopHeight - 0.1f ? Part::elevator : Part::arrived;
}

const char* name_of(Part part) {
  constexpr const char* kNames[] = {"stairs", "slope", "pier", "ferry", "crates", "elevator", "arrived"};
  return kNames[static_cast<int>(part)];
}

const char* Course::ground_name() const {
  if (walker.ground == MoverGround::none) return "nothing";
  if (walker.ground == MoverGround::steep) return "a steep slope";
  if (walker.ground_body == ferry) return "the ferry";
  if (walker.ground_body == elevator) return "the elevator";
  return "the ground";
}

float Course::crates_moved() const { return world.pose(crates[0]).position.x - 20.0f; }

void advance(Course& course, Workers& workers) {
  World& world = course.world;
  const float seconds = static_cast<float>(++course.steps_done) * kStep;
  world.set_kinematic_target(course.ferry, ferry_at(seconds), kStep);
  world.set_kinematic_target(course.elevator, elevator_at(seconds), kStep);
  step(world, kStep, workers);
  Vec3 wanted = will_of(course);
  if (course.walker.ground != MoverGround::firm) {
    wanted = course.walker.velocity + kStep * world.settings().gravity;
  }
  move(world, course.walker, course.settings, wanted, kStep);
  measure(course);
}

}  // namespace scree::course
