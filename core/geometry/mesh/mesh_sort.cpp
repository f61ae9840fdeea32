// See mesh_sort.h.
#include <core/geometry/mesh/mesh_sort.h>

namespace scree {

namespace {

// In the bucket of the first corner.
struct OtherCorners {
  std::uint32_t second, third, triangle;

  friend auto operator<=>(const OtherCorners&, const OtherCorners&) = default;
};

}  // namespace

EdgePasses sort_edges(std::span<const Corners> triangles, std::size_t vertices) {
  return sort_in_buckets<EdgePass>(vertices, [&](auto&& put) {
    std::uint32_t pass = 0;
    for (const Corners& corner : triangles) {
      for (std::size_t k = 0; k < 3; ++k, ++pass) {
        const std::uint32_t from = corner[k], to = corner[k < 2 ? k + 1 : 0];
        put(std::min(from, to), EdgePass{std::max(from, to), pass});
      }
    }
  });
}

std::vector<bool> find_repeated(std::span<const Corners> triangles, std::size_t vertices) {
  const auto sorted = sort_in_buckets<OtherCorners>(vertices, [&](auto&& put) {
    std::uint32_t triangle = 0;
    for (const Corners& corner : triangles) put(corner[0], OtherCorners{corner[1], corner[2], triangle++});
  });
  std::vector<bool> is_repeated(triangles.size());
  for (std::size_t bucket = 0; bucket < sorted.count(); ++bucket) {
    const std::span<const OtherCorners> row = sorted[bucket];
    for (std::size_t i = 1; i < row.size(); ++i) {
      if (row[i].second == row[i - 1].second && row[i].third == row[i - 1].third)
        is_repeated[row[i].triangle] = true;
    }
  }
  return is_repeated;
}

}  // namespace scree
