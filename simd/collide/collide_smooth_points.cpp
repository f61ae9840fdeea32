// Smooth shapes: contact points. The features of both shapes along the normal are clipped against each other,
// seen along the normal; every corner of what they share has the heights of both (after D. Gregorius,
// "Robust contact creation for physics simulation", GDC 2015). Of these corners at most four stay, the
// deepest and those that spread most.
//
// Clipping: I. E. Sutherland and G. W. Hodgman, "Reentrant polygon clipping", Comm. ACM 17(1), 1974. A corner
// is named by the two sides that meet there, so that it keeps its name while both shapes jitter.
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

std::uint32_t id_of(std::uint32_t kind, int first, int second) {
  return kind | static_cast<std::uint32_t>(first) << 8 | static_cast<std::uint32_t>(second);
}

// Seen along the normal.
struct Flat {
  double u, v, height;
};
struct View {
  Tangents tangents;
  D3 normal;

  Flat see(D3 p) const { return {dot(tangents.u, p), dot(tangents.v, p), dot(normal, p)}; }
};

// The height of a polygon's plane.
struct Slope {
  double u, v, height;

  double at(double x, double y) const { return height + u * x + v * y; }
};
Slope slope_of(const View& view, const Feature& feature) {
  const double along = dot(view.normal, feature.normal);
  const double u = -dot(view.tangents.u, feature.normal) / along,
               v = -dot(view.tangents.v, feature.normal) / along;
  const Flat p = view.see(feature.point[0]);
  return {u, v, p.height - (u * p.u + v * p.v)};
}

// Both features, and what their surfaces add.
struct Clip {
  View view;
  const Feature* feature[2];
  double margins, raise;  // m; `raise`: what the middle between the surfaces lies above that of the cores
  double deepest;         // of the surfaces
  double border;          // m, by which the second feature counts as larger
  SmoothCandidates* out;

  void put(double u, double v, double height_1, double height_2, std::uint32_t id) const {
    const double separation = greater_of(height_2 - height_1 - margins, deepest);
    out->of[out->count++] = {u, v, 0.5 * (height_1 + height_2) + raise, separation, id};
  }
};

// --- polygons ---

struct Corner {
  double u, v;
  int side_of;  // whose side begins here: 0 or 1
  int name;     // of the side
  int at;       // which corner of the second feature ends the side, if it is the second one's
};
struct Polygon {
  int count = 0;
  Corner corner[2 * kMostCorners];

  void put(const Corner& c) {
    if (count < 2 * kMostCorners) corner[count++] = c;
  }
};

// What lies left of a side: that from `from` to `to`, moved out by the border.
struct HalfPlane {
  double u, v, offset;

  double above(const Corner& c) const { return u * c.u + v * c.v - offset; }
};

void cut(const Polygon& from, const HalfPlane& half, int name, int at, Polygon& to) {
  to.count = 0;
  for (int k = 0; k < from.count; ++k) {
    const Corner &a = from.corner[k], &b = from.corner[k + 1 < from.count ? k + 1 : 0];
    const double height_a = half.above(a), height_b = half.above(b);
    const bool in_a = height_a <= 0.0, in_b = height_b <= 0.0;
    if (in_a) to.put(a);
    if (in_a == in_b) continue;
    const double share = height_a / (height_a - height_b);
    Corner crossing = a;  // of the same side where it comes in
    crossing.u = a.u + share * (b.u - a.u);
    crossing.v = a.v + share * (b.v - a.v);
    if (in_a) {
      crossing.side_of = 1;
      crossing.name = name;
      crossing.at = at;
    }
    to.put(crossing);
  }
}

// Counterclockwise seen along the normal: 1, or -1.
double turn_of(const Flat* p, int count) {
  double area = 0.0;
  for (int k = 0; k < count; ++k) {
    const Flat &a = p[k], &b = p[k + 1 < count ? k + 1 : 0];
    area += (a.u - p[0].u) * (b.v - p[0].v) - (a.v - p[0].v) * (b.u - p[0].u);
  }
  return area < 0.0 ? -1.0 : 1.0;
}

