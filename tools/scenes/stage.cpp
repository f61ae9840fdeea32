// See stage.h.
#include <tools/scenes/digest.h>
#include <tools/scenes/stage.h>

#include <utility>

namespace scree::scenes {
namespace {

constexpr std::size_t kThrownStride = 7;

std::vector<Scene> with_events(std::vector<Scene> scenes, ContactEvents events) {
  for (Scene& scene : scenes) scene.settings.contact_events = events;
  return scenes;
}

}  // namespace

Stage::Stage(const std::vector<Scene>& scenes) {
  worlds_.reserve(scenes.size());
  for (const Scene& scene : scenes) {
    World& world = worlds_.emplace_back(scene.settings);
    casts_.push_back({script_of(scene), populate(world, scene)});
    pointers_.push_back(&world);
  }
}

Stage::Stage(std::vector<Scene> scenes, ContactEvents events)
    : Stage(with_events(std::move(scenes), events)) {}

std::size_t Stage::bodies() const {
  std::size_t count = 0;
  for (const World& world : worlds_) count += world.body_count();
  return count;
}

void Stage::advance(float dt, Workers& workers) {
  for (std::size_t i = 0; i < worlds_.size(); ++i) {
    direct(worlds_[i], casts_[i].script, casts_[i].bodies, steps_, dt);
  }
  step(pointers_, dt, workers);
  ++steps_;
}

void Stage::throw_up(Vec3 velocity) {
  for (std::size_t i = 0; i < worlds_.size(); ++i) {
    World& world = worlds_[i];
    for (std::size_t body = 0; body < casts_[i].bodies.size(); body += kThrownStride) {
      const BodyId id = casts_[i].bodies[body];
      if (world.is_alive(id) && world.body_type(id) == BodyType::dynamic) {
        world.set_linear_velocity(id, velocity);
      }
    }
  }
}

std::uint64_t hash_of(const std::vector<World>& worlds) {
  if (worlds.size() == 1) return worlds.front().hash();
  Digest digest;
  for (const World& world : worlds) digest.add(world.hash());
  return digest.value();
}

}  // namespace scree::scenes
