// Recycles manifolds: while two boxes, hulls or capsules, or one of these and a mesh, have hardly moved
// relative to each other, their manifold stays, and only its separations follow the bodies. This lets a tall
// stack stand. Points computed from slightly different poses jump between corners and cause jitter. A wedged
// capsule would jump from one of its ends to the other, or from one point to two, and tremble at 0.1 m/s for
// ever. (Box3D's contact recycling, v0.1, after the persistent manifolds of PhysX; it also saves most of the
// narrow phase at rest.)
//
// Where a body has turned, the manifold of boxes and hulls is carried along with body A, so that only the
// relative motion counts, over all carries: bodies in a drum or on a turntable turn together. (What turns
// alone on a body at rest keeps its manifold within the same limit.)
#include "collide_contact.h"

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Largest relative motion of two bodies: a share of the thinner one's half thickness, up to this limit.
constexpr float kRecycleDistance = 10.0f * kLinearSlop;  // m
constexpr float kRecycleShare = 0.1f;
// Weight of motion along the normal. Such motion moves no point within its face, and the boxes at the foot of
// a tall stack are pressed together by several centimeters. At 1 a stack of 100 boxes leans and falls.
// Applies only where the manifold has all its points: others may appear as the boxes come closer.
constexpr float kPressWeight = 0.5f;
// If a manifold has room for more points, an absent point was farther than the speculative distance: the
// boxes may not move farther than that.
constexpr float kRecycleDistancePartial = kSpeculativeDistance;
// On a mesh, triangles that were farther than the speculative distance may come close, too, and half of that
// leaves the other half to a step.
constexpr float kRecycleDistanceMesh = 0.5f * kSpeculativeDistance;
// The normal stays fixed in the world, so neither body may turn by more than 2 degrees, unless the manifold
// is carried along: the squared cosine of half of that.
constexpr float kTurnLimit = 0.99969541f;
// rad. The arms stay fixed, too, unless the manifold is carried along: a turn about the normal leaves them
// behind, and a body on a turntable would be driven outward by that angle.
constexpr float kTwistLimit = 0.004f;

struct Motion {
  Q4 turn_a, turn_b;  // since the manifold was made or carried along
  V3 offset;          // of B's center of mass from A's
  V3 offset_change;
  V3 change_from_a;  // as seen from A, in the axes that it had then
  Q4 relative_turn;  // of B, the same way
  F distance;        // bound on the relative motion of the boxes' points since the manifold was made
  M turned;          // by more than the manifold may stay behind
};

// The types of shapes that the pairs of a call may have.
enum class Solids {
  boxes,
  boxes_and_hulls,
  all,     // the first shape is a capsule
  meshes,  // the first shape is a capsule, box or hull, the second one a mesh, whose size does not matter
};

// Half the thickness of a shape, and its largest distance from its center.
struct Measure {
  F thinness, size;
  M is_capsule = never();  // meaningful where capsules may be
};
inline Measure measure(const CollideColumns& columns, const std::int32_t* shape, const WideExtent& extent,
                       Solids solids) {
  const V3 half = extent.half;
  Measure m{min(min(half.x, half.y), half.z), length(half)};
  if (solids == Solids::boxes) return m;
  if (solids == Solids::all || solids == Solids::meshes) {
    const M is_capsule = half.x == F(0.0f);
    m.thinness = select(is_capsule, extent.radius, m.thinness);
    m.size = select(is_capsule, half.y + extent.radius, m.size);
    m.is_capsule = is_capsule;
  }
  m.thinness = thinness(columns, shape, m.thinness);
  return m;
}

inline V3 part(Q4 q) { return {q.x, q.y, q.z}; }

