// A ray against one solid, in double precision.
#pragma once

#include <parallel/queries/query_solid.h>
#include <simd/queries/query_kernels.h>

namespace scree::queries {

struct Line {
  Vector origin, translation;
};

// Where a ray enters a solid.
struct Entry {
  double fraction = 0.0;
  Vector normal;               // of the solid, outward; zero if `inside`
  int face = -1;               // see CastHit
  std::int32_t triangle = -1;  // of a mesh, see CastHit
  bool inside = false;         // the ray begins in the solid
};

// Whether the ray meets the solid, which is no mesh, and where first. A ray that begins on the surface begins
// inside.
bool meet(const simd::QueryKernels& kernels, const Solid& solid, const Line& line, Entry& entry);

}  // namespace scree::queries
