// Parts of a solid, from the whole pieces to those that become hulls: cutting them in two and joining them
// again.
#pragma once

#include <core/geometry/decompose/cell.h>
#include <core/geometry/decompose/fragments.h>
#include <core/geometry/decompose/lattice.h>
#include <core/geometry/decompose/pieces.h>
#include <core/geometry/decompose/planes.h>
#include <scree/decompose.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace scree::decomposition {

// A piece with what cutting it needs.
struct Solid {
  Piece piece;
  WindingBins winding;
  std::vector<ReentrantEdge> edges;

  explicit Solid(Piece&& whole)
      : piece(std::move(whole)),
        winding(piece.surface),
        edges(find_reentrant_edges(piece.surface, piece.inside_out)) {}
  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;
};

struct CellPart {
  const Solid* solid = nullptr;  // none: joined of several
  Cell cell;
  Fragments fragments;
  std::vector<Vector> points;  // whose hull it is
  Shell shell;                 // their hull
  double concavity = 0.0;      // m, of the shell
  double own_volume = 0.0;  // m^3, of the shells of the parts that were joined to this one, before they were
  bool is_final = false;    // no plane divides it into two solids
};

// What is the same for all parts of a mesh.
struct Workshop {
  Lattice lattice;
  PointGrid grid;
  double tolerance = 0.0;  // m: what lies this close to a plane lies in it
  double concavity = 0.0;  // m, that was asked for

  Workshop(const Surface& surface, const DecomposeOptions& options);
  Shell shell_of(std::span<const Vector> points) const;
};

// cut_part.cpp: all of a piece, and the best cut in two.
CellPart whole_part(const Solid& solid, Workshop& workshop);
std::optional<std::array<CellPart, 2>> cut_part(const CellPart& part, Workshop& workshop);

// join_parts.cpp: joins neighbors whose common hull keeps the concavity, and then the best ones while there
// are more than `max_parts`. Returns how many were joined against the concavity.
std::size_t join_parts(std::vector<CellPart>& parts, std::size_t max_parts, Workshop& workshop,
                       std::size_t& merges);

}  // namespace scree::decomposition
