// Shared by the stages of the narrow phase of hulls: a pair in the first hull's frame, farthest vertices, and
// reductions over a hull's columns.
//
// Included by collide_hull*.cpp only. Everything here is wide within one pair: lanes are vertices, faces or
// edges. Reductions are exact (the largest value, then the first equal index), so that their results do not
// depend on the number of lanes.
#pragma once

#include <core/plain/hull.h>
#include <simd/collide/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// ContactAxis::feature: what decided a contact. Faces and edges by their index.
inline constexpr std::uint32_t kFeatureFace1 = 1u << 28;  // | face of the first hull
inline constexpr std::uint32_t kFeatureFace2 = 2u << 28;  // | face of the second hull
inline constexpr std::uint32_t kFeatureEdges = 3u << 28;  // | edge of the first << 10 | edge of the second
inline constexpr std::uint32_t kFeatureKind = 3u << 28;
inline constexpr std::uint32_t kFeatureIndex = 0x3ff;
inline constexpr int kFeatureShift = 10;

struct Vec {
  float x, y, z;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(float s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float square_root(float a) { return __builtin_sqrtf(a); }
inline float larger(float a, float b) { return a > b ? a : b; }
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float size(float a) { return a < 0.0f ? -a : a; }
inline V3 wide(Vec a) { return {F(a.x), F(a.y), F(a.z)}; }
inline Vec vec(const float v[3]) { return {v[0], v[1], v[2]}; }

// Another hull's frame as seen from one hull: x = turn y + center. Rows are written 16 bytes at a time.
struct alignas(16) HullFrame {
  struct Row {
    Vec axis;
    float center;
  } row[3];

  Vec center() const { return {row[0].center, row[1].center, row[2].center}; }
  Vec turn(Vec y) const { return {dot(row[0].axis, y), dot(row[1].axis, y), dot(row[2].axis, y)}; }
  Vec turn_back(Vec x) const { return x.x * row[0].axis + x.y * row[1].axis + x.z * row[2].axis; }
  Vec place(Vec y) const { return turn(y) + center(); }
};

// A pair whose spheres touch.
struct alignas(64) HullPair {
  HullFrame frame[2];  // [0]: the second hull in the first one's frame, [1]: the reverse
  float reach;         // gap below which there are points
  float tolerance;     // by which an axis of lower rank must win
  float border;        // how much farther than a face's border still counts as within
  float rounding;      // largest error of bounds
  const HullData* hull[2];
};

// Writes the frames and the reach of each lane's pair into the pair of its slot. In collide_hull.cpp, as
// set_tolerances, which needs the hulls.
void store_frames(const WidePair& wide_pair, HullPair* pairs, const std::int32_t* slot);
void set_tolerances(HullPair& pair);

// A box as a hull: topology that all boxes share, and columns of its half extents.
struct BoxHull {
  HullData hull;
  alignas(64) float vertex[3][kHullPadding];
  alignas(64) float offset[kHullPadding];
  alignas(64) float middle_point[kHullPadding];
  alignas(64) float tilt_point[kHullPadding];
  HullEdge edge[12];

  BoxHull();
  void set_faces(const float half[3]);
  void set_edges();  // of the same box; most boxes are apart and need none
};

inline Vec vertex(const HullData& hull, int index) {
  return {hull.vertex[0][index], hull.vertex[1][index], hull.vertex[2][index]};
}
inline Vec normal(const HullData& hull, int index) {
  return {hull.normal[0][index], hull.normal[1][index], hull.normal[2][index]};
}
inline int corner_count(const HullData& hull, int face) {
  return hull.loop_begin[face + 1] - hull.loop_begin[face];
}

// The largest value and its first index. Indices travel as floats, which hold them exactly.
class Largest {
 public:
  explicit Largest(float above = -1e30f) : value_(above) {}
  void offer(F value, F index) {
    const M better = value > value_;
    value_ = select(better, value, value_);
    index_ = select(better, index, index_);
  }
  // -1 where nothing exceeds the start.
  int index() const {
    const float top = reduce_max(value_);
    std::uint32_t lanes = bits(value_ == F(top));
    alignas(64) float indices[kLanes];
    store(indices, index_);
    float first = indices[__builtin_ctz(lanes)];
    for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1) {
      first = smaller(indices[__builtin_ctz(lanes)], first);
    }
    return static_cast<int>(first);
  }

 private:
  F value_;
  F index_{-1.0f};
};

inline F first_indices() { return to_float(lane_numbers()); }

// Distance along d of the hull's farthest vertex.
inline float farthest_distance(const HullData& hull, Vec d) {
  const V3 direction = wide(d);
  F top(-1e30f);
  for (int k = 0; k < hull.padded_vertices; k += kLanes) {
    const V3 v{load(hull.vertex[0] + k), load(hull.vertex[1] + k), load(hull.vertex[2] + k)};
    top = max(dot(direction, v), top);
  }
  return reduce_max(top);
}
inline int farthest_vertex(const HullData& hull, Vec d) {
  const V3 direction = wide(d);
  Largest largest;
  F index = first_indices();
  for (int k = 0; k < hull.padded_vertices; k += kLanes) {
    const V3 v{load(hull.vertex[0] + k), load(hull.vertex[1] + k), load(hull.vertex[2] + k)};
    largest.offer(dot(direction, v), index);
    index = index + F(static_cast<float>(kLanes));
  }
  return largest.index();
}

// Gap along a unit axis of the first hull's frame that points from the first to the second.
inline float gap_along(const HullPair& pair, Vec axis) {
  const float end_1 = farthest_distance(*pair.hull[0], axis);
  const float end_2 = farthest_distance(*pair.hull[1], -pair.frame[0].turn_back(axis));
  return dot(axis, pair.frame[0].center()) - (end_1 + end_2);
}

// The feature that decides a pair, and its axis.
struct Decision {
  float separation;
  std::uint32_t feature;  // 0: separated
  Vec axis;               // from the first hull to the second, in the first one's frame
  int side;               // faces: whose face it is
  int face;
  int support;  // faces: the other hull's vertex that is deepest behind the face
  int edge[2];  // edges: of each hull

