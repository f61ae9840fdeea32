// The operations of one instruction set as a table. Obeys the rules of kernels: no standard templates.
#include "wide_cases.h"

#include <simd/constraints/joints/joint_angular.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {
namespace {

// The inputs and outputs of one pass: `kLanes` elements from `at` on.
struct Go {
  const Bits* const* in;
  Bits* const* out;
  int at;

  I i(int input) const { return load_unaligned(reinterpret_cast<const std::int32_t*>(in[input] + at)); }
  F f(int input) const { return as_float(i(input)); }
  V3 v(int first) const { return {f(first), f(first + 1), f(first + 2)}; }
  Q4 q(int first) const { return {f(first), f(first + 1), f(first + 2), f(first + 3)}; }
  S3 s(int first) const {
    return {f(first), f(first + 1), f(first + 2), f(first + 3), f(first + 4), f(first + 5)};
  }
  M3 m(int first) const { return {v(first), v(first + 3), v(first + 6)}; }

  void put(int output, I value) const {
    store_unaligned(reinterpret_cast<std::int32_t*>(out[output] + at), value);
  }
  void put(int output, F value) const { put(output, as_int(value)); }
  void put(int output, M value) const { put(output, select(value, I(-1), I(0))); }
  void put(int first, V3 value) const {
    put(first, value.x);
    put(first + 1, value.y);
    put(first + 2, value.z);
  }
  void put(int first, Q4 value) const {
    put(first, V3{value.x, value.y, value.z});
    put(first + 3, value.w);
  }
  void put(int first, const M3& value) const {
    put(first, value.x);
    put(first + 3, value.y);
    put(first + 6, value.z);
  }
  void put(int first, const S3& value) const {
    put(first, V3{value.xx, value.xy, value.xz});
    put(first + 3, V3{value.yy, value.yz, value.zz});
  }
};

template <void (*kWork)(const Go&)>
void run(const Bits* const* in, Bits* const* out, int count) {
  for (int at = 0; at < count; at += kLanes) kWork({in, out, at});
}

#define SCREE_CASE(name, inputs, outputs, computes, body)            \
  {                                                                  \
    name, inputs, outputs, computes, run<[](const Go& go) { body; }> \
  }

void load_store_aligned(const Go& go) {
  alignas(64) std::int32_t integers[kLanes];
  alignas(64) float floats[kLanes];
  store(integers, go.i(0));
  store(floats, as_float(load(integers)));
  go.put(0, load(floats));
  store_unaligned(floats, load(floats));
  go.put(1, load_unaligned(floats));
}

void mask_bits(const Go& go) {
  const std::uint32_t mask = bits(go.f(0) < go.f(1));
  for (int lane = 0; lane < kLanes; ++lane) go.out[0][go.at + lane] = mask >> lane & 1u;
}

// A pattern of 16 lanes.
void mask_of_bits(const Go& go) {
  constexpr std::uint32_t kPattern = 0xb38du;
  go.put(0, mask_from_bits(kPattern >> (go.at & 15) & ((1u << kLanes) - 1u)));
}

void update(const Go& go) {
  F a = go.f(0);
  a += go.f(1);
  go.put(0, a);
  a = go.f(0);
  a -= go.f(1);
  go.put(1, a);
  a = go.f(0);
  a *= go.f(1);
  go.put(2, a);
}

// Reductions over sixteen elements at a time, of numbers only: with NaN, and in a zero's sign, results may
// differ.
template <float (*kReduce)(F), F (*kCombine)(F, F)>
void reduce_sixteen(const Bits* const* in, Bits* const* out, int count) {
  for (int block = 0; block < count; block += 16) {
    F sum = F(1.0f);
    for (int at = block; at < block + 16; at += kLanes) {
      const F value = Go{in, out, at}.f(0);
      sum = kCombine(sum, select(value == value, value, F(1.0f)));
    }
    const float result = kReduce(sum) + 0.0f;
    for (int at = block; at < block + 16; ++at) __builtin_memcpy(&out[0][at], &result, sizeof(result));
  }
}

constexpr bool kMoves = false, kComputes = true;

constexpr WideCase kCases[] = {
    {"aligned load and store", 1, 2, kMoves, run<load_store_aligned>},
    {"bits(mask)", 2, 1, kMoves, run<mask_bits>},
    {"mask_from_bits", 0, 1, kMoves, run<mask_of_bits>},
    SCREE_CASE("lane_numbers", 0, 1, kMoves, go.put(0, lane_numbers() + I(go.at))),
    // Floats.
    SCREE_CASE("a + b", 2, 1, kComputes, go.put(0, go.f(0) + go.f(1))),
    SCREE_CASE("a - b", 2, 1, kComputes, go.put(0, go.f(0) - go.f(1))),
    SCREE_CASE("a * b", 2, 1, kComputes, go.put(0, go.f(0) * go.f(1))),
    SCREE_CASE("a / b", 2, 1, kComputes, go.put(0, go.f(0) / go.f(1))),
    SCREE_CASE("sqrt", 1, 1, kComputes, go.put(0, sqrt(go.f(0)))),
    {"+= -= *=", 2, 3, kComputes, run<update>},
    SCREE_CASE("a * b + c", 3, 1, kComputes, go.put(0, go.f(0) * go.f(1) + go.f(2))),
    SCREE_CASE("a * b - c", 3, 1, kComputes, go.put(0, go.f(0) * go.f(1) - go.f(2))),
    SCREE_CASE("-a", 1, 1, kMoves, go.put(0, -go.f(0))),
    SCREE_CASE("abs", 1, 1, kMoves, go.put(0, abs(go.f(0)))),
    SCREE_CASE("copy_sign", 2, 1, kMoves, go.put(0, copy_sign(go.f(0), go.f(1)))),
    SCREE_CASE("min", 2, 1, kMoves, go.put(0, min(go.f(0), go.f(1)))),
    SCREE_CASE("max", 2, 1, kMoves, go.put(0, max(go.f(0), go.f(1)))),
    SCREE_CASE("clamp", 3, 1, kMoves, go.put(0, clamp(go.f(0), go.f(1), go.f(2)))),
    SCREE_CASE("a < b", 2, 1, kMoves, go.put(0, go.f(0) < go.f(1))),
    SCREE_CASE("a <= b", 2, 1, kMoves, go.put(0, go.f(0) <= go.f(1))),
    SCREE_CASE("a > b", 2, 1, kMoves, go.put(0, go.f(0) > go.f(1))),
    SCREE_CASE("a >= b", 2, 1, kMoves, go.put(0, go.f(0) >= go.f(1))),
    SCREE_CASE("a == b", 2, 1, kMoves, go.put(0, go.f(0) == go.f(1))),
    SCREE_CASE("select floats", 4, 1, kMoves, go.put(0, select(go.f(0) < go.f(1), go.f(2), go.f(3)))),
    {"reduce_min", 1, 1, kMoves, reduce_sixteen<reduce_min, min>},
    {"reduce_max", 1, 1, kMoves, reduce_sixteen<reduce_max, max>},
    SCREE_CASE("broadcast", 0, 3, kMoves, go.put(0, V3{F(-0.0f), F(1e-45f), F(3.0f)})),
    // Integers and masks.
    SCREE_CASE("i + j", 2, 1, kMoves, go.put(0, go.i(0) + go.i(1))),
    SCREE_CASE("i - j", 2, 1, kMoves, go.put(0, go.i(0) - go.i(1))),
    SCREE_CASE("i & j", 2, 1, kMoves, go.put(0, go.i(0) & go.i(1))),
    SCREE_CASE("i | j", 2, 1, kMoves, go.put(0, go.i(0) | go.i(1))),
    SCREE_CASE("i ^ j", 2, 1, kMoves, go.put(0, go.i(0) ^ go.i(1))),
    SCREE_CASE("i == j", 2, 1, kMoves, go.put(0, go.i(0) == go.i(1))),
    SCREE_CASE("i < j", 2, 1, kMoves, go.put(0, go.i(0) < go.i(1))),
    SCREE_CASE("i > j", 2, 1, kMoves, go.put(0, go.i(0) > go.i(1))),
    SCREE_CASE("shift_left<1>", 1, 1, kMoves, go.put(0, shift_left<1>(go.i(0)))),
    SCREE_CASE("shift_left<31>", 1, 1, kMoves, go.put(0, shift_left<31>(go.i(0)))),
    SCREE_CASE("shift_right<1>", 1, 1, kMoves, go.put(0, shift_right<1>(go.i(0)))),
    SCREE_CASE("shift_right<31>", 1, 1, kMoves, go.put(0, shift_right<31>(go.i(0)))),
    SCREE_CASE("to_float", 1, 1, kMoves, go.put(0, to_float(go.i(0)))),
    SCREE_CASE("select integers", 4, 1, kMoves, go.put(0, select(go.f(0) < go.f(1), go.i(2), go.i(3)))),
    SCREE_CASE("m & n", 4, 1, kMoves, go.put(0, (go.f(0) < go.f(1)) & (go.i(2) > go.i(3)))),
    SCREE_CASE("m | n", 4, 1, kMoves, go.put(0, (go.f(0) < go.f(1)) | (go.i(2) == go.i(3)))),
    SCREE_CASE("!m", 2, 1, kMoves, go.put(0, !(go.f(0) <= go.f(1)))),
    // Vectors, rotations, matrices.
    SCREE_CASE("V3 + V3", 6, 3, kComputes, go.put(0, go.v(0) + go.v(3))),
    SCREE_CASE("V3 - V3", 6, 3, kComputes, go.put(0, go.v(0) - go.v(3))),
    SCREE_CASE("-V3", 3, 3, kMoves, go.put(0, -go.v(0))),
    SCREE_CASE("V3 * s", 4, 3, kComputes, go.put(0, go.v(0) * go.f(3))),
    SCREE_CASE("s * V3", 4, 3, kComputes, go.put(0, go.f(3) * go.v(0))),
    SCREE_CASE("dot", 6, 1, kComputes, go.put(0, dot(go.v(0), go.v(3)))),
    SCREE_CASE("cross", 6, 3, kComputes, go.put(0, cross(go.v(0), go.v(3)))),
    SCREE_CASE("select V3", 8, 3, kMoves, go.put(0, select(go.f(0) < go.f(1), go.v(2), go.v(5)))),
    SCREE_CASE("length_squared", 3, 1, kComputes, go.put(0, length_squared(go.v(0)))),
    SCREE_CASE("length", 3, 1, kComputes, go.put(0, length(go.v(0)))),
    SCREE_CASE("S3 * V3", 9, 3, kComputes, go.put(0, go.s(0) * go.v(6))),
    SCREE_CASE("Q4 * Q4", 8, 4, kComputes, go.put(0, go.q(0) * go.q(4))),
    SCREE_CASE("conjugate", 4, 4, kMoves, go.put(0, conjugate(go.q(0)))),
    SCREE_CASE("normalize", 4, 4, kComputes, go.put(0, normalize(go.q(0)))),
    SCREE_CASE("rotate", 7, 3, kComputes, go.put(0, rotate(go.q(0), go.v(4)))),
    SCREE_CASE("rotate_back", 7, 3, kComputes, go.put(0, rotate_back(go.q(0), go.v(4)))),
    SCREE_CASE("to_matrix", 4, 9, kComputes, go.put(0, to_matrix(go.q(0)))),
    SCREE_CASE("M3 * V3", 12, 3, kComputes, go.put(0, go.m(0) * go.v(9))),
    SCREE_CASE("multiply_transposed", 12, 3, kComputes, go.put(0, multiply_transposed(go.m(0), go.v(9)))),
    SCREE_CASE("rotate S3", 15, 6, kComputes, go.put(0, rotate(go.m(0), go.s(9)))),
    SCREE_CASE("tangent_of", 3, 3, kComputes, go.put(0, tangent_of(go.v(0)))),
    // Angles.
    SCREE_CASE("atan2", 2, 1, kComputes, go.put(0, atan2(go.f(0), go.f(1)))),
    SCREE_CASE("rotation_vector", 4, 3, kComputes, go.put(0, rotation_vector(go.q(0)))),
    SCREE_CASE("rotation_by", 3, 4, kComputes, go.put(0, rotation_by(go.v(0)))),
    SCREE_CASE("twist_angle", 4, 1, kComputes, go.put(0, twist_angle(go.q(0)))),
    SCREE_CASE("shorter_way", 1, 1, kComputes, go.put(0, shorter_way(go.f(0)))),
    SCREE_CASE("invert_semidefinite", 6, 6, kComputes, go.put(0, invert_semidefinite(go.s(0)))),
};

constexpr int kRows = 16;

int count_here(int count, int at) {
  const int left = count - at;
  return left < 0 ? 0 : left > kLanes ? kLanes : left;
}

void load_sixteen(const float* base, int stride, const std::int32_t* index, float* const* out) {
  for (int at = 0; at < kRows; at += kLanes) {
    F x, y, z, w;
    load_rows(base, stride, index + at, x, y, z, w);
    store_unaligned(out[0] + at, x);
    store_unaligned(out[1] + at, y);
    store_unaligned(out[2] + at, z);
    store_unaligned(out[3] + at, w);
  }
}

// Row i has its index in the second of three columns.
void load_sixteen_triples(const float* base, const std::int32_t* index, float* const* out) {
  std::int32_t table[kRows][3]{};
  for (int i = 0; i < kRows; ++i) table[i][1] = index[i];
  for (int at = 0; at < kRows; at += kLanes) {
    F x, y, z;
    load_triples(base, &table[at][1], 3, x, y, z);
    store_unaligned(out[0] + at, x);
    store_unaligned(out[1] + at, y);
    store_unaligned(out[2] + at, z);
  }
}

void store_sixteen(float* base, int stride, const std::int32_t* index, int count, const float* const* in) {
  for (int at = 0; at < kRows; at += kLanes) {
    store_rows(base, stride, index + at, count_here(count, at), load_unaligned(in[0] + at),
               load_unaligned(in[1] + at), load_unaligned(in[2] + at), load_unaligned(in[3] + at));
  }
}

void store_sixteen_pairs(float* base, int stride, const std::int32_t* index, int count,
                         const float* const* in) {
  for (int at = 0; at < kRows; at += kLanes) {
    store_row_pairs(base, stride, index + at, count_here(count, at), load_unaligned(in[0] + at),
                    load_unaligned(in[1] + at));
  }
}

void load_sixteen_long(const float* base, const std::int32_t* index, float* const* out) {
  for (int at = 0; at < kRows; at += kLanes) {
    F column[8];
    load_rows8(base, index + at, column);
    for (int k = 0; k < 8; ++k) store_unaligned(out[k] + at, column[k]);
  }
}

void store_sixteen_long(float* base, const std::int32_t* index, int count, const float* const* in) {
  for (int at = 0; at < kRows; at += kLanes) {
    F column[8];
    for (int k = 0; k < 8; ++k) column[k] = load_unaligned(in[k] + at);
    store_rows8(base, index + at, count_here(count, at), column);
  }
}

}  // namespace

WideCases wide_cases() {
  return {kLanes,
          static_cast<int>(sizeof(kCases) / sizeof(kCases[0])),
          kCases,
          load_sixteen,
          load_sixteen_triples,
          store_sixteen,
          store_sixteen_pairs,
          load_sixteen_long,
          store_sixteen_long};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
