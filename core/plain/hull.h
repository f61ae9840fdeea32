// Convex hulls as kernels read them: columns relative to the centroid, padded to whole blocks of 16.
//
// Written by core/hull_columns.cpp when a hull is built, never changed after that. Plain memory only, see
// rows.h.
#pragma once

#include <cstdint>

namespace scree {

inline constexpr int kMaxHullVertices = 256;
inline constexpr int kMaxHullFaces = 508;  // of triangles: 2 V - 4
inline constexpr int kMaxHullEdges = 762;  // 3 V - 6
inline constexpr int kHullPadding = 16;

// Columns are 64-byte aligned. Vertices are padded with vertex 0, faces with normal 0 and offset +1e30.
struct HullData {
  std::int32_t vertex_count;
  std::int32_t edge_count;
  std::int32_t face_count;
  std::int32_t padded_vertices;
  std::int32_t padded_edges;
  std::int32_t padded_faces;
  float inner_radius;  // m, of the largest ball about the centroid within the hull
  float outer_radius;  // m, of the smallest ball about the centroid around it
  const float* vertex[3];
  const float* normal[3];
  const float* offset;
};

}  // namespace scree
