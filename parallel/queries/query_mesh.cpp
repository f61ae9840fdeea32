// Meshes as queries meet them; see query_mesh.h. Works in the mesh's frame.
//
// A ray is followed from where it enters the mesh's box, so that its numbers are of the mesh's size. Whether
// it passes within a triangle is asked as S. Woop, C. Benthin and I. Wald do ("Watertight ray/triangle
// intersection", JCGT 2(1), 2013): corners are projected along the ray, once for all triangles that share
// them, and the sides of the edges are the signs of differences of two products. Rounding a product keeps its
// order with others, so such a sign may become zero but never the opposite. Zero counts as within. So the ray
// meets whatever the projected mesh covers, edges and vertices included.
#include <parallel/queries/query_mesh.h>
#include <parallel/queries/query_scope.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::queries {

namespace {

constexpr double kMeshRounding = 1e-6;  // of coordinates: more than floats are rounded by, a few times over
constexpr double kDoubleRounding = 1e-15;  // the same of double precision

Vector corner_of(const MeshData& mesh, std::int32_t triangle, int corner) {
  const float* vertex = mesh.vertex + std::ptrdiff_t{3} * mesh.corners[triangle].vertex[corner];
  return {vertex[0], vertex[1], vertex[2]};
}

// Of the triangle, towards its front, of any length.
Vector normal_of(const MeshData& mesh, std::int32_t triangle) {
  const Vector first = corner_of(mesh, triangle, 0);
  return cross(corner_of(mesh, triangle, 1) - first, corner_of(mesh, triangle, 2) - first);
}

// In the frame of a mesh.
Line to_frame(const Solid& mesh, const Line& line) {
  return {turn_back(mesh.axes, line.origin - mesh.position), turn_back(mesh.axes, line.translation)};
}
Solid to_frame(const Solid& mesh, Solid solid) {
  solid.position = turn_back(mesh.axes, solid.position - mesh.position);
  solid.axes = {turn_back(mesh.axes, solid.axes.x), turn_back(mesh.axes, solid.axes.y),
                turn_back(mesh.axes, solid.axes.z)};
  return solid;
}

double largest(Vector v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// A line from where it may meet a mesh on. Does not depend on how far it is asked for: so the first of all
// answers is the first one, bit for bit.
struct Passage {
  double begin = 0.0, end = 1.0;  // fractions of the line
  Line line;                      // between them
  double rounding = 0.0;          // m, more than floats are off by from what they stand for
  double exact_rounding = 0.0;    // m, the same of what is in double precision

  float limit_at(double fraction) const {
    if (!(end > begin)) return 1.0f;
    return limit_of(std::clamp((fraction - begin) / (end - begin), 0.0, 1.0));
  }
  double fraction_at(double part) const { return begin + part * (end - begin); }
};

// What of a line, about which a box of half `reach` moves, passes the mesh's box; false if nothing does.
bool find_passage(const Solid& mesh, const Line& line, Vector reach, Passage& passage) {
  const double size = largest(mesh.half) + largest(reach);
  passage.exact_rounding = kDoubleRounding * (largest(line.origin) + largest(line.translation) + size);
  passage.rounding = kMeshRounding * size + passage.exact_rounding;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = mesh.half[axis] + reach[axis] + passage.rounding;
    const double at = line.origin[axis], way = line.translation[axis];
    if (way == 0.0) {
      if (std::abs(at) > half) return false;
      continue;
    }
    const double side = std::copysign(half, way);
    passage.begin = std::max(passage.begin, (-side - at) / way);
    passage.end = std::min(passage.end, (side - at) / way);
  }
  if (!(passage.begin <= passage.end)) return false;
  passage.line.origin = line.origin + passage.begin * line.translation;
  passage.line.translation = (passage.end - passage.begin) * line.translation;
  passage.rounding += kMeshRounding * (largest(passage.line.origin) + largest(passage.line.translation));
  return true;
}

simd::CrossTask task_of(const Passage& passage, Vector reach) {
  simd::CrossTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    const double way = passage.line.translation[axis];
    task.origin[axis] = static_cast<float>(passage.line.origin[axis]);
    task.inverse[axis] = std::abs(way) * simd::kLargestInverse > 1.0
                             ? static_cast<float>(1.0 / way)
                             : static_cast<float>(std::copysign(double{simd::kLargestInverse}, way));
    task.half[axis] = static_cast<float>(reach[axis] + passage.rounding);
  }
  return task;
}

