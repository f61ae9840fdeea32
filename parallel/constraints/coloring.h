// What the two sources of the coloring share: the masks in which a constraint's color must be free, and how
// it takes a color. Private to color_constraints.cpp and color_cells.cpp.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <bit>

namespace scree {

// The masks that a constraint's color must be free in, and enters. One against a body that cannot be pushed,
// or with a hub, has one body that counts; both masks are that body's then.
struct Masks {
  std::uint64_t& a;
  std::uint64_t& b;
};

inline Masks masks_of(Column<BodyColors>& bodies, const Edge& edge) {
  BodyColors& a = bodies[edge.body_a];
  BodyColors& b = bodies[edge.body_b];
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

// Colors Constraints::uncolored cell by cell, in parallel.
void color_by_cells(const WorldData& data, Constraints& constraints, Crew& crew);

}  // namespace scree
