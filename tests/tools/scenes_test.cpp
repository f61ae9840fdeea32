// Laws of the built-in scenes, checked on their lists of bodies without any world.
#include <core/world/math.h>
#include <gtest/gtest.h>
#include <tools/scenes/angles.h>
#include <tools/scenes/hulls.h>
#include <tools/scenes/random.h>
#include <tools/scenes/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

namespace scree::scenes {
namespace {

Scene build_scene(const std::string& name, const Parameters& parameters = {}) {
  std::vector<Scene> worlds = build(name, parameters);
  EXPECT_EQ(worlds.size(), 1u);
  return std::move(worlds.front());
}

const Geometry& geometry_of(const Scene& scene, const SceneBody& body) {
  return scene.shapes[body.first_shape].geometry;
}

float bounding_radius(const Geometry& geometry) {
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return sphere->radius;
  if (const auto* capsule = std::get_if<Capsule>(&geometry)) return capsule->half_height + capsule->radius;
  if (const auto* hull = std::get_if<ConvexHull>(&geometry)) {
    float radius = 0.0f;
    for (const Vec3 v : hull->hull.vertices()) {
      radius = std::max(radius, length({v.x * hull->scale.x, v.y * hull->scale.y, v.z * hull->scale.z}));
    }
    return radius;
  }
  return length(std::get<Box>(geometry).half_extents);
}

std::vector<Vec3> corners(const Scene& scene, const SceneBody& body) {
  const Vec3 half = std::get<Box>(geometry_of(scene, body)).half_extents;
  std::vector<Vec3> all;
  for (int i = 0; i < 8; ++i) {
    const Vec3 local{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
    all.push_back(body.def.position + rotate(body.def.rotation, local));
  }
  return all;
}

float lowest(const Scene& scene, const SceneBody& body) {
  float low = std::numeric_limits<float>::infinity();
  for (const Vec3& corner : corners(scene, body)) low = std::min(low, corner.y);
  return low;
}

float highest(const Scene& scene, const SceneBody& body) {
  float high = -std::numeric_limits<float>::infinity();
  for (const Vec3& corner : corners(scene, body)) high = std::max(high, corner.y);
  return high;
}

std::string error_of(const std::string& name, const Parameters& parameters) {
  try {
    build(name, parameters);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// FNV-1a over the raw bits of what a builder computed.
std::uint64_t bits_of(const Scene& scene) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    for (int byte = 0; byte < 4; ++byte) hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3u;
  };
  for (const SceneBody& body : scene.bodies) {
    for (const float value : {body.def.position.x, body.def.position.y, body.def.position.z,
                              body.def.rotation.x, body.def.rotation.y, body.def.rotation.z,
                              body.def.rotation.w, bounding_radius(geometry_of(scene, body))}) {
      add(value);
    }
  }
  return hash;
}

TEST(Random, FollowsThePublishedSequence) {
  Random random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317u);
  EXPECT_EQ(random.next(), 3203168211198807973u);
  EXPECT_EQ(random.next(), 9817491932198370423u);
}

TEST(Random, RotationsHaveUnitLength) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const Quat q = random.rotation();
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1.0f, 1e-6f);
  }
}

TEST(Angles, RightAnglesAreExact) {
  for (int quarter = -8; quarter <= 8; ++quarter) {
    const auto [sine, cosine] = sine_cosine(90.0 * quarter);
    const double sines[] = {0.0, 1.0, 0.0, -1.0};
    EXPECT_EQ(sine, sines[quarter & 3]);
    EXPECT_EQ(cosine, sines[(quarter + 1) & 3]);
  }
}

TEST(Angles, AgreeWithTheMathLibraryToTheLastDigits) {
  for (double degrees = -720.0; degrees <= 720.0; degrees += 0.37) {
    const auto [sine, cosine] = sine_cosine(degrees);
    const double radians = std::fmod(degrees, 360.0) * (3.14159265358979323846 / 180.0);
    EXPECT_NEAR(sine, std::sin(radians), 1e-15);
    EXPECT_NEAR(cosine, std::cos(radians), 1e-15);
  }
}

