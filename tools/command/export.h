// `scree export`: a recording -> a show -> a file for viewers of others.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <optional>
#include <string>

namespace scree::command {

struct ExportOptions {
  std::string file;    // a recording
  std::string output;  // .gltf, .glb or .mcap
  std::uint64_t every = 1;
  std::optional<std::uint64_t> from, to;
  int threads = 0;  // 0: one per core
  Isa isa = Isa::automatic;
  bool quiet = false;  // no progress
};

struct ExportFigures {
  std::string file, output;
  std::string bytes;  // of the output
  std::uint64_t from = 0, to = 0;
  std::uint64_t samples = 0, bodies = 0;
  double seconds = 0.0;  // of time that the show lasts
  double seconds_taken = 0.0;
  Isa isa = Isa::scalar;
  int threads = 1;
};

// Throws scree::Error for bad options and for files that are no recordings.
ExportFigures export_show(const ExportOptions& options);

std::string to_table(const ExportFigures& figures);
std::string to_json(const ExportFigures& figures);

}  // namespace scree::command
