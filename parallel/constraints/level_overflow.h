// Levels of the overflow: which of the constraints without a color may be solved at the same time. Private to
// pack_blocks.cpp.
//
// The overflow is solved kind by kind in the order of its list. A constraint waits for the earlier ones that
// share a body with it, so its level is one more than the highest of theirs. Constraints of one level share
// no body, so that solving level by level gives the same bits as solving one by one. The contacts of n bodies
// in one place, which are all between hubs, make some 2 n levels of up to n / 2 contacts.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <cstddef>
#include <cstdint>

namespace scree {

// Of the edges from `first` on, which are `count`; after count_keys(). Writes the overflow of the table, with
// a place for each level of the whole world. `is_empty`: no rank has any.
void level_overflow(const WorldData& data, Constraints& constraints, std::int32_t first, std::size_t count,
                    bool is_empty, int lanes, KeyTable& table, Crew& crew);

}  // namespace scree
