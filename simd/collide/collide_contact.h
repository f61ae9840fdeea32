// Shared by all collide kernels: loads a block of pairs, drops separated pairs, and turns the geometry of a
// contact into a manifold with friction center, mixed materials and last step's impulses.
//
// Included by collide*.cpp only. Positions are relative to the first shape's origin, so that far from the
// world's origin only the difference of two stored positions is rounded.
#pragma once

#include <core/plain/rows.h>
#include <simd/collide/collide_kernels.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// Distance beyond a feature's border (a box's edge against a face's border) that still counts as within, so
// that exactly aligned shapes keep their features while they jitter. An axis of lower rank must also win by
// this much to replace one of higher rank. The smaller of a length and a share of the shapes' size.
inline constexpr float kFeatureTolerance = 0.1f * kLinearSlop;  // m
inline constexpr float kFeatureShare = 0.01f;

// A second contact point of a capsule must be this share of its radius away from the first.
inline constexpr float kMinimumSpread = 0.05f;

inline bool any(M m) { return bits(m) != 0; }
inline M never() { return F(0.0f) < F(0.0f); }
inline I count_if(M m) { return select(m, I(1), I(0)); }
inline F sign_of(F a) { return copy_sign(F(1.0f), a); }
inline F square(F a) { return a * a; }

// Pairs in lanes. Lanes from `count` on repeat the last pair and are not stored.
struct Block {
  alignas(64) std::int32_t shape_1[kLanes];
  alignas(64) std::int32_t shape_2[kLanes];
  alignas(64) std::int32_t body_1[kLanes];
  alignas(64) std::int32_t body_2[kLanes];
  alignas(64) std::int32_t row[kLanes];
  I flags;
  M is_known;  // kItemKnown
  int count;
};

// Numbers `lanes` rows from `begin` on; lanes beyond them repeat the last one.
inline void number_lanes(int begin, int lanes, std::int32_t (&which)[kLanes]) {
  for (int lane = 0; lane < kLanes; ++lane) which[lane] = begin + (lane < lanes ? lane : lanes - 1);
}

inline void load_block(const CollideItem* items, const std::int32_t* which, int count, Block& block) {
  const float* rows = reinterpret_cast<const float*>(items);
  constexpr int kStride = sizeof(CollideItem) / sizeof(float);
  F shape_1, shape_2, body_1, body_2, row, flags, pair, padding;
  load_rows(rows, kStride, which, shape_1, shape_2, body_1, body_2);
  load_rows(rows + 4, kStride, which, row, flags, pair, padding);
  store(block.shape_1, as_int(shape_1));
  store(block.shape_2, as_int(shape_2));
  store(block.body_1, as_int(body_1));
  store(block.body_2, as_int(body_2));
  store(block.row, as_int(row));
  block.flags = as_int(flags);
  block.is_known = (block.flags & I(kItemKnown)) == I(kItemKnown);
  block.count = count;
}

// The items from `begin` on, as many as there are lanes, and their numbers. Returns how many there are.
inline int take_block(const CollideItem* items, int count, int begin, std::int32_t (&which)[kLanes],
                      Block& block) {
  const int lanes = count - begin < kLanes ? count - begin : kLanes;
  number_lanes(begin, lanes, which);
  load_block(items, which, lanes, block);
  return lanes;
}

struct WidePose {
  V3 position;
  Q4 rotation;
};

inline WidePose load_pose(const PoseRow* poses, const std::int32_t* index, F& padding) {
  const float* rows = reinterpret_cast<const float*>(poses);
  constexpr int kStride = sizeof(PoseRow) / sizeof(float);
  WidePose pose;
  load_rows(rows, kStride, index, pose.position.x, pose.position.y, pose.position.z, padding);
  load_rows(rows + 4, kStride, index, pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w);
  return pose;
}
inline WidePose load_pose(const PoseRow* poses, const std::int32_t* index) {
  F padding;
  return load_pose(poses, index, padding);
}
inline V3 load_position(const PoseRow* poses, const std::int32_t* index) {
  V3 position;
  F padding;
  load_rows(reinterpret_cast<const float*>(poses), sizeof(PoseRow) / sizeof(float), index, position.x,
            position.y, position.z, padding);
  return position;
}

