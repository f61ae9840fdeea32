// Exact sums of the moments of mass; see mass_moments.h. Twofold arithmetic: Dekker, "A floating-point
// technique for extending the available precision", 1971.
#include <core/world/mass_moments.h>

#include <algorithm>
#include <bit>

namespace scree {

namespace {

Twofold sum_of(double a, double b) {
  const double sum = a + b;
  const double from_b = sum - a;
  return {sum, (a - (sum - from_b)) + (b - from_b)};
}

// Of a pair whose second is small beside the first.
Twofold joined(double high, double low) {
  const double sum = high + low;
  return {sum, low - (sum - high)};
}

// 2^exponent of a normal double.
double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

// Exact, as the halves' products fit into a double.
Twofold product_of(double a, double b) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const auto upper_half = [](double value) {
    const double scaled = kSplit * value;
    return scaled - (scaled - value);
  };
  const double product = a * b;
  const double a_high = upper_half(a), b_high = upper_half(b);
  const double a_low = a - a_high, b_low = b - b_high;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

Twofold negative(Twofold a) { return {-a.high, -a.low}; }

Twofold operator+(Twofold a, Twofold b) {
  const Twofold high = sum_of(a.high, b.high), low = sum_of(a.low, b.low);
  const Twofold sum = joined(high.high, high.low + low.high);
  return joined(sum.high, sum.low + low.low);
}

Twofold operator-(Twofold a, Twofold b) { return a + negative(b); }

Twofold operator*(Twofold a, Twofold b) {
  const Twofold product = product_of(a.high, b.high);
  return joined(product.high, product.low + (a.high * b.low + a.low * b.high));
}

// Digit by digit.
Twofold operator/(Twofold a, Twofold b) {
  const double first = a.high / b.high;
  Twofold rest = a - b * Twofold{first};
  const double second = rest.high / b.high;
  rest = rest - b * Twofold{second};
  const Twofold sum = joined(first, second);
  return joined(sum.high, sum.low + rest.high / b.high);
}

}  // namespace

void ExactSum::add(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  constexpr int kMantissaBits = 52, kBias = 1075;  // of the exponent of the mantissa's lowest bit
  const int exponent = static_cast<int>(bits >> kMantissaBits & 0x7ff);
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << kMantissaBits) - 1);
  if (exponent > 0) mantissa |= std::uint64_t{1} << kMantissaBits;
  int shift = std::max(exponent, 1) - kBias - kLowestExponent;
  if (shift < 0) {
    mantissa = shift > -64 ? mantissa >> -shift : 0;
    shift = 0;
  }
  const int first = shift / 64, offset = shift % 64;
  if (first >= kWords) return;  // cannot happen, see kLowestExponent
  const std::uint64_t part[2] = {mantissa << offset, offset > 0 ? mantissa >> (64 - offset) : 0};
  const bool negative = (bits >> 63) != 0;
  std::uint64_t carry = 0;
  for (int i = first; i < kWords && (i < first + 2 || carry != 0); ++i) {
    const std::uint64_t more = i < first + 2 ? part[i - first] : 0, old = word_[i];
    if (negative) {
      word_[i] = old - more - carry;
      carry = old < more || (old == more && carry != 0) ? 1 : 0;
    } else {
      word_[i] = old + more + carry;
      carry = word_[i] < old || (word_[i] == old && carry != 0) ? 1 : 0;
    }
  }
}

Twofold ExactSum::value() const {
  std::uint64_t magnitude[kWords];
  const bool negative = word_[kWords - 1] >> 63 != 0;
  std::uint64_t carry = negative ? 1 : 0;
  for (int i = 0; i < kWords; ++i) {
    magnitude[i] = (negative ? ~word_[i] : word_[i]) + carry;
    carry = carry != 0 && magnitude[i] == 0 ? 1 : 0;
  }
  int top = kWords - 1;
  while (top > 0 && magnitude[top] == 0) --top;
  // Halves of words are exact doubles; what is below the top three words is below 128 bits.
  Twofold sum;
  for (int i = top; i >= std::max(top - 2, 0); --i) {
    for (const int offset : {32, 0}) {
      const auto digits = static_cast<double>(magnitude[i] >> offset & 0xffffffffu);
      const Twofold more = sum_of(sum.high, digits * power_of_two(64 * i + offset + kLowestExponent));
      sum = joined(more.high, sum.low + more.low);
    }
  }
  return negative ? Twofold{-sum.high, -sum.low} : sum;
}

void MassMoments::change(const MassSum& part, double sign) {
  constexpr int kAxes[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
  parts_ += sign > 0.0 ? 1 : -1;
  const double mass = sign * part.mass;
  mass_.add(mass);
  Twofold moment[3];
  for (int i = 0; i < 3; ++i) {
    moment[i] = product_of(mass, part.center[i]);
    first_[i].add(moment[i]);
  }
  for (int i = 0; i < 6; ++i) {
    const Twofold along = moment[kAxes[i][0]];
    const double other = part.center[kAxes[i][1]];
    second_[i].add(product_of(along.high, other));
    second_[i].add(product_of(along.low, other));
    own_inertia_[i].add(sign * part.inertia.m[i]);
  }
}

// About the center the second moment is less by mass times center times center, which takes more digits than
// a double has: parts may lie far from the body's origin.
MassSum MassMoments::sum() const {
  MassSum sum;
  const Twofold mass = mass_.value();
  if (!(mass.high > 0.0)) return sum;
  sum.mass = mass.high;
  Twofold moment[3], center[3], own[6], second[6];
  for (int i = 0; i < 3; ++i) {
    moment[i] = first_[i].value();
    center[i] = moment[i] / mass;
    sum.center[i] = center[i].high;
  }
  constexpr int kAxes[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
  for (int i = 0; i < 6; ++i) {
    own[i] = own_inertia_[i].value();
    second[i] = second_[i].value() - moment[kAxes[i][0]] * center[kAxes[i][1]];
  }
  const Twofold inertia[6] = {
      own[XX] + (second[YY] + second[ZZ]), own[XY] - second[XY], own[XZ] - second[XZ],
      own[YY] + (second[XX] + second[ZZ]), own[YZ] - second[YZ], own[ZZ] + (second[XX] + second[YY])};
  for (int i = 0; i < 6; ++i) sum.inertia.m[i] = inertia[i].high;
  return sum;
}

}  // namespace scree
