// A world with a mover in it, and how far that is from all shapes.
#pragma once

#include <gtest/gtest.h>
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace scree::testing {

constexpr float kMoverStep = 1.0f / 60.0f;  // s
constexpr double kDegree = 3.14159265358979323846 / 180.0;

inline float cosine_of(double degrees) { return static_cast<float>(std::cos(degrees * kDegree)); }

struct MoverLab {
  World world;
  MoverSettings settings;
  MoverState mover;
  Workers workers{1};

  // The height of the middle of a mover that stands on ground at a height.
  float standing(float ground = 0.0f) const {
    return ground + settings.half_height + settings.radius + settings.skin;
  }
  BodyId add_box(BodyType type, Vec3 position, Vec3 half_extents, Quat rotation = {}, float friction = 0.6f,
                 float density = 1000.0f) {
    const BodyId body = world.create_body({.type = type, .position = position, .rotation = rotation});
    world.add_shape(body, Box{half_extents}, {.friction = friction, .density = density});
    return body;
  }
  BodyId add_floor(float height = 0.0f) {
    return add_box(BodyType::fixed, {0, height - 1, 0}, {100, 1, 100});
  }
  // Puts the mover on the ground below, at rest.
  void place(Vec3 position) {
    mover = MoverState{.position = position};
    move({}, 1);
  }
  // Steps and moves; on firm ground and in the air the caller wants `velocity`, and gravity acts in the air.
  void walk(Vec3 velocity, int steps) {
    for (int i = 0; i < steps; ++i) {
      step(world, kMoverStep, workers);
      Vec3 wanted = velocity;
      if (mover.ground != MoverGround::firm)
        wanted.y = mover.velocity.y + kMoverStep * world.settings().gravity.y;
      scree::move(world, mover, settings, wanted, kMoverStep);
    }
  }
  // Falls freely where it does not stand, and wants nothing.
  void wait(int steps) {
    for (int i = 0; i < steps; ++i) {
      step(world, kMoverStep, workers);
      Vec3 wanted{};
      if (mover.ground != MoverGround::firm) wanted = mover.velocity + kMoverStep * world.settings().gravity;
      scree::move(world, mover, settings, wanted, kMoverStep);
    }
  }
  // Moves alone, without gravity and without steps of the world.
  void move(Vec3 velocity, int moves) {
    for (int i = 0; i < moves; ++i) scree::move(world, mover, settings, velocity, kMoverStep);
  }
  // m, from the capsule to the nearest shape; below zero where one reaches into it. Large if none is near.
  double gap(BodyTypes types = BodyTypes::all) const {
    constexpr float kThin = 1e-4f;
    const PlacedShape line{Capsule{settings.half_height, kThin}, {mover.position, turn_of(settings.up)}};
    const std::optional<NearHit> hit =
        closest_to_shape(world, line, settings.radius + 1.0f, {.types = types});
    return hit ? double{hit->distance} + kThin - settings.radius : 1.0;
  }
  static Quat turn_of(Vec3 up) {
    const Vec3 axis = cross(Vec3{0, 1, 0}, up);
    return normalize(Quat{axis.x, axis.y, axis.z, 1.0f + up.y});
  }
};

}  // namespace scree::testing
