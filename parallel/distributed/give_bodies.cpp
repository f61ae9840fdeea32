// Gives bodies to other ranks: owners change, and what only the old owner knows of their pairs and joints
// travels with them. See border.h.
//
// A rank knows a pair if one of its bodies takes part. So the new owner of a body needs the body's pairs, but
// those with bodies that it had already. The bodies on the other side of these pairs come as ghosts before
// the next pairs are found.
#include <core/state/snapshot/absent_rows.h>
#include <core/world/pair_key.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_events.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>
#include <parallel/narrow_phase/narrow_phase.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace scree {

namespace {

// What is sent has no gaps: messages are written to files, in which chance bytes have no place.
struct SentPair {
  ShapePair pair;
  std::int32_t contacts;
  std::int32_t unused;
  ContactAxis axis;
};
static_assert(sizeof(SentPair) == sizeof(ShapePair) + 8 + sizeof(ContactAxis));

struct SentContact {
  Manifold manifold;
  ContactAnchor anchor;
  ContactForceRow force;
  ContactSurface surface;
  ManifoldFeatures features;
  std::uint8_t points, color;
  std::uint8_t unused[14];
};
static_assert(sizeof(SentContact) == sizeof(Manifold) + sizeof(ContactAnchor) + sizeof(ContactForceRow) +
                                         sizeof(ContactSurface) + sizeof(ManifoldFeatures) + 16);

// A pair on its way in, and where its contacts begin in the list of all.
struct FoundPair {
  SentPair sent;
  std::size_t first_contact;
};

void check_given(const WorldData& data, const Border& border, std::span<const GivenBody> given) {
  std::vector<std::uint8_t> is_given(border.owner.size(), 0);
  for (const auto& [body, to] : given) {
    const std::string name = "give_bodies: body " + std::to_string(body);
    if (body < 0 || std::cmp_greater_equal(body, border.owner.size()) || !border.owns(body))
      throw Error(name + " is not of rank " + std::to_string(border.transport.rank()));
    if (to < 0 || to >= border.transport.ranks()) {
      throw Error(name + " is given to rank " + std::to_string(to) + " of " +
                  std::to_string(border.transport.ranks()));
    }
    if (is_given[static_cast<std::size_t>(body)]++ != 0) throw Error(name + " is given twice");
  }
  if (std::cmp_not_equal(data.bodies.flags.size(), border.owner.size()))
    throw Error("give_bodies: bodies were created since divide_world");
}

// What goes to one rank.
struct Parcel {
  std::vector<std::int32_t> bodies;
  std::vector<SentPair> pairs;
  std::vector<SentContact> contacts;
  std::vector<SentJoint> joints;
  SentEvents events;
};

void pack_pairs(const WorldData& data, const Border& border, const std::vector<std::int32_t>& next_owner,
                std::vector<Parcel>& parcels) {
  const PairRows& pairs = data.contacts.pairs;
  const ContactRows& now = data.contacts.now;
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    const ShapePair pair = pairs.pair[row];
    if (has_changed(data.shapes, pair.a) || has_changed(data.shapes, pair.b)) continue;
    const Receivers to = receivers_of(border, next_owner, data.shapes.body[pair.a], data.shapes.body[pair.b]);
    for (int i = 0; i < to.count; ++i) {
      Parcel& parcel = parcels[static_cast<std::size_t>(to.ranks[i])];
      SentPair sent{pair, 0, 0, pairs.axis.empty() ? ContactAxis{} : pairs.axis[row]};
      for_each_contact(data.contacts, pairs.contact[row], [&](std::int32_t contact) {
        parcel.contacts.push_back(
            {now.manifold[contact],
             now.anchor[contact],
             data.contacts.forces.empty() ? ContactForceRow{} : data.contacts.forces[contact],
             now.surface[contact],
             now.features[contact],
             now.points[contact],
             now.color[contact],
             {}});
        ++sent.contacts;
      });
      parcel.pairs.push_back(sent);
    }
  }
}

