// Who takes part: flags of bodies and trees of shapes -> lists of what moves. Made anew only after a call, or
// falling asleep or waking, has changed them.
#include <parallel/islands.h>
#include <parallel/list_where.h>
#include <parallel/stages.h>

namespace scree {

void refresh_lists(WorldData& data, Crew& crew) {
  Bodies& bodies = data.bodies;
  Shapes& shapes = data.shapes;
  if (!bodies.lists_dirty) return;
  Column<std::int32_t>& places = islands_of(data).places;
  const auto lives_as = [&](std::size_t body, BodyType type) {
    return (bodies.flags[body] & kBodyAlive) != 0 && bodies.type[body] == type;
  };
  list_where(crew, bodies.pose.size(), places, bodies.awake, [&](std::size_t body) {
    return lives_as(body, BodyType::dynamic) && (bodies.flags[body] & kBodyAsleep) == 0;
  });
  list_where(crew, bodies.pose.size(), places, bodies.kinematic,
             [&](std::size_t body) { return lives_as(body, BodyType::kinematic); });
  list_where(crew, shapes.body.size(), places, shapes.moving, [&](std::size_t shape) {
    const TreeKind tree = shapes.tree[shape];
    return (shapes.flags[shape] & kShapeAlive) != 0 &&
           (tree == TreeKind::awake || tree == TreeKind::kinematic);
  });
  bodies.lists_dirty = false;
  data.joints.active_changed = true;
  shapes.trees_changed = true;
}

}  // namespace scree
