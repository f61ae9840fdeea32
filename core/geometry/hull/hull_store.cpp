// See hull_store.h.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/hull/hull_store.h>
#include <core/world/content_slots.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace scree {

SharedHull shared_hull(const ConvexHull& geometry, std::shared_ptr<const HullSolid> solid) {
  SharedHull shared{geometry, std::move(solid), nullptr};
  const HullData* const within = shared.solid->columns.data;
  if (geometry.rounding > 0.0f) {
    HullData rounded = *within;
    rounded.rounding = geometry.rounding;
    shared.data = std::make_shared<const HullData>(rounded);
  } else {
    shared.data = {shared.solid, within};
  }
  return shared;
}

std::int32_t acquire_hull(Call call, Hulls& hulls, const Geometry& geometry) {
  const auto* convex = std::get_if<ConvexHull>(&geometry);
  if (convex == nullptr) return -1;
  const std::uint64_t content = hull_content(*convex);
  const auto is_same = [convex](const SharedHull& shared) { return shared.geometry == *convex; };
  if (const std::int32_t slot = find_slot(hulls, content, is_same); slot >= 0) {
    ++hulls.shapes[slot];
    return slot;
  }
  std::shared_ptr<const HullSolid> solid = HullAccess::solid(convex->hull);
  if (convex->scale != Vec3{1.0f, 1.0f, 1.0f}) {
    solid = scale_hull(title(call) + ": the scaled hull", *solid, convex->scale);
  }
  SharedHull shared = shared_hull(*convex, std::move(solid));
  const HullData* const data = shared.data.get();
  return make_slot(hulls, content, std::move(shared), data);
}

std::uint64_t hull_content(const ConvexHull& geometry) {
  std::uint64_t hash = HullAccess::solid(geometry.hull)->content_hash;
  for (const float value : {geometry.scale.x, geometry.scale.y, geometry.scale.z, geometry.rounding + 0.0f}) {
    hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x9e3779b97f4a7c15u;  // 2^64 over the golden ratio
    hash ^= hash >> 32;
  }
  return hash | 1;  // 0 marks a free slot
}

ExtentRow extent_of(const SharedHull& hull) {
  ExtentRow extent{};
  for (const Vec3& v : hull.solid->topology.vertices) {
    extent.half[0] = std::max(extent.half[0], std::abs(v.x));
    extent.half[1] = std::max(extent.half[1], std::abs(v.y));
    extent.half[2] = std::max(extent.half[2], std::abs(v.z));
  }
  extent.radius = hull.data->outer_radius;
  const float rounding = hull.data->rounding;
  if (!(rounding > 0.0f)) return extent;
  for (float& half : extent.half) half = round_up(double{half} + double{rounding});
  extent.radius = round_up(double{extent.radius} + double{rounding});
  return extent;
}

std::size_t hull_bytes(const SharedHulls& hulls) {
  std::size_t bytes = hulls.capacity() * sizeof(SharedHull);
  std::vector<const HullSolid*> solids;  // each once, even if several slots scale it
  for (const SharedHull& shared : hulls) {
    if (shared.solid == nullptr) continue;
    if (shared.data.get() != shared.solid->columns.data) bytes += sizeof(HullData);
    solids.push_back(shared.solid.get());
    solids.push_back(HullAccess::solid(shared.geometry.hull).get());
  }
  std::sort(solids.begin(), solids.end());
  solids.erase(std::unique(solids.begin(), solids.end()), solids.end());
  for (const HullSolid* solid : solids) bytes += solid->bytes();
  return bytes;
}

}  // namespace scree
