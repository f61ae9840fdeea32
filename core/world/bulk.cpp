// Creating and destroying bodies, one or a million at a time.
#include <core/geometry/balls.h>
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>
#include <scree/world.h>

#include <string>
#include <vector>

namespace scree {

namespace {

std::uint8_t flags_of(const BodyDef& def) {
  return static_cast<std::uint8_t>(kBodyAlive | (def.can_sleep ? kBodyCanSleep : 0) |
                                   (def.mass ? kBodyMassGiven : 0));
}

// Writes all columns of a new body except generation, flags and scratch.
void write_body(Bodies& bodies, std::int32_t body, const BodyDef& def, const BodyMass& mass) {
  const Quat rotation = normalize(def.rotation);
  bodies.type[body] = def.type;
  put(bodies.center, body, mass.center);
  PoseRow pose{};
  store(pose.position, def.position + rotate(rotation, mass.center));
  store(pose.rotation, rotation);
  bodies.pose[body] = pose;
  bodies.transform[body] = transform_of(pose, mass.center);
  bodies.motion[body] = {def.linear_damping, def.angular_damping, def.gravity_factor,
                         (mass.gyroscopic ? std::uint32_t{kMotionGyroscopic} : 0u) |
                             (def.full_sweep ? std::uint32_t{kMotionSweptWhole} : 0u)};
  put(bodies.locks, body, def.locks);
  VelocityRow velocity{};
  if (def.type != BodyType::fixed) {
    store(velocity.linear, def.linear_velocity);
    store(velocity.angular, def.angular_velocity);
  }
  put(bodies.velocity, body, velocity);
  apply_locks(bodies, body);
  put(bodies.force, body, {});
  put(bodies.sleep_time, body, 0.0f);
  put(bodies.drift, body, {});
  put(bodies.local_mass, body, mass.inverse);
  put(bodies.local_inertia, body, mass.inertia);
  put(bodies.mass, body, mass.mass);
  put(bodies.given_mass, body, def.mass.value_or(0.0f));
  bodies.first_shape[body] = -1;
  bodies.first_joint[body] = -1;
  put(bodies.user_data, body, def.user_data);
  bodies.core[body] = kNoCore;
  bodies.marks.mark(body);
}

struct ShapeTemplate {
  std::span<const Geometry> geometries;
  const Material* material;
  const ShapeOptions* options;
};

BodyMass mass_of(Call item, const BodyDef& def, const ShapeTemplate* shape, std::size_t i) {
  if (def.type != BodyType::dynamic) return {};
  MassSum sum;
  if (shape != nullptr) {
    sum = part_of(shape->geometries[i], shape->options->sensor ? 0.0f : shape->material->density,
                  shape->options->local_pose);
  }
  return dynamic_mass(item, sum, def.mass);
}

// Throws what creating the body would, except for limits of its hull.
void check_item(Call item, const BodyDef& def, const ShapeTemplate* shape, std::size_t i) {
  check_body_def(item, def);
  if (shape == nullptr) return;
  check_geometry(item, shape->geometries[i]);
  check_place(item, shape->geometries[i], def.type, shape->options->sensor);
}

// Throws for bad definitions before anything is written: reused rows keep their old content, which shows in
// snapshots. Returns slots of hulls and meshes, which count one shape too many.
std::vector<SolidSlots> check_all(Call call, WorldData& data, std::span<const BodyDef> defs,
                                  const ShapeTemplate* shape) {
  const std::size_t count = defs.size();
  const SolidSlotCounts before(data);
  std::vector<SolidSlots> slots;
  try {
    for (std::size_t i = 0; i < count; ++i) {
      const Call item = item_of(call, count, i);
      check_item(item, defs[i], shape, i);
      mass_of(item, defs[i], shape, i);
      if (shape == nullptr || !has_slot(shape->geometries[i])) continue;
      slots.push_back({});
      slots.back() = acquire_slots(item, data, shape->geometries[i]);
    }
  } catch (...) {
    for (; !slots.empty(); slots.pop_back()) undo_slots(data, slots.back(), before);
    throw;
  }
  return slots;
}

// Gives the slots of new shapes back, the last one first.
void drop_slots(WorldData& data, const SlotPlan& plan, std::size_t count, const SolidSlotCounts& before) {
  while (count > 0) {
    const std::int32_t shape = plan.slot(data.shapes.free_slots, --count);
    undo_slots(data, slots_of(data.shapes, shape), before);
    data.shapes.hull[shape] = data.shapes.mesh[shape] = -1;
    data.shapes.marks.mark(shape);
  }
}

// Writes rows into slots that stay dead until all definitions are checked; then makes the slots live.
void create(Call call, WorldData& data, std::span<const BodyDef> defs, const ShapeTemplate* shape,
            std::span<BodyId> ids) {
  Bodies& bodies = data.bodies;
  Shapes& shapes = data.shapes;
  const std::size_t count = defs.size(), shape_count = shape != nullptr ? count : 0;
  const std::size_t old_bodies = bodies.flags.size(), old_shapes = shapes.flags.size();
  check_room(call, "bodies", old_bodies, count);
  check_room(call, "shapes", old_shapes, shape_count);
  const SlotPlan body_plan(bodies.free_slots, old_bodies, count);
  const SlotPlan shape_plan(shapes.free_slots, old_shapes, shape_count);
  const SolidSlotCounts before(data);
  std::size_t shapes_written = 0;
  try {
    grow(bodies, old_bodies + count - body_plan.from_free);
    // Waking cannot fail: a slot wakes once between two steps.
    data.events.woken.reserve(bodies.flags.size());
    grow(shapes, old_shapes + shape_count - shape_plan.from_free);
    std::vector<SolidSlots> checked;
    if (body_plan.from_free + shape_plan.from_free > 0) checked = check_all(call, data, defs, shape);
    for (std::size_t i = 0; i < count; ++i) {
      const Call item = item_of(call, count, i);
      const BodyDef& def = defs[i];
      check_item(item, def, shape, i);
      const BodyMass mass = mass_of(item, def, shape, i);
      const std::int32_t body = body_plan.slot(bodies.free_slots, i);
      write_body(bodies, body, def, mass);
      if (shape == nullptr) continue;
      const std::int32_t row = shape_plan.slot(shapes.free_slots, i);
      const SolidSlots slots = acquire_slots(item, data, shape->geometries[i]);
      write_shape(data, row, shape->geometries[i], slots, *shape->material, *shape->options);
      ++shapes_written;
    }
    for (const SolidSlots& slots : checked) release_slots(data, slots);
  } catch (...) {
    drop_slots(data, shape_plan, shapes_written, before);
    bodies.resize(old_bodies);
    shapes.resize(old_shapes);
    throw;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t body = body_plan.slot(bodies.free_slots, i);
    if (bodies.generation[body] == 0) bodies.generation[body] = 1;
    bodies.flags[body] = flags_of(defs[i]);
    put(bodies.is_absent, body, std::uint8_t{0});  // as the body that had the slot may have been
    bodies.marks.mark(body);
    if (defs[i].type != BodyType::fixed) note_change(bodies, body);
    ids[i] = body_handle(data, body);
    if (shape == nullptr) continue;
    const std::int32_t shape_row = shape_plan.slot(shapes.free_slots, i);
    link_shape(data, shape_row, body);
    commit_shape(data, shape_row, shape->options->sensor);
    measure_core(data, body);
  }
  take_slots(bodies, body_plan);
  take_slots(shapes, shape_plan);
  bodies.alive += count;
  if (shape_count > 0) data.contacts.pairs_stale = true;
}

// There is room in the list of lost joints for those of the body.
void remove_body(WorldData& data, std::int32_t body) {
  Bodies& bodies = data.bodies;
  if (bodies.unplaced[body] != 0 && !is_absent(bodies, body))
    place_matter_of(data, body);  // so that a dead row does not depend on when it was done
  while (bodies.first_joint[body] >= 0) {
    const std::int32_t joint = bodies.first_joint[body];
    const auto index = static_cast<std::uint32_t>(joint);
    data.events.lost.push_back({index, data.joints.generation[index]});
    remove_joint(data, joint);
  }
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    remove_shape(data, shape);
  }
  bodies.moments.erase(body);
  if ((bodies.flags[body] & kBodyAsleep) != 0) --bodies.asleep;
  if (bodies.type[body] != BodyType::fixed) note_change(bodies, body);
  bodies.marks.mark(body);
  bodies.flags[body] = 0;
  bodies.first_shape[body] = -1;
  put(bodies.velocity, body, {});
  put(bodies.force, body, {});
  put(bodies.local_mass, body, {});
  put(bodies.inertia, body, {});
  // A slot whose generations are used up stays empty for good.
  if (++bodies.generation[body] != 0) bodies.free_slots.push_back(body);
  --bodies.alive;
}

}  // namespace

