// Shared by the stages of convex shapes against triangle meshes: one pair, and a batch of triangles in lanes.
//
// Included by collide_mesh*.cpp only. Meshes are surfaces: a triangle pushes along directions that the mesh
// as a whole supports. With b_k the unit vector in the plane of the neighbor behind edge k that leads away
// from the edge, an edge that is farthest along d, the direction from the mesh to the shape, supports d if d
// . b_k <= 0: else the neighbor reaches farther along d, and pushes itself. A corner must pass this for its
// two edges. So nothing catches on seams.
#pragma once

#include <core/plain/mesh.h>
#include <simd/collide/collide_hull.h>
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// A direction still counts as supported where d . b_k is this much above zero, so that rounding loses no
// contact at seams.
inline constexpr float kTurnSlack = 1e-3f;
// An edge is a ridge, and may touch by itself, where the sine of its turn is above this.
inline constexpr float kLeastRidge = 1e-3f;

// One convex shape, the first of the pair, against one mesh.
struct MeshPair {
  HullPair hulls;  // frame[0]: the mesh in the shape's frame; [1]: the shape in the mesh's frame
  const MeshData* mesh;
  float extent[3];  // of the shape, ExtentRow::half
  float radius;
  float outer_radius;  // m, of a ball about the shape's origin around it
  float half[3];       // m, of the box around the shape without its radius, in the shape's frame
  bool is_ball;
  float round_reach;         // m, from that box on, with the rounding of the tests
  float lower[3], upper[3];  // m, around all points within reach of the shape, in the mesh's frame
  Core smooth;               // of a smooth shape, in its own frame; and how it and the mesh move
  PairMotion motion;
};

// Triangles in lanes. Lanes from `count` on repeat the last one.
struct TriangleBatch {
  int count = 0;
  alignas(64) float corner[3][3][kLanes];  // [corner][axis], in the mesh's frame
  alignas(64) float cosine[3][kLanes], sine[3][kLanes];
  alignas(64) std::int32_t triangle[kLanes];
};

// The same in the shape's frame.
struct WideTriangles {
  V3 corner[3];
  V3 along[3];    // from corner k to the next
  V3 normal;      // unit, out of the front
  V3 outward[3];  // m_k: unit, in the triangle's plane, out across edge k
  V3 behind[3];   // b_k
  F ridge[3];     // sine of the turn behind edge k
};
WideTriangles place_triangles(const MeshPair& pair, const TriangleBatch& batch);

// Edges whose neighbors decide whether a direction is supported: none for the face, the edge itself, the two
// edges of a corner.
struct WideEdgeSet {
  M has[3];
};
inline WideEdgeSet select(M m, const WideEdgeSet& yes, const WideEdgeSet& no) {
  const auto pick = [&](int k) { return (m & yes.has[k]) | ((!m) & no.has[k]); };
  return {{pick(0), pick(1), pick(2)}};
}
// Of the point at `share` of edge k.
inline WideEdgeSet edges_at(int k, F share) {
  WideEdgeSet set{{never(), never(), never()}};
  set.has[k] = !never();
  set.has[(k + 1) % 3] = share >= F(1.0f);
  set.has[(k + 2) % 3] = share <= F(0.0f);
  return set;
}
// Of what is farthest along d, up to a tolerance in meters.
inline WideEdgeSet edges_farthest(const WideTriangles& t, V3 d, F tolerance) {
  const F height[3] = {dot(d, t.corner[0]), dot(d, t.corner[1]), dot(d, t.corner[2])};
  const F least = max(height[0], max(height[1], height[2])) - tolerance;
  const M top[3] = {height[0] >= least, height[1] >= least, height[2] >= least};
  const M several = (top[0] & top[1]) | (top[1] & top[2]) | (top[2] & top[0]);
  const M all = top[0] & top[1] & top[2];
  const auto counts = [&](int k) {
    const M one = top[k] | top[(k + 1) % 3], both = top[k] & top[(k + 1) % 3];
    return ((several & both) | ((!several) & one)) & !all;
  };
  return {{counts(0), counts(1), counts(2)}};
}

// Any mixture that seldom gives two points of a manifold the same name.
inline std::uint32_t mixed_name(std::int32_t triangle, std::uint32_t id) {
  const std::uint32_t mixed = (static_cast<std::uint32_t>(triangle) * 0x9e3779b9u) ^ (id * 0x85ebca6bu);
  return (mixed & (kFirstMixedName - 1)) | kFirstMixedName;
}
// How much deeper than along its least axis a triangle may push, in meters: more than the overlap that
// contacts leave.
inline constexpr float kBeside = 2.0f * kLinearSlop;

