// Scratch of collide: the rows of this step grouped by type pair.
#pragma once

#include <core/column.h>
#include <core/world_data.h>
#include <simd/collide_kernels.h>

#include <array>
#include <cstdint>

namespace scree {

struct NarrowPhase : Part {
  // Rows of contacts handled by one chunk of the passes over rows.
  static constexpr int kRowChunk = 1024;
  using Counts = std::array<std::int32_t, simd::kCollideTypes>;

  Column<std::uint8_t> kind;    // scratch; per row of contacts: collide type, kSkipped or kNever
  Column<std::uint8_t> points;  // scratch; per row: points, valid after the kernels
  Column<Counts> chunk_counts;  // scratch; per row chunk: rows of each type, then where they go in `items`
  Column<std::int32_t> chunk_touching;  // scratch; per row chunk: touching rows, then where they go
  Column<std::int32_t> chunk_resting;   // scratch; per row chunk: rows with points whose bodies all rest
  Column<simd::CollideItem> items;      // scratch; by type, in ascending order of rows
  std::array<std::int32_t, simd::kCollideTypes + 1> type_begin{};  // first item of each type

  void report(const Visit& visit) const override;
};

}  // namespace scree
