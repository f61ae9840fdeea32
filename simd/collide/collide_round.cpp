// Spheres and capsules against each other: the closest points of two segments. The segment of a sphere has
// length zero.
#include <simd/collide/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Below this share of the radii the direction between two closest points is noise.
constexpr float kCoincident = 1e-6f;

// Half of a capsule's inner segment in world axes.
V3 capsule_half(const WidePose& pose, const WideExtent& extent) {
  const Q4 q = pose.rotation;
  const F two(2.0f);
  const V3 axis_y{two * (q.x * q.y - q.w * q.z), F(1.0f) - two * (q.x * q.x + q.z * q.z),
                  two * (q.y * q.z + q.w * q.x)};
  return axis_y * extent.half.y;
}

// Unit vector from x to y, or `fallback` if they coincide.
V3 direction(V3 difference, F distance, F radii, V3 fallback) {
  const M apart = distance > F(kCoincident) * radii;
  const V3 unit = difference * (F(1.0f) / select(apart, distance, F(1.0f)));
  return select(apart, unit, fallback);
}

V3 any_perpendicular(V3 v) { return tangent_of(v * (F(1.0f) / sqrt(max(length_squared(v), F(1e-30f))))); }

M is_close(const WidePair& pair, F distance, F radii) { return distance - radii <= pair.reach; }

template <int kPoints>
void set_radii(WideContact<kPoints>& contact, const WidePair& pair) {
  const F radius_1 = pair.extent_1.radius, radius_2 = pair.extent_2.radius;
  contact.curvature_radius = radius_1 * (radius_2 / (radius_1 + radius_2));
  contact.radius_1 = radius_1;
  contact.radius_2 = radius_2;
}

// A point on the line between the closest points x and y, both relative to the first shape.
template <int kPoints>
void set_single(WideContact<kPoints>& contact, V3 normal, V3 x, F radius_1, F separation, std::int32_t id) {
  contact.normal = normal;
  contact.point[0] = x + normal * (radius_1 + F(0.5f) * separation);
  contact.separation[0] = separation;
  contact.id[0] = I(id);
}

struct SphereSphere {
  using Contact = WideContact<1>;

  static M may_touch(const WidePair& pair, I&) {
    return spheres_touch(pair, pair.extent_1.radius, pair.extent_2.radius) &
           is_close(pair, length(pair.offset), pair.extent_1.radius + pair.extent_2.radius) &
           is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const F radii = pair.extent_1.radius + pair.extent_2.radius;
    const F distance = length(pair.offset);
    const V3 up{F(0.0f), F(1.0f), F(0.0f)};
    const V3 normal = direction(pair.offset, distance, radii, up);
    set_single(contact, normal, {F(0.0f), F(0.0f), F(0.0f)}, pair.extent_1.radius, distance - radii, 1);
    set_radii(contact, pair);
  }
};

// The sphere is the first shape.
struct SphereCapsule {
  using Contact = WideContact<1>;

  static V3 closest(const WidePair& pair, V3 half) {
    const F t = -dot(half, pair.offset) / max(length_squared(half), F(1e-30f));
    return pair.offset + half * clamp(t, F(-1.0f), F(1.0f));
  }

  static M may_touch(const WidePair& pair, I&) {
    const V3 half = capsule_half(pair.second, pair.extent_2);
    return spheres_touch(pair, pair.extent_1.radius, pair.extent_2.half.y + pair.extent_2.radius) &
           is_close(pair, length(closest(pair, half)), pair.extent_1.radius + pair.extent_2.radius) &
           is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const V3 half = capsule_half(pair.second, pair.extent_2);
    const F radii = pair.extent_1.radius + pair.extent_2.radius;
    const V3 y = closest(pair, half);
    const F distance = length(y);
    const V3 normal = direction(y, distance, radii, any_perpendicular(half));
    set_single(contact, normal, {F(0.0f), F(0.0f), F(0.0f)}, pair.extent_1.radius, distance - radii, 1);
    set_radii(contact, pair);
  }
};

struct CapsuleCapsule {
  using Contact = WideContact<2>;

  // Segments x(s) = s d1 and y(t) = e + t d2, with s and t in [-1, 1].
  struct Segments {
    V3 d1, d2, e, cross_12;
    F d1_squared, d2_squared, d1_d2, d1_e, d2_e, cross_squared;
  };
  static Segments segments(const WidePair& pair) {
    Segments g;
    g.d1 = capsule_half(pair.first, pair.extent_1);
    g.d2 = capsule_half(pair.second, pair.extent_2);
    g.e = pair.offset;
    g.cross_12 = cross(g.d1, g.d2);
    g.d1_squared = max(length_squared(g.d1), F(1e-30f));
    g.d2_squared = max(length_squared(g.d2), F(1e-30f));
    g.d1_d2 = dot(g.d1, g.d2);
    g.d1_e = dot(g.d1, g.e);
    g.d2_e = dot(g.d2, g.e);
    g.cross_squared = length_squared(g.cross_12);
    return g;
  }
  static F to_second(const Segments& g, F s) {
    return clamp((g.d1_d2 * s - g.d2_e) / g.d2_squared, F(-1.0f), F(1.0f));
  }

