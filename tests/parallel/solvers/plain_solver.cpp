#include "plain_solver.h"

#include <core/world/math.h>
#include <core/world/wake.h>
#include <parallel/constraints/constraints.h>
#include <parallel/stages.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace scree::testing {

namespace {

struct Motion {
  Vec3 linear, angular;
};

struct Soft {
  float bias_rate, mass_scale, impulse_scale;
};

Soft soften(float hertz, float damping_ratio, float h) {
  const float omega = 2.0f * std::numbers::pi_v<float> * hertz;
  const float a1 = 2.0f * damping_ratio + h * omega;
  const float a2 = h * omega * a1;
  const float a3 = 1.0f / (1.0f + a2);
  return {omega / a1, a2 * a3, a3};
}

Vec3 to_vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

Vec3 multiply(const InertiaRow& m, Vec3 v) {
  const float* s = m.inverse_inertia;
  return {s[0] * v.x + s[1] * v.y + s[2] * v.z, s[1] * v.x + s[3] * v.y + s[4] * v.z,
          s[2] * v.x + s[4] * v.y + s[5] * v.z};
}

// One contact while it is being solved.
struct Contact {
  Manifold* manifold;
  ContactSurface* surface;
  std::size_t a, b;
  Vec3 normal, t1, t2, arm_a, arm_b;
  Vec3 anchor_a[4], anchor_b[4];
  int points;
  bool pushes_a;
};

class PlainSolver {
 public:
  PlainSolver(WorldData& data, float dt) : data_(data), settings_(data.settings), dt_(dt) {
    h_ = dt / static_cast<float>(settings_.substeps);
    const float hertz = std::min(settings_.contact_hertz, 0.125f / h_);
    soft_ = soften(hertz, settings_.contact_damping_ratio, h_);
    soft_static_ = soften(2.0f * hertz, 0.5f * settings_.contact_damping_ratio, h_);
  }

  void run() {
    prepare_bodies();
    prepare_contacts();
    for (int substep = 0; substep < settings_.substeps; ++substep) {
      rebound_all();
      for (const std::int32_t body : data_.bodies.awake) integrate_velocity(static_cast<std::size_t>(body));
      for (Contact& contact : contacts_) warm_start(contact);
      for (Contact& contact : contacts_) solve_normals(contact, true);
      for (const std::int32_t body : data_.bodies.awake) integrate_pose(static_cast<std::size_t>(body));
      for (const std::int32_t body : data_.bodies.kinematic) integrate_pose(static_cast<std::size_t>(body));
      residual_ = 0.0f;
      for (Contact& contact : contacts_) {
        solve_normals(contact, false);
        solve_friction(contact);
      }
    }
    data_.stats.residual = static_cast<double>(residual_);
  }

 private:
  Motion motion(std::size_t body) const {
    const VelocityRow& row = data_.bodies.velocity[body];
    return {to_vec(row.linear), to_vec(row.angular)};
  }
  void set_motion(std::size_t body, const Motion& motion) {
    data_.bodies.velocity[body] = {{motion.linear.x, motion.linear.y, motion.linear.z},
                                   {motion.angular.x, motion.angular.y, motion.angular.z},
                                   0,
                                   0};
  }
  Quat delta_rotation(std::size_t body) const {
    const float* q = data_.bodies.delta[body].rotation;
    return {q[0], q[1], q[2], q[3]};
  }

  void prepare_bodies() {
    Bodies& bodies = data_.bodies;
    pushed_.assign(bodies.velocity.size(), false);
    Column<std::int32_t>& moving = constraints_of(data_).moving_bodies;
    moving.clear();
    for (const std::int32_t body : bodies.awake) moving.push_back(body);
    for (const std::int32_t body : bodies.kinematic) moving.push_back(body);
    for (const std::int32_t place : moving) {
      const auto body = static_cast<std::size_t>(place);
      const float* q = bodies.pose[body].rotation;
      const Quat rotation{q[0], q[1], q[2], q[3]};
      const InertiaRow& local = bodies.local_mass[body];
      Vec3 columns[3];
      const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      for (int i = 0; i < 3; ++i)
        columns[i] = rotate(rotation, multiply(local, rotate_back(rotation, axes[i])));
      bodies.inertia[body] = {
          {columns[0].x, columns[0].y, columns[0].z, columns[1].y, columns[1].z, columns[2].z},
          local.inverse_mass,
          0};
      bodies.delta[body] = {{0, 0, 0}, {0, 0, 0, 1}, 0};
    }
  }

