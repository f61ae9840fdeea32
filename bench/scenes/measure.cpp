// One measurement: times whole steps, then evaluates the result.
#include "bench/scenes/measure.h"

#include "bench/engine.h"

#include <nlohmann/json.hpp>

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <optional>
#include <vector>

extern char** environ;  // NOLINT: POSIX names it so

namespace scree::bench {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Request, scene, parameters, engine, isa, continuous, threads, steps,
                                   warmup, evaluate_every, stand_steps)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Measurement, error, complaint, variant, continuous, bodies, timed_steps,
                                   ms_per_step, ms_median, ms_min, ms_max, step_ms, cpu_ms_per_step,
                                   create_ms, phases, engine_contacts, awake, touching, penetration_mean,
                                   penetration_p999, penetration_max, kinetic_energy, top_drop, bodies_left,
                                   drift_joints, drift_mean, drift_max, pooled_pairs, pooled_mean,
                                   pooled_p999, pooled_max, pooled_drift_mean, pooled_drift_max,
                                   collapse_step, steps_done, bits, peak_bytes)

namespace {

using Clock = std::chrono::steady_clock;

// Peers print too: the result is the line that begins with this.
constexpr const char* kMarker = "scree-bench-result ";

double milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

Isa parse_isa(const std::string& name) {
  if (name == "auto") return Isa::automatic;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (name == isa_name(isa)) return isa;
  }
  throw Error("unknown instruction set " + name);
}

double processor_milliseconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