void flatten(const View& view, const Feature& feature, Flat* to) {
  for (int k = 0; k < feature.count; ++k) to[k] = view.see(feature.point[k]);
}

HalfPlane half_plane(const Flat& a, const Flat& b, double turn, double border) {
  double u = turn * (b.v - a.v), v = -turn * (b.u - a.u);
  const double size = root(u * u + v * v), scale = size > 0.0 ? 1.0 / size : 0.0;
  u *= scale;
  v *= scale;
  return {u, v, u * a.u + v * a.v + border};
}

void clip_polygons(const Clip& clip) {
  const Feature &first = *clip.feature[0], &second = *clip.feature[1];
  Flat flat_1[kMostCorners], flat_2[kMostCorners];
  flatten(clip.view, first, flat_1);
  flatten(clip.view, second, flat_2);
  Polygon polygon[2];
  for (int k = 0; k < first.count; ++k) polygon[0].put({flat_1[k].u, flat_1[k].v, 0, first.name[k], k});
  const double turn = turn_of(flat_2, second.count);
  int now = 0;
  for (int k = 0; k < second.count && polygon[now].count > 0; ++k, now ^= 1) {
    const int next = k + 1 < second.count ? k + 1 : 0;
    cut(polygon[now], half_plane(flat_2[k], flat_2[next], turn, clip.border), second.name[k], next,
        polygon[now ^ 1]);
  }
  const Slope slope_1 = slope_of(clip.view, first), slope_2 = slope_of(clip.view, second);
  const Polygon& all = polygon[now];
  for (int k = 0; k < all.count; ++k) {
    const Corner &c = all.corner[k], &before = all.corner[k > 0 ? k - 1 : all.count - 1];
    double u = c.u, v = c.v;
    std::uint32_t id;
    if (c.side_of == 0 && before.side_of == 0) {
      id = id_of(kOfFirst, c.name, 0);
    } else if (c.side_of == 1 && before.side_of == 1) {
      // A corner of the second feature, which the border has moved.
      const bool forward = second.name[before.at] == c.name;
      const int corner = forward ? before.at : c.at;
      u = flat_2[corner].u;
      v = flat_2[corner].v;
      id = id_of(kOfSecond, 0, second.name[corner]);
    } else {
      id = id_of(kOfBoth, c.side_of == 0 ? c.name : before.name, c.side_of == 1 ? c.name : before.name);
    }
    clip.put(u, v, slope_1.at(u, v), slope_2.at(u, v), id);
  }
}

// --- segments ---

// A segment of one shape over a polygon of the other one.
void clip_segment(const Clip& clip, int side) {
  const Feature &line = *clip.feature[side], &polygon = *clip.feature[1 - side];
  Flat flat[kMostCorners];
  flatten(clip.view, polygon, flat);
  const double turn = turn_of(flat, polygon.count);
  const Flat a = clip.view.see(line.point[0]), b = clip.view.see(line.point[1]);
  double begin = 0.0, end = 1.0;
  int begins_at = 0, ends_at = 0;  // 1 + the name of the side that cuts
  for (int k = 0; k < polygon.count; ++k) {
    const HalfPlane half = half_plane(flat[k], flat[k + 1 < polygon.count ? k + 1 : 0], turn, clip.border);
    const double above_a = half.u * a.u + half.v * a.v - half.offset;
    const double above_b = half.u * b.u + half.v * b.v - half.offset;
    if (above_a > 0.0 && above_b > 0.0) return;
    if (above_a > 0.0 || above_b > 0.0) {
      const double share = above_a / (above_a - above_b);
      if (above_a > 0.0 && share > begin) {
        begin = share;
        begins_at = 1 + polygon.name[k];
      } else if (above_b > 0.0 && share < end) {
        end = share;
        ends_at = 1 + polygon.name[k];
      }
    }
  }
  if (begin > end) return;
  const Slope slope = slope_of(clip.view, polygon);
  const double shares[2] = {begin, end};
  const int cuts[2] = {begins_at, ends_at};
  for (int k = 0; k < 2; ++k) {
    const double t = shares[k], u = a.u + t * (b.u - a.u), v = a.v + t * (b.v - a.v);
    const double own = a.height + t * (b.height - a.height), other = slope.at(u, v);
    const int name = line.name[k], cut = cuts[k] > 0 ? cuts[k] - 1 : 0;
    const std::uint32_t kind = cuts[k] > 0 ? kOfBoth : side == 0 ? kOfFirst : kOfSecond;
    clip.put(u, v, side == 0 ? own : other, side == 0 ? other : own,
             side == 0 ? id_of(kind, name, cut) : id_of(kind, cut, name));
  }
}

