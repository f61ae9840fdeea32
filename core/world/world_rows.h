// Flags of the stores' rows and their small rows; world_data.h says who writes which.
#pragma once

#include <core/world/mass_moments.h>
#include <scree/world.h>

#include <cstdint>
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

// Boxes and hulls without rounding are `box` and `hull`.
enum class ShapeType : std::uint8_t {
  sphere,
  capsule,
  box,
  hull,
  mesh,
  half_space,
  rounded_box,
  rounded_hull,
  cylinder,
  cone,
};
inline constexpr int kShapeTypeCount = 10;
inline constexpr int kFastTypeCount = 4;  // the types before mesh: each pair of them has a kernel of its own
// The convex types that share their kernels, by where each is farthest along a direction.
constexpr bool is_smooth(ShapeType type) { return type >= ShapeType::rounded_box; }
constexpr bool has_hull(ShapeType type) { return type == ShapeType::hull || type == ShapeType::rounded_hull; }

enum ShapeFlag : std::uint8_t {
  kShapeAlive = 1,
  kShapeDirty = 2,  // bounds must be made before the next pairs: new, moved or changed by a call. A slot that
                    // is dirty but not alive held a shape that was destroyed
  kShapeNew = 4,    // with kShapeDirty: pairs that name the shape describe a predecessor in its slot
                    // or an earlier geometry or body type; their manifolds and colors must not be inherited
  kShapeSensor = 16,  // has no mass and no contacts; see ShapeOptions
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
  kJointReports = 32,  // has a limit in JointThresholds
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

// Above which reactions a joint is listed.
struct JointThresholds {
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

// A hull as shapes have it. Solids may be shared with other worlds.
struct SharedHull {
  ConvexHull geometry;                     // as given
  std::shared_ptr<const HullSolid> solid;  // with the scale in it
  // What kernels read, with the rounding in it: the solid's own, or of a rounded hull a copy. Points into the
  // solid's columns.
  std::shared_ptr<const HullData> data{};
};

struct SharedMesh {
  std::shared_ptr<const MeshSolid> solid;  // as given
};

// Which handles are a world's own, see World and restore.
struct HandleTags {
  std::uint32_t given = 0;  // stands in the handles that it gives
  std::uint32_t first = 0;  // stood in them before the world of another one's snapshot was restored
};

using SharedHulls = std::vector<SharedHull>;
using SharedMeshes = std::vector<SharedMesh>;
using ContentSlots = std::unordered_multimap<std::uint64_t, std::int32_t>;
using BodyMoments = std::unordered_map<std::int32_t, MassMoments>;

inline constexpr std::uint8_t kNoColor = 0xff;

// A handle as columns hold it: without the world, so that their bytes depend on the scene alone.
struct SlotName {
  std::uint32_t index, generation;

  friend bool operator==(const SlotName&, const SlotName&) = default;
};

struct TouchingPair {
  SlotName shape_a, shape_b, body_a, body_b;

  friend bool operator==(const TouchingPair&, const TouchingPair&) = default;
};

// The ContactEvents that are about touching, and so must be remembered of a pair that touches.
inline constexpr auto kTouchEvents =
    static_cast<std::uint8_t>(ContactEvents::begin_end | ContactEvents::persist);

// A pair of which such events were asked for when it last touched.
struct TouchRow {
  TouchingPair pair;     // names outlive their shapes
  std::uint32_t events;  // ContactEvents, of kTouchEvents
};

// A ContactAnswer. The names outlive their shapes.
struct HookAnswer {
  SlotName shape_a, shape_b;
  std::int32_t contact;  // of the pair, -1: the pair does not collide
  std::uint32_t acts;    // 1 or 0
  float friction, restitution, rolling_resistance;
  float surface_velocity[3];
};

// Of one chunk of pairs: how many there are of each, then where they go.
struct EventCounts {
  std::int32_t touching, resting, begins, persists, ends, hits;
};

}  // namespace scree
