// Checks arguments of callers; see check.h.
#include <core/world/check.h>
#include <core/world/number_text.h>

#include <limits>

namespace scree {

namespace {

constexpr int kDigits = 9;  // all of a float
std::string text_of(double value) { return number_text(value, kDigits); }

double length_of(Quat q) {
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  return std::sqrt(x * x + y * y + z * z + w * w);
}

}  // namespace

std::string title(Call call) {
  const std::string message = std::string(call.owner) + call.name;
  return call.item >= 0 ? message + ": " + call.items + " " + std::to_string(call.item) : message;
}

void fail(Call call, const std::string& problem, ErrorCode code) {
  throw Error(title(call) + ": " + problem, code);
}

void check_room(Call call, const char* what, std::size_t rows, std::size_t more) {
  constexpr std::size_t kMaxRows = std::numeric_limits<std::int32_t>::max();
  if (more <= kMaxRows - rows) return;
  fail(call,
       "a world holds at most " + std::to_string(kMaxRows) + " " + what + ", asked for " +
           std::to_string(more) + " more",
       ErrorCode::too_many);
}

void fail_range(Call call, const char* what, double value, double low, double high) {
  fail(call, std::string(what) + " is " + text_of(value) + ", must lie in [" + text_of(low) + ", " +
                 text_of(high) + "]");
}

void fail_handle(Call call, const char* kind, std::uint32_t index, std::uint32_t generation, bool is_own) {
  if (generation == 0) fail(call, std::string("the handle names no ") + kind, ErrorCode::dead_handle);
  if (index == kWorld.index && generation == kWorld.generation) {
    fail(call, "the handle is kWorld, which only joints take", ErrorCode::dead_handle);
  }
  const std::string name = "index " + std::to_string(index) + ", generation " + std::to_string(generation);
  if (!is_own) {
    fail(call, std::string("the ") + kind + " of " + name + " belongs to another world",
         ErrorCode::foreign_handle);
  }
  fail(call, std::string("no ") + kind + " lives under " + name + ": it was destroyed",
       ErrorCode::dead_handle);
}

bool is_unit(Quat rotation) {
  const double length = length_of(rotation);
  return length >= 1.0 - kUnitTolerance && length <= 1.0 + kUnitTolerance;
}

void check_rotation(Call call, const char* what, Quat rotation) {
  if (is_unit(rotation)) return;
  fail(call, std::string(what) + " has length " + text_of(length_of(rotation)) + ", must be 1 within " +
                 text_of(kUnitTolerance));
}

void check_pose(Call call, const char* position, const char* rotation, const Pose& pose, float limit) {
  check_vector(call, position, pose.position, limit);
  check_rotation(call, rotation, pose.rotation);
}

void check_body_type(Call call, BodyType type) {
  if (type > BodyType::dynamic) fail_range(call, "type", static_cast<int>(type), 0, 2);
}

void check_locks(Call call, AxisLocks locks) {
  if (static_cast<unsigned>(locks) > kMotionLocksMask) {
    fail_range(call, "locks", static_cast<unsigned>(locks), 0, kMotionLocksMask);
  }
}

void check_body_def(Call call, const BodyDef& def) {
  check_body_type(call, def.type);
  check_vector(call, "position", def.position, kMaxPosition);
  check_rotation(call, "rotation", def.rotation);
  check_vector(call, "linear_velocity", def.linear_velocity, kMaxSpeed);
  check_vector(call, "angular_velocity", def.angular_velocity, kMaxSpeed);
  check_range(call, "linear_damping", def.linear_damping, 0.0f, kMaxRate);
  check_range(call, "angular_damping", def.angular_damping, 0.0f, kMaxRate);
  check_range(call, "gravity_factor", def.gravity_factor, -kMaxGravityFactor, kMaxGravityFactor);
  check_locks(call, def.locks);
  if (def.mass) check_range(call, "mass", *def.mass, kMinMass, kMaxMass);
}

void check_geometry(Call call, const Geometry& geometry) {
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    check_range(call, "sphere radius", sphere->radius, kMinExtent, kMaxExtent);
  } else if (const auto* capsule = std::get_if<Capsule>(&geometry)) {
    check_range(call, "capsule half_height", capsule->half_height, kMinExtent, kMaxExtent);
    check_range(call, "capsule radius", capsule->radius, kMinExtent, kMaxExtent);
  } else if (const auto* box = std::get_if<Box>(&geometry)) {
    check_range(call, "box half_extents.x", box->half_extents.x, kMinExtent, kMaxExtent);
    check_range(call, "box half_extents.y", box->half_extents.y, kMinExtent, kMaxExtent);
    check_range(call, "box half_extents.z", box->half_extents.z, kMinExtent, kMaxExtent);
    check_range(call, "box rounding", box->rounding, 0.0f, kMaxExtent);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    check_range(call, "cylinder half_height", cylinder->half_height, kMinExtent, kMaxExtent);
    check_range(call, "cylinder radius", cylinder->radius, kMinExtent, kMaxExtent);
  } else if (const auto* cone = std::get_if<Cone>(&geometry)) {
    check_range(call, "cone half_height", cone->half_height, kMinExtent, kMaxExtent);
    check_range(call, "cone radius", cone->radius, kMinExtent, kMaxExtent);
  } else if (const auto* convex = std::get_if<ConvexHull>(&geometry)) {
    if (convex->hull.is_empty()) fail(call, "the hull is empty: it was made of no points, or moved from");
    check_range(call, "hull scale.x", convex->scale.x, kMinHullScale, kMaxHullScale);
    check_range(call, "hull scale.y", convex->scale.y, kMinHullScale, kMaxHullScale);
    check_range(call, "hull scale.z", convex->scale.z, kMinHullScale, kMaxHullScale);
    check_range(call, "hull rounding", convex->rounding, 0.0f, kMaxExtent);
  } else if (const auto* mesh = std::get_if<TriangleMesh>(&geometry)) {
    if (mesh->is_empty()) fail(call, "the mesh is empty: it was made of no triangles, or moved from");
  } else if (!std::holds_alternative<HalfSpace>(geometry)) {
    fail(call, "geometry holds no value");
  }
}

