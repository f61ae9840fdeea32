// Wide numbers on xsimd, and the row transposes that it lacks. Included by wide.h only.
#pragma once

#include <immintrin.h>

#include <cstddef>
#include <xsimd/xsimd.hpp>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

#if SCREE_SIMD_LANES == 4
using Arch = xsimd::sse2;
#elif SCREE_SIMD_LANES == 8
using Arch = xsimd::avx2;
#elif SCREE_SIMD_LANES == 16
using Arch = xsimd::avx512dq;
#endif
using FloatBatch = xsimd::batch<float, Arch>;
using IntBatch = xsimd::batch<std::int32_t, Arch>;
using MaskBatch = xsimd::batch_bool<float, Arch>;

inline constexpr int kLanes = SCREE_SIMD_LANES;
static_assert(FloatBatch::size == kLanes);

struct F {
  FloatBatch v;
  F() = default;
  F(float value) : v(value) {}
  explicit F(FloatBatch value) : v(value) {}
};
struct I {
  IntBatch v;
  I() = default;
  I(std::int32_t value) : v(value) {}
  explicit I(IntBatch value) : v(value) {}
};
struct M {
  MaskBatch v;
  M() = default;
  explicit M(MaskBatch value) : v(value) {}
};

inline F operator+(F a, F b) { return F(a.v + b.v); }
inline F operator-(F a, F b) { return F(a.v - b.v); }
inline F operator*(F a, F b) { return F(a.v * b.v); }
inline F operator/(F a, F b) { return F(a.v / b.v); }
inline F sqrt(F a) { return F(xsimd::sqrt(a.v)); }
inline M operator<(F a, F b) { return M(a.v < b.v); }
inline M operator<=(F a, F b) { return M(a.v <= b.v); }
inline M operator>(F a, F b) { return M(a.v > b.v); }
inline M operator>=(F a, F b) { return M(a.v >= b.v); }
inline M operator==(F a, F b) { return M(a.v == b.v); }
// The instructions compute exactly a < b ? a : b and a > b ? a : b.
#if SCREE_SIMD_LANES == 4
inline F native_min(F a, F b) { return F(FloatBatch(_mm_min_ps(a.v, b.v))); }
inline F native_max(F a, F b) { return F(FloatBatch(_mm_max_ps(a.v, b.v))); }
#elif SCREE_SIMD_LANES == 8
inline F native_min(F a, F b) { return F(FloatBatch(_mm256_min_ps(a.v, b.v))); }
inline F native_max(F a, F b) { return F(FloatBatch(_mm256_max_ps(a.v, b.v))); }
#else
inline F native_min(F a, F b) { return F(FloatBatch(_mm512_min_ps(a.v, b.v))); }
inline F native_max(F a, F b) { return F(FloatBatch(_mm512_max_ps(a.v, b.v))); }
#endif

inline I operator+(I a, I b) { return I(a.v + b.v); }
inline I operator-(I a, I b) { return I(a.v - b.v); }
inline I operator&(I a, I b) { return I(a.v & b.v); }
inline I operator|(I a, I b) { return I(a.v | b.v); }
inline I operator^(I a, I b) { return I(a.v ^ b.v); }
template <int kBits>
inline I shift_left(I a) {
  return I(a.v << kBits);
}

inline M operator&(M a, M b) { return M(a.v & b.v); }
inline M operator|(M a, M b) { return M(a.v | b.v); }
inline M operator!(M a) { return M(!a.v); }
inline F select(M m, F yes, F no) { return F(xsimd::select(m.v, yes.v, no.v)); }

inline I as_int(F a) { return I(xsimd::bitwise_cast<IntBatch>(a.v)); }
inline F as_float(I a) { return F(xsimd::bitwise_cast<FloatBatch>(a.v)); }
inline F to_float(I a) { return F(xsimd::to_float(a.v)); }

