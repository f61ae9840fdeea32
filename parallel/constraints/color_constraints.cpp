// Colors constraints: gives every active contact and active joint a color such that no two constraints of
// one color share a dynamic body.
//
// A contact keeps its color while it touches, so that one new contact does not reshuffle the Gauss-Seidel
// order of a resting pile. New ones take the lowest free color in the order of a hash of groups of bodies
// (coloring.h): a color depends on what is near, and on no list and no count of the whole world.
// Contacts against bodies that cannot be pushed have colors of their own and are solved last.
//
// Hubs, which are bodies with many contacts, block no colors: their contacts are colored by the other body
// alone, and are solved in groups (see simd/constraints/constraint_block.h). A body with more contacts
// against bodies that cannot be pushed than there are colors has the rest of them solved in groups, too.
#include <parallel/constraints/coloring.h>
#include <parallel/distributed/border.h>
#include <parallel/stages.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace scree {

Constraints& constraints_of(WorldData& data) {
  if (data.constraints == nullptr) data.constraints = std::make_unique<Constraints>();
  return static_cast<Constraints&>(*data.constraints);
}

namespace {

constexpr int kEdgesPerTask = 4096;   // contacts and joints of one task
constexpr int kBodiesPerTask = 8192;  // bodies of one task

// From this many contacts on, threads share the coloring: 0.05 ms of serial work. Atomic operations cost
// twice as much as plain ones.
constexpr int kSharedContacts = 20000;
// From this many new ones on, so many threads or more share them, too, with the same colors. Two gain
// nothing: claims cost as much as colors do.
constexpr std::size_t kSharedNewContacts = 20000;
constexpr int kSharingThreads = 3;

// Adds, or sets bits, where other threads may do so too. Returns the value before.
template <bool kShared>
std::int32_t add(std::int32_t& count, std::int32_t more) {
  if constexpr (kShared) return std::atomic_ref(count).fetch_add(more, std::memory_order_relaxed);
  count += more;
  return count - more;
}

template <bool kShared>
std::uint64_t set_bits(std::uint64_t& mask, std::uint64_t bits) {
  if constexpr (kShared) return std::atomic_ref(mask).fetch_or(bits, std::memory_order_relaxed);
  const std::uint64_t before = mask;
  mask |= bits;
  return before;
}

template <bool kShared>
void clear_bits(std::uint64_t& mask, std::uint64_t bits) {
  if constexpr (kShared) {
    std::atomic_ref(mask).fetch_and(~bits, std::memory_order_relaxed);
  } else {
    mask &= ~bits;
  }
}

void clear_masks(const WorldData& data, Constraints& constraints, Crew& crew) {
  const bool border = data.border != nullptr;
  const Column<std::int32_t>& awake = data.bodies.awake;
  crew.run_ranges(static_cast<int>(awake.size()), kBodiesPerTask, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t body = awake[i];
      constraints.body_colors[body] = {0, 0, 0, 0, -1};
      if (border) constraints.clashes[body] = {};  // a step that lost a rank may have left some
      constraints.joint_count[body] = 0;
    }
  });
}

// Writes an edge; returns whether it is the same as in the last step, with a color, so that the masks are
// still valid.
bool list_edge(Edge& edge, std::int32_t body_a, std::int32_t body_b, std::uint16_t info, std::uint8_t color,
               bool pushed_b, bool same) {
  same = same && edge.body_a == body_a && edge.body_b == body_b && edge.color == color &&
         (edge.kind == EdgeKind::pushed_b) == pushed_b &&
         (color < color_limit(edge.kind) || (pushed_b && color == kStaticHubColor));
  edge.body_a = body_a;
  edge.body_b = body_b;
  edge.info = info;
  edge.color = color;
  if (!same) edge.kind = pushed_b ? EdgeKind::pushed_b : EdgeKind::dynamic;
  return same;
}

bool list_contact(const WorldData& data, Edge& edge, std::int32_t place, bool same) {
  const ContactRows& contacts = data.contacts.now;
  const std::int32_t row = data.contacts.active[place];
  const Manifold& manifold = contacts.manifold[row];
  return list_edge(edge, manifold.row_a, manifold.row_b, static_cast<std::uint16_t>(manifold.info),
                   contacts.color[row], (manifold.info & kManifoldStatic) != 0, same);
}

