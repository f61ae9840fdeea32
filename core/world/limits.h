// Limits of arguments, shared by the checks of World's calls and the reader of scene files. The public
// headers state them beside each field.
#pragma once

namespace scree {

// Limits that keep float arithmetic on state finite with room to spare.
inline constexpr float kMaxPosition = 1e7f;       // m; at 1e7 m neighboring floats are 1 m apart
inline constexpr float kMaxLocalPosition = 1e5f;  // m, of a shape in its body
inline constexpr float kMaxSpeed = 1e9f;          // m/s, rad/s; squares and cross products stay finite
inline constexpr float kMinExtent = 1e-4f;        // m
inline constexpr float kMaxExtent = 1e5f;         // m
inline constexpr float kMinHullScale = 1e-9f;     // from the largest to the smallest extent
inline constexpr float kMaxHullScale = 1e9f;
inline constexpr float kMinDensity = 1e-6f;  // kg/m^3; the smallest sphere keeps a finite inverse inertia
inline constexpr float kMaxDensity = 1e9f;   // kg/m^3; the largest sharp box keeps a sound inertia
inline constexpr float kMinMass = 1e-20f;    // kg
inline constexpr float kMaxMass = 1e30f;     // kg
inline constexpr float kMaxFriction = 1e6f;  // well above any surface, far below overflow
inline constexpr float kMaxRollingResistance = 1e5f;  // m
inline constexpr float kMaxPatchRadius = 1e5f;        // m
inline constexpr float kMaxSurfaceSpeed = 1e6f;       // m/s
inline constexpr float kMaxRate = 1e6f;               // 1/s, damping and other rates
inline constexpr float kMaxGravity = 1e6f;            // m/s^2
inline constexpr float kMaxGravityFactor = 1e6f;
inline constexpr float kMaxAcceleration = 1e15f;  // m/s^2, rad/s^2, from the forces on one body
inline constexpr float kUnitTolerance = 1e-3f;    // of a quaternion's length

// Of joints. Limits and forces may be infinite, too.
inline constexpr float kMaxJointValue = 1e6f;        // m, rad, m/s, rad/s: of axes and drives
inline constexpr float kMaxJointAngle = 3.1415927f;  // rad, of limits of angles; the float above pi
inline constexpr float kMaxSteering = 1.5707964f;    // rad, of a wheel's limits; the float above pi / 2
inline constexpr float kMinRatio = 1e-3f;            // of gears, racks (m) and pulleys
inline constexpr float kMaxRatio = 1e3f;
inline constexpr float kMaxRope = 1e6f;  // m, of a pulley

// Of settings.
inline constexpr int kMaxSubsteps = 64;
inline constexpr float kMinHertz = 1e-3f;  // of joints, too
inline constexpr float kMaxHertz = 1e4f;
inline constexpr float kMaxDampingRatio = 1e4f;
inline constexpr float kMaxThreshold = 1e6f;    // m/s, rad/s or s
inline constexpr float kMinSpeedLimit = 1e-3f;  // m/s, rad/s
inline constexpr float kMaxSpeedLimit = 1e6f;
inline constexpr int kMaxIterations = 1000000;
inline constexpr float kMaxTolerance = 1.0f;       // m/s or rad/s
inline constexpr float kMaxRelaxation = 1.99999f;  // below 2, where steps no longer converge
inline constexpr float kMaxSlop = 1e3f;            // m

}  // namespace scree
