// Helper arena: starts helpers. The only part of the library that calls oneTBB.
//
// ThreadSanitizer does not instrument its source. It does not instrument TBB's library either, so that every
// task that TBB hands to another thread would look like a race. The tasks themselves are instrumented.
#pragma once

#include <memory>
#include <mutex>

namespace scree {

class HelperArena {
 public:
  using Task = void (*)(void* context);

  // For so many helpers at most. TBB is asked for as many of them as it lends at the time: it prints a
  // warning where it is asked for more.
  explicit HelperArena(int helpers);
  ~HelperArena();  // does not wait: tasks that have not begun run later
  HelperArena(const HelperArena&) = delete;
  HelperArena& operator=(const HelperArena&) = delete;

  // Runs task(context) on some TBB thread at some time.
  void enqueue(Task task, void* context);

  // Threads that TBB lends the process, the calling thread included: one per core, unless the host holds a
  // tbb::global_control.
  static int allowed_threads();

 private:
  struct Inside;
  std::shared_ptr<Inside> inside();

  const int helpers_;
  std::mutex mutex_;
  std::shared_ptr<Inside> inside_;  // replaced by a larger one when TBB lends more; guarded
};

}  // namespace scree
