// WorldData: everything a world is, on one page. Who writes each column stands beside it.
//
// The lists below are the state table: each member of a store is declared once, with its kind and whatever
// else is known of it, see table.h. The structs, saving and restoring, the hash, the memory report, the
// comparison of worlds and the checks of what comes from outside are generated from it.
//   state    changes future results, so a snapshot holds it
//   derived  recomputable exactly from state
//   scratch  lives within one step
#pragma once

#include <core/plain/hull.h>
#include <core/plain/joint.h>
#include <core/plain/manifold.h>
#include <core/plain/mesh.h>
#include <core/plain/rows.h>
#include <core/state/recording_format/call_sink.h>
#include <core/state/snapshot/change_marks.h>
#include <core/world/column.h>
#include <core/world/limits.h>
#include <core/world/made_once.h>
#include <core/world/table.h>
#include <core/world/world_rows.h>
#include <scree/world.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

namespace scree {

inline constexpr unsigned kKnownBodyFlags =
    kBodyAlive | kBodyAsleep | kBodyCanSleep | kBodyMassGiven | kBodyPropertiesGiven | kBodyQuarantined;
inline constexpr unsigned kKnownShapeFlags =
    kShapeAlive | kShapeDirty | kShapeNew | kShapeWakes | kShapeSensor;
inline constexpr unsigned kKnownJointFlags =
    kJointAlive | kJointEnabled | kJointCollides | kJointBreaks | kJointRich | kJointReports;
// So that tells_life has one meaning.
static_assert(kBodyAlive == 1 && kShapeAlive == 1 && kJointAlive == 1);

// clang-format off
// Rows are of BodyId::index. "calls" are World's functions, "islands" wake_touched_islands, put_islands_to_sleep.
// World::hash covers the words kHashedWords of living bodies' rows that are kHashed, in the order of this list.
#define SCREE_BODY_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                     \
  ROWS (state,   std::uint32_t,   generation,      /* calls; raised when the body dies */                       \
        kOnAllRanks, not_zero("a living body has none"))                                                        \
  ROWS (state,   BodyType,        type,            /* calls, quarantine_bodies; as it takes part */             \
        kOnAllRanks, at_most(BodyType::dynamic, "is no type of bodies"))                                        \
  ROWS (state,   std::uint8_t,    flags,           /* calls, islands, quarantine_bodies; BodyFlag */            \
        kOnAllRanks, kTellsLife, known_flags(kKnownBodyFlags, 0))                                               \
  ROWS (state,   PoseRow,         pose,            /* calls, solve; of the center of mass, in the body's axes */ \
        kHashed, kApart, kPlacement)                                                                            \
  ROWS (state,   VelocityRow,     velocity,        /* calls, solve */                                           \
        kHashed, kApart, kFinite)                                                                               \
  ROWS (state,   ForceRow,        force,           /* calls; cleared by finish_step */                          \
        kApart, kFinite)                                                                                        \
  ROWS (state,   MotionRow,       motion)          /* calls; its locks act, so they are none if not given dynamic */ \
  ROWS (state,   AxisLocks,       locks,           /* calls; as given */                                        \
        mask(kMotionLocksMask, "names no axes"))                                                                \
  ROWS (state,   float,           sleep_time,      /* calls, finish_step; s for which it has stayed, see finish */ \
        kApart, kNotNegative)                                                                                   \
  ROWS (state,   DriftRow,        drift,           /* calls, finish_step, put_islands_to_sleep; since sleep_time was 0 */ \
        kApart, kFinite)                                                                                        \
  ROWS (state,   InertiaRow,      local_mass)      /* calls; inverse inertia in body axes; zero if not given    \
                                                      dynamic */                                                \
  ROWS (state,   LocalInertiaRow, local_inertia,   /* calls; in body axes */                                    \
        kFinite)                                                                                                \
  ROWS (state,   Vec3,            center,          /* calls; center of mass in the body's frame */              \
        kFinite)                                                                                                \
  ROWS (state,   float,           mass,            /* calls; kg */                                              \
        kNotNegative)                                                                                           \
  ROWS (state,   float,           given_mass,      /* calls; kg, with kBodyMassGiven */                         \
        within_limits(0.0f, kMaxMass))                                                                          \
  ROWS (state,   std::int32_t,    first_shape,     /* calls; -1: none */                                        \
        kOnAllRanks, if_dead(-1, "a dead body has none"))                                                       \
  ROWS (state,   std::int32_t,    first_joint,     /* calls; -1: none */                                        \
        kOnAllRanks, if_dead(-1, "a dead body has none"))                                                       \
  ROWS (state,   std::uint64_t,   user_data)       /* calls */                                                  \
  ROWS (derived, Pose,            transform)       /* calls, finish_step; of the origin */                      \
  ROWS (derived, CoreRow,         core, kKept)     /* calls, place_matter */                                    \
  ROWS (derived, std::uint8_t,    unplaced, kOnAllRanks) /* calls, place_matter; UnplacedFlag */                \
  ROWS (derived, std::uint8_t,    is_changed, kOnAllRanks) /* calls, islands; 1: stands in `changed` */         \
  ROWS (scratch, InertiaRow,      inertia)         /* solve; inverse, in world axes, zero on locked axes */     \
  ROWS (scratch, std::uint8_t,    step_notes)      /* solve; StepNote */                                        \
  ROWS (scratch, std::uint8_t,    is_absent,       /* parallel/distributed; 1: another rank moves the body, it is \
                                                      neither awake nor asleep here, and its rows say nothing   \
                                                      but those on all ranks */                                 \
        kOnAllRanks)                                                                                            \
  ROWS (scratch, DeltaRow,        delta)           /* solve; motion since the step began */                     \
  ROWS (scratch, VelocityRow,     free_velocity)   /* solve; after forces, before this step's impulses */       \
  TABLE(derived, PageMarks,       marks, "bodies") /* all that write state; not in each step of what moves */   \
  VALUE(derived, ListMark,        free_mark, {})   /* calls; of free_slots */                                   \
  LIST (state,   std::int32_t,    free_slots,      /* calls; taken from the back */                             \
        saved_in(SheetId::free_bodies), each_once(SheetId::bodies))                                             \
  LIST (derived, std::int32_t,    awake)           /* refresh_lists; awake dynamic bodies, ascending */         \
  LIST (derived, std::int32_t,    kinematic)       /* refresh_lists; kinematic bodies, ascending */             \
  LIST (derived, std::int32_t,    to_place,        /* calls, place_matter; unplaced bodies, each once */        \
        each_once(SheetId::bodies))                                                                             \
  LIST (scratch, std::int32_t,    to_wake)         /* wake_neighbors */                                         \
  VALUE(derived, BodyMoments,     moments, {})     /* calls; of some bodies of many shapes */                   \
  LIST (derived, std::int32_t,    changed,         /* calls, islands; bodies that may belong to other lists     \
                                                      than they are in */                                       \
        each_once(SheetId::bodies))                                                                             \
  VALUE(derived, std::size_t,     alive, 0)        /* calls */                                                  \
  VALUE(derived, std::int32_t,    asleep, 0)       /* calls, islands; sleeping bodies */                        \
  VALUE(derived, bool,            lists_dirty, true) /* calls, islands: some body may belong to another list */ \
  VALUE(derived, bool,            all_changed, true) /* restore: `changed` does not list all */

// Rows of shapes are indexed by ShapeId::index.
#define SCREE_SHAPE_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                    \
  ROWS (state,   std::uint32_t,   generation,      /* calls */                                                  \
        kOnAllRanks, not_zero("a living shape has none"))                                                       \
  ROWS (state,   ShapeType,       type,            /* calls */                                                  \
        kOnAllRanks, at_most(ShapeType::cone, "is no type of shapes"))                                          \
  ROWS (state,   std::uint8_t,    flags,           /* calls, update_bounds; ShapeFlag */                        \
        kOnAllRanks, kTellsLife, known_flags(kKnownShapeFlags, kShapeDirty | kShapeWakes))                      \
  ROWS (state,   std::int32_t,    body,            /* calls */                                                  \
        kOnAllRanks, row_of(SheetId::bodies, kFirstBody, kFirstBody, "does not exist"))                         \
  ROWS (state,   std::int32_t,    next, kOnAllRanks) /* calls; next shape of the body, -1: last */              \
  ROWS (state,   ExtentRow,       extent)          /* calls */                                                  \
  ROWS (state,   std::int32_t,    hull,            /* calls; slot in WorldData::hulls, -1: no hull */           \
        kOnAllRanks, if_dead(-1, "a dead shape has no hull"))                                                   \
  ROWS (state,   std::int32_t,    mesh,            /* calls; slot in WorldData::meshes, -1: no mesh */          \
        kOnAllRanks, if_dead(-1, "a dead shape has no mesh"))                                                   \
  ROWS (derived, std::int32_t,    previous, kOnAllRanks) /* calls; before it in the list of `next`, -1: first */ \
  ROWS (derived, PoseRow,         local_pose)      /* calls, place_matter; from the body's center of mass; of a \
                                                      hull's centroid, of the center of a mesh's box */         \
  ROWS (state,   Pose,            given_pose)      /* calls; relative to the body's origin */                   \
  ROWS (state,   MaterialRow,     material)        /* calls */                                                  \
  ROWS (state,   float,           density,         /* calls; kg/m^3 */                                          \
        within_limits(kMinDensity, kMaxDensity))                                                                \
  ROWS (state,   Filter,          filter)          /* calls */                                                  \
  ROWS (state,   BoundsRow,       fat_bounds,      /* update_bounds; the box that pairs were last found with */ \
        kApart, kFinite)                                                                                        \
  ROWS (state,   TreeKind,        tree,            /* calls, islands */                                         \
        kOnAllRanks, if_dead(TreeKind::none, "a dead shape has no tree"))                                       \
  ROWS (state,   std::uint64_t,   user_data)       /* calls */                                                  \
  ROWS (state,   ContactEvents,   events,          /* calls; asked for */                                       \
        kOnAllRanks, at_most(ContactEvents::all, "are unknown"))                                                \
  ROWS (state,   ContactHooks,    hooks,           /* calls; asked for */                                       \
        kOnAllRanks, at_most(ContactHooks::all, "are unknown"))                                                 \
  ROWS (derived, std::uint8_t,    is_changed, kOnAllRanks) /* calls, islands; 1: stands in `changed` */         \
  ROWS (derived, std::uint32_t,   first_resting, kOnAllRanks) /* find_pairs; its end of a pair at rest, see RestingLinks. \
                                                      Pairs outlive their shapes until the next list, so by     \
                                                      slot */                                                   \
  ROWS (state,   PoseRow,         pose,            /* update_bounds; in the world; the padding tells how far    \
                                                      the shape travels in a step, by the velocity it had then */ \
        kApart)                                                                                                 \
  ROWS (scratch, StepMotion,      motion, kTravels) /* update_bounds, forget_displaced, islands; since the last \
                                                      narrow phase. Outside of `moving`, and in a restored       \
                                                      world, it is motion_at_rest() */                          \
  TABLE(derived, PageMarks,       marks, "shapes") /* as those of bodies */                                     \
  VALUE(derived, ListMark,        free_mark, {})   /* calls; of free_slots */                                   \
  LIST (state,   std::int32_t,    free_slots,      /* calls */                                                  \
        saved_in(SheetId::free_shapes), each_once(SheetId::shapes))                                             \
  LIST (derived, std::int32_t,    moving)          /* refresh_lists; shapes of awake and kinematic bodies,      \
                                                      ascending */                                              \
  LIST (state,   std::int32_t,    dirty,           /* calls; slots with kShapeDirty, in order of the calls */   \
        saved_in(SheetId::dirty_shapes), each_once(SheetId::shapes))                                            \
  LIST (derived, std::int32_t,    wakers,          /* calls; slots with kShapeWakes */                          \
        each_once(SheetId::shapes))                                                                             \
  OTHER(scratch, mutable Column<std::int32_t>, waking) /* is_awake; bodies that wake_neighbors would wake now */\
  OTHER(scratch, mutable MadeOnce, waking_made)    /* is_awake; forgotten by request_wake, mark_dirty and the step */\
  LIST (derived, std::int32_t,    changed,         /* calls, islands; shapes that may have come into            \
                                                      another tree, or must be asked for filters there, and are \
                                                      not dirty */                                              \
        each_once(SheetId::shapes))                                                                             \
  VALUE(derived, std::size_t,     alive, 0)        /* calls */                                                  \
  ROWS (scratch, std::uint8_t,    is_noted, kOnAllRanks) /* calls, queries; 1: stands in `to_query` */          \
  LIST (scratch, std::int32_t,    to_query,        /* calls, queries; shapes that calls have changed since      \
                                                      queries last looked at them, while `is_queried` */        \
        each_once(SheetId::shapes))                                                                             \
  VALUE(scratch, bool,            is_queried, false) /* queries; from the first one on */                       \
  OTHER(scratch, mutable MadeOnce, queries_made)   /* queries; forgotten by mark_dirty and the step */          \
  VALUE(derived, bool,            trees_changed, true) /* restore: look at all shapes for those that changed    \
                                                      trees */                                                  \
  VALUE(state,   bool,            wake_requested, false) /* calls: some shape has kShapeWakes; cleared by       \
                                                      wake_neighbors */                                         \
  VALUE(derived, std::int32_t,    asking, 0)       /* calls: living shapes with events */                       \
  VALUE(derived, std::int32_t,    hooked, 0)       /* calls: living shapes with hooks */                        \
  VALUE(derived, std::int32_t,    sensors, 0)      /* calls: living sensors */

// Slots of hulls, each shared by all shapes of the same hull and scale.
#define SCREE_HULL_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                     \
  ROWS (state,   std::uint64_t,   content)         /* calls; hash of hull and scale, 0: the slot is free */     \
  ROWS (state,   std::int32_t,    shapes)          /* calls; how many share it */                               \
  ROWS (derived, const HullData*, data)            /* calls; null: the slot is free */                          \
  LIST (state,   std::int32_t,    free_slots,      /* calls; taken from the back */                             \
        saved_in(SheetId::free_hulls), each_once(SheetId::hulls))                                               \
  OTHER(state,   SharedHulls,     shared)          /* calls; by slot; snapshots have them in SnapshotData::hulls */ \
  OTHER(derived, ContentSlots,    slot_of)         /* calls; by content; made by restore */

// Slots of meshes, each shared by all shapes of the same mesh.
#define SCREE_MESH_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                     \
  ROWS (state,   std::uint64_t,   content)         /* calls; hash of the mesh, 0: the slot is free */           \
  ROWS (state,   std::int32_t,    shapes)          /* calls; how many share it */                               \
  ROWS (derived, const MeshData*, data)            /* calls; null: the slot is free */                          \
  LIST (state,   std::int32_t,    free_slots,      /* calls; taken from the back */                             \
        saved_in(SheetId::free_meshes), each_once(SheetId::meshes))                                             \
  OTHER(state,   SharedMeshes,    shared)          /* calls; by slot; snapshots have them in SnapshotData::meshes */ \
  OTHER(derived, ContentSlots,    slot_of)         /* calls; by content; made by restore */

// Candidate pairs; each stands in one of two lists.
#define SCREE_PAIR_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                     \
  ROWS (state,   ShapePair,       pair,            /* find_pairs */                                             \
        kCounts, kVaried)                                                                                       \
  ROWS (state,   std::int32_t,    contact)         /* collide; row of `contacts.now`, -1: does not touch */     \
  ROWS (state,   ContactAxis,     axis,            /* collide; of hulls against hulls and boxes; no rows while  \
                                                      there is no hull */                                       \
        kApart, kOrNone)

// Contacts: the pairs that touch, in no order. A contact keeps its row while it touches, so that nothing moves
// when the list of pairs changes. Free rows hold what kernels left there, which is never read.
#define SCREE_CONTACT_ROW_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                              \
  ROWS (derived, ShapePair,        pair)           /* collide; as the row of `pairs` that has the contact */    \
  ROWS (state,   std::uint8_t,     points,         /* collide; how many, 0: the row is free */                  \
        kTellsPresence, kApart, kVaried)                                                                        \
  ROWS (state,   std::int32_t,     next,           /* collide; 1 + the pair's next contact, 0: last. Only pairs  \
                                                      with a mesh have more than one */                         \
        kApart, kVaried)                                                                                        \
  ROWS (state,   Manifold,         manifold,       /* collide, store_impulses */                                \
        kApart, kVaried)                                                                                        \
  ROWS (state,   ManifoldFeatures, features,       /* collide */                                                \
        kVaried)                                                                                                \
  ROWS (state,   ContactAnchor,    anchor)         /* collide; where the manifold was made; without spheres */  \
  ROWS (state,   ContactSurface,   surface)        /* collide, store_impulses; where kManifoldRich */           \
  ROWS (state,   std::uint8_t,     color,          /* color_constraints; kNoColor before that */                \
        kVaried)

#define SCREE_CONTACTS_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                 \
  TABLE(state,   PairRows,         pairs, "contacts.pairs", SheetId::pairs, SheetId::pair_axes)                 \
                                                   /* find_pairs; in ascending order */                         \
  TABLE(state,   PairRows,         resting, "contacts.resting", SheetId::resting, SheetId::resting_axes)        \
                                                   /* find_pairs: pairs of two frozen shapes, in no order.      \
                                                      A row is looked at when a shape of it changes its tree    \
                                                      or is changed by a call: see resting_pairs.h */           \
  TABLE(derived, PageMarks,        resting_marks, "contacts") /* find_pairs, list_contact_events; of `resting` and \
                                                      Events::resting */                                        \
  LIST (derived, RestingLinks,     resting_links,  /* find_pairs: by row of `resting`, the lists of its shapes */ \
        all_or_none(SheetId::resting))                                                                          \
  OTHER(scratch, mutable Column<std::int32_t>, resting_order) /* contact_forces: rows of `resting` by pair */   \
  OTHER(scratch, mutable MadeOnce, resting_order_made) /* contact_forces; forgotten by find_pairs */            \
  VALUE(derived, std::int64_t,     resting_contacts, 0) /* find_pairs: of `resting`, how many touch */          \
  OTHER(derived, mutable SharedCount, resting_looks) /* all stages; how often rows of `resting` were looked at */\
  LIST (scratch, std::int32_t,     roused)         /* wake_touched_islands; rows of `resting` whose contacts take part \
                                                      by now */                                                 \
  VALUE(scratch, std::size_t,      resting_kept, 0) /* find_pairs: rows of `resting` that it has not added in   \
                                                      this step */                                              \
  TABLE(scratch, PairRows,         pairs_before, "contacts.pairs_before") /* find_pairs: the last list, where   \
                                                      it has changed */                                         \
  TABLE(state,   ContactRows,      now, "contacts.now", SheetId::contacts, SheetId::contacts_moving)            \
  TABLE(derived, PageMarks,        marks, "contacts") /* find_pairs, collide, refresh_lists; of `now` */        \
  VALUE(derived, ListMark,         free_mark, {})  /* collide; of free_rows */                                  \
  LIST (state,   std::int32_t,     free_rows,      /* find_pairs, collide; of `now`, taken from the back */     \
        saved_in(SheetId::free_contacts), each_once(SheetId::contacts))                                         \
  VALUE(scratch, bool,             list_kept, false) /* find_pairs: the list of pairs is the last one */        \
  VALUE(scratch, std::uint64_t,    list_number, 0) /* find_pairs: of `pairs`, another one for each new list ... */ \
  VALUE(scratch, std::uint64_t,    last_number, 0) /* ... and of the list that `last_place` means */            \
  LIST (scratch, std::int32_t,     last_place)     /* find_pairs; per pair: its place in the last list, or -1.  \
                                                      Meaningless while list_kept */                            \
  LIST (state,   ContactForceRow,  forces,         /* collide, store_impulses; by row of `now`; none unless     \
                                                      asked for */                                              \
        saved_in(SheetId::contact_forces), all_or_none(SheetId::contacts))                                      \
  OTHER(scratch, mutable Column<std::int32_t>, by_shape) /* contact_forces_of; contacts by shape ... */         \
  OTHER(scratch, mutable Column<std::int32_t>, by_shape_end) /* contact_forces_of; ... and where those of each end */\
  OTHER(scratch, mutable MadeOnce, by_shape_made)  /* contact_forces_of; forgotten by the step */               \
  LIST (derived, std::int32_t,     active)         /* collide, islands; contacts that an awake body takes       \
                                                      part in, in the order of their pairs */                   \
  VALUE(state,   bool,             manifolds_stale, false) /* calls: mass centers, materials or local poses     \
                                                      have changed, so that no manifold can be recycled;        \
                                                      cleared by collide */                                     \
  VALUE(state,   bool,             pairs_stale, false) /* calls: pairs may name dead or replaced shapes, or     \
                                                      filters and types have changed, so that the list cannot   \
                                                      be kept; cleared by find_pairs */

// Rows of joints are indexed by JointId::index.
#define SCREE_JOINT_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                    \
  ROWS (state,   std::uint32_t,    generation,     /* calls */                                                  \
        not_zero("a living joint has none"))                                                                    \
  ROWS (state,   JointType,        type,           /* calls */                                                  \
        at_most(kJointTypeCount - 1, "is no type of joints"))                                                   \
  ROWS (state,   std::uint8_t,     flags,          /* calls, break_joints; JointFlag */                         \
        kTellsLife, known_flags(kKnownJointFlags, 0))                                                           \
  ROWS (state,   JointBodies,      bodies,         /* calls */                                                  \
        kVaried, row_of(SheetId::bodies, kFirstBody, kFixedRow, "do not exist"))                                \
  ROWS (state,   JointBodies,      next,           /* calls; next joint of body a and of body b, -1: last. The  \
                                                      world has no list */                                      \
        kVaried)                                                                                                \
  ROWS (state,   Pose,             frame_a)        /* calls; in the frame of body a */                          \
  ROWS (state,   Pose,             frame_b)        /* calls */                                                  \
  ROWS (state,   JointParameters,  parameters)     /* calls */                                                  \
  ROWS (state,   JointImpulses,    impulses,       /* calls, store_impulses */                                  \
        kApart, kVaried)                                                                                        \
  ROWS (state,   JointStrength,    strength)       /* calls */                                                  \
  ROWS (state,   JointThresholds,  thresholds)     /* calls */                                                  \
  ROWS (state,   std::uint8_t,     color,          /* color_constraints; kNoColor before that */                \
        kApart)                                                                                                 \
  ROWS (state,   std::uint64_t,    user_data)      /* calls */                                                  \
  ROWS (derived, JointBodies,      previous)       /* calls; before it in the lists of `next`, -1: first */     \
  ROWS (derived, JointFrames,      frames)         /* calls, place_matter */                                    \
  ROWS (derived, std::int32_t,     user)           /* calls; row of UserJoints, of user joints alone */         \
  ROWS (derived, std::uint8_t,     is_changed)     /* calls, refresh_lists; 1: stands in `changed` */           \
  ROWS (scratch, JointReactionRow, reaction)       /* calls, store_impulses; zero in a restored world */        \
  TABLE(derived, PageMarks,        marks, "joints") /* as those of bodies */                                    \
  VALUE(derived, ListMark,         free_mark, {})  /* calls; of free_slots */                                   \
  LIST (state,   std::int32_t,     free_slots,     /* calls; taken from the back */                             \
        saved_in(SheetId::free_joints), each_once(SheetId::joints))                                             \
  LIST (derived, std::int32_t,     active)         /* refresh_joints; enabled joints of an awake body, ascending */ \
  LIST (derived, std::int32_t,     changed,        /* calls, refresh_lists; joints that may have to enter or    \
                                                      leave `active` */                                         \
        each_once(SheetId::joints))                                                                             \
  VALUE(derived, std::size_t,      alive, 0)       /* calls */                                                  \
  VALUE(derived, std::int32_t,     reporting, 0)   /* calls: living joints with kJointReports */                \
  VALUE(derived, bool,             all_changed, true) /* restore, refresh_lists: `changed` does not list all */

// The numbers of user joints, a row for each that lives, without gaps: a new one takes the last row, and the
// last one takes the row of one that goes.
#define SCREE_USER_JOINT_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                               \
  ROWS (state,   std::int32_t,     joint,          /* calls */                                                  \
        kCounts, row_of(SheetId::joints, 0, 0, "does not exist"))                                               \
  ROWS (state,   std::uint32_t,    state,          /* calls, refresh_user_rows, list_body_events; UserState */  \
        at_most(kUserFrozen, "is no state of user joints"))                                                     \
  ROWS (state,   UserJacobians,    jacobians,      /* calls, refresh_user_rows; as the other two */             \
        kVaried)                                                                                                \
  ROWS (state,   UserTargets,      targets)                                                                     \
  ROWS (state,   UserBounds,       bounds)                                                                      \
  OTHER(scratch, UserRowCallback,  callback)       /* calls; no part of the state: stays in restore */

// Events of the last step, for the caller; all but `touching`, `resting`, `woken` and `lost` are of no
// consequence to the next.
#define SCREE_EVENT_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                    \
  LIST (state,   TouchRow,         touching,       /* list_contact_events; ascending by the indices of the shapes; \
                                                      without the ... */                                        \
        saved_in(SheetId::events_touching), kVaried)                                                            \
  LIST (state,   TouchRow,         resting,        /* list_contact_events; ... pairs at rest, by row of         \
                                                      Contacts::resting; zero where such a pair does not touch  \
                                                      or no events are asked for. No rows while none are at all */ \
        saved_in(SheetId::events_resting), all_or_none(SheetId::resting))                                       \
  VALUE(derived, std::int64_t,     resting_touches, 0) /* list_contact_events: how many of `resting` touch */   \
  LIST (derived, std::int32_t,     asked_of)       /* calls: shapes of which others events are asked than before */ \
  VALUE(derived, bool,             asked_of_all, true) /* calls, restore: so are those of all pairs at rest */  \
  LIST (scratch, TouchRow,         before)         /* list_contact_events; the step before's */                 \
  LIST (scratch, ContactEvent,     begins, kEvent)  /* list_contact_events */                                   \
  LIST (scratch, ContactEvent,     persists, kEvent) /* list_contact_events */                                  \
  LIST (scratch, ContactEnd,       ends, kEvent)    /* list_contact_events */                                   \
  LIST (scratch, ContactEvent,     hits, kEvent)    /* list_contact_events */                                   \
  LIST (state,   TouchingPair,     sensed,         /* list_sensor_events; sensors and what they see, ascending by \
                                                      the indices of the sensor, then of the visitor */         \
        saved_in(SheetId::events_sensed), kVaried)                                                              \
  LIST (scratch, SensorEvent,      sensor_begins, kEvent) /* list_sensor_events */                              \
  LIST (scratch, SensorEvent,      sensor_ends, kEvent) /* list_sensor_events */                                \
  LIST (scratch, BodyId,           restored, kEvent) /* quarantine_bodies */                                    \
  LIST (scratch, BodyId,           quarantined, kEvent) /* quarantine_bodies */                                 \
  LIST (state,   SlotName,         woken,          /* calls, islands; bodies woken since the last step's lists, \
                                                      in the order of waking */                                 \
        saved_in(SheetId::events_woken), each_once(SheetId::bodies),                                            \
        handle_of(SheetId::bodies, "names no body"))                                                            \
  LIST (scratch, BodyId,           sleep_begins, kEvent) /* list_body_events */                                 \
  LIST (state,   SlotName,         lost,           /* calls; joints that went with their bodies since the last  \
                                                      step */                                                   \
        saved_in(SheetId::events_lost), handle_of(SheetId::joints, "names no joint"))                           \
  LIST (scratch, JointId,          broken, kEvent)  /* break_joints */                                          \
  LIST (scratch, JointEvent,       strained, kEvent) /* list_joint_events */                                    \
  LIST (scratch, std::int32_t,     strained_places) /* list_joint_events; for list_where */                     \
  LIST (scratch, JointId,          frozen, kEvent)  /* list_body_events */                                      \
  LIST (scratch, JointId,          destroyed, kEvent) /* list_body_events; `lost` of the last step */           \
  LIST (scratch, BodyId,           sleep_ends, kEvent) /* list_body_events */                                   \
  LIST (scratch, TouchRow,         moved)          /* list_contact_events, find_pairs; of pairs that no longer rest */ \
  LIST (scratch, std::int32_t,     judged)         /* list_contact_events; rows of pairs at rest of which there may be \
                                                      news */                                                   \
  LIST (scratch, ShapePair,        judged_pairs)   /* list_contact_events */                                    \
  LIST (scratch, ShapePair,        pairs)          /* list_contact_events; what moves and these, where there are any */ \
  LIST (scratch, std::int32_t,     contacts)       /* list_contact_events; of these pairs */                    \
  LIST (scratch, std::int32_t,     rows)           /* list_contact_events; of these pairs: `judged`, or -1 */   \
  LIST (scratch, float,            impulse)        /* store_impulses; N s by contact, of the whole step, if asked */ \
  LIST (scratch, float,            approach)       /* note_approach; m/s by contact, if asked */                \
  LIST (scratch, std::uint8_t,     verdicts)       /* list_contact_events; by pair */                           \
  LIST (scratch, EventCounts,      counts)         /* list_contact_events; by chunk of pairs */

// Hooks of contacts, see contact_hooks.h.
#define SCREE_HOOK_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                     \
  LIST (state,   HookAnswer,       answers,        /* calls; for the next step, ascending by the indices of the \
                                                      shapes and by contact; cleared by collide */              \
        saved_in(SheetId::hook_answers), kVaried)                                                               \
  LIST (scratch, ShapePair,        refused)        /* collide; pairs that do not collide in this step, ascending */ \
  OTHER(scratch, ContactFilter,    filter)         /* calls; no part of the state: stays in restore */          \
  OTHER(scratch, ContactRule,      rule)           /* calls; as filter */                                       \
  VALUE(scratch, const World*,     world, nullptr) /* step: what hooks may read; null: they are not called */   \
  VALUE(scratch, float,            dt, 0.0f)       /* step; s */                                                \
  OTHER(scratch, std::exception_ptr, thrown)       /* collide: by a hook; thrown again as the step ends */

#define SCREE_WORLD_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                    \
  VALUE(state,   WorldSettings,    settings, {})   /* calls */                                                  \
  VALUE(state,   std::uint64_t,    step_count, 0)  /* step */                                                   \
  VALUE(state,   float,            last_dt, 0.0f,  /* step; s, how far bounds and contacts look ahead */        \
        within_limits(0.0f, 1.0f))                                                                              \
  VALUE(state,   float,            last_substep, 0.0f, /* step; s, what the stored impulses have acted for */   \
        within_limits(0.0f, 1.0f))                                                                              \
  TABLE(state,   Bodies,           bodies, "bodies", SheetId::bodies, SheetId::bodies_moving)                   \
  TABLE(state,   Shapes,           shapes, "shapes", SheetId::shapes, SheetId::shapes_moving)                   \
  TABLE(state,   Hulls,            hulls, "hulls", SheetId::hulls)                                              \
  TABLE(state,   Meshes,           meshes, "meshes", SheetId::meshes)                                           \
  TABLE(state,   Contacts,         contacts, "contacts")                                                        \
  TABLE(state,   Joints,           joints, "joints", SheetId::joints, SheetId::joints_moving)                   \
  TABLE(state,   UserJoints,       user_joints, "user_joints", SheetId::user_joints)                            \
  TABLE(state,   Events,           events, "events")                                                            \
  TABLE(state,   Hooks,            hooks, "hooks")                                                              \
  OTHER(derived, LastSave,         last_save)      /* save, restore; what `marks` and the like are about */     \
  OTHER(scratch, mutable OwnMutex, saving)         /* save; held while it places matter and writes marks */     \
  VALUE(derived, StepStats,        stats, {})      /* every phase */                                            \
  OTHER(scratch, HandleTags,       handle_tags)    /* World(), restore, share_handles; no part of the state */  \
  VALUE(scratch, bool,             listed, false)  /* step of many worlds, while it looks for one that is named \
                                                      twice */                                                  \
  OTHER(derived, PartOwner,        broad_phase)    /* parallel/find_pairs */                                    \
  OTHER(derived, PartOwner,        narrow_phase)   /* parallel/collide */                                       \
  OTHER(derived, PartOwner,        constraints)    /* parallel/color_constraints, pack_blocks, solve */         \
  OTHER(derived, PartOwner,        islands)        /* parallel/islands */                                       \
  OTHER(scratch, PartOwner,        queries)        /* parallel/queries; made by reading calls */                \
  OTHER(scratch, PartOwner,        border)         /* parallel/distributed; null where the world is no part */   \
  OTHER(scratch, SinkLink,         recording)      /* parallel/recorder; last, see there */
// clang-format on

SCREE_STORE(Bodies, SCREE_BODY_MEMBERS)
SCREE_STORE(Shapes, SCREE_SHAPE_MEMBERS)
SCREE_STORE(Hulls, SCREE_HULL_MEMBERS)
SCREE_STORE(Meshes, SCREE_MESH_MEMBERS)
SCREE_STORE(PairRows, SCREE_PAIR_MEMBERS)
SCREE_STORE(ContactRows, SCREE_CONTACT_ROW_MEMBERS)
SCREE_STORE(Contacts, SCREE_CONTACTS_MEMBERS)
SCREE_STORE(Joints, SCREE_JOINT_MEMBERS)
SCREE_STORE(UserJoints, SCREE_USER_JOINT_MEMBERS)
SCREE_STORE(Events, SCREE_EVENT_MEMBERS)
SCREE_STORE(Hooks, SCREE_HOOK_MEMBERS)

// Data that only one stage looks into; defined beside that stage by a list of its own, see SCREE_PART, and
// made at its first run.
struct Part {
  virtual ~Part() = default;
  using Visit = std::function<void(const Member& member, const void* rows, std::size_t row_bytes,
                                   std::size_t bytes, std::size_t capacity_bytes)>;
  // Reports every member, those of stores within it included.
  virtual void report(const char* store, const Visit& visit) const = 0;
  // The world has been replaced: what is remembered of it between steps must be made anew by the next one.
  virtual void forget() noexcept {}
};
using PartOwner = std::unique_ptr<Part>;

template <class Members>
void report_members(const Members& part, const char* store, const Part::Visit& visit) {
  Members::visit_members(part, {store, ColumnKind::derived}, [&visit](const Member& member, const auto& it) {
    using It = std::remove_cvref_t<decltype(it)>;
    if constexpr (kIsColumn<It>) {
      visit(member, it.data(), sizeof(*it.data()), it.span().size_bytes(), it.capacity_bytes());
    } else {
      visit(member, &it, sizeof it, sizeof it, sizeof it);
    }
  });
}

SCREE_STORE(WorldData, SCREE_WORLD_MEMBERS)

// The next contact of the same pair; -1: there is none.
inline std::int32_t next_contact(const ContactRows& rows, std::int32_t contact) {
  return rows.next[contact] - 1;
}

// Calls visit(contact) for the contacts of a pair, from PairRows::contact on.
template <class Visit>
void for_each_contact(const Contacts& contacts, std::int32_t first, Visit&& visit) {
  for (std::int32_t contact = first; contact >= 0; contact = next_contact(contacts.now, contact))
    visit(contact);
}

inline bool is_sensor(const Shapes& shapes, std::int32_t shape) {
  return (shapes.flags[shape] & kShapeSensor) != 0;
}

// kg/m^3, of what the shape adds to its body.
inline float solid_density(const Shapes& shapes, std::int32_t shape) {
  return is_sensor(shapes, shape) ? 0.0f : shapes.density[shape];
}

// Whether another rank moves the body, and its rows are not here. Calls change what is on all ranks then; the
// rest comes with the body.
inline bool is_absent(const Bodies& bodies, std::int32_t body) { return bodies.is_absent[body] != 0; }

inline bool is_quarantined(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & kBodyQuarantined) != 0;
}

