// See options.h.
#include <tools/command/options.h>

#include <cmath>
#include <iostream>
#include <stdexcept>

namespace scree::command {
namespace {

constexpr int kMostThreads = 1024;  // WorkersOptions' limit

}  // namespace

scenes::Parameters read_parameters(const std::vector<std::string>& settings) {
  scenes::Parameters parameters;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error("--set " + setting + ": expected key=value");
    }
    const std::string key = setting.substr(0, equals);
    const std::string text = setting.substr(equals + 1);
    std::size_t used = 0;
    double value = 0.0;
    try {
      value = std::stod(text, &used);
    } catch (const std::logic_error&) {
      used = 0;
    }
    if (used == 0 || used != text.size() || !std::isfinite(value)) {
      throw Error("--set " + setting + ": \"" + text + "\" is not a finite number");
    }
    if (!parameters.emplace(key, value).second) throw Error("--set " + key + " is given twice");
  }
  return parameters;
}

Isa read_isa(const std::string& name) {
  std::string names;
  for (int i = 0; i <= static_cast<int>(Isa::avx512); ++i) {
    const auto isa = static_cast<Isa>(i);
    if (name == isa_name(isa)) return isa;
    names += (names.empty() ? "" : ", ") + std::string(isa_name(isa));
  }
  throw Error("--isa " + name + ": unknown instruction set; there are: " + names);
}

Solver read_solver(const std::string& name) {
  std::string names;
  for (int i = 0; i < kSolverCount; ++i) {
    const auto solver = static_cast<Solver>(i);
    if (name == solver_name(solver)) return solver;
    names += (names.empty() ? "" : ", ") + std::string(solver_name(solver));
  }
  throw Error("--solver " + name + ": unknown solver; there are: " + names);
}

void check_range(const char* option, int value, int low, int high) {
  if (value < low || value > high) {
    throw Error(std::string(option) + " " + std::to_string(value) + " must be from " + std::to_string(low) +
                " to " + std::to_string(high));
  }
}

void check_backend(int threads, Isa isa) {
  check_range("--threads", threads, 0, kMostThreads);
  if (!is_supported(isa)) {
    throw Error(std::string("--isa ") + isa_name(isa) +
                ": this processor or this build has no such instruction set");
  }
}

void tell_of_idle_threads(int threads) {
  const int cores = Workers().threads();
  if (threads <= cores) return;
  std::cerr << "scree: --threads " << threads << ": " << cores
            << (cores == 1 ? " thread works" : " threads work") << " at a time, one for each core\n";
}

}  // namespace scree::command
