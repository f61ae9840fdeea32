// Islands and sleep. Islands hang together by contacts and joints. A body that has been slow for long enough
// is tired; an island of tired bodies that touches no moving one falls asleep as a whole. A sleeping island
// wakes as a whole when one of its bodies is touched by an awake one: see rouse_islands.cpp.
//
// Islands are found only among bodies that may change: most steps do nothing here. They are found in parallel
// by union-find without locks (Anderson and Woll, "Wait-free parallel algorithms for the union-find problem",
// 1991): roots are linked under smaller roots only, so that an island's final root is its smallest body,
// whoever came first. Roots are read only once all contacts are in.
#include <core/world/wake.h>
#include <parallel/broad_phase/merge_pairs.h>
#include <parallel/crew/list_where.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

#include <algorithm>
#include <atomic>
#include <utility>

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
  column("tired", tired);
  column("kept_awake", kept_awake);
  column("candidates", candidates);
  column("touched", touched);
  column("pulled", pulled);
  column("reached", reached);
  column("remaining", remaining);
  column("fixed_ends", fixed_ends);
  column("places", places);
}

void Islands::forget() noexcept {  // marks of a step that ran out of memory
  tired.clear();
  reached.clear();
}

namespace {

constexpr int kChunk = 2048;  // contacts or bodies of one task: 10 to 40 microseconds

bool is_asleep(const Bodies& bodies, std::int32_t body) { return (bodies.flags[body] & kBodyAsleep) != 0; }

bool is_tired(const WorldData& data, std::int32_t body) {
  const auto index = static_cast<std::size_t>(body);
  const float slow_for = data.bodies.sleep_time[index];  // 0 while it moves, which no wait is too short for
  return (data.bodies.flags[index] & kBodyCanSleep) != 0 && slow_for > 0.0f &&
         slow_for >= data.settings.sleep_time;
}

// Relaxed is enough: an entry only ever names the body itself or a smaller one of its island, and stages hand
// everything on.
using Link = std::atomic_ref<std::int32_t>;
Link link_of(Column<std::int32_t>& parent, std::int32_t body) { return Link(parent[body]); }

std::int32_t find_root(Column<std::int32_t>& parent, std::int32_t body) {
  for (;;) {
    Link link = link_of(parent, body);
    const std::int32_t up = link.load(std::memory_order_relaxed);
    SCREE_ASSERT(up <= body);
    const std::int32_t above = link_of(parent, up).load(std::memory_order_relaxed);
    if (above == up) return up;
    // Path halving. Another thread may have set an even higher one meanwhile: this one is as true.
    link.store(above, std::memory_order_relaxed);
    body = above;
  }
}

void unite(Column<std::int32_t>& parent, std::int32_t a, std::int32_t b) {
  for (;;) {
    a = find_root(parent, a);
    b = find_root(parent, b);
    if (a == b) return;
    if (a < b) std::swap(a, b);
    std::int32_t root = a;
    if (link_of(parent, a).compare_exchange_weak(root, b, std::memory_order_relaxed)) return;
  }
}

void mark(Column<std::uint8_t>& marks, std::int32_t body) {
  std::atomic_ref<std::uint8_t>(marks[body]).store(1, std::memory_order_relaxed);
}

// Calls work(i) for all i in [0, count).
template <class Work>
void for_each(Crew& crew, std::size_t count, Work&& work) {
  crew.run_ranges(static_cast<int>(count), kChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) work(static_cast<std::size_t>(i));
  });
}

// Bodies of a contact.
struct Ends {
  std::int32_t a, b;
};

Ends ends_of(const WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.now.pair[row];
  return {data.shapes.body[pair.a], data.shapes.body[pair.b]};
}
Ends ends_of(const WorldData& data, std::int32_t row) { return ends_of(data, static_cast<std::size_t>(row)); }

bool is_enabled(const Joints& joints, std::size_t row) {
  constexpr std::uint8_t kWhole = kJointAlive | kJointEnabled;
  return (joints.flags[row] & kWhole) == kWhole;
}
Ends joint_ends(const WorldData& data, std::int32_t row) {
  const JointBodies bodies = data.joints.bodies[row];
  return {bodies.a, bodies.b};
}

// Whether the contact or joint has something to solve.
bool takes_part(const WorldData& data, Ends ends) {
  return is_awake_dynamic(data.bodies, ends.a) || is_awake_dynamic(data.bodies, ends.b);
}

void freeze_shapes(WorldData& data, std::int32_t body) {
  for (std::int32_t shape = data.bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = TreeKind::frozen;
  }
}

