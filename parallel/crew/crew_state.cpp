// Claims, publishes and helps; see crew_state.h.
#include <core/world/fp_environment.h>
#include <parallel/crew/crew_state.h>

#include <chrono>
#include <thread>
#include <utility>

namespace scree {
namespace {

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");
#endif
}

// Waits a moment, longer each time: a stage boundary takes well under a microsecond where every thread has a
// core, and a thread that holds a core for longer keeps it from the one that it waits for.
class Patience {
 public:
  void wait() {
    if (++waits_ < kPauses) {
      pause();
    } else {
      std::this_thread::yield();
    }
  }
  void restart() { waits_ = 0; }

 private:
  static constexpr int kPauses = 256;  // 3 to 12 us, by processor
  int waits_ = 0;
};

// Between two steps of a loop, a helper that stays is there when the next one begins; waking one takes 5 to
// 50 us. It is also the longest that TBB goes without a thread that has nothing to do.
constexpr std::chrono::microseconds kLinger{100};

}  // namespace

CrewState::CrewState(int threads)
    : segments_(std::make_unique<Segment[]>(static_cast<std::size_t>(threads))) {}

bool CrewState::try_own() {
  return !owned_.load(std::memory_order_relaxed) && !owned_.exchange(true, std::memory_order_acquire);
}

void CrewState::set_width(int width) { width_.store(width, std::memory_order_relaxed); }

// Sequentially consistent, as are the accesses to the number of helpers: either this thread sees that a
// helper has resigned and sends for another, or that helper sees that the crew is open.
void CrewState::open() { open_.store(true, std::memory_order_seq_cst); }

void CrewState::close() {
  open_.store(false, std::memory_order_relaxed);
  const int width = width_.load(std::memory_order_relaxed);
  for (int i = 0; i < width; ++i) segment(i).word.store(0, std::memory_order_release);
  owned_.store(false, std::memory_order_release);
}

void CrewState::publish(int chunks, StageFunction function, void* context) {
  if (++stage_ == 0) stage_ = 1;
  const int width = width_.load(std::memory_order_relaxed);
  const int share = chunks / width;
  const int larger = chunks % width;  // the first segments take one more: low seats are filled first
  int begin = 0;
  for (int i = 0; i < width; ++i) {
    Segment& part = segment(i);
    const int size = share + (i < larger ? 1 : 0);
    part.function = function;
    part.context = context;
    part.end = begin + size;
    begin += size;
    part.word.store(std::uint64_t{stage_} << 32 | static_cast<std::uint32_t>(size),
                    std::memory_order_release);
  }
}

void CrewState::finish(int chunks) {
  expected_ += static_cast<std::uint32_t>(chunks - drain_all(0, false));
  Patience patience;
  while (finished_.load(std::memory_order_acquire) != expected_) patience.wait();
  if (failed_) {
    failed_ = false;
    std::rethrow_exception(std::exchange(failure_, nullptr));
  }
}

int CrewState::drain(Segment& from, int worker) {
  int done = 0;
  std::uint64_t word = from.word.load(std::memory_order_relaxed);
  while (Segment::left(word) != 0) {
    // Acquire: what publish() wrote before, here and everywhere.
    if (!from.word.compare_exchange_weak(word, word - 1, std::memory_order_acquire,
                                         std::memory_order_relaxed)) {
      continue;
    }
    const int chunk = from.end - static_cast<int>(Segment::left(word));
    try {
      from.function(from.context, chunk, worker);
    } catch (...) {
      report_failure(chunk);
    }
    ++done;
    --word;  // unless another thread has claimed since
  }
  return done;
}

// Works on the worker's own segment first, then on the others'. A helper reports after each segment, so that
// the calling thread waits for one chunk at most.
int CrewState::drain_all(int worker, bool report) {
  int total = 0;
  const int width = width_.load(std::memory_order_relaxed);
  for (int i = 0; i < width; ++i) {
    const int victim = worker + i < width ? worker + i : worker + i - width;
    const int done = drain(segment(victim), worker);
    if (report && done != 0) {
      finished_.fetch_add(static_cast<std::uint32_t>(done), std::memory_order_release);
    }
    total += done;
  }
  return total;
}

