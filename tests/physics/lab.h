// Tools of the physics tests: a world on one thread, and its mechanics in double precision.
#pragma once

#include <core/world/math.h>
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace scree::physics {

inline constexpr float kStep = 1.0f / 60.0f;  // s
inline constexpr double kGravity = 9.81;      // m/s^2, of WorldSettings

inline WorldSettings without_sleep() {
  WorldSettings settings;
  settings.sleeping = false;
  return settings;
}

inline WorldSettings without_gravity() {
  WorldSettings settings = without_sleep();
  settings.gravity = {};
  return settings;
}

inline Eigen::Vector3d to_eigen(Vec3 v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
inline Eigen::Quaterniond to_eigen(Quat q) {
  return {static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
          static_cast<double>(q.z)};
}

inline Quat rotation_about(Vec3 axis, double angle) {
  const double s = std::sin(0.5 * angle) / to_eigen(axis).norm();
  return {static_cast<float>(s * axis.x), static_cast<float>(s * axis.y), static_cast<float>(s * axis.z),
          static_cast<float>(std::cos(0.5 * angle))};
}

/// A world that steps on one thread.
class Lab {
 public:
  explicit Lab(const WorldSettings& settings = without_sleep()) : world(settings) {}

  /// A fixed slab whose upper face passes through the origin, level unless tilted.
  BodyId add_ground(const Material& material = {}, Quat tilt = {}, float half_width = 100.0f) {
    const Eigen::Vector3d center = to_eigen(tilt) * Eigen::Vector3d(0, -1, 0);
    const BodyDef def{.type = BodyType::fixed,
                      .position = {static_cast<float>(center.x()), static_cast<float>(center.y()),
                                   static_cast<float>(center.z())},
                      .rotation = tilt};
    return add(def, Box{{half_width, 1.0f, half_width}}, material);
  }
  BodyId add(const BodyDef& def, const Geometry& geometry, const Material& material = {}) {
    const BodyId body = world.create_body(def);
    world.add_shape(body, geometry, material);
    return body;
  }
  void run(int steps, float dt = kStep) {
    for (int i = 0; i < steps; ++i) step(world, dt, workers);
  }

  Eigen::Vector3d position(BodyId body) const { return to_eigen(world.center_of_mass(body)); }
  Eigen::Vector3d velocity(BodyId body) const { return to_eigen(world.linear_velocity(body)); }
  Eigen::Vector3d spin(BodyId body) const { return to_eigen(world.angular_velocity(body)); }
  double height(BodyId body) const { return position(body).y(); }
  double mass(BodyId body) const { return static_cast<double>(world.mass_properties(body).mass); }

  /// About the center of mass, in world axes.
  Eigen::Matrix3d inertia(BodyId body) const {
    const MassProperties p = world.mass_properties(body);
    Eigen::Matrix3d local;
    local << p.inertia[0], p.inertia[3], p.inertia[4], p.inertia[3], p.inertia[1], p.inertia[5], p.inertia[4],
        p.inertia[5], p.inertia[2];
    const Eigen::Matrix3d rotation = to_eigen(world.pose(body).rotation).normalized().toRotationMatrix();
    return rotation * local * rotation.transpose();
  }
  Eigen::Vector3d angular_momentum(BodyId body) const { return inertia(body) * spin(body); }
  double spin_energy(BodyId body) const { return 0.5 * spin(body).dot(angular_momentum(body)); }
  double kinetic_energy(BodyId body) const {
    return 0.5 * mass(body) * velocity(body).squaredNorm() + spin_energy(body);
  }

  bool all_finite() const {
    for (std::uint32_t index = 0; index < world.poses().size(); ++index) {
      const BodyId body = world.body_at(index);
      if (body == BodyId{}) continue;
      const Pose pose = world.pose(body);
      const Quat q = pose.rotation;
      if (!is_finite(pose.position) || !is_finite({q.x, q.y, q.z}) || !std::isfinite(q.w) ||
          !is_finite(world.linear_velocity(body)) || !is_finite(world.angular_velocity(body))) {
        return false;
      }
    }
    return true;
  }

  World world;
  Workers workers{1};
};

/// A lab with a scene of the catalog, without sleep.
struct SceneLab {
  explicit SceneLab(const std::string& name, const scenes::Parameters& parameters = {})
      : scene(scenes::build(name, parameters).front()),
        lab(awake(scene)),
        bodies(populate(lab.world, scene)) {
    for (const BodyId body : bodies) start.push_back(lab.position(body));
  }
  static WorldSettings awake(const scenes::Scene& scene) {
    WorldSettings settings = scene.settings;
    settings.sleeping = false;
    return settings;
  }
  /// The largest horizontal distance of a body from its start, m.
  double drift() const {
    double worst = 0.0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Eigen::Vector3d way = lab.position(bodies[i]) - start[i];
      worst = std::max(worst, std::hypot(way.x(), way.z()));
    }
    return worst;
  }
  /// Whether every body is within `limit` of its start horizontally, and below it by at most `limit` and the
  /// 10 % of its height by which soft contacts yield while a tall load settles.
  bool stands(double limit) const {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const double drop = start[i].y() - lab.height(bodies[i]);
      if (!(drop < limit + 0.1 * std::abs(start[i].y()))) return false;
    }
    return drift() < limit;
  }
  /// Steps until the scene no longer stands; returns the number of steps.
  int run_while_standing(int steps, double limit, int check_every = 20) {
    for (int i = 0; i < steps; i += check_every) {
      lab.run(check_every);
      if (!stands(limit)) return i + check_every;
    }
    return steps;
  }

  scenes::Scene scene;
  Lab lab;
  std::vector<BodyId> bodies;
  std::vector<Eigen::Vector3d> start;
};

