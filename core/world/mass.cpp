// Mass properties of bodies; see mass.h.
//
// Computes in plain double arithmetic of a fixed order: the rows are state and must have the same bits for
// every compiler.
#include <core/geometry/hull/hull_build.h>
#include <core/geometry/mesh/mesh_build.h>
#include <core/world/check.h>
#include <core/world/mass.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace scree {

namespace {

constexpr double kIsotropyTolerance = 1e-6;  // relative; below it the gyroscopic term drowns in rounding
constexpr double kTriangleTolerance = 1e-3;  // relative; a flat plate meets the inequality with equality
constexpr float kMinInertia = 1e-30f;        // kg m^2, keeps the inverse finite
constexpr float kMaxInertia = 1e35f;         // kg m^2

double trace(const Symmetric& s) { return s.m[XX] + s.m[YY] + s.m[ZZ]; }

Symmetric diagonal(double xx, double yy, double zz) { return {{xx, 0.0, 0.0, yy, 0.0, zz}}; }

// Mass and inertia about the geometry's own center and axes.
double solid(const Sphere& sphere, double density, Symmetric* inertia) {
  const double r = sphere.radius;
  const double mass = density * (4.0 / 3.0) * std::numbers::pi * r * r * r;
  const double i = 0.4 * mass * r * r;
  *inertia = diagonal(i, i, i);
  return mass;
}

// A cylinder of height h and two half balls, whose centroids lie 3/8 r beyond the cylinder's ends.
double solid(const Capsule& capsule, double density, Symmetric* inertia) {
  const double r = capsule.radius, h = 2.0 * capsule.half_height;
  const double cylinder = density * std::numbers::pi * r * r * h;
  const double ball = density * (4.0 / 3.0) * std::numbers::pi * r * r * r;
  const double along = cylinder * 0.5 * r * r + ball * 0.4 * r * r;
  const double across =
      cylinder * (h * h / 12.0 + 0.25 * r * r) + ball * (0.4 * r * r + 0.25 * h * h + 0.375 * h * r);
  *inertia = diagonal(across, along, across);
  return cylinder + ball;
}

// What rounds a box: a slab on each face, a quarter of a cylinder along each edge and an eighth of a ball at
// each corner. Adds to the masses; moment[i] is the integral of x_i^2.
void add_rounding(const double (&half)[3], double r, double density, double& mass, double (&moment)[3]) {
  constexpr double kPi = std::numbers::pi;
  for (int axis = 0; axis < 3; ++axis) {
    const int others[] = {(axis + 1) % 3, (axis + 2) % 3};
    const double a = half[axis], b = half[others[0]], c = half[others[1]];
    const double slabs = density * 8.0 * r * b * c;           // both that face along the axis
    const double cylinder = density * 2.0 * kPi * r * r * a;  // in four quarters, along the axis
    mass += slabs + cylinder;
    moment[axis] += slabs * (a * a + a * r + r * r / 3.0) + cylinder * a * a / 3.0;
    for (const int other : others) {
      const double d = half[other];
      moment[other] += slabs * d * d / 3.0;
      moment[other] += cylinder * (d * d + d * r * (8.0 / (3.0 * kPi)) + 0.25 * r * r);
    }
  }
  const double ball = density * (4.0 / 3.0) * kPi * r * r * r;
  mass += ball;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = half[axis];
    moment[axis] += ball * (d * d + 0.75 * d * r + 0.2 * r * r);
  }
}

double solid(const Box& box, double density, Symmetric* inertia) {
  const double x = box.half_extents.x, y = box.half_extents.y, z = box.half_extents.z;
  double mass = density * 8.0 * x * y * z;
  const double third = mass / 3.0;
  *inertia = diagonal(third * (y * y + z * z), third * (x * x + z * z), third * (x * x + y * y));
  if (!(box.rounding > 0.0f)) return mass;
  double moment[3] = {third * x * x, third * y * y, third * z * z};
  add_rounding({x, y, z}, box.rounding, density, mass, moment);
  *inertia = diagonal(moment[1] + moment[2], moment[0] + moment[2], moment[0] + moment[1]);
  return mass;
}