// Bound on the relative motion, seen from A: the change of B's place plus the motion of B's surface by B's
// relative turn.
inline Motion motion_since(const CollideColumns& columns, const Block& block, M flip, F reach, V3 normal,
                           F press_weight) {
  const float* rows = reinterpret_cast<const float*>(columns.anchor);
  constexpr int kStride = sizeof(ContactAnchor) / sizeof(float);
  Q4 old_a, old_b;
  V3 old_offset;
  F is_set;
  load_rows(rows, kStride, block.row, old_a.x, old_a.y, old_a.z, old_a.w);
  load_rows(rows + 4, kStride, block.row, old_b.x, old_b.y, old_b.z, old_b.w);
  load_rows(rows + 8, kStride, block.row, old_offset.x, old_offset.y, old_offset.z, is_set);
  const WidePose body_1 = load_pose(columns.body_pose, block.body_1);
  const WidePose body_2 = load_pose(columns.body_pose, block.body_2);
  const V3 way = body_2.position - body_1.position;
  const V3 offset = select(flip, -way, way);
  Motion motion;
  motion.turn_a = select(flip, body_2.rotation, body_1.rotation) * conjugate(old_a);
  motion.turn_b = select(flip, body_1.rotation, body_2.rotation) * conjugate(old_b);
  motion.offset_change = offset - old_offset;
  motion.offset = offset;
  motion.change_from_a = rotate_back(motion.turn_a, offset) - old_offset;
  motion.relative_turn = conjugate(motion.turn_a) * motion.turn_b;
  const F along = dot(motion.change_from_a, normal);
  const F pressed = press_weight * along;
  const F near = sqrt(length_squared(motion.change_from_a - along * normal) + pressed * pressed) +
                 F(2.0f) * length(part(motion.relative_turn)) * reach;
  const F turn = min(motion.turn_a.w * motion.turn_a.w, motion.turn_b.w * motion.turn_b.w);
  const F twist = max(abs(dot(part(motion.turn_a), normal)), abs(dot(part(motion.turn_b), normal)));
  motion.turned = !((turn > F(kTurnLimit)) & (twist < F(0.5f * kTwistLimit)));
  motion.distance = select(is_set > F(0.0f), near + (is_set - F(1.0f)), F(kAbsentSeparation));
  return motion;
}

// From the body's center of mass, of the points that are within reach.
inline F farthest_point(V3 arm, V3 tangent_1, V3 tangent_2, const F u[4], const F v[4],
                        const F separation[4]) {
  F farthest(0.0f);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    const F distance = length_squared(arm + u[k] * tangent_1 + v[k] * tangent_2);
    farthest = max(select(separation[k] <= F(kSpeculativeDistance), distance, F(0.0f)), farthest);
  }
  return sqrt(farthest);
}

// The manifolds of a block, and how their bodies have moved.
struct Manifolds {
  V3 normal, tangent_1, tangent_2, arm_a, arm_b;
  F u[kMaxManifoldPoints], v[kMaxManifoldPoints];
  F base[kMaxManifoldPoints];  // separations when they were made or carried along
  F friction, row_a, row_b;    // as they stand in the rows
  Motion motion;
  M near;     // the bodies have moved little enough to keep the manifold
  M is_fast;  // meshes only: needs points ahead, which may have other normals than the mesh has had so far
};

