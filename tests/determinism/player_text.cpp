// Prints arguments of random calls for their log; see player_values.h.
#include <core/constraints/joint_parameters.h>
#include <tests/determinism/player_values.h>

#include <cstdio>

namespace scree::determinism {

void print(std::ostream& out, float value) {
  // Nine digits reproduce every float.
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(value));
  out << text;
}
void print(std::ostream& out, int value) { out << value; }
void print(std::ostream& out, std::uint32_t value) { out << value; }
void print(std::ostream& out, bool value) { out << (value ? "true" : "false"); }
void print(std::ostream& out, const char* value) { out << value; }
void print(std::ostream& out, Vec3 value) {
  out << "{";
  print(out, value.x);
  out << ", ";
  print(out, value.y);
  out << ", ";
  print(out, value.z);
  out << "}";
}

void print(std::ostream& out, Quat value) {
  out << "{";
  print(out, value.x);
  for (const float component : {value.y, value.z, value.w}) {
    out << ", ";
    print(out, component);
  }
  out << "}";
}

namespace {

// Prints ".name = value", with a separator before all but the first.
template <class Value>
void field(std::ostream& out, const char* name, const Value& value, bool first = false) {
  out << (first ? "{." : ", .") << name << " = ";
  print(out, value);
}

}  // namespace

void print(std::ostream& out, const Pose& value) {
  out << "{";
  print(out, value.position);
  out << ", ";
  print(out, value.rotation);
  out << "}";
}

void print(std::ostream& out, const Geometry& value) {
  if (const auto* sphere = std::get_if<Sphere>(&value)) {
    out << "Sphere";
    field(out, "radius", sphere->radius, true);
  } else if (const auto* capsule = std::get_if<Capsule>(&value)) {
    out << "Capsule";
    field(out, "half_height", capsule->half_height, true);
    field(out, "radius", capsule->radius);
  } else if (const auto* convex = std::get_if<ConvexHull>(&value)) {
    out << "ConvexHull{.points = ";
    for (const Vec3& vertex : convex->hull.vertices()) print(out, vertex);
    field(out, "scale", convex->scale);
    field(out, "rounding", convex->rounding);
  } else if (const auto* mesh = std::get_if<TriangleMesh>(&value)) {
    out << "TriangleMesh{.vertices = ";
    for (const Vec3& vertex : mesh->vertices()) print(out, vertex);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&value)) {
    out << "Cylinder";
    field(out, "half_height", cylinder->half_height, true);
    field(out, "radius", cylinder->radius);
  } else if (const auto* cone = std::get_if<Cone>(&value)) {
    out << "Cone";
    field(out, "half_height", cone->half_height, true);
    field(out, "radius", cone->radius);
  } else {
    out << "Box";
    field(out, "half_extents", std::get<Box>(value).half_extents, true);
    field(out, "rounding", std::get<Box>(value).rounding);
  }
  out << "}";
}

void print(std::ostream& out, const Material& value) {
  field(out, "friction", value.friction, true);
  field(out, "restitution", value.restitution);
  field(out, "rolling_resistance", value.rolling_resistance);
  field(out, "density", value.density);
  if (value.patch_radius) field(out, "patch_radius", *value.patch_radius);
  field(out, "surface_velocity", value.surface_velocity);
  field(out, "friction_mix", static_cast<int>(value.friction_mix));
  field(out, "restitution_mix", static_cast<int>(value.restitution_mix));
  out << "}";
}

void print(std::ostream& out, const Filter& value) {
  field(out, "category", value.category, true);
  field(out, "mask", value.mask);
  field(out, "group", static_cast<int>(value.group));
  out << "}";
}

void print(std::ostream& out, const BodyDef& value) {
  field(out, "type", static_cast<int>(value.type), true);
  field(out, "position", value.position);
  field(out, "rotation", value.rotation);
  field(out, "linear_velocity", value.linear_velocity);
  field(out, "angular_velocity", value.angular_velocity);
  field(out, "linear_damping", value.linear_damping);
  field(out, "angular_damping", value.angular_damping);
  field(out, "gravity_factor", value.gravity_factor);
  field(out, "locks", static_cast<int>(value.locks));
  if (value.mass) field(out, "mass", *value.mass);
  field(out, "can_sleep", value.can_sleep);
  out << "}";
}

void print(std::ostream& out, const MassProperties& value) {
  field(out, "mass", value.mass, true);
  field(out, "center", value.center);
  field(out, "inertia", Vec3{value.inertia[0], value.inertia[1], value.inertia[2]});
  out << "}";
}

void print(std::ostream& out, const WorldSettings& value) {
  field(out, "gravity", value.gravity, true);
  field(out, "substeps", value.substeps);
  field(out, "contact_hertz", value.contact_hertz);
  field(out, "contact_damping_ratio", value.contact_damping_ratio);
  field(out, "push_speed", value.push_speed);
  field(out, "restitution_threshold", value.restitution_threshold);
  field(out, "max_linear_speed", value.max_linear_speed);
  field(out, "max_angular_speed", value.max_angular_speed);
  field(out, "continuous", value.continuous);
  field(out, "warm_start", value.warm_start);
  field(out, "sleeping", value.sleeping);
  field(out, "sleep_linear_speed", value.sleep_linear_speed);
  field(out, "sleep_angular_speed", value.sleep_angular_speed);
  field(out, "sleep_time", value.sleep_time);
  field(out, "contact_events", static_cast<int>(value.contact_events));
  field(out, "hit_event_speed", value.hit_event_speed);
  field(out, "contact_forces", value.contact_forces);
  field(out, "measure_residual", value.measure_residual);
  field(out, "measure_penetration", value.measure_penetration);
  const SolverOptions& options = value.solver_options;
  field(out, "solver", static_cast<int>(value.solver));
  field(out, "iterations", options.iterations);
  field(out, "tolerance", options.tolerance);
  field(out, "relaxation", options.relaxation);
  field(out, "baumgarte", options.baumgarte);
  field(out, "slop", options.slop);
  field(out, "shuffle_seed", options.shuffle_seed);
  field(out, "points_together", options.points_together);
  out << "}";
}

void print(std::ostream& out, BodyId value) { out << "body " << value.index << "/" << value.generation; }
void print(std::ostream& out, ShapeId value) { out << "shape " << value.index << "/" << value.generation; }

void print(std::ostream& out, JointId value) {
  out << "joint " << value.index;
  if (value.generation != 1) out << ", generation " << value.generation;
}
void print(std::ostream& out, const Joint& value) { out << name_of(type_of(value)); }
void print(std::ostream& out, const JointDef& value) {
  print(out, value.body_a);
  out << " to ";
  print(out, value.body_b);
  out << " at ";
  print(out, value.frame_a);
  out << " and ";
  print(out, value.frame_b);
  if (value.collide_connected) out << ", colliding";
  if (!value.enabled) out << ", disabled";
}

}  // namespace scree::determinism