// True where the triangle supports the unit direction d by what has these edges.
inline M supports(const WideTriangles& t, V3 d, const WideEdgeSet& edges) {
  const F slack(kTurnSlack);
  M supported = dot(d, t.normal) >= -slack;
  for (int k = 0; k < 3; ++k) supported = supported & ((!edges.has[k]) | (dot(d, t.behind[k]) <= slack));
  return supported;
}

// What decides a box or hull against a triangle: along whose direction they overlap least.
enum Decider : std::int32_t { kTriangleDecides, kFaceDecides, kEdgesDecide };
// One triangle that a box or hull touches, in the shape's frame.
struct TriangleDecision {
  Vec corner[3];
  Vec normal;
  Vec axis;  // from the mesh to the shape
  float separation;
  float largest;  // gap along any axis, whether the mesh supports it or not
  std::int32_t decider;
  std::int32_t feature;  // the hull's face, or its edge << 2 | the triangle's edge
  std::int32_t support;  // the hull's vertex that is deepest behind the triangle
  std::int32_t triangle;
};

// A triangle as a hull of two faces, the front first, in the shape's frame. As far as clipping reads it:
// there is no padding of the columns.
struct TriangleHull {
  HullData hull;
  float vertex[3][3], normal[3][2], offset[2];
  HullEdge edge[3];

  TriangleHull();
  void set(const Vec (&corner)[3], Vec front);
};

// Clips the faces of boxes and hulls against triangles, whose points are the contacts'. Faces of few corners
// wait until they fill the lanes, whatever pairs they are of.
class MeshClips {
 public:
  MeshClips();
  void set_pair(const MeshPair& pair);  // in whose frame decisions are, from now on
  void touch(const TriangleDecision& decision, TriangleContact& to);
  // A triangle that overlaps the pair's shape holds it.
  void note_held() { is_held_ = true; }
  // A triangle that overlaps the shape lies beside it.
  void note_beside(const TriangleDecision& decision);
  // Where nothing holds the shape, of the triangles beside it the one touches that has to push it least.
  // Returns the number of contacts.
  int touch_beside(TriangleContact* out);
  void flush();

 private:
  // What the points of a pair of faces need to become those of a contact.
  struct Waiting {
    TriangleContact* to;
    Vec axis;
    float largest, reach;
    float at_corner;  // m, how close to a corner of the hull points have its name
    int hull_side;    // of the queue's faces
    int corners;
    std::uint8_t corner[kSmallFace];
  };

  void touch_edges(const TriangleDecision& decision, Decision& own, TriangleContact& to);
  void clip(const TriangleDecision& decision, const Decision& own, const FacePair& faces,
            TriangleContact& to);

  HullPair pair_;
  float at_corner_;
  TriangleHull triangle_;
  FaceQueue queue_;
  Waiting waiting_[kLanes];
  TriangleDecision beside_;
  bool is_held_ = false, has_beside_ = false;
};

// Of a smooth shape: whether a triangle that overlaps it holds it, and if not, the one beside it that has to
// push it least.
struct MeshBeside {
  bool is_held = false;
  std::int32_t triangle = -1;
  double separation = 0.0;  // m
  TriangleContact contact;
};

// Contacts of the shape with the batch's triangles, appended to `out` in the order of the lanes. Returns how
// many there are; a triangle has one at most. Those of polytopes are written when `clips` is flushed at the
// latest; where no point is left the contact's triangle is -1.
int touch_sphere(const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out);
int touch_capsule(const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out);
int touch_smooth(const MeshPair& pair, const TriangleBatch& batch, MeshBeside& beside, TriangleContact* out);
int touch_polytope(const MeshPair& pair, const TriangleBatch& batch, MeshClips& clips, TriangleContact* out);

// Writes lane after lane of what touches.
struct WideTouch {
  M touches;
  V3 normal;  // from the shape to the mesh
  V3 point[2];
  F separation[2];
  I id[2];  // 0: absent
};
int put_touches(const TriangleBatch& batch, const WideTouch& touch, TriangleContact* out);

// Writes the manifolds of smooth shapes. `own`: rows of the manifolds' shapes, as `own_items` number them.
void store_smooth_mesh_manifolds(const CollideColumns& columns, const CollideItem* items,
                                 const MeshManifold* found, int count, const CollideColumns& own,
                                 const CollideItem* own_items);
// Of a smooth shape against a mesh: MeshPair::smooth and its motion. False: a pose is not finite.
bool set_smooth(const CollideColumns& columns, const CollideItem& item, MeshPair& pair);

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
