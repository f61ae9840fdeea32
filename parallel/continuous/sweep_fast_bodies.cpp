// Sweeps fast bodies, so that they do not pass through fixed and sleeping shapes in one step.
//
// Runs after the solver. A body is swept if it moved by more than a share of its inner radius, which is that
// of the largest ball about a shape's center within the shape. Balls within a shape stand for it
// (core/geometry/balls.h). The core of each ball, which is half as large, is cast from the beginning of the
// step to its end against the frozen trees. Where it meets a fixed or sleeping shape, the body is put back to
// where the whole ball meets it. It keeps its velocity for the contact of the next step.
//
// A body that is put back must move on in the next step, or it would hang there while its speed grows. So the
// contact handles an obstacle that a ball touches when the step begins; the sweep only keeps the shape's
// center out of it. The body loses only the part of its path that leads there: it goes on along the surface,
// and turns.
//
// A body that rests on an obstacle or slides along it never meets it with a core, at any speed.
#include <core/geometry/balls.h>
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/stages.h>

#include <cmath>

namespace scree {

namespace {

constexpr int kFastPerChunk = 8;
constexpr float kNever = 2.0f;  // times run from 0 to 1

// rad; a ball's arc counts as straight over this turn: it leaves its chord by 0.8 % of its arm at most.
constexpr float kStraightTurn = 0.25f;

const HullData& hull_of(const WorldData& data, std::int32_t shape) {
  return *data.hulls.data[data.shapes.hull[shape]];
}

// Distance of a point that moves along a line from a convex shape, negative within, its slope by time, and
// the unit vector by which it grows; both are zero within boxes. Along a line it is a convex function: a
// tangent never overestimates it.
struct Distance {
  float value, slope;
  Vec3 normal;
};

Distance from_core(Vec3 way, Vec3 velocity, float radius) {
  const float far = length(way);
  if (!(far > 0.0f)) return {far - radius, 0.0f, {}};
  return {far - radius, dot(way, velocity) / far, (1.0f / far) * way};
}

Distance from_box(Vec3 point, Vec3 velocity, const float (&half)[3]) {
  const auto beyond = [](float x, float limit) {
    return x > limit ? x - limit : x < -limit ? x + limit : 0.0f;
  };
  const Vec3 way{beyond(point.x, half[0]), beyond(point.y, half[1]), beyond(point.z, half[2])};
  if (way != Vec3{}) return from_core(way, velocity, 0.0f);
  const float depth =
      std::min({half[0] - std::abs(point.x), half[1] - std::abs(point.y), half[2] - std::abs(point.z)});
  return {-depth, 0.0f, {}};
}

// What balls are swept against: shapes that they touch when the step begins, the others, or all.
enum class Against { touched, others, all };

// A point at `start` + t `motion` in the frame of an obstacle.
struct Path {
  Vec3 start, motion;
};

// The largest of three lower bounds: the planes', and, for sharp corners, those of the box and the sphere
// around the hull.
Distance from_hull(Vec3 point, Vec3 velocity, const HullData& hull, const ExtentRow& extent) {
  Distance best = from_core(point, velocity, hull.outer_radius);
  const auto take = [&best](Distance bound) { best = bound.value > best.value ? bound : best; };
  take(from_box(point, velocity, extent.half));
  for (int face = 0; face < hull.face_count; ++face) {
    const Vec3 normal{hull.normal[0][face], hull.normal[1][face], hull.normal[2][face]};
    take({dot(point, normal) - hull.offset[face], dot(velocity, normal), normal});
  }
  return best;
}

Distance distance_at(const WorldData& data, std::int32_t obstacle, const Path& path, float t) {
  const Vec3 point = path.start + t * path.motion;
  const ExtentRow& extent = data.shapes.extent[obstacle];
  switch (data.shapes.type[obstacle]) {
    case ShapeType::sphere:
      return from_core(point, path.motion, extent.radius);
    case ShapeType::capsule: {
      const float along = std::clamp(point.y, -extent.half[1], extent.half[1]);
      return from_core(point - Vec3{0.0f, along, 0.0f}, path.motion, extent.radius);
    }
    case ShapeType::hull:
      return from_hull(point, path.motion, hull_of(data, obstacle), extent);
    case ShapeType::box:
      break;
  }
  return from_box(point, path.motion, extent.half);
}

// When the path comes as near as `target`; kNever if it does not. Newton's method on a convex function comes
// nearer from one side, so no meeting is missed. Goes on from `t`, where `distance` has been found.
float first_within(const WorldData& data, std::int32_t obstacle, const Path& path, float target,
                   float tolerance, float t, Distance& distance) {
  constexpr int kIterations = 32;  // four or five are usual
  for (int i = 0; i < kIterations; ++i) {
    if (!(distance.slope < 0.0f)) return kNever;
    if (distance.value - target <= tolerance) return t;
    t += (target - distance.value) / distance.slope;
    if (!(t <= 1.0f)) return kNever;
    distance = distance_at(data, obstacle, path, t);
  }
  return kNever;
}

// The distance that a ball's center must keep.
struct Core {
  float distance, tolerance;  // m
};
Core core_of(const Path& path, float radius, float distance) {
  // A core that overlaps at the start may come nearer by a tenth of its center's distance.
  constexpr float kNearer = 0.9f;
  // Newton's method ends within these shares of the slop, the radius and the distance.
  constexpr float kSlopShare = 0.1f, kLengthShare = 0.02f;
  constexpr float kRounding = 1e-6f;  // of the path's coordinates: about eight units in the last place
  const float rounding = kRounding * (length(path.start) + length(path.motion));
  return {std::min(kCoreShare * radius, kNearer * distance),
          std::min({kSlopShare * kLinearSlop, kLengthShare * radius, kLengthShare * distance}) + rounding};
}

// Where a path meets an obstacle, from 0 to 1 along it, and the direction out of the obstacle. Of meetings at
// the same time the one with the smallest index counts.
struct Meeting {
  float time = kNever;
  std::int32_t obstacle = -1;
  Vec3 normal{};
};
Meeting earlier(const Meeting& a, const Meeting& b) {
  return b.time < a.time || (b.time == a.time && b.obstacle < a.obstacle) ? b : a;
}

// When a ball meets the obstacle, if its core is to meet it as well; else kNever.
float meeting(const WorldData& data, std::int32_t obstacle, const Path& path, float radius) {
  Distance distance = distance_at(data, obstacle, path, 0.0f);
  if (!(distance.value > 0.0f)) return kNever;
  const Core core = core_of(path, radius, distance.value);
  float met = 0.0f;
  const bool overlaps = !(distance.value > radius);
  if (!overlaps) met = first_within(data, obstacle, path, radius, core.tolerance, 0.0f, distance);
  if (met == kNever) return kNever;
  const float core_met = first_within(data, obstacle, path, core.distance, core.tolerance, met, distance);
  return overlaps || core_met == kNever ? core_met : met;
}

// When a ball's core meets the obstacle that the ball touched when the step began, and the normal there, if
// it is to come deeper by the end of the step, `left` such paths later, than a contact leaves what it holds.
Meeting core_meeting(const WorldData& data, std::int32_t obstacle, const Path& path, float radius,
                     float left) {
  Distance distance = distance_at(data, obstacle, path, 0.0f);
  if (!(distance.value > 0.0f)) return {};
  const Core core = core_of(path, radius, distance.value);
  const float met = first_within(data, obstacle, path, core.distance, core.tolerance, 0.0f, distance);
  const float held = std::min(core.distance, radius - kLinearSlop);
  if (met == kNever || !(distance.value + (1.0f - met + left) * distance.slope < held)) return {};
  return {met, static_cast<std::int32_t>(obstacle), distance.normal};
}

// A box around what moves within a step.
struct Swept {
  float lower[3], upper[3];

