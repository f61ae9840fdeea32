// Calls that create, change, read and destroy one shape.
#include <core/geometry/balls.h>
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <scree/world.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

struct ShapeRow {
  WorldData& data;
  Shapes& shapes;
  std::int32_t shape;
  std::int32_t body;
  FpEnvironment environment{};  // not the caller's rounding
};

ShapeRow at(Call call, const std::unique_ptr<WorldData>& owner, ShapeId id) {
  WorldData& data = opened(call, owner);
  const std::int32_t shape = checked_row(call, data, id);
  return {data, data.shapes, shape, data.shapes.body[shape]};
}

ShapeForm form_of(const ShapeRow& s) {
  return {geometry_of(s.data, s.shape), solid_density(s.shapes, s.shape), s.shapes.given_pose[s.shape]};
}

// The body's mass rows after the change, or an Error.
BodyMass mass_after_change(Call call, const ShapeRow& s, std::span<const ShapeForm> forms) {
  const Bodies& bodies = s.data.bodies;
  return mass_after(call, s.data, s.body, given_type(bodies, s.body), bodies.flags[s.body], {s.shape, forms});
}

// The shape collides in another way now: finds its pairs again, and wakes its neighbors.
void reconsider(const ShapeRow& s, std::uint8_t flags) {
  mark_dirty(s.shapes, s.shape, flags);
  request_wake(s.data, s.shape);
  wake_body(s.data, s.body);
  s.data.contacts.pairs_stale = true;
}

// Shapes of one call, and what they need before anything is written.
struct NewShapes {
  std::vector<ShapeForm> forms;
  std::vector<SolidSlots> slots;
};

// Releases the slots of shapes that are not created, the last one first.
void drop_slots(WorldData& data, std::vector<SolidSlots>& slots, const SolidSlotCounts& before) {
  for (; !slots.empty(); slots.pop_back()) undo_slots(data, slots.back(), before);
}

// Throws for a bad definition; then nothing has changed.
NewShapes check_new(Call call, WorldData& data, std::int32_t body, std::span<const ShapeDef> defs) {
  NewShapes made;
  made.forms.reserve(defs.size());
  made.slots.reserve(defs.size());
  const SolidSlotCounts before(data);
  try {
    for (std::size_t i = 0; i < defs.size(); ++i) {
      const Call item = item_of(call, defs.size(), i);
      check_geometry(item, defs[i].geometry);
      check_material(item, defs[i].material);
      check_options(item, defs[i].options);
      check_place(item, defs[i].geometry, given_type(data.bodies, body), defs[i].options.sensor);
      const Pose& pose = defs[i].options.local_pose;
      made.forms.push_back({defs[i].geometry,
                            defs[i].options.sensor ? 0.0f : defs[i].material.density,
                            {pose.position, normalize(pose.rotation)}});
      made.slots.push_back(acquire_slots(item, data, defs[i].geometry));
    }
  } catch (...) {
    drop_slots(data, made.slots, before);
    throw;
  }
  return made;
}

// Adds the shapes to the body's list in their order.
void add(Call call, WorldData& data, std::int32_t body, std::span<const ShapeDef> defs,
         std::span<ShapeId> ids) {
  Shapes& shapes = data.shapes;
  const std::size_t old_rows = shapes.flags.size();
  const SolidSlotCounts before(data);
  check_room(call, "shapes", old_rows, defs.size());
  const SlotPlan plan(shapes.free_slots, old_rows, defs.size());
  NewShapes made = check_new(call, data, body, defs);
  const ShapeChange change{-1, made.forms};
  BodyMass mass;
  try {
    mass = mass_after(call, data, body, given_type(data.bodies, body), data.bodies.flags[body], change);
    grow(shapes, old_rows + defs.size() - plan.from_free);
  } catch (...) {
    drop_slots(data, made.slots, before);
    throw;
  }
  follow_change(data, body, change);
  wake_body(data, body);
  const bool has_core = data.bodies.unplaced[body] == 0 && !is_absent(data.bodies, body);
  for (std::size_t i = 0; i < defs.size(); ++i) {
    const std::int32_t shape = plan.slot(shapes.free_slots, i);
    ShapeOptions options = defs[i].options;
    options.local_pose = made.forms[i].local_pose;
    write_shape(data, shape, defs[i].geometry, made.slots[i], defs[i].material, options);
    link_shape(data, shape, body);
    ids[i] = commit_shape(data, shape, options.sensor);
    if (has_core) extend_core(data, body, shape);
  }
  take_slots(shapes, plan);
  apply_mass(data, body, mass);
  data.contacts.pairs_stale = true;
}

}  // namespace

