// The program scree_sorting_belt: a conveyor belt that sorts crates. One rule of contacts makes the surface
// of a long box move; over its last part it also moves sideways, to the side that a crate's user data names.
// A material's surface velocity could not tell crates apart. Prints where and how fast the crates come beside
// what the belt's speed makes. Exit codes: 0 all within what README.md states, 1 not so.
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

using scree::BodyId;
using scree::Vec3;

constexpr float kSpeed = 1.0f;   // m/s, of the belt along x
constexpr float kAcross = 0.5f;  // m/s, of its last part along z
constexpr float kSwitch = 4.0f;  // m, along x: where that begins
constexpr float kDt = 1.0f / 60.0f;
constexpr int kSteps = 6 * 60, kCrates = 5;

enum Side : std::uint64_t { kLeft, kRight };  // user data of crates: to -z, to +z

// v: of the belt under a crate that is at x.
Vec3 belt_velocity(float x, std::uint64_t side) {
  return {kSpeed, 0, x < kSwitch ? 0.0f : side == kLeft ? -kAcross : kAcross};
}

// The belt is a fixed body, so the other one is a crate. What a rule wants is the velocity of b's surface
// against a's: that of the belt, or its reverse where the belt is a.
void move_belt(const scree::ContactRuleBatch& batch) {
  for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
    const scree::HookedPair& pair = batch.pairs[i];
    const bool belt_is_a = batch.world.body_type(pair.body_a) == scree::BodyType::fixed;
    const BodyId crate = belt_is_a ? pair.body_b : pair.body_a;
    const Vec3 v = belt_velocity(batch.world.pose(crate).position.x, batch.world.user_data(crate));
    batch.rules[i].surface_velocity = belt_is_a ? -v : v;
  }
}

bool report(const char* what, double value, double most, const char* unit) {
  const bool holds = value <= most;
  std::printf("%-40s %10.3g %-4s at most %g %s\n", what, value, unit, most, holds ? "" : "EXCEEDED");
  return holds;
}

}  // namespace

int main() {
  scree::World world;
  const BodyId belt = world.create_body({.type = scree::BodyType::fixed, .position = {4, -0.1f, 0}});
  world.add_shape(belt, scree::Box{{6, 0.1f, 3}}, {.friction = 0.8f},
                  {.contact_hooks = scree::ContactHooks::rule});
  std::vector<BodyId> crates;
  for (int i = 0; i < kCrates; ++i) {
    crates.push_back(world.create_body({.position = {-1.0f + 0.8f * static_cast<float>(i), 0.2f, 0},
                                        .user_data = i % 2 == 0 ? kLeft : kRight}));
    world.add_shape(crates.back(), scree::Box{{0.2f, 0.2f, 0.2f}}, {.friction = 0.8f});
  }
  world.set_contact_rule(move_belt);
  scree::Workers workers(1);
  double slip = 0;
  for (int i = 0; i < kSteps; ++i) {
    scree::step(world, kDt, workers);
    if (i < 60) continue;  // the crates begin at rest
    for (const BodyId crate : crates) {
      const Vec3 place = world.pose(crate).position, v = world.linear_velocity(crate);
      const bool is_turning = std::abs(place.x - kSwitch) < 0.3f;
      if (!is_turning)
        slip = std::max<double>(slip, length(v - belt_velocity(place.x, world.user_data(crate))));
    }
  }
  std::vector<double> off;
  for (std::size_t i = 0; i < crates.size(); ++i) {
    // mu g is how fast the belt takes a crate along: it comes v^2 / (2 mu g) late, along x and across.
    const double start = -1.0 + 0.8 * static_cast<double>(i), g = 9.81 * 0.8, v = kSpeed, w = kAcross;
    const double x = start + v * kSteps * static_cast<double>(kDt) - v * v / (2 * g);
    const double across = std::max(0.0, w * (x - kSwitch) / v - w * w / (2 * g));
    const double z = i % 2 == 0 ? -across : across;
    const Vec3 place = world.pose(crates[i]).position;
    off.push_back(std::hypot(place.x - x, place.z - z));
  }
  std::printf("a sorting belt: %d crates, %d steps of 1/60 s\n", kCrates, kSteps);
  const bool holds[] = {
      report("largest slip away from the switch", slip, 1e-4, "m/s"),
      report("largest distance from the exact place", *std::max_element(off.begin(), off.end()), 0.005, "m")};
  return holds[0] && holds[1] ? 0 : 1;
}
