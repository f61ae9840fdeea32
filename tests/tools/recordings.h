// Recordings for tests of programs that read them: valid ones, and one that no world can repeat.
#pragma once

#include <core/world/world_data.h>
#include <scree/recording.h>
#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <string>

namespace scree::testing {

/// Where a body changes behind the recorder's back; 0: nowhere.
struct Tampering {
  int step = 0;
  std::uint32_t body = kFirstBody + 3;  ///< its index
};

/// A stack of boxes, on which a ball falls at the tenth step; keyframes 20 steps apart.
inline void record_stack(const std::string& file, int steps, const Tampering& tampering = {},
                         float ball_speed = -10.0f) {
  const scenes::Scene scene = scenes::build("stack", {{"bodies", 5}}).front();
  World world(scene.settings);
  scenes::populate(world, scene);
  Workers workers(WorkersOptions{.threads = 1});
  Recorder recorder(world, file, {.keyframe_spacing = 20});
  for (int i = 1; i <= steps; ++i) {
    if (i == 10) {
      const BodyId ball =
          world.create_body({.position = {0.2f, 8.0f, 0.0f}, .linear_velocity = {0.0f, ball_speed, 0.0f}});
      world.add_shape(ball, Sphere{0.5f});
    }
    // A recorder sees calls. A change without a call happens once and never again.
    if (i == tampering.step) internals(world).bodies.velocity[tampering.body].linear[0] += 1.0f;
    step(world, 1.0f / 60.0f, workers);
  }
  recorder.finish();
}

}  // namespace scree::testing