ShapeId World::add_shape(BodyId body, const Geometry& geometry, const Material& material,
                         const ShapeOptions& options) {
  constexpr Call call{"add_shape"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::add_shape> call_record(data, body, geometry, material, options);
  const std::int32_t row = checked_row(call, data, body);
  const ShapeDef def{geometry, material, options};
  ShapeId id;
  add(call, data, row, {&def, 1}, {&id, 1});
  return id;
}

void World::add_shapes(BodyId body, std::span<const ShapeDef> defs, std::span<ShapeId> ids) {
  constexpr Call call{"add_shapes"};
  const FpEnvironment environment;
  if (ids.size() != defs.size()) {
    fail(call, "room for " + std::to_string(ids.size()) + " ids, but " + std::to_string(defs.size()) +
                   " definitions");
  }
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::add_shapes> call_record(data, body, defs);
  const std::int32_t row = checked_row(call, data, body);
  if (!defs.empty()) add(call, data, row, defs, ids);
}

void World::destroy_shape(ShapeId shape) {
  constexpr Call call{"destroy_shape"};
  const ShapeRow s = at(call, data_, shape);
  const CallRecord<RecordedCall::destroy_shape> call_record(s.data, shape);
  const BodyMass mass = mass_after_change(call, s, {});
  follow_change(s.data, s.body, {s.shape, {}});
  unlink_shape(s.data, s.shape);
  remove_shape(s.data, s.shape);
  apply_mass(s.data, s.body, mass);
  leave_core(s.data, s.body);
  wake_body(s.data, s.body);
}

bool World::is_alive(ShapeId shape) const noexcept {
  if (data_ == nullptr) return false;
  const Shapes& shapes = data_->shapes;
  return is_own(*data_, shape) && shape.index < shapes.flags.size() &&
         shapes.generation[shape.index] == shape.generation && (shapes.flags[shape.index] & kShapeAlive) != 0;
}

std::size_t World::shape_count() const noexcept { return data_ != nullptr ? data_->shapes.alive : 0; }

BodyId World::body_of(ShapeId shape) const {
  const ShapeRow s = at({"body_of"}, data_, shape);
  return body_handle(s.data, s.body);
}

Geometry World::geometry(ShapeId shape) const {
  const ShapeRow s = at({"geometry"}, data_, shape);
  return geometry_of(s.data, s.shape);
}

void World::set_geometry(ShapeId shape, const Geometry& geometry) {
  constexpr Call call{"set_geometry"};
  const ShapeRow s = at(call, data_, shape);
  const CallRecord<RecordedCall::set_geometry> call_record(s.data, shape, geometry);
  check_geometry(call, geometry);
  check_place(call, geometry, given_type(s.data.bodies, s.body), scree::is_sensor(s.shapes, s.shape));
  ShapeForm form = form_of(s);
  form.geometry = geometry;
  const BodyMass mass = mass_after_change(call, s, {&form, 1});
  const SolidSlots slots = acquire_slots(call, s.data, geometry);
  follow_change(s.data, s.body, {s.shape, {&form, 1}});
  release_slots(s.data, slots_of(s.shapes, s.shape));
  write_extent(s.data, s.shape, geometry, slots);
  place_shape_in_body(s.data, s.shape);
  apply_mass(s.data, s.body, mass);
  leave_core(s.data, s.body);
  reconsider(s, kShapeNew);
}

Material World::material(ShapeId shape) const {
  const ShapeRow s = at({"material"}, data_, shape);
  const MaterialRow& row = s.shapes.material[s.shape];
  return {
      .friction = row.friction,
      .restitution = row.restitution,
      .rolling_resistance = row.rolling_resistance,
      .density = s.shapes.density[s.shape],
      .patch_radius = row.patch_radius == kAutomaticPatch ? std::nullopt : std::optional(row.patch_radius),
      .surface_velocity = to_vec3(row.surface_velocity),
      .friction_mix = static_cast<MixRule>(row.rules & 0xff),
      .restitution_mix = static_cast<MixRule>(row.rules >> 8 & 0xff)};
}

void World::set_material(ShapeId shape, const Material& material) {
  constexpr Call call{"set_material"};
  const ShapeRow s = at(call, data_, shape);
  const CallRecord<RecordedCall::set_material> call_record(s.data, shape, material);
  check_material(call, material);
  if (material.density != s.shapes.density[s.shape] && !scree::is_sensor(s.shapes, s.shape)) {
    ShapeForm form = form_of(s);
    form.density = material.density;
    const BodyMass mass = mass_after_change(call, s, {&form, 1});
    follow_change(s.data, s.body, {s.shape, {&form, 1}});
    apply_mass(s.data, s.body, mass);
  }
  write_material(s.shapes, s.shape, material);
  mark_dirty(s.shapes, s.shape);
  s.data.contacts.manifolds_stale = true;  // recycled ones would keep the old surface
  request_wake(s.data, s.shape);
  wake_body(s.data, s.body);
}

Filter World::filter(ShapeId shape) const {
  const ShapeRow s = at({"filter"}, data_, shape);
  return s.shapes.filter[s.shape];
}

void World::set_filter(ShapeId shape, const Filter& filter) {
  const ShapeRow s = at({"set_filter"}, data_, shape);
  const CallRecord<RecordedCall::set_filter> call_record(s.data, shape, filter);
  s.shapes.filter[s.shape] = filter;
  reconsider(s, kShapeDirty);
}

// Lists a shape that is asked for other events now; beyond `most` shapes, all count as asked.
void note_asked(Events& events, std::int32_t shape, std::size_t most) {
  if (events.asked_of.size() < most) {
    events.asked_of.push_back(shape);
  } else {
    events.asked_of_all = true;
  }
}

ContactEvents World::contact_events(ShapeId shape) const {
  const ShapeRow s = at({"contact_events"}, data_, shape);
  return s.shapes.events[s.shape];
}

void World::set_contact_events(ShapeId shape, ContactEvents events) {
  constexpr Call call{"set_contact_events"};
  const ShapeRow s = at(call, data_, shape);
  const CallRecord<RecordedCall::set_contact_events> call_record(s.data, shape, events);
  check_events(call, events);
  if (events != s.shapes.events[s.shape]) note_asked(s.data.events, s.shape, s.shapes.flags.size());
  s.shapes.asking +=
      (events != ContactEvents::none ? 1 : 0) - (s.shapes.events[s.shape] != ContactEvents::none ? 1 : 0);
  s.shapes.events[s.shape] = events;
}

bool World::is_sensor(ShapeId shape) const {
  const ShapeRow s = at({"is_sensor"}, data_, shape);
  return scree::is_sensor(s.shapes, s.shape);
}

std::size_t World::visitors_of(ShapeId sensor, std::span<ShapeId> out) const {
  constexpr Call call{"visitors_of"};
  const ShapeRow s = at(call, data_, sensor);
  if (!scree::is_sensor(s.shapes, s.shape)) {
    fail(call, "shape " + std::to_string(s.shape) + " is no sensor");
  }
  const Column<TouchingPair>& rows = s.data.events.sensed;
  const TouchingPair* row = std::lower_bound(
      rows.begin(), rows.end(), sensor.index,
      [](const TouchingPair& pair, std::uint32_t index) { return pair.shape_a.index < index; });
  std::size_t count = 0;
  for (; row != rows.end() && row->shape_a.index == sensor.index; ++row) {
    if (row->shape_a.generation != sensor.generation) continue;  // of the shape that had the slot before
    if (count < out.size()) out[count] = handle_of<ShapeId>(s.data, row->shape_b);
    ++count;
  }
  return count;
}

Pose World::local_pose(ShapeId shape) const {
  const ShapeRow s = at({"local_pose"}, data_, shape);
  return s.shapes.given_pose[s.shape];
}

void World::set_local_pose(ShapeId shape, const Pose& given) {
  constexpr Call call{"set_local_pose"};
  const ShapeRow s = at(call, data_, shape);
  const Pose pose = given;  // which may be an entry of poses()
  const CallRecord<RecordedCall::set_local_pose> call_record(s.data, shape, pose);
  check_pose(call, "position", "rotation", pose, kMaxLocalPosition);
  ShapeForm form = form_of(s);
  form.local_pose = {pose.position, normalize(pose.rotation)};
  const BodyMass mass = mass_after_change(call, s, {&form, 1});
  follow_change(s.data, s.body, {s.shape, {&form, 1}});
  s.shapes.given_pose[s.shape] = form.local_pose;
  place_shape_in_body(s.data, s.shape);
  apply_mass(s.data, s.body, mass);
  leave_core(s.data, s.body);
  s.data.contacts.manifolds_stale = true;  // recycling compares the poses of bodies, not of shapes
  reconsider(s, kShapeDirty);
}

std::uint64_t World::user_data(ShapeId shape) const {
  const ShapeRow s = at({"user_data"}, data_, shape);
  return s.shapes.user_data[s.shape];
}

void World::set_user_data(ShapeId shape, std::uint64_t user_data) {
  const ShapeRow s = at({"set_user_data"}, data_, shape);
  const CallRecord<RecordedCall::set_shape_user_data> call_record(s.data, shape, user_data);
  s.shapes.user_data[s.shape] = user_data;
}

std::size_t World::shapes_of(BodyId body, std::span<ShapeId> out) const {
  constexpr Call call{"shapes_of"};
  const WorldData& data = opened(call, data_);
  const auto first = data.bodies.first_shape[checked_row(call, data, body)];
  const auto next = [&](std::int32_t shape) { return data.shapes.next[shape]; };
  std::size_t count = 0;
  for (std::int32_t shape = first; shape >= 0; shape = next(shape)) ++count;
  std::size_t place = count;  // the list is newest first
  for (std::int32_t shape = first; shape >= 0; shape = next(shape)) {
    --place;
    if (place >= out.size()) continue;
    out[place] = shape_handle(data, shape);
  }
  return count;
}

}  // namespace scree
