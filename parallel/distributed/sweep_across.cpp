// See sweep_across.h.
#include <parallel/continuous/sweep_moving.h>
#include <parallel/continuous/sweep_near.h>
#include <parallel/distributed/box_index.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>
#include <parallel/distributed/sweep_across.h>
#include <parallel/stages.h>
#include <scree/error.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

namespace scree {

namespace {

using sweeps::MovingPair;
using sweeps::place_of;
using sweeps::StepEnd;

// What the sweeps read of a body that moves; and of its shapes, where they are as the step begins.
struct SweptBody {
  PoseRow pose;
  VelocityRow velocity;
  DeltaRow delta;
  std::int32_t body, notes;
};

// What becomes of a body's step.
struct SweptStep {
  VelocityRow velocity;
  DeltaRow delta;
  StepEnd end;
};

bool is_fast_note(const Bodies& bodies, std::int32_t body) {
  return (bodies.step_notes[body] & kIsFast) != 0 && !is_asleep(bodies, body);
}

void append_sorted(Column<std::int32_t>& fast, std::vector<std::int32_t> more) {
  if (more.empty()) return;
  keep_each_once(more);
  std::vector<std::int32_t> all;
  all.reserve(fast.size() + more.size());
  std::set_union(fast.begin(), fast.end(), more.begin(), more.end(), std::back_inserter(all));
  fast.resize_discarding(all.size());
  std::copy(all.begin(), all.end(), fast.begin());
}

// Around all that the body may come to in this step: what holds it may turn its way aside, but not make it
// longer. `carried`: m, beyond that.
BoundsRow reach_of(const WorldData& data, std::int32_t body, float carried) {
  const sweeps::Reach way = sweeps::reach_of_way(data, body);
  const sweeps::Swept box(way.start, way.start, way.radius + length(way.end - way.start) + carried);
  BoundsRow reach{};
  for (int axis = 0; axis < 3; ++axis) {
    reach.lower[axis] = box.lower[axis];
    reach.upper[axis] = box.upper[axis];
  }
  return reach;
}

// Whether that leaves the bounds that ghosts were found by. Parts of a compound have bounds of their own,
// with room between them.
bool strays(const WorldData& data, std::int32_t body, const BoundsRow& reach) {
  const std::int32_t shape = data.bodies.first_shape[body];
  if (shape < 0) return false;
  if (data.shapes.next[shape] >= 0) return true;
  const BoundsRow& bounds = data.shapes.fat_bounds[shape];
  for (int axis = 0; axis < 3; ++axis) {
    if (!(bounds.lower[axis] <= reach.lower[axis] && reach.upper[axis] <= bounds.upper[axis])) return true;
  }
  return false;
}

std::int32_t body_of(const WorldData& data, const MovingPair& pair, int side) {
  return data.shapes.body[pair.shape[side]];
}

// All rows of bodies, for ranks on which they are absent and stay so.
void send_matter(Transport& transport, std::int32_t to, const WorldData& data,
                 const std::vector<std::int32_t>& sent) {
  const std::vector<std::int32_t> shapes = shapes_of(data, sent);
  std::vector<std::byte> message(sent.size() * bytes_of_row(data.bodies) +
                                 shapes.size() * bytes_of_row(data.shapes));
  std::byte* end = message.data();
  append_rows(data.bodies, sent, end);
  append_rows(data.shapes, shapes, end);
  transport.send(to, message);
}

void receive_matter(Transport& transport, std::int32_t from, WorldData& data,
                    const std::vector<std::int32_t>& received) {
  const std::vector<std::int32_t> shapes = shapes_of(data, received);
  const std::span<const std::byte> message = transport.receive(from);
  if (message.size() !=
      received.size() * bytes_of_row(data.bodies) + shapes.size() * bytes_of_row(data.shapes))
    refuse_world_of(from);
  const std::byte* next = message.data();
  const Bodies& bodies = data.bodies;
  take_rows(data.bodies, received, next, [&](std::int32_t body) { return is_absent(bodies, body); });
  take_rows(data.shapes, shapes, next,
            [&](std::int32_t shape) { return is_absent(bodies, data.shapes.body[shape]); });
}

SweptBody swept_body(const WorldData& data, std::int32_t body) {
  const Bodies& bodies = data.bodies;
  return {bodies.pose[body], bodies.velocity[body], bodies.delta[body], body, bodies.step_notes[body]};
}

}  // namespace

bool SweepAcross::is_own_fast(std::int32_t place) const {
  return place >= 0 && border_->owns(broad_phase_.fast[place]);
}

bool SweepAcross::share_fast() {
  Bodies& bodies = data_.bodies;
  Column<std::int32_t>& fast = broad_phase_.fast;
  if (border_ == nullptr) return !fast.empty();
  auto count = static_cast<std::int64_t>(fast.size());
  border_->transport.add_up({&count, 1});
  if (count == 0) return false;
  for (const std::int32_t body : fast) bodies.step_notes[body] |= std::uint8_t{kIsFast};
  std::vector<std::int32_t> ghosts;
  share_halos<std::uint8_t>(
      *border_, [&](std::int32_t body) { return !is_asleep(bodies, body); },
      [&](std::int32_t body) { return std::uint8_t{place_of(fast, body) >= 0}; },
      [&](std::int32_t body, std::uint8_t is) {
        std::uint8_t& notes = bodies.step_notes[body];
        notes = static_cast<std::uint8_t>(is != 0 ? notes | kIsFast : notes & ~kIsFast);
        if (is != 0) ghosts.push_back(body);
      });
  append_sorted(fast, std::move(ghosts));
  return true;
}

void SweepAcross::bring_sleepers() {
  if (border_ == nullptr) return;
  std::int64_t asleep = data_.bodies.asleep;
  border_->transport.add_up({&asleep, 1});
  any_asleep_ = asleep > 0;
  if (!any_asleep_) return;
  std::vector<BoundsRow> ways;
  for (const std::int32_t body : broad_phase_.fast) {
    if (!border_->owns(body) || !sweeps::has_finite_motion(data_.bodies.delta[body])) continue;
    const BoundsRow reach = reach_of(data_, body, 0.0f);
    if (strays(data_, body, reach)) ways.push_back(reach);
  }
  bring_sleepers(ways);
}

void SweepAcross::bring_sleepers_to_carried() {
  if (border_ == nullptr || !any_asleep_) return;
  std::vector<BoundsRow> ways;
  for (std::size_t place = 0; place < broad_phase_.fast.size(); ++place) {
    const std::int32_t body = broad_phase_.fast[place];
    const float carried = length(broad_phase_.step_ends[place].carried);
    if (border_->owns(body) && carried > 0.0f) ways.push_back(reach_of(data_, body, carried));
  }
  bring_sleepers(ways);
}

// Own sleeping bodies that another rank's bodies may come to, and that are not lent to it.
std::vector<std::int32_t> SweepAcross::sleepers_on(const BoxIndex& ways, std::int32_t rank) const {
  const std::vector<std::int32_t>& lent = border_->halos[static_cast<std::size_t>(rank)].lent;
  std::vector<std::int32_t> met;
  for (const std::int32_t shape : border_->resting.shapes) {
    const std::int32_t body = data_.shapes.body[shape];
    // What has fallen asleep in this step is in no frozen tree yet, and in nobody's way.
    if (rests_here(data_, *border_, shape) && is_frozen_tree(broad_phase_.tree_of[shape]) &&
        !std::binary_search(lent.begin(), lent.end(), body) && ways.meets(data_.shapes.fat_bounds[shape]))
      met.push_back(body);
  }
  keep_each_once(met);
  return met;
}

void SweepAcross::bring_sleepers(const std::vector<BoundsRow>& ways) {
  auto count = static_cast<std::int64_t>(ways.size());
  border_->transport.add_up({&count, 1});
  if (count == 0) return;
  const std::int32_t here = border_->transport.rank(), ranks = border_->transport.ranks();
  for (std::int32_t to = 0; to < ranks; ++to) {
    if (to == here) continue;
    std::vector<BoundsRow> near;
    std::copy_if(ways.begin(), ways.end(), std::back_inserter(near), [&](const BoundsRow& way) {
      return bounds_meet(way, border_->around[static_cast<std::size_t>(to)]);
    });
    send_list<BoundsRow>(border_->transport, to, near);
  }
  for (std::int32_t to = 0; to < ranks; ++to) {
    if (to == here) continue;
    std::vector<BoundsRow> near = receive_list<BoundsRow>(border_->transport, to);
    const std::vector<std::int32_t> met =
        near.empty() ? std::vector<std::int32_t>() : sleepers_on(BoxIndex(std::move(near)), to);
    send_list<std::int32_t>(border_->transport, to, met);
    send_bodies(border_->transport, to, data_, met);
  }
  std::vector<std::int32_t> come;
  for (std::int32_t from = 0; from < ranks; ++from) {
    if (from == here) continue;
    const std::vector<std::int32_t> bodies = receive_list<std::int32_t>(border_->transport, from);
    for (const std::int32_t body : bodies) check_owner(*border_, from, body);
    receive_bodies(border_->transport, from, data_, bodies);
    come.insert(come.end(), bodies.begin(), bodies.end());
  }
  if (!come.empty()) enter_ghosts(data_, come, crew_);
}

// Keeps the pairs of which this rank has a fast body. Returns whether any has one of another rank, too.
bool SweepAcross::keep_known_pairs() {
  Column<MovingPair>& pairs = broad_phase_.meeting_pairs;
  auto* const end = std::remove_if(pairs.begin(), pairs.end(), [&](const MovingPair& pair) {
    return !is_own_fast(pair.place[0]) && !is_own_fast(pair.place[1]);
  });
  pairs.resize(static_cast<std::size_t>(end - pairs.begin()));
  return std::any_of(pairs.begin(), pairs.end(), [&](const MovingPair& pair) {
    return pair.place[0] >= 0 && pair.place[1] >= 0 &&
           is_own_fast(pair.place[0]) != is_own_fast(pair.place[1]);
  });
}

// Returns for each place in `fast` the place of its chain's smallest body, as far as this rank knows.
std::vector<std::int32_t> SweepAcross::link_chains() const {
  std::vector<std::int32_t> parent(broad_phase_.fast.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root_of = [&](std::int32_t place) {
    while (parent[static_cast<std::size_t>(place)] != place)
      place = parent[static_cast<std::size_t>(place)] =
          parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(place)])];
    return place;
  };
  for (const MovingPair& pair : broad_phase_.meeting_pairs) {
    if (pair.place[0] < 0 || pair.place[1] < 0) continue;
    const auto [low, high] = std::minmax({root_of(pair.place[0]), root_of(pair.place[1])});
    parent[static_cast<std::size_t>(high)] = low;
  }
  for (std::size_t place = 0; place < parent.size(); ++place)
    parent[place] = root_of(static_cast<std::int32_t>(place));
  return parent;
}

