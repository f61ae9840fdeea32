// World::hash for code that has the data of a world only.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

std::uint64_t hash_of(const Bodies& bodies);
// What a living body adds to it.
std::uint64_t hash_of(const Bodies& bodies, std::size_t body);

}  // namespace scree
