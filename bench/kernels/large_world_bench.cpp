// What one change costs in a world of many fixed boxes: a step after nothing, after a ball was created, fell
// asleep or woke, after a fixed box was created, destroyed or moved; and creating the world.
//
// Each figure is that of the call and the step that follows it. Includes the same for Box3D, if CMake found
// it.
//
// Medians on an Intel Xeon at 2.6 GHz, one thread, cores shared with other work, 1,000,000 boxes, us,
// November 2026 (Scree before frozen shapes stood in several trees, Scree, Box3D):
//   nothing        1.1   1.1   0.28
//   ball flies     8.2   2.2   2.0
//   ball sleeps   2211   1.8   3.1
//   ball wakes   25321   7.9   3.2
//   box created  22687   2.3   5.4
//   box destroyed 24621  6.6   6.3
//   box moved    22323   7.5   7.5
//   create and two steps, ms: 1412, 703, 1452; from one call 602, 557
//
// Snapshots, us a save after a step, of 10,000 and 1,000,000 boxes, after nothing, of a flying ball, after a
// box was destroyed: 0.7, 1.5, 6.1 and 15, 17, 47 (34,000 while each save copied all); what changed is 0.3,
// 0.9 and 2.2 KB (430 KB while it was told by column), which takes 0.6 to 1.5 us to keep and 6 to 10 to
// apply.
#include <benchmark/benchmark.h>
#include <scree/scree.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#ifdef SCREE_BENCH_BOX3D
#include <box3d/box3d.h>
#endif

namespace {

constexpr float kStep = 1.0f / 60.0f;  // s
constexpr float kSpacing = 2.0f;       // m, between the centers of boxes of 1 m

struct Place {
  float x, y, z;
};

// A square field of boxes whose tops are y = 0.5.
Place place_of(std::int64_t i, std::int64_t count) {
  const auto side = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  return {kSpacing * static_cast<float>(i % side - side / 2), 0.0f,
          kSpacing * static_cast<float>(i / side - side / 2)};
}

// Operations that the changes need from an engine. Balls and boxes are numbered in the order of their
// creation.
class Scene {
 public:
  virtual ~Scene() = default;
  virtual void add_field(std::int64_t count, bool bulk) = 0;
  virtual void add_ball(Place place) = 0;
  virtual void add_box(Place place) = 0;
  virtual void destroy_box(std::size_t box) = 0;
  virtual void move_box(std::size_t box, Place place) = 0;
  virtual void wake_ball(std::size_t ball) = 0;
  virtual bool anybody_awake() = 0;
  virtual void step() = 0;
};

class ScreeScene final : public Scene {
 public:
  ScreeScene() {
    scree::WorldSettings settings;
    settings.sleep_time = 0.1f;
    world_ = scree::World(settings);
  }
  void add_field(std::int64_t count, bool bulk) override {
    const auto first = boxes_.size();
    boxes_.reserve(first + static_cast<std::size_t>(2 * count));  // for boxes created later
    boxes_.resize(first + static_cast<std::size_t>(count));
    if (!bulk) {
      for (std::int64_t i = 0; i < count; ++i) {
        boxes_[first + static_cast<std::size_t>(i)] = make_box(place_of(i, count));
      }
      return;
    }
    std::vector<scree::BodyDef> defs(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) {
      const Place p = place_of(i, count);
      defs[static_cast<std::size_t>(i)] = {.type = scree::BodyType::fixed, .position = {p.x, p.y, p.z}};
    }
    const std::vector<scree::Geometry> shapes(defs.size(), scree::Box{});
    world_.create_bodies(defs, shapes, {}, {}, std::span(boxes_).subspan(first));
  }
  void add_ball(Place p) override {
    balls_.push_back(world_.create_body({.position = {p.x, p.y, p.z}}));
    world_.add_shape(balls_.back(), scree::Sphere{0.25f});
  }
  void add_box(Place p) override { boxes_.push_back(make_box(p)); }
  void destroy_box(std::size_t box) override { world_.destroy_body(boxes_[box]); }
  void move_box(std::size_t box, Place p) override { world_.set_pose(boxes_[box], {{p.x, p.y, p.z}, {}}); }
  void wake_ball(std::size_t ball) override { world_.wake(balls_[ball]); }
  bool anybody_awake() override { return world_.stats().awake_bodies > 0; }
  void step() override { scree::step(world_, kStep, workers_); }
  const scree::World& world() const { return world_; }

