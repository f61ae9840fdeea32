// Cost of waking, removing, putting to sleep or touching one body among many sleepers, and of waking all.
//
// Figures are medians over steps, with the call before them. On an Intel Xeon at 2.6 GHz, one thread, cores
// shared with other work, November 2026 (pairs at rest in one sorted list, in lists by shape), 200,000
// sleepers, us:
//                               no events     events of contacts
//   nothing happens             1.3    1.3     5800    1.3
//   a row of ten wakes         6700     16    15300     18
//   ... moves                   680     16     7400     17
//   ... falls asleep            6.3    2.9     6700    3.2
//   ... the step after that     126    5.9     6100    8.1
//   one is destroyed           7300     17    15700     18
//   all wake, ms                252    256
//   a pile of 20,000 wakes, ms  102     88
#include <benchmark/benchmark.h>
#include <scree/scree.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

namespace {

using scree::BodyId;

constexpr float kStep = 1.0f / 60.0f;  // s
constexpr int kRow = 10;               // boxes of an island

// Boxes on one floor; each island is a row of boxes side by side.
class Field {
 public:
  Field(std::int64_t count, int threads, bool events) : workers_(threads) {
    scree::WorldSettings settings;
    settings.sleep_time = 0.05f;
    if (events) settings.contact_events = scree::ContactEvents::begin_end;
    world = scree::World(settings);
    const auto rows = (count + kRow - 1) / kRow;
    const auto side = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(rows))));
    const float half = static_cast<float>(side) * 12.0f + 10.0f;
    floor = world.create_body({.type = scree::BodyType::fixed, .position = {0, -1, 0}});
    world.add_shape(floor, scree::Box{{half, 1.0f, half}});
    std::vector<scree::BodyDef> defs(static_cast<std::size_t>(rows * kRow));
    for (std::int64_t i = 0; i < rows * kRow; ++i) {
      const std::int64_t row = i / kRow;
      defs[static_cast<std::size_t>(i)].position = {
          12.0f * static_cast<float>(row % side - side / 2) + static_cast<float>(i % kRow), 0.5f,
          1.5f * static_cast<float>(row / side - side / 2)};
    }
    const std::vector<scree::Geometry> shapes(defs.size(), scree::Box{});
    boxes.resize(defs.size());
    world.create_bodies(defs, shapes, {}, {}, boxes);
    settle();
  }
  void step() { scree::step(world, kStep, workers_); }
  void settle() {
    int steps = 0;
    do {
      if (++steps > 120) throw std::runtime_error("the field does not fall asleep");
      step();
    } while (world.stats().awake_bodies > 0);
    step();
    step();
  }

  scree::World world;
  BodyId floor;
  std::vector<BodyId> boxes;

 private:
  scree::Workers workers_;
};

double microseconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

// Arguments: sleepers, threads, whether events are requested.
Field make_field(const benchmark::State& state) {
  return Field(state.range(0), static_cast<int>(state.range(1)), state.range(2) != 0);
}

// For a row of ten boxes: the step in which a call on one of its boxes wakes it, the steps in which it moves
// and falls asleep, and the step after.
void one_island(benchmark::State& state) {
  Field field = make_field(state);
  std::vector<double> wakes, moves, falls_asleep, rests, nothing;
  for (auto _ : state) {
    const std::size_t box = field.boxes.size() / 3 + 17 * wakes.size();
    nothing.push_back(microseconds_of([&] { field.step(); }));
    wakes.push_back(microseconds_of([&] {
      field.world.wake(field.boxes[box]);
      field.step();
    }));
    double last = 0.0;
    for (int i = 0; i < 200 && field.world.stats().awake_bodies > 0; ++i) {
      if (i > 0) moves.push_back(last);
      last = microseconds_of([&] { field.step(); });
    }
    falls_asleep.push_back(last);
    rests.push_back(microseconds_of([&] { field.step(); }));
  }
  state.counters["nothing_us"] = median(nothing);
  state.counters["wakes_us"] = median(wakes);
  state.counters["moves_us"] = median(moves);
  state.counters["falls_asleep_us"] = median(falls_asleep);
  state.counters["rests_us"] = median(rests);
}

