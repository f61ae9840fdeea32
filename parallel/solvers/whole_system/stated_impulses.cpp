// Impulses of stated rows: to the sums of a step, and to manifolds and joints. See state_system.h.
#include <parallel/solvers/whole_system/state_system.h>
#include <scree/math.h>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

// Slots of a contact, see simd/constraints/contact/contact_statement.cpp.
constexpr int kTwistSlot = kMaxManifoldPoints, kFrictionSlot = kTwistSlot + 1,
              kRollingSlot = kFrictionSlot + 2;

float finite_or_zero(float value) { return std::isfinite(value) ? value : 0.0f; }

float impulse_of(const ConstraintRows& rows, int slot) { return finite_or_zero(rows.row[slot].impulse); }

Vec3 vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
Quat quat(const float (&q)[4]) { return {q[0], q[1], q[2], q[3]}; }

void add_contact(const SolveStep& step, const ConstraintRows& rows, const StatedLane& at) {
  if (step.contact.impulse_sum != nullptr) {
    for (int k = 0; k < kMaxManifoldPoints; ++k) step.contact.impulse_sum[at.lane] += impulse_of(rows, k);
  }
  if (step.contact.force_sum == nullptr) return;
  // Fields of a block are arrays of its lanes, see simd/constraints/contact/contact_forces.h.
  float* const lane = step.contact.force_sum +
                      static_cast<std::ptrdiff_t>(at.first_lane) * simd::kForceFields +
                      (at.lane - at.first_lane);
  const auto add = [&](int field, int slot) { lane[field * at.lanes] += impulse_of(rows, slot); };
  for (int k = 0; k < kMaxManifoldPoints; ++k) add(k, k);
  for (int k = 0; k < 2; ++k) add(simd::kFrictionField + k, kFrictionSlot + k);
  add(simd::kTwistField, kTwistSlot);
  for (int k = 0; k < 3; ++k) add(simd::kRollingField + k, kRollingSlot + k);
}

void store_contact(WorldData& data, std::int32_t contact, const ConstraintRows& rows) {
  Manifold& manifold = data.contacts.now.manifold[contact];
  for (int k = 0; k < kMaxManifoldPoints; ++k) manifold.normal_impulse[k] = impulse_of(rows, k);
  for (int k = 0; k < 2; ++k) manifold.friction_impulse[k] = impulse_of(rows, kFrictionSlot + k);
  manifold.twist_impulse = impulse_of(rows, kTwistSlot);
  if ((manifold.info & kManifoldRich) == 0) return;
  ContactSurface& surface = data.contacts.now.surface[contact];
  for (int k = 0; k < 3; ++k) surface.rolling_impulse[k] = impulse_of(rows, kRollingSlot + k);
}

// What the rows of a joint do to b, at its anchor.
struct Reaction {
  Vec3 force, torque;  // N, N m
};
Reaction reaction_of(const SolveStep& step, std::int32_t joint, const ConstraintRows& rows) {
  const JointFrames& frames = step.data.joints.frames[joint];
  Vec3 impulse{}, twist{};
  for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
    if (rows.row[slot].kind == kRowNone) continue;
    impulse = impulse + impulse_of(rows, slot) * vec(rows.row[slot].linear_b);
    twist = twist + impulse_of(rows, slot) * vec(rows.row[slot].angular_b);
  }
  const Vec3 placed = rotate(quat(step.data.bodies.pose[frames.row_b].rotation), vec(frames.anchor_b));
  const Vec3 arm = rotate(quat(step.data.bodies.delta[frames.row_b].rotation), placed);
  const float rate = step.joint.inverse_substep;
  return {rate * impulse, rate * (twist - cross(arm, impulse))};
}

void note_peak(const Reaction& reaction, JointReactionRow& row) {
  const auto raise = [](float& peak, Vec3 v) {
    const float square = dot(v, v);
    if (std::isfinite(square)) peak = std::max(peak, square);
  };
  raise(row.force_peak_squared, reaction.force);
  raise(row.torque_peak_squared, reaction.torque);
}

void store_reaction(const Reaction& reaction, JointReactionRow& row) {
  const float force[3] = {reaction.force.x, reaction.force.y, reaction.force.z};
  const float torque[3] = {reaction.torque.x, reaction.torque.y, reaction.torque.z};
  for (int k = 0; k < 3; ++k) {
    row.force[k] = finite_or_zero(force[k]);
    row.torque[k] = finite_or_zero(torque[k]);
  }
}

// Every kind states the impulses along its rows as products of its stored numbers with a matrix S whose rows
// are orthonormal, so S^T takes them back. Its columns are what the kind states of the unit vectors.
void store_joint_impulses(SolveStep& step, const StatedWorld& stated) {
  WorldData& data = step.data;
  std::vector<JointImpulses> units(data.joints.impulses.size(), JointImpulses{});
  simd::JointArgs args = step.joint;
  args.impulses = units.data();
  std::vector<std::int32_t> joints;
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    if (!stated.is_contact[i]) joints.push_back(stated.item[i]);
  }
  for (const std::int32_t joint : joints) {
    units[static_cast<std::size_t>(joint)].impulse[simd::kRememberedCoordinate] =
        data.joints.impulses[joint].impulse[simd::kRememberedCoordinate];
  }
  for (int number = 0; number < kJointImpulses; ++number) {
    if (number == simd::kRememberedCoordinate) continue;
    for (const std::int32_t joint : joints) units[static_cast<std::size_t>(joint)].impulse[number] = 1.0f;
    const std::vector<ConstraintRows> columns = state_joints(step, args);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const ConstraintRows& rows = stated.constraints[i].rows;
      float sum = 0.0f;
      for (int slot = 0; slot < kMaxConstraintRows; ++slot) {
        if (rows.row[slot].kind != kRowNone) sum += columns[i].row[slot].impulse * impulse_of(rows, slot);
      }
      data.joints.impulses[joints[i]].impulse[number] = sum;
    }
    for (const std::int32_t joint : joints) units[static_cast<std::size_t>(joint)].impulse[number] = 0.0f;
  }
}

}  // namespace

void add_stated_impulses(SolveStep& step, const StatedWorld& stated) {
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    const ConstraintRows& rows = stated.constraints[i].rows;
    if (stated.is_contact[i]) {
      add_contact(step, rows, stated.lane[i]);
    } else if (stated.lane[i].peaks) {
      const std::int32_t joint = stated.item[i];
      note_peak(reaction_of(step, joint, rows), step.data.joints.reaction[joint]);
    }
  }
}

void store_stated_impulses(SolveStep& step, const StatedWorld& stated) {
  store_joint_impulses(step, stated);
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    const ConstraintRows& rows = stated.constraints[i].rows;
    const std::int32_t item = stated.item[i];
    if (stated.is_contact[i]) {
      store_contact(step.data, item, rows);
      continue;
    }
    store_reaction(reaction_of(step, item, rows), step.data.joints.reaction[item]);
    if (!stated.lane[i].remembers) continue;
    for (const ConstraintRow& row : rows.row) {
      if (row.kind != kRowHeld) continue;
      step.data.joints.impulses[item].impulse[simd::kRememberedCoordinate] = finite_or_zero(row.error);
      break;
    }
  }
}

}  // namespace scree
