// Narrow-phase kernels: candidate pairs of two types of shapes -> manifolds.
//
// Implemented by collide*.cpp, called by parallel/narrow_phase/collide.cpp. A lane is one pair of shapes.
#pragma once

#include <core/plain/hull.h>
#include <core/plain/manifold.h>
#include <core/plain/rows.h>

#include <cstdint>

namespace scree::simd {

// Pairs of shape types, each with a kernel of its own. "First" is the shape of the lower type, and of the
// lower index where both are of one type.
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

// Pairs per call at most: the survivors of a call fit on its stack, and a call is worth a claim of the crew.
inline constexpr int kCollideChunk = 128;

enum CollideItemFlag : std::int32_t {
  kItemFlip = 1,    // the manifold's body A is the second shape's
  kItemStatic = 2,  // body A is not dynamic
  kItemFixed = 4,   // body A is fixed: constraints read the fixed world's row
  kItemKnown = 8,   // a contact already: its row holds what the last step made
};

// One pair to collide.
struct alignas(32) CollideItem {
  std::int32_t shape_1;
  std::int32_t shape_2;
  std::int32_t body_1;
  std::int32_t body_2;
  std::int32_t row;    // for the contact, if it is or becomes one: its own
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
  // Recycles what it can of up to kCollideChunk pairs and copies the other items to `left`; returns how many
  // those are. Axes stay as they are.
  using Recycle = int (*)(const CollideColumns& columns, const CollideItem* items, int count,
                          CollideItem* left);
  Recycle recycle_boxes;
  Recycle recycle_hulls;     // and boxes against hulls
  Recycle recycle_capsules;  // against all but spheres
};

}  // namespace scree::simd
