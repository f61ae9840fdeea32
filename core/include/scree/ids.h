// Handles of bodies, shapes and joints.
//
// A handle is an index and a generation: destroying an object raises the generation of its index, so that a
// handle kept too long is recognized instead of naming a stranger. Generations begin at 1: a default handle
// is never alive. A handle means something to the world that gave it only; another world rejects it unless it
// has a living object of the very same index and generation.
#pragma once

#include <compare>
#include <cstdint>

namespace scree {

/// Names a body of one world. The default is no body. `index` is the body's place in the bulk columns.
struct BodyId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;

  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

/// Names the world itself as an end of a joint: a body that never moves and whose origin is that of world
/// coordinates. Calls that want a body reject it.
inline constexpr BodyId kWorld{.index = 0, .generation = 0xffffffffu};

/// Names a shape of one world. The default is no shape.
struct ShapeId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;

  friend auto operator<=>(const ShapeId&, const ShapeId&) = default;
};

/// Names a joint of one world. The default is no joint.
struct JointId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;

  friend auto operator<=>(const JointId&, const JointId&) = default;
};

}  // namespace scree
