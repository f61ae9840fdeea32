// Handles of bodies, shapes and joints.
//
// A handle is an index, a generation and the world that gave it. Destroying an object raises the generation
// of its index, so that a handle kept too long is recognized instead of naming a stranger; generations begin
// at 1, so a default handle is never alive. The handle of another world is rejected
// (ErrorCode::foreign_handle).
//
// Worlds that branch off in memory share handles: save, restore and clone carry them over, so that a handle
// from before names the same body in all branches. Bytes hold none: a world that is restored from bytes goes
// on with handles of its own. Programs that keep handles in files keep index and generation; a handle made of
// the two is taken by any world.
#pragma once

#include <compare>
#include <cstdint>

namespace scree {

/// Names a body of one world. The default is no body. `index` is the body's place in the bulk columns.
/// Handles are equal if all three numbers are; World::share_handles lets equal worlds give equal ones.
struct BodyId {
  std::uint32_t index = 0;       ///< the place in the bulk columns
  std::uint32_t generation = 0;  ///< counts the bodies at this index, from 1; 0 is no body
  std::uint32_t world = 0;       ///< that gave it; 0: of any world. Another one in each run of a program

  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// Names the world itself as an end of a joint: a body that never moves and whose origin is that of world
/// coordinates. Calls that want a body reject it.
inline constexpr BodyId kWorld{.index = 0, .generation = 0xffffffffu};

/// Names a shape of one world. The default is no shape.
struct ShapeId {
  std::uint32_t index = 0;       ///< the place among the shapes
  std::uint32_t generation = 0;  ///< counts the shapes at this index, from 1; 0 is no shape
  std::uint32_t world = 0;       ///< as in BodyId

  friend auto operator<=>(const ShapeId&, const ShapeId&) = default;
};

/// Names a joint of one world. The default is no joint.
struct JointId {
  std::uint32_t index = 0;       ///< the place among the joints
  std::uint32_t generation = 0;  ///< counts the joints at this index, from 1; 0 is no joint
  std::uint32_t world = 0;       ///< as in BodyId

  friend auto operator<=>(const JointId&, const JointId&) = default;
};

}  // namespace scree
