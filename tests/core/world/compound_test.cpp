// Laws of bodies with many shapes: mass and positions depend neither on the calls that built them nor on
// reads in between.
#include <core/state/snapshot/snapshot.h>
#include <core/world/edit.h>
#include <scree/snapshot.h>
#include <tests/core/world/world_fixture.h>
#include <tests/parallel/hand_made_world.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace scree::test {
namespace {

ShapeDef random_def(testing::Random& random) {
  ShapeDef def;
  const float size = random.uniform(0.1f, 1.0f);
  switch (random.below(3)) {
    case 0:
      def.geometry = Sphere{size};
      break;
    case 1:
      def.geometry = Capsule{0.5f, size};
      break;
    default:
      def.geometry = Box{{size, 0.3f, 0.7f}};
  }
  def.material.density = random.uniform(1.0f, 2000.0f);
  def.options.local_pose = {random.point({50, 2, 9}), random.rotation()};
  return def;
}

std::vector<ShapeDef> random_defs(std::size_t count, std::uint64_t seed) {
  testing::Random random(seed);
  std::vector<ShapeDef> defs(count);
  for (ShapeDef& def : defs) def = random_def(random);
  return defs;
}

std::vector<ShapeId> add_each(World& world, BodyId body, const std::vector<ShapeDef>& defs) {
  std::vector<ShapeId> ids;
  for (const ShapeDef& def : defs)
    ids.push_back(world.add_shape(body, def.geometry, def.material, def.options));
  return ids;
}

// A fixed order of numbers, independent of their size.
std::vector<std::size_t> shuffled(std::size_t count, std::uint64_t seed) {
  testing::Random random(seed);
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) {
    order[i] = i;
    std::swap(order[i], order[random.below(static_cast<std::uint32_t>(i + 1))]);
  }
  return order;
}

void expect_same_mass(const World& world, BodyId body, const World& other, BodyId twin) {
  const MassProperties a = world.mass_properties(body), b = other.mass_properties(twin);
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0) << a.mass << " kg, " << b.mass << " kg";
}

// Each of these took time quadratic in the number of shapes: minutes.
TEST(Compound, OfAHundredThousandShapesIsBuiltAndRemovedOneByOne) {
  constexpr std::size_t kShapes = 100000;
  const std::vector<ShapeDef> defs = random_defs(kShapes, 1);
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic, BodyType::dynamic}) {
    World world;
    const BodyId body = world.create_body({.type = type, .angular_velocity = {0, 1, 0}});
    const JointId joint = world.create_joint({.body_a = body, .body_b = kWorld}, BallJoint{});
    const std::vector<ShapeId> ids = add_each(world, body, defs);
    EXPECT_EQ(world.shape_count(), kShapes);
    for (const std::size_t i : shuffled(kShapes, 2)) world.destroy_shape(ids[i]);
    EXPECT_EQ(world.shape_count(), 0u);
    EXPECT_EQ(world.shapes_of(body, {}), 0u);
    EXPECT_TRUE(world.is_alive(joint));
    EXPECT_EQ(world.mass_properties(body).mass, 1.0f);
  }
}

TEST(Compound, WeighsTheSameInEveryOrderOfItsShapes) {
  for (const std::size_t count : {2u, 3u, 8u, 9u, 40u, 1000u}) {
    const std::vector<ShapeDef> defs = random_defs(count, count);
    World world;
    const BodyId body = world.create_body({}), twin = world.create_body({}), bulk = world.create_body({});
    add_each(world, body, defs);
    for (const std::size_t i : shuffled(count, 5))
      world.add_shape(twin, defs[i].geometry, defs[i].material, defs[i].options);
    std::vector<ShapeId> ids(count), listed(count);
    world.add_shapes(bulk, defs, ids);
    expect_same_mass(world, body, world, twin);
    expect_same_mass(world, body, world, bulk);
    EXPECT_EQ(world.shapes_of(bulk, listed), count);
    EXPECT_EQ(listed, ids) << "oldest first";
  }
}

// Exact to the last bit of the doubles from which float rows are rounded.
TEST(Compound, SumsOfMomentsKeepNothingOfDestroyedShapes) {
  const std::vector<ShapeDef> defs = random_defs(60, 7);
  const auto part = [&](std::size_t i) {
    return part_of(defs[i].geometry, defs[i].material.density, defs[i].options.local_pose);
  };
  MassMoments plain, visited;
  for (std::size_t i = 0; i < 30; ++i) plain.add(part(i));
  for (const std::size_t i : shuffled(60, 8)) visited.add(part(i));
  for (const std::size_t i : shuffled(60, 9)) {
    if (i >= 30) visited.remove(part(i));
  }
  EXPECT_EQ(visited.parts(), 30);
  const MassSum a = plain.sum(), b = visited.sum();
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
  for (std::size_t i = 0; i < 30; ++i) visited.remove(part(i));
  const MassSum nothing = visited.sum(), zero;
  EXPECT_EQ(std::memcmp(&nothing, &zero, sizeof zero), 0);
}

