// Smooth shapes: cores, the points that are farthest along a direction, and the features that lie there.
//
// A direction has a feature of a core as large as can be: a face of a box or hull, a disk or a side of a
// cylinder, a disk or a generating line of a cone. A disk is a polygon that hardly moves on the shape but for
// one corner, which follows the lowest point of a tilted rim.
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Names of corners. Those of hulls are their vertices, those of boxes the signs of coordinates.
constexpr int kDisk = 16;  // corners of a disk
constexpr std::uint8_t kUpperDisk = 32, kApex = 64, kUpperEnd = 65, kLowerEnd = 66;

// Below this cosine between a face and the direction the face is too steep to have points.
constexpr double kSteep = 0.1;
// Cosine from which on a polygon lies across the direction.
constexpr double kFlat = 0.9999;
// Below this share of the unit, a direction's part across an axis is rounding.
constexpr double kNoDirection = 1e-12;

constexpr double kQuarterTurn = 0.7;  // cosine up to which another disk's direction counts

bool is_finite_and_turned(const PoseRow& pose, D3 center) {
  const float* q = pose.rotation;
  const float size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return size < 2.0f && size > 0.5f && dot(center, center) < 1e300;
}

void set_axes(const float (&q)[4], Core& core) {
  const double scale = 1.0 / root(double{q[0]} * double{q[0]} + double{q[1]} * double{q[1]} +
                                  double{q[2]} * double{q[2]} + double{q[3]} * double{q[3]});
  const double x = scale * double{q[0]}, y = scale * double{q[1]}, z = scale * double{q[2]},
               w = scale * double{q[3]};
  core.axis[0] = {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)};
  core.axis[1] = {2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)};
  core.axis[2] = {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
}

D3 hull_vertex(const HullData& hull, int k) {
  return {double{hull.vertex[0][k]}, double{hull.vertex[1][k]}, double{hull.vertex[2][k]}};
}
D3 hull_normal(const HullData& hull, int face) {
  return {double{hull.normal[0][face]}, double{hull.normal[1][face]}, double{hull.normal[2][face]}};
}
// The vertex that is farthest along d, the first of equal ones.
int hull_farthest(const HullData& hull, D3 d) {
  double distance[kMaxHullVertices];
  const float *const x = hull.vertex[0], *const y = hull.vertex[1], *const z = hull.vertex[2];
  const int count = hull.vertex_count;
  for (int k = 0; k < count; ++k) distance[k] = double{x[k]} * d.x + double{y[k]} * d.y + double{z[k]} * d.z;
  int best = 0;
  for (int k = 1; k < count; ++k) {
    if (distance[k] > distance[best]) best = k;
  }
  return best;
}

D3 rim_point(const Core& core, D3 d, double height) {
  const double across = root(d.x * d.x + d.z * d.z);
  if (!(across > 0.0)) return {core.half[0], height, 0.0};
  const double scale = core.half[0] / across;
  return {scale * d.x, height, scale * d.z};
}

D3 farthest_local(const Core& core, D3 d) {
  switch (core.kind) {
    case CoreKind::segment:
      return {0.0, d.y < 0.0 ? -core.half[1] : core.half[1], 0.0};
    case CoreKind::box:
      return {d.x < 0.0 ? -core.half[0] : core.half[0], d.y < 0.0 ? -core.half[1] : core.half[1],
              d.z < 0.0 ? -core.half[2] : core.half[2]};
    case CoreKind::hull:
      return hull_vertex(*core.hull, hull_farthest(*core.hull, d));
    case CoreKind::cylinder:
      return rim_point(core, d, d.y < 0.0 ? -core.half[1] : core.half[1]);
    case CoreKind::cone: {
      const bool is_apex = 2.0 * core.half[1] * d.y > core.half[0] * root(d.x * d.x + d.z * d.z);
      return is_apex ? D3{0.0, core.half[1], 0.0} : rim_point(core, d, -core.half[1]);
    }
    default:
      return {0.0, 0.0, 0.0};
  }
}

int triangle_farthest(const Core& core, D3 along) {
  int best = 0;
  for (int k = 1; k < 3; ++k) {
    if (dot(along, core.corner[k]) > dot(along, core.corner[best])) best = k;
  }
  return best;
}