struct WideExtent {
  V3 half;
  F radius;
};
inline WideExtent load_extent(const ExtentRow* extents, const std::int32_t* index) {
  WideExtent extent;
  load_rows(reinterpret_cast<const float*>(extents), sizeof(ExtentRow) / sizeof(float), index, extent.half.x,
            extent.half.y, extent.half.z, extent.radius);
  return extent;
}

// Two shapes: poses, extents, and the offset from the first to the second.
struct WidePair {
  WidePose first, second;
  WideExtent extent_1, extent_2;
  V3 offset;
  F reach;  // gap below which the pair has points
};

// Half the segment of a capsule that is the first shape, in the second one's frame.
inline V3 half_segment_in_second(const WidePair& pair) {
  const Q4 q = conjugate(pair.second.rotation) * pair.first.rotation;
  const F two(2.0f);
  const V3 axis{two * (q.x * q.y - q.w * q.z), F(1.0f) - two * (q.x * q.x + q.z * q.z),
                two * (q.y * q.z + q.w * q.x)};
  return axis * pair.extent_1.half.y;
}

// False if a rotation is not finite (a comparison with NaN is false).
inline M is_rotation(Q4 q) { return q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < F(2.0f); }
// Also false if the offset is not finite.
inline M spheres_touch(const WidePair& pair, F radius_1, F radius_2) {
  return length_squared(pair.offset) <= square(radius_1 + radius_2 + pair.reach);
}

// A contact's geometry. Absent points have separation kAbsentSeparation and id 0 and come last.
template <int kPoints>
struct WideContact {
  V3 normal;          // from the first shape to the second, in world axes
  V3 point[kPoints];  // halfway between the surfaces, relative to the first shape's position
  F separation[kPoints];
  I id[kPoints];
  // Where a round shape touches, or a smooth one with two points at most:
  F curvature_radius;    // of both surfaces together
  F radius_1, radius_2;  // of round surfaces about their cores, else 0
  // Polytopes, for grazes_ahead; set where the pair looks ahead.
  M in_strip;  // seen along the normal the two faces overlap in a thin strip, within reach or not
  M at_edges;  // two edges cross, and no faces lie against each other
};

// The first shape is round, the second one is a polytope.
template <int kPoints>
void set_radius(WideContact<kPoints>& contact, F radius) {
  contact.curvature_radius = contact.radius_1 = radius;
  contact.radius_2 = F(0.0f);
}

template <int kPoints>
void set_absent(WideContact<kPoints>& contact, int k) {
  contact.point[k] = {F(0.0f), F(0.0f), F(0.0f)};
  contact.separation[k] = F(kAbsentSeparation);
  contact.id[k] = I(0);
}

// Whether the line between two closest points deviates from the normal by at most this squared distance. Then
// their contact points may share the normal.
inline M is_beside(V3 difference, V3 normal, F squared_limit) {
  return length_squared(difference - dot(difference, normal) * normal) <= squared_limit;
}

// Whether a capsule is so nearly perpendicular to the normal that its surface lies a radius from its segment
// along the normal, not only at its deeper end.
inline M lies_across(V3 half_segment, V3 normal, F radius) {
  return square(dot(half_segment, normal)) * radius <= F(kLinearSlop) * length_squared(half_segment);
}

// Replaces a capsule's single point by the touching ends of its stretch along the other shape, where `use`
// holds and at least one end touches. The ends have ids 1 and 2.
inline void use_ends(WideContact<2>& contact, F reach, M use, const V3 point[2], const F separation[2]) {
  const M touches_1 = separation[0] <= reach;
  const M touches_2 = separation[1] <= reach;
  const M replace = use & (touches_1 | touches_2);
  const M both = use & touches_1 & touches_2;
  contact.point[0] = select(replace, select(touches_1, point[0], point[1]), contact.point[0]);
  contact.separation[0] =
      select(replace, select(touches_1, separation[0], separation[1]), contact.separation[0]);
  contact.id[0] = select(replace, select(touches_1, I(1), I(2)), contact.id[0]);
  contact.point[1] = select(both, point[1], contact.point[1]);
  contact.separation[1] = select(both, separation[1], contact.separation[1]);
  contact.id[1] = select(both, I(2), contact.id[1]);
}

