// A timeline of a run for the viewers of Perfetto (https://ui.perfetto.dev) and Chrome (about:tracing): zones
// of scree/zones.h by thread, and counters after each step. In the "Trace Event Format" of JSON.
#pragma once

#include <scree/scree.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace scree::command {

// What a trace has recorded.
struct TraceFigures {
  std::string file;  // to which `json` goes
  std::string json;
  std::uint64_t zones = 0;
  std::uint64_t left_out = 0;  // zones that came when the trace or the memory was full, or lay too deep
};

// The row of a table.
std::string trace_row(const TraceFigures& figures);

// Records from when it is made on. A trace that is full records nothing more.
class Trace {
 public:
  // `most`: zones. A million of them make a file of 120 MB.
  explicit Trace(std::size_t most = 1'000'000);
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;
  ~Trace();

  // For WorkersOptions; the trace must outlive these Workers.
  ZoneHooks hooks();
  // Counts what the last step has found, as sums over the worlds.
  void count(const std::vector<const StepStats*>& worlds);

  // After the last step, when no thread is in a zone.
  TraceFigures finish(const std::string& file);

 private:
  using Clock = std::chrono::steady_clock;
  struct Event {
    const char* name;
    ZoneKind kind;
    std::int64_t number;
    Clock::time_point begin, end;
  };
  // What one thread records.
  struct Lane {
    static constexpr int kDeepest = 16;  // zones in each other; worlds that share threads have six
    std::thread::id thread;
    std::array<Event, kDeepest> open;
    int depth = 0;  // may be more
    std::vector<Event> closed;
  };
  struct Counts {
    Clock::time_point time;
    std::int64_t contacts, awake_bodies, islands, colors;
    double lane_fill;
  };

  Lane& lane();
  bool is_full() const { return recorded_.load(std::memory_order_relaxed) >= most_; }
  void begin(const Zone& zone) noexcept;
  void end() noexcept;
  std::string to_json();

  const std::size_t most_;
  const Clock::time_point start_ = Clock::now();
  const std::uint64_t number_;  // of this trace: threads remember their lane by it
  std::atomic<std::uint64_t> recorded_{0}, left_out_{0};
  std::mutex mutex_;                          // of the list of lanes, not of what they hold
  std::vector<std::unique_ptr<Lane>> lanes_;  // the first one is that of the thread that made the trace
  std::vector<Counts> counts_;
};

// Workers for a run, and the trace that they report to if `file` is not empty.
Workers make_workers(int threads, Isa isa, const std::string& file, std::optional<Trace>& trace);

}  // namespace scree::command
