// Boxes and hulls against triangles of a mesh: lane = triangle, and the hull's faces and edges one after the
// other for all lanes.
//
// Separating axes of the two (Gottschalk, Lin and Manocha, "OBBTree", 1996; for edges see
// collide_hull_edges.cpp), but along those alone that the mesh supports (collide_mesh.h) may a triangle push.
// The axis along which the shape overlaps least is supported or not. If not, and it is much less than along
// the best supported one, the triangle lies beside the shape, and others hold that. Points are those of two
// faces clipped against each other, as of two hulls.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Squared sine of the angle below which two edges span no axis, as of hulls.
constexpr float kParallelEdges = 1e-8f;
// Of the cosine that bounds a hull edge's arc.
constexpr float kArcSlack = 1e-4f;
// How much deeper than along its least axis a triangle may push, in meters: more than the overlap that
// contacts leave.
constexpr float kBeside = 2.0f * kLinearSlop;

// Cosine: axes this close to the triangle's normal measure the same overlap as that, at other points. They
// only tell that there is none, by more than rounding and jitter.
constexpr float kSameAxis = 0.98f;
constexpr float kSureGap = 0.04f * kLinearSlop;  // m

// A triangle as a hull of two faces, the front first, in the shape's frame.
struct TriangleHull {
  HullData hull;
  alignas(64) float vertex[3][kHullPadding];
  alignas(64) float normal[3][kHullPadding];
  alignas(64) float offset[kHullPadding];
  HullEdge edge[3];

  TriangleHull();
  void set(const Vec (&corner)[3], Vec front);
};

constexpr std::uint8_t kLoop[6] = {0, 1, 2, 0, 2, 1};
constexpr std::uint16_t kLoopBegin[3] = {0, 3, 6};

TriangleHull::TriangleHull() : hull{}, vertex{}, normal{}, offset{}, edge{} {
  hull.vertex_count = 3;
  hull.edge_count = 3;
  hull.face_count = 2;
  hull.padded_vertices = hull.padded_faces = kHullPadding;
  for (int axis = 0; axis < 3; ++axis) {
    hull.vertex[axis] = vertex[axis];
    hull.normal[axis] = normal[axis];
  }
  hull.offset = offset;
  hull.edge = edge;
  hull.loop = kLoop;
  hull.loop_begin = kLoopBegin;
  for (int k = 2; k < kHullPadding; ++k) offset[k] = 1e30f;
  for (int k = 0; k < 3; ++k) {
    edge[k].vertex[0] = k;
    edge[k].vertex[1] = (k + 1) % 3;
    edge[k].face[1] = 1;
  }
}

void TriangleHull::set(const Vec (&corner)[3], Vec front) {
  const float distance = dot(front, corner[0]);
  const auto write = [](float(&to)[3][kHullPadding], int at, Vec v) {
    to[0][at] = v.x;
    to[1][at] = v.y;
    to[2][at] = v.z;
  };
  float outer = 0.0f;
  for (int k = 0; k < kHullPadding; ++k) write(vertex, k, corner[k < 3 ? k : 0]);
  for (const Vec c : corner) outer = larger(outer, dot(c, c));
  hull.outer_radius = square_root(outer);
  write(normal, 0, front);
  write(normal, 1, -front);
  offset[0] = distance;
  offset[1] = -distance;
  for (int k = 0; k < 3; ++k) {
    const Vec from = corner[k], along = corner[(k + 1) % 3] - from;
    const float numbers[3][3] = {
        {from.x, from.y, from.z}, {along.x, along.y, along.z}, {front.x, front.y, front.z}};
    for (int axis = 0; axis < 3; ++axis) {
      edge[k].point[axis] = numbers[0][axis];
      edge[k].along[axis] = numbers[1][axis];
      edge[k].normal_0[axis] = numbers[2][axis];
      edge[k].normal_1[axis] = -numbers[2][axis];
    }
  }
}