void pack_joints(const WorldData& data, const Border& border, const std::vector<std::int32_t>& next_owner,
                 std::vector<Parcel>& parcels) {
  const Joints& joints = data.joints;
  for (std::size_t joint = 0; joint < joints.flags.size(); ++joint) {
    if ((joints.flags[joint] & kJointAlive) == 0) continue;
    const JointBodies ends = joints.bodies[joint];
    const Receivers to = receivers_of(border, next_owner, ends.a, ends.b);
    for (int i = 0; i < to.count; ++i) {
      parcels[static_cast<std::size_t>(to.ranks[i])].joints.push_back(
          sent_joint(joints, static_cast<std::int32_t>(joint)));
    }
  }
}

bool is_sound(const WorldData& data, const Border& border, const SentPair& sent) {
  const auto is_alive = [&](std::int32_t shape) {
    return shape >= 0 && std::cmp_less(shape, data.shapes.flags.size()) &&
           (data.shapes.flags[shape] & kShapeAlive) != 0;
  };
  return sent.contacts >= 0 && is_alive(sent.pair.a) && is_alive(sent.pair.b) &&
         knows(&border, data.shapes.body[sent.pair.a], data.shapes.body[sent.pair.b]);
}

// Adds pairs that ranks have sent to the list. Two ranks may have sent the same one.
void take_pairs(WorldData& data, std::vector<FoundPair>& found, const std::vector<SentContact>& sent,
                Crew& crew) {
  std::stable_sort(found.begin(), found.end(), [](const FoundPair& one, const FoundPair& other) {
    return comes_before(one.sent.pair, other.sent.pair);
  });
  found.erase(std::unique(found.begin(), found.end(),
                          [](const FoundPair& one, const FoundPair& other) {
                            return key_of(one.sent.pair) == key_of(other.sent.pair);
                          }),
              found.end());
  // Of a pair at rest a rank may know, even if both bodies are others'.
  const Column<ShapePair>& known = data.contacts.pairs.pair;
  std::erase_if(found, [&](const FoundPair& pair) {
    return std::binary_search(known.begin(), known.end(), pair.sent.pair, comes_before);
  });
  Contacts& contacts = data.contacts;
  std::size_t needed = 0;
  for (const FoundPair& pair : found) needed += static_cast<std::size_t>(pair.sent.contacts);
  provide_rows(contacts, needed, 0, data.settings.contact_forces);
  PairRows added;
  for (const FoundPair& pair : found) {
    std::int32_t next = 0;
    for (std::int32_t i = pair.sent.contacts; i-- > 0;) {  // the last one first: others link to it
      const SentContact& from = sent[pair.first_contact + static_cast<std::size_t>(i)];
      const std::int32_t row = contacts.free_rows.back();
      contacts.free_rows.drop_back(1);
      ContactRows& now = contacts.now;
      now.pair[row] = pair.sent.pair;
      now.points[row] = from.points;
      now.next[row] = next;
      now.manifold[row] = from.manifold;
      now.features[row] = from.features;
      now.anchor[row] = from.anchor;
      now.surface[row] = from.surface;
      now.color[row] = from.color;
      if (!contacts.forces.empty()) contacts.forces[row] = from.force;
      contacts.marks.mark(row);
      next = row + 1;
    }
    added.pair.push_back(pair.sent.pair);
    added.contact.push_back(next - 1);
    if (!data.hulls.data.empty()) added.axis.push_back(pair.sent.axis);
  }
  contacts.free_mark.cut(contacts.free_rows.size());
  add_pairs(data, added, crew);
}

void take_joints(WorldData& data, const Border& border, std::int32_t from,
                 const std::vector<SentJoint>& sent) {
  Joints& joints = data.joints;
  for (const SentJoint& joint : sent) {
    if (joint.joint < 0 || std::cmp_greater_equal(joint.joint, joints.flags.size())) refuse_world_of(from);
    const JointBodies ends = joints.bodies[joint.joint];
    if (!knows(&border, ends.a, ends.b)) refuse_world_of(from);
    take_joint(joints, joint);
  }
}