// Masks are float masks; integers are compared and chosen through them.
#if SCREE_SIMD_LANES == 4
inline M mask_of(__m128i m) { return M(MaskBatch(_mm_castsi128_ps(m))); }
inline M operator==(I a, I b) { return mask_of(_mm_cmpeq_epi32(a.v, b.v)); }
inline M operator>(I a, I b) { return mask_of(_mm_cmpgt_epi32(a.v, b.v)); }
template <int kBits>
inline I shift_right(I a) {  // fills with zeros
  return I(IntBatch(_mm_srli_epi32(a.v, kBits)));
}
inline std::uint32_t bits(M a) { return static_cast<std::uint32_t>(_mm_movemask_ps(a.v)); }
inline I lane_numbers() { return I(IntBatch(_mm_setr_epi32(0, 1, 2, 3))); }
inline M mask_from_bits(std::uint32_t mask) {
  const __m128i lane_bits = _mm_setr_epi32(1, 2, 4, 8);
  return mask_of(
      _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(static_cast<int>(mask)), lane_bits), lane_bits));
}
#elif SCREE_SIMD_LANES == 8
inline M mask_of(__m256i m) { return M(MaskBatch(_mm256_castsi256_ps(m))); }
inline M operator==(I a, I b) { return mask_of(_mm256_cmpeq_epi32(a.v, b.v)); }
inline M operator>(I a, I b) { return mask_of(_mm256_cmpgt_epi32(a.v, b.v)); }
template <int kBits>
inline I shift_right(I a) {
  return I(IntBatch(_mm256_srli_epi32(a.v, kBits)));
}
inline std::uint32_t bits(M a) { return static_cast<std::uint32_t>(_mm256_movemask_ps(a.v)); }
inline I lane_numbers() { return I(IntBatch(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7))); }
inline M mask_from_bits(std::uint32_t mask) {
  const __m256i lane_bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  return mask_of(
      _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), lane_bits), lane_bits));
}
#else
inline M mask_of(__mmask16 m) { return M(MaskBatch(m)); }
inline M operator==(I a, I b) { return mask_of(_mm512_cmpeq_epi32_mask(a.v, b.v)); }
inline M operator>(I a, I b) { return mask_of(_mm512_cmpgt_epi32_mask(a.v, b.v)); }
template <int kBits>
inline I shift_right(I a) {
  return I(IntBatch(_mm512_srli_epi32(a.v, kBits)));
}
inline std::uint32_t bits(M a) { return static_cast<std::uint32_t>(static_cast<__mmask16>(a.v)); }
inline I lane_numbers() {
  return I(IntBatch(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)));
}
inline M mask_from_bits(std::uint32_t mask) { return mask_of(static_cast<__mmask16>(mask)); }
#endif
inline M operator<(I a, I b) { return b > a; }
inline I select(M m, I yes, I no) { return as_int(select(m, as_float(yes), as_float(no))); }

inline F load(const float* from) { return F(FloatBatch::load_aligned(from)); }
inline F load_unaligned(const float* from) { return F(FloatBatch::load_unaligned(from)); }
inline I load(const std::int32_t* from) { return I(IntBatch::load_aligned(from)); }
inline I load_unaligned(const std::int32_t* from) { return I(IntBatch::load_unaligned(from)); }
inline void store(float* to, F a) { a.v.store_aligned(to); }
inline void store_unaligned(float* to, F a) { a.v.store_unaligned(to); }
inline void store(std::int32_t* to, I a) { a.v.store_aligned(to); }
inline void store_unaligned(std::int32_t* to, I a) { a.v.store_unaligned(to); }

// Transposes 4 x 4 blocks: before, register k holds rows k, k + 4, k + 8, ... of four floats each; after, it
// holds float k of every row, in the rows' order. Its own reverse.
#if SCREE_SIMD_LANES == 4
using Register = __m128;
inline Register unpack_low(Register a, Register b) { return _mm_unpacklo_ps(a, b); }
inline Register unpack_high(Register a, Register b) { return _mm_unpackhi_ps(a, b); }
inline Register merge_low(Register a, Register b) { return _mm_movelh_ps(a, b); }
inline Register merge_high(Register a, Register b) { return _mm_movehl_ps(b, a); }
#elif SCREE_SIMD_LANES == 8
using Register = __m256;
inline Register unpack_low(Register a, Register b) { return _mm256_unpacklo_ps(a, b); }
inline Register unpack_high(Register a, Register b) { return _mm256_unpackhi_ps(a, b); }
inline Register merge_low(Register a, Register b) { return _mm256_shuffle_ps(a, b, 0x44); }
inline Register merge_high(Register a, Register b) { return _mm256_shuffle_ps(a, b, 0xee); }
#else
using Register = __m512;
inline Register unpack_low(Register a, Register b) { return _mm512_unpacklo_ps(a, b); }
inline Register unpack_high(Register a, Register b) { return _mm512_unpackhi_ps(a, b); }
inline Register merge_low(Register a, Register b) { return _mm512_shuffle_ps(a, b, 0x44); }
inline Register merge_high(Register a, Register b) { return _mm512_shuffle_ps(a, b, 0xee); }
#endif

