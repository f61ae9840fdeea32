// Waking what an awake body touches: islands of sleeping bodies, found breadth first from those touched.
//
// That costs by the bodies that wake, with their pairs and joints, however many sleep elsewhere. A pair of
// two sleeping bodies rests, so the pairs at rest are all there is to follow.
#include <core/world/pair_key.h>
#include <core/world/resting_pairs.h>
#include <core/world/wake.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/islands/islands.h>

#include <algorithm>

namespace scree {

namespace {

// Islands::reached.
constexpr std::uint8_t kListed = 1;    // among the candidates
constexpr std::uint8_t kFollowed = 2;  // its contacts at rest are listed

void reach(const WorldData& data, Islands& islands, std::int32_t body) {
  const auto row = static_cast<std::size_t>(body);
  if ((data.bodies.flags[row] & kBodyAsleep) == 0 || islands.reached[row] != 0) return;
  islands.reached[row] = kListed;
  islands.candidates.push_back(body);
}

void follow_contacts(WorldData& data, Islands& islands, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other_shape) {
      if (data.contacts.resting.contact[row] < 0) return;
      const std::int32_t other = data.shapes.body[other_shape];
      reach(data, islands, other);
      if (islands.reached[other] != kFollowed) data.contacts.roused.push_back(row);
    });
  }
  islands.reached[body] = kFollowed;
}

void follow_joints(const WorldData& data, Islands& islands, std::int32_t body) {
  constexpr std::uint8_t kWhole = kJointAlive | kJointEnabled;
  const Joints& joints = data.joints;
  for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;) {
    const auto row = static_cast<std::size_t>(joint);
    const bool is_a = joints.bodies[row].a == body;
    if ((joints.flags[row] & kWhole) == kWhole) {
      reach(data, islands, is_a ? joints.bodies[row].b : joints.bodies[row].a);
    }
    joint = is_a ? joints.next[row].a : joints.next[row].b;
  }
}

}  // namespace

void rouse_islands(WorldData& data, Islands& islands, Crew& crew) {
  Contacts& contacts = data.contacts;
  islands.reached.resize(data.bodies.flags.size());
  islands.candidates.clear();
  for (const std::int32_t contact : islands.touched) {
    const ShapePair pair = contacts.now.pair[contact];
    for (const std::int32_t shape : {pair.a, pair.b}) reach(data, islands, data.shapes.body[shape]);
  }
  for (const std::int32_t joint : islands.pulled) {
    const JointBodies ends = data.joints.bodies[joint];
    for (const std::int32_t body : {ends.a, ends.b}) reach(data, islands, body);
  }
  for (std::size_t i = 0; i < islands.candidates.size(); ++i) {  // which grows meanwhile
    const std::int32_t body = islands.candidates[i];
    follow_contacts(data, islands, body);
    follow_joints(data, islands, body);
  }
  for (const std::int32_t body : islands.candidates) islands.reached[body] = 0;
  std::sort(islands.candidates.begin(), islands.candidates.end());
  for (const std::int32_t body : islands.candidates) wake_body(data, body);
  sort_by_pair(broad_phase_of(data), contacts.resting.pair, contacts.roused, crew);
}

}  // namespace scree
