// Fast bodies that meet others that move; see sweep_moving.h.
//
// A pair of shapes is looked at if both bodies move and one of them is fast against the other: the list of
// pairs has all whose ways come near each other, at the velocities that the step began with. The balls of
// each shape (core/geometry/balls.h) are followed in the frame of the other one, where their ways are bent,
// so these are halved until they are straight.
//
// Meetings act in the order of time, over all bodies. Fast bodies that meet stop there together, and fast
// bodies that have yet to meet one of them meet it where it stands. A slow or kinematic body moves on, and
// carries what it has stopped. What touches when the step begins is the contact's business.
#include <core/geometry/balls.h>
#include <core/world/contact_hooks.h>
#include <core/world/edit.h>
#include <parallel/continuous/sweep_clear.h>
#include <parallel/continuous/sweep_convex.h>
#include <parallel/continuous/sweep_mesh.h>
#include <parallel/continuous/sweep_moving.h>
#include <parallel/continuous/sweep_whole.h>
#include <parallel/crew/list_where.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace scree::sweeps {

namespace {

constexpr int kPairsPerChunk = 16, kCoursesPerChunk = 64;

// Of a ball's radius, and m (kMostBend), by which its way may leave the chord that is swept. The ball stops
// so much ahead of the obstacle: where it overlapped, its contact would be soft, and let 4 % of its speed
// through. A way is halved so often at most.
constexpr float kBend = 0.05f;
constexpr int kMostHalvings = 20;

// The point of a body that is at `point` at the time of `delta`, as the step begins.
Vec3 place_back(const Mover& mover, const DeltaRow& delta, Vec3 point) {
  return mover.start + rotate_back(to_quat(delta.rotation), point - mover.start - to_vec3(delta.position));
}
// The other way round.
Vec3 place_forth(const Mover& mover, const DeltaRow& delta, Vec3 point) {
  return mover.start + to_vec3(delta.position) + rotate(to_quat(delta.rotation), point - mover.start);
}

// A ball of a shape that moves against another shape.
struct BallAgainst {
  const WorldData& data;
  const simd::QueryKernels& kernels;
  const Mover& mover;
  const Mover& other;
  std::int32_t shape, obstacle;
  const ObstacleBox& box;
  Vec3 arm;                // from the mover's center to the ball's, as the step begins
  float radius, reach;     // m, of the ball, and of the obstacle about its origin
  float rate, other_rate;  // rad per step, of the bodies, at most