TEST(Catalog, EverySceneBuildsWithItsDefaults) {
  for (const SceneInfo& info : catalog()) {
    Parameters parameters = info.parameters;
    if (parameters.contains("worlds")) parameters["worlds"] = 3;
    const std::vector<Scene> worlds = build(info.name, parameters);
    ASSERT_FALSE(worlds.empty()) << info.name;
    EXPECT_EQ(worlds.front().name, info.name);
    EXPECT_FALSE(info.summary.empty());
    EXPECT_EQ(info.summary.find('\n'), std::string::npos);
    for (const SceneBody& body : worlds.front().bodies) {
      EXPECT_LE(body.first_shape + body.shape_count, worlds.front().shapes.size());
    }
  }
}

TEST(Catalog, RefusalsNameWhatTheyRefuseAndTheLimit) {
  EXPECT_NE(error_of("pille", {}).find("unknown scene \"pille\"; there are: large_pyramid"),
            std::string::npos);
  EXPECT_EQ(error_of("pile", {{"body", 10}}), "scene pile has no parameter \"body\"; it has: bodies, seed");
  EXPECT_EQ(error_of("pile", {{"bodies", 9}}), "scene pile: bodies = 9 must be from 10 to 10000000");
  EXPECT_EQ(error_of("pile", {{"bodies", 10.5}}), "scene pile: bodies = 10.5 must be a whole number");
  EXPECT_EQ(error_of("slope", {{"angle", -1}}), "scene slope: angle = -1 must be from 0 to 60");
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1e300}) {
    for (const SceneInfo& info : catalog()) {
      for (const auto& [name, unused] : info.parameters) {
        EXPECT_NE(error_of(info.name, {{name, bad}}), "no error") << info.name << " " << name;
      }
    }
  }
}

TEST(LargePyramid, EqualsThePublishedScene) {
  const Scene scene = build_scene("large_pyramid");
  ASSERT_EQ(scene.bodies.size(), 5051u);
  EXPECT_EQ(scene.steps, 200);
  EXPECT_FALSE(scene.settings.sleeping);
  EXPECT_FALSE(scene.settings.continuous);
  EXPECT_EQ(scene.settings.gravity, (Vec3{0, -10, 0}));
  EXPECT_EQ(std::get<Box>(geometry_of(scene, scene.bodies[0])).half_extents, (Vec3{400, 1, 400}));
  EXPECT_EQ(scene.bodies[0].def.position, (Vec3{0, -1, 0}));
  EXPECT_EQ(scene.bodies[1].def.position, (Vec3{-49.5f, 0.5f, 0}));
  EXPECT_EQ(scene.bodies[100].def.position, (Vec3{49.5f, 0.5f, 0}));
  EXPECT_EQ(scene.bodies[101].def.position, (Vec3{-49, 1.5f, 0}));
  EXPECT_EQ(scene.bodies.back().def.position, (Vec3{0, 99.5f, 0}));
  const SceneShape& shape = scene.shapes[scene.bodies.back().first_shape];
  EXPECT_EQ(shape.material.density, 100.0f);
  EXPECT_EQ(shape.material.friction, 0.6f);
  EXPECT_EQ(shape.material.restitution, 0.0f);
}

TEST(ManyPyramids, EqualThePublishedScene) {
  const Scene scene = build_scene("many_pyramids");
  ASSERT_EQ(scene.bodies.size(), 10781u);
  EXPECT_EQ(scene.steps, 100);
  EXPECT_FALSE(scene.settings.sleeping);
  EXPECT_FALSE(scene.settings.continuous);
  EXPECT_EQ(std::get<Box>(geometry_of(scene, scene.bodies[0])).half_extents, (Vec3{77, 1, 77}));
  EXPECT_EQ(scene.bodies[1].def.position, (Vec3{-76, 0.5f, -76}));
  EXPECT_EQ(scene.bodies[56].def.position, (Vec3{-65, 0.5f, -76}));
  EXPECT_EQ(scene.bodies[1 + 14 * 55].def.position,
            (Vec3{-76, 0.5f, static_cast<float>(-76 + 152.0 / 13.0)}));
  EXPECT_EQ(scene.bodies.back().def.position.z, 76.0f);
}

