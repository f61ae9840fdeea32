// The pieces of a mesh, which share no vertex: each is decomposed by itself, with the hollows that lie in it.
#pragma once

#include <core/geometry/decompose/surface.h>

#include <cstddef>
#include <vector>

namespace scree::decomposition {

struct Piece {
  Surface surface;
  bool inside_out = false;  // its triangles look inward
};

// Pieces whose triangles look inward stay with those whose bounds they overlap. Where there are more than
// `limit`, neighbors are taken as one; `joined` counts how many fewer there are then. Points that no triangle
// has are left out. The volume of all says which way is outward.
std::vector<Piece> find_pieces(const Surface& surface, std::size_t limit, std::size_t& joined);

}  // namespace scree::decomposition
