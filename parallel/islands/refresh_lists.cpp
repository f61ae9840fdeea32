// Lists what moves: flags of bodies and trees of shapes -> lists of awake and kinematic bodies and of moving
// shapes. Calls, falling asleep and waking note what they change, and the lists are updated for these: the
// cost depends on what moves and what changed, not on what rests. After a restore, and where most have
// changed, the lists are rebuilt.
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/islands/islands.h>
#include <parallel/islands/take_up.h>
#include <parallel/stages.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

bool is_awake(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & (kBodyAlive | kBodyAsleep)) == kBodyAlive &&
         bodies.type[body] == BodyType::dynamic && bodies.is_absent[body] == 0;
}
bool is_kinematic(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[body] & kBodyAlive) != 0 && bodies.type[body] == BodyType::kinematic;
}
bool is_moving(const Shapes& shapes, std::int32_t shape) {
  const TreeKind tree = shapes.tree[shape];
  return (shapes.flags[shape] & kShapeAlive) != 0 && (tree == TreeKind::awake || tree == TreeKind::kinematic);
}

void make_lists(WorldData& data, Column<std::int32_t>& places, Crew& crew) {
  Bodies& bodies = data.bodies;
  const std::size_t rows = bodies.flags.size();
  list_where(crew, rows, places, bodies.awake, [&](std::int32_t body) { return is_awake(bodies, body); });
  list_where(crew, rows, places, bodies.kinematic,
             [&](std::int32_t body) { return is_kinematic(bodies, body); });
  list_where(crew, data.shapes.flags.size(), places, data.shapes.moving,
             [&](std::int32_t shape) { return is_moving(data.shapes, shape); });
}

}  // namespace

void refresh_lists(WorldData& data, Crew& crew) {
  Bodies& bodies = data.bodies;
  Shapes& shapes = data.shapes;
  if (!bodies.lists_dirty && shapes.changed.empty()) return;
  // Contacts of bodies that fall asleep leave the list of contacts that steps write to. Bodies and shapes
  // were marked when they changed.
  for (const std::int32_t contact : data.contacts.active) data.contacts.marks.mark(contact);
  BroadPhase& broad_phase = broad_phase_of(data);
  Column<std::int32_t>& places = islands_of(data).places;
  // Updating is serial, and costs more for each row than rebuilding does.
  constexpr std::size_t kCostOfMoving = 4, kCostOfChanged = 16;
  const std::size_t moving = bodies.awake.size() + bodies.kinematic.size() + shapes.moving.size();
  const std::size_t changed = bodies.changed.size() + shapes.changed.size();
  if (bodies.all_changed ||
      kCostOfMoving * moving + kCostOfChanged * changed > bodies.flags.size() + shapes.flags.size()) {
    make_lists(data, places, crew);
  } else {
    std::sort(bodies.changed.begin(), bodies.changed.end());
    std::sort(shapes.changed.begin(), shapes.changed.end());
    if (!bodies.changed.empty()) {
      take_up(bodies.awake, bodies.changed, bodies.is_changed, places,
              [&](std::int32_t body) { return is_awake(bodies, body); });
      take_up(bodies.kinematic, bodies.changed, bodies.is_changed, places,
              [&](std::int32_t body) { return is_kinematic(bodies, body); });
    }
    if (!shapes.changed.empty()) {
      take_up(shapes.moving, shapes.changed, shapes.is_changed, places,
              [&](std::int32_t shape) { return is_moving(shapes, shape); });
    }
  }
  note_joints(data);
  broad_phase.changed.append(std::as_const(shapes.changed).span());
  forget_changes(bodies);
  forget_changes(shapes);
  bodies.lists_dirty = bodies.all_changed = false;
}

}  // namespace scree
