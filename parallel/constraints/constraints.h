// Constraints: contacts and joints by color, packed into wide blocks. Each step rebuilds all of it except the
// colors, which stay with their contacts (ContactRows::color) and joints.
//
// color_constraints writes the colors, pack_blocks the rest; solve and store_impulses read it.
#pragma once

#include <core/constraints/user_rows.h>
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

// A active contact or an active joint, as coloring and packing see it.
struct Edge {
  std::int32_t body_a;  // a body that cannot be pushed is A, even if it is the joint's b
  std::int32_t body_b;
  std::uint16_t info;  // Manifold::info; of joints the number of their kind, see joint_block_kind
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

// Of a body with constraints that need a color: the first part of the order with any of them, and whether one
// of these waits in this round.
struct BodyClaim {
  std::int32_t part;
  std::int32_t waits;
};

// Colors that two kept constraints of a body have.
struct BodyClashes {
  std::uint64_t dynamic_colors;
  std::uint64_t static_colors;
  std::uint64_t hub_colors;
};

// One stage of the solver. Its chunks, some of contacts and some of joints, have no dynamic body in common,
// or one thread runs them in order. Within a chunk only a hub comes twice.
struct ColorStage {
  std::int32_t first_contact_chunk;
  std::int32_t contact_chunk_count;
  std::int32_t first_joint_chunk;
  std::int32_t joint_chunk_count;
  std::int32_t turn;  // which of the colors in use, in the order of solving
  bool serial;
  bool rich;  // has chunks of a rich variant
};

// A chunk, and a number to order it by.
struct ChunkPlace {
  std::int32_t place;
  std::int32_t chunk;
};

// What is solved together: a level of the overflow's joints or contacts, or a color.
struct SolvedTogether {
  std::int32_t place;  // see sort_constraints.h
  std::int32_t level;  // of place 0
  bool joints, contacts;
  bool serial;  // one thread runs it
};

// Of one chunk of moving bodies.
struct FinishSum {
  double kinetic_energy;  // J, of the dynamic ones
  std::int64_t restored;
};

// Rows sorted by key: how many there are of each, and where the lanes of each begin.
// clang-format off
#define SCREE_KEY_TABLE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                \
  VALUE(scratch, int,          kinds, 0)          /* keys of a place in the order of solving */                 \
  LIST (scratch, std::int32_t, counts)            /* by part and key; then where the part's rows of the key begin */ \
  LIST (scratch, std::int32_t, sums)              /* by part, see count_keys() */                               \
  LIST (scratch, std::int32_t, totals)            /* by key */                                                  \
  LIST (scratch, std::int32_t, in_place)          /* by place: totals of its keys. Where that is zero, nothing  \
                                                     else is read */                                            \
  LIST (scratch, std::int32_t, first_lane)        /* by key, and where the last one ends */                     \
  LIST (scratch, std::int32_t, overflow)          /* edges of place 0, level by level in the order of kinds */  \
  LIST (scratch, std::int32_t, level_ends)        /* in `overflow`, by level */                                 \
  LIST (scratch, std::int32_t, level_sizes)       /* by level: how many constraints the whole world has there */ \
  VALUE(scratch, std::int32_t, overflow_lanes, 0)
// clang-format on
SCREE_STORE(KeyTable, SCREE_KEY_TABLE_MEMBERS)

// Copies that the callback of user joints writes, by place in `asked`.
// clang-format off
#define SCREE_USER_REFRESH_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                             \
  LIST (scratch, std::int32_t,  asked)            /* joints, ascending */                                       \
  LIST (scratch, JointId,       ids)                                                                            \
  LIST (scratch, UserJacobians, jacobians)                                                                      \
  LIST (scratch, UserTargets,   targets)                                                                        \
  LIST (scratch, UserBounds,    bounds)                                                                         \
  LIST (scratch, UserVerdict,   verdicts)
// clang-format on
SCREE_STORE(UserRefresh, SCREE_USER_REFRESH_MEMBERS)

// What joints of one block have in common, and its number.
struct JointBlockKind {
  int variant;           // simd::joint_variant
  simd::BodySide fixed;  // which body cannot be pushed
  bool breaks;
};
inline constexpr int kJointBlockKinds = simd::kJointVariants * 6;
inline int number_of(const JointBlockKind& kind) {
  return (kind.variant * 3 + static_cast<int>(kind.fixed)) * 2 + (kind.breaks ? 1 : 0);
}
inline JointBlockKind joint_block_kind(int number) {
  return {number / 6, static_cast<simd::BodySide>(number / 2 % 3), number % 2 != 0};
}
struct JointBlockKindSet {
  std::uint64_t bits[(kJointBlockKinds + 63) / 64];
};

// clang-format off
#define SCREE_CONSTRAINT_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                               \
  LIST (scratch, Edge,         edges)           /* color_constraints; by place in the list of active contacts, then in    \
                                                   that of joints */                                            \
  VALUE(scratch, bool,         is_colored, false) /* color_constraints: `edges` hold a whole coloring */        \
  LIST (scratch, BodyColors,   body_colors)     /* color_constraints; by body */                                \
  LIST (scratch, std::int32_t, joint_count)     /* color_constraints; by body; joints with others that can be   \
                                                   pushed */                                                    \
  LIST (scratch, std::int32_t, uncolored)       /* color_constraints; edges that need a color */                \
  LIST (scratch, std::int32_t, part_counts)     /* color_constraints; of them, by part of the edges */          \
  LIST (scratch, BodyClaim,    claims)          /* color_in_rounds; by body */                                  \
  LIST (scratch, std::int32_t, ordered)         /* color_in_order */                                            \
  LIST (scratch, BodyClashes,  clashes)         /* color_constraints; by body; none but while it drops colors */          \
  LIST (scratch, std::uint16_t, keys)           /* pack_blocks; by edge */                                      \
  LIST (scratch, std::int32_t, overflow_begins) /* pack_blocks; first place in `overflow_edges` by kind */      \
  LIST (scratch, std::int32_t, overflow_edges)  /* pack_blocks; edges without a color, kind by kind */          \
  LIST (scratch, std::int32_t, overflow_levels) /* pack_blocks; theirs */                                       \
  LIST (scratch, SolvedTogether, solving)       /* pack_blocks; in the order of solving */                      \
  TABLE(scratch, UserRefresh,  refresh, "constraints.refresh") /* refresh_user_rows */                          \
  TABLE(scratch, KeyTable,     contact_keys, "constraints.contact_keys") /* pack_blocks */                      \
  TABLE(scratch, KeyTable,     joint_keys, "constraints.joint_keys") /* pack_blocks */                          \
  LIST (scratch, std::int32_t, joint_lanes)     /* pack_blocks; joints in lane order */                         \
  LIST (scratch, simd::ConstraintChunk, joint_chunks) /* pack_blocks */                                         \
  LIST (scratch, JointBlockKindSet, joint_block_kinds) /* pack_blocks; that occur, by part of the joints */      \
  LIST (scratch, std::int32_t, breaking_chunks) /* break_joints; of joint_chunks */                             \
  LIST (scratch, std::int32_t, contact_lanes)   /* pack_blocks; rows of contacts in lane order */               \
  LIST (scratch, std::int32_t, hub_counts)      /* pack_blocks; by hub */                                       \
  LIST (scratch, std::int32_t, hub_rows)        /* pack_blocks; rows of one hub color, sorted by hub */         \
  LIST (scratch, char,         blocks)          /* prepare and the sweeps */                                    \
  LIST (scratch, simd::ConstraintChunk, contact_chunks) /* pack_blocks */                                       \
  LIST (scratch, std::int32_t, chunk_order)     /* order_chunks; stage by stage its chunks as threads take them, \
                                                   by their numbers within it, those of joints first */         \
  LIST (scratch, std::int32_t, share_order)     /* order_chunks; all chunks, those of joints first, by the share \
                                                   of their stage */                                            \
  LIST (scratch, ChunkPlace,   chunk_places)    /* order_chunks; of a stage, by body */                         \
  LIST (scratch, ChunkPlace,   chunk_shares)    /* order_chunks */                                              \
  LIST (scratch, ColorStage,   stages)          /* pack_blocks; in the order in which they are solved */        \
  LIST (scratch, float,        parts_a)         /* solve; of joints; JointArgs::parts_a */                      \
  LIST (scratch, float,        parts_b)         /* solve; of joints; JointArgs::parts_b */                      \
  LIST (scratch, std::uint8_t, shared)          /* solve; JointArgs::shared */                                  \
  LIST (scratch, float,        residual)        /* solve; m/s by chunk */                                       \
  LIST (scratch, float,        impulse_sum)     /* solve; N s by lane, if events are asked for */               \
  LIST (scratch, std::uint8_t, impacts)         /* rebound; simd::ImpactState by chunk of contacts */           \
  LIST (scratch, simd::ImpactTimes, impact_times) /* rebound; by body */                                        \
  LIST (scratch, VelocityRow,  velocity_before) /* rebound; by body, before the impacts of a substep */         \
  LIST (scratch, float,        force_sum)       /* solve; by lane, if forces are asked for */                   \
  LIST (scratch, float,        depth)           /* store_impulses; m by lane, on request */                     \
  LIST (scratch, float,        depths)          /* store_impulses; m, of overlapping manifolds, for the ranking */ \
  LIST (scratch, std::int32_t, moving_bodies)   /* solve; awake dynamic bodies, then kinematic ones */          \
  LIST (scratch, float,        kinetic_energy)  /* finish_step; J by place in `moving_bodies` */                \
  LIST (scratch, std::uint8_t, non_finite)      /* finish_step; by place in `moving_bodies` */                  \
  LIST (scratch, FinishSum,    finish_sums)     /* finish_step; by chunk of `moving_bodies` */
// clang-format on
SCREE_PART(Constraints, SCREE_CONSTRAINT_MEMBERS)

Constraints& constraints_of(WorldData& data);

// For the kernels over contact blocks and joint blocks.
simd::ContactArgs contact_args(WorldData& data, Constraints& constraints, float dt);
simd::JointArgs joint_args(WorldData& data, Constraints& constraints, float dt);

}  // namespace scree
