// Hulls: finds the pair of edges along whose common perpendicular two hulls overlap least, if that overlap is
// less than the one along the best face.
//
// Only edges whose arcs cross on the sphere of directions span a face of the Minkowski difference (Gregorius,
// "The Separating Axis Test between Convex Polyhedra", 2013). Before testing pairs of edges, drops edges of
// each hull by an upper bound on the distance of a point of the other hull beyond their arc (HullData).
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kPaddedEdges = (kMaxHullEdges + kHullPadding - 1) / kHullPadding * kHullPadding;
// Two edges span no axis if the squared sine of their angle is below this: the rounding of their directions
// would decide it. The axis could win by 1e-4 of the shorter edge at most.
constexpr float kParallelEdges = 1e-8f;
constexpr int kCodeShift = 10;  // a pair of edges as one number that a float holds

struct EdgeList {
  int count = 0;
  alignas(64) std::int32_t edge[kPaddedEdges + kHullPadding];
};

// Lists the edges beyond which the point may lie farther than `to_beat`, in ascending order.
void sift(const HullData& hull, Vec point, float to_beat, EdgeList& list) {
  const V3 x = wide(point);
  for (int k = 0; k < hull.padded_edges; k += kLanes) {
    const V3 middle{load(hull.arc_middle[0] + k), load(hull.arc_middle[1] + k), load(hull.arc_middle[2] + k)};
    const V3 tilt{load(hull.arc_tilt[0] + k), load(hull.arc_tilt[1] + k), load(hull.arc_tilt[2] + k)};
    const F along_middle = dot(middle, x) - load(hull.arc_middle_point + k);
    const F along_tilt = dot(tilt, x) - load(hull.arc_tilt_point + k);
    const F bound = max(along_middle, load(hull.arc_cosine + k) * along_middle) + abs(along_tilt);
    const M kept = bound > F(to_beat);
    // Wide sets pack always: that costs less than a mispredicted branch.
    if constexpr (kLanes <= 4) {
      if (!any(kept)) continue;
    }
    list.count += compress_store(list.edge + list.count, kept, lane_numbers() + I(k));
  }
}

// Edges of the second hull in the first one's frame, in lanes.
struct WideEdges {
  V3 point, along, normal_0, normal_1;
  F number;
};
V3 turn(const HullFrame& frame, V3 v) {
  return {dot(wide(frame.row[0].axis), v), dot(wide(frame.row[1].axis), v), dot(wide(frame.row[2].axis), v)};
}
WideEdges place(const HullData& hull, const HullFrame& frame, const std::int32_t* which, F present) {
  const float* rows = reinterpret_cast<const float*>(hull.edge);
  constexpr int kStride = sizeof(HullEdge) / sizeof(float);
  V3 point, along, normal_0, normal_1;
  load_rows(rows, kStride, which, point.x, point.y, point.z, along.x);
  load_rows(rows + 4, kStride, which, along.y, along.z, normal_0.x, normal_0.y);
  load_rows(rows + 8, kStride, which, normal_0.z, normal_1.x, normal_1.y, normal_1.z);
  return {turn(frame, point) + wide(frame.center()), turn(frame, along) * present, turn(frame, normal_0),
          turn(frame, normal_1), to_float(load_unaligned(which))};
}

// Tests one edge of the first hull against edges of the second.
void cross_edges(const HullEdge& edge, int number, const WideEdges& second, Largest& largest) {
  const V3 along_1 = wide(vec(edge.along)), point_1 = wide(vec(edge.point));
  const V3 normal_a = wide(vec(edge.normal_0)), normal_b = wide(vec(edge.normal_1));
  const F zero(0.0f);
  const F c = dot(second.normal_0, along_1), d = dot(second.normal_1, along_1);
  const F a = dot(normal_a, second.along), b = dot(normal_b, second.along);
  const M crossing = (c * d < zero) & (a * b < zero) & (c * b < zero);
  if (!any(crossing)) return;
  const V3 product = cross(along_1, second.along);
  const F length_1 = length_squared(along_1), length_2 = length_squared(second.along);
  const M slanted = length_squared(product) > F(kParallelEdges) * length_1 * length_2;
  // The rounding of the cross product of nearly parallel edges must not tilt the axis along the edge.
  const V3 upright = product - along_1 * (dot(product, along_1) / length_1);
  const F length = sqrt(max(length_squared(upright), F(1e-30f)));
  const F distance = dot(upright, second.point - point_1);
  const F separation = select(dot(upright, normal_a + normal_b) < zero, -distance, distance) / length;
  const F code = second.number * F(static_cast<float>(1 << kCodeShift)) + F(static_cast<float>(number));
  largest.offer(select(crossing & slanted, separation, F(-1e30f)), code);
}