  // The order of the wide solver: color by color, in lane order.
  void prepare_contacts() {
    const Constraints& constraints = constraints_of(data_);
    for (const simd::ConstraintChunk& chunk : constraints.contact_chunks) {
      for (int i = 0; i < chunk.lanes; ++i) {
        add_contact(static_cast<std::size_t>(
            constraints.contact_lanes[static_cast<std::size_t>(chunk.first_lane + i)]));
      }
    }
    const float scale =
        settings_.warm_start ? warm_start_scale(substep_of(data_, dt_), data_.last_substep) : 0.0f;
    for (Contact& contact : contacts_) {
      for (float& impulse : contact.manifold->normal_impulse) impulse *= scale;
      for (float& impulse : contact.manifold->friction_impulse) impulse *= scale;
      contact.manifold->twist_impulse *= scale;
      if (is_rich(contact)) {
        for (float& impulse : contact.surface->rolling_impulse) impulse *= scale;
      }
    }
  }

  static bool is_rich(const Contact& contact) { return (contact.manifold->info & kManifoldRich) != 0; }

  void add_contact(std::size_t row) {
    Contact contact{};
    contact.manifold = &data_.contacts.now.manifold[row];
    contact.surface = &data_.contacts.now.surface[row];
    const Manifold& manifold = *contact.manifold;
    contact.a = static_cast<std::size_t>(manifold.row_a);
    contact.b = static_cast<std::size_t>(manifold.row_b);
    contact.normal = to_vec(manifold.normal);
    contact.t1 = tangent_of(contact.normal);
    contact.t2 = cross(contact.normal, contact.t1);
    contact.arm_a = to_vec(manifold.arm_a);
    contact.arm_b = to_vec(manifold.arm_b);
    contact.points = static_cast<int>(manifold.info & kManifoldPointMask);
    contact.pushes_a = (manifold.info & kManifoldStatic) == 0;
    for (int k = 0; k < contact.points; ++k) {
      const Vec3 r = manifold.point_u[k] * contact.t1 + manifold.point_v[k] * contact.t2;
      contact.anchor_a[k] = contact.arm_a + r;
      contact.anchor_b[k] = contact.arm_b + r;
    }
    contacts_.push_back(contact);
  }

  static Vec3 speed_at(const Motion& a, const Motion& b, Vec3 arm_a, Vec3 arm_b) {
    return b.linear + cross(b.angular, arm_b) - a.linear - cross(a.angular, arm_a);
  }

  Vec3 acceleration_of(std::size_t body) const {
    return data_.bodies.motion[body].gravity_factor * settings_.gravity +
           data_.bodies.inertia[body].inverse_mass * to_vec(data_.bodies.force[body].force);
  }

  void integrate_velocity(std::size_t body) {
    const MotionRow& row = data_.bodies.motion[body];
    const ForceRow& force = data_.bodies.force[body];
    const InertiaRow& inertia = data_.bodies.inertia[body];
    Motion v = motion(body);
    const Vec3 acceleration = acceleration_of(body);
    v.linear = (1.0f / (1.0f + h_ * row.linear_damping)) * (v.linear + h_ * acceleration);
    v.angular = (1.0f / (1.0f + h_ * row.angular_damping)) *
                (v.angular + h_ * multiply(inertia, to_vec(force.torque)));
    set_motion(body, v);
  }

  void integrate_pose(std::size_t body) {
    const Motion v = motion(body);
    DeltaRow& delta = data_.bodies.delta[body];
    Vec3 position = to_vec(delta.position) + h_ * v.linear;
    // On the parabola, where no impulse has acted.
    if (!pushed_[body] && data_.bodies.inertia[body].inverse_mass > 0.0f) {
      const Vec3 change = acceleration_of(body) - data_.bodies.motion[body].linear_damping * v.linear;
      position = position - 0.5f * h_ * h_ * change;
    }
    const Vec3 turn = 0.5f * h_ * v.angular;
    const Quat q = delta_rotation(body), spin = Quat{turn.x, turn.y, turn.z, 0.0f} * q;
    const Quat rotation = normalize({q.x + spin.x, q.y + spin.y, q.z + spin.z, q.w + spin.w});
    delta = {{position.x, position.y, position.z}, {rotation.x, rotation.y, rotation.z, rotation.w}, 0};
  }

