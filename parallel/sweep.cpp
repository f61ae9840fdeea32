// Sweeps: bodies that move far in one step do not pass through what rests.
//
// After the solver, a body whose motion exceeds a share of its inner radius (that of the largest ball about a
// shape's center within the shape) is swept. A shape stands for balls that lie within it (core/balls.h). Of
// each ball the core, which is half as large, is cast from the step's beginning to its end against the frozen
// tree. Where it would meet a fixed or sleeping shape, the body is put back to where the ball meets it. It
// keeps its velocity, and the next step's contact takes it.
//
// A body that rests on something or slides along it never meets it with a core, however fast it is. What
// holds the center of a ball when the step begins is left to its contact.
#include <core/balls.h>
#include <core/edit.h>
#include <parallel/broad_phase.h>
#include <parallel/list_where.h>
#include <parallel/stages.h>

#include <cmath>

namespace scree {

namespace {

constexpr int kFastPerChunk = 8;
constexpr float kNever = 2.0f;  // times run from 0 to 1

// rad of turn that a ball's arc is taken for straight: it leaves its chord by 0.8 % of its arm at most.
constexpr float kStraightTurn = 0.25f;

const HullData& hull_of(const WorldData& data, std::size_t shape) {
  return *data.hulls.data[static_cast<std::size_t>(data.shapes.hull[shape])];
}

// Distance of a point that moves along a line from a convex shape, negative within, and its slope by time.
// Along a line it is a convex function: a tangent never overestimates it.
struct Distance {
  float value, slope;
};

Distance from_core(Vec3 way, Vec3 velocity, float radius) {
  const float far = length(way);
  return {far - radius, far > 0.0f ? dot(way, velocity) / far : 0.0f};
}

Distance from_box(Vec3 point, Vec3 velocity, const float (&half)[3]) {
  const auto beyond = [](float x, float limit) {
    return x > limit ? x - limit : x < -limit ? x + limit : 0.0f;
  };
  const Vec3 way{beyond(point.x, half[0]), beyond(point.y, half[1]), beyond(point.z, half[2])};
  if (way != Vec3{}) return from_core(way, velocity, 0.0f);
  const float depth =
      std::min({half[0] - std::abs(point.x), half[1] - std::abs(point.y), half[2] - std::abs(point.z)});
  return {-depth, 0.0f};
}

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
    take({dot(point, normal) - hull.offset[face], dot(velocity, normal)});
  }
  return best;
}

Distance distance_at(const WorldData& data, std::size_t obstacle, const Path& path, float t) {
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

// When a ball meets the obstacle, if its core is to meet it as well; else kNever. Where the obstacle overlaps
// the core already, the ball's center may come nearer to it by a share only. Newton's method on a convex
// function comes nearer from one side, so no meeting is missed.
float meeting(const WorldData& data, std::size_t obstacle, const Path& path, float radius, float ignored) {
  constexpr int kIterations = 32;  // four or five are usual
  constexpr float kNearer = 0.9f;
  Distance distance = distance_at(data, obstacle, path, 0.0f);
  if (!(distance.value > ignored)) return kNever;
  const float core = std::min(kCoreShare * radius, kNearer * distance.value);
  const float rounding = 1e-6f * (length(path.start) + length(path.motion));
  const float tolerance = std::min({0.1f * kLinearSlop, 0.02f * radius, 0.02f * distance.value}) + rounding;
  float target = distance.value > radius ? radius : core;
  float t = 0.0f, met = kNever;
  for (int i = 0; i < kIterations; ++i) {
    if (!(distance.slope < 0.0f)) return kNever;
    if (distance.value - target <= tolerance) {
      if (met == kNever) met = t;
      if (target == core) return met;
      target = core;
    } else {
      t += (target - distance.value) / distance.slope;
      if (!(t <= 1.0f)) return kNever;
      distance = distance_at(data, obstacle, path, t);
    }
  }
  return kNever;
}

// What moves within a step.
struct Swept {
  float lower[3], upper[3];

  Swept(Vec3 start, Vec3 end, float radius)
      : lower{std::min(start.x, end.x) - radius, std::min(start.y, end.y) - radius,
              std::min(start.z, end.z) - radius},
        upper{std::max(start.x, end.x) + radius, std::max(start.y, end.y) + radius,
              std::max(start.z, end.z) + radius} {}
};

// A ball over a stretch of the step.
struct Sweep {
  std::int32_t shape;
  Vec3 start, end;
  float radius;
  float ignored;  // m; what is no farther from the ball's center at the start is left to its contact
  Swept core;
};

bool meets(const Swept& box, const float (&bounds)[6][simd::kBlock], std::size_t lane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(box.lower[axis] <= bounds[axis + 3][lane] && bounds[axis][lane] <= box.upper[axis])) return false;
  }
  return true;
}