  // Where the ball is when the bodies have moved so far, in the frame in which the obstacle stays where the
  // step begins.
  Vec3 center_after(const DeltaRow& delta, const DeltaRow& other_delta) const {
    const Vec3 center = mover.start + to_vec3(delta.position) + rotate(to_quat(delta.rotation), arm);
    return place_back(other, other_delta, center);
  }
  Vec3 center_at(float t) const { return center_after(mover.delta_at(t), other.delta_at(t)); }
};

// m, by which the ball's way leaves the chord between two moments: an eighth of the largest acceleration
// times the squared time. In the obstacle's frame, which turns by w, a ball at x that moves by v, while its
// arm r turns by u, has at most the acceleration u^2 r + 2 w (v + u r) + w^2 x. It is at `a` and `b` then.
// In between, x exceeds what it is there by the bend of the arm r at most. `most` is the bend with that. The
// usual one is without: the slop about the ball around the obstacle is larger, and chords are short.
struct Bend {
  float usual, most;  // m
};
Bend bend_of(const BallAgainst& ball, float from, float to, Vec3 a, Vec3 b) {
  const float farthest = std::max(length(a - ball.other.start), length(b - ball.other.start));
  const bool stands = ball.mover.stands_at(from), other_stands = ball.other.stands_at(from);
  const float u = stands ? 0.0f : ball.rate, w = other_stands ? 0.0f : ball.other_rate,
              arm = length(ball.arm);
  const Vec3 way =
      (stands ? Vec3{} : ball.mover.motion.way) - (other_stands ? Vec3{} : ball.other.motion.way);
  const float acceleration = u * u * arm + 2.0f * w * (length(way) + u * arm) + w * w * farthest;
  const float time = to - from, bend = 0.125f * acceleration * time * time;
  return {bend, bend * (1.0f + 0.125f * w * w * time * time)};
}

float distance_to_chord(Vec3 point, Vec3 from, Vec3 to) {
  const Vec3 chord = to - from;
  const float square = dot(chord, chord);
  const float part = square > 0.0f ? std::clamp(dot(point - from, chord) / square, 0.0f, 1.0f) : 0.0f;
  return length(from + part * chord - point);
}

// When a ball that moves along a chord comes as near to the obstacle as `bend`, 0 to 1.
float meeting_on_chord(const BallAgainst& ball, Vec3 from, Vec3 to, float bend) {
  const WorldData& data = ball.data;
  const PoseRow& pose = data.shapes.pose[ball.obstacle];
  if (data.shapes.type[ball.obstacle] == ShapeType::mesh) {
    const MeshData& mesh = *data.meshes.data[data.shapes.mesh[ball.obstacle]];
    const Sweep sweep{ball.shape,
                      from,
                      from,
                      to,
                      ball.radius + bend,
                      0.0f,
                      Against::others,
                      {from, to, kCoreShare * ball.radius}};
    return meeting_with_mesh(ball.kernels, mesh, pose, sweep, ball.obstacle, nullptr).time;
  }
  const Quat rotation = to_quat(pose.rotation);
  const Path path{rotate_back(rotation, from - to_vec3(pose.position)), rotate_back(rotation, to - from)};
  const ConvexObstacle obstacle{data, ball.obstacle};
  Distance distance = obstacle.distance_at(path, 0.0f);
  if (!(distance.value > 0.0f)) return kNever;
  const float tolerance = core_of(path, ball.radius, distance.value).tolerance;
  return first_within(obstacle, path, ball.radius + bend + tolerance, tolerance, 0.0f, distance);
}

// When the ball touches the obstacle between two moments, at which it is at `a` and `b`.
float meeting_between(const BallAgainst& ball, float from, float to, Vec3 a, Vec3 b, int halvings) {
  const auto [bend, most_bend] = bend_of(ball, from, to, a, b);
  const Vec3 origin = to_vec3(ball.data.shapes.pose[ball.obstacle].position);
  if (distance_to_chord(origin, a, b) > ball.reach + ball.radius + kLinearSlop + bend) return kNever;
  if (stays_beside(ball.box, a, b, ball.radius + most_bend)) return kNever;
  if (bend <= std::min(kBend * ball.radius, kMostBend) || halvings == 0) {
    const float met = meeting_on_chord(ball, a, b, bend);
    return met <= 1.0f ? from + met * (to - from) : kNever;
  }
  const float middle = 0.5f * (from + to);
  const Vec3 center = ball.center_at(middle);
  const float first = meeting_between(ball, from, middle, a, center, halvings - 1);
  return first <= 1.0f ? first : meeting_between(ball, middle, to, center, b, halvings - 1);
}

// Whether the ball touches the obstacle as the step begins; meshes, whose triangles are asked one by one, it
// never does.
bool touches_at_start(const BallAgainst& ball) {
  const WorldData& data = ball.data;
  if (data.shapes.type[ball.obstacle] == ShapeType::mesh) return false;
  const PoseRow& pose = data.shapes.pose[ball.obstacle];
  const Vec3 center =
      rotate_back(to_quat(pose.rotation), ball.mover.start + ball.arm - to_vec3(pose.position));
  return ConvexObstacle{data, ball.obstacle}.distance_at({center, {}}, 0.0f).value - ball.radius <=
         kLinearSlop;
}

// Two shapes on their way from a moment to the end of the step.
struct Chase {
  const WorldData& data;
  const simd::QueryKernels& kernels;
  std::int32_t shape[2];
  Mover mover[2];
  Leg leg[2];
  float from;
};

// The first meeting of balls of one shape with the other one between `from` and the end of the step.
// `side`: whose balls. What touches as the step begins is its contact's business, and hold_at_moving's.
void meet_from_side(const Chase& chase, int side, float& first) {
  const WorldData& data = chase.data;
  const std::int32_t shape = chase.shape[side], obstacle = chase.shape[1 - side];
  const Leg &leg = chase.leg[side], &other = chase.leg[1 - side];
  Passage passage;
  if (stays_clear(data, shape, leg, obstacle, other, passage)) return;
  Balls made;
  const Balls& balls = balls_at(data, shape, made);
  const ObstacleBox box = box_about(data, obstacle, leg.start, other.start);
  const float reach = outer_radius_of(data, obstacle), from = chase.from;
  float to = 1.0f;
  DeltaRow there = leg.to, other_there = other.to;  // at that time
  for (int i = 0; i < balls.count; ++i) {
    if (first < to) {
      to = first;
      there = chase.mover[side].delta_at(to);
      other_there = chase.mover[1 - side].delta_at(to);
    }
    if (!(from < to)) return;
    if (stays_clear(passage, balls.ball[i])) continue;
    const BallAgainst ball{data,
                           chase.kernels,
                           chase.mover[side],
                           chase.mover[1 - side],
                           shape,
                           obstacle,
                           box,
                           arm_of(data, data.shapes.body[shape], shape, balls.ball[i].center),
                           balls.ball[i].radius,
                           reach,
                           leg.rate,
                           other.rate};
    const Vec3 a = ball.center_after(leg.from, other.from), b = ball.center_after(there, other_there);
    // The distance is asked for before the halvings only where it may be that of a touch.
    const Vec3 center = ball.mover.start + ball.arm;
    const bool may_touch = !stays_beside(box, center, center, ball.radius);
    if (may_touch && touches_at_start(ball)) continue;
    first = std::min(first, meeting_between(ball, from, to, a, b, kMostHalvings));
  }
}

// When the shapes of the pair meet after `from`. `stops`: when their bodies stop.
float meeting_of(const WorldData& data, const simd::QueryKernels& kernels, const MovingPair& pair,
                 const Course& a, const Course& b, float from, const float (&stops)[2]) {
  Chase chase{data,
              kernels,
              {pair.shape[0], pair.shape[1]},
              {a.mover, b.mover},
              {leg_of(a, stops[0], from), leg_of(b, stops[1], from)},
              from};
  for (int side = 0; side < 2; ++side) chase.mover[side].stop = stops[side];
  float first = kNever;
  if (!stay_parted(data, pair.shape, chase.leg)) {
    for (int side = 0; side < 2; ++side) meet_from_side(chase, side, first);
  }
  if (is_swept_whole(data, data.shapes.body[pair.shape[0]]) ||
      is_swept_whole(data, data.shapes.body[pair.shape[1]]))
    first = std::min(first, whole_meeting(data, kernels, pair.shape, chase.mover, from));
  return first;
}

// Whether a kinematic body goes farther than the world's limit lets any that it would take along.
bool leaps(const WorldData& data, std::int32_t body, float dt) {
  const Bodies& bodies = data.bodies;
  return bodies.type[body] == BodyType::kinematic &&
         !(length(to_vec3(bodies.delta[body].position)) <= data.settings.max_linear_speed * dt);
}

// Whether both bodies of a pair move, and one of them is fast.
bool is_chase(const WorldData& data, std::int32_t a, std::int32_t b, float dt) {
  const Bodies& bodies = data.bodies;
  if (((bodies.step_notes[a] | bodies.step_notes[b]) & kIsFast) == 0) return false;
  for (const std::int32_t body : {a, b}) {
    if (bodies.type[body] == BodyType::fixed || (bodies.flags[body] & kBodyAsleep) != 0) return false;
    if (!has_finite_motion(bodies.delta[body]) || leaps(data, body, dt)) return false;
  }
  return true;
}

// Whether one of two shapes may pass through the other in this step: the way is longer than the sum of their
// inner radii. After a shorter one their centers are still on their sides, as a contact needs them. Such ways
// are common in a collapsing pile: sweeping those that are half as long took half of the step. Not by
// the inner radii of the bodies, which are those of the thinnest parts: sweeps of a pile of wheels took twice
// as long so.
bool may_pass(const WorldData& data, ShapePair pair, float dt) {
  const Bodies& bodies = data.bodies;
  const std::int32_t a = data.shapes.body[pair.a], b = data.shapes.body[pair.b];
  if (!is_chase(data, a, b, dt)) return false;
  if (((bodies.step_notes[a] | bodies.step_notes[b]) & kMovesWhole) != 0) return true;
  const auto turn = [&](std::int32_t body) {
    return farthest_way(bodies.core[body], bodies.delta[body]) - length(to_vec3(bodies.delta[body].position));
  };
  const Vec3 way = to_vec3(bodies.delta[a].position) - to_vec3(bodies.delta[b].position);
  const float inner = inner_radius_of(data, pair.a) + inner_radius_of(data, pair.b);
  return length(way) + std::max(0.0f, turn(a) + turn(b)) > inner;
}

// Whether `a` comes after `b`. Of what happens at one time, ends at rest come first, then pairs in their
// order.
bool is_later(const Meet& a, const Meet& b) {
  return std::tie(a.time, a.pair, a.place) > std::tie(b.time, b.pair, b.place);
}

// Lists the pairs of each body, in their order.
void list_by_place(BroadPhase& broad_phase) {
  const Column<MovingPair>& pairs = broad_phase.meeting_pairs;
  Column<std::int32_t>&begins = broad_phase.meets_begin, &of = broad_phase.meets_of;
  begins.resize_discarding(broad_phase.fast.size() + 1);
  std::fill(begins.begin(), begins.end(), 0);
  for (const MovingPair& pair : pairs) {
    for (const std::int32_t place : pair.place) {
      if (place >= 0) ++begins[place];
    }
  }
  std::int32_t total = 0;
  for (std::int32_t& begin : begins) {
    total += begin;
    begin = total;
  }
  of.resize_discarding(total);
  for (std::int32_t k = static_cast<std::int32_t>(pairs.size()); k-- > 0;) {
    for (const std::int32_t place : pairs[k].place) {
      if (place >= 0) of[--begins[place]] = k;
    }
  }
}

// Takes meetings in the order of time.
class Agenda {
 public:
  Agenda(const WorldData& data, BroadPhase& broad_phase, const simd::QueryKernels& kernels)
      : data_(data),
        kernels_(kernels),
        fast_(broad_phase.fast),
        pairs_(broad_phase.meeting_pairs),
        courses_(broad_phase.courses),
        ends_(broad_phase.step_ends),
        stop_(broad_phase.stop_times),
        begin_(broad_phase.meets_begin),
        of_(broad_phase.meets_of),
        meets_(broad_phase.meets) {
    stop_.resize_discarding(fast_.size());
    std::fill(stop_.begin(), stop_.end(), kNever);
    meets_.clear();
    for (std::int32_t k = 0; std::cmp_less(k, pairs_.size()); ++k) {
      if (broad_phase.meeting_times[k] <= 1.0f) push({broad_phase.meeting_times[k], k, -1, 0});
    }
    for (std::int32_t place = 0; std::cmp_less(place, fast_.size()); ++place) {
      const float time = ends_[place].time;
      if (time <= 1.0f && begin_[place] < begin_[place + 1]) push({time, -1, place, 0});
    }
  }
  void run() {
    while (!meets_.empty()) {
      std::pop_heap(meets_.begin(), meets_.end(), is_later);
      const Meet next = meets_.back();
      meets_.pop_back();
      if (next.pair < 0) {
        if (has_stopped(next.place)) continue;
        stop_[next.place] = next.time;
        meet_again(next.place, next.time);
      } else if (next.stopped == stopped_of(pairs_[next.pair])) {
        meet(pairs_[next.pair], next.time);
      }
    }
  }

