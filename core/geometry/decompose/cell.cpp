// See cell.h.
#include <core/geometry/decompose/cell.h>

#include <algorithm>
#include <iterator>

namespace scree::decomposition {

namespace {

std::vector<std::uint32_t> common(const CellCorner& a, const CellCorner& b) {
  std::vector<std::uint32_t> both;
  std::set_intersection(a.planes.begin(), a.planes.end(), b.planes.begin(), b.planes.end(),
                        std::back_inserter(both));
  return both;
}

}  // namespace

Cell make_cell(const Bounds& bounds) {
  Cell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vector normal{};
    normal[axis] = -1.0;
    cell.planes.push_back({normal, -bounds.lower[axis]});
    normal[axis] = 1.0;
    cell.planes.push_back({normal, bounds.upper[axis]});
  }
  for (std::uint32_t k = 0; k < 8; ++k) {
    CellCorner corner;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t upper = k >> axis & 1;
      corner.point[axis] = upper != 0 ? bounds.upper[axis] : bounds.lower[axis];
      corner.planes.push_back(2 * axis + upper);
    }
    cell.corners.push_back(corner);
  }
  return cell;
}

std::array<Cell, 2> cut(const Cell& cell, const Plane& plane, const WindingBins& solid, double tolerance) {
  std::array<Cell, 2> sides;
  const auto number = static_cast<std::uint32_t>(cell.planes.size());
  for (Cell& side : sides) side.planes = cell.planes;
  sides[0].planes.push_back(plane);
  sides[1].planes.push_back({-1.0 * plane.normal, -plane.offset});
  std::vector<double> heights;
  for (const CellCorner& corner : cell.corners) heights.push_back(plane.height(corner.point));
  for (std::size_t i = 0; i < heights.size(); ++i) {
    CellCorner corner = cell.corners[i];
    if (heights[i] >= -tolerance && heights[i] <= tolerance) corner.planes.push_back(number);
    if (heights[i] <= tolerance) sides[0].corners.push_back(corner);
    if (heights[i] >= -tolerance) sides[1].corners.push_back(corner);
  }
  // Corners on two common planes span an edge, or a piece of one.
  for (std::size_t i = 0; i < heights.size(); ++i) {
    for (std::size_t j = 0; j < heights.size(); ++j) {
      if (!(heights[i] < -tolerance && heights[j] > tolerance)) continue;
      CellCorner corner;
      corner.planes = common(cell.corners[i], cell.corners[j]);
      if (corner.planes.size() < 2) continue;
      corner.planes.push_back(number);
      const double share = heights[i] / (heights[i] - heights[j]);
      corner.point = cell.corners[i].point + share * (cell.corners[j].point - cell.corners[i].point);
      corner.in_solid = solid.winding(corner.point) != 0;
      for (Cell& side : sides) side.corners.push_back(corner);
    }
  }
  return sides;
}

bool clip(const Cell& cell, Vector& from, Vector& to, double tolerance) {
  double start = 0.0, end = 1.0;
  for (const Plane& plane : cell.planes) {
    const double a = plane.height(from) + tolerance, b = plane.height(to) + tolerance;
    if (a > 0.0 && b > 0.0) return false;
    if (a > 0.0) start = std::max(start, a / (a - b));
    if (b > 0.0) end = std::min(end, a / (a - b));
  }
  if (!(start < end)) return false;
  const Vector edge = to - from;
  to = from + end * edge;
  from = from + start * edge;
  return true;
}

}  // namespace scree::decomposition
