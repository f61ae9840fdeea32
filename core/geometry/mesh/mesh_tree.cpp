// The tree over a mesh's triangles: an order in which 16 neighbors are a leaf, 16 leaves a block, and so on,
// and the boxes of all blocks.
#include <core/geometry/mesh/mesh_stages.h>

#include <algorithm>
#include <limits>

namespace scree {

namespace {

constexpr float kLargestFloat = std::numeric_limits<float>::max();

struct Center {
  float twice[3];  // m, lower + upper corner of the triangle's box
  std::int32_t triangle;
};

int longest_axis(std::span<const Center> centers) {
  float lower[3], upper[3];
  std::fill_n(lower, 3, kLargestFloat);
  std::fill_n(upper, 3, -kLargestFloat);
  for (const Center& center : centers) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], center.twice[axis]);
      upper[axis] = std::max(upper[axis], center.twice[axis]);
    }
  }
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (upper[axis] - lower[axis] > upper[longest] - lower[longest]) longest = axis;
  }
  return longest;
}

// Splits into halves of whole blocks of `unit` triangles until these are leaves; the last one of all may have
// fewer. All keys differ, so that each half is a certain set, whatever std::nth_element does within it.
void split(std::span<Center> centers, std::size_t unit) {
  while (unit > kTreeBlock && centers.size() <= unit) unit /= kTreeBlock;
  if (centers.size() <= unit) {
    std::sort(centers.begin(), centers.end(),
              [](const Center& a, const Center& b) { return a.triangle < b.triangle; });
    return;
  }
  const std::size_t units = (centers.size() + unit - 1) / unit;
  const auto half = static_cast<std::ptrdiff_t>(units / 2 * unit);
  const int axis = longest_axis(centers);
  std::nth_element(
      centers.begin(), centers.begin() + half, centers.end(), [axis](const Center& a, const Center& b) {
        return a.twice[axis] != b.twice[axis] ? a.twice[axis] < b.twice[axis] : a.triangle < b.triangle;
      });
  split(centers.first(static_cast<std::size_t>(half)), unit);
  split(centers.subspan(static_cast<std::size_t>(half)), unit);
}

struct Bounds {
  float lower[3], upper[3];
};

Bounds bounds_of(std::span<const Vec3> points, const Corners& corner) {
  Bounds bounds{};
  for (int axis = 0; axis < 3; ++axis) {
    const float a = points[corner[0]][axis], b = points[corner[1]][axis], c = points[corner[2]][axis];
    bounds.lower[axis] = std::min({a, b, c});
    bounds.upper[axis] = std::max({a, b, c});
  }
  return bounds;
}

constexpr NodeBlock kEmptyNode = [] {
  NodeBlock node{};
  for (int axis = 0; axis < 3; ++axis) {
    for (int child = 0; child < kTreeBlock; ++child) {
      node.bounds[axis][child] = kLargestFloat;
      node.bounds[axis + 3][child] = -kLargestFloat;
    }
  }
  return node;
}();

// Widens the box of a block by one of its members.
void widen(NodeBlock* level, std::size_t block, const Bounds& bounds) {
  NodeBlock& node = level[block / kTreeBlock];
  const std::size_t child = block % kTreeBlock;
  for (int axis = 0; axis < 3; ++axis) {
    node.bounds[axis][child] = std::min(node.bounds[axis][child], bounds.lower[axis]);
    node.bounds[axis + 3][child] = std::max(node.bounds[axis + 3][child], bounds.upper[axis]);
  }
}

Bounds bounds_of(const NodeBlock& node) {
  Bounds bounds{};
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = *std::min_element(node.bounds[axis], node.bounds[axis] + kTreeBlock);
    bounds.upper[axis] = *std::max_element(node.bounds[axis + 3], node.bounds[axis + 3] + kTreeBlock);
  }
  return bounds;
}

}  // namespace

std::vector<std::int32_t> order_triangles(std::span<const Vec3> points, std::span<const Corners> triangles) {
  std::vector<Center> centers(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Bounds bounds = bounds_of(points, triangles[i]);
    for (int axis = 0; axis < 3; ++axis) centers[i].twice[axis] = bounds.lower[axis] + bounds.upper[axis];
    centers[i].triangle = static_cast<std::int32_t>(i);
  }
  std::size_t unit = kTreeBlock;
  while (unit < centers.size()) unit *= kTreeBlock;
  split(centers, unit);
  std::vector<std::int32_t> order;
  order.reserve(centers.size());
  for (const Center& center : centers) order.push_back(center.triangle);
  return order;
}

void make_nodes(std::span<const Vec3> points, std::span<const Corners> ordered, MeshSolid& solid) {
  std::size_t begin[kMaxTreeLevels + 1]{};
  std::size_t blocks = (ordered.size() + kTreeBlock - 1) / kTreeBlock;
  int levels = 0;
  do {
    blocks = (blocks + kTreeBlock - 1) / kTreeBlock;
    begin[levels + 1] = begin[levels] + blocks;
    ++levels;
  } while (blocks > 1);
  Column<NodeBlock>& nodes = solid.columns.nodes;
  nodes.resize_for_overwrite(begin[levels]);
  std::fill(nodes.begin(), nodes.end(), kEmptyNode);
  for (std::size_t i = 0; i < ordered.size(); ++i)
    widen(nodes.data(), i / kTreeBlock, bounds_of(points, ordered[i]));
  for (int level = 1; level < levels; ++level) {
    const std::size_t children = begin[level] - begin[level - 1];
    for (std::size_t child = 0; child < children; ++child)
      widen(nodes.data() + begin[level], child, bounds_of(nodes[begin[level - 1] + child]));
  }
  for (int level = 0; level < levels; ++level) solid.data.nodes[level] = nodes.data() + begin[level];
  solid.data.levels = levels;
}

}  // namespace scree
