// Height fields: ground given as heights on a grid, made a triangle mesh.
#pragma once

#include <scree/export.h>
#include <scree/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace scree {

/// Heights on a grid of columns along x and rows along z. The height at a column and a row stands at
/// `heights[row * columns + column]`, and its point at (column * spacing_x, height, row * spacing_z).
///
/// Between four neighbors lies a cell, of two triangles that are seen from above. Cell number
/// row * (columns - 1) + column lies behind that column and row. The shorter one of its diagonals parts it,
/// or where both are as long the one from its least column and row.
struct HeightField {
  std::size_t columns = 0;           ///< at least 2
  std::size_t rows = 0;              ///< at least 2
  std::span<const float> heights{};  ///< m, each within +-1e5; columns * rows of them
  float spacing_x = 1.0f;            ///< m between columns, at least 1e-4; all are within 1e5 m
  float spacing_z = 1.0f;            ///< m between rows, as spacing_x
  /// Of each cell whether it is left out: 0 is not. Empty: there are no holes.
  std::span<const std::uint8_t> holes{};
};

/// The mesh of a height field. Cell k has the triangles 2 k, with the edge along its least row, and 2 k + 1,
/// with the one along its greatest row. `materials` names those of all triangles in this order. Triangles of
/// holes count as dropped.
///
/// Throws Error on values outside the ranges above, on lists of other lengths, where all cells are holes, on
/// more than 2^30 heights or triangles, and on bad materials.
SCREE_API TriangleMesh height_field_mesh(const HeightField& field, const MeshMaterials& materials = {});

}  // namespace scree
