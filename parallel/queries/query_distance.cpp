// Distances and casts of solids; see query_distance.h.
#include <parallel/queries/query_distance.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::queries {

namespace {

// Whether along a direction a cone's apex is farther than its base.
bool is_apex_farthest(Vector half, Vector along) {
  return 2.0 * half.y * along.y > half.x * std::sqrt(along.x * along.x + along.z * along.z);
}

// The point of the core that is farthest along a direction, relative to the solid's position.
Vector farthest(const Solid& solid, Vector along) {
  const Vector local = turn_back(solid.axes, along);
  Vector corner;
  switch (solid.type) {
    case ShapeType::sphere:
    case ShapeType::mesh:  // has no core
    case ShapeType::half_space:
      return {};
    case ShapeType::capsule:
      return (local.y > 0.0 ? solid.half.y : -solid.half.y) * solid.axes.y;
    case ShapeType::cylinder:
    case ShapeType::cone: {
      const bool up = solid.type == ShapeType::cone ? is_apex_farthest(solid.half, local) : local.y > 0.0;
      if (up && solid.type == ShapeType::cone) return solid.half.y * solid.axes.y;
      const double across = std::sqrt(local.x * local.x + local.z * local.z);
      const double scale = across > 0.0 ? solid.half.x / across : 0.0;
      corner = {scale * local.x, up ? solid.half.y : -solid.half.y, scale * local.z};
      break;
    }
    case ShapeType::box:
    case ShapeType::rounded_box:
      corner = {local.x > 0.0 ? solid.half.x : -solid.half.x, local.y > 0.0 ? solid.half.y : -solid.half.y,
                local.z > 0.0 ? solid.half.z : -solid.half.z};
      break;
    case ShapeType::hull:
    case ShapeType::rounded_hull: {
      double most = -std::numeric_limits<double>::infinity();
      std::int32_t best = 0;
      for (std::int32_t i = 0; i < solid.corners; ++i) {
        const double reach =
            solid.corner[0][i] * local.x + solid.corner[1][i] * local.y + solid.corner[2][i] * local.z;
        if (reach > most) {
          most = reach;
          best = i;
        }
      }
      corner = {solid.corner[0][best], solid.corner[1][best], solid.corner[2][best]};
      break;
    }
  }
  return solid.axes * corner;
}

// A corner of the difference of two cores.
struct Corner {
  Vector difference, a, b;
};

struct Simplex {
  Corner corner[4];
  double weight[4] = {1.0, 0.0, 0.0, 0.0};  // of the corners in the point nearest to the origin
  int count = 0;
};

// The point nearest to the origin among those of faces, edges and corners of a simplex that have been tried.
class Nearest {
 public:
  explicit Nearest(const Simplex& simplex) : simplex_(simplex) {}

  void try_corner(int i) { take(at(i), {i, -1, -1}, {1.0, 0.0, 0.0}, 1); }
  void try_edge(int i, int j) {
    const Vector way = at(j) - at(i);
    const double size = dot(way, way);
    if (!(size > 0.0)) return;
    const double t = -dot(at(i), way) / size;
    if (t > 0.0 && t < 1.0) take(at(i) + t * way, {i, j, -1}, {1.0 - t, t, 0.0}, 2);
  }
  void try_face(int i, int j, int k) {
    const Vector normal = cross(at(j) - at(i), at(k) - at(i));
    const double size = dot(normal, normal);
    if (!(size > 0.0)) return;
    const double weight_i = dot(normal, cross(at(j), at(k))) / size;
    const double weight_j = dot(normal, cross(at(k), at(i))) / size;
    const double weight_k = dot(normal, cross(at(i), at(j))) / size;
    if (!(weight_i > 0.0 && weight_j > 0.0 && weight_k > 0.0)) return;
    // Along the normal: the sum of the corners would lose its direction near the origin.
    take((dot(normal, at(i)) / size) * normal, {i, j, k}, {weight_i, weight_j, weight_k}, 3);
  }
  // Whether the origin lies in the tetrahedron. A flat one, whose sides rounding decides, holds nothing.
  bool holds_origin() const {
    constexpr double kFlat = 1e-15;  // of the corners' distances from the origin
    double largest = 0.0;
    for (int i = 0; i < 4; ++i) largest = std::max(largest, dot(at(i), at(i)));
    constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    for (const auto& face : kFaces) {
      const Vector normal = cross(at(face[1]) - at(face[0]), at(face[2]) - at(face[0]));
      const double other = dot(normal, at(face[3]) - at(face[0])), origin = -dot(normal, at(face[0]));
      if (!(other * other > kFlat * kFlat * largest * dot(normal, normal))) return false;
      if (other > 0.0 ? origin < 0.0 : origin > 0.0) return false;
    }
    return true;
  }
  Vector point() const { return point_; }
  Simplex reduced() const {
    Simplex small;
    small.count = count_;
    for (int i = 0; i < count_; ++i) {
      small.corner[i] = simplex_.corner[index_[i]];
      small.weight[i] = weight_[i];
    }
    return small;
  }

 private:
  Vector at(int i) const { return simplex_.corner[i].difference; }
  void take(Vector point, const int (&index)[3], const double (&weight)[3], int count) {
    const double size = dot(point, point);
    if (!(size < size_)) return;
    size_ = size;
    point_ = point;
    count_ = count;
    for (int i = 0; i < 3; ++i) {
      index_[i] = index[i];
      weight_[i] = weight[i];
    }
  }

