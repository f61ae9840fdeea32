// Meshes as queries meet them: surfaces of triangles, without an inside. A walk through the tree of a mesh
// finds the triangles that may be part of an answer, and these are asked in double precision.
//
// Of triangles that answer alike, the one with the smallest given number counts. So answers do not depend on
// the order of the walk.
#pragma once

#include <parallel/queries/query_distance.h>
#include <parallel/queries/query_ray.h>
#include <simd/queries/query_kernels.h>

namespace scree::queries {

// Which meetings with triangles count.
struct MeshLook {
  bool back_sides = false;        // meetings from behind, too
  bool skips_overlapped = false;  // of casts: triangles that overlap the solid at first do not count
  bool any = false;               // ends at the first meeting that is found, which need not be the first one
};

// Triangles as convex solids of three corners, in the mesh's frame.
class TriangleSolid {
 public:
  explicit TriangleSolid(const MeshData& mesh);
  TriangleSolid(const TriangleSolid&) = delete;  // points into itself
  TriangleSolid& operator=(const TriangleSolid&) = delete;

  // Holds until the next one is taken.
  const Solid& take(std::int32_t triangle);

 private:
  const MeshData& mesh_;
  Solid solid_;
  float column_[3][3];
};

// Whether the ray meets a triangle at a fraction of at most `most`, and where first. It meets the front of a
// triangle if it comes from there; a ray without length, or in the plane of a triangle, meets none. Through
// an edge or a vertex that triangles share, it meets one of them.
bool meet_mesh(const simd::QueryKernels& kernels, const Solid& mesh, const Line& line, double most,
               const MeshLook& look, Entry& entry);

// The same for a solid that moves along `way`: it meets a triangle if it moves against the front. A triangle
// that it overlaps at first counts unless it moves out by the front.
bool meet_mesh(const simd::QueryKernels& kernels, const Solid& moving, Vector way, const Solid& mesh,
               double most, const MeshLook& look, Contact& contact);

// The first triangle, by given number, that the solid touches; -1 if it touches none. Sides do not matter.
std::int32_t touched_triangle(const simd::QueryKernels& kernels, const Solid& solid, const Solid& mesh);

// The gap from a solid to the nearest triangle, unless that is farther off than `most`: then a distance above
// it. Zero where they touch. Sides do not matter.
Gap gap_to_mesh(const simd::QueryKernels& kernels, const Solid& solid, const Solid& mesh, double most);

}  // namespace scree::queries