  bool has_edges() const { return (feature & kFeatureKind) == kFeatureEdges; }
};

inline int at_most(std::uint32_t index, int count) {
  return index < static_cast<std::uint32_t>(count) ? static_cast<int>(index) : count - 1;
}

// Contact in the first hull's frame, points in the middle between the surfaces.
struct HullContact {
  Vec point[4];
  float separation[4];
  std::uint32_t id[4];  // 0: absent
};

inline void set_absent(HullContact& contact, int k) {
  contact.point[k] = {0.0f, 0.0f, 0.0f};
  contact.separation[k] = kAbsentSeparation;
  contact.id[k] = 0;
}

// Where two edges of a pair are closest, in the first hull's frame.
struct EdgeCrossing {
  Vec on_1, on_2;
};

// Finds the best axis of a face. False: the pair is separated along decision.axis.
bool query_faces(const HullPair& pair, std::uint32_t hint, Decision& decision);
// Replaces a face's decision by two edges' where these are better. False: separated.
bool query_edges(const HullPair& pair, Decision& decision);

// Tests the edges that decided in the last step.
enum class Remembered { separates, decides, fails };
Remembered query_remembered_edges(const HullPair& pair, std::uint32_t hint, Decision& decision);
// Whether a face of either hull may be better than the floor, the gap along the axis of the two edges.
bool may_beat(const HullPair& pair, const int edge[2], float floor);

// A face of each hull that lie against each other along the contact axis. Their overlap, seen along the axis,
// gives the contact points.
struct FacePair {
  int side;  // of the hull whose face is the first: the deciding one, or that at an edge of the first hull
  int face, incident;
  Vec axis;      // in the frame of hull `side`, away from it
  float offset;  // along the axis, of the surface of hull `side`
  bool crosses;  // edges decided: their crossing is a point, too, and the first face may be askew
  EdgeCrossing crossing;
};
// The deciding face, and the face of the other hull at its deepest vertex that most opposes it.
FacePair pair_faces(const HullPair& pair, const Decision& decision);
// The faces at two edges that point most along the axis. False: one of them hardly does.
bool pair_edge_faces(const HullPair& pair, const Decision& decision, const EdgeCrossing& crossing,
                     FacePair& faces);
EdgeCrossing cross_deciding_edges(const HullPair& pair, const Decision& decision);
// Whether the edges pass each other sideways and do not touch yet.
bool pass_beside(const HullPair& pair, const Decision& decision, const EdgeCrossing& crossing);
// Makes a contact of the edges' crossing alone.
void touch_crossing(const Decision& decision, const EdgeCrossing& crossing, HullContact& contact);
// Contact points of two faces of any size.
void clip_faces(const HullPair& pair, const Decision& decision, const FacePair& faces, HullContact& contact);

// ManifoldFeatures::id of a point of two faces, without its number. It is the same whether a face or an edge
// of the first hull decides, so that points outlive the change from one to the other.
inline std::uint32_t face_id(const FacePair& faces) {
  return (faces.side == 0 ? kFeatureFace1 : kFeatureFace2) | static_cast<std::uint32_t>(faces.face) << 19 |
         static_cast<std::uint32_t>(faces.incident) << 10;
}
inline constexpr std::uint32_t kLostNumber = 1023;  // of the substitute where clipping finds no point

// A candidate counts as equal to the largest if its distance or area is less by at most this share, or if its
// depth differs by less than the axis tolerance. The first of equal candidates wins, so that they do not
// alternate while a hull at rest jitters.
inline constexpr float kTieShare = 1e-3f;
// Where the other hull's face is this steep, the deciding face's corners cannot be distinguished from its
// edges.
inline constexpr float kSteepFace = 1e-3f;

// Gathers pairs of faces with few corners until they fill the lanes. Clipping with lane = pair takes a third
// of the time. The result of a pair does not depend on the others.
inline constexpr int kSmallFace = 4;  // corners
struct FaceQueue {
  int count = 0;
  alignas(64) float deciding[kSmallFace][3][kLanes];  // corners in their hulls' frames; then the first again
  alignas(64) float incident[kSmallFace][3][kLanes];
  alignas(64) float incident_count[kLanes];
  alignas(64) float deciding_count[kLanes];
  alignas(64) float row[3][3][kLanes];  // from the other hull's frame to the deciding one's
  alignas(64) float center[3][kLanes];
  alignas(64) float axis[3][kLanes];
  alignas(64) float offset[kLanes];
  alignas(64) float crossing[4][kLanes];  // where edges decide, between them, and 1; all 0 elsewhere
  alignas(64) std::int32_t edges_id[kLanes];
  alignas(64) float deciding_normal[3][kLanes];
  alignas(64) float incident_normal[3][kLanes];
  alignas(64) float support[3][kLanes];  // deepest vertex, in the other hull's frame
  alignas(64) float separation[kLanes];
  alignas(64) float reach[kLanes], tolerance[kLanes], border[kLanes];
  alignas(64) std::int32_t id[kLanes];

  void put(const HullPair& pair, const Decision& decision, const FacePair& faces);
};
// Computes contact points of all queued pairs, in the deciding hulls' frames. Empties the queue.
void clip_queue(FaceQueue& queue, HullContact contacts[kLanes]);

// The projection of a point onto a face; outside the face, the border point on the line to it from the face's
// middle.
Vec point_within_face(const HullData& hull, int face, Vec point);

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
