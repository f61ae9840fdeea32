// Which velocities are sent before which colors, and what else ranks tell each other during a step; see
// border.h.
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <parallel/stages.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

namespace scree {

namespace {

// A constraint of a body at the border: when it is solved, and which other rank computes it; this one if no
// other does.
struct Use {
  std::int32_t body, turn, rank;
};

// What is sent when.
struct Refresh {
  std::int32_t turn, body;
};

// One body's uses -> when this neighbor needs its velocity: before a constraint that both compute, and at the
// end of a pass, if one that the neighbor does not know has changed it since.
void plan_for(std::span<const Use> uses, const Neighbor& with, std::int32_t turns,
              std::vector<Refresh>& plan) {
  bool stale = false;
  for (const Use& use : uses) {
    if (use.rank != with.rank) {
      stale = true;
    } else if (std::exchange(stale, false)) {
      plan.push_back({use.turn, use.body});
    }
  }
  if (stale) plan.push_back({turns, uses.front().body});
}

// `plan` ascends by turn.
BodiesByTurn lay_out(std::span<const Refresh> plan, std::int32_t turns) {
  BodiesByTurn way;
  way.ends.assign(static_cast<std::size_t>(turns) + 1, 0);
  for (const Refresh& refresh : plan) {
    way.bodies.push_back(refresh.body);
    ++way.ends[static_cast<std::size_t>(refresh.turn)];
  }
  for (std::size_t turn = 1; turn < way.ends.size(); ++turn) way.ends[turn] += way.ends[turn - 1];
  return way;
}

void sort_by_turn(std::vector<Refresh>& plan) {
  std::sort(plan.begin(), plan.end(), [](const Refresh& one, const Refresh& other) {
    return std::tie(one.turn, one.body) < std::tie(other.turn, other.body);
  });
}

struct TurnOf {
  const Constraints& constraints;
  const Border& border;
  std::int32_t first_joint;
  const Turns& turns;
  std::int32_t operator()(std::int32_t edge) const {
    const int place = place_of(constraints.edges[edge]);
    if (place == 0) {
      const auto of_edge = std::lower_bound(border.levels.begin(), border.levels.end(), std::pair(edge, 0));
      const auto level = static_cast<std::size_t>(of_edge->second);
      return edge >= first_joint ? turns.of_joint_levels[level] : turns.of_contact_levels[level];
    }
    return edge >= first_joint ? turns.of_joints[place] : turns.of_contacts[place];
  }
};

// What hubs do to bodies of other ranks. Both sides know these constraints.
void plan_returns(const Border& border, Neighbor& with, const TurnOf& turn_of, std::int32_t turns) {
  std::vector<Refresh> returned, taken;
  for (const std::int32_t place : with.edges) {
    const Edge& edge = turn_of.constraints.edges[place];
    if (!is_grouped(edge)) continue;
    const std::int32_t body = edge.kind == EdgeKind::hub_a ? edge.body_b : edge.body_a;
    (border.owns(body) ? taken : returned).push_back({turn_of(place), body});
  }
  sort_by_turn(returned);
  sort_by_turn(taken);
  with.returned = lay_out(returned, turns);
  with.taken = lay_out(taken, turns);
  keep_each_once(with.returned_once = with.returned.bodies);
  keep_each_once(with.taken_once = with.taken.bodies);
}

std::vector<Use> uses_at_border(const Border& border, const TurnOf& turn_of) {
  std::vector<std::uint8_t> at_border(border.owner.size(), 0);
  for (const Neighbor& with : border.neighbors) {
    for (const std::int32_t body : with.own) at_border[static_cast<std::size_t>(body)] = 1;
  }
  const std::int32_t here = border.transport.rank();
  std::vector<Use> uses;
  const auto count = static_cast<std::int32_t>(turn_of.constraints.edges.size());
  for (std::int32_t i = 0; i < count; ++i) {
    const Edge& edge = turn_of.constraints.edges[i];
    const std::int32_t turn = turn_of(i);
    const auto add = [&](std::int32_t body, std::int32_t other, bool alone) {
      if (!border.owns(body) || at_border[static_cast<std::size_t>(body)] == 0) return;
      const std::int32_t rank = border.owner_of(other);
      uses.push_back({body, turn, alone || rank == kEveryRank ? here : rank});
    };
    const bool grouped = is_grouped(edge);
    if (edge.kind != EdgeKind::pushed_b)
      add(edge.body_a, edge.body_b, grouped && edge.kind == EdgeKind::hub_a);
    add(edge.body_b, edge.body_a, grouped && edge.kind == EdgeKind::hub_b);
  }
  std::sort(uses.begin(), uses.end(), [](const Use& one, const Use& other) {
    return std::tie(one.body, one.turn, one.rank) < std::tie(other.body, other.turn, other.rank);
  });
  return uses;
}

}  // namespace

void count_everywhere(const Constraints& constraints, Border& border, std::span<std::int64_t> in_place) {
  border.levels.clear();
  std::fill(in_place.begin(), in_place.end(), 0);
  for (const Edge& edge : constraints.edges) {
    const std::int32_t counts = edge.kind == EdgeKind::pushed_b ? edge.body_b : edge.body_a;
    if (border.owns(counts)) ++in_place[static_cast<std::size_t>(place_of(edge))];
  }
  border.transport.add_up(in_place);
}

void plan_refreshes(const Constraints& constraints, Border& border, std::int32_t first_joint,
                    const Turns& turns) {
  border.turns = turns.count;
  const TurnOf turn_of{constraints, border, first_joint, turns};
  border.begin_hubs = border.end_hubs = 0;
  for (int place = kFirstHubPlace; place < kFirstDynamicPlace; ++place) {
    const std::int32_t turn = turns.of_contacts[place];
    if (turn == kNoTurn) continue;
    border.begin_hubs = border.end_hubs == 0 ? turn : std::min(border.begin_hubs, turn);
    border.end_hubs = std::max(border.end_hubs, turn + 1);
  }
  const std::vector<Use> uses = uses_at_border(border, turn_of);
  for (Neighbor& with : border.neighbors) {
    std::vector<Refresh> plan;
    auto begin = uses.begin();
    for (const std::int32_t body : with.own) {
      begin = std::find_if(begin, uses.end(), [&](const Use& use) { return use.body == body; });
      const auto end = std::find_if(begin, uses.end(), [&](const Use& use) { return use.body != body; });
      plan_for({begin, end}, with, turns.count, plan);
      begin = end;
    }
    sort_by_turn(plan);
    with.sent = lay_out(plan, turns.count);
    send_list<Refresh>(border.transport, with.rank, plan);
    plan_returns(border, with, turn_of, turns.count);
  }
  for (Neighbor& with : border.neighbors) {
    const std::vector<Refresh> plan = receive_list<Refresh>(border.transport, with.rank);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const Refresh& refresh = plan[i];
      if (i > 0 && refresh.turn < plan[i - 1].turn) refuse_world_of(with.rank);
      if (refresh.turn < 0 || refresh.turn > turns.count) refuse_world_of(with.rank);
      check_owner(border, with.rank, refresh.body);
    }
    with.received = lay_out(plan, turns.count);
  }
}