inline void transpose(Register& r0, Register& r1, Register& r2, Register& r3) {
  const Register low_01 = unpack_low(r0, r1);    // x0 x1 y0 y1
  const Register high_01 = unpack_high(r0, r1);  // z0 z1 w0 w1
  const Register low_23 = unpack_low(r2, r3);
  const Register high_23 = unpack_high(r2, r3);
  r0 = merge_low(low_01, low_23);
  r1 = merge_high(low_01, low_23);
  r2 = merge_low(high_01, high_23);
  r3 = merge_high(high_01, high_23);
}

// One register of the transpose's input: lanes first, first + 4, ... each bring a row.
inline Register gather_rows(const float* base, std::ptrdiff_t stride, const std::int32_t* index) {
#if SCREE_SIMD_LANES == 4
  return _mm_load_ps(base + stride * index[0]);
#elif SCREE_SIMD_LANES == 8
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(base + stride * index[0])),
                              _mm_load_ps(base + stride * index[4]), 1);
#else
  const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(base + stride * index[0])),
                                          _mm_load_ps(base + stride * index[4]), 1);
  const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(base + stride * index[8])),
                                           _mm_load_ps(base + stride * index[12]), 1);
  return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
#endif
}

inline __m128 quarter(Register r, int which) {
#if SCREE_SIMD_LANES == 4
  return which == 0 ? r : r;
#elif SCREE_SIMD_LANES == 8
  return which == 0 ? _mm256_castps256_ps128(r) : _mm256_extractf128_ps(r, 1);
#else
  switch (which) {
    case 0:
      return _mm512_castps512_ps128(r);
    case 1:
      return _mm512_extractf32x4_ps(r, 1);
    case 2:
      return _mm512_extractf32x4_ps(r, 2);
    default:
      return _mm512_extractf32x4_ps(r, 3);
  }
#endif
}

// Over all lanes; for numbers that are not NaN. The sign of a zero result is unspecified.
#if SCREE_SIMD_LANES == 16
inline float reduce_min(F a) { return _mm512_reduce_min_ps(a.v); }
inline float reduce_max(F a) { return _mm512_reduce_max_ps(a.v); }
#else
inline float reduce_min(F a) {
#if SCREE_SIMD_LANES == 8
  const __m128 r = _mm_min_ps(quarter(a.v, 0), quarter(a.v, 1));
#else
  const __m128 r = a.v;
#endif
  const __m128 pair = _mm_min_ps(r, _mm_movehl_ps(r, r));
  return _mm_cvtss_f32(_mm_min_ss(pair, _mm_shuffle_ps(pair, pair, 1)));
}
inline float reduce_max(F a) {
#if SCREE_SIMD_LANES == 8
  const __m128 r = _mm_max_ps(quarter(a.v, 0), quarter(a.v, 1));
#else
  const __m128 r = a.v;
#endif
  const __m128 pair = _mm_max_ps(r, _mm_movehl_ps(r, r));
  return _mm_cvtss_f32(_mm_max_ss(pair, _mm_shuffle_ps(pair, pair, 1)));
}
#endif