BodyId World::create_body(const BodyDef& def) {
  constexpr Call call{"create_body"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::create_body> call_record(data, def);
  BodyId id;
  create(call, data, {&def, 1}, nullptr, {&id, 1});
  return id;
}

void World::create_bodies(std::span<const BodyDef> defs, std::span<BodyId> ids) {
  constexpr Call call{"create_bodies"};
  const FpEnvironment environment;
  if (ids.size() != defs.size()) {
    fail(call, "room for " + std::to_string(ids.size()) + " ids, but " + std::to_string(defs.size()) +
                   " definitions");
  }
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::create_bodies> call_record(data, defs);
  create(call, data, defs, nullptr, ids);
}

void World::create_bodies(std::span<const BodyDef> defs, std::span<const Geometry> shapes,
                          const Material& material, const ShapeOptions& options, std::span<BodyId> ids) {
  constexpr Call call{"create_bodies"};
  const FpEnvironment environment;
  if (ids.size() != defs.size() || shapes.size() != defs.size()) {
    fail(call, std::to_string(defs.size()) + " definitions, but " + std::to_string(shapes.size()) +
                   " shapes and room for " + std::to_string(ids.size()) + " ids");
  }
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::create_bodies_with_shapes> call_record(data, defs, shapes, material,
                                                                        options);
  check_material(call, material);
  check_options(call, options);
  ShapeOptions unit_options = options;
  unit_options.local_pose.rotation = normalize(options.local_pose.rotation);
  const ShapeTemplate shape{shapes, &material, &unit_options};
  create(call, data, defs, &shape, ids);
}

void World::destroy_body(BodyId body) {
  constexpr Call call{"destroy_body"};
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::destroy_body> call_record(data, body);
  const std::int32_t row = checked_row(call, data, body);
  data.events.lost.reserve(data.events.lost.size() + count_joints(data, row));
  remove_body(data, row);
}

void World::destroy_bodies(std::span<const BodyId> bodies) {
  constexpr const char* kName = "destroy_bodies";
  WorldData& data = opened({kName}, data_);
  const CallRecord<RecordedCall::destroy_bodies> call_record(data, bodies);
  const auto unmark = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::uint8_t& flags = data.bodies.flags[bodies[i].index];
      flags = static_cast<std::uint8_t>(flags & ~kBodyMarked);
    }
  };
  std::size_t joints = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Call call{kName, static_cast<std::int64_t>(i)};
    try {
      const std::int32_t row = checked_row(call, data, bodies[i]);
      if ((data.bodies.flags[row] & kBodyMarked) != 0) fail(call, "the same body stands in the list twice");
      data.bodies.flags[row] |= kBodyMarked;
      joints += count_joints(data, row);
    } catch (...) {
      unmark(i);
      throw;
    }
  }
  try {
    data.events.lost.reserve(data.events.lost.size() + joints);
  } catch (...) {
    unmark(bodies.size());
    throw;
  }
  for (const BodyId& body : bodies) remove_body(data, static_cast<std::int32_t>(body.index));
}

}  // namespace scree