template <class Row>
void RefreshedPass::exchange(std::int32_t turn, Column<Row>& rows) {
  const auto both_ways = [&](const BodiesByTurn Neighbor::*from, const BodiesByTurn Neighbor::*to,
                             std::int32_t at) {
    for (const Neighbor& with : border_->neighbors) {
      const auto sent = (with.*from).at(at);
      if (!sent.empty())
        send_rows<Row>(border_->transport, with.rank, sent, [&](std::int32_t body) { return rows[body]; });
    }
    for (const Neighbor& with : border_->neighbors) {
      const auto received = (with.*to).at(at);
      if (received.empty()) continue;
      receive_rows<Row>(border_->transport, with.rank, received,
                        [&](std::int32_t body, const Row& row) { rows[body] = row; });
    }
  };
  // First what hubs have done in the turn before: owners may have to send it on.
  if (turn > 0) both_ways(&Neighbor::returned, &Neighbor::taken, turn - 1);
  both_ways(&Neighbor::sent, &Neighbor::received, turn);
}

void RefreshedPass::refresh(std::int32_t turn) {
  if (what_ == Refreshed::velocity) {
    exchange(turn, bodies_.velocity);
  } else {
    exchange(turn, bodies_.delta);
  }
}

void share_notes(const Constraints& constraints, Border& border, std::int32_t contacts, Bodies& bodies) {
  for (const Neighbor& with : border.neighbors) {  // contacts that the owners of hubs alone prepare
    for (const std::int32_t place : with.edges) {
      const Edge& edge = constraints.edges[place];
      if (place >= contacts || computes(border, edge)) continue;
      bodies.step_notes[border.owns(edge.body_a) ? edge.body_a : edge.body_b] |= std::uint8_t{kHasContacts};
    }
  }
  share_rows<std::uint8_t>(border, bodies.step_notes);
}

void SharedImpactTimes::before(std::int32_t turn) {
  if (border_ == nullptr) return;
  if (!has_begun_ && turn >= border_->begin_hubs) {
    has_begun_ = true;
    for (const Neighbor& with : border_->neighbors) {
      for (const std::int32_t body : with.returned_once)
        constraints_.impact_times[body] = {simd::kNoImpact, simd::kNoImpact};
    }
  }
  if (has_ended_ || turn < border_->end_hubs) return;
  has_ended_ = true;
  for (const Neighbor& with : border_->neighbors) {
    for (const std::int32_t body : with.returned_once) of_groups_.push_back(constraints_.impact_times[body]);
  }
}

