// Reads the code of the kernels into memory. The system loads pages of code when they first run, which would
// otherwise be in the middle of a step.
#pragma once

#include <simd/dispatch/kernels.h>

#include <cstddef>
#include <span>

namespace scree {

// From the first page of the set's kernels to the last one.
std::span<const std::byte> code_of(const simd::Kernels& kernels);
// Asks the system to bring them in, where it can be asked; otherwise, and the second time, nothing happens.
// The first ball that lands beside 1,000,000 boxes took 60 us, of which these pages were 20.
void bring_in(const simd::Kernels& kernels) noexcept;

}  // namespace scree
