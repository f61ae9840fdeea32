// The mover: a capsule that walks, slides, climbs steps and rides platforms, for characters of games and for
// whatever else shall move by wish instead of by forces.
//
// A mover is no body. It sees the shapes of a world through queries, and the bodies of the world do not see
// it. A program keeps a MoverState for each, and calls move() after each step. Bodies that shall collide with
// the mover meet a kinematic body that follows it and that MoverSettings::ignored names.
//
// What move() does depends on the world, the state and its arguments alone, bit for bit.
#pragma once

#include <scree/export.h>
#include <scree/ids.h>
#include <scree/math_types.h>
#include <scree/queries.h>
#include <scree/shapes.h>
#include <scree/world.h>

#include <cstdint>
#include <functional>
#include <optional>

namespace scree {

/// What a mover is and can do. The capsule's inner segment is along `up`; it never turns.
struct MoverSettings {
  float radius = 0.3f;           ///< m, of the capsule, in [1e-3, 1e3]
  float half_height = 0.6f;      ///< m, half the length of the inner segment, in [1e-4, 1e3]
  Vec3 up{0.0f, 1.0f, 0.0f};     ///< unit length within 1e-3 (renormalized)
  float skin = 0.02f;            ///< m, kept between the capsule and all shapes, in [1e-3, 1] of the radius
  float slope_cosine = 0.7071f;  ///< of the largest slope that can be walked (45 degrees), in [0.1, 1]
  float step_height = 0.35f;     ///< m, the highest step that is climbed, in [0, 1e3]; 0: none
  /// m, in [0, 1e3]: ground that falls away by no more than this is followed down, as on stairs and behind
  /// crests; else the mover is in the air.
  float snap_distance = 0.4f;
  float push_force = 500.0f;  ///< N, in [0, 1e9], of all bodies together: what dynamic bodies are pushed with
  /// kg, in [0, 1e6]: what presses on a dynamic body below, in the world's gravity; on bodies lighter than a
  /// tenth of it only ten times their own mass. Such bodies stay awake. 0: no weight.
  float mass = 70.0f;
  std::optional<Filter> filter{};    ///< of the mover, as if it were a shape; none: every shape counts
  BodyTypes types = BodyTypes::all;  ///< of the bodies that count; sensors never do
  BodyId ignored{};  ///< whose shapes do not count, as those of a body that stands for the mover
  /// Called for shapes that have passed the rest; false: does not count. As QueryOptions::predicate.
  std::function<bool(ShapeId, BodyId)> predicate{};
};

/// What a mover stands on.
enum class MoverGround : std::uint8_t {
  none,   ///< nothing: it is in the air
  steep,  ///< only what is steeper than MoverSettings::slope_cosine allows: it slides down
  firm,   ///< ground that it can walk on
};

/// Where a mover is and what holds it. To copy it is to save it. A new one needs a position only.
struct MoverState {
  Vec3 position{};  ///< m, the middle of the capsule, each within +-1e7
  /// m/s, what is left of the wanted velocity: without what obstacles have stopped. On firm ground relative
  /// to that ground and level; else in the world, with the velocity of the ground that it has left.
  Vec3 velocity{};
  MoverGround ground = MoverGround::none;  ///< what it stands on
  Vec3 ground_normal{};                    ///< of the surface that it stands on, unit; zero in the air
  Vec3 ground_point{};                     ///< m, where it stands; zero in the air
  BodyId ground_body{};                    ///< what it stands on; none in the air
  ShapeId ground_shape{};                  ///< the shape of that body
  Vec3 ground_velocity{};                  ///< m/s, of that body's matter at `position`; zero in the air
  Vec3 place_on_ground{};                  ///< m, `position` in the frame of `ground_body`
  bool touches_wall = false;               ///< in the last move something stopped it on its way
  bool touches_ceiling = false;            ///< in the last move something stopped it from above
  bool squeezed = false;  ///< has no room: a shape reaches into the capsule by more than a tenth of the skin

  friend bool operator==(const MoverState&, const MoverState&) = default;
};

/// Moves the mover for `dt` seconds, in (0, 1]; call it after the step of as many. `velocity` (m/s, each
/// within
/// +-1e6) is what the caller wants:
///
/// - On firm ground relative to that ground, whose motion the mover follows. Only its level part counts, and
///   the mover keeps it uphill and downhill. It jumps, and is in the air, if the velocity rises and leaves
///   the ground: by more than a thousandth of it away from `ground_normal`.
/// - Else in the world: a caller gives MoverState::velocity plus what gravity and steering add in `dt`.
///
/// First what moves pushes the mover out of its way, then it goes its own, slides along what it meets, and
/// steps up and down. It never enters a shape from outside. The world changes where it pushes dynamic bodies,
/// by World's calls, so that recordings play the same.
///
/// Throws Error for values out of range, for a dead MoverSettings::ignored and for a world that was moved
/// from, and what the predicate throws; nothing changes then.
SCREE_API void move(World& world, MoverState& state, const MoverSettings& settings, Vec3 velocity, float dt);

}  // namespace scree