float meeting_with(const WorldData& data, const Sweep& sweep, std::int32_t obstacle) {
  const auto row = static_cast<std::size_t>(obstacle);
  const auto body = static_cast<std::size_t>(data.shapes.body[row]);
  const bool rests =
      data.bodies.type[body] == BodyType::fixed || (data.bodies.flags[body] & kBodyAsleep) != 0;
  if (!rests || !may_collide(data, sweep.shape, obstacle)) return kNever;
  const PoseRow& pose = data.shapes.pose[row];
  const Quat rotation = to_quat(pose.rotation);
  const Path path{rotate_back(rotation, sweep.start - to_vec3(pose.position)),
                  rotate_back(rotation, sweep.end - sweep.start)};
  return meeting(data, row, path, sweep.radius, sweep.ignored);
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
float first_meeting(const WorldData& data, const PairTree& tree, const Sweep& sweep, int level,
                    std::size_t block) {
  float first = kNever;
  if (level < 0) {
    const simd::LeafBlock& leaf = tree.leaves[block];
    for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
      if (leaf.shape[lane] < 0 || !meets(sweep.core, leaf.bounds, lane)) continue;
      first = std::min(first, meeting_with(data, sweep, leaf.shape[lane]));
    }
    return first;
  }
  const simd::NodeBlock& node = tree.nodes[level][block];
  for (std::size_t lane = 0; lane < simd::kBlock; ++lane) {
    if (!meets(sweep.core, node.bounds, lane)) continue;
    first = std::min(first, first_meeting(data, tree, sweep, level - 1, block * simd::kBlock + lane));
  }
  return first;
}

// The part of a motion up to time t: by a straight way and a turn about one axis.
DeltaRow part_of(const DeltaRow& delta, float t) {
  Quat turn = to_quat(delta.rotation);
  if (turn.w < 0.0f) turn = {-turn.x, -turn.y, -turn.z, -turn.w};
  DeltaRow part{};
  store(part.position, t * to_vec3(delta.position));
  store(part.rotation, normalize({t * turn.x, t * turn.y, t * turn.z, 1.0f - t + t * turn.w}));
  return part;
}

Sweep sweep_of(const PoseRow& pose, std::int32_t shape, Vec3 arm, float radius, float ignored,
               const DeltaRow& from, const DeltaRow& to) {
  const auto place = [&](const DeltaRow& delta) {
    return to_vec3(pose.position) + to_vec3(delta.position) + rotate(to_quat(delta.rotation), arm);
  };
  const Vec3 start = place(from), end = place(to);
  return {shape, start, end, radius, ignored, {start, end, kCoreShare * radius}};
}

// Whether the body's motion may bring a core into something that its ball did not touch.
bool is_fast(const CoreRow& core, const DeltaRow& delta) {
  const Vec3 way = to_vec3(delta.position);
  if (dot(way, way) > core.radius * core.radius) return true;
  if (!(core.reach > 0.0f)) return false;
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  return length(way) + 2.0f * length(turn) * core.reach > core.radius;
}

