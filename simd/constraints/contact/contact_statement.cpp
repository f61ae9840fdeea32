// What a contact is, as rows for solvers of any kind; see core/plain/constraint_row.h.
//
// With the normal n from a to b, the tangents t_i, the friction center C and r_k the way from it to point k:
//
//   slots 0 to 3   points    C = separation_k,   J = [-n, -(c_a + r_k) x n, n, (c_b + r_k) x n], force >= 0
//   slot 4         twist     J = [0, -n, 0, n], |force| <= friction sum of |r_k| force_k
//   slots 5, 6     friction  J = [-t_i, -c_a x t_i, t_i, c_b x t_i], both together <= friction sum of force_k
//   slots 7 to 9   rolling   J = [0, -1, 0, 1], all together <= resistance sum of force_k
//
// The kernels take them in this order: a point after the other (Catto, "Iterative Dynamics with Temporal
// Coherence", GDC 2005; as Jolt's contact constraints), then in relax what rubs, at one center (as Bullet's
// torsional friction and Jolt's manifold friction have it). Rebounds are impacts and no rows, see
// contact_rebound.cpp. Relax alone moves the levers of friction on bodies that cannot be pushed and turn, see
// carried_over in contact_passes.h.
#include <simd/constraints/contact/contact_manifold.h>
#include <simd/constraints/row_statement.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

enum ContactBlockNumber : std::uint32_t { kTwistBlock = kMaxManifoldPoints, kFrictionBlock, kRollingBlock };

struct StatedContact {
  const WideManifold& manifold;
  V3 tangent1, tangent2;
  F arm[kMaxManifoldPoints];  // of friction against spin
  Statement& to;
};

void state_points(const StatedContact& of, const SeparationChange& change) {
  const WideManifold& m = of.manifold;
  const F zero(0.0f);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    // r_k x n, for r_k in the tangent plane.
    const V3 lever = of.tangent1 * m.v[k] - of.tangent2 * m.u[k];
    RowStatement said;
    said.row = {-m.normal, -(cross(m.arm_a, m.normal) + lever), m.normal, cross(m.arm_b, m.normal) + lever};
    const M present = is_present(m.separation[k]);
    said.kind = select(present, number(kRowContact), number(kRowNone));
    said.block = number(static_cast<std::uint32_t>(k));
    said.error = m.separation[k] + change.center + m.u[k] * change.tilt1 + m.v[k] * change.tilt2;
    said.lower = zero;
    said.impulse = m.impulse[k];
    of.to.add(said);
  }
}

// Bounded by the force of the points alone.
RowStatement friction_row(const Row& row, ConstraintRowKind kind, std::uint32_t block, F impulse) {
  RowStatement said;
  said.row = row;
  said.kind = number(kind);
  said.block = number(block);
  said.lower = said.upper = F(0.0f);
  said.impulse = impulse;
  return said;
}

void state_friction(const StatedContact& of, V3 surface_velocity) {
  const WideManifold& m = of.manifold;
  const F zero(0.0f);
  RowStatement twist = friction_row(turn_row(m.normal), kRowTwist, kTwistBlock, m.twist);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    twist.bound_by[k] = select(is_present(m.separation[k]), m.friction * of.arm[k], zero);
  }
  of.to.add(twist);
  const V3 tangent[2] = {of.tangent1, of.tangent2};
  for (int i = 0; i < 2; ++i) {
    RowStatement slip = friction_row(point_row(tangent[i], m.arm_a, m.arm_b), kRowFriction, kFrictionBlock,
                                     m.friction_impulse[i]);
    slip.flags = number(kRowBoundsLength);
    slip.target_speed = -dot(surface_velocity, tangent[i]);
    for (F& bound : slip.bound_by) bound = m.friction;
    of.to.add(slip);
  }
}

void state_rolling(const StatedContact& of, const WideSurface& surface) {
  const V3 old = surface.rolling_impulse;
  const F impulse[3] = {old.x, old.y, old.z};
  for (int i = 0; i < 3; ++i) {
    RowStatement roll = friction_row(turn_row(world_axis(i)), kRowRolling, kRollingBlock, impulse[i]);
    roll.flags = number(kRowBoundsLength);
    for (F& bound : roll.bound_by) bound = surface.rolling_resistance;
    of.to.add(roll);
  }
}

void state_rows(const ContactArgs& args, const ConstraintChunk& chunk, ConstraintRows* rows) {
  const bool rich = is_rich(chunk.variant), may_be_round = bucket_of(chunk.variant) < kPointBuckets - 1;
  const F zero(0.0f);
  for (int first = 0; first < chunk.lanes; first += kLanes) {
    const int count = chunk.lanes - first < kLanes ? chunk.lanes - first : kLanes;
    const std::int32_t* contact = args.rows + chunk.first_lane + first;
    const WideManifold m = load_manifold(args, contact);
    alignas(64) LaneInts row_a, row_b;
    store(row_a, as_int(m.row_a));
    store(row_b, as_int(m.row_b));
    Statement to(rows, chunk.first_lane + first, count);
    const V3 tangent1 = tangent_of(m.normal), tangent2 = cross(m.normal, tangent1);
    StatedContact of{m, tangent1, tangent2, {}, to};
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      of.arm[k] = twist_arm(m.u[k], m.v[k], may_be_round, m.v[kTwistArm]);
    }
    const TurningArms arms = may_be_round ? turning_arms(m.normal, m.arm_a, m.arm_b, m.u[kCoreA], m.u[kCoreB])
                                          : TurningArms{m.arm_a, m.arm_b};
    state_points(of, separation_change(load_delta(args.delta, row_a), load_delta(args.delta, row_b), m.normal,
                                       tangent1, tangent2, arms));
    if (rich) {
      const WideSurface surface = load_surface(args, contact);
      state_friction(of, surface.velocity);
      state_rolling(of, surface);
    } else {
      state_friction(of, {zero, zero, zero});
    }
    to.leave_rest_empty();
  }
}

}  // namespace

void add_contact_statement_kernel(ContactKernels& kernels) { kernels.state_rows = state_rows; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