// A ray as triangles see it: sheared along its longest axis, so that it passes the origin of the others.
struct Shear {
  Vector origin;
  int axis[3];
  double slope[2], scale;

  explicit Shear(const Line& line) : origin(line.origin) {
    const Vector way = line.translation;
    axis[2] = std::abs(way.x) > std::abs(way.y) ? 0 : 1;
    if (std::abs(way.z) > std::abs(way[axis[2]])) axis[2] = 2;
    axis[0] = (axis[2] + 1) % 3;
    axis[1] = (axis[2] + 2) % 3;
    if (way[axis[2]] < 0.0) std::swap(axis[0], axis[1]);  // keeps the sense of turning
    slope[0] = way[axis[0]] / way[axis[2]];
    slope[1] = way[axis[1]] / way[axis[2]];
    scale = 1.0 / way[axis[2]];
  }
};

simd::MeshRayTask task_of(const Passage& passage, const Shear& shear, const MeshLook& look) {
  simd::MeshRayTask task{};
  task.line = task_of(passage, {});
  for (int axis = 0; axis < 3; ++axis) {
    task.origin[axis] = passage.line.origin[axis];
    task.way[axis] = passage.line.translation[axis];
    task.axis[axis] = shear.axis[axis];
  }
  for (int i = 0; i < 2; ++i) task.slope[i] = static_cast<float>(shear.slope[i]);
  task.rounding = static_cast<float>(passage.exact_rounding);
  task.sides = simd::kFrontSide | (look.back_sides ? simd::kBackSide : 0u);
  return task;
}

// Whether the ray passes within the triangle, and at which part of it.
bool pass_within(const MeshData& mesh, std::int32_t triangle, const Shear& shear, bool back_sides,
                 double& part) {
  double x[3], y[3], along[3];
  for (int i = 0; i < 3; ++i) {
    const Vector corner = corner_of(mesh, triangle, i) - shear.origin;
    const double z = corner[shear.axis[2]];
    x[i] = corner[shear.axis[0]] - shear.slope[0] * z;
    y[i] = corner[shear.axis[1]] - shear.slope[1] * z;
    along[i] = shear.scale * z;
  }
  const double area_0 = x[2] * y[1] - y[2] * x[1];  // with the ray instead of corner 0
  const double area_1 = x[0] * y[2] - y[0] * x[2];
  const double area_2 = x[1] * y[0] - y[1] * x[0];
  const bool front = area_0 >= 0.0 && area_1 >= 0.0 && area_2 >= 0.0;
  const bool back = back_sides && area_0 <= 0.0 && area_1 <= 0.0 && area_2 <= 0.0;
  const double area = area_0 + area_1 + area_2;
  if (!(front || back) || area == 0.0) return false;
  part = along[0] + (area_1 * (along[1] - along[0]) + area_2 * (along[2] - along[0])) / area;
  return part >= 0.0 && part <= 1.0;
}

// Hands the kernels a callable to ask.
template <class Ask>
simd::AskShape asking(Ask&) {
  return [](void* context, std::int32_t triangle, float limit) -> float {
    return (*static_cast<Ask*>(context))(triangle, limit);
  };
}

}  // namespace

TriangleSolid::TriangleSolid(const MeshData& mesh) : mesh_(mesh) {
  solid_.type = ShapeType::hull;
  solid_.corners = 3;
  for (int axis = 0; axis < 3; ++axis) solid_.corner[axis] = column_[axis];
}

const Solid& TriangleSolid::take(std::int32_t triangle) {
  double half[3];
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 3; ++corner) {
      column_[axis][corner] = mesh_.vertex[std::ptrdiff_t{3} * mesh_.corners[triangle].vertex[corner] + axis];
    }
    const auto [lower, upper] = std::minmax({column_[axis][0], column_[axis][1], column_[axis][2]});
    half[axis] = 0.5 * (double{upper} - lower);
  }
  solid_.half = {half[0], half[1], half[2]};
  return solid_;
}