TEST(Pile, HasTheBodiesThatWereAskedForInsideItsWallsAndNoneOverlap) {
  for (const int count : {10, 11, 100, 2000}) {
    const Scene scene = build_scene("pile", {{"bodies", count}});
    ASSERT_EQ(scene.bodies.size(), static_cast<std::size_t>(count) + 1);
    const Vec3 floor = std::get<Box>(geometry_of(scene, scene.bodies[0])).half_extents;
    const float inside = floor.x - 2.0f;
    for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
      const Vec3 position = scene.bodies[i].def.position;
      const float radius = bounding_radius(geometry_of(scene, scene.bodies[i]));
      EXPECT_GE(position.y, radius);
      EXPECT_LE(std::max(std::abs(position.x), std::abs(position.z)) + radius, inside);
      for (std::size_t k = 1; k < i; ++k) {
        const Vec3 between = position - scene.bodies[k].def.position;
        const float other = bounding_radius(geometry_of(scene, scene.bodies[k]));
        EXPECT_GE(length(between), radius + other) << i << " " << k;
      }
    }
  }
}

TEST(Pile, MixesAllShapesAndSharesItsHulls) {
  const Scene scene = build_scene("pile", {{"bodies", 2000}});
  std::map<std::size_t, int> of_type;
  std::map<std::uint32_t, int> of_hull;
  std::set<std::size_t> vertices;
  for (const SceneBody& body : scene.bodies) {
    const Geometry& geometry = geometry_of(scene, body);
    ++of_type[geometry.index()];
    if (const auto* hull = std::get_if<ConvexHull>(&geometry)) {
      ++of_hull[body.first_shape];
      vertices.insert(hull->hull.vertices().size());
    }
  }
  ASSERT_EQ(of_type.size(), 4u);
  for (const auto& [type, count] : of_type) EXPECT_NEAR(count, 500, 100) << type;
  EXPECT_EQ(of_hull.size(), 8u);
  EXPECT_EQ(vertices, (std::set<std::size_t>{4, 6, 8, 10, 12, 16, 24, 32}));
}

TEST(HullZoo, HoldsHullsFromTheTetrahedronTo256VerticesAndThinOnes) {
  const Scene scene = build_scene("hull_zoo");
  ASSERT_EQ(scene.bodies.size(), 2001u);
  std::set<std::size_t> vertices;
  float thinnest = 1.0f, most_slender = 1.0f;
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    const Hull& hull = std::get<ConvexHull>(geometry_of(scene, scene.bodies[i])).hull;
    EXPECT_FALSE(hull.report().simplified());
    vertices.insert(hull.vertices().size());
    Vec3 low = hull.vertices().front();
    Vec3 high = low;
    for (const Vec3 v : hull.vertices()) {
      low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
      high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
    std::array<float, 3> size{high.x - low.x, high.y - low.y, high.z - low.z};
    std::sort(size.begin(), size.end());
    thinnest = std::min(thinnest, size[0] / size[1]);
    most_slender = std::min(most_slender, size[1] / size[2]);
  }
  for (const std::size_t count : {4u, 6u, 8u, 10u, 16u, 24u, 32u, 64u, 128u, 256u})
    EXPECT_TRUE(vertices.contains(count)) << count;
  EXPECT_LE(thinnest, 0.06f);      // plates and slivers
  EXPECT_LE(most_slender, 0.08f);  // needles
  const Scene few = build_scene("hull_zoo", {{"max_vertices", 8}, {"bodies", 200}});
  for (std::size_t i = 1; i < few.bodies.size(); ++i) {
    EXPECT_LE(std::get<ConvexHull>(geometry_of(few, few.bodies[i])).hull.vertices().size(), 8u);
  }
}

