// Waking; see wake.h.
#include <core/world/resting_pairs.h>
#include <core/world/wake.h>

#include <algorithm>
#include <utility>

namespace scree {

void note_shapes(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    note_change(data.shapes, shape);
  }
}

void wake_body(WorldData& data, std::int32_t body) {
  Bodies& bodies = data.bodies;
  if ((bodies.flags[body] & kBodyAlive) == 0 || bodies.type[body] != BodyType::dynamic) return;
  if (is_absent(bodies, body)) return;
  bodies.sleep_time[body] = 0.0f;
  bodies.marks.mark(body);
  if ((bodies.flags[body] & kBodyAsleep) == 0) return;
  data.events.woken.push_back({static_cast<std::uint32_t>(body), bodies.generation[body]});
  bodies.flags[body] = static_cast<std::uint8_t>(bodies.flags[body] & ~kBodyAsleep);
  --bodies.asleep;
  note_change(bodies, body);
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = TreeKind::awake;
    note_change(data.shapes, shape);
  }
}

namespace {

// Whether a call has created, moved or stopped this shape of a fixed or kinematic body: a sleeping body
// beside it is collided only if it is woken now.
bool has_been_put(const WorldData& data, std::int32_t shape) {
  constexpr std::uint8_t kPut = kShapeAlive | kShapeDirty | kShapeWakes;
  if ((data.shapes.flags[shape] & kPut) != kPut) return false;
  return data.bodies.type[data.shapes.body[shape]] != BodyType::dynamic;
}

bool wakes(const WorldData& data, const ShapePair& pair, std::int32_t contact) {
  return contact >= 0 || has_been_put(data, pair.a) || has_been_put(data, pair.b);
}

// A slot that died or changed hands names a dead body or a new, wakeful one: no harm in either.
std::int32_t body_of(const WorldData& data, std::int32_t shape) { return data.shapes.body[shape]; }

// Calls visit(body) for those in pairs that move, in the order of the pairs.
template <class Visit>
void for_each_waking(const WorldData& data, Visit&& visit) {
  const PairRows& moving = data.contacts.pairs;
  for (std::size_t i = 0; i < moving.pair.size(); ++i) {
    const ShapePair pair = moving.pair[i];
    if (((data.shapes.flags[pair.a] | data.shapes.flags[pair.b]) & kShapeWakes) == 0 ||
        !wakes(data, pair, moving.contact[i])) {
      continue;
    }
    visit(body_of(data, pair.a));
    visit(body_of(data, pair.b));
  }
}

// Adds those in pairs at rest.
void list_waking_at_rest(const WorldData& data, Column<std::int32_t>& bodies) {
  const PairRows& resting = data.contacts.resting;
  for (const std::int32_t shape : data.shapes.wakers) {
    const std::size_t before = bodies.size();
    for_each_resting(data, shape, [&](std::int32_t row, std::int32_t other) {
      if (wakes(data, resting.pair[row], resting.contact[row])) bodies.push_back(body_of(data, other));
    });
    if (bodies.size() > before) bodies.push_back(body_of(data, shape));
  }
}

void sort_once(Column<std::int32_t>& bodies) {
  if (!std::is_sorted(bodies.begin(), bodies.end())) std::sort(bodies.begin(), bodies.end());
  bodies.resize(std::unique(bodies.begin(), bodies.end()) - bodies.begin());
}

}  // namespace

void wake_neighbors(WorldData& data) {
  Shapes& shapes = data.shapes;
  if (!shapes.wake_requested) return;
  for_each_waking(data, [&data](std::int32_t body) { wake_body(data, body); });
  Column<std::int32_t>& woken = data.bodies.to_wake;
  woken.clear();
  list_waking_at_rest(data, woken);
  sort_once(woken);
  for (const std::int32_t body : woken) wake_body(data, body);
  for (const std::int32_t shape : shapes.wakers) {
    std::uint8_t& flags = shapes.flags[shape];
    flags = static_cast<std::uint8_t>(flags & ~kShapeWakes);
    shapes.marks.mark(shape);
  }
  shapes.wakers.clear();
  shapes.wake_requested = false;
}

bool is_about_to_wake(const WorldData& data, std::int32_t body) {
  if (!data.shapes.wake_requested) return false;
  const Shapes& shapes = data.shapes;
  shapes.waking_made.ensure([&] {
    Column<std::int32_t>& waking = shapes.waking;
    waking.clear();
    for_each_waking(data, [&waking](std::int32_t woken) { waking.push_back(woken); });
    list_waking_at_rest(data, waking);
    sort_once(waking);
  });
  return std::binary_search(std::as_const(shapes.waking).begin(), std::as_const(shapes.waking).end(), body);
}

}  // namespace scree