// `points`: their numbers.
inline Manifolds load_manifolds(const CollideColumns& columns, const Block& block, I points, Solids solids) {
  const float* rows = reinterpret_cast<const float*>(columns.manifold);
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  Manifolds m;
  load_rows(rows, kStride, block.row, m.normal.x, m.normal.y, m.normal.z, m.friction);
  load_rows(rows + 4, kStride, block.row, m.arm_a.x, m.arm_a.y, m.arm_a.z, m.row_a);
  load_rows(rows + 8, kStride, block.row, m.arm_b.x, m.arm_b.y, m.arm_b.z, m.row_b);
  load_rows(rows + 12, kStride, block.row, m.u[0], m.u[1], m.u[2], m.u[3]);
  load_rows(rows + 16, kStride, block.row, m.v[0], m.v[1], m.v[2], m.v[3]);
  load_rows(reinterpret_cast<const float*>(columns.anchor) + 12, sizeof(ContactAnchor) / sizeof(float),
            block.row, m.base[0], m.base[1], m.base[2], m.base[3]);
  m.tangent_1 = tangent_of(m.normal);
  m.tangent_2 = cross(m.normal, m.tangent_1);
  Measure shape_1 = measure(columns, block.shape_1, load_extent(columns.shape_extent, block.shape_1), solids);
  F travel_1(0.0f), travel_2(0.0f);
  if (solids == Solids::meshes) {
    // What is far from the body's center of mass moves farther by a turn, and may meet other triangles.
    const V3 place = load_pose(columns.shape_pose, block.shape_1, travel_1).position;
    load_pose(columns.shape_pose, block.shape_2, travel_2);
    shape_1.size = shape_1.size + length(place - load_pose(columns.body_pose, block.body_1).position);
  }
  m.is_fast = max(travel_1, travel_2) > F(0.0f);
  const Measure shape_2 =
      solids == Solids::meshes
          ? Measure{F(1e30f), F(0.0f)}
          : measure(columns, block.shape_2, load_extent(columns.shape_extent, block.shape_2), solids);
  const M flip = (block.flags & I(kItemFlip)) == I(kItemFlip);
  const M fixed = (block.flags & I(kItemFixed)) == I(kItemFixed);
  // A fixed body does not turn, so its size does not matter; B, whose turn is seen from A, is dynamic. Its
  // points may lie farther from its center of mass than the shape is large.
  const F size_a = select(flip, shape_2.size, shape_1.size),
          size_b = select(flip, shape_1.size, shape_2.size);
  const F reach = max(select(fixed, size_b, max(size_a, size_b)),
                      farthest_point(m.arm_b, m.tangent_1, m.tangent_2, m.u, m.v, m.base));
  const F share = F(kRecycleShare) * min(shape_1.thinness, shape_2.thinness);
  // Far points of hulls count. With near ones only, convex_pile sinks 1.5 % less deep and junkyard 2.4 %
  // deeper, and piles at rest keep two to four times the energy.
  const M full = (points == I(kMaxManifoldPoints)) & (solids == Solids::meshes ? never() : !never());
  const F room = F(solids == Solids::meshes ? kRecycleDistanceMesh : kRecycleDistancePartial);
  const F limit = select(full, F(kRecycleDistance), room);
  const F press_weight = select(full, F(kPressWeight), F(1.0f));
  m.motion = motion_since(columns, block, flip, reach, m.normal, press_weight);
  m.near = m.motion.distance < min(share, limit);
  if (solids == Solids::all || solids == Solids::meshes) {
    const M is_round = solids == Solids::all ? !never() : shape_1.is_capsule;
    m.arm_a = m.arm_a - m.normal * select(is_round, m.u[kCoreA], F(0.0f));
    m.arm_b = m.arm_b + m.normal * select(is_round, m.u[kCoreB], F(0.0f));
  }
  return m;
}

// Separations after a change by `center` and by `tilt` of the surfaces to each other, along the tangents.
// Returns the least.
inline F follow(const Manifolds& m, F center, V3 tilt, F (&separation)[kMaxManifoldPoints]) {
  const F tilt_1 = dot(m.tangent_1, tilt), tilt_2 = dot(m.tangent_2, tilt);
  F nearest(kAbsentSeparation);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    const M present = m.base[k] < F(0.5f * kAbsentSeparation);
    separation[k] = select(present, m.base[k] + center + m.u[k] * tilt_1 + m.v[k] * tilt_2, m.base[k]);
    nearest = min(separation[k], nearest);
  }
  return nearest;
}

// The manifolds of a block that stay where they are, and the new separations of their points.
struct Kept {
  M keeps;
  M turned;  // those that may be carried along instead
  F separation[kMaxManifoldPoints];
};

