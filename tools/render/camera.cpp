// See camera.h.
#include <tools/render/camera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <variant>

namespace scree::render {
namespace {

constexpr Vec3 kX{1.0f, 0.0f, 0.0f}, kZ{0.0f, 0.0f, 1.0f};

// In a shape's frame.
struct LocalBox {
  Vec3 lower, upper;
};

LocalBox around(std::span<const Vec3> points) {
  constexpr float kEnd = std::numeric_limits<float>::infinity();
  LocalBox box{{kEnd, kEnd, kEnd}, {-kEnd, -kEnd, -kEnd}};
  for (const Vec3& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = std::min(box.lower[axis], point[axis]);
      box.upper[axis] = std::max(box.upper[axis], point[axis]);
    }
  }
  return box;
}

LocalBox symmetric(Vec3 reach) { return {-reach, reach}; }

// Of each kind of shape; nothing for half-spaces, which have no end.
struct BoxOf {
  using Result = std::optional<LocalBox>;
  Result operator()(const Sphere& s) const { return symmetric({s.radius, s.radius, s.radius}); }
  Result operator()(const Capsule& s) const {
    return symmetric({s.radius, s.half_height + s.radius, s.radius});
  }
  Result operator()(const Box& s) const {
    return symmetric(s.half_extents + Vec3{s.rounding, s.rounding, s.rounding});
  }
  Result operator()(const ConvexHull& s) const {
    LocalBox box = around(s.hull.vertices());
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = s.scale[axis] * box.lower[axis] - s.rounding;
      box.upper[axis] = s.scale[axis] * box.upper[axis] + s.rounding;
    }
    return box;
  }
  Result operator()(const TriangleMesh& s) const { return around(s.vertices()); }
  Result operator()(const HalfSpace&) const { return {}; }
  Result operator()(const Cylinder& s) const { return symmetric({s.radius, s.half_height, s.radius}); }
  Result operator()(const Cone& s) const { return symmetric({s.radius, s.half_height, s.radius}); }
};

void add_shapes(const World& world, BodyId body, std::vector<ShapeId>& shapes, Subject& subject) {
  shapes.resize(world.shapes_of(body, {}));
  world.shapes_of(body, shapes);
  const Pose body_pose = world.pose(body);
  for (const ShapeId shape : shapes) {
    if (world.is_sensor(shape)) continue;
    const std::optional<LocalBox> box = std::visit(BoxOf{}, world.geometry(shape));
    if (!box) continue;
    const Pose pose = body_pose * world.local_pose(shape);
    for (int corner = 0; corner < Subject::kCorners; ++corner) {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis)
        point[axis] = (corner >> axis & 1) != 0 ? box->upper[axis] : box->lower[axis];
      subject.corners.push_back(transform(pose, point));
    }
    subject.owners.push_back(body);
  }
}

// What is so many times as far away as the rest does not belong to it.
constexpr float kFar = 3.0f;

// Those of `bodies` that are at most three times as far from their median as nine tenths of them are.
std::vector<BodyId> without_strays(const World& world, std::vector<BodyId> bodies) {
  if (bodies.empty()) return bodies;
  Vec3 median;
  std::vector<float> values(bodies.size());
  const auto quantile = [&values](std::size_t place) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place), values.end());
    return values[place];
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < bodies.size(); ++i) values[i] = world.center_of_mass(bodies[i])[axis];
    median[axis] = quantile(bodies.size() / 2);
  }
  const auto distance_of = [&](BodyId body) { return distance(world.center_of_mass(body), median); };
  for (std::size_t i = 0; i < bodies.size(); ++i) values[i] = distance_of(bodies[i]);
  const float most = kFar * quantile(bodies.size() * 9 / 10);
  std::erase_if(bodies, [&](BodyId body) { return distance_of(body) > most; });
  return bodies;
}

void add_bodies(const World& world, BodyType type, Subject& subject) {
  std::vector<BodyId> bodies;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (world.is_alive(body) && world.body_type(body) == type && world.shapes_of(body, {}) > 0)
      bodies.push_back(body);
  }
  std::vector<ShapeId> shapes;
  for (const BodyId body : without_strays(world, std::move(bodies))) add_shapes(world, body, shapes, subject);
}

void measure(Subject& subject) {
  const LocalBox box = around(subject.corners);
  subject.middle = 0.5f * box.lower + 0.5f * box.upper;
  // At least some units in the last place of where it is.
  const Vec3 far = subject.middle;
  subject.reach = std::max(1e-4f, 4e-6f * std::max({std::abs(far.x), std::abs(far.y), std::abs(far.z)}));
  for (const Vec3& corner : subject.corners)
    subject.reach = std::max(subject.reach, distance(corner, subject.middle));
}

