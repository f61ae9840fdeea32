// The order of pairs: ascending by the shape of lower index, then by the other.
#pragma once

#include <core/world/world_data.h>

#include <cstdint>

namespace scree {

inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }

inline std::uint64_t key_of(const ShapePair& pair) {
  return pair_key(static_cast<std::uint32_t>(pair.a), static_cast<std::uint32_t>(pair.b));
}
inline std::uint64_t key_of(const TouchRow& row) {
  return pair_key(row.pair.shape_a.index, row.pair.shape_b.index);
}

inline bool comes_before(const ShapePair& x, const ShapePair& y) { return key_of(x) < key_of(y); }

}  // namespace scree
