// The step: calls its phases in order. Each phase stands in the file of its name, in a room of this folder;
// the comment beside the call says what it reads and what it writes.
#include <core/state/hash.h>
#include <core/world/edit.h>
#include <core/world/wake.h>
#include <parallel/crew/zone_scope.h>
#include <parallel/distributed/border.h>
#include <parallel/stages.h>
#include <parallel/validate/validate_stages.h>
#include <scree/step.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <string>
#include <utility>

namespace scree {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// Runs the phases in their order and keeps the time of each.
class PhaseClock {
 public:
  PhaseClock(StepStats& stats, Clock::time_point begin, const ZoneHooks* zones)
      : stats_(stats), begin_(begin), last_(begin), zones_(zones) {}
  template <class Work>
  void run(Phase phase, Work&& work) {
    {
      const ZoneScope zone(zones_, {ZoneKind::phase, phase_name(phase), static_cast<int>(phase)});
      work();
    }
    lap(phase);
  }
  // The phase has taken the time since the last one.
  void lap(Phase phase) {
    const Clock::time_point now = Clock::now();
    stats_.phase_ms[static_cast<int>(phase)] += milliseconds(now - last_);
    last_ = now;
  }
  void finish() { stats_.step_ms = milliseconds(last_ - begin_); }

 private:
  StepStats& stats_;
  Clock::time_point begin_;
  Clock::time_point last_;
  const ZoneHooks* zones_;
};

// A step of no length solves nothing, but its bodies keep their energy.
void clear_figures(StepStats& stats) {
  StepStats cleared;
  cleared.step = stats.step;
  cleared.kinetic_energy = stats.kinetic_energy;
  stats = cleared;
}

void check_time_step(float dt) {
  if (!(dt >= 0.0f && dt <= 1.0f)) {
    throw Error("step: the time step is " + std::to_string(dt) + " s; it must be in [0, 1]");
  }
}

[[noreturn]] void fail_list(std::span<World* const> worlds, std::size_t index) {
  const std::string here = "step: world " + std::to_string(index) + " of the list ";
  if (worlds[index] == nullptr) throw Error(here + "is a null pointer");
  const auto first = std::find(worlds.begin(), worlds.end(), worlds[index]);
  throw Error(here + "stands in it before, at " + std::to_string(first - worlds.begin()));
}

// A step of no length measures no forces of contacts.
void forget_forces(WorldData& data) {
  Contacts& contacts = data.contacts;
  if (contacts.forces.empty()) return;
  for (const std::int32_t contact : contacts.active) contacts.forces[contact] = {};
}

// Throws unless all are worlds and no two are the same. Marks the worlds themselves, which needs no list.
void check_worlds(std::span<World* const> worlds) {
  for (World* world : worlds) {
    if (world != nullptr) check_whole(internals(*world, "step"), "step of a list");
  }
  std::size_t sound = 0;
  while (sound < worlds.size() && worlds[sound] != nullptr && !internals(*worlds[sound]).listed) {
    internals(*worlds[sound++]).listed = true;
  }
  for (std::size_t i = 0; i < sound; ++i) internals(*worlds[i]).listed = false;
  if (sound < worlds.size()) fail_list(worlds, sound);
}

// `begin`: of the step, whose numbers of user joints are there but where ranks share the world.
void run_phases(WorldData& data, float dt, Crew& crew, Clock::time_point begin) {
  const bool asks = data.user_joints.callback && dt > 0.0f;
  if (Border* const border = border_of(data)) {
    adopt_calls(data, *border);
    if (asks) list_asked_joints(data);
  }
  clear_figures(data.stats);
  clear_events(data.events);
  PhaseClock clock(data.stats, begin, crew.zones());
  clock.lap(Phase::refresh_user_rows);
  data.shapes.waking_made.forget();
  data.shapes.queries_made.forget();
  data.contacts.by_shape_made.forget();
  if (data.last_dt == 0.0f) data.last_dt = dt;  // the first step looks ahead, too
  clock.run(Phase::find_pairs, [&] {            // calls since the last step -> lists of what moves
    place_matter(data);
    wake_neighbors(data);
    refresh_lists(data, crew);
    if (wake_pulled_bodies(data)) refresh_lists(data, crew);
    if (data.border != nullptr) {  // bodies of other ranks -> those that this one may meet
      share_ghosts(data, crew);
      refresh_lists(data, crew);
    }
  });
  if (asks && data.border != nullptr) {  // now that all bodies are there that the callback may read
    clock.run(Phase::refresh_user_rows, [&] { refresh_user_rows(*data.hooks.world, data, dt, crew); });
  }
  validate_stores(data);
  validate_members(data);
  clock.run(Phase::find_pairs, [&] { find_pairs(data, crew); });  // bounds    -> candidate pairs
  validate_pairs(data);
  validate_trees(data);
  clock.run(Phase::collide, [&] { collide(data, crew); });  // pairs     -> manifolds
  validate_pairs(data);
  validate_contacts(data);
  clock.run(Phase::find_islands, [&] {
    wake_touched_islands(data, crew);  // contacts, joints -> sleeping islands that wake
    put_islands_to_sleep(data, crew);  // slow bodies -> islands that fall asleep
    refresh_joints(data, crew);        // joints of awake bodies -> joints to solve
  });
  validate_members(data);
  validate_islands(data);
  clock.run(Phase::list_events, [&] {
    list_body_events(data);         // sleep, waking and lost joints -> their events
    note_approach(data, dt, crew);  // velocities -> approach speeds
  });
  if (dt > 0.0f) {
    clock.run(Phase::color_constraints, [&] { color_constraints(data, crew); });  // contacts  -> batches
    validate_colors(data);
    clock.run(Phase::pack_blocks, [&] { pack_blocks(data, crew); });  // manifolds -> wide blocks
    validate_blocks(data, crew);
    clock.run(Phase::solve, [&] { solve(data, dt, crew); });  // blocks    -> velocities
    clock.run(Phase::store_impulses, [&] {                    // blocks    -> manifolds
      store_impulses(data, dt, crew);
      break_joints(data, crew);  // reactions -> broken joints
    });
    validate_impulses(data);
    clock.run(Phase::list_events, [&] { list_joint_events(data, crew); });  // reactions -> strained joints
  } else {
    forget_forces(data);
    data.stats.awake_bodies = static_cast<std::int64_t>(data.bodies.awake.size());
  }
  clock.run(Phase::list_events,
            [&] { list_contact_events(data, dt, crew); });  // manifolds -> begins, ends, hits
  validate_events(data);
  if (dt > 0.0f) {
    if (Border* const border = border_of(data)) {
      clock.run(Phase::solve, [&] { share_motion(*border, data.bodies); });  // owners' motion -> all ranks
    }
    clock.run(Phase::sweep_fast_bodies,
              [&] { sweep_fast_bodies(data, dt, crew); });                // motion -> shorter motion
    clock.run(Phase::finish_step, [&] { finish_step(data, dt, crew); });  // motion -> poses, bounds
    validate_motion(data);
    data.last_dt = dt;
    data.last_substep = substep_of(data, dt);
  }
  ++data.step_count;  // before sensors ask queries, whose index is that of the next step
  clock.run(Phase::list_events, [&] { list_sensor_events(data, dt, crew); });  // poses -> what sensors see
  clock.finish();
  data.stats.step = data.step_count;
  data.stats.stages = crew.stages();
}

// What hooks may read while a step runs.
class HooksReady {
 public:
  HooksReady(Hooks& hooks, const World& world, float dt) : hooks_(hooks) {
    hooks_.world = &world;
    hooks_.dt = dt;
    hooks_.thrown = nullptr;
  }
  ~HooksReady() { hooks_.world = nullptr; }
  HooksReady(const HooksReady&) = delete;
  HooksReady& operator=(const HooksReady&) = delete;

