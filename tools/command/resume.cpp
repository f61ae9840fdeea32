// See resume.h.
#include <tools/command/resume.h>

#include <cstdint>
#include <string>
#include <utility>

namespace scree::command {

namespace {

[[noreturn]] void refuse(const RunOptions& options, const std::string& reason) {
  throw Error("--resume " + options.resume + ": " + reason);
}

// Whether two worlds, or a rank's parts of them, have the same bodies, shapes and joints in the same rows.
bool are_alike(const World& one, const World& other) {
  if (one.poses().size() != other.poses().size()) return false;
  for (std::uint32_t row = 0; row < one.poses().size(); ++row) {
    const BodyId a = one.body_at(row), b = other.body_at(row);
    if (a.generation != b.generation || one.is_alive(a) != other.is_alive(b)) return false;
    if (!one.is_alive(a)) continue;
    if (one.body_type(a) != other.body_type(b) || one.shapes_of(a, {}) != other.shapes_of(b, {}) ||
        one.joints_of(a, {}) != other.joints_of(b, {}))
      return false;
  }
  return true;
}

// Makes the changes of a scene's first steps; calls taken_up() after each.
template <class TakenUp>
void make_changes(World& world, const scenes::Scene& script, std::vector<BodyId>& bodies, std::uint64_t steps,
                  TakenUp&& taken_up) {
  for (const scenes::SceneChange& change : script.changes) {
    if (static_cast<std::uint64_t>(change.step) >= steps) continue;
    scenes::make_change(world, script, change, bodies);
    taken_up();
  }
}

void check_alike(const World& checkpoint, const World& world, const RunOptions& options) {
  if (!are_alike(checkpoint, world))
    refuse(options, "it is of another scene: its bodies, shapes or joints are others");
}

// How many steps are behind.
int checked_steps(std::uint64_t taken, const RunOptions& options, int steps) {
  if (std::cmp_greater_equal(taken, steps)) {
    refuse(options, "it has taken " + std::to_string(taken) + " steps, and --steps " + std::to_string(steps) +
                        " are all that were asked for");
  }
  return static_cast<int>(taken);
}

}  // namespace

int resume(World& world, const scenes::Scene& script, std::vector<BodyId>& bodies, const RunOptions& options,
           int steps) {
  const WorldSettings settings = world.settings();
  Snapshot snapshot;
  {
    const World checkpoint = read_checkpoint(options.resume);
    save(checkpoint, snapshot);
    make_changes(world, script, bodies, snapshot.step(), [] {});
    check_alike(checkpoint, world, options);
  }
  restore(world, snapshot);
  world.set_settings(settings);
  return checked_steps(snapshot.step(), options, steps);
}

int resume(Team& team, DistributedWorld checkpoint, const scenes::Scene& script, std::vector<BodyId>& bodies,
           const RunOptions& options, int steps) {
  const std::uint64_t taken = checkpoint.world().stats().step;
  World& world = team.world().world();
  make_changes(world, script, bodies, taken, [&] { team.world().hash(); });  // which takes up calls
  check_alike(checkpoint.world(), world, options);
  for (BodyId& body : bodies)  // handles are of one world
    body = world.is_alive(body) ? checkpoint.world().body_at(body.index) : BodyId{};
  checkpoint.world().set_settings(world.settings());
  team.replace(std::move(checkpoint));
  return checked_steps(taken, options, steps);
}

}  // namespace scree::command
