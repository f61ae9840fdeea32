// Sweeps of whole shapes; see sweep_whole.h.
//
// Conservative advancement (B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996): no
// point of a body comes closer to the other one, along the line of their smallest distance, than the bodies'
// ways and turns let its farthest point. Both are moved on for as long as that takes to use up the distance,
// and the distance is measured anew, until they touch or the step ends.
#include <core/world/edit.h>
#include <parallel/continuous/sweep_convex.h>
#include <parallel/continuous/sweep_path.h>
#include <parallel/continuous/sweep_whole.h>
#include <parallel/queries/query_mesh.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::sweeps {

namespace {

using queries::Axes;
using queries::Gap;
using queries::Solid;
using queries::Vector;

// m; shapes this near to each other touch, and are left so far apart.
constexpr double kTouching = 0.2 * double{kLinearSlop};
// Five to ten are usual; a turn about a far center needs more.
constexpr int kMostAdvances = 100;

// A solid on its way through the step.
struct Traveler {
  Solid start;
  const Mover& mover;
  Vector center;  // of mass as the step begins
  double reach;   // m, from there around the solid
  double turn;    // rad per step, at most

  Traveler(Solid solid, const Mover& body, double radius)
      : start(solid),
        mover(body),
        center(queries::to_vector(body.start)),
        reach(queries::length(solid.position - center) + radius),
        turn(rate_of(body.motion)) {}

  Solid at(float t) const {
    const DeltaRow delta = mover.delta_at(t);
    const Axes rotation = queries::to_axes(to_quat(delta.rotation));
    Solid solid = start;
    solid.axes = {rotation * start.axes.x, rotation * start.axes.y, rotation * start.axes.z};
    solid.position = center + queries::to_vector(delta.position) + rotation * (start.position - center);
    return solid;
  }
  // m per step, at most, by which it comes nearer along a direction after t.
  double speed_along(Vector direction, float t) const {
    if (mover.stands_at(t)) return 0.0;
    return dot(queries::to_vector(mover.motion.way), direction) + turn * reach;
  }
};

// m, negative where they overlap as seen along a direction from a to b.
double separation_along(const Solid& a, const Solid& b, Vector direction) {
  return dot(b.position - a.position, direction) - queries::reach_along(a, direction) -
         queries::reach_along(b, -direction);
}

// Whether they touch as the step begins: then they are their contact's business.
bool touch_at_first(const Traveler& a, const Traveler& b) {
  return !(queries::gap_between(a.at(0.0f), b.at(0.0f)).distance > double{kLinearSlop});
}

// When they touch from `from` on, and how they are then; kNever if they do not, or do so as the step begins.
float touching(const Traveler& a, const Traveler& b, float from, Gap& gap) {
  float t = from;
  for (int i = 0; i < kMostAdvances; ++i) {
    gap = queries::gap_between(a.at(t), b.at(t));
    if (i == 0 && !(gap.distance > double{kLinearSlop}))
      return from <= 0.0f || touch_at_first(a, b) ? kNever : from;
    if (!(gap.distance > 0.0)) return t;  // by rounding
    if (gap.distance <= 1.5 * kTouching) return t;
    const double speed = a.speed_along(gap.normal, t) + b.speed_along(-gap.normal, t);
    if (!(speed > 0.0)) return kNever;
    const auto next = static_cast<float>(double{t} + (gap.distance - kTouching) / speed);
    if (!(next <= 1.0f)) return kNever;
    if (!(next > t)) return t;
    t = next;
  }
  return t;
}

// A step of a traveler.
struct Way {
  Solid start, end;
  double bulge;  // m, more than any of its points leaves the chord of its way by: twice R turn^2 / 8