// All ranks tell what they give: owners after that, and whether any has changed.
bool share_owners(Border& border, std::span<const GivenBody> given, std::vector<std::int32_t>& next_owner) {
  const int here = border.transport.rank(), ranks = border.transport.ranks();
  for (int to = 0; to < ranks; ++to) {
    if (to != here) send_list<GivenBody>(border.transport, to, given);
  }
  bool any = false;
  const auto note = [&](const GivenBody& one, std::int32_t from) {
    check_owner(border, from, one.body);
    if (one.to < 0 || one.to >= ranks) refuse_world_of(from);
    any = any || one.to != from;
    next_owner[static_cast<std::size_t>(one.body)] = one.to;
  };
  for (const GivenBody& one : given) note(one, here);
  for (int from = 0; from < ranks; ++from) {
    if (from == here) continue;
    for (const GivenBody& one : receive_list<GivenBody>(border.transport, from)) note(one, from);
  }
  return any;
}

// All that goes to each receiver. No pair may be at rest.
std::vector<Parcel> pack(const WorldData& data, const Border& border,
                         const std::vector<std::int32_t>& next_owner, std::size_t receivers) {
  std::vector<Parcel> parcels(receivers);
  for (std::size_t body = 0; body < next_owner.size(); ++body) {
    const auto row = static_cast<std::int32_t>(body);
    if (border.owns(row) && next_owner[body] != border.here)
      parcels[static_cast<std::size_t>(next_owner[body])].bodies.push_back(row);
  }
  pack_pairs(data, border, next_owner, parcels);
  pack_joints(data, border, next_owner, parcels);
  std::vector<SentEvents> events = pack_events(data, border, next_owner, receivers);
  for (std::size_t rank = 0; rank < parcels.size(); ++rank) parcels[rank].events = std::move(events[rank]);
  return parcels;
}

void send_parcel(Transport& transport, std::int32_t to, const WorldData& data, const Parcel& parcel) {
  send_bodies(transport, to, data, parcel.bodies);
  send_list<SentPair>(transport, to, parcel.pairs);
  send_list<SentContact>(transport, to, parcel.contacts);
  send_list<SentJoint>(transport, to, parcel.joints);
  send_events(transport, to, parcel.events);
}

// What has come from all ranks.
struct Arrivals {
  std::vector<FoundPair> found = {};
  std::vector<SentContact> contacts = {};
  SentEvents events = {};
};

// Of bodies that this rank owns already.
void receive_parcel(Transport& transport, std::int32_t from, WorldData& data,
                    std::span<const std::int32_t> bodies, Arrivals& arrivals) {
  const Border& border = *border_of(data);
  receive_bodies(transport, from, data, bodies);
  std::size_t next_contact = arrivals.contacts.size();
  for (const SentPair& pair : receive_list<SentPair>(transport, from)) {
    if (!is_sound(data, border, pair)) refuse_world_of(from);
    arrivals.found.push_back({pair, next_contact});
    next_contact += static_cast<std::size_t>(pair.contacts);
  }
  const std::vector<SentContact> sent = receive_list<SentContact>(transport, from);
  arrivals.contacts.insert(arrivals.contacts.end(), sent.begin(), sent.end());
  if (arrivals.contacts.size() != next_contact) refuse_world_of(from);
  take_joints(data, border, from, receive_list<SentJoint>(transport, from));
  receive_events(transport, from, arrivals.events);
}

void take(WorldData& data, Border& border, Arrivals& arrivals, Crew& crew) {
  if (!arrivals.found.empty()) take_pairs(data, arrivals.found, arrivals.contacts, crew);
  take_events(data, border, arrivals.events);
  forget_halos(data, border);
}

}  // namespace

