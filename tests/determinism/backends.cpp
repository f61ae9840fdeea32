// See backends.h.
#include <tests/determinism/backends.h>

#include <cstdio>
#include <cstdlib>

namespace scree::determinism {
namespace {

constexpr Isa kIsas[] = {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512};
constexpr int kThreadCounts[] = {1, 2, 3, 4, 8};

std::string name_of(Backend backend) {
  return std::string(isa_name(backend.isa)) + " x " + std::to_string(backend.threads) +
         (backend.threads == 1 ? " thread" : " threads");
}

Schedule ever_changing() {
  Schedule schedule;
  // The inner loop goes over the sets, so that consecutive steps use different sets.
  for (const int threads : kThreadCounts) {
    for (const Isa isa : supported_isas()) schedule.push_back({isa, threads});
  }
  return schedule;
}

}  // namespace

std::string name_of(const Schedule& schedule) {
  if (schedule.size() == 1) return name_of(schedule.front());
  return "another of " + std::to_string(schedule.size()) + " backends at each step";
}

std::vector<Isa> supported_isas() {
  std::vector<Isa> isas;
  for (const Isa isa : kIsas) {
    if (is_supported(isa)) isas.push_back(isa);
  }
  return isas;
}

void report_unsupported_isas() {
  static const bool kReported = [] {
    for (const Isa isa : kIsas) {
      if (!is_supported(isa)) {
        std::printf("[  SKIPPED ] instruction set %s: not supported here, NOT compared\n", isa_name(isa));
      }
    }
    return true;
  }();
  static_cast<void>(kReported);
}

std::vector<Schedule> schedules(bool full) {
  std::vector<Schedule> all;
  if (full) {
    for (const Isa isa : supported_isas()) {
      for (const int threads : kThreadCounts) {
        if (isa != kReference.isa || threads != kReference.threads) all.push_back({{isa, threads}});
      }
    }
  } else {
    all.push_back({{supported_isas().back(), 3}});
  }
  all.push_back(ever_changing());
  return all;
}

bool wants_full_matrix() {
  if (const char* wish = std::getenv("SCREE_DETERMINISM")) {
    const std::string value = wish;
    if (value == "full" || value == "quick") return value == "full";
    throw Error("SCREE_DETERMINISM is '" + value + "'; it must be full or quick");
  }
#ifdef NDEBUG
  return true;
#else
  return false;
#endif
}

Shift::Shift(const Schedule& schedule) {
  for (const Backend backend : schedule) {
    workers_.emplace_back(WorkersOptions{.threads = backend.threads, .isa = backend.isa});
  }
}

}  // namespace scree::determinism
