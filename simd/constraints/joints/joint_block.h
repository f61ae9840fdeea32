// What blocks of joints have in common: their bodies, frames, softness, reactions, and the rows of free axes.
// Private to the joint kernels.
#pragma once

#include <simd/constraints/constraint_block.h>
#include <simd/constraints/joints/joint_kernels.h>
#include <simd/wide/wide_angles.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Both bodies of a block as a sweep works on them: those of many joints as the parts that the lanes have of
// them, see joint_shares.h.
struct JointBodyLanes {
  BodyVelocity a, b;
  BodyMass mass_a, mass_b;
  F max_hertz;     // Hz, of what is held and of springs; only while a block is prepared
  F spring_scale;  // the same: times the hertz and damping ratio that springs were given
};

// An impulse at the arms: on b, its opposite on a.
inline void push(JointBodyLanes& bodies, V3 arm_a, V3 arm_b, V3 impulse) {
  bodies.a.linear = bodies.a.linear - impulse * bodies.mass_a.inverse_mass;
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * cross(arm_a, impulse);
  bodies.b.linear = bodies.b.linear + impulse * bodies.mass_b.inverse_mass;
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * cross(arm_b, impulse);
}

// A torque impulse: on b, its opposite on a.
inline void twist(JointBodyLanes& bodies, V3 torque) {
  bodies.a.angular = bodies.a.angular - bodies.mass_a.inverse_inertia * torque;
  bodies.b.angular = bodies.b.angular + bodies.mass_b.inverse_inertia * torque;
}

// Velocity of b's anchor as a's sees it.
inline V3 anchor_velocity(const JointBodyLanes& bodies, V3 arm_a, V3 arm_b) {
  return bodies.b.linear + cross(bodies.b.angular, arm_b) - bodies.a.linear - cross(bodies.a.angular, arm_a);
}

// Angular velocity of b as a sees it.
inline V3 turning_speed(const JointBodyLanes& bodies) { return bodies.b.angular - bodies.a.angular; }

inline S3 operator+(const S3& x, const S3& y) {
  return {x.xx + y.xx, x.xy + y.xy, x.xz + y.xz, x.yy + y.yy, x.yz + y.yz, x.zz + y.zz};
}

// [r] I [r]^T for the cross product matrix [r]: what an impulse at r does by turning to the velocity at r.
inline S3 lever_response(V3 r, const S3& i) {
  // Columns of I [r]^T = -I [r]: I applied to r x e_k.
  const V3 x = i * V3{F(0.0f), r.z, -r.y};
  const V3 y = i * V3{-r.z, F(0.0f), r.x};
  const V3 z = i * V3{r.y, -r.x, F(0.0f)};
  // Row j is (r x e_j) . (the columns).
  return {r.z * x.y - r.y * x.z, r.z * y.y - r.y * y.z, r.z * z.y - r.y * z.z,
          r.x * y.z - r.z * y.x, r.x * z.z - r.z * z.x, r.y * z.x - r.x * z.y};
}

// Velocity of the anchors against each other by a unit impulse at them: K = J M^-1 J^T of three held rows.
inline S3 anchor_response(const JointBodyLanes& bodies, V3 arm_a, V3 arm_b) {
  S3 k = lever_response(arm_a, bodies.mass_a.inverse_inertia) +
         lever_response(arm_b, bodies.mass_b.inverse_inertia);
  const F inverse_mass = bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass;
  k.xx += inverse_mass;
  k.yy += inverse_mass;
  k.zz += inverse_mass;
  return k;
}

// Response of the bodies' relative angular velocity to torques alone.
inline S3 turn_response(const JointBodyLanes& bodies) {
  return bodies.mass_a.inverse_inertia + bodies.mass_b.inverse_inertia;
}

