// Colors and blocks: what may be solved at the same time.
#include <parallel/constraints.h>
#include <parallel/stages.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <map>
#include <set>

namespace scree {
namespace {

using physics::Lab;

// A world of manifolds without geometry: only rows and who touches whom.
struct Graph {
  explicit Graph(int bodies) {
    data.bodies.resize(static_cast<std::size_t>(kFirstBody + bodies));
    for (int i = 0; i < bodies; ++i) {
      data.bodies.type[static_cast<std::size_t>(kFirstBody + i)] = BodyType::dynamic;
      data.bodies.awake.push_back(kFirstBody + i);
    }
  }
  // a < 0: a fixed body.
  void touch(int a, int b, std::uint32_t points = 4) {
    const std::size_t row = data.contacts.now.pair.size();
    data.contacts.now.resize(row + 1);
    Manifold& manifold = data.contacts.now.manifold[row];
    manifold.row_a = a < 0 ? kFixedRow : kFirstBody + a;
    manifold.row_b = kFirstBody + b;
    manifold.info = points | (a < 0 ? kManifoldStatic : 0u);
    data.contacts.now.color[row] = kNoColor;
    data.contacts.touching.push_back(static_cast<std::int32_t>(row));
  }
  void color(Crew& crew) {
    color_constraints(data, crew);
    pack_blocks(data, crew);
  }
  WorldData data;
};

// Every touching row lies in exactly one lane, and no parallel stage writes a body twice.
void expect_sound(WorldData& data) {
  const Constraints& constraints = constraints_of(data);
  std::multiset<std::int32_t> lanes;
  for (const ColorStage& stage : constraints.stages) {
    std::set<std::int32_t> written;
    for (int c = stage.first_chunk; c < stage.first_chunk + stage.chunk_count; ++c) {
      const simd::ContactChunk& chunk = constraints.chunks[static_cast<std::size_t>(c)];
      if (stage.serial) {
        EXPECT_EQ(chunk.lanes, 1) << "the overflow is solved one by one";
      }
      for (int i = 0; i < chunk.lanes; ++i) {
        const std::int32_t row = constraints.rows[static_cast<std::size_t>(chunk.first_lane + i)];
        lanes.insert(row);
        if (stage.serial) continue;
        const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(row)];
        EXPECT_TRUE(written.insert(manifold.row_b).second) << "body " << manifold.row_b;
        if ((manifold.info & kManifoldStatic) == 0) {
          EXPECT_TRUE(written.insert(manifold.row_a).second) << "body " << manifold.row_a;
        }
      }
    }
  }
  EXPECT_EQ(lanes.size(), data.contacts.touching.size());
  for (const std::int32_t row : data.contacts.touching) EXPECT_EQ(lanes.count(row), 1u);
}

TEST(Coloring, NoColorSharesADynamicBody) {
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Workers workers(WorkersOptions{.threads = 1, .isa = isa});
    Crew crew(workers);
    physics::Random random(1);
    Graph graph(500);
    for (int i = 0; i < 4000; ++i) {
      const int a = static_cast<int>(random.uniform(-20, 500)), b = static_cast<int>(random.uniform(0, 500));
      if (a != b) graph.touch(a, b, 1u + static_cast<std::uint32_t>(i % 4));
    }
    graph.color(crew);
    expect_sound(graph.data);
  }
}

TEST(Coloring, AHubWithTwoHundredContactsOverflowsIntoASerialStage) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(201);
  for (int i = 1; i <= 200; ++i) graph.touch(0, i);
  graph.color(crew);
  expect_sound(graph.data);
  const Column<std::uint8_t>& color = graph.data.contacts.now.color;
  EXPECT_EQ(std::count(color.begin(), color.end(), kOverflowColor), 200 - kColorLimit);
}

TEST(Coloring, FewColorsServeAChain) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(1000);
  for (int i = 0; i + 1 < 1000; ++i) graph.touch(i, i + 1);
  graph.color(crew);
  EXPECT_EQ(graph.data.stats.colors, 2);
}

TEST(Coloring, AKeptContactKeepsItsColorBesideNewOnes) {
  Workers workers(1);
  Crew crew(workers);
  physics::Random random(2);
  Graph graph(100);
  for (int i = 0; i < 200; ++i)
    graph.touch(i % 100, (i * 7 + 1) % 100 == i % 100 ? 99 - i % 100 : (i * 7 + 1) % 100);
  graph.color(crew);
  std::vector<std::uint8_t> before(graph.data.contacts.now.color.begin(),
                                   graph.data.contacts.now.color.end());
  for (int i = 0; i < 100; ++i) {
    const int a = static_cast<int>(random.uniform(0, 100));
    graph.touch(a, (a + 1 + i % 50) % 100);
  }
  graph.color(crew);
  expect_sound(graph.data);
  for (std::size_t row = 0; row < before.size(); ++row)
    EXPECT_EQ(graph.data.contacts.now.color[row], before[row]);
}

TEST(Coloring, PersistsInAMovingWorld) {
  Lab lab;
  physics::add_heap(lab, 120, 4);
  std::map<std::pair<std::int32_t, std::int32_t>, std::uint8_t> before;
  int kept = 0, changed = 0;
  for (int i = 0; i < 200; ++i) {
    lab.run(1);
    WorldData& data = internals(lab.world);
    expect_sound(data);
    std::map<std::pair<std::int32_t, std::int32_t>, std::uint8_t> now;
    for (const std::int32_t touching : data.contacts.touching) {
      const auto row = static_cast<std::size_t>(touching);
      const ShapePair pair = data.contacts.now.pair[row];
      now[{pair.a, pair.b}] = data.contacts.now.color[row];
      const auto found = before.find({pair.a, pair.b});
      if (found != before.end()) ++(found->second == data.contacts.now.color[row] ? kept : changed);
    }
    before = std::move(now);
  }
  EXPECT_GT(kept, 10000);
  EXPECT_EQ(changed, 0);
}

}  // namespace
}  // namespace scree