 private:
  void push(const Meet& meet) {
    meets_.push_back(meet);
    std::push_heap(meets_.begin(), meets_.end(), is_later);
  }
  bool has_stopped(std::int32_t place) const { return place >= 0 && stop_[place] <= 1.0f; }
  int stopped_of(const MovingPair& pair) const {
    return (has_stopped(pair.place[0]) ? 1 : 0) + (has_stopped(pair.place[1]) ? 1 : 0);
  }
  void meet(const MovingPair& pair, float time) {
    for (int side = 0; side < 2; ++side) {
      const std::int32_t place = pair.place[side];
      if (place < 0 || has_stopped(place)) continue;
      ends_[place].time = time;
      ends_[place].rebounds = may_rebound(data_, fast_[place], pair.shape[1 - side]);
      if (pair.place[1 - side] < 0) ends_[place].carried = carried_by(pair.shape[1 - side], place, time);
    }
    const bool stops[2] = {pair.place[0] >= 0 && !has_stopped(pair.place[0]),
                           pair.place[1] >= 0 && !has_stopped(pair.place[1])};
    for (int side = 0; side < 2; ++side) {
      if (stops[side]) stop_[pair.place[side]] = time;
    }
    for (int side = 0; side < 2; ++side) {
      if (stops[side]) meet_again(pair.place[side], time);
    }
  }
  // How far a body that moves on takes the one that it has stopped.
  Vec3 carried_by(std::int32_t shape, std::int32_t place, float time) const {
    const Mover carrier = mover_of(data_, data_.shapes.body[shape], kNever),
                carried = mover_of(data_, fast_[place], kNever);
    const Vec3 there = carried.start + to_vec3(carried.delta_at(time).position);
    return place_forth(carrier, carrier.delta_at(1.0f), place_back(carrier, carrier.delta_at(time), there)) -
           there;
  }
  // Fast bodies that have not stopped may meet the one that has where it stands.
  void meet_again(std::int32_t place, float time) {
    for (std::int32_t i = begin_[place]; i < begin_[place + 1]; ++i) {
      const std::int32_t k = of_[i];
      const MovingPair& pair = pairs_[k];
      if (pair.place[0] < 0 || pair.place[1] < 0 || stopped_of(pair) == 2) continue;
      const float stops[2] = {stop_[pair.place[0]], stop_[pair.place[1]]};
      const float again =
          meeting_of(data_, kernels_, pair, courses_[pair.place[0]], courses_[pair.place[1]], time, stops);
      if (again <= 1.0f) push({again, k, -1, 1});
    }
  }

