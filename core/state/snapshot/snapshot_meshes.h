// The meshes of a snapshot as bytes: the parts of each mesh once, then the slots. What follows from the parts
// is made again when they are read.
//
//   u32      number of meshes; of each
//     u32      vertices, triangles
//     u32 x 2  materials; 1 if triangles name theirs, 0 if not
//     f64 x 3  origin
//     u64 x 12 report: as TriangleMeshReport lists its counts, those of `given` first
//     f32 x 6  report: lower and upper of `given`
//     f32 x 3  of each vertex
//     u32 x 3  of each triangle
//     i32      of each triangle: its number as it was handed in
//     u8       of each triangle, if they name any: its material
//     ...      of each material: its fields, see value_bytes.h
//   u32      number of slots; of each
//     i32      the mesh, -1: the slot is free
#pragma once

#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_solids.h>

#include <cstdint>
#include <span>
#include <vector>

namespace scree {

// Meshes as bytes; reading refuses what complete_mesh could not make a mesh of.
void write_meshes(const std::vector<SharedMesh>& meshes, ByteWriter& writer);
std::vector<SharedMesh> read_meshes(ByteReader& reader);

// Their two parts alone: meshes, which are appended to those that are known, and slots.
void write_mesh_solids(std::span<const MeshPointer> meshes, ByteWriter& writer);
void read_mesh_solids(ByteReader& reader, std::vector<MeshPointer>& meshes);
void write_mesh_slots(const std::vector<std::int32_t>& numbers, ByteWriter& writer);
std::vector<SharedMesh> read_mesh_slots(ByteReader& reader, std::span<const MeshPointer> meshes);

}  // namespace scree
