// The hulls of a snapshot as bytes: each solid once, as it was built, then the slots.
//
//   u32      number of solids; of each
//     u32      vertices, faces, corners of all faces
//     f64 x 3  origin
//     u64 x 4  report: given_points, merged_points, inner_points, cut_vertices
//     f32      report: deviation
//     f32 x 3  of each vertex: HullTopology::vertices
//     f32 x 3  of each vertex: HullSolid::points
//     u16      of each face: its corners
//     u8       of each corner: its vertex
//   u32      number of slots; of each
//     i32 x 2  the unscaled solid and the scaled one, -1: the slot is free
//     f32 x 3  scale
//     f32      rounding, m
#pragma once

#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_solids.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// Hulls as bytes; reading refuses what is no convex polyhedron within the limits of Hull.
void write_hulls(const std::vector<SharedHull>& hulls, ByteWriter& writer);
std::vector<SharedHull> read_hulls(ByteReader& reader);

// Their two parts alone: solids, which are appended to those that are known, and slots.
void write_solids(std::span<const SolidPointer> solids, ByteWriter& writer);
void read_solids(ByteReader& reader, std::vector<SolidPointer>& solids);
void write_slots(const std::vector<SharedHull>& hulls, const std::vector<std::int32_t>& numbers,
                 ByteWriter& writer);
std::vector<SharedHull> read_slots(ByteReader& reader, std::span<const SolidPointer> solids);

}  // namespace scree
