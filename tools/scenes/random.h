// The random numbers of scenes: the same bits on every machine, compiler and standard library.
#pragma once

#include <core/world/mix.h>
#include <scree/math_types.h>

#include <cmath>
#include <cstdint>

namespace scree::scenes {

/// SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014): a 64-bit counter
/// that advances by the golden ratio and is scrambled by two multiplications. Integer arithmetic alone.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() { return mixed(state_ += 0x9e3779b97f4a7c15u); }

  /// In [0, 1): the upper 24 bits, which a float holds exactly.
  float unit() { return static_cast<float>(next() >> 40) * 0x1p-24f; }

  /// In [low, high].
  float between(float low, float high) { return low + (high - low) * unit(); }

  /// In [0, count). The bias of the remainder is below count / 2^64.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(next() % count); }

  /// Every orientation alike: a point drawn in the cube until it lies in the 4-ball, then brought to
  /// length 1.
  Quat rotation() {
    for (;;) {
      const Quat q{between(-1.0f, 1.0f), between(-1.0f, 1.0f), between(-1.0f, 1.0f), between(-1.0f, 1.0f)};
      const float square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
      // Short ones are drawn again too: their direction has too few bits.
      if (square > 1.0f || square < 0.01f) continue;
      const float scale = 1.0f / std::sqrt(square);
      return {q.x * scale, q.y * scale, q.z * scale, q.w * scale};
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace scree::scenes