  Swept(Vec3 start, Vec3 end, float radius)
      : lower{std::min(start.x, end.x) - radius, std::min(start.y, end.y) - radius,
              std::min(start.z, end.z) - radius},
        upper{std::max(start.x, end.x) + radius, std::max(start.y, end.y) + radius,
              std::max(start.z, end.z) + radius} {}
};

// A ball over a stretch of the step, which it began at `origin`.
struct Sweep {
  std::int32_t shape;
  Vec3 origin, start, end;
  float radius, left;  // m; stretches that follow
  Against against;
  Swept core;
};

bool meets(const Swept& box, const float (&bounds)[6][simd::kBlock], std::size_t lane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(box.lower[axis] <= bounds[axis + 3][lane] && bounds[axis][lane] <= box.upper[axis])) return false;
  }
  return true;
}

Meeting meeting_with(const WorldData& data, const Sweep& sweep, std::int32_t obstacle) {
  const std::int32_t body = data.shapes.body[obstacle];
  const bool rests =
      data.bodies.type[body] == BodyType::fixed || (data.bodies.flags[body] & kBodyAsleep) != 0;
  if (!rests || !may_collide(data, sweep.shape, obstacle)) return {};
  const PoseRow& pose = data.shapes.pose[obstacle];
  const Quat rotation = to_quat(pose.rotation);
  const auto place = [&](Vec3 point) { return rotate_back(rotation, point - to_vec3(pose.position)); };
  const float gap = distance_at(data, obstacle, {place(sweep.origin), {}}, 0.0f).value - sweep.radius;
  const bool touched = gap <= kLinearSlop;
  if (sweep.against != (touched ? Against::touched : Against::others) && sweep.against != Against::all)
    return {};
  const Path path{place(sweep.start), rotate_back(rotation, sweep.end - sweep.start)};
  if (!touched) return {meeting(data, obstacle, path, sweep.radius), obstacle};
  Meeting met = core_meeting(data, obstacle, path, sweep.radius, sweep.left);
  met.normal = rotate(rotation, met.normal);
  return met;
}

