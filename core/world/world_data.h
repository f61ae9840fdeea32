// WorldData: everything a world is, on one page. Who writes each column stands beside it.
//
// The lists below are the state table: each column is declared once, with its kind, and the structs, the
// resizing, the memory report and the hash are generated from it.
//   state    changes future results, so a snapshot holds it
//   derived  recomputable exactly from state
//   scratch  lives within one step
#pragma once

#include <core/plain/hull.h>
#include <core/plain/joint.h>
#include <core/plain/manifold.h>
#include <core/plain/rows.h>
#include <core/state/recording_format/call_sink.h>
#include <core/state/snapshot/change_marks.h>
#include <core/world/column.h>
#include <core/world/made_once.h>
#include <core/world/mass_moments.h>
#include <scree/world.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

namespace scree {

enum BodyFlag : std::uint8_t {
  kBodyAlive = 1,
  kBodyAsleep = 2,
  kBodyCanSleep = 4,
  kBodyMassGiven = 8,         // mass comes from the caller, inertia from the shapes
  kBodyPropertiesGiven = 16,  // mass, center and inertia come from the caller
  kBodyMarked = 32,           // set and cleared within one call
  // In quarantine: the state became non-finite. Takes part as a fixed body until a call ends that, but was
  // given as ...
  kBodyQuarantinedDynamic = 64,
  kBodyQuarantinedKinematic = 128,
  kBodyQuarantined = kBodyQuarantinedDynamic | kBodyQuarantinedKinematic,
};

enum class ShapeType : std::uint8_t { sphere, capsule, box, hull };
inline constexpr int kShapeTypeCount = 4;

enum ShapeFlag : std::uint8_t {
  kShapeAlive = 1,
  kShapeDirty = 2,  // bounds must be made before the next pairs: new, moved or changed by a call. A slot that
                    // is dirty but not alive held a shape that was destroyed
  kShapeNew = 4,    // with kShapeDirty: pairs that name the shape tell of a predecessor in its slot or
                    // of an earlier geometry or body type; their manifolds and colors must not be inherited
  kShapeWakes = 8,  // bodies that touched the shape wake at the next wake_neighbors; may stand on dead slots
};

// Which tree of the broad phase a shape belongs to.
enum class TreeKind : std::uint8_t { none, awake, kinematic, frozen };
inline constexpr int kTreeCount = 4;

enum JointFlag : std::uint8_t {
  kJointAlive = 1,
  kJointEnabled = 2,
  kJointCollides = 4,  // the shapes of its bodies collide with each other
  kJointBreaks = 8,    // has a limit in JointStrength
  kJointRich = 16,     // has limits or drives; see simd::joint_variant
};

// Of the bodies of a joint, one number each.
struct JointBodies {
  std::int32_t a, b;
};

// Of a pair at rest, in the lists of shape a and of shape b: the ends before and behind its own. An end is 1
// + 2 * row, and one more for shape b's; 0: none, so that rows of zeros are empty lists.
struct RestingLinks {
  std::uint32_t previous[2], next[2];
};

// What a joint bears.
struct JointStrength {
  float force;   // N
  float torque;  // N m
};

// How far a body may move before it must be swept.
struct CoreRow {
  float radius;  // m, half that of the smallest ball about a shape's center; infinite without shapes
  float reach;   // m, from the center of mass to the farthest ball's center; an upper bound
  float size;    // m, from the center of mass around all cores; an upper bound
};

inline constexpr CoreRow kNoCore{std::numeric_limits<float>::infinity(), 0.0f, 0.0f};

// What calls have left to do for a body, whose place_matter() is next.
enum UnplacedFlag : std::uint8_t {
  kShapesUnplaced = 1,  // the center has moved: local poses of shapes and frames of joints are those of an
                        // earlier one. All shapes are dirty
  kCoreUnmeasured = 2,
};

// clang-format off
// What World::hash covers of each living body, in the order of its bytes. Of a row, kHashedWords count.
#define SCREE_HASHED_BODY_COLUMNS(X)                                                                            \
  X(state,   PoseRow,         pose)            /* calls, solve; of the center of mass, in the body's axes */   \
  X(state,   VelocityRow,     velocity)        /* calls, solve */

// Rows of bodies, indexed by BodyId::index. "calls" are World's functions.
#define SCREE_BODY_COLUMNS(X)                                                                                   \
  X(state,   std::uint32_t,   generation)      /* calls; raised when the body dies */                          \
  X(state,   BodyType,        type)            /* calls, quarantine_bodies; as it takes part */                \
  X(state,   std::uint8_t,    flags)           /* calls, find_islands, quarantine_bodies; BodyFlag */          \
  SCREE_HASHED_BODY_COLUMNS(X)                                                                                 \
  X(state,   ForceRow,        force)           /* calls; cleared by finish_step */                             \
  X(state,   MotionRow,       motion)          /* calls; its locks act, so they are none if not given dynamic */ \
  X(state,   AxisLocks,       locks)           /* calls; as given */                                           \
  X(state,   float,           sleep_time)      /* calls, finish_step; s for which it has stayed, see finish */ \
  X(state,   DriftRow,        drift)           /* calls, finish_step, find_islands; since sleep_time was 0 */  \
  X(state,   InertiaRow,      local_mass)      /* calls; inverse inertia in body axes; zero if not given dynamic */ \
  X(state,   LocalInertiaRow, local_inertia)   /* calls; in body axes */                                       \
  X(state,   Vec3,            center)          /* calls; center of mass in the body's frame */                 \
  X(state,   float,           mass)            /* calls; kg */                                                 \
  X(state,   float,           given_mass)      /* calls; kg, with kBodyMassGiven */                            \
  X(state,   std::int32_t,    first_shape)     /* calls; -1: none */                                           \
  X(state,   std::int32_t,    first_joint)     /* calls; -1: none */                                           \
  X(state,   std::uint64_t,   user_data)       /* calls */                                                     \
  X(derived, Pose,            transform)       /* calls, finish_step; of the origin */                         \
  X(derived, CoreRow,         core)            /* calls, place_matter */                                       \
  X(derived, std::uint8_t,    unplaced)        /* calls, place_matter; UnplacedFlag */                         \
  X(derived, std::uint8_t,    is_changed)      /* calls, find_islands; 1: stands in Bodies::changed */         \
  X(scratch, InertiaRow,      inertia)         /* solve; inverse, in world axes, zero on locked axes */        \
  X(scratch, std::uint8_t,    step_notes)      /* solve; StepNote */                                           \
  X(scratch, DeltaRow,        delta)           /* solve; motion since the step began */                        \
  X(scratch, VelocityRow,     free_velocity)   /* solve; after forces, before this step's impulses */

// Rows of shapes, indexed by ShapeId::index.
#define SCREE_SHAPE_COLUMNS(X)                                                                                  \
  X(state,   std::uint32_t,   generation)      /* calls */                                                     \
  X(state,   ShapeType,       type)            /* calls */                                                     \
  X(state,   std::uint8_t,    flags)           /* calls, update_bounds; ShapeFlag */                           \
  X(state,   std::int32_t,    body)            /* calls */                                                     \
  X(state,   std::int32_t,    next)            /* calls; next shape of the body, -1: last */                   \
  X(state,   ExtentRow,       extent)          /* calls */                                                     \
  X(state,   std::int32_t,    hull)            /* calls; slot in WorldData::hulls, -1: no hull */              \
  X(derived, std::int32_t,    previous)        /* calls; before it in the list of `next`, -1: first */         \
  X(derived, PoseRow,         local_pose)      /* calls, place_matter; relative to the body's center of mass;  \
                                                  of a hull's centroid */                                      \
  X(state,   Pose,            given_pose)      /* calls; relative to the body's origin */                      \
  X(state,   MaterialRow,     material)        /* calls */                                                     \
  X(state,   float,           density)         /* calls; kg/m^3 */                                             \
  X(state,   Filter,          filter)          /* calls */                                                     \
  X(state,   BoundsRow,       fat_bounds)      /* update_bounds; the box that pairs were last found with */    \
  X(state,   TreeKind,        tree)            /* calls, find_islands */                                       \
  X(state,   std::uint64_t,   user_data)       /* calls */                                                     \
  X(state,   ContactEvents,   events)          /* calls; asked for */                                          \
  X(derived, std::uint8_t,    is_changed)      /* calls, find_islands; 1: stands in Shapes::changed */         \
  X(derived, std::uint32_t,   first_resting)   /* find_pairs; its end of a pair at rest, see RestingLinks. Pairs \
                                                  outlive their shapes until the next list, so by slot */      \
  X(state,   PoseRow,         pose)            /* update_bounds; in the world; the padding tells how far the  \
                                                  shape travels in a step, by the velocity it had then */

// Slots of hulls, each shared by all shapes of the same hull and scale.
#define SCREE_HULL_COLUMNS(X)                                                                                   \
  X(state,   std::uint64_t,   content)         /* calls; hash of hull and scale, 0: the slot is free */        \
  X(state,   std::int32_t,    shapes)          /* calls; how many share it */                                  \
  X(derived, const HullData*, data)            /* calls; null: the slot is free */

// Candidate pairs; each stands in one of two lists.
#define SCREE_PAIR_COLUMNS(X)                                                                                   \
  X(state,   ShapePair,        pair)           /* find_pairs */                                                \
  X(state,   std::int32_t,     contact)        /* collide; row of `contacts.now`, -1: does not touch */        \
  X(state,   ContactAxis,      axis)           /* collide; of hulls against hulls and boxes; no rows while     \
                                                  there is no hull */

// Contacts: the pairs that touch, in no order. A contact keeps its row while it touches, so that nothing moves
// when the list of pairs changes. Free rows hold what kernels left there, and nobody reads it.
#define SCREE_CONTACT_COLUMNS(X)                                                                                \
  X(derived, ShapePair,        pair)           /* collide; as the row of `pairs` that has the contact */       \
  X(state,   std::uint8_t,     points)         /* collide; how many, 0: the row is free */                     \
  X(state,   Manifold,         manifold)       /* collide, store_impulses */                                   \
  X(state,   ManifoldFeatures, features)       /* collide */                                                   \
  X(state,   ContactAnchor,    anchor)         /* collide; where the manifold was made; without spheres */     \
  X(state,   ContactSurface,   surface)        /* collide, store_impulses; where kManifoldRich */              \
  X(state,   std::uint8_t,     color)          /* color_constraints; kNoColor before that */

// Rows of joints, indexed by JointId::index.
#define SCREE_JOINT_COLUMNS(X)                                                                                  \
  X(state,   std::uint32_t,    generation)     /* calls */                                                     \
  X(state,   JointType,        type)           /* calls */                                                     \
  X(state,   std::uint8_t,     flags)          /* calls, break_joints; JointFlag */                            \
  X(state,   JointBodies,      bodies)         /* calls */                                                     \
  X(state,   JointBodies,      next)           /* calls; next joint of body a and of body b, -1: last. The   \
                                                  world has no list */                                         \
  X(state,   Pose,             frame_a)        /* calls; in the frame of body a */                             \
  X(state,   Pose,             frame_b)        /* calls */                                                     \
  X(state,   JointParameters,  parameters)     /* calls */                                                     \
  X(state,   JointImpulses,    impulses)       /* calls, store_impulses */                                     \
  X(state,   JointStrength,    strength)       /* calls */                                                     \
  X(state,   std::uint8_t,     color)          /* color_constraints; kNoColor before that */                   \
  X(state,   std::uint64_t,    user_data)      /* calls */                                                     \
  X(derived, JointBodies,      previous)       /* calls; before it in the lists of `next`, -1: first */        \
  X(derived, JointFrames,      frames)         /* calls, place_matter */                                       \
  X(derived, std::uint8_t,     is_changed)     /* calls, refresh_lists; 1: stands in Joints::changed */        \
  X(scratch, JointReactionRow, reaction)       /* calls, store_impulses; zero in a restored world */
// clang-format on

#define SCREE_DECLARE_COLUMN(kind, Type, name) Column<Type> name;
#define SCREE_VISIT_COLUMN(kind, Type, name) visit(ColumnKind::kind, #name, name);
#define SCREE_RESIZE_COLUMN(kind, Type, name) name.resize(count);

// Declares the columns of a list and the functions that go over all of them.
#define SCREE_STORE(LIST)                 \
  LIST(SCREE_DECLARE_COLUMN)              \
  template <class Visitor>                \
  void for_each_column(Visitor&& visit) { \
    LIST(SCREE_VISIT_COLUMN)              \
  }                                       \
  void resize(std::size_t count) { LIST(SCREE_RESIZE_COLUMN) }

struct Bodies {
  SCREE_STORE(SCREE_BODY_COLUMNS)
  PageMarks marks;                      // derived; whoever writes state; not in each step of what moves
  ListMark free_mark;                   // derived; whoever takes from free_slots
  Column<std::int32_t> free_slots;      // state; calls; taken from the back
  Column<std::int32_t> awake;           // derived; refresh_lists; awake dynamic bodies, ascending
  Column<std::int32_t> kinematic;       // derived; refresh_lists; kinematic bodies, ascending
  Column<std::int32_t> to_place;        // derived; calls, place_matter; who is unplaced, each once
  Column<std::int32_t> to_wake;         // scratch; wake_neighbors
  mutable Column<std::int32_t> waking;  // scratch; is_awake; whom wake_neighbors would wake now, ascending
  mutable MadeOnce waking_made;         // forgotten by calls that change the world and by the step
  std::unordered_map<std::int32_t, MassMoments> moments;  // derived; calls; of some bodies of many shapes
  Column<std::int32_t> changed;  // derived; calls, find_islands; who may take part otherwise than by these
  std::size_t alive = 0;         // state; calls
  std::int32_t asleep = 0;       // derived; calls, find_islands; sleeping bodies
  bool lists_dirty = true;       // derived; calls, find_islands: somebody may take part otherwise
  bool all_changed = true;       // derived; restore: `changed` does not tell who
};

inline bool is_quarantined(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & kBodyQuarantined) != 0;
}