  const Simplex& simplex_;
  double size_ = std::numeric_limits<double>::infinity();
  Vector point_;
  int index_[3] = {0, 0, 0}, count_ = 0;
  double weight_[3] = {1.0, 0.0, 0.0};
};

// Reduces the simplex to the part that is nearest to the origin, and returns the point there. Returns false
// if it holds the origin.
bool reduce(Simplex& simplex, Vector& point) {
  Nearest nearest(simplex);
  const int count = simplex.count;
  if (count == 4 && nearest.holds_origin()) return false;
  const int last = count - 1;
  nearest.try_corner(last);
  for (int i = 0; i < last; ++i) {
    nearest.try_edge(i, last);
    for (int j = i + 1; j < last; ++j) nearest.try_face(i, j, last);
  }
  point = nearest.point();
  simplex = nearest.reduced();
  return true;
}

// A half-space has no core: what is nearest to it is the other solid's lowest point.
Gap gap_to_half_space(const Solid& a, const Solid& half_space, Vector place) {
  const Vector up = half_space.axes.y;
  const Vector lowest = place + farthest(a, -up) - a.radius * up;
  Gap gap;
  gap.distance = dot(up, lowest);
  if (!(gap.distance > 0.0)) return gap;
  gap.normal = -up;
  gap.on_a = lowest;
  gap.on_b = lowest - gap.distance * up;
  return gap;
}

bool same(Vector a, Vector b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool has(const Simplex& simplex, const Corner& corner) {
  for (int i = 0; i < simplex.count; ++i) {
    if (same(simplex.corner[i].a, corner.a) && same(simplex.corner[i].b, corner.b)) return true;
  }
  return false;
}

// The difference of cores that is nearest to the origin; false if they overlap.
bool separate(const Solid& a, const Solid& b, Vector place, Simplex& simplex, Vector& nearest) {
  constexpr int kMostSteps = 200;      // 5 to 10 are usual
  constexpr double kRounding = 1e-14;  // of the corners' coordinates: a few units in the last place
  constexpr double kNoNearer = 1e-13;  // of the distance
  const auto corner_along = [&](Vector along) {
    const Vector on_a = place + farthest(a, along), on_b = farthest(b, -along);
    return Corner{on_a - on_b, on_a, on_b};
  };
  simplex.corner[0] = corner_along(-place);
  simplex.count = 1;
  nearest = simplex.corner[0].difference;
  double largest = dot(nearest, nearest);
  bool apart = false;  // a plane between the cores has been found
  for (int step = 0; step < kMostSteps; ++step) {
    const double size = dot(nearest, nearest);
    if (!(size > kRounding * kRounding * largest)) return false;
    const Corner corner = corner_along(-nearest);
    largest = std::max(largest, dot(corner.difference, corner.difference));
    const double reached = dot(nearest, corner.difference), still = size - reached;
    apart = apart || reached > kRounding * std::sqrt(size * largest);
    if (still <= kNoNearer * size + kRounding * std::sqrt(size * largest) || has(simplex, corner)) break;
    Simplex grown = simplex;
    grown.corner[grown.count++] = corner;
    Vector point;
    if (!reduce(grown, point)) {
      if (apart) break;  // what holds the origin is so flat that rounding decides
      return false;
    }
    if (!(dot(point, point) < size)) break;
    simplex = grown;
    nearest = point;
  }
  return true;
}

}  // namespace

Gap gap_between(const Solid& a, const Solid& b, Vector shift) {
  const Vector place = (a.position - b.position) + shift;
  if (b.type == ShapeType::half_space) return gap_to_half_space(a, b, place);
  Simplex simplex;
  Vector nearest;
  Gap gap;
  gap.distance = -1.0;
  if (!separate(a, b, place, simplex, nearest)) return gap;
  const double size = length(nearest);
  gap.distance = size - (a.radius + b.radius);
  if (!(gap.distance > 0.0)) return gap;
  gap.normal = (-1.0 / size) * nearest;
  for (int i = 0; i < simplex.count; ++i) gap.on_b = gap.on_b + simplex.weight[i] * simplex.corner[i].b;
  gap.on_a = gap.on_b + nearest + a.radius * gap.normal;
  gap.on_b = gap.on_b - b.radius * gap.normal;
  return gap;
}

bool meet(const Solid& a, Vector way, const Solid& b, double most, Contact& contact) {
  constexpr int kMostSteps = 100;  // 2 to 5 are usual; where solids graze, each step quarters the distance
  // m and of the solids' sizes: how near solids come before they count as touching. Far enough for a normal.
  constexpr double kTouching = 1e-9, kTouchingShare = 1e-11;
  const double target = kTouching + kTouchingShare * (length(a.half) + a.radius + length(b.half) + b.radius);
  contact = {};
  double fraction = 0.0;
  Gap gap = gap_between(a, b);
  if (!(gap.distance > 0.0)) {
    contact.inside = true;
    return true;
  }
  // The distance is a convex function of the fraction. Newton's method comes to its first zero from the left,
  // because tangents never lie above it.
  for (int step = 0; step < kMostSteps; ++step) {
    const double speed = dot(gap.normal, way);
    if (!(speed > 0.0)) return false;
    if (gap.distance <= 2.0 * target) break;
    fraction += (gap.distance - target) / speed;
    if (!(fraction <= most)) return false;
    const Gap next = gap_between(a, b, fraction * way);
    if (!(next.distance > 0.0)) break;  // by rounding; what was found before is as near
    gap = next;
  }
  contact.fraction = fraction;
  contact.normal = -gap.normal;
  contact.point = b.position + gap.on_b;
  return true;
}

}  // namespace scree::queries
