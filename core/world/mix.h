// Scrambles the bits of a number: where an order or a choice must look random and be the same everywhere.
#pragma once

#include <cstdint>

namespace scree {

/// The finalizer of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators",
/// 2014): a bijection in which each bit of the result depends on all bits of the argument.
inline constexpr std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
  return bits ^ (bits >> 31);
}

}  // namespace scree
