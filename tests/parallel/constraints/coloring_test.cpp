// Colors and blocks: constraints that may be solved at the same time.
#include <parallel/constraints/coloring.h>
#include <parallel/stages.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <vector>

namespace scree {
namespace {

using physics::Lab;

// A world of manifolds without geometry: only rows and their pairs of bodies.
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
    data.contacts.active.push_back(static_cast<std::int32_t>(row));
  }
  // Either may be fixed, but not both.
  void join(int a, int b, JointType type = JointType::ball) {
    Joints& joints = data.joints;
    const std::size_t row = joints.flags.size();
    joints.resize(row + 1);
    joints.flags[row] = kJointAlive | kJointEnabled;
    joints.type[row] = type;
    joints.bodies[row] = {a < 0 ? kFixedRow : kFirstBody + a, b < 0 ? kFixedRow : kFirstBody + b};
    joints.color[row] = kNoColor;
    joints.active.push_back(static_cast<std::int32_t>(row));
  }
  void color(Crew& crew) {
    color_constraints(data, crew);
    pack_blocks(data, crew);
  }
  WorldData data;
};

// A constraint in a lane: its bodies, and whether a chunk of these writes them.
struct LaneBodies {
  std::int32_t a, b;
  bool writes_a, writes_b;
};

LaneBodies bodies_of(const WorldData& data, std::int32_t contact, const simd::ConstraintChunk&) {
  const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(contact)];
  return {manifold.row_a, manifold.row_b, (manifold.info & kManifoldStatic) == 0, true};
}

LaneBodies joined_bodies_of(const WorldData& data, std::int32_t joint, const simd::ConstraintChunk& chunk) {
  const JointBodies bodies = data.joints.bodies[static_cast<std::size_t>(joint)];
  const JointType type = data.joints.type[static_cast<std::size_t>(joint)];
  EXPECT_EQ(chunk.variant, simd::joint_variant(type, false));
  EXPECT_EQ(chunk.fixed, bodies.a == kFixedRow   ? simd::BodySide::a
                         : bodies.b == kFixedRow ? simd::BodySide::b
                                                 : simd::BodySide::none);
  return {bodies.a, bodies.b, bodies.a != kFixedRow, bodies.b != kFixedRow};
}

// The rows of the lanes of a stage's chunks. Within a chunk only its hub occurs twice; chunks of a stage that
// threads share have no body in common.
template <class BodiesOf>
void expect_chunks(const WorldData& data, bool serial, std::span<const simd::ConstraintChunk> chunks,
                   const Column<std::int32_t>& rows, std::set<std::int32_t>& written,
                   std::multiset<std::int32_t>& lanes, BodiesOf&& bodies_of_lane) {
  for (const simd::ConstraintChunk& chunk : chunks) {
    if (serial) written.clear();
    std::int32_t hub = -1;
    for (int i = 0; i < chunk.lanes; ++i) {
      const std::int32_t row = rows[static_cast<std::size_t>(chunk.first_lane + i)];
      lanes.insert(row);
      const LaneBodies lane = bodies_of_lane(data, row, chunk);
      const std::int32_t shared = chunk.hub == simd::BodySide::a   ? lane.a
                                  : chunk.hub == simd::BodySide::b ? lane.b
                                                                   : -1;
      if (i == 0) hub = shared;
      EXPECT_EQ(shared, hub) << "a chunk has one hub";
      const auto write = [&](std::int32_t body) {
        EXPECT_TRUE(written.insert(body).second || (body == hub && i > 0)) << "body " << body;
      };
      if (lane.writes_a) write(lane.a);
      if (lane.writes_b) write(lane.b);
    }
  }
}

