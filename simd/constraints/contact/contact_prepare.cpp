// Contact blocks are made from manifolds here, and give their impulses back; see
// simd/constraints/contact/contact_kernels.h.
#include <simd/constraints/contact/contact_forces.h>
#include <simd/constraints/contact/contact_manifold.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The manifold's frame in numbers, and one body's share of its response to impulses: the products
// (c x f + q) . I^-1 (c x g + r) that the block's couplings are made of.
struct Frame {
  V3 normal, tangent1, tangent2;
};

struct Response {
  F normal_normal, normal_t1, normal_t2;      // c x n with itself and with torques about t1, t2
  F torque11, torque12, torque22;             // torques about t1, t2
  F twist, twist_normal, twist_t1, twist_t2;  // torque about n with itself, c x n, torques about t1, t2
  F push11, push12, push22;                   // c x t1, c x t2
  F push_normal[2], push_torque1[2], push_torque2[2], push_twist[2];
};

inline Response respond(const Frame& frame, V3 arm, const S3& inverse_inertia) {
  const V3 lever_n = cross(arm, frame.normal);
  const V3 lever_1 = cross(arm, frame.tangent1);
  const V3 lever_2 = cross(arm, frame.tangent2);
  const V3 spin_lever_n = inverse_inertia * lever_n;
  const V3 spin_n = inverse_inertia * frame.normal;
  const V3 spin_1 = inverse_inertia * frame.tangent1;
  const V3 spin_2 = inverse_inertia * frame.tangent2;
  const V3 spin_lever_1 = inverse_inertia * lever_1;
  Response r;
  r.normal_normal = dot(lever_n, spin_lever_n);
  r.normal_t1 = dot(lever_n, spin_1);
  r.normal_t2 = dot(lever_n, spin_2);
  r.torque11 = dot(frame.tangent1, spin_1);
  r.torque12 = dot(frame.tangent1, spin_2);
  r.torque22 = dot(frame.tangent2, spin_2);
  r.twist = dot(frame.normal, spin_n);
  r.twist_normal = dot(lever_n, spin_n);
  r.twist_t1 = dot(frame.tangent1, spin_n);
  r.twist_t2 = dot(frame.tangent2, spin_n);
  r.push11 = dot(lever_1, spin_lever_1);
  r.push12 = dot(lever_2, spin_lever_1);
  r.push22 = dot(lever_2, inverse_inertia * lever_2);
  r.push_normal[0] = dot(lever_1, spin_lever_n);
  r.push_normal[1] = dot(lever_2, spin_lever_n);
  r.push_torque1[0] = dot(lever_1, spin_1);
  r.push_torque1[1] = dot(lever_2, spin_1);
  r.push_torque2[0] = dot(lever_1, spin_2);
  r.push_torque2[1] = dot(lever_2, spin_2);
  r.push_twist[0] = dot(lever_1, spin_n);
  r.push_twist[1] = dot(lever_2, spin_n);
  return r;
}

inline void add(Response& r, const Response& other) {
  r.normal_normal += other.normal_normal;
  r.normal_t1 += other.normal_t1;
  r.normal_t2 += other.normal_t2;
  r.torque11 += other.torque11;
  r.torque12 += other.torque12;
  r.torque22 += other.torque22;
  r.twist += other.twist;
  r.twist_normal += other.twist_normal;
  r.twist_t1 += other.twist_t1;
  r.twist_t2 += other.twist_t2;
  r.push11 += other.push11;
  r.push12 += other.push12;
  r.push22 += other.push22;
  for (int i = 0; i < 2; ++i) {
    r.push_normal[i] += other.push_normal[i];
    r.push_torque1[i] += other.push_torque1[i];
    r.push_torque2[i] += other.push_torque2[i];
    r.push_twist[i] += other.push_twist[i];
  }
}