double solid(const Cylinder& cylinder, double density, Symmetric* inertia) {
  const double r = cylinder.radius, h = 2.0 * cylinder.half_height;
  const double mass = density * std::numbers::pi * r * r * h;
  const double across = mass * (h * h / 12.0 + 0.25 * r * r);
  *inertia = diagonal(across, 0.5 * mass * r * r, across);
  return mass;
}

double solid(const Cone& cone, double density, Symmetric* inertia) {
  const double r = cone.radius, h = 2.0 * cone.half_height;
  const double mass = density * std::numbers::pi * r * r * h / 3.0;
  const double across = mass * (0.0375 * h * h + 0.15 * r * r);
  *inertia = diagonal(across, 0.3 * mass * r * r, across);
  return mass;
}

HullIntegrals rounded_integrals(const ConvexHull& convex) {
  const HullSolid& hull = *HullAccess::solid(convex.hull);
  return integrate_rounded(hull.topology, hull.integrals, {convex.scale.x, convex.scale.y, convex.scale.z},
                           convex.rounding);
}

// The hull's own integrals, stretched.
double solid(const ConvexHull& convex, double density, Symmetric* inertia) {
  if (convex.rounding > 0.0f) {
    const HullIntegrals rounded = rounded_integrals(convex);
    const double* m = rounded.moment;
    *inertia = {{density * (m[YY] + m[ZZ]), -density * m[XY], -density * m[XZ], density * (m[XX] + m[ZZ]),
                 -density * m[YZ], density * (m[XX] + m[YY])}};
    return density * rounded.volume;
  }
  const HullIntegrals& integrals = HullAccess::solid(convex.hull)->integrals;
  const double s[3] = {convex.scale.x, convex.scale.y, convex.scale.z};
  const double stretch = density * s[0] * s[1] * s[2];
  const double* m = integrals.moment;
  const double xx = stretch * s[0] * s[0] * m[XX], yy = stretch * s[1] * s[1] * m[YY];
  const double zz = stretch * s[2] * s[2] * m[ZZ];
  *inertia = {{yy + zz, -stretch * s[0] * s[1] * m[XY], -stretch * s[0] * s[2] * m[XZ], xx + zz,
               -stretch * s[1] * s[2] * m[YZ], xx + yy}};
  return stretch * integrals.volume;
}

// A surface has no mass, and what has no end gets none.
double solid(const TriangleMesh&, double, Symmetric* inertia) {
  *inertia = {};
  return 0.0;
}
double solid(const HalfSpace&, double, Symmetric* inertia) {
  *inertia = {};
  return 0.0;
}

float to_float(double value) {
  constexpr double kMax = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kMax, kMax));
}

Symmetric round_to_float(const Symmetric& s) {
  Symmetric rounded;
  for (int i = 0; i < 6; ++i) rounded.m[i] = to_float(s.m[i]);
  return rounded;
}

bool is_isotropic(const Symmetric& s) {
  const double largest = std::max({s.m[XX], s.m[YY], s.m[ZZ]});
  const double smallest = std::min({s.m[XX], s.m[YY], s.m[ZZ]});
  const double off = std::max({std::abs(s.m[XY]), std::abs(s.m[XZ]), std::abs(s.m[YZ])});
  return largest - smallest <= kIsotropyTolerance * largest && off <= kIsotropyTolerance * largest;
}

Symmetric add_isotropic(Symmetric s, double value) {
  s.m[XX] += value;
  s.m[YY] += value;
  s.m[ZZ] += value;
  return s;
}

// Float rounding can make the inverse of a very slender solid that is turned against its body's axes
// indefinite, which would feed energy to it. Such a solid gets a little thicker until it does not.
Symmetric make_invertible(Symmetric inertia) {
  if (inertia.m[XY] == 0.0 && inertia.m[XZ] == 0.0 && inertia.m[YZ] == 0.0) return inertia;
  double thickening = 1e-7 * trace(inertia);
  while (!is_positive_definite(round_to_float(inertia)) ||
         !is_positive_definite(round_to_float(inverse(inertia)))) {
    inertia = add_isotropic(inertia, thickening);
    thickening *= 2.0;
  }
  return inertia;
}

// No solid has a principal moment above the sum of the other two: half the trace times the identity, less
// the inertia, is the second moment of its mass, which is positive.
bool meets_triangle_inequality(const Symmetric& inertia) {
  Symmetric moment;
  for (int i = 0; i < 6; ++i) moment.m[i] = -inertia.m[i];
  return is_positive_definite(add_isotropic(moment, (0.5 + kTriangleTolerance) * trace(inertia)));
}

