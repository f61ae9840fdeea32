// Boxes and hulls against triangles of a mesh: lane = triangle, and the hull's faces and edges one after the
// other for all lanes.
//
// Separating axes of the two (Gottschalk, Lin and Manocha, "OBBTree", 1996; for edges see
// collide_hull_edges.cpp), but along those alone that the mesh supports (collide_mesh.h) may a triangle push.
// The axis along which the shape overlaps least is supported or not. If not, and it is much less than along
// the best supported one, the triangle lies beside the shape, and others hold that. Where none does, because
// a fast shape has come in deep, the one with the least depth along a supported axis holds it. Points are
// those of two faces clipped against each other, as of two hulls.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Squared sine of the angle below which two edges span no axis, as of hulls.
constexpr float kParallelEdges = 1e-8f;
// Of the cosine that bounds a hull edge's arc.
constexpr float kArcSlack = 1e-4f;
// Cosine: axes this close to the triangle's normal measure the same overlap as that, at other points. They
// only tell that there is none, by more than rounding and jitter.
constexpr float kSameAxis = 0.98f;
constexpr float kSureGap = 0.04f * kLinearSlop;  // m

// See TriangleDecision.
struct WideDecision {
  F separation;
  I decider;
  I feature;
  I support;
  V3 axis;
  F largest;
};

// Along the triangle's normal.
WideDecision start(const HullData& hull, const WideTriangles& t) {
  F lowest(1e30f);
  I support(0);
  for (int v = 0; v < hull.vertex_count; ++v) {
    const F height = dot(t.normal, wide(vertex(hull, v)));
    const M lower = height < lowest;
    lowest = select(lower, height, lowest);
    support = select(lower, I(v), support);
  }
  const F separation = lowest - dot(t.normal, t.corner[0]);
  return {separation, I(kTriangleDecides), I(0), support, t.normal, separation};
}

// Of the three corners above a face of the hull.
struct Heights {
  F of[3];
};
Heights heights_over(const HullData& hull, int face, const WideTriangles& t) {
  const V3 n = wide(normal(hull, face));
  const F offset(hull.offset[face]);
  return {{dot(n, t.corner[0]) - offset, dot(n, t.corner[1]) - offset, dot(n, t.corner[2]) - offset}};
}

// The heights above all faces; kept for the first ones, computed anew for the others, which few hulls have.
class HeightTable {
 public:
  HeightTable(const HullData& hull, const WideTriangles& t) : hull_(hull), triangles_(t) {}

  void keep(int face, const Heights& heights) {
    if (face >= kKept) return;
    for (int k = 0; k < 3; ++k) store(kept_[face][k], heights.of[k]);
  }
  Heights get(int face) const {
    if (face >= kKept) return heights_over(hull_, face, triangles_);
    return {{load(kept_[face][0]), load(kept_[face][1]), load(kept_[face][2])}};
  }

 private:
  static constexpr int kKept = 64;
  const HullData& hull_;
  const WideTriangles& triangles_;
  alignas(64) float kept_[kKept][3][kLanes];
};

void try_faces(const HullData& hull, const WideTriangles& t, F tolerance, HeightTable& table,
               WideDecision& decision) {
  F best = decision.separation + tolerance;
  for (int f = 0; f < hull.face_count; ++f) {
    const V3 n = wide(normal(hull, f));
    const Heights heights = heights_over(hull, f, t);
    table.keep(f, heights);
    const F gap = min(heights.of[0], min(heights.of[1], heights.of[2]));
    const M is_same = (dot(n, t.normal) < F(-kSameAxis)) & (gap <= F(kSureGap));
    decision.largest = select(is_same, decision.largest, max(gap, decision.largest));
    const M better = gap > best;
    if (!any(better)) continue;
    const M takes = better & supports(t, -n, edges_farthest(t, -n, tolerance));
    best = select(takes, gap, best);
    decision.separation = select(takes, gap, decision.separation);
    decision.decider = select(takes, I(kFaceDecides), decision.decider);
    decision.feature = select(takes, I(f), decision.feature);
    decision.axis = select(takes, -n, decision.axis);
  }
}

// One edge of the hull and edge k of the triangles, whose arcs must hold the axis. Edge k's leads from the
// triangle's normal over `outward` to the other side; the mesh supports the part of it up to the neighbor's
// normal, which only ridges have.
[[gnu::noinline]] void try_edge(const HullData& hull, int e, const WideTriangles& t, int k, F tolerance,
                                M tries, WideDecision& decision) {
  const HullEdge& edge = hull.edge[e];
  const V3 along = wide(vec(edge.along));
  const F length_1 = length_squared(along), length_2 = length_squared(t.along[k]);
  const V3 product = cross(along, t.along[k]);
  const M slanted = length_squared(product) > F(kParallelEdges) * length_1 * length_2;
  const V3 upright = product - along * (dot(product, along) / length_1);
  const F length = sqrt(max(length_squared(upright), F(1e-37f)));
  const V3 axis = upright * (sign_of(dot(upright, t.outward[k])) / length);
  const V3 middle = wide(vec(edge.normal_0) + vec(edge.normal_1));  // not of unit length
  const F cosine_of_half = dot(middle, wide(vec(edge.normal_0)));   // times the same length
  const F slack(kTurnSlack);
  const M in_arcs = tries & slanted & (-dot(axis, middle) >= cosine_of_half - F(kArcSlack));
  const F gap = select(in_arcs, dot(axis, wide(vec(edge.point)) - t.corner[k]), F(-1e30f));
  const M is_same = (dot(axis, t.normal) > F(kSameAxis)) & (gap <= F(kSureGap));
  decision.largest = select(is_same, decision.largest, max(gap, decision.largest));
  const M is_ridge = (t.ridge[k] > F(kLeastRidge)) & (dot(axis, t.behind[k]) <= slack);
  const M takes = is_ridge & (gap > decision.separation + tolerance);
  decision.separation = select(takes, gap, decision.separation);
  decision.decider = select(takes, I(kEdgesDecide), decision.decider);
  decision.feature = select(takes, I(e << 2 | k), decision.feature);
  decision.axis = select(takes, axis, decision.axis);
}