// The points' rows: A_kj = R(n, r_k x n; n, r_j x n) with r x n = v t1 - u t2.
template <int kPoints>
inline void store_points(ContactBlock<kPoints>& block, const Response& r, F inverse_mass, const F (&u)[4],
                         const F (&v)[4], const F (&separation)[4]) {
  const F zero(0.0f);
  const F base = inverse_mass + r.normal_normal;
  int pair = 0;
  for (int k = 0; k < kPoints; ++k) {
    store(block.u[k], u[k]);
    store(block.v[k], v[k]);
    store(block.radius[k], twist_arm(u[k], v[k], kPoints <= kTwistArm, v[kTwistArm]));
    store(block.initial_separation[k], separation[k]);
    store(block.separation[k], separation[k]);
    const F diagonal = base + F(2.0f) * (v[k] * r.normal_t1 - u[k] * r.normal_t2) + v[k] * v[k] * r.torque11 -
                       F(2.0f) * (u[k] * v[k] * r.torque12) + u[k] * u[k] * r.torque22;
    store(block.effective_mass[k], select(is_present(separation[k]), invert_positive(diagonal), zero));
    for (int j = k + 1; j < kPoints; ++j) {
      const F coupling = base + (v[k] + v[j]) * r.normal_t1 - (u[k] + u[j]) * r.normal_t2 +
                         v[k] * v[j] * r.torque11 - (u[k] * v[j] + v[k] * u[j]) * r.torque12 +
                         u[k] * u[j] * r.torque22;
      store(block.coupling[pair++], coupling);
    }
  }
}

template <int kPoints>
inline void store_friction(ContactBlock<kPoints>& block, const Response& r, F inverse_mass) {
  store(block.twist_mass, invert_positive(r.twist));
  store(block.twist_by_normal, r.twist_normal);
  store(block.twist_by_torque[0], r.twist_t1);
  store(block.twist_by_torque[1], r.twist_t2);
  for (int i = 0; i < 2; ++i) {
    store(block.tangent_by_normal[i], r.push_normal[i]);
    store(block.tangent_by_torque1[i], r.push_torque1[i]);
    store(block.tangent_by_torque2[i], r.push_torque2[i]);
    store(block.tangent_by_twist[i], r.push_twist[i]);
  }
  // Scaled to a trace of 1, as in invert().
  const F unit = invert_positive(inverse_mass + r.push11 + (inverse_mass + r.push22));
  const F k11 = unit * (inverse_mass + r.push11), k12 = unit * r.push12,
          k22 = unit * (inverse_mass + r.push22);
  // Rounding can spoil the determinant of a long lever's matrix; its true value is positive.
  const F determinant = max(k11 * k22 - k12 * k12, F(kLeastPivot) * (k11 * k22));
  const F inverse = unit * invert_positive(determinant);
  store(block.tangent_mass[0], inverse * k22);
  store(block.tangent_mass[1], -(inverse * k12));
  store(block.tangent_mass[2], inverse * k11);
}

template <int kPoints, bool kStatic>
inline void prepare_rich(const ContactArgs& args, RichBlock<kPoints>& block, const Frame& frame,
                         const std::int32_t* contact) {
  const WideSurface surface = load_surface(args, contact);
  store(block.restitution, surface.restitution);
  store(block.rolling_resistance, surface.rolling_resistance);
  store(block.surface_speed[0], dot(surface.velocity, frame.tangent1));
  store(block.surface_speed[1], dot(surface.velocity, frame.tangent2));
  store3(block.rolling_impulse, surface.rolling_impulse * F(args.warm_start_scale));
  S3 sum = load6(block.inverse_inertia_b);
  if constexpr (!kStatic) {
    const S3 a = load6(block.inverse_inertia_a);
    sum = {sum.xx + a.xx, sum.xy + a.xy, sum.xz + a.xz, sum.yy + a.yy, sum.yz + a.yz, sum.zz + a.zz};
  }
  store6(block.rolling_mass, invert_semidefinite(sum));
}

// Contacts of one body may be prepared at the same time, so the note is an atomic store.
inline void note_contacts(const ContactArgs& args, const std::int32_t* rows) {
  for (int lane = 0; lane < kLanes; ++lane) {
    __atomic_store_n(&args.step_notes[rows[lane]], std::uint8_t{1}, __ATOMIC_RELAXED);
  }
}

