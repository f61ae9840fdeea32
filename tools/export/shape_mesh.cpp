// See shape_mesh.h.
#include <tools/export/shape_mesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <variant>

namespace scree::exports {
namespace {

constexpr int kSides = 24, kRings = 12;

void add_triangle(ShapeMesh& mesh, std::size_t a, std::size_t b, std::size_t c) {
  for (const std::size_t index : {a, b, c}) mesh.indices.push_back(static_cast<std::uint32_t>(index));
}

// A convex polygon, counterclockwise seen from the tip of its normal.
void add_polygon(ShapeMesh& mesh, std::span<const Vec3> corners, Vec3 normal) {
  const std::size_t first = mesh.positions.size();
  for (const Vec3& corner : corners) {
    mesh.positions.push_back(corner);
    mesh.normals.push_back(normal);
  }
  for (std::size_t i = 2; i < corners.size(); ++i) add_triangle(mesh, first, first + i - 1, first + i);
}

// A point of a circle about the y axis.
Vec3 around(int side, float radius, float y) {
  const double angle = 2.0 * std::numbers::pi * side / kSides;
  return {radius * static_cast<float>(std::cos(angle)), y, -radius * static_cast<float>(std::sin(angle))};
}

// What is at directions from the south pole to the north pole, kSides + 1 a ring. The ring about the middle
// comes twice: `at` learns whether a direction belongs to the northern half.
template <class At>
ShapeMesh globe(const At& at) {
  static_assert(kRings % 2 == 0);
  ShapeMesh mesh;
  for (int row = 0; row <= kRings + 1; ++row) {
    const bool is_north = 2 * row > kRings;
    const int ring = is_north ? row - 1 : row;
    const bool is_pole = ring == 0 || ring == kRings;
    const double height = std::numbers::pi * (static_cast<double>(ring) / kRings - 0.5);
    const float radius = is_pole ? 0.0f : static_cast<float>(std::cos(height));
    for (int side = 0; side <= kSides; ++side) {
      const Vec3 direction = around(side % kSides, radius, static_cast<float>(std::sin(height)));
      mesh.positions.push_back(at(direction, is_north));
      mesh.normals.push_back(direction);
    }
  }
  constexpr std::size_t kRow = kSides + 1;
  for (std::size_t row = 0; row <= kRings; ++row) {
    for (std::size_t side = 0; side < kSides; ++side) {
      const std::size_t low = row * kRow + side, high = low + kRow;
      if (row > 0) add_triangle(mesh, low, low + 1, high + 1);
      if (row < kRings) add_triangle(mesh, low, high + 1, high);
    }
  }
  return mesh;
}

// The point of a hull, given by its corners, that is farthest along a direction, and the rounding beyond it.
ShapeMesh rounded(std::span<const Vec3> corners, float rounding) {
  return globe([&](Vec3 direction, bool) {
    const Vec3 farthest = *std::max_element(corners.begin(), corners.end(), [&](Vec3 a, Vec3 b) {
      return dot(a, direction) < dot(b, direction);
    });
    return farthest + rounding * direction;
  });
}

// Between two circles about the y axis, the upper of which may be a point, with a disk at each end.
ShapeMesh barrel(float half_height, float lower_radius, float upper_radius) {
  ShapeMesh mesh;
  const float rise = (lower_radius - upper_radius) / (2.0f * half_height);
  for (int side = 0; side <= kSides; ++side) {
    const Vec3 out = around(side % kSides, 1.0f, 0.0f);
    for (const bool upper : {false, true}) {
      mesh.positions.push_back(
          around(side % kSides, upper ? upper_radius : lower_radius, upper ? half_height : -half_height));
      mesh.normals.push_back(normalize(out + Vec3{0.0f, rise, 0.0f}));
    }
  }
  for (std::size_t side = 0; side < kSides; ++side) {
    const std::size_t low = 2 * side;
    add_triangle(mesh, low, low + 2, low + 3);
    if (upper_radius > 0.0f) add_triangle(mesh, low, low + 3, low + 1);
  }
  std::vector<Vec3> lower, upper;
  for (int side = 0; side < kSides; ++side) {
    lower.push_back(around((kSides - side) % kSides, lower_radius, -half_height));
    upper.push_back(around(side, upper_radius, half_height));
  }
  add_polygon(mesh, lower, {0.0f, -1.0f, 0.0f});
  if (upper_radius > 0.0f) add_polygon(mesh, upper, {0.0f, 1.0f, 0.0f});
  return mesh;
}

std::vector<Vec3> box_corners(Vec3 half) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back({i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
  return corners;
}

struct MeshOf {
  ShapeMesh operator()(const Sphere& s) const {
    return globe([&](Vec3 direction, bool) { return s.radius * direction; });
  }
  ShapeMesh operator()(const Capsule& s) const {
    return globe([&](Vec3 direction, bool is_north) {
      const float shift = is_north ? s.half_height : -s.half_height;
      return s.radius * direction + Vec3{0.0f, shift, 0.0f};
    });
  }
  ShapeMesh operator()(const Box& s) const {
    const std::vector<Vec3> corners = box_corners(s.half_extents);
    if (s.rounding > 0.0f) return rounded(corners, s.rounding);
    // By face: its corners, counterclockwise seen from outside.
    constexpr std::size_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    ShapeMesh mesh;
    for (int face = 0; face < 6; ++face) {
      Vec3 polygon[4], normal;
      for (int i = 0; i < 4; ++i) polygon[i] = corners[kFaces[face][i]];
      normal[face / 2] = face % 2 == 0 ? -1.0f : 1.0f;
      add_polygon(mesh, polygon, normal);
    }
    return mesh;
  }
  ShapeMesh operator()(const ConvexHull& s) const {
    std::vector<Vec3> corners;
    for (const Vec3& v : s.hull.vertices())
      corners.push_back({s.scale.x * v.x, s.scale.y * v.y, s.scale.z * v.z});
    if (s.rounding > 0.0f) return rounded(corners, s.rounding);
    ShapeMesh mesh;
    for (std::size_t face = 0; face < s.hull.face_count(); ++face) {
      std::vector<Vec3> polygon;
      for (const std::uint8_t corner : s.hull.face(face)) polygon.push_back(corners[corner]);
      Vec3 area;
      for (std::size_t i = 2; i < polygon.size(); ++i)
        area += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
      add_polygon(mesh, polygon, normalize(area));
    }
    return mesh;
  }
  ShapeMesh operator()(const TriangleMesh& s) const {
    ShapeMesh mesh;
    const std::span<const Vec3> vertices = s.vertices();
    std::size_t left = s.triangle_count();
    for (std::size_t i = 0; left > 0; ++i) {
      MeshTriangle triangle;
      try {
        triangle = s.triangle(i);
      } catch (const Error&) {  // this one was dropped
        continue;
      }
      --left;
      const Vec3 corners[] = {vertices[triangle.a], vertices[triangle.b], vertices[triangle.c]};
      add_polygon(mesh, corners, normalize(cross(corners[1] - corners[0], corners[2] - corners[0])));
    }
    return mesh;
  }
  ShapeMesh operator()(const HalfSpace&) const {
    constexpr float kHalf = 500.0f;  // m
    const Vec3 corners[] = {
        {-kHalf, 0.0f, kHalf}, {kHalf, 0.0f, kHalf}, {kHalf, 0.0f, -kHalf}, {-kHalf, 0.0f, -kHalf}};
    ShapeMesh mesh;
    add_polygon(mesh, corners, {0.0f, 1.0f, 0.0f});
    return mesh;
  }
  ShapeMesh operator()(const Cylinder& s) const { return barrel(s.half_height, s.radius, s.radius); }
  ShapeMesh operator()(const Cone& s) const { return barrel(s.half_height, s.radius, 0.0f); }
};

}  // namespace

ShapeMesh mesh_of(const Geometry& geometry) { return std::visit(MeshOf{}, geometry); }

Vec3 scale_of(const Geometry& geometry) {
  if (const auto* sphere = std::get_if<Sphere>(&geometry))
    return {sphere->radius, sphere->radius, sphere->radius};
  if (const auto* box = std::get_if<Box>(&geometry)) {
    if (box->rounding == 0.0f) return box->half_extents;
  }
  if (const auto* hull = std::get_if<ConvexHull>(&geometry)) {
    if (hull->rounding == 0.0f) return hull->scale;
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    return {cylinder->radius, cylinder->half_height, cylinder->radius};
  if (const auto* cone = std::get_if<Cone>(&geometry)) return {cone->radius, cone->half_height, cone->radius};
  return {1.0f, 1.0f, 1.0f};
}

Geometry unit_of(const Geometry& geometry) {
  if (std::holds_alternative<Sphere>(geometry)) return Sphere{1.0f};
  if (const auto* box = std::get_if<Box>(&geometry); box != nullptr && box->rounding == 0.0f)
    return Box{{1.0f, 1.0f, 1.0f}};
  if (const auto* hull = std::get_if<ConvexHull>(&geometry); hull != nullptr && hull->rounding == 0.0f)
    return ConvexHull{hull->hull};
  if (std::holds_alternative<Cylinder>(geometry)) return Cylinder{1.0f, 1.0f};
  if (std::holds_alternative<Cone>(geometry)) return Cone{1.0f, 1.0f};
  return geometry;
}

std::string key_of(const Geometry& geometry) {
  const Geometry unit = unit_of(geometry);
  std::string key = std::to_string(unit.index());
  const auto add_number = [&key](std::uint64_t number) {
    key += ',';
    key += std::to_string(number);
  };
  const auto add = [&](float number) { add_number(std::bit_cast<std::uint32_t>(number)); };
  const auto add_all = [&](std::span<const Vec3> points) {
    for (const Vec3& point : points) {
      for (int axis = 0; axis < 3; ++axis) add(point[axis]);
    }
  };
  if (const auto* capsule = std::get_if<Capsule>(&unit)) {
    add(capsule->half_height);
    add(capsule->radius);
  } else if (const auto* box = std::get_if<Box>(&unit)) {
    add_all({&box->half_extents, 1});
    add(box->rounding);
  } else if (const auto* hull = std::get_if<ConvexHull>(&unit)) {
    add_all(hull->hull.vertices());
    add_all({&hull->scale, 1});
    add(hull->rounding);
  } else if (const auto* mesh = std::get_if<TriangleMesh>(&unit)) {
    // Shapes share the geometry; equal meshes that were built separately are two.
    add_number(reinterpret_cast<std::uintptr_t>(mesh->vertices().data()));
  }
  return key;
}

}  // namespace scree::exports
