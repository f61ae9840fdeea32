// See stage.h.
#include <tools/soak_program/stage.h>

namespace scree::soak {
namespace {

constexpr float kThrow = 5.0f;  // m/s

}  // namespace

Stage::Stage(const std::vector<scenes::Scene>& scenes) {
  worlds_.reserve(scenes.size());
  for (const scenes::Scene& scene : scenes) {
    World& world = worlds_.emplace_back(scene.settings);
    casts_.push_back({scene.drives, scenes::populate(world, scene)});
    pointers_.push_back(&world);
  }
}

std::size_t Stage::bodies() const {
  std::size_t count = 0;
  for (const World& world : worlds_) count += world.body_count();
  return count;
}

void Stage::advance(float dt, Workers& workers) {
  for (std::size_t i = 0; i < worlds_.size(); ++i) {
    scenes::drive(worlds_[i], casts_[i].drives, casts_[i].bodies, steps_, dt);
  }
  if (worlds_.size() == 1) {
    step(worlds_.front(), dt, workers);
  } else {
    step(pointers_, dt, workers);
  }
  ++steps_;
}

void Stage::throw_up() {
  for (std::size_t i = 0; i < worlds_.size(); ++i) {
    World& world = worlds_[i];
    for (std::size_t body = 0; body < casts_[i].bodies.size(); body += 7) {
      const BodyId id = casts_[i].bodies[body];
      if (world.is_alive(id) && world.body_type(id) == BodyType::dynamic) {
        world.set_linear_velocity(id, {0.0f, kThrow, 0.0f});
      }
    }
  }
}

}  // namespace scree::soak
