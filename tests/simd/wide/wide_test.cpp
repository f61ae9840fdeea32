// Laws of the wide numbers: every instruction set gives the bits of the scalar one, for every kind of number.
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "wide_cases.h"

namespace scree::simd {
namespace {

constexpr int kRows = 16;

std::vector<WideCases> wide_sets() {
  std::vector<WideCases> sets;
#if SCREE_HAS_SSE2
  if (find_kernels(InstructionSet::sse2) != nullptr) sets.push_back(sse2::wide_cases());
#endif
#if SCREE_HAS_AVX2
  if (find_kernels(InstructionSet::avx2) != nullptr) sets.push_back(avx2::wide_cases());
#endif
#if SCREE_HAS_AVX512
  if (find_kernels(InstructionSet::avx512) != nullptr) sets.push_back(avx512::wide_cases());
#endif
  return sets;
}

// Signed zeros, denormals, the ends of the ranges of floats and integers, infinities, quiet and signaling
// NaNs of both signs with payloads, and values where conversion and rounding decide.
constexpr Bits kSpecial[] = {
    0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff, 0x807fffff, 0x00400000, 0x00800000,
    0x80800000, 0x00800001, 0x3f800000, 0xbf800000, 0x3f7fffff, 0x3f800001, 0x40000000, 0xc0400000,
    0x3eaaaaab, 0x42280000, 0x4b7fffff, 0x4b800001, 0x4effffff, 0x4f000000, 0xcf000000, 0x7f7fffff,
    0xff7fffff, 0x7f000000, 0x7f800000, 0xff800000, 0x7fc00000, 0xffc00000, 0x7fc12345, 0xffc54321,
    0x7fffffff, 0xffffffff, 0x7f800001, 0xff812345, 0x7fa00000, 0x01000001, 0x01000003, 0xff000001};

// xorshift32 (Marsaglia 2003).
class Random {
 public:
  Bits next() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return state_;
  }
  float between(float low, float high) {
    return low + (high - low) * static_cast<float>(next() >> 8) / 16777216.0f;
  }