inline F mix(I rule, F a, F b) {
  const F smaller = min(a, b), larger = max(a, b), product = a * b;
  F mixed = smaller;
  mixed = select(rule == I(1), F(0.5f) * (a + b), mixed);
  mixed = select(rule == I(2), product, mixed);
  mixed = select(rule == I(3), sqrt(product), mixed);
  return select(rule == I(4), larger, mixed);
}

struct WideSurface {
  F friction, restitution, rolling_resistance;
  M moves;
  M has_patch;
};
inline WideSurface mix_materials(const MaterialRow* materials, const Block& block) {
  const float* rows = reinterpret_cast<const float*>(materials);
  constexpr int kStride = sizeof(MaterialRow) / sizeof(float);
  F friction_1, restitution_1, rolling_1, rules_1, friction_2, restitution_2, rolling_2, rules_2;
  load_rows(rows, kStride, block.shape_1, friction_1, restitution_1, rolling_1, rules_1);
  load_rows(rows, kStride, block.shape_2, friction_2, restitution_2, rolling_2, rules_2);
  const auto stronger = [](I a, I b) { return select(a > b, a, b); };
  const I low_byte(0xff);
  const I friction_rule = stronger(as_int(rules_1) & low_byte, as_int(rules_2) & low_byte);
  const I restitution_rule =
      stronger(shift_right<8>(as_int(rules_1)) & low_byte, shift_right<8>(as_int(rules_2)) & low_byte);
  const I moves(kMaterialMoves), patch(kMaterialPatch), either = as_int(rules_1) | as_int(rules_2);
  return {mix(friction_rule, friction_1, friction_2), mix(restitution_rule, restitution_1, restitution_2),
          max(rolling_1, rolling_2), (either & moves) == moves, (either & patch) == patch};
}

inline V3 relative_velocity(const CollideColumns& columns, const Block& block) {
  V3 v_1, v_2;
  F pad;
  const float* rows = reinterpret_cast<const float*>(columns.body_velocity);
  load_rows(rows, 8, block.body_1, v_1.x, v_1.y, v_1.z, pad);
  load_rows(rows, 8, block.body_2, v_2.x, v_2.y, v_2.z, pad);
  return v_2 - v_1;
}

// Width of a group of points in a plane: the largest distance of a point from the line through two points
// that lie far apart. (Moments of the points would lose the width of a strip to the rounding of its squared
// length.)
template <int kCount>
F width_of(const F (&x)[kCount], const F (&y)[kCount]) {
  const auto take_farthest = [&](F from_x, F from_y, F& to_x, F& to_y) {
    F most(0.0f);
    to_x = from_x;
    to_y = from_y;
    for (int k = 0; k < kCount; ++k) {
      const F distance = square(x[k] - from_x) + square(y[k] - from_y);
      const M farther = distance > most;
      most = select(farther, distance, most);
      to_x = select(farther, x[k], to_x);
      to_y = select(farther, y[k], to_y);
    }
  };
  F a_x, a_y, b_x, b_y;
  take_farthest(x[0], y[0], a_x, a_y);
  take_farthest(a_x, a_y, b_x, b_y);
  const F way_x = b_x - a_x, way_y = b_y - a_y;
  F area(0.0f);
  for (int k = 0; k < kCount; ++k) {
    area = max(abs(way_x * (y[k] - a_y) - way_y * (x[k] - a_x)), area);
  }
  return area / max(sqrt(square(way_x) + square(way_y)), F(1e-30f));
}

// A pair with a fast shape has points below this gap. If the pair rebounds, the gap is its relative travel in
// a step, so that the rebound starts at the surface with the speed of the impact. Else it is a share of its
// size: points far ahead act on the arms of the step's beginning, which costs an eccentric impact 3 % of its
// spin. Without points ahead, contact begins only after a falling body has sunk in by up to a step's travel,
// which is three times the mean penetration of a collapsing pile of hulls.
inline constexpr float kAheadShare = 0.1f;
inline F reach_of_fast(const CollideColumns& columns, const Block& block, F smaller) {
  // At most the size of the smaller shape: else a bullet would stop at shapes that it passes.
  const F ahead = min(length(relative_velocity(columns, block)) * F(columns.dt), smaller);
  const M rebounds = mix_materials(columns.shape_material, block).restitution > F(0.0f);
  return F(kSpeculativeDistance) + select(rebounds, ahead, min(ahead, F(kAheadShare) * smaller));
}

