// Who has constraints in common with whom; see border.h.
#include <core/state/hash.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>
#include <scree/error.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace scree {

namespace {

// Farther out, floats are 2 mm apart and more, and a slop of 5 mm is few of these.
constexpr float kMostDistance = 16384.0f;  // m, along an axis

[[noreturn]] void refuse(const std::string& what) { throw Error("DistributedWorld: " + what); }

void check_owners(const WorldData& data, const Transport& transport, const std::vector<std::int32_t>& owner) {
  if (owner.size() != data.bodies.flags.size()) {
    refuse(std::to_string(owner.size()) + " owners were given for " +
           std::to_string(data.bodies.flags.size()) + " rows of bodies");
  }
  for (std::size_t body = 0; body < owner.size(); ++body) {
    if (data.bodies.type[body] != BodyType::dynamic || (data.bodies.flags[body] & kBodyAlive) == 0) continue;
    if (owner[body] >= 0 && owner[body] < transport.ranks()) continue;
    refuse("body " + std::to_string(body) + " is given to rank " + std::to_string(owner[body]) + " of " +
           std::to_string(transport.ranks()));
  }
}

// Of the two bodies of a constraint, that of this rank and that of another; none where both are alike.
struct Sides {
  std::int32_t own = -1, other = -1;
};

Sides sides_of(const Border& border, const Edge& edge) {
  if (edge.kind == EdgeKind::pushed_b) return {};
  const bool own_a = border.owns(edge.body_a), own_b = border.owns(edge.body_b);
  if (own_a == own_b) return {};
  return own_a ? Sides{edge.body_a, edge.body_b} : Sides{edge.body_b, edge.body_a};
}

}  // namespace

void Border::report(const char* store, const Visit& visit) const {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  std::size_t lists = 0;
  for (const Neighbor& with : neighbors) {
    lists += bytes(with.edges) + bytes(with.uncolored) + bytes(with.own) + bytes(with.other) +
             bytes(with.returned_once) + bytes(with.taken_once);
    for (const BodiesByTurn* way : {&with.sent, &with.received, &with.returned, &with.taken})
      lists += bytes(way->bodies) + bytes(way->ends);
  }
  for (const Halo& halo : halos)
    lists += bytes(halo.lent) + bytes(halo.borrowed) + bytes(halo.near) + bytes(halo.near_resting) +
             bytes(halo.tied);
  lists += places.capacity_bytes() + found.capacity_bytes() + own_shapes.capacity_bytes() +
           resting.shapes.capacity_bytes();
  lists += bytes(levels);
  const std::size_t all =
      bytes(owner) + bytes(generation) + bytes(ghosts) + bytes(around) + bytes(waits) + lists;
  static const Attributes kPlain{};
  visit(Member{ColumnKind::scratch, MemberForm::list, store, "border", kPlain}, this, 1, all, all);
}

void check_border(const WorldData& data) {
  const Border& border = *border_of(data);
  check_not_giving(border);
  check_new_bodies(data, border);
}

void check_not_giving(const Border& border) {
  if (border.is_giving) refuse("one rank makes calls by give(): what all ranks do together must wait");
}

void check_position(const Bodies& bodies, std::int32_t body) {
  for (const float at : bodies.pose[body].position) {
    if (std::abs(at) <= kMostDistance) continue;
    refuse("body " + std::to_string(body) + " is " + std::to_string(at) +
           " m from the origin along an axis; it must be at most " +
           std::to_string(static_cast<int>(kMostDistance)) + " m");
  }
}

void check_positions(const WorldData& data) {
  const Bodies& bodies = data.bodies;
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) {
    if (is_shared_out(bodies, row) && bodies.is_absent[row] == 0)
      check_position(bodies, static_cast<std::int32_t>(row));
  }
}

