// A step in the steady state allocates nothing: the crew's part of that law.
//
// Counts every malloc of the program, including those of TBB. Sanitizers replace malloc; under them only
// operator new is counted. Clang's ThreadSanitizer lets no program replace that one, so that nothing is
// counted.
#include <gtest/gtest.h>
#include <parallel/crew/crew.h>
#include <parallel/crew/workers_impl.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <thread>

#include <tests/parallel/allocations.h>

#ifdef __has_feature
#if __has_feature(thread_sanitizer)
#define SCREE_KEEPS_OPERATOR_NEW
#endif
#endif

namespace {

std::atomic<long> allocations{0};
std::atomic<bool> others_fail{false};
thread_local bool is_spared = false, fails_here = false;

// Counts an allocation. Returns whether it may succeed.
[[maybe_unused]] bool may_allocate() {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return !fails_here && (is_spared || !others_fail.load(std::memory_order_relaxed));
}

}  // namespace

namespace scree {

long allocations_so_far() { return allocations.load(std::memory_order_relaxed); }

FailingAllocations::FailingAllocations(Of of) {
  fails_here = of == Of::this_thread;
  is_spared = of == Of::others;
  others_fail = is_spared;
}
FailingAllocations::~FailingAllocations() { others_fail = is_spared = fails_here = false; }

}  // namespace scree

#if defined(__GLIBC__) && !defined(SCREE_SANITIZED)
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);
// Visible, so that shared libraries find them.
extern "C" __attribute__((visibility("default"))) void* malloc(std::size_t size) noexcept {
  return may_allocate() ? __libc_malloc(size) : nullptr;
}
extern "C" __attribute__((visibility("default"))) void* aligned_alloc(std::size_t alignment,
                                                                      std::size_t size) noexcept {
  return may_allocate() ? __libc_memalign(alignment, size) : nullptr;
}
#elif !defined(SCREE_KEEPS_OPERATOR_NEW)
__attribute__((noinline)) void* operator new(std::size_t size) {
  if (void* memory = may_allocate() ? std::malloc(size != 0 ? size : 1) : nullptr) return memory;
  throw std::bad_alloc();
}
// As std::stable_sort asks for memory.
__attribute__((noinline)) void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return may_allocate() ? std::malloc(size != 0 ? size : 1) : nullptr;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace scree {
namespace {

void step(Workers& workers) {
  Crew crew(workers);
  std::atomic<int> sum{0};
  for (int stage = 0; stage < 50; ++stage) {
    crew.run(32, [&](int chunk, int) { sum.fetch_add(chunk, std::memory_order_relaxed); });
    crew.run(1, [&](int, int) { sum.fetch_add(1, std::memory_order_relaxed); });
  }
}

TEST(CrewMemory, TheAllocationCounterCounts) {
  const long before = allocations_so_far();
  delete new Workers(1);
  EXPECT_GT(allocations_so_far(), before);
}

TEST(CrewMemory, StepsInTheSteadyStateAllocateNothing) {
  for (const int threads : {1, 2, 4}) {
    tbb::global_control enough(tbb::global_control::max_allowed_parallelism, 4);
    Workers workers(threads);
    for (int i = 0; i < 500; ++i) step(workers);
    const long before = allocations_so_far();
    for (int i = 0; i < 500; ++i) step(workers);
    EXPECT_EQ(allocations_so_far() - before, 0) << threads << " threads, one step after the other";
  }
}

TEST(CrewMemory, StepsFarApartAllocateNothing) {
  // Pauses long enough for the helpers to leave: each step must call them again.
  Workers workers(2);
  const auto pause_and_step = [&] {
    std::this_thread::sleep_for(std::chrono::microseconds(400));
    step(workers);
  };
  for (int i = 0; i < 500; ++i) pause_and_step();
  const long before = allocations_so_far();
  for (int i = 0; i < 500; ++i) pause_and_step();
  EXPECT_EQ(allocations_so_far() - before, 0);
}

// Keeps a thread of TBB busy. A thread that comes late returns at once.
struct BusyThreads {
  std::atomic<int> count{0};
  std::atomic<bool> over{false};
  static void stay(void* context) {
    BusyThreads& threads = *static_cast<BusyThreads*>(context);
    threads.count.fetch_add(1);
    while (!threads.over.load()) std::this_thread::yield();
    threads.count.fetch_sub(1);
  }
};

// All threads of TBB are busy elsewhere, so that no helper comes before the end.
TEST(CrewMemory, CreatingAndDestroyingWorkersKeepsOneSetOfHelpers) {
  constexpr int kThreads = 4;
  tbb::global_control enough(tbb::global_control::max_allowed_parallelism, kThreads);
  const int before = helper_sets();
  static BusyThreads busy;
  busy.over.store(false);
  HelperArena elsewhere(kThreads - 1);
  for (int i = 0; i < kThreads - 1; ++i) elsewhere.enqueue(&BusyThreads::stay, &busy);
  for (int i = 0; i < 1000 && busy.count.load() < kThreads - 1; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (int i = 0; i < 2000; ++i) {
    Workers workers(kThreads);
    step(workers);
  }
  EXPECT_LE(helper_sets(), before + 1);
  {
    Workers one(kThreads), another(kThreads);
    step(one);
    step(another);
  }
  EXPECT_LE(helper_sets(), before + 2) << "as many as live at a time";
  busy.over.store(true);
  while (busy.count.load() > 0) std::this_thread::yield();
}

// Helpers that have returned take no memory.
TEST(CrewMemory, NoMemoryRemainsOnceTheHelpersHaveReturned) {
  for (int i = 0; i < 100; ++i) {
    Workers workers(3);
    step(workers);
  }
  for (int i = 0; i < 5000; ++i) {
    { Workers alone(1); }  // collects the helpers that remain
    if (helper_sets() == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(helper_sets(), 0);
}

}  // namespace
}  // namespace scree
