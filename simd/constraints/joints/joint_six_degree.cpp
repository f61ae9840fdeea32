// Joints of six degrees of freedom; see simd/constraints/joints/joint_kernels.h.
//
// Rows 0 to 2 are the angles, 3 to 5 the offsets. Those that are held are solved as one, whichever they are.
// A free one is solved with the held ones held: an impulse along it brings along those that keep them.
#include <simd/constraints/joints/joint_linear.h>
#include <simd/constraints/joints/joint_sweeps.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

constexpr int kRows = 6, kAngles = 3;
constexpr int axis_of(int row) { return (row + 3) % kRows; }  // its number in JointParameters

using SixRows = F[kRows];
using SixMatrix = F[kRows][kRows];

struct alignas(64) SixDegreeBlock {
  LaneInts row_a, row_b;
  PlacedLanes first;
  LaneFloats lever_a[3], lever_b[3];  // now; both lead to anchor b
  LaneFloats way[kRows][3];           // what a unit impulse is: a torque impulse, or an impulse at the levers
  LaneFloats coordinate[kRows];
  LaneFloats held[kRows];  // 1 where held, else 0
  LaneFloats target[kRows];
  LaneFloats held_impulse[kRows];
  LaneFloats held_mass[kRows][kRows];  // inverse response of the held rows, zero elsewhere
  LaneFloats hold[kRows][kRows];       // by free row: impulses on the held ones that keep them
  // Of free rows: alone, and with the held ones held; the latter 0 where these leave nothing.
  LaneFloats response_alone[kRows], response_held[kRows];
  LaneAxis axis[kRows];  // of free rows
  TurnedLanes turned;
  LaneSoftness softness, relaxed;
};

inline Wrench wrench_of(const SixDegreeBlock& block) {
  const F zero(0.0f);
  Wrench wrench{load3(block.lever_a), load3(block.lever_b), {zero, zero, zero}, {zero, zero, zero}};
  for (int row = 0; row < kRows; ++row) {
    const F impulse = load(block.held_impulse[row]) + load(block.axis[row].limit_impulse) +
                      load(block.axis[row].drive_impulse);
    V3& sum = row < kAngles ? wrench.torque : wrench.impulse;
    sum = sum + load3(block.way[row]) * impulse;
  }
  return wrench;
}

// rad^2: below this two terms of c's series are exact up to rounding, and the cotangent is not.
constexpr float kSeriesSquare = 0.01f;

// The rotation vector r of frame b in frame a, and the torques by which it is turned: its rate is a multiple
// of the angular velocity, I - [r] / 2 + c [r]^2 with c = (1 - (|r| / 2) cot(|r| / 2)) / |r|^2.
inline void place_angles(const Frames& frames, const M3& axes, V3 (&way)[kRows], SixRows& coordinate) {
  const F half(0.5f), one(1.0f);
  const Q4 q = conjugate(frames.a) * frames.b;
  const V3 r = rotation_vector(q);
  const F square = length_squared(r);
  const F sine = length(V3{q.x, q.y, q.z});
  const M small = square < F(kSeriesSquare);
  const F safe_square = select(small, one, square);
  const F cotangent = abs(q.w) / select(small, one, sine);
  const F c = select(small, F(1.0f / 12.0f) + square * F(1.0f / 720.0f),
                     (one - half * sqrt(safe_square) * cotangent) / safe_square);
  const V3 turned = axes * r;
  const V3 axis[3] = {axes.x, axes.y, axes.z};
  const F parts[3] = {r.x, r.y, r.z};
  for (int i = 0; i < kAngles; ++i) {
    coordinate[i] = parts[i];
    way[i] = axis[i] * (one - c * square) + turned * (c * parts[i]) + cross(turned, axis[i]) * half;
  }
}