void put(Feature& feature, D3 point, int name) {
  feature.point[feature.count] = point;
  feature.name[feature.count++] = static_cast<std::uint8_t>(name);
}

// --- features, by kind ---

void put_segment(const Core& core, D3 local, Feature& feature) {
  const D3 way = core.half[1] * core.axis[1];
  if (local.y < kFlat) put(feature, core.center - way, kLowerEnd);
  if (local.y > -kFlat) put(feature, core.center + way, kUpperEnd);
}

void put_box_face(const Core& core, D3 local, Feature& feature) {
  const double size[3] = {absolute(local.x), absolute(local.y), absolute(local.z)};
  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  const double part[3] = {local.x, local.y, local.z};
  const double sign = part[axis] < 0.0 ? -1.0 : 1.0;
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  constexpr double kFirst[4] = {-1, 1, 1, -1}, kSecond[4] = {-1, -1, 1, 1};
  for (int k = 0; k < 4; ++k) {
    double corner[3];
    corner[axis] = sign * core.half[axis];
    corner[next] = sign * kFirst[k] * core.half[next];  // counterclockwise seen from outside
    corner[last] = kSecond[k] * core.half[last];
    const int name = (corner[0] > 0.0 ? 1 : 0) | (corner[1] > 0.0 ? 2 : 0) | (corner[2] > 0.0 ? 4 : 0);
    put(feature, core.place({corner[0], corner[1], corner[2]}), name);
  }
  feature.normal = sign * core.axis[axis];
  feature.is_flat = size[axis] > kFlat;
}

void put_hull_face(const Core& core, D3 local, Feature& feature) {
  const HullData& hull = *core.hull;
  int face = 0;
  double most = -2.0;
  for (int f = 0; f < hull.face_count; ++f) {
    const double value = dot(hull_normal(hull, f), local);
    if (value > most) {
      most = value;
      face = f;
    }
  }
  if (most < kSteep) {
    const int vertex = hull_farthest(hull, local);
    put(feature, core.place(hull_vertex(hull, vertex)), vertex);
    return;
  }
  for (int k = hull.loop_begin[face]; k < hull.loop_begin[face + 1]; ++k) {
    put(feature, core.place(hull_vertex(hull, hull.loop[k])), hull.loop[k]);
  }
  feature.normal = core.turn(hull_normal(hull, face));
  feature.is_flat = most > kFlat;
}

void put_triangle(const Core& core, D3 along, Feature& feature) {
  const D3 across = cross(core.corner[1] - core.corner[0], core.corner[2] - core.corner[0]);
  const double area = length(across);
  const double cosine = area > 0.0 ? dot(across, along) / area : 0.0;
  if (absolute(cosine) >= kSteep) {
    const bool front = cosine > 0.0;
    for (int k = 0; k < 3; ++k) {
      const int corner = front ? k : (3 - k) % 3;
      put(feature, core.corner[corner], corner);
    }
    feature.normal = (front ? 1.0 / area : -1.0 / area) * across;
    feature.is_flat = absolute(cosine) > kFlat;
    return;
  }
  // Seen from its edge, a triangle is its highest side.
  const int top = triangle_farthest(core, along), one = (top + 1) % 3, two = (top + 2) % 3;
  const int second = dot(along, core.corner[one]) >= dot(along, core.corner[two]) ? one : two;
  const int ends[2] = {top < second ? top : second, top < second ? second : top};
  for (const int end : ends) put(feature, core.corner[end], end);
}

