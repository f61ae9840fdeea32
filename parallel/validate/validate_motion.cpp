// Validation of what the solver and the end of the step leave behind; see validate_stages.h.
#ifdef SCREE_ASSERTIONS

#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/pair_key.h>
#include <parallel/stages.h>
#include <parallel/validate/validate_stages.h>

#include <cmath>

namespace scree {

namespace {

bool is_finite(const float (&v)[3]) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void validate_body(const Bodies& bodies, std::int32_t body) {
  SCREE_ASSERT(is_finite(bodies.pose[body].position));
  SCREE_ASSERT(is_unit(to_quat(bodies.pose[body].rotation)));  // as far as calls ask for
  SCREE_ASSERT(is_finite(bodies.velocity[body].linear) && is_finite(bodies.velocity[body].angular));
}

std::uint64_t key_of(const ContactEvent& event) { return pair_key(event.shape_a.index, event.shape_b.index); }
std::uint64_t key_of(const ContactEnd& end) { return pair_key(end.shape_a.index, end.shape_b.index); }

template <class Row>
bool ascends_by_pair(const Column<Row>& rows) {
  return ascends(rows, [](const Row& x, const Row& y) { return key_of(x) < key_of(y); });
}

}  // namespace

void validate_impulses(const WorldData& data) {
  if (!is_validated(data)) return;
  for (std::int32_t row = kFixedRow; row < kFirstBody; ++row) {
    const VelocityRow& velocity = data.bodies.velocity[row];
    for (int axis = 0; axis < 3; ++axis) {
      SCREE_ASSERT(velocity.linear[axis] == 0.0f && velocity.angular[axis] == 0.0f);
    }
    SCREE_ASSERT(data.bodies.inertia[row].inverse_mass == 0.0f);
  }
  for (const std::int32_t contact : data.contacts.active) {
    const Manifold& manifold = data.contacts.now.manifold[contact];
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      SCREE_ASSERT(!(manifold.normal_impulse[k] < 0.0f));  // but it may be no number: see quarantine_bodies
    }
  }
  SCREE_ASSERT(ascends(data.events.broken, [](JointId x, JointId y) { return x.index < y.index; }));
  for (const JointId joint : data.events.broken) {
    SCREE_ASSERT((data.joints.flags[joint.index] & kJointEnabled) == 0);
  }
}

void validate_events(const WorldData& data) {
  if (!is_validated(data)) return;
  const Events& events = data.events;
  SCREE_ASSERT(ascends(events.touching, [](const TouchRow& x, const TouchRow& y) {
    return scree::key_of(x) < scree::key_of(y);
  }));
  for (const TouchRow& row : events.touching) SCREE_ASSERT(row.events != 0 && row.events <= kTouchEvents);
  SCREE_ASSERT(ascends(events.sleep_begins));
  SCREE_ASSERT(ascends(events.sleep_ends));
  SCREE_ASSERT(events.woken.empty() && events.lost.empty());
  SCREE_ASSERT(ascends_by_pair(events.begins));
  SCREE_ASSERT(ascends_by_pair(events.persists));
  SCREE_ASSERT(ascends_by_pair(events.ends));
  SCREE_ASSERT(ascends_by_pair(events.hits));
  SCREE_ASSERT(ascends(events.strained, [](const JointEvent& x, const JointEvent& y) {
    return x.joint.index < y.joint.index;
  }));
  SCREE_ASSERT(asks_for_events(data) || events.resting.empty());
  validate_pairs(data);
}

void validate_motion(const WorldData& data) {
  if (!is_validated(data)) return;
  for (const std::int32_t body : data.bodies.awake) validate_body(data.bodies, body);
  for (const std::int32_t body : data.bodies.kinematic) validate_body(data.bodies, body);
  // Shapes may lie outside their fat bounds: those of a snapshot from outside are anything until they move.
}

}  // namespace scree

#endif
