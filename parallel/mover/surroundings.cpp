// What is around a mover; see surroundings.h.
#include <core/world/limits.h>
#include <parallel/mover/surroundings.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace scree::mover {

namespace {

constexpr float kThin = 1e-4f;          // m, of the inner segment where distances are measured from it
constexpr double kSlackShare = 0.1;     // of the skin
constexpr double kFirmRounding = 1e-5;  // of cosines

// The turn that takes y to a unit vector, by the shorter way.
Quat turn_to(Vector up) {
  const double half_cosine = std::sqrt(0.5 * (1.0 + up.y));
  if (!(half_cosine > 1e-6)) return {1.0f, 0.0f, 0.0f, 0.0f};
  const double s = 0.5 / half_cosine;  // y x up has the length of twice the product of half sine and cosine
  return {static_cast<float>(s * up.z), 0.0f, static_cast<float>(-s * up.x), static_cast<float>(half_cosine)};
}

// Options of a query of the task. They must not outlive it.
QueryOptions options_of(const Task& task, StartInside start_inside) {
  const MoverSettings& settings = task.settings;
  QueryOptions options;
  options.filter = settings.filter;
  options.types = settings.types;
  options.ignored = settings.ignored;
  options.start_inside = start_inside;
  if (task.carrier.generation == 0 && !settings.predicate) return options;
  // One pointer, which a std::function holds without memory of its own.
  options.predicate = [&task](ShapeId shape, BodyId body) {
    if (task.carrier.generation != 0 && body == task.carrier) return false;
    return !task.settings.predicate || task.settings.predicate(shape, body);
  };
  return options;
}

Pose pose_of(const Task& task, Vector position) { return {queries::to_vec3(position), task.turn}; }

Geometry capsule_of(const Task& task, float radius) {
  return Capsule{.half_height = task.settings.half_height, .radius = radius};
}

}  // namespace

Task task_of(const World& world, const MoverSettings& settings, float dt) {
  const Vector up = queries::normalize(queries::to_vector(settings.up));
  return {world,
          settings,
          up,
          turn_to(up),
          settings.radius,
          settings.half_height,
          settings.skin,
          double{settings.slope_cosine} - kFirmRounding,
          dt};
}

Vector placed(Vector position) {
  constexpr double kMost = kMaxPosition;
  return queries::to_vector(Vec3{static_cast<float>(std::clamp(position.x, -kMost, kMost)),
                                 static_cast<float>(std::clamp(position.y, -kMost, kMost)),
                                 static_cast<float>(std::clamp(position.z, -kMost, kMost))});
}

double slack(const Task& task, Vector position) {
  constexpr double kPlaceRounding = 1.2e-7;  // of coordinates: two halves of a unit in the last place
  const double largest = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  return kSlackShare * task.skin + kPlaceRounding * largest;
}

