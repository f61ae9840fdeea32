// Checks what decompose is handed.
#pragma once

#include <scree/decompose.h>

#include <span>

namespace scree::decomposition {

// Throw Error "decompose: <problem>".
void check_options(const DecomposeOptions& options);
// Of a mesh that check_mesh accepts. Names the first open edges.
void check_closed(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles);

}  // namespace scree::decomposition
