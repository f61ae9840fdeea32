// Balls within shapes; see balls.h.
#include <core/geometry/balls.h>
#include <core/geometry/hull/hull_build.h>
#include <core/world/edit.h>

#include <algorithm>
#include <cmath>

namespace scree {

namespace {

void add_corners(const float (&half)[3], float radius, Balls& balls) {
  const Vec3 inset{half[0] - radius, half[1] - radius, half[2] - radius};
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto along = [&](unsigned axis, float size) { return (corner >> axis & 1u) != 0 ? -size : size; };
    // The thinnest axis, and others as thin, have one corner in place of two.
    const bool repeated = ((corner & 1u) != 0 && !(inset.x > 0.0f)) ||
                          ((corner & 2u) != 0 && !(inset.y > 0.0f)) ||
                          ((corner & 4u) != 0 && !(inset.z > 0.0f));
    if (!repeated) balls.add({along(0, inset.x), along(1, inset.y), along(2, inset.z)}, radius);
  }
}

// Eight balls about the y axis.
void add_ring(float height, float distance, float radius, Balls& balls) {
  constexpr float kDiagonal = 0.70710677f;
  const float aside = kDiagonal * distance;
  const float places[8][2] = {{distance, 0.0f},  {aside, aside},   {0.0f, distance},  {-aside, aside},
                              {-distance, 0.0f}, {-aside, -aside}, {0.0f, -distance}, {aside, -aside}};
  for (const auto& [x, z] : places) balls.add({x, height, z}, radius);
}

// The ball about the center, and where the cylinder is long two at its ends, or where it is flat eight along
// its rim.
Balls balls_of_cylinder(float radius, float half_height) {
  const float size = std::min(radius, half_height);
  Balls balls;
  balls.add({}, size);
  if (half_height > radius) {
    for (const float end : {half_height - size, size - half_height}) balls.add({0.0f, end, 0.0f}, size);
  } else if (radius > half_height) {
    add_ring(0.0f, radius - size, size, balls);
  }
  return balls;
}

// The largest ball within, and between it and the apex and the rim smaller ones: a cone holds what lies
// between a ball of its own and one of its points.
Balls balls_of_cone(float radius, float half_height) {
  constexpr float kOut = 0.75f;  // of the way there
  const float height = 2.0f * half_height;
  const float share = radius / std::sqrt(radius * radius + height * height);  // sine of half the apex's angle
  const float inner = height * share / (1.0f + share), place = inner - half_height;
  const float least = (1.0f - kOut) * inner;
  Balls balls;
  balls.add({0.0f, place, 0.0f}, inner);
  balls.add({0.0f, place + kOut * (half_height - place), 0.0f}, least);
  add_ring(place - kOut * (half_height + place), kOut * radius, least, balls);
  return balls;
}

// A rounding makes all that is within a shape larger by as much.
Balls rounded(Balls balls, float rounding) {
  for (int i = 0; i < balls.count; ++i) balls.ball[i].radius += rounding;
  return balls;
}

Vec3 vertex_of(const HullData& hull, int vertex) {
  return {hull.vertex[0][vertex], hull.vertex[1][vertex], hull.vertex[2][vertex]};
}

// A hull holds the ball about its centroid and its vertices, so also the latter's smaller copies between
// them.
void add_vertices(const HullData& hull, Balls& balls) {
  constexpr float kOut = 0.75f;  // of the way to the vertex
  int chosen[kMostBalls], count = 0;
  for (int direction = 0; direction < 14; ++direction) {  // along the axes and the diagonals
    const int bits = direction < 8 ? direction : 1 << (direction - 8) / 2;
    const auto sign = [&](int axis) {
      if (direction < 8) return (bits >> axis & 1) != 0 ? -1.0f : 1.0f;
      return (bits >> axis & 1) == 0 ? 0.0f : direction % 2 == 0 ? -1.0f : 1.0f;
    };
    const Vec3 normal{sign(0), sign(1), sign(2)};
    int best = 0;
    for (int vertex = 1; vertex < hull.vertex_count; ++vertex) {
      if (dot(vertex_of(hull, vertex), normal) > dot(vertex_of(hull, best), normal)) best = vertex;
    }
    if (std::find(chosen, chosen + count, best) != chosen + count) continue;
    chosen[count++] = best;
    balls.add(kOut * vertex_of(hull, best), (1.0f - kOut) * hull.inner_radius);
  }
}

}  // namespace