// The contacts of the pairs that move that have something to solve.
void list_parts(const WorldData& data, Islands& islands, Column<std::int32_t>& list, Crew& crew) {
  const Column<std::int32_t>& contact_of = data.contacts.pairs.contact;
  list_where(
      crew, contact_of.size(), islands.places, list,
      [&](std::size_t pair) {
        return contact_of[pair] >= 0 && takes_part(data, ends_of(data, contact_of[pair]));
      },
      [&](std::size_t pair) { return contact_of[pair]; });
}

// Wakes every island of sleeping bodies that an awake body touches, and lists the contacts that take part
// now.
void wake_touched_islands(WorldData& data, Islands& islands, Crew& crew) {
  Bodies& bodies = data.bodies;
  Contacts& contacts = data.contacts;
  const auto row_of = [&](std::size_t i) { return contacts.touching[i]; };
  list_where(
      crew, contacts.touching.size(), islands.places, islands.touched,
      [&](std::size_t i) {
        const Ends ends = ends_of(data, row_of(i));
        return is_asleep(bodies, ends.a) || is_asleep(bodies, ends.b);
      },
      row_of);
  refresh_joints(data, islands, crew);
  list_where(
      crew, data.joints.active.size(), islands.places, islands.pulled,
      [&](std::size_t i) {
        const Ends ends = joint_ends(data, data.joints.active[i]);
        return is_asleep(bodies, ends.a) || is_asleep(bodies, ends.b);
      },
      [&](std::size_t i) { return data.joints.active[i]; });
  if (islands.touched.empty() && islands.pulled.empty()) return;

  rouse_islands(data, islands, crew);
  refresh_lists(data, crew);
  // Pairs that rest go on resting until the next list of pairs; their contacts take part at once.
  list_parts(data, islands, islands.remaining, crew);
  islands.touched.resize_discarding(contacts.roused.size());
  std::transform(contacts.roused.begin(), contacts.roused.end(), islands.touched.begin(),
                 [&](std::int32_t row) { return contacts.resting.contact[row]; });
  contacts.touching.resize_discarding(islands.remaining.size() + islands.touched.size());
  const ShapePair* const pair = contacts.now.pair.data();
  std::merge(islands.remaining.begin(), islands.remaining.end(), islands.touched.begin(),
             islands.touched.end(), contacts.touching.begin(),
             [&](std::int32_t x, std::int32_t y) { return comes_before(pair[x], pair[y]); });
}

// Joins tired bodies that touch or are jointed, and marks the islands that something moving touches.
void find_tired_islands(WorldData& data, Islands& islands, Crew& crew) {
  const Bodies& bodies = data.bodies;
  const Column<std::int32_t>& touching = data.contacts.touching;
  // Of fixed bodies nobody asks for the mark: their rows may be anywhere, in memory that is not there yet.
  const auto is_candidate = [&](std::int32_t body) {
    const auto index = static_cast<std::size_t>(body);
    return bodies.type[index] == BodyType::dynamic && islands.tired[index] != 0;
  };
  const auto keeps_awake = [&](std::int32_t body) {
    const auto index = static_cast<std::size_t>(body);
    if (bodies.type[index] == BodyType::kinematic) return !is_still(bodies.velocity[index]);
    return bodies.type[index] == BodyType::dynamic;
  };
  const auto join = [&](Ends ends) {
    if (is_candidate(ends.a) && is_candidate(ends.b)) unite(islands.parent, ends.a, ends.b);
  };
  const auto keep_awake = [&](Ends ends) {
    const bool a = is_candidate(ends.a), b = is_candidate(ends.b);
    if (a && !b && keeps_awake(ends.b)) mark(islands.kept_awake, find_root(islands.parent, ends.a));
    if (b && !a && keeps_awake(ends.a)) mark(islands.kept_awake, find_root(islands.parent, ends.b));
  };
  const Column<std::int32_t>& joints = data.joints.active;
  for_each(crew, touching.size(), [&](std::size_t i) { join(ends_of(data, touching[i])); });
  for_each(crew, joints.size(), [&](std::size_t i) { join(joint_ends(data, joints[i])); });
  for_each(crew, touching.size(), [&](std::size_t i) { keep_awake(ends_of(data, touching[i])); });
  for_each(crew, joints.size(), [&](std::size_t i) { keep_awake(joint_ends(data, joints[i])); });
}

