// Waking; see wake.h.
#include <core/wake.h>

namespace scree {

void note_shapes(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[static_cast<std::size_t>(body)]; shape >= 0;
       shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
    note_change(data.shapes, shape);
  }
}

void wake_body(WorldData& data, std::int32_t body) {
  Bodies& bodies = data.bodies;
  const auto row = static_cast<std::size_t>(body);
  if ((bodies.flags[row] & kBodyAlive) == 0 || bodies.type[row] != BodyType::dynamic) return;
  bodies.sleep_time[row] = 0.0f;
  bodies.marks.mark(body);
  if ((bodies.flags[row] & kBodyAsleep) == 0) return;
  data.events.woken.push_back({static_cast<std::uint32_t>(body), bodies.generation[row]});
  bodies.flags[row] = static_cast<std::uint8_t>(bodies.flags[row] & ~kBodyAsleep);
  --bodies.asleep;
  note_change(bodies, body);
  for (std::int32_t shape = bodies.first_shape[row]; shape >= 0;
       shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
    data.shapes.tree[static_cast<std::size_t>(shape)] = TreeKind::awake;
    note_change(data.shapes, shape);
  }
}

namespace {

// Moved by a call, and nothing that an awake body would be found to touch: what sleeps next to it is only
// collided if it is woken now.
bool has_been_put(const WorldData& data, std::size_t shape) {
  constexpr std::uint8_t kPut = kShapeAlive | kShapeDirty | kShapeWakes;
  if ((data.shapes.flags[shape] & kPut) != kPut) return false;
  return data.bodies.type[static_cast<std::size_t>(data.shapes.body[shape])] != BodyType::dynamic;
}

}  // namespace

void wake_neighbors(WorldData& data) {
  Shapes& shapes = data.shapes;
  if (!shapes.wake_requested) return;
  for (const PairRows* rows : {&data.contacts.pairs, &data.contacts.resting}) {
    for (std::size_t i = 0; i < rows->pair.size(); ++i) {
      const auto a = static_cast<std::size_t>(rows->pair[i].a);
      const auto b = static_cast<std::size_t>(rows->pair[i].b);
      if (((shapes.flags[a] | shapes.flags[b]) & kShapeWakes) == 0) continue;
      const bool touches = rows->contact[i] >= 0;
      if (!touches && !has_been_put(data, a) && !has_been_put(data, b)) continue;
      // A slot that died or changed hands names a dead body or a new, wakeful one: no harm in either.
      wake_body(data, shapes.body[a]);
      wake_body(data, shapes.body[b]);
    }
  }
  for (const std::int32_t shape : shapes.wakers) {
    std::uint8_t& flags = shapes.flags[static_cast<std::size_t>(shape)];
    flags = static_cast<std::uint8_t>(flags & ~kShapeWakes);
    shapes.marks.mark(shape);
  }
  shapes.wakers.clear();
  shapes.wake_requested = false;
}

}  // namespace scree
