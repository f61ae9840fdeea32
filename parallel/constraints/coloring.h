// What the sources of the coloring share: the masks in which a constraint's color must be free, how it takes
// a color, and which of two comes first. For this folder and distributed/.
#pragma once

#include <core/world/mix.h>
#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <algorithm>
#include <bit>
#include <span>

namespace scree {

// The masks that a constraint's color must be free in, and enters. One against a body that cannot be pushed,
// or with a hub, has one body that counts; both masks are that body's then.
struct Masks {
  std::uint64_t& a;
  std::uint64_t& b;
};

// `Masked` is BodyColors or BodyClashes.
template <class Masked>
Masks masks_of(Column<Masked>& bodies, const Edge& edge) {
  Masked& a = bodies[edge.body_a];
  Masked& b = bodies[edge.body_b];
  switch (edge.kind) {
    case EdgeKind::pushed_b:
      return {b.static_colors, b.static_colors};
    case EdgeKind::hub_a:
      return {b.hub_colors, b.hub_colors};
    case EdgeKind::hub_b:
      return {a.hub_colors, a.hub_colors};
    default:
      return {a.dynamic_colors, b.dynamic_colors};
  }
}

inline int color_limit(EdgeKind kind) {
  switch (kind) {
    case EdgeKind::hub_a:
    case EdgeKind::hub_b:
      return kHubColorLimit;
    case EdgeKind::two_hubs:
      return 0;
    default:
      return kColorLimit;
  }
}

// Gives a constraint the lowest color that is free at its bodies.
inline void take_lowest_color(Column<BodyColors>& bodies, Edge& edge) {
  edge.color = edge.kind == EdgeKind::pushed_b ? kStaticHubColor : kOverflowColor;
  const int limit = color_limit(edge.kind);
  if (limit == 0) return;
  const Masks masks = masks_of(bodies, edge);
  const int color = std::countr_one(masks.a | masks.b);
  if (color >= limit) return;
  edge.color = static_cast<std::uint8_t>(color);
  masks.a |= std::uint64_t{1} << color;
  masks.b |= std::uint64_t{1} << color;
}

// Moves the first counts[p] entries of each part p of a list to the front of it; returns their number.
inline std::size_t join_parts(std::int32_t* list, const Column<std::int32_t>& counts, int part_size) {
  std::int32_t* to = list;
  for (std::size_t part = 0; part < counts.size(); ++part) {
    const std::int32_t* const from = list + part * static_cast<std::size_t>(part_size);
    to = std::copy(from, from + counts[part], to);
  }
  return static_cast<std::size_t>(to - list);
}

// The order in which constraints take their colors: by a hash of the group of their lower body that can be
// pushed, and within a group of bodies by their places in the list. Only constraints that share a body wait
// for one another, so a random order of groups makes short chains (Jones and Plassmann, "A parallel graph
// coloring heuristic", 1993). Within a group the order is that of pairs, as what is built layer by layer then
// has colors that alternate from layer to layer and carry a load far: by a hash of each pair, 3 of 5 towers
// of 240 planks fell that stand so.
inline constexpr int kOrderBits = 11, kGroupBits = 8;
inline std::uint32_t order_of(const Edge& edge) {
  const std::int32_t first =
      edge.kind == EdgeKind::pushed_b ? edge.body_b : std::min(edge.body_a, edge.body_b);
  return static_cast<std::uint32_t>(mixed(static_cast<std::uint64_t>(first >> kGroupBits)) >>
                                    (64 - kOrderBits));
}

// Sorts `places`, which ascend, by the edges' order: the first of Constraints::ordered.
void sort_by_order(Constraints& constraints, std::span<const std::int32_t> places);

// Gives the edges of `places`, which ascend, their colors in that order.
void color_in_order(Constraints& constraints, std::span<const std::int32_t> places);

// Does the same for Constraints::uncolored with all threads.
void color_in_rounds(Constraints& constraints, Crew& crew);

}  // namespace scree