  void push(const Contact& contact, Vec3 impulse, Vec3 arm_a, Vec3 arm_b) {
    if (impulse != Vec3{} && !rebounds_) pushed_[contact.a] = pushed_[contact.b] = true;
    if (contact.pushes_a) {
      Motion a = motion(contact.a);
      const InertiaRow& inertia = data_.bodies.inertia[contact.a];
      a.linear = a.linear - inertia.inverse_mass * impulse;
      a.angular = a.angular - multiply(inertia, cross(arm_a, impulse));
      set_motion(contact.a, a);
    }
    Motion b = motion(contact.b);
    const InertiaRow& inertia = data_.bodies.inertia[contact.b];
    b.linear = b.linear + inertia.inverse_mass * impulse;
    b.angular = b.angular + multiply(inertia, cross(arm_b, impulse));
    set_motion(contact.b, b);
  }

  void twist(const Contact& contact, Vec3 impulse) {
    if (contact.pushes_a) {
      Motion a = motion(contact.a);
      a.angular = a.angular - multiply(data_.bodies.inertia[contact.a], impulse);
      set_motion(contact.a, a);
    }
    Motion b = motion(contact.b);
    b.angular = b.angular + multiply(data_.bodies.inertia[contact.b], impulse);
    set_motion(contact.b, b);
  }

  // f . M^-1 g for impulses f and g at the anchors.
  float response(const Contact& contact, Vec3 f, Vec3 g, Vec3 arm_a, Vec3 arm_b) const {
    const InertiaRow& b = data_.bodies.inertia[contact.b];
    float result = b.inverse_mass * dot(f, g) + dot(cross(arm_b, f), multiply(b, cross(arm_b, g)));
    if (contact.pushes_a) {
      const InertiaRow& a = data_.bodies.inertia[contact.a];
      result += a.inverse_mass * dot(f, g) + dot(cross(arm_a, f), multiply(a, cross(arm_a, g)));
    }
    return result;
  }

  void warm_start(const Contact& contact) {
    const Manifold& m = *contact.manifold;
    if (!settings_.warm_start) {
      for (float& impulse : contact.manifold->normal_impulse) impulse = 0.0f;
      contact.manifold->friction_impulse[0] = contact.manifold->friction_impulse[1] = 0.0f;
      contact.manifold->twist_impulse = 0.0f;
      return;
    }
    for (int k = 0; k < contact.points; ++k) {
      push(contact, m.normal_impulse[k] * contact.normal, contact.anchor_a[k], contact.anchor_b[k]);
    }
    push(contact, m.friction_impulse[0] * contact.t1 + m.friction_impulse[1] * contact.t2, contact.arm_a,
         contact.arm_b);
    twist(contact, m.twist_impulse * contact.normal);
    if (is_rich(contact)) twist(contact, to_vec(contact.surface->rolling_impulse));
  }

  float separation(const Contact& contact, int k) const {
    const DeltaRow &a = data_.bodies.delta[contact.a], &b = data_.bodies.delta[contact.b];
    const Manifold& m = *contact.manifold;
    Vec3 arm_a = contact.anchor_a[k], arm_b = contact.anchor_b[k];
    if (contact.points <= 2) {
      arm_a = arm_a - m.point_u[kCoreA] * contact.normal;
      arm_b = arm_b + m.point_u[kCoreB] * contact.normal;
    }
    const Vec3 moved_a = to_vec(a.position) + rotate(delta_rotation(contact.a), arm_a);
    const Vec3 moved_b = to_vec(b.position) + rotate(delta_rotation(contact.b), arm_b);
    const Vec3 change = (moved_b - arm_b) - (moved_a - arm_a);
    return m.separation[k] + dot(change, contact.normal);
  }

  void solve_normals(Contact& contact, bool biased) {
    const Soft& soft = contact.pushes_a ? soft_ : soft_static_;
    for (int k = 0; k < contact.points; ++k) {
      const float s = separation(contact, k);
      float bias = std::max(s, 0.0f) / h_, mass_scale = 1.0f, impulse_scale = 0.0f;
      if (biased && s <= 0.0f) {
        bias = soft.mass_scale * std::max(soft.bias_rate * s, -settings_.push_speed);
        mass_scale = soft.mass_scale;
        impulse_scale = soft.impulse_scale;
      }
      const Vec3 n = contact.normal, arm_a = contact.anchor_a[k], arm_b = contact.anchor_b[k];
      const float mass = 1.0f / response(contact, n, n, arm_a, arm_b);
      const float speed = dot(speed_at(motion(contact.a), motion(contact.b), arm_a, arm_b), n);
      float& impulse = contact.manifold->normal_impulse[k];
      if ((!biased || s > 0.0f) && is_left_to_rebound(contact, speed, impulse)) continue;
      if (!biased) {
        const float error = speed + bias;
        residual_ = std::max(residual_, impulse > 0.0f ? std::abs(error) : std::max(-error, 0.0f));
      }
      const float next =
          std::max(impulse - mass * (mass_scale * speed + bias) - impulse_scale * impulse, 0.0f);
      push(contact, (next - impulse) * n, arm_a, arm_b);
      impulse = next;
    }
  }

