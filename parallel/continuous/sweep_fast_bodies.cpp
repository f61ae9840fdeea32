// Sweeps fast bodies, so that they do not pass through fixed and sleeping shapes in one step.
//
// Runs after the solver. A body is swept if it moved by more than a share of its inner radius, which is that
// of the largest ball about a shape's center within the shape, and of a compound, that of its thinnest part;
// then each part is swept if it moved by more than that share of its own. Balls within a shape stand for it
// (core/geometry/balls.h). The core of each ball, which is half as large, is cast from the beginning of the
// step to its end against the frozen trees. Where it meets a fixed or sleeping shape, the body is put back to
// where the whole ball meets it. It keeps the velocity that it has there for the contact of the next step,
// and the time that it has not moved: see VelocityRow.
//
// A body that is put back must move on in the next step, or it would hang there while its speed grows. So the
// contact handles an obstacle that a ball touches when the step begins; the sweep only keeps the shape's
// center out of it. The body loses only the part of its path that leads there: it goes on along the surface,
// and turns.
//
// A body that rests on an obstacle or slides along it never meets it with a core, at any speed.
//
// Of bodies that ask for it, the shapes themselves are swept, too: see sweep_whole.cpp.
#include <core/geometry/balls.h>
#include <core/world/contact_hooks.h>
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/continuous/sweep_convex.h>
#include <parallel/continuous/sweep_motion.h>
#include <parallel/continuous/sweep_moving.h>
#include <parallel/continuous/sweep_near.h>
#include <parallel/continuous/sweep_whole.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/sweep_across.h>
#include <parallel/stages.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace scree {

namespace {

using namespace sweeps;

constexpr int kFastPerChunk = 8;

// rad; a ball's arc counts as straight over this turn: it leaves its chord by 0.8 % of its arm at most.
constexpr float kStraightTurn = 0.25f;

// Whether the shape may be stopped by the other one, which rests.
bool may_stop(const WorldData& data, std::int32_t shape, std::int32_t obstacle) {
  const std::int32_t body = data.shapes.body[obstacle];
  const bool rests =
      data.bodies.type[body] == BodyType::fixed || (data.bodies.flags[body] & kBodyAsleep) != 0;
  return rests && may_collide(data, shape, obstacle) &&
         !is_refused(data.hooks, {std::min(shape, obstacle), std::max(shape, obstacle)});
}

// `near`: as meeting_with_mesh().
Meeting meeting_with(const Obstacles& obstacles, const Sweep& sweep, std::int32_t obstacle,
                     const NearTriangles* near) {
  const WorldData& data = obstacles.data;
  if (!may_stop(data, sweep.shape, obstacle)) return {};
  const PoseRow& pose = data.shapes.pose[obstacle];
  if (data.shapes.type[obstacle] == ShapeType::mesh) {
    const MeshData& mesh = *data.meshes.data[data.shapes.mesh[obstacle]];
    return meeting_with_mesh(obstacles.kernels, mesh, pose, sweep, obstacle, near);
  }
  const Quat rotation = to_quat(pose.rotation);
  const auto place = [&](Vec3 point) { return rotate_back(rotation, point - to_vec3(pose.position)); };
  const ConvexObstacle convex{data, obstacle};
  const float gap = convex.distance_at({place(sweep.origin), {}}, 0.0f).value - sweep.radius;
  const bool touched = gap <= kLinearSlop;
  if (sweep.against != (touched ? Against::touched : Against::others) && sweep.against != Against::all)
    return {};
  const Path path{place(sweep.start), rotate_back(rotation, sweep.end - sweep.start)};
  if (!touched) return {meeting(convex, path, sweep.radius), obstacle};
  Meeting met = core_meeting(convex, path, sweep.radius, sweep.left);
  met.normal = rotate(rotation, met.normal);
  return met;
}

// The first meeting with a shape of the tree. It is a minimum, so the order of the tree does not matter.
Meeting first_meeting(const Obstacles& obstacles, const PairTree& tree, const Sweep& sweep, int level,
                      std::size_t block) {
  Meeting first;
  if (level < 0) {
    const simd::LeafBlock& leaf = tree.leaves[block];
    for (std::uint32_t met = lanes_met(sweep.core, leaf.bounds); met != 0; met &= met - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(met));
      if (leaf.shape[lane] < 0) continue;
      first = earlier(first, meeting_with(obstacles, sweep, leaf.shape[lane], nullptr));
    }
    return first;
  }
  const simd::NodeBlock& node = tree.nodes[level][block];
  const std::size_t blocks = blocks_below(tree, level);
  for (std::uint32_t met = lanes_met(sweep.core, node.bounds); met != 0; met &= met - 1) {
    const std::size_t child = block * simd::kBlock + static_cast<std::size_t>(std::countr_zero(met));
    if (child < blocks) first = earlier(first, first_meeting(obstacles, tree, sweep, level - 1, child));
  }
  return first;
}

