// The tables: time, ratio and quality of all engines side by side.
#pragma once

#include "bench/scenes/measure.h"
#include "bench/scenes/step_times.h"

#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace scree::bench {

/// All measurements of one engine on one scene with one number of threads.
struct Entry {
  std::string scene;                         ///< with its parameters, as requested
  std::string name;                          ///< of the scene alone
  std::map<std::string, double> parameters;  ///< as requested
  std::string engine;                        ///< name, and the instruction set if several are compared
  std::string title;                         ///< with version, and the instruction set that was used
  int threads = 1;                           ///< as requested; a single-threaded engine always uses one
  int threads_used = 1;
  std::vector<Measurement> repeats;
  std::optional<Measurement> quality;  ///< of the run that was evaluated every few steps
};

/// The repeat with the median time per step; nothing if none succeeded.
const Measurement* median_repeat(const Entry& entry);
/// Over the repeats that succeeded.
StepTimes step_times(const Entry& entry);

/// Cells of a table, the head first.
using Table = std::vector<std::vector<std::string>>;

/// A row per entry: time per step (median of the repeats, their range), times of single steps, ratio to the
/// entry of the same scene and thread count whose engine is `baseline`, scaling against one thread, cost per
/// touching pair, quality.
Table comparison(const std::vector<Entry>& entries, const std::string& baseline);
/// The same in fewer columns, and only engines that could run the scene.
Table brief(const std::vector<Entry>& entries, const std::string& baseline);
/// A row per entry of a run with Request::stand_steps.
Table standing(const std::vector<Entry>& entries);
/// A line per entry with errors, complaints, or bits that differ between repeats.
std::vector<std::string> remarks(const std::vector<Entry>& entries);

void print_aligned(const Table& table, std::ostream& out);
void print_markdown(const Table& table, std::ostream& out);

}  // namespace scree::bench
