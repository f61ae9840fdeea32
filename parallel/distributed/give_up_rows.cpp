// Gives up the memory of bodies that are absent: rows that are not on all ranks become zero, and pages of
// nothing else go back to the system. See border.h.
//
// Rows stay numbered as in the whole world, so what a rank saves depends on how many of its absent bodies
// stand side by side. Cuts across the axis along which rows stay together make long runs of them.
#include <parallel/distributed/border.h>
#include <parallel/distributed/local_columns.h>

#include <algorithm>
#include <cstddef>

namespace scree {

namespace {

constexpr std::size_t kLeastRun = 64;  // rows; shorter runs fill no page of any column
// Gives up again where more than one of so many shapes that are here has gone.
constexpr std::size_t kHerePerGone = 8;

struct Rows {
  std::size_t begin, end;
};

// Of rows that is_absent(row) holds for.
template <class Store, class IsAbsent>
void give_up_runs(Store& store, const Rows& rows, IsAbsent&& is_absent) {
  for (std::size_t first = rows.begin; first < rows.end;) {
    std::size_t end = first;
    while (end < rows.end && is_absent(end)) ++end;
    if (end - first >= kLeastRun)
      for_each_local_column(store, LocalColumns::all, [&](auto& column) { column.zero(first, end); });
    first = end + 1;
  }
}

void give_up(WorldData& data, const Rows& of_bodies, const Rows& of_shapes) {
  const Bodies& bodies = data.bodies;
  const Shapes& shapes = data.shapes;
  give_up_runs(data.bodies, of_bodies, [&](std::size_t body) {
    return (bodies.flags[body] & kBodyAlive) != 0 && bodies.is_absent[body] != 0;
  });
  give_up_runs(data.shapes, of_shapes, [&](std::size_t shape) {
    return (shapes.flags[shape] & kShapeAlive) != 0 && bodies.is_absent[shapes.body[shape]] != 0;
  });
}

}  // namespace

void give_up_rows(WorldData& data, Border& border) {
  if (kHerePerGone * border.gone <= border.own_shapes.size() + border.resting.shapes.size()) return;
  border.gone = 0;
  give_up(data, {0, data.bodies.flags.size()}, {0, data.shapes.flags.size()});
}

void give_up_rows_among(WorldData& data, const std::vector<std::int32_t>& bodies,
                        const std::vector<std::int32_t>& shapes) {
  const auto around = [](const std::vector<std::int32_t>& rows) {
    if (rows.empty()) return Rows{0, 0};
    const auto [first, last] = std::minmax_element(rows.begin(), rows.end());
    return Rows{static_cast<std::size_t>(*first), static_cast<std::size_t>(*last) + 1};
  };
  give_up(data, around(bodies), around(shapes));
}

}  // namespace scree