// Writes the chosen lanes one behind the other and returns their number. May write kLanes numbers.
#if SCREE_SIMD_LANES == 16
inline int compress_store(std::int32_t* to, M which, I a) {
  // Not the instruction that stores by itself: it takes a hundred cycles on Zen 4.
  const auto mask = static_cast<__mmask16>(bits(which));
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, a.v));
  return __builtin_popcount(bits(which));
}
#elif SCREE_SIMD_LANES == 8
// For each mask, the chosen lanes in order.
struct CompressTable {
  alignas(64) std::uint8_t lanes[256][8];
};
constexpr CompressTable make_compress_table() {
  CompressTable table{};
  for (int mask = 0; mask < 256; ++mask) {
    int count = 0;
    for (int lane = 0; lane < 8; ++lane) {
      if ((mask >> lane & 1) != 0) table.lanes[mask][count++] = static_cast<std::uint8_t>(lane);
    }
  }
  return table;
}
inline constexpr CompressTable kCompressTable = make_compress_table();
inline int compress_store(std::int32_t* to, M which, I a) {
  const std::uint32_t mask = bits(which);
  const __m128i packed = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompressTable.lanes[mask]));
  const __m256i order = _mm256_cvtepu8_epi32(packed);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(a.v, order));
  return __builtin_popcount(mask);
}
#else
inline int compress_store(std::int32_t* to, M which, I a) {
  const std::uint32_t mask = bits(which);
  alignas(16) std::int32_t lanes[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(lanes), a.v);
  int count = 0;
  for (int lane = 0; lane < 4; ++lane) {
    to[count] = lanes[lane];
    count += static_cast<int>(mask >> lane & 1u);
  }
  return count;
}
#endif

// Writes a0 b0 a1 b1 ...
inline void store_interleaved(std::int32_t* to, I a, I b) {
#if SCREE_SIMD_LANES == 4
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_unpacklo_epi32(a.v, b.v));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to + 4), _mm_unpackhi_epi32(a.v, b.v));
#elif SCREE_SIMD_LANES == 8
  const __m256i low = _mm256_unpacklo_epi32(a.v, b.v), high = _mm256_unpackhi_epi32(a.v, b.v);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permute2x128_si256(low, high, 0x20));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + 8), _mm256_permute2x128_si256(low, high, 0x31));
#else
  const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(8));
  _mm512_storeu_si512(to, _mm512_permutex2var_epi32(a.v, low, b.v));
  _mm512_storeu_si512(to + 16, _mm512_permutex2var_epi32(a.v, high, b.v));
#endif
}

// Four consecutive floats per lane (16-byte aligned), at base + stride * index[lane]; becomes four wide
// numbers.
inline void load_rows(const float* base, int stride, const std::int32_t* index, F& x, F& y, F& z, F& w) {
  Register r0 = gather_rows(base, stride, index);
  Register r1 = gather_rows(base, stride, index + 1);
  Register r2 = gather_rows(base, stride, index + 2);
  Register r3 = gather_rows(base, stride, index + 3);
  transpose(r0, r1, r2, r3);
  x = F(FloatBatch(r0));
  y = F(FloatBatch(r1));
  z = F(FloatBatch(r2));
  w = F(FloatBatch(r3));
}

// Three consecutive floats per lane, at base + 3 * index[step * lane]; becomes three wide numbers. Reads a
// fourth float behind each.
inline void load_triples(const float* base, const std::int32_t* index, int step, F& x, F& y, F& z) {
  const auto row = [=](int lane) { return _mm_loadu_ps(base + std::ptrdiff_t{3} * index[step * lane]); };
  Register r[4];
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 4
#endif
  for (int i = 0; i < 4; ++i) {
#if SCREE_SIMD_LANES == 4
    r[i] = row(i);
#elif SCREE_SIMD_LANES == 8
    r[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(row(i)), row(i + 4), 1);
#else
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(row(i)), row(i + 4), 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(row(i + 8)), row(i + 12), 1);
    r[i] = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
#endif
  }
  transpose(r[0], r[1], r[2], r[3]);
  x = F(FloatBatch(r[0]));
  y = F(FloatBatch(r[1]));
  z = F(FloatBatch(r[2]));
}

// The reverse of load_rows, for lanes 0 to count - 1; later lanes write nothing.
inline void store_rows(float* base, std::ptrdiff_t stride, const std::int32_t* index, int count, F x, F y,
                       F z, F w) {
  Register r[4] = {x.v, y.v, z.v, w.v};
  transpose(r[0], r[1], r[2], r[3]);
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 16
#endif
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane < count) _mm_store_ps(base + stride * index[lane], quarter(r[lane & 3], lane >> 2));
  }
}

