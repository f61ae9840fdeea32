// Narrow-phase kernels: candidate pairs of two types of shapes -> manifolds.
//
// Implemented by collide*.cpp, called by parallel/narrow_phase/collide.cpp. A lane is one pair of shapes.
#pragma once

#include <core/plain/hull.h>
#include <core/plain/manifold.h>
#include <core/plain/rows.h>

#include <cstdint>

namespace scree::simd {

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
  std::int32_t row;    // the contact's own row, also if it only becomes one
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
};

}  // namespace scree::simd