inline F size_of(const WideExtent& extent) {
  return max(max(extent.half.x, extent.half.y), max(extent.half.z, extent.radius));
}
inline WidePair load_pair(const CollideColumns& columns, const Block& block) {
  WidePair pair;
  F travel_1, travel_2;
  pair.first = load_pose(columns.shape_pose, block.shape_1, travel_1);
  pair.second = load_pose(columns.shape_pose, block.shape_2, travel_2);
  pair.extent_1 = load_extent(columns.shape_extent, block.shape_1);
  pair.extent_2 = load_extent(columns.shape_extent, block.shape_2);
  pair.offset = pair.second.position - pair.first.position;
  pair.reach = F(kSpeculativeDistance);
  const M fast = max(travel_1, travel_2) > F(0.0f);
  if (any(fast)) {
    const F smaller = min(size_of(pair.extent_1), size_of(pair.extent_2));
    pair.reach = select(fast, reach_of_fast(columns, block, smaller), pair.reach);
  }
  return pair;
}

struct WideImpulses {
  F normal[kMaxManifoldPoints];
  F friction_1, friction_2, twist;
  M rolling;  // there is a rolling impulse to keep
};

// Last step's impulses: those of points by id, friction by its world vector, twist by its part about the new
// normal. A contact whose features have all changed starts from zero.
template <int kPoints>
WideImpulses match_impulses(const CollideColumns& columns, const Block& block,
                            const WideContact<kPoints>& contact, V3 normal, V3 tangent_1, V3 tangent_2) {
  const F zero(0.0f);
  WideImpulses impulses{{zero, zero, zero, zero}, zero, zero, zero, never()};
  if (!any(block.is_known)) return impulses;
  const float* rows = reinterpret_cast<const float*>(columns.manifold);
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  V3 old_normal;
  F friction, friction_1, friction_2, twist, info;
  F old_impulse[kMaxManifoldPoints], old_id[kMaxManifoldPoints];
  load_rows(rows, kStride, block.row, old_normal.x, old_normal.y, old_normal.z, friction);
  load_rows(rows + 24, kStride, block.row, old_impulse[0], old_impulse[1], old_impulse[2], old_impulse[3]);
  load_rows(rows + 28, kStride, block.row, friction_1, friction_2, twist, info);
  load_rows(reinterpret_cast<const float*>(columns.features), sizeof(ManifoldFeatures) / sizeof(float),
            block.row, old_id[0], old_id[1], old_id[2], old_id[3]);
  const M touched = block.is_known & ((as_int(info) & I(kManifoldPointMask)) > I(0));
  M matched = never();
  for (int k = 0; k < kPoints; ++k) {
    const M present = touched & (contact.id[k] > I(0));
    for (int old = 0; old < kPoints; ++old) {
      const M same = present & (contact.id[k] == as_int(old_id[old]));
      impulses.normal[k] = select(same, old_impulse[old], impulses.normal[k]);
      matched = matched | same;
    }
  }
  const V3 old_tangent_1 = tangent_of(old_normal);
  const V3 old_tangent_2 = cross(old_normal, old_tangent_1);
  const V3 old_friction = friction_1 * old_tangent_1 + friction_2 * old_tangent_2;
  impulses.friction_1 = select(matched, dot(old_friction, tangent_1), zero);
  impulses.friction_2 = select(matched, dot(old_friction, tangent_2), zero);
  impulses.twist = select(matched, twist * dot(old_normal, normal), zero);
  impulses.rolling = matched & ((as_int(info) & I(kManifoldRich)) == I(kManifoldRich));
  return impulses;
}