// Makes of the places of roots the smallest body of each chain that reaches over ranks; -1 for others.
void SweepAcross::spread_chains(std::vector<std::int32_t>& chain_of) {
  struct Chain {
    std::int32_t smallest, is_shared;
  };
  const Column<std::int32_t>& fast = broad_phase_.fast;
  std::vector<Chain> chains;
  for (const std::int32_t body : fast) chains.push_back({body, 0});
  const auto chain_at = [&](std::int32_t place) -> Chain& {
    return chains[static_cast<std::size_t>(chain_of[static_cast<std::size_t>(place)])];
  };
  for (const MovingPair& pair : broad_phase_.meeting_pairs) {
    if (pair.place[0] >= 0 && pair.place[1] >= 0 && is_own_fast(pair.place[0]) != is_own_fast(pair.place[1]))
      chain_at(pair.place[0]).is_shared = 1;
  }
  std::int64_t news = 1;
  while (news > 0) {
    news = 0;
    share_halos<Chain>(
        *border_, [&](std::int32_t body) { return is_fast_note(data_.bodies, body); },
        [&](std::int32_t body) { return chain_at(place_of(fast, body)); },
        [&](std::int32_t body, const Chain& told) {
          Chain& chain = chain_at(place_of(fast, body));
          if (told.smallest < 0 || std::cmp_greater_equal(told.smallest, border_->owner.size()))
            refuse_world_of(border_->owner_of(body));
          if (told.smallest >= chain.smallest && told.is_shared <= chain.is_shared) return;
          chain.smallest = std::min(chain.smallest, told.smallest);
          chain.is_shared = std::max(chain.is_shared, told.is_shared);
          news = 1;
        });
    border_->transport.add_up({&news, 1});
  }
  for (std::size_t place = 0; place < chain_of.size(); ++place) {
    // Roots are read before they are overwritten: a root's place is the smallest of its chain.
    const Chain& chain = chains[static_cast<std::size_t>(chain_of[place])];
    chain_of[place] = chain.is_shared != 0 ? chain.smallest : -1;
  }
}

