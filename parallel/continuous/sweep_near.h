// What at rest is near the ways of fast bodies, so that their many balls need not ask the trees; part of
// sweep_fast_bodies.cpp, which tells what a sweep is.
#pragma once

#include <parallel/broad_phase/broad_phase.h>
#include <parallel/continuous/sweep_mesh.h>
#include <parallel/continuous/sweep_motion.h>
#include <parallel/continuous/sweep_path.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

namespace scree::sweeps {

// Where a sweep finds what is in the way.
struct Obstacles {
  const WorldData& data;
  const BroadPhase& broad_phase;
  const simd::QueryKernels& kernels;
};

// A bit for each lane whose box meets this one; without branches, so that compilers take lanes together.
inline std::uint32_t lanes_met(const Swept& box, const float (&bounds)[6][simd::kBlock]) {
  static constexpr std::uint32_t kBit[] = {1u << 0,  1u << 1,  1u << 2,  1u << 3, 1u << 4,  1u << 5,
                                           1u << 6,  1u << 7,  1u << 8,  1u << 9, 1u << 10, 1u << 11,
                                           1u << 12, 1u << 13, 1u << 14, 1u << 15};
  static_assert(std::size(kBit) == simd::kBlock);
  const auto mask = [](bool holds) { return holds ? ~0u : 0u; };
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
    bits |= kBit[lane] & mask(box.lower[0] <= bounds[3][lane]) & mask(bounds[0][lane] <= box.upper[0]) &
            mask(box.lower[1] <= bounds[4][lane]) & mask(bounds[1][lane] <= box.upper[1]) &
            mask(box.lower[2] <= bounds[5][lane]) & mask(bounds[2][lane] <= box.upper[2]);
  }
  return bits;
}

// How many blocks stand under a level. A box without end meets empty lanes, too, behind which there is
// nothing.
inline std::size_t blocks_below(const PairTree& tree, int level) {
  return level > 0 ? tree.nodes[level - 1].size() : tree.leaves.size();
}

// Calls call(leaf, lane) for the shapes of the tree that are near, until it returns false; whether it did
// not.
template <class Call>
bool for_each_shape_near(const PairTree& tree, const Swept& box, int level, std::size_t block, Call&& call) {
  if (level < 0) {
    const simd::LeafBlock& leaf = tree.leaves[block];
    for (std::uint32_t met = lanes_met(box, leaf.bounds); met != 0; met &= met - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(met));
      if (leaf.shape[lane] >= 0 && !call(leaf, lane)) return false;
    }
    return true;
  }
  const std::size_t blocks = blocks_below(tree, level);
  for (std::uint32_t met = lanes_met(box, tree.nodes[level][block].bounds); met != 0; met &= met - 1) {
    const std::size_t child = block * simd::kBlock + static_cast<std::size_t>(std::countr_zero(met));
    if (child < blocks && !for_each_shape_near(tree, box, level - 1, child, call)) return false;
  }
  return true;
}

// A ball on a straight way that holds all that moves in it.
struct Reach {
  Vec3 start, end;
  float radius;
  Swept box;
  Reach(Vec3 from, Vec3 to, float size) : start(from), end(to), radius(size), box(from, to, size) {}
};

// What is near a body's way.
struct NearShapes {
  static constexpr int kMost = 16, kMostMeshes = 2;
  struct Row {
    std::int32_t shape;
    Swept bounds;
    int mesh;  // in `triangles`; -1: is none, or its triangles are not listed
  } row[kMost];
  NearTriangles triangles[kMostMeshes];
  int count = 0, meshes = 0;
  bool too_many = false;
  bool any = false;  // as seen without room for rounding

  const NearTriangles* triangles_of(const Row& near) const {
    return near.mesh >= 0 ? &triangles[near.mesh] : nullptr;
  }
};

// Whether two boxes meet.
inline bool overlap(const Swept& a, const Swept& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis])) return false;
  }
  return true;
}

// Null where the shape is none.
inline const MeshData* mesh_of(const WorldData& data, std::int32_t shape) {
  if (data.shapes.type[shape] != ShapeType::mesh) return nullptr;
  return data.meshes.data[data.shapes.mesh[shape]];
}

// m, by which places in floats are off at most.
inline float rounding_of(Vec3 a, Vec3 b, float size) {
  constexpr float kRounding = 4e-6f;  // of coordinates
  const auto sum = [](Vec3 v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  return kRounding * (sum(a) + sum(b) + size);
}

// Whether the body's shapes are swept as they are.
bool moves_whole(const WorldData& data, std::int32_t body);
// m, about the center of mass around what is swept.
float swept_radius(const WorldData& data, std::int32_t body);
// Around the body's way, with room for rounding.
Reach reach_of_way(const WorldData& data, std::int32_t body);

// Whether nothing at rest is near the ways of all these bodies. May miss that, but is never wrong.
bool are_free(const Obstacles& obstacles, std::span<const std::int32_t> bodies);

// Lists what is near a body's way. `box`: that of `reach` without its room for rounding.
void list_near(const Obstacles& obstacles, const Reach& reach, const Swept& box, NearShapes& near);

// Takes from what is near a body the triangles that none of its balls comes down to in any of the stretches
// that its motion is cut into: of bodies that roll or tumble over a mesh, nearly all.
void drop_far_triangles(const WorldData& data, std::int32_t body, const Motion& motion, int stretches,
                        const Reach& reach, NearShapes& near);

}  // namespace scree::sweeps