// Of several failures the lowest chunk's counts, which is what one thread alone would have met.
void CrewState::report_failure(int chunk) {
  const std::lock_guard lock(failure_mutex_);
  if (failed_ && failed_chunk_ < chunk) return;
  failed_ = true;
  failed_chunk_ = chunk;
  failure_ = std::current_exception();
}

bool CrewState::has_free_seat() const {
  if (!open_.load(std::memory_order_seq_cst)) return false;
  const int width = width_.load(std::memory_order_relaxed);
  for (int seat = 1; seat < width; ++seat) {
    if (!segment(seat).taken.load(std::memory_order_relaxed)) return true;
  }
  return false;
}

bool CrewState::help() {
  if (!open_.load(std::memory_order_acquire)) return false;
  const int width = width_.load(std::memory_order_relaxed);
  for (int seat = 1; seat < width; ++seat) {
    std::atomic<bool>& taken = segment(seat).taken;
    // Acquire and release hand the worker number's scratch memory on.
    if (taken.load(std::memory_order_relaxed) || taken.exchange(true, std::memory_order_acquire)) continue;
    serve(seat);
    taken.store(false, std::memory_order_release);
    return true;
  }
  return false;
}

void CrewState::serve(int seat) {
  const Segment& own = segment(seat);
  std::uint32_t seen = 0;
  Patience patience;
  for (;;) {
    const std::uint64_t word = own.word.load(std::memory_order_acquire);
    if (word == 0) return;
    if (Segment::stage(word) == seen) {
      patience.wait();
      continue;
    }
    seen = Segment::stage(word);
    drain_all(seat, true);
    patience.restart();
  }
}

void HelperPool::release() {
  if (owners_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete this;
}

HelperPool::~HelperPool() {
  for (CrewState* state = first_.load(std::memory_order_relaxed); state != nullptr;) {
    delete std::exchange(state, state->next);
  }
}

CrewState& HelperPool::acquire() {
  for (CrewState* state = first_.load(std::memory_order_acquire); state != nullptr; state = state->next) {
    if (state->try_own()) return *state;
  }
  CrewState* state = new CrewState(threads_);
  state->try_own();
  state->next = first_.load(std::memory_order_relaxed);
  while (!first_.compare_exchange_weak(state->next, state, std::memory_order_release,
                                       std::memory_order_relaxed)) {
  }
  return *state;
}

bool HelperPool::enlist(int limit) {
  int helpers = helpers_.load(std::memory_order_seq_cst);
  while (helpers < limit) {
    if (helpers_.compare_exchange_weak(helpers, helpers + 1, std::memory_order_seq_cst)) return true;
  }
  return false;
}

bool HelperPool::help_someone() {
  for (CrewState* state = first_.load(std::memory_order_acquire); state != nullptr; state = state->next) {
    if (state->help()) return true;
  }
  return false;
}

bool HelperPool::someone_needs_help() const {
  for (CrewState* state = first_.load(std::memory_order_acquire); state != nullptr; state = state->next) {
    if (state->has_free_seat()) return true;
  }
  return false;
}

void HelperPool::run_helper() {
  using Clock = std::chrono::steady_clock;
  const FpEnvironment environment;
  Patience patience;
  Clock::time_point idle_since = Clock::now();
  for (;;) {
    if (help_someone()) {
      patience.restart();
      idle_since = Clock::now();
    } else if (Clock::now() - idle_since < kLinger) {
      patience.wait();
    } else {
      resign();
      if (!someone_needs_help() || !enlist(threads_ - 1)) break;
      idle_since = Clock::now();
    }
  }
  release();
}

}  // namespace scree
