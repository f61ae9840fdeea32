// Hull building: points -> corners, faces and edges in canonical order, with a report of what was left out.
//
// Rounds the points' coordinates to a grid, whose step along each axis is 2^-23 of the hull's half extent.
// Decides exactly on this grid on which side of a plane a point lies; Qhull only selects which of many points
// can be corners. Grid coordinates relative to the hull's centroid are floats without further rounding.
#pragma once

#include <core/geometry/balls.h>
#include <core/geometry/hull/hull_columns.h>
#include <core/geometry/hull/hull_topology.h>
#include <scree/hull.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace scree {

// The data of a Hull. Never changes.
struct HullSolid {
  HullTopology topology;
  std::vector<Vec3> points;  // the corners as they were given, in the frame of the points
  double origin[3]{};  // m, of the topology's frame in the frame of the points; the centroid's grid point
  HullIntegrals integrals;  // about `origin`
  HullReport report;
  HullColumns columns;
  Balls balls;
  std::uint64_t content_hash = 0;  // of points and topology

  std::size_t bytes() const;  // of memory
};

bool equal(const HullSolid& a, const HullSolid& b);

// Throws Error "<who>: <problem>", see Hull, and std::bad_alloc.
std::shared_ptr<const HullSolid> build_hull(const std::string& who, std::span<const Vec3> points,
                                            const HullOptions& options);
// The hull of the corners times `scale`, whose components are finite and above zero.
std::shared_ptr<const HullSolid> scale_hull(const std::string& who, const HullSolid& hull, Vec3 scale);

// Computes integrals, columns, balls and hash from points and topology. Throws std::bad_alloc.
void complete_solid(HullSolid& solid);

// The data of a hull; null for an empty one.
struct HullAccess {
  static const std::shared_ptr<const HullSolid>& solid(const Hull& hull) { return hull.solid_; }
  static Hull hull(std::shared_ptr<const HullSolid> solid) {
    Hull hull;
    hull.solid_ = std::move(solid);
    return hull;
  }
};

}  // namespace scree