// By lane.
using Softness = BasicSoftness<F>;
struct LaneSoftness {
  LaneFloats bias_rate, mass_scale, impulse_scale;
};
inline Softness load_softness(const LaneSoftness& from) {
  return {load(from.bias_rate), load(from.mass_scale), load(from.impulse_scale)};
}
inline void store_softness(LaneSoftness& to, const Softness& soft) {
  store(to.bias_rate, soft.bias_rate);
  store(to.mass_scale, soft.mass_scale);
  store(to.impulse_scale, soft.impulse_scale);
}
// Of a spring between the bodies as these joints meet them.
inline Softness soften(const JointArgs& args, const JointBodyLanes& bodies, F hertz, F damping_ratio) {
  return simd::soften(min(hertz * bodies.spring_scale, bodies.max_hertz), damping_ratio * bodies.spring_scale,
                      F(args.substep));
}
// Of what a joint holds; hertz 0 is as stiff as the step allows.
inline Softness soften_held(const JointArgs& args, const JointBodyLanes& bodies, F hertz, F damping_ratio) {
  const M given = hertz > F(0.0f), shared = bodies.max_hertz < F(args.max_hertz);
  const Softness soft = soften(args, bodies, select(given, hertz, F(1.0f)), damping_ratio);
  const auto of = [&](float SoftConstants::*constant, F asked) {
    return select(given, asked, select(shared, F(args.stiff_shared.*constant), F(args.stiff.*constant)));
  };
  return {of(&SoftConstants::bias_rate, soft.bias_rate), of(&SoftConstants::mass_scale, soft.mass_scale),
          of(&SoftConstants::impulse_scale, soft.impulse_scale)};
}

// Relax holds without bias and without giving way; but what the user made soft is a spring, which acts there,
// too.
inline Softness relax_held(const Softness& held, F hertz) {
  const F zero(0.0f), one(1.0f);
  const M given = hertz > zero;
  return {select(given, held.bias_rate, zero), select(given, held.mass_scale, one),
          select(given, held.impulse_scale, zero)};
}

// The response of what a joint leaves free, by what it is alone and with the rest held, in a sweep that holds
// the rest with this softness; to be pushed with as much of what keeps the rest. What is soft gives way, and
// would answer to a rigid hold with more than was taken from it.
template <class Response>
inline Response free_response(const Response& alone, const Response& with_rest_held, const Softness& held) {
  return with_rest_held * held.mass_scale + alone * (F(1.0f) - held.mass_scale);
}

// Where the frames of a block lie when the step begins, in world axes.
struct JointPlacement {
  V3 arm_a, arm_b;   // from the centers of mass to the anchors
  V3 center_offset;  // from a's center of mass to b's
  Q4 frame_a, frame_b;
};

// Reads the joints' rows into the block's body rows and places their frames.
inline JointPlacement load_placement(const JointArgs& args, const std::int32_t* joint, LaneInts& row_a,
                                     LaneInts& row_b) {
  constexpr int kStride = sizeof(JointFrames) / sizeof(float);
  const float* base = args.frames->anchor_a;
  V3 anchor_a, anchor_b;
  Q4 local_a, local_b;
  F index_a, index_b;
  load_rows(base, kStride, joint, anchor_a.x, anchor_a.y, anchor_a.z, index_a);
  load_rows(base + 4, kStride, joint, anchor_b.x, anchor_b.y, anchor_b.z, index_b);
  load_rows(base + 8, kStride, joint, local_a.x, local_a.y, local_a.z, local_a.w);
  load_rows(base + 12, kStride, joint, local_b.x, local_b.y, local_b.z, local_b.w);
  store(row_a, as_int(index_a));
  store(row_b, as_int(index_b));
  V3 position_a, position_b;
  Q4 rotation_a, rotation_b;
  F pad;
  const float* pose = args.pose->position;
  load_rows(pose, 8, row_a, position_a.x, position_a.y, position_a.z, pad);
  load_rows(pose, 8, row_b, position_b.x, position_b.y, position_b.z, pad);
  load_rows(pose + 4, 8, row_a, rotation_a.x, rotation_a.y, rotation_a.z, rotation_a.w);
  load_rows(pose + 4, 8, row_b, rotation_b.x, rotation_b.y, rotation_b.z, rotation_b.w);
  return {rotate(rotation_a, anchor_a), rotate(rotation_b, anchor_b), position_b - position_a,
          rotation_a * local_a, rotation_b * local_b};
}

// Entries of JointAxisRow number `axis` of the joints.
struct WideAxis {
  F lower, upper, target, speed, hertz, damping_ratio, max_force;
  I drive;
};
inline WideAxis load_axis(const JointArgs& args, const std::int32_t* joint, int axis) {
  constexpr int kStride = sizeof(JointParameters) / sizeof(float);
  const float* base = &args.parameters->axis[0].lower + 8 * axis;
  WideAxis a;
  F drive;
  load_rows(base, kStride, joint, a.lower, a.upper, a.target, a.speed);
  load_rows(base + 4, kStride, joint, a.hertz, a.damping_ratio, a.max_force, drive);
  a.drive = as_int(drive);
  return a;
}