// The axes of what looks at the world from the front.
Axes front_axes(Vec3 up) {
  const Vec3 sideways = std::abs(dot(up, kX)) < 0.9f ? kX : kZ;
  const Vec3 right = normalize(sideways - dot(sideways, up) * up);
  return {right, up, cross(right, up)};
}

// Unit, from the subject to the camera.
Vec3 direction_of(Side side, const Axes& front) {
  switch (side) {
    case Side::front:
      return front.backward;
    case Side::side:
      return front.right;
    case Side::top:
      return front.up;
    case Side::corner:
      break;
  }
  return normalize(0.45f * front.right + 0.36f * front.up + 0.82f * front.backward);
}

// A corner x to the right and z ahead of the camera's position p lies between the edges of the picture, which
// are at +-h, if +-(x - p_x) cos h <= (z - p_z) sin h. Of the two bounds on p that the corners set, the
// nearest p meets both.
struct Fit {
  double beside, ahead;
};

Fit fit(std::span<const Vec3> corners, Vec3 middle, Vec3 sideways, Vec3 forward, double half_view) {
  const double c = std::cos(half_view), s = std::sin(half_view);
  double most_right = -std::numeric_limits<double>::infinity(), most_left = most_right;
  for (const Vec3& corner : corners) {
    const double x = double{dot(corner - middle, sideways)}, z = double{dot(corner - middle, forward)};
    most_right = std::max(most_right, x * c - z * s);
    most_left = std::max(most_left, -x * c - z * s);
  }
  return {(most_right - most_left) / (2.0 * c), -(most_right + most_left) / (2.0 * s)};
}

}  // namespace

Axes axes_of(const Camera& camera) {
  const Vec3 backward = normalize(camera.eye - camera.target);
  Vec3 right = cross(camera.up, backward);
  if (length(right) < 1e-4f) right = front_axes(camera.up).right;
  right = normalize(right);
  return {right, cross(backward, right), backward};
}

Subject subject_of(const World& world) {
  Subject subject;
  const Vec3 gravity = world.settings().gravity;
  if (const Vec3 down = normalize(gravity); down != Vec3{}) subject.up = -down;
  add_bodies(world, BodyType::dynamic, subject);
  Subject driven;
  add_bodies(world, BodyType::kinematic, driven);
  if (!driven.corners.empty()) {
    measure(driven);
    // A kinematic floor may be of any size.
    if (!subject.corners.empty()) measure(subject);
    if (subject.corners.empty() || driven.reach < kFar * subject.reach) subject = join(subject, driven);
  }
  if (subject.corners.empty()) add_bodies(world, BodyType::fixed, subject);
  if (subject.corners.empty()) {
    for (int corner = 0; corner < Subject::kCorners; ++corner)
      subject.corners.push_back(
          {corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f});
    subject.owners.emplace_back();
  }
  measure(subject);
  return subject;
}

Subject join(const Subject& first, const Subject& second) {
  Subject both = first;
  both.corners.insert(both.corners.end(), second.corners.begin(), second.corners.end());
  both.owners.insert(both.owners.end(), second.owners.begin(), second.owners.end());
  measure(both);
  return both;
}

Camera look_from(Side side, const Subject& subject, double view, double aspect) {
  constexpr double kMargin = 0.94;  // of the picture is filled
  Camera camera{subject.middle + direction_of(side, front_axes(subject.up)), subject.middle, subject.up,
                view};
  const Axes axes = axes_of(camera);
  const double tangent = kMargin * std::tan(0.5 * view * std::numbers::pi / 180.0);
  const Vec3 forward = -axes.backward;
  const Fit across = fit(subject.corners, subject.middle, axes.right, forward, std::atan(tangent * aspect));
  const Fit upright = fit(subject.corners, subject.middle, axes.up, forward, std::atan(tangent));
  // At least the subject's size away, so that a single point is not looked at from within.
  const double ahead = std::min({across.ahead, upright.ahead, -double{subject.reach}});
  camera.eye = subject.middle + static_cast<float>(across.beside) * axes.right +
               static_cast<float>(upright.beside) * axes.up + static_cast<float>(ahead) * forward;
  camera.target = camera.eye - static_cast<float>(ahead) * forward;
  return camera;
}

}  // namespace scree::render
