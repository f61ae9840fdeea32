// Convex hulls as kernels read them: columns relative to the centroid, padded to whole blocks of 16.
//
// Written by core/geometry/hull/hull_columns.cpp when a hull is built, never changed after that. Plain memory
// only, see rows.h.
#pragma once

#include <cstdint>

namespace scree {

inline constexpr int kMaxHullVertices = 256;
inline constexpr int kMaxHullFaces = 508;  // of triangles: 2 V - 4
inline constexpr int kMaxHullEdges = 762;  // 3 V - 6
inline constexpr int kHullPadding = 16;

// What segments and points need of a hull besides its face planes. Written by
// core/geometry/hull/hull_round_columns.cpp.
struct HullRoundData {
  // Edges in an order of their own: blocks of 16 that lie close together, each in a ball; the last block is
  // padded with its first edge. Where edges begin, the way to their end, one over its length squared, their
  // faces and these faces' normals.
  std::int32_t edge_blocks;
  const float* block_center[3];
  const float* block_radius;  // m; -1e30 for the blocks that pad the column
  const float* edge_point[3];
  const float* edge_way[3];
  const float* edge_inverse;  // 1/m^2
  const float* edge_normal_0[3];
  const float* edge_normal_1[3];
  const std::int32_t* edge_face[2];
  // Planes that bound each face within its own plane, one a corner, from that corner on: unit normals that
  // look away from the face. Those of face f are side_begin[f] to side_begin[f + 1] - 1; loads may run past
  // the last by a block.
  const float* side_normal[3];
  const float* side_offset;
  const std::int32_t* side_begin;
};

// An edge, one cache line: what the narrow phase reads of the few edges that may decide a contact.
struct alignas(64) HullEdge {
  float point[3];  // of vertex 0
  float along[3];  // from vertex 0 to vertex 1
  float normal_0[3];
  float normal_1[3];
  std::int32_t vertex[2];
  std::int32_t face[2];  // [0] has the edge from vertex 0 to vertex 1 in its loop, [1] the other way
};

// Columns are 64-byte aligned. Vertices are padded with vertex 0, faces with normal 0 and offset +1e30, edges
// with arcs that nothing reaches.
//
// The arc of an edge: the directions in which it is the farthest of the hull, from the normal of one face to
// that of the other. Along any of them a point x lies at most max(m . d, cosine m . d) + |t . d| beyond the
// edge, where d = x - p, p a point of the edge, m the middle of the arc, and t half the normals' difference.
//
// All but `rounding` is of the polyhedron within. Solids have no rounding; slots of hulls have: see
// SharedHull.
struct HullData {
  std::int32_t vertex_count;
  std::int32_t edge_count;
  std::int32_t face_count;
  std::int32_t padded_vertices;
  std::int32_t padded_edges;
  std::int32_t padded_faces;
  float inner_radius;  // m, of the largest ball about the centroid within the hull
  float outer_radius;  // m, of the smallest ball about the centroid around it
  float rounding;      // m, of the shape: all points within this distance of the polyhedron belong to it
  const float* vertex[3];
  const float* normal[3];
  const float* offset;
  const float* arc_middle[3];     // m
  const float* arc_middle_point;  // m . p; +1e30 in padding
  const float* arc_tilt[3];       // t
  const float* arc_tilt_point;    // t . p
  const float* arc_cosine;        // of half the arc
  const HullEdge* edge;
  const std::uint8_t* loop;         // vertices of all faces, counterclockwise seen from outside
  const std::uint16_t* loop_begin;  // per face, and where the last one ends
  HullRoundData round;
};

}  // namespace scree