 private:
  Hooks& hooks_;
};

void step(World& world, float dt, Crew& crew) {
  WorldData& data = internals(world, "step");
  const ZoneScope zone(crew.zones(), {ZoneKind::step, "step", static_cast<std::int64_t>(data.step_count)});
  const Clock::time_point begin = Clock::now();
  // Before anything else: it may throw, and the world is as it was then.
  if (data.user_joints.callback && dt > 0.0f && data.border == nullptr) {
    constexpr Phase kPhase = Phase::refresh_user_rows;
    const ZoneScope phase(crew.zones(), {ZoneKind::phase, phase_name(kPhase), static_cast<int>(kPhase)});
    list_asked_joints(data);
    refresh_user_rows(world, data, dt, crew);
  }
  if (data.border != nullptr) check_border(data);  // of what it refuses, a recording does not end
  data.recording.hash.reset();                     // a step that threw may have left one
  const HooksReady ready(data.hooks, world, dt);
  try {
    run_phases(data, dt, crew, begin);
  } catch (...) {
    data.recording.fail();  // the world must not be read any more
    data.last_save = {};    // a save nevertheless copies all there is
    throw;
  }
  if (Border* const border = border_of(data); border != nullptr && border->is_recorded)
    data.recording.hash = hash_of_all(data, *border);
  if (data.recording.sink != nullptr) {
    const std::uint64_t hash = data.recording.hash ? *data.recording.hash : hash_of(data.bodies);
    data.recording.sink->stepped(data, dt, hash);
  }
  if (Border* const border = border_of(data)) border->has_ended = true;
  if (data.hooks.thrown != nullptr) std::rethrow_exception(std::exchange(data.hooks.thrown, nullptr));
}

}  // namespace

void step(World& world, float dt, Workers& workers) {
  check_time_step(dt);
  internals(world, "step");  // throws where there is no world
  Crew crew(workers);
  step(world, dt, crew);
}

void step(std::span<World* const> worlds, float dt, Workers& workers) {
  check_time_step(dt);
  check_worlds(worlds);
  Crew crew(workers);
  const bool apart = std::cmp_greater_equal(worlds.size(), crew.threads());  // a thread for each
  const auto step_one = [&](int number) {
    World& world = *worlds[static_cast<std::size_t>(number)];
    if (!apart) return step(world, dt, workers);
    Crew alone(crew, Crew::Alone{});
    step(world, dt, alone);
  };
  const auto count = static_cast<int>(worlds.size());
  if (apart && crew.threads() > 1) return crew.run(count, [&](int world, int) { step_one(world); });
  // As there, one whose callback throws keeps no other from its step.
  std::exception_ptr first;
  for (int world = 0; world < count; ++world) {
    try {
      step_one(world);
    } catch (...) {
      if (first == nullptr) first = std::current_exception();
    }
  }
  if (first != nullptr) std::rethrow_exception(first);
}

}  // namespace scree
