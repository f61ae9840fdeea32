// Waking; see wake.h.
#include <core/world/resting_pairs.h>
#include <core/world/wake.h>

#include <algorithm>

namespace scree {

void note_shapes(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
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
  for (std::int32_t shape = bodies.first_shape[row]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = TreeKind::awake;
    note_change(data.shapes, shape);
  }
}

namespace {

// Whether a call has created, moved or stopped this shape of a fixed or kinematic body: a sleeping body
// beside it is collided only if it is woken now.
bool has_been_put(const WorldData& data, std::size_t shape) {
  constexpr std::uint8_t kPut = kShapeAlive | kShapeDirty | kShapeWakes;
  if ((data.shapes.flags[shape] & kPut) != kPut) return false;
  return data.bodies.type[data.shapes.body[shape]] != BodyType::dynamic;
}

}  // namespace

void wake_neighbors(WorldData& data) {
  Shapes& shapes = data.shapes;
  if (!shapes.wake_requested) return;
  const PairRows &moving = data.contacts.pairs, &resting = data.contacts.resting;
  const auto wakes = [&](const ShapePair& pair, std::int32_t contact) {
    return contact >= 0 || has_been_put(data, static_cast<std::size_t>(pair.a)) ||
           has_been_put(data, static_cast<std::size_t>(pair.b));
  };
  // A freed or reused slot names a dead body or a new, awake one; neither does harm.
  const auto body_of = [&](std::int32_t shape) { return shapes.body[shape]; };
  for (std::size_t i = 0; i < moving.pair.size(); ++i) {
    const ShapePair pair = moving.pair[i];
    if (((shapes.flags[pair.a] | shapes.flags[pair.b]) & kShapeWakes) == 0 ||
        !wakes(pair, moving.contact[i])) {
      continue;
    }
    wake_body(data, body_of(pair.a));
    wake_body(data, body_of(pair.b));
  }
  Column<std::int32_t>& woken = data.bodies.to_wake;
  woken.clear();
  for (const std::int32_t shape : shapes.wakers) {
    const std::size_t before = woken.size();
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
      const auto index = static_cast<std::size_t>(row);
      if (wakes(resting.pair[index], resting.contact[index])) woken.push_back(body_of(other));
    });
    if (woken.size() > before) woken.push_back(body_of(shape));
  }
  if (!std::is_sorted(woken.begin(), woken.end())) std::sort(woken.begin(), woken.end());
  woken.resize(static_cast<std::size_t>(std::unique(woken.begin(), woken.end()) - woken.begin()));
  for (const std::int32_t body : woken) wake_body(data, body);
  for (const std::int32_t shape : shapes.wakers) {
    std::uint8_t& flags = shapes.flags[shape];
    flags = static_cast<std::uint8_t>(flags & ~kShapeWakes);
    shapes.marks.mark(shape);
  }
  shapes.wakers.clear();
  shapes.wake_requested = false;
}

}  // namespace scree
