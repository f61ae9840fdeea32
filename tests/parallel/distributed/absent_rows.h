// What tests do to rows of bodies that are absent, for the tests of this folder.
#pragma once

#include <parallel/distributed/local_columns.h>

#include <cstddef>
#include <cstring>

namespace scree::distributed_tests {

// Calls work(store, row) for rows of absent bodies and of their shapes.
template <class Work>
void for_each_absent_row(WorldData& data, Work&& work) {
  const auto is_gone = [&](std::size_t body) {
    return (data.bodies.flags[body] & kBodyAlive) != 0 && data.bodies.is_absent[body] != 0;
  };
  for (std::size_t body = 0; body < data.bodies.flags.size(); ++body) {
    if (is_gone(body)) work(data.bodies, body);
  }
  for (std::size_t shape = 0; shape < data.shapes.flags.size(); ++shape) {
    if ((data.shapes.flags[shape] & kShapeAlive) != 0 &&
        is_gone(static_cast<std::size_t>(data.shapes.body[shape])))
      work(data.shapes, shape);
  }
}

// Makes all that is not on all ranks the worst there is: no numbers, and indices of nothing. Who reads it is
// found out.
inline void scramble_absent_rows(WorldData& data) {
  for_each_absent_row(data, [](auto& store, std::size_t row) {
    for_each_local_column(store, LocalColumns::all, [row](auto& column) {
      std::memset(static_cast<void*>(&column[row]), 0xff, sizeof column[row]);
    });
  });
}

}  // namespace scree::distributed_tests
