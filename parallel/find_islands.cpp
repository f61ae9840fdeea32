// Islands and sleep. A body that has been slow for long enough is tired; an island of tired bodies that
// touches no moving one falls asleep as a whole. A sleeping island wakes as a whole when one of its bodies is
// touched by an awake one.
//
// Islands are found only among bodies that may change: most steps do nothing here.
#include <core/wake.h>
#include <parallel/islands.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

Islands& islands_of(WorldData& data) {
  if (data.islands == nullptr) data.islands = std::make_unique<Islands>();
  return static_cast<Islands&>(*data.islands);
}

void Islands::report(const Visit& visit) const {
  const auto column = [&](const char* name, const auto& cells) {
    visit(ColumnKind::scratch, name, cells.data(), cells.size() * sizeof(*cells.data()),
          cells.capacity_bytes());
  };
  column("parent", parent);
  column("kept_awake", kept_awake);
  column("candidates", candidates);
  column("to_wake", to_wake);
}

namespace {

bool is_asleep(const Bodies& bodies, std::int32_t body) {
  return (bodies.flags[static_cast<std::size_t>(body)] & kBodyAsleep) != 0;
}

bool is_tired(const WorldData& data, std::int32_t body) {
  const auto index = static_cast<std::size_t>(body);
  const float slow_for = data.bodies.sleep_time[index];  // 0 while it moves, which no wait is too short for
  return (data.bodies.flags[index] & kBodyCanSleep) != 0 && slow_for > 0.0f &&
         slow_for >= data.settings.sleep_time;
}

std::int32_t find_root(Column<std::int32_t>& parent, std::int32_t body) {
  while (parent[static_cast<std::size_t>(body)] != body) {
    std::int32_t& up = parent[static_cast<std::size_t>(body)];
    up = parent[static_cast<std::size_t>(up)];  // path halving
    body = up;
  }
  return body;
}

// The smaller index becomes the root, so that an island's name does not depend on the order of its contacts.
void unite(Column<std::int32_t>& parent, std::int32_t a, std::int32_t b) {
  const std::int32_t root_a = find_root(parent, a), root_b = find_root(parent, b);
  if (root_a == root_b) return;
  parent[static_cast<std::size_t>(std::max(root_a, root_b))] = std::min(root_a, root_b);
}

std::int32_t body_of_shape(const WorldData& data, std::int32_t shape) {
  return data.shapes.body[static_cast<std::size_t>(shape)];
}

// Bodies of a contact row.
struct Ends {
  std::int32_t a, b;
};

Ends ends_of(const WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.now.pair[row];
  return {body_of_shape(data, pair.a), body_of_shape(data, pair.b)};
}

void freeze_shapes(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[static_cast<std::size_t>(body)]; shape >= 0;
       shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
    data.shapes.tree[static_cast<std::size_t>(shape)] = TreeKind::frozen;
  }
}

// Wakes every island of sleeping bodies that an awake body touches, and lists the contacts that take part
// now.
void wake_touched_islands(WorldData& data, Islands& islands) {
  Bodies& bodies = data.bodies;
  Contacts& contacts = data.contacts;
  islands.to_wake.clear();
  for (const std::int32_t row : contacts.touching) {
    const Ends ends = ends_of(data, static_cast<std::size_t>(row));
    for (const std::int32_t body : {ends.a, ends.b}) {
      if (is_asleep(bodies, body)) islands.to_wake.push_back(body);
    }
  }
  if (islands.to_wake.empty()) return;

  islands.parent.resize(bodies.pose.size());
  for (std::size_t body = 0; body < bodies.pose.size(); ++body)
    islands.parent[body] = static_cast<std::int32_t>(body);
  for (std::size_t row = 0; row < contacts.now.pair.size(); ++row) {
    if ((contacts.now.manifold[row].info & kManifoldPointMask) == 0) continue;
    const Ends ends = ends_of(data, row);
    if (is_asleep(bodies, ends.a) && is_asleep(bodies, ends.b)) unite(islands.parent, ends.a, ends.b);
  }
  islands.kept_awake.resize(bodies.pose.size());
  std::fill(islands.kept_awake.begin(), islands.kept_awake.end(), std::uint8_t{0});
  for (const std::int32_t body : islands.to_wake) {
    islands.kept_awake[static_cast<std::size_t>(find_root(islands.parent, body))] = 1;
  }
  for (std::size_t body = static_cast<std::size_t>(kFirstBody); body < bodies.pose.size(); ++body) {
    const auto index = static_cast<std::int32_t>(body);
    if (!is_asleep(bodies, index)) continue;
    if (islands.kept_awake[static_cast<std::size_t>(find_root(islands.parent, index))] == 0) continue;
    wake_body(data, index);
  }
  refresh_lists(data);

  contacts.touching.clear();
  for (std::size_t row = 0; row < contacts.now.pair.size(); ++row) {
    if ((contacts.now.manifold[row].info & kManifoldPointMask) == 0) continue;
    const Ends ends = ends_of(data, row);
    const auto moves = [&](std::int32_t body) {
      return bodies.type[static_cast<std::size_t>(body)] == BodyType::dynamic && !is_asleep(bodies, body);
    };
    if (moves(ends.a) || moves(ends.b)) contacts.touching.push_back(static_cast<std::int32_t>(row));
  }
}