TEST(ConvexPile, EqualsThePublishedScene) {
  const Scene scene = build_scene("convex_pile");
  ASSERT_EQ(scene.bodies.size(), 5121u);
  EXPECT_EQ(scene.steps, 500);
  EXPECT_TRUE(scene.settings.sleeping);
  EXPECT_TRUE(scene.settings.continuous);
  EXPECT_EQ(scene.settings.gravity, (Vec3{0, -10, 0}));
  EXPECT_EQ(std::get<Box>(geometry_of(scene, scene.bodies[0])).half_extents, (Vec3{250, 1, 250}));
  EXPECT_EQ(scene.bodies[0].def.position, (Vec3{0, -1, 0}));
  EXPECT_EQ(scene.bodies[1].def.position, (Vec3{-16, 2, -16}));
  EXPECT_EQ(scene.bodies[2].def.position, (Vec3{-12, 2, -16}));
  EXPECT_EQ(scene.bodies[9].def.position, (Vec3{-16, 2, -12}));
  EXPECT_EQ(scene.bodies.back().def.position, (Vec3{12, 318, 12}));
  const Hull& hull = std::get<ConvexHull>(geometry_of(scene, scene.bodies[1])).hull;
  ASSERT_EQ(hull.vertices().size(), 32u);
  for (const Vec3 vertex : hull.vertices()) EXPECT_NEAR(length(vertex), 2.0f, 1e-6f);
  for (const SceneBody& body : scene.bodies) EXPECT_LE(body.first_shape, 1u);  // one hull for all
}

TEST(RandomSpherePoints, FollowThePublishedGenerator) {
  // The first state is 42 * 2147001325 + 715136305 modulo 2^32.
  const std::vector<Vec3> points = random_sphere_points(32, 2.0f, 42);
  std::uint64_t state = 42;
  const auto next = [&state] {
    state = (state * 2147001325u + 715136305u) % (std::uint64_t{1} << 32);
    return static_cast<double>(state % 65536) / 65535.0 - 0.5;
  };
  for (const Vec3 point : points) {
    double x = next(), y = next(), z = next();
    while (x * x + y * y + z * z > 0.25) {
      x = next();
      y = next();
      z = next();
    }
    const double scale = 2.0 / std::sqrt(x * x + y * y + z * z);
    EXPECT_NEAR(point.x, x * scale, 1e-6);
    EXPECT_NEAR(point.y, y * scale, 1e-6);
    EXPECT_NEAR(point.z, z * scale, 1e-6);
  }
}

TEST(Junkyard, EqualsThePublishedScene) {
  const Scene scene = build_scene("junkyard");
  ASSERT_EQ(scene.bodies.size(), 10586u);
  EXPECT_EQ(scene.steps, 500);
  EXPECT_TRUE(scene.settings.sleeping);
  EXPECT_TRUE(scene.settings.continuous);
  EXPECT_EQ(scene.bodies[0].shape_count, 5u);
  EXPECT_EQ(scene.bodies[0].def.position, (Vec3{0, -1, 0}));
  EXPECT_EQ(scene.shapes[1].options.local_pose.position, (Vec3{-50, 8, 0}));
  EXPECT_EQ(scene.shapes[4].options.local_pose.position, (Vec3{0, 8, 50}));
  EXPECT_EQ(std::get<Box>(scene.shapes[4].geometry).half_extents, (Vec3{50, 8, 1}));
  EXPECT_EQ(scene.bodies[1].def.position, (Vec3{-40, 25, -40}));
  EXPECT_EQ(scene.bodies[2].def.position, (Vec3{-40, 25, -36}));
  EXPECT_EQ(scene.bodies[10584].def.position, (Vec3{40, 117, 40}));
  const Hull& rock = std::get<ConvexHull>(geometry_of(scene, scene.bodies[1])).hull;
  ASSERT_EQ(rock.vertices().size(), 10u);
  for (const Vec3 vertex : rock.vertices()) EXPECT_NEAR(length(vertex), 1.5f, 1e-6f);
  const SceneBody& pusher = scene.bodies.back();
  EXPECT_EQ(pusher.def.type, BodyType::kinematic);
  EXPECT_EQ(pusher.def.position, (Vec3{35, 0, 0}));
  const Hull& prism = std::get<ConvexHull>(geometry_of(scene, pusher)).hull;
  EXPECT_EQ(prism.vertices().size(), 32u);
  EXPECT_EQ(prism.face_count(), 18u);
  EXPECT_EQ(prism.vertices().front().x, -4.0f);
}

