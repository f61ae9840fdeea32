// Colors many new contacts at once: level by level over a grid of cells.
//
// Level 0 colors the contacts whose bodies lie in one cell, all cells in parallel. Each further level merges
// two cells along every axis into one, and colors the contacts that lie within it and within none of its
// parts. No two cells of a level share a body, and within a cell the order is that of the pairs. So the
// colors depend on the scene alone.
#include <parallel/constraints/coloring.h>

#include <algorithm>
#include <array>
#include <utility>

namespace scree {

namespace {

constexpr int kPartRows = 4096;  // new contacts of one task
constexpr int kBodyRows = 8192;  // bodies of one task
constexpr int kCellRows = 256;   // contacts wanted in a cell: about 1 us of coloring, against a claim's 0.2
constexpr std::int32_t kMaxCells = 4096;  // at level 0: keys of the counting sort

constexpr std::int32_t kMaxCuts = 1024;  // of the longest extent
constexpr int kMaxLevels = 16;
constexpr float kMaxExtent = 1e30f;       // m; keeps the grid finite
constexpr float kMinExtent = 1e-3f;       // m; of bodies in one place: the inverse size of cells stays finite
constexpr std::int32_t kPartsOfCell = 8;  // halving the cubes once more may make so many times the cells

using Cell = std::array<std::int32_t, 3>;

struct Grid {
  float lower[3];      // m
  float inverse_size;  // 1/m
  Cell dimensions;     // in cells of level 0
  int levels;          // the last has a single cell

  Cell dimensions_at(int level) const {
    return {((dimensions[0] - 1) >> level) + 1, ((dimensions[1] - 1) >> level) + 1,
            ((dimensions[2] - 1) >> level) + 1};
  }
  std::int32_t cells_at(int level) const {
    const Cell n = dimensions_at(level);
    return n[0] * n[1] * n[2];
  }
  Cell cell_of(const PoseRow& pose) const {
    Cell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float place = (pose.position[axis] - lower[axis]) * inverse_size;
      const auto last = static_cast<float>(dimensions[axis] - 1);
      cell[axis] = place >= last ? dimensions[axis] - 1 : place > 0.0f ? static_cast<std::int32_t>(place) : 0;
    }
    return cell;
  }
};

// The bounds of the awake bodies' centers. Minima and maxima are exact, so parts may be joined in any order.
BoundsRow bounds_of(const WorldData& data, Column<BoundsRow>& parts, Crew& crew) {
  const Column<std::int32_t>& awake = data.bodies.awake;
  const int count = static_cast<int>(awake.size());
  const auto include = [](BoundsRow& box, const float* lower, const float* upper) {
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = lower[axis] < box.lower[axis] ? lower[axis] : box.lower[axis];
      box.upper[axis] = upper[axis] > box.upper[axis] ? upper[axis] : box.upper[axis];
    }
  };
  const auto position_of = [&](int i) { return data.bodies.pose[awake[i]].position; };
  const auto begin_with = [](const float* p) {
    return BoundsRow{{p[0], p[1], p[2]}, 0.0f, {p[0], p[1], p[2]}, 0.0f};
  };
  parts.resize_discarding((count + kBodyRows - 1) / kBodyRows);
  crew.run_ranges(count, kBodyRows, [&](int begin, int end, int) {
    BoundsRow box = begin_with(position_of(begin));
    for (int i = begin; i < end; ++i) include(box, position_of(i), position_of(i));
    parts[begin / kBodyRows] = box;
  });
  BoundsRow all = parts[0];
  for (const BoundsRow& box : parts) include(all, box.lower, box.upper);
  return all;
}

// Cubes, halved until a filled box would have about kCellRows contacts in each.
Grid make_grid(const BoundsRow& bounds, std::size_t contacts) {
  Grid grid{};
  float extent[3];
  for (int axis = 0; axis < 3; ++axis) {
    grid.lower[axis] = bounds.lower[axis];
    extent[axis] = std::min(bounds.upper[axis] - bounds.lower[axis], kMaxExtent);
  }
  const float longest = std::max({extent[0], extent[1], extent[2], kMinExtent});
  const auto wanted =
      static_cast<std::int32_t>(std::min<std::size_t>(contacts / kCellRows, kMaxCells / kPartsOfCell));
  grid.dimensions = {1, 1, 1};
  for (std::int32_t cuts = 2; grid.cells_at(0) < wanted && cuts <= kMaxCuts; cuts *= 2) {
    grid.inverse_size = static_cast<float>(cuts) / longest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      grid.dimensions[axis] = std::min(static_cast<std::int32_t>(extent[axis] * grid.inverse_size) + 1, cuts);
    }
  }
  grid.levels = 1;
  while (grid.cells_at(grid.levels - 1) > 1) ++grid.levels;
  return grid;
}

