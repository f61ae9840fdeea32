// Proofs that shapes stay clear of each other; see sweep_clear.h.
//
// Seen from the obstacle's body, a ball's center is at
//   z(t) = R(t)^T y(t) - o,  y(t) = c + t w + S(t) r,
// with the turns R and S of both bodies, the arms r and o of the ball and the obstacle, and c + t w between
// the bodies' centers. Between two moments that are 0 and 1, let L x(t) = (1 - t) x(0) + t x(1). Where
//   |S(t) r - L(S r)(t)| <= s |r|  and  |R(t) - LR(t)| <= b  (the bows),
// it follows, because LR Ly = L(R^T y) - t (1 - t) (R(0) - R(1))^T (y(0) - y(1)), that
//   |z(t) - Lz(t)| <= s |r| + b max(|y(0)|, |y(1)|) + |R(0) - R(1)| |y(0) - y(1)| / 4.
// So all of the way, and with it every chord between two of its points, is within this of one line.
//
// The bow of a turn q by an angle of at most pi along part_of(q, t), where |q| = 1: in the complex plane
// normal to the axis, with v = exp(i angle / 2) and N = |1 - t + t v|^2, the place is (1 - t + t v)^2 / N,
// and
//   (1 - t + t v)^2 - (1 - t + t v^2) = -t (1 - t) (1 - v)^2,  |1 - N| = t (1 - t) |1 - v|^2,
// so that the bow is at most 2 t (1 - t) |1 - v|^2 <= 1 - q.w. Two turns one after the other have both bows
// and t (1 - t) |1 - v^2| |1 - u^2|, the product of their sines at most. Between moments within the step it
// is twice that of the step at most, as both ends are near its line.
//
// Where the turns of the other body matter, this is much. Seen from the world, with its bow b and its arm o,
// what is between a ball and a point of the obstacle,
//   c + t w + S(t) r - R(t) o,
// is within s |r| + b |o| of its own line: a plane that parts all such points of two shapes by more than that
// at both ends parts them all the time (stay_parted()). Ways come no nearer than that, and chords that are
// swept by no more than two bends.
//
// What stays so far from a ball or a box around the obstacle is left by meeting_between() at each chord, and
// what stays so far from the box by first_within(), whose distances are not below that from the box.
#include <core/world/edit.h>
#include <parallel/continuous/sweep_clear.h>
#include <parallel/continuous/sweep_convex.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::sweeps {