// Bytes [begin, end) of the manifolds of the next block of a chunk, if there is one.
template <Access kAccess>
inline void prefetch_manifolds(const ContactArgs& args, const ConstraintChunk& chunk, int first_lane,
                               std::size_t begin, std::size_t end) {
  const int next = first_lane + kLanes;
  if (next >= chunk.first_lane + chunk.blocks * kLanes) return;
  for (int lane = 0; lane < kLanes; ++lane) {
    prefetch<kAccess>(args.manifolds + args.rows[next + lane], begin, end);
  }
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void prepare_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  const F scale(args.warm_start_scale);
  for_each_block<Block>(args, chunk, [&](Block& block, int, int first_lane) {
    const std::int32_t* contact = args.rows + first_lane;
    prefetch<Access::write>(&block + 1, 0, sizeof(Block));
    prefetch_manifolds<Access::read>(args, chunk, first_lane, 0, sizeof(Manifold));
    const WideManifold m = load_manifold(args, contact);
    const V3 arm_a = m.arm_a, arm_b = m.arm_b;
    Frame frame;
    frame.normal = m.normal;
    frame.tangent1 = tangent_of(frame.normal);
    frame.tangent2 = cross(frame.normal, frame.tangent1);
    store(block.row_a, as_int(m.row_a));
    store(block.row_b, as_int(m.row_b));
    note_contacts(args, block.row_b);
    if constexpr (!kStatic) note_contacts(args, block.row_a);
    store3(block.normal, frame.normal);
    store3(block.arm_a, arm_a);
    store3(block.arm_b, arm_b);
    store(block.friction, m.friction);

    BodyMass b = load_mass(args.inertia, block.row_b);
    const F hub_parts(static_cast<float>(hub_group_size(chunk, first_lane)));
    if (chunk.hub == BodySide::b) b = split(b, hub_parts);
    store(block.inverse_mass_b, b.inverse_mass);
    store6(block.inverse_inertia_b, b.inverse_inertia);
    F inverse_mass = b.inverse_mass;
    Response response = respond(frame, arm_b, b.inverse_inertia);
    if constexpr (!kStatic) {
      BodyMass a = load_mass(args.inertia, block.row_a);
      if (chunk.hub == BodySide::a) a = split(a, hub_parts);
      store(block.inverse_mass_a, a.inverse_mass);
      store6(block.inverse_inertia_a, a.inverse_inertia);
      inverse_mass += a.inverse_mass;
      add(response, respond(frame, arm_a, a.inverse_inertia));
    }
    store_points(block, response, inverse_mass, m.u, m.v, m.separation);
    if constexpr (kMayBeRound<kPoints>) {
      store(block.cores.core_a, m.u[kCoreA]);
      store(block.cores.core_b, m.u[kCoreB]);
    }
    store_friction(block, response, inverse_mass);
    for (int k = 0; k < kPoints; ++k) store(block.impulse[k], m.impulse[k] * scale);
    store(block.tangent_impulse[0], m.friction_impulse[0] * scale);
    store(block.tangent_impulse[1], m.friction_impulse[1] * scale);
    store(block.twist_impulse, m.twist * scale);
    if constexpr (kRich) prepare_rich<kPoints, kStatic>(args, block, frame, contact);
    if (args.impulse_sum != nullptr) store_unaligned(args.impulse_sum + first_lane, F(0.0f));
    if (args.force_sum != nullptr) clear_forces(args, first_lane);
  });
}

// By its warm start an impulse that is not finite would make the bodies non-finite again that finish_step is
// about to restore, in every step anew. A contact that has one forgets all of its impulses.
template <int kPoints, bool kRich, class Block>
inline void forget_non_finite_impulses(Block& block) {
  F differences(0.0f);  // the sum of x - x, as in is_finite
  const auto for_each_impulse = [&block](auto&& visit) {
    for (int k = 0; k < kPoints; ++k) visit(block.impulse[k]);
    visit(block.tangent_impulse[0]);
    visit(block.tangent_impulse[1]);
    visit(block.twist_impulse);
    if constexpr (kRich) {
      for (int axis = 0; axis < 3; ++axis) visit(block.rolling_impulse[axis]);
    }
  };
  for_each_impulse([&differences](const LaneFloats& impulse) {
    const F value = load(impulse);
    differences += value - value;
  });
  const M finite = differences == F(0.0f);
  if (bits(finite) == (1u << kLanes) - 1u) return;
  for_each_impulse([finite](LaneFloats& impulse) { store(impulse, select(finite, load(impulse), F(0.0f))); });
}

