// Bodies of many joints, and how each of these has a share of such a body. Private to the joint kernels.
//
// A sweep solves the joints of a body one after the other, each with the whole of the body to push. While a
// round of a star's n joints is under way, what the first ones have done to the hub is undone by the last
// ones, and the errors that are left go round from joint to joint. The impulses that a substep inherits act
// in full before anything is solved, so that such errors are pumped up by half in each substep: a star of 16
// balls about a ball flew apart from rest at 400 m/s.
//
// With the sweep as P = (D + L)^-1 on K = J M^-1 J^T, where D is what the joints take for their own response,
// the inherited impulses make z^2 - 2 g z + g = 0 of each eigenvalue g of I - P K. All |z| are below 1 where
// Im(1/mu)^2 < Re(1/mu) - 3/4 for mu = 1 - g. Of equal joints of a hub with n of them that is so if D has at
// least (n - 1) / 2 times the hub's own response in it. So a joint is solved with that part of the body's
// mass whose response is as many times larger, less what the other body's response already makes up for; and
// what it does to its part moves the whole body accordingly less. That conserves momentum, and no sweep adds
// energy. (Tonge, Benevolenski and Voroshilov, "Mass Splitting for Jitter-Free Parallel Rigid Body
// Simulation", 2012, give n times the response to each, as their joints are all solved at once.)
//
// What then is left of an error after a sweep goes away over several substeps, and a stiff hold would drive
// it the other way meanwhile: at a fourth of the substeps' rate such modes grow, at a fifth none does for 2
// to 100 joints on hubs from 1/1000 to 30 times the mass of a leaf; kSharedJointStiffness of
// parallel/solvers/solve.cpp is below.
#pragma once

#include <simd/constraints/joints/joint_block.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Of the product.
inline F trace(const S3& x, const S3& y) {
  return (x.xx * y.xx + x.yy * y.yy + x.zz * y.zz) + F(2.0f) * (x.xy * y.xy + x.xz * y.xz + x.yz * y.yz);
}

// A body as one of its joints meets it.
struct JointEnd {
  BodyMass mass;
  S3 response;  // of the anchor
};

// How much heavier than its own body the other one is to a joint that holds the anchors: a mean over three
// directions.
inline F weight_at_anchor(const JointEnd& own, const JointEnd& other) {
  return trace(invert(other.response), own.response) * F(1.0f / 3.0f);
}

// The same for one that holds rotations, too: the other body turns with its own as if it were a part of it.
inline F weight_as_one(const JointEnd& own, const JointEnd& other, V3 center_offset) {
  const S3 lever = lever_response(center_offset, own.mass.inverse_inertia);
  const S3 inertia = invert_semidefinite(other.mass.inverse_inertia);
  return trace(lever) * (F(1.0f / 3.0f) * invert_positive(other.mass.inverse_mass)) +
         trace(inertia, own.mass.inverse_inertia) * F(1.0f / 3.0f);
}

// Parts of a body for one of its `joints`, of which `at_once` are solved at once. One with what cannot be
// pushed needs none: what it does is not undone by others.
inline F parts_of(F joints, float at_once, const JointEnd& other, F weight) {
  const F least(at_once), one(1.0f);
  const F parts = F(0.5f) * (joints + least) - one - invert_positive(weight);
  return select(other.mass.inverse_mass > F(0.0f), max(least, parts), least);
}

// `is_fixed`: the joints of bodies that cannot be pushed are not counted.
inline F load_counts(const JointArgs& args, const std::int32_t* row, bool is_fixed) {
  if (is_fixed) return F(0.0f);
  alignas(64) LaneFloats counts;
  for (int lane = 0; lane < kLanes; ++lane) counts[lane] = static_cast<float>(args.joint_count[row[lane]]);
  return load(counts);
}

inline JointEnd end_of(const BodyMass& mass, V3 arm) {
  S3 response = lever_response(arm, mass.inverse_inertia);
  response.xx += mass.inverse_mass;
  response.yy += mass.inverse_mass;
  response.zz += mass.inverse_mass;
  return {mass, response};
}

// A kind of joint that holds no rotation says so by a member kLeavesTurns that is true.
template <class Kind>
inline constexpr bool kHoldsTurns = !requires {
  requires Kind::kLeavesTurns;
};

// Fewer joints than this do not share a body, unless they are solved at once: parts_of() is 1.
constexpr float kFewestSharers = 4.0f;

// How many parts the bodies of a block have.
struct Parts {
  F a, b;
};

template <class Kind>
inline Parts measure_parts(const ConstraintChunk& chunk, int first_lane, const JointEnd& a, const JointEnd& b,
                           F joints_a, F joints_b, V3 center_offset) {
  F weight_of_a = weight_at_anchor(b, a), weight_of_b = weight_at_anchor(a, b);
  if constexpr (kHoldsTurns<Kind>) {
    weight_of_a = max(weight_of_a, weight_as_one(b, a, center_offset));
    weight_of_b = max(weight_of_b, weight_as_one(a, b, center_offset));
  }
  const auto group = static_cast<float>(hub_group_size(chunk, first_lane));
  return {parts_of(joints_a, chunk.hub == BodySide::a ? group : 1.0f, b, weight_of_b),
          parts_of(joints_b, chunk.hub == BodySide::b ? group : 1.0f, a, weight_of_a)};
}

