// Workers: the threads and the instruction set that steps run on.
#pragma once

#include <scree/error.h>
#include <scree/export.h>
#include <scree/zones.h>

#include <cstdint>
#include <memory>

namespace scree {

/// An instruction set of the kernels. Results do not depend on it. `automatic` takes the environment variable
/// SCREE_ISA (scalar, sse2, avx2 or avx512) if it is set, otherwise the widest that the processor supports.
enum class Isa : std::uint8_t {
  automatic,  ///< SCREE_ISA, or the widest
  scalar,     ///< no vector instructions: any processor
  sse2,       ///< 4 lanes
  avx2,       ///< 8 lanes
  avx512,     ///< 16 lanes
};

/// "auto", "scalar", "sse2", "avx2" or "avx512"; "unknown" for other values.
SCREE_API const char* isa_name(Isa isa);
/// Whether this build holds the kernels and this processor runs them.
SCREE_API bool is_supported(Isa isa);

/// The threads and the instruction set of Workers.
struct WorkersOptions {
  int threads = 0;           ///< threads that share a step, the caller's included; 0: one per core; <= 1024
  Isa isa = Isa::automatic;  ///< throws scree::Error if it is not supported
  ZoneHooks zones{};         ///< reports what steps do, for profilers; default: nothing
};

class Crew;

/// Lends helpers to steps. One `Workers` may serve many worlds and many calling threads at once; a step never
/// waits for a helper that has not begun to work, so stepping from inside tasks of the caller's own is safe.
/// Helpers are threads of oneTBB, which lends one per core at most; a tbb::global_control of
/// max_allowed_parallelism that the caller holds changes that. Threads beyond those are never asked for. A
/// moved-from `Workers` can only be assigned to or destroyed.
class SCREE_API Workers {
 public:
  Workers();
  /// As WorkersOptions{.threads = threads}.
  explicit Workers(int threads);
  /// Throws Error for more than 1024 or fewer than 0 threads, for an instruction set that is not supported,
  /// and for hooks of zones of which one is null and the other is not.
  explicit Workers(const WorkersOptions& options);
  ~Workers();
  Workers(Workers&&) noexcept;             ///< the other one can only be assigned to or destroyed
  Workers& operator=(Workers&&) noexcept;  ///< the other one can only be assigned to or destroyed

  int threads() const noexcept;  ///< as many as were asked for
  Isa isa() const noexcept;      ///< the one in use, never `automatic`

 private:
  friend class Crew;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace scree