// What the caller made it, whatever it takes part as.
inline BodyType given_type(const Bodies& bodies, std::int32_t body) {
  const auto row = static_cast<std::size_t>(body);
  if ((bodies.flags[row] & kBodyQuarantined) == 0) return bodies.type[row];
  return (bodies.flags[row] & kBodyQuarantinedDynamic) != 0 ? BodyType::dynamic : BodyType::kinematic;
}

struct Shapes {
  SCREE_STORE(SCREE_SHAPE_COLUMNS)
  PageMarks marks;                  // derived; as those of bodies
  ListMark free_mark;               // derived; likewise
  Column<std::int32_t> free_slots;  // state; calls
  Column<std::int32_t> moving;      // derived; refresh_lists; shapes of awake and kinematic bodies, ascending
  Column<std::int32_t> dirty;       // state; calls; slots with kShapeDirty, in order of the calls, each once
  Column<std::int32_t> wakers;      // derived; calls; slots with kShapeWakes
  Column<std::int32_t> changed;     // derived; calls, find_islands; shapes that may have come into another
                                    // tree, or must be asked for filters there, and are not dirty
  std::size_t alive = 0;            // state; calls
  bool trees_changed = true;        // derived; restore: look at all shapes for who changed between trees
  bool wake_requested = false;      // state; calls: some shape has kShapeWakes; cleared by wake_neighbors
  std::int32_t asking = 0;          // derived; calls: living shapes with events
};

