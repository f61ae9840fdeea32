// The wide solver against the plain one on the same moving scenes: residual, penetration and drift.
#include <parallel/constraints/constraints.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "plain_solver.h"

namespace scree {
namespace {

using physics::kStep;
using physics::Lab;

struct Figures {
  double residual = 0.0;     // m/s, mean over steps of the largest of a step
  double penetration = 0.0;  // m, mean over touching manifolds and steps
  double deep = 0.0;         // m, 99.9th percentile
  double drift = 0.0;        // m, mean over bodies of the horizontal way
};

using Build = std::function<std::vector<BodyId>(Lab&)>;

Figures simulate(const Build& build, int steps, bool plain) {
  WorldSettings settings = physics::without_sleep();
  settings.measure_residual = true;
  Lab lab(settings);
  const std::vector<BodyId> bodies = build(lab);
  std::vector<Eigen::Vector3d> start;
  for (const BodyId body : bodies) start.push_back(lab.position(body));
  Figures figures;
  std::vector<double> depths;
  for (int i = 0; i < steps; ++i) {
    if (plain) {
      testing::step_plainly(lab.world, kStep, lab.workers);
    } else {
      lab.run(1);
    }
    figures.residual += lab.world.stats().residual / steps;
    const Contacts& contacts = internals(lab.world).contacts;
    for (const std::int32_t row : contacts.active) {
      const auto& separation = contacts.now.manifold[static_cast<std::size_t>(row)].separation;
      const float least = *std::min_element(std::begin(separation), std::end(separation));
      depths.push_back(std::max(0.0, -static_cast<double>(least)));
      figures.penetration += depths.back();
    }
  }
  figures.penetration /= static_cast<double>(depths.size());
  std::sort(depths.begin(), depths.end());
  figures.deep = depths[depths.size() * 999 / 1000];
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const Eigen::Vector3d way = lab.position(bodies[k]) - start[k];
    figures.drift += std::hypot(way.x(), way.z()) / static_cast<double>(bodies.size());
  }
  return figures;
}

Figures mean_of(const std::vector<Build>& builds, int steps, bool plain) {
  Figures mean;
  const auto count = static_cast<double>(builds.size());
  for (const Build& build : builds) {
    const Figures figures = simulate(build, steps, plain);
    mean.residual += figures.residual / count;
    mean.penetration += figures.penetration / count;
    mean.deep += figures.deep / count;
    mean.drift += figures.drift / count;
  }
  return mean;
}

// At most 1.1 times the plain solver's figure, up to the effect of chaos on small numbers.
void compare(const char* name, const std::vector<Build>& builds, int steps) {
  const Figures wide = mean_of(builds, steps, false), plain = mean_of(builds, steps, true);
  std::printf(
      "%-10s residual %.5f (plain %.5f) m/s, penetration %.5f (%.5f), 99.9 %% %.5f (%.5f), drift %.5f (%.5f) "
      "m\n",
      name, wide.residual, plain.residual, wide.penetration, plain.penetration, wide.deep, plain.deep,
      wide.drift, plain.drift);
  EXPECT_LE(wide.residual, 1.1 * plain.residual + 2e-3) << name;
  EXPECT_LE(wide.penetration, 1.1 * plain.penetration + 1e-4) << name;
  EXPECT_LE(wide.deep, 1.1 * plain.deep + 1e-3) << name;
  EXPECT_LE(wide.drift, 1.1 * plain.drift + 5e-3) << name;
}

std::vector<BodyId> pyramid(Lab& lab) {
  lab.add_ground();
  std::vector<BodyId> bodies;
  constexpr int kBase = 14;
  for (int i = 0; i < kBase; ++i) {
    for (int j = i; j < kBase; ++j) {
      const float x = 0.5f * static_cast<float>(i + 1) + static_cast<float>(j - i);
      bodies.push_back(lab.add({.position = {x, static_cast<float>(i) + 0.5f, 0}}, Box{}));
    }
  }
  return bodies;
}

std::vector<BodyId> stack(Lab& lab) {
  lab.add_ground();
  std::vector<BodyId> bodies;
  for (int i = 0; i < 20; ++i) {
    bodies.push_back(lab.add({.position = {0, static_cast<float>(i) + 0.5f, 0}}, Box{}));
  }
  return bodies;
}

// Balls and cubes roll down a slope against a wall, their columns `pitch` meters apart.
std::vector<BodyId> rolling_pile(Lab& lab, float pitch) {
  lab.add_ground({}, physics::rotation_about({0, 0, 1}, 0.25));
  lab.add({.type = BodyType::fixed, .position = {-9, 0, 0}}, Box{{1, 8, 20}});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 120; ++i) {
    const float x = static_cast<float>(i % 6), z = static_cast<float>(i / 6 % 4),
                y = static_cast<float>(i / 24);
    const BodyDef def{.position = {pitch * x, 2.2f + 1.1f * y + 0.05f * x, 1.1f * z}};
    if (i % 2 == 0) {
      bodies.push_back(lab.add(def, Sphere{0.5f}, {.rolling_resistance = 0.02f}));
    } else {
      bodies.push_back(lab.add(def, Box{{0.45f, 0.45f, 0.45f}}));
    }
  }
  return bodies;
}

TEST(Solver, IsAsAccurateAsThePlainSolverOnAPyramid) { compare("pyramid", {pyramid}, 240); }

TEST(Solver, IsAsAccurateAsThePlainSolverOnAStack) { compare("stack", {stack}, 480); }

TEST(Solver, IsAsAccurateAsThePlainSolverOnARollingPile) {
  // A single pile is chaotic: the stone that sinks deepest changes with the last bit.
  std::vector<Build> piles;
  for (const float pitch : {1.07f, 1.08f, 1.09f, 1.1f, 1.11f, 1.12f, 1.13f, 1.14f}) {
    piles.push_back([pitch](Lab& lab) { return rolling_pile(lab, pitch); });
  }
  compare("rolling", piles, 240);
}

TEST(Solver, FollowsThePlainSolverClosely) {
  // One tumbling box on the ground: no chaos for some time, so positions agree.
  const auto tumble = [](bool plain) {
    Lab lab;
    lab.add_ground();
    const BodyId box = lab.add({.position = {0, 0.8f, 0},
                                .rotation = physics::rotation_about({1, 0, 0.5f}, 0.3),
                                .linear_velocity = {1, 0, 0}},
                               Box{});
    for (int i = 0; i < 20; ++i) {
      if (plain) {
        testing::step_plainly(lab.world, kStep, lab.workers);
      } else {
        lab.run(1);
      }
    }
    return lab.position(box);
  };
  EXPECT_LT((tumble(true) - tumble(false)).norm(), 2e-3);
}

}  // namespace
}  // namespace scree