bool list_joint(const WorldData& data, Edge& edge, std::int32_t place, bool same) {
  const Joints& joints = data.joints;
  const std::int32_t row = joints.active[place];
  const JointBodies bodies = joints.bodies[row];
  const auto is_pushed = [&](std::int32_t body) { return data.bodies.type[body] == BodyType::dynamic; };
  const bool pushed_a = is_pushed(bodies.a), pushed_b = is_pushed(bodies.b);
  const int variant = simd::joint_variant(joints.type[row], (joints.flags[row] & kJointRich) != 0);
  const simd::BodySide fixed = !pushed_a   ? simd::BodySide::a
                               : !pushed_b ? simd::BodySide::b
                                           : simd::BodySide::none;
  const bool breaks = (joints.flags[row] & kJointBreaks) != 0;
  const auto info = static_cast<std::uint16_t>(number_of({variant, fixed, breaks}));
  const bool turned = fixed == simd::BodySide::b;
  return list_edge(edge, turned ? bodies.b : bodies.a, turned ? bodies.a : bodies.b, info, joints.color[row],
                   fixed != simd::BodySide::none, same);
}

// Lists the active contacts, then the active joints, as edges of a graph. Returns whether all of them are
// those of the last step, at the same places and with colors: then the colors stay valid, and the bodies'
// masks need not be rebuilt. That would be a third of the time, and atomic operations on masks make two
// threads slower than one.
bool list_edges(const WorldData& data, Constraints& constraints, int begin, int end) {
  const int contacts = static_cast<int>(data.contacts.active.size());
  bool same = true;
  for (int place = begin; place < end; ++place) {
    Edge& edge = constraints.edges[place];
    same = place < contacts ? list_contact(data, edge, place, same)
                            : list_joint(data, edge, place - contacts, same);
  }
  return same;
}

// Counts the constraints of each body with others that can be pushed, and how many of them are joints, which
// are the edges from `first_joint` on.
template <bool kShared>
void count_degrees(Constraints& constraints, int first_joint, int begin, int end) {
  for (int i = begin; i < end; ++i) {
    Edge& edge = constraints.edges[i];
    if (edge.kind == EdgeKind::pushed_b) continue;
    edge.kind = EdgeKind::dynamic;
    for (const std::int32_t body : {edge.body_a, edge.body_b}) {
      add<kShared>(constraints.body_colors[body].degree, 1);
      if (i >= first_joint) add<kShared>(constraints.joint_count[body], 1);
    }
  }
}

EdgeKind kind_of(const Column<BodyColors>& bodies, const Edge& edge) {
  if (edge.kind == EdgeKind::pushed_b) return EdgeKind::pushed_b;
  const bool hub_a = bodies[edge.body_a].degree > kHubDegree;
  const bool hub_b = bodies[edge.body_b].degree > kHubDegree;
  return hub_a && hub_b ? EdgeKind::two_hubs
         : hub_a        ? EdgeKind::hub_a
         : hub_b        ? EdgeKind::hub_b
                        : EdgeKind::dynamic;
}

struct Part {
  int begin, end;
  std::int32_t* uncolored;  // where its list goes
};

Part part_of(Constraints& constraints, int number) {
  const int begin = number * kEdgesPerTask;
  return {begin, std::min(begin + kEdgesPerTask, static_cast<int>(constraints.edges.size())),
          constraints.uncolored.data() + begin};
}

// Enters the kept colors of a part into its bodies' masks and lists the contacts that need one. Notes which
// colors clash, as happens after a body has changed its type or has become or ceased to be a hub; false if
// some do.
template <bool kShared>
bool keep_colors(Constraints& constraints, int number) {
  Column<BodyColors>& bodies = constraints.body_colors;
  const Part part = part_of(constraints, number);
  std::int32_t count = 0;
  bool sound = true;
  for (int i = part.begin; i < part.end; ++i) {
    Edge& edge = constraints.edges[i];
    edge.kind = kind_of(bodies, edge);
    if (edge.color >= color_limit(edge.kind)) {
      part.uncolored[count++] = i;
      continue;
    }
    const Masks masks = masks_of(bodies, edge);
    const std::uint64_t bit = std::uint64_t{1} << edge.color;
    const std::uint64_t twice_a = set_bits<kShared>(masks.a, bit) & bit;
    const std::uint64_t twice_b = &masks.a != &masks.b ? set_bits<kShared>(masks.b, bit) & bit : 0;
    if ((twice_a | twice_b) == 0) continue;
    const Masks clashes = masks_of(constraints.clashes, edge);
    set_bits<kShared>(clashes.a, twice_a);
    set_bits<kShared>(clashes.b, twice_b);
    sound = false;
  }
  constraints.part_counts[number] = count;
  return sound;
}

