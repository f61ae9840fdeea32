// Spheres and capsules against boxes. While the segment is outside, takes its closest point to the box; where
// it passes through the box, tests separating axes.
#include <simd/collide/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// A segment whose distance from the box is below this share of its radius counts as inside.
constexpr float kInside = 1e-4f;
// A normal whose component along a face's normal is above this leans on the face.
constexpr float kFaceCosine = 0.98f;

struct Axes {
  F of[3];
};
Axes axes_of(V3 v) { return {{v.x, v.y, v.z}}; }
V3 vector_of(const Axes& a) { return {a.of[0], a.of[1], a.of[2]}; }
V3 clamp_to_box(V3 p, V3 half) {
  return {clamp(p.x, -half.x, half.x), clamp(p.y, -half.y, half.y), clamp(p.z, -half.z, half.z)};
}
F largest_of(V3 v) { return max(v.x, max(v.y, v.z)); }

// In the box's frame: the segment center + t half_segment with t in [-1, 1], and the box's half extents.
struct SegmentBox {
  V3 center, half_segment, half;
  F radius;
};

// The closest point: its parameter, the outward normal of the box and the separation.
struct Closest {
  F t;
  V3 normal;
  F separation;
  M inside;  // the segment passes through the box
};

// Normal and depth of a point in the box: out through the nearest face, the first of equal ones.
void leave_by_face(V3 point, V3 half, V3 reach, V3& normal, F& separation) {
  const F one(1.0f), zero(0.0f);
  normal = {sign_of(point.x), zero, zero};
  separation = abs(point.x) - half.x - reach.x;
  const F along_y = abs(point.y) - half.y - reach.y, along_z = abs(point.z) - half.z - reach.z;
  const M is_y = along_y > separation;
  normal = select(is_y, {zero, copy_sign(one, point.y), zero}, normal);
  separation = select(is_y, along_y, separation);
  const M is_z = along_z > separation;
  normal = select(is_z, {zero, zero, copy_sign(one, point.z)}, normal);
  separation = select(is_z, along_z, separation);
}

struct SphereBox {
  using Contact = WideContact<1>;

  static V3 center_in_box(const WidePair& pair) { return rotate_back(pair.second.rotation, -pair.offset); }

  static M may_touch(const WidePair& pair, I&) {
    const V3 half = pair.extent_2.half, center = center_in_box(pair);
    const V3 outside = center - clamp_to_box(center, half);
    return spheres_touch(pair, pair.extent_1.radius, length(half)) & is_rotation(pair.first.rotation) &
           is_rotation(pair.second.rotation) & (length(outside) - pair.extent_1.radius <= pair.reach);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const V3 half = pair.extent_2.half, center = center_in_box(pair), zero{F(0.0f), F(0.0f), F(0.0f)};
    const F radius = pair.extent_1.radius;
    const V3 outside = center - clamp_to_box(center, half);
    const F distance = length(outside);
    V3 normal;
    F separation;
    leave_by_face(center, half, zero, normal, separation);
    const M is_outside = distance > F(kInside) * radius;
    normal = select(is_outside, outside * (F(1.0f) / select(is_outside, distance, F(1.0f))), normal);
    separation = select(is_outside, distance, separation) - radius;
    contact.normal = -rotate(pair.second.rotation, normal);
    contact.point[0] = contact.normal * (radius + F(0.5f) * separation);
    contact.separation[0] = separation;
    contact.id[0] = I(1);
    set_radius(contact, radius);
  }
};

// The capsule is the first shape.
struct CapsuleBox {
  using Contact = WideContact<2>;

  static SegmentBox to_box_frame(const WidePair& pair) {
    return {rotate_back(pair.second.rotation, -pair.offset), half_segment_in_second(pair), pair.extent_2.half,
            pair.extent_1.radius};
  }

  // Half the derivative of the squared distance from the box by t.
  static F slope(const SegmentBox& g, F t) {
    const V3 x = g.center + t * g.half_segment;
    return dot(g.half_segment, x - clamp_to_box(x, g.half));
  }