// Returns whether anybody fell asleep.
bool put_to_sleep(WorldData& data, Islands& islands, Crew& crew) {
  Bodies& bodies = data.bodies;
  std::atomic<std::int64_t> count{0};
  std::atomic<bool> anybody{false};
  crew.run_ranges(static_cast<int>(islands.candidates.size()), kChunk, [&](int begin, int end, int) {
    std::int64_t roots = 0;
    for (int i = begin; i < end; ++i) {
      const std::int32_t body = islands.candidates[i];
      const auto index = static_cast<std::size_t>(body);
      const std::int32_t root = find_root(islands.parent, body);
      islands.tired[index] = 0;
      roots += root == body ? 1 : 0;
      if (islands.kept_awake[root] != 0) continue;
      bodies.flags[index] = static_cast<std::uint8_t>(bodies.flags[index] | kBodyAsleep);
      bodies.velocity[index] = VelocityRow{};
      bodies.force[index] = ForceRow{};
      bodies.drift[index] = DriftRow{};  // rows that are equal take no room in snapshots
      freeze_shapes(data, body);
      anybody.store(true, std::memory_order_relaxed);
    }
    count.fetch_add(roots, std::memory_order_relaxed);
  });
  data.stats.islands = count.load(std::memory_order_relaxed);
  return anybody.load(std::memory_order_relaxed);
}

// Puts islands whose bodies are all tired to sleep.
void put_tired_islands_to_sleep(WorldData& data, Islands& islands, Crew& crew) {
  Bodies& bodies = data.bodies;
  const auto body_of = [&](std::size_t i) { return bodies.awake[i]; };
  list_where(
      crew, bodies.awake.size(), islands.places, islands.candidates,
      [&](std::size_t i) { return is_tired(data, body_of(i)); }, body_of);
  if (islands.candidates.empty()) return;

  islands.parent.resize_discarding(bodies.pose.size());
  islands.kept_awake.resize_discarding(bodies.pose.size());
  islands.tired.resize(bodies.pose.size());
  for_each(crew, islands.candidates.size(), [&](std::size_t i) {
    const std::int32_t body = islands.candidates[i];
    islands.parent[body] = body;
    islands.kept_awake[body] = 0;
    islands.tired[body] = 1;
  });
  find_tired_islands(data, islands, crew);
  if (!put_to_sleep(data, islands, crew)) return;
  list_where(
      crew, islands.candidates.size(), islands.places, data.events.sleep_begins,
      [&](std::size_t i) { return is_asleep(bodies, islands.candidates[i]); },
      [&](std::size_t i) {
        const auto body = static_cast<std::uint32_t>(islands.candidates[i]);
        return BodyId{body, bodies.generation[body]};
      });
  for (const BodyId& asleep : data.events.sleep_begins) {
    const auto body = static_cast<std::int32_t>(asleep.index);
    note_change(bodies, body);
    note_shapes(data, body);
  }
  bodies.asleep += static_cast<std::int32_t>(data.events.sleep_begins.size());
  refresh_lists(data, crew);
  Column<std::int32_t>& touching = data.contacts.touching;
  const auto row_of = [&](std::size_t i) { return touching[i]; };
  list_where(
      crew, touching.size(), islands.places, islands.remaining,
      [&](std::size_t i) { return takes_part(data, ends_of(data, row_of(i))); }, row_of);
  touching.swap(islands.remaining);
}

// Bodies that have woken since the last step, by calls or above, and are still there.
void list_woken(WorldData& data) {
  Events& events = data.events;
  for (const BodyId& body : events.woken) {
    if (data.bodies.generation[body.index] == body.generation &&
        data.bodies.type[body.index] == BodyType::dynamic) {
      events.sleep_ends.push_back(body);
    }
  }
  std::sort(events.sleep_ends.begin(), events.sleep_ends.end());
  events.woken.clear();
}

}  // namespace

bool wake_pulled_bodies(WorldData& data) {
  const Bodies& bodies = data.bodies;
  const Joints& joints = data.joints;
  bool any = false;
  for (const std::int32_t body : bodies.kinematic) {
    const auto row = static_cast<std::size_t>(body);
    if (bodies.first_joint[row] < 0 || is_still(bodies.velocity[row])) continue;
    for (std::int32_t joint = bodies.first_joint[row]; joint >= 0;) {
      const auto index = static_cast<std::size_t>(joint);
      const bool is_a = joints.bodies[index].a == body;
      const std::int32_t other = is_a ? joints.bodies[index].b : joints.bodies[index].a;
      if (is_enabled(joints, index) && is_asleep(bodies, other)) {
        wake_body(data, other);
        any = true;
      }
      joint = is_a ? joints.next[index].a : joints.next[index].b;
    }
  }
  return any;
}

void find_islands(WorldData& data, Crew& crew) {
  data.stats.islands = 0;
  islands_of(data).joints_judged = 0;
  data.contacts.roused.clear();
  if (data.settings.sleeping) {
    Islands& islands = islands_of(data);
    wake_touched_islands(data, islands, crew);
    put_tired_islands_to_sleep(data, islands, crew);
  }
  refresh_joints(data, islands_of(data), crew);
  if (!data.events.woken.empty()) list_woken(data);
  data.events.destroyed.swap(data.events.lost);
  data.events.lost.clear();
}

}  // namespace scree
