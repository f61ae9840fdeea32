// Narrow-phase kernels: candidate pairs of two types of shapes -> manifolds.
//
// Implemented by collide*.cpp, called by parallel/narrow_phase/collide.cpp. A lane is one pair of shapes.
#pragma once

#include <core/plain/hull.h>
#include <core/plain/manifold.h>
#include <core/plain/mesh.h>
#include <core/plain/rows.h>

#include <cstdint>

namespace scree::simd {

// Convex shapes by the values of ShapeType. Those from kSolidRoundedBox on are smooth.
enum SolidType : std::uint8_t {
  kSolidSphere,
  kSolidCapsule,
  kSolidBox,
  kSolidHull,
  kSolidRoundedBox = 6,
  kSolidRoundedHull,
  kSolidCylinder,
  kSolidCone,
};

// Pairs of shape types, each with a kernel of its own. "First" is the shape of the lower type; for two shapes
// of one type, the shape of the lower index.
enum CollideType : int {
  kSphereSphere,
  kSphereCapsule,
  kSphereBox,
  kCapsuleCapsule,
  kCapsuleBox,
  kBoxBox,
  kSphereHull,
  kCapsuleHull,
  kBoxHull,
  kHullHull,
  kSphereHalfSpace,
  kCapsuleHalfSpace,
  kBoxHalfSpace,
  kHullHalfSpace,
  kSmooth,  // a smooth shape and any convex one, in any order
  kSmoothHalfSpace,
  kCollideTypes,
};

// Largest number of pairs per call. The pairs left after the sphere test fit on the stack, and a call is
// worth a claim of the crew.
inline constexpr int kCollideChunk = 128;

enum CollideItemFlag : std::int32_t {
  kItemFlip = 1,    // the manifold's body A is the second shape's
  kItemStatic = 2,  // body A is not dynamic
  kItemFixed = 4,   // body A is fixed: constraints read the fixed world's row
  kItemKnown = 8,   // already a contact: its row holds the last step's manifold
};

// One pair to collide.
struct alignas(32) CollideItem {
  std::int32_t shape_1;
  std::int32_t shape_2;
  std::int32_t body_1;
  std::int32_t body_2;
  std::int32_t row;    // of the contact's columns: its own, or a place in a round if it is none yet
  std::int32_t flags;  // CollideItemFlag
  std::int32_t pair;   // row of its axis
  std::int32_t padding = 0;
};

// Columns that the kernels read and write.
struct CollideColumns {
  const PoseRow* shape_pose;
  const ExtentRow* shape_extent;
  const MaterialRow* shape_material;
  const std::int32_t* shape_hull = nullptr;  // slot in `hulls`, -1: no hull
  const HullData* const* hulls = nullptr;
  const std::int32_t* shape_mesh = nullptr;  // slot in `meshes`, -1: no mesh
  const MeshData* const* meshes = nullptr;
  const std::uint8_t* shape_type = nullptr;  // SolidType of convex shapes; read where a shape is smooth
  const PoseRow* body_pose;
  const VelocityRow* body_velocity;
  float dt;  // s; how far ahead points are made for fast bodies
  // Contacts, by CollideItem::row. An item with kItemKnown is read before it is written.
  Manifold* manifold;
  ManifoldFeatures* features;
  ContactSurface* surface;      // written where the contact is rich
  ContactAnchor* anchor;        // written where no sphere touches
  ContactAxis* axis = nullptr;  // by CollideItem::pair; read and written for hulls against hulls and boxes
  std::uint8_t* points;         // number of points of the row
  // By CollideItem::pair, if not null: written for some pairs that do not touch.
  PairClearance* clearance = nullptr;
};

// Convex shapes that touch meshes, by the values of ShapeType; all smooth ones are one.
enum MeshFirstType : std::int32_t { kMeshSphere, kMeshCapsule, kMeshBox, kMeshHull, kMeshSmooth };

// What a convex shape, the first of a pair, touches a triangle of the second one with, in the frame of the
// first.
struct TriangleContact {
  float normal[3];  // unit, from the shape to the mesh
  std::int32_t triangle;
  float point[kMaxManifoldPoints][3];  // halfway between the surfaces
  float separation[kMaxManifoldPoints];
  std::uint32_t id[kMaxManifoldPoints];  // 0: absent; absent ones come last
};

// TriangleContact::id of what is no corner of a box or hull begins here.
inline constexpr std::uint32_t kFirstMixedName = 0x40000000u;

// collide_meshes: up to kMeshChunk pairs, one after the other. The contacts of a pair come in the order of
// the triangles.
inline constexpr int kMeshChunk = 16;  // some microseconds each
struct MeshTask {
  const CollideColumns& columns;
  const CollideItem* items;
  const MeshFirstType* first_types;  // of each item
  int count;
  TriangleContact* contacts;
  int capacity;  // at least kLeastMeshCapacity
  int* ends;     // out: where the contacts of each item end
};
inline constexpr int kLeastMeshCapacity = 64;

// A manifold of a pair with a mesh, as merged from contacts with triangles.
struct MeshManifold {
  TriangleContact contact;
  std::int32_t place;     // of the pair in its list
  std::int32_t row;       // of contacts; -1: not yet known
  std::int32_t material;  // MeshData::material of its triangles
  std::int32_t is_known;  // 1: the row holds the last step's manifold
};

// Where a manifold with a mesh has gone since it was made.
struct FollowedManifold {
  float separation[kMaxManifoldPoints];
  std::int32_t keeps;  // 1: the shape has hardly moved, so that it may be recycled
};

struct CollideKernels {
  // Collides up to kCollideChunk items, all of one type pair. Without contact only `points` of the row is
  // sure to be written.
  using Collide = void (*)(const CollideColumns& columns, const CollideItem* items, int count);
  Collide collide[kCollideTypes];
  // Recycles manifolds of up to kCollideChunk pairs, and copies the other items to `left`. Returns the number
  // of items in `left`. Does not change axes.
  using Recycle = int (*)(const CollideColumns& columns, const CollideItem* items, int count,
                          CollideItem* left);
  Recycle recycle_boxes;
  Recycle recycle_hulls;     // and boxes against hulls
  Recycle recycle_capsules;  // against all but spheres
  // Follows manifolds of up to kCollideChunk contacts of capsules, boxes and hulls with meshes. Writes no
  // row: a pair has several contacts, of which either all are recycled or none.
  void (*follow_mesh_manifolds)(const CollideColumns& columns, const CollideItem* items, int count,
                                FollowedManifold* followed);
  // False: there may be more contacts than the capacity, and what was written is void.
  bool (*collide_meshes)(const MeshTask& task);
  // Writes up to kCollideChunk manifolds into their rows. items[i] is that of found[i], with its row; all
  // first shapes are of one type.
  void (*store_mesh_manifolds)(const CollideColumns& columns, const CollideItem* items,
                               const MeshManifold* found, int count, std::int32_t first_type);
};

}  // namespace scree::simd