TEST(Junkyard, ThePusherGoesRoundAtSixDegreesASecondAndDoesNotTurn) {
  const Scene scene = build_scene("junkyard", {{"columns", 1}, {"layers", 1}});
  ASSERT_EQ(scene.drives.size(), 1u);
  EXPECT_EQ(scene.drives[0].body, 2u);
  EXPECT_EQ(drive_target(scene.drives[0], 0.0).position, (Vec3{35, 0, 0}));
  for (const double seconds : {1.0 / 60.0, 1.0, 15.0, 33.3}) {
    const Pose pose = drive_target(scene.drives[0], seconds);
    const double angle = -6.0 * seconds * 3.14159265358979323846 / 180.0;
    EXPECT_NEAR(pose.position.x, 35.0 * std::cos(angle), 1e-5);
    EXPECT_EQ(pose.position.y, 0.0f);
    EXPECT_NEAR(pose.position.z, 35.0 * std::sin(angle), 1e-5);
    EXPECT_EQ(pose.rotation, Quat{});
  }
  EXPECT_EQ(drive_target(scene.drives[0], 15.0).position.z, -35.0f);
}

TEST(DriveTarget, TurnsABodyAboutAnyAxis) {
  SceneDrive drive;
  drive.start = {{3, 1, 0}, {0, 0, 1, 0}};
  drive.center = {1, 1, 5};
  drive.axis = {0, 0, 2};
  drive.degrees_per_second = 90.0;
  const Pose quarter = drive_target(drive, 1.0);
  EXPECT_EQ(quarter.position, (Vec3{1, 3, 0}));
  const Vec3 turned = rotate(quarter.rotation, {1, 0, 0});  // by 180 and then 90 degrees about z
  EXPECT_NEAR(turned.x, 0.0f, 1e-6f);
  EXPECT_NEAR(turned.y, -1.0f, 1e-6f);
  EXPECT_EQ(drive_target(drive, 4.0).position, drive.start.position);
}

TEST(Drive, BringsABodyToItsTargetStepByStep) {
  const Scene scene = build_scene("junkyard", {{"columns", 1}, {"layers", 1}});
  World world(scene.settings);
  const std::vector<BodyId> bodies = populate(world, scene);
  Workers workers{1};
  for (int i = 0; i < 120; ++i) {
    drive(world, scene.drives, bodies, i, scene.dt);
    step(world, scene.dt, workers);
    const Pose target = drive_target(scene.drives[0], (i + 1) * double{scene.dt});
    EXPECT_LT(length(world.pose(bodies[2]).position - target.position), 1e-4f) << i;
  }
}

TEST(Builders, GiveTheSameBitsOnEveryMachine) {
  EXPECT_EQ(bits_of(build_scene("pile", {{"bodies", 1000}})), 0x6069e7979ed91664u);
  EXPECT_EQ(bits_of(build_scene("card_house")), 0x82e01bb17a1468f1u);
  EXPECT_EQ(bits_of(build_scene("kapla")), 0x63f96077e77c7c1du);
  EXPECT_EQ(bits_of(build_scene("slope")), 0xd14b72763c57cc79u);
}

TEST(Pile, SeedsChangeItAndNothingElseDoes) {
  const auto bits = [](double seed) {
    return bits_of(build_scene("pile", {{"bodies", 50}, {"seed", seed}}));
  };
  EXPECT_EQ(bits(3), bits(3));
  EXPECT_NE(bits(3), bits(4));
}

TEST(ManyWorlds, AreIndependentPiles) {
  const std::vector<Scene> worlds = build("many_worlds", {{"worlds", 5}, {"seed", 9}});
  ASSERT_EQ(worlds.size(), 5u);
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    EXPECT_EQ(worlds[i].bodies.size(), 101u);
    EXPECT_EQ(bits_of(worlds[i]),
              bits_of(build_scene("pile", {{"bodies", 100}, {"seed", 9.0 + static_cast<double>(i)}})));
  }
}