  void solve_friction(Contact& contact) {
    Manifold& m = *contact.manifold;
    float sum = 0.0f, moment = 0.0f;
    const float patch = contact.points <= kTwistArm ? m.point_v[kTwistArm] : 0.0f;
    for (int k = 0; k < contact.points; ++k) {
      sum += m.normal_impulse[k];
      moment += std::max(std::hypot(m.point_u[k], m.point_v[k]), patch) * m.normal_impulse[k];
    }
    const InertiaRow& inertia_b = data_.bodies.inertia[contact.b];
    float twist_response = dot(contact.normal, multiply(inertia_b, contact.normal));
    if (contact.pushes_a) {
      twist_response += dot(contact.normal, multiply(data_.bodies.inertia[contact.a], contact.normal));
    }
    const float twist_speed = dot(motion(contact.b).angular - motion(contact.a).angular, contact.normal);
    const float twist_limit = m.friction * moment;
    const float next_twist =
        std::clamp(m.twist_impulse - twist_speed / twist_response, -twist_limit, twist_limit);
    twist(contact, (next_twist - m.twist_impulse) * contact.normal);
    m.twist_impulse = next_twist;

    Vec3 slip = speed_at(motion(contact.a), motion(contact.b), contact.arm_a, contact.arm_b);
    if (is_rich(contact)) slip = slip + to_vec(contact.surface->surface_velocity);
    const float k11 = response(contact, contact.t1, contact.t1, contact.arm_a, contact.arm_b);
    const float k12 = response(contact, contact.t1, contact.t2, contact.arm_a, contact.arm_b);
    const float k22 = response(contact, contact.t2, contact.t2, contact.arm_a, contact.arm_b);
    const float determinant = k11 * k22 - k12 * k12;
    const float slip1 = dot(slip, contact.t1), slip2 = dot(slip, contact.t2);
    float next1 = m.friction_impulse[0] - (k22 * slip1 - k12 * slip2) / determinant;
    float next2 = m.friction_impulse[1] - (k11 * slip2 - k12 * slip1) / determinant;
    const float size = std::hypot(next1, next2), limit = m.friction * sum;
    if (size > limit) {
      next1 *= limit / size;
      next2 *= limit / size;
    }
    push(contact, (next1 - m.friction_impulse[0]) * contact.t1 + (next2 - m.friction_impulse[1]) * contact.t2,
         contact.arm_a, contact.arm_b);
    m.friction_impulse[0] = next1;
    m.friction_impulse[1] = next2;
    if (is_rich(contact)) solve_rolling(contact, sum);
  }

  // Stops the relative spin with a torque of at most resistance times normal impulse.
  void solve_rolling(Contact& contact, float impulse_sum) {
    InertiaRow both = data_.bodies.inertia[contact.b];
    if (contact.pushes_a) {
      for (int i = 0; i < 6; ++i) {
        both.inverse_inertia[i] += data_.bodies.inertia[contact.a].inverse_inertia[i];
      }
    }
    const float* s = both.inverse_inertia;
    const Vec3 x{s[0], s[1], s[2]}, y{s[1], s[3], s[4]}, z{s[2], s[4], s[5]};
    const float determinant = dot(x, cross(y, z));
    if (!(determinant > 0.0f)) return;
    const Vec3 spin = motion(contact.b).angular - motion(contact.a).angular;
    // Cramer's rule for the impulse that stops the spin.
    const Vec3 stop =
        (1.0f / determinant) * Vec3{dot(spin, cross(y, z)), dot(x, cross(spin, z)), dot(x, cross(y, spin))};
    float(&stored)[3] = contact.surface->rolling_impulse;
    const Vec3 old = to_vec(stored);
    Vec3 next = old - stop;
    const float limit = contact.surface->rolling_resistance * impulse_sum;
    if (length(next) > limit) {
      next = old - (1.0f / (s[0] + s[3] + s[5])) * spin;
      next = std::min(limit / length(next), 1.0f) * next;
    }
    stored[0] = next.x;
    stored[1] = next.y;
    stored[2] = next.z;
    twist(contact, next - old);
  }

