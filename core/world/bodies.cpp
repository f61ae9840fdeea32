// Calls that change and read one body.
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <scree/world.h>

#include <cmath>
#include <complex>
#include <string>

namespace scree {

namespace {

struct BodyRow {
  WorldData& data;
  Bodies& bodies;
  std::int32_t body;
  FpEnvironment environment{};  // not the caller's rounding

  bool is_dynamic() const { return bodies.type[body] == BodyType::dynamic; }
  bool is_absent() const { return scree::is_absent(bodies, body); }
  BodyType given_type() const { return scree::given_type(bodies, body); }
};

BodyRow at(Call call, const std::unique_ptr<WorldData>& owner, BodyId id) {
  WorldData& data = opened(call, owner);
  const std::int32_t body = checked_row(call, data, id);
  return {data, data.bodies, body};
}

Vec3 multiply(const float (&s)[6], Vec3 v) {
  return {s[0] * v.x + s[1] * v.y + s[2] * v.z, s[1] * v.x + s[3] * v.y + s[4] * v.z,
          s[2] * v.x + s[4] * v.y + s[5] * v.z};
}

// Change of the angular velocity by a torque impulse in world axes, within the free axes.
Vec3 angular_response(const BodyRow& at_row, Vec3 torque) {
  const Quat rotation = to_quat(at_row.bodies.pose[at_row.body].rotation);
  const MotionRow& motion = at_row.bodies.motion[at_row.body];
  const Vec3 local = rotate_back(rotation, free_angular(motion, torque));
  return free_angular(
      motion, rotate(rotation, multiply(at_row.bodies.local_mass[at_row.body].inverse_inertia, local)));
}

Vec3 arm_to(const BodyRow& at_row, Vec3 world_point) {
  return world_point - to_vec3(at_row.bodies.pose[at_row.body].position);
}

// Adds to the force and torque of the next step.
void add_load(Call call, const BodyRow& at_row, Vec3 force, Vec3 torque) {
  if (!at_row.is_dynamic() || at_row.is_absent()) return;
  ForceRow& load = at_row.bodies.force[at_row.body];
  const Vec3 force_sum = to_vec3(load.force) + force, torque_sum = to_vec3(load.torque) + torque;
  const float inverse_mass = at_row.bodies.local_mass[at_row.body].inverse_mass;
  check_vector(call, "the acceleration by all forces", force_sum * inverse_mass, kMaxAcceleration);
  check_vector(call, "the angular acceleration by all torques", angular_response(at_row, torque_sum),
               kMaxAcceleration);
  store(load.force, force_sum);
  store(load.torque, torque_sum);
  wake_body(at_row.data, at_row.body);
}

// The bounds of shapes cover the way of the next step, and the narrow phase makes points ahead of what is
// fast. Both were made for the velocity that the last step ended with; where this one leads elsewhere, they
// are made anew.
void look_ahead(const BodyRow& at_row, const VelocityRow& before) {
  const VelocityRow& now = at_row.bodies.velocity[at_row.body];
  const float dt = at_row.data.last_dt;
  // However little each call changes: many of them add up.
  const auto differ = [dt](const float(&from)[3], const float(&to)[3], float most) {
    return to_vec3(from) != to_vec3(to) && length(to_vec3(to)) * dt > most;
  };
  if (differ(before.linear, now.linear, kFastTravel) || differ(before.angular, now.angular, kFastTurn))
    mark_shapes_dirty(at_row.data, at_row.body);
}

// Changes the velocities at once.
void kick(Call call, const BodyRow& at_row, Vec3 impulse, Vec3 angular_impulse) {
  if (!at_row.is_dynamic() || at_row.is_absent()) return;
  VelocityRow& velocity = at_row.bodies.velocity[at_row.body];
  const float inverse_mass = at_row.bodies.local_mass[at_row.body].inverse_mass;
  const Vec3 linear =
      to_vec3(velocity.linear) + free_linear(at_row.bodies.motion[at_row.body], impulse * inverse_mass);
  const Vec3 angular = to_vec3(velocity.angular) + angular_response(at_row, angular_impulse);
  check_vector(call, "the linear velocity after the impulse", linear, kMaxSpeed);
  check_vector(call, "the angular velocity after the impulse", angular, kMaxSpeed);
  const VelocityRow before = velocity;
  store(velocity.linear, linear);
  store(velocity.angular, angular);
  look_ahead(at_row, before);
  wake_body(at_row.data, at_row.body);
}

// std::complex calls the compiler's runtime for it.
std::complex<double> product(std::complex<double> a, std::complex<double> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// A new velocity wakes the body. One of a kinematic body wakes what rests on it, unless it is the same as
// before: some callers set it in every step. A body that is stopped has moved since its contacts were found,
// and counts as put there, so that it wakes what it came near.
void change_velocity(const BodyRow& at_row, Vec3 linear, Vec3 angular) {
  if (at_row.is_absent()) return;
  VelocityRow& velocity = at_row.bodies.velocity[at_row.body];
  const bool stays = to_vec3(velocity.linear) == linear && to_vec3(velocity.angular) == angular;
  if (stays && !at_row.is_dynamic()) return;
  const bool moved = !is_still(velocity);
  const VelocityRow before = velocity;
  velocity.lag = 0.0f;
  store(velocity.linear, linear);
  store(velocity.angular, angular);
  look_ahead(at_row, before);
  if (at_row.is_dynamic()) {
    wake_body(at_row.data, at_row.body);
    return;
  }
  disturb(at_row.data, at_row.body);
  if (moved && is_still(velocity)) mark_shapes_dirty(at_row.data, at_row.body);
}

// The angular velocity whose substeps add up to a turn. A substep turns by the unit quaternion of
// (1, h w / 2), so that of the whole turn is its power: the root of the complex number cos + i sin of the
// half angle gives tan = h |w| / 2. Newton's method, because no root needs a function of the platform's
// library.
Vec3 spin_for(Quat turn, int substeps, float dt) {
  if (turn.w < 0.0f) turn = {-turn.x, -turn.y, -turn.z, -turn.w};
  const double x = turn.x, y = turn.y, z = turn.z;
  const double sine = std::sqrt(x * x + y * y + z * z),
               size = std::sqrt(sine * sine + double{turn.w} * turn.w);
  if (!(sine > 0.0)) return {};
  const std::complex<double> whole(turn.w / size, sine / size);
  const double n = substeps;
  std::complex<double> root = 1.0 + (whole - 1.0) / n;
  constexpr int kIterations = 8;  // the angle is at most a right one: five are enough
  for (int i = 0; i < kIterations; ++i) {
    std::complex<double> power = 1.0;
    for (int k = 1; k < substeps; ++k) power = product(power, root);
    root =
        ((n - 1.0) * root + product(whole, std::conj(power)) / product(power, std::conj(power)).real()) / n;
  }
  const double scale = 2.0 * n / dt * (root.imag() / root.real()) / sine;
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale)};
}

constexpr float kMaxLoad = 1e30f;  // N, N m, N s, N m s; what it does to the body is checked as well

}  // namespace