 private:
  Bits state_ = 2463534242u;
};

using Columns = std::vector<std::vector<Bits>>;

// All pairs of special numbers, then numbers of every kind, mixed more and more with ordinary ones.
Columns inputs_of(const WideCase& wide_case) {
  constexpr int kSpecials = static_cast<int>(std::size(kSpecial));
  constexpr int kMixed = 8192;
  Columns columns(static_cast<std::size_t>(wide_case.inputs));
  Random random;
  for (std::size_t column = 0; column < columns.size(); ++column) {
    std::vector<Bits>& values = columns[column];
    for (int i = 0; i < kSpecials * kSpecials; ++i) {
      values.push_back(kSpecial[column % 2 == 0 ? i % kSpecials : i / kSpecials]);
    }
    for (int i = 0; i < kMixed; ++i) {
      const Bits dice = random.next() % kMixed;
      values.push_back(dice > static_cast<Bits>(2 * i) ? kSpecial[random.next() % kSpecials]
                       : dice > static_cast<Bits>(i)   ? random.next()
                                                       : std::bit_cast<Bits>(random.between(-4.0f, 4.0f)));
    }
    static_assert((kSpecials * kSpecials + kMixed) % kRows == 0);
  }
  return columns;
}

Columns run(const WideCase& wide_case, const Columns& inputs) {
  const std::size_t count = inputs.empty() ? kRows : inputs[0].size();
  Columns outputs(static_cast<std::size_t>(wide_case.outputs), std::vector<Bits>(count));
  std::vector<const Bits*> in;
  std::vector<Bits*> out;
  for (const std::vector<Bits>& column : inputs) in.push_back(column.data());
  for (std::vector<Bits>& column : outputs) out.push_back(column.data());
  wide_case.run(in.data(), out.data(), static_cast<int>(count));
  return outputs;
}

bool is_nan(Bits bits) { return (bits & 0x7fffffffu) > 0x7f800000u; }

const WideCase& scalar_case(const std::string& name) {
  const WideCases set = scalar::wide_cases();
  const WideCase* end = set.cases + set.count;
  return *std::find_if(set.cases, end, [&](const WideCase& wide_case) { return name == wide_case.name; });
}

float as_float(Bits bits) { return std::bit_cast<float>(bits); }

TEST(Wide, EveryOperationGivesTheScalarBitsOnEveryInstructionSet) {
  const WideCases oracle = scalar::wide_cases();
  for (const WideCases& set : wide_sets()) {
    ASSERT_EQ(set.count, oracle.count);
    for (int i = 0; i < set.count; ++i) {
      const WideCase& wide_case = set.cases[i];
      ASSERT_STREQ(wide_case.name, oracle.cases[i].name);
      const Columns inputs = inputs_of(wide_case);
      const Columns expected = run(oracle.cases[i], inputs);
      const Columns results = run(wide_case, inputs);
      int different = 0;
      for (std::size_t output = 0; output < results.size(); ++output) {
        for (std::size_t at = 0; at < results[output].size(); ++at) {
          const Bits want = expected[output][at], got = results[output][at];
          if (want == got || (wide_case.computes && is_nan(want) && is_nan(got))) continue;
          if (++different > 3) continue;
          ADD_FAILURE() << wide_case.name << ", " << set.lanes << " lanes, output " << output << ", element "
                        << at << std::hex << ": scalar " << want << ", wide " << got << ", first input "
                        << (inputs.empty() ? 0u : inputs[0][at]);
        }
      }
      EXPECT_EQ(different, 0) << wide_case.name << ", " << set.lanes << " lanes";
    }
  }
}

TEST(Wide, LanesAreWhatTheKernelsSay) {
  EXPECT_EQ(scalar::wide_cases().lanes, find_kernels(InstructionSet::scalar)->lanes);
#if SCREE_HAS_SSE2
  EXPECT_EQ(sse2::wide_cases().lanes, 4);
#endif
#if SCREE_HAS_AVX2
  EXPECT_EQ(avx2::wide_cases().lanes, 8);
#endif
}

TEST(Wide, NegationAndAbsoluteValueTouchTheSignBitOnly) {
  const WideCase& negate = scalar_case("-a");
  const WideCase& absolute = scalar_case("abs");
  const Columns inputs = inputs_of(negate);
  const Columns negated = run(negate, inputs), positive = run(absolute, inputs);
  for (std::size_t at = 0; at < inputs[0].size(); ++at) {
    EXPECT_EQ(negated[0][at], inputs[0][at] ^ 0x80000000u);
    EXPECT_EQ(positive[0][at], inputs[0][at] & 0x7fffffffu);
  }
}

TEST(Wide, MinAndMaxTakeTheSecondOperandWhereNeitherIsLess) {
  const WideCase& smaller = scalar_case("min");
  const WideCase& larger = scalar_case("max");
  const Columns inputs = inputs_of(smaller);
  const Columns minima = run(smaller, inputs), maxima = run(larger, inputs);
  for (std::size_t at = 0; at < inputs[0].size(); ++at) {
    const Bits a = inputs[0][at], b = inputs[1][at];
    EXPECT_EQ(minima[0][at], as_float(a) < as_float(b) ? a : b);
    EXPECT_EQ(maxima[0][at], as_float(a) > as_float(b) ? a : b);
  }
}

TEST(Wide, ProductsAndSumsRoundSeparately) {
  // (1 + e)(1 - e) - 1 is -e^2 when fused, 0 when the product is rounded first.
  const float e = std::numeric_limits<float>::epsilon();
  const Columns inputs = {std::vector<Bits>(kRows, std::bit_cast<Bits>(1 + e)),
                          std::vector<Bits>(kRows, std::bit_cast<Bits>(1 - e)),
                          std::vector<Bits>(kRows, std::bit_cast<Bits>(1.0f))};
  std::vector<WideCases> sets = wide_sets();
  sets.push_back(scalar::wide_cases());
  for (const WideCases& set : sets) {
    for (int i = 0; i < set.count; ++i) {
      if (std::string("a * b - c") != set.cases[i].name) continue;
      const Columns results = run(set.cases[i], inputs);
      for (const Bits result : results[0]) EXPECT_EQ(result, 0u) << set.lanes << " lanes";
    }
  }
}

// A table of rows, larger than any test indexes, whose every float tells where it was.
std::vector<float> table_of(int floats) {
  std::vector<float> table(static_cast<std::size_t>(floats) + 4);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i) + 0.5f;
  return table;
}
float* aligned(std::vector<float>& table, std::uintptr_t bytes = 16) {
  return reinterpret_cast<float*>((reinterpret_cast<std::uintptr_t>(table.data()) + bytes - 1) / bytes *
                                  bytes);
}

