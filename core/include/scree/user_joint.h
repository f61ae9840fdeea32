// User joints: constraints whose rows the caller states. A joint of this kind has 1 to 6 rows; each is an
// equation or an inequality of the velocities of both bodies,
//
//   J v = linear_a . v_a + angular_a . w_a + linear_b . v_b + angular_b . w_b
//
// where v is the velocity of a body's center of mass and w its angular velocity, in the axes of the world. An
// impulse along the row changes these velocities by M^-1 J^T times the impulse. The kinds of the rows are
// fixed by UserJoint; their numbers come from World::set_user_rows or, before every step, from the callback
// of World::set_user_row_callback.
//
// The numbers are those of the moment at which the step begins. While the step lasts its Jacobians stay, and
// the errors go on as the bodies move: by J times the motion of both (displacements and rotation vectors,
// within half a turn), less `speed` times the time. So a row that turns with the motion is of first order in
// the time step; core/constraints/README.md tells how to make it of second order.
#pragma once

#include <scree/ids.h>
#include <scree/math_types.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <span>

namespace scree {

class World;

/// The most rows that a user joint has.
inline constexpr int kMaxUserRows = 6;

/// What a row asks for. C is the error, whose rate is J v - speed.
enum class RowKind : std::uint8_t {
  none,  ///< no row
  /// C = 0, as stiffly as JointDef::hertz asks. All held rows of a joint are solved as one block, with
  /// whatever impulses they need: their bounds are not looked at.
  held,
  /// C >= 0, as the limits of other joints: it pushes only, with at most `upper`; `lower` is not looked at.
  /// While C is above 0 the end may be reached within a substep and no farther.
  limit,
  motor,  ///< J v = speed with a force within the bounds; the error is not looked at
  /// A spring on C and a damper on J v - speed, with a force within the bounds; as stiff and as damped as
  /// `hertz` and `damping_ratio` ask.
  spring,
};

/// A constraint that the caller states. It does nothing before it is given numbers.
struct UserJoint {
  /// The first entry is a row, and none stands behind an entry without one.
  RowKind rows[kMaxUserRows]{RowKind::held};

  friend bool operator==(const UserJoint&, const UserJoint&) = default;
};

/// The Jacobian of a row, in the axes of the world; each number within +-1e6. A body that cannot be pushed
/// has whatever numbers: its velocity counts, its mass is infinite.
struct RowJacobian {
  Vec3 linear_a{};   ///< times the velocity of body a's center of mass
  Vec3 angular_a{};  ///< times the angular velocity of body a
  Vec3 linear_b{};   ///< as linear_a, of body b
  Vec3 angular_b{};  ///< as angular_a, of body b

  friend bool operator==(const RowJacobian&, const RowJacobian&) = default;
};

/// What a row is to bring about. Units are those of C, whatever the Jacobian makes them: m or rad, say.
struct RowTarget {
  float error = 0.0f;          ///< C where the step begins, within +-1e6
  float speed = 0.0f;          ///< of C's target, 1/s; within +-1e6
  float hertz = 1.0f;          ///< Hz, of a spring, in [1e-3, 1e4]; at most 1/(4 substep) is used
  float damping_ratio = 1.0f;  ///< of a spring, in [0, 1e4]; 1 is critical

  friend bool operator==(const RowTarget&, const RowTarget&) = default;
};

/// The least and the largest force along a row; N where J makes m/s of velocities, N m where it makes rad/s.
/// `lower` is at most `upper`; both may be infinite. A substep's impulse is bounded by them times its length.
struct RowBounds {
  float lower = -std::numeric_limits<float>::infinity();  ///< N or N m
  float upper = std::numeric_limits<float>::infinity();   ///< N or N m

  friend bool operator==(const RowBounds&, const RowBounds&) = default;
};

/// All numbers of one row.
struct UserRow {
  RowJacobian jacobian{};  ///< zero: the row moves nothing
  RowTarget target{};      ///< what it is to bring about
  RowBounds bounds{};      ///< and with which force

  friend bool operator==(const UserRow&, const UserRow&) = default;
};

/// Some of the user joints of a world, for which a callback writes the numbers of the next step. Columns hold
/// kMaxUserRows entries a joint: row r of joints[i] is entry kMaxUserRows * i + r. They come with the present
/// numbers; entries behind the last row of a joint are ignored.
struct UserRowBatch {
  const World& world;                ///< where the step begins; only its const functions may be called
  float dt;                          ///< s, of the step
  std::span<const JointId> joints;   ///< enabled joints with an awake body
  std::span<RowJacobian> jacobians;  ///< to be written
  std::span<RowTarget> targets;      ///< to be written
  std::span<RowBounds> bounds;       ///< to be written
};

/// Writes the numbers of a batch, see World::set_user_row_callback.
using UserRowCallback = std::function<void(const UserRowBatch& batch)>;

}  // namespace scree