// With d the way from anchor a to anchor b, which is also where forces act on a, the offsets are x_a . d, y_a
// . d and z_a . d, J = [-x_a, -(r_a + d) x x_a, x_a, r_b x x_a]. The angles are those of place_angles(),
// whose rows are the inverse of the left Jacobian of SO(3) seen from frame a (Chirikjian, "Stochastic Models,
// Information Theory, and Lie Groups", volume 2, 2011). As PhysX's D6 joint, which has swing and twist
// instead.
struct SixDegreeRows : FramedShape {
  static constexpr int kAxes = kRows;
  static constexpr bool kKeepsHeld = true, kHoldsEqualEnds = true;
  static constexpr AxisUnit unit(int row) { return row < kAngles ? AxisUnit::angle : AxisUnit::length; }
  static void measure(const Lanes& lanes, const WideDelta& delta_a, const WideDelta& delta_b,
                      RowsNow<SixDegreeRows>& now) {
    const auto [anchors, frames] = move_placed(lanes, delta_a, delta_b);
    const M3 axes = to_matrix(frames.a);
    V3 way[kRows] = {{}, {}, {}, axes.x, axes.y, axes.z};
    place_angles(frames, axes, way, now.coordinate);
    for (int row = 0; row < kAngles; ++row) now.axis[row] = turn_row(way[row]);
    for (int row = kAngles; row < kRows; ++row) {
      now.axis[row] = offset_row(way[row], anchors.arm_a, anchors.arm_b, anchors.offset);
      now.coordinate[row] = dot(way[row], anchors.offset);
    }
    now.arm_b = anchors.arm_b;
  }
  static WideAxis asked(const JointArgs& args, const std::int32_t* joint, int row, const Row&,
                        const JointBodyLanes&) {
    return load_axis(args, joint, axis_of(row));
  }
  static void impulses(const F (&stored)[kJointImpulses], const RowsNow<SixDegreeRows>&,
                       RowImpulses<SixDegreeRows>& along) {
    for (int row = 0; row < kRows; ++row) {
      along.limit[row] = stored[row];
      along.drive[row] = stored[kRows + row];
    }
  }
};

// J M^-1 J^T of all rows.
inline void respond(const JointBodyLanes& bodies, V3 lever_a, V3 lever_b, const V3 (&way)[kRows],
                    SixMatrix& k) {
  V3 turn_a[kRows], turn_b[kRows];
  for (int row = 0; row < kRows; ++row) {
    turn_a[row] = row < kAngles ? way[row] : cross(lever_a, way[row]);
    turn_b[row] = row < kAngles ? way[row] : cross(lever_b, way[row]);
  }
  const F inverse_mass = bodies.mass_a.inverse_mass + bodies.mass_b.inverse_mass;
  for (int row = 0; row < kRows; ++row) {
    const V3 by_a = bodies.mass_a.inverse_inertia * turn_a[row];
    const V3 by_b = bodies.mass_b.inverse_inertia * turn_b[row];
    for (int other = 0; other <= row; ++other) {
      F value = dot(turn_a[other], by_a) + dot(turn_b[other], by_b);
      if (row == other && row >= kAngles) value += inverse_mass;
      k[row][other] = k[other][row] = value;
    }
  }
}

// What elimination leaves of a diagonal entry is rounding below this part of it: the row depends on others,
// because of locks of axes, and is dropped.
constexpr float kLeastResponse = 5e-7f;

// Inverse of the rows and columns for which `held` is 1; the others of the result are zero. K = L D L^T.
inline void invert_held(const SixMatrix& k, const SixRows& held, SixMatrix& inverse) {
  const F zero(0.0f), one(1.0f);
  SixMatrix lower, scaled;  // L below its diagonal of ones, and L D
  SixRows inverse_pivot;
  for (int j = 0; j < kRows; ++j) {
    const F diagonal = k[j][j] * held[j];
    F pivot = diagonal;
    for (int m = 0; m < j; ++m) pivot -= lower[j][m] * scaled[j][m];
    const M present = pivot > F(kLeastResponse) * diagonal;
    inverse_pivot[j] = select(present, one / select(present, pivot, one), zero);
    for (int i = j + 1; i < kRows; ++i) {
      F value = k[i][j] * (held[i] * held[j]);
      for (int m = 0; m < j; ++m) value -= lower[i][m] * scaled[j][m];
      lower[i][j] = value * inverse_pivot[j];
      scaled[i][j] = select(present, value, zero);
    }
  }
  SixMatrix n;  // L^-1 below its diagonal
  for (int i = 1; i < kRows; ++i) {
    for (int j = 0; j < i; ++j) {
      F value = lower[i][j];
      for (int m = j + 1; m < i; ++m) value += lower[i][m] * n[m][j];
      n[i][j] = -value;
    }
  }
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j <= i; ++j) {
      F value = inverse_pivot[i] * (j == i ? one : n[i][j]);
      for (int m = i + 1; m < kRows; ++m) value += n[m][i] * n[m][j] * inverse_pivot[m];
      inverse[i][j] = inverse[j][i] = value;
    }
  }
}

