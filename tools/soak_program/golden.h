// The long golden matrix: scenes at their full sizes on every instruction set with several thread counts.
// Compares the backends with each other at every step, and the results with recorded hashes.
#pragma once

#include <tools/scenes/golden_file.h>
#include <tools/soak_program/backends.h>
#include <tools/soak_program/round.h>

#include <cstdint>
#include <optional>
#include <string>

namespace scree::soak {

class GoldenMatrix {
 public:
  /// A run that differs is recorded into the folder.
  GoldenMatrix(std::string file, std::string folder);

  /// Plays the whole matrix and prints a line a run. Stops at the first difference.
  std::optional<Failure> check();
  /// Plays every run once and rewrites the file; prints the runs that changed.
  void update();
  std::int64_t hashes_compared() const { return hashes_; }

 private:
  Failure failure(const scenes::Golden& golden, Backend backend, std::size_t step);

  std::string file_;
  std::string folder_;
  std::int64_t hashes_ = 0;
};

}  // namespace scree::soak
