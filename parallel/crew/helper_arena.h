// Helper arena: where helpers come from. The one part of the library that calls oneTBB.
//
// Its source is not instrumented by ThreadSanitizer: TBB's library is not either, so that every task that it
// hands from one thread to another would look like a race. What the tasks themselves do is instrumented.
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
  ~HelperArena();  // waits for nobody: tasks that have not begun run later
  HelperArena(const HelperArena&) = delete;
  HelperArena& operator=(const HelperArena&) = delete;

  // Runs task(context) on some TBB thread at some time.
  void enqueue(Task task, void* context);

  // Threads that TBB lends the process, the calling thread included: one per core, unless somebody holds a
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