void check_new_bodies(const WorldData& data, const Border& border) {
  const Bodies& bodies = data.bodies;
  const auto check = [&](std::int32_t body) {
    const auto row = static_cast<std::size_t>(body);
    const bool is_new = row >= border.generation.size() || border.generation[row] != bodies.generation[row];
    if (is_new && is_shared_out(bodies, row)) check_position(bodies, body);
  };
  if (!bodies.all_changed) {
    for (const std::int32_t body : bodies.changed) check(body);
    return;
  }
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) check(static_cast<std::int32_t>(row));
}

void divide_world(WorldData& data, Transport& transport, std::vector<std::int32_t> owner) {
  if (data.recording.sink != nullptr)
    refuse("a Recorder records the world; call DistributedWorld::record instead");
  check_owners(data, transport, owner);
  for (std::size_t body = 0; body < owner.size(); ++body) {
    if (data.bodies.type[body] != BodyType::dynamic) owner[body] = kEveryRank;
  }
  auto border = std::make_unique<Border>(transport, std::move(owner));
  for (std::size_t row = 0; row < data.bodies.flags.size(); ++row)
    border->generation.push_back(known_generation(data.bodies, row));
  data.border = std::move(border);
  forget_halos(data, *border_of(data));
}

void forget_halos(WorldData& data, Border& border) {
  border.ghosts.clear();
  for (std::size_t row = 0; row < border.owner.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    const bool is_here = (data.bodies.flags[row] & kBodyAlive) != 0 && data.bodies.is_absent[row] == 0;
    if (is_here && !border.owns(body) && border.owner_of(body) != kEveryRank) border.ghosts.push_back(body);
  }
  border.halos_stale = border.ties_stale = border.events_stale = true;
  data.contacts.pairs_stale = true;
  data.joints.all_changed = true;
}

std::uint64_t hash_of_part(const WorldData& data, const Border& border) {
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < border.owner.size(); ++row) {
    const bool is_alive = (data.bodies.flags[row] & kBodyAlive) != 0;
    if (is_alive && speaks_for(border, static_cast<std::int32_t>(row))) sum += hash_of(data.bodies, row);
  }
  return sum;
}

std::uint64_t hash_of_all(const WorldData& data, Border& border) {
  auto sum = static_cast<std::int64_t>(hash_of_part(data, border));
  border.transport.add_up({&sum, 1});
  return static_cast<std::uint64_t>(sum);
}

void meet_neighbors(Constraints& constraints, Border& border) {
  std::vector<Neighbor>& neighbors = border.neighbors;
  std::vector<std::int32_t> place_of(static_cast<std::size_t>(border.transport.ranks()), -1);
  neighbors.clear();
  for (std::size_t i = 0; i < constraints.edges.size(); ++i) {
    const Sides sides = sides_of(border, constraints.edges[i]);
    if (sides.own < 0) continue;
    std::int32_t& place = place_of[static_cast<std::size_t>(border.owner_of(sides.other))];
    if (place < 0) {
      place = static_cast<std::int32_t>(neighbors.size());
      neighbors.push_back({.rank = border.owner_of(sides.other)});
    }
    Neighbor& with = neighbors[static_cast<std::size_t>(place)];
    with.edges.push_back(static_cast<std::int32_t>(i));
    with.own.push_back(sides.own);
    with.other.push_back(sides.other);
  }
  // Messages go to neighbors in the order of their ranks.
  std::sort(neighbors.begin(), neighbors.end(),
            [](const Neighbor& one, const Neighbor& other) { return one.rank < other.rank; });
  struct Degree {
    std::int32_t constraints, joints;
  };
  for (Neighbor& with : neighbors) {
    keep_each_once(with.own);
    keep_each_once(with.other);
    send_rows<Degree>(border.transport, with.rank, with.own, [&](std::int32_t body) {
      return Degree{constraints.body_colors[body].degree, constraints.joint_count[body]};
    });
  }
  for (const Neighbor& with : neighbors) {
    receive_rows<Degree>(border.transport, with.rank, with.other,
                         [&](std::int32_t body, const Degree& degree) {
                           constraints.body_colors[body].degree = degree.constraints;
                           constraints.joint_count[body] = degree.joints;
                         });
  }
}

}  // namespace scree
