// What reading calls make when it is first asked for, and keep: lists that worlds which are only stepped do
// not pay for. Reading calls run at the same time from many threads: one makes it, the others wait.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>

namespace scree {

class MadeOnce {
 public:
  MadeOnce() = default;
  MadeOnce(MadeOnce&&) noexcept {}  // of data that move: to be made anew

  // Calls make(), unless that has been done since forget(). What make() throws leaves it to be done.
  template <class Make>
  void ensure(Make&& make) {
    if (is_made_.load(std::memory_order_acquire)) return;
    const std::lock_guard lock(mutex_);
    if (is_made_.load(std::memory_order_relaxed)) return;
    make();
    ++times_made_;
    is_made_.store(true, std::memory_order_release);
  }
  // How often it has been made, for tests of what reading costs.
  std::int64_t times_made() const {
    const std::lock_guard lock(mutex_);
    return times_made_;
  }
  // While it is held nothing is being made.
  [[nodiscard]] std::unique_lock<std::mutex> hold() const { return std::unique_lock(mutex_); }
  // By calls that write and by steps, which run alone.
  void forget() noexcept { is_made_.store(false, std::memory_order_relaxed); }

 private:
  mutable std::mutex mutex_;
  std::atomic<bool> is_made_ = false;
  std::int64_t times_made_ = 0;
};

// Counts what several threads do at the same time.
class SharedCount {
 public:
  SharedCount() = default;
  SharedCount(SharedCount&& other) noexcept : value_(other) {}
  void operator+=(std::int64_t more) noexcept { value_.fetch_add(more, std::memory_order_relaxed); }
  operator std::int64_t() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> value_ = 0;
};

// Held by callers that exclude one another. A store that is moved gets a new mutex.
struct OwnMutex : std::mutex {
  OwnMutex() = default;
  OwnMutex(OwnMutex&&) noexcept {}
};

}  // namespace scree
