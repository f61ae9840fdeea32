// Checks of command-line values; they throw scree::Error, which names the option.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace scree::command {

inline constexpr int kMostSubsteps = 64;           // WorldSettings' limit
inline constexpr int kMostIterations = 1'000'000;  // SolverOptions' limit

// "key=value" each; otherwise CLI11 would take them as its own positional arguments.
scenes::Parameters read_parameters(const std::vector<std::string>& settings);
Isa read_isa(const std::string& name);
Solver read_solver(const std::string& name);

void check_range(const char* option, int value, int low, int high);
// Threads within their limits, and an instruction set that runs here.
void check_backend(int threads, Isa isa);
// Prints a note on standard error if not all of the threads can work at the same time.
void tell_of_idle_threads(int threads);

}  // namespace scree::command