// Whether any shape of the tree is near.
bool is_near(const PairTree& tree, const Swept& box, int level, std::size_t block) {
  for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
    if (level < 0) {
      if (tree.leaves[block].shape[lane] >= 0 && meets(box, tree.leaves[block].bounds, lane)) return true;
    } else if (meets(box, tree.nodes[level][block].bounds, lane)) {
      if (is_near(tree, box, level - 1, block * simd::kBlock + lane)) return true;
    }
  }
  return false;
}

// The first meeting with a shape of the tree. It is a minimum, so the order of the tree does not matter.
Meeting first_meeting(const WorldData& data, const PairTree& tree, const Sweep& sweep, int level,
                      std::size_t block) {
  Meeting first;
  if (level < 0) {
    const simd::LeafBlock& leaf = tree.leaves[block];
    for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
      if (leaf.shape[lane] < 0 || !meets(sweep.core, leaf.bounds, lane)) continue;
      first = earlier(first, meeting_with(data, sweep, leaf.shape[lane]));
    }
    return first;
  }
  const simd::NodeBlock& node = tree.nodes[level][block];
  for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
    if (!meets(sweep.core, node.bounds, lane)) continue;
    first = earlier(first, first_meeting(data, tree, sweep, level - 1, block * simd::kBlock + lane));
  }
  return first;
}

// A body's motion in the step: along a straight way, while its long axis swings by the shorter way and the
// rest turns about that. So a stick that spins about itself goes where its axis does, and not around a cone
// into the ground.
struct Motion {
  Vec3 way;
  Quat swing, twist;  // twist first
};

Quat shorter(Quat q) { return q.w < 0.0f ? Quat{-q.x, -q.y, -q.z, -q.w} : q; }

// `axis`: a unit vector, or zero.
Motion motion_of(const DeltaRow& delta, Vec3 axis) {
  const Quat turn = to_quat(delta.rotation);
  const Vec3 about = dot({turn.x, turn.y, turn.z}, axis) * axis;
  const float size = dot(about, about) + turn.w * turn.w;
  // Below it the turn is half a turn about an axis normal to this one, where no twist is defined.
  constexpr float kLeastSize = 1e-12f;
  const Quat twist = size > kLeastSize ? normalize({about.x, about.y, about.z, turn.w}) : Quat{};
  return {to_vec3(delta.position), shorter(turn * Quat{-twist.x, -twist.y, -twist.z, twist.w}),
          shorter(twist)};
}

Quat part_of(Quat turn, float t) {
  return normalize({t * turn.x, t * turn.y, t * turn.z, 1.0f - t + t * turn.w});
}

// Up to time t.
DeltaRow part_of(const Motion& motion, float t) {
  DeltaRow part{};
  store(part.position, t * motion.way);
  store(part.rotation, part_of(motion.swing, t) * part_of(motion.twist, t));
  return part;
}

// A stretch of a body's motion.
struct Stretch {
  DeltaRow from, to;
  int left;  // stretches that follow
  Against against;
};

Sweep sweep_of(const PoseRow& pose, std::int32_t shape, Vec3 arm, float radius, const Stretch& stretch) {
  const auto place = [&](const DeltaRow& delta) {
    return to_vec3(pose.position) + to_vec3(delta.position) + rotate(to_quat(delta.rotation), arm);
  };
  const Vec3 start = place(stretch.from), end = place(stretch.to);
  return {shape,  to_vec3(pose.position) + arm,     start,           end,
          radius, static_cast<float>(stretch.left), stretch.against, {start, end, kCoreShare * radius}};
}

// Whether the body's motion may bring a core into something that its ball did not touch.
bool is_fast(const CoreRow& core, const DeltaRow& delta) {
  const Vec3 way = to_vec3(delta.position);
  if (dot(way, way) > core.radius * core.radius) return true;
  if (!(core.reach > 0.0f)) return false;
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  return length(way) + 2.0f * length(turn) * core.reach > core.radius;
}

