// Balls within shapes: fast bodies are swept with them, and they say how far a body may move unswept.
//
// Balls that lie within a shape stand for it: one about its center, and those that fit into its corners or
// ends. A body that moves less than half a ball's radius cannot bring the ball's core, which is half as
// large, into an obstacle that the ball did not touch before.
#pragma once

#include <core/plain/hull.h>
#include <scree/math_types.h>

#include <cstddef>
#include <cstdint>

namespace scree {

struct WorldData;

inline constexpr int kMostBalls = 16;
inline constexpr float kCoreShare = 0.5f;  // the core's of a ball's radius; cores are what is swept

// A ball within a shape; the center is in the shape's frame.
struct Ball {
  Vec3 center;
  float radius;
};

// The first one is about the shape's center.
struct Balls {
  Ball ball[kMostBalls];
  int count = 0;
  void add(Vec3 center, float radius) { ball[count++] = {center, radius}; }
};

Balls balls_of(const HullData& hull);
Balls balls_of(const WorldData& data, std::int32_t shape);  // none of meshes and half-spaces
// m, of the first ball; 0 of meshes and half-spaces, which have none.
float inner_radius_of(const WorldData& data, std::int32_t shape);

// Makes the core of a body that of one more shape, wherever that is.
void extend_core(WorldData& data, std::int32_t body, std::int32_t shape);
// Writes Bodies::core of a body from its shapes.
void measure_core(WorldData& data, std::int32_t body);

}  // namespace scree
