// Gives up the memory of bodies that are absent: rows that are not on all ranks become zero, and pages of
// nothing else go back to the system. See border.h.
//
// Rows stay numbered as in the whole world, so what a rank saves depends on how many of its absent bodies
// stand side by side. Cuts across the axis along which rows stay together make long runs of them.
#include <parallel/distributed/border.h>
#include <parallel/distributed/local_columns.h>

#include <cstddef>

namespace scree {

namespace {

constexpr std::size_t kLeastRun = 64;  // rows; shorter runs fill no page of any column
// Gives up again where more than one of so many shapes that are here has gone.
constexpr std::size_t kHerePerGone = 8;

// Of rows that is_absent(row) holds for.
template <class Store, class IsAbsent>
void give_up_runs(Store& store, IsAbsent&& is_absent) {
  const std::size_t rows = store.flags.size();
  for (std::size_t first = 0; first < rows;) {
    std::size_t end = first;
    while (end < rows && is_absent(end)) ++end;
    if (end - first >= kLeastRun)
      for_each_local_column(store, LocalColumns::all, [&](auto& column) { column.zero(first, end); });
    first = end + 1;
  }
}

}  // namespace

void give_up_rows(WorldData& data, Border& border) {
  if (kHerePerGone * border.gone <= border.own_shapes.size()) return;
  border.gone = 0;
  const Bodies& bodies = data.bodies;
  const Shapes& shapes = data.shapes;
  give_up_runs(data.bodies, [&](std::size_t body) {
    return (bodies.flags[body] & kBodyAlive) != 0 && bodies.is_absent[body] != 0;
  });
  give_up_runs(data.shapes, [&](std::size_t shape) {
    return (shapes.flags[shape] & kShapeAlive) != 0 && bodies.is_absent[shapes.body[shape]] != 0;
  });
}

}  // namespace scree
