// Laws of the query index: what it costs, and that each shape is found in one place.
#include <core/world/world_data.h>
#include <parallel/queries/query_index.h>
#include <simd/dispatch/kernels.h>
#include <tests/parallel/queries/query_fixture.h>

#include <map>

namespace scree {
namespace {

using testing::MixedWorld;

constexpr int kBoxes = 20000;

// A square field of fixed boxes.
World field() {
  World world;
  std::vector<BodyDef> defs(kBoxes);
  for (int i = 0; i < kBoxes; ++i) {
    defs[static_cast<std::size_t>(i)] = {
        .type = BodyType::fixed,
        .position = {2.0f * static_cast<float>(i % 150), 0, 2.0f * static_cast<float>(i / 150)}};
  }
  for (std::size_t i = 0; i < defs.size(); ++i) world.add_shape(world.create_body(defs[i]), Box{});
  return world;
}

const QueryIndex& index_of(const World& world) {
  return query_index_of(internals(world), simd::widest_kernels());
}

std::optional<CastHit> look_down(const World& world, float x, float z) {
  return cast_ray(world, {{x, 10, z}, {0, -20, 0}});
}

TEST(QueryIndex, CostsNothingForWhatTheLastStepLeftInItsTrees) {
  World world = field();
  Workers workers(1);
  step(world, 0.01f, workers);
  EXPECT_TRUE(look_down(world, 40, 40));
  EXPECT_EQ(index_of(world).boxes_made, 0);
  for (int i = 0; i < 100; ++i) {
    const float x = 2.0f * static_cast<float>(i);
    const BodyId body = world.create_body({.type = BodyType::fixed, .position = {x, 2, 0}});
    world.add_shape(body, Sphere{});
    EXPECT_FLOAT_EQ(look_down(world, x, 0)->point.y, 2.5f);
    world.set_pose(body, {{x, 3, 0}, {}});
    EXPECT_FLOAT_EQ(look_down(world, x, 0)->point.y, 3.5f);
    if (i % 2 == 0) world.destroy_body(body);
    EXPECT_FLOAT_EQ(look_down(world, x, 0)->point.y, i % 2 == 0 ? 0.5f : 3.5f);
  }
  EXPECT_LE(index_of(world).boxes_made, 200 * 70);
  step(world, 0.01f, workers);
  const std::int64_t before = index_of(world).boxes_made;
  EXPECT_FLOAT_EQ(look_down(world, 2, 0)->point.y, 3.5f);
  EXPECT_EQ(index_of(world).boxes_made, before);
}

TEST(QueryIndex, CostsByWhatChangesInAWorldThatIsNeverStepped) {
  World world = field();
  EXPECT_TRUE(look_down(world, 40, 40));
  EXPECT_EQ(index_of(world).boxes_made, kBoxes);
  for (int i = 0; i < 200; ++i) {
    world.add_shape(
        world.create_body({.type = BodyType::fixed, .position = {40, 1.0f + static_cast<float>(i), 40}}),
        Box{});
    if (i < 9) {
      EXPECT_FLOAT_EQ(look_down(world, 40, 40)->point.y, 1.5f + static_cast<float>(i));
    } else {
      EXPECT_TRUE(look_down(world, 40, 40)->starts_inside);
    }
  }
  // Each is counted again when trees of 64 and 512 are made.
  EXPECT_LE(index_of(world).boxes_made, kBoxes + 200 * 64);
}

TEST(QueryIndex, NamesEachLivingShapeOnceAmongThoseThatCount) {
  MixedWorld mixed(41, 300);
  for (int round = 0; round < 40; ++round) {
    if (round % 3 != 0) mixed.step(round % 5);
    for (int i = 0; i < 5; ++i) {
      mixed.change_something();
      if (round % 2 == 0) look_down(mixed.world, 0, 0);
    }
    const WorldData& data = internals(mixed.world);
    const QueryIndex& index = index_of(mixed.world);
    std::map<std::int32_t, int> times;
    const auto count = [&](const simd::TreeView& tree, bool loose) {
      const simd::MeetTask all{{-1e10f, -1e10f, -1e10f}, {1e10f, 1e10f, 1e10f}};
      std::vector<std::int32_t> named;
      const auto name = [](void* context, std::int32_t shape, float limit) {
        static_cast<std::vector<std::int32_t>*>(context)->push_back(shape);
        return limit;
      };
      simd::widest_kernels().query.meet(tree, all, 1.0f, name, &named);
      for (const std::int32_t shape : named) times[shape] += loose || index.is_loose[shape] == 0 ? 1 : 0;
    };
    for_each_base_tree(data, index, [&](const simd::TreeView& tree) { count(tree, false); });
    for_each_loose_tree(data, index, [&](const simd::TreeView& tree) { count(tree, true); });
    std::size_t living = 0;
    for (const auto& [shape, number] : times) {
      const bool lives = (data.shapes.flags[shape] & kShapeAlive) != 0;
      EXPECT_EQ(number, lives ? 1 : 0) << shape;
      living += lives ? 1 : 0;
    }
    EXPECT_EQ(living, mixed.world.shape_count());
  }
}

TEST(QueryIndex, WorldsThatAreNeverAskedNoteNothing) {
  World world = field();
  EXPECT_EQ(internals(world).shapes.to_query.size(), 0u);
  EXPECT_EQ(internals(world).queries, nullptr);
}

}  // namespace
}  // namespace scree