// An edge of the second hull in the first one's frame.
struct PlacedEdge {
  Vec point, along;
};
PlacedEdge second_edge(const HullPair& pair, int index) {
  const HullEdge& edge = pair.hull[1]->edge[index];
  return {pair.frame[0].place(vec(edge.point)), pair.frame[0].turn(vec(edge.along))};
}

Vec axis_of(const HullPair& pair, int edge_1, int edge_2) {
  const HullEdge& first = pair.hull[0]->edge[edge_1];
  const Vec along_1 = vec(first.along);
  const Vec product = cross(along_1, second_edge(pair, edge_2).along);
  const Vec upright = product - (dot(product, along_1) / dot(along_1, along_1)) * along_1;
  const float length = square_root(larger(dot(upright, upright), 1e-30f));
  const Vec outward = vec(first.normal_0) + vec(first.normal_1);
  return ((dot(upright, outward) < 0.0f ? -1.0f : 1.0f) / length) * upright;
}

float clamp_share(float a) { return smaller(larger(a, 0.0f), 1.0f); }

// Uses triple products: the usual differences of products cancel where edges are nearly parallel, which puts
// the point anywhere along them.
EdgeCrossing closest_points(const HullPair& pair, const int edge[2]) {
  const HullEdge& first = pair.hull[0]->edge[edge[0]];
  const PlacedEdge second = second_edge(pair, edge[1]);
  const Vec point_1 = vec(first.point), along_1 = vec(first.along);
  const Vec way = second.point - point_1;
  const Vec upright = cross(along_1, second.along);
  const float inverse = 1.0f / larger(dot(upright, upright), 1e-30f);
  const float s = clamp_share(dot(cross(way, second.along), upright) * inverse);
  const float t = clamp_share(dot(cross(way, along_1), upright) * inverse);
  return {point_1 + s * along_1, second.point + t * second.along};
}

void decide(Decision& decision, const int edge[2], Vec axis, float separation) {
  decision.separation = separation;
  decision.axis = axis;
  decision.support = 0;
  decision.edge[0] = edge[0];
  decision.edge[1] = edge[1];
  decision.feature = kFeatureEdges | static_cast<std::uint32_t>(edge[0] << kFeatureShift | edge[1]);
}

// The best two edges that cross and beat the given gap. points[k] is a point of the other hull, in hull k's
// frame. False: no such edges exist.
bool find_edges(const HullPair& pair, const Vec points[2], int side, float to_beat, int edge[2]) {
  EdgeList lists[2];
  for (int turn = 0; turn < 2; ++turn) {
    const int k = turn == 0 ? side : 1 - side;
    sift(*pair.hull[k], points[k], to_beat - pair.rounding, lists[k]);
    if (lists[k].count == 0) return false;
  }
  // The lanes after the last edge hold an edge of length zero, which crosses nothing.
  for (int lane = 0; lane < kLanes; ++lane) lists[1].edge[lists[1].count + lane] = lists[1].edge[0];
  Largest largest(to_beat);
  F index = first_indices();
  for (int k = 0; k < lists[1].count; k += kLanes) {
    const F present = select(index < F(static_cast<float>(lists[1].count)), F(1.0f), F(0.0f));
    const WideEdges second = place(*pair.hull[1], pair.frame[0], lists[1].edge + k, present);
    for (int i = 0; i < lists[0].count; ++i) {
      const int number = lists[0].edge[i];
      cross_edges(pair.hull[0]->edge[number], number, second, largest);
    }
    index = index + F(static_cast<float>(kLanes));
  }
  const int code = largest.index();
  if (code < 0) return false;
  edge[0] = code & ((1 << kCodeShift) - 1);
  edge[1] = code >> kCodeShift;
  return true;
}

}  // namespace

Vec point_within_face(const HullData& hull, int face, Vec point) {
  const int count = corner_count(hull, face);
  const std::uint8_t* loop = hull.loop + hull.loop_begin[face];
  const Vec n = normal(hull, face);
  Vec middle{0.0f, 0.0f, 0.0f};
  for (int k = 0; k < count; ++k) middle = middle + vertex(hull, loop[k]);
  middle = (1.0f / static_cast<float>(count)) * middle;
  const Vec onto = point - (dot(n, point) - hull.offset[face]) * n;
  float share = 1.0f;
  Vec corner = vertex(hull, loop[count - 1]);
  for (int k = 0; k < count; ++k) {
    const Vec next = vertex(hull, loop[k]);
    const Vec outward = cross(next - corner, n);
    const float inside = dot(outward, middle - corner), beyond = dot(outward, onto - corner);
    if (beyond > 0.0f && inside < 0.0f) share = smaller(share, inside / (inside - beyond));
    corner = next;
  }
  return middle + share * (onto - middle);
}

