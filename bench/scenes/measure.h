// One measurement: one engine, one scene, one thread count, in a process of its own.
//
// The program starts itself again with a request and reads the figures back as one line of JSON, so that no
// engine inherits another's memory, threads or accumulated state.
#pragma once

#include "tools/scenes/scene.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace scree::bench {

/// What to measure.
struct Request {
  std::string scene;
  std::map<std::string, double> parameters;
  std::string engine;
  std::string isa = "auto";
  std::string continuous = "scene";  ///< continuous collision: "on", "off", or as the scene has it
  int threads = 1;
  int steps = 0;           ///< all of them, including the warm-up; 0: the scene's own length
  int warmup = 1;          ///< untimed first steps
  int evaluate_every = 0;  ///< k: also evaluate every k-th step (a run whose time does not count)
  int stand_steps = 0;     ///< above 0: no timing; steps up to this number until the stack has collapsed
};

/// The results. Lengths in m, energy in J, times in ms.
struct Measurement {
  std::string error;                ///< empty on success; otherwise no other member is valid
  std::string complaint;            ///< see Engine::complaint
  std::string variant;              ///< see Engine::variant
  std::string continuous = "none";  ///< collision: "on", "off", or "none" if the engine does not have it
  int bodies = 0;                   ///< dynamic ones
  int timed_steps = 0;
  double ms_per_step = 0.0;  ///< total time over timed steps
  double ms_median = 0.0;    ///< over the timed steps, as are the two below
  double ms_min = 0.0;
  double ms_max = 0.0;
  std::vector<double> step_ms;           ///< of the timed steps, in their order
  double cpu_ms_per_step = 0.0;          ///< processor time of the whole process, all threads together
  double create_ms = 0.0;                ///< building the worlds, the first step not included
  std::map<std::string, double> phases;  ///< mean over the timed steps, by the engine's own names
  std::int64_t engine_contacts = -1;     ///< as the engine counts them
  std::int64_t awake = 0;                ///< dynamic bodies that do not sleep at the end
  std::int64_t touching = 0;             ///< pairs of shapes at the end, as the evaluator counts them
  double penetration_mean = 0.0;
  double penetration_p999 = 0.0;
  double penetration_max = 0.0;
  double kinetic_energy = 0.0;
  double top_drop = 0.0;
  std::int64_t bodies_left = 0;
  std::int64_t drift_joints = 0;  ///< whose anchors are held together: see Evaluator::add_joint_drift
  double drift_mean = 0.0;        ///< of those joints at the end
  double drift_max = 0.0;
  std::int64_t pooled_pairs = 0;  ///< with evaluate_every: over all evaluated steps, as are the five below
  double pooled_mean = 0.0;
  double pooled_p999 = 0.0;
  double pooled_max = 0.0;
  double pooled_drift_mean = 0.0;
  double pooled_drift_max = 0.0;
  int collapse_step = 0;  ///< with stand_steps: the step of the collapse, or 0 if it stands
  int steps_done = 0;
  std::uint64_t bits = 0;       ///< fingerprint of the final poses and velocities
  std::int64_t peak_bytes = 0;  ///< resident memory of the process before the evaluator begins
};

/// Measures in a new process. Reports every failure there, including crashes, as Measurement::error.
Measurement measure_in_child(const Request& request);

/// The child process: runs the request on the command line and prints the result.
int child_main(const std::string& request_json);

std::string to_json(const Measurement& measurement);  ///< an object

/// A stack has collapsed when a body that was on top has lost a tenth of its height.
inline constexpr double kCollapseHeight = 0.9;

}  // namespace scree::bench