namespace {

// Of coordinates: more than the sums in floats of places and their ways are off by, here and where the balls
// are followed.
constexpr float kPlaceRounding = 4e-6f;

// m; beyond this, halvings may end before a way is straight.
constexpr float kFarthest = 1e5f;

float size_of(Vec3 v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

float square_to_chord(Vec3 from, Vec3 to) {
  const Vec3 chord = to - from;
  const float square = dot(chord, chord);
  const float part = square > 0.0f ? std::clamp(-dot(from, chord) / square, 0.0f, 1.0f) : 0.0f;
  const Vec3 nearest = from + part * chord;
  return dot(nearest, nearest);
}

// Whether a box about the shape's origin holds it.
bool has_box(const WorldData& data, std::int32_t shape) {
  const ShapeType type = data.shapes.type[shape];
  return type != ShapeType::mesh && type != ShapeType::half_space;
}

// m, half; no distance of a sweep from the shape is below that from this box; see sweep_convex.cpp.
Vec3 box_of(const WorldData& data, std::int32_t shape) {
  const ExtentRow& extent = data.shapes.extent[shape];
  const Vec3 half = to_vec3(extent.half);
  const float radius = extent.radius;
  switch (data.shapes.type[shape]) {
    case ShapeType::sphere:
      return {radius, radius, radius};
    case ShapeType::capsule:
      return {radius, std::abs(half.y) + radius, radius};
    case ShapeType::box:
    case ShapeType::rounded_box:
      return half + Vec3{radius, radius, radius};
    case ShapeType::cylinder:
    case ShapeType::cone:
      return {half.x, half.y, half.x};
    default:  // hulls have their rounding in it
      return half;
  }
}

float reach_along(Vec3 half, float x, float y, float z) {
  return std::abs(x) * half.x + std::abs(y) * half.y + std::abs(z) * half.z;
}

// Whether a line between two points has no point in a box about the origin: as seen along an axis of the box,
// or normal to one and to the line (S. Gottschalk, M. Lin, D. Manocha, "OBBTree", 1996).
bool is_beside(Vec3 from, Vec3 to, Vec3 half) {
  const Vec3 c = 0.5f * (from + to), d = 0.5f * (to - from);
  const auto size = [](float x) { return std::abs(x); };
  const Vec3 e{size(d.x), size(d.y), size(d.z)};
  return size(c.x) > half.x + e.x || size(c.y) > half.y + e.y || size(c.z) > half.z + e.z ||
         size(d.y * c.z - d.z * c.y) > half.y * e.z + half.z * e.y ||
         size(d.z * c.x - d.x * c.z) > half.z * e.x + half.x * e.z ||
         size(d.x * c.y - d.y * c.x) > half.x * e.y + half.y * e.x;
}

bool is_round(const WorldData& data, std::int32_t shape) {
  const ShapeType type = data.shapes.type[shape];
  return type == ShapeType::sphere || type == ShapeType::capsule;
}

// m, from a round shape's center to the end of the segment that all of it is within its radius of.
Vec3 half_segment_of(const WorldData& data, std::int32_t shape, Quat turn) {
  if (data.shapes.type[shape] == ShapeType::sphere) return {};
  const Vec3 half{0.0f, data.shapes.extent[shape].half[1], 0.0f};
  return rotate(turn * to_quat(data.shapes.pose[shape].rotation), half);
}

// The shortest way to a segment about `center` from one about the origin, or about that.
Vec3 way_between(Vec3 center, Vec3 half, Vec3 from_half) {
  const float a = dot(half, half), b = dot(from_half, from_half), c = dot(half, from_half);
  const float d = dot(center, half), e = dot(center, from_half), area = a * b - c * c;
  const auto part = [](float x, float size) {
    return size > 0.0f ? std::clamp(x / size, -1.0f, 1.0f) : 0.0f;
  };
  const float first = part(c * e - b * d, area), from = part(e + c * first, b), to = part(c * from - d, a);
  return center + to * half - from * from_half;
}

}  // namespace

float bow_of(const Motion& motion) {
  // Quaternions are of unit length but for rounding.
  constexpr float kOff = 1e-4f;
  float sine[2], bow = 0.0f;
  int i = 0;
  for (const Quat q : {motion.swing, motion.twist}) {
    const float square = q.x * q.x + q.y * q.y + q.z * q.z;
    if (!(std::abs(square + q.w * q.w - 1.0f) < kOff)) return std::numeric_limits<float>::infinity();
    bow += square / (1.0f + q.w);  // 1 - w
    sine[i++] = std::sqrt(square);
  }
  return bow + sine[0] * sine[1] + 3.0f * kOff * (sine[0] + sine[1]) + 1e-6f;
}

Leg leg_of(const Course& course, float stop, float from) {
  const Mover& mover = course.mover;
  if (stop <= from) {
    const DeltaRow there = part_of(mover.motion, stop);
    return {mover.start, there, there, 0.0f, 0.0f, 0.0f};
  }
  const DeltaRow begin = from > 0.0f ? part_of(mover.motion, from) : course.begin;
  // What stops on the way has no straight one.
  if (stop < 1.0f)
    return {mover.start, begin,       part_of(mover.motion, stop),
            course.turn, course.rate, std::numeric_limits<float>::infinity()};
  const float bow = from > 0.0f ? 2.0f * course.bow : course.bow;
  return {mover.start, begin, course.end, course.turn, course.rate, bow};
}

// Looks along the shortest ways between the segments that the shapes are about, at both ends. Of pairs of
// capsules that may pass each other, three quarters are parted so.
bool stay_parted(const WorldData& data, const std::int32_t (&shape)[2], const Leg (&leg)[2]) {
  if (!is_round(data, shape[0]) || !is_round(data, shape[1])) return false;
  Vec3 apart[2] = {leg[0].start - leg[1].start, leg[0].start - leg[1].start};  // at both ends
  Vec3 half[2][2];                                                             // by shape, at both ends
  float leaves = 0.0f, radii = 0.0f, scale = size_of(leg[0].start) + size_of(leg[1].start);
  for (int side = 0; side < 2; ++side) {
    const Vec3 arm = to_vec3(data.shapes.pose[shape[side]].position) - leg[side].start;
    const float sign = side == 0 ? 1.0f : -1.0f;
    for (int i = 0; i < 2; ++i) {
      const DeltaRow& delta = i == 0 ? leg[side].from : leg[side].to;
      const Quat turn = to_quat(delta.rotation);
      apart[i] = apart[i] + sign * (to_vec3(delta.position) + rotate(turn, arm));
      half[side][i] = half_segment_of(data, shape[side], turn);
      scale += size_of(to_vec3(delta.position));
    }
    const float size = size_of(arm) + outer_radius_of(data, shape[side]);
    leaves += leg[side].bow * size;
    radii += data.shapes.extent[shape[side]].radius;
    scale += size;
  }
  if (!(scale < kFarthest)) return false;
  const float room = radii + kLinearSlop + 2.0f * kMostBend + leaves + kPlaceRounding * scale;
  for (int seen = 0; seen < 2; ++seen) {
    const Vec3 normal = way_between(apart[seen], half[0][seen], half[1][seen]);
    const float most = room * length(normal);
    if (!(most > 0.0f)) continue;  // too short a normal for floats
    const auto is_beyond = [&](int i) {
      return dot(normal, apart[i]) - std::abs(dot(normal, half[0][i])) - std::abs(dot(normal, half[1][i])) >
             most;
    };
    if (is_beyond(0) && is_beyond(1)) return true;
  }
  return false;
}

bool stays_clear(const WorldData& data, std::int32_t shape, const Leg& leg, std::int32_t obstacle,
                 const Leg& other, Passage& passage) {
  passage.is_boxed = false;
  const float radius = outer_radius_of(data, shape);  // all balls are within
  const Vec3 arm = to_vec3(data.shapes.pose[shape].position) - leg.start;
  const Vec3 other_arm = to_vec3(data.shapes.pose[obstacle].position) - other.start;
  const Vec3 apart = leg.start - other.start;
  const auto place = [&](const DeltaRow& delta, const DeltaRow& other_delta) {
    return apart + (to_vec3(delta.position) - to_vec3(other_delta.position)) +
           rotate(to_quat(delta.rotation), arm);
  };
  const Vec3 y[2] = {place(leg.from, other.from), place(leg.to, other.to)};
  const Vec3 z[2] = {rotate_back(to_quat(other.from.rotation), y[0]) - other_arm,
                     rotate_back(to_quat(other.to.rotation), y[1]) - other_arm};
  const float far = std::max(size_of(y[0]), size_of(y[1])) + radius;
  const float scale = size_of(leg.start) + size_of(other.start) + size_of(arm) + size_of(other_arm) + far;
  if (!(scale < kFarthest)) return false;
  const float leaves = leg.bow * (length(arm) + radius) +
                       other.bow * (std::sqrt(std::max(dot(y[0], y[0]), dot(y[1], y[1]))) + radius) +
                       0.25f * other.turn * (length(y[1] - y[0]) + leg.turn * radius);
  const float room = kLinearSlop + kMostBend + leaves + kPlaceRounding * scale;
  const float most = radius + outer_radius_of(data, obstacle) + room;
  if (square_to_chord(z[0], z[1]) > most * most) return true;
  if (!has_box(data, obstacle)) return false;
  passage.is_boxed = true;
  const Quat turn = to_quat(data.shapes.pose[shape].rotation),
             back = conjugate(to_quat(data.shapes.pose[obstacle].rotation));
  Vec3 reach{};  // of the shape along the obstacle's axes
  const Vec3 half = box_of(data, shape);
  for (int i = 0; i < 2; ++i) {
    const Quat there = to_quat((i == 0 ? leg.from : leg.to).rotation),
               other_there = to_quat((i == 0 ? other.from : other.to).rotation);
    const Quat whole = back * conjugate(other_there) * there * turn;
    passage.place[i] = rotate(back, z[i]);
    auto& axes = passage.axes[i];
    axes[0] = rotate(whole, {1.0f, 0.0f, 0.0f});
    axes[1] = rotate(whole, {0.0f, 1.0f, 0.0f});
    axes[2] = rotate(whole, {0.0f, 0.0f, 1.0f});
    reach.x = std::max(reach.x, reach_along(half, axes[0].x, axes[1].x, axes[2].x));
    reach.y = std::max(reach.y, reach_along(half, axes[0].y, axes[1].y, axes[2].y));
    reach.z = std::max(reach.z, reach_along(half, axes[0].z, axes[1].z, axes[2].z));
  }
  passage.half = box_of(data, obstacle) + Vec3{room, room, room};
  return has_box(data, shape) && is_beside(passage.place[0], passage.place[1], passage.half + reach);
}

bool stays_clear(const Passage& passage, const Ball& ball) {
  if (!passage.is_boxed) return false;
  const auto place = [&](int i) {
    const auto& axes = passage.axes[i];
    return passage.place[i] + ball.center.x * axes[0] + ball.center.y * axes[1] + ball.center.z * axes[2];
  };
  return is_beside(place(0), place(1), passage.half + Vec3{ball.radius, ball.radius, ball.radius});
}

ObstacleBox box_about(const WorldData& data, std::int32_t obstacle, Vec3 start, Vec3 other) {
  const PoseRow& pose = data.shapes.pose[obstacle];
  const Vec3 origin = to_vec3(pose.position);
  const float scale = size_of(origin) + size_of(start) + size_of(other);
  const bool is_there = has_box(data, obstacle) && scale < kFarthest;
  return {origin, conjugate(to_quat(pose.rotation)), is_there ? box_of(data, obstacle) : Vec3{}, scale,
          is_there};
}

bool stays_beside(const ObstacleBox& box, Vec3 from, Vec3 to, float room) {
  if (!box.is_there) return false;
  const float scale = size_of(from) + size_of(to) + box.scale,
              most = room + kLinearSlop + kPlaceRounding * scale;
  return is_beside(rotate(box.back, from - box.origin), rotate(box.back, to - box.origin),
                   box.half + Vec3{most, most, most});
}

bool starts_clear(const WorldData& data, std::int32_t a, std::int32_t b) {
  for (const std::int32_t shape : {a, b}) {
    const ShapeType type = data.shapes.type[shape];
    if (type == ShapeType::half_space || type == ShapeType::mesh) return false;  // no ball holds them
  }
  const Vec3 from = to_vec3(data.shapes.pose[a].position), to = to_vec3(data.shapes.pose[b].position);
  const float room = outer_radius_of(data, a) + outer_radius_of(data, b) + kLinearSlop +
                     kPlaceRounding * (size_of(from) + size_of(to));
  return dot(to - from, to - from) > room * room;
}

}  // namespace scree::sweeps
