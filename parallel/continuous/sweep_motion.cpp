// See sweep_motion.h.
#include <core/geometry/balls.h>
#include <core/geometry/hull/hull_build.h>
#include <core/world/edit.h>
#include <parallel/continuous/sweep_motion.h>
#include <parallel/continuous/sweep_path.h>

#include <algorithm>
#include <cmath>

namespace scree::sweeps {

namespace {

Quat shorter(Quat q) { return q.w < 0.0f ? Quat{-q.x, -q.y, -q.z, -q.w} : q; }

}  // namespace

Motion motion_of(const DeltaRow& delta, Vec3 axis) {
  const Quat turn = to_quat(delta.rotation);
  const Vec3 about = dot({turn.x, turn.y, turn.z}, axis) * axis;
  const float size = dot(about, about) + turn.w * turn.w;
  // Below it the turn is half a turn about an axis normal to this one, where no twist is defined.
  constexpr float kLeastSize = 1e-12f;
  const Quat twist = size > kLeastSize ? normalize({about.x, about.y, about.z, turn.w}) : Quat{};
  return {to_vec3(delta.position), shorter(turn * Quat{-twist.x, -twist.y, -twist.z, twist.w}),
          shorter(twist)};
}

Quat part_of(Quat turn, float t) {
  return normalize({t * turn.x, t * turn.y, t * turn.z, 1.0f - t + t * turn.w});
}

DeltaRow part_of(const Motion& motion, float t) {
  DeltaRow part{};
  store(part.position, t * motion.way);
  store(part.rotation, part_of(motion.swing, t) * part_of(motion.twist, t));
  return part;
}

Vec3 arm_of(const WorldData& data, std::int32_t body, std::int32_t shape, Vec3 in_shape) {
  const PoseRow& local = data.shapes.local_pose[shape];
  const Vec3 in_body = to_vec3(local.position) + rotate(to_quat(local.rotation), in_shape);
  return rotate(to_quat(data.bodies.pose[body].rotation), in_body);
}

const Balls& balls_at(const WorldData& data, std::int32_t shape, Balls& made) {
  if (data.shapes.type[shape] == ShapeType::hull)
    return data.hulls.shared[static_cast<std::size_t>(data.shapes.hull[shape])].solid->balls;
  return made = balls_of(data, shape);
}

Vec3 long_axis_of(const WorldData& data, std::int32_t body) {
  constexpr int kIterations = 4;  // for a stick, each leaves less than a tenth of the error
  const float* m = data.bodies.local_mass[body].inverse_inertia;  // xx, xy, xz, yy, yz, zz
  const float largest = std::max({m[0], m[3], m[5]});
  if (!(largest > 0.0f)) return {};
  const float scale = 1.0f / largest;
  const Vec3 x{m[0] * scale, m[1] * scale, m[2] * scale}, y{m[1] * scale, m[3] * scale, m[4] * scale},
      z{m[2] * scale, m[4] * scale, m[5] * scale};
  Vec3 axis = largest == m[0] ? x : largest == m[3] ? y : z;
  for (int i = 0; i < kIterations; ++i) {
    axis = {dot(x, axis), dot(y, axis), dot(z, axis)};
    axis = (1.0f / length(axis)) * axis;
  }
  return rotate(to_quat(data.bodies.pose[body].rotation), axis);
}

// Passing over balls that are plainly not the farthest, by their arms in the body's frame, saved nothing.
Arms arms_of(const WorldData& data, std::int32_t body) {
  Arms arms{long_axis_of(data, body)};
  float reach = 0.0f, beside = 0.0f;  // squares
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    Balls made;
    const Balls& balls = balls_at(data, shape, made);
    for (int i = 0; i < balls.count; ++i) {
      const Vec3 arm = arm_of(data, body, shape, balls.ball[i].center);
      const Vec3 aside = arm - dot(arm, arms.axis) * arms.axis;
      reach = std::max(reach, dot(arm, arm));
      beside = std::max(beside, dot(aside, aside));
    }
  }
  arms.reach = std::sqrt(reach);
  arms.beside = std::sqrt(beside);
  return arms;
}