// Keys count the cells of level 0, then those of level 1, and so on.
std::int32_t key_of(const Grid& grid, const std::int32_t* first_key, const WorldData& data,
                    const Edge& edge) {
  const auto cell_of = [&](std::int32_t body) { return grid.cell_of(data.bodies.pose[body]); };
  // Only bodies whose masks the contact enters count.
  Cell cell = cell_of(edge.kind == EdgeKind::hub_b ? edge.body_a : edge.body_b);
  int level = 0;
  if (edge.kind == EdgeKind::dynamic) {
    const Cell other = cell_of(edge.body_a);
    const std::int32_t difference = (cell[0] ^ other[0]) | (cell[1] ^ other[1]) | (cell[2] ^ other[2]);
    level = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(difference)));
  }
  const Cell n = grid.dimensions_at(level);
  return first_key[level] + ((cell[2] >> level) * n[1] + (cell[1] >> level)) * n[0] + (cell[0] >> level);
}

}  // namespace

void color_by_cells(const WorldData& data, Constraints& constraints, Crew& crew) {
  const Grid grid = make_grid(bounds_of(data, constraints.cell_bounds, crew), constraints.uncolored.size());
  std::int32_t first_key[kMaxLevels + 1] = {0};
  for (int level = 0; level < grid.levels; ++level) {
    first_key[level + 1] = first_key[level] + grid.cells_at(level);
  }
  const auto keys = static_cast<std::size_t>(first_key[grid.levels]);

  // Counting sort in parts of fixed size: stable, so that a cell's contacts keep their order.
  const int count = static_cast<int>(constraints.uncolored.size());
  const int parts = (count + kPartRows - 1) / kPartRows;
  constraints.cells.resize_discarding(constraints.uncolored.size());
  constraints.cell_rows.resize_discarding(constraints.uncolored.size());
  constraints.histogram.resize_discarding(static_cast<std::size_t>(parts) * keys);
  constraints.cell_begins.resize_discarding(keys + 1);
  crew.run_ranges(count, kPartRows, [&](int begin, int end, int) {
    std::int32_t* counts = constraints.histogram.data() + static_cast<std::size_t>(begin / kPartRows) * keys;
    std::fill(counts, counts + keys, 0);
    for (int i = begin; i < end; ++i) {
      const std::int32_t edge = constraints.uncolored[i];
      const std::int32_t key = key_of(grid, first_key, data, constraints.edges[edge]);
      constraints.cells[i] = key;
      ++counts[key];
    }
  });
  std::int32_t before = 0;
  for (std::size_t key = 0; key < keys; ++key) {
    constraints.cell_begins[key] = before;
    for (std::size_t part = 0; part < static_cast<std::size_t>(parts); ++part) {
      before += std::exchange(constraints.histogram[part * keys + key], before);
    }
  }
  constraints.cell_begins[keys] = before;
  crew.run_ranges(count, kPartRows, [&](int begin, int end, int) {
    std::int32_t* places = constraints.histogram.data() + static_cast<std::size_t>(begin / kPartRows) * keys;
    for (int i = begin; i < end; ++i) {
      const std::int32_t to = places[constraints.cells[i]]++;
      constraints.cell_rows[to] = constraints.uncolored[i];
    }
  });

  for (int level = 0; level < grid.levels; ++level) {
    crew.run(first_key[level + 1] - first_key[level], [&](int cell, int) {
      const std::int32_t key = first_key[level] + cell;
      for (std::int32_t i = constraints.cell_begins[key]; i < constraints.cell_begins[key + 1]; ++i) {
        const std::int32_t edge = constraints.cell_rows[i];
        take_lowest_color(constraints.body_colors, constraints.edges[edge]);
      }
    });
  }
}

}  // namespace scree
