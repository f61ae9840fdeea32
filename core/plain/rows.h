// Rows: the data of one body, shape or contact that a stage reads together, as plain memory.
//
// Kernels of every instruction set include this file, so it holds plain structs only: no function with a body
// (an inline function compiled for AVX-512 could be the copy that the linker keeps for everyone), no
// container, no Eigen. Every row is a multiple of 16 bytes, because kernels load rows 16 bytes at a time and
// transpose them in registers.
#pragma once

#include <cstdint>

namespace scree {

// Body index 0 is the fixed world: constraints against any fixed body read its row. Indices 1 to 3 stay
// empty, so that no row that a solver thread writes shares a cache line pair with row 0, which all read.
inline constexpr std::int32_t kFixedRow = 0;
inline constexpr std::int32_t kFirstBody = 4;

// Lengths, in meters.
inline constexpr float kLinearSlop = 0.005f;  // overlap that contacts leave to stay in touch
inline constexpr float kSpeculativeDistance = 4 * kLinearSlop;  // gap below which a pair has contact points
// What moves or turns farther in a step is fast: bounds cover its way, and contacts look ahead along it.
inline constexpr float kFastTravel = 0.5f * kSpeculativeDistance;
inline constexpr float kFastTurn = 0.5f;  // rad

// Placement of a center of mass (bodies) or of a shape's origin (shapes).
struct alignas(32) PoseRow {
  float position[3];
  float padding;
  float rotation[4];  // x y z w

  // What World::hash reads: bit k stands for the k-th word. All but the padding.
  static constexpr unsigned kHashedWords = 0b11110111;
};

// Velocity of the center of mass; the layout of scree::Velocity.
//
// A fast body that was stopped where it will rebound has not moved for the rest of that step: it lags behind
// the world's time, and makes up for it at the end of its next step; see sweep_fast_bodies.cpp.
struct alignas(32) VelocityRow {
  float linear[3];
  float angular[3];
  float lag;  // s
  float padding;

  static constexpr unsigned kHashedWords = 0b01111111;  // see PoseRow
};

// Motion since the step began. Kept apart from the pose: small numbers keep their precision far from the
// origin, and contacts need differences only.
struct alignas(32) DeltaRow {
  float position[3];
  float rotation[4];  // x y z w, rotates the pose at the step's beginning
  float padding;
};

// Inverse inertia (in the axes that the column names) and inverse mass. Zero for bodies that cannot be
// pushed.
struct alignas(32) InertiaRow {
  float inverse_inertia[6];  // xx xy xz yy yz zz
  float inverse_mass;
  float padding;
};

// Force and torque on a body during the next step.
struct alignas(32) ForceRow {
  float force[3];
  float torque[3];
  float padding[2];
};

// Motion since the timer of sleep began to run.
struct alignas(32) DriftRow {
  float way[3];   // m
  float turn[3];  // rad, the sum of the steps' rotation vectors
  float padding[2];
};

// Parameters of motion.
struct alignas(16) MotionRow {
  float linear_damping;   // 1/s
  float angular_damping;  // 1/s
  float gravity_factor;
  std::uint32_t flags;  // MotionFlag
};

// Inertia in the body's axes, for the gyroscopic term.
struct alignas(32) LocalInertiaRow {
  float inertia[6];  // xx xy xz yy yz zz, kg m^2
  float padding[2];
};

enum MotionFlag : std::uint32_t {
  kMotionLocksMask = 0x3f,      // AxisLocks
  kMotionGyroscopic = 1 << 8,   // inertia is not isotropic: integrate the gyroscopic term
  kMotionJointed = 1 << 9,      // has joints: its inertia in world axes is kept up to date within the step
  kMotionSweptWhole = 1 << 10,  // its shapes are swept as they are, not by balls within them
};

// What a step notes about a body.
enum StepNote : std::uint8_t {
  kHasContacts = 1,
  kNonFiniteAlone = 2,  // became non-finite by its own motion, before any contact acted
  kIsFast = 4,          // may pass through others in this step: it is swept
  kLags = 8,            // its last step ended early: it is swept
  kMovesWhole = 16,     // it is swept as it is, and moves so far that contacts cannot take it
};

// Extents of a shape: sphere (radius), capsule (half[1], radius), box (half), hull (the box and the ball
// about its centroid that hold it; of a rounded hull, too), rounded box (half of the box within, and radius:
// the rounding), cylinder and cone (half: radius, half height, radius).
struct alignas(16) ExtentRow {
  float half[3];
  float radius;
};

// Of a half-space: a box about its origin in which all that it may touch lies. Positions that calls give are
// at most 1e7 m along each axis.
inline constexpr float kHalfSpaceReach = 1e8f;  // m
inline constexpr ExtentRow kHalfSpaceExtent{{kHalfSpaceReach, kHalfSpaceReach, kHalfSpaceReach},
                                            2.0f * kHalfSpaceReach};

// Surface of a shape as the narrow phase mixes it.
struct alignas(32) MaterialRow {
  float friction;
  float restitution;
  float rolling_resistance;   // m
  std::uint32_t rules;        // friction MixRule | restitution MixRule << 8 | MaterialFlag
  float surface_velocity[3];  // m/s, in the shape's frame
  float patch_radius;         // m, or kAutomaticPatch
};
// Below all that are given, as of two surfaces the larger counts.
inline constexpr float kAutomaticPatch = -1.0f;

enum MaterialFlag : std::uint32_t {
  kMaterialMoves = 1 << 16,  // surface velocity is not zero
  kMaterialPatch = 1 << 17,  // patch_radius is given; others, as nearly all, are spared reading it
};

// Axis-aligned box and bounding sphere; the sphere's center is the box's center.
struct alignas(32) BoundsRow {
  float lower[3];
  float sphere_radius;
  float upper[3];
  float padding;
};

// How far a shape has moved since the last narrow phase.
struct alignas(16) StepMotion {
  float offset[3];  // of its place, m
  float turn;  // m, how far a point 1 m from its place can have moved beyond that; infinite where that is
               // not known, or the shape is fast
};

// A candidate pair of shapes, a < b.
struct ShapePair {
  std::int32_t a;
  std::int32_t b;
};

}  // namespace scree
