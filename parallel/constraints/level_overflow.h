// Levels of the overflow: which of the constraints that found no color may be solved side by side. Used by
// pack_blocks.cpp only.
//
// They are solved kind by kind in the order of their list, each after those before it that share a body with
// it. Its level is one more than the highest of theirs: constraints of one level share no body, and level by
// level they come to the same bits as one after the other. Of n bodies in one place, whose contacts are all
// between hubs, there are some 2 n levels of up to n / 2 contacts.
#pragma once

#include <parallel/constraints/constraints.h>
#include <parallel/crew/crew.h>

#include <cstddef>

namespace scree {

// Of the edges from `first` on, which are `count`; after count_keys(). Writes the overflow of the table.
void level_overflow(Constraints& constraints, std::size_t first, std::size_t count, int lanes,
                    KeyTable& table, Crew& crew);

}  // namespace scree
