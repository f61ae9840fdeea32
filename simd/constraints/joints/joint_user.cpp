// User joints: rows that the caller states, see scree/user_joint.h.
//
// Held rows are one block, as in joint_rows.h, and are solved last; each of the others is solved by itself
// before them, in their order. Rows are those of the step's beginning: with Jacobians that stay, what a
// substep inherits need not be turned.
#include <simd/constraints/joints/joint_rows.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// Rows that answer an impulse of 1 N s by less count as zero: its inverse must be a float.
constexpr float kLeastResponse = 1e-36f;

// A row as its joint's numbers have it.
struct GivenRow {
  Row row;
  F error, speed, hertz, damping_ratio, lower, upper;
};

// Where the numbers of the joints stand, and which joints are frozen.
struct UserPlaces {
  alignas(64) LaneInts place;
  M frozen;
};

inline UserPlaces find_numbers(const JointArgs& args, const std::int32_t* joint) {
  UserPlaces at;
  alignas(64) LaneFloats frozen;
  for (int lane = 0; lane < kLanes; ++lane) {
    at.place[lane] = args.user[joint[lane]];
    frozen[lane] = args.user_state[at.place[lane]] != kUserActs ? 1.0f : 0.0f;
  }
  at.frozen = load(frozen) > F(0.0f);
  return at;
}

template <int kRows>
inline void load_kinds(const JointArgs& args, const std::int32_t* joint, I (&kind)[kRows]) {
  constexpr int kStride = sizeof(JointParameters) / sizeof(float);
  F words[8];
  for (int group = 0; group < 2; ++group) {
    F* const w = words + 4 * group;
    load_rows(&args.parameters->axis[0].lower + 4 * group, kStride, joint, w[0], w[1], w[2], w[3]);
  }
  for (int i = 0; i < kRows; ++i) kind[i] = as_int(words[i]);
}

template <int kRows>
inline void load_numbers(const JointArgs& args, const UserPlaces& at, GivenRow (&given)[kRows]) {
  constexpr int kJacobians = sizeof(UserJacobians) / sizeof(float);
  constexpr int kTargets = sizeof(UserTargets) / sizeof(float);
  constexpr int kBounds = sizeof(UserBounds) / sizeof(float);
  for (int i = 0; i < kRows; ++i) {
    auto& [linear_a, angular_a, linear_b, angular_b] = given[i].row;
    const float* base = args.user_jacobians->row[i];
    load_rows(base, kJacobians, at.place, linear_a.x, linear_a.y, linear_a.z, angular_a.x);
    load_rows(base + 4, kJacobians, at.place, angular_a.y, angular_a.z, linear_b.x, linear_b.y);
    load_rows(base + 8, kJacobians, at.place, linear_b.z, angular_b.x, angular_b.y, angular_b.z);
    load_rows(args.user_targets->row[i], kTargets, at.place, given[i].error, given[i].speed, given[i].hertz,
              given[i].damping_ratio);
  }
  for (int i = 0; i < kUserRows; i += 2) {
    F bounds[4];
    load_rows(args.user_bounds->row[i], kBounds, at.place, bounds[0], bounds[1], bounds[2], bounds[3]);
    for (int k = 0; k < 2; ++k) {
      if (i + k >= kRows) break;
      given[i + k].lower = bounds[2 * k];
      given[i + k].upper = bounds[2 * k + 1];
    }
  }
}

// The motion of both bodies as rows meet it: displacements and rotation vectors.
inline Row motion_of(const WideDelta& a, const WideDelta& b) {
  return {a.position, rotation_vector(a.rotation), b.position, rotation_vector(b.rotation)};
}

inline Row choose(M which, const Row& yes, const Row& no) {
  return {select(which, yes.linear_a, no.linear_a), select(which, yes.angular_a, no.angular_a),
          select(which, yes.linear_b, no.linear_b), select(which, yes.angular_b, no.angular_b)};
}

// What rows have that are solved by themselves.
template <int kRows, bool kRich>
struct OwnRows {};
template <int kRows>
struct OwnRows<kRows, true> {
  LaneInts kind[kRows];
  LaneFloats mass[kRows];                // inverse of the row's response
  LaneFloats least[kRows], most[kRows];  // impulse in a substep
  LaneSoftness soft[kRows];              // a motor is rigid
};

