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

// The body of a lane that a hub's chunk shares among its lanes; -1: the chunk has none.
std::int32_t hub_of(const simd::ConstraintChunk& chunk, const Manifold& manifold) {
  return chunk.hub == simd::BodySide::a   ? manifold.row_a
         : chunk.hub == simd::BodySide::b ? manifold.row_b
                                          : -1;
}

// Every touching row lies in exactly one lane; nothing but its hub comes twice in a chunk, and nothing at all
// in two chunks of a stage that threads share.
void expect_sound(WorldData& data) {
  const Constraints& constraints = constraints_of(data);
  std::multiset<std::int32_t> lanes;
  for (const ColorStage& stage : constraints.stages) {
    std::set<std::int32_t> written;
    for (int c = stage.first_chunk; c < stage.first_chunk + stage.chunk_count; ++c) {
      const simd::ConstraintChunk& chunk = constraints.chunks[static_cast<std::size_t>(c)];
      if (stage.serial) written.clear();
      std::int32_t hub = -1;
      for (int i = 0; i < chunk.lanes; ++i) {
        const std::int32_t row = constraints.rows[static_cast<std::size_t>(chunk.first_lane + i)];
        lanes.insert(row);
        const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(row)];
        if (i == 0) hub = hub_of(chunk, manifold);
        EXPECT_EQ(hub_of(chunk, manifold), hub) << "a chunk has one hub";
        const auto write = [&](std::int32_t body) {
          EXPECT_TRUE(written.insert(body).second || (body == hub && i > 0)) << "body " << body;
        };
        write(manifold.row_b);
        if ((manifold.info & kManifoldStatic) == 0) write(manifold.row_a);
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

int count_overflow(const Graph& graph) {
  const Column<std::uint8_t>& color = graph.data.contacts.now.color;
  return static_cast<int>(std::count(color.begin(), color.end(), kOverflowColor));
}

TEST(Coloring, HubsBlockNoColors) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(1004);
  for (int i = 4; i < 1004; ++i) {  // four hubs of 250, as A and as B, in a chain
    const int hub = i % 4;
    if (i % 8 < 4) {
      graph.touch(hub, i, 1u + static_cast<std::uint32_t>(i % 3));
    } else {
      graph.touch(i, hub);
    }
    if (i + 1 < 1004) graph.touch(i, i + 1);
  }
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(count_overflow(graph), 0);
  EXPECT_LE(graph.data.stats.colors, 4) << "two of the chain, one of hubs as A and one of hubs as B";
}

TEST(Coloring, ContactsBetweenHubsAreSolvedOneByOne) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(202);
  for (int i = 2; i < 202; ++i) graph.touch(i % 2, i);
  graph.touch(0, 1);
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(count_overflow(graph), 1);
}

TEST(Coloring, ABodyThatCeasesToBeAHubIsColoredAnew) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(kHubDegree + 2);
  for (int i = 1; i <= kHubDegree + 1; ++i) graph.touch(0, i);
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(graph.data.stats.colors, 1);
  graph.data.contacts.touching.drop_back(1);
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(graph.data.stats.colors, kHubDegree);
  EXPECT_EQ(count_overflow(graph), 0);
}

// Bodies in a cube of 30 x 30 x 30 that touch those nearby, and a few hubs that touch whoever.
Graph make_lattice(int seed) {
  constexpr int kSide = 30, kBodies = kSide * kSide * kSide;
  Graph graph(kBodies);
  physics::Random random(static_cast<std::uint64_t>(seed));
  for (int i = 0; i < kBodies; ++i) {
    PoseRow& pose = graph.data.bodies.pose[static_cast<std::size_t>(kFirstBody + i)];
    pose.position[0] = static_cast<float>(i % kSide);
    pose.position[1] = static_cast<float>(i / kSide % kSide);
    pose.position[2] = static_cast<float>(i / kSide / kSide);
    if (i < kSide * kSide) graph.touch(-1, i);
    for (const int step : {1, kSide, kSide * kSide, kSide + 1}) {
      if (i + step < kBodies) graph.touch(i, i + step, 1u + static_cast<std::uint32_t>(i % 4));
    }
    if (i % 50 == 0 && i > 8) graph.touch(i % 8, i);
    if (random.uniform(0, 100) < 1) graph.touch(i, (i + kBodies / 2) % kBodies);
  }
  return graph;
}

TEST(Coloring, ManyContactsGetTheSameColorsFromEveryThreadCount) {
  std::vector<std::uint8_t> expected;
  for (const int threads : {1, 2, 3, 8}) {
    Workers workers(threads);
    Crew crew(workers);
    Graph graph = make_lattice(3);
    ASSERT_GT(graph.data.contacts.touching.size(), 100000u);
    graph.color(crew);
    expect_sound(graph.data);
    EXPECT_LE(count_overflow(graph), 28) << "pairs of hubs only";
    EXPECT_LE(graph.data.stats.colors, 40);
    // A second time with kept colors, some of which clash.
    Column<std::uint8_t>& color = graph.data.contacts.now.color;
    for (std::size_t row = 0; row < color.size(); row += 997) color[row] = 0;
    graph.color(crew);
    expect_sound(graph.data);
    const std::vector<std::uint8_t> colors(color.begin(), color.end());
    if (expected.empty()) expected = colors;
    EXPECT_EQ(colors, expected) << threads << " threads";
  }
}

TEST(Coloring, BodiesInOnePlaceAreColoredToo) {
  Workers workers(2);
  Crew crew(workers);
  Graph graph(10000);
  for (int i = 0; i + 3 < 10000; ++i) {
    graph.touch(i, i + 1);
    graph.touch(i, i + 2);
    graph.touch(i, i + 3);
  }
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_LE(graph.data.stats.colors, 11);
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