inline void place(const JointBodyLanes& bodies, const Placed& now, SixDegreeBlock& block) {
  const F zero(0.0f);
  const V3 offset = now.anchors.offset, lever_a = now.anchors.arm_a + offset, lever_b = now.anchors.arm_b;
  const M3 axes = to_matrix(now.frames.a);
  V3 way[kRows];
  SixRows coordinate, held;
  place_angles(now.frames, axes, way, coordinate);
  way[3] = axes.x;
  way[4] = axes.y;
  way[5] = axes.z;
  for (int row = kAngles; row < kRows; ++row) coordinate[row] = dot(way[row], offset);
  for (int row = 0; row < kRows; ++row) held[row] = load(block.held[row]);
  SixMatrix response, held_mass;
  respond(bodies, lever_a, lever_b, way, response);
  invert_held(response, held, held_mass);
  store3(block.lever_a, lever_a);
  store3(block.lever_b, lever_b);
  for (int row = 0; row < kRows; ++row) {
    store3(block.way[row], way[row]);
    store(block.coordinate[row], coordinate[row]);
    F left = response[row][row];
    for (int other = 0; other < kRows; ++other) {
      store(block.held_mass[row][other], held_mass[row][other]);
      F hold = zero;
      for (int m = 0; m < kRows; ++m) hold -= held_mass[other][m] * response[m][row];
      store(block.hold[row][other], hold);
      left += hold * response[row][other];
    }
    const M free = (left > F(kLeastResponse) * response[row][row]) & (held[row] == zero);
    store(block.response_alone[row], response[row][row]);
    store(block.response_held[row], select(free, left, zero));
  }
}

// Where the rotation passes half a turn, its vector turns over, and with it the rows of the angles.
inline void turn_angles_over(const V3 (&old_way)[kAngles], SixDegreeBlock& block) {
  for (int row = 0; row < kAngles; ++row) {
    const F sign = select(dot(old_way[row], load3(block.way[row])) < F(0.0f), F(-1.0f), F(1.0f));
    LaneAxis& axis = block.axis[row];
    store(block.held_impulse[row], load(block.held_impulse[row]) * sign);
    store(axis.limit_impulse, load(axis.limit_impulse) * sign);
    store(axis.drive_impulse, load(axis.drive_impulse) * sign);
  }
}

// An angle's difference by the shorter way.
inline F shorter(int row, F difference) {
  if (row >= kAngles) return difference;
  const F half_turn(3.14159265f), whole_turn(6.28318531f), zero(0.0f);
  return difference - select(difference > half_turn, whole_turn, zero) +
         select(difference < -half_turn, whole_turn, zero);
}

struct SixVelocity {
  V3 anchor, spin;
};
inline SixVelocity velocity_of(const SixDegreeBlock& block, const JointBodyLanes& bodies) {
  return {anchor_velocity(bodies, load3(block.lever_a), load3(block.lever_b)), turning_speed(bodies)};
}
inline F speed_of(const SixDegreeBlock& block, int row, const SixVelocity& velocity) {
  return dot(load3(block.way[row]), row < kAngles ? velocity.spin : velocity.anchor);
}

inline void push_rows(const SixDegreeBlock& block, JointBodyLanes& bodies, const SixRows& impulse) {
  const F zero(0.0f);
  V3 linear{zero, zero, zero}, torque{zero, zero, zero};
  for (int row = 0; row < kRows; ++row) {
    V3& sum = row < kAngles ? torque : linear;
    sum = sum + load3(block.way[row]) * impulse[row];
  }
  push(bodies, load3(block.lever_a), load3(block.lever_b), linear);
  twist(bodies, torque);
}

// Returns the largest speed, of anchors or rotation, that was left in a held row.
inline F solve_held(SixDegreeBlock& block, JointBodyLanes& bodies, const Softness& soft, F keep) {
  const SixVelocity velocity = velocity_of(block, bodies);
  SixRows speed, change;
  F worst(0.0f);
  for (int row = 0; row < kRows; ++row) {
    const F now = speed_of(block, row, velocity);
    const F error = shorter(row, load(block.coordinate[row]) - load(block.target[row]));
    speed[row] = (now + error * soft.bias_rate) * soft.mass_scale;
    worst = max(abs(now) * load(block.held[row]), worst);
  }
  for (int row = 0; row < kRows; ++row) {
    const F old = load(block.held_impulse[row]) * keep;
    F stop = old * soft.impulse_scale;
    for (int other = 0; other < kRows; ++other) stop += load(block.held_mass[row][other]) * speed[other];
    store(block.held_impulse[row], old - stop);
    change[row] = -stop;
  }
  push_rows(block, bodies, change);
  return worst;
}

// An impulse along a free row, and as much of those that keep the held ones as they are as free_response()
// says.
inline void push_free(SixDegreeBlock& block, int row, JointBodyLanes& bodies, const Softness& held,
                      F impulse) {
  SixRows change;
  for (int other = 0; other < kRows; ++other) {
    const F hold = load(block.hold[row][other]) * (impulse * held.mass_scale);
    store(block.held_impulse[other], load(block.held_impulse[other]) + hold);
    change[other] = other == row ? hold + impulse : hold;
  }
  push_rows(block, bodies, change);
}