// Surfaces that touch in a point would spin on it for ever. Real surfaces deform and touch in a disk. Its
// radius is sqrt(R d) for a radius of curvature R and a deformation d. Under Hertz's pressure, friction in
// the disk acts at a mean arm of 3 pi / 16 of that radius (Johnson, "Contact Mechanics", 1985, 7.4). d is the
// slop, or a share of R if that is less.
inline constexpr float kPatchArm = 0.58904862f;  // 3 pi / 16
inline constexpr float kPatchDepthShare = 0.02f;
// A material may specify the radius itself.
inline F twist_arm(const MaterialRow* materials, const Block& block, M has_patch, F curvature_radius) {
  const F depth = min(F(kLinearSlop), F(kPatchDepthShare) * curvature_radius);
  const F automatic = F(kPatchArm) * sqrt(curvature_radius * depth);
  if (bits(has_patch) == 0) return automatic;
  const float* rows = reinterpret_cast<const float*>(materials);
  constexpr int kStride = sizeof(MaterialRow) / sizeof(float);
  F x, y, z, patch_1, patch_2;
  load_rows(rows + 4, kStride, block.shape_1, x, y, z, patch_1);
  load_rows(rows + 4, kStride, block.shape_2, x, y, z, patch_2);
  const F given = max(patch_1, patch_2);
  return select(has_patch, F(kPatchArm) * given, automatic);
}

// Average of the points, weighted by closeness: a point that appears at the speculative distance has almost
// no weight, so the center moves continuously with the separations.
struct FrictionCenter {
  V3 place;
  F separation;
};
template <int kPoints>
FrictionCenter friction_center(const WideContact<kPoints>& contact, F reach) {
  if constexpr (kPoints == 1) {
    return {contact.point[0], contact.separation[0]};
  } else {
    constexpr float kLeastWeight = 1e-3f * kLinearSlop;  // m; keeps the sum above zero
    F total(0.0f), separation(0.0f);
    V3 sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < kPoints; ++k) {
      const F closeness = max(reach - contact.separation[k], F(kLeastWeight));
      const F weight = select(contact.id[k] > I(0), closeness, F(0.0f));
      total += weight;
      sum = sum + weight * contact.point[k];
      separation += weight * contact.separation[k];
    }
    const F share = F(1.0f) / max(total, F(kLeastWeight));
    return {sum * share, separation * share};
  }
}

// Half the thickness of shapes. For hulls it is the radius of the inner ball, because their thinnest part may
// lie askew.
inline F thinness(const CollideColumns& columns, const std::int32_t* shape, F of_others) {
  alignas(64) float lanes[kLanes];
  store(lanes, of_others);
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int32_t slot = columns.shape_hull != nullptr ? columns.shape_hull[shape[lane]] : -1;
    if (slot >= 0) lanes[lane] = columns.hulls[slot]->inner_radius;
  }
  return load(lanes);
}
// Finds contacts ahead with fixed shapes that the body will only graze. Floors consist of pieces: the side of
// the next piece would stop a body that slides over a seam. The sides of the two overlap in a strip as thin
// as the body has sunk in. Where points touch instead of faces, the direction of motion decides.
inline constexpr float kStrip = 2.0f * kLinearSlop;  // m
template <int kPoints>
M grazes_ahead(const CollideColumns& columns, const Block& block, const WideContact<kPoints>& contact,
               V3 normal) {
  const M fixed = (block.flags & I(kItemFixed)) == I(kItemFixed);
  F nearest = contact.separation[0];
  for (int k = 1; k < kPoints; ++k) nearest = min(contact.separation[k], nearest);
  const M ahead = fixed & (nearest > F(kSpeculativeDistance)) & (nearest < F(0.5f * kAbsentSeparation));
  if (!any(ahead)) return never();
  const V3 velocity = relative_velocity(columns, block);
  const M leads_past = square(dot(velocity, normal)) < F(0.5f) * length_squared(velocity);
  if constexpr (kPoints < kMaxManifoldPoints) {
    return ahead & leads_past;
  } else {
    return ahead & (contact.in_strip | (contact.at_edges & leads_past));
  }
}

// Writes the rare part of one contact, whose manifold is written. In collide.cpp.
void store_rich_surface(const CollideColumns& columns, const CollideItem& item, float restitution,
                        float rolling_resistance, bool keep_rolling);
inline void store_rich_surfaces(const CollideColumns& columns, const CollideItem* items,
                                const std::int32_t* which, const Block& block, const WideSurface& surface,
                                M rich, M keep_rolling) {
  const std::uint32_t rich_lanes = bits(rich), rolling_lanes = bits(keep_rolling);
  alignas(64) float restitution[kLanes], rolling_resistance[kLanes];
  store(restitution, surface.restitution);
  store(rolling_resistance, surface.rolling_resistance);
  for (int lane = 0; lane < block.count; ++lane) {
    if ((rich_lanes >> lane & 1u) == 0) continue;
    store_rich_surface(columns, items[which[lane]], restitution[lane], rolling_resistance[lane],
                       (rolling_lanes >> lane & 1u) != 0);
  }
}