// Expects that every touching row and every active joint lies in exactly one lane, and that no lane conflicts
// with another.
void expect_sound(const WorldData& data) {
  const Constraints& constraints = static_cast<const Constraints&>(*data.constraints);
  std::multiset<std::int32_t> contacts, joints;
  for (const ColorStage& stage : constraints.stages) {
    std::set<std::int32_t> written;
    const auto part = [](const auto& chunks, std::int32_t first, std::int32_t count) {
      return chunks.span().subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    };
    expect_chunks(data, stage.serial,
                  part(constraints.joint_chunks, stage.first_joint_chunk, stage.joint_chunk_count),
                  constraints.joint_lanes, written, joints, joined_bodies_of);
    expect_chunks(data, stage.serial,
                  part(constraints.contact_chunks, stage.first_contact_chunk, stage.contact_chunk_count),
                  constraints.contact_lanes, written, contacts, bodies_of);
  }
  EXPECT_EQ(contacts.size(), data.contacts.active.size());
  for (const std::int32_t row : data.contacts.active) EXPECT_EQ(contacts.count(row), 1u);
  EXPECT_EQ(joints.size(), data.joints.active.size());
  for (const std::int32_t joint : data.joints.active) EXPECT_EQ(joints.count(joint), 1u);
}

// A body that the chunk's constraint in the middle pushes.
template <class BodiesOf>
std::int32_t body_of_chunk(const WorldData& data, const simd::ConstraintChunk& chunk,
                           const Column<std::int32_t>& rows, BodiesOf&& bodies_of_lane) {
  const LaneBodies lane = bodies_of_lane(data, rows[chunk.first_lane + chunk.lanes / 2], chunk);
  return lane.writes_a && lane.writes_b ? std::min(lane.a, lane.b) : lane.writes_a ? lane.a : lane.b;
}

// Expects that threads take each chunk of a stage once, and those of lower bodies first.
void expect_order(const WorldData& data) {
  const Constraints& constraints = static_cast<const Constraints&>(*data.constraints);
  std::size_t first = 0;
  for (const ColorStage& stage : constraints.stages) {
    const auto count = static_cast<std::size_t>(stage.joint_chunk_count + stage.contact_chunk_count);
    std::set<std::int32_t> taken;
    std::vector<std::int32_t> bodies;
    for (std::size_t i = first; i < first + count; ++i) {
      const std::int32_t chunk = constraints.chunk_order[i], contact = chunk - stage.joint_chunk_count;
      taken.insert(chunk);
      bodies.push_back(
          contact < 0 ? body_of_chunk(data, constraints.joint_chunks[stage.first_joint_chunk + chunk],
                                      constraints.joint_lanes, joined_bodies_of)
                      : body_of_chunk(data, constraints.contact_chunks[stage.first_contact_chunk + contact],
                                      constraints.contact_lanes, bodies_of));
    }
    EXPECT_EQ(taken.size(), count);
    EXPECT_TRUE(taken.empty() || (*taken.begin() == 0 && *taken.rbegin() == static_cast<int>(count) - 1));
    EXPECT_TRUE(stage.serial || std::is_sorted(bodies.begin(), bodies.end()));
    first += count;
  }
  EXPECT_EQ(constraints.chunk_order.size(), first);
  const std::set<std::int32_t> all(constraints.share_order.begin(), constraints.share_order.end());
  EXPECT_EQ(all.size(), first);
  EXPECT_EQ(constraints.share_order.size(), first);
}

template <class Check>
void with_every_set(Check&& check) {
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Workers workers(WorkersOptions{.threads = 1, .isa = isa});
    Crew crew(workers);
    check(crew);
  }
}

TEST(Coloring, NoColorSharesADynamicBody) {
  with_every_set([](Crew& crew) {
    physics::Random random(1);
    Graph graph(500);
    for (int i = 0; i < 4000; ++i) {
      const int a = static_cast<int>(random.uniform(-20, 500)), b = static_cast<int>(random.uniform(0, 500));
      if (a == b) continue;
      graph.touch(a, b, 1u + static_cast<std::uint32_t>(i % 4));
      if (i % 3 == 0) graph.join(b, a, static_cast<JointType>(i % kJointTypeCount));
    }
    graph.color(crew);
    expect_sound(graph.data);
    expect_order(graph.data);
  });
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
  EXPECT_LE(graph.data.stats.colors, 5) << "three of the chain, one of hubs as A and one of hubs as B";
}

