// Puts islands to sleep. A body that has been slow for long enough is tired. An island of tired bodies that
// touches no moving body falls asleep as a whole.
//
// Looks for islands among tired bodies only, so that most steps do nothing here. Finds them in parallel by
// union-find without locks (Anderson and Woll, "Wait-free parallel algorithms for the union-find problem",
// 1991). A root is linked under smaller roots only, so that the final root of an island is its smallest body
// in every order of contacts. Roots are read once all contacts are entered.
#include <core/world/edit.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/spread.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace scree {

namespace {

constexpr int kChunk = 2048;  // contacts or bodies of one task: 10 to 40 microseconds

bool is_tired(const WorldData& data, std::int32_t body) {
  const float slow_for = data.bodies.sleep_time[body];  // 0 while it moves, which no wait is too short for
  return (data.bodies.flags[body] & kBodyCanSleep) != 0 && slow_for > 0.0f &&
         slow_for >= data.settings.sleep_time;
}

// Relaxed order suffices: an entry always names the body itself or a smaller one of its island, and the
// barriers of stages order the rest.
using Link = std::atomic_ref<std::int32_t>;
Link link_of(Column<std::int32_t>& parent, std::int32_t body) { return Link(parent[body]); }

std::int32_t find_root(Column<std::int32_t>& parent, std::int32_t body) {
  for (;;) {
    Link link = link_of(parent, body);
    const std::int32_t up = link.load(std::memory_order_relaxed);
    SCREE_ASSERT(up <= body);
    const std::int32_t above = link_of(parent, up).load(std::memory_order_relaxed);
    if (above == up) return up;
    // Path halving. Another thread may have stored an ancestor even higher up; this one is correct, too.
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
    for (int i = begin; i < end; ++i) work(i);
  });
}

// Lists the tired bodies, each as an island of its own at first. Returns whether there are any.
bool list_tired(WorldData& data, Islands& islands, Crew& crew) {
  const Bodies& bodies = data.bodies;
  const auto body_of = [&](std::int32_t i) { return bodies.awake[i]; };
  list_where(
      crew, bodies.awake.size(), islands.places, islands.candidates,
      [&](std::int32_t i) { return is_tired(data, body_of(i)); }, body_of);
  if (islands.candidates.empty()) return false;
  islands.parent.resize_discarding(bodies.pose.size());
  islands.kept_awake.resize_discarding(bodies.pose.size());
  islands.tired.resize(bodies.pose.size());
  for_each(crew, islands.candidates.size(), [&](std::int32_t i) {
    const std::int32_t body = islands.candidates[i];
    islands.parent[body] = body;
    islands.kept_awake[body] = 0;
    islands.tired[body] = 1;
  });
  return true;
}

// An island may go on with bodies of other ranks, which know what touches it there.
void share_kept_awake(Border& border, Islands& islands, bool any_tired) {
  const auto is_candidate = [&](std::int32_t body) { return any_tired && islands.tired[body] != 0; };
  spread(
      border, any_tired,
      [&](std::int32_t body) {
        return is_candidate(body) && islands.kept_awake[find_root(islands.parent, body)] != 0;
      },
      [&](std::int32_t body) {
        if (!is_candidate(body)) return false;
        return std::exchange(islands.kept_awake[find_root(islands.parent, body)], std::uint8_t{1}) == 0;
      },
      [] {});
}

// Unites tired bodies that touch or are jointed, and marks the islands that a moving body touches.
void find_islands(WorldData& data, Islands& islands, Crew& crew) {
  const Bodies& bodies = data.bodies;
  const Column<std::int32_t>&contacts = data.contacts.active, &joints = data.joints.active;
  // The marks of fixed bodies are not read: their rows may lie in memory that has never been touched.
  const auto is_candidate = [&](std::int32_t body) {
    return bodies.type[body] == BodyType::dynamic && islands.tired[body] != 0;
  };
  const auto keeps_awake = [&](std::int32_t body) {
    if (bodies.type[body] == BodyType::kinematic) return !is_still(bodies.velocity[body]);
    return bodies.type[body] == BodyType::dynamic;
  };
  const auto join = [&](Ends ends) {
    if (is_candidate(ends.a) && is_candidate(ends.b)) unite(islands.parent, ends.a, ends.b);
  };
  const auto keep_awake = [&](Ends ends) {
    const bool a = is_candidate(ends.a), b = is_candidate(ends.b);
    if (a && !b && keeps_awake(ends.b)) mark(islands.kept_awake, find_root(islands.parent, ends.a));
    if (b && !a && keeps_awake(ends.a)) mark(islands.kept_awake, find_root(islands.parent, ends.b));
  };
  for_each(crew, contacts.size(), [&](std::int32_t i) { join(contact_ends(data, contacts[i])); });
  for_each(crew, joints.size(), [&](std::int32_t i) { join(joint_ends(data, joints[i])); });
  for_each(crew, contacts.size(), [&](std::int32_t i) { keep_awake(contact_ends(data, contacts[i])); });
  for_each(crew, joints.size(), [&](std::int32_t i) { keep_awake(joint_ends(data, joints[i])); });
}

