// A recording as a show: who appears, in which shapes, and where they are at each time.
#pragma once

#include <scree/recording.h>
#include <scree/scree.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace scree::exports {

struct ActorShape {
  Geometry geometry;
  Pose pose;  // in the body's frame
};

// A body, with the shapes that it had when it first appeared; no sensors.
struct Actor {
  BodyId body;
  BodyType type = BodyType::dynamic;
  std::vector<ActorShape> shapes;
  std::size_t first = 0;    // the sample at which it appears
  std::vector<Pose> poses;  // from then on, while it lives
};

struct Show {
  std::vector<double> times;         // s, of the samples, since the first; ascending, as steps of no length
                                     // are left out
  std::vector<std::uint64_t> steps;  // their step counters
  std::vector<StepStats> stats;  // of those steps; of the first sample, for which none was played, of no step
  std::vector<Actor> actors;     // by the sample at which they appear, then by BodyId::index
  Vec3 up{0.0f, 1.0f, 0.0f};     // unit, against the gravity at first; y where there is none
};

// Plays the steps `from` to `to` and samples every `every` of them. `show_progress(done, all)` counts steps.
Show play(Player& player, std::uint64_t from, std::uint64_t to, std::uint64_t every, Workers& workers,
          const std::function<void(std::uint64_t, std::uint64_t)>& show_progress);

// Of a body, but for sensors.
std::vector<ActorShape> shapes_of(const World& world, BodyId body);

// The turn that takes `up` to `to`; both unit.
Quat turn_to(Vec3 up, Vec3 to);

// Whether the actor lives in all samples, and whether it stays in one place while it does.
bool is_always_there(const Show& show, const Actor& actor);
bool stands_still(const Actor& actor);

}  // namespace scree::exports
