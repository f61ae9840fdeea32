// The machine and the build, as every published figure must name them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace scree::bench {

/// Name and value, in the order in which they are printed: processor, cores, memory, system, compiler, load,
/// date.
std::vector<std::pair<std::string, std::string>> describe_machine();

}  // namespace scree::bench