void put_to_sleep(WorldData& data, std::int32_t body) {
  Bodies& bodies = data.bodies;
  bodies.flags[body] = static_cast<std::uint8_t>(bodies.flags[body] | kBodyAsleep);
  bodies.velocity[body] = VelocityRow{};
  bodies.force[body] = ForceRow{};
  bodies.drift[body] = DriftRow{};  // rows that are equal take no room in snapshots
  for (std::int32_t shape = bodies.first_shape[body]; shape >= 0; shape = data.shapes.next[shape]) {
    data.shapes.tree[shape] = TreeKind::frozen;
    data.shapes.motion[shape] = motion_at_rest(data.shapes.pose[shape]);
  }
}

// Puts the islands to sleep that nothing keeps awake, and lists their bodies.
void put_found_to_sleep(WorldData& data, Islands& islands, Crew& crew) {
  Bodies& bodies = data.bodies;
  const Column<std::int32_t>& candidates = islands.candidates;
  std::atomic<std::int64_t> count{0};
  std::atomic<bool> any{false};
  crew.run_ranges(static_cast<int>(candidates.size()), kChunk, [&](int begin, int end, int) {
    std::int64_t roots = 0;
    for (int i = begin; i < end; ++i) {
      const std::int32_t body = candidates[i];
      const std::int32_t root = find_root(islands.parent, body);
      islands.tired[body] = 0;
      roots += root == body ? 1 : 0;
      if (islands.kept_awake[root] != 0) continue;
      put_to_sleep(data, body);
      any.store(true, std::memory_order_relaxed);
    }
    count.fetch_add(roots, std::memory_order_relaxed);
  });
  data.stats.islands = count.load(std::memory_order_relaxed);
  if (!any.load(std::memory_order_relaxed)) return;
  list_where(
      crew, candidates.size(), islands.places, islands.fallen_asleep,
      [&](std::int32_t i) { return is_asleep(bodies, candidates[i]); },
      [&](std::int32_t i) { return candidates[i]; });
  for (const std::int32_t body : islands.fallen_asleep) {
    note_change(bodies, body);
    note_shapes(data, body);
  }
  bodies.asleep += static_cast<std::int32_t>(islands.fallen_asleep.size());
}

// Removes the contacts that have nothing left to solve from the list.
void drop_resting_contacts(WorldData& data, Islands& islands, Crew& crew) {
  Column<std::int32_t>& contacts = data.contacts.active;
  const auto contact_of = [&](std::int32_t i) { return contacts[i]; };
  list_where(
      crew, contacts.size(), islands.places, islands.remaining,
      [&](std::int32_t i) { return takes_part(data, contact_ends(data, contact_of(i))); }, contact_of);
  contacts.swap(islands.remaining);
}

}  // namespace

void put_islands_to_sleep(WorldData& data, Crew& crew) {
  Islands& islands = islands_of(data);
  islands.fallen_asleep.clear();
  if (!data.settings.sleeping) return;
  const bool any_tired = list_tired(data, islands, crew);
  if (any_tired) find_islands(data, islands, crew);
  if (Border* const border = border_of(data)) share_kept_awake(*border, islands, any_tired);
  if (!any_tired) return;
  put_found_to_sleep(data, islands, crew);
  if (islands.fallen_asleep.empty()) return;
  refresh_lists(data, crew);
  drop_resting_contacts(data, islands, crew);
}

}  // namespace scree
