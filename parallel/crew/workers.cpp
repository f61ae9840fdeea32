// Workers: how many threads, which instruction set, and where helpers come from.
#include <parallel/crew/kernel_code.h>
#include <parallel/crew/workers_impl.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#if defined(__linux__)
#include <sched.h>
#endif

namespace scree {
namespace {

constexpr int kMaxThreads = 1024;  // beyond any machine; each takes memory in every stage

constexpr Isa kAllIsas[] = {Isa::automatic, Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512};
constexpr char kIsaVariable[] = "SCREE_ISA";

// Cores that this process may run on.
int core_count() {
#if defined(__linux__)
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) == 0) return std::max(1, CPU_COUNT(&cores));
#endif
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int checked_threads(int threads) {
  if (threads < 0 || threads > kMaxThreads) {
    throw Error("WorkersOptions::threads is " + std::to_string(threads) + "; it must lie between 0 and " +
                std::to_string(kMaxThreads));
  }
  return threads != 0 ? threads : std::min(core_count(), kMaxThreads);
}

bool is_known(Isa isa) { return static_cast<int>(isa) <= static_cast<int>(Isa::avx512); }

const simd::Kernels* kernels_of(Isa isa) {
  return simd::find_kernels(static_cast<simd::InstructionSet>(static_cast<int>(isa) - 1));
}

Isa isa_of(const simd::Kernels& kernels) {
  return static_cast<Isa>(static_cast<int>(kernels.instruction_set) + 1);
}

std::string names(bool (*wanted)(Isa)) {
  std::string list;
  for (const Isa isa : kAllIsas) {
    if (wanted(isa)) list += (list.empty() ? "" : ", ") + std::string(isa_name(isa));
  }
  return list;
}

Isa isa_from_environment() {
  const char* text = std::getenv(kIsaVariable);
  if (text == nullptr || *text == '\0') return Isa::automatic;
  for (const Isa isa : kAllIsas) {
    if (std::string_view(text) == isa_name(isa)) return isa;
  }
  throw Error("environment variable " + std::string(kIsaVariable) + " names the unknown instruction set '" +
              text + "'; known are " + names([](Isa) { return true; }));
}

const simd::Kernels& checked_kernels(Isa asked) {
  if (!is_known(asked)) {
    throw Error("WorkersOptions::isa has the unknown value " + std::to_string(static_cast<int>(asked)) +
                "; known are " + names([](Isa) { return true; }));
  }
  const Isa isa = asked == Isa::automatic ? isa_from_environment() : asked;
  if (isa == Isa::automatic) return simd::widest_kernels();
  if (const simd::Kernels* kernels = kernels_of(isa)) return *kernels;
  throw Error((asked == Isa::automatic ? "environment variable " + std::string(kIsaVariable)
                                       : std::string("WorkersOptions::isa")) +
                  " asks for instruction set " + isa_name(isa) +
                  ", which this build or this processor does not support; supported are " +
                  names(is_supported),
              ErrorCode::not_supported);
}

const ZoneHooks& checked_zones(const ZoneHooks& zones) {
  if ((zones.begin == nullptr) == (zones.end == nullptr)) return zones;
  throw Error(std::string("WorkersOptions::zones has no ") + (zones.begin == nullptr ? "begin" : "end") +
              "; set both or none");
}

}  // namespace

const char* isa_name(Isa isa) {
  constexpr const char* kNames[] = {"auto", "scalar", "sse2", "avx2", "avx512"};
  return is_known(isa) ? kNames[static_cast<int>(isa)] : "unknown";
}

bool is_supported(Isa isa) { return isa == Isa::automatic || (is_known(isa) && kernels_of(isa) != nullptr); }

HelperSet::HelperSet(int thread_count)
    : threads(thread_count), pool(new HelperPool(thread_count)), arena(std::max(1, thread_count - 1)) {}

namespace {

// Unused sets. Never destroyed: a helper may still run while the process ends.
struct LeftSets {
  std::mutex mutex;
  HelperSet* first = nullptr;
  int in_all = 0;  // those in use, too
};

LeftSets& left_sets() {
  static LeftSets* const sets = new LeftSets;
  return *sets;
}

}  // namespace

HelperSet* take_helper_set(int threads) {
  LeftSets& left = left_sets();
  const std::lock_guard lock(left.mutex);
  for (HelperSet** link = &left.first; *link != nullptr; link = &(*link)->next) {
    if ((*link)->threads == threads) return std::exchange(*link, (*link)->next);
  }
  HelperSet* const set = new HelperSet(threads);
  ++left.in_all;
  return set;
}

void leave_helper_set(HelperSet* set) noexcept {
  LeftSets& left = left_sets();
  const std::lock_guard lock(left.mutex);
  set->next = std::exchange(left.first, set);
  for (HelperSet** link = &left.first; *link != nullptr;) {
    if ((*link)->pool->has_helpers()) {
      link = &(*link)->next;
      continue;
    }
    delete std::exchange(*link, (*link)->next);
    --left.in_all;
  }
}

int helper_sets() {
  LeftSets& left = left_sets();
  const std::lock_guard lock(left.mutex);
  return left.in_all;
}

Workers::Impl::Impl(int thread_count, const simd::Kernels& chosen, const ZoneHooks& hooks)
    : threads(thread_count),
      kernels(&chosen),
      helpers(take_helper_set(thread_count)),
      pool(helpers->pool),
      zones(hooks) {
  bring_in(chosen);
}

int Workers::Impl::available_threads() const {
  return threads == 1 ? 1 : std::min(threads, HelperArena::allowed_threads());
}

void Workers::Impl::send_helpers(int count) {
  while (pool->enlist(count)) {
    pool->retain();
    try {
      helpers->arena.enqueue([](void* task_pool) { static_cast<HelperPool*>(task_pool)->run_helper(); },
                             pool);
    } catch (...) {  // a step needs no helper
      pool->resign();
      pool->release();
      return;
    }
  }
}

Workers::Workers() : Workers(WorkersOptions{}) {}
Workers::Workers(int threads) : Workers(WorkersOptions{.threads = threads}) {}
Workers::Workers(const WorkersOptions& options)
    : impl_(std::make_shared<Impl>(checked_threads(options.threads), checked_kernels(options.isa),
                                   checked_zones(options.zones))) {}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;
int Workers::threads() const noexcept { return impl_->threads; }
Isa Workers::isa() const noexcept { return isa_of(*impl_->kernels); }

}  // namespace scree
