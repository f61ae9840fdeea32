#pragma once

namespace scree::simd {

struct PairKernels {};

}  // namespace scree::simd
