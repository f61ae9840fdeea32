// Validation of bodies, shapes and joints; see validate.h.
#ifdef SCREE_ASSERTIONS

#include <core/constraints/joint_parameters.h>
#include <core/validate/validate.h>
#include <core/world/edit.h>

#include <utility>

namespace scree {

bool is_validated(const WorldData& data) {
  const Contacts& contacts = data.contacts;
  const std::size_t rows = data.bodies.flags.size() + data.shapes.flags.size() + data.joints.flags.size() +
                           contacts.pairs.pair.size() + contacts.resting.pair.size() +
                           contacts.now.pair.size();
  return data.step_count % (1 + rows / kValidatedRows) == 0;
}

std::vector<std::uint8_t>& validation_marks(std::size_t count) {
  thread_local std::vector<std::uint8_t> marks;
  marks.assign(count, 0);
  return marks;
}

namespace {

// The slots of a store that can be taken anew: of the dead ones all but those whose generations are used up.
template <class Store, class IsAlive>
void validate_free_slots(const Store& store, std::size_t first, IsAlive&& is_alive) {
  SCREE_ASSERT(lists_exactly(store.free_slots, store.generation.size(), [&](std::size_t row) {
    return row >= first && !is_alive(row) && store.generation[row] != 0;
  }));
}

template <class Store>
void validate_changed(const Store& store) {
  SCREE_ASSERT(lists_exactly(store.changed, store.is_changed.size(),
                             [&](std::size_t row) { return store.is_changed[row] != 0; }));
}

void validate_bodies(const Bodies& bodies) {
  std::size_t alive = 0;
  std::int32_t asleep = 0;
  for (std::size_t row = 0; row < bodies.flags.size(); ++row) {
    const bool is_alive = (bodies.flags[row] & kBodyAlive) != 0;
    const bool is_asleep = (bodies.flags[row] & kBodyAsleep) != 0;
    SCREE_ASSERT(!is_alive || row >= kFirstBody);
    SCREE_ASSERT(!is_asleep || (is_alive && bodies.type[row] == BodyType::dynamic));
    SCREE_ASSERT((bodies.flags[row] & kBodyMarked) == 0);
    alive += is_alive ? 1 : 0;
    asleep += is_asleep ? 1 : 0;
  }
  SCREE_ASSERT(bodies.alive == alive);
  SCREE_ASSERT(bodies.asleep == asleep);
  validate_free_slots(bodies, kFirstBody,
                      [&](std::size_t row) { return (bodies.flags[row] & kBodyAlive) != 0; });
  validate_changed(bodies);
  SCREE_ASSERT(lists_exactly(bodies.to_place, bodies.unplaced.size(),
                             [&](std::size_t row) { return bodies.unplaced[row] != 0; }));
}

// Every living shape stands once in the list of its body, whose links back agree.
void validate_shape_lists(const WorldData& data) {
  const Shapes& shapes = data.shapes;
  std::size_t listed = 0;
  for (std::size_t body = kFirstBody; body < data.bodies.flags.size(); ++body) {
    const bool is_alive = (data.bodies.flags[body] & kBodyAlive) != 0;
    SCREE_ASSERT(is_alive || data.bodies.first_shape[body] == -1);
    std::int32_t before = -1;
    for (std::int32_t shape = data.bodies.first_shape[body]; shape != -1; shape = shapes.next[shape]) {
      SCREE_ASSERT(std::cmp_equal(shapes.body[shape], body));
      SCREE_ASSERT((shapes.flags[shape] & kShapeAlive) != 0);
      SCREE_ASSERT(shapes.previous[shape] == before);
      SCREE_ASSERT(++listed <= shapes.alive);  // and does not run in a circle
      before = shape;
    }
  }
  SCREE_ASSERT(listed == shapes.alive);
}

void validate_shapes(const WorldData& data) {
  const Shapes& shapes = data.shapes;
  std::size_t alive = 0;
  std::int32_t asking = 0, hooked = 0, sensors = 0;
  for (std::size_t row = 0; row < shapes.flags.size(); ++row) {
    const bool is_alive = (shapes.flags[row] & kShapeAlive) != 0;
    const bool is_hull = is_alive && has_hull(shapes.type[row]);
    const bool is_here = is_alive && data.bodies.is_absent[shapes.body[row]] == 0;
    SCREE_ASSERT(shapes.tree[row] == (is_here ? tree_of(data.bodies, shapes.body[row]) : TreeKind::none));
    SCREE_ASSERT((shapes.hull[row] >= 0) == is_hull);
    SCREE_ASSERT(!is_hull || data.hulls.data[shapes.hull[row]] != nullptr);
    const bool is_mesh = is_alive && shapes.type[row] == ShapeType::mesh;
    SCREE_ASSERT((shapes.mesh[row] >= 0) == is_mesh);
    SCREE_ASSERT(!is_mesh || data.meshes.data[shapes.mesh[row]] != nullptr);
    SCREE_ASSERT(!is_mesh || given_type(data.bodies, shapes.body[row]) != BodyType::dynamic);
    const bool is_half_space = is_alive && shapes.type[row] == ShapeType::half_space;
    SCREE_ASSERT(!is_half_space || given_type(data.bodies, shapes.body[row]) != BodyType::dynamic);
    alive += is_alive ? 1 : 0;
    asking += is_alive && shapes.events[row] != ContactEvents::none ? 1 : 0;
    hooked += is_alive && shapes.hooks[row] != ContactHooks::none ? 1 : 0;
    SCREE_ASSERT(is_alive || (shapes.flags[row] & kShapeSensor) == 0);
    sensors += (shapes.flags[row] & kShapeSensor) != 0 ? 1 : 0;
  }
  SCREE_ASSERT(shapes.alive == alive);
  SCREE_ASSERT(shapes.asking == asking);
  SCREE_ASSERT(shapes.hooked == hooked);
  SCREE_ASSERT(shapes.sensors == sensors);
  const auto lists = [&](const Column<std::int32_t>& list, ShapeFlag flag) {
    return lists_exactly(list, shapes.flags.size(),
                         [&](std::size_t row) { return (shapes.flags[row] & flag) != 0; });
  };
  SCREE_ASSERT(lists(shapes.dirty, kShapeDirty));
  SCREE_ASSERT(lists(shapes.wakers, kShapeWakes));
  validate_free_slots(shapes, 0, [&](std::size_t row) { return (shapes.flags[row] & kShapeAlive) != 0; });
  validate_changed(shapes);
  validate_shape_lists(data);
}

// Every living joint stands once in the list of each of its bodies but the world, whose links back agree.
void validate_joint_lists(const WorldData& data) {
  const Joints& joints = data.joints;
  std::size_t wanted = 0, listed = 0;
  for (std::size_t row = 0; row < joints.flags.size(); ++row) {
    if ((joints.flags[row] & kJointAlive) == 0) continue;
    const JointBodies ends = joints.bodies[row];
    SCREE_ASSERT(ends.a != ends.b);
    wanted += (is_listed(ends.a) ? 1u : 0u) + (is_listed(ends.b) ? 1u : 0u);
  }
  for (std::size_t row = kFirstBody; row < data.bodies.flags.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    const std::int32_t first = data.bodies.first_joint[row];
    SCREE_ASSERT((data.bodies.flags[row] & kBodyAlive) != 0 || first == -1);
    std::int32_t before = -1;
    for (std::int32_t joint = first; joint != -1; joint = next_joint(joints, joint, body)) {
      const JointBodies ends = joints.bodies[joint];
      SCREE_ASSERT(ends.a == body || ends.b == body);
      SCREE_ASSERT((joints.flags[joint] & kJointAlive) != 0);
      SCREE_ASSERT(link_of(joints.previous[joint], ends, body) == before);
      SCREE_ASSERT(++listed <= wanted);
      before = joint;
    }
  }
  SCREE_ASSERT(listed == wanted);
}

void validate_joints(const WorldData& data) {
  const Joints& joints = data.joints;
  std::size_t alive = 0;
  std::int32_t reporting = 0;
  for (const std::uint8_t flags : joints.flags) {
    alive += (flags & kJointAlive) != 0 ? 1 : 0;
    reporting += (flags & kJointReports) != 0 ? 1 : 0;
  }
  SCREE_ASSERT(joints.alive == alive);
  SCREE_ASSERT(joints.reporting == reporting);
  const Column<std::int32_t>& users = data.user_joints.joint;
  for (std::size_t row = 0; row < users.size(); ++row) {
    SCREE_ASSERT((joints.flags[users[row]] & kJointAlive) != 0);
    SCREE_ASSERT(joints.type[users[row]] == JointType::user);
    SCREE_ASSERT(joints.user[users[row]] == static_cast<std::int32_t>(row));
  }
  validate_free_slots(joints, 0, [&](std::size_t row) { return (joints.flags[row] & kJointAlive) != 0; });
  validate_changed(joints);
  validate_joint_lists(data);
}

}  // namespace

void validate_stores(const WorldData& data) {
  if (!is_validated(data)) return;
  validate_bodies(data.bodies);
  validate_shapes(data);
  validate_joints(data);
}

}  // namespace scree

#endif