 private:
  scree::BodyId make_box(Place p) {
    const scree::BodyId id =
        world_.create_body({.type = scree::BodyType::fixed, .position = {p.x, p.y, p.z}});
    world_.add_shape(id, scree::Box{});
    return id;
  }
  scree::World world_;
  scree::Workers workers_{1};
  std::vector<scree::BodyId> boxes_, balls_;
};

#ifdef SCREE_BENCH_BOX3D
class Box3dScene final : public Scene {
 public:
  Box3dScene() {
    b3WorldDef def = b3DefaultWorldDef();
    def.workerCount = 1;
    world_ = b3CreateWorld(&def);
  }
  ~Box3dScene() override { b3DestroyWorld(world_); }
  void add_field(std::int64_t count, bool) override {
    for (std::int64_t i = 0; i < count; ++i) add_box(place_of(i, count));
  }
  void add_ball(Place p) override {
    b3BodyDef def = b3DefaultBodyDef();
    def.type = b3_dynamicBody;
    def.position = {p.x, p.y, p.z};
    balls_.push_back(b3CreateBody(world_, &def));
    const b3ShapeDef shape = b3DefaultShapeDef();
    const b3Sphere sphere{{0.0f, 0.0f, 0.0f}, 0.25f};
    b3CreateSphereShape(balls_.back(), &shape, &sphere);
  }
  void add_box(Place p) override {
    b3BodyDef def = b3DefaultBodyDef();
    def.position = {p.x, p.y, p.z};
    boxes_.push_back(b3CreateBody(world_, &def));
    const b3ShapeDef shape = b3DefaultShapeDef();
    const b3BoxHull hull = b3MakeBoxHull(0.5f, 0.5f, 0.5f);
    b3CreateHullShape(boxes_.back(), &shape, &hull.base);
  }
  void destroy_box(std::size_t box) override { b3DestroyBody(boxes_[box]); }
  void move_box(std::size_t box, Place p) override {
    b3Body_SetTransform(boxes_[box], {p.x, p.y, p.z}, b3Quat_identity);
  }
  void wake_ball(std::size_t ball) override { b3Body_SetAwake(balls_[ball], true); }
  bool anybody_awake() override { return b3World_GetAwakeBodyCount(world_) > 0; }
  void step() override { b3World_Step(world_, kStep, 4); }

 private:
  b3WorldId world_;
  std::vector<b3BodyId> boxes_, balls_;
};
#endif

using Make = std::function<std::unique_ptr<Scene>()>;

double milliseconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void settle(Scene& scene) {
  for (int i = 0; i < 2000 && (i < 3 || scene.anybody_awake()); ++i) scene.step();
}

// Random places without clusters, the same for every engine.
std::int64_t pick(int i, std::int64_t count) { return (static_cast<std::int64_t>(i) * 7919 + 101) % count; }

void report(benchmark::State& state, std::vector<double> times) {
  double total = 0.0;
  for (const double time : times) total += time;
  std::sort(times.begin(), times.end());
  state.SetIterationTime(1e-3 * total / static_cast<double>(times.size()));
  state.counters["median_us"] = 1e3 * times[times.size() / 2];
  state.counters["worst_us"] = 1e3 * times.back();
}

constexpr int kChanges = 200;

enum class Change { nothing, ball_flies, ball_sleeps, ball_wakes, box_created, box_destroyed, box_moved };

void run(benchmark::State& state, const Make& make, Change change) {
  const std::int64_t count = state.range(0);
  const auto scene = make();
  scene->add_field(count, true);
  settle(*scene);
  if (change == Change::ball_flies) scene->add_ball({0.0f, 1000.0f, 0.0f});
  const int balls = change == Change::ball_wakes || change == Change::ball_sleeps ? kChanges : 1;
  if (change != Change::ball_flies) {
    for (int i = 0; i < balls; ++i) {
      Place place = place_of(pick(i, count), count);
      place.y = 0.75f;
      scene->add_ball(place);
    }
    settle(*scene);
  }
  for (auto _ : state) {
    std::vector<double> times;
    for (int i = 0; i < kChanges; ++i) {
      const auto index = static_cast<std::size_t>(pick(i + 1000, count));
      Place place = place_of(static_cast<std::int64_t>(index), count);
      place.y = 1.5f;
      if (change == Change::ball_sleeps) {
        scene->wake_ball(static_cast<std::size_t>(i));
        for (int k = 0; k < 200 && (k < 1 || scene->anybody_awake()); ++k) {
          times.push_back(milliseconds_of([&] { scene->step(); }));
        }
        const double last = times.back();  // the step in which the ball fell asleep
        times.resize(static_cast<std::size_t>(i));
        times.push_back(last);
        continue;
      }
      times.push_back(milliseconds_of([&] {
        if (change == Change::ball_wakes) scene->wake_ball(static_cast<std::size_t>(i));
        if (change == Change::box_created) scene->add_box(place);
        if (change == Change::box_destroyed) scene->destroy_box(index);
        if (change == Change::box_moved) scene->move_box(index, place);
        scene->step();
      }));
      if (change == Change::ball_wakes) settle(*scene);
    }
    report(state, times);
  }
}

// Resident memory of the process.
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  file >> total >> resident;
  return 4096.0 * resident;
}

