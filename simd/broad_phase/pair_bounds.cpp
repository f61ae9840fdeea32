// Computes bounds of shapes, lane = shape: poses of bodies -> poses and fat bounds of shapes. Called by
// update_bounds.
//
// The search for pairs uses fat bounds. They contain the shape, half of the speculative distance (the other
// shape of a pair adds the other half), and a margin for slow bodies. While no shape leaves its fat bounds,
// the list of pairs stays complete.
#include <simd/broad_phase/pair_kernels.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// m; two shapes slightly farther apart than this cause no new list for four steps.
constexpr float kMargin = 0.05f;
// A body gets the margin if this many of its steps fit into it. Faster bodies cause a new list anyway, and
// the margin would only add pairs that never touch.
constexpr float kStepsInMargin = 4.0f;
// Of StepMotion::turn: more than the error of a product of two rotations.
constexpr float kTurnRounding = 1e-6f;
// Relative to the largest coordinate: eight units in the last place, more than the sum of the rounding errors
// of a box's corners, of its center and of the comparison of spheres.
constexpr float kRounding = 1e-6f;
constexpr float kLargestFloat = 3.402823466e38f;
// m; squares of larger distances are not finite. A shape beyond this counts as lost.
constexpr float kFarthest = 1e18f;

struct Lanes {
  alignas(64) std::int32_t shape[kLanes];
  alignas(64) std::int32_t body[kLanes];
  alignas(64) std::int32_t type[kLanes];
  alignas(64) std::int32_t body_type[kLanes];
};

// Later lanes repeat the last shape and are not stored.
void read_lanes(const BoundsTask& task, int begin, int end, Lanes& lanes) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int32_t shape = task.list[begin + lane < end ? begin + lane : end - 1];
    lanes.shape[lane] = shape;
    lanes.body[lane] = task.shape_body[shape];
    lanes.type[lane] = task.shape_type[shape];
    lanes.body_type[lane] = task.body_type[lanes.body[lane]];
  }
}

const float* floats(const void* rows) { return static_cast<const float*>(rows); }
float* floats(void* rows) { return static_cast<float*>(rows); }

struct Placement {
  V3 position;
  Q4 rotation;
};
Placement load_placement(const PoseRow* rows, const std::int32_t* index) {
  Placement p;
  F padding;
  load_rows(floats(rows), 8, index, p.position.x, p.position.y, p.position.z, padding);
  load_rows(floats(rows) + 4, 8, index, p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w);
  return p;
}