// `points`: their numbers; `candidates`: where there is a manifold to keep.
Kept follow_separations(const CollideColumns& columns, const Block& block, I points, M candidates,
                        Solids solids) {
  const Manifolds m = load_manifolds(columns, block, points, solids);
  // As the solver updates separations within a step: the normal turns with each body.
  const V3 change_a = rotate_back(m.motion.turn_a, m.normal) - m.normal;
  const V3 change_b = rotate_back(m.motion.turn_b, m.normal) - m.normal;
  const F center = dot(m.normal, m.motion.offset_change) + dot(m.arm_b, change_b) - dot(m.arm_a, change_a);
  Kept kept;
  const F nearest = follow(m, center, change_b - change_a, kept.separation);
  const M stays = candidates & m.near;
  kept.turned = stays & m.motion.turned;
  kept.keeps = stays & !m.motion.turned & (nearest <= F(kSpeculativeDistance));
  if (solids == Solids::meshes) kept.keeps = kept.keeps & !m.is_fast;
  return kept;
}

// The number of points of a block's manifolds, and which of these may be kept.
struct Candidates {
  I points;
  M are;
};
Candidates candidates_of(const CollideColumns& columns, const Block& block) {
  F friction_1, friction_2, twist, info_bits;
  load_rows(reinterpret_cast<const float*>(columns.manifold) + 28, sizeof(Manifold) / sizeof(float),
            block.row, friction_1, friction_2, twist, info_bits);
  const I info = as_int(info_bits), points = info & I(kManifoldPointMask);
  return {points, block.is_known & (points > I(0)) & ((info & I(kManifoldRich)) == I(0))};
}

// Recycles manifolds of a block that stay where they are; returns their lanes.
std::uint32_t recycle_block(const CollideColumns& columns, const Block& block, Solids solids,
                            std::uint32_t& turned) {
  turned = 0;
  const auto [points, candidates] = candidates_of(columns, block);
  if (!any(candidates)) return 0;
  const Kept kept = follow_separations(columns, block, points, candidates, solids);
  const std::uint32_t recycled = bits(kept.keeps);
  turned = bits(kept.turned);
  alignas(64) float separations[kMaxManifoldPoints][kLanes];
  for (int k = 0; k < kMaxManifoldPoints; ++k) store(separations[k], kept.separation[k]);
  alignas(64) std::int32_t counts[kLanes];
  store(counts, points);
  for (int lane = 0; lane < block.count; ++lane) {
    if ((recycled >> lane & 1u) == 0) continue;
    const std::int32_t row = block.row[lane];
    for (int k = 0; k < kMaxManifoldPoints; ++k) columns.manifold[row].separation[k] = separations[k][lane];
    columns.points[row] = static_cast<std::uint8_t>(counts[lane]);
  }
  return recycled;
}