// Four directions around a disk, counterclockwise seen from outside. One of them moves toward the lean, so
// that the lowest point of the rim is among the corners. It does so by degrees, so that it hardly moves while
// a disk that lies flat jitters.
void set_quarters(const Core& core, const DiskFrame& frame, double sign, D3 (&quarter)[5]) {
  D3 first{1.0, 0.0, 0.0};
  if (frame.has_start) {
    const D3 start = core.turn_back(frame.start);
    const double across = root(start.x * start.x + start.z * start.z);
    if (across > kQuarterTurn) first = {start.x / across, 0.0, start.z / across};
  }
  quarter[0] = first;
  quarter[1] = {sign * first.z, 0.0, -sign * first.x};
  quarter[2] = -quarter[0];
  quarter[3] = -quarter[1];
  const D3 lean = core.turn_back(frame.lean);
  const double size = root(lean.x * lean.x + lean.z * lean.z);
  const double tolerance = lesser_of(double{kFeatureTolerance}, double{kFeatureShare} * core.thinness);
  constexpr double kFade = 3.0;  // times the tolerance
  const double share = lesser_of((size * core.half[0] - tolerance) / (kFade * tolerance), 1.0);
  if (share > 0.0 && size > kNoDirection) {
    const D3 lowest{lean.x / size, 0.0, lean.z / size};
    int nearest = 0;
    for (int k = 1; k < 4; ++k) {
      if (dot(quarter[k], lowest) > dot(quarter[nearest], lowest)) nearest = k;
    }
    const D3 moved = (1.0 - share) * quarter[nearest] + share * lowest;
    quarter[nearest] = (1.0 / length(moved)) * moved;
  }
  quarter[4] = quarter[0];
}

// The disk at a height; `local` is of unit length.
void put_disk(const Core& core, D3 local, double height, int names, const DiskFrame& frame,
              Feature& feature) {
  const double radius = core.half[0], tilt = root(local.x * local.x + local.z * local.z);
  const double sign = height < 0.0 ? -1.0 : 1.0;
  D3 quarter[5];
  set_quarters(core, frame, sign, quarter);
  for (int k = 0; k < kDisk; ++k) {
    const int part = k % kDiskQuarter;
    const D3 &from = quarter[k / kDiskQuarter], &to = quarter[k / kDiskQuarter + 1];
    const D3 between = double(kDiskQuarter - part) * from + double(part) * to;
    const double scale = radius / length(between);
    put(feature, core.place({scale * between.x, height, scale * between.z}), names + k);
  }
  feature.start = core.turn(quarter[0]);
  feature.normal = sign * core.axis[1];
  feature.is_disk = true;
  feature.is_flat = absolute(local.y) > kFlat;
  feature.is_rim = 2.0 * radius * tilt > double{kSpeculativeDistance};
}

// The line on the side of a cylinder or cone that lies farthest along the direction.
void put_side(const Core& core, D3 local, double upper_radius, Feature& feature) {
  const double tilt = root(local.x * local.x + local.z * local.z);
  const D3 out = tilt > kNoDirection ? D3{local.x / tilt, 0.0, local.z / tilt} : D3{1.0, 0.0, 0.0};
  put(feature, core.place({upper_radius * out.x, core.half[1], upper_radius * out.z}), kUpperEnd);
  put(feature, core.place({core.half[0] * out.x, -core.half[1], core.half[0] * out.z}), kLowerEnd);
  feature.is_rolling = true;
}

void put_cone(const Core& core, D3 local, const DiskFrame& frame, Feature& feature) {
  const double radius = core.half[0], height = 2.0 * core.half[1];
  const double tilt = root(local.x * local.x + local.z * local.z);
  const double side = (height * tilt + radius * local.y) / root(height * height + radius * radius);
  if (-local.y >= side) {
    put_disk(core, local, -core.half[1], 0, frame, feature);
  } else if (side > kSteep) {
    put_side(core, local, 0.0, feature);
  } else {
    put(feature, core.place({0.0, core.half[1], 0.0}), kApex);
  }
}

}  // namespace

bool make_frame(const PoseRow& pose, D3 center, Core& core) {
  if (!is_finite_and_turned(pose, center)) return false;
  core = {};
  core.kind = CoreKind::box;
  set_axes(pose.rotation, core);
  core.center = center;
  return true;
}