bool may_be_dynamic(const Geometry& geometry) {
  return !std::holds_alternative<TriangleMesh>(geometry) && !std::holds_alternative<HalfSpace>(geometry);
}

void check_place(Call call, const Geometry& geometry, BodyType body, bool sensor) {
  if (may_be_dynamic(geometry)) return;
  const std::string name =
      std::holds_alternative<TriangleMesh>(geometry) ? "a triangle mesh" : "a half-space";
  if (body == BodyType::dynamic) {
    fail(call, name + " belongs to fixed and kinematic bodies only, but the body is dynamic",
         ErrorCode::wrong_state);
  }
  if (sensor) fail(call, name + " is no sensor, but the shape is one");
}

void check_may_be_dynamic(Call call, const WorldData& data, std::int32_t body) {
  const Shapes& shapes = data.shapes;
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = shapes.next[shape]) {
    const bool is_mesh = shapes.type[shape] == ShapeType::mesh;
    if (!is_mesh && shapes.type[shape] != ShapeType::half_space) continue;
    fail(call,
         "shape " + std::to_string(shape) + " of the body is " +
             (is_mesh ? "a triangle mesh" : "a half-space") +
             ", which belongs to fixed and kinematic bodies only",
         ErrorCode::wrong_state);
  }
}

void check_material(Call call, const Material& material) {
  check_range(call, "friction", material.friction, 0.0f, kMaxFriction);
  check_range(call, "restitution", material.restitution, 0.0f, 1.0f);
  check_range(call, "rolling_resistance", material.rolling_resistance, 0.0f, kMaxRollingResistance);
  if (material.patch_radius) check_range(call, "patch_radius", *material.patch_radius, 0.0f, kMaxPatchRadius);
  check_range(call, "density", material.density, kMinDensity, kMaxDensity);
  check_vector(call, "surface_velocity", material.surface_velocity, kMaxSurfaceSpeed);
  if (material.friction_mix > MixRule::maximum) {
    fail_range(call, "friction_mix", static_cast<int>(material.friction_mix), 0, 4);
  }
  if (material.restitution_mix > MixRule::maximum) {
    fail_range(call, "restitution_mix", static_cast<int>(material.restitution_mix), 0, 4);
  }
}

void check_events(Call call, ContactEvents events) {
  if (events > ContactEvents::all) {
    fail_range(call, "contact_events", static_cast<int>(events), 0, static_cast<int>(ContactEvents::all));
  }
}

void check_hooks(Call call, ContactHooks hooks) {
  if (hooks > ContactHooks::all) fail_range(call, "contact_hooks", static_cast<int>(hooks), 0, 3);
}

void check_options(Call call, const ShapeOptions& options) {
  check_events(call, options.contact_events);
  check_hooks(call, options.contact_hooks);
  check_pose(call, "local_pose.position", "local_pose.rotation", options.local_pose, kMaxLocalPosition);
}

namespace {

void check_solver(Call call, Solver solver, const SolverOptions& options) {
  if (static_cast<int>(solver) >= kSolverCount)
    fail_range(call, "solver", static_cast<int>(solver), 0, kSolverCount - 1);
  if (options.iterations < 1 || options.iterations > kMaxIterations)
    fail_range(call, "solver_options.iterations", options.iterations, 1, kMaxIterations);
  check_range(call, "solver_options.tolerance", options.tolerance, 0.0f, kMaxTolerance);
  check_range(call, "solver_options.relaxation", options.relaxation, 0.0f, kMaxRelaxation);
  check_range(call, "solver_options.baumgarte", options.baumgarte, 0.0f, 1.0f);
  check_range(call, "solver_options.slop", options.slop, 0.0f, kMaxSlop);
}

}  // namespace

void check_settings(Call call, const WorldSettings& settings) {
  check_events(call, settings.contact_events);
  check_vector(call, "gravity", settings.gravity, kMaxGravity);
  if (settings.substeps < 1 || settings.substeps > kMaxSubsteps) {
    fail_range(call, "substeps", settings.substeps, 1, kMaxSubsteps);
  }
  check_range(call, "contact_hertz", settings.contact_hertz, kMinHertz, kMaxHertz);
  check_range(call, "contact_damping_ratio", settings.contact_damping_ratio, 0.0f, kMaxDampingRatio);
  check_range(call, "push_speed", settings.push_speed, 0.0f, kMaxRate);
  check_range(call, "restitution_threshold", settings.restitution_threshold, 0.0f, kMaxThreshold);
  check_range(call, "hit_event_speed", settings.hit_event_speed, 0.0f, kMaxThreshold);
  check_range(call, "max_linear_speed", settings.max_linear_speed, kMinSpeedLimit, kMaxSpeedLimit);
  check_range(call, "max_angular_speed", settings.max_angular_speed, kMinSpeedLimit, kMaxSpeedLimit);
  check_range(call, "sleep_linear_speed", settings.sleep_linear_speed, 0.0f, kMaxThreshold);
  check_range(call, "sleep_angular_speed", settings.sleep_angular_speed, 0.0f, kMaxThreshold);
  check_range(call, "sleep_time", settings.sleep_time, 0.0f, kMaxThreshold);
  check_solver(call, settings.solver, settings.solver_options);
}

}  // namespace scree
