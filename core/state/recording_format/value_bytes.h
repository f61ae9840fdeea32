// Values as bytes: numbers one behind the other in little-endian order. Each struct lists its fields once,
// for writing and reading.
//
// The lists are part of the formats of snapshots and recordings: a new field changes their versions.
#pragma once

#include <core/state/snapshot/snapshot_bytes.h>
#include <scree/world.h>

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace scree {

template <class Value, class Struct>
concept Of = std::is_same_v<std::remove_const_t<Value>, Struct>;
// Of any kind of object; see ids.h. The world is left out: a reader has another one.
template <class Value>
concept Handle = sizeof(Value) == 12 && requires(Value id) {
  { id.index } -> std::convertible_to<std::uint32_t>;
  { id.generation } -> std::convertible_to<std::uint32_t>;
};

void fields(Of<Vec3> auto& v, auto&& visit) {
  visit(v.x);
  visit(v.y);
  visit(v.z);
}
void fields(Of<Quat> auto& q, auto&& visit) {
  visit(q.x);
  visit(q.y);
  visit(q.z);
  visit(q.w);
}
void fields(Of<Pose> auto& pose, auto&& visit) {
  visit(pose.position);
  visit(pose.rotation);
}
void fields(Handle auto& id, auto&& visit) {
  visit(id.index);
  visit(id.generation);
}
void fields(Of<BodyDef> auto& def, auto&& visit) {
  static_assert(sizeof(BodyDef) == 96, "a new field goes here, too");
  visit(def.type);
  visit(def.position);
  visit(def.rotation);
  visit(def.linear_velocity);
  visit(def.angular_velocity);
  visit(def.linear_damping);
  visit(def.angular_damping);
  visit(def.gravity_factor);
  visit(def.locks);
  visit(def.mass);
  visit(def.can_sleep);
  visit(def.full_sweep);
  visit(def.user_data);
}
void fields(Of<MassProperties> auto& properties, auto&& visit) {
  static_assert(sizeof(MassProperties) == 40, "a new field goes here, too");
  visit(properties.mass);
  visit(properties.center);
  for (auto& moment : properties.inertia) visit(moment);
}
void fields(Of<Sphere> auto& sphere, auto&& visit) { visit(sphere.radius); }
void fields(Of<Capsule> auto& capsule, auto&& visit) {
  visit(capsule.half_height);
  visit(capsule.radius);
}
void fields(Of<Box> auto& box, auto&& visit) {
  static_assert(sizeof(Box) == 16, "a new field goes here, too");
  visit(box.half_extents);
  visit(box.rounding);
}
void fields(Of<Cylinder> auto& cylinder, auto&& visit) {
  visit(cylinder.half_height);
  visit(cylinder.radius);
}
void fields(Of<Cone> auto& cone, auto&& visit) {
  visit(cone.half_height);
  visit(cone.radius);
}
void fields(Of<HalfSpace> auto&, auto&&) {}
void fields(Of<ConvexHull> auto& convex, auto&& visit) {
  visit(convex.hull);
  visit(convex.scale);
  visit(convex.rounding);
}
void fields(Of<Material> auto& material, auto&& visit) {
  static_assert(sizeof(Material) == 40, "a new field goes here, too");
  visit(material.friction);
  visit(material.restitution);
  visit(material.rolling_resistance);
  visit(material.patch_radius);
  visit(material.density);
  visit(material.surface_velocity);
  visit(material.friction_mix);
  visit(material.restitution_mix);
}
void fields(Of<Filter> auto& filter, auto&& visit) {
  visit(filter.category);
  visit(filter.mask);
  visit(filter.group);
}
void fields(Of<ShapeOptions> auto& options, auto&& visit) {
  static_assert(sizeof(ShapeOptions) == 56, "a new field goes here, too");
  visit(options.local_pose);
  visit(options.filter);
  visit(options.user_data);
  visit(options.contact_events);
  visit(options.sensor);
  visit(options.contact_hooks);
}
void fields(Of<ShapeDef> auto& def, auto&& visit) {
  visit(def.geometry);
  visit(def.material);
  visit(def.options);
}
void fields(Of<SolverOptions> auto& options, auto&& visit) {
  static_assert(sizeof(SolverOptions) == 28, "a new field goes here, too");
  visit(options.iterations);
  visit(options.tolerance);
  visit(options.relaxation);
  visit(options.baumgarte);
  visit(options.slop);
  visit(options.shuffle_seed);
  visit(options.points_together);
}
void fields(Of<WorldSettings> auto& settings, auto&& visit) {
  static_assert(sizeof(WorldSettings) == 96, "a new field goes here, too");
  visit(settings.gravity);
  visit(settings.substeps);
  visit(settings.contact_hertz);
  visit(settings.contact_damping_ratio);
  visit(settings.push_speed);
  visit(settings.restitution_threshold);
  visit(settings.max_linear_speed);
  visit(settings.max_angular_speed);
  visit(settings.continuous);
  visit(settings.warm_start);
  visit(settings.sleeping);
  visit(settings.sleep_linear_speed);
  visit(settings.sleep_angular_speed);
  visit(settings.sleep_time);
  visit(settings.contact_events);
  visit(settings.hit_event_speed);
  visit(settings.contact_forces);
  visit(settings.measure_residual);
  visit(settings.measure_penetration);
  visit(settings.solver);
  visit(settings.solver_options);
}
void fields(Of<JointDef> auto& def, auto&& visit) {
  static_assert(sizeof(JointDef) == 120, "a new field goes here, too");
  visit(def.body_a);
  visit(def.body_b);
  visit(def.frame_a);
  visit(def.frame_b);
  visit(def.collide_connected);
  visit(def.enabled);
  visit(def.hertz);
  visit(def.damping_ratio);
  visit(def.break_force);
  visit(def.break_torque);
  visit(def.event_force);
  visit(def.event_torque);
  visit(def.user_data);
}
void fields(Of<JointAxis> auto& axis, auto&& visit) {
  static_assert(sizeof(JointAxis) == 32, "a new field goes here, too");
  visit(axis.lower);
  visit(axis.upper);
  visit(axis.drive);
  visit(axis.target);
  visit(axis.speed);
  visit(axis.hertz);
  visit(axis.damping_ratio);
  visit(axis.max_force);
}
void fields(Of<RotationDrive> auto& drive, auto&& visit) {
  static_assert(sizeof(RotationDrive) == 44, "a new field goes here, too");
  visit(drive.drive);
  visit(drive.target);
  visit(drive.velocity);
  visit(drive.hertz);
  visit(drive.damping_ratio);
  visit(drive.max_torque);
}
void fields(Of<BallJoint> auto& ball, auto&& visit) {
  static_assert(sizeof(BallJoint) == 56, "a new field goes here, too");
  visit(ball.cone_limit);
  visit(ball.twist_lower);
  visit(ball.twist_upper);
  visit(ball.drive);
}
void fields(Of<HingeJoint> auto& hinge, auto&& visit) { visit(hinge.angle); }
void fields(Of<SliderJoint> auto& slider, auto&& visit) { visit(slider.offset); }
void fields(Of<DistanceJoint> auto& distance, auto&& visit) { visit(distance.length); }
void fields(Of<WeldJoint> auto& weld, auto&& visit) {
  static_assert(sizeof(WeldJoint) == 8, "a new field goes here, too");
  visit(weld.angular_hertz);
  visit(weld.angular_damping_ratio);
}
void fields(Of<SixDegreeJoint> auto& joint, auto&& visit) {
  for (auto& axis : joint.offset) visit(axis);
  for (auto& axis : joint.angle) visit(axis);
}
void fields(Of<WheelJoint> auto& wheel, auto&& visit) {
  visit(wheel.suspension);
  visit(wheel.steering);
  visit(wheel.spin);
}
void fields(Of<UniversalJoint> auto& universal, auto&& visit) {
  visit(universal.first);
  visit(universal.second);
}
void fields(Of<PlanarJoint> auto& planar, auto&& visit) {
  visit(planar.offset_y);
  visit(planar.offset_z);
  visit(planar.angle);
}
void fields(Of<GearJoint> auto& gear, auto&& visit) { visit(gear.ratio); }
void fields(Of<RackAndPinionJoint> auto& rack, auto&& visit) { visit(rack.radius); }
void fields(Of<PulleyJoint> auto& pulley, auto&& visit) {
  static_assert(sizeof(PulleyJoint) == 36, "a new field goes here, too");
  visit(pulley.point_a);
  visit(pulley.point_b);
  visit(pulley.ratio);
  visit(pulley.length);
  visit(pulley.rigid);
}
void fields(Of<MotorJoint> auto& motor, auto&& visit) {
  static_assert(sizeof(MotorJoint) == 84, "a new field goes here, too");
  visit(motor.rotation);
  visit(motor.drive);
  visit(motor.target);
  visit(motor.velocity);
  visit(motor.hertz);
  visit(motor.damping_ratio);
  visit(motor.max_force);
}
void fields(Of<MouseJoint> auto& mouse, auto&& visit) {
  static_assert(sizeof(MouseJoint) == 24, "a new field goes here, too");
  visit(mouse.target);
  visit(mouse.hertz);
  visit(mouse.damping_ratio);
  visit(mouse.max_force);
}
void fields(Of<UserJoint> auto& user, auto&& visit) {
  for (auto& row : user.rows) visit(row);
}
void fields(Of<UserRow> auto& row, auto&& visit) {
  static_assert(sizeof(UserRow) == 72, "a new field goes here, too");
  visit(row.jacobian.linear_a);
  visit(row.jacobian.angular_a);
  visit(row.jacobian.linear_b);
  visit(row.jacobian.angular_b);
  visit(row.target.error);
  visit(row.target.speed);
  visit(row.target.hertz);
  visit(row.target.damping_ratio);
  visit(row.bounds.lower);
  visit(row.bounds.upper);
}
void fields(Of<ContactAnswer> auto& answer, auto&& visit) {
  static_assert(sizeof(ContactAnswer) == 56, "a new field goes here, too");
  visit(answer.shape_a);
  visit(answer.shape_b);
  visit(answer.contact);
  visit(answer.rules.acts);
  visit(answer.rules.friction);
  visit(answer.rules.restitution);
  visit(answer.rules.rolling_resistance);
  visit(answer.rules.surface_velocity);
}
void fields(Of<SavedWorld> auto& world, auto&& visit) {
  SavedWorld::visit_members(world, TablePlace{"world"},
                            [&visit](const Member&, auto& value) { visit(value); });
}

// --- writing ---

template <class Writer, class Value>
void write_value(Writer& writer, const Value& value) {
  if constexpr (std::is_same_v<Value, bool> || std::is_enum_v<Value>) {
    writer.put(static_cast<std::uint8_t>(value));
  } else if constexpr (std::is_arithmetic_v<Value>) {
    writer.put(value);
  } else if constexpr (std::is_same_v<Value, Hull>) {
    writer.put_hull(value);
  } else if constexpr (std::is_same_v<Value, TriangleMesh>) {
    writer.put_mesh(value);
  } else {
    fields(value, [&writer](const auto& field) { write_value(writer, field); });
  }
}
// The world as an end is written as a handle of zeros.
template <class Writer>
void write_value(Writer& writer, const JointDef& given) {
  JointDef def = given;
  for (BodyId* end : {&def.body_a, &def.body_b}) {
    if (*end == kWorld) *end = BodyId{};
  }
  fields(def, [&writer](const auto& field) { write_value(writer, field); });
}
template <class Writer, class Value>
void write_value(Writer& writer, const std::optional<Value>& value) {
  write_value(writer, value.has_value());
  if (value) write_value(writer, *value);
}
template <class Writer, class... Kinds>
void write_value(Writer& writer, const std::variant<Kinds...>& value) {
  writer.put(static_cast<std::uint8_t>(value.index()));
  std::visit([&writer](const auto& kind) { write_value(writer, kind); }, value);
}
template <class Writer, class Value>
void write_value(Writer& writer, const std::span<const Value>& values) {
  writer.put(std::uint64_t{values.size()});
  for (const Value& value : values) write_value(writer, value);
}

// --- reading: what is no value of its type is refused; whether it is in range is for the caller to check ---

template <class Reader, class Value>
void read_value(Reader& reader, Value& value) {
  if constexpr (std::is_same_v<Value, bool>) {
    const std::size_t at = reader.at();
    const auto byte = reader.template take<std::uint8_t>();
    if (byte > 1) refuse_bytes(at, "a yes or no is " + std::to_string(byte));
    value = byte == 1;
  } else if constexpr (std::is_enum_v<Value>) {
    value = static_cast<Value>(reader.template take<std::uint8_t>());
  } else if constexpr (std::is_arithmetic_v<Value>) {
    value = reader.template take<Value>();
  } else if constexpr (std::is_same_v<Value, Hull>) {
    value = reader.take_hull();
  } else if constexpr (std::is_same_v<Value, TriangleMesh>) {
    value = reader.take_mesh();
  } else {
    fields(value, [&reader](auto& field) { read_value(reader, field); });
  }
}
template <class Reader>
void read_value(Reader& reader, JointDef& def) {
  fields(def, [&reader](auto& field) { read_value(reader, field); });
  for (BodyId* end : {&def.body_a, &def.body_b}) {
    if (*end == BodyId{}) *end = kWorld;
  }
}
template <class Reader, class Value>
void read_value(Reader& reader, std::optional<Value>& value) {
  bool has_value = false;
  read_value(reader, has_value);
  if (has_value) read_value(reader, value.emplace());
}
template <class Reader, class Variant, std::size_t... kIndex>
void read_kind(Reader& reader, std::size_t index, Variant& value, std::index_sequence<kIndex...>) {
  ((index == kIndex ? read_value(reader, value.template emplace<kIndex>()) : void()), ...);
}
template <class Reader, class... Kinds>
void read_value(Reader& reader, std::variant<Kinds...>& value) {
  constexpr const char* kName = Of<std::variant<Kinds...>, Joint> ? "joint" : "geometry";
  const std::size_t at = reader.at();
  const auto index = reader.template take<std::uint8_t>();
  if (index >= sizeof...(Kinds)) {
    refuse_bytes(at, std::string("there is no ") + kName + " of kind " + std::to_string(index));
  }
  read_kind(reader, index, value, std::index_sequence_for<Kinds...>());
}

struct ByteCounter {
  std::size_t bytes = 0;
  template <class Number>
  void put(Number) {
    bytes += sizeof(Number);
  }
  void put_hull(const Hull&) { bytes += sizeof(std::int32_t); }
  void put_mesh(const TriangleMesh&) { bytes += sizeof(std::int32_t); }
};
// Bytes of the shortest value of a type.
template <class Value>
struct LeastBytes {
  static std::size_t count() {
    ByteCounter counter;
    write_value(counter, Value{});
    return counter.bytes;
  }
};
template <class... Kinds>
struct LeastBytes<std::variant<Kinds...>> {
  static std::size_t count() { return 1 + std::min({LeastBytes<Kinds>::count()...}); }
};
// Also within another value, whose own default may be of a longer kind.
template <class... Kinds>
void write_value(ByteCounter& counter, const std::variant<Kinds...>&) {
  counter.bytes += LeastBytes<std::variant<Kinds...>>::count();
}
template <class Reader, class Value>
void read_value(Reader& reader, std::vector<Value>& values) {
  const std::size_t at = reader.at();
  const auto count = reader.template take<std::uint64_t>();
  if (count > reader.left() / LeastBytes<Value>::count())
    refuse_bytes(at, "a list is longer than what follows");
  values.resize(count);
  for (Value& value : values) read_value(reader, value);
}

}  // namespace scree
