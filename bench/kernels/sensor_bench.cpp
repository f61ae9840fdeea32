// What sensors cost: a step of 20,000 balls that drift without touching, with no sensor, with one around them
// all, and with 1,000 that see about 20 balls each.
#include <benchmark/benchmark.h>
#include <scree/scree.h>

#include <cmath>

namespace {

constexpr int kSide = 27;              // balls, along each axis, a meter apart
constexpr float kStep = 1.0f / 60.0f;  // s

void add_balls(scree::World& world) {
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const scree::Vec3 place{static_cast<float>(i % kSide), static_cast<float>(i / kSide % kSide),
                            static_cast<float>(i / (kSide * kSide))};
    const scree::BodyId ball = world.create_body({.position = place, .linear_velocity = {0.5f, 0, 0}});
    world.add_shape(ball, scree::Sphere{0.2f});
  }
}

// A cube of sensors, `count` along each axis, over the balls.
void add_sensors(scree::World& world, int count) {
  const float extent = 0.5f * kSide / static_cast<float>(count);
  const scree::BodyId body = world.create_body({.type = scree::BodyType::fixed});
  for (int i = 0; i < count * count * count; ++i) {
    const auto middle = [&](int place) { return extent * static_cast<float>(2 * place + 1) - 0.5f; };
    const scree::Vec3 place{middle(i % count), middle(i / count % count), middle(i / (count * count))};
    world.add_shape(body, scree::Box{{extent, extent, extent}}, {},
                    {.local_pose = {place, {}}, .sensor = true});
  }
}

// Argument: sensors along each axis.
void step_with_sensors(benchmark::State& state) {
  scree::World world{scree::WorldSettings{.gravity = {}, .sleeping = false}};
  scree::Workers workers(1);
  add_balls(world);
  if (state.range(0) > 0) add_sensors(world, static_cast<int>(state.range(0)));
  for (int i = 0; i < 3; ++i) scree::step(world, kStep, workers);
  for (auto _ : state) scree::step(world, kStep, workers);
}
BENCHMARK(step_with_sensors)->Arg(0)->Arg(1)->Arg(10)->Unit(benchmark::kMicrosecond)->Iterations(60);

}  // namespace