  // The squared distance is convex in t, and its derivative is linear between the places where the segment
  // crosses a plane of a face: the root lies between the two of them where the sign changes.
  static F closest_parameter(const SegmentBox& g) {
    const F zero(0.0f);
    F low(-1.0f), high(1.0f);
    F slope_low = slope(g, low), slope_high = slope(g, high);
    const M starts_up = slope_low >= zero, ends_down = slope_high <= zero;
    const F slope_first = slope_low, slope_last = slope_high;
    const Axes center = axes_of(g.center), along = axes_of(g.half_segment), half = axes_of(g.half);
    for (int axis = 0; axis < 3; ++axis) {
      const F step = copy_sign(max(abs(along.of[axis]), F(1e-18f)), along.of[axis]);
      for (int side = 0; side < 2; ++side) {
        const F plane = side == 0 ? -half.of[axis] : half.of[axis];
        const F t = clamp((plane - center.of[axis]) / step, F(-1.0f), F(1.0f));
        const F at = slope(g, t);
        const M raise = (at <= zero) & (t > low), lower = (at >= zero) & (t < high);
        low = select(raise, t, low);
        slope_low = select(raise, at, slope_low);
        high = select(lower, t, high);
        slope_high = select(lower, at, slope_high);
      }
    }
    high = select(starts_up, F(-1.0f), high);
    slope_high = select(starts_up, slope_first, slope_high);
    low = select(ends_down, F(1.0f), low);
    slope_low = select(ends_down, slope_last, slope_low);
    // Where the slope is zero on a whole stretch low > high: its middle.
    const F rise = slope_high - slope_low;
    const M crosses = (rise > zero) & (high > low);
    const F between = low - slope_low * (high - low) / select(crosses, rise, F(1.0f));
    return clamp(select(crosses, between, F(0.5f) * (low + high)), F(-1.0f), F(1.0f));
  }