// A hull as shapes have it. What it is built of and who else shares that does not matter to the world.
struct SharedHull {
  ConvexHull geometry;                     // as given
  std::shared_ptr<const HullSolid> solid;  // with the scale in it
};

struct Hulls {
  SCREE_STORE(SCREE_HULL_COLUMNS)
  Column<std::int32_t> free_slots;                               // state; calls; taken from the back
  std::vector<SharedHull> shared;                                // by slot; `content` stands for them
  std::unordered_multimap<std::uint64_t, std::int32_t> slot_of;  // by content
};

inline constexpr std::uint8_t kNoColor = 0xff;

struct PairRows {
  SCREE_STORE(SCREE_PAIR_COLUMNS)
};

struct ContactRows {
  SCREE_STORE(SCREE_CONTACT_COLUMNS)
};

struct Contacts {
  PairRows pairs;    // in ascending order
  PairRows resting;  // find_pairs: pairs of two frozen shapes, in no order. Nobody looks at one until a shape
                     // of it changes its tree or is changed by a call: see resting_pairs.h
  PageMarks resting_marks;             // derived; find_pairs, list_events; of `resting` and Events::resting
  Column<RestingLinks> resting_links;  // derived; find_pairs: by row of `resting`, the lists of its shapes
  mutable Column<std::int32_t> resting_order;  // scratch; contact_forces: rows of `resting` by pair
  mutable MadeOnce resting_order_made;         // forgotten by find_pairs
  std::int64_t resting_contacts = 0;           // derived; find_pairs: of `resting`, how many touch
  mutable SharedCount resting_looks;           // derived; how often somebody has looked at a row of `resting`
  Column<std::int32_t> roused;   // scratch; find_islands; rows of `resting` whose contacts take part by now
  std::size_t resting_kept = 0;  // scratch; find_pairs: rows of `resting` that it has not added in this step
  PairRows pairs_before;         // scratch; find_pairs: the last list, where it has changed
  ContactRows now;
  PageMarks marks;                  // derived; find_pairs, collide, refresh_lists; of `now`
  ListMark free_mark;               // derived; collide; of free_rows
  Column<std::int32_t> free_rows;   // state; find_pairs, collide; of `now`, taken from the back
  bool list_kept = false;           // scratch; find_pairs: the list of pairs is the last one
  Column<std::int32_t> last_place;  // scratch; find_pairs; per pair: its place in the last list, or -1.
                                    // Meaningless while list_kept
  Column<ContactForceRow> forces;   // state; collide, store_impulses; by row of `now`; none unless asked for
  mutable Column<std::int32_t> by_shape;      // scratch; contact_forces_of; contacts by shape ...
  mutable Column<std::int32_t> by_shape_end;  // scratch; likewise; ... and where those of each end
  mutable MadeOnce by_shape_made;             // forgotten by the step
  Column<std::int32_t> touching;  // derived; collide, find_islands; contacts that somebody awake takes part
                                  // in, in the order of their pairs
  bool manifolds_stale = false;  // state; calls: mass centers, materials or local poses have changed, so that
                                 // no manifold can be recycled; cleared by collide
  bool pairs_stale = false;      // state; calls: pairs may name dead or replaced shapes, or filters and types
                                 // have changed, so that the list can not be kept; cleared by find_pairs
};