// Puts islands whose bodies are all tired to sleep.
void put_tired_islands_to_sleep(WorldData& data, Islands& islands) {
  Bodies& bodies = data.bodies;
  islands.candidates.clear();
  for (const std::int32_t body : bodies.awake) {
    if (is_tired(data, body)) islands.candidates.push_back(body);
  }
  data.stats.islands = 0;
  if (islands.candidates.empty()) return;

  islands.parent.resize(bodies.pose.size());
  islands.kept_awake.resize(bodies.pose.size());
  for (const std::int32_t body : islands.candidates) {
    islands.parent[static_cast<std::size_t>(body)] = body;
    islands.kept_awake[static_cast<std::size_t>(body)] = 0;
  }
  const auto is_candidate = [&](std::int32_t body) {
    return bodies.type[static_cast<std::size_t>(body)] == BodyType::dynamic && is_tired(data, body);
  };
  for (const std::int32_t row : data.contacts.touching) {
    const Ends ends = ends_of(data, static_cast<std::size_t>(row));
    if (is_candidate(ends.a) && is_candidate(ends.b)) unite(islands.parent, ends.a, ends.b);
  }
  const auto moves = [&](std::int32_t body) {
    const auto index = static_cast<std::size_t>(body);
    if (bodies.type[index] == BodyType::fixed) return false;
    if (bodies.type[index] == BodyType::dynamic) return true;
    return !is_still(bodies.velocity[index]);
  };
  for (const std::int32_t row : data.contacts.touching) {
    const Ends ends = ends_of(data, static_cast<std::size_t>(row));
    const bool a = is_candidate(ends.a), b = is_candidate(ends.b);
    if (a && !b && moves(ends.b))
      islands.kept_awake[static_cast<std::size_t>(find_root(islands.parent, ends.a))] = 1;
    if (b && !a && moves(ends.a))
      islands.kept_awake[static_cast<std::size_t>(find_root(islands.parent, ends.b))] = 1;
  }

  bool anybody = false;
  for (const std::int32_t body : islands.candidates) {
    const std::int32_t root = find_root(islands.parent, body);
    data.stats.islands += root == body ? 1 : 0;
    if (islands.kept_awake[static_cast<std::size_t>(root)] != 0) continue;
    const auto index = static_cast<std::size_t>(body);
    bodies.flags[index] = static_cast<std::uint8_t>(bodies.flags[index] | kBodyAsleep);
    bodies.velocity[index] = VelocityRow{};
    bodies.force[index] = ForceRow{};
    freeze_shapes(data, body);
    anybody = true;
  }
  if (!anybody) return;
  bodies.lists_dirty = true;
  refresh_lists(data);
  const auto sleeps = [&](std::int32_t row) {
    const Ends ends = ends_of(data, static_cast<std::size_t>(row));
    const auto moving = [&](std::int32_t body) {
      return bodies.type[static_cast<std::size_t>(body)] == BodyType::dynamic && !is_asleep(bodies, body);
    };
    return !moving(ends.a) && !moving(ends.b);
  };
  Column<std::int32_t>& touching = data.contacts.touching;
  std::int32_t* end = std::remove_if(touching.begin(), touching.end(), sleeps);
  touching.resize(static_cast<std::size_t>(end - touching.begin()));
}

}  // namespace

void refresh_lists(WorldData& data) {
  Bodies& bodies = data.bodies;
  if (!bodies.lists_dirty) return;
  bodies.awake.clear();
  bodies.kinematic.clear();
  data.shapes.moving.clear();
  for (std::size_t body = static_cast<std::size_t>(kFirstBody); body < bodies.pose.size(); ++body) {
    const std::uint8_t flags = bodies.flags[body];
    if ((flags & kBodyAlive) == 0 || bodies.type[body] == BodyType::fixed) continue;
    if (bodies.type[body] == BodyType::kinematic) {
      bodies.kinematic.push_back(static_cast<std::int32_t>(body));
    } else if ((flags & kBodyAsleep) == 0) {
      bodies.awake.push_back(static_cast<std::int32_t>(body));
    }
  }
  for (std::size_t shape = 0; shape < data.shapes.body.size(); ++shape) {
    if ((data.shapes.flags[shape] & kShapeAlive) == 0) continue;
    const TreeKind tree = data.shapes.tree[shape];
    if (tree == TreeKind::awake || tree == TreeKind::kinematic) {
      data.shapes.moving.push_back(static_cast<std::int32_t>(shape));
    }
  }
  bodies.lists_dirty = false;
}

void find_islands(WorldData& data, Crew&) {
  if (!data.settings.sleeping) {
    data.stats.islands = 0;
    return;
  }
  Islands& islands = islands_of(data);
  wake_touched_islands(data, islands);
  put_tired_islands_to_sleep(data, islands);
}

}  // namespace scree
