// See ray_order.h.
#include <parallel/queries/ray_order.h>

#include <algorithm>
#include <cmath>

namespace scree::queries {

namespace {

constexpr std::size_t kFewRays = 512;
constexpr int kRaysPerChunk = 1024;
// Bits for each axis of the place of entry, and of the direction. More sort longer and gain nothing.
constexpr int kPlaceBits = 8, kWayBits = 4;

// The box in which most shapes lie.
struct Region {
  double lower[3], upper[3];
};

// From the boxes of the uppermost blocks' children. Leaves out half-spaces and what is near them in a tree,
// and the outermost tenth on each side: one shape that fell out of the scene must not put all rays into one
// cell.
Region region_of(const Scope& scope) {
  constexpr std::size_t kOutermost = 10;
  std::vector<float> lower[3], upper[3];
  const auto take = [&](const float(&bounds)[6][simd::kBlock]) {
    for (int child = 0; child < simd::kBlock; ++child) {
      const bool is_absent = bounds[0][child] > bounds[3][child];
      if (is_absent || bounds[3][child] - bounds[0][child] >= kHalfSpaceReach) continue;
      for (int axis = 0; axis < 3; ++axis) {
        lower[axis].push_back(bounds[axis][child]);
        upper[axis].push_back(bounds[axis + 3][child]);
      }
    }
  };
  const auto take_root = [&](const simd::TreeView& tree) {
    if (tree.levels > 0) take(tree.nodes[tree.levels - 1][0].bounds);
  };
  for_each_base_tree(scope.data, scope.index, take_root);
  for_each_loose_tree(scope.data, scope.index, take_root);
  Region region{};
  for (int axis = 0; axis < 3; ++axis) {
    if (lower[axis].empty()) continue;
    std::sort(lower[axis].begin(), lower[axis].end());
    std::sort(upper[axis].begin(), upper[axis].end());
    const std::size_t left_out = lower[axis].size() / kOutermost;
    region.lower[axis] = lower[axis][left_out];
    region.upper[axis] = upper[axis][upper[axis].size() - 1 - left_out];
  }
  return region;
}

// The lowest bits, two zeros between each and the next.
std::uint64_t apart(std::uint32_t bits, int count) {
  std::uint64_t spread = 0;
  for (int i = 0; i < count; ++i) spread |= std::uint64_t{bits >> i & 1u} << (3 * i);
  return spread;
}

std::uint32_t cell_of(double share, int bits) {
  const double cells = static_cast<double>(1 << bits);
  return static_cast<std::uint32_t>(std::clamp(share * cells, 0.0, cells - 1.0));
}

// Where the ray enters the region, along a Morton curve, then its direction. Of one that misses it, where it
// passes.
std::uint64_t key_of(const Ray& ray, const Region& region) {
  double begin = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double way = ray.translation[axis];
    if (way == 0.0) continue;
    const double side = way > 0.0 ? region.lower[axis] : region.upper[axis];
    begin = std::max(begin, (side - ray.origin[axis]) / way);
  }
  begin = std::min(begin, 1.0);
  const double size = length(to_vector(ray.translation));
  std::uint64_t place = 0, way = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = ray.origin[axis] + begin * ray.translation[axis];
    const double wide = std::max(region.upper[axis] - region.lower[axis], 1e-30);
    place |= apart(cell_of((at - region.lower[axis]) / wide, kPlaceBits), kPlaceBits) << axis;
    const double along = size > 0.0 ? ray.translation[axis] / size : 0.0;
    way |= apart(cell_of(0.5 + 0.5 * along, kWayBits), kWayBits) << axis;
  }
  return place << (3 * kWayBits) | way;
}

}  // namespace

std::vector<std::int32_t> order_rays(const Scope& scope, std::span<const Ray> rays, Crew& crew) {
  if (rays.size() < kFewRays) return {};
  const Region region = region_of(scope);
  Column<SortKey> keys, others;
  Column<std::uint32_t> digit_counts;
  keys.resize_discarding(rays.size());
  others.resize_discarding(rays.size());
  const auto count = static_cast<int>(rays.size());
  crew.run_ranges(count, kRaysPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) keys[i] = {key_of(rays[static_cast<std::size_t>(i)], region), i, 0};
  });
  const SortKey* const sorted = sort_by_key(keys.data(), others.data(), count, digit_counts, crew);
  std::vector<std::int32_t> order(rays.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = sorted[i].shape;
  return order;
}

}  // namespace scree::queries
