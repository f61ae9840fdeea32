// Wakes islands: a sleeping island wakes as a whole where an awake body touches or pulls one of its bodies.
//
// Contacts and joints connect an island. It is searched breadth first from the bodies that are touched: the
// cost depends on the bodies that wake, with their pairs and joints, not on how many sleep elsewhere. A pair
// of two sleeping bodies rests, so the search only needs the resting pairs.
#include <core/constraints/joint_parameters.h>
#include <core/world/pair_key.h>
#include <core/world/resting_pairs.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/spread.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

// Islands::reached.
constexpr std::uint8_t kListed = 1;    // among the candidates
constexpr std::uint8_t kFollowed = 2;  // its contacts at rest are listed

void reach(const WorldData& data, Islands& islands, std::int32_t body) {
  if (!is_asleep(data.bodies, body) || islands.reached[body] != 0) return;
  islands.reached[body] = kListed;
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
  const Joints& joints = data.joints;
  for (std::int32_t joint = data.bodies.first_joint[body]; joint >= 0;
       joint = next_joint(joints, joint, body)) {
    if (!is_enabled(joints, joint)) continue;
    const Ends ends = joint_ends(data, joint);
    reach(data, islands, ends.a == body ? ends.b : ends.a);
  }
}

// Lists the contacts and the joints of an awake and a sleeping body. Returns whether there are any.
bool list_touched(WorldData& data, Islands& islands, Crew& crew) {
  const Bodies& bodies = data.bodies;
  const Column<std::int32_t>&contacts = data.contacts.active, &joints = data.joints.active;
  const auto joins_sleeper = [&](Ends ends) {
    return is_asleep(bodies, ends.a) || is_asleep(bodies, ends.b);
  };
  list_where(
      crew, contacts.size(), islands.places, islands.waking_contacts,
      [&](std::int32_t i) { return joins_sleeper(contact_ends(data, contacts[i])); },
      [&](std::int32_t i) { return contacts[i]; });
  refresh_joints(data, crew);
  list_where(
      crew, joints.size(), islands.places, islands.waking_joints,
      [&](std::int32_t i) { return joins_sleeper(joint_ends(data, joints[i])); },
      [&](std::int32_t i) { return joints[i]; });
  return !islands.waking_contacts.empty() || !islands.waking_joints.empty();
}

// Wakes the islands of the sleeping bodies that Islands::waking_contacts and Islands::waking_joints name, and
// lists their contacts at rest, in the order of the pairs: Contacts::roused.
void wake_listed(WorldData& data, Islands& islands, Crew& crew) {
  Contacts& contacts = data.contacts;
  islands.reached.resize(data.bodies.flags.size());
  islands.candidates.clear();
  for (const std::int32_t contact : islands.waking_contacts) {
    const Ends ends = contact_ends(data, contact);
    for (const std::int32_t body : {ends.a, ends.b}) reach(data, islands, body);
  }
  for (const std::int32_t joint : islands.waking_joints) {
    const Ends ends = joint_ends(data, joint);
    for (const std::int32_t body : {ends.a, ends.b}) reach(data, islands, body);
  }
  std::size_t followed = 0;
  const auto follow = [&] {
    for (; followed < islands.candidates.size(); ++followed) {  // which grows meanwhile
      const std::int32_t body = islands.candidates[followed];
      follow_contacts(data, islands, body);
      follow_joints(data, islands, body);
    }
  };
  follow();
  if (Border* const border = border_of(data)) {
    spread(
        *border, true, [&](std::int32_t body) { return islands.reached[body] != 0; },
        [&](std::int32_t body) {
          const std::size_t before = islands.candidates.size();
          reach(data, islands, body);
          return islands.candidates.size() > before;
        },
        follow);
  }
  for (const std::int32_t body : islands.candidates) islands.reached[body] = 0;
  std::sort(islands.candidates.begin(), islands.candidates.end());
  for (const std::int32_t body : islands.candidates) wake_body(data, body);
  sort_by_pair(broad_phase_of(data), contacts.resting.pair, contacts.roused, crew);
}

// Islands::remaining has the first contact of each pair: puts the others behind it.
void follow_contacts_of_pairs(const Contacts& contacts, Islands& islands) {
  Column<std::int32_t>& all = islands.waking_contacts;  // no longer needed
  all.clear();
  for (const std::int32_t first : islands.remaining) {
    for_each_contact(contacts, first, [&](std::int32_t contact) { all.push_back(contact); });
  }
  all.swap(islands.remaining);
}

// Lists the contacts that take part now, in the order of their pairs. Their pairs stay at rest until the next
// list of pairs; their contacts take part at once.
void list_active_contacts(WorldData& data, Islands& islands, Crew& crew) {
  Contacts& contacts = data.contacts;
  const Column<std::int32_t>& contact_of = contacts.pairs.contact;
  list_where(
      crew, contact_of.size(), islands.places, islands.remaining,
      [&](std::int32_t pair) {
        return contact_of[pair] >= 0 && takes_part(data, contact_ends(data, contact_of[pair]));
      },
      [&](std::int32_t pair) { return contact_of[pair]; });
  if (!data.meshes.data.empty()) follow_contacts_of_pairs(contacts, islands);
  islands.waking_contacts.clear();
  for (const std::int32_t row : contacts.roused) {
    for_each_contact(contacts, contacts.resting.contact[row],
                     [&](std::int32_t contact) { islands.waking_contacts.push_back(contact); });
  }
  contacts.active.resize_discarding(islands.remaining.size() + islands.waking_contacts.size());
  const ShapePair* const pair = contacts.now.pair.data();
  std::merge(islands.remaining.begin(), islands.remaining.end(), islands.waking_contacts.begin(),
             islands.waking_contacts.end(), contacts.active.begin(),
             [&](std::int32_t x, std::int32_t y) { return comes_before(pair[x], pair[y]); });
}

}  // namespace

void wake_touched_islands(WorldData& data, Crew& crew) {
  Islands& islands = islands_of(data);
  islands.joints_judged = 0;
  data.contacts.roused.clear();
  if (!data.settings.sleeping) return;
  std::int64_t touched = list_touched(data, islands, crew) ? 1 : 0;
  if (Border* const border = border_of(data)) border->transport.add_up({&touched, 1});
  if (touched == 0) return;
  wake_listed(data, islands, crew);
  refresh_lists(data, crew);
  list_active_contacts(data, islands, crew);
}

}  // namespace scree
