// Turns a box into a hull, so that boxes and hulls collide by the code for hulls.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// In the canonical order of hulls: vertices by (x, y, z), faces by their loops, edges by their vertices.
constexpr int kVertices = 8, kFaces = 6, kEdges = 12;
constexpr float kCornerSign[3][kVertices] = {
    {-1, -1, -1, -1, 1, 1, 1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, 1, -1, 1, -1, 1, -1, 1}};
constexpr int kFaceAxis[kFaces] = {0, 2, 1, 2, 1, 0};
constexpr float kFaceSign[kFaces] = {-1, -1, -1, 1, 1, 1};
constexpr std::uint8_t kLoop[4 * kFaces] = {0, 1, 3, 2, 0, 2, 6, 4, 0, 4, 5, 1,
                                            1, 5, 7, 3, 2, 3, 7, 6, 4, 6, 7, 5};
constexpr std::uint16_t kLoopBegin[kFaces + 1] = {0, 4, 8, 12, 16, 20, 24};
struct EdgeEnds {
  int vertex[2], face[2];
};
constexpr EdgeEnds kEdge[kEdges] = {{{0, 1}, {0, 2}}, {{0, 2}, {1, 0}}, {{0, 4}, {2, 1}}, {{1, 3}, {0, 3}},
                                    {{1, 5}, {3, 2}}, {{2, 3}, {4, 0}}, {{2, 6}, {1, 4}}, {{3, 7}, {4, 3}},
                                    {{4, 5}, {2, 5}}, {{4, 6}, {5, 1}}, {{5, 7}, {3, 5}}, {{6, 7}, {5, 4}}};
constexpr float kHalfRoot = 0.70710678f;  // cosine of half the arc of an edge

// Columns that do not depend on the extents.
struct Directions {
  alignas(64) float normal[3][kHullPadding];
  alignas(64) float middle[3][kHullPadding];
  alignas(64) float tilt[3][kHullPadding];
  alignas(64) float cosine[kHullPadding];
};
constexpr Directions make_directions() {
  Directions d{};
  for (int f = 0; f < kFaces; ++f) d.normal[kFaceAxis[f]][f] = kFaceSign[f];
  for (int e = 0; e < kHullPadding; ++e) {
    d.cosine[e] = kHalfRoot;
    if (e >= kEdges) continue;
    const int one = kEdge[e].face[0], two = kEdge[e].face[1];
    d.middle[kFaceAxis[one]][e] = kHalfRoot * kFaceSign[one];
    d.middle[kFaceAxis[two]][e] = kHalfRoot * kFaceSign[two];
    d.tilt[kFaceAxis[one]][e] = -0.5f * kFaceSign[one];
    d.tilt[kFaceAxis[two]][e] = 0.5f * kFaceSign[two];
  }
  return d;
}
constexpr Directions kDirections = make_directions();

}  // namespace

BoxHull::BoxHull() : hull{}, vertex{}, offset{}, middle_point{}, tilt_point{}, edge{} {
  hull.vertex_count = kVertices;
  hull.edge_count = kEdges;
  hull.face_count = kFaces;
  hull.padded_vertices = hull.padded_edges = hull.padded_faces = kHullPadding;
  for (int k = 0; k < 3; ++k) {
    hull.vertex[k] = vertex[k];
    hull.normal[k] = kDirections.normal[k];
    hull.arc_middle[k] = kDirections.middle[k];
    hull.arc_tilt[k] = kDirections.tilt[k];
  }
  hull.offset = offset;
  hull.arc_middle_point = middle_point;
  hull.arc_tilt_point = tilt_point;
  hull.arc_cosine = kDirections.cosine;
  hull.edge = edge;
  hull.loop = kLoop;
  hull.loop_begin = kLoopBegin;
  for (int k = kFaces; k < kHullPadding; ++k) offset[k] = 1e30f;
  for (int k = kEdges; k < kHullPadding; ++k) middle_point[k] = 1e30f;
  for (int e = 0; e < kEdges; ++e) {
    for (int k = 0; k < 2; ++k) {
      edge[e].vertex[k] = kEdge[e].vertex[k];
      edge[e].face[k] = kEdge[e].face[k];
    }
    edge[e].normal_0[kFaceAxis[kEdge[e].face[0]]] = kFaceSign[kEdge[e].face[0]];
    edge[e].normal_1[kFaceAxis[kEdge[e].face[1]]] = kFaceSign[kEdge[e].face[1]];
  }
}

void BoxHull::set_faces(const float half[3]) {
  hull.inner_radius = smaller(half[0], smaller(half[1], half[2]));
  hull.outer_radius = square_root(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
  for (int k = 0; k < 3; ++k) {
    for (int v = 0; v < kHullPadding; ++v) {
      vertex[k][v] = kCornerSign[k][v < kVertices ? v : 0] * half[k];
    }
  }
  for (int f = 0; f < kFaces; ++f) offset[f] = half[kFaceAxis[f]];
}

void BoxHull::set_edges() {
  for (int e = 0; e < kEdges; ++e) {
    const float to_0 = offset[kEdge[e].face[0]], to_1 = offset[kEdge[e].face[1]];
    middle_point[e] = kHalfRoot * (to_0 + to_1);
    tilt_point[e] = 0.5f * (to_1 - to_0);
    for (int k = 0; k < 3; ++k) {
      const float begin = vertex[k][kEdge[e].vertex[0]], end = vertex[k][kEdge[e].vertex[1]];
      edge[e].point[k] = begin;
      edge[e].along[k] = end - begin;
    }
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