// A sum of far and near parts, light and heavy ones, against the definition in long double about a near
// point.
TEST(Compound, LosesNoDigitsFarFromTheOriginOfItsBody) {
  const float far = 65536.0f;
  MassMoments moments, near;
  testing::Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Vec3 place = {0.5f * static_cast<float>(random.below(8)),
                        0.25f * static_cast<float>(random.below(8)), static_cast<float>(random.below(8))};
    const float density = random.uniform(1.0f, 1e6f);
    near.add(part_of(Sphere{0.25f}, density, {place, {}}));
    moments.add(part_of(Sphere{0.25f}, density, {place + Vec3{far, -far, far}, {}}));
  }
  const MassSum a = near.sum(), b = moments.sum();
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(b.inertia.m[i], a.inertia.m[i], 1e-14 * a.inertia.m[0]) << i;
  EXPECT_EQ(a.mass, b.mass);
}

// Compares the sums kept of a body with those computed anew, after every kind of change.
TEST(Compound, HasTheMassOfItsShapesAfterEveryChange) {
  testing::Random random(3);
  World world;
  const BodyId body = world.create_body({.angular_velocity = {0.3f, 0.2f, 0.1f}});
  std::vector<ShapeId> shapes = add_each(world, body, random_defs(6, 4));
  for (int i = 0; i < 400; ++i) {
    const std::size_t which = random.below(static_cast<std::uint32_t>(shapes.size()));
    const ShapeDef def = random_def(random);
    switch (shapes.size() < 3 ? 0 : random.below(6)) {
      case 0:
        shapes.push_back(world.add_shape(body, def.geometry, def.material, def.options));
        break;
      case 1:
        world.destroy_shape(shapes[which]);
        shapes.erase(shapes.begin() + static_cast<std::ptrdiff_t>(which));
        break;
      case 2:
        world.set_geometry(shapes[which], def.geometry);
        break;
      case 3:
        world.set_material(shapes[which], def.material);
        break;
      case 4:
        world.set_local_pose(shapes[which], def.options.local_pose);
        break;
      default: {
        world.set_body_type(body, BodyType::fixed);
        std::vector<ShapeId> ids(3);
        world.add_shapes(body, random_defs(3, random.bits()), ids);
        shapes.insert(shapes.end(), ids.begin(), ids.end());
        world.set_body_type(body, BodyType::dynamic);
      }
    }
    World copy = clone(world);  // which keeps nothing
    copy.reset_mass(body);
    expect_same_mass(world, body, copy, body);
    const Bodies &left = internals(world).bodies, &right = internals(copy).bodies;
    ASSERT_EQ(std::memcmp(&left.local_mass[body.index], &right.local_mass[body.index], sizeof(InertiaRow)),
              0);
  }
}

// Reads between calls change neither the order in which bodies are updated nor the saved bytes.
TEST(Compound, IsTheSameWhetherOrNotItIsReadInBetween) {
  World world, watched;
  watched.share_handles(world);
  testing::Random random(9);
  std::vector<ShapeId> shapes;
  const BodyId body = world.create_body({.angular_velocity = {1, 2, 3}}), other = world.create_body({});
  watched.create_body({.angular_velocity = {1, 2, 3}}), watched.create_body({});
  const JointDef joint{.body_a = body, .body_b = other};
  const JointId joined = world.create_joint(joint, BallJoint{});
  watched.create_joint(joint, BallJoint{});
  for (int i = 0; i < 60; ++i) {
    const ShapeDef def = random_def(random);
    shapes.push_back(world.add_shape(body, def.geometry, def.material, def.options));
    watched.add_shape(body, def.geometry, def.material, def.options);
    if (i % 5 == 4) {
      const ShapeId gone = shapes[random.below(static_cast<std::uint32_t>(shapes.size()))];
      world.destroy_shape(gone);
      watched.destroy_shape(gone);
      std::erase(shapes, gone);
    }
    const Pose seen = watched.joint_pose(joined);
    Snapshot snapshot;
    save(watched, snapshot);
    const Pose placed = watched.joint_pose(joined);
    EXPECT_EQ(seen.position, placed.position) << "frames that wait, and frames that are placed";
    EXPECT_EQ(seen.rotation, placed.rotation);
  }
  world.destroy_body(other);
  watched.destroy_body(other);
  const auto bytes = [](const World& of) {
    Snapshot snapshot;
    save(of, snapshot);
    return write_snapshot(snapshot);
  };
  EXPECT_EQ(world.hash(), watched.hash());
  EXPECT_EQ(bytes(world), bytes(watched));
}

}  // namespace
}  // namespace scree::test