  // The closest points by the lines' closest points, clamped one after the other (Ericson, "Real-Time
  // Collision Detection", 5.1.9), with cross products where the usual determinant cancels.
  static void closest(const Segments& g, F& s, F& t) {
    constexpr float kParallel = 1e-6f;  // squared sine below which lines count as parallel
    const M crossing = g.cross_squared > F(kParallel) * g.d1_squared * g.d2_squared;
    const F on_line = dot(cross(g.e, g.d2), g.cross_12) / select(crossing, g.cross_squared, F(1.0f));
    t = to_second(g, select(crossing, clamp(on_line, F(-1.0f), F(1.0f)), F(0.0f)));
    s = clamp((g.d1_d2 * t + g.d1_e) / g.d1_squared, F(-1.0f), F(1.0f));
  }

  static M may_touch(const WidePair& pair, I&) {
    const M near = spheres_touch(pair, pair.extent_1.half.y + pair.extent_1.radius,
                                 pair.extent_2.half.y + pair.extent_2.radius) &
                   is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation);
    if (!any(near)) return near;
    const Segments g = segments(pair);
    F s, t;
    closest(g, s, t);
    return near &
           is_close(pair, length(g.e + t * g.d2 - s * g.d1), pair.extent_1.radius + pair.extent_2.radius);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const Segments g = segments(pair);
    const F radius_1 = pair.extent_1.radius, radii = radius_1 + pair.extent_2.radius;
    F s, t;
    closest(g, s, t);
    const V3 x = s * g.d1, difference = g.e + t * g.d2 - x;
    const F distance = length(difference);
    // Crossing segments separate along their common perpendicular, toward the second capsule's center.
    const M crossing = g.cross_squared > F(1e-12f) * g.d1_squared * g.d2_squared;
    const V3 common = g.cross_12 * (copy_sign(F(1.0f), dot(g.cross_12, g.e)) /
                                    sqrt(select(crossing, g.cross_squared, F(1.0f))));
    const V3 normal =
        direction(difference, distance, radii, select(crossing, common, any_perpendicular(g.d1)));
    set_single(contact, normal, x, radius_1, distance - radii, 3);
    set_absent(contact, 1);
    set_radii(contact, pair);
    use_overlap(g, pair, contact);
  }

  // Capsules side by side touch at both ends of their common stretch.
  static void use_overlap(const Segments& g, const WidePair& pair, Contact& contact) {
    const F radius_1 = pair.extent_1.radius, radii = radius_1 + pair.extent_2.radius;
    const F end_1 = (g.d1_e - g.d1_d2) / g.d1_squared, end_2 = (g.d1_e + g.d1_d2) / g.d1_squared;
    const F ends[2] = {max(min(end_1, end_2), F(-1.0f)), min(max(end_1, end_2), F(1.0f))};
    const F smaller = min(radius_1, pair.extent_2.radius);
    V3 point[2];
    F separation[2];
    M level =
        lies_across(g.d1, contact.normal, radius_1) & lies_across(g.d2, contact.normal, pair.extent_2.radius);
    for (int k = 0; k < 2; ++k) {
      const V3 x = ends[k] * g.d1, difference = g.e + to_second(g, ends[k]) * g.d2 - x;
      separation[k] = length(difference) - radii;
      level = level & is_beside(difference, contact.normal, F(kLinearSlop) * smaller);
      point[k] = x + contact.normal * (radius_1 + F(0.5f) * separation[k]);
    }
    const F tolerance = min(F(kFeatureTolerance), F(kFeatureShare) * smaller);
    const F spread = F(kMinimumSpread) * smaller;
    const M long_enough = (ends[1] > ends[0]) & (square(ends[1] - ends[0]) * g.d1_squared > square(spread));
    const M keeps_depth = min(separation[0], separation[1]) <= contact.separation[0] + tolerance;
    use_ends(contact, pair.reach, level & long_enough & keeps_depth, point, separation);
  }
};

}  // namespace

void collide_sphere_sphere(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<SphereSphere>(columns, items, count);
}
void collide_sphere_capsule(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<SphereCapsule>(columns, items, count);
}
void collide_capsule_capsule(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<CapsuleCapsule>(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