Mover mover_of(const WorldData& data, std::int32_t body, float stop) {
  const bool turns = data.bodies.type[body] == BodyType::dynamic;
  return {to_vec3(data.bodies.pose[body].position),
          motion_of(data.bodies.delta[body], turns ? long_axis_of(data, body) : Vec3{}), stop};
}

float chord_of(const Motion& motion) {
  const auto sine = [](Quat q) { return length(Vec3{q.x, q.y, q.z}); };
  return 2.0f * (sine(motion.swing) + sine(motion.twist));
}

float rate_of(const Motion& motion) {
  // Of part_of(), at the middle of the turn's chord, which is nearest to the center.
  const auto rate = [](Quat q) { return 4.0f * length(Vec3{q.x, q.y, q.z}) / (1.0f + q.w); };
  return rate(motion.swing) + rate(motion.twist);
}

Course course_of(const WorldData& data, std::int32_t body) {
  const Mover mover = mover_of(data, body, kNever);
  return {mover,
          part_of(mover.motion, 0.0f),
          part_of(mover.motion, 1.0f),
          chord_of(mover.motion),
          rate_of(mover.motion),
          bow_of(mover.motion)};
}

float farthest_way(const CoreRow& core, const DeltaRow& delta) {
  const float way = length(to_vec3(delta.position));
  if (!(core.reach > 0.0f)) return way;
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  return way + 2.0f * length(turn) * core.reach;
}

bool is_fast(const CoreRow& core, const DeltaRow& delta) {
  const Vec3 way = to_vec3(delta.position);
  if (dot(way, way) > core.radius * core.radius) return true;
  return core.reach > 0.0f && farthest_way(core, delta) > core.radius;
}

bool has_finite_motion(const DeltaRow& delta) {
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  return is_finite(to_vec3(delta.position)) && is_finite(turn) && std::isfinite(delta.rotation[3]);
}

bool may_rebound(const WorldData& data, std::int32_t body, std::int32_t obstacle) {
  if (data.shapes.material[obstacle].restitution > 0.0f) return true;
  // Its triangles may have materials of their own.
  const bool is_mesh = data.shapes.type[obstacle] == ShapeType::mesh;
  if (is_mesh && data.meshes.data[data.shapes.mesh[obstacle]]->material != nullptr) return true;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    if (data.shapes.material[shape].restitution > 0.0f) return true;
  }
  return false;
}

void pay_for_height(WorldData& data, std::int32_t body, Vec3 back) {
  const MotionRow& motion = data.bodies.motion[body];
  if (is_jointed(data, body) || (data.bodies.step_notes[body] & kHasContacts) == 0) return;
  const Vec3 gravity = free_linear(motion, motion.gravity_factor * data.settings.gravity);
  const float size = length(gravity);
  if (!(size > 0.0f)) return;
  float(&linear)[3] = data.bodies.velocity[body].linear;
  const Vec3 down = (1.0f / size) * gravity;
  const float speed = dot(to_vec3(linear), down), height = dot(gravity, back);  // m^2/s^2
  if (!(height > 0.0f) || speed == 0.0f || !std::isfinite(speed)) return;
  const float left = std::sqrt(std::max(1.0f - 2.0f * (height / speed) / speed, 0.0f));  // of the speed
  store(linear, to_vec3(linear) - (1.0f - left) * speed * down);
}

float turn_of(const Motion& motion, const Arms& arms) {
  if (!(arms.reach > 0.0f)) return 0.0f;
  const auto sine = [](Quat q) { return length(Vec3{q.x, q.y, q.z}); };
  return 2.0f * (sine(motion.swing) + sine(motion.twist) * (arms.beside / arms.reach));
}

}  // namespace scree::sweeps