  Way(const Traveler& traveler, float from)
      : start(traveler.at(from)),
        end(traveler.at(1.0f)),
        bulge(traveler.mover.stands_at(from) ? 0.0 : 0.25 * traveler.reach * traveler.turn * traveler.turn) {}
};

// m, from one end to the other along a direction; of what has no end or no inside nothing that counts.
double width_along(const Solid& solid, Vector direction) {
  const bool is_triangle = solid.type == ShapeType::hull && solid.hull == nullptr;
  if (is_triangle || solid.type == ShapeType::half_space) return std::numeric_limits<double>::infinity();
  return queries::reach_along(solid, direction) + queries::reach_along(solid, -direction);
}

// Whether the shapes are apart along a direction from a to b on all of their ways, but for what contacts
// leave: then neither is deep in the other at the end, nor has passed it.
bool stay_apart(const Way& a, const Way& b, Vector direction) {
  constexpr double kDeep = 2.0 * double{kLinearSlop};  // m; also where a load presses what rests
  constexpr double kShare = 0.25;                      // of the thinner one, whose middle stays on its side
  const double thinner = std::min(width_along(a.end, direction), width_along(b.end, direction));
  const double least = a.bulge + b.bulge - std::min(kDeep, kShare * thinner);
  return separation_along(a.end, b.end, direction) >= least &&
         separation_along(a.start, b.start, direction) >= least;
}

// Whether is_met(outward normal) holds for any of a solid's faces; of round ones, for any of its axes.
template <class IsMet>
bool any_face(const Solid& solid, IsMet&& is_met) {
  if (solid.hull == nullptr) {
    for (const Vector axis : {solid.axes.x, solid.axes.y, solid.axes.z}) {
      if (is_met(axis) || is_met(-axis)) return true;
    }
    return false;
  }
  const HullData& hull = *solid.hull;
  for (int face = 0; face < hull.face_count; ++face) {
    const Vector normal{hull.normal[0][face], hull.normal[1][face], hull.normal[2][face]};
    if (is_met(solid.axes * normalize(normal))) return true;
  }
  return false;
}

// Whether balls about the bodies' centers that hold the solids do not touch on their straight ways. A body
// that stops earlier goes a part of its way, so both are taken to stand or to move.
bool stay_far(const Traveler& a, const Traveler& b) {
  const Vector between = b.center - a.center;
  const double ways = queries::length(queries::to_vector(a.mover.motion.way)) +
                      queries::length(queries::to_vector(b.mover.motion.way));
  return queries::length(between) > a.reach + b.reach + ways;
}

// What slides over an edge of its ground meets the ground's next part there, and stays above it.
float meeting_of_convex(const Traveler& a, const Traveler& b, float from) {
  if (stay_far(a, b)) return kNever;
  Gap gap;
  const float met = touching(a, b, from, gap);
  if (!(met <= 1.0f)) return kNever;
  const Way way_a(a, from), way_b(b, from);
  if (gap.distance > 0.0 && stay_apart(way_a, way_b, gap.normal)) return kNever;
  if (b.start.type == ShapeType::half_space) return met;  // which has no end along other directions
  const bool stays_beside =
      any_face(way_b.start, [&](Vector out) { return stay_apart(way_a, way_b, -out); }) ||
      any_face(way_a.start, [&](Vector out) { return stay_apart(way_a, way_b, out); });
  return stays_beside ? kNever : met;
}

// A shape against a triangle of a mesh.
float meeting_with_triangle(const Traveler& a, const Way& way_a, const Mover& mesh_mover, Solid triangle,
                            float from) {
  const Vector local[3] = {{triangle.corner[0][0], triangle.corner[1][0], triangle.corner[2][0]},
                           {triangle.corner[0][1], triangle.corner[1][1], triangle.corner[2][1]},
                           {triangle.corner[0][2], triangle.corner[1][2], triangle.corner[2][2]}};
  const Vector front = cross(local[1] - local[0], local[2] - local[0]);
  double radius = 0.0;
  for (const Vector corner : local) radius = std::max(radius, queries::length(corner));
  const Traveler b(triangle, mesh_mover, radius);
  const Way way_b(b, from);
  const Solid &shape = way_a.start, &then = way_b.start;
  const Vector out = then.axes * normalize(front);
  if (!(dot(out, shape.position - then.position - then.axes * local[0]) > 0.0)) return kNever;
  // What does not come below its plane does not pass it.
  const double nearer = (1.0 - double{from}) * (a.speed_along(-out, from) + b.speed_along(out, from));
  if (separation_along(shape, then, -out) - nearer >= -double{kLinearSlop}) return kNever;
  if (stay_apart(way_a, way_b, -out)) return kNever;
  Gap gap;
  const float met = touching(a, b, from, gap);
  if (!(met <= 1.0f)) return kNever;
  if (!(gap.distance > 0.0)) return met;
  const bool from_front = dot(b.at(met).axes * front, gap.normal) < 0.0;
  return from_front && !stay_apart(way_a, way_b, gap.normal) ? met : kNever;
}

// A box, in the mesh's frame as the step begins, around all that the shape comes to in it.
simd::MeetTask task_of(const Traveler& a, const Solid& mesh, const Mover& mesh_mover) {
  constexpr double kRounding = 1e-6;  // of coordinates: more than floats are off by
  const Vector way = queries::to_vector(a.mover.motion.way) - queries::to_vector(mesh_mover.motion.way);
  const double mesh_turn = rate_of(mesh_mover.motion);
  const double far = queries::length(a.center - queries::to_vector(mesh_mover.start)) + queries::length(way);
  const double mesh_room = mesh_turn * (far + a.reach), turn_room = a.turn * a.reach;
  Solid placed = a.start;
  placed.axes = {turn_back(mesh.axes, a.start.axes.x), turn_back(mesh.axes, a.start.axes.y),
                 turn_back(mesh.axes, a.start.axes.z)};
  const Vector half = queries::reach_of(placed), local_way = turn_back(mesh.axes, way);
  const Vector place = turn_back(mesh.axes, a.start.position - mesh.position);
  const Vector center = turn_back(mesh.axes, a.center - mesh.position);
  simd::MeetTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    // In the box that it has at first, widened by its turn, and in the ball about its center of mass.
    const double ahead = std::max(local_way[axis], 0.0), behind = std::min(local_way[axis], 0.0);
    const double lower = std::max(place[axis] - half[axis] - turn_room, center[axis] - a.reach) + behind;
    const double upper = std::min(place[axis] + half[axis] + turn_room, center[axis] + a.reach) + ahead;
    const double wide = mesh_room + kRounding * (std::abs(lower) + std::abs(upper));
    task.lower[axis] = static_cast<float>(lower - wide);
    task.upper[axis] = static_cast<float>(upper + wide);
  }
  return task;
}