// Sends the chains that others decide about, and takes those that this rank does.
void SweepAcross::send_chains(const std::vector<std::int32_t>& chain_of) {
  struct Parcel {
    std::vector<std::int32_t> bodies, companions;
    std::vector<ShapePair> pairs;
  };
  const std::int32_t here = border_->transport.rank(), ranks = border_->transport.ranks();
  const Column<std::int32_t>& fast = broad_phase_.fast;
  std::vector<Parcel> parcels(static_cast<std::size_t>(ranks));
  const auto decider_of = [&](std::int32_t place) {
    const std::int32_t chain = chain_of[static_cast<std::size_t>(place)];
    return chain < 0 ? here : border_->owner_of(chain);
  };
  for (std::int32_t place = 0; std::cmp_less(place, fast.size()); ++place) {
    if (is_own_fast(place) && decider_of(place) != here)
      parcels[static_cast<std::size_t>(decider_of(place))].bodies.push_back(fast[place]);
  }
  std::vector<MovingPair> kept;
  for (const MovingPair& pair : broad_phase_.meeting_pairs) {
    // Of a pair that two ranks know, the owner of the first body tells.
    const int told_by = pair.place[0] >= 0 ? 0 : 1;
    if (!is_own_fast(pair.place[told_by])) continue;
    const std::int32_t decider = decider_of(pair.place[told_by]);
    if (decider == here) {
      kept.push_back(pair);
      continue;
    }
    Parcel& parcel = parcels[static_cast<std::size_t>(decider)];
    parcel.pairs.push_back({pair.shape[0], pair.shape[1]});
    for (int side = 0; side < 2; ++side) {
      const std::int32_t body = body_of(data_, pair, side);
      if (pair.place[side] < 0 && data_.bodies.type[body] == BodyType::dynamic)
        parcel.companions.push_back(body);
    }
  }
  for (std::int32_t to = 0; to < ranks; ++to) {
    if (to == here) continue;
    Parcel& parcel = parcels[static_cast<std::size_t>(to)];
    send_list<std::int32_t>(border_->transport, to, parcel.bodies);
    std::vector<std::int32_t> all = parcel.bodies;
    all.insert(all.end(), parcel.companions.begin(), parcel.companions.end());
    send_rows<SweptBody>(border_->transport, to, all,
                         [&](std::int32_t body) { return swept_body(data_, body); });
    send_matter(border_->transport, to, data_, all);
    send_rows<PoseRow>(border_->transport, to, shapes_of(data_, all),
                       [&](std::int32_t shape) { return data_.shapes.pose[shape]; });
    send_list<ShapePair>(border_->transport, to, parcel.pairs);
    visits_[static_cast<std::size_t>(to)].sent = std::move(parcel.bodies);
  }
  std::vector<std::int32_t> visitors;
  for (std::int32_t from = 0; from < ranks; ++from) {
    if (from == here) continue;
    Visit& visit = visits_[static_cast<std::size_t>(from)];
    visit.received = receive_list<std::int32_t>(border_->transport, from);
    for (const std::int32_t body : visit.received) check_owner(*border_, from, body);
    std::vector<std::int32_t> all;
    const std::vector<SweptBody> rows = receive_list<SweptBody>(border_->transport, from);
    for (const SweptBody& row : rows) {
      if (row.body < 0 || std::cmp_greater_equal(row.body, border_->owner.size())) refuse_world_of(from);
      all.push_back(row.body);
    }
    receive_matter(border_->transport, from, data_, all);
    for (const SweptBody& row : rows) {
      if (border_->owns(row.body)) continue;  // a companion, which is here as it is there
      data_.bodies.pose[row.body] = row.pose;
      data_.bodies.velocity[row.body] = row.velocity;
      data_.bodies.delta[row.body] = row.delta;
      data_.bodies.step_notes[row.body] = static_cast<std::uint8_t>(row.notes);
    }
    receive_rows<PoseRow>(border_->transport, from, shapes_of(data_, all),
                          [&](std::int32_t shape, const PoseRow& pose) { data_.shapes.pose[shape] = pose; });
    for (const ShapePair& pair : receive_list<ShapePair>(border_->transport, from)) {
      const auto shapes = static_cast<std::int64_t>(data_.shapes.flags.size());
      if (pair.a < 0 || pair.b < 0 || pair.a >= shapes || pair.b >= shapes) refuse_world_of(from);
      kept.push_back({{pair.a, pair.b}, {-1, -1}});
    }
    visitors.insert(visitors.end(), visit.received.begin(), visit.received.end());
  }
  admit(std::move(visitors), kept);
}

