// The accuracy suite on a command line: its options, and a run of it. The benchmark of other engines declares
// the same.
#pragma once

#include <tools/accuracy/suite.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

struct AccuracyArguments {
  accuracy::SuiteOptions options;
  std::string isa = "auto";
  std::optional<std::string> solver;  // by name; default: that of WorldSettings
  std::string json;                   // empty: none; -: standard output
  bool list = false;
  bool quiet = false;  // no progress
};

// `with_engines` adds the option --engines.
void declare_accuracy(CLI::App& app, AccuracyArguments& arguments, bool with_engines);

// Runs and prints. Throws scree::Error for bad input.
void run_accuracy(AccuracyArguments& arguments, const std::vector<accuracy::EngineChoice>& engines,
                  const std::string& version);

}  // namespace scree::command
