// The mark of materials that give the radius of their patch: who has none, as nearly all, is spared reading
// it.
#pragma once

#include <core/plain/rows.h>

namespace scree {

enum MaterialPatchFlag : std::uint32_t { kMaterialPatch = 1 << 17 };  // in MaterialRow::rules

}  // namespace scree
