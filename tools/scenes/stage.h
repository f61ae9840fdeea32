// A stage: the worlds of a scene and their driven bodies, played step by step.
#pragma once

#include <tools/scenes/scene.h>

#include <cstdint>
#include <vector>

namespace scree::scenes {

class Stage {
 public:
  explicit Stage(const std::vector<Scene>& scenes);
  /// Worlds that report contacts as `events` says, whatever their scenes say.
  Stage(std::vector<Scene> scenes, ContactEvents events);

  std::vector<World>& worlds() { return worlds_; }
  const std::vector<World>& worlds() const { return worlds_; }
  std::size_t bodies() const;  ///< of all worlds
  int steps() const { return steps_; }

  /// Makes the changes of bodies, moves the driven ones and steps all worlds.
  void advance(float dt, Workers& workers);
  /// Throws every seventh body up, so that sleeping bodies wake and standing structures collapse.
  void throw_up(Vec3 velocity);

 private:
  struct Cast {
    Scene script;
    std::vector<BodyId> bodies;
  };

  std::vector<World> worlds_;  // never resized: pointers_ and recorders point to them
  std::vector<Cast> casts_;
  std::vector<World*> pointers_;
  int steps_ = 0;
};

/// World::hash of one world; of several, the digest of theirs in order.
std::uint64_t hash_of(const std::vector<World>& worlds);

}  // namespace scree::scenes