// Hubs by their contacts, each with few joints, and the other way round.
TEST(Coloring, HubsOfContactsMayHaveFewJointsAndHubsOfJointsFewContacts) {
  for (const int hubs : {3, 10, 100}) {
    for (const bool by_contacts : {true, false}) {
      with_every_set([&](Crew& crew) {
        constexpr int kMany = kHubDegree + 1, kFew = 4, kAll = kMany + kFew;
        Graph graph(hubs * (1 + kAll));
        for (int hub = 0; hub < hubs; ++hub) {
          for (int i = 0; i < kAll; ++i) {
            const int other = hubs + hub * kAll + i;
            if ((i < kMany) == by_contacts) {
              graph.touch(hub, other);
            } else {
              graph.join(hub, other);
            }
          }
        }
        graph.color(crew);
        expect_sound(graph.data);
        EXPECT_EQ(graph.data.stats.colors, 1);
      });
    }
  }
}

TEST(Coloring, ConstraintsWithFixedBodiesBeyondTheColorsAreSolvedInGroups) {
  with_every_set([](Crew& crew) {
    Graph graph(4);
    for (int i = 0; i < 300; ++i) {
      graph.touch(-1, 0);
      graph.join(-1, 1);
      graph.join(2, -1, i % 2 == 0 ? JointType::ball : JointType::distance);
    }
    graph.touch(-1, 3);
    graph.color(crew);
    expect_sound(graph.data);
    EXPECT_EQ(count_overflow(graph), 0);
    EXPECT_EQ(graph.data.stats.colors, kColorLimit + 1);
    const Constraints& constraints = constraints_of(graph.data);
    EXPECT_LT(constraints.joint_chunks.size() + constraints.contact_chunks.size(), 3u * kColorLimit + 5);
    // The bodies stay there, and the coloring holds.
    graph.color(crew);
    expect_sound(graph.data);
    EXPECT_TRUE(constraints.uncolored.empty());
  });
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

// All bodies touch each other, in the order of sorted pairs; numbers of contact points cycle through three
// kinds.
Graph make_clique(int bodies) {
  Graph graph(bodies);
  for (int a = 0; a < bodies; ++a) {
    for (int b = a + 1; b < bodies; ++b) graph.touch(a, b, 1u + static_cast<std::uint32_t>(a + b) % 3u);
  }
  return graph;
}

TEST(Coloring, BodiesThatAllTouchOneAnotherFillTheirBlocks) {
  with_every_set([](Crew& crew) {
    constexpr int kBodies = 200, kKinds = 3;
    Graph graph = make_clique(kBodies);
    graph.color(crew);
    expect_sound(graph.data);
    const Constraints& constraints = constraints_of(graph.data);
    EXPECT_EQ(count_overflow(graph), kBodies * (kBodies - 1) / 2);
    EXPECT_LE(constraints.contact_keys.level_ends.size(), static_cast<std::size_t>(2 * kBodies * kKinds));
    EXPECT_GT(graph.data.stats.lane_fill, 0.75) << crew.kernels().lanes << " lanes";
  });
}

TEST(Coloring, UncoloredConstraintsOfABodyAreSolvedInListOrder) {
  with_every_set([](Crew& crew) {
    Graph graph = make_clique(60);
    graph.color(crew);
    const Constraints& constraints = constraints_of(graph.data);
    std::map<std::int32_t, int> last;  // by body: place of its last contact, kind by kind
    const auto rows = static_cast<int>(graph.data.contacts.active.size());
    int solved = 0;
    for (const simd::ConstraintChunk& chunk : constraints.contact_chunks) {
      for (int lane = 0; lane < chunk.lanes; ++lane, ++solved) {
        const std::int32_t row = constraints.contact_lanes[static_cast<std::size_t>(chunk.first_lane + lane)];
        const Manifold& manifold = graph.data.contacts.now.manifold[static_cast<std::size_t>(row)];
        const int place = static_cast<int>(manifold.info & kManifoldPointMask) * rows + row;
        for (const std::int32_t body : {manifold.row_a, manifold.row_b}) {
          EXPECT_TRUE(last.insert({body, -1}).first->second < place) << "body " << body;
          last[body] = place;
        }
      }
    }
    EXPECT_EQ(solved, rows);
  });
}

TEST(Coloring, ABodyThatCeasesToBeAHubIsColoredAnew) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(kHubDegree + 2);
  for (int i = 1; i <= kHubDegree + 1; ++i) graph.touch(0, i);
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(graph.data.stats.colors, 1);
  graph.data.contacts.active.drop_back(1);
  graph.color(crew);
  expect_sound(graph.data);
  EXPECT_EQ(graph.data.stats.colors, kHubDegree);
  EXPECT_EQ(count_overflow(graph), 0);
}