// The first meeting of a body whose shapes are swept as they are. `near`: as first_meeting_of(); `radius`: m,
// about the center of mass around all of it.
Meeting first_whole_meeting(const Obstacles& obstacles, const NearShapes* near, std::int32_t body,
                            float radius) {
  const WorldData& data = obstacles.data;
  const Mover mover = mover_of(data, body, kNever);
  const Swept box(mover.start, mover.start + mover.motion.way, radius);
  Meeting first;
  const auto meet = [&](std::int32_t obstacle) {
    const std::int32_t other = data.shapes.body[obstacle];
    const Mover still{to_vec3(data.bodies.pose[other].position), {}, 0.0f};
    for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
      if (!may_stop(data, shape, obstacle)) continue;
      const float met = whole_meeting(data, obstacles.kernels, {shape, obstacle}, {mover, still}, 0.0f);
      first = earlier(first, {met, obstacle, {}});
    }
  };
  if (near != nullptr) {
    for (int k = 0; k < near->count; ++k) meet(near->row[k].shape);
    return first;
  }
  const auto meet_leaf = [&](const simd::LeafBlock& leaf, std::size_t lane) {
    meet(leaf.shape[lane]);
    return true;
  };
  for (const PairTree& tree : obstacle_trees(obstacles.broad_phase)) {
    if (tree.levels > 0) for_each_shape_near(tree, box, tree.levels - 1, 0, meet_leaf);
  }
  return first;
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

// Whether any of what is near the body is near the way of the shape's balls, which one about its center
// holds.
bool is_any_near(const Obstacles& obstacles, const NearShapes& near, std::int32_t body, std::int32_t shape,
                 const Stretch& stretch) {
  const WorldData& data = obstacles.data;
  const float radius = outer_radius_of(data, shape);
  const Vec3 arm = to_vec3(data.shapes.pose[shape].position) - to_vec3(data.bodies.pose[body].position);
  const Sweep sweep = sweep_of(data.bodies.pose[body], shape, arm, radius, stretch);
  const float room = rounding_of(sweep.start, sweep.end, length(arm) + radius);
  const Reach reach(sweep.start, sweep.end, radius + room);
  return std::any_of(near.row, near.row + near.count, [&](const NearShapes::Row& row) {
    if (!overlap(reach.box, row.bounds)) return false;
    const MeshData* mesh = mesh_of(data, row.shape);
    return mesh == nullptr || is_near_mesh(obstacles.kernels, *mesh, data.shapes.pose[row.shape],
                                           {reach.start, reach.end, reach.radius}, near.triangles_of(row));
  });
}

// The first meeting of one of the body's balls on a stretch of its motion, 0 to 1 along the stretch. `near`:
// all that is, or null where that is not known. `way`: m, the most that any ball moves in the step. `most`:
// balls of a shape that are looked at.
Meeting first_meeting_of(const Obstacles& obstacles, const NearShapes* near, std::int32_t body,
                         const Stretch& stretch, float way, int most = kMostBalls) {
  const WorldData& data = obstacles.data;
  const PoseRow& pose = data.bodies.pose[body];
  const std::int32_t first_shape = data.bodies.first_shape[body];
  const bool is_compound = first_shape >= 0 && data.shapes.next[first_shape] >= 0;
  Meeting first;
  for (std::int32_t shape = first_shape; shape >= 0; shape = data.shapes.next[shape]) {
    // The thicker parts of a compound need no sweep while they move little.
    const bool is_slow = way <= kCoreShare * inner_radius_of(data, shape);
    if (is_compound && is_slow && stretch.against != Against::touched) continue;
    if (near != nullptr && is_compound && !is_any_near(obstacles, *near, body, shape, stretch)) continue;
    Balls made;
    const Balls& balls = balls_at(data, shape, made);
    for (int i = 0; i < std::min(balls.count, most); ++i) {
      const Vec3 arm = arm_of(data, body, shape, balls.ball[i].center);
      const Sweep sweep = sweep_of(pose, shape, arm, balls.ball[i].radius, stretch);
      if (near != nullptr) {
        for (int k = 0; k < near->count; ++k) {
          const NearShapes::Row& row = near->row[k];
          if (!overlap(sweep.core, row.bounds)) continue;
          first = earlier(first, meeting_with(obstacles, sweep, row.shape, near->triangles_of(row)));
        }
        continue;
      }
      for (const PairTree& tree : obstacle_trees(obstacles.broad_phase)) {
        if (tree.levels == 0) continue;
        first = earlier(first, first_meeting(obstacles, tree, sweep, tree.levels - 1, 0));
      }
    }
  }
  return first;
}

