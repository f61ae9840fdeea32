// Body kernels; see simd/bodies/body_kernels.h.
#include <simd/bodies/body_kernels.h>
#include <simd/bodies/body_rows.h>
#include <simd/bodies/free_turn.h>
#include <simd/wide/wide_angles.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Indices of a group of lanes. Lanes past the end repeat the last body: they compute what it computes and
// store nothing.
struct Lanes {
  alignas(64) std::int32_t index[kLanes];
  int count;
};

inline Lanes load_lanes(const std::int32_t* list, int begin, int end) {
  Lanes lanes;
  lanes.count = end - begin < kLanes ? end - begin : kLanes;
  for (int lane = 0; lane < kLanes; ++lane) {
    lanes.index[lane] = list[begin + (lane < lanes.count ? lane : lanes.count - 1)];
  }
  return lanes;
}

struct WideVelocity {
  V3 linear, angular;
  F spare;  // VelocityRow::lag; of free_velocity: rounding_shift()
};

inline WideVelocity load_velocity(const VelocityRow* rows, const Lanes& lanes) {
  const float* base = rows->linear;
  WideVelocity v;
  F padding;
  load_rows(base, 8, lanes.index, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  load_rows(base + 4, 8, lanes.index, v.angular.y, v.angular.z, v.spare, padding);
  return v;
}

inline void store_velocity(VelocityRow* rows, const Lanes& lanes, const WideVelocity& v) {
  float* base = rows->linear;
  store_rows(base, 8, lanes.index, lanes.count, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  store_row_pairs(base + 4, 8, lanes.index, lanes.count, v.angular.y, v.angular.z);
}

inline void store_free_velocity(VelocityRow* rows, const Lanes& lanes, const WideVelocity& v) {
  float* base = rows->linear;
  store_rows(base, 8, lanes.index, lanes.count, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  store_rows(base + 4, 8, lanes.index, lanes.count, v.angular.y, v.angular.z, v.spare, F(0.0f));
}

inline void store_delta(DeltaRow* rows, const Lanes& lanes, const WideDelta& d) {
  float* base = rows->position;
  store_rows(base, 8, lanes.index, lanes.count, d.position.x, d.position.y, d.position.z, d.rotation.x);
  store_rows(base + 4, 8, lanes.index, lanes.count, d.rotation.y, d.rotation.z, d.rotation.w, F(0.0f));
}

inline Q4 load_rotation(const PoseRow* rows, const Lanes& lanes) {
  Q4 q;
  const float* base = rows->position;
  load_rows(base + 4, 8, lanes.index, q.x, q.y, q.z, q.w);
  return q;
}

struct WideMotion {
  F linear_damping, angular_damping, gravity_factor;
  I flags;
};

inline WideMotion load_motion(const MotionRow* rows, const Lanes& lanes) {
  WideMotion m;
  F flags;
  load_rows(&rows->linear_damping, 4, lanes.index, m.linear_damping, m.angular_damping, m.gravity_factor,
            flags);
  m.flags = as_int(flags);
  return m;
}

inline M has_contacts(const BodyArgs& args, const Lanes& lanes) {
  alignas(64) std::int32_t noted[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) noted[lane] = args.step_notes[lanes.index[lane]] & kHasContacts;
  return load(noted) > I(0);
}

// Notes bodies whose own motion is non-finite before any contact acts: they are at fault, see
// parallel/bodies/quarantine_bodies.cpp.
inline void mark_non_finite(const BodyArgs& args, const Lanes& lanes, const WideVelocity& v) {
  const std::uint32_t finite = bits(is_finite(v.linear) & is_finite(v.angular));
  if (finite == (1u << kLanes) - 1u) return;
  for (int lane = 0; lane < lanes.count; ++lane) {
    if ((finite >> lane & 1u) == 0) args.step_notes[lanes.index[lane]] |= std::uint8_t{kNonFiniteAlone};
  }
}

void prepare(const BodyArgs& args, int begin, int end) {
  for (int i = begin; i < end; i += kLanes) {
    const Lanes lanes = load_lanes(args.list, i, end);
    const BodyMass local = load_mass(args.local_mass, lanes.index);
    const I flags = load_motion(args.motion, lanes).flags;
    S3 inverse = rotate(to_matrix(load_rotation(args.pose, lanes)), local.inverse_inertia);
    const F zero(0.0f);
    const M lock_x = is_locked(flags, 3), lock_y = is_locked(flags, 4), lock_z = is_locked(flags, 5);
    inverse.xx = select(lock_x, zero, inverse.xx);
    inverse.yy = select(lock_y, zero, inverse.yy);
    inverse.zz = select(lock_z, zero, inverse.zz);
    inverse.xy = select(lock_x | lock_y, zero, inverse.xy);
    inverse.xz = select(lock_x | lock_z, zero, inverse.xz);
    inverse.yz = select(lock_y | lock_z, zero, inverse.yz);
    float* base = args.inertia->inverse_inertia;
    store_rows(base, 8, lanes.index, lanes.count, inverse.xx, inverse.xy, inverse.xz, inverse.yy);
    store_rows(base + 4, 8, lanes.index, lanes.count, inverse.yz, inverse.zz, local.inverse_mass, zero);
    store_delta(args.delta, lanes, {{zero, zero, zero}, {zero, zero, zero, F(1.0f)}});
    for (int lane = 0; lane < lanes.count; ++lane) args.step_notes[lanes.index[lane]] = 0;
  }
}

// Scales speeds above the world's limits down to them. The scale is NaN where the square of the velocity
// overflows, so that the body counts as non-finite: a scale of 0 would hide it.
struct SpeedScales {
  F linear, angular;
};
inline F scale_to_limit(V3 velocity, F limit) {
  const F speed = length(velocity);
  const F zero_or_none = speed - speed;
  return select(speed > limit, limit / speed, F(1.0f)) + zero_or_none;
}
inline SpeedScales scales_to_limits(const BodyArgs& args, const WideVelocity& v) {
  return {scale_to_limit(v.linear, F(args.max_linear_speed)),
          scale_to_limit(v.angular, F(args.max_angular_speed))};
}
// A scale that is NaN changes its body, too: whether it does must not depend on the lanes beside it.
inline bool is_any_scaled(const SpeedScales& scales) {
  const F one(1.0f);
  return bits(!((scales.linear == one) & (scales.angular == one))) != 0;
}
// Clamps dynamic bodies only. Returns whether any speed was above its limit.
inline bool clamp_speeds(const BodyArgs& args, const Lanes& lanes, WideVelocity& v) {
  const SpeedScales scales = scales_to_limits(args, v);
  if (!is_any_scaled(scales)) return false;
  const F one(1.0f);
  const M dynamic = load_mass(args.local_mass, lanes.index).inverse_mass > F(0.0f);
  v.linear = v.linear * select(dynamic, scales.linear, one);
  v.angular = v.angular * select(dynamic, scales.angular, one);
  return true;
}

// Clamps within a substep, for joints that cannot be held: these would give their bodies any speed. Scales
// the free velocity, too, and v - u with both. Bodies without joints are left alone: a thin rod that lands
// may spin faster for a moment, and contacts bound the speeds that they cause.
inline bool clamp_both(const BodyArgs& args, const Lanes& lanes, M which, WideVelocity& v) {
  const SpeedScales scales = scales_to_limits(args, v);
  if (!is_any_scaled(scales)) return false;
  const F one(1.0f);
  WideVelocity u = load_velocity(args.free_velocity, lanes);
  const M dynamic = which & (load_mass(args.local_mass, lanes.index).inverse_mass > F(0.0f));
  const F linear = select(dynamic, scales.linear, one), angular = select(dynamic, scales.angular, one);
  v = {v.linear * linear, v.angular * angular, v.spare};
  store_velocity(args.free_velocity, lanes, {u.linear * linear, u.angular * angular, u.spare});
  return true;
}

// m/s^2, by gravity and the caller's forces.
inline V3 acceleration_of(const BodyArgs& args, V3 force, F inverse_mass, F gravity_factor) {
  const V3 gravity{F(args.gravity[0]), F(args.gravity[1]), F(args.gravity[2])};
  return gravity * gravity_factor + force * inverse_mass;
}

// s^2: of a flight's acceleration, added to the way in a substep, it makes up for the rounding of v + a h:
// the kinetic energy has changed as over that much more time. Rounded increments are the same in every
// substep at about the same speed, so that the energy's error would grow with the fall: 49 balls that bounce
// 5 m high for 20 s erred by 0.2 J at 1 ms and 4 substeps. Where most of the change is lost, a body would
// stand still instead: there the velocity counts.
inline F rounding_shift(V3 v, V3 change, V3 acceleration) {
  constexpr float kMostLost = 1.0f / 64.0f;
  const auto lost_of = [](F a, F b) {  // exactly (Knuth's TwoSum)
    const F sum = a + b, added = sum - a;
    return (a - (sum - added)) + (b - added);
  };
  const V3 lost{lost_of(v.x, change.x), lost_of(v.y, change.y), lost_of(v.z, change.z)};
  const M counts = length_squared(lost) < length_squared(change) * F(kMostLost * kMostLost);
  const F square = length_squared(acceleration), one(1.0f);
  // Of both, what is along the acceleration: what is lost across it would be made up for in another
  // direction.
  const F share = one / select(square > F(0.0f), square, one);
  const F lost_along = dot(lost, acceleration) * share, along = dot(v + change * F(0.5f), acceleration);
  return select(counts & (square > F(0.0f)), F(0.0f) - lost_along * along * share, F(0.0f));
}

// Bodies whose last step ended early are swept: they make up for it at the end of this one.
inline void note_lags(const BodyArgs& args, const Lanes& lanes, F lag) {
  const std::uint32_t lags = bits(lag > F(0.0f));
  if (lags == 0) return;
  for (int lane = 0; lane < lanes.count; ++lane) {
    if ((lags >> lane & 1u) != 0) args.step_notes[lanes.index[lane]] |= std::uint8_t{kLags};
  }
}

// Semi-implicit Euler with implicit damping. The impulses of this step so far, v - u, are kept: they are the
// warm start of the coming substep. Those of impacts are not.
void integrate_velocities(const BodyArgs& args, int begin, int end) {
  const F h(args.substep), one(1.0f);
  const bool inherit = !args.first_substep && args.warm_start;
  for (int i = begin; i < end; i += kLanes) {
    const Lanes lanes = load_lanes(args.list, i, end);
    const WideVelocity v = load_velocity(args.velocity, lanes);
    const BodyMass mass = load_mass(args.inertia, lanes.index);
    const WideMotion motion = load_motion(args.motion, lanes);
    V3 force, torque;
    F pad0, pad1;
    const float* loads = args.force->force;
    load_rows(loads, 8, lanes.index, force.x, force.y, force.z, torque.x);
    load_rows(loads + 4, 8, lanes.index, torque.y, torque.z, pad0, pad1);

    const V3 acceleration = acceleration_of(args, force, mass.inverse_mass, motion.gravity_factor);
    const V3 change = acceleration * h;
    WideVelocity u;
    u.linear = (v.linear + change) * (one / (one + h * motion.linear_damping));
    u.angular =
        (v.angular + (mass.inverse_inertia * torque) * h) * (one / (one + h * motion.angular_damping));
    apply_locks(motion.flags, u.linear, u.angular);
    u.spare = args.flies_on_parabolas ? rounding_shift(v.linear, change, acceleration) : F(0.0f);
    WideVelocity next = u;
    if (inherit) {
      const WideVelocity pushed = load_velocity(args.velocity_before, lanes);
      const WideVelocity before = load_velocity(args.free_velocity, lanes);
      next.linear = u.linear + (pushed.linear - before.linear);
      next.angular = u.angular + (pushed.angular - before.angular);
    }
    const SpeedScales scales = scales_to_limits(args, next);
    next = {next.linear * scales.linear, next.angular * scales.angular, v.spare};
    store_velocity(args.velocity, lanes, next);
    store_free_velocity(args.free_velocity, lanes,
                        {u.linear * scales.linear, u.angular * scales.angular, u.spare});
    if (args.first_substep) {
      mark_non_finite(args, lanes, next);
      note_lags(args, lanes, v.spare);
    }
  }
}

// The velocity of a body with contacts when it has turned by `delta` since the step began, `time` ago.
// Contacts act by the inertia of the step's beginning for the whole step. Else an impulse along an axis of
// small inertia could meet a large one there. So w is the velocity in the axes of the step's beginning. They
// turn with the body, and w precesses in them for the time that it takes to turn as far as the body has.
//
// Keeping the momentum instead fails: turned by more or less than its own path, it comes to lie along other
// axes. Keeping the energy fails, too: a needle on the ground came to spin ten times as fast about itself,
// and a box lost 9 % of its momentum in ten seconds. The precession keeps the magnitude of the momentum as
// well.
inline V3 turn_along(Q4 before, Q4 delta, V3 w, const S3& inertia, F time) {
  constexpr float kLeastCosine = 1e-3f;  // of half the angle
  constexpr float kWholeTurn = 6.2831853f;
  constexpr float kShort = 0.48f;  // of a turn; rounds to the whole turns below, and by 2 % of one upward
  const M3 r = to_matrix(before);
  const V3 local = multiply_transposed(r, w);
  const F cosine = copy_sign(max(abs(delta.w), F(kLeastCosine)), delta.w);
  const V3 t = multiply_transposed(r, V3{delta.x, delta.y, delta.z} * (F(1.0f) / cosine));
  const F speed = length(w), angle = dot(rotation_vector(delta), w) / speed;
  const F whole = round_to_nearest((speed * time - angle) * F(1.0f / kWholeTurn) - F(kShort));
  const F turned =
      (angle + whole * F(kWholeTurn)) / speed;  // s, negative where a blow has turned the velocity
  const V3 change = precession(local, inertia, max(min(turned, time), -time));
  return w + r * (change + rotation_change(t, local + change));
}

struct Inertias {
  S3 direct, inverse;  // in the body's axes
};
inline Inertias load_inertias(const BodyArgs& args, const Lanes& lanes) {
  Inertias inertias;
  S3& i = inertias.direct;
  F pad0, pad1;
  const float* base = args.local_inertia->inertia;
  load_rows(base, 8, lanes.index, i.xx, i.xy, i.xz, i.yy);
  load_rows(base + 4, 8, lanes.index, i.yz, i.zz, pad0, pad1);
  inertias.inverse = load_mass(args.local_mass, lanes.index).inverse_inertia;
  return inertias;
}

// Joints act by the body's present inertia. The next substep inherits their impulses of this one, v - u, as
// what the same impulses do by the new inertia. Else a spinning top gains a sixth of its spin in five
// seconds, at any number of substeps.
inline void turn_inertia(const BodyArgs& args, const Lanes& lanes, Q4 before, Q4 after,
                         const Inertias& inertias, V3 impulses, M which, WideVelocity& v) {
  const M3 from = to_matrix(before), to = to_matrix(after);
  const V3 momentum = from * (inertias.direct * multiply_transposed(from, impulses));
  const S3 turned = rotate(to, inertias.inverse);
  WideVelocity u = load_velocity(args.free_velocity, lanes);
  u.angular = select(which, v.angular - turned * momentum, u.angular);
  store_velocity(args.free_velocity, lanes, u);
  const BodyMass mass = load_mass(args.inertia, lanes.index);
  const S3& old = mass.inverse_inertia;
  float* base = args.inertia->inverse_inertia;
  store_rows(base, 8, lanes.index, lanes.count, select(which, turned.xx, old.xx),
             select(which, turned.xy, old.xy), select(which, turned.xz, old.xz),
             select(which, turned.yy, old.yy));
  store_rows(base + 4, 8, lanes.index, lanes.count, select(which, turned.yz, old.yz),
             select(which, turned.zz, old.zz), mass.inverse_mass, F(0.0f));
}

constexpr float kWhirl = 0.2f;  // rad in a substep; less than that bodies with contacts turn about one axis

// rad in a substep; a body that turns by less shows no precession within an hour. The squares of such turns
// are denormal, which take a hundred times as long: 10,000 bodies of 1e-20 rad/s took 20 ms a step.
constexpr float kStill = 1e-6f;

// m, by which the way of a body that flies falls short of its last velocity: where no impulse acts, v = u,
// and the body moves at the mean of its velocities before and after the substep. So it flies on the parabola,
// and its velocity is that of the parabola. Under impulses, which hold for the end of the substep, the way
// must be that of the last velocity: a body at rest would sink by the difference.
inline V3 flight_shift(const BodyArgs& args, const Lanes& lanes, const WideMotion& motion, V3 v) {
  const F zero(0.0f), h(args.substep), most(args.max_linear_speed);
  V3 shift{zero, zero, zero};
  if (!args.flies_on_parabolas) return shift;
  const WideVelocity free = load_velocity(args.free_velocity, lanes);
  const V3 u = free.linear;
  const M flies = (v.x == u.x) & (v.y == u.y) & (v.z == u.z);
  if (bits(flies) == 0) return shift;
  V3 force, unused = shift;
  load_rows(args.force->force, 8, lanes.index, force.x, force.y, force.z, unused.x);
  const F inverse_mass = load_mass(args.inertia, lanes.index).inverse_mass;
  const V3 acceleration = acceleration_of(args, force, inverse_mass, motion.gravity_factor);
  V3 change = (acceleration - v * motion.linear_damping) * h;
  apply_locks(motion.flags, change, unused);
  // Where the world's limit cuts the velocity, the change is none of this.
  const M counts = flies & (inverse_mass > zero) & (length_squared(change) < most * most);
  return select(counts, change * (F(-0.5f) * h + free.spare / h), shift);
}

SCREE_SWEEP void integrate_poses(const BodyArgs& args, int begin, int end) {
  const F h(args.substep);
  const V3 none{F(0.0f), F(0.0f), F(0.0f)};
  for (int i = begin; i < end; i += kLanes) {
    const Lanes lanes = load_lanes(args.list, i, end);
    WideVelocity v = load_velocity(args.velocity, lanes);
    WideDelta delta = load_delta(args.delta, lanes.index);
    const WideMotion motion = load_motion(args.motion, lanes);
    const I flags = motion.flags;
    const M locked = !((flags & I(kMotionLocksMask)) == I(0));
    const M gyroscopic = !((flags & I(kMotionGyroscopic)) == I(0));
    V3 turn = v.angular;
    bool changed = false;
    if (bits(locked) != 0) {
      apply_locks(flags, v.linear, v.angular);
      turn = v.angular;
      changed = true;
    }
    const M jointed = !((flags & I(kMotionJointed)) == I(0));
    if (bits(jointed) != 0 && clamp_both(args, lanes, jointed, v)) {
      turn = v.angular;
      changed = true;
    }
    const F turn_squared = length_squared(v.angular) * (h * h);
    const M spins = jointed | (turn_squared > F(kStill * kStill));
    const M free = gyroscopic & spins & !(locked | has_contacts(args, lanes));
    Q4 rotation = advance(delta.rotation, turn, h);
    if (bits(free) != 0) {
      const Inertias inertias = load_inertias(args, lanes);
      const Q4 start = load_rotation(args.pose, lanes);
      Q4 turned = delta.rotation;
      V3 next = select(free, v.angular, none);
      turn_freely(start, inertias.direct, h, free, turned, next);
      // Turns the free velocity, too, so that v - u stays the sum of the impulses.
      WideVelocity u = load_velocity(args.free_velocity, lanes);
      const V3 pushed = v.angular - u.angular;
      u.angular = select(free, u.angular + (next - v.angular), u.angular);
      rotation = select(free, turned, rotation);
      v.angular = select(free, next, v.angular);
      store_velocity(args.free_velocity, lanes, u);
      changed = true;
      const M turns = free & jointed;
      if (bits(turns) != 0)
        turn_inertia(args, lanes, delta.rotation * start, turned * start, inertias, pushed, turns, v);
    }
    // Only velocity across the axis of a stick turns it. Turned about all of the velocity, the axis would
    // circle.
    const M whirls = gyroscopic & !(locked | free) & (turn_squared > F(kWhirl * kWhirl));
    if (bits(whirls) != 0) {
      const S3 inertia = load_inertias(args, lanes).direct;
      const Q4 start = load_rotation(args.pose, lanes);
      const V3 spin = select(whirls, v.angular, none);
      V3 now = turn_along(start, delta.rotation, spin, inertia, F(args.elapsed));
      Q4 turned = delta.rotation;
      turn_freely(start, inertia, h, whirls, turned, now);
      rotation = select(whirls, turned, rotation);
    }
    if (changed) store_velocity(args.velocity, lanes, v);
    delta.position = delta.position + (v.linear * h + flight_shift(args, lanes, motion, v.linear));
    delta.rotation = rotation;
    store_delta(args.delta, lanes, delta);
  }
}

// A body may be this many times as fast as the speeds of sleep at times, and still fall asleep.
constexpr float kTremble = 8.0f;

// Without rolling resistance nothing stops a body that rolls slowly or rocks on a ball, and it would keep its
// island awake for ever. So bodies that may sleep and touch something are damped while they turn no faster
// than kTremble times the speed of sleep: at this rate, and less near that limit. For a ball with a radius of
// 0.3 m it acts as rolling resistance of 1 % of the radius does.
constexpr float kDrowsyDamping = 2.0f;  // 1/s
// Slower bodies, in shares of the speed of sleep, are near enough to rest, as all bodies of a pile are.
constexpr float kDrowsyLeast = 0.5f;

// Returns whether any body was damped.
inline bool damp_drowsy(const BodyArgs& args, const Lanes& lanes, WideVelocity& v) {
  const F squared = length_squared(v.angular), limit(args.sleep_angular_speed), one(1.0f);
  const F least = F(kDrowsyLeast) * limit, most = F(kTremble) * limit;
  const M slow = (squared > least * least) & (squared < most * most);
  if (bits(slow) == 0) return false;
  alignas(64) std::int32_t sleeper[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) sleeper[lane] = args.flags[lanes.index[lane]] & args.may_sleep;
  const M drowsy = slow & has_contacts(args, lanes) & (load(sleeper) > I(0)) &
                   (load_mass(args.local_mass, lanes.index).inverse_mass > F(0.0f));
  if (bits(drowsy) == 0) return false;
  const F rate = F(kDrowsyDamping * args.step) * (one - squared / (most * most));
  v.angular = v.angular * select(drowsy, one / (one + rate), one);
  return true;
}

// A body that stays in place falls asleep. The test is how far it has moved since its timer began, not its
// speed: a body that is wedged in, and shaken by contacts that jump between two features every few steps,
// moves to and fro by less than a centimeter. (Jolt's sleep test is similar: points of a body must stay
// within small balls.) It has to stay within the distance that the speeds of sleep cover in the time to
// sleep, and may be kTremble times as fast meanwhile. That is slower than a bouncing ball, unless the ball
// rises by less than 8 mm. A faster step takes this many slower ones from the timer.
constexpr float kRestlessWeight = 3.0f;

// Rotation vector of a turn by less than a quarter, to second order.
inline V3 turn_of(Q4 q) {
  const F twice = select(q.w < F(0.0f), F(-2.0f), F(2.0f));
  return {q.x * twice, q.y * twice, q.z * twice};
}

// The timers of bodies that have moved by `delta` and end the step with speeds of these squares, and their
// drift.
inline F time_at_rest(const BodyArgs& args, const Lanes& lanes, const WideDelta& delta, F linear_squared,
                      F angular_squared) {
  const F zero(0.0f), step(args.step), full(args.sleep_time);
  const F linear_limit(args.sleep_linear_speed), angular_limit(args.sleep_angular_speed);
  alignas(64) float timers[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) timers[lane] = args.sleep_timer[lanes.index[lane]];
  F row[8];
  load_rows8(args.drift->way, lanes.index, row);
  const F timer = load(timers);
  const M runs = timer > zero;
  const V3 nowhere{zero, zero, zero};
  const V3 way = select(runs, V3{row[0], row[1], row[2]}, nowhere) + delta.position;
  const V3 turn = select(runs, V3{row[3], row[4], row[5]}, nowhere) + turn_of(delta.rotation);

  const F tremble(kTremble * kTremble);
  const M calm = (linear_squared < tremble * (linear_limit * linear_limit)) &
                 (angular_squared < tremble * (angular_limit * angular_limit));
  const F longer = select(calm, timer + step, min(timer, full) - F(kRestlessWeight) * step);
  const F time_to_move = max(longer, full);
  const F farthest = linear_limit * time_to_move, widest = angular_limit * time_to_move;
  const M counts = (length_squared(way) < farthest * farthest) & (length_squared(turn) < widest * widest) &
                   (longer > zero);
  // Drops the older half after twice the time, so that a body that moves on after a long rest is noticed.
  const M old = !(longer < F(2.0f) * full);
  const F share = select(old, F(0.5f), F(1.0f));
  const V3 kept_way = select(counts, way * share, nowhere), kept_turn = select(counts, turn * share, nowhere);
  const F kept[8] = {kept_way.x, kept_way.y, kept_way.z, kept_turn.x, kept_turn.y, kept_turn.z, zero, zero};
  store_rows8(args.drift->way, lanes.index, lanes.count, kept);
  return select(counts, select(old, full, longer), zero);
}

// Transforms, sleep timers and energies of bodies that are where the step ends. `place`: of the first lane in
// the list.
void store_outcome(const BodyArgs& args, const Lanes& lanes, int place, const WideVelocity& v, V3 position,
                   Q4 rotation, const WideDelta& delta, const S3& inertia, std::uint32_t finite) {
  const F linear_squared = length_squared(v.linear);
  alignas(64) float timer[kLanes], energy[kLanes], mass[kLanes], center[3][kLanes], origin[7][kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const float* row = args.center + 3 * static_cast<std::ptrdiff_t>(lanes.index[lane]);
    for (int axis = 0; axis < 3; ++axis) center[axis][lane] = row[axis];
    mass[lane] = args.mass[lanes.index[lane]];
  }
  const V3 to_center{load(center[0]), load(center[1]), load(center[2])};
  const V3 offset = rotate(rotation, to_center);
  store(origin[0], position.x - offset.x);
  store(origin[1], position.y - offset.y);
  store(origin[2], position.z - offset.z);
  store(origin[3], rotation.x);
  store(origin[4], rotation.y);
  store(origin[5], rotation.z);
  store(origin[6], rotation.w);
  store(timer, time_at_rest(args, lanes, delta, linear_squared, length_squared(v.angular)));

  const V3 local_w = rotate_back(rotation, v.angular);
  store(energy, F(0.5f) * (load(mass) * linear_squared + dot(local_w, inertia * local_w)));

  for (int lane = 0; lane < lanes.count; ++lane) {
    float* transform = args.transform + 7 * static_cast<std::ptrdiff_t>(lanes.index[lane]);
    for (int part = 0; part < 7; ++part) transform[part] = origin[part][lane];
    args.sleep_timer[lanes.index[lane]] = timer[lane];
    args.kinetic_energy[place + lane] = energy[lane];
    args.non_finite[place + lane] = (finite >> lane & 1u) != 0 ? 0 : 1;
  }
}

SCREE_SWEEP void finish(const BodyArgs& args, int begin, int end) {
  const F zero(0.0f);
  for (int i = begin; i < end; i += kLanes) {
    const Lanes lanes = load_lanes(args.list, i, end);
    WideVelocity v = load_velocity(args.velocity, lanes);
    const WideDelta delta = load_delta(args.delta, lanes.index);
    V3 position;
    F pad;
    load_rows(args.pose->position, 8, lanes.index, position.x, position.y, position.z, pad);
    const Q4 rotation = load_rotation(args.pose, lanes);
    V3 new_position = position + delta.position;
    Q4 new_rotation = normalize(delta.rotation * rotation);

    // The last sweep over the contacts ignores locks.
    const I flags = load_motion(args.motion, lanes).flags;
    const M locked = !((flags & I(kMotionLocksMask)) == I(0));
    const bool any_locks = bits(locked) != 0;
    if (any_locks) apply_locks(flags, v.linear, v.angular);
    const F turn = F(args.step) * F(args.step) * length_squared(v.angular);
    const M turns = has_contacts(args, lanes) & !locked & !((flags & I(kMotionGyroscopic)) == I(0)) &
                    (turn > F(kStill * kStill));
    const bool any_turns = bits(turns) != 0;
    const Inertias inertias = load_inertias(args, lanes);
    if (any_turns) {
      const V3 spin = select(turns, v.angular, V3{zero, zero, zero});
      const V3 turned = turn_along(rotation, delta.rotation, spin, inertias.direct, F(args.step));
      v.angular = select(turns, turned, v.angular);
    }

    const bool any_drowsy = args.may_sleep != 0 && damp_drowsy(args, lanes, v);

    // A body whose state has become non-finite is put back where it was, at rest.
    const V3 rotation_part{new_rotation.x, new_rotation.y, new_rotation.z};
    const M finite = is_finite(new_position) & is_finite(rotation_part) &
                     is_finite(length_squared(v.linear)) & is_finite(length_squared(v.angular)) &
                     is_finite(new_rotation.w);
    new_position = select(finite, new_position, position);
    new_rotation = {select(finite, new_rotation.x, rotation.x), select(finite, new_rotation.y, rotation.y),
                    select(finite, new_rotation.z, rotation.z), select(finite, new_rotation.w, rotation.w)};
    const V3 at_rest{zero, zero, zero};
    v.linear = select(finite, v.linear, at_rest);
    v.angular = select(finite, v.angular, at_rest);
    const std::uint32_t finite_bits = bits(finite);
    // Clamps what the last sweep has left, so that no caller sees a speed above the limits.
    const bool any_fast = clamp_speeds(args, lanes, v);
    if (finite_bits != (1u << kLanes) - 1u || any_locks || any_fast || any_turns || any_drowsy) {
      store_velocity(args.velocity, lanes, v);
    }
    float* pose = args.pose->position;
    store_rows(pose, 8, lanes.index, lanes.count, new_position.x, new_position.y, new_position.z, zero);
    store_rows(pose + 4, 8, lanes.index, lanes.count, new_rotation.x, new_rotation.y, new_rotation.z,
               new_rotation.w);
    store_outcome(args, lanes, i, v, new_position, new_rotation, delta, inertias.direct, finite_bits);
  }
}

}  // namespace

BodyKernels make_body_kernels() { return {prepare, integrate_velocities, integrate_poses, finish}; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
