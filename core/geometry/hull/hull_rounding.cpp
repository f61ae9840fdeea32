// Volume integrals of a rounded hull; see hull_topology.h.
//
// All points within a distance r of a polyhedron are the polyhedron, a prism on each face, a sector of a
// cylinder along each edge and a sector of a ball at each vertex (J. Steiner, 1840). A sector's directions
// are those in which its edge or vertex is the farthest of the hull: an arc or a spherical polygon. Of
// polygons, integrals of u and u u^T are sums over their arcs, by the divergence theorem on the sphere, and
// the area is what the angles of the faces at the vertex lack to a full turn.
#include <core/geometry/hull/hull_numbers.h>
#include <core/geometry/hull/hull_topology.h>
#include <core/geometry/solid_integrals.h>
#include <core/world/math.h>

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <vector>

namespace scree {

namespace {

constexpr double kPi = std::numbers::pi;

// About the origin.
struct Moments {
  double volume = 0.0;
  Vector first{};
  double second[6]{};

  void add_first(double weight, const Vector& a) { first = first + weight * a; }
  // weight (a b^T + b a^T) / 2
  void add_second(double weight, const Vector& a, const Vector& b) {
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t i = kMomentRow[k], j = kMomentColumn[k];
      second[k] += 0.5 * weight * (a[i] * b[j] + a[j] * b[i]);
    }
  }
};

double length(const Vector& v) { return std::sqrt(dot(v, v)); }

// The angle in [0, pi] of a sine, at least zero, and a cosine of any scale.
double arc_of_half_turn(double sine, double cosine) {
  if (!(sine > 0.0)) return cosine < 0.0 ? kPi : 0.0;
  return cosine < 0.0 ? kPi - arc_of(sine, -cosine) : arc_of(sine, cosine);
}

// What the parts are made of: the hull, stretched, and what a vertex's part needs of its edges and faces.
struct Stretched {
  const HullTopology& topology;
  std::vector<Vector> vertices, normals;
  // Of each vertex's spherical polygon: what the faces' angles leave, and sums over its arcs of
  // (angle times outward normal) and of (integral of u) (outward normal)^T.
  struct Cap {
    double area = 2.0 * kPi;
    Vector first{};
    double second[6]{};
  };
  std::vector<Cap> caps;

