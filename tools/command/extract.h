// `scree extract`: options -> plan -> extract -> file.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

struct ExtractOptions {
  std::string file;  // a recording
  std::vector<std::string> signals;
  std::string bodies = "all";  // or indices and spans of them: 3,7-12
  std::optional<std::uint64_t> from, to;
  std::uint64_t every = 1;
  std::string output;  // .npz or .csv
  int threads = 0;     // 0: one per core
  Isa isa = Isa::automatic;
  bool quiet = false;  // no progress
};

struct ExtractFigures {
  std::string file, output;
  std::string bytes;  // of the output
  std::uint64_t from = 0, to = 0;
  std::uint64_t samples = 0, bodies = 0, joints = 0, events = 0;
  double seconds = 0.0;
  Isa isa = Isa::scalar;
  int threads = 1;
};

// Throws scree::Error for bad options and for files that are no recordings.
ExtractFigures extract_signals(const ExtractOptions& options);

std::string to_table(const ExtractFigures& figures);
std::string to_json(const ExtractFigures& figures);

}  // namespace scree::command