// FNV-1a over the raw floats: enough to see whether two runs ended in the same bits.
class Fingerprint {
 public:
  template <class Row>
  void add(const Row& row) {
    std::array<unsigned char, sizeof(Row)> bytes{};
    std::memcpy(bytes.data(), &row, sizeof(Row));
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3u;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

// The scene's worlds in one engine, and their evaluators.
class Run {
 public:
  explicit Run(const Request& request) : scenes_(scenes::build(request.scene, request.parameters)) {
    const auto& all = engines();
    const auto info =
        std::find_if(all.begin(), all.end(), [&](const EngineInfo& e) { return e.name == request.engine; });
    if (info == all.end()) throw Error("unknown engine " + request.engine);
    for (const scenes::Scene& scene : scenes_) check_scene(*info, scene);
    const bool continuous =
        request.continuous == "scene" ? scenes_.front().settings.continuous : request.continuous == "on";
    continuous_ = info->continuous.empty() ? "none" : continuous ? "on" : "off";
    const Clock::time_point start = Clock::now();
    engine_ = info->create(
        scenes_,
        {.threads = request.threads, .isa = parse_isa(request.isa), .continuous = continuous_ == "on"});
    create_ms_ = milliseconds(Clock::now() - start);
  }

  float dt() const { return scenes_.front().dt; }
  int scene_steps() const { return scenes_.front().steps; }
  Engine& engine() { return *engine_; }

  void describe(Measurement& result) {
    result.create_ms = create_ms_;
    result.continuous = continuous_;
    for (const scenes::Scene& scene : scenes_) {
      for (const scenes::SceneBody& body : scene.bodies) {
        if (body.def.type == BodyType::dynamic) ++result.bodies;
      }
    }
  }

  // Passes the engine the poses of driven bodies at the end of the next step.
  void drive(int step) {
    for (std::size_t world = 0; world < scenes_.size(); ++world) {
      for (const scenes::SceneDrive& drive : scenes_[world].drives) {
        const double end = static_cast<double>(step + 1) * double{dt()};
        engine_->move_kinematic(world, drive.body, scenes::drive_target(drive, end), dt());
      }
    }
  }

  // Creates and destroys the bodies that are due before the next step.
  void make_changes(int step) {
    for (std::size_t world = 0; world < scenes_.size(); ++world) {
      for (const scenes::SceneChange& change : scenes::changes_at(scenes_[world], step)) {
        engine_->make_change(world, change);
      }
    }
  }

  void judge_bodies(Measurement& result, double* top_height = nullptr) {
    prepare_judges();
    Fingerprint fingerprint;
    for (std::size_t world = 0; world < scenes_.size(); ++world) {
      engine_->read(world, states_);
      const BodyFigures figures = judges_[world].body_figures(states_);
      result.kinetic_energy += figures.kinetic_energy;
      result.top_drop = std::max(result.top_drop, figures.top_drop);
      result.bodies_left += figures.bodies_left;
      if (top_height != nullptr) *top_height = std::min(*top_height, figures.top_height);
      for (const BodyState& state : states_) {
        if (!state.exists) continue;
        fingerprint.add(state.pose);
        fingerprint.add(state.linear_velocity);
        fingerprint.add(state.angular_velocity);
      }
    }
    result.bits = fingerprint.value();
  }

  void judge_constraints(PenetrationStatistics& contacts, DriftStatistics& joints) {
    prepare_judges();
    for (std::size_t world = 0; world < scenes_.size(); ++world) {
      engine_->read(world, states_);
      judges_[world].add_touching_pairs(states_, contacts);
      judges_[world].add_joint_drift(states_, joints);
    }
  }

 private:
  void prepare_judges() {
    if (!judges_.empty()) return;
    judges_.reserve(scenes_.size());
    for (const scenes::Scene& scene : scenes_) judges_.emplace_back(scene);
  }

  std::vector<scenes::Scene> scenes_;
  std::unique_ptr<Engine> engine_;
  std::vector<Evaluator> judges_;
  std::vector<BodyState> states_;
  std::string continuous_;
  double create_ms_ = 0.0;
};

void time_steps(const Request& request, Run& run, Measurement& result) {
  const int steps = request.steps > 0 ? request.steps : run.scene_steps();
  const int warmup = std::min(request.warmup, steps - 1);
  PenetrationStatistics pooled;
  DriftStatistics pooled_drift;
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(steps - warmup));
  double total = 0.0;
  double processor_total = 0.0;
  for (int step = 0; step < steps; ++step) {
    run.drive(step);
    const double processor_start = processor_milliseconds();
    const Clock::time_point start = Clock::now();
    run.make_changes(step);
    run.engine().step(run.dt());
    const double ms = milliseconds(Clock::now() - start);
    const double processor_ms = processor_milliseconds() - processor_start;
    if (step >= warmup) {
      times.push_back(ms);
      total += ms;
      processor_total += processor_ms;
      for (const auto& [name, phase_ms] : run.engine().phases()) result.phases[name] += phase_ms;
    }
    if (request.evaluate_every > 0 && (step + 1) % request.evaluate_every == 0) {
      run.judge_constraints(pooled, pooled_drift);
    }
  }
  const double count = static_cast<double>(times.size());
  for (auto& [name, ms] : result.phases) ms /= count;
  result.step_ms = times;
  std::sort(times.begin(), times.end());
  result.steps_done = steps;
  result.timed_steps = static_cast<int>(times.size());
  result.ms_per_step = total / count;
  result.cpu_ms_per_step = processor_total / count;
  result.ms_median = times[times.size() / 2];
  result.ms_min = times.front();
  result.ms_max = times.back();
  result.pooled_pairs = pooled.pairs();
  result.pooled_mean = pooled.mean();
  result.pooled_p999 = pooled.quantile(0.999);
  result.pooled_max = pooled.max();
  result.pooled_drift_mean = pooled_drift.mean();
  result.pooled_drift_max = pooled_drift.max();
}

void step_until_collapse(const Request& request, Run& run, Measurement& result) {
  while (result.steps_done < request.stand_steps && result.collapse_step == 0) {
    run.drive(result.steps_done);
    run.make_changes(result.steps_done);
    run.engine().step(run.dt());
    ++result.steps_done;
    Measurement now;
    double top_height = 1.0;
    run.judge_bodies(now, &top_height);
    if (top_height < kCollapseHeight) result.collapse_step = result.steps_done;
  }
}

Measurement measure(const Request& request) {
  Measurement result;
  Run run(request);
  run.describe(result);
  if (request.stand_steps > 0) {
    step_until_collapse(request, run, result);
  } else {
    time_steps(request, run, result);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  result.peak_bytes = std::int64_t{usage.ru_maxrss} * 1024;
  run.judge_bodies(result);
  PenetrationStatistics last;
  DriftStatistics last_drift;
  run.judge_constraints(last, last_drift);
  result.touching = last.pairs();
  result.penetration_mean = last.mean();
  result.penetration_p999 = last.quantile(0.999);
  result.penetration_max = last.max();
  result.drift_joints = last_drift.joints();
  result.drift_mean = last_drift.mean();
  result.drift_max = last_drift.max();
  result.engine_contacts = run.engine().contacts();
  result.awake = run.engine().awake();
  result.variant = run.engine().variant();
  result.complaint = run.engine().complaint();
  return result;
}

Measurement failed(const std::string& reason) {
  Measurement result;
  result.error = reason;
  return result;
}

// Starts this program again and returns its output and exit status; nothing if it could not be started.
std::optional<std::string> run_self(const std::string& request_json, int& status) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return std::nullopt;
  std::string program = "/proc/self/exe";
  std::string flag = "--child";
  std::string argument = request_json;
  std::array<char*, 4> arguments{program.data(), flag.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addclose(&actions, ends[0]);
  posix_spawn_file_actions_addclose(&actions, ends[1]);
  pid_t child = 0;
  const int failure = posix_spawn(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string output;
  if (failure == 0) {
    std::array<char, 4096> buffer{};
    for (ssize_t got = 0; (got = read(ends[0], buffer.data(), buffer.size())) > 0;) {
      output.append(buffer.data(), static_cast<std::size_t>(got));
    }
    waitpid(child, &status, 0);
  }
  close(ends[0]);
  if (failure != 0) return std::nullopt;
  return output;
}

}  // namespace

Measurement measure_in_child(const Request& request) {
  int status = 0;
  const std::optional<std::string> output = run_self(nlohmann::json(request).dump(), status);
  if (!output) return failed("could not start the measuring process");
  if (WIFSIGNALED(status)) return failed("killed by signal " + std::to_string(WTERMSIG(status)));
  const std::size_t begin = output->rfind(kMarker);
  if (begin == std::string::npos)
    return failed("no result, exit status " + std::to_string(WEXITSTATUS(status)));
  return nlohmann::json::parse(output->substr(begin + std::strlen(kMarker))).get<Measurement>();
}

int child_main(const std::string& request_json) {
  Measurement result;
  try {
    result = measure(nlohmann::json::parse(request_json).get<Request>());
  } catch (const std::exception& exception) {
    result = failed(exception.what());
  }
  std::printf("\n%s%s\n", kMarker, to_json(result).c_str());
  return 0;
}

std::string to_json(const Measurement& measurement) { return nlohmann::json(measurement).dump(); }

}  // namespace scree::bench