// From a body's center of mass to a point of one of its shapes, as the step begins.
Vec3 arm_of(const WorldData& data, std::int32_t body, std::int32_t shape, Vec3 in_shape) {
  const PoseRow& local = data.shapes.local_pose[shape];
  const Vec3 in_body = to_vec3(local.position) + rotate(to_quat(local.rotation), in_shape);
  return rotate(to_quat(data.bodies.pose[body].rotation), in_body);
}

// The first meeting of one of the body's balls on a stretch of its motion, 0 to 1 along the stretch. `most`:
// balls of a shape that are looked at.
Meeting first_meeting_of(const WorldData& data, const BroadPhase& broad_phase, std::int32_t body,
                         const Stretch& stretch, int most = kMostBalls) {
  const PoseRow& pose = data.bodies.pose[body];
  Meeting first;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    const Balls balls = balls_of(data, shape);
    for (int i = 0; i < std::min(balls.count, most); ++i) {
      const Vec3 arm = arm_of(data, body, shape, balls.ball[i].center);
      const Sweep sweep = sweep_of(pose, shape, arm, balls.ball[i].radius, stretch);
      for (const PairTree& tree : obstacle_trees(broad_phase)) {
        if (tree.levels == 0) continue;
        first = earlier(first, first_meeting(data, tree, sweep, tree.levels - 1, 0));
      }
    }
  }
  return first;
}

// The axis of a body's least inertia as the step begins, which is that of a stick; zero where it has none.
Vec3 long_axis_of(const WorldData& data, std::int32_t body) {
  constexpr int kIterations = 4;  // for a stick, each leaves less than a tenth of the error
  const float* m = data.bodies.local_mass[body].inverse_inertia;  // xx, xy, xz, yy, yz, zz
  const float largest = std::max({m[0], m[3], m[5]});
  if (!(largest > 0.0f)) return {};
  const float scale = 1.0f / largest;
  const Vec3 x{m[0] * scale, m[1] * scale, m[2] * scale}, y{m[1] * scale, m[3] * scale, m[4] * scale},
      z{m[2] * scale, m[4] * scale, m[5] * scale};
  Vec3 axis = largest == m[0] ? x : largest == m[3] ? y : z;
  for (int i = 0; i < kIterations; ++i) {
    axis = {dot(x, axis), dot(y, axis), dot(z, axis)};
    axis = (1.0f / length(axis)) * axis;
  }
  return rotate(to_quat(data.bodies.pose[body].rotation), axis);
}

// Where the centers of a body's balls lie as the step begins.
struct Arms {
  Vec3 axis;            // long_axis_of()
  float reach = 0.0f;   // m, the largest distance from the center of mass
  float beside = 0.0f;  // m, from the axis
};

Arms arms_of(const WorldData& data, std::int32_t body) {
  Arms arms{long_axis_of(data, body)};
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    const Balls balls = balls_of(data, shape);
    for (int i = 0; i < balls.count; ++i) {
      const Vec3 arm = arm_of(data, body, shape, balls.ball[i].center);
      arms.reach = std::max(arms.reach, length(arm));
      arms.beside = std::max(arms.beside, length(arm - dot(arm, arms.axis) * arms.axis));
    }
  }
  return arms;
}

// So many that each ball's arc is nearly straight in each.
int stretches_of(const Motion& motion, const Arms& arms) {
  if (!(arms.reach > 0.0f)) return 1;
  const auto sine = [](Quat q) { return length(Vec3{q.x, q.y, q.z}); };
  const float turn = 2.0f * (sine(motion.swing) + sine(motion.twist) * (arms.beside / arms.reach));
  return 1 + static_cast<int>(turn / kStraightTurn);
}

// Takes from a body's way what would bring a shape's core into what the shape touches; whether there was
// such.
bool hold_centers(const WorldData& data, const BroadPhase& broad_phase, std::int32_t body, Vec3& way) {
  constexpr int kWalls = 3;
  Stretch straight{};
  straight.from.rotation[3] = straight.to.rotation[3] = 1.0f;
  straight.against = Against::touched;
  for (int wall = 0; wall <= kWalls; ++wall) {
    store(straight.to.position, way);
    const Meeting met = first_meeting_of(data, broad_phase, body, straight, 1);
    if (met.time == kNever) return wall > 0;
    // A body that three walls still stop stays there.
    const float inward = wall < kWalls ? std::min(dot(way, met.normal), 0.0f) : 0.0f;
    way = inward < 0.0f ? way - ((1.0f - met.time) * inward) * met.normal : met.time * way;
  }
  return true;
}

