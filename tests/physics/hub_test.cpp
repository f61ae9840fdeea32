// Laws of hubs: bodies with so many contacts that these are solved in groups.
#include <parallel/constraints/constraints.h>
#include <tests/physics/lab.h>

#include <algorithm>

namespace scree::physics {
namespace {

int hub_chunks(World& world) {
  const Constraints& constraints = constraints_of(internals(world));
  return static_cast<int>(
      std::count_if(constraints.contact_chunks.begin(), constraints.contact_chunks.end(),
                    [](const simd::ConstraintChunk& chunk) { return chunk.hub != simd::BodySide::none; }));
}

// A plate on the ground with columns x columns stacks of two boxes on it.
std::vector<BodyId> add_loaded_plate(Lab& lab, int columns) {
  lab.add_ground();
  const float half = 0.75f * static_cast<float>(columns);
  std::vector<BodyId> bodies;
  bodies.push_back(lab.add({.position = {0, 0.25f, 0}}, Box{{half, 0.25f, half}}));
  for (int x = 0; x < columns; ++x) {
    for (int z = 0; z < columns; ++z) {
      for (int y = 0; y < 2; ++y) {
        const Vec3 place{1.5f * (static_cast<float>(x) + 0.5f) - half, 1.0f + static_cast<float>(y),
                         1.5f * (static_cast<float>(z) + 0.5f) - half};
        bodies.push_back(lab.add({.position = place}, Box{{0.5f, 0.5f, 0.5f}}));
      }
    }
  }
  return bodies;
}

TEST(Hub, ALoadedPlateComesToRestUnderItsLoad) {
  WorldSettings settings = without_sleep();
  settings.measure_penetration = true;
  Lab lab(settings);
  const std::vector<BodyId> bodies = add_loaded_plate(lab, 12);
  std::vector<Eigen::Vector3d> start;
  for (const BodyId body : bodies) start.push_back(lab.position(body));
  lab.run(600);
  EXPECT_GT(hub_chunks(lab.world), 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    EXPECT_LT((lab.position(bodies[i]) - start[i]).norm(), 0.02) << "body " << i;
    EXPECT_LT(lab.velocity(bodies[i]).norm(), 0.01) << "body " << i;
  }
  EXPECT_LT(lab.world.stats().penetration_max, 0.02);
}

TEST(Hub, TheImpulsesOfTheLoadSumToItsWeight) {
  Lab lab;
  const std::vector<BodyId> bodies = add_loaded_plate(lab, 12);
  lab.run(600);
  double weight = 0.0;
  for (std::size_t i = 1; i < bodies.size(); ++i) weight += lab.mass(bodies[i]) * kGravity;
  const WorldData& data = internals(lab.world);
  double impulse = 0.0;
  for (const std::int32_t touching : data.contacts.active) {
    const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(touching)];
    const auto plate = static_cast<std::int32_t>(bodies[0].index);
    if (manifold.row_a != plate && (manifold.row_b != plate || (manifold.info & kManifoldStatic) != 0))
      continue;
    for (const float point : manifold.normal_impulse) impulse += static_cast<double>(point);
  }
  const double substep = static_cast<double>(kStep) / lab.world.settings().substeps;
  EXPECT_NEAR(impulse / substep, weight, 0.01 * weight);
}

// Small balls fly at a big ball from all sides.
std::vector<BodyId> add_swarm(Lab& lab) {
  std::vector<BodyId> bodies{lab.add({}, Sphere{3.0f})};
  Random random(7);
  constexpr int kBalls = 300;
  for (int i = 0; i < kBalls; ++i) {
    const double height = 1.0 - 2.0 * (i + 0.5) / kBalls;  // a spiral of uniform density
    const double turn = 2.39996323 * i, ring = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d out(ring * std::cos(turn), height, ring * std::sin(turn));
    const auto to_vec = [](const Eigen::Vector3d& v) {
      return Vec3{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    };
    const double speed = random.uniform(0.5, 3.0);
    bodies.push_back(lab.add({.position = to_vec(3.3 * out), .linear_velocity = to_vec(-speed * out)},
                             Sphere{0.2f}, {.friction = 0.5f}));
  }
  return bodies;
}

TEST(Hub, KeepsMomentumAndGainsNoEnergy) {
  Lab lab(without_gravity());
  const std::vector<BodyId> bodies = add_swarm(lab);
  const auto sum = [&](Eigen::Vector3d& linear, Eigen::Vector3d& angular, double& energy) {
    linear = angular = Eigen::Vector3d::Zero();
    energy = 0.0;
    for (const BodyId body : bodies) {
      const Eigen::Vector3d momentum = lab.mass(body) * lab.velocity(body);
      linear += momentum;
      angular += lab.position(body).cross(momentum) + lab.angular_momentum(body);
      energy += lab.kinetic_energy(body);
    }
  };
  Eigen::Vector3d linear, angular, linear_now, angular_now;
  double energy = 0.0, energy_now = 0.0, scale = 0.0;
  sum(linear, angular, energy);
  for (const BodyId body : bodies) scale += lab.mass(body) * lab.velocity(body).norm();
  int chunks = 0;
  for (int i = 0; i < 60; ++i) {
    lab.run(1, 1.0f / 240.0f);
    chunks += hub_chunks(lab.world);
    sum(linear_now, angular_now, energy_now);
    EXPECT_LT((linear_now - linear).norm(), 1e-4 * scale) << "step " << i;
    EXPECT_LT((angular_now - angular).norm(), 1e-3 * scale * 3.0) << "step " << i;
    EXPECT_LT(energy_now, energy * 1.0001) << "step " << i;
    energy = energy_now;
  }
  EXPECT_GT(chunks, 10);
}

// A slab on 20 x 15 fixed tiles, more than the colors of a body.
BodyId add_slab_on_tiles(Lab& lab, Vec3 velocity) {
  for (int i = 0; i < 300; ++i) {
    const Vec3 place{static_cast<float>(i % 20) - 9.5f, -0.25f, static_cast<float>(i / 20) - 7.0f};
    lab.add({.type = BodyType::fixed, .position = place}, Box{{0.3f, 0.25f, 0.3f}}, {.friction = 0.5f});
  }
  return lab.add({.position = {0, 0.25f, 0}, .linear_velocity = velocity}, Box{{10, 0.25f, 7.5f}},
                 {.friction = 0.5f});
}

TEST(Hub, ASlabOnHundredsOfTilesSlidesAndStopsAsOnAFloor) {
  Lab lab(without_sleep());
  const BodyId slab = add_slab_on_tiles(lab, {});
  lab.run(30);
  EXPECT_GT(hub_chunks(lab.world), 0);
  lab.world.set_linear_velocity(slab, {1, 0, 0});
  const double before = lab.position(slab).x();
  const double weight = lab.mass(slab) * kGravity;
  for (int i = 0; i < 60; ++i) {
    lab.run(1);
    EXPECT_NEAR(lab.height(slab), 0.25, 2e-3) << "step " << i;
    EXPECT_LT(lab.spin(slab).norm(), 5e-3) << "step " << i;
    const double seconds = (i + 1) / 60.0, speed = std::max(0.0, 1.0 - 0.5 * kGravity * seconds);
    EXPECT_NEAR(lab.velocity(slab).x(), speed, 0.03) << "step " << i;
    double carried = 0.0;
    const WorldData& data = internals(lab.world);
    for (const std::int32_t row : data.contacts.active) {
      const Manifold& manifold = data.contacts.now.manifold[static_cast<std::size_t>(row)];
      for (const float impulse : manifold.normal_impulse) carried += static_cast<double>(impulse);
    }
    EXPECT_NEAR(carried * lab.world.settings().substeps * 60.0, weight, 0.02 * weight) << "step " << i;
  }
  EXPECT_NEAR(lab.position(slab).x() - before, 1.0 / (2.0 * 0.5 * kGravity), 0.01);
}

// Bodies at the same place, each of which touches all others.
std::vector<BodyId> add_cluster(Lab& lab) {
  Random random(11);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 120; ++i) {
    const auto near = [&] { return random.uniform(-0.05f, 0.05f); };
    const Geometry geometry = i % 2 == 0 ? Geometry(Box{{0.5f, 0.5f, 0.5f}}) : Geometry(Sphere{0.5f});
    bodies.push_back(lab.add({.position = {near(), near(), near()}}, geometry));
  }
  return bodies;
}

TEST(Hub, BodiesInOnePlaceSeparateAndKeepTheirMomentum) {
  WorldSettings settings = without_gravity();
  settings.measure_penetration = true;
  Lab lab(settings);
  const std::vector<BodyId> bodies = add_cluster(lab);
  double scale = 0.0, depth = 0.0;
  for (int i = 0; i < 240; ++i) {
    lab.run(1);
    if (i == 0) depth = lab.world.stats().penetration_max;
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
    for (const BodyId body : bodies) {
      momentum += lab.mass(body) * lab.velocity(body);
      scale = std::max(scale, lab.mass(body) * lab.velocity(body).norm());
    }
    EXPECT_LT(momentum.norm(), 1e-3 * scale) << "step " << i;
  }
  EXPECT_GT(depth, 0.5);
  EXPECT_LT(lab.world.stats().penetration_max, 0.1 * depth);
}

TEST(Hub, ResultsDoNotDependOnLaneWidthOrThreads) {
  std::vector<std::uint64_t> expected;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Lab lab(without_gravity()), plate, slab, cluster;
      add_cluster(cluster);
      add_swarm(lab);
      add_loaded_plate(plate, 9);
      add_slab_on_tiles(slab, {2, 0, 0.5f});
      Workers workers(WorkersOptions{.threads = threads, .isa = isa});
      std::vector<std::uint64_t> hashes;
      for (int i = 0; i < 60; ++i) {
        step(lab.world, kStep, workers);
        step(plate.world, kStep, workers);
        step(slab.world, kStep, workers);
        step(cluster.world, kStep, workers);
        for (const Lab* each : {&lab, &plate, &slab, &cluster}) hashes.push_back(each->world.hash());
      }
      if (expected.empty()) expected = hashes;
      EXPECT_EQ(hashes, expected) << static_cast<int>(isa) << ", " << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace scree::physics