void SharedImpactTimes::finish(bool found) {
  if (border_ == nullptr) return;
  before(border_->turns);
  if (!found) return;
  std::size_t begin = 0;
  for (const Neighbor& with : border_->neighbors) {
    const std::size_t count = with.returned_once.size();
    if (count > 0)
      send_list<simd::ImpactTimes>(border_->transport, with.rank,
                                   std::span(of_groups_).subspan(begin, count));
    begin += count;
  }
  for (const Neighbor& with : border_->neighbors) {
    if (with.taken_once.empty()) continue;
    receive_rows<simd::ImpactTimes>(border_->transport, with.rank, with.taken_once,
                                    [&](std::int32_t body, const simd::ImpactTimes& told) {
                                      simd::ImpactTimes& times = constraints_.impact_times[body];
                                      for (const float time : {told.first, told.second}) {
                                        times.second = std::min(times.second, std::max(times.first, time));
                                        times.first = std::min(times.first, time);
                                      }
                                    });
  }
  share_rows<simd::ImpactTimes>(*border_, constraints_.impact_times);
}

void share_impulses(const Constraints& constraints, Border& border, WorldData& data) {
  const auto contacts = static_cast<std::int32_t>(data.contacts.active.size());
  const auto list = [&](const Neighbor& with, bool joints, bool here) {
    std::vector<std::int32_t> places;
    std::copy_if(with.edges.begin(), with.edges.end(), std::back_inserter(places), [&](std::int32_t place) {
      const Edge& edge = constraints.edges[place];
      return is_grouped(edge) && (place >= contacts) == joints && computes(border, edge) == here;
    });
    return places;
  };
  const auto share = [&]<class Row>(bool joints, auto&& row_of, auto&& take, const Row&) {
    for (const Neighbor& with : border.neighbors) {
      const std::vector<std::int32_t> given = list(with, joints, true);
      if (!given.empty()) send_rows<Row>(border.transport, with.rank, given, row_of);
    }
    for (const Neighbor& with : border.neighbors) {
      const std::vector<std::int32_t> taken = list(with, joints, false);
      if (!taken.empty()) receive_rows<Row>(border.transport, with.rank, taken, take);
    }
  };
  struct Borne {
    Manifold manifold;
    ContactSurface surface;  // of rich contacts
    ContactForceRow force;
    float impulse;
  };
  Contacts& all = data.contacts;
  const bool forces = !all.forces.empty(), events = asks_for_events(data);
  share(
      false,
      [&](std::int32_t place) {
        const std::int32_t contact = all.active[place];
        return Borne{all.now.manifold[contact], all.now.surface[contact],
                     forces ? all.forces[contact] : ContactForceRow{},
                     events ? data.events.impulse[contact] : 0.0f};
      },
      [&](std::int32_t place, const Borne& borne) {
        const std::int32_t contact = all.active[place];
        all.now.manifold[contact] = borne.manifold;
        all.now.surface[contact] = borne.surface;
        if (forces) all.forces[contact] = borne.force;
        if (events) data.events.impulse[contact] = borne.impulse;
      },
      Borne{});
  struct BorneByJoint {
    JointImpulses impulses;
    JointReactionRow reaction;
  };
  Joints& joints = data.joints;
  share(
      true,
      [&](std::int32_t place) {
        const std::int32_t joint = joints.active[place - contacts];
        return BorneByJoint{joints.impulses[joint], joints.reaction[joint]};
      },
      [&](std::int32_t place, const BorneByJoint& borne) {
        const std::int32_t joint = joints.active[place - contacts];
        joints.impulses[joint] = borne.impulses;
        joints.reaction[joint] = borne.reaction;
      },
      BorneByJoint{});
}

void share_motion(Border& border, Bodies& bodies) {
  struct Motion {
    VelocityRow velocity;
    DeltaRow delta;
    std::int32_t notes;
  };
  share_halos<Motion>(
      border, [&](std::int32_t body) { return (bodies.flags[body] & kBodyAsleep) == 0; },
      [&](std::int32_t body) {
        return Motion{bodies.velocity[body], bodies.delta[body], bodies.step_notes[body]};
      },
      [&](std::int32_t body, const Motion& motion) {
        bodies.velocity[body] = motion.velocity;
        bodies.delta[body] = motion.delta;
        bodies.step_notes[body] = static_cast<std::uint8_t>(motion.notes);
      });
}

void share_broken(Border& border, const WorldData& data, Column<JointId>& broken) {
  if (data.joints.flags.empty()) return;
  auto any = static_cast<std::int64_t>(broken.size());
  border.transport.add_up({&any, 1});
  if (any == 0) return;
  std::vector<std::uint32_t> all;
  for (const JointId id : broken) all.push_back(id.index);
  all = gather_lists(border.transport, all, [&](std::uint32_t joint) {
    return joint < data.joints.flags.size() && (data.joints.flags[joint] & kJointAlive) != 0;
  });
  keep_each_once(all);
  broken.clear();
  for (const std::uint32_t joint : all)
    broken.push_back(joint_handle(data, static_cast<std::int32_t>(joint)));
}

}  // namespace scree