void run_create(benchmark::State& state, const Make& make, bool bulk) {
  for (auto _ : state) {
    const double before = resident_bytes();
    const auto scene = make();
    const double create = milliseconds_of([&] { scene->add_field(state.range(0), bulk); });
    const double first = milliseconds_of([&] { scene->step(); });
    const double second = milliseconds_of([&] { scene->step(); });
    state.SetIterationTime(1e-3 * (create + first + second));
    state.counters["resident_bytes"] = (resident_bytes() - before) / static_cast<double>(state.range(0));
    state.counters["create_ms"] = create;
    state.counters["first_step_ms"] = first;
    state.counters["second_step_ms"] = second;
    if (const auto* scree_scene = dynamic_cast<const ScreeScene*>(scene.get())) {
      const scree::MemoryUse use = scree_scene->world().memory_use();
      const auto per_body = [&](std::size_t bytes) {
        return static_cast<double>(bytes) / static_cast<double>(state.range(0));
      };
      state.counters["state_bytes"] = per_body(use.state);
      state.counters["derived_bytes"] = per_body(use.derived);
      state.counters["scratch_bytes"] = per_body(use.scratch);
    }
  }
}

// Snapshots of a window that follows the world: after each change comes a step, then a save into the oldest
// snapshot. Compares each snapshot with the first.
void run_snapshot(benchmark::State& state, Change change) {
  constexpr std::size_t kWindow = 8;
  const std::int64_t count = state.range(0);
  ScreeScene scene;
  scene.add_field(count, true);
  settle(scene);
  if (change == Change::ball_flies) scene.add_ball({0.0f, 1000.0f, 0.0f});
  scene.step();
  scree::Snapshot base, again;
  scree::SnapshotChanges changes;
  std::vector<scree::Snapshot> window(kWindow);
  for (auto _ : state) {
    state.counters["first_save_ms"] = milliseconds_of([&] { scree::save(scene.world(), base); });
    for (scree::Snapshot& snapshot : window) scree::save(scene.world(), snapshot);
    std::vector<double> save_us, keep_us, apply_us, bytes;
    for (int i = 0; i < kChanges; ++i) {
      if (change == Change::box_destroyed) scene.destroy_box(static_cast<std::size_t>(pick(i, count)));
      scene.step();
      scree::Snapshot& oldest = window[static_cast<std::size_t>(i) % kWindow];
      const scree::Snapshot& last = window[static_cast<std::size_t>(i + 7) % kWindow];
      save_us.push_back(1e3 * milliseconds_of([&] { scree::save(scene.world(), oldest); }));
      keep_us.push_back(1e3 * milliseconds_of([&] { scree::keep_changes(last, oldest, changes); }));
      apply_us.push_back(1e3 * milliseconds_of([&] { scree::apply_changes(last, changes, again); }));
      bytes.push_back(static_cast<double>(changes.bytes()));
    }
    const auto median = [](std::vector<double> numbers) {
      std::sort(numbers.begin(), numbers.end());
      return numbers[numbers.size() / 2];
    };
    state.SetIterationTime(1e-6 * median(save_us));
    state.counters["keep_changes_us"] = median(keep_us);
    state.counters["apply_changes_us"] = median(apply_us);
    state.counters["changed_bytes"] = median(bytes);
    scree::World copy;
    scree::restore(copy, base);
    state.counters["restore_ms"] = milliseconds_of([&] { scree::restore(copy, base); });
    state.counters["write_ms"] =
        milliseconds_of([&] { benchmark::DoNotOptimize(scree::write_snapshot(base)); });
  }
  state.counters["bytes_per_body"] = static_cast<double>(base.bytes()) / static_cast<double>(count);
}

void register_for(const std::string& engine, const Make& make) {
  const std::pair<const char*, Change> changes[] = {
      {"nothing", Change::nothing},         {"ball_flies", Change::ball_flies},
      {"ball_sleeps", Change::ball_sleeps}, {"ball_wakes", Change::ball_wakes},
      {"box_created", Change::box_created}, {"box_destroyed", Change::box_destroyed},
      {"box_moved", Change::box_moved},
  };
  for (const auto& [name, change] : changes) {
    benchmark::RegisterBenchmark(
        (std::string(name) + "/" + engine).c_str(),
        [make, change = change](benchmark::State& state) { run(state, make, change); })
        ->Arg(10000)
        ->Arg(1000000)
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  }
  for (const bool bulk : {false, true}) {
    if (bulk && engine != "scree") continue;
    benchmark::RegisterBenchmark((std::string(bulk ? "create_bulk/" : "create/") + engine).c_str(),
                                 [make, bulk](benchmark::State& state) { run_create(state, make, bulk); })
        ->Arg(1000000)
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
}

const bool kRegistered = [] {
  register_for("scree", [] { return std::make_unique<ScreeScene>(); });
#ifdef SCREE_BENCH_BOX3D
  register_for("box3d", [] { return std::make_unique<Box3dScene>(); });
#endif
  const std::pair<const char*, Change> snapshots[] = {{"snapshot/nothing", Change::nothing},
                                                      {"snapshot/ball_flies", Change::ball_flies},
                                                      {"snapshot/box_destroyed", Change::box_destroyed}};
  for (const auto& [name, change] : snapshots) {
    benchmark::RegisterBenchmark(name,
                                 [change = change](benchmark::State& state) { run_snapshot(state, change); })
        ->Arg(10000)
        ->Arg(1000000)
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
