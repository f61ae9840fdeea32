// The mesh that is decomposed, in canonical order, and what is asked of it: where a point lies, and how far
// it is from the surface.
#pragma once

#include <core/geometry/hull/hull_numbers.h>
#include <scree/mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scree::decomposition {

using Triangle = std::array<std::uint32_t, 3>;

struct Bounds {
  Vector lower{}, upper{};  // m

  double extent() const;  // m, the largest one
  void include(const Vector& point);
};

// Triangles of three different places, the lowest one first, ascending. So the order in which vertices and
// triangles were handed in is forgotten.
struct Surface {
  std::vector<Vector> points;  // m, the different places, ascending
  std::vector<Triangle> triangles;

  Bounds bounds() const;  // of the points that triangles have
  double volume() const;  // m^3, signed
};

// Leaves out triangles that have equal corners, and pairs that cover each other back to back; counts them.
Surface make_surface(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                     std::size_t& dropped_triangles);

// Triangles by their places seen along x, so that a ray along x meets few.
class WindingBins {
 public:
  explicit WindingBins(const Surface& surface);
  // How often the surface goes around the point. Exactly consistent: on every line along x it is 0 at both
  // ends. A point that rounding cannot tell from the surface is on either side.
  int winding(const Vector& point) const;

 private:
  std::size_t bin_of(double coordinate, std::size_t axis) const;

  const Surface& surface_;
  Bounds bounds_;
  std::size_t count_ = 1;  // along y and along z
  double inverse_size_[2]{};
  std::vector<std::uint32_t> begin_, triangles_;
};

// The distance to the nearest triangle: a tree of boxes.
class NearestTriangles {
 public:
  explicit NearestTriangles(const Surface& surface);
  // m^2; exact but for rounding, unless it is at most `enough`: then it is any distance that is.
  double distance_squared(const Vector& point, double enough = 0.0) const;

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t first = 0;  // of a leaf: its first triangle; else its second child, the first one follows
    std::uint32_t count = 0;  // triangles of a leaf; 0: an inner node
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t end, std::vector<Vector>& middles);

  const Surface& surface_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// m^2, of a point from a triangle.
double distance_squared(const Vector& point, const Vector& a, const Vector& b, const Vector& c);

}  // namespace scree::decomposition