void SweepAcross::admit(std::vector<std::int32_t> visitors, const std::vector<MovingPair>& pairs) {
  Column<std::int32_t>& fast = broad_phase_.fast;
  const std::vector<std::int32_t> before(fast.begin(), fast.end());
  const std::vector<StepEnd> ends(broad_phase_.step_ends.begin(), broad_phase_.step_ends.end());
  append_sorted(fast, std::move(visitors));
  broad_phase_.step_ends.resize_discarding(fast.size());
  std::fill(broad_phase_.step_ends.begin(), broad_phase_.step_ends.end(), StepEnd{});
  for (std::size_t i = 0; i < before.size(); ++i) broad_phase_.step_ends[place_of(fast, before[i])] = ends[i];
  Column<MovingPair>& all = broad_phase_.meeting_pairs;
  all.resize_discarding(pairs.size());
  std::copy(pairs.begin(), pairs.end(), all.begin());
  for (MovingPair& pair : all) {
    for (int side = 0; side < 2; ++side) pair.place[side] = place_of(fast, body_of(data_, pair, side));
    if (pair.place[0] < 0 && pair.place[1] < 0)
      throw Error("sweep_fast_bodies: another rank has sent a pair of which no body is fast");
  }
  std::sort(all.begin(), all.end(), [](const MovingPair& one, const MovingPair& other) {
    return std::tie(one.shape[0], one.shape[1]) < std::tie(other.shape[0], other.shape[1]);
  });
}

