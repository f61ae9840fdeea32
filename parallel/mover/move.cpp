// The move, as a story: what carries the mover, what pushes it, its own way, its ground, what it pushes.
#include <core/world/check.h>
#include <core/world/fp_environment.h>
#include <parallel/mover/ground.h>
#include <parallel/mover/push.h>

#include <cmath>

namespace scree {

namespace {

using mover::Course;
using mover::Gait;
using mover::Ground;
using mover::Task;
using mover::Touches;
using mover::Vector;

constexpr Call kCall{"move", -1, ""};

constexpr float kMostSize = 1e3f;     // m
constexpr float kMostForce = 1e9f;    // N
constexpr float kMostMass = 1e6f;     // kg
constexpr float kMostSpeed = 1e6f;    // m/s
constexpr float kLeastCosine = 0.1f;  // of slopes: ways along steeper ones would be very long
constexpr float kLeastSkin = 1e-3f;   // of the radius

void check_mover(const World& world, const MoverSettings& settings) {
  const WorldData& data = internals(world, kCall.name);
  check_range(kCall, "radius", settings.radius, 1e-3f, kMostSize);
  check_range(kCall, "half_height", settings.half_height, kMinExtent, kMostSize);
  check_vector(kCall, "up", settings.up, 2.0f);
  const float size = length(settings.up);
  check_range(kCall, "length of up", size, 1.0f - kUnitTolerance, 1.0f + kUnitTolerance);
  check_range(kCall, "skin", settings.skin, kLeastSkin * settings.radius, settings.radius);
  check_range(kCall, "slope_cosine", settings.slope_cosine, kLeastCosine, 1.0f);
  check_range(kCall, "step_height", settings.step_height, 0.0f, kMostSize);
  check_range(kCall, "snap_distance", settings.snap_distance, 0.0f, kMostSize);
  check_range(kCall, "push_force", settings.push_force, 0.0f, kMostForce);
  check_range(kCall, "mass", settings.mass, 0.0f, kMostMass);
  if (settings.types > BodyTypes::all) fail_range(kCall, "types", static_cast<double>(settings.types), 0, 7);
  if (settings.ignored != BodyId{}) checked_row(kCall, data, settings.ignored);
}

void check_state(const MoverState& state) {
  check_vector(kCall, "position", state.position, kMaxPosition);
  if (state.ground > MoverGround::firm) {
    fail_range(kCall, "ground", static_cast<double>(state.ground), 0, 2);
  }
  check_vector(kCall, "ground_normal", state.ground_normal, 2.0f);
  check_vector(kCall, "place_on_ground", state.place_on_ground, 4.0f * kMaxPosition);
}

// Whether the wanted velocity leaves the ground instead of going along it.
bool jumps(const Task& task, const MoverState& state, Vector velocity) {
  constexpr double kLeaves = 1e-3;  // of the velocity
  return dot(task.up, velocity) > 0.0 &&
         dot(queries::to_vector(state.ground_normal), velocity) > kLeaves * length(velocity);
}

// What the mover stood on and still can: it moves with that body.
bool has_carrier(const World& world, const MoverState& state) {
  return state.ground != MoverGround::none && world.is_alive(state.ground_body) &&
         world.body_type(state.ground_body) != BodyType::fixed;
}

// Follows the body that the mover stands on, as far as nothing else is in the way. Returns where that body
// would bring it.
Vector follow_ground(Task& task, const MoverState& state, Vector& position) {
  const Pose pose = task.world.pose(state.ground_body);
  const Vector place = queries::to_axes(pose.rotation) * queries::to_vector(state.place_on_ground);
  const Vector target = mover::placed(queries::to_vector(pose.position) + place);
  if (!(length(target - position) > mover::tolerance(task))) return target;
  task.carrier = state.ground_body;
  Course carried{.position = position, .velocity = {}};
  mover::slide(task, target - position, Gait::fly, carried);
  task.carrier = {};
  position = carried.position;
  return target;
}

// Leaves what has come too near since the last move.
Vector give_way(const Task& task, Vector position, Gait gait) {
  const Touches& touches = mover::touched_at(task, position);
  if (touches.inside) position = mover::escape(task, position, touches);
  Course pushed{.position = position, .velocity = {}};
  mover::slide(task, {}, gait, pushed);
  return pushed.position;
}

// The mover's own way, over a step if one is in the way. Returns the ground if it has been found already.
Ground go(const Task& task, Gait gait, Course& course) {
  if (gait == Gait::fly) {
    mover::slide(task, task.dt * course.velocity, gait, course);
    return {};
  }
  constexpr double kBlocked = 1e-3;  // of the way that is lost
  const Vector start = course.position, velocity = course.velocity, way = task.dt * velocity;
  const double size = length(way);
  mover::slide(task, way, gait, course);
  Ground ground;
  if (size > mover::tolerance(task) && task.settings.step_height > 0.0f &&
      dot(way, course.position - start) < (1.0 - kBlocked) * size * size) {
    mover::step_up(task, start, velocity, way, course, ground);
  }
  return ground;
}

bool is_squeezed(const Task& task, Vector position) {
  constexpr double kDeep = 0.1;  // of the skin
  const Touches& touches = mover::touched_at(task, position);
  return touches.inside || (touches.count > 0 && touches.touch[0].distance < -kDeep * task.skin);
}

// What the mover stands on now. Velocities change their meaning where it leaves ground or comes onto it.
// `followed`: where the ground of before has brought it.
void stand(const Task& task, const Ground& ground, Vector carried, Vector followed, const Course& course,
           MoverState& state) {
  const World& world = task.world;
  const bool rests = ground.touch.body == state.ground_body &&
                     queries::to_vec3(course.position) == queries::to_vec3(followed);
  state.position = queries::to_vec3(course.position);
  state.ground = ground.kind;
  state.ground_body = ground.touch.body;
  state.ground_shape = ground.touch.shape;
  state.ground_normal = queries::to_vec3(ground.touch.normal);
  state.ground_point = queries::to_vec3(ground.touch.point);
  state.ground_velocity = {};
  if (ground.kind == MoverGround::none) {
    state.place_on_ground = {};
  } else {
    state.ground_velocity = world.velocity_at(state.ground_body, state.position);
    const Pose pose = world.pose(state.ground_body);
    // Rounding must not move a mover that only stands.
    if (!rests) {
      state.place_on_ground = queries::to_vec3(
          turn_back(queries::to_axes(pose.rotation), course.position - queries::to_vector(pose.position)));
    }
  }
  const Vector in_world = course.velocity + carried;
  state.velocity =
      queries::to_vec3(ground.kind == MoverGround::firm
                           ? level_part(task, in_world - queries::to_vector(state.ground_velocity))
                           : in_world);
}

// Finds what the mover stands on after its way, and follows ground that falls away.
Ground land(const Task& task, bool walks, Vector wanted, BodyId before, Course& course) {
  const Ground ground = mover::find_ground(task, course.position, walks, before);
  if (walks) {
    constexpr double kHovers = 1.01;  // of the skin
    if (ground.kind == MoverGround::firm && ground.touch.distance < kHovers * task.skin) return ground;
    const Ground lower = mover::follow_down(task, course.position, before);
    return lower.kind == MoverGround::firm ? lower : ground;
  }
  // Who jumps has left the ground, however near it still is.
  const bool rises = dot(task.up, wanted) > 0.0;
  if (rises && dot(course.velocity, ground.touch.normal) > 0.0) return {};
  if (rises || ground.kind == MoverGround::firm) return ground;
  const Ground below = mover::land_on(task, course.position);
  return below.kind == MoverGround::firm ? below : ground;
}

}  // namespace

void move(World& world, MoverState& state, const MoverSettings& settings, Vec3 velocity, float dt) {
  check_mover(world, settings);
  check_state(state);
  check_vector(kCall, "velocity", velocity, kMostSpeed);
  if (!(dt > 0.0f && dt <= 1.0f)) fail_range(kCall, "dt (above 0)", dt, 0.0, 1.0);
  const FpEnvironment environment;

  Task task = mover::task_of(world, settings, dt);
  MoverState next = state;
  const Vector wanted = queries::to_vector(velocity);
  const bool stood = state.ground == MoverGround::firm;
  const bool walks = stood && !jumps(task, state, wanted);
  const Gait gait = walks ? Gait::walk : Gait::fly;

  if (stood) task.stands_on = state.ground_body;
  Course course{.position = queries::to_vector(state.position),
                .velocity = walks ? level_part(task, wanted) : wanted};
  Vector carried{}, followed = course.position;  // m/s, of what the velocity is relative to; m
  if (stood && has_carrier(world, state)) {
    followed = follow_ground(task, state, course.position);
    carried = queries::to_vector(world.velocity_at(state.ground_body, queries::to_vec3(course.position)));
  }
  course.position = give_way(task, course.position, gait);
  Ground ground = go(task, gait, course);
  if (ground.kind == MoverGround::none) ground = land(task, walks, wanted, state.ground_body, course);

  next.touches_wall = course.touches_wall;
  next.touches_ceiling = course.touches_ceiling;
  next.squeezed = is_squeezed(task, course.position);
  stand(task, ground, carried, followed, course, next);
  push_bodies(world, task, course, carried);
  if (ground.kind == MoverGround::firm) press_on_ground(world, task, ground.touch);
  state = next;
}

}  // namespace scree
