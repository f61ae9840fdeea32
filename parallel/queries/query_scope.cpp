// The scope of a query; see query_scope.h.
#include <parallel/queries/query_scope.h>

#include <cmath>
#include <string>
#include <utility>

namespace scree::queries {

namespace {

constexpr unsigned bit_of(BodyType type) { return 1u << static_cast<unsigned>(type); }
static_assert(bit_of(BodyType::fixed) == static_cast<unsigned>(BodyTypes::fixed));
static_assert(bit_of(BodyType::kinematic) == static_cast<unsigned>(BodyTypes::kinematic));
static_assert(bit_of(BodyType::dynamic) == static_cast<unsigned>(BodyTypes::dynamic));

bool takes_all(const WorldData& data, const QueryOptions& options) {
  return (options.sensors || data.shapes.sensors == 0) && !options.filter &&
         options.types == BodyTypes::all && options.ignored.generation == 0 && !options.predicate;
}

const WorldData& checked_data(Call call, const World& world, const QueryOptions& options) {
  const WorldData& data = internals(world, call.name);
  check_options(call, data, options);
  return data;
}

}  // namespace

void check_options(Call call, const WorldData& data, const QueryOptions& options) {
  if (options.types > BodyTypes::all) fail_range(call, "types", static_cast<double>(options.types), 0, 7);
  if (options.start_inside > StartInside::skip) {
    fail_range(call, "start_inside", static_cast<double>(options.start_inside), 0, 1);
  }
  if (options.ignored != BodyId{}) checked_row(call, data, options.ignored);
}

void check_length(Call call, const char* what, std::size_t length, std::size_t queries) {
  if (length == queries) return;
  fail(call, std::string(what) + " has room for " + std::to_string(length) + ", but there are " +
                 std::to_string(queries) + " queries");
}

void check_point(Call call, const char* what, Vec3 point) { check_vector(call, what, point, kMaxPosition); }

void check_translation(Call call, Vec3 translation) {
  check_vector(call, "translation", translation, 2.0f * kMaxPosition);
}

void check_placed(Call call, const Geometry& geometry, const Pose& pose) {
  check_geometry(call, geometry);
  check_pose(call, "position", "rotation", pose, kMaxPosition);
  if (std::holds_alternative<TriangleMesh>(geometry)) fail(call, "a triangle mesh cannot be cast or placed");
  if (std::holds_alternative<HalfSpace>(geometry)) fail(call, "a half-space cannot be cast or placed");
  const auto* convex = std::get_if<ConvexHull>(&geometry);
  if (convex == nullptr) return;
  for (const Vec3& corner : convex->hull.vertices()) {
    const Vec3 scale = convex->scale;
    check_vector(call, "scaled hull's corner", {corner.x * scale.x, corner.y * scale.y, corner.z * scale.z},
                 kMaxExtent);
  }
}

namespace {

constexpr double kBoxRounding = 1e-6;  // of coordinates: more than boxes and places are rounded by

}  // namespace

simd::MeetTask task_of(const Solid& solid) {
  const Vector reach = reach_of(solid);
  simd::MeetTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = solid.position[axis];
    const double half = reach[axis] + kBoxRounding * (std::abs(middle) + reach[axis]);
    task.lower[axis] = static_cast<float>(middle - half);
    task.upper[axis] = static_cast<float>(middle + half);
  }
  return task;
}

simd::CrossTask task_of(const Solid& solid, Vec3 translation) {
  constexpr float kLeast = 1.0f / simd::kLargestInverse;
  const Vector reach = reach_of(solid);
  const bool is_point = !(length(reach) > 0.0);  // whose place is a float, and exact
  simd::CrossTask task{};
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = solid.position[axis];
    const float way = translation[axis];
    task.origin[axis] = static_cast<float>(origin);
    task.inverse[axis] = std::abs(way) > kLeast ? 1.0f / way : std::copysign(simd::kLargestInverse, way);
    task.half[axis] = is_point
                          ? 0.0f
                          : static_cast<float>(reach[axis] + kBoxRounding * (std::abs(origin) + reach[axis] +
                                                                             std::abs(double{way})));
  }
  return task;
}

bool agree(const Filter& a, const Filter& b) {
  if (a.group != 0 && a.group == b.group) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

const simd::Kernels& query_kernels() {
  static const simd::Kernels& kernels = simd::widest_kernels();
  return kernels;
}

Scope::Scope(const WorldData& world_data, const simd::Kernels& chosen, const QueryOptions& given)
    : data(world_data),
      index(query_index_of(world_data, chosen)),
      kernels(chosen),
      options(given),
      takes_all(queries::takes_all(world_data, given)) {}

OwnScope::OwnScope(Call call, const World& world, const QueryOptions& options)
    : scope(checked_data(call, world, options), query_kernels(), options) {}

bool passes(const Scope& scope, std::int32_t shape) {
  const Shapes& shapes = scope.data.shapes;
  const QueryOptions& options = scope.options;
  if (scope.takes_all) return true;
  if (!options.sensors && is_sensor(shapes, shape)) return false;
  const std::int32_t body = shapes.body[shape];
  const unsigned type = bit_of(given_type(scope.data.bodies, body));
  if ((type & static_cast<unsigned>(options.types)) == 0) return false;
  if (options.filter && !agree(*options.filter, shapes.filter[shape])) return false;
  if (options.ignored.generation != 0 && std::cmp_equal(options.ignored.index, body)) return false;
  return !options.predicate ||
         options.predicate(shape_handle(scope.data, shape), body_handle(scope.data, body));
}

}  // namespace scree::queries
