// Every operation of wide.h and wide_math.h as a function over arrays, so that one test can feed the same
// numbers to each instruction set. Made by wide_cases.cpp, which is compiled once per instruction set.
#pragma once

#include <cstdint>

namespace scree::simd {

// Numbers travel as bit patterns: an assignment of floats may quiet a signaling NaN.
using Bits = std::uint32_t;

struct WideCase {
  const char* name;
  int inputs;
  int outputs;
  // Where the operation computes, a NaN result may carry any sign and payload: the processor passes on one of
  // its operands, and the compiler may exchange them. Operations that only move or compare bits are exact.
  bool computes;
  void (*run)(const Bits* const* in, Bits* const* out, int count);  // count: a multiple of 16
};

struct WideCases {
  int lanes;
  int count;
  const WideCase* cases;
  // Sixteen rows of four floats each, in as many goes as it takes.
  void (*load_rows)(const float* base, int stride, const std::int32_t* index, float* const* out);
  void (*load_triples)(const float* base, const std::int32_t* index, float* const* out);
  // Rows 0 to count - 1 of sixteen.
  void (*store_rows)(float* base, int stride, const std::int32_t* index, int count, const float* const* in);
  void (*store_row_pairs)(float* base, int stride, const std::int32_t* index, int count,
                          const float* const* in);
  // The same for rows of eight floats, one behind the other.
  void (*load_rows8)(const float* base, const std::int32_t* index, float* const* out);
  void (*store_rows8)(float* base, const std::int32_t* index, int count, const float* const* in);
};

namespace scalar {
WideCases wide_cases();
}
namespace sse2 {
WideCases wide_cases();
}
namespace avx2 {
WideCases wide_cases();
}
namespace avx512 {
WideCases wide_cases();
}

}  // namespace scree::simd
