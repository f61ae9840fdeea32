// Mischief: random calls between the steps of a scene.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <cstdint>
#include <vector>

namespace scree::soak {

class Mischief {
 public:
  /// About one step in `pause` is preceded by a call.
  Mischief(std::uint64_t seed, std::uint32_t pause) : random_(seed), pause_(pause) {}

  /// Perhaps makes a call, or a few.
  void before_step(World& world);
  std::int64_t calls() const { return calls_; }

 private:
  void make_call(World& world);
  void create(World& world);
  void create_many(World& world);
  void destroy(World& world);
  void push(World& world, BodyId body);
  void change_body(World& world, BodyId body);
  void change_shape(World& world, BodyId body);
  void change_settings(World& world);
  void make_wrong_call(World& world, BodyId body);
  void keep_or_restore(World& world);

  BodyDef random_def();
  Geometry random_geometry();
  Vec3 random_vector(float reach);
  /// A moving body that no scene drives; no body if none is found.
  BodyId random_body(const World& world);

  scenes::Random random_;
  std::uint32_t pause_;
  std::int64_t calls_ = 0;
  Snapshot kept_;
};

}  // namespace scree::soak