  Vector corner(std::size_t place) const { return vertices[topology.loops[place]]; }
};

Stretched stretch(const HullTopology& topology, const double (&scale)[3]) {
  Stretched hull{topology, {}, {}, {}};
  for (const Vec3& v : topology.vertices)
    hull.vertices.push_back({scale[0] * double{v.x}, scale[1] * double{v.y}, scale[2] * double{v.z}});
  hull.caps.resize(hull.vertices.size());
  for (std::size_t f = 0; f + 1 < topology.begin.size(); ++f) {
    const std::size_t begin = topology.begin[f], end = topology.begin[f + 1];
    const Vector first = hull.corner(begin);
    Vector normal{};
    for (std::size_t k = begin + 1; k + 1 < end; ++k)
      normal = normal + cross(hull.corner(k) - first, hull.corner(k + 1) - first);
    hull.normals.push_back((1.0 / length(normal)) * normal);
  }
  return hull;
}

// The prism of height r on a face.
void add_face(Stretched& hull, std::size_t face, double r, Moments& sums) {
  const std::size_t begin = hull.topology.begin[face], end = hull.topology.begin[face + 1];
  const Vector normal = hull.normals[face], first = hull.corner(begin);
  double area = 0.0;
  Vector area_first{};
  for (std::size_t k = begin + 1; k + 1 < end; ++k) {
    const Vector second = hull.corner(k), third = hull.corner(k + 1), sum = first + second + third;
    const double part = 0.5 * dot(cross(second - first, third - first), normal);
    area += part;
    area_first = area_first + (part / 3.0) * sum;
    for (const Vector& corner : {first, second, third, sum}) sums.add_second(r * part / 12.0, corner, corner);
  }
  sums.volume += r * area;
  sums.add_first(r, area_first);
  sums.add_first(0.5 * r * r * area, normal);
  sums.add_second(r * r, area_first, normal);
  sums.add_second(r * r * r / 3.0 * area, normal, normal);
  for (std::size_t k = begin; k < end; ++k) {
    const Vector corner = hull.corner(k);
    const Vector back = hull.corner(k > begin ? k - 1 : end - 1) - corner,
                 forth = hull.corner(k + 1 < end ? k + 1 : begin) - corner;
    hull.caps[hull.topology.loops[k]].area -= arc_of_half_turn(length(cross(forth, back)), dot(forth, back));
  }
}

// The sector along an edge, whose directions turn by `angle` from one face's normal to the other's.
void add_edge(Stretched& hull, const HullTopology::Edge& edge, double r, Moments& sums) {
  const Vector from = hull.vertices[edge.vertex[0]], to = hull.vertices[edge.vertex[1]];
  const double size = length(to - from);
  const Vector along = (1.0 / size) * (to - from);
  const Vector normal = hull.normals[edge.face[0]], aside = cross(along, normal);
  const double cosine = dot(normal, hull.normals[edge.face[1]]);
  const double sine = std::max(dot(aside, hull.normals[edge.face[1]]), 0.0);
  const double angle = arc_of_half_turn(sine, cosine);
  const Vector arc = sine * normal + (1.0 - cosine) * aside;  // integral of the directions u
  const Vector middle = 0.5 * (from + to);
  const double sector = 0.5 * angle * r * r, third = r * r * r / 3.0, fourth = 0.25 * r * r * r * r * size;
  sums.volume += size * sector;
  sums.add_first(size * sector, middle);
  sums.add_first(size * third, arc);
  sums.add_second(size * sector, middle, middle);
  sums.add_second(size * size * size / 12.0 * sector, along, along);
  sums.add_second(2.0 * size * third, middle, arc);
  sums.add_second(fourth * 0.5 * (angle + sine * cosine), normal, normal);
  sums.add_second(fourth * sine * sine, normal, aside);
  sums.add_second(fourth * 0.5 * (angle - sine * cosine), aside, aside);
  for (int end = 0; end < 2; ++end) {
    Stretched::Cap& cap = hull.caps[edge.vertex[end]];
    const Vector outward = (end == 0 ? 1.0 : -1.0) * along;
    cap.first = cap.first + angle * outward;
    Moments part;
    part.add_second(1.0, arc, outward);
    for (int k = 0; k < 6; ++k) cap.second[k] += part.second[k];
  }
}

// The sector at a vertex.
void add_vertex(const Stretched& hull, std::size_t vertex, double r, Moments& sums) {
  const Stretched::Cap& cap = hull.caps[vertex];
  const Vector& place = hull.vertices[vertex];
  const Vector first = -0.5 * cap.first;  // integral of the directions u
  const double third = r * r * r / 3.0, fourth = 0.25 * r * r * r * r, fifth = 0.2 * r * r * r * r * r;
  sums.volume += cap.area * third;
  sums.add_first(cap.area * third, place);
  sums.add_first(fourth, first);
  sums.add_second(cap.area * third, place, place);
  sums.add_second(2.0 * fourth, place, first);
  for (int k = 0; k < 6; ++k) {
    const double own = kMomentRow[k] == kMomentColumn[k] ? cap.area : 0.0;
    sums.second[k] += fifth * (own - cap.second[k]) / 3.0;
  }
}

}  // namespace

HullIntegrals integrate_rounded(const HullTopology& topology, const HullIntegrals& within,
                                const double (&scale)[3], double rounding) {
  Stretched hull = stretch(topology, scale);
  Moments sums;
  const double stretched = scale[0] * scale[1] * scale[2];
  sums.volume = stretched * within.volume;
  Vector center{};
  for (std::size_t i = 0; i < 3; ++i) center[i] = scale[i] * within.center[i];
  sums.add_first(sums.volume, center);
  sums.add_second(sums.volume, center, center);
  for (int k = 0; k < 6; ++k)
    sums.second[k] += stretched * scale[kMomentRow[k]] * scale[kMomentColumn[k]] * within.moment[k];
  for (std::size_t face = 0; face < hull.normals.size(); ++face) add_face(hull, face, rounding, sums);
  for (const HullTopology::Edge& edge : topology.edges) add_edge(hull, edge, rounding, sums);
  for (std::size_t vertex = 0; vertex < hull.vertices.size(); ++vertex)
    add_vertex(hull, vertex, rounding, sums);
  HullIntegrals integrals;
  integrals.volume = sums.volume;
  center = (1.0 / sums.volume) * sums.first;
  std::copy(center.begin(), center.end(), integrals.center);
  sums.add_second(-sums.volume, center, center);
  std::copy_n(sums.second, 6, integrals.moment);
  return integrals;
}

}  // namespace scree
