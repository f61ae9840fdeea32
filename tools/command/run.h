// One run of a scene, from options to figures. report.cpp shows the figures.
#pragma once

#include <scree/scree.h>
#include <tools/command/picture.h>
#include <tools/command/team.h>
#include <tools/command/trace.h>
#include <tools/scenes/scene.h>

#include <array>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

struct RunOptions {
  std::string scene;              // a built-in name or a scene file
  scenes::Parameters parameters;  // of a built-in scene
  std::optional<int> steps;       // all of them, the warm-up included; default: the scene's
  std::optional<double> dt;       // s; default: the scene's
  std::optional<int> substeps;    // default: the scene's
  int threads = 0;                // 0: one per core
  Isa isa = Isa::automatic;
  std::optional<int> warmup;          // untimed steps at the start; default 1 where there are that many
  std::optional<std::string> solver;  // default: the scene's
  std::optional<int> iterations;      // the same
  bool no_sleep = false;
  bool no_continuous = false;
  std::optional<double> latency;        // us, that each message takes longer; with `distributed`
  bool distributed = false;             // needs a team
  bool quiet = false;                   // no progress
  std::string record;                   // file for a recording; empty: none
  std::optional<int> keyframes;         // steps from one keyframe of the recording to the next
  std::string checkpoint;               // file that is written anew again and again; empty: none
  std::optional<int> checkpoint_steps;  // from one to the next; default 1000
  std::string resume;                   // a checkpoint to go on from; empty: from the beginning
  std::string trace;                    // file for a timeline; empty: none
  std::string picture_file;             // for a picture of the end, of the first world; empty: none
  PictureOptions picture;
};

// The recording that a run made.
struct RecordingFigures {
  std::string file;
  std::uint64_t bytes = 0;
  std::uint64_t steps = 0;
};

// Figures of a run. Counts, energy and stages are sums over the worlds; penetrations and residual are the
// largest; the mean penetration is the mean over all overlaps.
struct RunFigures {
  std::string scene;
  Isa isa = Isa::scalar;
  int threads = 1;
  int worlds = 1;
  int steps = 0;
  int warmup = 0;
  int timed_steps = 0;
  double dt = 0.0;
  int substeps = 0;
  std::int64_t bodies = 0;  // that can move
  std::int64_t fixed_bodies = 0;
  std::int64_t joints = 0;
  std::int64_t restored_bodies = 0;  // over all steps, each time that a body's state became non-finite
  std::int64_t awake_bodies = 0;     // at the end, as all that follows
  std::int64_t contacts = 0;         // touching manifolds
  std::int64_t overlaps = 0;         // touching manifolds of awake bodies that overlap
  double ms_mean = 0.0;
  double ms_median = 0.0;
  double ms_min = 0.0;
  double ms_max = 0.0;
  std::array<double, kPhaseCount> phase_ms{};  // mean over the timed steps
  double penetration_mean = 0.0;
  double penetration_p999 = 0.0;
  double penetration_max = 0.0;
  double residual = 0.0;
  double kinetic_energy = 0.0;
  std::uint64_t peak_memory_bytes = 0;
  double lane_fill = 1.0;
  std::int64_t stages = 0;
  std::uint64_t hash = 0;
  std::vector<RankStats> ranks;  // of the last step, if the run is distributed
  std::optional<RecordingFigures> recording;
  std::optional<TraceFigures> trace;
  std::optional<PictureFigures> picture;
  std::exception_ptr failure;  // of the picture; to be thrown when all else is written

  double steps_per_second() const { return ms_mean > 0.0 ? 1000.0 / ms_mean : 0.0; }
};

// Whether the name is that of a scene file rather than of a built-in scene.
bool is_scene_file(const std::string& name);

// The worlds of a built-in scene or of a scene file, which has no parameters.
std::vector<scenes::Scene> find_scene(const std::string& name, const scenes::Parameters& parameters);

// Checks the options, builds the scene, runs it, and shows progress on standard error. Throws scree::Error
// for bad options. With a team, which is otherwise null, all of its processes run it together.
RunFigures run(const RunOptions& options, Team* team);

}  // namespace scree::command
