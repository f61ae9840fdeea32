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
  for (const auto& [body, to] : given) {
    const std::string name = "give_bodies: body " + std::to_string(body);
    if (body < 0 || std::cmp_greater_equal(body, border.owner.size()) || !border.owns(body))
      throw Error(name + " is not of rank " + std::to_string(border.transport.rank()));
    if (to < 0 || to >= border.transport.ranks()) {
      throw Error(name + " is given to rank " + std::to_string(to) + " of " +
                  std::to_string(border.transport.ranks()));
    }
  }
  std::vector<std::int32_t> bodies;
  for (const GivenBody& one : given) bodies.push_back(one.body);
  std::sort(bodies.begin(), bodies.end());
  const auto twice = std::adjacent_find(bodies.begin(), bodies.end());
  if (twice != bodies.end()) throw Error("give_bodies: body " + std::to_string(*twice) + " is given twice");
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
  // Of pairs that were at rest a rank may know some, even if both bodies were others'.
  const Column<ShapePair>& known = data.contacts.pairs.pair;
  std::erase_if(found, [&](const FoundPair& pair) {
    return std::binary_search(known.begin(), known.end(), pair.sent.pair, comes_before);
  });
  Contacts& contacts = data.contacts;
  std::size_t needed = 0;
  for (const FoundPair& pair : found) needed += static_cast<std::size_t>(pair.sent.contacts);
  // Calls may have changed the setting: the column follows in the next step.
  provide_rows(contacts, needed, 0, data.settings.contact_forces || !contacts.forces.empty());
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

// A body that gets another owner.
struct Move {
  std::int32_t body, from, to;
};

// All ranks tell what they give: the same list everywhere, which ascends.
std::vector<Move> share_moves(Border& border, std::span<const GivenBody> given) {
  const int here = border.transport.rank(), ranks = border.transport.ranks();
  for (int to = 0; to < ranks; ++to) {
    if (to != here) send_list<GivenBody>(border.transport, to, given);
  }
  std::vector<Move> moves;
  const auto note = [&](const GivenBody& one, std::int32_t from) {
    check_owner(border, from, one.body);
    if (one.to < 0 || one.to >= ranks) refuse_world_of(from);
    if (one.to != from) moves.push_back({one.body, from, one.to});
  };
  for (const GivenBody& one : given) note(one, here);
  for (int from = 0; from < ranks; ++from) {
    if (from == here) continue;
    for (const GivenBody& one : receive_list<GivenBody>(border.transport, from)) note(one, from);
  }
  std::sort(moves.begin(), moves.end(),
            [](const Move& one, const Move& other) { return one.body < other.body; });
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].body == moves[i - 1].body) refuse_world_of(moves[i].from);
  }
  return moves;
}

// All that goes to each receiver of these own bodies, none of which is in a pair at rest.
std::vector<Parcel> pack(const WorldData& data, const Border& border, std::span<const std::int32_t> bodies,
                         const std::vector<std::int32_t>& next_owner, std::size_t receivers) {
  std::vector<Parcel> parcels(receivers);
  for (const std::int32_t body : bodies)
    parcels[static_cast<std::size_t>(next_owner[static_cast<std::size_t>(body)])].bodies.push_back(body);
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
}

// Where a body is a ghost, as its owner knows.
struct Loan {
  std::int32_t body, rank;
};

// Of bodies that this rank gives to another, which lends them from now on.
std::vector<Loan> list_loans(const Border& border, std::span<const std::int32_t> bodies, std::int32_t to) {
  std::vector<Loan> loans;
  for (const std::int32_t body : bodies) {
    for (std::int32_t rank = 0; std::cmp_less(rank, border.halos.size()); ++rank) {
      const std::vector<std::int32_t>& lent = border.halos[static_cast<std::size_t>(rank)].lent;
      if (rank != to && std::binary_search(lent.begin(), lent.end(), body)) loans.push_back({body, rank});
    }
    loans.push_back({body, border.here});
  }
  return loans;
}

void check_loan(const Border& border, std::int32_t from, const Loan& loan) {
  check_owner(border, border.here, loan.body);
  if (loan.rank < 0 || std::cmp_greater_equal(loan.rank, border.halos.size()) || loan.rank == border.here)
    refuse_world_of(from);
}

