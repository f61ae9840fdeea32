// Constraints: contacts and joints by color, packed into wide blocks. Each step rebuilds all of it except the
// colors, which stay with their contacts (ContactRows::color) and joints.
//
// color_constraints writes the colors, pack_blocks the rest; solve and store_impulses read it.
#pragma once

#include <core/world/world_data.h>
#include <simd/constraints/contact/contact_kernels.h>
#include <simd/constraints/joints/joint_kernels.h>

namespace scree {

inline constexpr int kColorLimit = 64;              // colors of one kind: bits of a body's mask
inline constexpr int kHubColorLimit = 8;            // the same for contacts with hubs
inline constexpr std::uint8_t kOverflowColor = 64;  // no color was free: solved level by level
// No static color was free: solved in groups, as constraints of a hub are.
inline constexpr std::uint8_t kStaticHubColor = 65;

// A body with more constraints than this, with other bodies that can be pushed, is a hub. Without hubs, eight
// bodies of 1,300 contacts use up all colors, most of them for a handful of contacts.
inline constexpr std::int32_t kHubDegree = 32;

// The bodies of a constraint whose other constraints must have other colors.
enum class EdgeKind : std::uint8_t {
  dynamic,   // both
  pushed_b,  // B: A cannot be pushed
  hub_a,     // B: A is a hub
  hub_b,     // A: B is a hub
  two_hubs,  // always overflows
};

// A touching contact or an active joint, as coloring and packing see it.
struct Edge {
  std::int32_t body_a;  // a body that cannot be pushed is A, even if it is the joint's b
  std::int32_t body_b;
  std::uint16_t info;  // Manifold::info; of joints the number of their kind, see joint_kind
  std::uint8_t color;
  EdgeKind kind;
};

// Colors in use by the constraints of a body, and how many others that can be pushed it has some with.
struct BodyColors {
  std::uint64_t dynamic_colors;
  std::uint64_t static_colors;
  std::uint64_t hub_colors;
  std::int32_t degree;
  std::int32_t number;  // pack_blocks; of a hub among those of a key, else -1
};

// One stage of the solver. Its chunks, some of contacts and some of joints, have no dynamic body in common,
// or one thread runs them in order. Within a chunk only a hub comes twice.
struct ColorStage {
  std::int32_t first_contact_chunk;
  std::int32_t contact_chunk_count;
  std::int32_t first_joint_chunk;
  std::int32_t joint_chunk_count;
  bool serial;
  bool rich;  // has chunks of a rich variant
};

// Of one chunk of moving bodies.
struct FinishSum {
  double kinetic_energy;  // J, of the dynamic ones
  std::int64_t restored;
};

// Rows sorted by key: how many there are of each, and where the lanes of each begin.
struct KeyTable {
  int kinds = 0;                    // keys of a place in the order of solving
  Column<std::int32_t> counts;      // by part and key; then where the part's rows of the key begin
  Column<std::int32_t> sums;        // by part, see count_keys()
  Column<std::int32_t> totals;      // by key
  Column<std::int32_t> in_place;    // by place: totals of its keys. Where that is zero, nothing else is read
  Column<std::int32_t> first_lane;  // by key, and where the last one ends
  Column<std::int32_t> overflow;    // edges of place 0, level by level in the order of kinds
  Column<std::int32_t> level_ends;  // in `overflow`, by level
  std::int32_t overflow_lanes = 0;
};

// What joints of one block have in common, and its number.
struct JointKind {
  int variant;           // simd::joint_variant
  simd::BodySide fixed;  // which body cannot be pushed
  bool breaks;
};
inline constexpr int kJointBlockKinds = simd::kJointVariants * 6;
inline int number_of(const JointKind& kind) {
  return (kind.variant * 3 + static_cast<int>(kind.fixed)) * 2 + (kind.breaks ? 1 : 0);
}
inline JointKind joint_kind(int number) {
  return {number / 6, static_cast<simd::BodySide>(number / 2 % 3), number % 2 != 0};
}
struct JointKindSet {
  std::uint64_t bits[(kJointBlockKinds + 63) / 64];
};

struct Constraints : Part {
  Column<Edge> edges;  // scratch; color_constraints; by place in the touching list, then in that of joints
  bool is_colored = false;         // scratch; color_constraints: `edges` hold a whole coloring
  Column<BodyColors> body_colors;  // scratch; color_constraints; by body
  // scratch; color_constraints; by body; joints with others that can be pushed
  Column<std::int32_t> joint_count;
  Column<std::int32_t> uncolored;        // scratch; color_constraints; edges that need a color
  Column<std::int32_t> part_counts;      // scratch; color_constraints; of them, by part of the edges
  Column<BoundsRow> cell_bounds;         // scratch; color_by_cells; of the bodies, by part of the awake ones
  Column<std::int32_t> cells;            // scratch; color_by_cells; by place in `uncolored`
  Column<std::int32_t> cell_rows;        // scratch; color_by_cells; `uncolored`, sorted by cell
  Column<std::int32_t> cell_begins;      // scratch; color_by_cells; first place in `cell_rows` by cell
  Column<std::int32_t> histogram;        // scratch; color_by_cells; by part and key
  Column<std::uint16_t> keys;            // scratch; pack_blocks; by edge
  Column<std::int32_t> overflow_begins;  // scratch; pack_blocks; first place in `overflow_edges` by kind
  Column<std::int32_t> overflow_edges;   // scratch; pack_blocks; edges without a color, kind by kind
  Column<std::int32_t> overflow_levels;  // scratch; pack_blocks; theirs
  KeyTable contact_keys;                 // scratch; pack_blocks
  KeyTable joint_keys;                   // scratch; pack_blocks
  Column<std::int32_t> joint_rows;       // scratch; pack_blocks; joints in lane order
  Column<simd::ConstraintChunk> joint_chunks;    // scratch; pack_blocks
  Column<JointKindSet> joint_kinds;              // scratch; pack_blocks; that occur, by part of the joints
  Column<std::int32_t> breaking_chunks;          // scratch; break_joints; of joint_chunks
  Column<std::int32_t> contact_rows;             // scratch; pack_blocks; rows of contacts in lane order
  Column<std::int32_t> hub_counts;               // scratch; pack_blocks; by hub
  Column<std::int32_t> hub_rows;                 // scratch; pack_blocks; rows of one hub color, sorted by hub
  Column<char> blocks;                           // scratch; prepare and the sweeps
  Column<simd::ConstraintChunk> contact_chunks;  // scratch; pack_blocks
  Column<ColorStage> stages;       // scratch; pack_blocks; in the order in which they are solved
  Column<float> parts_a, parts_b;  // scratch; solve; of joints; JointArgs::parts_a
  Column<std::uint8_t> shared;     // scratch; solve; JointArgs::shared
  Column<float> residual;          // scratch; solve; m/s by chunk
  Column<float> impulse_sum;       // scratch; solve; N s by lane, if events are asked for
  Column<std::uint8_t> rebounded;  // scratch; solve; by chunk, whether any contact did
  Column<float> force_sum;         // scratch; solve; by lane, if forces are asked for
  Column<float> depth;             // scratch; store_impulses; m by lane, on request
  Column<float> depths;            // scratch; store_impulses; m, of overlapping manifolds, for the ranking
  Column<std::int32_t> moving_bodies;  // scratch; solve; awake dynamic bodies, then kinematic ones
  Column<float> kinetic_energy;        // scratch; finish_step; J by place in `moving_bodies`
  Column<std::uint8_t> non_finite;     // scratch; finish_step; by place in `moving_bodies`
  Column<FinishSum> finish_sums;       // scratch; finish_step; by chunk of `moving_bodies`

  void report(const Visit& visit) const override;
  void forget() noexcept override { is_colored = false; }
};

Constraints& constraints_of(WorldData& data);

// For the kernels over contact blocks and joint blocks.
simd::ContactArgs contact_args(WorldData& data, Constraints& constraints, float dt);
simd::JointArgs joint_args(WorldData& data, Constraints& constraints, float dt);

}  // namespace scree
