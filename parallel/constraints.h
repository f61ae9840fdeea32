// Constraints: contacts by color, packed into wide blocks. Made anew each step, but for the colors
// themselves, which stay with their contacts (ContactRows::color).
//
// color_constraints writes the colors, pack_blocks everything else, solve and store_impulses read it.
#pragma once

#include <core/world_data.h>
#include <simd/contact_kernels.h>

namespace scree {

inline constexpr int kColorLimit = 64;              // colors of one kind: bits of a body's mask
inline constexpr std::uint8_t kOverflowColor = 64;  // no color was free: solved one after the other

// One stage of the solver: chunks [first_chunk, first_chunk + chunk_count) touch no dynamic body twice, or
// are run in their order by one thread.
struct ColorStage {
  std::int32_t first_chunk;
  std::int32_t chunk_count;
  bool serial;
  bool rich;  // has chunks of a rich variant
};

struct Constraints : Part {
  Column<std::uint64_t> dynamic_colors;  // scratch; color_constraints; by body: colors in use
  Column<std::uint64_t> static_colors;   // scratch; likewise against bodies that cannot be pushed
  Column<std::int32_t> uncolored;        // scratch; color_constraints; rows that need a color
  Column<std::int32_t> histogram;        // scratch; pack_blocks; by part of the touching list and key
  Column<std::uint16_t> keys;            // scratch; pack_blocks; by place in the touching list
  Column<std::int32_t> points;           // scratch; pack_blocks; contact points by part of the touching list
  Column<std::int32_t> rows;             // scratch; pack_blocks; contact rows in lane order
  Column<char> blocks;                   // scratch; prepare and the sweeps
  Column<simd::ContactChunk> chunks;     // scratch; pack_blocks
  Column<ColorStage> stages;             // scratch; pack_blocks; in the order in which they are solved
  Column<float> residual;                // scratch; solve; m/s by chunk
  Column<float> depth;                   // scratch; store_impulses; m by lane, on request
  Column<float> depths;          // scratch; store_impulses; m, of overlapping manifolds, for the ranking
  Column<std::int32_t> moving;   // scratch; solve; awake dynamic bodies, then kinematic ones
  Column<float> kinetic_energy;  // scratch; finish_step; J by place in `moving`
  Column<std::uint8_t> broken;   // scratch; finish_step; by place in `moving`

  void report(const Visit& visit) const override;
};

Constraints& constraints_of(WorldData& data);

// For the kernels over contact blocks.
simd::ContactArgs contact_args(WorldData& data, Constraints& constraints, float dt);

}  // namespace scree