// Numbers of the joints' parameters that stand together: `first` is that of joint row 0.
inline void load_four(const float& first, const std::int32_t* joint, F& x, F& y, F& z, F& w) {
  load_rows(&first, sizeof(JointParameters) / sizeof(float), joint, x, y, z, w);
}
inline V3 load_vector(const float (&first)[3], const std::int32_t* joint) {
  V3 v;
  F behind;
  load_four(first[0], joint, v.x, v.y, v.z, behind);
  return v;
}

// What the joints' held parts ask for: hertz, damping_ratio, angular_hertz, angular_damping_ratio.
struct WideStiffness {
  F hertz, damping_ratio, angular_hertz, angular_damping_ratio;
};
inline WideStiffness load_stiffness(const JointArgs& args, const std::int32_t* joint) {
  WideStiffness s;
  load_four(args.parameters->hertz, joint, s.hertz, s.damping_ratio, s.angular_hertz,
            s.angular_damping_ratio);
  return s;
}

// Four of a joint's impulses, number 4 group to 4 group + 3.
inline void load_impulses(const JointArgs& args, const std::int32_t* joint, int group, F& w, F& x, F& y,
                          F& z) {
  load_rows(args.impulses->impulse + 4 * group, kJointImpulses, joint, w, x, y, z);
}
inline void store_impulses(const JointArgs& args, const std::int32_t* joint, int count, int group, F w, F x,
                           F y, F z) {
  store_rows(args.impulses->impulse + 4 * group, kJointImpulses, joint, count, w, x, y, z);
}

// A non-finite impulse would make its bodies non-finite again.
inline F finite_or_zero(F a) { return select(is_finite(a), a, F(0.0f)); }
inline V3 finite_or_zero(V3 a) {
  const F zero(0.0f);
  return select(is_finite(a), a, V3{zero, zero, zero});
}

// What acts on b in a substep: an impulse at its anchor and a torque impulse about that.
struct JointImpulse {
  V3 linear, angular;
};

// That of the last substep, and what stands there of the others.
inline void store_reaction(const JointArgs& args, const ConstraintChunk& chunk, const std::int32_t* joint,
                           int count, const JointImpulse& impulse) {
  constexpr int kStride = sizeof(JointReactionRow) / sizeof(float);
  const F rate(args.inverse_substep);
  const V3 force = impulse.linear * rate, torque = impulse.angular * rate;
  F torque_y, torque_z, force_peak(0.0f), torque_peak(0.0f);
  float* base = args.reactions->force;
  if (chunk.peaks) load_rows(base + 4, kStride, joint, torque_y, torque_z, force_peak, torque_peak);
  store_rows(base, kStride, joint, count, force.x, force.y, force.z, torque.x);
  store_rows(base + 4, kStride, joint, count, torque.y, torque.z, force_peak, torque_peak);
}

// A shock is over within a substep. One that is not finite tells nothing: its bodies are about to be
// restored.
inline void note_peak(const JointArgs& args, const std::int32_t* joint, int count,
                      const JointImpulse& impulse) {
  constexpr int kStride = sizeof(JointReactionRow) / sizeof(float);
  const F rate(args.inverse_substep), most(3e38f);
  const F force = length_squared(impulse.linear * rate), torque = length_squared(impulse.angular * rate);
  F torque_y, torque_z, force_peak, torque_peak;
  float* base = &args.reactions->torque[1];
  load_rows(base, kStride, joint, torque_y, torque_z, force_peak, torque_peak);
  force_peak = select((force > force_peak) & (force < most), force, force_peak);
  torque_peak = select((torque > torque_peak) & (torque < most), torque, torque_peak);
  store_rows(base, kStride, joint, count, torque_y, torque_z, force_peak, torque_peak);
}
inline void clear_peaks(const JointArgs& args, const std::int32_t* joint, int count) {
  constexpr int kStride = sizeof(JointReactionRow) / sizeof(float);
  const F zero(0.0f);
  store_rows(&args.reactions->torque[1], kStride, joint, count, zero, zero, zero, zero);
}

// The limit of a free axis, and its drive, by lane.
struct LaneAxis {
  LaneFloats lower, upper;
  LaneFloats target, speed;  // target: of the spring where the step begins
  LaneFloats max_impulse;    // of the drive in a substep
  LaneSoftness drive;        // a motor is rigid: bias rate 0, scales 1 and 0
  LaneFloats limit_impulse, drive_impulse;
};