// Two segments side by side touch at both ends of their common stretch; `beside`: squared, how far apart,
// seen along the normal, they may be there.
void clip_segments(const Clip& clip, double beside, double spread) {
  const Feature &first = *clip.feature[0], &second = *clip.feature[1];
  const Flat a = clip.view.see(first.point[0]), b = clip.view.see(first.point[1]);
  const Flat c = clip.view.see(second.point[0]), d = clip.view.see(second.point[1]);
  const double way_u = b.u - a.u, way_v = b.v - a.v, squared = way_u * way_u + way_v * way_v;
  const double other_u = d.u - c.u, other_v = d.v - c.v;
  const double along = way_u * other_u + way_v * other_v;
  if (!(squared > 0.0) || along == 0.0) return;
  const double at_c = ((c.u - a.u) * way_u + (c.v - a.v) * way_v) / squared;
  const double at_d = ((d.u - a.u) * way_u + (d.v - a.v) * way_v) / squared;
  const bool same_way = at_c <= at_d;
  const double low = same_way ? at_c : at_d, high = same_way ? at_d : at_c;
  const double begin = greater_of(low, 0.0), end = lesser_of(high, 1.0);
  if (!(end > begin) || (end - begin) * (end - begin) * squared <= spread * spread) return;
  const double shares[2] = {begin, end};
  for (const double t : shares) {
    const double s = (t - at_c) / (at_d - at_c);
    const double u = a.u + t * way_u - (c.u + s * other_u), v = a.v + t * way_v - (c.v + s * other_v);
    if (u * u + v * v > beside) return;
  }
  for (int k = 0; k < 2; ++k) {
    const double t = shares[k], s = (t - at_c) / (at_d - at_c);
    const bool of_first = k == 0 ? low <= 0.0 : high >= 1.0;
    const int own = first.name[k], other = second.name[same_way ? k : 1 - k];
    clip.put(a.u + t * way_u, a.v + t * way_v, a.height + t * (b.height - a.height),
             c.height + s * (d.height - c.height),
             of_first ? id_of(kOfFirst, own, 0) : id_of(kOfSecond, 0, other));
  }
}

// The radius of a rounded segment about its core, or of the side that it is of.
double radius_of(const Core& core, const Feature& feature) {
  return core.margin + (feature.is_rolling ? core.half[0] : 0.0);
}

// The points where the search ended, if none of the candidates is about as deep.
void put_deepest(const Clip& clip, const Gap& gap, double tolerance) {
  for (int k = 0; k < clip.out->count; ++k) {
    if (clip.out->of[k].separation <= clip.deepest + tolerance) return;
  }
  const Flat p = clip.view.see(gap.on_1), q = clip.view.see(gap.on_2);
  const double middle = 0.5 * (p.height + q.height), half = 0.5 * gap.separation;
  clip.put(0.5 * (p.u + q.u), 0.5 * (p.v + q.v), middle - half, middle + half, kOfSearch);
}

D3 without_spin(const Core& core, D3 angular) {
  switch (core.kind) {
    case CoreKind::point:
      return {0.0, 0.0, 0.0};
    case CoreKind::segment:
    case CoreKind::cylinder:
    case CoreKind::cone:
      return angular - dot(core.axis[1], angular) * core.axis[1];
    default:
      return angular;
  }
}

}  // namespace