// Ghosts stay where they are, and are lent by the new owners from now on. `loans`: of what this rank has
// taken.
void move_halos(Border& border, const std::vector<Move>& moves, const std::vector<Loan>& loans) {
  std::vector<Loan> borrowed;  // from whom
  for (const Move& move : moves) {
    const std::vector<std::int32_t>& before = border.halos[static_cast<std::size_t>(move.from)].borrowed;
    const bool is_here =
        move.from == border.here || std::binary_search(before.begin(), before.end(), move.body);
    if (is_here && move.to != border.here) borrowed.push_back({move.body, move.to});
  }
  const auto has_moved = [&](std::int32_t body) {
    const auto found =
        std::lower_bound(moves.begin(), moves.end(), body,
                         [](const Move& move, std::int32_t other) { return move.body < other; });
    return found != moves.end() && found->body == body;
  };
  for (Halo& halo : border.halos) {
    std::erase_if(halo.lent, has_moved);
    std::erase_if(halo.borrowed, has_moved);
  }
  for (const auto& [body, rank] : loans) border.halos[static_cast<std::size_t>(rank)].lent.push_back(body);
  for (const auto& [body, rank] : borrowed)
    border.halos[static_cast<std::size_t>(rank)].borrowed.push_back(body);
  for (Halo& halo : border.halos) {
    keep_each_once(halo.lent);
    keep_each_once(halo.borrowed);
  }
}

// What follows from owners in what this rank keeps from step to step.
void note_moves(WorldData& data, Border& border, const std::vector<Move>& moves) {
  bool has_joints = false;
  std::vector<std::int32_t> given;
  for (const Move& move : moves) {
    has_joints = has_joints || data.bodies.first_joint[move.body] >= 0;
    if (move.from == border.here) given.push_back(move.body);
  }
  std::erase_if(border.ghosts, [&](std::int32_t body) { return border.owns(body); });
  border.ghosts.insert(border.ghosts.end(), given.begin(), given.end());
  keep_each_once(border.ghosts);
  border.resting.is_stale = border.events_stale = true;
  data.contacts.pairs_stale = true;
  if (has_joints) border.ties_stale = data.joints.all_changed = true;
}

}  // namespace

void give_bodies(WorldData& data, std::span<const GivenBody> given, Crew& crew) {
  Border& border = *border_of(data);
  check_given(data, border, given);
  place_matter(data);
  wake_neighbors(data);  // while pairs that calls have ended are there, which do not travel
  const std::vector<Move> moves = share_moves(border, given);
  if (moves.empty()) return;
  std::vector<std::int32_t> next_owner = border.owner, own, moved_here;  // `moved_here`: given or taken
  std::vector<std::vector<std::int32_t>> taken(border.halos.size());  // by rank that gives them to this one
  for (const Move& move : moves) {
    next_owner[static_cast<std::size_t>(move.body)] = move.to;
    if (move.from == border.here) own.push_back(move.body);
    if (move.to == border.here) taken[static_cast<std::size_t>(move.from)].push_back(move.body);
    if (move.from == border.here || move.to == border.here) moved_here.push_back(move.body);
  }
  // Pairs at rest travel like others. Of bodies that it takes, too, this rank may know some: of a world that
  // was just shared out all, and those with what calls have made everybody's.
  if (border.halos_stale) {
    pull_all_pairs(data, crew);
  } else {
    pull_pairs_of(data, moved_here, crew);
  }
  if (!own.empty()) {
    const std::vector<Parcel> parcels = pack(data, border, own, next_owner, border.halos.size());
    for (std::size_t place = 0; place < parcels.size(); ++place) {
      if (parcels[place].bodies.empty()) continue;
      const auto to = static_cast<std::int32_t>(place);
      send_parcel(border.transport, to, data, parcels[place]);
      send_list<Loan>(border.transport, to, list_loans(border, parcels[place].bodies, to));
    }
  }
  border.owner = std::move(next_owner);
  Arrivals arrivals;
  std::vector<Loan> loans;
  for (std::size_t place = 0; place < taken.size(); ++place) {
    if (taken[place].empty()) continue;
    const auto from = static_cast<std::int32_t>(place);
    receive_parcel(border.transport, from, data, taken[place], arrivals);
    for (const Loan& loan : receive_list<Loan>(border.transport, from)) {
      check_loan(border, from, loan);
      loans.push_back(loan);
    }
  }
  take(data, border, arrivals, crew);
  move_halos(border, moves, loans);
  note_moves(data, border, moves);
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
  std::vector<std::int32_t> next_owner = border.owner, own;
  for (std::size_t body = 0; body < next_owner.size(); ++body) {
    if (next_owner[body] != border.here) continue;
    own.push_back(static_cast<std::int32_t>(body));
    next_owner[body] = nobody;
  }
  Parcel parcel = std::move(pack(data, border, own, next_owner, border.halos.size() + 1).back());
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
  forget_halos(data, border);
}

}  // namespace scree
