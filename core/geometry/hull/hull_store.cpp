// See hull_store.h.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/hull/hull_store.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace scree {

namespace {

std::int32_t find_slot(const Hulls& hulls, std::uint64_t content, const ConvexHull& geometry) {
  const auto [first, last] = hulls.slot_of.equal_range(content);
  for (auto entry = first; entry != last; ++entry) {
    if (hulls.shared[static_cast<std::size_t>(entry->second)].geometry == geometry) return entry->second;
  }
  return -1;
}

void resize(Hulls& hulls, std::size_t slots) {
  hulls.resize(slots);
  hulls.shared.resize(slots);
}

// Returns a free slot without taking it.
std::int32_t free_slot(Hulls& hulls) {
  const std::size_t slots = hulls.shared.size();
  if (!hulls.free_slots.empty()) return hulls.free_slots.back();
  hulls.free_slots.reserve(slots + 1);  // so that releasing cannot fail
  try {
    resize(hulls, slots + 1);
  } catch (...) {
    resize(hulls, slots);
    throw;
  }
  return static_cast<std::int32_t>(slots);
}

// Empties a slot that no shape uses.
void clear(Hulls& hulls, std::int32_t slot) {
  SCREE_ASSERT(hulls.shapes[slot] == 0);
  const auto [first, last] = hulls.slot_of.equal_range(hulls.content[slot]);
  const auto own = std::find_if(first, last, [&](const auto& entry) { return entry.second == slot; });
  SCREE_ASSERT(own != last);
  hulls.slot_of.erase(own);
  hulls.content[slot] = 0;
  hulls.data[slot] = nullptr;
  hulls.shared[static_cast<std::size_t>(slot)] = {};
}

}  // namespace

std::int32_t acquire_hull(Call call, Hulls& hulls, const Geometry& geometry) {
  const auto* convex = std::get_if<ConvexHull>(&geometry);
  if (convex == nullptr) return -1;
  const std::uint64_t content = hull_content(*convex);
  if (const std::int32_t slot = find_slot(hulls, content, *convex); slot >= 0) {
    ++hulls.shapes[slot];
    return slot;
  }
  SharedHull shared{*convex, HullAccess::solid(convex->hull)};
  if (convex->scale != Vec3{1.0f, 1.0f, 1.0f}) {
    shared.solid = scale_hull(title(call) + ": the scaled hull", *shared.solid, convex->scale);
  }
  const std::size_t old_slots = hulls.shared.size();
  const std::int32_t slot = free_slot(hulls);
  try {
    hulls.slot_of.emplace(content, slot);
  } catch (...) {
    resize(hulls, old_slots);
    throw;
  }
  if (!hulls.free_slots.empty()) hulls.free_slots.pop_back();
  hulls.content[slot] = content;
  hulls.shapes[slot] = 1;
  hulls.data[slot] = shared.solid->columns.data;
  hulls.shared[static_cast<std::size_t>(slot)] = std::move(shared);
  return slot;
}

void release_hull(Hulls& hulls, std::int32_t slot) {
  if (slot < 0 || --hulls.shapes[slot] > 0) return;
  clear(hulls, slot);
  hulls.free_slots.push_back(slot);
}

void undo_hull(Hulls& hulls, std::int32_t slot, std::size_t old_slots) {
  if (slot < 0 || --hulls.shapes[slot] > 0) return;
  clear(hulls, slot);
  if (std::cmp_less(slot, old_slots)) {
    hulls.free_slots.push_back(slot);
  } else {
    resize(hulls, static_cast<std::size_t>(slot));
  }
}

std::uint64_t hull_content(const ConvexHull& geometry) {
  std::uint64_t hash = HullAccess::solid(geometry.hull)->content_hash;
  for (const float scale : {geometry.scale.x, geometry.scale.y, geometry.scale.z}) {
    hash = (hash ^ std::bit_cast<std::uint32_t>(scale)) * 0x9e3779b97f4a7c15u;  // 2^64 over the golden ratio
    hash ^= hash >> 32;
  }
  return hash | 1;  // 0 marks a free slot
}

ExtentRow extent_of(const HullSolid& solid) {
  ExtentRow extent{};
  for (const Vec3& v : solid.topology.vertices) {
    extent.half[0] = std::max(extent.half[0], std::abs(v.x));
    extent.half[1] = std::max(extent.half[1], std::abs(v.y));
    extent.half[2] = std::max(extent.half[2], std::abs(v.z));
  }
  extent.radius = solid.columns.data->outer_radius;
  return extent;
}

std::size_t hull_bytes(const SharedHulls& hulls) {
  std::size_t bytes = hulls.capacity() * sizeof(SharedHull);
  std::vector<const HullSolid*> solids;  // each once, even if several slots scale it
  for (const SharedHull& shared : hulls) {
    if (shared.solid == nullptr) continue;
    solids.push_back(shared.solid.get());
    solids.push_back(HullAccess::solid(shared.geometry.hull).get());
  }
  std::sort(solids.begin(), solids.end());
  solids.erase(std::unique(solids.begin(), solids.end()), solids.end());
  for (const HullSolid* solid : solids) bytes += solid->bytes();
  return bytes;
}

}  // namespace scree