struct Joints {
  SCREE_STORE(SCREE_JOINT_COLUMNS)
  PageMarks marks;                  // derived; as those of bodies
  ListMark free_mark;               // derived; likewise
  Column<std::int32_t> free_slots;  // state; calls; taken from the back
  Column<std::int32_t> active;      // derived; refresh_joints; enabled joints of an awake body, ascending
  Column<std::int32_t>
      changed;              // derived; calls, refresh_lists; who may be active otherwise than by `active`
  std::size_t alive = 0;    // derived; calls
  bool all_changed = true;  // derived; restore, refresh_lists: `changed` does not tell who
};

// A handle as columns hold it: without the world, so that their bytes depend on the scene alone.
struct SlotName {
  std::uint32_t index, generation;

  friend bool operator==(const SlotName&, const SlotName&) = default;
};

struct TouchingPair {
  SlotName shape_a, shape_b, body_a, body_b;

  friend bool operator==(const TouchingPair&, const TouchingPair&) = default;
};

// A pair whose contact somebody asked about when it last touched.
struct TouchRow {
  TouchingPair pair;     // names outlive their shapes
  std::uint32_t events;  // ContactEvents
};

// Of one chunk of pairs: how many there are of each, then where they go.
struct EventCounts {
  std::int32_t touching, resting, begins, persists, ends;
};

