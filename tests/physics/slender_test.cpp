// Laws of slender bodies: needles, slivers and plates, whose inertia differs by factors of hundreds between
// axes, among bodies with hundreds of times their mass.
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>

namespace scree::physics {
namespace {

double potential_energy(const SceneLab& heap) {
  const double gravity = -double{heap.scene.settings.gravity.y};
  double sum = 0.0;
  for (const BodyId body : heap.bodies) {
    if (heap.lab.world.body_type(body) != BodyType::dynamic) continue;
    sum += double{heap.lab.world.mass_properties(body).mass} * gravity * heap.lab.height(body);
  }
  return sum;
}

double fastest(const SceneLab& heap) {
  double speed = 0.0;
  for (const BodyId body : heap.bodies) speed = std::max(speed, heap.lab.velocity(body).norm());
  return speed;
}

TEST(Slender, AHeapNeverGainsEnergyAndComesToRest) {
  SceneLab heap("hull_zoo", {{"bodies", 200}, {"max_vertices", 32}});
  double height = 0.0;
  for (const BodyId body : heap.bodies) height = std::max(height, heap.lab.height(body));
  const double free_fall = std::sqrt(2.0 * -double{heap.scene.settings.gravity.y} * height);
  double energy = potential_energy(heap) + heap.lab.world.stats().kinetic_energy;
  for (int step = 0; step < 400; ++step) {
    heap.lab.run(1);
    const double now = potential_energy(heap) + heap.lab.world.stats().kinetic_energy;
    // Pushing overlaps apart lifts bodies: by less than a thousandth of the energy.
    ASSERT_LT(now, energy * 1.001) << "step " << step;
    // A heavy body gives a light one at most twice its speed.
    ASSERT_LT(fastest(heap), 2.0 * free_fall) << "step " << step;
    energy = now;
  }
  EXPECT_LT(heap.lab.world.stats().kinetic_energy, 2e-4 * energy);
}

TEST(Slender, NoSpeedEverExceedsTheLimits) {
  WorldSettings settings = without_sleep();
  settings.max_linear_speed = 5.0f;
  settings.max_angular_speed = 7.0f;
  Lab lab(settings);
  lab.add_ground({.restitution = 1.0f});
  std::vector<BodyId> needles;
  for (int i = 0; i < 20; ++i) {
    needles.push_back(lab.add(
        {.position = {2.0f * static_cast<float>(i), 3.0f, 0},
         .rotation = {0, 0, std::sin(0.1f * static_cast<float>(i)), std::cos(0.1f * static_cast<float>(i))}},
        Box{{0.02f, 0.6f, 0.02f}}, {.restitution = 1.0f}));
  }
  for (int step = 0; step < 120; ++step) {
    lab.run(1);
    for (const BodyId needle : needles) {
      const Vec3 spin = lab.world.angular_velocity(needle);
      EXPECT_LT(lab.velocity(needle).norm(), 5.0 * 1.00001);
      EXPECT_LT(std::hypot(spin.x, spin.y, spin.z), 7.0f * 1.00001f);
    }
  }
}

Hull prism(float radius, float half_length, int corners) {
  std::vector<Vec3> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    for (const float end : {-half_length, half_length}) {
      points.push_back(
          {radius * static_cast<float>(std::cos(angle)), end, radius * static_cast<float>(std::sin(angle))});
    }
  }
  return Hull(points);
}

Hull needle(float radius, float half_length) {
  return Hull(std::vector<Vec3>{{radius, -half_length, 0},
                                {-radius, -half_length, 0},
                                {0, -half_length, radius},
                                {0, -half_length, -radius},
                                {0, half_length, 0}});
}

const Geometry kSlender[] = {Capsule{0.5f, 0.005f},
                             Capsule{0.5f, 0.02f},
                             Box{{0.004f, 0.4f, 0.004f}},
                             Box{{0.5f, 0.02f, 0.004f}},
                             Box{{0.05f, 0.0015f, 0.08f}},
                             Box{{0.5f, 0.005f, 0.4f}},
                             ConvexHull{prism(0.0035f, 0.09f, 6)},
                             ConvexHull{prism(0.01f, 0.5f, 8)},
                             ConvexHull{needle(0.005f, 0.3f)}};

enum class Ground { box, sphere, capsule, hull, edge, sleeper, thin };
constexpr Ground kGrounds[] = {Ground::box,  Ground::sphere,  Ground::capsule, Ground::hull,
                               Ground::edge, Ground::sleeper, Ground::thin};

// Bodies thrown at one piece of ground each, above a floor.
struct Throws {
  explicit Throws(const WorldSettings& settings) : lab(settings) {}

  void add_ground(Ground ground, float x) {
    BodyDef fixed{.type = BodyType::fixed, .position = {x, -0.5f, 0}};
    switch (ground) {
      case Ground::box:
      case Ground::thin:
        return;  // the floor
      case Ground::sphere:
        lab.add(fixed, Sphere{0.5f});
        return;
      case Ground::capsule:
        fixed.rotation = rotation_about({0, 0, 1}, 0.5 * std::numbers::pi);
        lab.add(fixed, Capsule{1.0f, 0.5f});
        return;
      case Ground::hull:
        lab.add(fixed, ConvexHull{prism(1.0f, 0.5f, 12)});
        return;
      case Ground::edge:
        fixed.rotation = rotation_about({0, 0, 1}, 0.25 * std::numbers::pi);
        lab.add(fixed, Box{{0.35f, 0.35f, 1.0f}});
        return;
      case Ground::sleeper:
        lab.add({.position = {x, -0.5f, 0}}, Box{{0.8f, 0.5f, 0.8f}});
        return;
    }
  }
  void add_floor(Ground ground) {
    top = ground == Ground::box || ground == Ground::thin ? 0.0f : -1.0f;
    const float half = ground == Ground::thin ? 0.005f : 1.0f;
    lab.add({.type = BodyType::fixed, .position = {0, top - half, 0}}, Box{{1e4f, half, 1e4f}});
  }
  void add_thrown(const Geometry& geometry, float x, float speed, float spin, Random& random) {
    Vec3 velocity = random.vector(0.5f * speed);
    velocity.y = -random.uniform(0.0f, speed);
    thrown.push_back(lab.add({.position = {x + random.uniform(-0.4f, 0.4f), random.uniform(0.7f, 2.0f),
                                           random.uniform(-0.4f, 0.4f)},
                              .rotation = random.rotation(),
                              .linear_velocity = velocity,
                              .angular_velocity = random.vector(spin)},
                             geometry));
  }