template <int kRows, bool kRich>
struct alignas(64) UserBlock {
  LaneInts row_a, row_b;
  LaneFloats arm_b[3];
  HeldLanes<kRows> held;          // the rows, errors and impulses of all kinds; the rest of held ones
  LaneFloats first_error[kRows];  // where the step begins
  LaneFloats speed[kRows];
  OwnRows<kRows, kRich> own;
};

// A row that is solved by itself as solve_limit() knows it: with one end, at 0.
struct OneEnd {
  alignas(64) LaneFloats lower, upper, limit_impulse;
};

// States the rows as they are now: those that are solved by themselves, then the held ones.
void state_user_rows(const JointArgs& args, const ConstraintChunk& chunk, ConstraintRows* rows) {
  static_assert(2 * kUserRows <= kMaxConstraintRows);
  for (int lane = 0; lane < chunk.lanes; lane += kLanes) {
    const int count = chunk.lanes - lane < kLanes ? chunk.lanes - lane : kLanes;
    const std::int32_t* joint = args.rows + chunk.first_lane + lane;
    alignas(64) LaneInts row_a, row_b;
    load_placement(args, joint, row_a, row_b);
    const UserPlaces places = find_numbers(args, joint);
    GivenRow given[kUserRows];
    I kind[kUserRows];
    load_numbers(args, places, given);
    load_kinds(args, joint, kind);
    F impulse[8];
    for (int i = 0; i < 8; i += 4) {
      load_impulses(args, joint, i / 4, impulse[i], impulse[i + 1], impulse[i + 2], impulse[i + 3]);
    }
    const WideStiffness stiffness = load_stiffness(args, joint);
    const Row motion = motion_of(load_delta(args.delta, row_a), load_delta(args.delta, row_b));
    Statement to(rows, chunk.first_lane + lane, count);
    const I none = number(kRowNone);
    RowStatement said[kUserRows];
    M is_held[kUserRows];
    for (int i = 0; i < kUserRows; ++i) {
      const M held = kind[i] == number(kUserHeld), limit = kind[i] == number(kUserLimit),
              motor = kind[i] == number(kUserMotor), spring = kind[i] == number(kUserSpring);
      const M acts = (dot(given[i].row, given[i].row) > F(0.0f)) & !places.frozen;
      const F error = given[i].error + dot(given[i].row, motion) - given[i].speed * F(args.elapsed);
      is_held[i] = held & acts;
      said[i].row = given[i].row;
      said[i].kind =
          select(limit & acts, number(kRowLimit),
                 select(motor & acts, number(kRowMotor), select(spring & acts, number(kRowSpring), none)));
      said[i].error = select(motor, F(0.0f), error);
      said[i].target_speed = given[i].speed;
      said[i].lower = select(limit, F(0.0f), given[i].lower);
      said[i].upper = given[i].upper;
      said[i].hertz = select(spring, given[i].hertz, select(motor, F(0.0f), stiffness.hertz));
      said[i].damping_ratio = select(spring, given[i].damping_ratio, stiffness.damping_ratio);
      said[i].impulse = impulse[i];
      said[i].block = number(kHeldBlock + 1 + static_cast<std::uint32_t>(i));
      to.add(said[i]);
    }
    for (int i = 0; i < kUserRows; ++i) {
      said[i].kind = select(is_held[i], number(kRowHeld), none);
      said[i].block = number(kHeldBlock);
      said[i].lower = F(-kInfinity);
      said[i].upper = F(kInfinity);
      to.add(said[i]);
    }
    to.leave_rest_empty();
  }
}

template <int kRows, bool kRich>
struct UserKernels {
  using Block = UserBlock<kRows, kRich>;