PairMotion motion_of(const CollideColumns& columns, std::int32_t body_1, std::int32_t body_2,
                     const float (&origin)[3], const Core& a, const Core& b) {
  PairMotion motion;
  motion.dt = double{columns.dt};
  const std::int32_t bodies[2] = {body_1, body_2};
  const Core* cores[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    const VelocityRow& velocity = columns.body_velocity[bodies[side]];
    BodyMotion& to = motion.body[side];
    const D3 mass_center = to_d3(columns.body_pose[bodies[side]].position) - to_d3(origin);
    to.whole_angular = to_d3(velocity.angular);
    to.center = cores[side]->center;
    to.linear = to_d3(velocity.linear) + cross(to.whole_angular, to.center - mass_center);
    to.angular = without_spin(*cores[side], to.whole_angular);
  }
  return motion;
}

// Whether two faces, seen along the normal, have no more than a thin strip in common.
bool share_a_strip(const SmoothCandidates& common, double thinnest) {
  double from_u = 0.0, from_v = 0.0, to_u = 0.0, to_v = 0.0;
  const auto take_farthest = [&](double u, double v, double& far_u, double& far_v) {
    double most = -1.0;
    for (int k = 0; k < common.count; ++k) {
      const SmoothCandidate& c = common.of[k];
      const double square = (c.u - u) * (c.u - u) + (c.v - v) * (c.v - v);
      if (!(square > most)) continue;
      most = square;
      far_u = c.u;
      far_v = c.v;
    }
  };
  if (common.count == 0) return true;
  take_farthest(common.of[0].u, common.of[0].v, from_u, from_v);
  take_farthest(from_u, from_v, to_u, to_v);
  const double way_u = to_u - from_u, way_v = to_v - from_v, way = root(way_u * way_u + way_v * way_v);
  double area = 0.0;
  for (int k = 0; k < common.count; ++k) {
    const double side = way_u * (common.of[k].v - from_v) - way_v * (common.of[k].u - from_u);
    area = greater_of(area, side < 0.0 ? -side : side);
  }
  return area < lesser_of(double{kStrip}, thinnest) * way || !(way > 0.0);
}

void find_points(const Core& a, const Core& b, const Gap& gap, double reach, const PairMotion& motion,
                 SmoothContact& contact) {
  Feature feature[2];
  DiskFrame disks{lean_of(a, gap.normal) + lean_of(b, -gap.normal), false, gap.normal};
  find_feature(a, gap.normal, disks, feature[0]);
  disks.has_start = feature[0].is_disk;
  disks.start = feature[0].start;
  find_feature(b, -gap.normal, disks, feature[1]);
  const double tolerance = tolerance_of(a, b), margins = a.margin + b.margin;
  const double deepest = gap.separation - margins;
  SmoothCandidates candidates;
  const Clip clip{{tangents_of(gap.normal), gap.normal},
                  {&feature[0], &feature[1]},
                  margins,
                  0.5 * (a.margin - b.margin),
                  deepest,
                  tolerance,
                  &candidates};
  const int counts[2] = {feature[0].count, feature[1].count};
  contact.in_strip = false;
  if (counts[0] > 2 && counts[1] > 2) {
    clip_polygons(clip);
    contact.in_strip = share_a_strip(candidates, lesser_of(a.thinness, b.thinness));
  } else if (counts[0] == 2 && counts[1] == 2) {
    const double radius_1 = radius_of(a, feature[0]), radius_2 = radius_of(b, feature[1]);
    const double smaller =
        radius_1 > 0.0 && radius_2 > 0.0 ? lesser_of(radius_1, radius_2) : radius_1 + radius_2;
    clip_segments(clip, greater_of(double{kLinearSlop} * smaller, tolerance * tolerance),
                  double{kMinimumSpread} * lesser_of(a.thinness, b.thinness));
  } else if (counts[0] == 2 && counts[1] > 2) {
    clip_segment(clip, 0);
  } else if (counts[1] == 2 && counts[0] > 2) {
    clip_segment(clip, 1);
  }
  put_deepest(clip, gap, tolerance);
  const bool is_rim = feature[0].is_rim || feature[1].is_rim;
  drop_far(motion, gap.normal, clip.view.tangents, is_rim ? 0.0 : reach, deepest + tolerance, candidates);
  const bool on_triangle = b.kind == CoreKind::triangle;
  if (on_triangle || feature[0].is_disk || feature[1].is_disk) {
    choose_steady(candidates, feature[0].is_disk, feature[1].is_disk, on_triangle, gap.normal, tolerance,
                  contact);
  } else {
    choose_points(candidates, gap.normal, tolerance, tolerance, contact);
  }
  const Roundness one = find_roundness(a, feature[0], contact, 1.0, motion.body[0].whole_angular);
  const Roundness two = find_roundness(b, feature[1], contact, -1.0, motion.body[1].whole_angular);
  contact.core_1 = one.core;
  contact.core_2 = two.core;
  const double sum = one.curvature + two.curvature;
  contact.curvature_radius =
      one.curvature > 0.0 && two.curvature > 0.0 ? one.curvature * (two.curvature / sum) : sum;
  contact.at_edges = !feature[0].is_flat && !feature[1].is_flat;
}