constexpr std::int32_t kIndex[kRows] = {3, 0, 17, 5, 31, 1, 2, 30, 8, 9, 4, 25, 24, 11, 19, 7};
constexpr int kTableRows = 32;

TEST(Wide, RowsAreLoadedLaneByLane) {
  std::vector<WideCases> sets = wide_sets();
  sets.push_back(scalar::wide_cases());
  for (const WideCases& set : sets) {
    for (const int stride : {4, 8, 12}) {
      std::vector<float> table = table_of(kTableRows * stride);
      const float* base = aligned(table);
      std::array<std::array<float, kRows>, 4> results{};
      float* const out[] = {results[0].data(), results[1].data(), results[2].data(), results[3].data()};
      set.load_rows(base, stride, kIndex, out);
      for (int lane = 0; lane < kRows; ++lane) {
        for (int k = 0; k < 4; ++k) {
          EXPECT_EQ(out[k][lane], base[kIndex[lane] * stride + k]) << set.lanes << " lanes";
        }
      }
    }
  }
}

TEST(Wide, TriplesAreLoadedLaneByLaneFromAnywhere) {
  std::vector<WideCases> sets = wide_sets();
  sets.push_back(scalar::wide_cases());
  for (const WideCases& set : sets) {
    const std::vector<float> table = table_of(kTableRows * 3 + 4);
    std::array<std::array<float, kRows>, 3> results{};
    float* const out[] = {results[0].data(), results[1].data(), results[2].data()};
    for (const int from : {0, 1}) {
      set.load_triples(table.data() + from, kIndex, out);
      for (int lane = 0; lane < kRows; ++lane) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_EQ(out[k][lane], table[static_cast<std::size_t>(kIndex[lane] * 3 + k + from)])
              << set.lanes << " lanes";
        }
      }
    }
  }
}

TEST(Wide, RowsAreStoredForTheFirstLanesAndNothingElseIsTouched) {
  std::vector<WideCases> sets = wide_sets();
  sets.push_back(scalar::wide_cases());
  std::array<std::array<float, kRows>, 4> values{};
  for (int k = 0; k < 4; ++k) {
    for (int lane = 0; lane < kRows; ++lane) {
      values[static_cast<std::size_t>(k)][static_cast<std::size_t>(lane)] =
          -static_cast<float>(lane * 4 + k + 1);
    }
  }
  const float* const in[] = {values[0].data(), values[1].data(), values[2].data(), values[3].data()};
  for (const WideCases& set : sets) {
    for (const int width : {4, 2}) {
      for (const int stride : {4, 8, 12}) {
        for (int count = 0; count <= kRows; ++count) {
          std::vector<float> table = table_of(kTableRows * stride);
          std::vector<float> expected = table;
          float* base = aligned(table);
          const auto offset = static_cast<std::size_t>(base - table.data());
          for (int lane = 0; lane < count; ++lane) {
            for (int k = 0; k < width; ++k) {
              expected[offset + static_cast<std::size_t>(kIndex[lane] * stride + k)] = in[k][lane];
            }
          }
          (width == 4 ? set.store_rows : set.store_row_pairs)(base, stride, kIndex, count, in);
          EXPECT_EQ(table, expected) << set.lanes << " lanes, " << width << " floats, " << count << " rows";
        }
      }
    }
  }
}

