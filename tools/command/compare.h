// The command `scree compare`: options, checked, to figures.
#pragma once

#include <tools/compare/compare.h>

#include <optional>
#include <string>
#include <vector>

namespace scree::command {

struct CompareArguments {
  std::string scene;
  scenes::Parameters parameters;
  std::vector<std::string> solvers;  // by name; empty: all
  std::vector<int> counts;           // empty: powers of two to 1024
  std::optional<int> steps;          // default: the scene's, at most 600
  std::optional<int> at;             // default: 10
  std::optional<int> substeps;       // of the runs; default: the scene's
  int iterations = 30;
  int threads = 1;
  Isa isa = Isa::automatic;
};

comparison::CompareFigures compare_solvers(const CompareArguments& arguments);

}  // namespace scree::command