  // Separating axes for a segment through the box: three face normals and three products of edges with the
  // segment. An edge must win by the tolerance over the best face.
  static void leave_by_axis(const SegmentBox& g, F tolerance, Closest& found) {
    V3 normal;
    F separation;
    const V3 reach{abs(g.half_segment.x), abs(g.half_segment.y), abs(g.half_segment.z)};
    leave_by_face(g.center, g.half, reach, normal, separation);
    // The end that is deepest along the face's normal.
    F t = -sign_of(dot(normal, g.half_segment));
    F best = separation + tolerance;
    const Axes d = axes_of(g.half_segment), c = axes_of(g.center), half = axes_of(g.half);
    const F length_2 = length_squared(g.half_segment);
    for (int axis = 0; axis < 3; ++axis) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      // The unit vector of `axis` times the segment: (0, -d_last, d_next) in the order axis, next, last.
      const F squared = square(d.of[next]) + square(d.of[last]);
      const M crossing = squared > F(1e-6f) * length_2;
      const F inverse = F(1.0f) / sqrt(select(crossing, squared, F(1.0f)));
      const F l_next = -d.of[last] * inverse, l_last = d.of[next] * inverse;
      const F distance = l_next * c.of[next] + l_last * c.of[last];
      const F along = abs(distance) - half.of[next] * abs(l_next) - half.of[last] * abs(l_last);
      const M wins = crossing & (along > best);
      best = select(wins, along, best);
      separation = select(wins, along, separation);
      Axes n;
      n.of[axis] = F(0.0f);
      n.of[next] = l_next * sign_of(distance);
      n.of[last] = l_last * sign_of(distance);
      normal = select(wins, vector_of(n), normal);
      // Where the segment passes the edge, seen along the edge.
      const F edge_next = copy_sign(half.of[next], n.of[next]),
              edge_last = copy_sign(half.of[last], n.of[last]);
      const F toward = d.of[next] * (edge_next - c.of[next]) + d.of[last] * (edge_last - c.of[last]);
      t = select(wins, clamp(toward / select(crossing, squared, F(1.0f)), F(-1.0f), F(1.0f)), t);
    }
    found.t = select(found.inside, t, found.t);
    found.normal = select(found.inside, normal, found.normal);
    found.separation = select(found.inside, separation - g.radius, found.separation);
  }

  static M may_touch(const WidePair& pair, I&) {
    const F size = pair.extent_1.half.y + pair.extent_1.radius;
    const M near = spheres_touch(pair, size, length(pair.extent_2.half)) & is_rotation(pair.first.rotation) &
                   is_rotation(pair.second.rotation);
    if (!any(near)) return near;
    const SegmentBox g = to_box_frame(pair);
    const V3 gap{abs(g.center.x) - abs(g.half_segment.x) - g.half.x,
                 abs(g.center.y) - abs(g.half_segment.y) - g.half.y,
                 abs(g.center.z) - abs(g.half_segment.z) - g.half.z};
    const M near_faces = near & (largest_of(gap) - g.radius <= pair.reach);
    if (!any(near_faces)) return near_faces;
    const V3 x = g.center + closest_parameter(g) * g.half_segment;
    return near_faces & (length(x - clamp_to_box(x, g.half)) - g.radius <= pair.reach);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const SegmentBox g = to_box_frame(pair);
    const F smallest = min(g.radius, min(g.half.x, min(g.half.y, g.half.z)));
    const F tolerance = min(F(kFeatureTolerance), F(kFeatureShare) * smallest);
    Closest found;
    found.t = closest_parameter(g);
    const V3 x = g.center + found.t * g.half_segment;
    const V3 outside = x - clamp_to_box(x, g.half);
    const F distance = length(outside);
    found.inside = !(distance > F(kInside) * g.radius);
    found.normal = outside * (F(1.0f) / select(found.inside, F(1.0f), distance));
    found.separation = distance - g.radius;
    if (any(found.inside)) leave_by_axis(g, tolerance, found);

    contact.normal = -rotate(pair.second.rotation, found.normal);
    contact.point[0] = point_at(pair, g, found, found.t, found.separation);
    contact.separation[0] = found.separation;
    contact.id[0] = I(3);
    set_radius(contact, g.radius);
    set_absent(contact, 1);
    use_stretch(pair, g, found, tolerance, contact);
  }

  // Halfway between the surfaces, relative to the capsule's center, in world axes.
  static V3 point_at(const WidePair& pair, const SegmentBox& g, const Closest& found, F t, F separation) {
    return rotate(pair.second.rotation,
                  t * g.half_segment - found.normal * (g.radius + F(0.5f) * separation));
  }

  // A capsule that lies on a face or along an edge touches at both ends of its stretch over it: the part of
  // the segment between the planes that bound the face, or between the edge's ends.
  static void use_stretch(const WidePair& pair, const SegmentBox& g, const Closest& found, F tolerance,
                          Contact& contact) {
    const Axes n = axes_of(found.normal), d = axes_of(g.half_segment), c = axes_of(g.center);
    const Axes half = axes_of(g.half);
    const F smallest_component = min(abs(n.of[0]), min(abs(n.of[1]), abs(n.of[2])));
    F t[2] = {F(-1.0f), F(1.0f)};
    M on_face = never();
    F height_at_center(0.0f), height_slope(0.0f);  // over the face along the normal; zero without a face
    M bounded = never();                           // an axis has bounded the stretch along the edge
    for (int axis = 0; axis < 3; ++axis) {
      const M is_face = abs(n.of[axis]) > F(kFaceCosine);
      const F face_cosine = F(1.0f) / select(is_face, abs(n.of[axis]), F(1.0f));
      on_face = on_face | is_face;
      height_at_center =
          select(is_face, (sign_of(n.of[axis]) * c.of[axis] - half.of[axis]) * face_cosine, height_at_center);
      height_slope = select(is_face, sign_of(n.of[axis]) * d.of[axis] * face_cosine, height_slope);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const M is_edge = (!(on_face | bounded)) & (abs(n.of[axis]) == smallest_component);
      bounded = bounded | is_edge;
      const M bounds = is_edge | (on_face & (abs(n.of[axis]) <= F(kFaceCosine)));
      // Where the segment's image on the face, along the normal, crosses the planes.
      const F center = c.of[axis] - n.of[axis] * height_at_center,
              run = d.of[axis] - n.of[axis] * height_slope;
      const F step = copy_sign(max(abs(run), F(1e-18f)), run);
      const F enter = (-half.of[axis] - center) / step, leave = (half.of[axis] - center) / step;
      t[0] = select(bounds, max(t[0], min(enter, leave)), t[0]);
      t[1] = select(bounds, min(t[1], max(enter, leave)), t[1]);
    }
    V3 point[2];
    F separation[2];
    M level = lies_across(g.half_segment, found.normal, g.radius);
    for (int k = 0; k < 2; ++k) {
      const F end = clamp(t[k], F(-1.0f), F(1.0f));
      const V3 x = g.center + end * g.half_segment;
      const V3 outside = x - clamp_to_box(x, g.half);
      level = level & (on_face | is_beside(outside, found.normal, F(0.25f * kLinearSlop * kLinearSlop)));
      separation[k] = select(on_face, height_at_center + end * height_slope, length(outside)) - g.radius;
      point[k] = point_at(pair, g, found, end, separation[k]);
    }
    const F spread = F(kMinimumSpread) * g.radius;
    const M long_enough =
        (t[1] > t[0]) & (square(t[1] - t[0]) * length_squared(g.half_segment) > square(spread));
    const M keeps_depth = min(separation[0], separation[1]) <= contact.separation[0] + tolerance;
    const M stretches = level & (on_face | (!found.inside));
    use_ends(contact, pair.reach, stretches & long_enough & keeps_depth, point, separation);
  }
};

}  // namespace

void collide_sphere_box(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<SphereBox>(columns, items, count);
}
void collide_capsule_box(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<CapsuleBox>(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
