// What `scree extract` and `scree export` have in common: samples of a recording that go into a file.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace scree::command {

struct SampledOptions {
  std::string file;    // a recording
  std::string output;  // whose name says the format
  std::uint64_t every = 1;
  std::optional<std::uint64_t> from, to;
  int threads = 0;  // 0: one per core
  Isa isa = Isa::automatic;
  bool quiet = false;  // no progress
};

struct SampledFigures {
  std::string file, output;
  std::string bytes;  // of the output
  std::uint64_t from = 0, to = 0;
  std::uint64_t samples = 0, bodies = 0;
  double seconds = 0.0;  // that it took
  Isa isa = Isa::scalar;
  int threads = 1;
};

// The rows of a table and the members of an object that both have, before and behind their own.
std::string table_head(const SampledFigures& figures);
std::string table_tail(const SampledFigures& figures);
nlohmann::ordered_json json_head(const SampledFigures& figures);
std::string finish_json(nlohmann::ordered_json json, const SampledFigures& figures);

}  // namespace scree::command