// Takes what an axis asks for, and the two impulses that it has accumulated.
inline void prepare_axis(const JointArgs& args, const JointBodyLanes& bodies, const WideAxis& a,
                         F limit_impulse, F drive_impulse, LaneAxis& lanes) {
  const M spring = a.drive == I(static_cast<std::int32_t>(kDriveSpring));
  const M idle = a.drive == I(static_cast<std::int32_t>(kDriveNone));
  const F zero(0.0f), one(1.0f);
  const Softness soft = soften(args, bodies, select(spring, a.hertz, one), a.damping_ratio);
  store(lanes.lower, a.lower);
  store(lanes.upper, a.upper);
  store(lanes.target, a.target);
  store(lanes.speed, a.speed);
  store(lanes.max_impulse, select(idle, zero, a.max_force * F(args.substep)));
  store_softness(lanes.drive, {select(spring, soft.bias_rate, zero), select(spring, soft.mass_scale, one),
                               select(spring, soft.impulse_scale, zero)});
  const F scale(args.warm_start_scale);
  store(lanes.limit_impulse, limit_impulse * scale);
  store(lanes.drive_impulse, select(idle, zero, drive_impulse * scale));
}

// Where the target of an axis's spring is now.
inline F target_now(const JointArgs& args, const LaneAxis& axis) {
  return load(axis.target) + load(axis.speed) * F(args.elapsed);
}

// The drive's step on an axis: returns the change of its impulse. `coordinate_error` is how far the axis is
// ahead of target_now(), by the shorter way for an angle; `speed` the axis's present one; `mass` the inverse
// of its response.
inline F solve_drive(LaneAxis& axis, F coordinate_error, F speed, F mass, F keep) {
  const Softness soft = load_softness(axis.drive);
  const F old_impulse = load(axis.drive_impulse) * keep;
  const F error = soft.mass_scale * (speed - load(axis.speed) + soft.bias_rate * coordinate_error);
  const F limit = load(axis.max_impulse);
  const F impulse = clamp(old_impulse - mass * error - soft.impulse_scale * old_impulse, -limit, limit);
  store(axis.drive_impulse, impulse);
  return impulse - old_impulse;
}

// m or rad: an end of a range that is farther away is none. Infinite ones must not come into products with
// zero.
constexpr float kNoEnd = 1e30f;

// What a coordinate lies on: on a circle what has passed one end may come round to the other one.
enum class Course { line, circle };

// The limit's step on an axis: like a contact at the nearer end, or like a spring that begins there, and both
// ways where the ends are equal. `held` is the softness of what the joint holds, in solve or in relax. Any
// struct with the limit's lanes of LaneAxis will do.
template <class Axis>
inline F solve_limit(const JointArgs& args, Course course, Axis& axis, F coordinate, F speed, F mass,
                     const Softness& held, F keep) {
  const F zero(0.0f), one(1.0f), lower = load(axis.lower), upper = load(axis.upper);
  const F above = coordinate - lower, below = upper - coordinate;
  const M at_upper = below < above;
  const M equal = lower == upper;
  // As a distance from the end and its rate; negative where the limit has been passed.
  const F sign = select(at_upper, F(-1.0f), one);
  const F separation = select(at_upper, below, above);
  const F rate = speed * sign;
  const M apart = (separation > zero) & !equal;
  const M stiff = (held.bias_rate == F(args.stiff.bias_rate)) |
                  (held.bias_rate == F(args.stiff_shared.bias_rate)) | (held.bias_rate == zero);
  // What is stiff goes back at a bounded speed; a spring pulls as it should. The exception is a
  // single end of a circle: it can be reached from behind, where the spring would release energy that it
  // never stored.
  const F bounded(args.push_speed);
  F push = select(stiff, bounded, F(__builtin_inff()));
  if (course == Course::circle) {
    push = select((lower > F(-kNoEnd)) & (upper < F(kNoEnd)), push, bounded);
  }
  const F pull_back = clamp(held.bias_rate * separation, -push, push);
  // No limit at all: the separation is infinite, and so must not come into a product with zero.
  const M near = separation < F(kNoEnd);
  const F bias = select(apart, select(near, separation, F(kNoEnd)) * F(args.inverse_substep),
                        held.mass_scale * pull_back);
  const F old_impulse = load(axis.limit_impulse) * keep * sign;
  const F change = mass * (select(apart, one, held.mass_scale) * rate + bias) +
                   select(apart, zero, held.impulse_scale) * old_impulse;
  const F free = old_impulse - change;
  const F impulse = select(equal, free, select(apart & !stiff, zero, max(free, zero)));
  // An impulse of the other end ends here: max() above has taken it away.
  const F result = select(near | equal, impulse, zero) * sign;
  store(axis.limit_impulse, result);
  return result - old_impulse * sign;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