// What the caller made it, whatever it takes part as.
inline BodyType given_type(const Bodies& bodies, std::int32_t body) {
  if ((bodies.flags[body] & kBodyQuarantined) == 0) return bodies.type[body];
  return (bodies.flags[body] & kBodyQuarantinedDynamic) != 0 ? BodyType::dynamic : BodyType::kinematic;
}

// Empties the lists of the last step's events.
inline void clear_events(Events& events) {
#define SCREE_CLEAR_EVENTS(kind, Row, name, ...) \
  if (attributes(__VA_ARGS__).event) events.name.clear();
  SCREE_EVENT_MEMBERS(SCREE_NOTHING, SCREE_CLEAR_EVENTS, SCREE_NOTHING, SCREE_NOTHING, SCREE_NOTHING)
#undef SCREE_CLEAR_EVENTS
}

// The public form of a name.
template <class Handle>
Handle handle_of(const WorldData& data, SlotName name) {
  return {name.index, name.generation, data.handle_tags.given};
}
inline BodyId body_handle(const WorldData& data, std::int32_t body) {
  return {static_cast<std::uint32_t>(body), data.bodies.generation[body], data.handle_tags.given};
}
inline ShapeId shape_handle(const WorldData& data, std::int32_t shape) {
  return {static_cast<std::uint32_t>(shape), data.shapes.generation[shape], data.handle_tags.given};
}
inline JointId joint_handle(const WorldData& data, std::int32_t joint) {
  return {static_cast<std::uint32_t>(joint), data.joints.generation[joint], data.handle_tags.given};
}
// Whether the world takes the handle for one of its own, dead or alive.
template <class Handle>
bool is_own(const WorldData& data, const Handle& handle) {
  const HandleTags& tags = data.handle_tags;
  return handle.world == tags.given || handle.world == tags.first || handle.world == 0;
}

// What is inside a world. Throws Error, which names the call, where the world has been moved from.
WorldData& internals(World& world, const char* call = "internals");
const WorldData& internals(const World& world, const char* call = "internals");
// Throws Error where the world is a part of a distributed one, whose rows of other parts say nothing.
void check_whole(const WorldData& data, const char* call);

}  // namespace scree
