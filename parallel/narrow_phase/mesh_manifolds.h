// Merges what one convex shape touches of a mesh to few manifolds: contacts of about one normal and one
// surface become one manifold, with the points that spread most.
#pragma once

#include <core/world/column.h>
#include <simd/collide/collide_kernels.h>

#include <cstdint>
#include <span>

namespace scree {

// Scratch of one thread.
struct MeshScratch {
  Column<simd::TriangleContact>& contacts;
  Column<std::int32_t>& order;    // contacts, the deepest first
  Column<std::int32_t>& cluster;  // per contact: place in the list of manifolds
};

// Appends the manifolds of scratch.contacts, which are in the order of their triangles, to `manifolds`:
// deepest first, each with `place` and without a row. `spread` is the least distance of two points, in
// meters.
void merge_contacts(const MeshData& mesh, simd::MeshFirstType first_type, std::int32_t place, float spread,
                    const MeshScratch& scratch, Column<simd::MeshManifold>& manifolds);

}  // namespace scree
