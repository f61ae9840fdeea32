// Kernels of queries: walks through the trees of the broad phase and of meshes, lane = one of a block's 16
// children, or one of a leaf's 16 triangles.
//
// Called by parallel/queries, which asks the shapes and triangles that a walk comes to, and by
// parallel/continuous. What a walk leaves out cannot be part of the answer; what it comes to beside that, and
// in which order, depends on the tree.
#pragma once

#include <core/plain/hull.h>
#include <core/plain/mesh.h>
#include <simd/broad_phase/pair_kernels.h>

#include <cstdint>

namespace scree::simd {

// Asks a shape, or a triangle by its row in the mesh, and returns the new limit of the walk; one below zero
// ends it.
using AskShape = float (*)(void* context, std::int32_t shape, float limit);

// A box that moves along a line, or a ray where it has no extent: at the fraction t it is about
// origin + t * translation.
struct CrossTask {
  float origin[3];
  float inverse[3];  // 1 / translation, of the same sign; 1e30 or -1e30 where the translation is smaller
  float half[3];     // m, of the moving box, rounding errors included
};
inline constexpr float kLargestInverse = 1e30f;

// A box at rest.
struct MeetTask {
  float lower[3], upper[3];
};

// Sides of triangles.
enum MeshSide : std::uint32_t { kFrontSide = 1, kBackSide = 2 };

// A ray in the frame of a mesh. Its triangles are seen along it: sheared, so that the ray becomes the last of
// `axis` (S. Woop, C. Benthin, I. Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013).
struct MeshRayTask {
  CrossTask line;    // `half`: what the line and the boxes are rounded by, at least
  double origin[3];  // m, as of `line`, with less rounding
  double way[3];     // m, from fraction 0 to 1
  std::int32_t
      axis[3];     // the way is longest along the last; seen along it, fronts turn clockwise in the others
  float slope[2];  // of the first two by the last
  float rounding;  // m, more than double precision takes from a place of the ray
  std::uint32_t sides;  // MeshSide, set of
};

// A straight way in the frame of a hull, which is in or near the ball around that, whole.
struct HullStretch {
  float base[3], way[3];  // m, where it begins and to where it ends
  float margin;           // m, more than single precision takes from distances to planes
};

struct QueryKernels {
  // Asks the shapes whose boxes the moving box enters at a fraction of at most the limit, about in the order
  // of entering. A limit is a fraction of at most 1.
  float (*cross)(const TreeView& tree, const CrossTask& task, float limit, AskShape ask, void* context);
  // Asks the shapes whose boxes the box meets. The limit says only when to end.
  float (*meet)(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
  // Asks the shapes whose boxes come as near to the box as the limit, about from near to far. The limit is
  // the square of a distance, in m^2.
  float (*approach)(const TreeView& tree, const MeetTask& task, float limit, AskShape ask, void* context);
  // Asks the triangles that the ray may meet, and few others, about in the order of meeting.
  float (*cross_mesh_by_ray)(const MeshData& mesh, const MeshRayTask& task, float limit, AskShape ask,
                             void* context);
  // As those for trees, for the boxes of triangles.
  float (*cross_mesh)(const MeshData& mesh, const CrossTask& task, float limit, AskShape ask, void* context);
  float (*meet_mesh)(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context);
  float (*approach_mesh)(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask,
                         void* context);
  // Lists the faces that may cut what may lie in the hull of the stretch, ascending, and returns their
  // number; -1 if none of it does. `faces` has room for the hull's padded_faces.
  int (*cut_hull)(const HullData& hull, const HullStretch& stretch, std::int32_t* faces);
};

}  // namespace scree::simd
