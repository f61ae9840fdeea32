// A hull's corners, faces and edges in canonical order: what hull building hands to the columns of the
// kernels (core/plain/hull.h).
#pragma once

#include <scree/math_types.h>

#include <cstdint>
#include <vector>

namespace scree {

// Corners are relative to the hull's centroid, in ascending order of (x, y, z). A face's loop runs
// counterclockwise seen from outside and starts at its lowest corner; faces ascend by their loops. Edges have
// vertex[0] < vertex[1] and ascend by (vertex[0], vertex[1]).
struct HullTopology {
  struct Plane {
    float normal[3];  // unit, outward
    float offset;     // m: normal . x for the corners x of the face; the largest of them
  };
  struct Edge {
    std::uint8_t vertex[2];
    std::uint16_t face[2];  // [0] has the edge from vertex[0] to vertex[1] in its loop, [1] the other way
  };

  std::vector<Vec3> vertices;        // 4 to 256
  std::vector<std::uint8_t> loops;   // corners of all faces, face after face
  std::vector<std::uint16_t> begin;  // face f is loops[begin[f]] to loops[begin[f + 1] - 1]
  std::vector<Plane> planes;         // of each face
  std::vector<Edge> edges;
};

}  // namespace scree
