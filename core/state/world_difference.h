// Where two worlds differ.
#pragma once

#include <scree/world.h>

#include <string>

namespace scree {

// First body and field of the poses and velocities that differ in their bits: "body 7, position.y is 1.5
// (3fc00000) instead of 1.25 (3fa00000)"; empty if none.
std::string first_body_difference(const World& expected, const World& actual);
// First column of kind state that differs in its bytes, what stages keep included; empty if none. Rows that
// are free count, too, so it is for worlds that have gone the same way.
std::string first_column_difference(const World& expected, const World& actual);
// Of copies, whose free rows are empty: bodies, columns, settings and what else decides about the steps to
// come.
std::string first_difference_of_copies(const World& expected, const World& actual);
// As a snapshot sees it: bodies, columns, settings and what else decides about the steps to come.
std::string first_state_difference(const World& expected, const World& actual);

}  // namespace scree
