// A ray against a cylinder, a cone or a rounded box; see query_ray_smooth.h.
#include <parallel/queries/query_ray_smooth.h>

#include <algorithm>
#include <cmath>

namespace scree::queries {

namespace {

// A stretch of a ray.
struct Span {
  double begin = -kNever, end = kNever;
  bool is_empty() const { return !(begin <= end); }
};

// What lies between y = -half and y = half.
Span within_slab(const Line& line, double half) {
  const double at = line.origin.y, speed = line.translation.y;
  if (speed == 0.0) return std::abs(at) <= half ? Span{} : Span{kNever, -kNever};
  const double side = speed > 0.0 ? -half : half;
  return {(side - at) / speed, (-side - at) / speed};
}

// What lies within the radius about the y axis, from the point that is nearest to it.
Span within_tube(const Line& line, double radius) {
  const Vector origin{line.origin.x, 0.0, line.origin.z}, way{line.translation.x, 0.0, line.translation.z};
  const double size = dot(way, way);
  if (!(size > 0.0)) return dot(origin, origin) <= radius * radius ? Span{} : Span{kNever, -kNever};
  const double nearest = -dot(origin, way) / size;
  const Vector middle = origin + nearest * way;
  const double inside = radius * radius - dot(middle, middle);
  if (!(inside >= 0.0)) return {kNever, -kNever};
  const double half = std::sqrt(inside / size);
  return {nearest - half, nearest + half};
}

double across(Vector v) { return std::sqrt(v.x * v.x + v.z * v.z); }

Vector at(const Line& line, double fraction) { return line.origin + fraction * line.translation; }

}  // namespace

bool meet_cylinder(double half, double radius, const Line& line, Entry& entry) {
  if (std::abs(line.origin.y) <= half && across(line.origin) <= radius) {
    entry.inside = true;
    return true;
  }
  const Span slab = within_slab(line, half), tube = within_tube(line, radius);
  const Span both{std::max(slab.begin, tube.begin), std::min(slab.end, tube.end)};
  if (both.is_empty() || !(both.begin >= 0.0 && both.begin <= 1.0)) return false;
  entry.fraction = both.begin;
  const Vector place = at(line, both.begin);
  entry.normal = slab.begin > tube.begin ? Vector{0.0, line.translation.y < 0.0 ? 1.0 : -1.0, 0.0}
                                         : normalize({place.x, 0.0, place.z});
  return true;
}

// From where the ray enters the cylinder around the cone, in coordinates in which the cone is all points with
// x^2 + z^2 <= s^2, 0 <= s <= 1. So all numbers are about 1, however slender the cone is.
bool meet_cone(double half, double radius, const Line& line, Entry& entry) {
  const double height = 2.0 * half;
  if (std::abs(line.origin.y) <= half && across(line.origin) * height <= radius * (half - line.origin.y)) {
    entry.inside = true;
    return true;
  }
  const Span slab = within_slab(line, half), tube = within_tube(line, radius);
  const Span both{std::max({slab.begin, tube.begin, 0.0}), std::min({slab.end, tube.end, 1.0})};
  if (both.is_empty()) return false;
  const Vector base = at(line, both.begin), way = (both.end - both.begin) * line.translation;
  const Vector from{base.x / radius, (half - base.y) / height, base.z / radius};
  const Vector by{way.x / radius, -way.y / height, way.z / radius};
  const double square = by.x * by.x + by.z * by.z - by.y * by.y;
  const double slope = from.x * by.x + from.z * by.z - from.y * by.y;
  const double outside = from.x * from.x + from.z * from.z - from.y * from.y;
  double part = 0.0;
  if (outside > 0.0) {
    const double root = slope * slope - square * outside;
    if (!(root >= 0.0)) return false;
    const double closing = std::sqrt(root) - slope;
    part = outside / closing;  // the first of the roots, of any sign of `square`
    if (!(closing > 0.0 && part <= 1.0)) return false;
  } else if (!(both.begin > 0.0)) {  // by rounding
    entry.inside = true;
    return true;
  } else if (slab.begin > tube.begin && line.translation.y > 0.0) {  // through the base
    entry.fraction = both.begin;
    entry.normal = {0.0, -1.0, 0.0};
    return true;
  }
  entry.fraction = both.begin + part * (both.end - both.begin);
  const Vector place = base + part * way;
  const double size = across(place);
  entry.normal = size > 0.0 ? normalize({height * place.x / size, radius, height * place.z / size})
                            : Vector{0.0, 1.0, 0.0};
  return true;
}

// A rounded box is the union of three boxes, each larger by the rounding along one axis, and of a capsule
// about each edge.
bool meet_rounded_box(Vector half, double rounding, const Line& line, Entry& entry) {
  const auto beyond = [](double x, double limit) { return x - std::clamp(x, -limit, limit); };
  const Vector from{beyond(line.origin.x, half.x), beyond(line.origin.y, half.y),
                    beyond(line.origin.z, half.z)};
  if (dot(from, from) <= rounding * rounding) {
    entry.inside = true;
    return true;
  }
  const Vector grown{half.x + rounding, half.y + rounding, half.z + rounding};
  Entry outer;
  if (!meet_box(grown, line, outer)) return false;
  const int axis = outer.face / 2;
  const Vector place = at(line, outer.fraction);
  const auto is_within = [&](int i) { return i == axis || std::abs(place[i]) <= half[i]; };
  if (!outer.inside && is_within(0) && is_within(1) && is_within(2)) {
    entry = outer;
    return true;
  }
  Entry first;
  first.fraction = kNever;
  const auto take = [&first](const Entry& met) {
    if (!met.inside && met.fraction < first.fraction) first = met;
  };
  for (int i = 0; i < 3; ++i) {
    const Vector box{i == 0 ? grown.x : half.x, i == 1 ? grown.y : half.y, i == 2 ? grown.z : half.z};
    Entry met;
    if (meet_box(box, line, met)) take(met);
  }
  // The capsules along axis i, whose axis is y to meet_capsule.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (const double side_j : {-half[j], half[j]}) {
      for (const double side_k : {-half[k], half[k]}) {
        const Line turned{{line.origin[j] - side_j, line.origin[i], line.origin[k] - side_k},
                          {line.translation[j], line.translation[i], line.translation[k]}};
        Entry met;
        if (!meet_capsule(half[i], rounding, turned, met)) continue;
        double normal[3];
        normal[j] = met.normal.x;
        normal[i] = met.normal.y;
        normal[k] = met.normal.z;
        met.normal = {normal[0], normal[1], normal[2]};
        take(met);
      }
    }
  }
  if (!(first.fraction <= 1.0)) return false;
  entry = first;
  return true;
}

}  // namespace scree::queries
