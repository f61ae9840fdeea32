// Snapshots: their size, and the cost of saving and restoring compared with copying the same bytes.
//
// large_pyramid (5,051 bodies) and piles of mixed shapes and of hulls after 200 steps. Buffers are reused, as
// in a program that keeps a window of snapshots. `save` follows a step each time; `save_all` follows no
// earlier save. The counters are bytes of the whole snapshot, and of its columns when written: per body, and
// per contact without the bytes of bodies.
#include <benchmark/benchmark.h>
#include <core/state/snapshot/snapshot.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace scree {
namespace {

struct Settled {
  World world;
  Snapshot snapshot;
  Snapshot later;  // by one step
  SnapshotChanges changes;
};

Settled& settled(const std::string& name, const scenes::Parameters& parameters) {
  static std::map<std::string, std::unique_ptr<Settled>> known;
  std::unique_ptr<Settled>& scene = known[name];
  if (scene != nullptr) return *scene;
  const scenes::Scene built = scenes::build(name, parameters).front();
  scene = std::make_unique<Settled>(Settled{World(built.settings), {}, {}, {}});
  scenes::populate(scene->world, built);
  Workers workers(1);
  for (int i = 0; i < 200; ++i) step(scene->world, built.dt, workers);
  save(scene->world, scene->snapshot);
  step(scene->world, built.dt, workers);
  save(scene->world, scene->later);
  keep_changes(scene->snapshot, scene->later, scene->changes);
  restore(scene->world, scene->snapshot);
  return *scene;
}

void count_bytes(benchmark::State& state, const Settled& scene) {
  const SnapshotData& data = *SnapshotAccess::data(scene.snapshot);
  Column<std::byte> columns;
  pack_columns(data.pages->sheets, columns);
  const SavedColumns saved = find_columns(columns);
  double of_bodies = 0.0, of_contacts = 0.0;
  for (std::size_t i = 0; i < saved.count; ++i) {
    const bool body = saved.column[i].store == "bodies" || saved.column[i].store == "shapes";
    (body ? of_bodies : of_contacts) += static_cast<double>(saved.column[i].bytes);
  }
  const auto contacts = static_cast<double>(saved.find("contacts.now", "manifold").rows);
  state.counters["bytes"] = static_cast<double>(scene.snapshot.bytes());
  state.counters["changed_bytes"] = static_cast<double>(scene.changes.bytes());  // in one step
  state.counters["per_body"] = of_bodies / static_cast<double>(scene.world.body_count());
  state.counters["per_contact"] = of_contacts / contacts;
  state.counters["pairs_per_contact"] =
      static_cast<double>(saved.find("contacts.pairs", "pair").rows) / contacts;
}

enum class Work { copy, save, save_all, restore, write, read, keep_changes, apply_changes };

void run(benchmark::State& state, const std::string& name, const scenes::Parameters& parameters, Work work) {
  Settled& scene = settled(name, parameters);
  std::vector<std::byte> from(scene.snapshot.bytes()), to(from.size());
  const std::vector<std::byte> bytes = write_snapshot(scene.snapshot);
  Snapshot scratch;
  Workers workers(1);
  for (auto _ : state) {
    if (work == Work::save) step(scene.world, 1.0f / 60.0f, workers);
    const auto begin = std::chrono::steady_clock::now();
    switch (work) {
      case Work::copy:
        std::memcpy(to.data(), from.data(), from.size());
        break;
      case Work::save:
        save(scene.world, scratch);
        break;
      case Work::save_all:
        internals(scene.world).last_save = {};
        save(scene.world, scratch);
        break;
      case Work::restore:
        restore(scene.world, scene.snapshot);
        break;
      case Work::write:
        benchmark::DoNotOptimize(write_snapshot(scene.snapshot));
        break;
      case Work::read:
        benchmark::DoNotOptimize(read_snapshot(bytes));
        break;
      case Work::keep_changes:
        keep_changes(scene.snapshot, scene.later, scene.changes);
        break;
      case Work::apply_changes:
        apply_changes(scene.snapshot, scene.changes, scene.later);
        break;
    }
    benchmark::ClobberMemory();
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  restore(scene.world, scene.snapshot);
  count_bytes(state, scene);
}

const bool kRegistered = [] {
  const std::pair<const char*, scenes::Parameters> cases[] = {
      {"large_pyramid", {}}, {"pile", {{"bodies", 5000}}}, {"convex_pile", {{"columns", 8}, {"layers", 20}}}};
  const std::pair<const char*, Work> works[] = {{"copy", Work::copy},
                                                {"save", Work::save},
                                                {"save_all", Work::save_all},
                                                {"restore", Work::restore},
                                                {"write", Work::write},
                                                {"read", Work::read},
                                                {"keep_changes", Work::keep_changes},
                                                {"apply_changes", Work::apply_changes}};
  for (const auto& [name, parameters] : cases) {
    for (const auto& [title, work] : works) {
      benchmark::RegisterBenchmark((std::string(name) + "/" + title).c_str(),
                                   [name = name, parameters = parameters, work = work](
                                       benchmark::State& state) { run(state, name, parameters, work); })
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace scree
