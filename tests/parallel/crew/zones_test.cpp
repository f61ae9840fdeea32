// Laws of zones: they nest on each thread, every one ends, each chunk of a stage is reported once, and
// results do not depend on them.
#include <gtest/gtest.h>
#include <parallel/crew/crew.h>
#include <scree/scree.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace scree {
namespace {

// What is reported, and whether zones nest on their threads.
struct Report {
  struct Entry {
    Zone zone;
    bool begins;
  };
  std::mutex mutex;
  std::vector<Entry> entries;  // those of one thread in its order
  std::map<std::thread::id, std::vector<Zone>> open;
  bool ends_match = true;  // each end is that of the zone that began last
  bool kinds_rise = true;  // a zone lies in one of a kind before its own

  ZoneHooks hooks() {
    return {[](void* report, const Zone& zone) noexcept { static_cast<Report*>(report)->note(zone, true); },
            [](void* report, const Zone& zone) noexcept { static_cast<Report*>(report)->note(zone, false); },
            this};
  }
  void note(const Zone& zone, bool begins) {
    const std::lock_guard lock(mutex);
    entries.push_back({zone, begins});
    std::vector<Zone>& stack = open[std::this_thread::get_id()];
    if (begins) {
      kinds_rise = kinds_rise && (stack.empty() || stack.back().kind < zone.kind);
      stack.push_back(zone);
      return;
    }
    ends_match = ends_match && !stack.empty() && stack.back().kind == zone.kind &&
                 stack.back().number == zone.number && stack.back().name == zone.name;
    if (!stack.empty()) stack.pop_back();
  }
  bool all_ended() const {
    return std::all_of(open.begin(), open.end(), [](const auto& each) { return each.second.empty(); });
  }
  int count(ZoneKind kind) const {
    return static_cast<int>(std::count_if(entries.begin(), entries.end(), [&](const Entry& entry) {
      return entry.begins && entry.zone.kind == kind;
    }));
  }
};

class Zones : public ::testing::Test {
 private:
  tbb::global_control more_threads_{tbb::global_control::max_allowed_parallelism, 8};
};

World pile() {
  World world;
  world.add_shape(world.create_body({.type = BodyType::fixed}), HalfSpace{});
  for (int i = 0; i < 300; ++i) {
    const Vec3 place{0.7f * static_cast<float>(i % 6), 0.6f + 1.1f * static_cast<float>(i / 36),
                     0.7f * static_cast<float>(i / 6 % 6)};
    world.add_shape(world.create_body({.position = place}), Box{{0.5f, 0.5f, 0.5f}});
  }
  return world;
}

TEST_F(Zones, OfStepsNestAndEnd) {
  for (const int threads : {1, 3}) {
    Report report;
    Workers workers({.threads = threads, .zones = report.hooks()});
    World world = pile();
    std::int64_t stages = 0;
    for (int i = 0; i < 40; ++i) {
      step(world, 1.0f / 60.0f, workers);
      stages += world.stats().stages;
    }
    EXPECT_TRUE(report.ends_match && report.kinds_rise);
    EXPECT_TRUE(report.all_ended());
    EXPECT_EQ(report.count(ZoneKind::step), 40);
    std::set<std::string> phases, stage_names, chunk_names;
    std::int64_t chunks = 0, shared = 0, steps = 0;
    for (const Report::Entry& entry : report.entries) {
      if (!entry.begins) continue;
      if (entry.zone.kind == ZoneKind::phase) {
        EXPECT_STREQ(entry.zone.name, phase_name(static_cast<Phase>(entry.zone.number)));
        phases.insert(entry.zone.name);
      }
      if (entry.zone.kind == ZoneKind::stage) {
        chunks += entry.zone.number;
        shared += entry.zone.number > 0 ? 1 : 0;
        stage_names.insert(entry.zone.name);
        EXPECT_STRNE(entry.zone.name, "");
        EXPECT_NE(std::string(entry.zone.name).find("operator"), 0u);  // as in a lambda
      }
      if (entry.zone.kind == ZoneKind::chunk) chunk_names.insert(entry.zone.name);
      if (entry.zone.kind == ZoneKind::step) {
        EXPECT_EQ(entry.zone.number, steps++);
      }
    }
    EXPECT_EQ(phases.size(), kPhaseCount - 1);  // no user joints
    EXPECT_EQ(report.count(ZoneKind::chunk), chunks);
    EXPECT_EQ(shared, stages);
    EXPECT_TRUE(
        std::includes(stage_names.begin(), stage_names.end(), chunk_names.begin(), chunk_names.end()));
  }
}

TEST_F(Zones, OfTheCallbackOfUserRowsIsAPhase) {
  Report report;
  Workers workers({.threads = 1, .zones = report.hooks()});
  World world;
  world.create_body({});
  world.set_user_row_callback([](auto&&...) {});
  step(world, 1.0f / 60.0f, workers);
  EXPECT_TRUE(std::any_of(report.entries.begin(), report.entries.end(), [](const Report::Entry& entry) {
    return std::strcmp(entry.zone.name, phase_name(Phase::refresh_user_rows)) == 0;
  }));
}

TEST_F(Zones, ChangeNoBit) {
  std::vector<std::uint64_t> hashes;
  for (const bool reported : {false, true}) {
    Report report;
    Workers workers({.threads = 2, .zones = reported ? report.hooks() : ZoneHooks{}});
    World world = pile();
    for (int i = 0; i < 60; ++i) step(world, 1.0f / 60.0f, workers);
    hashes.push_back(world.hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST_F(Zones, OfAStageNameItAndEachChunkOnce) {
  Report report;
  Workers workers({.threads = 3, .zones = report.hooks()});
  Crew crew(workers);
  crew.run_ranges(
      100, 7, [](int, int, int) {}, "sweep the floor");
  std::set<std::int64_t> chunks;
  int stages = 0;
  for (const Report::Entry& entry : report.entries) {
    EXPECT_STREQ(entry.zone.name, "sweep the floor");
    if (!entry.begins) continue;
    if (entry.zone.kind == ZoneKind::chunk) {
      EXPECT_TRUE(chunks.insert(entry.zone.number).second);
    } else {
      EXPECT_EQ(entry.zone.number, 15);
      ++stages;
    }
  }
  EXPECT_EQ(stages, 1);
  EXPECT_EQ(chunks.size(), 15u);
  EXPECT_EQ(*chunks.rbegin(), 14);
}

TEST_F(Zones, EndWhereAnExceptionLeavesThem) {
  for (const int threads : {1, 3}) {
    Report report;
    Workers workers({.threads = threads, .zones = report.hooks()});
    Crew crew(workers);
    EXPECT_THROW(crew.run(20,
                          [](int chunk, int) {
                            if (chunk % 5 == 3) throw std::runtime_error("dirty");
                          }),
                 std::runtime_error);
    EXPECT_TRUE(report.ends_match && report.kinds_rise);
    EXPECT_TRUE(report.all_ended());
  }
}

TEST_F(Zones, OfManyWorldsAreThoseOfEach) {
  for (const int threads : {1, 2, 4}) {  // more worlds than threads, and fewer
    Report report;
    Workers workers({.threads = threads, .zones = report.hooks()});
    std::vector<World> worlds;
    for (int i = 0; i < 3; ++i) worlds.push_back(pile());
    std::vector<World*> pointers;
    for (World& world : worlds) pointers.push_back(&world);
    for (int i = 0; i < 5; ++i) step(pointers, 1.0f / 60.0f, workers);
    EXPECT_EQ(report.count(ZoneKind::step), 15);
    EXPECT_TRUE(report.ends_match);
    EXPECT_TRUE(report.all_ended());
  }
}

TEST_F(Zones, OfQueriesAreStages) {
  Report report;
  Workers workers({.threads = 2, .zones = report.hooks()});
  const World world = pile();
  const std::vector<Ray> rays(1000, Ray{{0.0f, 20.0f, 0.0f}, {0.0f, -30.0f, 0.0f}});
  std::vector<std::optional<CastHit>> hits(rays.size());
  cast_rays(world, rays, hits, workers);
  EXPECT_GT(report.count(ZoneKind::stage), 0);
  EXPECT_EQ(report.count(ZoneKind::step) + report.count(ZoneKind::phase), 0);
  EXPECT_TRUE(report.ends_match && report.all_ended());
}

TEST_F(Zones, NeedBothHooksOrNone) {
  Report report;
  ZoneHooks only_begin = report.hooks(), only_end = report.hooks();
  only_begin.end = nullptr;
  only_end.begin = nullptr;
  const auto message_of = [](const ZoneHooks& hooks) -> std::string {
    try {
      Workers workers({.threads = 1, .zones = hooks});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message_of(only_begin), "WorkersOptions::zones has no end; set both or none");
  EXPECT_EQ(message_of(only_end), "WorkersOptions::zones has no begin; set both or none");
  EXPECT_EQ(message_of(report.hooks()), "");
}

}  // namespace
}  // namespace scree