// Stores the poses of the bodies of a new manifold.
inline void store_anchor(const CollideColumns& columns, const Block& block, M flip, F is_set,
                         const F (&separation)[kMaxManifoldPoints]) {
  const WidePose body_1 = load_pose(columns.body_pose, block.body_1);
  const WidePose body_2 = load_pose(columns.body_pose, block.body_2);
  const Q4 a = select(flip, body_2.rotation, body_1.rotation),
           b = select(flip, body_1.rotation, body_2.rotation);
  const V3 offset = body_2.position - body_1.position;
  const V3 a_to_b = select(flip, -offset, offset);
  float* rows = reinterpret_cast<float*>(columns.anchor);
  constexpr int kStride = sizeof(ContactAnchor) / sizeof(float);
  store_rows(rows, kStride, block.row, block.count, a.x, a.y, a.z, a.w);
  store_rows(rows + 4, kStride, block.row, block.count, b.x, b.y, b.z, b.w);
  store_rows(rows + 8, kStride, block.row, block.count, a_to_b.x, a_to_b.y, a_to_b.z, is_set);
  store_rows(rows + 12, kStride, block.row, block.count, separation[0], separation[1], separation[2],
             separation[3]);
}

// Completes contacts and writes their rows. `kRound`: the surfaces are round where there are two points at
// most.
template <int kPoints, bool kRound = (kPoints < kMaxManifoldPoints)>
void store_contacts(const CollideColumns& columns, const CollideItem* items, const std::int32_t* which,
                    const Block& block, V3 position_1, F reach, const WideContact<kPoints>& contact) {
  const F zero(0.0f);
  const M flip = (block.flags & I(kItemFlip)) == I(kItemFlip);
  const V3 normal = select(flip, -contact.normal, contact.normal);
  const V3 tangent_1 = tangent_of(normal);
  const V3 tangent_2 = cross(normal, tangent_1);
  const FrictionCenter friction = friction_center(contact, reach);
  const V3 center = friction.place;

  const V3 arm_1 = center - (load_position(columns.body_pose, block.body_1) - position_1);
  const V3 arm_2 = center - (load_position(columns.body_pose, block.body_2) - position_1);
  const V3 arm_a = select(flip, arm_2, arm_1), arm_b = select(flip, arm_1, arm_2);
  const I body_1 = load(block.body_1), body_2 = load(block.body_2);
  const M fixed = (block.flags & I(kItemFixed)) == I(kItemFixed);
  const I row_a = select(fixed, I(kFixedRow), select(flip, body_2, body_1));
  const I row_b = select(flip, body_1, body_2);

  const WideSurface surface = mix_materials(columns.shape_material, block);
  const M grazes = grazes_ahead(columns, block, contact, normal) & !(surface.restitution > zero);
  F u[kMaxManifoldPoints], v[kMaxManifoldPoints], separation[kMaxManifoldPoints], id[kMaxManifoldPoints];
  I count(0);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    u[k] = zero;
    v[k] = zero;
    separation[k] = F(kAbsentSeparation);
    id[k] = zero;
    if (k >= kPoints) continue;
    const M present = (contact.id[k] > I(0)) & !grazes;
    const V3 from_center = contact.point[k] - center;
    u[k] = select(present, dot(from_center, tangent_1), zero);
    v[k] = select(present, dot(from_center, tangent_2), zero);
    separation[k] = select(present, contact.separation[k], F(kAbsentSeparation));
    id[k] = as_float(select(present, contact.id[k], I(0)));
    count = count + count_if(present);
  }

  if constexpr (kRound) {
    const M is_round = kPoints < kMaxManifoldPoints ? !never() : count < I(kTwistArm);
    const F arm = twist_arm(columns.shape_material, block, surface.has_patch, contact.curvature_radius);
    const F half_gap = F(0.5f) * friction.separation;
    const F core_1 = contact.radius_1 + half_gap, core_2 = contact.radius_2 + half_gap;
    v[kTwistArm] = select(is_round, arm, v[kTwistArm]);
    u[kCoreA] = select(is_round, select(flip, core_2, core_1), u[kCoreA]);
    u[kCoreB] = select(is_round, select(flip, core_1, core_2), u[kCoreB]);
  }

  const WideImpulses impulses = match_impulses(columns, block, contact, normal, tangent_1, tangent_2);
  const M touches = count > I(0);
  const M rich =
      touches & ((surface.restitution > zero) | (surface.rolling_resistance > zero) | surface.moves);
  const M is_static = (block.flags & I(kItemStatic)) == I(kItemStatic);
  const I info =
      count | select(rich, I(kManifoldRich), I(0)) | select(touches & is_static, I(kManifoldStatic), I(0));

  float* rows = reinterpret_cast<float*>(columns.manifold);
  constexpr int kStride = sizeof(Manifold) / sizeof(float);
  const auto write = [&](int group, F x, F y, F z, F w) {
    store_rows(rows + 4 * group, kStride, block.row, block.count, x, y, z, w);
  };
  write(0, normal.x, normal.y, normal.z, surface.friction);
  write(1, arm_a.x, arm_a.y, arm_a.z, as_float(row_a));
  write(2, arm_b.x, arm_b.y, arm_b.z, as_float(row_b));
  write(3, u[0], u[1], u[2], u[3]);
  write(4, v[0], v[1], v[2], v[3]);
  write(5, separation[0], separation[1], separation[2], separation[3]);
  write(6, impulses.normal[0], impulses.normal[1], impulses.normal[2], impulses.normal[3]);
  write(7, impulses.friction_1, impulses.friction_2, impulses.twist, as_float(info));
  store_rows(reinterpret_cast<float*>(columns.features), sizeof(ManifoldFeatures) / sizeof(float), block.row,
             block.count, id[0], id[1], id[2], id[3]);

  if constexpr (kPoints > 1) {
    // Where smooth shapes roll their manifold is new in every step.
    const M rolls = kRound && kPoints == kMaxManifoldPoints ? count < I(kTwistArm) : never();
    store_anchor(columns, block, flip, select(rich | rolls, F(0.0f), F(1.0f)), separation);
  }
  alignas(64) std::int32_t counts[kLanes];
  store(counts, count);
  for (int lane = 0; lane < block.count; ++lane) {
    columns.points[block.row[lane]] = static_cast<std::uint8_t>(counts[lane]);
  }
  if (any(rich)) store_rich_surfaces(columns, items, which, block, surface, rich, impulses.rolling);
}

