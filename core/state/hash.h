// World::hash, for those who have no World at hand.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

std::uint64_t hash_of(const Bodies& bodies);

}  // namespace scree