/// Random numbers for tests, the same on every platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 1) {}
  float uniform(float low, float high) {
    // Marsaglia, "Xorshift RNGs", 2003.
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return low + (high - low) * static_cast<float>(state_ >> 40) * 0x1p-24f;
  }
  Vec3 vector(float size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Quat rotation() {  // the angle first: the order in which arguments are evaluated is unspecified
    const double angle = static_cast<double>(uniform(0.0f, 6.0f));
    return rotation_about(vector(1.0f), angle);
  }

 private:
  std::uint64_t state_;
};

/// Drops `count` boxes, balls and capsules into a walled pit and returns them.
inline std::vector<BodyId> add_heap(Lab& lab, int count, std::uint64_t seed, const Material& material = {}) {
  lab.add_ground(material);
  const float half = 0.9f * std::cbrt(static_cast<float>(count)) * 0.5f + 0.5f;
  for (const float side : {-1.0f, 1.0f}) {
    lab.add({.type = BodyType::fixed, .position = {side * (half + 1.0f), 10.0f, 0.0f}},
            Box{{1.0f, 10.0f, half + 2.0f}}, material);
    lab.add({.type = BodyType::fixed, .position = {0.0f, 10.0f, side * (half + 1.0f)}},
            Box{{half + 2.0f, 10.0f, 1.0f}}, material);
  }
  Random random(seed);
  const int columns = std::max(1, static_cast<int>(2.0f * half / 0.9f));
  std::vector<BodyId> bodies;
  for (int i = 0; i < count; ++i) {
    const float pitch = 2.0f * half / static_cast<float>(columns);
    const auto place = [&](int cell) { return -half + pitch * (static_cast<float>(cell) + 0.5f); };
    const BodyDef def{.position = {place(i % columns), 0.5f + static_cast<float>(i / (columns * columns)),
                                   place(i / columns % columns)},
                      .rotation = random.rotation()};
    const float size = random.uniform(0.15f, 0.3f);
    Geometry geometry = Sphere{size};
    if (i % 3 == 1) geometry = Box{{size, random.uniform(0.15f, 0.3f), random.uniform(0.15f, 0.3f)}};
    if (i % 3 == 2) geometry = Capsule{random.uniform(0.1f, 0.2f), 0.7f * size};
    bodies.push_back(lab.add(def, geometry, material));
  }
  return bodies;
}

}  // namespace scree::physics
