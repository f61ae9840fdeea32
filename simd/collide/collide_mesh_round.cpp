// Spheres and capsules against triangles of a mesh: lane = triangle.
//
// Closest points by the regions of the triangle (Ericson, "Real-Time Collision Detection", 2005, 5.1). What
// is closest on an edge or a corner counts only where the mesh supports that direction (collide_mesh.h): else
// the neighbor is as close, or closer.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The point of a triangle's edges that is closest to a point, as the way from there to the point.
struct ToEdges {
  V3 way;
  F distance_2;
  WideEdgeSet edges;
};
ToEdges to_edges(const WideTriangles& t, V3 point) {
  ToEdges nearest{{F(0.0f), F(0.0f), F(0.0f)}, F(1e30f), edges_at(0, F(0.5f))};
  for (int k = 0; k < 3; ++k) {
    const V3 from = point - t.corner[k];
    const F share =
        clamp(dot(from, t.along[k]) / max(length_squared(t.along[k]), F(1e-37f)), F(0.0f), F(1.0f));
    const V3 way = from - share * t.along[k];
    const F distance_2 = length_squared(way);
    const M nearer = distance_2 < nearest.distance_2;
    nearest.way = select(nearer, way, nearest.way);
    nearest.distance_2 = select(nearer, distance_2, nearest.distance_2);
    nearest.edges = select(nearer, edges_at(k, share), nearest.edges);
  }
  return nearest;
}

M is_over(const WideTriangles& t, V3 point) {
  const F zero(0.0f);
  return (dot(t.outward[0], point - t.corner[0]) <= zero) & (dot(t.outward[1], point - t.corner[1]) <= zero) &
         (dot(t.outward[2], point - t.corner[2]) <= zero);
}

// A direction computed from a way this short, as a share of the radius, is noise: the normal is taken.
constexpr float kNoise = 1e-4f;

// The distance of a point from a triangle and the direction in which it grows.
struct Apart {
  F distance;
  V3 direction;
  M counts;  // the mesh supports the direction
};
Apart apart_of(const WideTriangles& t, V3 point, float radius) {
  const M over = is_over(t, point);
  const F height = dot(t.normal, point - t.corner[0]);
  const ToEdges edge = to_edges(t, point);
  const F far = sqrt(edge.distance_2);
  const M is_noise = far <= F(kNoise * radius);
  const V3 direction = edge.way * (F(1.0f) / max(far, F(1e-30f)));
  const M takes_normal = over | is_noise;
  return {select(over, height, far), select(takes_normal, t.normal, direction),
          takes_normal | supports(t, direction, edge.edges)};
}

// The stretch of a segment, center + s half, that lies over the triangle along its normal.
struct Over {
  F begin, end;
  M exists;
};
Over stretch_over(const WideTriangles& t, V3 half) {
  Over over{F(-1.0f), F(1.0f), F(0.0f) == F(0.0f)};
  const F tiny(1e-12f);
  for (int k = 0; k < 3; ++k) {
    const F beyond = -dot(t.outward[k], t.corner[k]);  // of the center
    const F slope = dot(t.outward[k], half);
    const M level = abs(slope) <= tiny;
    const F cut = -beyond / select(level, tiny, slope);
    over.exists = over.exists & ((!level) | (beyond <= F(0.0f)));
    over.begin = select((!level) & (slope < F(0.0f)), max(cut, over.begin), over.begin);
    over.end = select((!level) & (slope > F(0.0f)), min(cut, over.end), over.end);
  }
  over.exists = over.exists & (over.begin <= over.end);
  return over;
}

// The closest points of the segment and the triangle's edges, as the place on the segment and the way from
// the edge. Of a segment and an edge: Ericson, 5.1.9.
struct Nearest {
  F s;
  V3 way;
  F distance_2;
  WideEdgeSet edges;
};
Nearest nearest_of_edges(const WideTriangles& t, V3 half) {
  Nearest nearest{F(0.0f), {F(0.0f), F(0.0f), F(0.0f)}, F(1e30f), edges_at(0, F(0.5f))};
  const F one(1.0f), zero(0.0f), tiny(1e-37f);
  const F a = max(length_squared(half), tiny);
  for (int k = 0; k < 3; ++k) {
    const V3 from = -t.corner[k];  // from the edge's beginning to the center
    const F e = max(length_squared(t.along[k]), tiny), b = dot(half, t.along[k]);
    const F c = dot(half, from), f = dot(t.along[k], from);
    const F determinant = a * e - b * b;
    F s = select(determinant > F(1e-6f) * a * e, (b * f - c * e) / max(determinant, tiny), zero);
    s = clamp(s, -one, one);
    const F u = clamp((b * s + f) / e, zero, one);
    s = clamp((b * u - c) / a, -one, one);
    const V3 way = from + s * half - u * t.along[k];
    const F distance_2 = length_squared(way);
    const M nearer = distance_2 < nearest.distance_2;
    nearest.s = select(nearer, s, nearest.s);
    nearest.way = select(nearer, way, nearest.way);
    nearest.distance_2 = select(nearer, distance_2, nearest.distance_2);
    nearest.edges = select(nearer, edges_at(k, u), nearest.edges);
  }
  return nearest;
}