// What decides each lane, and the largest gap along any axis.
enum Decider : std::int32_t { kTriangleDecides, kFaceDecides, kEdgesDecide };
struct WideDecision {
  F separation;
  I decider;
  I feature;  // the hull's face, or its edge << 2 | the triangle's edge
  I support;  // the hull's vertex that is deepest behind the triangle
  V3 axis;    // from the mesh to the shape
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

void try_faces(const HullData& hull, const WideTriangles& t, F tolerance, WideDecision& decision) {
  F best = decision.separation + tolerance;
  for (int f = 0; f < hull.face_count; ++f) {
    const V3 n = wide(normal(hull, f));
    const F distance = min(dot(n, t.corner[0]), min(dot(n, t.corner[1]), dot(n, t.corner[2])));
    const F gap = distance - F(hull.offset[f]);
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
void try_edge(const HullData& hull, int e, const WideTriangles& t, int k, F tolerance,
              WideDecision& decision) {
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
  const M in_arcs = slanted & (-dot(axis, middle) >= cosine_of_half - F(kArcSlack));
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

// Decisions as plain numbers, lane by lane.
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
  static void put(float (&to)[3][kLanes], V3 v) {
    store(to[0], v.x);
    store(to[1], v.y);
    store(to[2], v.z);
  }
  static Vec get(const float (&from)[3][kLanes], int lane) {
    return {from[0][lane], from[1][lane], from[2][lane]};
  }
};

// Clips the faces of the lanes that touch, those of few corners all at once.
class Clipping {
 public:
  Clipping(const MeshPair& pair, const Lanes& lanes) : base_(pair.hulls), lanes_(lanes) {
    base_.frame[0] = base_.frame[1] = {{{{1, 0, 0}, 0}, {{0, 1, 0}, 0}, {{0, 0, 1}, 0}}};
    base_.hull[1] = &triangle_.hull;
    set_tolerances(base_);
    const float inner = base_.hull[0]->inner_radius;
    base_.border = smaller(kFeatureTolerance, kFeatureShare * inner);
  }

  void touch(int lane) {
    Vec corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = Lanes::get(lanes_.corner[k], lane);
    triangle_.set(corner, Lanes::get(lanes_.normal, lane));
    Decision decision{};
    decision.separation = lanes_.separation[lane];
    decision.axis = -Lanes::get(lanes_.axis, lane);
    switch (lanes_.decider[lane]) {
      case kTriangleDecides:
        decision.side = 1;
        decision.face = 0;
        decision.support = lanes_.support[lane];
        decision.feature = kFeatureFace2;
        clip(lane, decision, pair_faces(base_, decision));
        break;
      case kFaceDecides:
        decision.side = 0;
        decision.face = lanes_.feature[lane];
        decision.feature = kFeatureFace1;
        clip(lane, decision,
             {0, decision.face, 0, decision.axis, base_.hull[0]->offset[decision.face], false, {}});
        break;
      default:
        touch_edges(lane, decision);
        break;
    }
  }
  void flush() {
    const int count = queue_.count;
    if (count == 0) return;
    HullContact clipped[kLanes];
    clip_queue(queue_, clipped);
    for (int k = 0; k < count; ++k) contact[waiting_[k]] = clipped[k];
  }

  HullContact contact[kLanes]{};

 private:
  void touch_edges(int lane, Decision& decision) {
    decision.edge[0] = lanes_.feature[lane] >> 2;
    decision.edge[1] = lanes_.feature[lane] & 3;
    decision.feature = kFeatureEdges | static_cast<std::uint32_t>(decision.edge[0]) << kFeatureShift |
                       static_cast<std::uint32_t>(decision.edge[1]);
    const EdgeCrossing crossing = cross_deciding_edges(base_, decision);
    FacePair faces;
    if (pass_beside(base_, decision, crossing)) return;
    if (pair_edge_faces(base_, decision, crossing, faces) && faces.incident == 0) {
      clip(lane, decision, faces);
    } else {
      touch_crossing(decision, crossing, contact[lane]);
    }
  }
  void clip(int lane, const Decision& decision, const FacePair& faces) {
    const int convex_face = faces.side == 0 ? faces.face : faces.incident;
    if (corner_count(*base_.hull[0], convex_face) > kSmallFace) {
      clip_faces(base_, decision, faces, contact[lane]);
      return;
    }
    waiting_[queue_.count] = lane;
    queue_.put(base_, decision, faces);
  }

  HullPair base_;
  const Lanes& lanes_;
  TriangleHull triangle_;
  FaceQueue queue_;
  int waiting_[kLanes];
};

// A point at a corner of the hull keeps its name while the shape slides from triangle to triangle.
std::uint32_t name_of(const HullData& hull, Vec point, float separation, Vec axis, std::int32_t triangle,
                      std::uint32_t id) {
  constexpr float kAtCorner = 1e-4f;  // of the hull's radius
  const Vec on_hull = point + (0.5f * separation) * axis;
  const float limit = kAtCorner * hull.outer_radius;
  const int nearest = farthest_vertex(hull, on_hull);
  const Vec apart = vertex(hull, nearest) - on_hull;
  if (dot(apart, apart) <= limit * limit) return 1u + static_cast<std::uint32_t>(nearest);
  // Any mixture that seldom gives two points of a manifold the same name.
  const std::uint32_t mixed = (static_cast<std::uint32_t>(triangle) * 0x9e3779b9u) ^ (id * 0x85ebca6bu);
  return (mixed & (kFirstMixedName - 1)) | kFirstMixedName;
}

// Copies the points of a lane. No point may be deeper than the overlap along the least axis.
bool take(const MeshPair& pair, const Lanes& lanes, int lane, const HullContact& from, std::int32_t triangle,
          TriangleContact& to) {
  const Vec axis = Lanes::get(lanes.axis, lane);
  int count = 0;
  to = {};
  to.triangle = triangle;
  to.normal[0] = -axis.x;
  to.normal[1] = -axis.y;
  to.normal[2] = -axis.z;
  for (float& separation : to.separation) separation = kAbsentSeparation;
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    const bool is_edges = (from.id[k] & kFeatureKind) == kFeatureEdges;
    if (from.id[k] == 0 || (!is_edges && (from.id[k] & kLostNumber) == kLostNumber)) continue;
    const float separation = larger(from.separation[k], lanes.largest[lane]);
    if (!(separation <= pair.hulls.reach)) continue;
    const Vec point = from.point[k];
    to.point[count][0] = point.x;
    to.point[count][1] = point.y;
    to.point[count][2] = point.z;
    to.separation[count] = separation;
    to.id[count] = name_of(*pair.hulls.hull[0], point, from.separation[k], axis, triangle, from.id[k]);
    ++count;
  }
  return count > 0;
}

}  // namespace

int touch_polytope(const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out) {
  const HullData& hull = *pair.hulls.hull[0];
  const WideTriangles t = place_triangles(pair, batch);
  const F tolerance(smaller(kFeatureTolerance, kFeatureShare * hull.inner_radius));
  const F reach(pair.hulls.reach);
  WideDecision decision = start(hull, t);
  if (!any(decision.largest <= reach)) return 0;
  try_faces(hull, t, tolerance, decision);
  if (!any(decision.largest <= reach)) return 0;
  for (int k = 0; k < 3; ++k) {
    for (int e = 0; e < hull.edge_count; ++e) try_edge(hull, e, t, k, tolerance, decision);
  }
  const M touches = (decision.largest <= reach) & (decision.largest <= decision.separation + F(kBeside));
  const std::uint32_t touching = bits(touches);
  if (touching == 0) return 0;
  const Lanes lanes(decision, t);
  Clipping clipping(pair, lanes);
  for (int lane = 0; lane < batch.count; ++lane) {
    if ((touching >> lane & 1u) != 0) clipping.touch(lane);
  }
  clipping.flush();
  int count = 0;
  for (int lane = 0; lane < batch.count; ++lane) {
    if ((touching >> lane & 1u) == 0) continue;
    if (take(pair, lanes, lane, clipping.contact[lane], batch.triangle[lane], out[count])) ++count;
  }
  return count;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
