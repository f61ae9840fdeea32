// The step: advances a world in time.
#pragma once

#include <scree/export.h>
#include <scree/workers.h>
#include <scree/world.h>

#include <span>

namespace scree {

/// Advances the world by `dt` seconds (0 <= dt <= 1; 0 only collides) with the workers' threads.
/// Throws scree::Error for a bad `dt`, std::bad_alloc when memory runs out (the world can then only be
/// destroyed), what the callback of World::set_user_row_callback throws (the world is as it was then), and
/// what hooks of contacts throw (the world has taken its step then, see contact_hooks.h); nothing else. The
/// same calls give the same bits for any workers.
SCREE_API void step(World& world, float dt, Workers& workers);

/// Advances many worlds, each as step(*world, dt, workers) would and to the same bits. Where there are at
/// least as many worlds as threads, each world is stepped whole by one thread: small worlds gain little from
/// threads that share one. Throws as step() does, and for a null pointer or a world that stands in the list
/// twice, before any world is stepped. A world whose callback or hook throws is as step() leaves it; the
/// others take their step, and the exception of the first such world is thrown after that. After
/// std::bad_alloc each of the worlds can only be destroyed.
SCREE_API void step(std::span<World* const> worlds, float dt, Workers& workers);

}  // namespace scree