  static void prepare(const JointArgs& args, const std::int32_t* joint, const JointBodyLanes& bodies,
                      const JointPlacement& at, Block& block) {
    const UserPlaces places = find_numbers(args, joint);
    GivenRow given[kRows];
    load_numbers(args, places, given);
    const F zero(0.0f), one(1.0f);
    const WideStiffness stiffness = load_stiffness(args, joint);
    const Softness soft = soften_held(args, bodies, stiffness.hertz, stiffness.damping_ratio);
    store_softness(block.held.soft, soft);
    store_softness(block.held.relaxed, relax_held(soft, stiffness.hertz));
    store3(block.arm_b, at.arm_b);
    F impulse[8];
    for (int i = 0; i < 8; i += 4) {
      load_impulses(args, joint, i / 4, impulse[i], impulse[i + 1], impulse[i + 2], impulse[i + 3]);
    }
    for (int i = 0; i < kRows; ++i) {
      const F response = dot(given[i].row, row_push(given[i].row, bodies));
      const M acts = (response >= F(kLeastResponse)) & (response < F(kInfinity)) & !places.frozen;
      store_row(block.held.row[i], choose(acts, given[i].row, zero_row()));
      store(block.held.error[i], given[i].error);
      store(block.held.impulse[i], impulse[i] * F(args.warm_start_scale));
      store(block.first_error[i], given[i].error);
      store(block.speed[i], given[i].speed);
    }
    if constexpr (kRich) {
      I kind[kRows];
      load_kinds(args, joint, kind);
      for (int i = 0; i < kRows; ++i) {
        const M spring = kind[i] == number(kUserSpring), limit = kind[i] == number(kUserLimit);
        const Softness own = soften(args, bodies, given[i].hertz, given[i].damping_ratio);
        store(block.own.kind[i], kind[i]);
        store(block.own.least[i], select(limit, zero, given[i].lower * F(args.substep)));
        store(block.own.most[i], given[i].upper * F(args.substep));
        store_softness(block.own.soft[i],
                       {select(spring, own.bias_rate, zero), select(spring, own.mass_scale, one),
                        select(spring, own.impulse_scale, zero)});
      }
    }
    measure_responses(bodies, block);
  }

  static void warm_start(const Block& block, JointBodyLanes& bodies) {
    push_row(bodies, sum(block), F(1.0f));
  }
  static void solve(const JointArgs& args, Block& block, JointBodyLanes& bodies) {
    run(args, block, bodies, load_softness(block.held.soft), F(args.impulse_keep));
  }
  static F relax(const JointArgs& args, Block& block, const WideDelta& delta_a, const WideDelta& delta_b,
                 JointBodyLanes& bodies) {
    const Row motion = motion_of(delta_a, delta_b);
    for (int i = 0; i < kRows; ++i) {
      store(block.held.error[i], load(block.first_error[i]) + dot(load_row(block.held.row[i]), motion) -
                                     load(block.speed[i]) * F(args.elapsed));
    }
    measure_responses(bodies, block);
    return run(args, block, bodies, load_softness(block.held.relaxed), F(1.0f));
  }
  static JointImpulse acting(const Block& block) {
    const Row all = sum(block);
    return {all.linear_b, all.angular_b - cross(load3(block.arm_b), all.linear_b)};
  }
  static void store(const JointArgs& args, const std::int32_t* joint, int count, const Block& block) {
    const F zero(0.0f);
    F impulse[kJointImpulses], differences(0.0f);  // as in is_finite
    for (F& each : impulse) each = zero;
    for (int i = 0; i < kRows; ++i) {
      impulse[i] = load(block.held.impulse[i]);
      differences += impulse[i] - impulse[i];
    }
    const JointImpulse all = acting(block);
    const M finite = (differences == zero) & is_finite(all.linear) & is_finite(all.angular);
    for (F& each : impulse) each = select(finite, each, zero);
    for (int i = 0; i < kJointImpulses; i += 4) {
      store_impulses(args, joint, count, i / 4, impulse[i], impulse[i + 1], impulse[i + 2], impulse[i + 3]);
    }
  }

 private:
  // Beside the sweep of this name.
  static void store(LaneFloats& to, F value) { simd::SCREE_SIMD_NAMESPACE::store(to, value); }
  static void store(LaneInts& to, I value) { simd::SCREE_SIMD_NAMESPACE::store(to, value); }