// Takes their colors from all that clash, and lists the contacts of a part that need one. That neither of two
// keeps its color makes what happens to a constraint depend on those at its own bodies alone.
template <bool kShared>
void drop_clashing_colors(Constraints& constraints, int number) {
  const Part part = part_of(constraints, number);
  std::int32_t count = 0;
  for (int i = part.begin; i < part.end; ++i) {
    Edge& edge = constraints.edges[i];
    if (edge.color < color_limit(edge.kind)) {
      const std::uint64_t bit = std::uint64_t{1} << edge.color;
      const Masks clashes = masks_of(constraints.clashes, edge);
      if (((clashes.a | clashes.b) & bit) == 0) continue;
      const Masks masks = masks_of(constraints.body_colors, edge);
      clear_bits<kShared>(masks.a, bit);
      clear_bits<kShared>(masks.b, bit);
      edge.color = kNoColor;
    }
    part.uncolored[count++] = i;
  }
  constraints.part_counts[number] = count;
}

// Enters the kept colors into the bodies' masks, without those that clash, and lists what needs a color part
// by part.
template <bool kShared>
void keep_sound_colors(const WorldData& data, Constraints& constraints, Crew& crew, int parts) {
  std::atomic<bool> sound{true};
  const auto keep = [&](int part) {
    if (!keep_colors<kShared>(constraints, part)) sound.store(false, std::memory_order_relaxed);
  };
  const auto drop = [&](int part) { drop_clashing_colors<kShared>(constraints, part); };
  const auto run = [&](auto& work) {
    if constexpr (kShared) {
      crew.run(parts, [&](int part, int) { work(part); });
    } else {
      for (int part = 0; part < parts; ++part) work(part);
    }
  };
  run(keep);
  if (Border* const border = border_of(data)) {
    share_clashes(constraints, *border);  // others may have found some
  } else if (sound.load(std::memory_order_relaxed)) {
    return;
  }
  run(drop);
  for (const std::int32_t body : data.bodies.awake) constraints.clashes[body] = {};
}

// Enters the kept colors into the masks of all bodies and lists the contacts that need one.
void keep_all_colors(const WorldData& data, Constraints& constraints, Crew& crew, int parts) {
  const int count = static_cast<int>(constraints.edges.size());
  const int first_joint = static_cast<int>(data.contacts.active.size());
  const bool shared = count >= kSharedContacts && crew.threads() > 1;
  clear_masks(data, constraints, crew);
  if (shared) {
    crew.run_ranges(count, kEdgesPerTask, [&](int begin, int end, int) {
      count_degrees<true>(constraints, first_joint, begin, end);
    });
  } else {
    count_degrees<false>(constraints, first_joint, 0, count);
  }
  if (Border* const border = border_of(data)) meet_neighbors(constraints, *border);
  if (shared) {
    keep_sound_colors<true>(data, constraints, crew, parts);
  } else {
    keep_sound_colors<false>(data, constraints, crew, parts);
  }
  constraints.uncolored.resize(
      join_parts(constraints.uncolored.data(), constraints.part_counts, kEdgesPerTask));
}

}  // namespace

void color_constraints(WorldData& data, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  const int contacts = static_cast<int>(data.contacts.active.size());
  const int count = contacts + static_cast<int>(data.joints.active.size());
  const int parts = (count + kEdgesPerTask - 1) / kEdgesPerTask;
  constraints.body_colors.resize(data.bodies.pose.size());
  constraints.joint_count.resize(data.bodies.pose.size());
  constraints.clashes.resize(data.bodies.pose.size());
  Border* const border = border_of(data);
  std::atomic<bool> same{border == nullptr && constraints.is_colored &&
                         std::cmp_equal(constraints.edges.size(), count)};
  constraints.edges.resize(count);
  crew.run_ranges(count, kEdgesPerTask, [&](int begin, int end, int) {
    if (!list_edges(data, constraints, begin, end)) same.store(false, std::memory_order_relaxed);
  });
  if (same.load(std::memory_order_relaxed)) {
    constraints.uncolored.resize_discarding(0);
    return;
  }
  constraints.is_colored = false;  // until all is done
  constraints.uncolored.resize_discarding(count);
  constraints.part_counts.resize_discarding(parts);
  keep_all_colors(data, constraints, crew, parts);

  if (border != nullptr) {
    color_across(constraints, *border);
  } else if (constraints.uncolored.size() >= kSharedNewContacts && crew.threads() >= kSharingThreads) {
    color_in_rounds(constraints, crew);
  } else {
    color_in_order(constraints, constraints.uncolored.span());
  }
  for (const std::int32_t i : constraints.uncolored) {
    const std::uint8_t color = constraints.edges[i].color;
    if (i < contacts) {
      data.contacts.now.color[data.contacts.active[i]] = color;
    } else {
      data.joints.color[data.joints.active[i - contacts]] = color;
    }
  }
  constraints.is_colored = true;
}

}  // namespace scree
