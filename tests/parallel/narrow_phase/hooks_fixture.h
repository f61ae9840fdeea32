// Worlds with hooks of contacts, shared by their tests.
#pragma once

#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace scree::hooks_test {

inline constexpr float kStep = 1.0f / 60.0f;
inline constexpr float kGravity = 9.81f;
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Hooked {
  explicit Hooked(const WorldSettings& settings = {.sleeping = false}, int threads = 1,
                  Isa isa = Isa::automatic)
      : world(settings), workers({threads, isa}) {}
  BodyId add(const BodyDef& def, const Geometry& geometry, const Material& material = {},
             ContactHooks hooks = ContactHooks::none) {
    const BodyId body = world.create_body(def);
    shapes.push_back(world.add_shape(body, geometry, material, {.contact_hooks = hooks}));
    return body;
  }
  BodyId add_floor(ContactHooks hooks, const Material& material = {}) {
    return add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{50, 1, 50}}, material, hooks);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kStep, workers);
  }

  World world;
  Workers workers;
  std::vector<ShapeId> shapes;
};

inline ContactFilter refuse_all() {
  return [](const ContactFilterBatch& batch) {
    std::fill(batch.collide.begin(), batch.collide.end(), std::uint8_t{0});
  };
}

// A rule that changes each contact by itself.
template <class Change>
ContactRule changing(Change change) {
  return [change](const ContactRuleBatch& batch) {
    for (ContactRules& rules : batch.rules) change(rules);
  };
}

// Boxes, balls, capsules and hulls that fall into a heap on a floor and a mesh that ask for both hooks.
struct Pile : Hooked {
  explicit Pile(int threads = 1, Isa isa = Isa::automatic) : Hooked({}, threads, isa) {
    add_floor(ContactHooks::all);
    const std::vector<Vec3> corners = {{-6, 1, -6}, {6, 1, -6}, {6, 1.5f, 6}, {-6, 0.2f, 6}};
    const std::vector<MeshTriangle> triangles = {{0, 2, 1}, {0, 3, 2}};
    add({.type = BodyType::fixed}, TriangleMesh(corners, triangles), {}, ContactHooks::all);
    for (int i = 0; i < 160; ++i) {
      const auto at = [i](int each) { return 1.1f * static_cast<float>(i / each % 5) - 2.2f; };
      const Vec3 position{at(1), 2.5f + 1.1f * static_cast<float>(i / 25), at(5)};
      const Geometry forms[] = {Box{{0.5f, 0.3f, 0.4f}}, Sphere{0.4f}, Capsule{0.3f, 0.25f},
                                ConvexHull{test::wedge()}};
      add({.position = position}, forms[i % 4], {.restitution = i % 3 == 0 ? 0.5f : 0.0f},
          i % 5 == 0 ? ContactHooks::all : ContactHooks::none);
    }
  }
};

// Answers that depend on the batch alone.
inline void set_lively_hooks(World& world) {
  const auto number = [](const HookedPair& pair) { return pair.shape_a.index + 3 * pair.shape_b.index; };
  world.set_contact_filter([number](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.collide[i] = number(batch.pairs[i]) % 11 == 0 ? 0 : 1;
  });
  world.set_contact_rule([number](const ContactRuleBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
      ContactRules& rules = batch.rules[i];
      const std::uint32_t kind = number(batch.pairs[i]) % 7;
      if (kind == 0) rules.acts = batch.contacts[i].points[0].separation > -0.05f;
      if (kind == 1) rules.friction = 0.1f;
      if (kind == 2) rules.restitution = 0.7f;
      if (kind == 3) rules.surface_velocity = {1, 0, 0.5f};
      if (kind == 4) rules.rolling_resistance = 0.05f;
      if (kind == 5) rules.friction = kNan;
    }
  });
}

}  // namespace scree::hooks_test