void drop_far(const PairMotion& motion, D3 normal, const Tangents& tangents, double limit, double nearest,
              SmoothCandidates& candidates) {
  const auto speed_of = [&](const BodyMotion& body, D3 place) {
    return dot(normal, body.linear + cross(body.angular, place - body.center));
  };
  int kept = 0;
  for (int k = 0; k < candidates.count; ++k) {
    const SmoothCandidate& c = candidates.of[k];
    const D3 place = c.u * tangents.u + c.v * tangents.v + c.height * normal;
    const double closing = speed_of(motion.body[0], place) - speed_of(motion.body[1], place);
    const double ahead = c.separation - greater_of(closing, 0.0) * motion.dt;
    if (c.separation > nearest && ahead > limit) continue;
    candidates.of[kept++] = c;
  }
  candidates.count = kept;
}

Roundness find_roundness(const Core& core, const Feature& feature, const SmoothContact& contact, double side,
                         D3 spin) {
  const bool is_ball = core.kind == CoreKind::point || core.kind == CoreKind::segment;
  if (is_ball || (core.margin > 0.0 && !feature.is_flat)) return {core.margin, core.margin};
  if (!feature.is_rolling && !feature.is_rim) return {0.0, 0.0};
  // The radius in which the surface rolls is that of its circle there over the cosine of the circle's plane
  // to the normal (Meusnier).
  constexpr double kLeastCosine = 0.05;
  const D3 along = side * contact.normal;
  D3 point{0.0, 0.0, 0.0};
  double separation = 0.0;
  for (int k = 0; k < contact.count; ++k) {
    point = point + (1.0 / contact.count) * contact.point[k];
    separation += (1.0 / contact.count) * contact.separation[k];
  }
  point = point - (0.5 * separation) * along;  // on the shape's surface
  const D3 local = core.turn_back(point - core.center), way = core.turn_back(along);
  const double across = root(way.x * way.x + way.z * way.z);
  const double circle = root(local.x * local.x + local.z * local.z);
  const double radius = circle / greater_of(across, kLeastCosine);
  // As far as the body turns in the plane of that circle; otherwise the contact stays where it is.
  const D3 tangent = cross(core.axis[1], along), axis = cross(along, tangent);
  const double squared = dot(axis, axis), rolls = dot(spin, axis), tips = dot(spin, tangent);
  const double all = rolls * rolls + tips * tips;
  const double share = squared > 0.0 && all > 0.0 ? rolls * rolls / all : 1.0;
  return {share * radius, feature.is_rolling ? circle : 0.0};
}

// --- choice ---

namespace {

// Candidates count as equally good up to this share.
constexpr double kEqual = 1e-3;

// The first candidate whose score is the largest, up to a share or the slack; -1: none is above `least`.
template <class Score>
int best_of(const SmoothCandidates& c, double least, double slack, Score&& score) {
  double most = least;
  for (int k = 0; k < c.count; ++k) most = greater_of(score(c.of[k]), most);
  if (!(most > least)) return -1;
  const double enough = most - slack - kEqual * (slack > 0.0 ? 0.0 : absolute(most));
  for (int k = 0; k < c.count; ++k) {
    const double value = score(c.of[k]);
    if (value >= enough && value > least) return k;
  }
  return -1;
}

double area(const SmoothCandidate& a, const SmoothCandidate& b, const SmoothCandidate& p) {
  return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
}

}  // namespace

