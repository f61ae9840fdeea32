// Sweeps of balls against meshes; sweep_fast_bodies.cpp tells what a sweep is.
#pragma once

#include <core/plain/mesh.h>
#include <parallel/continuous/sweep_path.h>
#include <simd/queries/query_kernels.h>

#include <span>

namespace scree::sweeps {

// The most ends of ways that drop_triangles_below() is asked about: of all balls of a shape in so many
// stretches of its motion, and of the way of its center.
inline constexpr int kMostStretches = 4, kMostEnds = kMostBalls * kMostStretches + 1;

// Triangles of one mesh that may be near what moves in a step.
struct NearTriangles {
  static constexpr int kMost = 32;
  std::int32_t row[kMost];
  int count = 0;
  bool too_many = false;  // there are more than are listed
};

// A ball's straight way that is asked for near triangles.
struct MeshReach {
  Vec3 start, end;
  float radius;
};

// The first meeting of a ball with a triangle of a mesh, which each is an obstacle of its own: where the
// ball's center comes from the front and moves against it. `near`: all that are near, or null where that is
// not known.
Meeting meeting_with_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                          const Sweep& sweep, std::int32_t shape, const NearTriangles* near);

// Lists the triangles whose boxes are near the way: all balls within the ball, on chords of ways within its
// own, meet no other triangle.
void list_near_triangles(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                         const MeshReach& reach, NearTriangles& near);
// Takes out those above whose planes the cores of all these balls end, and that hence none of them meets.
// `ends`: where the balls' ways end; `room`: m, by which that may be wrong, and more than a way's rounding.
void drop_triangles_below(const MeshData& mesh, const PoseRow& pose, std::span<const Ball> ends, float room,
                          NearTriangles& near);
// Whether any triangle is near such a way, of those in `near` if that is not null.
bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                  const MeshReach& reach, const NearTriangles* near);
// Whether the box of any is near the box, in which ways lie.
bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                  const Swept& box);

}  // namespace scree::sweeps
