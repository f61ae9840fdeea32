// Meshes for tests of queries and sweeps, and what these answer by brute force over all triangles, in double
// precision.
#pragma once

#include <tests/parallel/queries/query_fixture.h>

#include <scree/triangle_mesh.h>

#include <limits>
#include <vector>

namespace scree::testing {

struct TriangleSoup {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;

  TriangleMesh mesh() const { return TriangleMesh(vertices, triangles); }
};

// A closed surface about the origin, star-shaped, seen from outside: rings of points on rays from the origin.
inline TriangleSoup bumpy_ball(Dice& dice, int rings, int around, float least, float most) {
  TriangleSoup soup;
  const double pi = 3.14159265358979323846;
  const auto at = [&](double polar, double turn) {
    const double size = dice.uniform(least, most);
    soup.vertices.push_back({static_cast<float>(size * std::sin(polar) * std::cos(turn)),
                             static_cast<float>(size * std::cos(polar)),
                             static_cast<float>(size * std::sin(polar) * std::sin(turn))});
  };
  at(0.0, 0.0);
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < around; ++j) at(pi * i / rings, 2.0 * pi * j / around);
  }
  at(pi, 0.0);
  const auto row = [&](int i, int j) {
    if (i == 0) return 0u;
    if (i == rings) return static_cast<std::uint32_t>(soup.vertices.size() - 1);
    return static_cast<std::uint32_t>(1 + (i - 1) * around + j % around);
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      if (i > 0) soup.triangles.push_back({row(i, j), row(i, j + 1), row(i + 1, j)});
      if (i < rings - 1) soup.triangles.push_back({row(i, j + 1), row(i + 1, j + 1), row(i + 1, j)});
    }
  }
  return soup;
}

// Triangles at random, `size` each.
inline TriangleSoup random_soup(Dice& dice, int count, float reach, float size) {
  TriangleSoup soup;
  for (int i = 0; i < count; ++i) {
    const Vec3 middle = dice.within({reach, reach, reach});
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(middle + dice.within({size, size, size}));
    const auto first = static_cast<std::uint32_t>(3 * i);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

// A ground seen from above: squares of one meter, two triangles each, with heights of whole meters, so that
// all coordinates are exact.
inline TriangleSoup whole_meters(Dice& dice, int squares, std::uint32_t heights) {
  TriangleSoup soup;
  const auto side = static_cast<std::uint32_t>(squares + 1);
  for (int x = 0; x <= squares; ++x) {
    for (int z = 0; z <= squares; ++z) {
      soup.vertices.push_back(
          {static_cast<float>(x), static_cast<float>(dice.below(heights)), static_cast<float>(z)});
    }
  }
  for (std::uint32_t x = 0; x + 1 < side; ++x) {
    for (std::uint32_t z = 0; z + 1 < side; ++z) {
      const std::uint32_t a = x * side + z, b = a + 1, c = a + side, d = c + 1;
      soup.triangles.push_back({a, b, d});
      soup.triangles.push_back({a, d, c});
    }
  }
  return soup;
}

struct Triangle {
  Point corner[3];

  Point normal() const {
    const Point n = cross(corner[1] - corner[0], corner[2] - corner[0]);
    return (1.0 / norm(n)) * n;
  }
};

// In the world, by given number.
inline std::vector<Triangle> triangles_of(const World& world, ShapeId shape, const TriangleSoup& soup) {
  const Pose pose = world.pose(world.body_of(shape)), local = world.local_pose(shape);
  const auto place = [&](Vec3 v) {
    const Point in_body = to_point(local.position) + turn(local.rotation, to_point(v));
    return to_point(pose.position) + turn(pose.rotation, in_body);
  };
  std::vector<Triangle> all;
  for (const MeshTriangle& t : soup.triangles)
    all.push_back({{place(soup.vertices[t.a]), place(soup.vertices[t.b]), place(soup.vertices[t.c])}});
  return all;
}

// Where a line crosses the plane of a triangle, and how far within its edges (below zero: outside).
struct Crossing {
  double fraction = -1.0, within = -1e300;
  bool from_front = false;
};
inline Crossing crossing_of(const Triangle& triangle, Point origin, Point way) {
  const Point n = triangle.normal();
  const double speed = dot(n, way);
  if (speed == 0.0) return {};
  Crossing crossing;
  crossing.from_front = speed < 0.0;
  crossing.fraction = dot(n, triangle.corner[0] - origin) / speed;
  const Point at = origin + crossing.fraction * way;
  crossing.within = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Point edge = triangle.corner[(i + 1) % 3] - triangle.corner[i];
    const double inward = dot(cross(n, edge), at - triangle.corner[i]) / norm(edge);
    crossing.within = std::min(crossing.within, inward);
  }
  return crossing;
}

inline double distance_of_segments(Point a, Point b, Point c, Point d) {
  const Point u = b - a, v = d - c, w = a - c;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  const double area = uu * vv - uv * uv;
  double nearest = std::numeric_limits<double>::infinity();
  const auto take = [&](double s, double t) {
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) nearest = std::min(nearest, norm(w + s * u - t * v));
  };
  if (area > 0.0) take((uv * vw - vv * uw) / area, (uu * vw - uv * uw) / area);
  const auto part = [](double x, double size) { return size > 0.0 ? std::clamp(x / size, 0.0, 1.0) : 0.0; };
  take(0.0, part(vw, vv));
  take(1.0, part(vw + uv, vv));
  take(part(-uw, uu), 0.0);
  take(part(uv - uw, uu), 1.0);
  return nearest;
}

