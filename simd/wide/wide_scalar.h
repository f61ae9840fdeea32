// Wide numbers of one lane, in plain C++, for any processor: the reference for the other instruction sets.
// Included by wide.h only.
#pragma once

#include <cstddef>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

inline constexpr int kLanes = 1;

struct F {
  float v;
  F() = default;
  F(float value) : v(value) {}
};
struct I {
  std::int32_t v;
  I() = default;
  I(std::int32_t value) : v(value) {}
};
struct M {
  bool v;
  M() = default;
  explicit M(bool value) : v(value) {}
};

inline F operator+(F a, F b) { return a.v + b.v; }
inline F operator-(F a, F b) { return a.v - b.v; }
inline F operator*(F a, F b) { return a.v * b.v; }
inline F operator/(F a, F b) { return a.v / b.v; }
inline F sqrt(F a) { return __builtin_sqrtf(a.v); }
inline F native_min(F a, F b) { return a.v < b.v ? a.v : b.v; }
inline F native_max(F a, F b) { return a.v > b.v ? a.v : b.v; }
inline M operator<(F a, F b) { return M(a.v < b.v); }
inline M operator<=(F a, F b) { return M(a.v <= b.v); }
inline M operator>(F a, F b) { return M(a.v > b.v); }
inline M operator>=(F a, F b) { return M(a.v >= b.v); }
inline M operator==(F a, F b) { return M(a.v == b.v); }

inline I operator+(I a, I b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a.v) + static_cast<std::uint32_t>(b.v));
}
inline I operator-(I a, I b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a.v) - static_cast<std::uint32_t>(b.v));
}
inline I operator&(I a, I b) { return a.v & b.v; }
inline I operator|(I a, I b) { return a.v | b.v; }
inline I operator^(I a, I b) { return a.v ^ b.v; }
inline M operator==(I a, I b) { return M(a.v == b.v); }
inline M operator<(I a, I b) { return M(a.v < b.v); }
inline M operator>(I a, I b) { return M(a.v > b.v); }
template <int kBits>
inline I shift_left(I a) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a.v) << kBits);
}
template <int kBits>
inline I shift_right(I a) {  // fills with zeros
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a.v) >> kBits);
}

inline M operator&(M a, M b) { return M(a.v && b.v); }
inline M operator|(M a, M b) { return M(a.v || b.v); }
inline M operator!(M a) { return M(!a.v); }
inline std::uint32_t bits(M a) { return a.v ? 1u : 0u; }
inline M mask_from_bits(std::uint32_t mask) { return M((mask & 1u) != 0); }
inline F select(M m, F yes, F no) { return m.v ? yes : no; }
inline I select(M m, I yes, I no) { return m.v ? yes : no; }

inline I as_int(F a) {
  std::int32_t result;
  __builtin_memcpy(&result, &a.v, sizeof(result));
  return result;
}
inline F as_float(I a) {
  float result;
  __builtin_memcpy(&result, &a.v, sizeof(result));
  return result;
}
inline F to_float(I a) { return static_cast<float>(a.v); }

inline F load(const float* from) { return *from; }
inline F load_unaligned(const float* from) { return *from; }
inline I load(const std::int32_t* from) { return *from; }
inline I load_unaligned(const std::int32_t* from) { return *from; }
inline void store(float* to, F a) { *to = a.v; }
inline void store_unaligned(float* to, F a) { *to = a.v; }
inline void store(std::int32_t* to, I a) { *to = a.v; }
inline void store_unaligned(std::int32_t* to, I a) { *to = a.v; }
inline I lane_numbers() { return 0; }
// Writes the chosen lanes one behind the other and returns their number. May write kLanes numbers.
inline int compress_store(std::int32_t* to, M which, I a) {
  *to = a.v;
  return which.v ? 1 : 0;
}
// Writes a0 b0 a1 b1 ...
inline void store_interleaved(std::int32_t* to, I a, I b) {
  to[0] = a.v;
  to[1] = b.v;
}
// Over all lanes; for numbers that are not NaN. The sign of a zero result is unspecified.
inline float reduce_min(F a) { return a.v; }
inline float reduce_max(F a) { return a.v; }

// Four consecutive floats per lane, at base + stride * index[lane]; becomes four wide numbers.
inline void load_rows(const float* base, int stride, const std::int32_t* index, F& x, F& y, F& z, F& w) {
  const float* row = base + static_cast<std::ptrdiff_t>(stride) * index[0];
  x = row[0];
  y = row[1];
  z = row[2];
  w = row[3];
}
// Three consecutive floats per lane, at base + 3 * index[step * lane]; becomes three wide numbers.
inline void load_triples(const float* base, const std::int32_t* index, int, F& x, F& y, F& z) {
  const float* row = base + std::ptrdiff_t{3} * index[0];
  x = row[0];
  y = row[1];
  z = row[2];
}
// The reverse of load_rows, for lanes 0 to count - 1; later lanes write nothing.
inline void store_rows(float* base, int stride, const std::int32_t* index, int count, F x, F y, F z, F w) {
  if (count < 1) return;
  float* row = base + static_cast<std::ptrdiff_t>(stride) * index[0];
  row[0] = x.v;
  row[1] = y.v;
  row[2] = z.v;
  row[3] = w.v;
}
// The first two floats of each row only.
inline void store_row_pairs(float* base, int stride, const std::int32_t* index, int count, F x, F y) {
  if (count < 1) return;
  float* row = base + static_cast<std::ptrdiff_t>(stride) * index[0];
  row[0] = x.v;
  row[1] = y.v;
}

// Eight consecutive floats per lane, at base + 8 * index[lane]; becomes eight wide numbers.
inline void load_rows8(const float* base, const std::int32_t* index, F (&column)[8]) {
  for (int k = 0; k < 8; ++k) column[k] = base[std::ptrdiff_t{8} * index[0] + k];
}
// The reverse, for lanes 0 to count - 1; later lanes write nothing.
inline void store_rows8(float* base, const std::int32_t* index, int count, const F (&column)[8]) {
  if (count < 1) return;
  for (int k = 0; k < 8; ++k) base[std::ptrdiff_t{8} * index[0] + k] = column[k].v;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
