// Smooth shapes: the closest points of two cores.
//
// The distance of two convex sets is that of their Minkowski difference from the origin. A simplex of points
// of the difference approaches it, each point the farthest against the way found so far (E. G. Gilbert, D. W.
// Johnson, S. S. Keerthi, "A fast procedure for computing the distance between complex objects in
// three-dimensional space", IEEE J. Robotics and Automation 4(2), 1988). The closest point of a simplex is
// found by its regions (C. Ericson, "Real-Time Collision Detection", 2005, 5.1); the end by bounds from both
// sides (G. van den Bergen, "A fast and robust GJK implementation for collision detection of convex objects",
// J. Graphics Tools 4(2), 1999).
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kMostSteps = 64;
// The distance is right to this share of its square.
constexpr double kEnough = 1e-10;
// Below this share of the shapes' sizes and their distance, a gap is rounding: the cores overlap.
constexpr double kTouching = 1e-9;
// Of squared sines and volumes: below it, a simplex is flat.
constexpr double kFlatSimplex = 1e-18;

// Of the difference, and the points of both cores that it comes from.
struct Corner {
  D3 w, on_1, on_2;
};
struct Simplex {
  int count = 0;
  Corner corner[4]{};
  double weight[4]{};
};

// Weights of up to three corners by number; others are dropped.
struct Nearest {
  int count;
  int corner[3];
  double weight[3];
  D3 point;
};
Nearest nearest_of_corner(const Simplex& s, int i) { return {1, {i}, {1.0}, s.corner[i].w}; }
Nearest nearest_of_segment(const Simplex& s, int i, int j) {
  const D3 a = s.corner[i].w, way = s.corner[j].w - a;
  const double squared = dot(way, way), t = squared > 0.0 ? -dot(a, way) / squared : 0.0;
  if (!(t > 0.0)) return nearest_of_corner(s, i);
  if (t >= 1.0) return nearest_of_corner(s, j);
  Nearest n{2, {i, j}, {1.0 - t, t}, {}};
  n.point = a + t * way;
  return n;
}
Nearest nearer_of(const Nearest& a, const Nearest& b) {
  return dot(b.point, b.point) < dot(a.point, a.point) ? b : a;
}
Nearest nearest_of_triangle(const Simplex& s, int i, int j, int k) {
  const D3 a = s.corner[i].w, b = s.corner[j].w, c = s.corner[k].w;
  const D3 ab = b - a, ac = c - a, across = cross(ab, ac);
  const double area = dot(across, across);
  if (area > kFlatSimplex * dot(ab, ab) * dot(ac, ac)) {
    // Of the origin's projection onto the plane.
    const double u = dot(cross(b, c), across), v = dot(cross(c, a), across), w = dot(cross(a, b), across);
    if (u > 0.0 && v > 0.0 && w > 0.0) {
      const double scale = 1.0 / (u + v + w);
      Nearest n{3, {i, j, k}, {scale * u, scale * v, scale * w}, {}};
      n.point = (dot(a, across) / area) * across;
      return n;
    }
  }
  return nearer_of(nearer_of(nearest_of_segment(s, i, j), nearest_of_segment(s, j, k)),
                   nearest_of_segment(s, i, k));
}
// False: the origin lies within.
bool nearest_of_tetrahedron(const Simplex& s, Nearest& nearest) {
  constexpr int kFace[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  bool outside = false;
  for (const auto& face : kFace) {
    const D3 a = s.corner[face[0]].w, ab = s.corner[face[1]].w - a, ac = s.corner[face[2]].w - a,
             ad = s.corner[face[3]].w - a;
    const D3 across = cross(ab, ac);
    const double side = dot(across, ad), origin = -dot(across, a);
    const bool is_flat = side * side <= kFlatSimplex * dot(across, across) * dot(ad, ad);
    if (!is_flat && side * origin >= 0.0) continue;
    const Nearest n = nearest_of_triangle(s, face[0], face[1], face[2]);
    nearest = outside ? nearer_of(nearest, n) : n;
    outside = true;
  }
  return outside;
}
bool nearest_of(const Simplex& s, Nearest& nearest) {
  switch (s.count) {
    case 1:
      nearest = nearest_of_corner(s, 0);
      return true;
    case 2:
      nearest = nearest_of_segment(s, 0, 1);
      return true;
    case 3:
      nearest = nearest_of_triangle(s, 0, 1, 2);
      return true;
    default:
      return nearest_of_tetrahedron(s, nearest);
  }
}

// Corners move down only: those of the nearest ones ascend.
void keep(const Nearest& nearest, Simplex& s) {
  for (int k = 0; k < nearest.count; ++k) {
    if (nearest.corner[k] != k) s.corner[k] = s.corner[nearest.corner[k]];
    s.weight[k] = nearest.weight[k];
  }
  s.count = nearest.count;
}

bool has(const Simplex& s, D3 w) {
  for (int k = 0; k < s.count; ++k) {
    const D3& own = s.corner[k].w;
    if (own.x == w.x && own.y == w.y && own.z == w.z) return true;
  }
  return false;
}

}  // namespace

Nearness find_distance(const Core& a, const Core& b, D3 start, double limit, Gap& gap) {
  const double size = a.size + b.size + length(b.center - a.center);
  const double touching = kTouching * size;
  Simplex s;
  D3 way = start;  // from the first core to the second, with the closest point of the simplex
  double squared = 1e300;
  for (int step = 0; step < kMostSteps; ++step) {
    const D3 on_1 = farthest_point(a, way), on_2 = farthest_point(b, -way), w = on_2 - on_1;
    const double bound = dot(way, w);
    if (bound > 0.0 && bound * bound > limit * limit * dot(way, way)) return Nearness::far;
    if (s.count > 0 && (squared - bound <= kEnough * squared || has(s, w))) break;
    s.corner[s.count++] = {w, on_1, on_2};
    Nearest nearest;
    if (!nearest_of(s, nearest)) return Nearness::overlap;
    const double next = dot(nearest.point, nearest.point);
    if (next <= touching * touching) return Nearness::overlap;
    if (!(next < squared)) {  // for rounding: the last corner brings nothing
      --s.count;
      break;
    }
    keep(nearest, s);
    way = nearest.point;
    squared = next;
  }
  const double distance = root(squared);
  gap.separation = distance;
  gap.normal = (1.0 / distance) * way;
  gap.on_1 = gap.on_2 = {0.0, 0.0, 0.0};
  for (int k = 0; k < s.count; ++k) {
    gap.on_1 = gap.on_1 + s.weight[k] * s.corner[k].on_1;
    gap.on_2 = gap.on_2 + s.weight[k] * s.corner[k].on_2;
  }
  return Nearness::apart;
}

void measure_along(const Core& a, const Core& b, Gap& gap) {
  gap.on_1 = farthest_point(a, gap.normal);
  gap.on_2 = farthest_point(b, -gap.normal);
  gap.separation = dot(gap.normal, gap.on_2 - gap.on_1);
}

bool find_gap(const Core& a, const Core& b, const D3* known, double limit, Gap& gap) {
  const double margins = a.margin + b.margin;
  if (known != nullptr && is_shallow_overlap(a, b, *known, gap)) return true;
  D3 start = known != nullptr ? *known : b.center - a.center;
  if (!(dot(start, start) > 0.0)) start = {0.0, 1.0, 0.0};
  switch (find_distance(a, b, start, limit + margins, gap)) {
    case Nearness::far:
      return false;
    case Nearness::apart:
      return gap.separation - margins <= limit;
    case Nearness::overlap:
      find_depth(a, b, known, gap);
      return true;
  }
  return false;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
