// Walks through the trees of meshes for queries, and from their leaves to triangles: lane = triangle.
//
// Rays are tested in single precision here, with a margin for all that rounding may do, and only for whether
// they pass within the edges of a triangle, seen along them. The few triangles that are left are asked in
// double precision.
#include <simd/queries/query_walk.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The corners of a leaf's triangles, by corner and axis.
struct Corners {
  alignas(64) float at[3][3][kBlock];
};

const MeshCorners* leaf_corners(const MeshData& mesh, std::int32_t leaf) {
  return mesh.corners + static_cast<std::ptrdiff_t>(leaf) * kBlock;
}

void load_corners(const MeshData& mesh, std::int32_t leaf, Corners& corners) {
  const MeshCorners* triangles = leaf_corners(mesh, leaf);
  for (int lane = 0; lane < kBlock; ++lane) {
    for (int corner = 0; corner < 3; ++corner) {
      const float* vertex = mesh.vertex + std::ptrdiff_t{3} * triangles[lane].vertex[corner];
      for (int axis = 0; axis < 3; ++axis) corners.at[corner][axis][lane] = vertex[axis];
    }
  }
}

// A bit for each triangle of a leaf: the last one is filled up with copies.
std::uint32_t triangles_of(const MeshData& mesh, std::int32_t leaf) {
  const std::int32_t left = mesh.triangle_count - leaf * kBlock;
  return left >= kBlock ? 0xffffu : (1u << left) - 1u;
}

void widen(float& size, float by) {
  const float far = __builtin_fabsf(by);
  size = far > size ? far : size;
}

// The triangles that a ray may meet within their edges.
//
// Errors: with p the point of the ray where it enters the leaf's box and M the largest coordinate of a corner
// relative to it, a relative coordinate is off by the rounding of p and its own, e = u (|p| + M) + r, where
// u = 2^-24 and r is that of the task. Shearing leaves 2 e + 4 u M in numbers of at most 2 M. So the doubled
// area of a triangle with the ray as a corner, of two products of such numbers, is off by less than
// 8 M (2 e + 4 u M) + 8 u (2 M)^2.
std::uint32_t within_edges(const MeshData& mesh, const MeshRayTask& task, std::int32_t leaf, float at) {
  constexpr float kUnit = 6.0e-8f;
  const NodeBlock& parent = mesh.nodes[0][leaf / kBlock];
  const int child = leaf % kBlock;
  float place[3], size = 0.0f, far = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    place[axis] = static_cast<float>(task.origin[axis] + double{at} * task.way[axis]);
    widen(far, place[axis]);
    widen(size, parent.bounds[axis][child] - place[axis]);
    widen(size, parent.bounds[axis + 3][child] - place[axis]);
  }
  const float error = 2.0f * (kUnit * (far + size) + task.rounding) + 4.0f * kUnit * size;
  const float margin = (8.0f * size + 2.0f * error) * error + 32.0f * kUnit * size * size;
  Corners corners;
  load_corners(mesh, leaf, corners);
  const int across = task.axis[0], up = task.axis[1], along = task.axis[2];
  const F origin_x(place[across]), origin_y(place[up]), origin_z(place[along]);
  const F slope_x(task.slope[0]), slope_y(task.slope[1]);
  const F least(-margin), most(margin);
  std::uint32_t fronts = 0, backs = 0;
  for (int first = 0; first < kBlock; first += kLanes) {
    F x[3], y[3];
    for (int corner = 0; corner < 3; ++corner) {
      const F z = load(&corners.at[corner][along][first]) - origin_z;
      x[corner] = load(&corners.at[corner][across][first]) - origin_x - slope_x * z;
      y[corner] = load(&corners.at[corner][up][first]) - origin_y - slope_y * z;
    }
    const F area_0 = x[1] * y[0] - y[1] * x[0];
    const F area_1 = x[2] * y[1] - y[2] * x[1];
    const F area_2 = x[0] * y[2] - y[0] * x[2];
    fronts |= bits(min(min(area_0, area_1), area_2) >= least) << first;
    backs |= bits(max(max(area_0, area_1), area_2) <= most) << first;
  }
  return triangles_of(mesh, leaf) &
         (((task.sides & kFrontSide) != 0 ? fronts : 0u) | ((task.sides & kBackSide) != 0 ? backs : 0u));
}

// Asks the triangles of a leaf whose boxes matter.
template <class Measure>
float ask_boxes(const Measure& measure, const MeshData& mesh, std::int32_t leaf, float limit, AskShape ask,
                void* context) {
  Corners corners;
  load_corners(mesh, leaf, corners);
  alignas(64) float bounds[6][kBlock];
  for (int first = 0; first < kBlock; first += kLanes) {
    for (int axis = 0; axis < 3; ++axis) {
      const F a = load(&corners.at[0][axis][first]);
      const F b = load(&corners.at[1][axis][first]);
      const F c = load(&corners.at[2][axis][first]);
      store(&bounds[axis][first], min(min(a, b), c));
      store(&bounds[axis + 3][first], max(max(a, b), c));
    }
  }
  const std::uint32_t there = triangles_of(mesh, leaf);
  Visit triangles[kBlock];
  int count = list_children(measure, bounds, limit, 0, 0, triangles);
  while (count > 0) {
    const Visit triangle = triangles[--count];
    if (!(triangle.at <= limit)) break;
    if ((there >> triangle.child & 1u) != 0) limit = ask(context, leaf * kBlock + triangle.child, limit);
  }
  return limit;
}

template <class Measure>
float walk(const Measure& measure, const MeshData& mesh, float limit, AskShape ask, void* context) {
  return walk_nodes(measure, mesh.nodes, mesh.levels, limit, [&](std::int32_t leaf, float, float now) {
    return ask_boxes(measure, mesh, leaf, now, ask, context);
  });
}

}  // namespace

float cross_mesh_by_ray(const MeshData& mesh, const MeshRayTask& task, float limit, AskShape ask,
                        void* context);
float cross_mesh_by_ray(const MeshData& mesh, const MeshRayTask& task, float limit, AskShape ask,
                        void* context) {
  return walk_nodes(Crossing(task.line), mesh.nodes, mesh.levels, limit,
                    [&](std::int32_t leaf, float at, float now) {
                      std::uint32_t met = within_edges(mesh, task, leaf, at);
                      for (; met != 0 && !(now < 0.0f); met &= met - 1) {
                        now = ask(context, leaf * kBlock + __builtin_ctz(met), now);
                      }
                      return now;
                    });
}

float cross_mesh(const MeshData& mesh, const CrossTask& task, float limit, AskShape ask, void* context);
float cross_mesh(const MeshData& mesh, const CrossTask& task, float limit, AskShape ask, void* context) {
  return walk(Crossing(task), mesh, limit, ask, context);
}

float meet_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context);
float meet_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context) {
  return walk(Meeting(task), mesh, limit, ask, context);
}

float approach_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context);
float approach_mesh(const MeshData& mesh, const MeetTask& task, float limit, AskShape ask, void* context) {
  return walk(Approach(task), mesh, limit, ask, context);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
