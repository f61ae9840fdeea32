// Triangle meshes as kernels read them: triangles in the order of a tree, 16 a leaf, with what lies behind
// their edges.
//
// Written by core/geometry/mesh when a mesh is built, never changed after that. Plain memory only, see
// rows.h.
#pragma once

#include <core/plain/rows.h>
#include <core/plain/tree.h>

#include <cstdint>

namespace scree {

// Corners as rows of MeshData::vertex, counterclockwise seen from the front. Edge k leads from corner k to
// corner k + 1, the last one back to corner 0.
struct MeshCorners {
  std::int32_t vertex[3];
};

// How the surface goes on behind an edge. With n the triangle's normal and m the unit vector in its plane
// that points out across the edge, the unit vector in the neighbor's plane that leads away from the edge is
//     (cosine m - sine n) / kTurnUnit,
// so a positive sine is a ridge, seen from the front, zero a flat seam and a negative one a valley. Behind a
// rim the surface turns back: cosine 0, sine kTurnUnit. Of several neighbors the one that rises highest
// counts; one that passes the edge in the same direction, as its front looks to the other side, is none. What
// is flat but for the rounding of corners counts as flat. The sine is 0 only where the cosine is kTurnUnit: a
// neighbor that is folded back is a ridge or a valley of sine 1 or -1.
struct EdgeTurn {
  std::int16_t cosine, sine;
};
inline constexpr int kTurnUnit = 32767;

struct MeshTurns {
  EdgeTurn edge[3];
};

// MeshData::material of triangles that have the surface of their shape.
inline constexpr std::uint8_t kShapeMaterial = 255;

// Columns are 64-byte aligned, and those by triangle end with copies of the last row up to a whole leaf.
// Loads may run 64 bytes past the end of any column. Triangles have an area that is not 0, but may be slivers
// of which single precision leaves none. Triangles of a leaf ascend by their given numbers.
//
// The tree is implicit: child c of block b is block 16 b + c of the level below. Leaf block b has the
// triangles from 16 b on.
struct MeshData {
  std::int32_t vertex_count;
  std::int32_t triangle_count;
  const float* vertex;           // x y z of each, relative to the center of the mesh's box
  const MeshCorners* corners;    // by triangle
  const MeshTurns* turns;        // by triangle
  const std::int32_t* given;     // by triangle: its number as the mesh was handed in
  const std::uint8_t* material;  // by triangle: row of `materials`, or kShapeMaterial; null: all have this
  const MaterialRow* materials;
  const NodeBlock* nodes[kMaxTreeLevels];  // nodes[0]: boxes of the leaf blocks
  std::int32_t levels;                     // of nodes, at least 1
};

}  // namespace scree