// Divides the bodies of a block that is being prepared. Returns whether any has parts.
template <class Kind>
inline bool divide_bodies(const JointArgs& args, const ConstraintChunk& chunk, const std::int32_t* row_a,
                          const std::int32_t* row_b, int first_lane, const JointPlacement& at,
                          JointBodyLanes& bodies) {
  const F one(1.0f), few(kFewestSharers);
  store(args.parts_a + first_lane, one);
  store(args.parts_b + first_lane, one);
  const F joints_a = load_counts(args, row_a, chunk.fixed == BodySide::a),
          joints_b = load_counts(args, row_b, chunk.fixed == BodySide::b);
  if (chunk.hub == BodySide::none && bits((joints_a >= few) | (joints_b >= few)) == 0) return false;
  const JointEnd a = end_of(bodies.mass_a, at.arm_a), b = end_of(bodies.mass_b, at.arm_b);
  const Parts parts = measure_parts<Kind>(chunk, first_lane, a, b, joints_a, joints_b, at.center_offset);
  const M divided = (parts.a > one) | (parts.b > one);
  if (bits(divided) == 0) return false;
  store(args.parts_a + first_lane, parts.a);
  store(args.parts_b + first_lane, parts.b);
  // Springs are as stiff as they are at whole bodies.
  const F whole = trace(a.response) + trace(b.response);
  const F in_parts = trace(a.response) * parts.a + trace(b.response) * parts.b;
  bodies.spring_scale = sqrt(select(divided, in_parts * invert_positive(whole), one));
  bodies.max_hertz = select(divided, F(args.max_hertz_shared), bodies.max_hertz);
  bodies.mass_a = split(a.mass, parts.a);
  bodies.mass_b = split(b.mass, parts.b);
  return true;
}

inline JointBodyLanes load_bodies(const JointArgs& args, const std::int32_t* row_a,
                                  const std::int32_t* row_b) {
  return {load_velocity(args.velocity, row_a),
          load_velocity(args.velocity, row_b),
          load_mass(args.inertia, row_a),
          load_mass(args.inertia, row_b),
          F(args.max_hertz),
          F(1.0f)};
}

// The same as parts, where any joint of the chunk has some.
inline JointBodyLanes load_parts(const JointArgs& args, bool shared, const std::int32_t* row_a,
                                 const std::int32_t* row_b, int first_lane) {
  JointBodyLanes bodies = load_bodies(args, row_a, row_b);
  if (shared) {
    bodies.mass_a = split(bodies.mass_a, load(args.parts_a + first_lane));
    bodies.mass_b = split(bodies.mass_b, load(args.parts_b + first_lane));
  }
  return bodies;
}

// The rows of a block's bodies before they are written. Rare, as is all with parts: kept out of the sweeps.
struct RowsBefore {
  VelocityRow a[kLanes], b[kLanes];
};
[[gnu::noinline]] inline void keep_rows(const JointArgs& args, const std::int32_t* row_a,
                                        const std::int32_t* row_b, int count, RowsBefore& before) {
  for (int lane = 0; lane < count; ++lane) {
    before.a[lane] = args.velocity[row_a[lane]];
    before.b[lane] = args.velocity[row_b[lane]];
  }
}

// The velocity of a whole body after its part has been pushed.
inline void join_row(const VelocityRow& before, float parts, VelocityRow& row) {
  if (!(parts > 1.0f)) return;
  const float share = 1.0f / parts;
  for (int i = 0; i < 3; ++i) {
    row.linear[i] = before.linear[i] + (row.linear[i] - before.linear[i]) * share;
    row.angular[i] = before.angular[i] + (row.angular[i] - before.angular[i]) * share;
  }
}

// After parts were written as if they were whole bodies; HubSum does it for hubs.
[[gnu::noinline]] inline void join_rows(const JointArgs& args, const ConstraintChunk& chunk,
                                        const std::int32_t* row_a, const std::int32_t* row_b, int count,
                                        int first_lane, const RowsBefore& before) {
  for (int lane = 0; lane < count; ++lane) {
    if (chunk.fixed != BodySide::a && chunk.hub != BodySide::a)
      join_row(before.a[lane], args.parts_a[first_lane + lane], args.velocity[row_a[lane]]);
    if (chunk.fixed != BodySide::b && chunk.hub != BodySide::b)
      join_row(before.b[lane], args.parts_b[first_lane + lane], args.velocity[row_b[lane]]);
  }
}

// Writes the velocities of the bodies that can be pushed.
inline void store_bodies(const JointArgs& args, const ConstraintChunk& chunk, bool shared,
                         const std::int32_t* row_a, const std::int32_t* row_b, int count, int first_lane,
                         const JointBodyLanes& bodies, HubSum& hub) {
  RowsBefore before;
  if (shared) keep_rows(args, row_a, row_b, count, before);
  if (chunk.fixed != BodySide::a) {
    if (chunk.hub == BodySide::a) {
      hub.add(row_a, count, first_lane, bodies.a, args.parts_a + first_lane);
    } else {
      store_velocity(args.velocity, row_a, count, bodies.a);
    }
  }
  if (chunk.fixed != BodySide::b) {
    if (chunk.hub == BodySide::b) {
      hub.add(row_b, count, first_lane, bodies.b, args.parts_b + first_lane);
    } else {
      store_velocity(args.velocity, row_b, count, bodies.b);
    }
  }
  if (shared) join_rows(args, chunk, row_a, row_b, count, first_lane, before);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
