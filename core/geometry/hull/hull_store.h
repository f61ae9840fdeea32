// The hulls of a world: one slot for all shapes of the same hull, scale and rounding.
#pragma once

#include <core/world/check.h>
#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace scree {

// A hull for a slot; `solid` has the scale in it. Throws std::bad_alloc.
SharedHull shared_hull(const ConvexHull& geometry, std::shared_ptr<const HullSolid> solid);
// Counts one more shape for the slot of a hull, and makes the slot if there is none. Returns the slot, or -1
// for other geometries. Throws if the scaled hull exceeds a limit, and then changes nothing. The geometry
// must have been checked. content_slots.h releases slots.
std::int32_t acquire_hull(Call call, Hulls& hulls, const Geometry& geometry);
// Hash of hull, scale and rounding, never 0.
std::uint64_t hull_content(const ConvexHull& geometry);
ExtentRow extent_of(const SharedHull& hull);
std::size_t hull_bytes(const SharedHulls& hulls);  // of the geometry that the slots share

}  // namespace scree
