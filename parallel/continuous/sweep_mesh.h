// Sweeps of balls against meshes; sweep_fast_bodies.cpp tells what a sweep is.
#pragma once

#include <core/plain/mesh.h>
#include <parallel/continuous/sweep_path.h>
#include <simd/queries/query_kernels.h>

namespace scree::sweeps {

// The first meeting of a ball with a triangle of a mesh, which each is an obstacle of its own: where the
// ball's center comes from the front and moves against it.
Meeting meeting_with_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose,
                          const Sweep& sweep, std::int32_t shape);

// Whether the box of any triangle is near a ball's straight way: those of all balls within it, on chords of
// ways within its own, meet no other triangle.
bool is_near_mesh(const simd::QueryKernels& kernels, const MeshData& mesh, const PoseRow& pose, Vec3 start,
                  Vec3 end, float radius);

}  // namespace scree::sweeps