bool query_edges(const HullPair& pair, Decision& decision) {
  const int side = decision.side, other = 1 - side;
  const float to_beat = decision.separation + pair.tolerance;
  // A point of each hull, close together: the deepest vertex, and its projection onto the face.
  Vec points[2];
  points[side] = pair.frame[side].place(vertex(*pair.hull[other], decision.support));
  points[other] = pair.frame[other].place(point_within_face(*pair.hull[side], decision.face, points[side]));
  int edge[2];
  if (!find_edges(pair, points, side, to_beat, edge)) return true;
  // Checks the result with all vertices: rounding may have called an arc crossed.
  const Vec axis = axis_of(pair, edge[0], edge[1]);
  const float separation = gap_along(pair, axis);
  if (!(separation > to_beat)) return true;
  decide(decision, edge, axis, separation);
  return separation <= pair.reach;
}

// The gap along the last edges' axis bounds the best gap from below. If no face reaches it, the best edges
// are among the few that do. The result is the same as that of query_faces and query_edges.
Remembered query_remembered_edges(const HullPair& pair, std::uint32_t hint, Decision& decision) {
  const int last[2] = {at_most(hint >> kFeatureShift & kFeatureIndex, pair.hull[0]->edge_count),
                       at_most(hint & kFeatureIndex, pair.hull[1]->edge_count)};
  const Vec axis = axis_of(pair, last[0], last[1]);
  const float separation = gap_along(pair, axis);
  decision.axis = axis;
  if (separation > pair.reach) return Remembered::separates;
  const float margin = pair.tolerance + 2.0f * pair.rounding;
  if (may_beat(pair, last, separation - margin)) return Remembered::fails;
  const EdgeCrossing crossing = closest_points(pair, last);
  const Vec points[2] = {crossing.on_2, pair.frame[1].place(crossing.on_1)};
  int edge[2];
  if (!find_edges(pair, points, 0, separation - pair.rounding, edge)) return Remembered::fails;
  if (edge[0] == last[0] && edge[1] == last[1]) {
    decide(decision, edge, axis, separation);
    return Remembered::decides;
  }
  const Vec better = axis_of(pair, edge[0], edge[1]);
  const float gap = gap_along(pair, better);
  if (!(gap > separation - pair.rounding)) return Remembered::fails;
  decide(decision, edge, better, gap);
  return gap > pair.reach ? Remembered::separates : Remembered::decides;
}

EdgeCrossing cross_deciding_edges(const HullPair& pair, const Decision& decision) {
  return closest_points(pair, decision.edge);
}

bool pass_beside(const HullPair& pair, const Decision& decision, const EdgeCrossing& crossing) {
  const Vec difference = crossing.on_2 - crossing.on_1;
  const Vec beside = difference - dot(difference, decision.axis) * decision.axis;
  const float limit = smaller(kSpeculativeDistance, pair.reach);
  return decision.separation > 0.0f && dot(beside, beside) > limit * limit;
}

bool pair_edge_faces(const HullPair& pair, const Decision& decision, const EdgeCrossing& crossing,
                     FacePair& faces) {
  constexpr float kLeastCosine = 0.1f;  // of a face's normal and the axis; beyond, it is seen from its edge
  const HullEdge& first = pair.hull[0]->edge[decision.edge[0]];
  const HullEdge& second = pair.hull[1]->edge[decision.edge[1]];
  const Vec against = pair.frame[0].turn_back(-decision.axis);
  const float cosine_0 = dot(decision.axis, vec(first.normal_0)),
              cosine_1 = dot(decision.axis, vec(first.normal_1)),
              incident_0 = dot(against, vec(second.normal_0)),
              incident_1 = dot(against, vec(second.normal_1));
  faces.side = 0;
  faces.face = first.face[cosine_1 > cosine_0 ? 1 : 0];
  faces.incident = second.face[incident_1 > incident_0 ? 1 : 0];
  faces.axis = decision.axis;
  faces.offset = dot(decision.axis, crossing.on_1);
  faces.crosses = true;
  faces.crossing = crossing;
  return larger(cosine_0, cosine_1) > kLeastCosine && larger(incident_0, incident_1) > kLeastCosine;
}

void touch_crossing(const Decision& decision, const EdgeCrossing& crossing, HullContact& contact) {
  contact.point[0] = 0.5f * (crossing.on_1 + crossing.on_2);
  contact.separation[0] = decision.separation;
  contact.id[0] = decision.feature;
  for (int k = 1; k < 4; ++k) set_absent(contact, k);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
