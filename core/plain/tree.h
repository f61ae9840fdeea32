// Blocks of trees of 16 children, of the broad phase, of queries and of meshes. Plain memory only, see
// rows.h.
#pragma once

namespace scree {

// Blocks have 16 members for every instruction set: one register for AVX-512, four for SSE2.
inline constexpr int kTreeBlock = 16;
// 16^8 leaves are more than a 32-bit index can name.
inline constexpr int kMaxTreeLevels = 8;

// The boxes of 16 children: lower x y z, upper x y z. Absent children have empty boxes.
struct alignas(64) NodeBlock {
  float bounds[6][kTreeBlock];
};

}  // namespace scree