bool World::is_alive(BodyId body) const noexcept {
  if (data_ == nullptr) return false;
  const Bodies& bodies = data_->bodies;
  return is_own(*data_, body) && body.index < bodies.flags.size() &&
         bodies.generation[body.index] == body.generation && (bodies.flags[body.index] & kBodyAlive) != 0;
}

std::size_t World::body_count() const noexcept { return data_ != nullptr ? data_->bodies.alive : 0; }

BodyId World::body_at(std::uint32_t index) const noexcept {
  if (data_ == nullptr || index >= data_->bodies.flags.size()) return {};
  if ((data_->bodies.flags[index] & kBodyAlive) == 0) return {};
  return body_handle(*data_, static_cast<std::int32_t>(index));
}

BodyType World::body_type(BodyId body) const { return at({"body_type"}, data_, body).given_type(); }

void World::set_body_type(BodyId body, BodyType type) {
  constexpr Call call{"set_body_type"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_body_type> call_record(b.data, body, type);
  check_body_type(call, type);
  if (b.given_type() == type) return end_quarantine(b.data, b.body);
  if (type == BodyType::dynamic) check_may_be_dynamic(call, b.data, b.body);
  const BodyMass mass = mass_after(call, b.data, b.body, type, b.bodies.flags[b.body]);
  disturb(b.data, b.body);
  b.bodies.flags[b.body] = static_cast<std::uint8_t>(b.bodies.flags[b.body] & ~kBodyQuarantined);
  b.bodies.type[b.body] = type;
  apply_mass(b.data, b.body, mass);
  apply_locks(b.bodies, b.body);
  take_part_as(b.data, b.body, type);
}

bool World::is_quarantined(BodyId body) const {
  const BodyRow b = at({"is_quarantined"}, data_, body);
  return scree::is_quarantined(b.bodies, b.body);
}

Pose World::pose(BodyId body) const {
  const BodyRow b = at({"pose"}, data_, body);
  return b.bodies.transform[b.body];
}

void World::set_pose(BodyId body, const Pose& given) {
  constexpr Call call{"set_pose"};
  const BodyRow b = at(call, data_, body);
  const Pose pose = given;  // which may be an entry of poses()
  const CallRecord<RecordedCall::set_pose> call_record(b.data, body, pose);
  check_pose(call, "position", "rotation", pose, kMaxPosition);
  end_quarantine(b.data, b.body);
  disturb(b.data, b.body);
  place_body(b.data, b.body, {pose.position, normalize(pose.rotation)});
}

Vec3 World::linear_velocity(BodyId body) const {
  const BodyRow b = at({"linear_velocity"}, data_, body);
  return to_vec3(b.bodies.velocity[b.body].linear);
}

Vec3 World::angular_velocity(BodyId body) const {
  const BodyRow b = at({"angular_velocity"}, data_, body);
  return to_vec3(b.bodies.velocity[b.body].angular);
}

Vec3 World::velocity_at(BodyId body, Vec3 world_point) const {
  constexpr Call call{"velocity_at"};
  const BodyRow b = at(call, data_, body);
  check_vector(call, "world_point", world_point, kMaxPosition);
  const VelocityRow& velocity = b.bodies.velocity[b.body];
  return to_vec3(velocity.linear) + cross(to_vec3(velocity.angular), arm_to(b, world_point));
}

void World::set_linear_velocity(BodyId body, Vec3 velocity) {
  constexpr Call call{"set_linear_velocity"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_linear_velocity> call_record(b.data, body, velocity);
  check_vector(call, "velocity", velocity, kMaxSpeed);
  if (b.given_type() == BodyType::fixed) return;
  end_quarantine(b.data, b.body);
  change_velocity(b, free_linear(b.bodies.motion[b.body], velocity),
                  to_vec3(b.bodies.velocity[b.body].angular));
}

void World::set_angular_velocity(BodyId body, Vec3 velocity) {
  constexpr Call call{"set_angular_velocity"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_angular_velocity> call_record(b.data, body, velocity);
  check_vector(call, "velocity", velocity, kMaxSpeed);
  if (b.given_type() == BodyType::fixed) return;
  end_quarantine(b.data, b.body);
  change_velocity(b, to_vec3(b.bodies.velocity[b.body].linear),
                  free_angular(b.bodies.motion[b.body], velocity));
}

void World::set_kinematic_target(BodyId body, const Pose& target, float dt) {
  constexpr Call call{"set_kinematic_target"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_kinematic_target> call_record(b.data, body, target, dt);
  if (b.given_type() != BodyType::kinematic) {
    fail(call, "the body is not kinematic", ErrorCode::wrong_state);
  }
  check_pose(call, "target.position", "target.rotation", target, kMaxPosition);
  if (!(dt > 0.0f && dt <= 1.0f)) {
    fail(call, "the time step is " + std::to_string(dt) + " s; it must be in (0, 1]");
  }
  if (b.is_absent()) return end_quarantine(b.data, b.body);
  const PoseRow& pose = b.bodies.pose[b.body];
  const Quat rotation = normalize(target.rotation);
  const Vec3 center = target.position + rotate(rotation, b.bodies.center[b.body]);
  const Vec3 linear = (center - to_vec3(pose.position)) * (1.0f / dt);
  const Vec3 angular = spin_for(rotation * conjugate(to_quat(pose.rotation)), b.data.settings.substeps, dt);
  check_vector(call, "the linear velocity", linear, kMaxSpeed);
  check_vector(call, "the angular velocity", angular, kMaxSpeed);
  end_quarantine(b.data, b.body);
  change_velocity(b, linear, angular);
}

Vec3 World::center_of_mass(BodyId body) const {
  const BodyRow b = at({"center_of_mass"}, data_, body);
  return to_vec3(b.bodies.pose[b.body].position);
}

MassProperties World::mass_properties(BodyId body) const {
  const BodyRow b = at({"mass_properties"}, data_, body);
  if (b.given_type() == BodyType::dynamic || (b.bodies.flags[b.body] & kBodyPropertiesGiven) != 0) {
    return properties_of(b.bodies, b.body);
  }
  std::optional<float> given_mass;
  if ((b.bodies.flags[b.body] & kBodyMassGiven) != 0) given_mass = b.bodies.given_mass[b.body];
  return properties_of(sum_shapes(b.data, b.body), given_mass);
}

void World::set_mass_properties(BodyId body, const MassProperties& properties) {
  constexpr Call call{"set_mass_properties"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_mass_properties> call_record(b.data, body, properties);
  const BodyMass mass = given_mass_rows(call, properties, b.given_type());
  b.bodies.flags[b.body] |= kBodyPropertiesGiven;
  apply_mass(b.data, b.body, mass);
  wake_body(b.data, b.body);
}

void World::reset_mass(BodyId body) {
  constexpr Call call{"reset_mass"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::reset_mass> call_record(b.data, body);
  const auto flags =
      static_cast<std::uint8_t>(b.bodies.flags[b.body] & ~(kBodyMassGiven | kBodyPropertiesGiven));
  const BodyMass mass = mass_after(call, b.data, b.body, b.given_type(), flags);
  b.bodies.flags[b.body] = flags;
  b.bodies.given_mass[b.body] = 0.0f;
  apply_mass(b.data, b.body, mass);
  wake_body(b.data, b.body);
}

float World::linear_damping(BodyId body) const {
  const BodyRow b = at({"linear_damping"}, data_, body);
  return b.bodies.motion[b.body].linear_damping;
}

float World::angular_damping(BodyId body) const {
  const BodyRow b = at({"angular_damping"}, data_, body);
  return b.bodies.motion[b.body].angular_damping;
}

float World::gravity_factor(BodyId body) const {
  const BodyRow b = at({"gravity_factor"}, data_, body);
  return b.bodies.motion[b.body].gravity_factor;
}

AxisLocks World::locks(BodyId body) const {
  const BodyRow b = at({"locks"}, data_, body);
  return b.bodies.locks[b.body];
}

void World::set_linear_damping(BodyId body, float damping) {
  constexpr Call call{"set_linear_damping"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_linear_damping> call_record(b.data, body, damping);
  check_range(call, "damping", damping, 0.0f, kMaxRate);
  b.bodies.motion[b.body].linear_damping = damping;
  wake_body(b.data, b.body);
}

void World::set_angular_damping(BodyId body, float damping) {
  constexpr Call call{"set_angular_damping"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_angular_damping> call_record(b.data, body, damping);
  check_range(call, "damping", damping, 0.0f, kMaxRate);
  b.bodies.motion[b.body].angular_damping = damping;
  wake_body(b.data, b.body);
}

void World::set_gravity_factor(BodyId body, float factor) {
  constexpr Call call{"set_gravity_factor"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_gravity_factor> call_record(b.data, body, factor);
  check_range(call, "factor", factor, -kMaxGravityFactor, kMaxGravityFactor);
  b.bodies.motion[b.body].gravity_factor = factor;
  wake_body(b.data, b.body);
}

void World::set_locks(BodyId body, AxisLocks locks) {
  constexpr Call call{"set_locks"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::set_locks> call_record(b.data, body, locks);
  check_locks(call, locks);
  b.bodies.locks[b.body] = locks;
  apply_locks(b.bodies, b.body);
  wake_body(b.data, b.body);
}

bool World::can_sleep(BodyId body) const {
  const BodyRow b = at({"can_sleep"}, data_, body);
  return (b.bodies.flags[b.body] & kBodyCanSleep) != 0;
}

void World::set_can_sleep(BodyId body, bool can_sleep) {
  const BodyRow b = at({"set_can_sleep"}, data_, body);
  const CallRecord<RecordedCall::set_can_sleep> call_record(b.data, body, can_sleep);
  if (can_sleep) {
    b.bodies.flags[b.body] |= kBodyCanSleep;
  } else {
    b.bodies.flags[b.body] = static_cast<std::uint8_t>(b.bodies.flags[b.body] & ~kBodyCanSleep);
    wake_body(b.data, b.body);
  }
}

bool World::full_sweep(BodyId body) const {
  const BodyRow b = at({"full_sweep"}, data_, body);
  return (b.bodies.motion[b.body].flags & std::uint32_t{kMotionSweptWhole}) != 0;
}

void World::set_full_sweep(BodyId body, bool full) {
  const BodyRow b = at({"set_full_sweep"}, data_, body);
  const CallRecord<RecordedCall::set_full_sweep> call_record(b.data, body, full);
  std::uint32_t& flags = b.bodies.motion[b.body].flags;
  flags = (flags & ~std::uint32_t{kMotionSweptWhole}) | (full ? std::uint32_t{kMotionSweptWhole} : 0u);
}

bool World::is_awake(BodyId body) const {
  const BodyRow b = at({"is_awake"}, data_, body);
  if (b.bodies.type[b.body] == BodyType::fixed) return false;
  return (b.bodies.flags[b.body] & kBodyAsleep) == 0 || is_about_to_wake(b.data, b.body);
}

void World::wake(BodyId body) {
  const BodyRow b = at({"wake"}, data_, body);
  const CallRecord<RecordedCall::wake> call_record(b.data, body);
  end_quarantine(b.data, b.body);
  wake_body(b.data, b.body);
}

std::uint64_t World::user_data(BodyId body) const {
  const BodyRow b = at({"user_data"}, data_, body);
  return b.bodies.user_data[b.body];
}

void World::set_user_data(BodyId body, std::uint64_t user_data) {
  const BodyRow b = at({"set_user_data"}, data_, body);
  const CallRecord<RecordedCall::set_body_user_data> call_record(b.data, body, user_data);
  b.bodies.user_data[b.body] = user_data;
}

void World::add_force(BodyId body, Vec3 force) {
  constexpr Call call{"add_force"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_force> call_record(b.data, body, force);
  check_vector(call, "force", force, kMaxLoad);
  add_load(call, b, force, {});
}

void World::add_force_at(BodyId body, Vec3 force, Vec3 world_point) {
  constexpr Call call{"add_force_at"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_force_at> call_record(b.data, body, force, world_point);
  check_vector(call, "force", force, kMaxLoad);
  check_vector(call, "world_point", world_point, kMaxPosition);
  add_load(call, b, force, cross(arm_to(b, world_point), force));
}

void World::add_torque(BodyId body, Vec3 torque) {
  constexpr Call call{"add_torque"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_torque> call_record(b.data, body, torque);
  check_vector(call, "torque", torque, kMaxLoad);
  add_load(call, b, {}, torque);
}

void World::add_impulse(BodyId body, Vec3 impulse) {
  constexpr Call call{"add_impulse"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_impulse> call_record(b.data, body, impulse);
  check_vector(call, "impulse", impulse, kMaxLoad);
  kick(call, b, impulse, {});
}

void World::add_impulse_at(BodyId body, Vec3 impulse, Vec3 world_point) {
  constexpr Call call{"add_impulse_at"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_impulse_at> call_record(b.data, body, impulse, world_point);
  check_vector(call, "impulse", impulse, kMaxLoad);
  check_vector(call, "world_point", world_point, kMaxPosition);
  kick(call, b, impulse, cross(arm_to(b, world_point), impulse));
}

void World::add_angular_impulse(BodyId body, Vec3 impulse) {
  constexpr Call call{"add_angular_impulse"};
  const BodyRow b = at(call, data_, body);
  const CallRecord<RecordedCall::add_angular_impulse> call_record(b.data, body, impulse);
  check_vector(call, "impulse", impulse, kMaxLoad);
  kick(call, b, {}, impulse);
}

}  // namespace scree