// Carries manifolds of a block along with body A, with their points and impulses; returns the lanes where one
// still touches. All lanes are written: others are collided anew, and need of their last manifold only the
// impulses in the world's axes.
std::uint32_t carry_block(const CollideColumns& columns, const Block& block, Solids solids) {
  const auto [points, candidates] = candidates_of(columns, block);
  const Manifolds m = load_manifolds(columns, block, points, solids);
  const Q4 turn = m.motion.turn_a;
  F separation[kMaxManifoldPoints];
  const V3 change = rotate_back(m.motion.relative_turn, m.normal) - m.normal;
  const F center = dot(m.normal, m.motion.change_from_a) + dot(m.arm_b, change);
  const F nearest = follow(m, center, change, separation);
  const std::uint32_t carried = bits(candidates & (nearest <= F(kSpeculativeDistance)));

  const V3 turned = rotate(turn, m.normal);
  const V3 normal = turned * (F(1.0f) / sqrt(length_squared(turned)));
  const V3 arm_a = rotate(turn, m.arm_a), arm_b = arm_a - m.motion.offset;
  const V3 along = rotate(turn, m.tangent_1), tangent_1 = tangent_of(normal);
  const F cosine = dot(along, tangent_1), sine = dot(along, cross(normal, tangent_1));
  float* rows = reinterpret_cast<float*>(columns.manifold);
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  F friction_1, friction_2, twist, info;
  load_rows(rows + 28, kStride, block.row, friction_1, friction_2, twist, info);
  const auto write = [&](int group, F x, F y, F z, F w) {
    store_rows(rows + 4 * group, kStride, block.row, block.count, x, y, z, w);
  };
  F u[kMaxManifoldPoints], v[kMaxManifoldPoints];
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    u[k] = cosine * m.u[k] - sine * m.v[k];
    v[k] = sine * m.u[k] + cosine * m.v[k];
  }
  write(0, normal.x, normal.y, normal.z, m.friction);
  write(1, arm_a.x, arm_a.y, arm_a.z, m.row_a);
  write(2, arm_b.x, arm_b.y, arm_b.z, m.row_b);
  write(3, u[0], u[1], u[2], u[3]);
  write(4, v[0], v[1], v[2], v[3]);
  write(5, separation[0], separation[1], separation[2], separation[3]);
  write(7, cosine * friction_1 - sine * friction_2, sine * friction_1 + cosine * friction_2, twist, info);
  const M flip = (block.flags & I(kItemFlip)) == I(kItemFlip);
  store_anchor(columns, block, flip, F(1.0f) + m.motion.distance, separation);
  alignas(64) std::int32_t counts[kLanes];
  store(counts, points);
  for (int lane = 0; lane < block.count; ++lane) {
    columns.points[block.row[lane]] = static_cast<std::uint8_t>(counts[lane]);
  }
  return carried;
}

// Recycles manifolds of the items, and copies the other items to `left`. Returns the number of items in
// `left`.
int recycle_items(const CollideColumns& columns, const CollideItem* items, int count, Solids solids,
                  CollideItem* left) {
  const bool may_carry = solids == Solids::boxes || solids == Solids::boxes_and_hulls;
  CollideItem turned_items[kCollideChunk];
  int left_count = 0, turned_count = 0;
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    std::uint32_t turned = 0;
    const std::uint32_t recycled = recycle_block(columns, block, solids, turned);
    for (int lane = 0; lane < lanes; ++lane) {
      if ((recycled >> lane & 1u) != 0) continue;
      if (may_carry && (turned >> lane & 1u) != 0) {
        turned_items[turned_count++] = items[which[lane]];
      } else {
        left[left_count++] = items[which[lane]];
      }
    }
  }
  for (int begin = 0; begin < turned_count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(turned_items, turned_count, begin, which, block);
    const std::uint32_t carried = carry_block(columns, block, solids);
    for (int lane = 0; lane < lanes; ++lane) {
      if ((carried >> lane & 1u) == 0) left[left_count++] = turned_items[which[lane]];
    }
  }
  return left_count;
}

}  // namespace

void follow_mesh_manifolds(const CollideColumns& columns, const CollideItem* items, int count,
                           FollowedManifold* followed) {
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    const Candidates candidates = candidates_of(columns, block);
    const Kept kept = follow_separations(columns, block, candidates.points, candidates.are, Solids::meshes);
    const std::uint32_t keeps = bits(kept.keeps);
    alignas(64) float separations[kMaxManifoldPoints][kLanes];
    for (int k = 0; k < kMaxManifoldPoints; ++k) store(separations[k], kept.separation[k]);
    for (int lane = 0; lane < lanes; ++lane) {
      FollowedManifold& to = followed[begin + lane];
      for (int k = 0; k < kMaxManifoldPoints; ++k) to.separation[k] = separations[k][lane];
      to.keeps = static_cast<std::int32_t>(keeps >> lane & 1u);
    }
  }
}

int recycle_boxes(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left) {
  return recycle_items(columns, items, count, Solids::boxes, left);
}

int recycle_hulls(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left) {
  return recycle_items(columns, items, count, Solids::boxes_and_hulls, left);
}

int recycle_capsules(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left) {
  return recycle_items(columns, items, count, Solids::all, left);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