bool make_core(const CollideColumns& columns, std::int32_t shape, D3 center, Core& core) {
  const PoseRow& pose = columns.shape_pose[shape];
  if (!is_finite_and_turned(pose, center)) return false;
  const ExtentRow& extent = columns.shape_extent[shape];
  set_axes(pose.rotation, core);
  core.center = center;
  for (int axis = 0; axis < 3; ++axis) core.half[axis] = double{extent.half[axis]};
  core.margin = double{extent.radius};
  core.hull = nullptr;
  const double x = core.half[0], y = core.half[1], z = core.half[2];
  core.size = root(x * x + y * y + z * z) + core.margin;
  core.thinness = lesser_of(lesser_of(x, y), z) + core.margin;
  switch (static_cast<SolidType>(columns.shape_type[shape])) {
    case kSolidSphere:
      core.kind = CoreKind::point;
      break;
    case kSolidCapsule:
      core.kind = CoreKind::segment;
      core.half[0] = core.half[2] = 0.0;
      core.size = y + core.margin;
      core.thinness = core.margin;
      break;
    case kSolidBox:
      core.kind = CoreKind::box;
      core.margin = 0.0;
      core.size = root(x * x + y * y + z * z);
      core.thinness = lesser_of(lesser_of(x, y), z);
      break;
    case kSolidRoundedBox:
      core.kind = CoreKind::box;
      break;
    case kSolidCylinder:
    case kSolidCone: {
      const bool is_cone = columns.shape_type[shape] == kSolidCone;
      core.kind = is_cone ? CoreKind::cone : CoreKind::cylinder;
      core.margin = 0.0;
      core.size = root(x * x + y * y);
      core.thinness = is_cone ? 0.5 * lesser_of(x, y) : lesser_of(x, y);
      break;
    }
    default:
      core.kind = CoreKind::hull;
      core.hull = columns.hulls[columns.shape_hull[shape]];
      core.margin = double{core.hull->rounding};
      core.size = double{core.hull->outer_radius} + core.margin;
      core.thinness = double{core.hull->inner_radius} + core.margin;
      break;
  }
  return true;
}

Core triangle_core(D3 a, D3 b, D3 c) {
  Core core{};
  core.kind = CoreKind::triangle;
  core.corner[0] = a;
  core.corner[1] = b;
  core.corner[2] = c;
  core.axis[0] = {1.0, 0.0, 0.0};
  core.axis[1] = {0.0, 1.0, 0.0};
  core.axis[2] = {0.0, 0.0, 1.0};
  core.center = (1.0 / 3.0) * (a + b + c);
  for (const D3& corner : core.corner) core.size = greater_of(length(corner - core.center), core.size);
  core.thinness = 1e30;
  return core;
}

D3 farthest_point(const Core& core, D3 along) {
  if (core.kind == CoreKind::point) return core.center;
  if (core.kind == CoreKind::triangle) return core.corner[triangle_farthest(core, along)];
  return core.place(farthest_local(core, core.turn_back(along)));
}

D3 lean_of(const Core& core, D3 along) {
  if (core.kind != CoreKind::cylinder && core.kind != CoreKind::cone) return {0.0, 0.0, 0.0};
  const D3 lean = along - dot(along, core.axis[1]) * core.axis[1];
  return dot(lean, lean) < 0.5 ? lean : D3{0.0, 0.0, 0.0};
}

void find_feature(const Core& core, D3 along, const DiskFrame& frame, Feature& feature) {
  feature.count = 0;
  feature.normal = along;
  feature.is_flat = feature.is_rolling = feature.is_disk = feature.is_rim = false;
  feature.start = along;
  const D3 local = core.turn_back(along);
  switch (core.kind) {
    case CoreKind::point:
      put(feature, core.center, 0);
      break;
    case CoreKind::segment:
      put_segment(core, local, feature);
      break;
    case CoreKind::box:
      put_box_face(core, local, feature);
      break;
    case CoreKind::hull:
      put_hull_face(core, local, feature);
      break;
    case CoreKind::triangle:
      put_triangle(core, along, feature);
      break;
    case CoreKind::cylinder: {
      const double tilt = root(local.x * local.x + local.z * local.z);
      const bool upper = local.y >= 0.0;
      if (absolute(local.y) < tilt) {
        put_side(core, local, core.half[0], feature);
      } else {
        put_disk(core, local, upper ? core.half[1] : -core.half[1], upper ? kUpperDisk : 0, frame, feature);
      }
      break;
    }
    case CoreKind::cone:
      put_cone(core, local, frame, feature);
      break;
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
