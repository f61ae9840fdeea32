// Helper arena on oneTBB: see helper_arena.h.
#include <parallel/crew/helper_arena.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>

namespace scree {

struct HelperArena::Inside {
  // No slot is kept for the calling thread, which never enters: that can block while the slots are taken.
  // Helpers run nothing but chunks, and chunks spawn nothing, so that no foreign task ever runs inside a step
  // and none needs to be isolated from.
  explicit Inside(int helpers) : slots(helpers), arena(helpers, /*reserved_for_masters=*/0) {}
  const int slots;
  tbb::task_arena arena;
};

HelperArena::HelperArena(int helpers) : helpers_(helpers) { inside(); }
HelperArena::~HelperArena() = default;

std::shared_ptr<HelperArena::Inside> HelperArena::inside() {
  const int lent = std::clamp(allowed_threads() - 1, 1, helpers_);
  const std::lock_guard lock(mutex_);
  // Helpers of the smaller one that have not begun run later.
  if (inside_ == nullptr || inside_->slots < lent) inside_ = std::make_shared<Inside>(lent);
  return inside_;
}

void HelperArena::enqueue(Task task, void* context) {
  inside()->arena.enqueue([task, context] { task(context); });
}

int HelperArena::allowed_threads() {
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(std::min<std::size_t>(allowed, std::numeric_limits<int>::max()));
}

}  // namespace scree
