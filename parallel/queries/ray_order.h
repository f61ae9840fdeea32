// The order in which many rays are asked: those that enter the world side by side and go the same way follow
// each other. They walk through the same blocks of trees and meet the same triangles, which are in the caches
// then. No answer depends on it.
#pragma once

#include <parallel/crew/crew.h>
#include <parallel/queries/query_scope.h>
#include <scree/queries.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree::queries {

// The places of the rays in the order in which to ask them; empty where they are so few that it would not
// pay.
std::vector<std::int32_t> order_rays(const Scope& scope, std::span<const Ray> rays, Crew& crew);

}  // namespace scree::queries
