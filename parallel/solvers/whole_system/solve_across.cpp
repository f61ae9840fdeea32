// See solve_across.h.
//
// Ranks send rank 0 what they state, in each substep. It puts the bodies and constraints into the order that
// they have in one process, so that sums come out the same, and sends back what each rank has asked about.
// A constraint across a border is stated by two ranks, from the same numbers: the first one counts. That is
// all the parallelism that these solvers have in a single process, too.
#include <core/world/pair_key.h>
#include <parallel/distributed/messages.h>
#include <parallel/solvers/whole_system/solve_across.h>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace scree {

namespace {

struct SentBody {
  SystemBody body;
  std::int32_t row;
  std::int32_t counts;  // 1: the body is as this rank says
};

// What a constraint is called on all ranks, in the order of StatedWorld.
struct ConstraintName {
  std::int32_t is_contact;
  std::int32_t number;  // of the contacts of a pair
  std::uint64_t item;   // the joint, or the pair

  auto order() const { return std::tuple(is_contact, item, number); }
};

struct SentConstraint {
  ConstraintRows rows;
  ConstraintName name;
  std::int32_t row_a, row_b;  // of bodies
  std::int32_t padding[2];
};

struct SentImpulses {
  float impulse[kMaxConstraintRows];
};

// What one rank states.
struct StatedPart {
  std::vector<SentBody> bodies;
  std::vector<SentConstraint> constraints;
};

StatedPart pack(const StatedWorld& stated, const Contacts& contacts, const Border& border) {
  StatedPart part;
  for (std::size_t i = 1; i < stated.bodies.size(); ++i) {
    const std::int32_t row = stated.row[i];
    part.bodies.push_back({stated.bodies[i], row, speaks_for(border, row) ? 1 : 0});
  }
  ConstraintName last{-1, 0, 0};
  for (std::size_t i = 0; i < stated.constraints.size(); ++i) {
    const StatedConstraint& constraint = stated.constraints[i];
    const std::int32_t item = stated.item[i];
    ConstraintName name{stated.is_contact[i] ? 1 : 0, 0, static_cast<std::uint64_t>(item)};
    if (stated.is_contact[i]) name.item = key_of(contacts.now.pair[item]);
    if (name.is_contact == last.is_contact && name.item == last.item) name.number = last.number + 1;
    part.constraints.push_back({constraint.rows,
                                name,
                                stated.row[static_cast<std::size_t>(constraint.body_a)],
                                stated.row[static_cast<std::size_t>(constraint.body_b)],
                                {}});
    last = name;
  }
  return part;
}

// Bodies and constraints of all ranks, and where each of the parts' has its place.
struct Whole {
  StatedWorld stated;
  std::vector<std::int32_t> place_of_row;                // by row of bodies, among the stated ones
  std::vector<std::vector<std::int32_t>> place_of_sent;  // by rank and place in StatedPart::constraints
};

void put_bodies(const std::vector<StatedPart>& parts, const Border& border, Whole& whole) {
  std::vector<SentBody> bodies;
  for (const StatedPart& part : parts) {
    std::copy_if(part.bodies.begin(), part.bodies.end(), std::back_inserter(bodies),
                 [](const SentBody& sent) { return sent.counts != 0; });
  }
  // Dynamic ones come first, as in Bodies::awake and Bodies::kinematic, which ascend.
  const auto order = [&](const SentBody& sent) {
    return std::pair(border.owner_of(sent.row) == kEveryRank, sent.row);
  };
  std::sort(bodies.begin(), bodies.end(),
            [&](const SentBody& one, const SentBody& other) { return order(one) < order(other); });
  whole.place_of_row.assign(border.owner.size(), 0);
  whole.stated.bodies.push_back({});  // which is every body that is not moving
  whole.stated.row.push_back(kFixedRow);
  for (const SentBody& sent : bodies) {
    whole.place_of_row[static_cast<std::size_t>(sent.row)] =
        static_cast<std::int32_t>(whole.stated.bodies.size());
    whole.stated.bodies.push_back(sent.body);
    whole.stated.row.push_back(sent.row);
  }
}

void put_constraints(const std::vector<StatedPart>& parts, Whole& whole) {
  struct Place {
    ConstraintName name;
    std::int32_t rank, place;
  };
  std::vector<Place> places;
  for (std::size_t rank = 0; rank < parts.size(); ++rank) {
    whole.place_of_sent.emplace_back(parts[rank].constraints.size());
    for (std::size_t i = 0; i < parts[rank].constraints.size(); ++i)
      places.push_back(
          {parts[rank].constraints[i].name, static_cast<std::int32_t>(rank), static_cast<std::int32_t>(i)});
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& one, const Place& other) {
    return one.name.order() < other.name.order();
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto rank = static_cast<std::size_t>(places[i].rank),
               place = static_cast<std::size_t>(places[i].place);
    if (i == 0 || places[i - 1].name.order() < places[i].name.order()) {
      const SentConstraint& sent = parts[rank].constraints[place];
      const auto place_of = [&](std::int32_t row) {
        return whole.place_of_row[static_cast<std::size_t>(row)];
      };
      whole.stated.constraints.push_back({sent.rows, place_of(sent.row_a), place_of(sent.row_b)});
    }
    whole.place_of_sent[rank][place] = static_cast<std::int32_t>(whole.stated.constraints.size() - 1);
  }
}

// What a rank learns of the answer, in the order in which it has sent its part.
struct Share {
  std::vector<VelocityRow> velocities;
  std::vector<SentImpulses> impulses;
};

Share share_of(const Whole& whole, const StatedPart& part, std::size_t rank) {
  Share share;
  for (const SentBody& sent : part.bodies) {
    const auto place = static_cast<std::size_t>(whole.place_of_row[static_cast<std::size_t>(sent.row)]);
    share.velocities.push_back(whole.stated.bodies[place].velocity);
  }
  for (const std::int32_t place : whole.place_of_sent[rank]) {
    const ConstraintRows& rows = whole.stated.constraints[static_cast<std::size_t>(place)].rows;
    SentImpulses& sent = share.impulses.emplace_back();
    for (int slot = 0; slot < kMaxConstraintRows; ++slot) sent.impulse[slot] = rows.row[slot].impulse;
  }
  return share;
}

void take(const Share& share, std::int32_t from, StatedWorld& stated) {
  if (share.velocities.size() + 1 != stated.bodies.size() ||
      share.impulses.size() != stated.constraints.size())
    refuse_world_of(from);
  for (std::size_t i = 0; i < share.velocities.size(); ++i)
    stated.bodies[i + 1].velocity = share.velocities[i];
  for (std::size_t i = 0; i < share.impulses.size(); ++i) {
    for (int slot = 0; slot < kMaxConstraintRows; ++slot)
      stated.constraints[i].rows.row[slot].impulse = share.impulses[i].impulse[slot];
  }
}

StatedPart receive_part(Border& border, std::int32_t from) {
  StatedPart part{receive_list<SentBody>(border.transport, from),
                  receive_list<SentConstraint>(border.transport, from)};
  const auto is_row = [&](std::int32_t row) { return row >= 0 && std::cmp_less(row, border.owner.size()); };
  for (const SentBody& sent : part.bodies) {
    if (!is_row(sent.row)) refuse_world_of(from);
  }
  for (const SentConstraint& sent : part.constraints) {
    if (!is_row(sent.row_a) || !is_row(sent.row_b)) refuse_world_of(from);
  }
  return part;
}

}  // namespace

