// Runs a scene: options -> worlds -> steps -> figures.
#include <scree/recording.h>
#include <sys/resource.h>
#include <tools/command/options.h>
#include <tools/command/progress.h>
#include <tools/command/resume.h>
#include <tools/command/run.h>
#include <tools/scenes/digest.h>
#include <tools/scenes/scene_file.h>
#include <tools/scenes/stage.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace scree::command {

std::vector<scenes::Scene> find_scene(const std::string& name, const scenes::Parameters& parameters) {
  if (!is_scene_file(name)) return scenes::build(name, parameters);
  if (!parameters.empty())
    throw Error("--set " + parameters.begin()->first + ": a scene file has no parameters");
  std::vector<scenes::Scene> worlds;
  worlds.push_back(scenes::read_scene_file(name));
  return worlds;
}

namespace {

constexpr int kMostSteps = 1'000'000'000;
constexpr int kStepsToCheckpoint = 1000;
constexpr int kMostKeyframes = 1'000'000'000;  // RecorderOptions' limit

// The worlds and settings of a run, after its scene and options are checked.
struct Plan {
  std::vector<scenes::Scene> worlds;
  int steps = 0;
  int steps_taken = 0;  // of these, before this run
  int warmup = 0;       // of this run
  float dt = 0.0f;
  std::string checkpoint;
  int checkpoint_steps = 0;
};

// Times of a run, one entry per timed step, and the number of restored bodies.
struct Timing {
  std::vector<double> step_ms;
  std::array<double, kPhaseCount> phase_ms{};  // sums
  std::int64_t restored_bodies = 0;            // in all steps, timed or not
};

bool is_built_in(const std::string& name) {
  return std::any_of(scenes::catalog().begin(), scenes::catalog().end(),
                     [&](const scenes::SceneInfo& info) { return info.name == name; });
}

// What a process would do with its part of the world alone.
void refuse_beside_distributed(const RunOptions& options) {
  const std::pair<const char*, const std::string&> files[] = {{"--trace", options.trace},
                                                              {"--picture", options.picture_file}};
  for (const auto& [name, file] : files) {
    if (!file.empty()) throw Error(std::string(name) + " " + file + ": not with --distributed yet");
  }
}

void check_options(const RunOptions& options) {
  if (options.steps) check_range("--steps", *options.steps, 1, kMostSteps);
  if (options.substeps) check_range("--substeps", *options.substeps, 1, kMostSubsteps);
  if (options.iterations) check_range("--iterations", *options.iterations, 1, kMostIterations);
  if (options.warmup) check_range("--warmup", *options.warmup, 0, kMostSteps);
  if (options.keyframes) check_range("--keyframes", *options.keyframes, 1, kMostKeyframes);
  if (options.keyframes && options.record.empty())
    throw Error("--keyframes says nothing without --record FILE");
  if (options.checkpoint_steps) check_range("--checkpoint-steps", *options.checkpoint_steps, 1, kMostSteps);
  if (options.checkpoint_steps && options.checkpoint.empty())
    throw Error("--checkpoint-steps says nothing without --checkpoint FILE");
  if (options.dt && !(*options.dt >= 0.0 && *options.dt <= 1.0)) {
    throw Error("--dt " + std::to_string(*options.dt) + " must be from 0 to 1 seconds");
  }
  check_backend(options.threads, options.isa);
  if (options.latency && !options.distributed) throw Error("--latency says nothing without --distributed");
  if (options.latency && !(*options.latency >= 0.0 && *options.latency <= 1e6))
    throw Error("--latency " + std::to_string(*options.latency) + " must be from 0 to 1e6 microseconds");
  if (options.distributed) refuse_beside_distributed(options);
  if (options.picture_file.empty()) return;
  check_picture_name("--picture", options.picture_file);
  read_picture(options.picture);
}

Plan make_plan(const RunOptions& options) {
  check_options(options);
  Plan plan;
  plan.worlds = find_scene(options.scene, options.parameters);
  if (!options.record.empty() && plan.worlds.size() > 1) {
    throw Error("--record " + options.record + ": a recording is of one world, and the scene " +
                plan.worlds.front().name + " consists of " + std::to_string(plan.worlds.size()) +
                "; say --set worlds=1");
  }
  const scenes::Scene& first = plan.worlds.front();
  plan.steps = options.steps.value_or(first.steps);
  plan.dt = options.dt ? static_cast<float>(*options.dt) : first.dt;
  plan.warmup = options.warmup.value_or(std::min(1, plan.steps - 1));
  plan.checkpoint = options.checkpoint;
  plan.checkpoint_steps = options.checkpoint_steps.value_or(kStepsToCheckpoint);
  if (options.distributed && plan.worlds.size() > 1)
    throw Error("--distributed: is for one world; say --set worlds=1");
  for (const auto& [name, file] :
       {std::pair("--checkpoint", options.checkpoint), std::pair("--resume", options.resume)}) {
    if (file.empty()) continue;
    if (plan.worlds.size() > 1)
      throw Error(std::string(name) + " " + file + ": is for one world; say --set worlds=1");
  }
  if (plan.warmup >= plan.steps) {
    throw Error("--warmup " + std::to_string(plan.warmup) + " must be below the " +
                std::to_string(plan.steps) + " steps of the run");
  }
  for (scenes::Scene& scene : plan.worlds) {
    if (options.substeps) scene.settings.substeps = *options.substeps;
    if (options.solver) scene.settings.solver = read_solver(*options.solver);
    if (options.iterations) scene.settings.solver_options.iterations = *options.iterations;
    if (options.no_sleep) scene.settings.sleeping = false;
    if (options.no_continuous) scene.settings.continuous = false;
  }
  return plan;
}

void measure_quality(std::span<World* const> worlds) {
  for (World* const world : worlds) {
    WorldSettings settings = world->settings();
    settings.measure_residual = true;
    settings.measure_penetration = true;
    world->set_settings(settings);
  }
}

// The driven bodies of a world, and the changes of its bodies.
struct Cast {
  scenes::Scene script;
  std::vector<BodyId> bodies;  // of the whole scene; empty if no body is driven, arrives or leaves
};

void direct_all(std::span<World* const> worlds, std::vector<Cast>& casts, int steps_done, float dt) {
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    scenes::direct(*worlds[i], casts[i].script, casts[i].bodies, steps_done, dt);
  }
}

