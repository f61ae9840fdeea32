// The data that a calling thread and its helpers share. Private to workers.cpp and crew.cpp.
//
// A Workers owns one HelperPool, and the pool owns one CrewState for each step that runs at the same time.
// The calling thread publishes a stage by writing one segment of chunks for each thread; an idle thread
// claims chunks from any segment. All of it stays in memory until the last helper has released the pool, so
// that a helper that starts after its Workers are gone finds an empty pool, not freed memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>

namespace scree {

// Two cache lines: processors that prefetch lines in pairs would share neighbors otherwise.
inline constexpr std::size_t kSeparation = 128;

using StageFunction = void (*)(void* context, int chunk, int worker);

// The chunks [end - left, end) of the current stage, and the seat of the thread whose share they are. Seat 0
// is the calling thread's.
//
// `word` is stage << 32 | left, or 0 while no crew is at work. A chunk is claimed by counting `left` down
// with a compare-and-swap, and only then are the other members read: the stage cannot end before a claimed
// chunk is reported, so they are the claimed stage's, however long the thread slept before. A thread with a
// word of an earlier stage fails at the compare.
struct alignas(kSeparation) Segment {
  std::atomic<std::uint64_t> word{0};
  StageFunction function = nullptr;
  void* context = nullptr;
  int end = 0;
  std::atomic<bool> taken{false};  // by a helper

  static std::uint32_t stage(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32); }
  static std::uint32_t left(std::uint64_t word) { return static_cast<std::uint32_t>(word); }
};

class CrewState {
 public:
  explicit CrewState(int threads);

  // The calling thread's side.
  bool try_own();             // false if another step has it
  void set_width(int width);  // segments of the stages to come, at most `threads`
  void open();                // lets helpers in; after the first publish
  void close();               // sends helpers away and gives the state up
  void publish(int chunks, StageFunction function, void* context);
  // Runs what is left of the stage and waits for the chunks that helpers have begun.
  void finish(int chunks);

  // The helper's side: takes a seat if the crew is open and one is free, helps until the crew closes.
  bool has_free_seat() const;
  bool help();

  CrewState* next = nullptr;  // in the pool's list; never changes once there

 private:
  Segment& segment(int seat) { return segments_[static_cast<std::size_t>(seat)]; }
  const Segment& segment(int seat) const { return segments_[static_cast<std::size_t>(seat)]; }
  int drain(Segment& from, int worker);
  int drain_all(int worker, bool report);
  void serve(int seat);
  void report_failure(int chunk);

  alignas(kSeparation) std::atomic<bool> owned_{false};
  std::atomic<bool> open_{false};
  std::atomic<int> width_{1};
  std::unique_ptr<Segment[]> segments_;
  std::uint32_t stage_ = 0;     // last published; calling thread only
  std::uint32_t expected_ = 0;  // value of finished_ at the end of the stage; calling thread only

  alignas(kSeparation) std::atomic<std::uint32_t> finished_{0};  // chunks finished by helpers, ever

  alignas(kSeparation) std::mutex failure_mutex_;
  bool failed_ = false;
  int failed_chunk_ = 0;
  std::exception_ptr failure_;
};

// The crews of one Workers and the number of its helpers. Lives until its Workers and all tasks have let go.
class HelperPool {
 public:
  explicit HelperPool(int threads) : threads_(threads) {}
  HelperPool(const HelperPool&) = delete;
  HelperPool& operator=(const HelperPool&) = delete;
  void retain() { owners_.fetch_add(1, std::memory_order_relaxed); }
  void release();

  CrewState& acquire();
  // Counts one more helper unless there are `limit`.
  bool enlist(int limit);
  // Whether a task holds the pool: it may have resigned already.
  bool has_helpers() const { return owners_.load(std::memory_order_acquire) > 1; }
  void resign() { helpers_.fetch_sub(1, std::memory_order_seq_cst); }
  // A helper's life, from the task that carries it; releases the pool in the end.
  void run_helper();

 private:
  ~HelperPool();
  bool help_someone();
  bool someone_needs_help() const;

  const int threads_;
  std::atomic<CrewState*> first_{nullptr};
  std::atomic<int> owners_{1};
  alignas(kSeparation) std::atomic<int> helpers_{0};  // enqueued or at work
};

}  // namespace scree
