// The program scree_one_way_platform: balls jump through a platform from below, and land on it. A rule lets
// the contacts of the platform act only where they push up what does not rise. Prints how high the balls
// jump beside the height without a platform, and where they lie in the end. Exit codes: 0 all within what
// README.md states, 1 not so.
#include <scree/scree.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

using scree::BodyId;
using scree::Vec3;

constexpr float kRadius = 0.25f;                 // m, of the balls
constexpr float kTop = 2.0f, kThickness = 0.2f;  // m, of the platform
constexpr float kDeep = 0.05f;                   // m: what overlaps more is still on its way through
constexpr float kDt = 1.0f / 60.0f, kGravity = 9.81f;
constexpr int kSteps = 4 * 60;

void let_through(const scree::ContactRuleBatch& batch) {
  for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
    const scree::HookedPair& pair = batch.pairs[i];
    const scree::HookedContact& contact = batch.contacts[i];
    const bool platform_is_a = batch.world.body_type(pair.body_a) == scree::BodyType::fixed;
    const BodyId jumper = platform_is_a ? pair.body_b : pair.body_a;
    const float up = platform_is_a ? contact.normal.y : -contact.normal.y;
    bool is_through = true;
    for (int k = 0; k < contact.point_count; ++k)
      is_through = is_through && contact.points[k].separation > -kDeep;
    batch.rules[i].acts = up > 0.7f && is_through && batch.world.linear_velocity(jumper).y <= 0.1f;
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
  const BodyId ground = world.create_body({.type = scree::BodyType::fixed, .position = {0, -1, 0}});
  world.add_shape(ground, scree::Box{{20, 1, 20}});
  const BodyId platform =
      world.create_body({.type = scree::BodyType::fixed, .position = {0, kTop - 0.5f * kThickness, 0}});
  world.add_shape(platform, scree::Box{{10, 0.5f * kThickness, 10}}, {},
                  {.contact_hooks = scree::ContactHooks::rule});
  world.set_contact_rule(let_through);
  struct Jump {
    BodyId ball;
    float speed;    // m/s, upward from the ground; 0: dropped from above
    double height;  // m, the highest that the ball's center comes
  };
  std::vector<Jump> jumps;
  for (const float speed : {0.0f, 4.0f, 5.0f, 6.0f, 7.0f, 8.0f, 9.0f, 12.0f}) {
    const float start = speed > 0.0f ? kRadius : kTop + 1.0f;
    const float x = 1.0f * static_cast<float>(jumps.size()) - 4.0f;
    jumps.push_back(
        {world.create_body({.position = {x, start, 0}, .linear_velocity = {0, speed, 0}}), speed, 0});
    world.add_shape(jumps.back().ball, scree::Sphere{kRadius});
  }
  scree::Workers workers(1);
  for (int i = 0; i < kSteps; ++i) {
    scree::step(world, kDt, workers);
    for (Jump& jump : jumps) jump.height = std::max<double>(jump.height, world.pose(jump.ball).position.y);
  }
  double worst_height = 0, worst_place = 0;
  std::printf("a one-way platform, %g m high\n", static_cast<double>(kTop));
  for (const Jump& jump : jumps) {
    const double free = jump.speed > 0.0f ? kRadius + jump.speed * jump.speed / (2 * kGravity) : kTop + 1.0;
    // What gets its center above by so much that it overlaps by less than kDeep stays up there.
    const bool lands = free > kTop + kRadius - kDeep;
    const double rest = lands ? kTop + kRadius : kRadius, place = world.pose(jump.ball).position.y;
    std::printf("  %4.1f m/s: jumps %.3f m high (%.3f), ends at %.3f m (%.3f)\n",
                static_cast<double>(jump.speed), jump.height, free, place, rest);
    worst_height = std::max(worst_height, std::abs(jump.height - free) / free);
    worst_place = std::max(worst_place, std::abs(place - rest));
  }
  const bool holds[] = {report("largest error of a height", worst_height, 0.002, ""),
                        report("largest distance from where a ball rests", worst_place, 0.001, "m")};
  return holds[0] && holds[1] ? 0 : 1;
}