namespace {

void put_point(const SmoothCandidate& c, const Tangents& tangents, SmoothContact& contact) {
  const int k = contact.count++;
  contact.point[k] = c.u * tangents.u + c.v * tangents.v + c.height * contact.normal;
  contact.separation[k] = c.separation;
  contact.id[k] = c.id;
}

}  // namespace

void choose_points(const SmoothCandidates& candidates, D3 normal, double tolerance, double spread,
                   SmoothContact& contact) {
  const auto& of = candidates.of;
  int chosen[kMaxManifoldPoints], count = 0;
  const auto take = [&](int k) {
    if (k >= 0) chosen[count++] = k;
    return k >= 0;
  };
  if (take(best_of(candidates, -1e300, tolerance, [](const auto& c) { return -c.separation; }))) {
    const SmoothCandidate& a = of[chosen[0]];
    const auto apart = [&](const SmoothCandidate& c) {
      return (c.u - a.u) * (c.u - a.u) + (c.v - a.v) * (c.v - a.v);
    };
    if (take(best_of(candidates, spread * spread, 0.0, apart))) {
      const SmoothCandidate& b = of[chosen[1]];
      const double least = spread * root(apart(b));
      const auto aside = [&](const SmoothCandidate& c) { return absolute(area(a, b, c)); };
      if (take(best_of(candidates, least, 0.0, aside))) {
        const SmoothCandidate& d = of[chosen[2]];
        const double turn = area(a, b, d) < 0.0 ? 1.0 : -1.0;
        take(best_of(candidates, least, 0.0, [&](const SmoothCandidate& c) {
          return greater_of(turn * area(a, b, c), greater_of(turn * area(b, d, c), turn * area(d, a, c)));
        }));
      }
    }
  }
  const Tangents tangents = tangents_of(normal);
  contact.normal = normal;
  contact.count = 0;
  for (int k = 0; k < count; ++k) put_point(of[chosen[k]], tangents, contact);
}

void choose_steady(const SmoothCandidates& candidates, bool is_disk_1, bool is_disk_2, bool on_triangle,
                   D3 normal, double tolerance, SmoothContact& contact) {
  SmoothCandidates corners, others;
  for (int k = 0; k < candidates.count; ++k) {
    const SmoothCandidate& c = candidates.of[k];
    const bool of_first = is_first_corner(c.id), of_second = is_second_corner(c.id) && !on_triangle;
    const bool is_disk = of_first ? is_disk_1 : is_disk_2;
    const std::uint32_t name = of_first ? first_name(c.id) : second_name(c.id);
    const bool is_corner = (of_first || of_second) && (!is_disk || name % kDiskQuarter == 0);
    if (of_first && on_triangle && !is_corner) continue;
    SmoothCandidates& to = is_corner ? corners : others;
    to.of[to.count++] = c;
  }
  if (corners.count == 0) {
    choose_points(others.count > 0 ? others : candidates, normal, tolerance, tolerance, contact);
    return;
  }
  choose_points(corners, normal, tolerance, tolerance, contact);
  // Each further point is the farthest from all that are taken, and the deepest is among them.
  const Tangents tangents = tangents_of(normal);
  const auto apart = [&](const SmoothCandidate& c) {
    double least = 1e300;
    for (int k = 0; k < contact.count; ++k) {
      const double u = dot(tangents.u, contact.point[k]) - c.u, v = dot(tangents.v, contact.point[k]) - c.v;
      least = lesser_of(u * u + v * v, least);
    }
    return least;
  };
  const int deepest = best_of(others, -1e300, 0.0, [](const auto& c) { return -c.separation; });
  double so_far = 1e300;
  for (int k = 0; k < contact.count; ++k) so_far = lesser_of(contact.separation[k], so_far);
  if (deepest >= 0 && others.of[deepest].separation < so_far - tolerance) {
    if (contact.count == kMaxManifoldPoints) --contact.count;
    put_point(others.of[deepest], tangents, contact);
  }
  while (contact.count < kMaxManifoldPoints) {
    const int next = best_of(others, tolerance * tolerance, 0.0, apart);
    if (next < 0) return;
    put_point(others.of[next], tangents, contact);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
