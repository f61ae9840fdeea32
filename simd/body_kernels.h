#pragma once

namespace scree::simd {

struct BodyKernels {};

}  // namespace scree::simd