// So many that each ball's arc is nearly straight in each.
int stretches_of(const WorldData& data, std::int32_t body, const Motion& motion) {
  constexpr float kSurely = 0.999f;  // as no ball turns by more than the body, but for rounding
  if (chord_of(motion) < kSurely * kStraightTurn) return 1;
  return 1 + static_cast<int>(turn_of(motion, arms_of(data, body)) / kStraightTurn);
}

// Takes from a body's way what would bring a shape's core into what the shape touches; whether there was
// such. `farthest`: m, as first_meeting_of().
bool hold_centers(const Obstacles& obstacles, const NearShapes* near, std::int32_t body, float farthest,
                  Vec3& way) {
  constexpr int kWalls = 3;
  Stretch straight{};
  straight.from.rotation[3] = straight.to.rotation[3] = 1.0f;
  straight.against = Against::touched;
  for (int wall = 0; wall <= kWalls; ++wall) {
    store(straight.to.position, way);
    // What has been held may leave the box.
    const Meeting met = first_meeting_of(obstacles, wall == 0 ? near : nullptr, body, straight, farthest, 1);
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
void turn_spin_back(WorldData& data, std::int32_t body, const Motion& motion, float time) {
  constexpr float kSlender = 0.25f;
  const std::uint32_t flags = data.bodies.motion[body].flags;
  const bool turned_freely = (flags & std::uint32_t{kMotionGyroscopic}) != 0 &&
                             (flags & std::uint32_t{kMotionLocksMask}) == 0 &&
                             (data.bodies.step_notes[body] & kHasContacts) == 0;
  if (!turned_freely) return;
  const Arms arms = arms_of(data, body);
  const bool slender = arms.beside < kSlender * arms.reach;
  const Quat whole = slender ? motion.swing : motion.swing * motion.twist;
  const Quat part = part_of(motion.swing, time) * (slender ? Quat{} : part_of(motion.twist, time));
  float(&spin)[3] = data.bodies.velocity[body].angular;
  store(spin, rotate(part * Quat{-whole.x, -whole.y, -whole.z, whole.w}, to_vec3(spin)));
}

// m/s^2, by gravity and the caller's forces.
Vec3 acceleration_of(const WorldData& data, std::int32_t body) {
  const float inverse_mass = data.bodies.local_mass[body].inverse_mass;
  if (!(inverse_mass > 0.0f)) return {};
  return free_linear(data.bodies.motion[body],
                     data.bodies.motion[body].gravity_factor * data.settings.gravity +
                         inverse_mass * to_vec3(data.bodies.force[body].force));
}

// The same of a body that has fallen freely in this step; zero for others.
Vec3 fall_of(const WorldData& data, std::int32_t body) {
  const bool is_free = !is_jointed(data, body) && (data.bodies.step_notes[body] & kHasContacts) == 0;
  return is_free ? acceleration_of(data, body) : Vec3{};
}

// A body whose last step ended early goes on for that time. It flies then, unless what it met still bears it:
// after an impact it rises. Returns the time, s, of a step at most.
float make_up(WorldData& data, std::int32_t body, float dt) {
  VelocityRow& velocity = data.bodies.velocity[body];
  const float lag = std::min(velocity.lag, dt);
  velocity.lag = 0.0f;
  DeltaRow& delta = data.bodies.delta[body];
  if (!(lag > 0.0f) || !has_finite_motion(delta) || is_jointed(data, body)) return 0.0f;
  // The solver's last sweep ignores locks.
  const MotionRow& motion = data.bodies.motion[body];
  const Vec3 linear = free_linear(motion, to_vec3(velocity.linear)),
             angular = free_angular(motion, to_vec3(velocity.angular));
  Vec3 fall = fall_of(data, body);
  if ((data.bodies.step_notes[body] & kHasContacts) != 0) {
    const Vec3 acceleration = acceleration_of(data, body);
    if (dot(linear, acceleration) < -dt * dot(acceleration, acceleration)) fall = acceleration;
  }
  store(delta.position, to_vec3(delta.position) + lag * (linear + (0.5f * lag) * fall));
  store(velocity.linear, to_vec3(velocity.linear) + lag * fall);
  const Vec3 half = (0.5f * lag) * angular;
  store(delta.rotation, normalize(Quat{half.x, half.y, half.z, 1.0f}) * to_quat(delta.rotation));
  return lag;
}

// The share of the step's time after which a falling body has come as far as a share of its way. It falls
// along a parabola, of which the way is the chord: with the acceleration a and the mean speed v along the
// way,
//   share = time - k time (1 - time),  k = a T / (2 v).
// Without this, a ball of 10 cm that bounces 5 m high at 30 Hz lost 1.2 % of its energy in 100 bounces.
float time_at(float share, Vec3 way, Vec3 acceleration, float step) {
  const float square = dot(way, way);
  if (!(square > 0.0f)) return share;
  const float k = 0.5f * step * step * dot(acceleration, way) / square;
  // Beyond this the body all but turns back within the step.
  constexpr float kMost = 0.5f;
  if (!(std::abs(k) < kMost)) return share;
  return 2.0f * share / ((1.0f - k) + std::sqrt((1.0f - k) * (1.0f - k) + 4.0f * k * share));
}

// Finds when the body meets what rests.
//
// What a body touches when the step begins is its contact's business: it turns about the point of contact,
// while the motion that is swept turns about the center and would dip into the ground in every step anew.
// Only the center of a shape must not get to the other side, where the contact would push it on.
void end_at_rest(WorldData& data, const Obstacles& obstacles, std::int32_t body, StepEnd& end) {
  DeltaRow& delta = data.bodies.delta[body];
  if (!has_finite_motion(delta)) return;  // finish_step restores it
  const bool is_whole = moves_whole(data, body);
  const float radius = swept_radius(data, body);
  const Reach reach = reach_of_way(data, body);
  const Vec3 start = reach.start, there = reach.end;
  NearShapes listed;
  list_near(obstacles, reach, Swept(start, there, radius), listed);
  if (!listed.any || listed.count == 0) return;
  Motion motion = motion_of(delta, long_axis_of(data, body));
  const int stretches = stretches_of(data, body, motion);
  if (!is_whole) drop_far_triangles(data, body, motion, stretches, reach, listed);
  if (listed.count == 0) return;
  const NearShapes* near = listed.too_many ? nullptr : &listed;
  const auto time_of = [&](int stretch) {
    return static_cast<float>(stretch) / static_cast<float>(stretches);
  };
  const float farthest = farthest_way(data.bodies.core[body], delta);
  const Vec3 way = motion.way;
  if (hold_centers(obstacles, near, body, farthest, motion.way)) {
    near = nullptr;
    end.held = true;
    store(delta.position, motion.way);
    pay_for_height(data, body, way - motion.way);
  }
  DeltaRow from = part_of(motion, 0.0f);
  for (int i = 0; i < stretches && end.time == kNever; ++i) {
    const DeltaRow to = part_of(motion, time_of(i + 1));
    const Against against = i == 0 ? Against::others : Against::all;
    const Meeting first =
        first_meeting_of(obstacles, near, body, {from, to, stretches - 1 - i, against}, farthest);
    if (first.time <= 1.0f) {
      end.time = time_of(i) + first.time * (time_of(i + 1) - time_of(i));
      end.rebounds = may_rebound(data, body, first.obstacle);
    }
    from = to;
  }
  if (!is_whole) return;
  const Meeting first = first_whole_meeting(obstacles, near, body, radius);
  if (!(first.time < end.time)) return;
  end.time = first.time;
  end.rebounds = may_rebound(data, body, first.obstacle);
}

// Puts the body back to where its step ends. What carries it on does so as far as nothing at rest is in the
// way.
void stop_body(WorldData& data, const Obstacles& obstacles, std::int32_t body, const StepEnd& end, float dt) {
  DeltaRow& delta = data.bodies.delta[body];
  const Motion motion = motion_of(delta, long_axis_of(data, body));
  turn_spin_back(data, body, motion, end.time);
  delta = part_of(motion, end.time);
  const Vec3 carried = free_linear(data.bodies.motion[body], end.carried);
  if (carried != Vec3{}) {
    DeltaRow there = delta;
    store(there.position, to_vec3(delta.position) + carried);
    constexpr float kAnyWay = std::numeric_limits<float>::infinity();
    const float met =
        first_meeting_of(obstacles, nullptr, body, {delta, there, 0, Against::all}, kAnyWay).time;
    store(delta.position, to_vec3(delta.position) + std::min(met, 1.0f) * carried);
  }
  VelocityRow& velocity = data.bodies.velocity[body];
  const Vec3 fall = fall_of(data, body);
  const float step = dt + end.lag;
  const float left = (1.0f - time_at(end.time, motion.way, fall, step)) * step;
  // Its velocity is that of the end of the step.
  store(velocity.linear, to_vec3(velocity.linear) - left * fall);
  pay_for_height(data, body, (1.0f - end.time) * motion.way);
  // What is carried far is where it would be if it had been taken along from its impact.
  const bool is_carried = dot(carried, carried) > kLinearSlop * kLinearSlop;
  if (end.rebounds && !is_carried && !is_jointed(data, body)) velocity.lag = left;
}

}  // namespace

void sweep_fast_bodies(WorldData& data, float dt, Crew& crew) {
  if (!data.settings.continuous) return;
  BroadPhase& broad_phase = broad_phase_of(data);
  note_fast_kinematic_bodies(data, dt);
  const Bodies& bodies = data.bodies;
  const Border* const border = border_of(data);
  list_where(
      crew, bodies.awake.size(), broad_phase.fast_counts, broad_phase.fast,
      [&](std::int32_t place) {
        const std::int32_t body = bodies.awake[place];
        if (border != nullptr && !border->owns(body)) return false;
        return (bodies.step_notes[body] & (kIsFast | kLags)) != 0 ||
               is_fast(bodies.core[body], bodies.delta[body]) ||
               (is_swept_whole(data, body) && moves_far(data, body));
      },
      [&](std::int32_t place) { return bodies.awake[place]; });
  const Column<std::int32_t>& fast = broad_phase.fast;
  SweepAcross across(data, broad_phase, crew);
  if (!across.share_fast()) {
    // A pile that has settled keeps no memory for the time when all of it fell.
    constexpr std::size_t kFew = 65536;  // bytes
    if (broad_phase.courses.capacity_bytes() > kFew) broad_phase.courses = {};
    return;
  }
  Column<StepEnd>& ends = broad_phase.step_ends;
  ends.resize_discarding(fast.size());
  const Obstacles obstacles{data, broad_phase, crew.kernels().query};
  const auto run = [&](auto&& work) {
    crew.run_ranges(static_cast<int>(fast.size()), kFastPerChunk,
                    [&](int begin, int end, int) { work(begin, end); });
  };
  run([&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t body = fast[i];
      ends[i] = {.lag = make_up(data, body, dt)};
      if (is_swept_whole(data, body) && moves_far(data, body))
        data.bodies.step_notes[body] |= std::uint8_t{kMovesWhole};
    }
  });
  list_chases(data, broad_phase, dt, crew);
  across.bring_chains();
  hold_at_moving(data, broad_phase);
  across.return_ways();
  across.bring_sleepers();
  const auto is_own = [&](std::int32_t body) { return border == nullptr || border->owns(body); };
  run([&](int begin, int end) {
    // Bodies that were made together, as those of a ragdoll, are often near each other.
    if (are_free(obstacles,
                 fast.span().subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin))))
      return;
    for (int i = begin; i < end; ++i) {
      if (is_own(fast[i])) end_at_rest(data, obstacles, fast[i], ends[i]);
    }
  });
  across.send_ends();
  end_at_moving(data, broad_phase, crew);
  across.return_ends();
  across.bring_sleepers_to_carried();
  run([&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (is_own(fast[i]) && ends[i].time <= 1.0f) stop_body(data, obstacles, fast[i], ends[i], dt);
    }
  });
  across.share_ends();
  for (std::size_t i = 0; i < fast.size(); ++i) {
    if (!is_own(fast[i])) continue;
    ++data.stats.swept_bodies;
    data.stats.sweep_hits += ends[i].time <= 1.0f || ends[i].held ? 1 : 0;
  }
}

}  // namespace scree