// Collides items in two rounds. Pair::may_touch drops the separated pairs and may leave a hint for each other
// pair. Pair::collide then makes the contacts of the remaining pairs, so that lanes stay full. A pair's
// result does not depend on its lane.
template <class Pair>
void collide_pairs(const CollideColumns& columns, const CollideItem* items, int count) {
  alignas(64) std::int32_t kept[kCollideChunk + kLanes];
  alignas(64) std::int32_t kept_hint[kCollideChunk + kLanes];
  int kept_count = 0;
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    I hint(0);
    const std::uint32_t near = bits(Pair::may_touch(load_pair(columns, block), hint));
    alignas(64) std::int32_t hints[kLanes];
    store(hints, hint);
    for (int lane = 0; lane < lanes; ++lane) {
      if ((near >> lane & 1u) != 0) {
        kept[kept_count] = which[lane];
        kept_hint[kept_count++] = hints[lane];
      } else {
        columns.points[block.row[lane]] = 0;
      }
    }
  }
  if (kept_count == 0) return;
  for (int lane = 0; lane < kLanes; ++lane) {
    kept[kept_count + lane] = kept[kept_count - 1];
    kept_hint[kept_count + lane] = kept_hint[kept_count - 1];
  }
  for (int begin = 0; begin < kept_count; begin += kLanes) {
    const int lanes = kept_count - begin < kLanes ? kept_count - begin : kLanes;
    Block block;
    load_block(items, kept + begin, lanes, block);
    const WidePair pair = load_pair(columns, block);
    typename Pair::Contact contact;
    Pair::collide(pair, load(kept_hint + begin), contact);
    store_contacts(columns, items, kept + begin, block, pair.first.position, pair.reach, contact);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
