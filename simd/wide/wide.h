// Wide numbers: as many floats, integers or truth values as the instruction set has lanes.
//
// Kernels are written once against this file and compiled once per instruction set, each time with another
// SCREE_SIMD_NAMESPACE (scalar, sse2, avx2, avx512). It wraps xsimd so that every operation gives the same
// bits on every instruction set: xsimd 8.1 negates as 0 - x on AVX-512 and by the sign bit elsewhere, and its
// != is ordered on some sets and unordered on others.
//
// Meaning of the operations where IEEE leaves a choice:
//   min(a, b) = a < b ? a : b     max(a, b) = a > b ? a : b     (b if either is NaN or both are zero)
//   -a flips the sign bit         a != b is !(a == b)
//
// All sets agree on what is NaN. But the sign and payload of a NaN that an operation computes (+ - * / sqrt
// and all that is built from them) may differ: processors pass on one of the operands, and compilers may
// exchange these. So never take copy_sign() or the bits of a value that may be NaN.
// tests/simd/wide/wide_test.cpp checks this, and equal bits everywhere else, for every operation.
#pragma once

#ifndef SCREE_SIMD_NAMESPACE
#error "wide.h belongs in sources that are compiled once per instruction set"
#endif

#include <cstdint>

#if SCREE_SIMD_LANES == 1
#include <simd/wide/wide_scalar.h>
#else
#include <simd/wide/wide_xsimd.h>
#endif

// In front of a loop over lanes or blocks: leaves no call in it. GCC 12 makes functions of the helpers below
// and hands them vectors through memory, which costs relax a third of its time. Sanitizers would take minutes
// over it.
#ifdef SCREE_SANITIZED
#define SCREE_SWEEP
#else
#define SCREE_SWEEP [[gnu::flatten]]
#endif

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline F min(F a, F b) { return native_min(a, b); }
inline F max(F a, F b) { return native_max(a, b); }
inline F clamp(F value, F low, F high) { return min(max(value, low), high); }
inline F operator-(F a) { return as_float(as_int(a) ^ I(INT32_MIN)); }
inline F abs(F a) { return as_float(as_int(a) & I(INT32_MAX)); }
inline F copy_sign(F magnitude, F sign) {
  return as_float((as_int(magnitude) & I(INT32_MAX)) | (as_int(sign) & I(INT32_MIN)));
}
inline F& operator+=(F& a, F b) { return a = a + b; }
inline F& operator-=(F& a, F b) { return a = a - b; }
inline F& operator*=(F& a, F b) { return a = a * b; }

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
