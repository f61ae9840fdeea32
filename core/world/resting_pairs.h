// Resting pairs: adds, removes and finds rows of Contacts::resting.
//
// A world may have far more of them than a step may read, so each is in a list of each of its shapes. Rows
// are not sorted: the last one takes the place of a removed one. Results must not depend on the order of rows
// or lists: code that gathers rows sorts its results.
#pragma once

#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>

namespace scree {

// Calls visit(row, other) for the resting pairs of a shape, or of the one that had its slot before; `other`
// is the pair's other shape. In no order; `visit` must not add or remove rows.
template <class Visit>
void for_each_resting(WorldData& data, std::int32_t shape, Visit&& visit) {
  Contacts& contacts = data.contacts;
  for (std::uint32_t end = data.shapes.first_resting[shape]; end != 0;) {
    const std::size_t row = (end - 1) / 2, side = (end - 1) % 2;
    const ShapePair pair = contacts.resting.pair[row];
    ++contacts.resting_looks;
    end = contacts.resting_links[row].next[side];
    visit(static_cast<std::int32_t>(row), side == 0 ? pair.b : pair.a);
  }
}

// Appends rows. For events they do not touch. The columns of axes have as many rows as those of pairs, or
// none.
void add_resting(WorldData& data, const PairRows& more);
// Removes the rows with these numbers, which ascend. Their touch rows must have been moved to
// Events::touching.
void remove_resting(WorldData& data, const Column<std::int32_t>& rows);
// Rebuilds the lists of all shapes.
void link_resting(WorldData& data);

}  // namespace scree