template <int kPoints, bool kRich, bool kStatic>
SCREE_SWEEP void store_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  for_each_block<Block>(args, chunk, [&](Block& block, int count, int first_lane) {
    prefetch(&block + 1, offsetof(ContactBlock<kPoints>, impulse),
             kRich ? sizeof(Block) : offsetof(ContactBlock<kPoints>, initial_separation));
    prefetch_manifolds<Access::write>(args, chunk, first_lane, offsetof(Manifold, normal_impulse),
                                      sizeof(Manifold));
    forget_non_finite_impulses<kPoints, kRich>(block);
    const std::int32_t* contact = args.rows + first_lane;
    F impulse[4] = {F(0.0f), F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < kPoints; ++k) impulse[k] = load(block.impulse[k]);
    float* base = args.manifolds->normal;
    store_rows(base + 24, kStride, contact, count, impulse[0], impulse[1], impulse[2], impulse[3]);
    store_row_pairs(base + 28, kStride, contact, count, load(block.tangent_impulse[0]),
                    load(block.tangent_impulse[1]));
    for (int lane = 0; lane < count; ++lane) {
      args.manifolds[contact[lane]].twist_impulse = block.twist_impulse[lane];
      if constexpr (kRich) {
        for (int axis = 0; axis < 3; ++axis) {
          args.surfaces[contact[lane]].rolling_impulse[axis] = block.rolling_impulse[axis][lane];
        }
      }
    }
  });
}

template <int kPoints, bool kRich, bool kStatic>
void measure_depth_chunk(const ContactArgs& args, const ConstraintChunk& chunk) {
  using Block = typename BlockOf<kPoints, kRich>::Type;
  for_each_block<Block>(args, chunk, [&](Block& block, int, int first_lane) {
    F depth(0.0f);
    for (int k = 0; k < kPoints; ++k) depth = max(-load(block.separation[k]), depth);
    store_unaligned(args.depth + first_lane, depth);
  });
}

void measure_depth(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(measure_depth_chunk, args, chunk)
}

void prepare(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(prepare_chunk, args, chunk)
}

void store_blocks(const ContactArgs& args, const ConstraintChunk& chunk) {
  SCREE_CONTACT_VARIANTS(store_chunk, args, chunk)
}

}  // namespace

void add_contact_solve_kernels(ContactKernels& kernels);
void add_contact_together_kernels(ContactKernels& kernels);
void add_contact_sequential_kernels(ContactKernels& kernels);
void add_contact_rebound_kernels(ContactKernels& kernels);
void add_contact_force_kernels(ContactKernels& kernels);
void add_contact_statement_kernel(ContactKernels& kernels);

ContactKernels make_contact_kernels() {
  ContactKernels kernels{};
  for (int is_static = 0; is_static < 2; ++is_static) {
    kernels.block_bytes[contact_variant(0, false, is_static != 0)] = sizeof(ContactBlock<1>);
    kernels.block_bytes[contact_variant(1, false, is_static != 0)] = sizeof(ContactBlock<2>);
    kernels.block_bytes[contact_variant(2, false, is_static != 0)] = sizeof(ContactBlock<4>);
    kernels.block_bytes[contact_variant(0, true, is_static != 0)] = sizeof(RichBlock<1>);
    kernels.block_bytes[contact_variant(1, true, is_static != 0)] = sizeof(RichBlock<2>);
    kernels.block_bytes[contact_variant(2, true, is_static != 0)] = sizeof(RichBlock<4>);
  }
  kernels.prepare = prepare;
  kernels.store = store_blocks;
  kernels.measure_depth = measure_depth;
  add_contact_solve_kernels(kernels);
  add_contact_together_kernels(kernels);
  add_contact_sequential_kernels(kernels);
  add_contact_rebound_kernels(kernels);
  add_contact_force_kernels(kernels);
  add_contact_statement_kernel(kernels);
  return kernels;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
