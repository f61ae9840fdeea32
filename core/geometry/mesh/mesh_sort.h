// Sorts what hangs on vertices: edges by their two ends, triangles by their three corners.
//
// The first number leads to a bucket, what is within a bucket is compared. Few entries share a vertex, so
// that this takes a fifth of the time of sorting all at once.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scree {

using Corners = std::array<std::uint32_t, 3>;

// Rows of `entries` from begin[bucket] to begin[bucket + 1].
template <class Entry>
struct Buckets {
  std::vector<std::uint32_t> begin;
  std::vector<Entry> entries;

  std::size_t count() const { return begin.size() - 1; }
  std::span<const Entry> operator[](std::size_t bucket) const {
    return std::span(entries).subspan(begin[bucket], begin[bucket + 1] - begin[bucket]);
  }
};

// `each(put)` calls put(bucket, entry) for all entries, and does so twice. Below 2^32 entries. Entries are
// compared by <, and no two within a bucket are equal.
template <class Entry, class Each>
Buckets<Entry> sort_in_buckets(std::size_t bucket_count, Each&& each) {
  Buckets<Entry> buckets{std::vector<std::uint32_t>(bucket_count + 1), {}};
  std::vector<std::uint32_t>& begin = buckets.begin;
  each([&](std::size_t bucket, const Entry&) { ++begin[bucket]; });
  std::uint32_t sum = 0;
  for (std::uint32_t& place : begin) {
    sum += place;
    place = sum;  // the end of its bucket: filling goes backward
  }
  buckets.entries.resize(sum);
  each([&](std::size_t bucket, const Entry& entry) { buckets.entries[--begin[bucket]] = entry; });
  for (std::size_t i = 0; i < bucket_count; ++i)
    std::sort(buckets.entries.data() + begin[i], buckets.entries.data() + begin[i + 1]);
  return buckets;
}

// A triangle's passage along an edge, in the bucket of the edge's lower end.
struct EdgePass {
  std::uint32_t high_end;
  std::uint32_t pass;  // 3 triangle + edge

  friend auto operator<=>(const EdgePass&, const EdgePass&) = default;
};
using EdgePasses = Buckets<EdgePass>;

// Below 2^30 triangles, each of three different corners.
EdgePasses sort_edges(std::span<const Corners> triangles, std::size_t vertices);

// Whether a triangle passes the edge from its higher end to the lower one.
inline bool goes_down(std::span<const Corners> triangles, std::uint32_t pass) {
  const Corners& corner = triangles[pass / 3];
  return corner[pass % 3] > corner[(pass + 1) % 3];
}

// Calls edge(passes) for each edge, with the passes of all its triangles.
template <class Edge>
void each_edge(const EdgePasses& passes, Edge&& edge) {
  for (std::size_t low = 0; low < passes.count(); ++low) {
    const std::span<const EdgePass> bucket = passes[low];
    for (std::size_t first = 0, end = 0; first < bucket.size(); first = end) {
      while (end < bucket.size() && bucket[end].high_end == bucket[first].high_end) ++end;
      edge(bucket.subspan(first, end - first));
    }
  }
}

// For each triangle whether an earlier one has the same corners in the same order.
std::vector<bool> find_repeated(std::span<const Corners> triangles, std::size_t vertices);

}  // namespace scree