  static Row sum(const Block& block) {
    Row all = zero_row();
    for (int i = 0; i < kRows; ++i) {
      all = all + load_row(block.held.row[i]) * load(block.held.impulse[i]);
    }
    return all;
  }
  // Inertia turns with the bodies, if the rows do not.
  static void measure_responses(const JointBodyLanes& bodies, Block& block) {
    Row held[kRows];
    for (int i = 0; i < kRows; ++i) {
      held[i] = load_row(block.held.row[i]);
      if constexpr (kRich) {
        store(block.own.mass[i], invert_positive(dot(held[i], row_push(held[i], bodies))));
        held[i] = choose(is_held(block, i), held[i], zero_row());
      }
    }
    factor_held(block.held, held, bodies);
  }
  static M is_held(const Block& block, int row) {
    if constexpr (kRich) return load(block.own.kind[row]) == number(kUserHeld);
    return F(0.0f) == F(0.0f);
  }

  static F run(const JointArgs& args, Block& block, JointBodyLanes& bodies, const Softness& held, F keep) {
    if constexpr (kRich) {
      for (int i = 0; i < kRows; ++i) solve_own(args, block, i, bodies, held, keep);
    }
    return solve_held_rows(block, bodies, held, keep);
  }

  // A limit, a motor or a spring; no other row.
  static void solve_own(const JointArgs& args, Block& block, int i, JointBodyLanes& bodies,
                        const Softness& held, F keep) {
    const Row row = load_row(block.held.row[i]);
    const I kind = load(block.own.kind[i]);
    const M limit = kind == number(kUserLimit), motor = kind == number(kUserMotor),
            spring = kind == number(kUserSpring);
    const F mass = load(block.own.mass[i]), least = load(block.own.least[i]), most = load(block.own.most[i]);
    const F stored = load(block.held.impulse[i]), old_impulse = stored * keep;
    const F speed = row_speed(row, bodies) - load(block.speed[i]), error = load(block.held.error[i]);
    const Softness soft = load_softness(block.own.soft[i]);
    const F free = old_impulse - mass * (soft.mass_scale * (speed + soft.bias_rate * error)) -
                   soft.impulse_scale * old_impulse;
    OneEnd end;
    store(end.lower, F(0.0f));
    store(end.upper, F(kInfinity));
    store(end.limit_impulse, stored);
    solve_limit(args, Course::line, end, error, speed, mass, held, keep);
    const F impulse = clamp(select(limit, load(end.limit_impulse), free), least, most);
    const M acts = limit | motor | spring;
    store(block.held.impulse[i], select(acts, impulse, stored));
    push_row(bodies, row, select(acts, impulse - old_impulse, F(0.0f)));
  }

  // Returns the largest speed that it met.
  static F solve_held_rows(Block& block, JointBodyLanes& bodies, const Softness& soft, F keep) {
    HeldLanes<kRows>& held = block.held;
    F change[kRows], worst(0.0f);
    for (int i = 0; i < kRows; ++i) {
      const F speed = row_speed(load_row(held.row[i]), bodies) - load(block.speed[i]);
      const F wanted = (speed + load(held.error[i]) * soft.bias_rate) * soft.mass_scale;
      change[i] = select(is_held(block, i), wanted, F(0.0f));
      worst = max(select(is_held(block, i), abs(speed), F(0.0f)), worst);
    }
    divide_held(held, change);
    Row push = zero_row();
    for (int i = 0; i < kRows; ++i) {
      const F stored = load(held.impulse[i]), old_impulse = stored * keep;
      const F impulse = old_impulse - (change[i] + old_impulse * soft.impulse_scale);
      store(held.impulse[i], select(is_held(block, i), impulse, stored));
      push = push + load_row(held.row[i]) * select(is_held(block, i), impulse - old_impulse, F(0.0f));
    }
    push_row(bodies, push, F(1.0f));
    return worst;
  }
};

template <int kRows, bool kRich>
JointVariantKernels make_user_kernels() {
  using Kind = UserKernels<kRows, kRich>;
  return {sizeof(typename Kind::Block), false,
          prepare_joints<Kind>,         warm_start_joints<Kind>,
          solve_joints<Kind>,           relax_joints<Kind>,
          relax_measured_joints<Kind>,  store_joints<Kind>,
          note_peaks_joints<Kind>,      state_user_rows};
}

}  // namespace

template <>
JointTypeKernels make_joint_type_kernels<JointType::user>() {
  return {make_user_kernels<kPlainUserRows, false>(), make_user_kernels<kUserRows, true>()};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