  const WorldData& data_;
  const simd::QueryKernels& kernels_;
  const Column<std::int32_t>& fast_;
  const Column<MovingPair>& pairs_;
  const Column<Course>& courses_;
  Column<StepEnd>& ends_;
  Column<float>& stop_;  // by place; kNever: not yet
  const Column<std::int32_t>& begin_;
  const Column<std::int32_t>& of_;
  Column<Meet>& meets_;
};

// Takes from a body's way what would bring its shape's center to the other side of a shape that the shape
// touches and that moves, too; see hold_centers() in sweep_fast_bodies.cpp.
void hold_pair(WorldData& data, const MovingPair& pair, Column<StepEnd>& ends) {
  if (starts_clear(data, pair.shape[0], pair.shape[1])) return;
  for (int side = 0; side < 2; ++side) {
    const std::int32_t shape = pair.shape[side], obstacle = pair.shape[1 - side];
    if (data.shapes.type[obstacle] == ShapeType::mesh) continue;  // from behind, all pass
    const std::int32_t body = data.shapes.body[shape], other = data.shapes.body[obstacle];
    Balls made;
    const Balls& balls = balls_at(data, shape, made);
    if (balls.count == 0) continue;
    const float radius = balls.ball[0].radius;
    DeltaRow& delta = data.bodies.delta[body];
    DeltaRow& other_delta = data.bodies.delta[other];
    const Vec3 way = to_vec3(delta.position) - to_vec3(other_delta.position);
    const Vec3 center =
        to_vec3(data.bodies.pose[body].position) + arm_of(data, body, shape, balls.ball[0].center);
    const PoseRow& pose = data.shapes.pose[obstacle];
    const Quat rotation = to_quat(pose.rotation);
    const Path path{rotate_back(rotation, center - to_vec3(pose.position)), rotate_back(rotation, way)};
    const ConvexObstacle convex{data, obstacle};
    if (convex.distance_at(path, 0.0f).value - radius > kLinearSlop) continue;
    const Meeting met = core_meeting(convex, path, radius, 0.0f);
    if (met.time == kNever) continue;
    const Vec3 normal = rotate(rotation, met.normal);
    const bool is_swept = pair.place[side] >= 0;
    const Vec3 back = free_linear(data.bodies.motion[is_swept ? body : other],
                                  ((1.0f - met.time) * std::max(-dot(way, normal), 0.0f)) * normal);
    DeltaRow& held = is_swept ? delta : other_delta;
    store(held.position, is_swept ? to_vec3(held.position) + back : to_vec3(held.position) - back);
    pay_for_height(data, is_swept ? body : other, is_swept ? -back : back);
    ends[pair.place[is_swept ? side : 1 - side]].held = true;
  }
}

}  // namespace