// Names of points: the capsule's ends keep theirs while it slides, others have their triangle's.
constexpr std::int32_t kEndNames = 3;
I name_of(I triangle, F s, std::int32_t which) {
  const I other = shift_left<2>(triangle & I(0x0fffffff)) + I(kEndNames + which);
  return select(s <= F(-1.0f), I(1), select(s >= F(1.0f), I(2), other));
}

}  // namespace

int touch_sphere(const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out) {
  const WideTriangles t = place_triangles(pair, batch);
  const V3 center{F(0.0f), F(0.0f), F(0.0f)};
  const Apart apart = apart_of(t, center, pair.radius);
  const F radius(pair.radius), separation = apart.distance - radius;
  WideTouch touch;
  touch.touches = apart.counts & (separation <= F(pair.hulls.reach));
  touch.normal = -apart.direction;
  touch.point[0] = touch.point[1] = touch.normal * (radius + F(0.5f) * separation);
  touch.separation[0] = touch.separation[1] = separation;
  touch.id[0] = I(1);
  touch.id[1] = I(0);
  return put_touches(batch, touch, out);
}

// Over the triangle the capsule touches with the ends of its stretch there, unless one of the triangle's
// edges is closer and pushes.
int touch_capsule(const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out) {
  const WideTriangles t = place_triangles(pair, batch);
  const F zero(0.0f), radius(pair.radius), reach(pair.hulls.reach);
  const V3 half{zero, F(pair.extent[1]), zero};
  const Over over = stretch_over(t, half);
  const F height = -dot(t.normal, t.corner[0]), slope = dot(t.normal, half);
  const F at[2] = {height + over.begin * slope, height + over.end * slope};
  const F lowest = min(at[0], at[1]);
  const Nearest edge = nearest_of_edges(t, half);
  const F far = sqrt(edge.distance_2);
  const V3 direction = edge.way * (F(1.0f) / max(far, F(1e-30f)));
  const F tolerance(smaller(kFeatureTolerance, kFeatureShare * pair.radius));
  // A segment through the triangle is closest to it where the two cross.
  const M crosses = over.exists & (lowest <= zero);
  const M by_edge = (!crosses) & supports(t, direction, edge.edges) & (far > F(kNoise * pair.radius)) &
                    ((!over.exists) | (far + tolerance < lowest));
  const M by_face = over.exists & !by_edge;
  WideTouch touch;
  touch.normal = select(by_edge, -direction, -t.normal);
  const I triangle = load(batch.triangle);
  const F s[2] = {select(by_edge, edge.s, over.begin), over.end};
  const F distance[2] = {select(by_edge, far, at[0]), at[1]};
  M is_there[2];
  for (int k = 0; k < 2; ++k) {
    touch.separation[k] = distance[k] - radius;
    touch.point[k] = s[k] * half + touch.normal * (radius + F(0.5f) * touch.separation[k]);
    is_there[k] = (k == 0 ? by_edge | by_face : by_face) & (touch.separation[k] <= reach);
    touch.id[k] = select(is_there[k], name_of(triangle, s[k], k), I(0));
  }
  const F apart = (over.end - over.begin) * F(pair.extent[1]);
  const M same = by_face & (apart < F(kMinimumSpread) * radius);  // then the lower one stays
  const M first_lower = touch.separation[0] <= touch.separation[1];
  touch.id[0] = select(same & !first_lower, I(0), touch.id[0]);
  touch.id[1] = select(same & first_lower, I(0), touch.id[1]);
  touch.touches = is_there[0] | is_there[1];
  return put_touches(batch, touch, out);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
