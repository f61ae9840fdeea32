// The hulls and meshes that snapshots and recordings hold: each solid once, under a number.
#pragma once

#include <core/geometry/hull/hull_build.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/world/world_data.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

namespace scree {

using SolidPointer = std::shared_ptr<const HullSolid>;
using MeshPointer = std::shared_ptr<const MeshSolid>;

// Numbers solids of different content in the order in which they are met.
template <class Solid>
class NumberedSolids {
 public:
  using Pointer = std::shared_ptr<const Solid>;

  std::int32_t number_of(const Pointer& solid) {  // -1: of none
    if (solid == nullptr) return -1;
    const auto [first, last] = numbers_.equal_range(solid->content_hash);
    for (auto known = first; known != last; ++known) {
      const Pointer& other = all_[static_cast<std::size_t>(known->second)];
      if (other == solid || equal(*other, *solid)) return known->second;
    }
    const auto number = static_cast<std::int32_t>(all_.size());
    numbers_.emplace(solid->content_hash, number);
    all_.push_back(solid);
    return number;
  }
  const std::vector<Pointer>& all() const { return all_; }

 private:
  std::vector<Pointer> all_;
  std::unordered_multimap<std::uint64_t, std::int32_t> numbers_;
};

// By number.
struct SolidViews {
  std::span<const SolidPointer> hulls;
  std::span<const MeshPointer> meshes;
};
struct SolidVectors {
  std::vector<SolidPointer> hulls;
  std::vector<MeshPointer> meshes;
};

// Of each slot of hulls the numbers of the unscaled solid and the scaled one, of each slot of meshes one.
struct SlotNumbers {
  std::vector<std::int32_t> hulls, meshes;
};

class SolidList {
 public:
  std::int32_t number_of(const SolidPointer& hull) { return hulls_.number_of(hull); }
  std::int32_t number_of(const MeshPointer& mesh) { return meshes_.number_of(mesh); }
  SlotNumbers numbers_of(const std::vector<SharedHull>& hulls, const std::vector<SharedMesh>& meshes);
  SolidViews solids() const { return {hulls_.all(), meshes_.all()}; }

 private:
  NumberedSolids<HullSolid> hulls_;
  NumberedSolids<MeshSolid> meshes_;
};

}  // namespace scree
