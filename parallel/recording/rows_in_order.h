// Comparing worlds but for the order of what has none: rows of contacts, and pairs that rest beside those
// that move. Ranks that step one world together take rows in an order of their own.
#pragma once

#include <parallel/crew/crew.h>
#include <scree/world.h>

#include <string>

namespace scree {

// As first_state_difference; empty if the worlds go on alike.
std::string first_difference_but_for_order(const World& expected, const World& actual);
// Of what this rank has of two worlds, in which the same rank has each body. The worlds stay what they are.
std::string first_difference_of_parts(World& expected, World& actual, Crew& crew);

}  // namespace scree