inline double distance_from(const Triangle& triangle, Point p) {
  const Point n = triangle.normal();
  const Crossing crossing = crossing_of(triangle, p, n);
  if (crossing.within >= 0.0) return std::abs(crossing.fraction);
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i)
    nearest = std::min(nearest, distance_of_segments(p, p, triangle.corner[i], triangle.corner[(i + 1) % 3]));
  return nearest;
}

inline double distance_from(const Triangle& triangle, Point a, Point b) {
  const Crossing crossing = crossing_of(triangle, a, b - a);
  if (crossing.within >= 0.0 && crossing.fraction >= 0.0 && crossing.fraction <= 1.0) return 0.0;
  double nearest = std::min(distance_from(triangle, a), distance_from(triangle, b));
  for (int i = 0; i < 3; ++i)
    nearest = std::min(nearest, distance_of_segments(a, b, triangle.corner[i], triangle.corner[(i + 1) % 3]));
  return nearest;
}

// A convex shape for brute force: points, the segments between those that are neighbors, its faces and the
// radius about all.
struct Brute {
  std::vector<Triangle> faces;
  Point a, b;
  double radius = 0.0;
};
inline Brute brute_of(const Geometry& geometry, const Pose& pose) {
  const Point position = to_point(pose.position);
  const auto place = [&](Point p) { return position + turn(pose.rotation, p); };
  Brute brute;
  brute.a = brute.b = position;
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    brute.radius = sphere->radius;
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry)) {
    brute.a = place({0, capsule->half_height, 0});
    brute.b = place({0, -capsule->half_height, 0});
    brute.radius = capsule->radius;
  } else if (const auto* box = std::get_if<Box>(&geometry)) {
    const Vec3 h = box->half_extents;
    const auto corner = [&](int i) {
      return place({(i & 1) != 0 ? h.x : -h.x, (i & 2) != 0 ? h.y : -h.y, (i & 4) != 0 ? h.z : -h.z});
    };
    constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    for (const auto& face : kFaces) {
      brute.faces.push_back({{corner(face[0]), corner(face[1]), corner(face[2])}});
      brute.faces.push_back({{corner(face[0]), corner(face[2]), corner(face[3])}});
    }
  } else {
    const auto& convex = std::get<ConvexHull>(geometry);
    const std::vector<Point> corners = hull_corners(convex);
    for (std::size_t f = 0; f < convex.hull.face_count(); ++f) {
      const auto loop = convex.hull.face(f);
      for (std::size_t i = 2; i < loop.size(); ++i)
        brute.faces.push_back(
            {{place(corners[loop[0]]), place(corners[loop[i - 1]]), place(corners[loop[i]])}});
    }
  }
  return brute;
}

// Not above zero where they overlap, unless the shape holds the whole triangle.
inline double distance_of(const Brute& shape, const Triangle& triangle, Point shift = {}) {
  if (shape.faces.empty()) return distance_from(triangle, shape.a + shift, shape.b + shift) - shape.radius;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& face : shape.faces) {
    Triangle moved = face;
    for (Point& corner : moved.corner) corner = corner + shift;
    for (int i = 0; i < 3; ++i) {
      nearest = std::min(nearest, distance_from(triangle, moved.corner[i], moved.corner[(i + 1) % 3]));
      nearest = std::min(nearest, distance_from(moved, triangle.corner[i], triangle.corner[(i + 1) % 3]));
    }
  }
  return nearest;
}

// How far the shape reaches from its position.
inline double reach_of(const Brute& brute, const Pose& pose) {
  const Point position = to_point(pose.position);
  double reach = norm(brute.a - position) + brute.radius;
  for (const Triangle& face : brute.faces) {
    for (const Point& corner : face.corner) reach = std::max(reach, norm(corner - position));
  }
  return reach;
}

// Whether a triangle is too far from the way of what lies within `reach` of a point to be met on it.
inline bool is_off_the_way(const Triangle& triangle, Point from, Point way, double reach) {
  const Point middle = (1.0 / 3.0) * (triangle.corner[0] + triangle.corner[1] + triangle.corner[2]);
  double size = reach + 1e-3;
  for (const Point& corner : triangle.corner) size = std::max(size, reach + 1e-3 + norm(corner - middle));
  return distance_of_segments(from, from + way, middle, middle) > size;
}

}  // namespace scree::testing
