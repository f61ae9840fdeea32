// The order of pairs: ascending by the shape of lower index, then by the other.
#pragma once

#include <core/plain/rows.h>

#include <cstdint>

namespace scree {

inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }

inline std::uint64_t key_of(const ShapePair& pair) {
  return pair_key(static_cast<std::uint32_t>(pair.a), static_cast<std::uint32_t>(pair.b));
}

}  // namespace scree
