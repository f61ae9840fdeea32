// A drive of three rows at once, as motors and mice have it. Private to the joint kernels.
#pragma once

#include <simd/constraints/joints/joint_frames.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// A drive of three rows at once, whose impulse is bounded by its length. The spring is implicit with
// K + yield for its response: `yield`, zero for a motor, is what the spring itself gives way by, as the hertz
// say for the response of a reference. So springs are stable whatever the levers, and as stiff as one
// expects.
struct VectorDriveLanes {
  LaneFloats error[3];  // how far ahead of the target
  LaneFloats target_speed[3];
  LaneFloats yield[6], inverse_response[6];  // of K + yield
  LaneFloats response_trace;                 // the same
  LaneFloats bias_rate, yield_rate;          // yield_rate: times the reference's response
  LaneFloats max_impulse;                    // in a substep
  LaneFloats impulse[3];
};

inline void prepare_drive(const JointArgs& args, const JointBodyLanes& bodies, const WideDrive& given,
                          V3 impulse, VectorDriveLanes& lanes) {
  const F zero(0.0f), one(1.0f);
  const M spring = given.drive == I(static_cast<std::int32_t>(kDriveSpring));
  const M idle = given.drive == I(static_cast<std::int32_t>(kDriveNone));
  const Softness soft = soften(args, bodies, select(spring, given.hertz, one), given.damping_ratio);
  store(lanes.bias_rate, select(spring, soft.bias_rate, zero));
  store(lanes.yield_rate, select(spring, soft.impulse_scale / soft.mass_scale, zero));
  store(lanes.max_impulse, select(idle, zero, given.max_force * F(args.substep)));
  store3(lanes.impulse, select(idle, V3{zero, zero, zero}, impulse * F(args.warm_start_scale)));
}

// Returns the change of the impulse.
inline V3 solve_vector_drive(VectorDriveLanes& lanes, V3 speed, F keep) {
  const V3 old_impulse = load3(lanes.impulse) * keep;
  const V3 error = (speed - load3(lanes.target_speed)) + load3(lanes.error) * load(lanes.bias_rate) +
                   load6(lanes.yield) * old_impulse;
  const V3 free = old_impulse - load6(lanes.inverse_response) * error;
  const V3 impulse =
      bound_length(free, old_impulse, error, load(lanes.response_trace), load(lanes.max_impulse));
  store3(lanes.impulse, impulse);
  return impulse - old_impulse;
}

// Of the offset of anchors. The reference are the masses alone, wherever the anchors are.
inline void place_offset_response(S3 response, F inverse_mass, VectorDriveLanes& lanes) {
  const F zero(0.0f), yield = inverse_mass * load(lanes.yield_rate);
  store6(lanes.yield, {yield, zero, zero, yield, zero, yield});
  response.xx += yield;
  response.yy += yield;
  response.zz += yield;
  store(lanes.response_trace, trace(response));
  store6(lanes.inverse_response, invert(response));
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