SystemAnswer solve_across(StatedWorld& stated, const Contacts& contacts, Border& border,
                          const SystemPolicy& policy, const ReferenceOptions& options) {
  CountedTransport& transport = border.transport;
  StatedPart own = pack(stated, contacts, border);
  if (border.here != 0) {
    send_list<SentBody>(transport, 0, own.bodies);
    send_list<SentConstraint>(transport, 0, own.constraints);
    const std::vector<SystemAnswer> answer = receive_list<SystemAnswer>(transport, 0);
    if (answer.size() != 1) refuse_world_of(0);
    take({receive_list<VelocityRow>(transport, 0), receive_list<SentImpulses>(transport, 0)}, 0, stated);
    return answer[0];
  }
  std::vector<StatedPart> parts;
  parts.push_back(std::move(own));
  for (std::int32_t from = 1; from < transport.ranks(); ++from) parts.push_back(receive_part(border, from));
  Whole whole;
  put_bodies(parts, border, whole);
  put_constraints(parts, whole);
  const SystemAnswer answer = solve_stated(whole.stated, policy, options);
  for (std::int32_t to = 1; to < transport.ranks(); ++to) {
    const auto rank = static_cast<std::size_t>(to);
    const Share share = share_of(whole, parts[rank], rank);
    send_list<SystemAnswer>(transport, to, std::span(&answer, 1));
    send_list<VelocityRow>(transport, to, share.velocities);
    send_list<SentImpulses>(transport, to, share.impulses);
  }
  take(share_of(whole, parts[0], 0), 0, stated);
  return answer;
}

}  // namespace scree