// The first two floats of each row only.
inline void store_row_pairs(float* base, std::ptrdiff_t stride, const std::int32_t* index, int count, F x,
                            F y) {
  const Register low = unpack_low(x.v, y.v);    // rows 0 and 1 of each four
  const Register high = unpack_high(x.v, y.v);  // rows 2 and 3
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 16
#endif
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane >= count) continue;
    const __m128 rows = quarter((lane & 2) != 0 ? high : low, lane >> 2);
    __m64* to = reinterpret_cast<__m64*>(base + stride * index[lane]);
    if ((lane & 1) != 0) {
      _mm_storeh_pi(to, rows);
    } else {
      _mm_storel_pi(to, rows);
    }
  }
}

// Eight consecutive floats per lane (32-byte aligned), at base + 8 * index[lane]; becomes eight wide numbers.
inline void load_rows8(const float* base, const std::int32_t* index, F (&column)[8]) {
#if SCREE_SIMD_LANES == 4
  load_rows(base, 8, index, column[0], column[1], column[2], column[3]);
  load_rows(base + 4, 8, index, column[4], column[5], column[6], column[7]);
#else
  const auto row = [=](int lane) { return _mm256_load_ps(base + std::ptrdiff_t{8} * index[lane]); };
  Register r[8];
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 4
#endif
  for (int i = 0; i < 4; ++i) {
#if SCREE_SIMD_LANES == 8
    r[i] = row(i);
    r[4 + i] = row(4 + i);
#else
    r[i] = _mm512_insertf32x8(_mm512_castps256_ps512(row(i)), row(4 + i), 1);
    r[4 + i] = _mm512_insertf32x8(_mm512_castps256_ps512(row(8 + i)), row(12 + i), 1);
#endif
  }
  // Each four registers become columns k and 4 + k of half of the rows, in alternating quarters.
  transpose(r[0], r[1], r[2], r[3]);
  transpose(r[4], r[5], r[6], r[7]);
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 4
#endif
  for (int k = 0; k < 4; ++k) {
#if SCREE_SIMD_LANES == 8
    column[k] = F(FloatBatch(_mm256_permute2f128_ps(r[k], r[4 + k], 0x20)));
    column[4 + k] = F(FloatBatch(_mm256_permute2f128_ps(r[k], r[4 + k], 0x31)));
#else
    column[k] = F(FloatBatch(_mm512_shuffle_f32x4(r[k], r[4 + k], 0x88)));
    column[4 + k] = F(FloatBatch(_mm512_shuffle_f32x4(r[k], r[4 + k], 0xdd)));
#endif
  }
#endif
}

// The reverse, for lanes 0 to count - 1; later lanes write nothing.
inline void store_rows8(float* base, const std::int32_t* index, int count, const F (&column)[8]) {
#if SCREE_SIMD_LANES == 4
  store_rows(base, 8, index, count, column[0], column[1], column[2], column[3]);
  store_rows(base + 4, 8, index, count, column[4], column[5], column[6], column[7]);
#else
  Register r[8];
#if SCREE_SIMD_LANES == 16
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
  const __m512i high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 4
#endif
  for (int k = 0; k < 4; ++k) {
#if SCREE_SIMD_LANES == 8
    r[k] = _mm256_permute2f128_ps(column[k].v, column[4 + k].v, 0x20);
    r[4 + k] = _mm256_permute2f128_ps(column[k].v, column[4 + k].v, 0x31);
#else
    const __m512d a = _mm512_castps_pd(column[k].v), b = _mm512_castps_pd(column[4 + k].v);
    r[k] = _mm512_castpd_ps(_mm512_permutex2var_pd(a, low, b));
    r[4 + k] = _mm512_castpd_ps(_mm512_permutex2var_pd(a, high, b));
#endif
  }
  transpose(r[0], r[1], r[2], r[3]);
  transpose(r[4], r[5], r[6], r[7]);
#if SCREE_SIMD_LANES == 8
  const auto row = [&r](int lane) { return r[lane]; };
#else
  const auto row = [&r](int lane) {
    const __m512 pair = r[(lane & 3) | (lane >> 3 << 2)];  // this row and the one four lanes on or before
    return (lane & 4) == 0 ? _mm512_castps512_ps256(pair) : _mm512_extractf32x8_ps(pair, 1);
  };
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC unroll 16
#endif
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane < count) _mm256_store_ps(base + std::ptrdiff_t{8} * index[lane], row(lane));
  }
#endif
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
