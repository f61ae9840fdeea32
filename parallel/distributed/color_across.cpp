// Colors new constraints where some of them lie across the borders of ranks; see border.h.
//
// The rule is that of coloring.h: each takes the lowest free color in the order of a hash. A rank goes
// through its constraints in this order and colors those whose bodies are its own and wait for no earlier
// one. For those across a border it tells the neighbor whether its own body waits, and which colors that has;
// if neither waits, both ranks take the same color. Then they begin again with what is left. A constraint
// across a border is known to both of its ranks alone, so a rank is done when none of its own is left.
#include <parallel/constraints/coloring.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/messages.h>

#include <algorithm>
#include <vector>

namespace scree {

namespace {

// What a rank says of its side of a constraint.
struct Side {
  std::uint64_t colors;  // in use at its body
  std::uint64_t waits;   // 1: an earlier constraint of its body has no color yet
};

// Calls work(body, mask) for the bodies in whose masks the constraint's color must be free.
template <class Work>
void for_each_mask(Constraints& constraints, const Edge& edge, Work&& work) {
  if (edge.kind == EdgeKind::two_hubs) return;
  const Masks masks = masks_of(constraints.body_colors, edge);
  if (edge.kind == EdgeKind::dynamic || edge.kind == EdgeKind::hub_b) work(edge.body_a, masks.a);
  if (edge.kind != EdgeKind::hub_b) work(edge.body_b, masks.b);
}

bool is_across(const Border& border, const Edge& edge) {
  return edge.kind != EdgeKind::pushed_b && border.owns(edge.body_a) != border.owns(edge.body_b);
}

// In order: colors what waits for nothing and lies within; marks the bodies of the others, which make later
// ones wait. Writes which constraints across the border waited. Returns what has no color yet, in order.
std::vector<std::int32_t> color_within(Constraints& constraints, Border& border,
                                       const std::vector<std::int32_t>& ordered,
                                       std::vector<std::uint8_t>& waited) {
  std::vector<std::int32_t> left;
  for (const std::int32_t place : ordered) {
    Edge& edge = constraints.edges[place];
    bool waits = false;
    for_each_mask(constraints, edge, [&](std::int32_t body, std::uint64_t&) {
      waits = waits || (border.owns(body) && border.waits[static_cast<std::size_t>(body)] != 0);
    });
    const bool across = is_across(border, edge);
    if (!across && !waits) {
      take_lowest_color(constraints.body_colors, edge);
      continue;
    }
    if (across) waited[static_cast<std::size_t>(place)] = waits ? 1 : 0;
    for_each_mask(constraints, edge, [&](std::int32_t body, std::uint64_t&) {
      border.waits[static_cast<std::size_t>(body)] = 1;
    });
    left.push_back(place);
  }
  for (const std::int32_t place : left) {
    for_each_mask(constraints, constraints.edges[place], [&](std::int32_t body, std::uint64_t&) {
      border.waits[static_cast<std::size_t>(body)] = 0;
    });
  }
  return left;
}

// Colors what waits on neither side of a border.
void color_common(Constraints& constraints, Border& border, const std::vector<std::uint8_t>& waited) {
  for (const Neighbor& with : border.neighbors) {
    if (with.uncolored.empty()) continue;
    send_rows<Side>(border.transport, with.rank, with.uncolored, [&](std::int32_t place) {
      Side side{0, waited[static_cast<std::size_t>(place)]};
      for_each_mask(constraints, constraints.edges[place], [&](std::int32_t body, const std::uint64_t& mask) {
        if (border.owns(body)) side.colors = mask;
      });
      return side;
    });
  }
  for (Neighbor& with : border.neighbors) {
    if (with.uncolored.empty()) continue;
    receive_rows<Side>(border.transport, with.rank, with.uncolored,
                       [&](std::int32_t place, const Side& side) {
                         Edge& edge = constraints.edges[place];
                         if ((waited[static_cast<std::size_t>(place)] | side.waits) != 0) return;
                         for_each_mask(constraints, edge, [&](std::int32_t body, std::uint64_t& mask) {
                           if (!border.owns(body)) mask = side.colors;
                         });
                         take_lowest_color(constraints.body_colors, edge);
                       });
    std::erase_if(with.uncolored,
                  [&](std::int32_t place) { return constraints.edges[place].color != kNoColor; });
  }
}

}  // namespace

void share_clashes(Constraints& constraints, Border& border) {
  share_rows<BodyClashes>(border, constraints.clashes);
}

void color_across(Constraints& constraints, Border& border) {
  border.waits.assign(border.owner.size(), 0);
  // A constraint that does not fit under its limit has a color of its own, and is colored then, too.
  for (const std::int32_t place : constraints.uncolored) constraints.edges[place].color = kNoColor;
  for (Neighbor& with : border.neighbors) {
    with.uncolored.clear();
    std::copy_if(with.edges.begin(), with.edges.end(), std::back_inserter(with.uncolored),
                 [&](std::int32_t place) { return constraints.edges[place].color == kNoColor; });
  }
  sort_by_order(constraints, constraints.uncolored.span());
  std::vector<std::int32_t> left(constraints.ordered.begin(),
                                 constraints.ordered.begin() + constraints.uncolored.size());
  std::vector<std::uint8_t> waited(constraints.edges.size(), 0);
  while (!left.empty()) {
    left = color_within(constraints, border, left, waited);
    color_common(constraints, border, waited);
    std::erase_if(left, [&](std::int32_t place) { return constraints.edges[place].color != kNoColor; });
  }
}

}  // namespace scree
