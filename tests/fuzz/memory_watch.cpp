// See memory_watch.h.
#include <tests/fuzz/memory_watch.h>

#if defined(SCREE_SANITIZED) && __has_include(<sanitizer/allocator_interface.h>)
#include <sanitizer/allocator_interface.h>
#define SCREE_WATCHES_MEMORY 1
#endif

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace scree::fuzz {

namespace {

std::atomic<std::int64_t> in_use{0};
std::atomic<std::int64_t> most{0};
double largest_share = 0.0;  // of a bound; of the thread that runs targets

#ifdef SCREE_WATCHES_MEMORY
void note_allocation(const volatile void*, std::size_t bytes) {
  const std::int64_t now = in_use.fetch_add(static_cast<std::int64_t>(bytes), std::memory_order_relaxed) +
                           static_cast<std::int64_t>(bytes);
  std::int64_t before = most.load(std::memory_order_relaxed);
  while (before < now && !most.compare_exchange_weak(before, now, std::memory_order_relaxed)) {
  }
}

void note_free(const volatile void* memory) {
  if (memory == nullptr) return;
  const std::size_t bytes = __sanitizer_get_allocated_size(memory);
  in_use.fetch_sub(static_cast<std::int64_t>(bytes), std::memory_order_relaxed);
}

const bool kWatched = __sanitizer_install_malloc_and_free_hooks(note_allocation, note_free) != 0;
#else
constexpr bool kWatched = false;
#endif

}  // namespace

void tell_memory_at_exit() {
  std::atexit([] { std::fprintf(stderr, "stat::memory_of_bound: %.0f%%\n", 100.0 * largest_share); });
}

bool memory_is_watched() { return kWatched; }

MemoryWatch::MemoryWatch() : begin_(in_use.load(std::memory_order_relaxed)) {
  most.store(begin_, std::memory_order_relaxed);
}

std::size_t MemoryWatch::peak() const {
  return static_cast<std::size_t>(most.load(std::memory_order_relaxed) - begin_);
}

void MemoryWatch::require_within(const MemoryBound& bound, std::size_t input_bytes, const char* who) const {
  const std::size_t taken = peak(), allowed = bound.of(input_bytes);
  largest_share = std::max(largest_share, static_cast<double>(taken) / static_cast<double>(allowed));
  if (taken <= allowed) return;
  throw BrokenLaw(std::string(who) + " takes " + std::to_string(taken) + " bytes for " +
                  std::to_string(input_bytes) + ", more than " + std::to_string(allowed));
}

}  // namespace scree::fuzz