// Edges that may give a larger gap than the faces, by the heights of the triangles' corners above the faces
// at a hull's edge. Where the heights of an edge's ends differ by a_0 and a_1, of unlike signs, the arcs
// cross along v = |a_1| n_0 + |a_0| n_1, if the third corner is not closer along that; the gap is that of the
// heights. Where the signs are alike the best axis is that of a face. About one in fifty pairs of edges
// passes.
void try_edges(const HullData& hull, const WideTriangles& t, F tolerance, F reach, const HeightTable& table,
               WideDecision& decision) {
  for (int e = 0; e < hull.edge_count; ++e) {
    const HullEdge& edge = hull.edge[e];
    const Heights h_0 = table.get(edge.face[0]), h_1 = table.get(edge.face[1]);
    const F twice_cosine(2.0f * dot(vec(edge.normal_0), vec(edge.normal_1)));
    for (int k = 0; k < 3; ++k) {
      const int end = (k + 1) % 3, third = (k + 2) % 3;
      const F a_0 = h_0.of[end] - h_0.of[k], a_1 = h_1.of[end] - h_1.of[k];
      const M crosses = (a_0 * a_1 < F(0.0f)) & (decision.largest <= reach);
      if (!any(crosses)) continue;
      const F w_0 = abs(a_1), w_1 = abs(a_0);
      const F height = w_0 * h_0.of[k] + w_1 * h_1.of[k];
      const M is_side = height <= w_0 * h_0.of[third] + w_1 * h_1.of[third];
      const F length = sqrt(w_0 * (w_0 + twice_cosine * w_1) + w_1 * w_1);
      const F for_ridge = select(t.ridge[k] > F(kLeastRidge), decision.separation + tolerance, F(1e30f));
      const M passes = crosses & is_side & (height > min(for_ridge, decision.largest) * length);
      if (any(passes)) try_edge(hull, e, t, k, tolerance, passes, decision);
    }
  }
}

// Decisions as plain numbers.
struct Lanes {
  alignas(64) float separation[kLanes], largest[kLanes];
  alignas(64) std::int32_t decider[kLanes], feature[kLanes], support[kLanes];
  alignas(64) float axis[3][kLanes], normal[3][kLanes], corner[3][3][kLanes];

  Lanes(const WideDecision& d, const WideTriangles& t) {
    store(separation, d.separation);
    store(largest, d.largest);
    store(decider, d.decider);
    store(feature, d.feature);
    store(support, d.support);
    put(axis, d.axis);
    put(normal, t.normal);
    for (int k = 0; k < 3; ++k) put(corner[k], t.corner[k]);
  }
  TriangleDecision get(int lane, std::int32_t triangle) const {
    return {{get(corner[0], lane), get(corner[1], lane), get(corner[2], lane)},
            get(normal, lane),
            get(axis, lane),
            separation[lane],
            largest[lane],
            decider[lane],
            feature[lane],
            support[lane],
            triangle};
  }

 private:
  static void put(float (&to)[3][kLanes], V3 v) {
    store(to[0], v.x);
    store(to[1], v.y);
    store(to[2], v.z);
  }
  static Vec get(const float (&from)[3][kLanes], int lane) {
    return {from[0][lane], from[1][lane], from[2][lane]};
  }
};

}  // namespace

int touch_polytope(const MeshPair& pair, const TriangleBatch& batch, MeshClips& clips, TriangleContact* out) {
  const HullData& hull = *pair.hulls.hull[0];
  const WideTriangles t = place_triangles(pair, batch);
  const F tolerance(smaller(kFeatureTolerance, kFeatureShare * hull.inner_radius));
  const F reach(pair.hulls.reach);
  WideDecision decision = start(hull, t);
  if (!any(decision.largest <= reach)) return 0;
  HeightTable table(hull, t);
  try_faces(hull, t, tolerance, table, decision);
  if (!any(decision.largest <= reach)) return 0;
  try_edges(hull, t, tolerance, reach, table, decision);
  const M touches = (decision.largest <= reach) & (decision.largest <= decision.separation + F(kBeside));
  const std::uint32_t there = (1u << batch.count) - 1u;
  std::uint32_t touching = bits(touches) & there;
  const std::uint32_t overlapping = bits(decision.largest <= F(0.0f)) & there;
  if ((touching | overlapping) == 0) return 0;
  const Lanes lanes(decision, t);
  if ((touching & overlapping) != 0) clips.note_held();
  for (std::uint32_t beside = overlapping & ~touching; beside != 0; beside &= beside - 1) {
    const int lane = __builtin_ctz(beside);
    clips.note_beside(lanes.get(lane, batch.triangle[lane]));
  }
  int count = 0;
  for (; touching != 0; touching &= touching - 1) {
    const int lane = __builtin_ctz(touching);
    clips.touch(lanes.get(lane, batch.triangle[lane]), out[count++]);
  }
  return count;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