bool meet_mesh(const simd::QueryKernels& kernels, const Solid& mesh, const Line& line, double most,
               const MeshLook& look, Entry& entry) {
  entry = {};
  const MeshData& data = *mesh.mesh;
  const Line local = to_frame(mesh, line);
  Passage passage;
  if (!find_passage(mesh, local, {}, passage) || !(passage.begin <= most)) return false;
  if (!(largest(passage.line.translation) > 0.0)) return false;
  const Shear shear(passage.line);
  std::int32_t first = -1;
  auto ask = [&](std::int32_t triangle, float limit) -> float {
    double part = 0.0;
    if (!pass_within(data, triangle, shear, look.back_sides, part)) return limit;
    const double fraction = passage.fraction_at(part);
    const std::int32_t given = data.given[triangle];
    if (fraction > most) return limit;
    if (first >= 0 && (fraction > entry.fraction || (fraction == entry.fraction && given > entry.triangle)))
      return limit;
    entry.fraction = fraction;
    entry.triangle = given;
    first = triangle;
    return look.any ? -1.0f : std::min(limit, passage.limit_at(fraction));
  };
  kernels.cross_mesh_by_ray(data, task_of(passage, shear, look), passage.limit_at(most), asking(ask), &ask);
  if (first < 0) return false;
  entry.normal = mesh.axes * normalize(normal_of(data, first));
  return true;
}

bool meet_mesh(const simd::QueryKernels& kernels, const Solid& moving, Vector way, const Solid& mesh,
               double most, const MeshLook& look, Contact& contact) {
  contact = {};
  const MeshData& data = *mesh.mesh;
  const Solid local = to_frame(mesh, moving);
  const Line line{local.position, turn_back(mesh.axes, way)};
  const Vector reach = reach_of(local);
  Passage passage;
  if (!find_passage(mesh, line, reach, passage) || !(passage.begin <= most)) return false;
  TriangleSolid solid(data);
  bool met = false;
  auto ask = [&](std::int32_t triangle, float limit) -> float {
    const double inward = -dot(normal_of(data, triangle), line.translation);
    if (inward < 0.0 && !look.back_sides) return limit;
    Contact found;
    if (!meet(local, line.translation, solid.take(triangle), met ? contact.fraction : most, found))
      return limit;
    if (found.inside ? look.skips_overlapped : !(inward > 0.0 || look.back_sides)) return limit;
    found.triangle = data.given[triangle];
    if (met && (found.fraction > contact.fraction ||
                (found.fraction == contact.fraction && found.triangle > contact.triangle)))
      return limit;
    met = true;
    contact = found;
    return look.any ? -1.0f : std::min(limit, passage.limit_at(found.fraction));
  };
  kernels.cross_mesh(data, task_of(passage, reach), passage.limit_at(most), asking(ask), &ask);
  if (!met) return false;
  contact.normal = mesh.axes * contact.normal;
  contact.point = mesh.position + mesh.axes * contact.point;
  return true;
}

std::int32_t touched_triangle(const simd::QueryKernels& kernels, const Solid& solid, const Solid& mesh) {
  const MeshData& data = *mesh.mesh;
  const Solid local = to_frame(mesh, solid);
  TriangleSolid other(data);
  std::int32_t first = -1;
  auto ask = [&](std::int32_t triangle, float limit) -> float {
    const std::int32_t given = data.given[triangle];
    if (first >= 0 && given > first) return limit;
    if (!(gap_between(local, other.take(triangle)).distance > 0.0)) first = given;
    return limit;
  };
  kernels.meet_mesh(data, queries::task_of(local), 0.0f, asking(ask), &ask);
  return first;
}

Gap gap_to_mesh(const simd::QueryKernels& kernels, const Solid& solid, const Solid& mesh, double most) {
  const MeshData& data = *mesh.mesh;
  const Solid local = to_frame(mesh, solid);
  TriangleSolid other(data);
  Gap nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  auto ask = [&](std::int32_t triangle, float limit) -> float {
    const std::int32_t given = data.given[triangle];
    if (nearest.distance == 0.0 && given > nearest.triangle) return limit;
    Gap gap = gap_between(local, other.take(triangle));
    gap.distance = std::max(gap.distance, 0.0);
    gap.triangle = given;
    if (gap.distance > most || gap.distance > nearest.distance) return limit;
    if (gap.distance == nearest.distance && given > nearest.triangle) return limit;
    nearest = gap;
    return std::min(limit, limit_of(gap.distance * gap.distance));
  };
  kernels.approach_mesh(data, queries::task_of(local), limit_of(most * most), asking(ask), &ask);
  nearest.on_a = mesh.axes * nearest.on_a;
  nearest.on_b = mesh.axes * nearest.on_b;
  nearest.normal = mesh.axes * nearest.normal;
  return nearest;
}

}  // namespace scree::queries
