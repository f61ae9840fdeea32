// Laws of sweeps against meshes: at any speed no body passes through the front of a triangle, and none is
// stopped by its back.
#include <core/plain/rows.h>
#include <tests/parallel/queries/mesh_fixture.h>
#include <tests/physics/lab.h>

namespace scree::physics {
namespace {

using testing::Dice;
using testing::Point;
using testing::to_point;
using testing::Triangle;
using testing::TriangleSoup;

constexpr float kBullet = 1000.0f;  // m/s: 16.7 m a step

const Geometry kBullets[] = {Sphere{0.05f}, Sphere{0.5f}, Capsule{0.1f, 0.05f}, Box{{0.05f, 0.07f, 0.06f}},
                             ConvexHull{Dice::hull(0), {0.2f, 0.2f, 0.2f}}};

WorldSettings without_limits() {
  WorldSettings settings = without_gravity();
  settings.max_linear_speed = 1e6f;
  return settings;
}

struct Floor {
  Lab lab;
  TriangleSoup soup;
  BodyId body;
  ShapeId shape;
  std::vector<Triangle> triangles;
  std::vector<BodyId> bullets;

  Floor(TriangleSoup given, const Pose& pose, const WorldSettings& settings = without_limits())
      : lab(settings), soup(std::move(given)) {
    body = lab.world.create_body(
        {.type = BodyType::fixed, .position = pose.position, .rotation = pose.rotation});
    shape = lab.world.add_shape(body, soup.mesh());
    triangles = testing::triangles_of(lab.world, shape, soup);
  }
  void shoot(const Geometry& bullet, Vec3 from, Vec3 velocity, Quat rotation = {}) {
    bullets.push_back(lab.add({.position = from, .rotation = rotation, .linear_velocity = velocity}, bullet));
  }
  Point center(BodyId bullet) const { return to_point(lab.world.center_of_mass(bullet)); }
  // Steps, and returns how many bullets' centers have come through a front.
  int passes(int steps) {
    int count = 0;
    for (int i = 0; i < steps; ++i) {
      std::vector<Point> before;
      for (const BodyId bullet : bullets) before.push_back(center(bullet));
      lab.run(1);
      for (std::size_t k = 0; k < bullets.size(); ++k) {
        const Point way = center(bullets[k]) - before[k];
        if (!(norm(way) > 0.0)) continue;
        for (const Triangle& triangle : triangles) {
          const auto crossing = testing::crossing_of(triangle, before[k], way);
          if (crossing.from_front && crossing.within >= 0.0 && crossing.fraction >= 0.0 &&
              crossing.fraction <= 1.0) {
            ++count;
            break;
          }
        }
      }
    }
    return count;
  }
};

// A hilly ground of triangles of `size` meters, centered at the origin of its frame.
TriangleSoup hills(Dice& dice, int squares, float size) {
  TriangleSoup soup = testing::whole_meters(dice, squares, 2);
  const float half = 0.5f * static_cast<float>(squares);
  for (Vec3& v : soup.vertices) v = {size * (v.x - half), 0.4f * size * v.y, size * (v.z - half)};
  return soup;
}

TEST(SweptMeshes, NoBulletPassesAFloor) {
  Dice dice(31);
  for (const float size : {0.05f, 1.0f, 20.0f}) {
    for (const Geometry& bullet : kBullets) {
      const Pose pose{dice.within({30, 30, 30}), dice.rotation()};
      const float reach = 0.3f * 20.0f * size;
      Floor floor(hills(dice, 20, size), pose);
      for (int i = 0; i < 30; ++i) {
        const Vec3 at = dice.within({reach, 0, reach});
        const Vec3 down = normalize(Vec3{dice.uniform(-0.3f, 0.3f), -1, dice.uniform(-0.3f, 0.3f)});
        const float height = dice.uniform(0.6f, 0.9f) * std::min(16.0f, 10.0f * size) + size;
        const Vec3 from = at + Vec3{0, height, 0};
        floor.shoot(bullet, pose.position + rotate(pose.rotation, from),
                    kBullet * rotate(pose.rotation, down), dice.rotation());
      }
      EXPECT_EQ(floor.passes(4), 0) << size;
      EXPECT_GT(floor.lab.world.stats().swept_bodies, 0);
    }
  }
}

TEST(SweptMeshes, NoBulletPassesTheFirstOfManyFloors) {
  // More meshes than have lists of triangles, coarse and fine, and more shapes than are listed at all.
  Dice dice(37);
  constexpr int kFloors = 5;
  for (int round = 0; round < kFloors; ++round) {
    for (const int posts : {0, 30}) {
      Lab lab(without_limits());
      for (int i = 0; i < kFloors; ++i) {
        const int floor = (i + round) % kFloors;  // every one comes first in the list once
        const float size = floor % 2 == 0 ? 0.1f : 4.0f;
        TriangleSoup flat = testing::whole_meters(dice, floor % 2 == 0 ? 40 : 2, 2);
        const float half = floor % 2 == 0 ? 20.0f : 1.0f;
        for (Vec3& v : flat.vertices)
          v = {size * (v.x - half), -static_cast<float>(floor), size * (v.z - half)};
        lab.world.add_shape(lab.world.create_body({.type = BodyType::fixed}), flat.mesh());
      }
      for (int i = 0; i < posts; ++i) {
        const Vec3 place{0.6f * static_cast<float>(i % 6) - 1.5f, -0.4f,
                         0.6f * static_cast<float>(i / 6) - 1.5f};
        lab.add({.type = BodyType::fixed, .position = place}, Sphere{0.05f});
      }
      const BodyId bullet = lab.world.create_body(
          {.position = {0.11f, 4.0f, 0.07f}, .linear_velocity = {0.0f, -0.9f * kBullet, 0.0f}});
      for (const float x : {-0.2f, 0.0f, 0.2f})
        lab.world.add_shape(bullet, Sphere{0.05f}, {}, {.local_pose = {{x, 0.0f, 0.0f}, {}}});
      lab.run(3);
      EXPECT_GT(lab.world.center_of_mass(bullet).y, 0.0f) << round << " " << posts;
    }
  }
}

// Ways of some bodies are asked for what is near together.
TEST(SweptMeshes, ABodyMovesAmongOthersAsItMovesAlone) {
  constexpr int kBodies = 60, kSteps = 25;
  const auto fall = [](int only, std::vector<Vec3>& places) {
    Dice dice(38);
    Floor floor(hills(dice, 60, 1.0f), {{3, 1, 2}, from_axis_angle({1, 0, 1}, 0.2f)}, WorldSettings{});
    for (int i = 0; i < kBodies; ++i) {
      const float column = static_cast<float>(i % 8) - 3.5f, row = static_cast<float>(i / 8) - 3.5f;
      const Vec3 from{3.0f + 4.0f * column, dice.uniform(5.0f, 10.0f), 2.0f + 4.0f * row};
      const Vec3 velocity{0, dice.uniform(-30.0f, -10.0f), dice.uniform(-1.0f, 1.0f)};
      const Quat rotation = dice.rotation();
      const Geometry bullet = dice.geometry(0.2f);
      if (only < 0 || only == i) floor.shoot(bullet, from, velocity, rotation);
    }
    std::int64_t hits = 0;
    for (int i = 0; i < kSteps; ++i) {
      floor.lab.run(1);
      hits += floor.lab.world.stats().sweep_hits;
      for (const BodyId body : floor.bullets) places.push_back(floor.lab.world.pose(body).position);
    }
    return hits;
  };
  std::vector<Vec3> together;
  EXPECT_GT(fall(-1, together), 20);
  int same = 0;
  for (int i = 0; i < kBodies; ++i) {
    std::vector<Vec3> alone;
    fall(i, alone);
    for (int k = 0; k < kSteps; ++k) {
      const auto place = static_cast<std::size_t>(k);
      same += alone[place] == together[kBodies * place + static_cast<std::size_t>(i)] ? 1 : 0;
    }
  }
  EXPECT_EQ(same, kBodies * kSteps);
}

TEST(SweptMeshes, WithoutSweepsBulletsPass) {
  Dice dice(32);
  WorldSettings settings = without_limits();
  settings.continuous = false;
  Floor floor(hills(dice, 20, 1.0f), {}, settings);
  floor.shoot(Sphere{0.05f}, {0.3f, 5, 0.2f}, {0, -kBullet, 0});
  EXPECT_EQ(floor.passes(2), 1);
}

TEST(SweptMeshes, ABulletStopsAtTheSurfaceAndKeepsItsVelocity) {
  for (const float reach : {1.0f, 100.0f, 1e4f}) {
    TriangleSoup soup;
    soup.vertices = {{-reach, 0, -reach}, {-reach, 0, reach}, {reach, 0, -reach}, {reach, 0, reach}};
    soup.triangles = {{0, 1, 2}, {2, 1, 3}};
    Floor floor(soup, {{3, 1, 2}, {}});
    floor.shoot(Sphere{0.1f}, {3.25f, 8, 2.5f}, {0, -kBullet, 0});
    floor.lab.run(1);
    EXPECT_NEAR(floor.center(floor.bullets[0]).y, 1.1, 2e-3) << reach;
    EXPECT_EQ(floor.lab.world.linear_velocity(floor.bullets[0]).y, -kBullet);
    EXPECT_EQ(floor.lab.world.stats().sweep_hits, 1);
  }
}

TEST(SweptMeshes, FromBehindBodiesPass) {
  Dice dice(33);
  Floor floor(hills(dice, 20, 1.0f), {});
  for (int i = 0; i < 20; ++i) {
    const Vec3 at = dice.within({5, 0, 5});
    floor.shoot(Sphere{0.05f}, at + Vec3{0, -8, 0}, {0, kBullet, 0});
  }
  floor.lab.run(1);
  EXPECT_EQ(floor.lab.world.stats().swept_bodies, 20);
  EXPECT_EQ(floor.lab.world.stats().sweep_hits, 0);
  for (const BodyId bullet : floor.bullets) EXPECT_GT(floor.center(bullet).y, 8.0);
}

TEST(SweptMeshes, NoBodyLeavesAClosedRoom) {
  Dice dice(34);
  TriangleSoup room = testing::bumpy_ball(dice, 9, 14, 3.0f, 4.0f);
  for (MeshTriangle& triangle : room.triangles) std::swap(triangle.b, triangle.c);  // seen from within
  const Pose pose{{10, -20, 30}, dice.rotation()};
  Floor floor(room, pose);
  for (const Geometry& bullet : kBullets) {
    for (int i = 0; i < 8; ++i) {
      floor.shoot(bullet, pose.position + dice.within({1, 1, 1}),
                  kBullet * normalize(dice.within({1, 1, 1}) + Vec3{0.01f, 0, 0}), dice.rotation());
      ShapeId shape;
      floor.lab.world.shapes_of(floor.bullets.back(), {&shape, 1});
      floor.lab.world.set_filter(shape, {.group = -1});
    }
  }
  EXPECT_EQ(floor.passes(60), 0);
}

TEST(SweptMeshes, BodiesThatSlideOverSeamsAreNotStopped) {
  Dice dice(35);
  TriangleSoup flat = hills(dice, 40, 0.5f);
  for (Vec3& v : flat.vertices) v.y = 0.0f;
  Floor floor(flat, {});
  for (int i = 0; i < 10; ++i)
    floor.shoot(Sphere{0.1f}, {-9, 0.1f - 0.5f * kLinearSlop, 0.37f * static_cast<float>(i) - 1.5f},
                {60, 0, 7});
  for (int i = 0; i < 10; ++i) {
    floor.lab.run(1);
    EXPECT_EQ(floor.lab.world.stats().sweep_hits, 0);
  }
  for (const BodyId bullet : floor.bullets) EXPECT_NEAR(floor.center(bullet).x, -9 + 10 * 60.0 / 60.0, 0.05);
}

TEST(SweptMeshes, BodiesThatDoNotCollideWithItDoNotStop) {
  Dice dice(36);
  Floor floor(hills(dice, 20, 1.0f), {});
  floor.lab.world.set_filter(floor.shape, {.category = 2});
  const BodyId bullet =
      floor.lab.world.create_body({.position = {0, 5, 0}, .linear_velocity = {0, -kBullet, 0}});
  floor.lab.world.add_shape(bullet, Sphere{0.05f}, {}, {.filter = {.mask = 1}});
  floor.lab.run(1);
  EXPECT_EQ(floor.lab.world.stats().sweep_hits, 0);
  EXPECT_LT(floor.center(bullet).y, -11.0);
}

TEST(SweptMeshes, DoTheSameForEveryInstructionSetAndThreadCount) {
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Dice dice(37);
      Workers workers({.threads = threads, .isa = isa});
      const Quat rotation = dice.rotation();
      Floor floor(hills(dice, 20, 1.0f), {{1, 2, 3}, rotation});
      for (int i = 0; i < 100; ++i) {
        const Vec3 at = dice.within({6, 0, 6});
        floor.shoot(kBullets[i % 5], Vec3{1, 2, 3} + rotate(rotation, at + Vec3{0, 9, 0}),
                    kBullet * rotate(rotation, Vec3{0, -1, 0}), dice.rotation());
      }
      for (int i = 0; i < 5; ++i) step(floor.lab.world, kStep, workers);
      hashes.push_back(floor.lab.world.hash());
    }
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

}  // namespace
}  // namespace scree::physics