float meeting_with_mesh(const simd::QueryKernels& kernels, const Traveler& a, const Solid& mesh,
                        const Mover& mesh_mover, float from) {
  struct First {
    const Traveler& a;
    const Way way;
    const Solid& mesh;
    const Mover& mover;
    float from;
    queries::TriangleSolid triangle;
    float met = kNever;
  } first{a, Way(a, from), mesh, mesh_mover, from, queries::TriangleSolid(*mesh.mesh)};
  const simd::AskShape ask = [](void* context, std::int32_t triangle, float limit) -> float {
    First& f = *static_cast<First*>(context);
    Solid solid = f.triangle.take(triangle);
    solid.position = f.mesh.position;
    solid.axes = f.mesh.axes;
    f.met = std::min(f.met, meeting_with_triangle(f.a, f.way, f.mover, solid, f.from));
    return limit;
  };
  kernels.meet_mesh(*mesh.mesh, task_of(a, mesh, mesh_mover), 0.0f, ask, &first);
  return first.met;
}

}  // namespace

bool is_swept_whole(const WorldData& data, std::int32_t body) {
  return (data.bodies.motion[body].flags & std::uint32_t{kMotionSweptWhole}) != 0 &&
         data.bodies.type[body] == BodyType::dynamic;
}

float reach_of(const WorldData& data, std::int32_t body) {
  float reach = 0.0f;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    reach = std::max(reach,
                     length(to_vec3(data.shapes.local_pose[shape].position)) + outer_radius_of(data, shape));
  }
  return reach;
}

bool moves_far(const WorldData& data, std::int32_t body) {
  const DeltaRow& delta = data.bodies.delta[body];
  const float way = length(to_vec3(delta.position));
  if (way > kFastTravel) return true;
  const float turn = 2.0f * length(Vec3{delta.rotation[0], delta.rotation[1], delta.rotation[2]});
  return turn > 0.0f && way + turn * reach_of(data, body) > kFastTravel;
}

float whole_meeting(const WorldData& data, const simd::QueryKernels& kernels, const std::int32_t (&shapes)[2],
                    const Mover (&movers)[2], float from) {
  const int other =
      data.shapes.type[shapes[0]] == ShapeType::mesh || data.shapes.type[shapes[0]] == ShapeType::half_space
          ? 0
          : 1;
  const std::int32_t shape = shapes[1 - other], obstacle = shapes[other];
  const Traveler a(queries::solid_of(data, shape), movers[1 - other], double{outer_radius_of(data, shape)});
  const Solid solid = queries::solid_of(data, obstacle);
  if (solid.mesh != nullptr) return meeting_with_mesh(kernels, a, solid, movers[other], from);
  // A half-space has no end: of it counts what comes near the shape.
  const double radius = solid.type == ShapeType::half_space
                            ? queries::length(a.start.position - solid.position) + a.reach
                            : double{outer_radius_of(data, obstacle)};
  return meeting_of_convex(a, Traveler(solid, movers[other], radius), from);
}

}  // namespace scree::sweeps
