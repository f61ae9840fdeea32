// Shared by the stages of the narrow phase of smooth and rounded shapes: cylinders, cones, rounded boxes and
// rounded hulls against each other and against every other convex shape.
//
// Included by collide_smooth*.cpp and collide_mesh*.cpp only. One pair after the other, in double precision,
// relative to the first shape's position in world axes. A shape is a core (point, segment, box, hull,
// triangle, cylinder or cone) and a margin around it: what is within the margin of the core. All stages ask a
// core only how far it reaches along a direction, and with what.
//
//   find_gap     distance and normal: collide_smooth_distance.cpp, or, where cores overlap,
//                collide_smooth_depth.cpp
//   find_points  contact points: features of both along the normal, clipped against each other, and how the
//                surfaces roll there
#pragma once

#include <core/plain/hull.h>
#include <simd/collide/collide_contact.h>

#include <cstdint>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

struct D3 {
  double x, y, z;
};
inline D3 operator+(D3 a, D3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline D3 operator-(D3 a, D3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline D3 operator-(D3 a) { return {-a.x, -a.y, -a.z}; }
inline D3 operator*(double s, D3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline D3 cross(D3 a, D3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double root(double a) { return __builtin_sqrt(a); }
inline double length(D3 a) { return root(dot(a, a)); }
inline double absolute(double a) { return a < 0.0 ? -a : a; }
inline double greater_of(double a, double b) { return a > b ? a : b; }
inline double lesser_of(double a, double b) { return a < b ? a : b; }
inline D3 to_d3(const float v[3]) { return {double{v[0]}, double{v[1]}, double{v[2]}}; }
// Two unit vectors perpendicular to the unit vector n and to each other; see tangent_of in wide_math.h.
struct Tangents {
  D3 u, v;
};
inline Tangents tangents_of(D3 n) {
  const double sign = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  const D3 u{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  return {u, cross(n, u)};
}

enum class CoreKind : std::uint8_t { point, segment, box, hull, triangle, cylinder, cone };

struct Core {
  CoreKind kind;
  double half[3];   // m; segment: [1]; box; cylinder and cone: radius, half height, radius
  double margin;    // m, around the core
  double size;      // m, of a ball about the center around all
  double thinness;  // m, half the thickness of the shape
  const HullData* hull;
  D3 corner[3];  // of a triangle, which is placed already
  D3 axis[3];    // of the shape's frame
  D3 center;     // of the shape's frame

  D3 turn(D3 local) const { return local.x * axis[0] + local.y * axis[1] + local.z * axis[2]; }
  D3 turn_back(D3 v) const { return {dot(axis[0], v), dot(axis[1], v), dot(axis[2], v)}; }
  D3 place(D3 local) const { return center + turn(local); }
};

// A shape of any convex type at a place. False: its pose is not finite.
bool make_core(const CollideColumns& columns, std::int32_t shape, D3 center, Core& core);
// A box without extent at a pose. False: it is not finite.
bool make_frame(const PoseRow& pose, D3 center, Core& core);
// A triangle in the frame of the pair.
Core triangle_core(D3 a, D3 b, D3 c);
// The point of the core that is farthest along a direction of any length above zero.
D3 farthest_point(const Core& core, D3 along);

// A separation of two cores: negative where they overlap.
struct Gap {
  double separation;  // m, along the normal, from the first core to the second
  D3 normal;          // unit, from the first core to the second
  D3 on_1, on_2;      // a point of each where they are closest, or deepest
};
// What is farthest of both cores along gap.normal: writes the separation. Points are those of the search.
void measure_along(const Core& a, const Core& b, Gap& gap);

enum class Nearness { far, apart, overlap };
// The closest points. `far`: the cores are farther apart than the limit, and nothing is written.
// `start`: where to begin, of any length above zero.
Nearness find_distance(const Core& a, const Core& b, D3 start, double limit, Gap& gap);
// The direction along which two overlapping cores are separated by the shortest way. `known`: the normal of
// the last step, or null; a shallow overlap keeps to it, and a deep one where it is about as good as any.
void find_depth(const Core& a, const Core& b, const D3* known, Gap& gap);
// Whether the cores overlap a little along about the normal of the last step; then the gap is written.
bool is_shallow_overlap(const Core& a, const Core& b, D3 known, Gap& gap);
// All of these. The gap is that of the cores; the limit that of the shapes. False: the shapes are farther
// apart.
bool find_gap(const Core& a, const Core& b, const D3* known, double limit, Gap& gap);

// What a core touches with along a direction: a point, a segment, or a flat polygon.
inline constexpr int kMostCorners = kMaxHullVertices;
struct Feature {
  int count;
  D3 point[kMostCorners];
  std::uint8_t name[kMostCorners];  // of a corner, and of the side that begins there
  D3 normal;                        // unit, of a polygon; looks away from the core
  bool is_flat;                     // the direction is the polygon's normal, but for rounding
  bool is_rolling;                  // a side of a cylinder or cone
  bool is_disk;                     // of which every fourth corner stays in place on the shape
  bool is_rim;                      // a disk that is so tilted that only its lowest point is near
  D3 start;                         // unit, from the middle of a disk to its first corner
};
// Where the corners of disks lie. Where one disk stands on another both have corners in the same directions.
struct DiskFrame {
  D3 lean;         // in the plane of contact: where the shapes come closest, times the sine of their tilt
  bool has_start;  // else a disk begins at an axis of its own
  D3 start;
};
// How a disk that looks along a direction is tilted toward it; zero for other features.
D3 lean_of(const Core& core, D3 along);
void find_feature(const Core& core, D3 along, const DiskFrame& frame, Feature& feature);

// How the surface of a shape moves: that of its center, which lies at `center` in the frame of the pair, and
// its turn about that without the spin about its own axis of symmetry, which moves no surface.
struct BodyMotion {
  D3 linear, angular, center;  // m/s, rad/s, m
  D3 whole_angular;            // rad/s, with that spin
};

struct SmoothContact {
  D3 normal;  // from the first shape to the second
  int count;
  D3 point[kMaxManifoldPoints];  // halfway between the surfaces
  double separation[kMaxManifoldPoints];
  std::uint32_t id[kMaxManifoldPoints];
  // See WideContact.
  double core_1, core_2, curvature_radius;
  bool at_edges, in_strip;
};

// SmoothContact::id: what a point is, and names of features of the first and of the second shape: a corner of
// either, the crossing of two sides, or where the search for the gap has ended.
inline constexpr std::uint32_t kOfFirst = 1u << 16, kOfSecond = 2u << 16, kOfBoth = 3u << 16,
                               kOfSearch = 4u << 16;
inline bool is_first_corner(std::uint32_t id) { return (id >> 16) == (kOfFirst >> 16); }
inline bool is_second_corner(std::uint32_t id) { return (id >> 16) == (kOfSecond >> 16); }
inline bool is_of_search(std::uint32_t id) { return id == kOfSearch; }
inline std::uint32_t first_name(std::uint32_t id) { return id >> 8 & 0xffu; }
inline std::uint32_t second_name(std::uint32_t id) { return id & 0xffu; }

// A contact point that may be taken.
struct SmoothCandidate {
  double u, v;        // along the tangents of the normal
  double height;      // along the normal, halfway between the surfaces
  double separation;  // of the surfaces
  std::uint32_t id;
};
struct SmoothCandidates {
  int count = 0;
  SmoothCandidate of[2 * kMostCorners + 1];  // a clipped polygon's corners, and the deepest point
};

struct PairMotion {
  BodyMotion body[2];
  double dt;  // s, of the step
};
// The points of a pair, up to the reach and beyond where they come near within the step.
void find_points(const Core& a, const Core& b, const Gap& gap, double reach, const PairMotion& motion,
                 SmoothContact& contact);
// Takes at most four: the deepest up to a tolerance, and those that spread most, no two nearer than `spread`.
void choose_points(const SmoothCandidates& candidates, D3 normal, double tolerance, double spread,
                   SmoothContact& contact);
// Takes corners of the shapes before other points, because they stay while seams of a mesh pass below, or
// while a disk rocks; of a disk every fourth.
inline constexpr int kDiskQuarter = 4;  // corners
void choose_steady(const SmoothCandidates& candidates, bool is_disk_1, bool is_disk_2, bool on_triangle,
                   D3 normal, double tolerance, SmoothContact& contact);
// Drops candidates that neither are as deep as `nearest` nor come below the limit within the step.
void drop_far(const PairMotion& motion, D3 normal, const Tangents& tangents, double limit, double nearest,
              SmoothCandidates& candidates);
// How a shape's surface rolls at the contact's points. `feature`: of the shape along the normal; `side`: 1
// for the first shape, -1 for the second; `spin`: of the shape's body.
struct Roundness {
  double core;       // m, from the surface to what turns with the body; 0: the surface itself
  double curvature;  // m, a radius; 0: none that a patch would form on
};
Roundness find_roundness(const Core& core, const Feature& feature, const SmoothContact& contact, double side,
                         D3 spin);

// By which points count as equally deep, as features of other shapes.
inline double tolerance_of(const Core& a, const Core& b) {
  return lesser_of(double{kFeatureTolerance}, double{kFeatureShare} * lesser_of(a.thinness, b.thinness));
}

PairMotion motion_of(const CollideColumns& columns, std::int32_t body_1, std::int32_t body_2,
                     const float (&origin)[3], const Core& a, const Core& b);

// Contacts that wait to be written together.
class SmoothStore {
 public:
  SmoothStore(const CollideColumns& columns, const CollideItem* items) : columns_(columns), items_(items) {}
  void put(int item, const SmoothContact& contact);
  void flush();

 private:
  const CollideColumns& columns_;
  const CollideItem* items_;
  int count_ = 0;
  std::int32_t which_[kLanes];
  SmoothContact waiting_[kLanes];
};

// Collides pairs one after the other with `collide_pair(columns, item, reach, contact)`.
template <class CollidePair>
void collide_smooth_pairs(const CollideColumns& columns, const CollideItem* items, int count,
                          CollidePair&& collide_pair) {
  SmoothStore contacts(columns, items);
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    alignas(64) float reach[kLanes];
    store(reach, load_pair(columns, block).reach);
    for (int lane = 0; lane < lanes; ++lane) {
      const CollideItem& item = items[begin + lane];
      SmoothContact contact;
      if (collide_pair(columns, item, double{reach[lane]}, contact)) {
        contacts.put(begin + lane, contact);
      } else {
        columns.points[item.row] = 0;
      }
    }
  }
  contacts.flush();
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
