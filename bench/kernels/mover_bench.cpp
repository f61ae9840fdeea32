// Movers: what a move costs where one stands, walks, slides along a wall, climbs stairs, and wanders over a
// pile of 5,000 mixed bodies that have come to rest. parallel/mover has the figures.
#include <benchmark/benchmark.h>
#include <scree/scree.h>
#include <tools/scenes/random.h>
#include <tools/scenes/scene.h>

#include <vector>

namespace {

using scree::Vec3;

constexpr float kStep = 1.0f / 60.0f;  // s

float standing() {
  const scree::MoverSettings settings;
  return settings.half_height + settings.radius + settings.skin;
}

void add_box(scree::World& world, Vec3 center, Vec3 half_extents) {
  world.add_shape(world.create_body({.type = scree::BodyType::fixed, .position = center}),
                  scree::Box{half_extents});
}

// A floor, a wall along x at z = 2, and stairs from x = 100 on.
scree::World& course() {
  static scree::World world = [] {
    scree::World made;
    add_box(made, {0, -1, 0}, {1000, 1, 1000});
    add_box(made, {0, 5, 3}, {90, 5, 1});
    for (int i = 0; i < 100; ++i) {
      const float top = 0.2f * static_cast<float>(i + 1);
      add_box(made, {100.0f + 0.4f * static_cast<float>(i) + 50.0f, top - 0.1f, 0}, {50, 0.1f, 5});
    }
    return made;
  }();
  return world;
}

// Moves from `place` with a velocity, and begins again after so many moves.
void go(benchmark::State& state, Vec3 place, Vec3 velocity, int moves) {
  scree::World& world = course();
  const scree::MoverSettings settings;
  scree::MoverState start{.position = place};
  scree::move(world, start, settings, {}, kStep);
  scree::MoverState mover = start;
  int done = 0;
  for (auto _ : state) {
    if (done++ == moves) {
      mover = start;
      done = 0;
    }
    scree::move(world, mover, settings, velocity, kStep);
  }
}

void stands(benchmark::State& state) { go(state, {-95, standing(), 0}, {}, 1000); }
void walks(benchmark::State& state) { go(state, {-95, standing(), -5}, {3, 0, 0}, 1000); }
void slides_along_a_wall(benchmark::State& state) { go(state, {-85, standing(), 1.6f}, {3, 0, 1}, 1000); }
void climbs_stairs(benchmark::State& state) { go(state, {99, standing(), 0}, {3, 0, 0}, 700); }
BENCHMARK(stands)->Unit(benchmark::kMicrosecond);
BENCHMARK(walks)->Unit(benchmark::kMicrosecond);
BENCHMARK(slides_along_a_wall)->Unit(benchmark::kMicrosecond);
BENCHMARK(climbs_stairs)->Unit(benchmark::kMicrosecond);

// Movers that fall onto the pile and wander; they push nothing, so that it rests.
void wanders_over_a_pile(benchmark::State& state) {
  const scree::scenes::Scene scene = scree::scenes::build("pile", {{"bodies", 5000}}).front();
  scree::World world(scene.settings);
  populate(world, scene);
  scree::Workers workers;
  for (int i = 0; i < 400; ++i) scree::step(world, kStep, workers);
  const scree::MoverSettings settings{.push_force = 0.0f, .mass = 0.0f};
  scree::scenes::Random random(1);
  std::vector<scree::MoverState> movers(16);
  std::vector<Vec3> wishes(movers.size());
  float top = 0.0f;
  for (const scree::Pose& pose : world.poses()) top = pose.position.y > top ? pose.position.y : top;
  for (std::size_t k = 0; k < movers.size(); ++k) {
    const float x = random.between(-3.0f, 3.0f), z = random.between(-3.0f, 3.0f);
    movers[k].position = {x, top + 2.0f, z};
  }
  std::size_t moves = 0, on_ground = 0;
  for (auto _ : state) {
    const std::size_t k = moves % movers.size();
    scree::MoverState& mover = movers[k];
    if (moves / movers.size() % 30 == 0) {
      const float x = random.between(-4.0f, 4.0f), z = random.between(-4.0f, 4.0f);
      wishes[k] = {x - 0.2f * mover.position.x, 0, z - 0.2f * mover.position.z};
    }
    Vec3 wanted = wishes[k];
    if (mover.ground != scree::MoverGround::firm) wanted.y = mover.velocity.y - 9.81f * kStep;
    scree::move(world, mover, settings, wanted, kStep);
    on_ground += mover.ground == scree::MoverGround::firm ? 1 : 0;
    ++moves;
  }
  state.counters["on ground"] = static_cast<double>(on_ground) / static_cast<double>(moves);
}
BENCHMARK(wanders_over_a_pile)->Unit(benchmark::kMicrosecond);

}  // namespace