TEST(Wide, LongRowsAreLoadedAndStoredLikeShortOnes) {
  std::vector<WideCases> sets = wide_sets();
  sets.push_back(scalar::wide_cases());
  std::array<std::array<float, kRows>, 8> columns{};
  float* out[8];
  for (std::size_t k = 0; k < 8; ++k) out[k] = columns[k].data();
  for (const WideCases& set : sets) {
    std::vector<float> source = table_of(kTableRows * 8 + 4);
    const float* from = aligned(source, 32);
    set.load_rows8(from, kIndex, out);
    for (int lane = 0; lane < kRows; ++lane) {
      for (int k = 0; k < 8; ++k) {
        EXPECT_EQ(out[k][lane], from[kIndex[lane] * 8 + k]) << set.lanes << " lanes";
        out[k][lane] = -static_cast<float>(lane * 8 + k + 1);
      }
    }
    for (int count = 0; count <= kRows; ++count) {
      std::vector<float> table = table_of(kTableRows * 8 + 4);
      std::vector<float> expected = table;
      float* base = aligned(table, 32);
      const auto offset = static_cast<std::size_t>(base - table.data());
      for (int lane = 0; lane < count; ++lane) {
        for (int k = 0; k < 8; ++k) {
          expected[offset + static_cast<std::size_t>(kIndex[lane] * 8 + k)] = out[k][lane];
        }
      }
      set.store_rows8(base, kIndex, count, out);
      EXPECT_EQ(table, expected) << set.lanes << " lanes, " << count << " rows";
    }
  }
}

TEST(WideMath, TangentsArePerpendicularUnitVectors) {
  Columns normals(3);
  const auto add = [&](double x, double y, double z) {
    const double length = std::sqrt(x * x + y * y + z * z);
    const double unit[] = {x / length, y / length, z / length};
    for (std::size_t k = 0; k < 3; ++k)
      normals[k].push_back(std::bit_cast<Bits>(static_cast<float>(unit[k])));
  };
  for (const double s : {1.0, -1.0}) {
    add(s, 0, 0), add(0, s, 0), add(0, 0, s), add(s, s, 0), add(s, 0, -0.0), add(1e-4, 1e-4, s),
        add(s, 1e-7, -1e-7), add(1e-20, 0, s);
  }
  Random random;
  while (normals[0].size() < 4096) {
    add(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  }
  const Columns tangents = run(scalar_case("tangent_of"), normals);
  for (std::size_t i = 0; i < normals[0].size(); ++i) {
    double square = 0, projection = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double t = as_float(tangents[k][i]), n = as_float(normals[k][i]);
      square += t * t;
      projection += t * n;
    }
    EXPECT_NEAR(square, 1.0, 1e-6);
    EXPECT_NEAR(projection, 0.0, 1e-6);
  }
}

TEST(WideMath, ARotationAndItsMatrixAgreeAndAreUndoneByTheInverse) {
  Random random;
  Columns in(7);
  for (int i = 0; i < 4096; ++i) {
    double q[4], square = 0;
    for (double& component : q) {
      component = random.between(-1, 1);
      square += component * component;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      in[k].push_back(std::bit_cast<Bits>(static_cast<float>(q[k] / std::sqrt(square))));
    }
    for (std::size_t k = 4; k < 7; ++k) in[k].push_back(std::bit_cast<Bits>(random.between(-1, 1)));
  }
  const Columns rotations(in.begin(), in.begin() + 4);
  const Columns turned = run(scalar_case("rotate"), in);
  Columns by_matrix = run(scalar_case("to_matrix"), rotations);
  by_matrix.insert(by_matrix.end(), in.begin() + 4, in.end());
  const Columns multiplied = run(scalar_case("M3 * V3"), by_matrix);
  Columns back = rotations;
  back.insert(back.end(), turned.begin(), turned.end());
  const Columns restored = run(scalar_case("rotate_back"), back);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < in[0].size(); ++i) {
      EXPECT_NEAR(as_float(turned[k][i]), as_float(multiplied[k][i]), 1e-6f);
      EXPECT_NEAR(as_float(restored[k][i]), as_float(in[k + 4][i]), 1e-6f);
    }
  }
}

}  // namespace
}  // namespace scree::simd