  // The solver does not brake a free point that approaches fast enough to rebound.
  bool is_left_to_rebound(const Contact& contact, float speed, float impulse) const {
    return rebounds_at_all(contact) && speed < -settings_.restitution_threshold && impulse == 0.0f;
  }

  static bool rebounds_at_all(const Contact& contact) {
    return is_rich(contact) && contact.surface->restitution > 0.0f;
  }

  // Solves impacts before the substep, contact after contact, until none is left or the passes are over.
  void rebound_all() {
    constexpr int kPasses = 32;
    rebounds_ = true;
    bool any = true;
    for (int pass = 0; any && pass < kPasses; ++pass) {
      any = false;
      for (Contact& contact : contacts_) any = rebound(contact) || any;
    }
    rebounds_ = false;
  }

  float normal_speed(const Contact& contact, int k) const {
    return dot(speed_at(motion(contact.a), motion(contact.b), contact.anchor_a[k], contact.anchor_b[k]),
               contact.normal);
  }

  // Points that meet within the substep leave with e times the speed at which they come, the fastest being
  // above the threshold; then friction under the impulses of the impact.
  bool rebound(Contact& contact) {
    if (!rebounds_at_all(contact)) return false;
    float incoming[4] = {}, fastest = 0.0f;
    bool meets[4] = {};
    for (int k = 0; k < contact.points; ++k) {
      incoming[k] = normal_speed(contact, k);
      meets[k] = separation(contact, k) + incoming[k] * h_ < 0.0f;
      if (meets[k]) fastest = std::min(fastest, incoming[k]);
    }
    if (!(fastest < -settings_.restitution_threshold)) return false;
    constexpr int kSweeps = 8;
    float impulse[4] = {};
    for (int i = 0; i < kSweeps * contact.points; ++i) {
      const int k = i % contact.points;
      if (!meets[k]) continue;
      const Vec3 n = contact.normal, arm_a = contact.anchor_a[k], arm_b = contact.anchor_b[k];
      const float error =
          normal_speed(contact, k) + contact.surface->restitution * std::min(incoming[k], 0.0f);
      const float next = std::max(impulse[k] - error / response(contact, n, n, arm_a, arm_b), 0.0f);
      push(contact, (next - impulse[k]) * n, arm_a, arm_b);
      impulse[k] = next;
    }
    // Friction as in a relax sweep that begins with these impulses and without any of its own.
    const Manifold kept = *contact.manifold;
    const ContactSurface kept_surface = *contact.surface;
    std::copy(impulse, impulse + 4, contact.manifold->normal_impulse);
    contact.manifold->friction_impulse[0] = contact.manifold->friction_impulse[1] = 0.0f;
    contact.manifold->twist_impulse = 0.0f;
    std::fill(contact.surface->rolling_impulse, contact.surface->rolling_impulse + 3, 0.0f);
    solve_friction(contact);
    *contact.manifold = kept;
    *contact.surface = kept_surface;
    return true;
  }

  WorldData& data_;
  const WorldSettings& settings_;
  float dt_;
  float h_;
  Soft soft_, soft_static_;
  float residual_ = 0.0f;
  bool rebounds_ = false;
  std::vector<bool> pushed_;  // by body, by impulses of this step
  std::vector<Contact> contacts_;
};

}  // namespace

void solve_plainly(WorldData& data, float dt) { PlainSolver(data, dt).run(); }

void step_plainly(World& world, float dt, Workers& workers) {
  WorldData& data = internals(world);
  Crew crew(workers);
  wake_neighbors(data);
  refresh_lists(data, crew);
  find_pairs(data, crew);
  collide(data, crew);
  wake_touched_islands(data, crew);
  put_islands_to_sleep(data, crew);
  refresh_joints(data, crew);
  list_body_events(data);
  color_constraints(data, crew);
  pack_blocks(data, crew);
  solve_plainly(data, dt);
  finish_step(data, dt, crew);
  data.last_dt = dt;
  data.last_substep = substep_of(data, dt);
  ++data.step_count;
}

}  // namespace scree::testing
