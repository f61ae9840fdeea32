// The plan of a measurement: the options of the command line, and the jobs that follow from them.
#pragma once

#include "bench/scenes/measure.h"
#include "bench/scenes/report.h"

#include <cstddef>
#include <string>
#include <vector>

namespace scree::bench {

struct EngineInfo;

struct Options {
  std::vector<std::string> scenes{"large_pyramid", "many_pyramids"};
  std::string sweep;  ///< "bodies=1000,10000": every scene once for each value of that parameter
  std::vector<std::string> engines;
  std::vector<std::string> isas{"auto"};
  std::vector<int> threads{1, 2};
  std::string continuous = "scene";  ///< "on", "off", or as each scene has it
  std::vector<std::string> stand;    ///< scenes to step until they collapse, instead of timing any
  int steps = 0;
  int max_steps = 3600;  // 60 s
  int warmup = 1;
  int repeats = 5;
  double patience = 0.0;  ///< s; longer runs are not repeated; 0: all runs are
  int evaluate_every = 0;
  std::string markdown_file;
  std::string brief_file;
  std::string json_file;
  bool list = false;
};

struct Job {
  Entry entry;
  Request request;
  std::size_t same_as =
      0;  ///< the job whose measurements this one shares: its own index, or an earlier one's
};

/// The engines used if the options name none.
std::vector<std::string> default_engines();
/// Throws scree::Error for an engine that this program does not have.
const EngineInfo& find_engine(const std::string& name);
/// All jobs, grouped by scene. Throws scree::Error for unknown scenes, parameters and engines.
std::vector<Job> plan(const Options& options);

}  // namespace scree::bench
