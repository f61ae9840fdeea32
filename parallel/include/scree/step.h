// The step: advances a world in time.
#pragma once

#include <scree/export.h>
#include <scree/workers.h>
#include <scree/world.h>

namespace scree {

/// Advances the world by `dt` seconds (0 <= dt <= 1; 0 only collides) with the workers' threads.
/// Throws scree::Error for a bad `dt` and std::bad_alloc when memory runs out (the world can then only be
/// destroyed), nothing else. The same calls give the same bits for any workers.
SCREE_API void step(World& world, float dt, Workers& workers);

}  // namespace scree
