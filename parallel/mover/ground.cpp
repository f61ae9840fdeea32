// What a mover stands on; see ground.h.
#include <parallel/mover/ground.h>

#include <algorithm>

namespace scree::mover {

namespace {

// Whether steep surfaces hold the mover between them: falling is no way that they allow.
bool are_a_hollow(const Task& task, std::span<const Touch> touches) {
  constexpr double kHeld = 0.01;  // of the fall that is left
  std::array<Plane, kMostTouched> planes{};
  std::size_t count = 0;
  for (const Touch& touch : touches) planes[count++] = {.normal = touch.normal};
  Vector left;
  if (!nearest_allowed(std::span(planes).first(count), -task.up, tolerance(task), left)) return true;
  return length(left) < kHeld;
}

}  // namespace

Ground find_ground(const Task& task, Vector position, bool walks, BodyId before) {
  const Touches& touches = touched_at(task, position);
  Ground ground;
  double best = 0.0;  // cosine
  bool best_is_before = false;
  for (const Touch& touch : touches.all()) {
    const double rise = dot(task.up, touch.normal);
    if (!(rise > 0.0)) continue;
    const bool firm = is_firm(task, touch.normal), is_before = before.generation != 0 && touch.body == before;
    const bool was_firm = ground.kind == MoverGround::firm;
    if (was_firm && !firm) continue;
    if (firm == was_firm && (best_is_before && !is_before)) continue;
    if (firm == was_firm && is_before == best_is_before && !(rise > best)) continue;
    ground = {firm ? MoverGround::firm : MoverGround::steep, touch};
    best = rise;
    best_is_before = is_before;
  }
  if (ground.kind != MoverGround::steep) return ground;
  if (walks) {
    for (const Touch& touch : touches.all()) {
      if (is_edge_of_firm(task, touch)) return {MoverGround::firm, touch};
    }
  }
  if (are_a_hollow(task, touches.all())) ground.kind = MoverGround::firm;
  return ground;
}

namespace {

// The ground of a mover that has come down onto something. A shape that is not convex answers with its
// nearest part alone, which may be a wall: what was met below counts, too.
Ground ground_on(const Task& task, Vector position, const Meeting& below, bool walks, BodyId before) {
  const Ground ground = find_ground(task, position, walks, before);
  if (ground.kind == MoverGround::firm) return ground;
  if (is_firm(task, below.touch.normal) || (walks && is_edge_of_firm(task, below.touch))) {
    return {MoverGround::firm, below.touch};
  }
  return {};
}

}  // namespace

Ground follow_down(const Task& task, Vector& position, BodyId before) {
  const Vector way = -(double{task.settings.snap_distance} + task.skin) * task.up;
  const Meeting meeting = meet_below(task, position, way);
  if (!meeting.meets) return {};
  const Vector lower = placed(position + meeting.advance * way);
  const Ground ground = ground_on(task, lower, meeting, true, before);
  if (ground.kind == MoverGround::firm) position = lower;
  return ground;
}

Ground land_on(const Task& task, Vector position) {
  const Vector way = -slack(task, position) * task.up;
  const Meeting meeting = meet_on_way(task, position, way);
  return meeting.meets ? ground_on(task, position, meeting, false, {}) : Ground{};
}

namespace {

// m, to the nearest shape that is touched, but no more than the skin.
double clearance(const Task& task, Vector position) {
  const Touches& touches = touched_at(task, position);
  if (touches.inside) return -task.radius;
  return touches.count == 0 ? task.skin : std::min(touches.touch[0].distance, task.skin);
}

// Tries the step with a way of `reach` m along the unit vector `ahead`, which must bring the mover farther
// than `least`.
bool try_step(const Task& task, Vector start, Vector velocity, Vector ahead, double reach, double least,
              Course& course, Ground& ground) {
  const Vector lift = (double{task.settings.step_height} + task.skin) * task.up;
  const Meeting above = meet_on_way(task, start, lift);
  Course over{.position = placed(start + above.advance * lift), .velocity = velocity};
  slide(task, reach * ahead, Gait::walk, over);
  if (!(dot(ahead, over.position - start) > least)) return false;

  const double height = dot(task.up, over.position - start);
  if (!(height > 0.0)) return false;
  const Vector down = (-(height + task.skin)) * task.up;
  const Meeting below = meet_below(task, over.position, down);
  if (!below.meets) return false;
  over.position = placed(over.position + below.advance * down);
  const Ground found = ground_on(task, over.position, below, true, {});
  if (found.kind != MoverGround::firm) return false;
  const double rise = dot(task.up, found.touch.point) - feet(task, start);
  if (rise > double{task.settings.step_height} + slack(task, start)) return false;
  // A step leads up, or across something: else it is the way that was blocked.
  constexpr double kUp = 0.01, kAcross = 0.1;  // of the skin; of the radius
  if (dot(task.up, over.position - start) < kUp * task.skin &&
      dot(ahead, over.position - start) < least + kAcross * task.radius) {
    return false;
  }
  // Nor is a step into the skin of a wall one.
  constexpr double kTighter = 0.1;  // of the skin
  if (clearance(task, over.position) < clearance(task, start) - kTighter * task.skin) return false;
  over.push_count = 0;
  course = over;
  ground = found;
  return true;
}

}  // namespace

bool step_up(const Task& task, Vector start, Vector velocity, Vector way, Course& course, Ground& ground) {
  // So far even a slow mover reaches, that the edge comes below its round end.
  constexpr double kReach = 0.03;    // of the radius
  constexpr double kFarther = 1e-4;  // of the radius: what counts as farther
  const double size = length(way);
  const Vector ahead = (1.0 / size) * way;
  const double gained = std::max(dot(ahead, course.position - start), 0.0);
  const double farther = kFarther * task.radius;
  if (try_step(task, start, velocity, ahead, size, gained + farther, course, ground)) return true;
  const double reach = gained + kReach * task.radius;
  return reach > size &&
         try_step(task, start, velocity, ahead, reach, gained * (reach / size) + farther, course, ground);
}

}  // namespace scree::mover