TEST(Wall, BricksFillEveryRowWithoutOverlap) {
  const Scene scene = build_scene("wall", {{"columns", 7}, {"rows", 4}});
  for (int row = 0; row < 4; ++row) {
    float filled = 0.0f;
    for (const SceneBody& body : scene.bodies) {
      if (body.def.position.y != 0.25f + 0.5f * static_cast<float>(row)) continue;
      filled += 2.0f * std::get<Box>(geometry_of(scene, body)).half_extents.x;
      EXPECT_LE(std::abs(body.def.position.x), 3.5f);
    }
    EXPECT_EQ(filled, 7.0f);
  }
}

TEST(CardHouse, LeaningPairsTouchTheGroundAndEachOther) {
  const Scene scene = build_scene("card_house", {{"stories", 4}});
  for (int i = 0; i < 4; ++i) {
    const SceneBody& left = scene.bodies[static_cast<std::size_t>(1 + 2 * i)];
    const SceneBody& right = scene.bodies[static_cast<std::size_t>(2 + 2 * i)];
    EXPECT_NEAR(lowest(scene, left), 0.0f, 1e-6f);
    EXPECT_NEAR(lowest(scene, right), 0.0f, 1e-6f);
    float left_reach = -100.0f;
    float right_reach = 100.0f;
    for (const Vec3& corner : corners(scene, left)) left_reach = std::max(left_reach, corner.x);
    for (const Vec3& corner : corners(scene, right)) right_reach = std::min(right_reach, corner.x);
    EXPECT_NEAR(left_reach, right_reach, 1e-6f);
  }
}

TEST(CardHouse, EveryCardRestsOnCardsBelowAndIsOneCentimeterThick) {
  const Scene scene = build_scene("card_house", {{"stories", 5}});
  std::vector<float> tops{0.0f};  // of the ground and the cards
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) tops.push_back(highest(scene, scene.bodies[i]));
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    const float low = lowest(scene, scene.bodies[i]);
    float nearest = 1.0f;
    for (std::size_t k = 0; k < tops.size(); ++k) {
      if (k != i) nearest = std::min(nearest, std::abs(tops[k] - low));
    }
    EXPECT_LT(nearest, 2e-6f) << "card " << i;
    const Vec3 half = std::get<Box>(geometry_of(scene, scene.bodies[i])).half_extents;
    EXPECT_FLOAT_EQ(std::min({half.x, half.y, half.z}), 0.005f);
  }
}

TEST(Slope, BoxesLieOnTheRampAndHaveRisingFriction) {
  const Scene scene = build_scene("slope", {{"boxes", 5}, {"angle", 30}});
  ASSERT_EQ(scene.bodies.size(), 7u);
  const BodyDef& ramp = scene.bodies[1].def;
  for (std::size_t i = 2; i < 7; ++i) {
    const Vec3 local = rotate_back(ramp.rotation, scene.bodies[i].def.position - ramp.position);
    EXPECT_NEAR(local.y, 0.75f, 1e-5f);
    EXPECT_EQ(scene.bodies[i].def.rotation, ramp.rotation);
    const Material& material = scene.shapes[scene.bodies[i].first_shape].material;
    EXPECT_NEAR(material.friction, 0.1 + 0.125 * static_cast<double>(i - 2), 1e-6);
    EXPECT_EQ(material.friction_mix, MixRule::product);
  }
}

TEST(SpheresInBox, AreAllInsideTheBox) {
  const Scene scene = build_scene("spheres_in_box", {{"bodies", 500}});
  ASSERT_EQ(scene.bodies.size(), 501u);
  EXPECT_EQ(scene.bodies[0].shape_count, 6u);
  const float inside = std::get<Box>(scene.shapes[0].geometry).half_extents.x - 2.0f;
  const float lid = scene.shapes[5].options.local_pose.position.y - 1.0f;
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    const Vec3 position = scene.bodies[i].def.position;
    EXPECT_LE(std::max(std::abs(position.x), std::abs(position.z)) + 0.25f, inside);
    EXPECT_GE(position.y - 0.25f, 0.0f);
    EXPECT_LE(position.y + 0.25f, lid);
  }
}

}  // namespace
}  // namespace scree::scenes