inline void solve_free(const JointArgs& args, const Softness& held, F keep, SixDegreeBlock& block,
                       JointBodyLanes& bodies) {
  const F zero(0.0f), one(1.0f);
  for (int row = 0; row < kRows; ++row) {
    LaneAxis& axis = block.axis[row];
    const F coordinate = load(block.coordinate[row]), left = load(block.response_held[row]);
    const F response = free_response(load(block.response_alone[row]), left, held);
    const M free = left > zero;
    const F mass = select(free, one / select(free, response, one), zero);
    const F error = shorter(row, coordinate - target_now(args, axis));
    F speed = speed_of(block, row, velocity_of(block, bodies));
    push_free(block, row, bodies, held, solve_drive(axis, error, speed, mass, keep));
    speed = speed_of(block, row, velocity_of(block, bodies));
    const bool is_angle = row < kAngles;
    const F within = is_angle ? angle_within(coordinate, load(axis.lower), load(axis.upper)) : coordinate;
    push_free(
        block, row, bodies, held,
        solve_limit(args, is_angle ? Course::circle : Course::line, axis, within, speed, mass, held, keep));
  }
}

// What an axis with equal limits asks for is held; its impulse is that of its limit.
inline void take_held(SixDegreeBlock& block, int row) {
  LaneAxis& axis = block.axis[row];
  const F zero(0.0f), one(1.0f), none(__builtin_inff());
  const F lower = load(axis.lower), upper = load(axis.upper), impulse = load(axis.limit_impulse);
  const M held = lower == upper;
  store(block.held[row], select(held, one, zero));
  store(block.target[row], select(held, lower, zero));
  store(block.held_impulse[row], select(held, impulse, zero));
  store(axis.limit_impulse, select(held, zero, impulse));
  store(axis.lower, select(held, -none, lower));
  store(axis.upper, select(held, none, upper));
  store(axis.max_impulse, select(held, zero, load(axis.max_impulse)));
  store(axis.drive_impulse, select(held, zero, load(axis.drive_impulse)));
}

// Impulses: 0 to 5 of what holds or limits the rows, 6 to 11 of their drives.
struct SixDegree {
  using Rows = SixDegreeRows;
  using Block = SixDegreeBlock;

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    F impulse[2 * kRows];
    for (int group = 0; group < 3; ++group) {
      F* four = impulse + 4 * group;
      load_impulses(args, joint, group, four[0], four[1], four[2], four[3]);
    }
    for (int row = 0; row < kRows; ++row) {
      prepare_axis(args, bodies, load_axis(args, joint, axis_of(row)), impulse[row], impulse[kRows + row],
                   block.axis[row]);
      take_held(block, row);
    }
    place(bodies, store_placed(at, block.first), block);
    clear_turned(block.turned);
    const WideStiffness given = load_stiffness(args, joint);
    const Softness soft = soften_held(args, bodies, given.hertz, given.damping_ratio);
    store_softness(block.softness, soft);
    store_softness(block.relaxed, relax_held(soft, given.hertz));
  }
  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push_wrench(wrench_of(block), bodies);
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    const F keep(args.impulse_keep);
    const Softness soft = load_softness(block.softness);
    push_turned(block.turned, bodies, keep);
    solve_held(block, bodies, soft, keep);
    solve_free(args, soft, keep, block, bodies);
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Wrench before = wrench_of(block);
    const V3 old_way[kAngles] = {load3(block.way[0]), load3(block.way[1]), load3(block.way[2])};
    place(bodies, move_placed(block.first, delta_a, delta_b), block);
    turn_angles_over(old_way, block);
    store_turned(before, wrench_of(block), block.turned);
    const Softness relaxed = load_softness(block.relaxed);
    const F error = solve_held(block, bodies, relaxed, F(1.0f));
    solve_free(args, relaxed, F(1.0f), block, bodies);
    return error;
  }
  static JointImpulse acting(const Block& block) { return acting_of(wrench_of(block)); }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    const Wrench wrench = wrench_of(block);
    // A non-finite impulse would make its bodies non-finite again.
    const M finite = is_finite(wrench.impulse) & is_finite(wrench.torque);
    F impulse[2 * kRows];
    for (int row = 0; row < kRows; ++row) {
      const LaneAxis& axis = block.axis[row];
      impulse[row] = select(finite, load(block.held_impulse[row]) + load(axis.limit_impulse), zero);
      impulse[kRows + row] = select(finite, load(axis.drive_impulse), zero);
    }
    for (int group = 0; group < 3; ++group) {
      const F* four = impulse + 4 * group;
      store_impulses(args, joint, count, group, four[0], four[1], four[2], four[3]);
    }
  }
};

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::six_degree>() {
  const JointVariantKernels both = make_joint_kernels_of<SixDegree>();
  return {both, both};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
