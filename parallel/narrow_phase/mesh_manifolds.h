// Merges what one convex shape touches of a mesh to few manifolds: contacts of about one normal and one
// surface become one manifold, with the points that spread most.
#pragma once

#include <core/world/column.h>
#include <simd/collide/collide_kernels.h>

#include <cstdint>
#include <span>

namespace scree {

// The least separation of a contact.
struct MeshDepth {
  float separation;
  std::int32_t contact;
};

// A point of a contact, seen along the normal of its manifold.
struct MeshPoint {
  float u, v, separation;
  std::int32_t contact;
  std::int32_t number;
  std::int32_t is_corner;  // 1: a corner of the shape
};

// Scratch of one thread.
struct MeshScratch {
  Column<simd::TriangleContact>& contacts;  // of all pairs of a chunk
  Column<MeshDepth>& order;                 // of one pair's contacts, the deepest first
  Column<std::int32_t>& cluster;            // per contact of the pair: place in the list of manifolds
  Column<MeshPoint>& points;                // of one manifold
};

// Appends the manifolds of a pair's contacts, which are in the order of their triangles, to `manifolds`:
// deepest first, each with `place` and without a row. `spread` is the least distance of two points, in
// meters.
void merge_contacts(const MeshData& mesh, std::span<const simd::TriangleContact> contacts,
                    simd::MeshFirstType first_type, std::int32_t place, float spread,
                    const MeshScratch& scratch, Column<simd::MeshManifold>& manifolds);

}  // namespace scree
