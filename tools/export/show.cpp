// See show.h.
#include <tools/export/show.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace scree::exports {
namespace {

// The actor of a body, and the last sample that had it. A body that a restored snapshot brings back is
// another actor.
struct Known {
  std::size_t actor = 0, last = 0;
};

void sample(const World& world, Show& show, std::map<std::pair<std::uint32_t, std::uint32_t>, Known>& known) {
  const std::size_t now = show.times.size() - 1;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (!world.is_alive(body)) continue;
    const auto [place, is_new] = known.try_emplace({body.index, body.generation});
    Known& mine = place->second;
    if (is_new || mine.last + 1 < now) {
      mine.actor = show.actors.size();
      show.actors.push_back({body, world.body_type(body), shapes_of(world, body), now, {}});
    }
    mine.last = now;
    show.actors[mine.actor].poses.push_back(world.pose(body));
  }
}

}  // namespace

std::vector<ActorShape> shapes_of(const World& world, BodyId body) {
  std::vector<ShapeId> ids(world.shapes_of(body, {}));
  world.shapes_of(body, ids);
  std::vector<ActorShape> shapes;
  for (const ShapeId id : ids) {
    if (!world.is_sensor(id)) shapes.push_back({world.geometry(id), world.local_pose(id)});
  }
  return shapes;
}

Show play(Player& player, std::uint64_t from, std::uint64_t to, std::uint64_t every, Workers& workers,
          const std::function<void(std::uint64_t, std::uint64_t)>& show_progress) {
  Show show;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Known> known;
  player.measure({.residual = true});
  player.seek(from, workers);
  if (const Vec3 down = normalize(player.world().settings().gravity); down != Vec3{}) show.up = -down;
  double time = 0.0;
  for (std::uint64_t step = from;; ++step) {
    if ((step - from) % every == 0 && (show.times.empty() || time > show.times.back())) {
      show.times.push_back(time);
      show.steps.push_back(step);
      show.stats.push_back(player.world().stats());
      sample(player.world(), show, known);
    }
    if (step == to || !player.step(workers)) break;
    time += double{*player.recorded_dt()};
    show_progress(step + 1 - from, to - from);
  }
  return show;
}

Quat turn_to(Vec3 up, Vec3 to) {
  const float cosine = dot(up, to);
  if (cosine < -0.999999f) {
    const Vec3 aside = std::abs(up.x) < 0.9f ? Vec3{1.0f, 0.0f, 0.0f} : Vec3{0.0f, 1.0f, 0.0f};
    return from_axis_angle(cross(up, aside), std::numbers::pi_v<float>);
  }
  const Vec3 axis = cross(up, to);
  return normalize(Quat{axis.x, axis.y, axis.z, 1.0f + cosine});
}

bool is_always_there(const Show& show, const Actor& actor) { return actor.poses.size() == show.times.size(); }

bool stands_still(const Actor& actor) {
  return std::all_of(actor.poses.begin(), actor.poses.end(),
                     [&](const Pose& pose) { return pose == actor.poses.front(); });
}

}  // namespace scree::exports