// Steps all worlds once, or the one of the team; milliseconds.
double step_all(std::span<World* const> worlds, Team* team, float dt, Workers& workers) {
  const auto start = std::chrono::steady_clock::now();
  if (team != nullptr) {
    team->world().step(dt, workers);
  } else {
    step(worlds, dt, workers);
  }
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Records the world of a run, if requested. A full disk ends the run: the loss of a recording must not stay
// hidden for hours.
class Recording {
 public:
  void begin(World& world, Team* team, const RunOptions& options, Workers& workers) {
    if (options.record.empty()) return;
    file_ = options.record;
    team_ = team;
    workers_ = &workers;
    RecorderOptions recorder_options;
    if (options.keyframes) recorder_options.keyframe_spacing = *options.keyframes;
    try {
      if (team != nullptr) {
        team->world().record(file_, workers, recorder_options);
      } else {
        recorder_.emplace(world, file_, recorder_options);
      }
    } catch (const Error& error) {
      fail(error.what());  // name and options were checked when the command began
    }
  }
  void check() const {
    if (const Recorder* const one = recorder(); one != nullptr && !one->is_recording()) fail(one->error());
  }
  std::optional<RecordingFigures> finish() {
    if (file_.empty()) return {};
    try {
      if (team_ != nullptr) {
        team_->world().finish_recording(*workers_);
      } else {
        recorder_->finish();
      }
    } catch (const Error& error) {
      fail(error.what());
    }
    const Recorder* const one = recorder();
    return one != nullptr ? std::optional(RecordingFigures{file_, one->bytes_written(), one->steps()})
                          : std::nullopt;
  }

 private:
  // Not the caller's mistake, so not a scree::Error.
  [[noreturn]] void fail(const std::string& reason) const { throw std::runtime_error("--record: " + reason); }

  // Of a team, the leader has it.
  const Recorder* recorder() const {
    if (team_ != nullptr) return team_->world().recorder();
    return recorder_ ? &*recorder_ : nullptr;
  }

  std::string file_;
  Team* team_ = nullptr;
  Workers* workers_ = nullptr;
  std::optional<Recorder> recorder_;
};

// Bytes of memory that programs can still get; 0 if the system does not tell.
std::uint64_t available_memory() {
  std::ifstream info("/proc/meminfo");
  for (std::string line; std::getline(info, line);) {
    constexpr std::string_view kName = "MemAvailable:";
    if (line.starts_with(kName)) return std::stoull(line.substr(kName.size())) * 1024;
  }
  return 0;
}

// What each process takes at most, now that it has the scene. A pile of 500,000 bodies took 0.94 KB for the
// rows of a body, and at rest a body has some three contacts of 0.7 KB. Of a body of others a process has 70
// bytes, and a joint is everywhere.
std::uint64_t memory_of_each(const scenes::Scene& scene, const Team& team, const RunOptions& options) {
  constexpr std::uint64_t kBytesPerBody = 3100, kBytesPerAbsentBody = 100, kBytesPerJoint = 600;
  const auto ranks = static_cast<std::uint64_t>(team.processes());
  const std::uint64_t bodies = scene.bodies.size();
  const std::uint64_t part =
      bodies * (kBytesPerBody / ranks + kBytesPerAbsentBody) + scene.joints.size() * kBytesPerJoint;
  // A checkpoint of a single process each of them reads as a whole. Who reads or writes a file has its part
  // of the world several times meanwhile.
  if (!options.resume.empty() && checkpoint_ranks(options.resume) == 1)
    return 3 * (bodies * kBytesPerBody + scene.joints.size() * kBytesPerJoint);
  const bool has_files = !options.record.empty() || !options.checkpoint.empty() || !options.resume.empty();
  return has_files ? 3 * part : part;
}

// Each looks before any of them takes more.
void check_memory(const scenes::Scene& scene, Team& team, const RunOptions& options) {
  const auto processes = static_cast<std::uint64_t>(team.processes_here());
  const std::uint64_t each = memory_of_each(scene, team, options);
  const std::uint64_t available = available_memory();
  team.meet();
  if (available == 0 || each * processes <= available) return;
  throw Error("--distributed: " + std::to_string(scene.bodies.size()) + " bodies take about " +
              std::to_string(each >> 20) + " MiB in each of the " + std::to_string(processes) +
              " processes of a machine that has " + std::to_string(available >> 20) + " MiB left");
}

// Of all that the scene and its steps are made from, of what processes do together besides, and roughly of
// the scene itself.
std::uint64_t digest_of(const scenes::Scene& scene, const RunOptions& options, const Plan& plan) {
  scenes::Digest digest;
  const auto add_text = [&](const std::string& text) {
    for (const char letter : text) digest.add(static_cast<unsigned char>(letter));
    digest.add(text.size());
  };
  for (const auto& [name, value] : options.parameters) {
    add_text(name);
    digest.add(std::bit_cast<std::uint64_t>(value));
  }
  if (is_scene_file(options.scene)) {  // which may have another name in each process
    std::ifstream file(options.scene, std::ios::binary);
    add_text(std::string(std::istreambuf_iterator<char>(file), {}));
  } else {
    add_text(options.scene);
  }
  digest.add(std::bit_cast<std::uint32_t>(plan.dt));
  const int together[] = {plan.steps,
                          options.record.empty() ? 0 : options.keyframes.value_or(-1),
                          options.checkpoint.empty() ? 0 : plan.checkpoint_steps,
                          options.resume.empty() ? 0 : 1,
                          options.no_sleep ? 1 : 0,
                          options.no_continuous ? 1 : 0};
  for (const int one : together) digest.add(static_cast<std::uint64_t>(one));
  digest.add(scenes::digest_of(scene));
  return digest.value();
}

void check_alike(Team& team, const scenes::Scene& scene, const RunOptions& options, const Plan& plan) {
  const std::uint64_t own = digest_of(scene, options, plan) >> 32;
  team.meet();
  // All are the same exactly where the mean of the squares is the square of the mean.
  const auto sum = static_cast<std::uint64_t>(team.add_up(static_cast<std::int64_t>(own)));
  const auto squares = static_cast<std::uint64_t>(team.add_up(static_cast<std::int64_t>(own * own)));
  if (static_cast<std::uint64_t>(team.processes()) * squares != sum * sum)
    throw Error("--distributed: the scenes or steps of the processes differ");
}

// Fills the world of a team: each process gives its share of a scene.
std::vector<BodyId> populate_team(Team& team, const scenes::Scene& scene, const RunOptions& options,
                                  Workers& workers) {
  team.take(World(scene.settings), options.latency.value_or(0.0));
  return scenes::populate(team.world(), scene, workers);
}

// A full disk ends the run, as where it is recorded.
void write_checkpoint_of(const World& world, Team* team, const Plan& plan, int steps_taken,
                         Workers& workers) {
  if (plan.checkpoint.empty() || steps_taken % plan.checkpoint_steps != 0) return;
  try {
    if (team == nullptr) return write_checkpoint(world, plan.checkpoint);
    team->world().checkpoint(plan.checkpoint, workers);
  } catch (const Error& error) {
    throw std::runtime_error(std::string("--checkpoint: ") + error.what());
  }
  team->note_checkpoint(plan.checkpoint, static_cast<std::uint64_t>(steps_taken));
}

// Measures quality in the last step. This step is excluded from the times unless it is the only one.
Timing simulate(std::span<World* const> worlds, Team* team, std::vector<Cast>& casts, const Plan& plan,
                const Recording& recording, Trace* trace, Workers& workers, Progress& progress) {
  Timing timing;
  std::vector<const StepStats*> stats;
  for (const World* const world : worlds) stats.push_back(&world->stats());
  for (int i = plan.steps_taken; i < plan.steps; ++i) {
    const bool last = i + 1 == plan.steps;
    if (last && team == nullptr) measure_quality(worlds);
    direct_all(worlds, casts, i, plan.dt);
    const double milliseconds = step_all(worlds, team, plan.dt, workers);
    if (trace != nullptr) trace->count(stats);
    progress.show(i + 1);
    recording.check();
    write_checkpoint_of(*worlds.front(), team, plan, i + 1, workers);
    for (const StepStats* const of_world : stats) timing.restored_bodies += of_world->restored_bodies;
    if (i - plan.steps_taken < plan.warmup || (last && !timing.step_ms.empty())) continue;
    timing.step_ms.push_back(milliseconds);
    for (const StepStats* const of_world : stats) {
      for (std::size_t phase = 0; phase < kPhaseCount; ++phase) {
        timing.phase_ms[phase] += of_world->phase_ms[phase];
      }
    }
  }
  progress.finish();
  return timing;
}

void add_times(Timing timing, RunFigures& figures) {
  std::vector<double>& times = timing.step_ms;
  const auto count = static_cast<double>(times.size());
  figures.timed_steps = static_cast<int>(times.size());
  figures.restored_bodies = timing.restored_bodies;
  double sum = 0.0;
  for (const double time : times) sum += time;
  figures.ms_mean = sum / count;
  std::sort(times.begin(), times.end());
  const std::size_t middle = times.size() / 2;
  figures.ms_median = times.size() % 2 == 1 ? times[middle] : 0.5 * (times[middle - 1] + times[middle]);
  figures.ms_min = times.front();
  figures.ms_max = times.back();
  for (std::size_t phase = 0; phase < kPhaseCount; ++phase) {
    figures.phase_ms[phase] = timing.phase_ms[phase] / count;
  }
}

void add_quality(const std::vector<World>& worlds, RunFigures& figures) {
  double penetration_sum = 0.0;
  double fill_sum = 0.0;
  for (const World& world : worlds) {
    const StepStats& stats = world.stats();
    figures.contacts += stats.contacts;
    figures.overlaps += stats.overlaps;
    figures.awake_bodies += stats.awake_bodies;
    figures.stages += stats.stages;
    figures.kinetic_energy += stats.kinetic_energy;
    figures.residual = std::max(figures.residual, stats.residual);
    figures.penetration_max = std::max(figures.penetration_max, stats.penetration_max);
    figures.penetration_p999 = std::max(figures.penetration_p999, stats.penetration_p999);
    penetration_sum += stats.penetration_mean * static_cast<double>(stats.overlaps);
    fill_sum += stats.lane_fill;
  }
  if (figures.overlaps > 0) {
    figures.penetration_mean = penetration_sum / static_cast<double>(figures.overlaps);
  }
  figures.lane_fill = fill_sum / static_cast<double>(worlds.size());
}

// What only all ranks together know. Contacts across borders are known twice.
void add_ranks(Team& team, RunFigures& figures) {
  figures.ranks.resize(static_cast<std::size_t>(team.world().ranks()));
  team.world().stats(figures.ranks);
  std::int64_t border_contacts = 0;
  for (const RankStats& rank : figures.ranks) {
    figures.awake_bodies += rank.awake_bodies;
    figures.contacts += rank.contacts;
    border_contacts += rank.border_contacts;
  }
  figures.contacts -= border_contacts / 2;
  figures.restored_bodies = team.add_up(figures.restored_bodies);  // of the bodies of each
  figures.hash = team.world().hash();
}

PictureFigures take_picture(const World& world, const RunOptions& options, Workers& workers) {
  const PicturePlan plan = read_picture(options.picture);
  const render::Subject subject = render::subject_of(world);
  return take_picture(world, plan, camera_for(plan, subject), subject, options.picture_file, workers);
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux reports KiB
}

}  // namespace