void note_fast_kinematic_bodies(WorldData& data, float dt) {
  Bodies& bodies = data.bodies;
  bool any = false;
  for (const std::int32_t body : bodies.kinematic) {
    if (!has_finite_motion(bodies.delta[body]) || leaps(data, body, dt)) continue;
    // Others that a slower one may pass are fast themselves. So a drum that turns slowly costs nothing.
    const CoreRow& core = bodies.core[body];
    if (!(farthest_way(core, bodies.delta[body]) > core.radius / kCoreShare)) continue;
    bodies.step_notes[body] |= std::uint8_t{kIsFast};
    any = true;
  }
  if (!any) return;
  const Column<ShapePair>& pairs = data.contacts.pairs.pair;
  const auto is_swung = [&](std::int32_t body) {
    return bodies.type[body] == BodyType::kinematic && (bodies.step_notes[body] & kIsFast) != 0;
  };
  // One at a time: a body may be in many pairs.
  for (const ShapePair pair : pairs) {
    const std::int32_t a = data.shapes.body[pair.a], b = data.shapes.body[pair.b];
    if (is_swung(a) && bodies.type[b] == BodyType::dynamic) bodies.step_notes[b] |= std::uint8_t{kIsFast};
    if (is_swung(b) && bodies.type[a] == BodyType::dynamic) bodies.step_notes[a] |= std::uint8_t{kIsFast};
  }
}

