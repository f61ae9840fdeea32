// A world with many resting bodies, and calls that change which bodies rest.
#pragma once

#include <tests/parallel/hand_made_world.h>

#include <scree/scree.h>

#include <cmath>
#include <vector>

namespace scree::testing {

// A field of fixed boxes about which balls fall, sleep and are pushed about.
class Field {
 public:
  Field(std::uint64_t seed, int boxes) : random_(seed), side_(static_cast<int>(std::sqrt(boxes))) {
    WorldSettings settings;
    settings.sleep_time = 0.1f;
    world = World(settings);
    world.add_shape(world.create_body({.type = BodyType::fixed, .position = {0, -2, 0}}),
                    Box{{1000, 1, 1000}});
    for (int i = 0; i < boxes; ++i) add_box();
  }

  void add_box() {
    const float x = static_cast<float>(random_.below(static_cast<std::uint32_t>(side_)));
    const float z = static_cast<float>(random_.below(static_cast<std::uint32_t>(side_)));
    fixed_.push_back(
        world.create_body({.type = BodyType::fixed, .position = {x, random_.uniform(-0.2f, 0.2f), z}}));
    world.add_shape(fixed_.back(), Box{{0.6f, 0.5f, 0.6f}});
    if (random_.below(8) == 0) {
      world.add_shape(fixed_.back(), Sphere{0.3f}, {}, {.local_pose = {{0, 0.6f, 0}, {}}});
    }
  }
  void add_ball() {
    const float reach = static_cast<float>(side_);
    balls_.push_back(world.create_body(
        {.position = {random_.uniform(0, reach), random_.uniform(1.0f, 2.0f), random_.uniform(0, reach)}}));
    static const std::vector<Vec3> kCorners{
        {-0.3f, 0, 0}, {0.3f, 0, 0}, {0, 0.4f, 0}, {0, 0, 0.4f}, {0.1f, 0.2f, -0.2f}};
    static const Hull kRoof(kCorners);
    const bool is_hull = hulls && random_.below(3) == 0;
    world.add_shape(balls_.back(), is_hull ? Geometry{ConvexHull{kRoof}} : Geometry{Sphere{0.3f}},
                    {.rolling_resistance = 0.05f});
  }
  // A call of every kind that changes which bodies rest.
  void change_something() {
    switch (random_.below(9)) {
      case 0:
        return add_box();
      case 1:
      case 2:
        return add_ball();
      case 3:
        if (fixed_.size() > 10) world.destroy_body(take(fixed_));
        return;
      case 4:
        if (balls_.size() > 40) world.destroy_body(take(balls_));
        return;
      case 5:
        if (fixed_.empty()) return;
        return world.set_pose(any(fixed_), {{random_.uniform(0, 5), 0.5f, random_.uniform(0, 5)}, {}});
      case 6:
        if (!balls_.empty()) world.set_linear_velocity(any(balls_), {1, 3, 0});
        return;
      case 7:
        if (!balls_.empty()) world.set_body_type(any(balls_), random_type());
        return;
      default:
        if (balls_.empty()) return;
        world.shapes_of(any(balls_), std::span(&shape_, 1));
        return world.set_filter(shape_, {.mask = random_.below(4) == 0 ? 0u : ~0u});
    }
  }

  World world;
  bool hulls = false;  // some shapes are hulls instead of balls

 private:
  BodyId any(const std::vector<BodyId>& list) {
    return list[random_.below(static_cast<std::uint32_t>(list.size()))];
  }
  BodyId take(std::vector<BodyId>& list) {
    const BodyId body = any(list);
    std::erase(list, body);
    return body;
  }
  BodyType random_type() {
    const BodyType types[] = {BodyType::fixed, BodyType::kinematic, BodyType::dynamic, BodyType::dynamic};
    return types[random_.below(4)];
  }

  Random random_;
  int side_;
  ShapeId shape_;
  std::vector<BodyId> fixed_, balls_;
};

}  // namespace scree::testing
