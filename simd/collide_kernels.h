#pragma once

namespace scree::simd {

struct CollideKernels {};

}  // namespace scree::simd
