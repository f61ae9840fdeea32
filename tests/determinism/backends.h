// Backends: what a step can run on. Results must not depend on it.
#pragma once

#include <scree/scree.h>

#include <string>
#include <vector>

namespace scree::determinism {

struct Backend {
  Isa isa = Isa::scalar;
  int threads = 1;
};

// The reference of all comparisons.
inline constexpr Backend kReference{Isa::scalar, 1};

// One backend per step, in turn, repeating from the first. Most schedules hold one backend.
using Schedule = std::vector<Backend>;

std::string name_of(const Schedule& schedule);  // "avx2 x 3 threads"

std::vector<Isa> supported_isas();
// Prints to standard output which instruction sets this machine cannot run, once per program.
void report_unsupported_isas();

// The schedules to compare with the reference. In full: every instruction set with 1, 2, 3, 4 and 8 threads,
// and a schedule that changes both at every step. Otherwise the widest set with three threads and that
// schedule, which covers every set and every thread count at some step.
std::vector<Schedule> schedules(bool full);

// Builds with assertions are slow and compare less, unless the environment variable SCREE_DETERMINISM is
// "full" or "quick".
bool wants_full_matrix();

// The workers of a schedule, one per backend.
class Shift {
 public:
  explicit Shift(const Schedule& schedule);
  Workers& at(int step) { return workers_[static_cast<std::size_t>(step) % workers_.size()]; }

 private:
  std::vector<Workers> workers_;
};

}  // namespace scree::determinism