void give_bodies(WorldData& data, std::span<const GivenBody> given, Crew& crew) {
  Border& border = *border_of(data);
  check_given(data, border, given);
  place_matter(data);
  wake_neighbors(data);  // while pairs that calls have ended are there, which do not travel
  std::vector<std::int32_t> next_owner = border.owner;
  if (!share_owners(border, given, next_owner)) return;
  pull_all_pairs(data, crew);  // pairs at rest travel like others
  const std::vector<Parcel> parcels = pack(data, border, next_owner, border.halos.size());
  std::vector<std::vector<std::int32_t>> taken(parcels.size());  // by rank: the bodies that it gives this one
  for (std::size_t body = 0; body < next_owner.size(); ++body) {
    if (next_owner[body] == border.here && border.owner[body] != border.here &&
        border.owner[body] != kEveryRank)
      taken[static_cast<std::size_t>(border.owner[body])].push_back(static_cast<std::int32_t>(body));
  }
  for (std::size_t to = 0; to < parcels.size(); ++to) {
    if (!parcels[to].bodies.empty())
      send_parcel(border.transport, static_cast<std::int32_t>(to), data, parcels[to]);
  }
  border.owner = std::move(next_owner);
  Arrivals arrivals;
  for (std::size_t from = 0; from < taken.size(); ++from) {
    if (!taken[from].empty())
      receive_parcel(border.transport, static_cast<std::int32_t>(from), data, taken[from], arrivals);
  }
  take(data, border, arrivals, crew);
  data.queries.reset();  // they would know of what was here when they were last asked
  data.shapes.queries_made.forget();
}

void send_all_bodies(WorldData& data, Transport& transport, Crew& crew) {
  Border& border = *border_of(data);
  place_matter(data);
  wake_neighbors(data);
  data.contacts.pairs_stale = true;  // pairs at rest go back to where they were, even if memory runs out now
  pull_all_pairs(data, crew);
  const auto nobody = static_cast<std::int32_t>(border.halos.size());  // who has had none of them
  std::vector<std::int32_t> next_owner = border.owner;
  std::replace(next_owner.begin(), next_owner.end(), border.here, nobody);
  Parcel parcel = std::move(pack(data, border, next_owner, border.halos.size() + 1).back());
  append_left_events(data, parcel.events);
  send_list<std::int32_t>(transport, nobody, parcel.bodies);
  send_list<std::uint8_t>(transport, nobody, std::vector<std::uint8_t>{data.contacts.manifolds_stale});
  send_parcel(transport, nobody, data, parcel);
}

namespace {

// As restore() does: what comes from outside may be wrong.
void derive_rows(WorldData& data, std::int32_t body) {
  const FpEnvironment environment;
  Bodies& bodies = data.bodies;
  bodies.transform[body] = transform_of(bodies.pose[body], bodies.center[body]);
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.motion[shape] = motion_at_rest(data.shapes.pose[shape]);
    place_shape_in_body(data, shape);
  }
}

}  // namespace

void receive_all_bodies(WorldData& data, Transport& transport, std::span<const std::int32_t> senders,
                        Crew& crew) {
  Border& border = *border_of(data);
  std::vector<std::uint8_t> has_come(border.owner.size(), 0);
  Arrivals arrivals;
  for (const std::int32_t from : senders) {
    const std::vector<std::int32_t> bodies = receive_list<std::int32_t>(transport, from);
    const std::vector<std::uint8_t> is_stale = receive_list<std::uint8_t>(transport, from);
    if (is_stale.size() != 1) refuse_world_of(from);
    data.contacts.manifolds_stale = data.contacts.manifolds_stale || is_stale[0] != 0;
    for (const std::int32_t body : bodies) {
      if (body < 0 || std::cmp_greater_equal(body, has_come.size()) || !border.owns(body) ||
          !is_absent(data.bodies, body))
        refuse_world_of(from);
      if (has_come[static_cast<std::size_t>(body)]++ != 0) refuse_world_of(from);
    }
    receive_parcel(transport, from, data, bodies, arrivals);
    for (const std::int32_t body : bodies) {
      if (is_zero_row(data.bodies.pose[body])) refuse_world_of(from);  // as if it were absent
      derive_rows(data, body);
    }
  }
  for (std::size_t body = 0; body < has_come.size(); ++body) {
    if (border.owns(static_cast<std::int32_t>(body)) && data.bodies.is_absent[body] != 0)
      throw Error("no rank has sent body " + std::to_string(body));
  }
  take(data, border, arrivals, crew);
}

}  // namespace scree
