// Constraints: contacts by color, packed into wide blocks. Made anew each step, but for the colors
// themselves, which stay with their contacts (ContactRows::color).
//
// color_constraints writes the colors, pack_blocks everything else, solve and store_impulses read it.
#pragma once

#include <core/world_data.h>
#include <simd/contact_kernels.h>

namespace scree {

inline constexpr int kColorLimit = 64;              // colors of one kind: bits of a body's mask
inline constexpr int kHubColorLimit = 8;            // likewise of contacts with hubs
inline constexpr std::uint8_t kOverflowColor = 64;  // no color was free: solved one after the other

// Contacts with other bodies that can be pushed from which a body is a hub. Eight bodies of 1,300 contacts
// would otherwise use up all colors, most of them for a handful of contacts.
inline constexpr std::int32_t kHubDegree = 32;

// Which bodies of a contact keep it from sharing a color with others.
enum class EdgeKind : std::uint8_t {
  dynamic,   // both
  pushed_b,  // B: A cannot be pushed
  hub_a,     // B: A is a hub
  hub_b,     // A: B is a hub
  two_hubs,  // always overflows
};

// A touching contact, as coloring and packing see it.
struct ContactEdge {
  std::int32_t body_a;
  std::int32_t body_b;
  std::uint16_t info;  // Manifold::info
  std::uint8_t color;
  EdgeKind kind;
};

// Colors in use by the contacts of a body, and how many bodies it touches that can be pushed.
struct BodyColors {
  std::uint64_t dynamic_colors;
  std::uint64_t static_colors;
  std::uint64_t hub_colors;
  std::int32_t degree;
  std::int32_t number;  // pack_blocks; of a hub among those of a key, else -1
};

// One stage of the solver: chunks [first_chunk, first_chunk + chunk_count) have no dynamic body in common, or
// are run in their order by one thread. Within a chunk only a hub comes twice.
struct ColorStage {
  std::int32_t first_chunk;
  std::int32_t chunk_count;
  bool serial;
  bool rich;  // has chunks of a rich variant
};

// Of one chunk of moving bodies.
struct FinishSum {
  double kinetic_energy;  // J, of the dynamic ones
  std::int64_t restored;
};

struct Constraints : Part {
  Column<ContactEdge> edges;             // scratch; color_constraints; by place in the touching list
  bool is_colored = false;               // scratch; color_constraints: `edges` hold a whole coloring
  Column<BodyColors> body_colors;        // scratch; color_constraints; by body
  Column<std::int32_t> uncolored;        // scratch; color_constraints; edges that need a color
  Column<std::int32_t> part_counts;      // scratch; color_constraints; of them, by part of the edges
  Column<BoundsRow> cell_bounds;         // scratch; color_by_cells; of the bodies, by part of the awake ones
  Column<std::int32_t> cells;            // scratch; color_by_cells; by place in `uncolored`
  Column<std::int32_t> cell_rows;        // scratch; color_by_cells; `uncolored`, sorted by cell
  Column<std::int32_t> cell_begins;      // scratch; color_by_cells; first place in `cell_rows` by cell
  Column<std::int32_t> histogram;        // scratch; color_by_cells, pack_blocks; by part and key
  Column<std::uint16_t> keys;            // scratch; pack_blocks; by place in the touching list
  Column<std::int32_t> points;           // scratch; pack_blocks; contact points by part of the touching list
  Column<std::int32_t> rows;             // scratch; pack_blocks; contact rows in lane order
  Column<std::int32_t> hub_counts;       // scratch; pack_blocks; by hub
  Column<std::int32_t> hub_rows;         // scratch; pack_blocks; contacts of one hub color, sorted by hub
  Column<char> blocks;                   // scratch; prepare and the sweeps
  Column<simd::ConstraintChunk> chunks;  // scratch; pack_blocks
  Column<ColorStage> stages;             // scratch; pack_blocks; in the order in which they are solved
  Column<float> residual;                // scratch; solve; m/s by chunk
  Column<float> impulse_sum;             // scratch; solve; N s by lane, if events are asked for
  Column<float> depth;                   // scratch; store_impulses; m by lane, on request
  Column<float> depths;           // scratch; store_impulses; m, of overlapping manifolds, for the ranking
  Column<std::int32_t> moving;    // scratch; solve; awake dynamic bodies, then kinematic ones
  Column<float> kinetic_energy;   // scratch; finish_step; J by place in `moving`
  Column<std::uint8_t> broken;    // scratch; finish_step; by place in `moving`
  Column<FinishSum> finish_sums;  // scratch; finish_step; by chunk of `moving`

  void report(const Visit& visit) const override;
  void forget() noexcept override { is_colored = false; }
};

Constraints& constraints_of(WorldData& data);

// For the kernels over contact blocks.
simd::ContactArgs contact_args(WorldData& data, Constraints& constraints, float dt);

}  // namespace scree
