// Laws of the hash.
#include <core/world/state_table.h>
#include <tests/core/world/world_fixture.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace scree::test {
namespace {

// The same for all instruction sets, compilers and build types. Compute it again only if the hash's
// definition changes: index, pose of the center of mass and velocities of the living bodies, and by how much
// they lag; the sum of XXH3's 64 bits of each.
constexpr std::uint64_t kGoldenHash = 3778664391355705470u;

World make_world() {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(ground, Box{{50, 1, 50}});
  const BodyId gone = world.create_body({});
  const BodyId compound = world.create_body({.position = {0.1f, 4, -0.3f},
                                             .rotation = {0.6f, 0, 0, 0.8f},
                                             .linear_velocity = {1, -0.0f, 3},
                                             .angular_velocity = {0.7f, 0.3f, -0.9f}});
  world.add_shape(compound, Box{{0.5f, 0.25f, 0.75f}}, {},
                  {.local_pose = {{0.3f, 0.1f, 0.2f}, {0, 0.6f, 0.8f, 0}}});
  world.add_shape(compound, Capsule{0.7f, 0.3f}, {.density = 333.0f}, {.local_pose = {{-1, 0.1f, 0.4f}, {}}});
  world.add_impulse_at(compound, {100, 200, -50}, {0.5f, 4.5f, 0.1f});
  world.destroy_body(gone);
  return world;
}

TEST(Hash, OfAFixedWorldIsKnown) { EXPECT_EQ(make_world().hash(), kGoldenHash); }

TEST(Hash, OfAnEmptyWorldIsZero) {
  World world;
  EXPECT_EQ(world.hash(), 0u);
  world.destroy_body(world.create_body({}));
  EXPECT_EQ(world.hash(), 0u);
}

// So processes that hold some of the bodies each can tell the hash of all.
TEST(Hash, IsTheSumOverTheBodies) {
  constexpr int kBodies = 300;
  const auto world_of = [](auto&& holds) {
    World world;
    std::vector<BodyId> rest;
    for (int i = 0; i < kBodies; ++i) {
      const float x = static_cast<float>(i);
      const BodyId body = world.create_body({.position = {x, 2 * x, 1}, .linear_velocity = {1, x, 0}});
      if (!holds(i)) rest.push_back(body);
    }
    for (const BodyId body : rest) world.destroy_body(body);
    return world.hash();
  };
  const std::uint64_t all = world_of([](int) { return true; });
  std::uint64_t sum = 0;
  for (int part = 0; part < 7; ++part) sum += world_of([part](int i) { return i * i % 7 == part; });
  EXPECT_EQ(sum, all);
}

TEST(Hash, ChangesWithEveryBitOfPoseAndVelocity) {
  World world = make_world();
  const std::uint64_t hash = world.hash();
  Bodies& bodies = internals(world).bodies;
  const auto row = static_cast<std::size_t>(kFirstBody) + 2;
  float* values[] = {
      &bodies.pose[row].position[0],   &bodies.pose[row].position[1],    &bodies.pose[row].position[2],
      &bodies.pose[row].rotation[0],   &bodies.pose[row].rotation[1],    &bodies.pose[row].rotation[2],
      &bodies.pose[row].rotation[3],   &bodies.velocity[row].linear[0],  &bodies.velocity[row].linear[1],
      &bodies.velocity[row].linear[2], &bodies.velocity[row].angular[0], &bodies.velocity[row].angular[1],
      &bodies.velocity[row].angular[2]};
  for (float* value : values) {
    const float old = *value;
    *value = std::nextafter(old, std::numeric_limits<float>::infinity());
    EXPECT_NE(world.hash(), hash);
    *value = old == 0.0f ? -old : old;  // signed zeros differ
    EXPECT_EQ(world.hash() == hash, old != 0.0f);
    *value = old;
  }
  EXPECT_EQ(world.hash(), hash);
}

TEST(Hash, CoversTheColumnsThatTheTableMarksAndNoOthers) {
  World world = make_world();
  const std::uint64_t hash = world.hash();
  const std::size_t row = kFirstBody + 2;
  std::set<std::string> hashed;
  for_each_column_member(internals(world), [&hashed](const Member& member, const auto&) {
    if (!member.is.hashed) return;
    hashed.insert(member.name);
    EXPECT_EQ(std::string(member.store), "bodies") << "of which alone the hash is made";
  });
  EXPECT_EQ(hashed, (std::set<std::string>{"pose", "velocity"}));
  internals(world).bodies.for_each_column([&](ColumnKind kind, const char* name, auto& column) {
    EXPECT_TRUE(kind == ColumnKind::state || hashed.count(name) == 0) << name;
    if (std::string(name) == "flags") return;  // tells which bodies live
    auto* bytes = reinterpret_cast<unsigned char*>(&column[row]);
    for (std::size_t i = 0; i < sizeof(column[row]); ++i) bytes[i] ^= 1;
    EXPECT_EQ(world.hash() != hash, hashed.count(name) == 1) << name;
    for (std::size_t i = 0; i < sizeof(column[row]); ++i) bytes[i] ^= 1;
  });
  EXPECT_EQ(world.hash(), hash);
}

TEST(Hash, IgnoresPaddingDeadRowsAndUserData) {
  World world = make_world();
  const std::uint64_t hash = world.hash();
  Bodies& bodies = internals(world).bodies;
  const auto dead = static_cast<std::size_t>(kFirstBody) + 1, live = dead + 1;
  bodies.pose[dead].position[0] = 9.0f;
  bodies.pose[live].padding = 9.0f;
  bodies.velocity[live].padding = 9.0f;
  bodies.velocity[0].linear[0] = 9.0f;
  world.set_user_data(world.body_at(static_cast<std::uint32_t>(live)), 9);
  EXPECT_EQ(world.hash(), hash);
}

TEST(Hash, DependsOnTheLag) {
  World world = make_world();
  const std::uint64_t hash = world.hash();
  internals(world).bodies.velocity[static_cast<std::size_t>(kFirstBody) + 2].lag = 0.01f;
  EXPECT_NE(world.hash(), hash);
}

TEST(Hash, DependsOnTheIndex) {
  World first, second;
  first.create_body({});
  const BodyId other = second.create_body({});
  second.create_body({});
  EXPECT_NE(first.hash(), second.hash());
  second.destroy_body(other);
  EXPECT_NE(first.hash(), second.hash());
}

TEST(Hash, DoesNotDependOnHowTheBodiesWereMade) {
  World single, bulk;
  std::vector<BodyDef> defs(1000);
  for (std::size_t i = 0; i < defs.size(); ++i) defs[i].position.x = static_cast<float>(i);
  for (const BodyDef& def : defs) single.create_body(def);
  std::vector<BodyId> ids(defs.size());
  bulk.create_bodies(defs, ids);
  EXPECT_EQ(single.hash(), bulk.hash());
}

}  // namespace
}  // namespace scree::test