  Lab lab;
  float top = 0.0f;  // m, of the floor
  std::vector<BodyId> thrown;
};

// Consecutive steps in which a body was fast but did not move.
struct Standstill {
  Pose pose;
  int steps = 0;

  void look(const Pose& now, const Eigen::Vector3d& velocity) {
    constexpr double kFast = 0.3, kStays = 0.05;  // m/s; share of the distance at that velocity
    const double way = (to_eigen(now.position) - to_eigen(pose.position)).norm();
    const bool stays = velocity.norm() > kFast && way < kStays * velocity.norm() * static_cast<double>(kStep);
    steps = stays ? steps + 1 : 0;
    pose = now;
  }
};

// A body that hits an obstacle is put back to the point of impact once. In the next step it must have a
// contact.
TEST(Slender, NoBodyHangsStillWhileItsVelocityGrows) {
  constexpr int kEach = 12;
  for (const Ground ground : kGrounds) {
    for (const float speed : {3.0f, 12.0f, 60.0f}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(ground)) + ", " + std::to_string(speed) + " m/s");
      Throws throws{WorldSettings{}};
      throws.add_floor(ground);
      const auto place = [](int i) { return 5.0f * static_cast<float>(i); };
      const int count = kEach * static_cast<int>(std::size(kSlender));
      for (int i = 0; i < count; ++i) throws.add_ground(ground, place(i));
      if (ground == Ground::sleeper) throws.lab.run(90);
      Random random(17 + static_cast<std::uint64_t>(speed));
      for (int i = 0; i < count; ++i) throws.add_thrown(kSlender[i / kEach], place(i), speed, 20.0f, random);

      std::vector<Standstill> still(throws.thrown.size());
      const double lowest = 4.0 + 0.5 * static_cast<double>(speed * speed) / kGravity;  // m of fall
      for (int step = 0; step < 300; ++step) {
        throws.lab.run(1);
        for (std::size_t i = 0; i < still.size(); ++i) {
          const BodyId body = throws.thrown[i];
          still[i].look(throws.lab.world.pose(body), throws.lab.velocity(body));
          ASSERT_LT(still[i].steps, 12) << "body " << i << ", step " << step;
          ASSERT_LT(0.5 * throws.lab.velocity(body).squaredNorm(), 1.5 * kGravity * lowest)
              << "body " << i << ", step " << step;
        }
      }
      for (std::size_t i = 0; i < still.size(); ++i)
        EXPECT_GT(throws.lab.height(throws.thrown[i]), static_cast<double>(throws.top) - 0.02)
            << "body " << i;
    }
  }
}

TEST(Slender, ABodyPutBackToWhereItMetAWallKeepsItsEnergy) {
  Random random(8);
  int hits = 0;
  for (const Geometry& geometry : kSlender) {
    for (int i = 0; i < 20; ++i) {
      Lab lab(without_gravity());
      lab.add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{500, 1, 500}});
      const BodyId body = lab.add({.position = {0, 0.8f, 0},
                                   .rotation = random.rotation(),
                                   .linear_velocity = {3, -40, 0},
                                   .angular_velocity = random.vector(200)},
                                  geometry);
      for (int step = 0; step < 3 && lab.world.stats().sweep_hits == 0; ++step) {
        const double energy = lab.kinetic_energy(body);
        lab.run(1);
        if (lab.world.stats().sweep_hits == 0 || lab.world.stats().contacts != 0) continue;
        EXPECT_NEAR(lab.kinetic_energy(body), energy, 1e-3 * energy) << geometry.index() << ", " << i;
        ++hits;
      }
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Slender, ADroppedStickEndsLyingOnTheGround) {
  // The stick stayed in the ground with half its length, and its velocity grew to 197 m/s.
  for (const bool continuous : {true, false}) {
    WorldSettings settings;
    settings.continuous = continuous;
    Lab lab(settings);
    lab.add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{5000, 1, 5000}});
    std::vector<BodyId> sticks;
    Random random(5);
    for (int i = 0; i < 100; ++i) {
      sticks.push_back(lab.add({.position = {40.0f * static_cast<float>(i), random.uniform(1, 3), 0},
                                .rotation = i == 0 ? Quat{} : random.rotation(),
                                .linear_velocity = random.vector(10)},
                               Capsule{0.5f, 0.005f}));
    }
    lab.run(600);
    for (const BodyId stick : sticks) {
      EXPECT_NEAR(lab.height(stick), 0.0, 0.006) << stick.index;
      EXPECT_NEAR((to_eigen(lab.world.pose(stick).rotation) * Eigen::Vector3d(0, 1, 0)).y(), 0.0, 0.02)
          << stick.index;
      EXPECT_LT(std::abs(lab.velocity(stick).y()), 0.1) << stick.index;
    }
  }
}

}  // namespace
}  // namespace scree::physics