Symmetric to_symmetric(const MassProperties& properties) {
  const float* i = properties.inertia;
  return {{i[0], i[3], i[4], i[1], i[5], i[2]}};
}

BodyMass to_rows(double mass, const double center[3], const Symmetric& inertia) {
  BodyMass rows;
  rows.mass = to_float(mass);
  rows.center = {to_float(center[0]), to_float(center[1]), to_float(center[2])};
  for (int i = 0; i < 6; ++i) rows.inertia.inertia[i] = to_float(inertia.m[i]);
  return rows;
}

BodyMass to_dynamic_rows(Call call, double mass, const double center[3], const Symmetric& inertia) {
  check_range(call, "the body's mass", to_float(mass), kMinMass, kMaxMass);
  constexpr int kDiagonal[] = {XX, YY, ZZ};
  for (const int i : kDiagonal) {
    check_range(call, "the body's moment of inertia", to_float(inertia.m[i]), kMinInertia, kMaxInertia);
  }
  const Symmetric sound = make_invertible(inertia);
  const Symmetric inverted = inverse(sound);
  BodyMass rows = to_rows(mass, center, sound);
  for (int i = 0; i < 6; ++i) rows.inverse.inverse_inertia[i] = to_float(inverted.m[i]);
  rows.inverse.inverse_mass = static_cast<float>(1.0 / mass);
  rows.gyroscopic = !is_isotropic(sound);
  return rows;
}

// Scales to the given mass; a sum without shapes becomes 1 kg, or the given mass, with gyration radii of 1 m.
MassSum completed(MassSum sum, std::optional<float> given_mass) {
  if (sum.mass == 0.0) {
    sum.mass = 1.0;
    sum.inertia = diagonal(1.0, 1.0, 1.0);
  }
  if (given_mass) {
    const double scale = *given_mass / sum.mass;
    for (double& moment : sum.inertia.m) moment *= scale;
    sum.mass = *given_mass;
  }
  return sum;
}

void to_matrix(Quat rotation, double (&r)[3][3]) {
  double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
  const double scale = 1.0 / std::sqrt(x * x + y * y + z * z + w * w);
  x *= scale, y *= scale, z *= scale, w *= scale;
  const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  for (int i = 0; i < 3; ++i) std::copy_n(rows[i], 3, r[i]);
}

}  // namespace

void rotate(Quat rotation, const double v[3], double out[3]) {
  double r[3][3];
  to_matrix(rotation, r);
  for (int i = 0; i < 3; ++i) out[i] = r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2];
}

Symmetric rotated(Quat rotation, const Symmetric& s) {
  double r[3][3];
  to_matrix(rotation, r);
  const double full[3][3] = {
      {s.m[XX], s.m[XY], s.m[XZ]}, {s.m[XY], s.m[YY], s.m[YZ]}, {s.m[XZ], s.m[YZ], s.m[ZZ]}};
  double half[3][3];  // R M
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      half[i][j] = r[i][0] * full[0][j] + r[i][1] * full[1][j] + r[i][2] * full[2][j];
  }
  const auto entry = [&](int i, int j) {
    return half[i][0] * r[j][0] + half[i][1] * r[j][1] + half[i][2] * r[j][2];
  };
  return {{entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)}};
}

// By the pivots of its Cholesky factors.
bool is_positive_definite(const Symmetric& s) {
  const double p0 = s.m[XX];
  if (!(p0 > 0.0)) return false;
  const double l1 = s.m[XY] / p0, l2 = s.m[XZ] / p0;
  const double p1 = s.m[YY] - l1 * s.m[XY];
  if (!(p1 > 0.0)) return false;
  const double yz = s.m[YZ] - l1 * s.m[XZ];
  return s.m[ZZ] - l2 * s.m[XZ] - yz / p1 * yz > 0.0;
}