void one_destroyed(benchmark::State& state) {
  Field field = make_field(state);
  std::vector<double> goes;
  for (auto _ : state) {
    const std::size_t box = field.boxes.size() / 3 + kRow * goes.size();
    goes.push_back(microseconds_of([&] {
      field.world.destroy_body(field.boxes[box]);
      field.step();
    }));
    field.settle();
  }
  state.counters["destroyed_us"] = median(goes);
}

// Moving the floor wakes all boxes; they fall asleep again.
void all(benchmark::State& state) {
  Field field = make_field(state);
  std::vector<double> wake, next, fall_asleep, rest;
  for (auto _ : state) {
    wake.push_back(microseconds_of([&] {
      field.world.set_pose(field.floor, {{0, -1, 0}, {}});
      field.step();
    }));
    double last = microseconds_of([&] { field.step(); });
    next.push_back(last);
    for (int i = 0; i < 200 && field.world.stats().awake_bodies > 0; ++i) {
      last = microseconds_of([&] { field.step(); });
    }
    fall_asleep.push_back(last);
    rest.push_back(microseconds_of([&] { field.step(); }));
  }
  state.counters["wake_ms"] = 1e-3 * median(wake);
  state.counters["next_ms"] = 1e-3 * median(next);
  state.counters["fall_asleep_ms"] = 1e-3 * median(fall_asleep);
  state.counters["rest_ms"] = 1e-3 * median(rest);
}

// One pile of `sleepers` balls and boxes that falls asleep as one island; a call wakes one of its boxes.
void whole_pile(benchmark::State& state) {
  scree::WorldSettings settings;
  settings.sleep_time = 0.05f;
  scree::World world(settings);
  scree::Workers workers(static_cast<int>(state.range(1)));
  world.add_shape(world.create_body({.type = scree::BodyType::fixed, .position = {0, -1, 0}}),
                  scree::Box{{100, 1, 100}});
  const auto side = static_cast<std::int64_t>(std::cbrt(static_cast<double>(state.range(0))));
  std::vector<BodyId> boxes;
  for (std::int64_t i = 0; i < side * side * side; ++i) {
    boxes.push_back(world.create_body(
        {.position = {static_cast<float>(i % side), 0.5f + static_cast<float>(i / side / side),
                      static_cast<float>(i / side % side)}}));
    world.add_shape(boxes.back(), scree::Box{});
  }
  std::vector<double> wake, fall_asleep, rest;
  double last = 0.0;
  const auto settle = [&] {
    for (int i = 0; i < 600 && (i == 0 || world.stats().awake_bodies > 0); ++i)
      last = microseconds_of([&] { scree::step(world, kStep, workers); });
    if (world.stats().awake_bodies > 0) throw std::runtime_error("the pile does not fall asleep");
    rest.push_back(microseconds_of([&] { scree::step(world, kStep, workers); }));
  };
  settle();
  for (auto _ : state) {
    wake.push_back(microseconds_of([&] {
      world.wake(boxes[boxes.size() / 2]);
      scree::step(world, kStep, workers);
    }));
    settle();
    fall_asleep.push_back(last);
  }
  state.counters["wakes_ms"] = 1e-3 * median(wake);
  state.counters["falls_asleep_ms"] = 1e-3 * median(fall_asleep);
  state.counters["rests_ms"] = 1e-3 * median(rest);
}

BENCHMARK(one_island)->Args({200000, 1, 0})->Args({200000, 1, 1})->Iterations(41);
BENCHMARK(one_destroyed)->Args({200000, 1, 0})->Args({200000, 1, 1})->Iterations(21);
BENCHMARK(all)->Args({200000, 1, 0})->Args({200000, 4, 0})->Args({200000, 1, 1})->Iterations(7);
BENCHMARK(whole_pile)->Args({20000, 1})->Args({20000, 4})->Iterations(11);

}  // namespace
