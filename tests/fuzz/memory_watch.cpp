// See memory_watch.h.
#include <tests/fuzz/memory_watch.h>

#if defined(SCREE_SANITIZED) && __has_include(<sanitizer/allocator_interface.h>)
#include <sanitizer/allocator_interface.h>
#define SCREE_WATCHES_MEMORY 1
#endif

#include <atomic>

namespace scree::fuzz {

namespace {

std::atomic<std::int64_t> in_use{0};
std::atomic<std::int64_t> most{0};

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

bool memory_is_watched() { return kWatched; }

MemoryWatch::MemoryWatch() : begin_(in_use.load(std::memory_order_relaxed)) {
  most.store(begin_, std::memory_order_relaxed);
}

std::size_t MemoryWatch::peak() const {
  return static_cast<std::size_t>(most.load(std::memory_order_relaxed) - begin_);
}

void MemoryWatch::require_within(const MemoryBound& bound, std::size_t input_bytes, const char* who) const {
  const std::size_t taken = peak(), allowed = bound.of(input_bytes);
  if (taken <= allowed) return;
  throw BrokenLaw(std::string(who) + " takes " + std::to_string(taken) + " bytes for " +
                  std::to_string(input_bytes) + ", more than " + std::to_string(allowed));
}

}  // namespace scree::fuzz