Symmetric inverse(const Symmetric& s) {
  const double cxx = s.m[YY] * s.m[ZZ] - s.m[YZ] * s.m[YZ];
  const double cxy = s.m[XZ] * s.m[YZ] - s.m[XY] * s.m[ZZ];
  const double cxz = s.m[XY] * s.m[YZ] - s.m[XZ] * s.m[YY];
  const double d = 1.0 / (s.m[XX] * cxx + s.m[XY] * cxy + s.m[XZ] * cxz);
  const double cyy = s.m[XX] * s.m[ZZ] - s.m[XZ] * s.m[XZ];
  const double cyz = s.m[XY] * s.m[XZ] - s.m[XX] * s.m[YZ];
  const double czz = s.m[XX] * s.m[YY] - s.m[XY] * s.m[XY];
  return {{cxx * d, cxy * d, cxz * d, cyy * d, cyz * d, czz * d}};
}

namespace {

// False where it is the shape's origin.
bool find_centroid(const Geometry& geometry, double (&centroid)[3]) {
  if (const auto* cone = std::get_if<Cone>(&geometry)) {
    centroid[0] = centroid[2] = 0.0;
    centroid[1] = -0.5 * double{cone->half_height};
    return true;
  }
  const auto* convex = std::get_if<ConvexHull>(&geometry);
  if (convex == nullptr) return false;
  const HullSolid& hull = *HullAccess::solid(convex->hull);
  const float scale[3] = {convex->scale.x, convex->scale.y, convex->scale.z};
  for (int i = 0; i < 3; ++i) centroid[i] = scale[i] * (hull.origin[i] + hull.integrals.center[i]);
  if (convex->rounding > 0.0f) {
    const HullIntegrals rounded = rounded_integrals(*convex);
    for (int i = 0; i < 3; ++i) centroid[i] = scale[i] * hull.origin[i] + rounded.center[i];
  }
  return true;
}

}  // namespace

MassSum part_of(const Geometry& geometry, double density, const Pose& local_pose) {
  MassSum part;
  part.mass = std::visit([&](const auto& shape) { return solid(shape, density, &part.inertia); }, geometry);
  if (!may_be_dynamic(geometry)) return part;
  if (local_pose.rotation != Quat{}) part.inertia = rotated(local_pose.rotation, part.inertia);
  part.center[0] = local_pose.position.x;
  part.center[1] = local_pose.position.y;
  part.center[2] = local_pose.position.z;
  double centroid[3];
  if (find_centroid(geometry, centroid)) {
    double offset[3];
    rotate(local_pose.rotation, centroid, offset);
    for (int i = 0; i < 3; ++i) part.center[i] += offset[i];
  }
  // No negative zeros: a sum has none.
  for (double& moment : part.inertia.m) moment += 0.0;
  for (double& coordinate : part.center) coordinate += 0.0;
  return part;
}

Geometry geometry_of(const WorldData& data, std::int32_t shape) {
  const Shapes& shapes = data.shapes;
  const ExtentRow& extent = shapes.extent[shape];
  switch (shapes.type[shape]) {
    case ShapeType::sphere:
      return Sphere{extent.radius};
    case ShapeType::capsule:
      return Capsule{extent.half[1], extent.radius};
    case ShapeType::cylinder:
      return Cylinder{extent.half[1], extent.half[0]};
    case ShapeType::cone:
      return Cone{extent.half[1], extent.half[0]};
    case ShapeType::hull:
    case ShapeType::rounded_hull:
      return data.hulls.shared[static_cast<std::size_t>(shapes.hull[shape])].geometry;
    case ShapeType::mesh:
      return MeshAccess::mesh(data.meshes.shared[static_cast<std::size_t>(shapes.mesh[shape])].solid);
    case ShapeType::half_space:
      return HalfSpace{};
    case ShapeType::box:
    case ShapeType::rounded_box:
      break;
  }
  return Box{{extent.half[0], extent.half[1], extent.half[2]}, extent.radius};
}

namespace {

MassSum part_of(const WorldData& data, std::int32_t shape) {
  return part_of(geometry_of(data, shape), solid_density(data.shapes, shape), data.shapes.given_pose[shape]);
}

void apply_change(const WorldData& data, const ShapeChange& change, MassMoments& moments) {
  if (change.index >= 0) moments.remove(part_of(data, change.index));
  for (const ShapeForm& form : change.forms) {
    moments.add(part_of(form.geometry, form.density, form.local_pose));
  }
}

MassMoments moments_of(const WorldData& data, std::int32_t body) {
  const auto kept = data.bodies.moments.find(body);
  if (kept != data.bodies.moments.end()) return kept->second;
  MassMoments moments;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    moments.add(part_of(data, shape));
  }
  return moments;
}