void list_chases(WorldData& data, BroadPhase& broad_phase, float dt, Crew& crew) {
  for (const std::int32_t body : broad_phase.fast) data.bodies.step_notes[body] |= std::uint8_t{kIsFast};
  const Column<ShapePair>& all = data.contacts.pairs.pair;
  list_where(
      crew, all.size(), broad_phase.places, broad_phase.meeting_pairs,
      [&](std::int32_t i) { return may_pass(data, all[i], dt) && !is_refused(data.hooks, all[i]); },
      [&](std::int32_t i) {
        const ShapePair pair = all[i];
        return MovingPair{{pair.a, pair.b},
                          {place_of(broad_phase.fast, data.shapes.body[pair.a]),
                           place_of(broad_phase.fast, data.shapes.body[pair.b])}};
      });
}

void hold_at_moving(WorldData& data, BroadPhase& broad_phase) {
  for (const MovingPair& pair : broad_phase.meeting_pairs) hold_pair(data, pair, broad_phase.step_ends);
}

void end_at_moving(WorldData& data, BroadPhase& broad_phase, Crew& crew) {
  const Column<MovingPair>& pairs = broad_phase.meeting_pairs;
  const auto count = static_cast<int>(pairs.size());
  if (count == 0) return;
  list_by_place(broad_phase);
  const Column<std::int32_t>&fast = broad_phase.fast, &begins = broad_phase.meets_begin;
  Column<Course>& courses = broad_phase.courses;
  courses.resize_discarding(fast.size());
  crew.run_ranges(static_cast<int>(fast.size()), kCoursesPerChunk, [&](int begin, int end, int) {
    for (int place = begin; place < end; ++place) {
      if (begins[place] < begins[place + 1]) courses[place] = course_of(data, fast[place]);
    }
  });
  Column<float>& times = broad_phase.meeting_times;
  times.resize_discarding(count);
  const simd::QueryKernels& kernels = crew.kernels().query;
  crew.run_ranges(count, kPairsPerChunk, [&](int begin, int end, int) {
    // The pairs of a body that is not swept are often next to each other.
    struct Unswept {
      std::int32_t body = -1;
      Course course{};
    } unswept[2];
    const auto course_at = [&](const MovingPair& pair, int side) -> const Course& {
      if (pair.place[side] >= 0) return courses[pair.place[side]];
      const std::int32_t body = data.shapes.body[pair.shape[side]];
      if (unswept[side].body != body) unswept[side] = {body, course_of(data, body)};
      return unswept[side].course;
    };
    for (int i = begin; i < end; ++i) {
      times[i] = meeting_of(data, kernels, pairs[i], course_at(pairs[i], 0), course_at(pairs[i], 1), 0.0f,
                            {kNever, kNever});
    }
  });
  Agenda(data, broad_phase, kernels).run();
}

}  // namespace scree::sweeps