// Bodies in a cube of 30 x 30 x 30 that touch their neighbors, and a few hubs that touch random bodies.
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

// Colors all anew, in rounds, whatever the number of threads.
std::vector<int> colors_in_rounds(Graph& graph, Crew& crew) {
  Constraints& constraints = constraints_of(graph.data);
  for (BodyColors& body : constraints.body_colors) {
    body.dynamic_colors = body.static_colors = body.hub_colors = 0;
  }
  constraints.uncolored.resize(constraints.edges.size());
  std::iota(constraints.uncolored.begin(), constraints.uncolored.end(), 0);
  for (Edge& edge : constraints.edges) edge.color = kNoColor;
  color_in_rounds(constraints, crew);
  std::vector<int> colors;
  for (const Edge& edge : constraints.edges) colors.push_back(edge.color);
  return colors;
}

TEST(Coloring, ManyContactsGetTheSameColorsFromEveryThreadCount) {
  std::vector<std::uint8_t> expected;
  for (const int threads : {1, 2, 3, 8}) {
    Workers workers(threads);
    Crew crew(workers);
    Graph graph = make_lattice(3);
    ASSERT_GT(graph.data.contacts.active.size(), 100000u);
    graph.color(crew);
    expect_sound(graph.data);
    EXPECT_LE(count_overflow(graph), 28) << "pairs of hubs only";
    EXPECT_LE(graph.data.stats.colors, 40);
    std::vector<int> in_order;
    for (const Edge& edge : constraints_of(graph.data).edges) in_order.push_back(edge.color);
    Graph other = make_lattice(3);
    other.color(crew);
    EXPECT_EQ(colors_in_rounds(other, crew), in_order) << threads << " threads";
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

// The colors of a graph of contacts that has none yet, by the definition: each takes the lowest color that
// none before it in the order of the hash has at one of its bodies.
std::vector<int> colors_by_definition(const Graph& graph) {
  const Constraints& constraints = static_cast<const Constraints&>(*graph.data.constraints);
  std::vector<std::pair<std::uint32_t, std::size_t>> order;
  for (std::size_t i = 0; i < constraints.edges.size(); ++i)
    order.emplace_back(order_of(constraints.edges[i]), i);
  std::sort(order.begin(), order.end());
  std::map<std::pair<std::int32_t, bool>, std::set<int>> used;  // by body, and whether the other is fixed
  std::vector<int> colors(order.size());
  for (const auto& [hash, i] : order) {
    const Edge& edge = constraints.edges[i];
    const bool fixed = edge.kind == EdgeKind::pushed_b;
    std::set<int>&b = used[{edge.body_b, fixed}], &a = fixed ? b : used[{edge.body_a, false}];
    int color = 0;
    while (a.count(color) + b.count(color) > 0) ++color;
    a.insert(color);
    b.insert(color);
    colors[i] = color;
  }
  return colors;
}

TEST(Coloring, ColorsAreTheLowestFreeOnesInTheOrderOfAHash) {
  for (const int contacts : {1, 100, 129, 3000, 40000}) {
    for (const int threads : {1, 2}) {
      Workers workers(threads);
      Crew crew(workers);
      physics::Random random(5);
      const int bodies = 2 + contacts / 3;
      Graph graph(bodies);
      for (int i = 0; i < contacts; ++i) {
        const int a = static_cast<int>(random.uniform(0, static_cast<float>(bodies) - 0.01f));
        graph.touch(i % 5 == 0 ? -1 : a, (a + 1 + i % 3 % (bodies - 1)) % bodies);
      }
      graph.color(crew);
      const std::vector<int> expected = colors_by_definition(graph);
      for (std::size_t i = 0; i < expected.size(); ++i)
        ASSERT_EQ(graph.data.contacts.now.color[i], expected[i]) << contacts << " contacts, contact " << i;
      EXPECT_EQ(colors_in_rounds(graph, crew), expected)
          << contacts << " contacts, " << threads << " threads";
    }
  }
}

// What other parts of the world do, new ones and those that lose colors, changes no color.
TEST(Coloring, AColorDependsOnWhatIsConnectedAlone) {
  const auto color_twice = [](int parts, int threads) {
    Workers workers(threads);
    Crew crew(workers);
    constexpr int kBodies = 2000;
    Graph graph(parts * kBodies);
    for (int part = 0; part < parts; ++part) {
      physics::Random random(static_cast<std::uint64_t>(part));
      for (int i = 0; i < 6000; ++i) {
        const int a = static_cast<int>(random.uniform(0, kBodies - 0.01f));
        graph.touch(part * kBodies + a, part * kBodies + (a + 1 + i % 7) % kBodies);
      }
    }
    graph.color(crew);
    Column<std::uint8_t>& color = graph.data.contacts.now.color;
    for (std::size_t row = 0; row < color.size(); row += 17) color[row] = 1;  // clashes with others
    graph.color(crew);
    expect_sound(graph.data);
    return std::vector<std::uint8_t>(color.begin(), color.begin() + 6000);
  };
  const std::vector<std::uint8_t> alone = color_twice(1, 1);
  EXPECT_EQ(color_twice(2, 1), alone);
  EXPECT_EQ(color_twice(6, 1), alone);
}

// Rounds in which each body colors one of its many contacts would not end soon.
TEST(Coloring, BodiesOfThousandsOfNewContactsGetTheSameColorsFromEveryThreadCount) {
  std::vector<std::uint8_t> expected;
  for (const int threads : {1, 3}) {
    Workers workers(threads);
    Crew crew(workers);
    Graph graph(6);
    for (int i = 0; i < 60000; ++i) graph.touch(-1, i % 6);
    graph.color(crew);
    expect_sound(graph.data);
    const Column<std::uint8_t>& color = graph.data.contacts.now.color;
    const std::vector<std::uint8_t> colors(color.begin(), color.end());
    if (expected.empty()) expected = colors;
    EXPECT_EQ(colors, expected);
    EXPECT_EQ(colors_in_rounds(graph, crew), std::vector<int>(expected.begin(), expected.end()));
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

TEST(Coloring, AChainTakesFewColors) {
  Workers workers(1);
  Crew crew(workers);
  Graph graph(1000);
  for (int i = 0; i + 1 < 1000; ++i) graph.touch(i, i + 1);
  graph.color(crew);
  EXPECT_LE(graph.data.stats.colors, 3) << "a link and its two neighbors";
}

TEST(Coloring, AKeptContactKeepsItsColorWhenOthersAreAdded) {
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
    for (const std::int32_t touching : data.contacts.active) {
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
