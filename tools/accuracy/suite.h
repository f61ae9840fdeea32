// The suite: options -> runs -> figures, the same for the command and for the benchmark of other engines.
#pragma once

#include <tools/accuracy/cases.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace scree::accuracy {

struct SuiteOptions {
  std::vector<std::string> cases;                                  ///< empty: all
  std::vector<std::string> engines;                                ///< empty: all that there are
  std::vector<double> time_steps{1.0 / 60.0, 0.01, 0.004, 0.001};  ///< s, each above 0 and at most 0.1
  std::vector<int> substeps{4};                                    ///< each in [1, 64]
  Backend backend;
};

/// One case with one engine and one step.
struct Entry {
  const Case* of = nullptr;
  const EngineChoice* engine = nullptr;
  double dt = 0.0;
  int substeps = 0;                ///< 0: the engine has none
  std::vector<double> errors{};    ///< by measure; empty where the engine cannot run the case
  std::string refusal{};           ///< why not
  double ms_per_second = 0.0;      ///< real time of the steps over simulated time
  double step_seconds = 0.0;       ///< real time of all steps; of a short run the least of three
  double simulated_seconds = 0.0;  ///< of all trials
};

/// Throws scree::Error for unknown names, with the list of the known ones, and for numbers out of range.
void check(const SuiteOptions& options, std::span<const EngineChoice> engines);

/// Runs case by case, engine by engine, time step by time step; an engine without substeps runs each time
/// step once. Checks the options first. `show` is called before each run.
std::vector<Entry> run_suite(const SuiteOptions& options, std::span<const EngineChoice> engines,
                             const std::function<void(const std::string&)>& show);

/// Tables for people, one for each case: a row per engine and step, its errors, and what they took. Above
/// them Scree's solver, if `backend` chooses one or its iterations.
std::string to_table(std::span<const Entry> entries, const Backend& backend);
/// For machines and for tools/accuracy/plot. `backend` is the one that ran, `version` that of Scree.
std::string to_json(std::span<const Entry> entries, const Backend& backend, const std::string& version);

/// One line per case: its name and what happens.
std::string list_of_cases();

}  // namespace scree::accuracy