// The spin of a body that turned freely belongs to the pose at the end of its motion. At an earlier one it is
// the same in the body's axes: what a stick has about itself would not be along it otherwise, and a share of
// it would throw the stick about. That of a stick stays as it is about itself, however far it has turned so.
// (What has contacts is turned by finish_step, by as much as is left.)
void turn_spin_back(WorldData& data, std::int32_t body, const Motion& motion, const Arms& arms, float time) {
  constexpr float kSlender = 0.25f;
  const std::uint32_t flags = data.bodies.motion[body].flags;
  const bool turned_freely = (flags & std::uint32_t{kMotionGyroscopic}) != 0 &&
                             (flags & std::uint32_t{kMotionLocksMask}) == 0 &&
                             (data.bodies.step_notes[body] & kHasContacts) == 0;
  if (!turned_freely) return;
  const bool slender = arms.beside < kSlender * arms.reach;
  const Quat whole = slender ? motion.swing : motion.swing * motion.twist;
  const Quat part = part_of(motion.swing, time) * (slender ? Quat{} : part_of(motion.twist, time));
  float(&spin)[3] = data.bodies.velocity[body].angular;
  store(spin, rotate(part * Quat{-whole.x, -whole.y, -whole.z, whole.w}, to_vec3(spin)));
}

// Returns whether the body was put back.
//
// What a body touches when the step begins is its contact's business: it turns about the point of contact,
// while the motion that is swept turns about the center and would dip into the ground in every step anew.
// Only the center of a shape must not get to the other side, where the contact would push it on.
bool sweep_body(WorldData& data, const BroadPhase& broad_phase, std::int32_t body) {
  DeltaRow& delta = data.bodies.delta[body];
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  if (!is_finite(to_vec3(delta.position)) || !is_finite(turn) || !std::isfinite(delta.rotation[3]))
    return false;  // finish_step restores it
  const Vec3 start = to_vec3(data.bodies.pose[body].position);
  const Swept box(start, start + to_vec3(delta.position), data.bodies.core[body].size);
  const auto trees = obstacle_trees(broad_phase);
  if (std::none_of(trees.begin(), trees.end(), [&](const PairTree& tree) {
        return tree.levels > 0 && is_near(tree, box, tree.levels - 1, 0);
      })) {
    return false;
  }
  const Arms arms = arms_of(data, body);
  Motion motion = motion_of(delta, arms.axis);
  const int stretches = stretches_of(motion, arms);
  const auto time_of = [&](int stretch) {
    return static_cast<float>(stretch) / static_cast<float>(stretches);
  };
  const bool held = hold_centers(data, broad_phase, body, motion.way);
  if (held) store(delta.position, motion.way);
  DeltaRow from = part_of(motion, 0.0f);
  for (int i = 0; i < stretches; ++i) {
    const DeltaRow to = part_of(motion, time_of(i + 1));
    const Against against = i == 0 ? Against::others : Against::all;
    const float first =
        first_meeting_of(data, broad_phase, body, {from, to, stretches - 1 - i, against}).time;
    if (first <= 1.0f) {
      const float time = time_of(i) + first * (time_of(i + 1) - time_of(i));
      turn_spin_back(data, body, motion, arms, time);
      delta = part_of(motion, time);
      return true;
    }
    from = to;
  }
  return held;
}

}  // namespace

void sweep_fast_bodies(WorldData& data, Crew& crew) {
  if (!data.settings.continuous) return;
  BroadPhase& broad_phase = broad_phase_of(data);
  const Bodies& bodies = data.bodies;
  const auto body_at = [&](std::int32_t place) { return bodies.awake[place]; };
  list_where(
      crew, bodies.awake.size(), broad_phase.fast_counts, broad_phase.fast,
      [&](std::int32_t place) { return is_fast(bodies.core[body_at(place)], bodies.delta[body_at(place)]); },
      [&](std::int32_t place) { return bodies.awake[place]; });
  const int count = static_cast<int>(broad_phase.fast.size());
  if (count == 0) return;
  broad_phase.fast_hits.resize_discarding(count);
  crew.run_ranges(count, kFastPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const bool hit = sweep_body(data, broad_phase, broad_phase.fast[i]);
      broad_phase.fast_hits[i] = hit ? 1 : 0;
    }
  });
  data.stats.swept_bodies = count;
  data.stats.sweep_hits =
      std::count(broad_phase.fast_hits.begin(), broad_phase.fast_hits.end(), std::uint8_t{1});
}

}  // namespace scree
