// Numbers that the files of movers share.
#pragma once

#include <cstddef>

namespace scree::mover {

inline constexpr std::size_t kMostTouched = 12;  // shapes around a mover that count, the nearest
inline constexpr std::size_t kMostMet = 6;       // shapes met on one way
// Each of them holds a displacement as it is, and some a second time as a wall.
inline constexpr std::size_t kMostPlanes = 2 * (kMostTouched + kMostMet);

}  // namespace scree::mover
