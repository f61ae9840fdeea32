// A small world with something of everything, for tests that damage it: bodies that are awake, asleep, fixed
// and kinematic, one of three shapes, a row of boxes with joints, contacts that move and others that rest.
#pragma once

#include <core/world/world_data.h>
#include <scree/scree.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace scree::test {

inline constexpr float kDt = 1.0f / 60.0f;

class DamagedWorld : public testing::Test {
 protected:
  World world{{.sleep_time = 0.1f, .contact_events = ContactEvents::begin_end}};
  WorldData& data = internals(world);
  Workers workers{1};
  BodyId floor, kinematic, compound, sleepers[3], boxes[4];
  std::vector<JointId> joints;

  void SetUp() override {
    floor = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
    world.add_shape(floor, Box{{50, 1, 50}});
    kinematic = world.create_body({.type = BodyType::kinematic, .position = {20, 5, 0}});
    world.add_shape(kinematic, Box{{1, 1, 1}});
    world.set_linear_velocity(kinematic, {0.1f, 0, 0});
    for (int i = 0; i < 3; ++i) {
      sleepers[i] = world.create_body({.position = {10, 0.5f + static_cast<float>(i), 0}});
      world.add_shape(sleepers[i], Box{{0.5f, 0.5f, 0.5f}});
    }
    for (int i = 0; i < 4; ++i) {
      boxes[i] = world.create_body({.position = {0, 0.5f + static_cast<float>(i), 0}, .can_sleep = false});
      world.add_shape(boxes[i], Box{{0.5f, 0.5f, 0.5f}});
    }
    compound = world.create_body({.position = {-5, 0.5f, 0}, .can_sleep = false});
    for (const float x : {-1.0f, 0.0f, 1.0f}) {
      world.add_shape(compound, Sphere{0.5f}, {}, {.local_pose = {{x, 0, 0}, {}}});
    }
    for (int i = 0; i < 2; ++i) {
      joints.push_back(world.create_joint({.body_a = boxes[i],
                                           .body_b = boxes[i + 1],
                                           .frame_a = {{0, 0.5f, 0}, {}},
                                           .frame_b = {{0, -0.5f, 0}, {}},
                                           .collide_connected = true},
                                          BallJoint{}));
    }
    for (int i = 0; i < 60; ++i) step(world, kDt, workers);
    ASSERT_GT(data.bodies.asleep, 0);
    ASSERT_FALSE(data.contacts.resting.pair.empty());
    ASSERT_FALSE(data.contacts.active.empty());
    ASSERT_EQ(data.joints.active.size(), 2u);
  }

  static std::int32_t row_of(BodyId body) { return static_cast<std::int32_t>(body.index); }
  std::int32_t shape_of(BodyId body) const { return data.bodies.first_shape[body.index]; }
  bool rests(const ShapePair& pair) const {
    return data.shapes.tree[pair.a] == TreeKind::frozen && data.shapes.tree[pair.b] == TreeKind::frozen;
  }
  // Rows of two pairs that move and touch.
  std::pair<std::size_t, std::size_t> two_contacts() const {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < data.contacts.pairs.pair.size(); ++row) {
      if (data.contacts.pairs.contact[row] >= 0) rows.push_back(row);
    }
    return {rows.at(0), rows.at(1)};
  }
};

}  // namespace scree::test