F largest(V3 v) { return max(max(v.x, v.y), v.z); }
V3 abs(V3 v) { return {abs(v.x), abs(v.y), abs(v.z)}; }
M no_farther(V3 a, V3 b) { return (a.x <= b.x) & (a.y <= b.y) & (a.z <= b.z); }
V3 spread(F a) { return {a, a, a}; }
V3 min(V3 a, V3 b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
V3 max(V3 a, V3 b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }

struct BodyMotion {
  V3 linear, angular;
};
BodyMotion load_motion(const BoundsTask& task, const Lanes& lanes) {
  BodyMotion v;
  F padding_0, padding_1;
  load_rows(floats(task.body_velocity), 8, lanes.body, v.linear.x, v.linear.y, v.linear.z, v.angular.x);
  load_rows(floats(task.body_velocity) + 4, 8, lanes.body, v.angular.y, v.angular.z, padding_0, padding_1);
  return v;
}

// An empty box overlaps nothing.
void make_empty(M where, V3& lower, V3& upper, F& radius) {
  lower = select(where, spread(F(kLargestFloat)), lower);
  upper = select(where, spread(F(-kLargestFloat)), upper);
  radius = select(where, F(0.0f), radius);
}

// A box about a shape's place in the world, and balls that hold it: one about that place, which the shape may
// turn about, and one about the box's center.
struct Extent {
  V3 reach;
  V3 middle;  // of the box, relative to the shape's place
  F radius, radius_about_middle;
};

// Of a cylinder or a cone, whose axis is the second one. Along each axis of the world a disk reaches as far
// as its radius times the sine between that and its own axis.
void take_round(M cylinder, M cone, M3 axes, V3 half, Extent& extent) {
  const V3 rim{sqrt(axes.x.x * axes.x.x + axes.z.x * axes.z.x) * half.x,
               sqrt(axes.x.y * axes.x.y + axes.z.y * axes.z.y) * half.x,
               sqrt(axes.x.z * axes.x.z + axes.z.z * axes.z.z) * half.x};
  const V3 top = axes.y * half.y;
  const V3 upper = max(top, rim - top), lower = min(top, spread(F(0.0f)) - rim - top);
  const V3 middle = (upper + lower) * F(0.5f), reach = (upper - lower) * F(0.5f);
  const M round = cylinder | cone;
  extent.reach = select(cone, reach, select(cylinder, abs(top) + rim, extent.reach));
  extent.middle = select(cone, middle, extent.middle);
  extent.radius = select(round, sqrt(half.x * half.x + half.y * half.y), extent.radius);
  extent.radius_about_middle = select(cone, min(length(reach), extent.radius + length(middle)),
                                      select(cylinder, extent.radius, extent.radius_about_middle));
}

// Every other shape is a box, perhaps flat, with a round skin; a hull or mesh is a box within a ball.
Extent extent_of(const BoundsTask& task, const Lanes& lanes, Q4 rotation) {
  V3 half;
  F skin;
  load_rows(floats(task.extent), 4, lanes.shape, half.x, half.y, half.z, skin);
  const I type = load(lanes.type);
  const M sphere = type == I(kBoundsSphere);
  const M capsule = type == I(kBoundsCapsule);
  const M skinned = sphere | capsule | (type == I(kBoundsRoundedBox));
  const M in_ball = (type == I(kBoundsHull)) | (type == I(kBoundsMesh)) | (type == I(kBoundsRoundedHull));
  const M cylinder = type == I(kBoundsCylinder), cone = type == I(kBoundsCone);
  const F ball = skin;
  half.x = select(sphere | capsule, F(0.0f), half.x);
  half.y = select(sphere, F(0.0f), half.y);
  half.z = select(sphere | capsule, F(0.0f), half.z);
  skin = select(skinned, skin, F(0.0f));
  const M3 axes = to_matrix(rotation);
  const V3 box_reach = abs(axes.x) * half.x + abs(axes.y) * half.y + abs(axes.z) * half.z;
  Extent extent;
  extent.reach = select(in_ball, min(box_reach, spread(ball)), box_reach) + spread(skin);
  extent.middle = spread(F(0.0f));
  extent.radius = select(in_ball, ball, length(half) + skin);
  extent.radius_about_middle = extent.radius;
  if (bits(cylinder | cone) != 0) take_round(cylinder, cone, axes, half, extent);
  return extent;
}

// From the place in its last pose, which the narrow phase has seen: where calls have changed a shape since,
// nothing is known (`force`). Fast shapes have points far ahead, so that no distance keeps them from being
// looked at.
void store_motion(const BoundsTask& task, const Lanes& lanes, int count, const Placement& now, M fast) {
  const Placement before = load_placement(task.shape_pose, lanes.shape);
  const V3 offset = now.position - before.position;
  const Q4 turn = conjugate(before.rotation) * now.rotation;
  const F chord = F(2.0f) * length({turn.x, turn.y, turn.z}) + F(kTurnRounding);
  constexpr float kInfinity = __builtin_huge_valf();
  const F bound = task.force ? F(kInfinity) : select(fast, F(kInfinity), chord);
  store_rows(floats(task.motion), 4, lanes.shape, count, offset.x, offset.y, offset.z, bound);
}

// Returns a bit for each lane with new fat bounds.
std::uint32_t update_lanes(const BoundsTask& task, const Lanes& lanes, int count) {
  const Placement body = load_placement(task.body_pose, lanes.body);
  const Placement local = load_placement(task.local_pose, lanes.shape);
  const V3 position = body.position + rotate(body.rotation, local.position);
  const Q4 rotation = body.rotation * local.rotation;
  const BodyMotion motion = load_motion(task, lanes);
  const V3 way = motion.linear * F(task.dt);
  const F travel = length(way);
  // Also false if the velocity is not finite.
  const M fast = (travel > F(kFastTravel)) & (travel <= F(kFarthest));
  store_motion(task, lanes, count, {position, rotation}, fast);
  store_rows(floats(task.shape_pose), 8, lanes.shape, count, position.x, position.y, position.z,
             select(fast, travel, F(0.0f)));
  store_rows(floats(task.shape_pose) + 4, 8, lanes.shape, count, rotation.x, rotation.y, rotation.z,
             rotation.w);

  const Extent own = extent_of(task, lanes, rotation);
  // A shape that turns far lies in a ball about its place, which grows by its arc, and in one about its
  // body's center.
  const F arm = own.radius + length(local.position);
  const F turn = length(motion.angular) * F(task.dt);
  const M whirls = (turn > F(kFastTurn)) & (turn * arm > F(kFastTravel)) & (arm <= F(kFarthest));
  const M circles = whirls & (turn > F(1.0f));
  const F outer = select(circles, arm,
                         select(whirls, own.radius + turn * length(local.position), own.radius_about_middle));
  const V3 center = select(circles, body.position, select(whirls, position, position + own.middle));

  const F pad = F(0.5f * kSpeculativeDistance) + F(kRounding) * (largest(abs(center)) + outer);
  const V3 extent = select(whirls, spread(outer), own.reach) + spread(pad);
  const V3 half_way = select(fast, way * F(0.5f), spread(F(0.0f)));
  const F sphere_radius = outer + pad + select(fast, F(0.5f) * travel, F(0.0f));
  const V3 middle = center + half_way;
  const V3 swept_extent = extent + abs(half_way);
  const V3 lower = middle - swept_extent, upper = middle + swept_extent;

  V3 fat_lower, fat_upper;
  F fat_radius, padding;
  float* fat = floats(task.fat_bounds);
  load_rows(fat, 8, lanes.shape, fat_lower.x, fat_lower.y, fat_lower.z, fat_radius);
  load_rows(fat + 4, 8, lanes.shape, fat_upper.x, fat_upper.y, fat_upper.z, padding);
  const V3 offset = middle - (fat_lower + fat_upper) * F(0.5f);
  const F slack = max(fat_radius - sphere_radius, F(0.0f));
  const M inside =
      no_farther(fat_lower, lower) & no_farther(upper, fat_upper) & (length_squared(offset) <= slack * slack);
  const V3 farthest = spread(F(kFarthest));
  const M finite =
      no_farther(abs(lower), farthest) & no_farther(abs(upper), farthest) & (sphere_radius <= F(kFarthest));
  // A shape without finite bounds has not left its fat bounds if these are empty already.
  const M empty = fat_lower.x > fat_upper.x;
  const M stays = (finite & inside) | ((!finite) & empty);
  const std::uint32_t valid = (1u << count) - 1u;
  const std::uint32_t left = (task.force ? ~0u : ~bits(stays)) & valid;
  if (left == 0) return 0;

  const F farthest_travel = (length(motion.linear) + length(motion.angular) * arm) * F(task.dt);
  const M slow =
      (farthest_travel * F(kStepsInMargin) <= F(kMargin)) & !(load(lanes.body_type) == I(kBoundsFixedBody));
  const F margin = select(slow, F(kMargin), F(0.0f));
  V3 new_lower = lower - spread(margin), new_upper = upper + spread(margin);
  F new_radius = sphere_radius + margin;
  make_empty(!finite, new_lower, new_upper, new_radius);
  const M renew = mask_from_bits(left);
  new_lower = select(renew, new_lower, fat_lower);
  new_upper = select(renew, new_upper, fat_upper);
  new_radius = select(renew, new_radius, fat_radius);
  store_rows(fat, 8, lanes.shape, count, new_lower.x, new_lower.y, new_lower.z, new_radius);
  store_rows(fat + 4, 8, lanes.shape, count, new_upper.x, new_upper.y, new_upper.z, F(0.0f));
  return left;
}

}  // namespace

int update_bounds(const BoundsTask& task, int begin, int end);
int update_bounds(const BoundsTask& task, int begin, int end) {
  int left = 0;
  Lanes lanes;
  for (int first = begin; first < end; first += kLanes) {
    read_lanes(task, first, end, lanes);
    const int count = end - first < kLanes ? end - first : kLanes;
    const std::uint32_t bits = update_lanes(task, lanes, count);
    left += __builtin_popcount(bits);
    if (task.left == nullptr) continue;
    for (int lane = 0; lane < count; ++lane) {
      task.left[first + lane] = static_cast<std::uint8_t>(bits >> lane & 1u);
    }
  }
  return left;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