Balls balls_of(const HullData& hull) {
  Balls balls;
  balls.add({}, hull.inner_radius);
  if (hull.outer_radius > 2.0f * hull.inner_radius) add_vertices(hull, balls);
  return balls;
}

Balls balls_of(const WorldData& data, std::int32_t shape) {
  const ExtentRow& extent = data.shapes.extent[shape];
  Balls balls;
  switch (data.shapes.type[shape]) {
    case ShapeType::sphere:
      balls.add({}, extent.radius);
      break;
    case ShapeType::capsule:
      for (const float end : {0.0f, extent.half[1], -extent.half[1]})
        balls.add({0.0f, end, 0.0f}, extent.radius);
      break;
    case ShapeType::box:
    case ShapeType::rounded_box: {
      const float radius = std::min(extent.half[0], std::min(extent.half[1], extent.half[2]));
      balls.add({}, radius);
      if (std::max(extent.half[0], std::max(extent.half[1], extent.half[2])) > radius)
        add_corners(extent.half, radius, balls);
      balls = rounded(balls, extent.radius);
      break;
    }
    case ShapeType::cylinder:
      balls = balls_of_cylinder(extent.half[0], extent.half[1]);
      break;
    case ShapeType::cone:
      balls = balls_of_cone(extent.half[0], extent.half[1]);
      break;
    case ShapeType::rounded_hull: {
      const SharedHull& hull = data.hulls.shared[static_cast<std::size_t>(data.shapes.hull[shape])];
      balls = rounded(hull.solid->balls, hull.data->rounding);
      break;
    }
    case ShapeType::hull:
      balls = data.hulls.shared[static_cast<std::size_t>(data.shapes.hull[shape])].solid->balls;
      break;
    case ShapeType::mesh:
    case ShapeType::half_space:
      break;
  }
  return balls;
}

float inner_radius_of(const WorldData& data, std::int32_t shape) {
  const ExtentRow& extent = data.shapes.extent[shape];
  switch (data.shapes.type[shape]) {  // the commonest, without their other balls
    case ShapeType::sphere:
    case ShapeType::capsule:
      return extent.radius;
    case ShapeType::box:
    case ShapeType::rounded_box:
      return std::min(extent.half[0], std::min(extent.half[1], extent.half[2])) + extent.radius;
    case ShapeType::hull:
      return data.hulls.data[data.shapes.hull[shape]]->inner_radius;
    default: {
      const Balls balls = balls_of(data, shape);
      return balls.count > 0 ? balls.ball[0].radius : 0.0f;
    }
  }
}

void extend_core(WorldData& data, std::int32_t body, std::int32_t shape) {
  CoreRow& core = data.bodies.core[body];
  data.bodies.marks.mark(body);
  const Balls balls = balls_of(data, shape);
  if (balls.count == 0) return;
  core.radius = std::min(core.radius, kCoreShare * balls.ball[0].radius);
  const float offset = length(to_vec3(data.shapes.local_pose[shape].position));
  for (int i = 0; i < balls.count; ++i) {
    const float reach = offset + length(balls.ball[i].center);
    core.reach = std::max(core.reach, reach);
    core.size = std::max(core.size, reach + kCoreShare * balls.ball[i].radius);
  }
}

void measure_core(WorldData& data, std::int32_t body) {
  data.bodies.core[body] = kNoCore;
  data.bodies.marks.mark(body);
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    extend_core(data, body, shape);
  }
}

}  // namespace scree