// Events of the last step, for the caller; all but `touching` and `resting` are of no consequence to the
// next.
struct Events {
  Column<TouchRow> touching;  // state; list_events; ascending by the indices of the shapes; without the ...
  Column<TouchRow> resting;  // state; list_events; ... pairs at rest, by row of Contacts::resting; zero where
                             // such a pair does not touch or nobody asks. No rows while nobody asks at all
  std::int64_t resting_touches = 0;  // derived; list_events: how many of `resting` touch
  Column<std::int32_t> asked_of;     // derived; calls: shapes of which others events are asked than before
  bool asked_of_all = true;          // derived; calls, restore: likewise of all pairs at rest
  Column<TouchRow> before;           // scratch; list_events; the step before's
  Column<ContactEvent> begins;       // scratch; list_events
  Column<ContactEvent> persists;     // scratch; list_events
  Column<ContactEnd> ends;           // scratch; list_events
  Column<BodyId> restored;           // scratch; quarantine_bodies
  Column<BodyId> quarantined;        // scratch; quarantine_bodies
  Column<SlotName> woken;       // state; calls, find_islands; who has woken since the last step's lists, in
                                // the order of waking
  Column<BodyId> sleep_begins;  // scratch; find_islands
  Column<SlotName> lost;        // state; calls; joints that went with their bodies since the last step
  Column<JointId> broken;       // scratch; break_joints
  Column<JointId> destroyed;    // scratch; find_islands; `lost` of the last step
  Column<BodyId> sleep_ends;    // scratch; find_islands
  Column<TouchRow> moved;       // scratch; list_events, find_pairs; of pairs that no longer rest
  Column<std::int32_t> judged;  // scratch; list_events; rows of pairs at rest of which there may be news
  Column<ShapePair> judged_pairs;  // scratch; list_events
  Column<ShapePair> pairs;         // scratch; list_events; what moves and these, where there are any
  Column<std::int32_t> contacts;   // scratch; list_events; of these pairs
  Column<std::int32_t> rows;       // scratch; list_events; of these pairs: `judged`, or -1
  Column<float> impulse;           // scratch; store_impulses; N s by contact, of the whole step, if asked
  Column<float> approach;          // scratch; note_approach; m/s by contact, if asked
  Column<std::uint8_t> verdicts;   // scratch; list_events; by pair
  Column<EventCounts> counts;      // scratch; list_events; by chunk of pairs
};