namespace {

Touches touches_of(const Task& task, Vector position) {
  const double most = task.radius - kThin + task.skin + slack(task, position);
  Touches touches;
  for (const NearHit& hit : near_shape(task.world, {capsule_of(task, kThin), pose_of(task, position)},
                                       static_cast<float>(most), options_of(task, StartInside::hit))) {
    if (hit.normal == Vec3{}) {
      if (!touches.inside) touches.holder = hit.shape, touches.holder_body = hit.body;
      touches.inside = true;
      continue;
    }
    if (touches.count == kMostTouched) break;
    touches.touch[touches.count++] = {.normal = queries::normalize(queries::to_vector(hit.normal)),
                                      .point = queries::to_vector(hit.point),
                                      .distance = double{hit.distance} + kThin - task.radius,
                                      .shape = hit.shape,
                                      .body = hit.body,
                                      .type = task.world.body_type(hit.body)};
  }
  return touches;
}

bool same(Vector a, Vector b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace

const Touches& touched_at(const Task& task, Vector position) {
  if (!task.is_known || !same(task.known_position, position) || task.known_carrier != task.carrier) {
    task.is_known = false;  // until the queries have not thrown
    task.known = touches_of(task, position);
    task.known_position = position;
    task.known_carrier = task.carrier;
    task.is_known = true;
  }
  return task.known;
}

namespace {

// m, what must be left between the capsule and a shape that it meets.
double kept_off(const Task& task, ShapeId shape, std::span<const Touch> near) {
  constexpr double kLeast = 0.1;  // of the distance that there is
  for (const Touch& touch : near) {
    if (touch.shape == shape && touch.distance < task.skin) return kLeast * std::max(touch.distance, 0.0);
  }
  return task.skin;
}

// With so much around the capsule (m, less than the skin).
Meeting meet_with(const Task& task, Vector position, Vector way, double around, std::span<const Touch> near) {
  // Beyond the way's end, so that it ends outside of the skin of what is ahead.
  constexpr double kBeyond = 2.0;  // times the skin
  Meeting meeting;
  const double size = length(way);
  if (!(size > 0.0)) return meeting;
  const double stretch = 1.0 + kBeyond * (task.skin - around) / size;
  const float radius = static_cast<float>(task.radius + around);
  const std::optional<CastHit> hit = cast_shape(
      task.world, {capsule_of(task, radius), pose_of(task, position), queries::to_vec3(stretch * way)},
      options_of(task, StartInside::skip));
  if (!hit) return meeting;
  const Vector normal = queries::normalize(queries::to_vector(hit->normal));
  // The way comes nearer to the plane that they meet at by `closing` in all, and shall leave the skin.
  const double closing = std::max(-dot(normal, way), 0.0);
  const double met = stretch * double{hit->fraction}, at_first = met * closing + around;
  const double kept = kept_off(task, hit->shape, near);
  const double advance = closing > 0.0 ? std::max((at_first - kept) / closing, 0.0) : 0.0;
  if (advance >= 1.0) return meeting;
  meeting.meets = true;
  meeting.advance = advance;
  meeting.touch = {.normal = normal,
                   .point = queries::to_vector(hit->point),
                   .distance = at_first - advance * closing,
                   .shape = hit->shape,
                   .body = hit->body,
                   .type = task.world.body_type(hit->body)};
  return meeting;
}

}  // namespace

Meeting meet_on_way(const Task& task, Vector position, Vector way, std::span<const Touch> around) {
  return meet_with(task, position, way, 0.0, around);
}

Meeting meet_below(const Task& task, Vector position, Vector way) {
  constexpr double kAround = 0.95;  // of the skin: what is beside the mover is farther off
  const Meeting by_skin = meet_with(task, position, way, kAround * task.skin, {});
  if (!by_skin.meets) return by_skin;
  // What is within the skin already was passed over: the capsule itself must not meet it.
  const ShapeCast itself{capsule_of(task, task.settings.radius), pose_of(task, position),
                         queries::to_vec3(by_skin.advance * way)};
  const bool enters = is_cast_blocked(task.world, itself, options_of(task, StartInside::skip));
  return enters ? meet_with(task, position, way, 0.0, {}) : by_skin;
}

bool is_edge_of_firm(const Task& task, const Touch& touch) {
  constexpr double kLeastRise = 0.02;        // cosine: what is steeper holds the capsule from the side only
  constexpr double kProbes[] = {0.1, 0.01};  // of the radius: thin ledges need the shorter one
  if (dot(task.up, touch.normal) < kLeastRise) return false;
  const Vector beyond = -queries::normalize(level_part(task, touch.normal));
  for (const double probe : kProbes) {
    const double reach = probe * task.radius;
    const Ray ray{.origin = queries::to_vec3(placed(touch.point + reach * (beyond + task.up))),
                  .translation = queries::to_vec3((-2.0 * reach) * task.up)};
    const std::optional<CastHit> hit = cast_ray(task.world, ray, options_of(task, StartInside::hit));
    if (hit && !hit->starts_inside && is_firm(task, queries::to_vector(hit->normal))) return true;
  }
  return false;
}

namespace {

// Options of a query of one shape, whose handle must outlive them.
QueryOptions options_of(const ShapeId& only) {
  QueryOptions options;
  options.predicate = [&only](ShapeId shape, BodyId) { return shape == only; };
  return options;
}

}  // namespace

Vector point_at_height(const Task& task, Vector position, const Touch& touch, double height) {
  constexpr double kUpright = 1e-3;  // cosine
  if (std::abs(dot(task.up, touch.normal)) > kUpright) return touch.point;
  const double along = std::clamp(height - dot(task.up, position), -task.half, task.half);
  const double most = task.radius + task.skin + slack(task, position);
  const std::optional<NearHit> hit =
      closest_to_point(task.world, queries::to_vec3(placed(position + along * task.up)),
                       static_cast<float>(most), options_of(touch.shape));
  return hit && hit->normal != Vec3{} ? queries::to_vector(hit->point) : touch.point;
}

namespace {

// How far the capsule must go along a direction to be out of one shape; nothing if that is too far to find.
std::optional<double> way_out(const Task& task, Vector position, Vector direction, const ShapeId& holder) {
  constexpr int kDoublings = 6;  // of the capsule's size, each by four
  const QueryOptions options = options_of(holder);
  double away = 2.0 * (task.half + task.radius);
  for (int i = 0; i < kDoublings; ++i, away *= 4.0) {
    const Vector from = placed(position + away * direction);
    const std::optional<CastHit> hit = cast_shape(
        task.world,
        {capsule_of(task, task.settings.radius), pose_of(task, from), queries::to_vec3((-away) * direction)},
        options);
    if (!hit) return std::nullopt;  // by rounding: it is not held at all
    if (!hit->starts_inside) return away - double{hit->distance} + task.skin;
  }
  return std::nullopt;
}

// Whether the capsule is free after a way, and no fixed shape is on it that the inner segment is not in.
bool is_way_free(const Task& task, Vector position, Vector way) {
  QueryOptions walls = options_of(task, StartInside::skip);
  walls.types =
      static_cast<BodyTypes>(static_cast<unsigned>(walls.types) & static_cast<unsigned>(BodyTypes::fixed));
  if (is_cast_blocked(task.world, {capsule_of(task, kThin), pose_of(task, position), queries::to_vec3(way)},
                      walls)) {
    return false;
  }
  const ShapeCast end{capsule_of(task, task.settings.radius), pose_of(task, placed(position + way)), {}};
  return !is_cast_blocked(task.world, end, options_of(task, StartInside::hit));
}

}  // namespace

Vector escape(const Task& task, Vector position, const Touches& touches) {
  const Vector holder_velocity =
      queries::to_vector(task.world.velocity_at(touches.holder_body, queries::to_vec3(position)));
  const Vector side =
      queries::normalize(level_part(task, std::abs(task.up.x) < 0.7 ? Vector{1, 0, 0} : Vector{0, 1, 0}));
  const Vector across = cross(task.up, side);
  constexpr double kDiagonal = 0.70710678118654752;
  const Vector directions[] = {queries::normalize(holder_velocity),
                               task.up,
                               side,
                               -side,
                               across,
                               -across,
                               kDiagonal * (side + across),
                               kDiagonal * (side - across),
                               kDiagonal * (across - side),
                               -kDiagonal * (side + across),
                               -task.up};
  // What has just swallowed the mover pushes it on, though the way back may be shorter.
  const double swallowed = queries::length(holder_velocity) * task.dt + task.radius + 2.0 * task.skin;
  double shortest = std::numeric_limits<double>::infinity();
  Vector best{};
  for (const Vector& direction : directions) {
    if (!(dot(direction, direction) > 0.0)) continue;
    const std::optional<double> out = way_out(task, position, direction, touches.holder);
    if (!out || !(*out < shortest) || !is_way_free(task, position, *out * direction)) continue;
    shortest = *out;
    best = shortest * direction;
    if (&direction == &directions[0] && *out <= swallowed) break;
  }
  return placed(position + best);
}

}  // namespace scree::mover