void SweepAcross::bring_chains() {
  if (border_ == nullptr) return;
  std::int64_t any = keep_known_pairs() ? 1 : 0;
  border_->transport.add_up({&any, 1});
  has_chains_ = any > 0;
  if (!has_chains_) return;
  std::vector<std::int32_t> chain_of = link_chains();
  visits_.assign(border_->halos.size(), {});
  spread_chains(chain_of);
  send_chains(chain_of);
}

template <class Take>
void SweepAcross::exchange(std::vector<std::int32_t> Visit::*sent, std::vector<std::int32_t> Visit::*received,
                           Take&& take) {
  if (!has_chains_) return;
  const auto ranks = static_cast<std::int32_t>(visits_.size());
  for (std::int32_t to = 0; to < ranks; ++to) {
    const std::vector<std::int32_t>& bodies = visits_[static_cast<std::size_t>(to)].*sent;
    if (bodies.empty()) continue;
    send_rows<SweptStep>(border_->transport, to, bodies, [&](std::int32_t body) {
      return SweptStep{data_.bodies.velocity[body], data_.bodies.delta[body],
                       broad_phase_.step_ends[place_of(broad_phase_.fast, body)]};
    });
  }
  for (std::int32_t from = 0; from < ranks; ++from) {
    const std::vector<std::int32_t>& bodies = visits_[static_cast<std::size_t>(from)].*received;
    if (bodies.empty()) continue;
    receive_rows<SweptStep>(border_->transport, from, bodies, [&](std::int32_t body, const SweptStep& step) {
      take(body, step, broad_phase_.step_ends[place_of(broad_phase_.fast, body)]);
    });
  }
}

void SweepAcross::return_ways() {
  exchange(&Visit::received, &Visit::sent, [&](std::int32_t body, const SweptStep& step, StepEnd& end) {
    data_.bodies.velocity[body] = step.velocity;
    data_.bodies.delta[body] = step.delta;
    end.held = end.held || step.end.held;
  });
}

void SweepAcross::send_ends() {
  exchange(&Visit::sent, &Visit::received, [&](std::int32_t body, const SweptStep& step, StepEnd& end) {
    data_.bodies.velocity[body] = step.velocity;
    data_.bodies.delta[body] = step.delta;
    end = step.end;
  });
}

void SweepAcross::return_ends() {
  exchange(&Visit::received, &Visit::sent,
           [](std::int32_t, const SweptStep& step, StepEnd& end) { end = step.end; });
}

void SweepAcross::share_ends() {
  if (border_ == nullptr) return;
  struct Motion {
    VelocityRow velocity;
    DeltaRow delta;
  };
  Bodies& bodies = data_.bodies;
  share_halos<Motion>(
      *border_, [&](std::int32_t body) { return is_fast_note(bodies, body); },
      [&](std::int32_t body) {
        return Motion{bodies.velocity[body], bodies.delta[body]};
      },
      [&](std::int32_t body, const Motion& motion) {
        bodies.velocity[body] = motion.velocity;
        bodies.delta[body] = motion.delta;
      });
}

}  // namespace scree
