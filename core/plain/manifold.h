// Manifolds: the contact points and impulses of one touching pair of shapes, from the narrow phase to the
// solver.
//
// collide writes the geometry, and the impulses of matched features of the last step; store_impulses writes
// the new impulses; pack_blocks reads it. Does not depend on lanes or instruction sets.
#pragma once

#include <core/plain/rows.h>

#include <cstdint>

namespace scree {

inline constexpr int kMaxManifoldPoints = 4;

// 128 bytes in eight groups of 16, each one transpose.
//
// The normal points from body A to body B. Where one body is not dynamic it is A. A point lies at C + point_u
// t1 + point_v t2 (+ an offset along the normal that does not matter), C the friction center: the average of
// the points, weighted by closeness, continuous in separation. t1 = tangent_of(normal), t2 = normal x t1.
// Points that do not exist have separation kAbsentSeparation, u = v = 0 and no impulse; but where a sphere or
// a capsule touches, which has two points at most, or a smooth shape does with as few, point_v[kTwistArm] is
// the mean arm at which friction acts against spin about the normal in the patch around a point, in meters.
// There point_u[kCoreA] and point_u[kCoreB] are distances from C, against the normal and along it, to what
// turns with A and B: the core of a round shape (a sphere's center, the axis of a capsule or of a lying
// cylinder), the surface of any other. The surface of a round shape lies a radius from its core along the
// normal, however the body turns.
struct alignas(64) Manifold {
  float normal[3];
  float friction;
  float arm_a[3];  // C - center of mass of A
  std::int32_t row_a;
  float arm_b[3];  // C - center of mass of B
  std::int32_t row_b;
  float point_u[kMaxManifoldPoints];
  float point_v[kMaxManifoldPoints];
  float separation[kMaxManifoldPoints];
  float normal_impulse[kMaxManifoldPoints];  // N s
  float friction_impulse[2];                 // along t1 and t2, N s
  float twist_impulse;                       // about the normal, N m s
  std::uint32_t info;                        // points | ManifoldFlag
};

inline constexpr int kTwistArm = 3;
inline constexpr int kCoreA = 2;
inline constexpr int kCoreB = 3;
inline constexpr float kAbsentSeparation = 1e10f;

enum ManifoldFlag : std::uint32_t {
  kManifoldPointMask = 0x7,  // number of points; 0: the pair does not touch and the rest is meaningless
  kManifoldRich = 1 << 4,    // has restitution, rolling resistance or a surface velocity: see ContactSurface
  kManifoldStatic = 1 << 5,  // body A is not dynamic
};

// Identity of the points, equal from step to step while the same features touch.
struct alignas(16) ManifoldFeatures {
  std::uint32_t id[kMaxManifoldPoints];
};

// Where both bodies were when a manifold was made. While they have hardly moved relative to each other since,
// the manifold is recycled: its points keep their places and only the separations follow. Where one has
// turned, it is carried along with A.
struct alignas(64) ContactAnchor {
  float rotation_a[4];  // of the body A of the manifold
  float rotation_b[4];
  float offset[3];  // from the center of mass of A to that of B
  float is_set;     // 0: must not be recycled; else 1 and m, by which the bodies have moved relative to each
                    // other before the manifold was carried along
  float separation[kMaxManifoldPoints];
};

// Where the narrow phase starts its search for a pair with a hull. A hint only: every value leads to the same
// contact.
struct alignas(16) ContactAxis {
  float axis[3];          // unit, in the first shape's frame: separated the pair, or the contact's normal
  std::uint32_t feature;  // what decided the contact, 0: the pair did not touch. See collide_hull.h
};

// How much two shapes that do not touch may move before they can. It only spares work: without it the same
// pairs touch.
struct PairClearance {
  float gap;    // between the balls about them, or along an axis fixed in one of them, m. Known above
                // kSpeculativeDistance
  float lever;  // of the points that turns bring nearer, m; 0 between balls
};

// The rare part of a contact's surface; meaningful where kManifoldRich is set.
struct alignas(16) ContactSurface {
  float restitution;
  float rolling_resistance;   // m
  float surface_velocity[3];  // of B's surface relative to A's in world axes, m/s; along the tangent plane
  float rolling_impulse[3];   // N m s in world axes; written by store_impulses
};

// The impulses of a contact over a whole step, summed over its substeps; while WorldSettings::contact_forces
// is on. Written by store_impulses.
struct alignas(64) ContactForceRow {
  float normal_impulse[kMaxManifoldPoints];  // N s
  float friction_impulse[2];                 // along t1 and t2, N s
  float twist_impulse;                       // about the normal, N m s
  float is_set;                              // 1: measured, 0: not yet
  float rolling_impulse[3];                  // N m s in world axes
  float padding_1;
  float center[3];  // m, of friction, in world coordinates where the step began
  float padding_2;
};

}  // namespace scree
