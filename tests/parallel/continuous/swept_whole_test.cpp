// Laws of full sweeps: whatever their shape, at any speed and spin, such bodies pass nothing, however thin it
// is, and go on as others do where nothing is in the way.
#include <scree/height_field.h>
#include <tests/physics/lab.h>

#include <string>
#include <vector>

namespace scree::physics {
namespace {

const float kThin = 0.01f;  // m

BodyDef full(BodyDef def) {
  def.full_sweep = true;
  return def;
}

// Whether a plate that flies face ahead meets the end of a needle, at a place where no ball within the plate
// passes. It may swing on beside the needle, which meets it off its center.
bool meets(bool full_sweep, float speed, const Geometry& needle, int spread) {
  Lab lab(without_gravity());
  lab.add({.type = BodyType::fixed}, needle);
  BodyDef def{.position = {0.37f, 3.0f + 0.013f * static_cast<float>(spread), 0.23f},
              .linear_velocity = {0, -speed, 0}};
  def.full_sweep = full_sweep;
  const BodyId plate = lab.add(def, Box{{1.0f, kThin, 1.0f}});
  for (int i = 0; i < 60 && lab.position(plate).y() > -2.0; ++i) lab.run(1);
  return lab.velocity(plate).y() > -0.99f * speed;
}

TEST(SweptWhole, AFlatPlatePassesNoNeedle) {
  for (const float speed : {20.0f, 60.0f, 150.0f, 390.0f}) {
    for (int spread = 0; spread < 10; ++spread) {
      for (const Geometry& needle : {Geometry{Capsule{0.5f, kThin}}, Geometry{Box{{kThin, 0.5f, kThin}}}}) {
        EXPECT_TRUE(meets(true, speed, needle, spread)) << speed << " m/s, " << spread;
      }
    }
  }
}

TEST(SweptWhole, WithoutItSuchAPlateMayPass) {
  int passed = 0;
  for (int spread = 0; spread < 10; ++spread)
    passed += meets(false, 150.0f, Capsule{0.5f, kThin}, spread) ? 0 : 1;
  EXPECT_GT(passed, 0) << "else the law above is none of full sweeps";
}

// Two rods that cross each other's way in the air, each thinner than its way in a step is long.
void expect_rods_meet(float thin, float speed, int spreads) {
  int passed_without = 0;
  for (const bool full_sweep : {false, true}) {
    for (int spread = 0; spread < spreads; ++spread) {
      Lab lab(without_gravity());
      const float shift = 0.021f * static_cast<float>(spread);
      BodyDef left{.position = {-2.0f - shift, 0.31f, 0.43f}, .linear_velocity = {speed, 0, 0}};
      BodyDef right{.position = {2, 0, 0}, .linear_velocity = {-speed, 0, 0}};
      left.full_sweep = right.full_sweep = full_sweep;
      const BodyId a = lab.add(left, Box{{thin, 1.0f, thin}});
      const BodyId b = lab.add(right, Box{{thin, thin, 1.0f}});
      lab.run(20 + static_cast<int>(5.0f / speed / kStep));
      const bool met = lab.velocity(a).x() < 0.9 * speed && lab.velocity(b).x() > -0.9 * speed;
      if (full_sweep) {
        EXPECT_TRUE(met) << thin << " m, " << speed << " m/s, " << spread << ": " << lab.velocity(a).x();
      } else {
        passed_without += met ? 0 : 1;
      }
    }
  }
  EXPECT_TRUE(speed < 80.0f || passed_without > 0) << "else the law is none of full sweeps";
}

TEST(SweptWhole, RodsThatCrossMeet) {
  expect_rods_meet(kThin, 90.0f, 20);
  for (const float speed : {2.0f, 5.0f, 10.0f, 20.0f, 90.0f}) expect_rods_meet(0.002f, speed, 10);
}

// A rod that spins in place beside a post that its ends would sweep.
TEST(SweptWhole, ASpinningRodIsStoppedByAPost) {
  for (const float spin : {20.0f, 60.0f, 120.0f}) {
    for (int spread = 0; spread < 12; ++spread) {
      Lab lab(without_gravity());
      lab.add({.type = BodyType::fixed, .position = {0.93f, 0, 0}}, Capsule{1.0f, kThin});
      const float angle = 0.2f + 0.2f * static_cast<float>(spread);
      const BodyId rod =
          lab.add(full({.rotation = from_axis_angle({0, 1, 0}, angle), .angular_velocity = {0, spin, 0}}),
                  Box{{1.0f, kThin, kThin}});
      bool stopped = false;
      for (int i = 0; i < 30 && !stopped; ++i) {
        lab.run(1);
        stopped = std::abs(lab.world.angular_velocity(rod).y) < 0.9f * spin;
      }
      EXPECT_TRUE(stopped) << spin << " rad/s, " << angle;
    }
  }
}

// A slab that tumbles through the air above a ridge and pits of a mesh.
TEST(SweptWhole, NoTumblingSlabGetsBehindAMesh) {
  constexpr int kColumns = 24, kRows = 24;
  std::vector<float> heights(kColumns * kRows);
  Random random(5);
  for (float& height : heights) height = random.uniform(0.0f, 0.8f);
  const TriangleMesh mesh = height_field_mesh({.columns = kColumns, .rows = kRows, .heights = heights});
  int judged = 0;
  for (int i = 0; i < 40; ++i) {
    Lab lab;
    lab.add({.type = BodyType::fixed, .position = {-12, 0, -12}}, mesh);
    const BodyId slab =
        lab.add(full({.position = {random.uniform(-6, 6), 4, random.uniform(-6, 6)},
                      .linear_velocity = {random.uniform(-20, 20), -random.uniform(20, 200), 0},
                      .angular_velocity = random.vector(40)}),
                Box{{0.6f, 0.02f, 0.4f}});
    lab.run(90);
    const Eigen::Vector3d place = lab.position(slab);
    if (std::abs(place.x()) < 11.0 && std::abs(place.z()) < 11.0) {
      ++judged;
      EXPECT_GT(place.y(), -0.05) << i;
    }
  }
  EXPECT_GT(judged, 10);
}

TEST(SweptWhole, AHalfSpaceStopsIt) {
  for (const float speed : {50.0f, 390.0f}) {
    Lab lab(without_gravity());
    lab.add({.type = BodyType::fixed}, HalfSpace{});
    const BodyId rod = lab.add(
        full({.position = {0, 5, 0}, .linear_velocity = {0, -speed, 0}, .angular_velocity = {30, 0, 0}}),
        Box{{kThin, 1.0f, kThin}});
    for (int i = 0; i < 60; ++i) {
      lab.run(1);
      ASSERT_GT(lab.position(rod).y(), -0.01) << speed << " m/s, step " << i;
    }
  }
}

// Grounds to slide over, level at y = 0 and 60 m long.
void add_whole(Lab& lab) { lab.add_ground({.friction = 0.0f}, {}, 200.0f); }
void add_tiles(Lab& lab) {
  const Material smooth{.friction = 0.0f};
  for (int i = -2; i < 60; ++i)
    lab.add({.type = BodyType::fixed, .position = {static_cast<float>(i), -0.5f, 0}}, Box{}, smooth);
}
void add_mesh(Lab& lab) {
  const std::vector<float> heights(130 * 9);
  lab.add({.type = BodyType::fixed, .position = {-4, 0, -2}},
          height_field_mesh(
              {.columns = 130, .rows = 9, .heights = heights, .spacing_x = 0.5f, .spacing_z = 0.5f}),
          {.friction = 0.0f});
}

// In contact a body is not stopped: it slides as without, over seams of its ground, too.
TEST(SweptWhole, WhatSlidesFastIsNotHeld) {
  for (const auto add_floor : {add_whole, add_tiles, add_mesh}) {
    for (const float speed : {5.0f, 20.0f}) {
      Lab lab;
      add_floor(lab);
      const BodyId box = lab.add(full({.position = {0.1f, 0.1f, 0.03f}, .linear_velocity = {speed, 0, 0}}),
                                 Box{{0.1f, 0.1f, 0.1f}}, {.friction = 0.0f});
      lab.run(120);
      EXPECT_NEAR(lab.velocity(box).x(), speed, 1e-3 * speed) << speed;
      EXPECT_NEAR(lab.position(box).x(), 0.1 + 2.0 * speed, 1e-3 * speed) << speed;
    }
  }
}

// Where nothing is in the way, a full sweep changes nothing.
TEST(SweptWhole, InFreeFlightItChangesNothing) {
  std::uint64_t hashes[2];
  for (const bool full_sweep : {false, true}) {
    Lab lab;
    lab.add_ground();
    Random random(3);
    for (int i = 0; i < 20; ++i) {
      BodyDef def{.position = {4.0f * static_cast<float>(i), 300, 0},
                  .linear_velocity = random.vector(100),
                  .angular_velocity = random.vector(50)};
      def.full_sweep = full_sweep;
      lab.add(def, Box{{0.5f, 0.1f, 0.2f}});
    }
    lab.run(30);
    hashes[full_sweep ? 1 : 0] = lab.world.hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(SweptWhole, ItStaysAcrossTypesMassesAndSnapshots) {
  World world;
  const BodyId body = world.create_body(full({}));
  const BodyId other = world.create_body({});
  world.add_shape(body, Box{});
  world.set_body_type(body, BodyType::kinematic);
  world.set_body_type(body, BodyType::dynamic);
  world.set_locks(body, AxisLocks::rotation_x);
  world.set_mass_properties(body, {.mass = 3.0f});
  world.reset_mass(body);
  EXPECT_TRUE(world.full_sweep(body));
  EXPECT_FALSE(world.full_sweep(other));
  Snapshot snapshot;
  save(world, snapshot);
  world.set_full_sweep(body, false);
  world.set_full_sweep(other, true);
  EXPECT_FALSE(world.full_sweep(body));
  EXPECT_TRUE(world.full_sweep(other));
  restore(world, snapshot);
  EXPECT_TRUE(world.full_sweep(body));
  EXPECT_FALSE(world.full_sweep(other));
}

TEST(SweptWhole, DoesTheSameForEveryInstructionSetAndThreadCount) {
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Lab lab;
      lab.add_ground();
      Random random(9);
      for (int i = 0; i < 60; ++i) {
        lab.add(full({.position = random.vector(3) + Vec3{0, 5, 0},
                      .linear_velocity = random.vector(150),
                      .angular_velocity = random.vector(60)}),
                Box{{0.6f, 0.02f, 0.1f}});
      }
      Workers workers({.threads = threads, .isa = isa});
      for (int i = 0; i < 30; ++i) step(lab.world, kStep, workers);
      hashes.push_back(lab.world.hash());
    }
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

}  // namespace
}  // namespace scree::physics