// The mass of a body's only part, to the last bit.
MassSum only_part(const WorldData& data, std::int32_t body, const ShapeChange& change) {
  if (!change.forms.empty()) {
    return part_of(change.forms[0].geometry, change.forms[0].density, change.forms[0].local_pose);
  }
  std::int32_t shape = data.bodies.first_shape[body];
  if (shape == change.index) shape = data.shapes.next[shape];
  return part_of(data, shape);
}

}  // namespace

MassSum sum_shapes(const WorldData& data, std::int32_t body) {
  const MassMoments moments = moments_of(data, body);
  return moments.parts() == 1 ? only_part(data, body, {}) : moments.sum();
}

MassSum sum_shapes_after(WorldData& data, std::int32_t body, const ShapeChange& change) {
  MassMoments moments = moments_of(data, body);
  if (moments.parts() > kFewShapes) data.bodies.moments.emplace(body, moments);  // unless they are kept
  apply_change(data, change, moments);
  return moments.parts() == 1 ? only_part(data, body, change) : moments.sum();
}

void follow_change(WorldData& data, std::int32_t body, const ShapeChange& change) {
  const auto kept = data.bodies.moments.find(body);
  if (kept == data.bodies.moments.end()) return;
  apply_change(data, change, kept->second);
  if (kept->second.parts() <= kFewShapes) data.bodies.moments.erase(kept);
}

BodyMass dynamic_mass(Call call, const MassSum& sum, std::optional<float> given_mass) {
  const MassSum whole = completed(sum, given_mass);
  return to_dynamic_rows(call, whole.mass, whole.center, whole.inertia);
}

BodyMass given_mass_rows(Call call, const MassProperties& properties, BodyType type) {
  check_range(call, "mass", properties.mass, kMinMass, kMaxMass);
  check_vector(call, "center", properties.center, kMaxLocalPosition);
  for (const float moment : properties.inertia) {
    check_range(call, "inertia", moment, -kMaxInertia, kMaxInertia);
  }
  const Symmetric inertia = to_symmetric(properties);
  if (!is_positive_definite(inertia)) fail(call, "the inertia is not positive definite");
  if (!meets_triangle_inequality(inertia)) {
    fail(call, "no solid has this inertia: one principal moment exceeds the sum of the others");
  }
  const double center[3] = {properties.center.x, properties.center.y, properties.center.z};
  BodyMass rows = to_dynamic_rows(call, properties.mass, center, inertia);
  if (type != BodyType::dynamic) {
    rows.inverse = {};
    rows.gyroscopic = false;
  }
  return rows;
}

BodyMass mass_after(Call call, WorldData& data, std::int32_t body, BodyType type, std::uint8_t flags,
                    const ShapeChange& change) {
  if (is_absent(data.bodies, body)) return {};
  if ((flags & kBodyPropertiesGiven) != 0) {
    return given_mass_rows(call, properties_of(data.bodies, body), type);
  }
  if (type != BodyType::dynamic) return {};
  std::optional<float> given_mass;
  if ((flags & kBodyMassGiven) != 0) given_mass = data.bodies.given_mass[body];
  return dynamic_mass(call, sum_shapes_after(data, body, change), given_mass);
}

MassProperties properties_of(const MassSum& sum, std::optional<float> given_mass) {
  const MassSum whole = completed(sum, given_mass);
  const double* i = whole.inertia.m;
  return {.mass = to_float(whole.mass),
          .center = {to_float(whole.center[0]), to_float(whole.center[1]), to_float(whole.center[2])},
          .inertia = {to_float(i[XX]), to_float(i[YY]), to_float(i[ZZ]), to_float(i[XY]), to_float(i[XZ]),
                      to_float(i[YZ])}};
}

MassProperties properties_of(const Bodies& bodies, std::int32_t body) {
  const float* i = bodies.local_inertia[body].inertia;
  return {.mass = bodies.mass[body],
          .center = bodies.center[body],
          .inertia = {i[XX], i[YY], i[ZZ], i[XY], i[XZ], i[YZ]}};
}

}  // namespace scree
