// What a body is when it is created.
#pragma once

#include <scree/math_types.h>

#include <cstdint>
#include <optional>

namespace scree {

/// Fixed bodies never move, kinematic ones follow their velocity and push without being pushed, dynamic ones
/// obey forces and contacts.
enum class BodyType : std::uint8_t {
  fixed,      ///< never moves
  kinematic,  ///< follows its velocity and pushes without being pushed
  dynamic,    ///< obeys forces, contacts and joints
};

/// Degrees of freedom taken from a dynamic body, in world axes; combine with |. Planar motion in x and y is
/// `translation_z | rotation_x | rotation_y`.
enum class AxisLocks : std::uint8_t {
  none = 0,           ///< free
  translation_x = 1,  ///< no motion of the center of mass along x
  translation_y = 2,  ///< no motion of the center of mass along y
  translation_z = 4,  ///< no motion of the center of mass along z
  rotation_x = 8,     ///< no rotation about x
  rotation_y = 16,    ///< no rotation about y
  rotation_z = 32,    ///< no rotation about z
};

/// The locks of both.
constexpr AxisLocks operator|(AxisLocks left, AxisLocks right) {
  return static_cast<AxisLocks>(static_cast<unsigned>(left) | static_cast<unsigned>(right));
}

/// Mass, center of mass and inertia of a body in its own frame.
struct MassProperties {
  float mass = 1.0f;  ///< kg, in [1e-20, 1e30]
  Vec3 center{};      ///< m, center of mass in the body's frame, each within +-1e5
  /// kg m^2 about the center of mass in the body's axes: xx, yy, zz, then xy, xz, yz. Positive definite; the
  /// diagonal in [1e-30, 1e35].
  float inertia[6] = {1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f};
};

/// What a new body is. Mass comes from the shapes' densities unless it is given here; a dynamic body that has
/// neither shapes nor a mass weighs 1 kg with the inertia of 1 kg m^2 about every axis (with a given mass,
/// that inertia scales with it).
struct BodyDef {
  BodyType type = BodyType::dynamic;  ///< fixed, kinematic or dynamic
  Vec3 position{};                    ///< m, of the body's origin, each within +-1e7
  Quat rotation{};                    ///< unit length within 1e-3 (renormalized)
  Vec3 linear_velocity{};        ///< m/s, of the center of mass, each within +-1e9; fixed bodies ignore it
  Vec3 angular_velocity{};       ///< rad/s, each within +-1e9; fixed bodies ignore it
  float linear_damping = 0.0f;   ///< 1/s, in [0, 1e6]
  float angular_damping = 0.0f;  ///< 1/s, in [0, 1e6]
  float gravity_factor = 1.0f;   ///< multiplies the world's gravity, within +-1e6
  AxisLocks locks = AxisLocks::none;  ///< degrees of freedom taken from a dynamic body
  std::optional<float> mass{};        ///< kg, in [1e-20, 1e30]: scales the shapes' inertia to this mass
  bool can_sleep = true;              ///< false: the body never falls asleep
  /// Of a dynamic body: whether, with WorldSettings::continuous, its shapes are swept as they are, while they
  /// move and turn, where those of others are swept by balls within them. For what is long, flat or spins
  /// fast among what is thin. It may still pass meshes from behind, what it comes to by more than half a turn
  /// in a step, and what moves if one of the two got its speed in the same step.
  /// Costs some microseconds for each shape and each triangle near its way, and nothing while it moves less
  /// than 1 cm in a step.
  bool full_sweep = false;
  std::uint64_t user_data = 0;  ///< any number of the caller's; the library never reads it
};

}  // namespace scree