// The first meeting of one of the body's balls on a stretch of its motion, 0 to 1 along the stretch.
// `starts`: it is the first one. A corner that touches when the step begins is its contact's business: it
// turns about the point of contact, while the motion that is swept turns about the center and would dip into
// the ground in every step anew.
float first_meeting_of(const WorldData& data, const BroadPhase& broad_phase, std::size_t body,
                       const DeltaRow& from, const DeltaRow& to, bool starts) {
  const PoseRow& pose = data.bodies.pose[body];
  float first = kNever;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0;
       shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
    const auto row = static_cast<std::size_t>(shape);
    const PoseRow& local = data.shapes.local_pose[row];
    const Balls balls = balls_of(data, row);
    for (int i = 0; i < balls.count; ++i) {
      const Vec3 in_body = to_vec3(local.position) + rotate(to_quat(local.rotation), balls.ball[i].center);
      const Vec3 arm = rotate(to_quat(pose.rotation), in_body);
      const float radius = balls.ball[i].radius;
      const bool in_contact = starts && i > 0;
      const float ignored = in_contact ? radius + kLinearSlop : 0.0f;
      const Sweep sweep = sweep_of(pose, shape, arm, radius, ignored, from, to);
      for (const PairTree& tree : broad_phase.resting_trees()) {
        if (tree.levels == 0) continue;
        first = std::min(first, first_meeting(data, tree, sweep, tree.levels - 1, 0));
      }
    }
  }
  return first;
}

// Returns whether the body was put back.
bool sweep_body(WorldData& data, const BroadPhase& broad_phase, std::size_t body) {
  DeltaRow& delta = data.bodies.delta[body];
  const Vec3 turn{delta.rotation[0], delta.rotation[1], delta.rotation[2]};
  if (!is_finite(to_vec3(delta.position)) || !is_finite(turn) || !std::isfinite(delta.rotation[3]))
    return false;  // finish_step restores it
  const Vec3 start = to_vec3(data.bodies.pose[body].position);
  const Swept box(start, start + to_vec3(delta.position), data.bodies.core[body].size);
  const auto trees = broad_phase.resting_trees();
  if (std::none_of(trees.begin(), trees.end(), [&](const PairTree& tree) {
        return tree.levels > 0 && is_near(tree, box, tree.levels - 1, 0);
      })) {
    return false;
  }
  const bool turns = data.bodies.core[body].reach > 0.0f;
  const int stretches = turns ? 1 + static_cast<int>(2.0f * length(turn) / kStraightTurn) : 1;
  const auto time_of = [&](int stretch) {
    return static_cast<float>(stretch) / static_cast<float>(stretches);
  };
  DeltaRow from = part_of(delta, 0.0f);
  for (int i = 0; i < stretches; ++i) {
    const DeltaRow to = part_of(delta, time_of(i + 1));
    const float first = first_meeting_of(data, broad_phase, body, from, to, i == 0);
    if (first <= 1.0f) {
      delta = part_of(delta, time_of(i) + first * (time_of(i + 1) - time_of(i)));
      return true;
    }
    from = to;
  }
  return false;
}

}  // namespace

void sweep_fast_bodies(WorldData& data, Crew& crew) {
  if (!data.settings.continuous) return;
  BroadPhase& broad_phase = broad_phase_of(data);
  const Bodies& bodies = data.bodies;
  const auto body_at = [&](std::size_t place) { return static_cast<std::size_t>(bodies.awake[place]); };
  list_where(
      crew, bodies.awake.size(), broad_phase.fast_counts, broad_phase.fast,
      [&](std::size_t place) { return is_fast(bodies.core[body_at(place)], bodies.delta[body_at(place)]); },
      [&](std::size_t place) { return bodies.awake[place]; });
  const int count = static_cast<int>(broad_phase.fast.size());
  if (count == 0) return;
  broad_phase.fast_hits.resize_discarding(static_cast<std::size_t>(count));
  crew.run_ranges(count, kFastPerChunk, [&](int begin, int end, int) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const bool hit = sweep_body(data, broad_phase, static_cast<std::size_t>(broad_phase.fast[i]));
      broad_phase.fast_hits[i] = hit ? 1 : 0;
    }
  });
  data.stats.swept_bodies = count;
  data.stats.sweep_hits =
      std::count(broad_phase.fast_hits.begin(), broad_phase.fast_hits.end(), std::uint8_t{1});
}

}  // namespace scree
