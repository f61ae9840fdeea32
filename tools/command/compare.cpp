// See compare.h.
#include <tools/command/compare.h>
#include <tools/command/options.h>
#include <tools/command/run.h>

#include <algorithm>

namespace scree::command {
namespace {

constexpr int kMostComparedSteps = 1'000'000;
constexpr int kUsualSteps = 600;
constexpr int kUsualMostCount = 1024;
constexpr int kUsualAt = 10;  // steps: bodies that were placed without pressure have found it

}  // namespace

comparison::CompareFigures compare_solvers(const CompareArguments& arguments) {
  check_backend(arguments.threads, arguments.isa);
  check_range("--iterations", arguments.iterations, 1, kMostIterations);
  if (arguments.steps) check_range("--steps", *arguments.steps, 1, kMostComparedSteps);
  comparison::CompareOptions options;
  for (const std::string& name : arguments.solvers) options.solvers.push_back(read_solver(name));
  for (int i = 0; arguments.solvers.empty() && i < kSolverCount; ++i)
    options.solvers.push_back(static_cast<Solver>(i));
  options.counts = arguments.counts;
  for (const int count : options.counts) check_range("--counts", count, 1, kMostIterations);
  for (int count = 1; arguments.counts.empty() && count <= kUsualMostCount; count *= 2)
    options.counts.push_back(count);
  std::sort(options.counts.begin(), options.counts.end());
  if (arguments.substeps) check_range("--substeps", *arguments.substeps, 1, kMostSubsteps);
  std::vector<scenes::Scene> worlds = find_scene(arguments.scene, arguments.parameters);
  options.steps = arguments.steps.value_or(std::min(worlds.front().steps, kUsualSteps));
  options.at = arguments.at.value_or(std::min(options.steps, kUsualAt));
  check_range("--at", options.at, 0, options.steps);
  options.iterations = arguments.iterations;
  options.dt = worlds.front().dt;
  if (arguments.substeps) worlds.front().settings.substeps = *arguments.substeps;
  options.threads = arguments.threads;
  options.isa = arguments.isa;
  return comparison::compare(worlds, options);
}

}  // namespace scree::command