// Empties what the caller is told of the last step.
inline void clear_told(Events& events) {
  events.begins.clear();
  events.persists.clear();
  events.ends.clear();
  events.restored.clear();
  events.quarantined.clear();
  events.sleep_begins.clear();
  events.sleep_ends.clear();
  events.broken.clear();
  events.destroyed.clear();
}

// Data that only one stage looks into; defined beside that stage, which makes it at its first run.
struct Part {
  virtual ~Part() = default;
  using Visit = std::function<void(ColumnKind kind, const char* name, const void* rows, std::size_t bytes,
                                   std::size_t capacity_bytes)>;
  // Reports every column, as the generated for_each_column of the public stores do.
  virtual void report(const Visit& visit) const = 0;
  // The world has been replaced: what is remembered of it between steps must be made anew by the next one.
  virtual void forget() noexcept {}
};

struct WorldData {
  WorldSettings settings;        // state; calls
  std::uint64_t step_count = 0;  // state; step
  float last_dt = 0.0f;          // state; step; s, how far bounds and contacts look ahead
  float last_substep = 0.0f;     // state; step; s, what the stored impulses have acted for
  Bodies bodies;
  Shapes shapes;
  Hulls hulls;
  Contacts contacts;
  Joints joints;
  Events events;
  LastSave last_save;       // save, restore; what `marks` and the like are about
  mutable OwnMutex saving;  // held by whoever saves: it places matter and writes marks
  StepStats stats;          // derived; every phase
  // No part of the state; World(), restore, share_handles: which handles are the world's own.
  std::uint32_t handle_tag = 0;
  bool listed = false;  // scratch; step of many worlds, while it looks for one that is named twice

  std::unique_ptr<Part> broad_phase;   // parallel/find_pairs
  std::unique_ptr<Part> narrow_phase;  // parallel/collide
  std::unique_ptr<Part> constraints;   // parallel/color_constraints, pack_blocks, solve
  std::unique_ptr<Part> islands;       // parallel/find_islands

  SinkLink recording;  // parallel/recorder
};

// The public form of a name.
template <class Handle>
Handle handle_of(const WorldData& data, SlotName name) {
  return {name.index, name.generation, data.handle_tag};
}
inline BodyId body_handle(const WorldData& data, std::int32_t body) {
  return {static_cast<std::uint32_t>(body), data.bodies.generation[body], data.handle_tag};
}
inline ShapeId shape_handle(const WorldData& data, std::int32_t shape) {
  return {static_cast<std::uint32_t>(shape), data.shapes.generation[shape], data.handle_tag};
}
inline JointId joint_handle(const WorldData& data, std::int32_t joint) {
  return {static_cast<std::uint32_t>(joint), data.joints.generation[joint], data.handle_tag};
}
// Whether the world takes the handle for one of its own, dead or alive.
template <class Handle>
bool is_own(const WorldData& data, const Handle& handle) {
  return handle.world == data.handle_tag || handle.world == 0;
}

// What is inside a world. Throws Error, which names the call, where the world has been moved from.
WorldData& internals(World& world, const char* call = "internals");
const WorldData& internals(const World& world, const char* call = "internals");

}  // namespace scree
