// Backends: what a step may run on, and none of which may show in the results.
#pragma once

#include <scree/scree.h>

#include <string>
#include <vector>

namespace scree::determinism {

struct Backend {
  Isa isa = Isa::scalar;
  int threads = 1;
};

// What all others are compared with.
inline constexpr Backend kReference{Isa::scalar, 1};

// One backend per step, taken in turn and again from the first. Most schedules hold a single one.
using Schedule = std::vector<Backend>;

std::string name_of(const Schedule& schedule);  // "avx2 x 3 threads"

std::vector<Isa> supported_isas();
// Prints to standard output which instruction sets this machine cannot check, once per program.
void report_unsupported_isas();

// What to compare with the reference. In full: every instruction set with 1, 2, 3, 4 and 8 threads, and a
// schedule that changes both at every step. Otherwise the widest set with three threads and that schedule,
// which covers every set and every thread count at some step.
std::vector<Schedule> schedules(bool full);

// Builds with assertions are slow and compare less, unless the environment variable SCREE_DETERMINISM says
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
