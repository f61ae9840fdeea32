// Queries: rays, casts, overlaps and distances in a pile of 100,000 mixed bodies, per instruction set, asked
// one by one and by many on one and two threads; and what the first query after a step or a call costs.
//
// The pile is a cube as dense as one at rest: boxes, spheres, capsules and hulls of 0.4 to 1.0 m at random
// places and turns. Rays go 100 m from random places; most meet a body within some meters. parallel/queries
// has the figures.
#include <benchmark/benchmark.h>
#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <cmath>
#include <memory>
#include <vector>

namespace {

using scree::scenes::Random;

constexpr int kBodies = 100000;
constexpr int kQueries = 4096;
constexpr float kStep = 1.0f / 60.0f;  // s
constexpr float kRayLength = 100.0f;   // m

scree::Vec3 point(Random& random, float reach) {
  const float x = random.between(-reach, reach);
  const float y = random.between(-reach, reach);
  const float z = random.between(-reach, reach);
  return {x, y, z};
}

scree::Geometry geometry(Random& random) {
  static const scree::Hull kRock = [] {
    Random points_of(5);
    std::vector<scree::Vec3> points;
    for (int i = 0; i < 40; ++i) points.push_back(point(points_of, 0.5f));
    return scree::Hull(points);
  }();
  const float size = random.between(0.2f, 0.5f);
  switch (random.below(4)) {
    case 0:
      return scree::Sphere{size};
    case 1:
      return scree::Capsule{size, 0.5f * size};
    case 2:
      return scree::Box{{size, 0.8f * size, 0.6f * size}};
    default:
      return scree::ConvexHull{kRock};  // one for all: a hull of each body's own would mostly be memory
  }
}

struct Pile {
  scree::World world{scree::WorldSettings{.gravity = {}}};
  float reach = 0.0f;
  std::vector<scree::Ray> rays;
  std::vector<scree::ShapeCast> casts;
  std::vector<scree::Vec3> points;

  explicit Pile(int bodies, scree::BodyType type) {
    Random random(1);
    reach = 0.5f * std::cbrt(static_cast<float>(bodies) * 0.8f);
    for (int i = 0; i < bodies; ++i) {
      const scree::BodyId body = world.create_body({.type = type,
                                                    .position = point(random, reach),
                                                    .rotation = random.rotation(),
                                                    .linear_velocity = {5, 0, 0}});
      world.add_shape(body, geometry(random), {}, {.filter = {.mask = 0}});
    }
    for (int i = 0; i < kQueries; ++i) {
      const scree::Vec3 origin = point(random, 1.5f * reach);
      const scree::Vec3 target = point(random, reach);
      rays.push_back({origin, kRayLength * normalize(target - origin)});
      casts.push_back({scree::Sphere{0.3f}, {origin, {}}, rays.back().translation});
      points.push_back(target);
    }
    scree::Workers workers(1);
    scree::step(world, kStep, workers);
    cast_ray(world, rays[0]);
  }
};

Pile& fixed_pile() {
  static Pile pile(kBodies, scree::BodyType::fixed);
  return pile;
}

void count(benchmark::State& state) {
  state.counters["queries/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kQueries, benchmark::Counter::kIsRate);
}

// Asks ask(i) for every query.
template <class Ask>
void ask_singly(benchmark::State& state, Ask&& ask) {
  for (auto _ : state) {
    for (std::size_t i = 0; i < kQueries; ++i) benchmark::DoNotOptimize(ask(i));
  }
  count(state);
}

void single_rays(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) { return cast_ray(pile.world, pile.rays[i]); });
}
BENCHMARK(single_rays)->Unit(benchmark::kMillisecond)->UseRealTime();

void single_any(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) { return is_blocked(pile.world, pile.rays[i]); });
}
BENCHMARK(single_any)->Unit(benchmark::kMillisecond)->UseRealTime();

void single_all(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) { return cast_ray_all(pile.world, pile.rays[i]).size(); });
}
BENCHMARK(single_all)->Unit(benchmark::kMillisecond)->UseRealTime();

void single_casts(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) { return cast_shape(pile.world, pile.casts[i]); });
}
BENCHMARK(single_casts)->Unit(benchmark::kMillisecond)->UseRealTime();

void single_overlaps(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) {
    return overlap_shape(pile.world, {scree::Box{}, {pile.points[i], {}}}).size();
  });
}
BENCHMARK(single_overlaps)->Unit(benchmark::kMillisecond)->UseRealTime();

void single_closest(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  ask_singly(state, [&](std::size_t i) { return closest_to_point(pile.world, pile.points[i], 10.0f); });
}
BENCHMARK(single_closest)->Unit(benchmark::kMillisecond)->UseRealTime();

// Arguments: threads, instruction set.
void many_rays(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  const auto isa = static_cast<scree::Isa>(state.range(1));
  if (!is_supported(isa)) return state.SkipWithError("not supported");
  scree::Workers workers({.threads = static_cast<int>(state.range(0)), .isa = isa});
  std::vector<std::optional<scree::CastHit>> hits(kQueries);
  for (auto _ : state) cast_rays(pile.world, pile.rays, hits, workers);
  count(state);
  state.SetLabel(isa_name(isa));
}
BENCHMARK(many_rays)->ArgsProduct({{1, 2}, {1, 2, 3, 4}})->Unit(benchmark::kMillisecond)->UseRealTime();

void many_casts(benchmark::State& state) {
  const Pile& pile = fixed_pile();
  scree::Workers workers(static_cast<int>(state.range(0)));
  std::vector<std::optional<scree::CastHit>> hits(kQueries);
  for (auto _ : state) cast_shapes(pile.world, pile.casts, hits, workers);
  count(state);
}
BENCHMARK(many_casts)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// The first query after a step in which every body moves. Argument: bodies.
void after_a_step(benchmark::State& state) {
  Pile pile(static_cast<int>(state.range(0)), scree::BodyType::kinematic);
  scree::Workers workers(1);
  for (auto _ : state) {
    state.PauseTiming();
    scree::step(pile.world, kStep, workers);
    state.ResumeTiming();
    benchmark::DoNotOptimize(cast_ray(pile.world, pile.rays[0]));
  }
}
BENCHMARK(after_a_step)->Arg(10000)->Arg(100000)->Unit(benchmark::kMicrosecond)->Iterations(30);

// A call that moves a fixed body, and a query. Argument: bodies.
void after_a_call(benchmark::State& state) {
  Pile pile(static_cast<int>(state.range(0)), scree::BodyType::fixed);
  const scree::BodyId body = pile.world.body_at(100);
  float at = 0.0f;
  for (auto _ : state) {
    pile.world.set_pose(body, {{0, at += 0.001f, 0}, {}});
    benchmark::DoNotOptimize(cast_ray(pile.world, pile.rays[0]));
  }
}
BENCHMARK(after_a_call)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMicrosecond)->Iterations(2000);

}  // namespace
