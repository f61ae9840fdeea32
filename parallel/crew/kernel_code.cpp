// See kernel_code.h. Runs once, when Workers are made.
#include <parallel/crew/kernel_code.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace scree {

namespace {

constexpr std::uintptr_t kPageBytes = 4096;
constexpr std::uintptr_t kMostBytes = std::uintptr_t{1} << 24;  // more lies between them than kernels

struct CodeRange {
  std::uintptr_t first = std::numeric_limits<std::uintptr_t>::max();
  std::uintptr_t last = 0;

  template <class... Functions>
  void add(Functions*... functions) {
    for (const std::uintptr_t at : {reinterpret_cast<std::uintptr_t>(functions)...}) {
      if (at == 0) continue;
      first = std::min(first, at);
      last = std::max(last, at);
    }
  }
};

CodeRange range_of(const simd::Kernels& kernels) {
  CodeRange range;
  const simd::BodyKernels& body = kernels.body;
  range.add(body.prepare, body.integrate_velocities, body.integrate_poses, body.finish);
  const simd::PairKernels& pair = kernels.pair;
  range.add(pair.update_bounds, pair.refit_leaves, pair.refit_nodes, pair.join, pair.rank_rows);
  const simd::CollideKernels& collide = kernels.collide;
  for (const simd::CollideKernels::Collide function : collide.collide) range.add(function);
  range.add(collide.recycle_boxes, collide.recycle_hulls, collide.recycle_capsules);
  const simd::ContactKernels& contact = kernels.contact;
  range.add(contact.prepare, contact.warm_start, contact.solve, contact.relax, contact.relax_measured,
            contact.find_impacts, contact.push_impacts, contact.rub_impacts, contact.finish_impacts,
            contact.store, contact.store_forces, contact.measure_depth);
  for (const simd::JointVariantKernels& joint : kernels.joint.variant) {
    range.add(joint.prepare, joint.warm_start, joint.solve, joint.relax, joint.relax_measured, joint.store);
  }
  return range;
}

}  // namespace

std::span<const std::byte> code_of(const simd::Kernels& kernels) {
  const CodeRange range = range_of(kernels);
  const std::uintptr_t begin = range.first / kPageBytes * kPageBytes;
  const std::uintptr_t end = (range.last / kPageBytes + 1) * kPageBytes;
  return {reinterpret_cast<const std::byte*>(begin), std::min(end - begin, kMostBytes)};
}

void bring_in(const simd::Kernels& kernels) noexcept {
#if defined(__linux__) && defined(MADV_POPULATE_READ)
  static std::atomic<unsigned> done{0};
  const unsigned bit = 1u << static_cast<unsigned>(kernels.instruction_set);
  if ((done.fetch_or(bit, std::memory_order_relaxed) & bit) != 0) return;
  const std::span<const std::byte> code = code_of(kernels);
  // An older system refuses, and loads the pages one by one as before.
  madvise(const_cast<std::byte*>(code.data()), code.size(), MADV_POPULATE_READ);
#else
  static_cast<void>(kernels);
#endif
}

}  // namespace scree
