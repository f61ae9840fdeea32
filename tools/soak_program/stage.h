// A stage: the worlds of a scene and what drives them, played step by step.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <cstdint>
#include <vector>

namespace scree::soak {

class Stage {
 public:
  explicit Stage(const std::vector<scenes::Scene>& scenes);

  std::vector<World>& worlds() { return worlds_; }
  std::size_t bodies() const;  ///< of all worlds
  int steps() const { return steps_; }

  /// Moves the driven bodies and steps all worlds.
  void advance(float dt, Workers& workers);
  /// Every seventh body flies up: sleepers wake, and what has settled collides once more.
  void throw_up();

 private:
  struct Cast {
    std::vector<scenes::SceneDrive> drives;
    std::vector<BodyId> bodies;
  };

  std::vector<World> worlds_;  // never moved: recorders hold on to them
  std::vector<Cast> casts_;
  std::vector<World*> pointers_;
  int steps_ = 0;
};

}  // namespace scree::soak
