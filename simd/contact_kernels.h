#pragma once

namespace scree::simd {

struct ContactKernels {};

}  // namespace scree::simd
