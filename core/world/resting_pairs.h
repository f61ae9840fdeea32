// Pairs at rest: what happens to rows of Contacts::resting.
//
// A world may have far more of them than a step may look at, so each stands in a list of each of its shapes,
// and rows lie in no order: the last one takes the place of one that goes. Results must not depend on the
// order of rows or of lists: who gathers rows sorts what it makes of them.
#pragma once

#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>

namespace scree {

// Calls visit(row, other) for the pairs at rest of a shape or of the one that had its slot before; `other` is
// the pair's other shape. In no order; `visit` must not add or remove rows.
template <class Visit>
void for_each_resting(const WorldData& data, std::int32_t shape, Visit&& visit) {
  const Contacts& contacts = data.contacts;
  std::int64_t looks = 0;
  for (std::uint32_t end = data.shapes.first_resting[shape]; end != 0;) {
    const std::size_t row = (end - 1) / 2, side = (end - 1) % 2;
    const ShapePair pair = contacts.resting.pair[row];
    ++looks;
    end = contacts.resting_links[row].next[side];
    visit(static_cast<std::int32_t>(row), side == 0 ? pair.b : pair.a);
  }
  if (looks > 0) contacts.resting_looks += looks;
}

// Adds rows behind the others, which do not touch as far as events tell. The columns of axes have as many
// rows as those of pairs, or none.
void add_resting(WorldData& data, const PairRows& more);
// Takes out the rows with these numbers, which ascend. What they touch must have been moved to
// Events::touching.
void remove_resting(WorldData& data, const Column<std::int32_t>& rows);
// Makes the lists of all shapes anew, whatever stands in them.
void link_resting(WorldData& data);

}  // namespace scree
