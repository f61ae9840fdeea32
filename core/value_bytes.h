// Values as bytes: numbers one behind the other in little-endian order. Each struct lists its fields once,
// for writing and reading.
//
// The lists are part of the formats of snapshots and recordings: a new field changes their versions.
#pragma once

#include <core/snapshot_bytes.h>
#include <scree/world.h>

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
// Of any kind of object; see ids.h.
template <class Value>
concept Handle = sizeof(Value) == 8 && requires(Value id) {
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
void fields(Of<Box> auto& box, auto&& visit) { visit(box.half_extents); }
void fields(Of<ConvexHull> auto& convex, auto&& visit) {
  visit(convex.hull);
  visit(convex.scale);
}
void fields(Of<Material> auto& material, auto&& visit) {
  static_assert(sizeof(Material) == 32, "a new field goes here, too");
  visit(material.friction);
  visit(material.restitution);
  visit(material.rolling_resistance);
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
}
void fields(Of<WorldSettings> auto& settings, auto&& visit) {
  static_assert(sizeof(WorldSettings) == 60, "a new field goes here, too");
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
  visit(settings.measure_residual);
  visit(settings.measure_penetration);
}
void fields(Of<SavedWorld> auto& world, auto&& visit) {
  visit(world.settings);
  visit(world.step_count);
  visit(world.last_dt);
  visit(world.last_substep);
  visit(world.wake_requested);
  visit(world.manifolds_stale);
  visit(world.pairs_stale);
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
  } else {
    fields(value, [&writer](const auto& field) { write_value(writer, field); });
  }
}
template <class Writer, class Value>
void write_value(Writer& writer, const std::optional<Value>& value) {
  write_value(writer, value.has_value());
  if (value) write_value(writer, *value);
}
template <class Writer>
void write_value(Writer& writer, const Geometry& geometry) {
  writer.put(static_cast<std::uint8_t>(geometry.index()));
  std::visit([&writer](const auto& shape) { write_value(writer, shape); }, geometry);
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
  } else {
    fields(value, [&reader](auto& field) { read_value(reader, field); });
  }
}
template <class Reader, class Value>
void read_value(Reader& reader, std::optional<Value>& value) {
  bool has_value = false;
  read_value(reader, has_value);
  if (has_value) read_value(reader, value.emplace());
}
template <class Reader, std::size_t... kIndex>
void read_geometry(Reader& reader, std::size_t index, Geometry& geometry, std::index_sequence<kIndex...>) {
  ((index == kIndex ? read_value(reader, geometry.emplace<kIndex>()) : void()), ...);
}
template <class Reader>
void read_value(Reader& reader, Geometry& geometry) {
  const std::size_t at = reader.at();
  const auto index = reader.template take<std::uint8_t>();
  constexpr std::size_t kKinds = std::variant_size_v<Geometry>;
  if (index >= kKinds) refuse_bytes(at, "there is no geometry of kind " + std::to_string(index));
  read_geometry(reader, index, geometry, std::make_index_sequence<kKinds>());
}

struct ByteCounter {
  std::size_t bytes = 0;
  template <class Number>
  void put(Number) {
    bytes += sizeof(Number);
  }
  void put_hull(const Hull&) { bytes += sizeof(std::int32_t); }
};
// Bytes of the shortest value of a type.
template <class Value>
std::size_t least_bytes() {
  ByteCounter counter;
  write_value(counter, Value{});
  return counter.bytes;
}
template <class Reader, class Value>
void read_value(Reader& reader, std::vector<Value>& values) {
  const std::size_t at = reader.at();
  const auto count = reader.template take<std::uint64_t>();
  if (count > reader.left() / least_bytes<Value>()) refuse_bytes(at, "a list is longer than what follows");
  values.resize(static_cast<std::size_t>(count));
  for (Value& value : values) read_value(reader, value);
}

}  // namespace scree