bool is_scene_file(const std::string& name) {
  if (is_built_in(name)) return false;
  std::error_code problem;  // such as a name that is too long
  return name.ends_with(".json") || name.find('/') != std::string::npos ||
         std::filesystem::is_regular_file(name, problem);
}

RunFigures run(const RunOptions& options, Team* team) {
  Plan plan = make_plan(options);
  const bool quiet = options.quiet || (team != nullptr && !team->leads());
  const int threads = team == nullptr ? options.threads : team->threads_each(options.threads);
  if (!quiet) tell_of_idle_threads(threads);
  std::optional<Trace> trace;
  Workers workers = make_workers(threads, options.isa, options.trace, trace);
  RunFigures figures;
  figures.scene = plan.worlds.front().name;
  figures.isa = workers.isa();
  figures.threads = workers.threads();
  figures.worlds = static_cast<int>(plan.worlds.size());
  figures.steps = plan.steps;
  figures.warmup = plan.warmup;
  figures.dt = static_cast<double>(plan.dt);
  figures.substeps = plan.worlds.front().settings.substeps;
  if (team != nullptr) {
    check_memory(plan.worlds.front(), *team, options);
    check_alike(*team, plan.worlds.front(), options, plan);
  }
  Progress progress(figures.scene, plan.steps, !quiet);
  std::vector<World> worlds;
  std::vector<Cast> casts;
  worlds.reserve(plan.worlds.size());
  std::optional<DistributedWorld> checkpoint;
  if (team != nullptr && !options.resume.empty())
    checkpoint.emplace(team->read(options.resume, options.latency.value_or(0.0), workers));
  for (scenes::Scene& scene : plan.worlds) {
    std::vector<BodyId> bodies = team != nullptr
                                     ? populate_team(*team, scene, options, workers)
                                     : scenes::populate(worlds.emplace_back(scene.settings), scene);
    if (scene.drives.empty() && scene.changes.empty()) bodies = {};
    casts.push_back({scenes::script_of(scene), std::move(bodies)});
    for (const scenes::SceneBody& body : scene.bodies) {
      ++(body.def.type == BodyType::fixed ? figures.fixed_bodies : figures.bodies);
    }
    figures.joints += static_cast<std::int64_t>(scene.joints.size());
    scene = {};  // avoids holding a million bodies twice
  }
  if (!options.resume.empty()) {
    auto& [script, bodies] = casts.front();
    plan.steps_taken = checkpoint ? resume(*team, std::move(*checkpoint), script, bodies, options, plan.steps)
                                  : resume(worlds.front(), script, bodies, options, plan.steps);
  }
  plan.warmup = figures.warmup = std::min(plan.warmup, plan.steps - plan.steps_taken - 1);
  std::vector<World*> pointers;
  for (World& world : worlds) pointers.push_back(&world);
  if (team != nullptr) pointers = {&team->world().world()};
  Recording recording;
  recording.begin(*pointers.front(), team, options, workers);
  Trace* const tracing = trace ? &*trace : nullptr;
  add_times(simulate(pointers, team, casts, plan, recording, tracing, workers, progress), figures);
  if (trace) figures.trace = trace->finish(options.trace);
  figures.recording = recording.finish();
  if (team != nullptr) {
    add_ranks(*team, figures);
  } else {
    add_quality(worlds, figures);
    figures.hash = scenes::hash_of(worlds);
  }
  figures.peak_memory_bytes = peak_memory_bytes();
  try {
    if (!options.picture_file.empty()) figures.picture = take_picture(worlds.front(), options, workers);
  } catch (...) {
    figures.failure = std::current_exception();  // the figures of a long run are worth more
  }
  return figures;
}

}  // namespace scree::command
