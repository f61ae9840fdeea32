// Scratch of collide: the pairs of this step, grouped by the types of their shapes and by whether they have
// touched.
#pragma once

#include <core/world/column.h>
#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <parallel/crew/list_where.h>
#include <parallel/narrow_phase/mesh_manifolds.h>
#include <simd/collide/collide_kernels.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree {

// Pairs handled by one chunk of the passes over pairs.
inline constexpr int kPairChunk = 1024;
// Chunks of pairs that are no contacts in one round: their rows, 2 MB of manifolds, stay in the caches.
inline constexpr int kRoundChunks = 64;
// Groups: the collide types of pairs that are contacts, then those of pairs that are not.
inline constexpr std::size_t kPairGroups = 2 * simd::kCollideTypes;
using GroupCounts = TableArray<std::int32_t, kPairGroups>;
using GroupBegins = TableArray<std::int32_t, kPairGroups + 1>;

// Values of NarrowPhase::kind beside simd::CollideType.
inline constexpr std::uint8_t kMeshPair = simd::kCollideTypes;  // one of its shapes is a mesh
// No body is awake: the contact, if it is one, stays as it is. Or there is none, and the shapes are clear of
// each other.
inline constexpr std::uint8_t kSkipped = kMeshPair + 1;
inline constexpr std::uint8_t kNever = kMeshPair + 2;  // no dynamic body, or a hook took the pair out

enum RuleVerdict : std::uint8_t { kSameRules, kOtherRules, kUnsoundRules };

// Of each chunk of pairs with meshes, or of each thread.
using FoundManifolds = std::vector<Column<simd::MeshManifold>>;
using TriangleContacts = std::vector<Column<simd::TriangleContact>>;
using MeshDepths = std::vector<Column<MeshDepth>>;
using ContactNumbers = std::vector<Column<std::int32_t>>;
using MeshPoints = std::vector<Column<MeshPoint>>;

struct PairOutcome {     // of one chunk of pairs
  std::int32_t active;   // contacts of an awake dynamic body, then where they go
  std::int32_t resting;  // other contacts
  std::int32_t lost;     // contacts that are no more, then where they go
};

// clang-format off
#define SCREE_NARROW_PHASE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                             \
  LIST (scratch, std::uint8_t, kind)            /* per pair: collide type, kSkipped or kNever */                \
  LIST (scratch, PairClearance, clearance)      /* per pair, while there are hulls; see is_clear */               \
  LIST (scratch, PairClearance, last_clearance) /* per pair of the last list */                                 \
  VALUE(scratch, std::uint64_t, list_number, 0) /* Contacts::list_number of the list that `clearance` is of */ \
  LIST (scratch, GroupCounts,  chunk_counts)    /* per chunk of pairs: how many of each group, then where they go */ \
  LIST (scratch, PairOutcome,  outcomes)        /* per chunk of pairs */                                        \
  LIST (scratch, std::int32_t, order)           /* the pairs by group, ascending */                             \
  LIST (scratch, std::int32_t, fresh)           /* places of a round whose pairs touch, ascending */            \
  LIST (scratch, Manifold,     fresh_manifold)  /* by place in a round: rows of pairs that were no contacts */  \
  LIST (scratch, ManifoldFeatures, fresh_features)                                                              \
  LIST (scratch, ContactSurface, fresh_surface)                                                                 \
  LIST (scratch, ContactAnchor, fresh_anchor)                                                                   \
  LIST (scratch, std::uint8_t, fresh_points)    /* 0: does not touch */                                         \
  LIST (scratch, std::int32_t, places)          /* of list_where */                                             \
  LIST (scratch, std::int32_t, mesh_pairs)      /* pairs with a mesh that are collided, ascending */            \
  TABLE(scratch, FoundManifolds, mesh_found, "narrow_phase") /* per chunk of mesh_pairs */                      \
  LIST (scratch, std::int32_t, mesh_fresh)      /* per chunk of mesh_pairs: new contacts, then where they go */ \
  TABLE(scratch, TriangleContacts, mesh_contacts, "narrow_phase") /* per worker: see MeshScratch */             \
  TABLE(scratch, MeshDepths, mesh_order, "narrow_phase")                                                        \
  TABLE(scratch, ContactNumbers, mesh_cluster, "narrow_phase")                                                  \
  TABLE(scratch, MeshPoints, mesh_points, "narrow_phase")                                                       \
  LIST (scratch, std::int32_t, asked)           /* pairs that a hook is asked about, ascending */                \
  LIST (scratch, std::int32_t, asked_contacts)  /* their contacts that touch, in the order of the pairs */       \
  LIST (scratch, HookedPair,   asked_pairs)     /* as hooks get them: of pairs, then of contacts */              \
  LIST (scratch, HookedContact, asked_shown)    /* per contact */                                                \
  LIST (scratch, std::int32_t, asked_number)    /* per contact: which of its pair it is */                       \
  LIST (scratch, std::uint8_t, may_collide)     /* answers of the filter, per pair */                            \
  LIST (scratch, ContactRules, rules)           /* answers of the rule, per contact */                           \
  LIST (scratch, ContactAnswer, recorded)       /* what both hooks have changed, where that is recorded */       \
  LIST (scratch, std::uint8_t, verdicts)        /* what becomes of these: RuleVerdict */                         \
  VALUE(scratch, GroupBegins,  group_begin, {}) /* first pair of each group in `order` */
// clang-format on
SCREE_PART(NarrowPhase, SCREE_NARROW_PHASE_MEMBERS)

// In collide.cpp.
simd::CollideItem make_item(const WorldData& data, std::int32_t place);
simd::CollideColumns collide_columns(WorldData& data);
// Makes sure that there are `count` free rows. Where that takes more memory, `expected` further ones get
// some, too, as far as that does not double it: a million contacts that come at once would be copied nine
// times while columns grow by an eighth.
void provide_rows(Contacts& contacts, std::size_t count, std::size_t expected, bool with_forces);
// Clears what a new contact's kernel has not written: state must not depend on the contact that had the row
// before.
void clear_unwritten(ContactRows& rows, std::int32_t row, bool has_anchor);

// --- hooks, see ask_hooks.cpp ---

// Asks the filter, or the answers in its place, for pairs that have their kinds: those that it refuses become
// kNever.
void filter_pairs(WorldData& data, NarrowPhase& phase, Crew& crew);
// Whether it has to be asked.
bool has_filter(const WorldData& data);
// Asks the rule, or the answers in its place: changes contacts, and takes out those that do not act. Tells
// the recorder, if there is one, what both hooks have changed. The answers for this step are over then.
void rule_contacts(WorldData& data, NarrowPhase& phase, Crew& crew);

// Collides the pairs of kMeshPair: updates their contacts, ends and adds some.
void collide_meshes(WorldData& data, NarrowPhase& phase, Crew& crew);

}  // namespace scree
