// `scree extract`: options -> plan -> extract -> file.
#pragma once

#include <tools/command/sampled.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::command {

// The output is .npz or .csv.
struct ExtractOptions : SampledOptions {
  std::vector<std::string> signals;
  std::string bodies = "all";  // or indices and spans of them: 3,7-12
};

struct ExtractFigures : SampledFigures {
  std::uint64_t joints = 0, events = 0;
};

// Throws scree::Error for bad options and for files that are no recordings.
ExtractFigures extract_signals(const ExtractOptions& options);

std::string to_table(const ExtractFigures& figures);
std::string to_json(const ExtractFigures& figures);

}  // namespace scree::command
