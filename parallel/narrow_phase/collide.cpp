// Narrow phase: candidate pairs -> contacts. Writes contacts.now, the contacts and axes of the pairs, and
// contacts.active. Read by the island phases, color_constraints and pack_blocks.
//
// Groups pairs by the types of their shapes, and by whether they are contacts already, with a counting sort.
// Each group runs through its kernel in chunks. Contacts are updated in their rows; the other pairs have rows
// of a round, from which those that touch are copied into free rows. Then lists the active ones. Every pass
// runs in parallel over fixed chunks, and nothing depends on their order.
//
// Hooks decide before that which pairs collide, and after it how contacts act: see ask_hooks.cpp.
//
// A contact's row is 250 bytes, a pair's 28 and in two lists 8 for its clearance, and most pairs do not
// touch.
#include <core/world/edit.h>
#include <core/world/wake.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/narrow_phase/narrow_phase.h>
#include <parallel/stages.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

using simd::CollideItem;

// Relative; more than the rounding of the sum and the difference that it stands beside.
constexpr float kMotionRounding = 1e-6f;

bool is_dynamic(BodyType type) { return type == BodyType::dynamic; }

static_assert(static_cast<int>(ShapeType::hull) == simd::kSolidHull);
static_assert(static_cast<int>(ShapeType::rounded_box) == simd::kSolidRoundedBox);
static_assert(static_cast<int>(ShapeType::cone) == simd::kSolidCone);
static_assert(sizeof(ShapeType) == sizeof(std::uint8_t));

// Of a pair of which one shape is smooth, and the other one any.
std::uint8_t smooth_kind(ShapeType a, ShapeType b) {
  if (a == ShapeType::mesh || b == ShapeType::mesh) return kMeshPair;
  const bool has_plane = a == ShapeType::half_space || b == ShapeType::half_space;
  return has_plane ? simd::kSmoothHalfSpace : simd::kSmooth;
}

// The first shape of a pair has the lower rank: convex shapes come before what has no end or no inside.
int rank_of(ShapeType type) {
  const bool is_convex = type != ShapeType::mesh && type != ShapeType::half_space;
  return static_cast<int>(type) + (is_convex ? 0 : kShapeTypeCount);
}

// The types of convex shapes in any order, or a convex shape and a half-space.
simd::CollideType collide_type(ShapeType a, ShapeType b) {
  constexpr simd::CollideType kOnHalfSpace[kFastTypeCount] = {simd::kSphereHalfSpace, simd::kCapsuleHalfSpace,
                                                              simd::kBoxHalfSpace, simd::kHullHalfSpace};
  if (a == ShapeType::half_space || b == ShapeType::half_space)
    return kOnHalfSpace[static_cast<int>(std::min(a, b))];
  constexpr simd::CollideType kTypes[kFastTypeCount][kFastTypeCount] = {
      {simd::kSphereSphere, simd::kSphereCapsule, simd::kSphereBox, simd::kSphereHull},
      {simd::kSphereCapsule, simd::kCapsuleCapsule, simd::kCapsuleBox, simd::kCapsuleHull},
      {simd::kSphereBox, simd::kCapsuleBox, simd::kBoxBox, simd::kBoxHull},
      {simd::kSphereHull, simd::kCapsuleHull, simd::kBoxHull, simd::kHullHull}};
  return kTypes[static_cast<int>(a)][static_cast<int>(b)];
}

// Whether the pair is not in the last list. If both shapes are at rest, a call has put one of them there: the
// pair is collided to see whether a sleeping body must wake.
bool is_new(const Contacts& contacts, std::int32_t row) {
  return !contacts.list_kept && contacts.last_place[row] < 0;
}

// Whether the body may push what it touches. If it rests, a call has put or stopped it there, and has woken
// what sleeps near it: see wake_neighbors.
bool may_push(const WorldData& data, std::int32_t body) {
  const BodyType type = data.bodies.type[body];
  if (is_dynamic(type)) return (data.bodies.flags[body] & kBodyAsleep) == 0;
  return type == BodyType::kinematic && !is_still(data.bodies.velocity[body]);
}

// A pair that is collided and touches is listed, so that its sleeping bodies wake.
std::uint8_t classify(const WorldData& data, std::int32_t row) {
  const ShapePair pair = data.contacts.pairs.pair[row];
  const std::int32_t body_a = data.shapes.body[pair.a];
  const std::int32_t body_b = data.shapes.body[pair.b];
  if (!is_dynamic(data.bodies.type[body_a]) && !is_dynamic(data.bodies.type[body_b])) return kNever;
  if (!may_push(data, body_a) && !may_push(data, body_b) && !is_new(data.contacts, row)) return kSkipped;
  const ShapeType a = data.shapes.type[pair.a], b = data.shapes.type[pair.b];
  if (is_smooth(a) || is_smooth(b)) return smooth_kind(a, b);
  if (a == ShapeType::mesh || b == ShapeType::mesh) return kMeshPair;
  return static_cast<std::uint8_t>(collide_type(a, b));
}

// Of a pair that cannot collide.
void clear_pair(Contacts& contacts, std::int32_t row) {
  for_each_contact(contacts, contacts.pairs.contact[row],
                   [&](std::int32_t contact) { contacts.now.points[contact] = 0; });
  if (!contacts.pairs.axis.empty()) contacts.pairs.axis[row] = {};
}

std::size_t group_of(const Contacts& contacts, std::int32_t row, int type) {
  return static_cast<std::size_t>(type + (contacts.pairs.contact[row] < 0 ? simd::kCollideTypes : 0));
}

// Classifies the pairs before they are counted, and lets the hook refuse some. Returns whether that was asked
// for.
bool filter(WorldData& data, NarrowPhase& phase, Crew& crew) {
  data.hooks.refused.clear();
  if (!has_filter(data)) return false;
  const int rows = static_cast<int>(data.contacts.pairs.pair.size());
  phase.kind.resize_discarding(rows);
  crew.run_ranges(rows, kPairChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) phase.kind[i] = classify(data, i);
  });
  filter_pairs(data, phase, crew);
  return true;
}

// Of pairs that were in the last list. If it cannot be told where, nothing is known of any.
void carry_clearance(const WorldData& data, NarrowPhase& phase, Crew& crew) {
  const Contacts& contacts = data.contacts;
  const std::size_t rows = data.hulls.data.empty() ? 0 : contacts.pairs.pair.size();
  if (phase.list_number == contacts.list_number && phase.clearance.size() == rows) return;
  const bool is_known =
      !phase.clearance.empty() && !contacts.list_kept && contacts.last_number == phase.list_number;
  phase.clearance.swap(phase.last_clearance);
  phase.clearance.resize_discarding(rows);
  crew.run_ranges(static_cast<int>(rows), kPairChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t last = is_known ? contacts.last_place[i] : -1;
      phase.clearance[i] = last >= 0 ? phase.last_clearance[last] : PairClearance{};
    }
  });
  phase.list_number = contacts.list_number;
}

// Whether the pair is still too far apart to touch. Its clearance shrinks by what both shapes have moved
// since the last narrow phase. The kernels would find it separated along the same axis as before, so that
// nothing else depends on whether they are asked.
bool is_clear(const WorldData& data, PairClearance& clearance, std::int32_t row) {
  if (!(clearance.gap > kSpeculativeDistance)) return false;
  const ShapePair pair = data.contacts.pairs.pair[row];
  const StepMotion &a = data.shapes.motion[pair.a], &b = data.shapes.motion[pair.b];
  const Vec3 way = to_vec3(b.offset) - to_vec3(a.offset);
  // What comes of an infinite turn, which is no number where the lever is 0, is not clear.
  const float nearer = length(way) + (a.turn + b.turn) * clearance.lever;
  clearance.gap -= nearer + kMotionRounding * (nearer + clearance.gap);
  return clearance.gap > kSpeculativeDistance;
}

// Pairs that are clear are skipped. `classified`: the kinds of the pairs are there.
std::uint8_t kind_of(const WorldData& data, NarrowPhase& phase, bool classified, std::int32_t row) {
  const bool clear = !phase.clearance.empty() && is_clear(data, phase.clearance[row], row);
  if (clear && !classified) return kSkipped;
  const std::uint8_t kind = classified ? phase.kind[row] : classify(data, row);
  if (clear && kind != kNever) return kSkipped;
  if (!phase.clearance.empty()) phase.clearance[row] = {};
  return kind;
}

// `classified`: the kinds of the pairs are there.
void count_groups(WorldData& data, NarrowPhase& phase, bool classified, Crew& crew) {
  const int rows = static_cast<int>(data.contacts.pairs.pair.size());
  const int chunks = (rows + kPairChunk - 1) / kPairChunk;
  if (!classified) phase.kind.resize_discarding(rows);
  phase.chunk_counts.resize_discarding(chunks);
  phase.outcomes.resize_discarding(chunks);
  crew.run_ranges(rows, kPairChunk, [&](int begin, int end, int) {
    GroupCounts counts{};
    for (int i = begin; i < end; ++i) {
      const std::uint8_t type = kind_of(data, phase, classified, i);
      phase.kind[i] = type;
      if (type < simd::kCollideTypes) ++counts[group_of(data.contacts, i, type)];
      if (type == kNever) clear_pair(data.contacts, i);
    }
    phase.chunk_counts[begin / kPairChunk] = counts;
  });
  // Counts become places: by group, then by chunk.
  std::int32_t place = 0;
  for (std::size_t group = 0; group < kPairGroups; ++group) {
    phase.group_begin[group] = place;
    for (GroupCounts& counts : phase.chunk_counts) {
      const std::int32_t count = counts[group];
      counts[group] = place;
      place += count;
    }
  }
  phase.group_begin[kPairGroups] = place;
  phase.order.resize_discarding(place);
}

void sort_by_group(const WorldData& data, NarrowPhase& phase, Crew& crew) {
  const int rows = static_cast<int>(data.contacts.pairs.pair.size());
  crew.run_ranges(rows, kPairChunk, [&](int begin, int end, int) {
    GroupCounts place = phase.chunk_counts[begin / kPairChunk];
    for (int i = begin; i < end; ++i) {
      const int type = phase.kind[i];
      if (type >= simd::kCollideTypes) continue;
      phase.order[place[group_of(data.contacts, i, type)]++] = i;
    }
  });
}

// The groups [first_group, first_group + kCollideTypes) in chunks of one type each. Smaller chunks of hulls
// in contact (32) gained nothing on two threads.
class TypeChunks {
 public:
  TypeChunks(const NarrowPhase& phase, std::size_t first_group)
      : group_begin_(phase.group_begin.data() + first_group) {
    for (std::size_t type = 0; type < simd::kCollideTypes; ++type) {
      const int count = group_begin_[type + 1] - group_begin_[type];
      chunk_begin_[type + 1] = chunk_begin_[type] + (count + simd::kCollideChunk - 1) / simd::kCollideChunk;
    }
  }
  int count() const { return chunk_begin_[simd::kCollideTypes]; }
  // Into NarrowPhase::order; a chunk ends where the next one begins.
  int begin(int chunk) const {
    if (chunk == count()) return group_begin_[simd::kCollideTypes];
    const std::size_t type = type_of(chunk);
    return group_begin_[type] + (chunk - chunk_begin_[type]) * simd::kCollideChunk;
  }
  std::size_t type_of(int chunk) const {
    std::size_t type = 0;
    while (chunk >= chunk_begin_[type + 1]) ++type;
    return type;
  }

 private:
  const std::int32_t* group_begin_;
  std::array<int, simd::kCollideTypes + 1> chunk_begin_{};
};

// Null where manifolds of the type are not recycled: making them takes as long.
simd::CollideKernels::Recycle recycle_of(const simd::CollideKernels& kernels, std::size_t type) {
  switch (type) {
    case simd::kBoxBox:
      return kernels.recycle_boxes;
    case simd::kBoxHull:
    case simd::kHullHull:
    case simd::kSmooth:
      return kernels.recycle_hulls;
    case simd::kCapsuleCapsule:
    case simd::kCapsuleBox:
    case simd::kCapsuleHull:
      return kernels.recycle_capsules;
    default:
      return nullptr;
  }
}

// Whether the kernel writes ContactRows::anchor: those of spheres do not.
bool writes_anchor(std::size_t type) {
  switch (type) {
    case simd::kSphereSphere:
    case simd::kSphereCapsule:
    case simd::kSphereBox:
    case simd::kSphereHull:
    case simd::kSphereHalfSpace:
      return false;
    default:
      return true;
  }
}

// Brings a contact's row nearer: rows are in no order, and no other chunk reads this one.
void fetch_contact(const simd::CollideColumns& columns, std::int32_t row) {
  const char* const manifold = reinterpret_cast<const char*>(columns.manifold + row);
  __builtin_prefetch(manifold);
  __builtin_prefetch(manifold + 64);
  __builtin_prefetch(columns.anchor + row);
}

// Collides the pairs that are contacts, in their rows.
void collide_contacts(WorldData& data, NarrowPhase& phase, Crew& crew) {
  const simd::CollideColumns columns = collide_columns(data);
  const simd::CollideKernels& kernels = crew.kernels().collide;
  const TypeChunks chunks(phase, 0);
  crew.run(chunks.count(), [&](int chunk, int) {
    const std::size_t type = chunks.type_of(chunk);
    const int begin = chunks.begin(chunk), count = chunks.begin(chunk + 1) - begin;
    CollideItem items[simd::kCollideChunk], left[simd::kCollideChunk];
    for (int k = 0; k < count; ++k) {
      items[k] = make_item(data, phase.order[begin + k]);
      fetch_contact(columns, items[k].row);
    }
    const simd::CollideKernels::Recycle recycle = recycle_of(kernels, type);
    if (recycle == nullptr || data.contacts.manifolds_stale) {
      kernels.collide[type](columns, items, count);
      return;
    }
    const int left_count = recycle(columns, items, count, left);
    if (left_count > 0) kernels.collide[type](columns, left, left_count);
  });
}

// Where kernels write the contacts of pairs that were none: of one round, by the pair's place in it.
simd::CollideColumns fresh_columns(WorldData& data, NarrowPhase& phase, std::size_t rows) {
  phase.fresh_manifold.resize_discarding(rows);
  phase.fresh_features.resize_discarding(rows);
  phase.fresh_surface.resize_discarding(rows);
  phase.fresh_anchor.resize_discarding(rows);
  phase.fresh_points.resize_discarding(rows);
  simd::CollideColumns columns = collide_columns(data);
  columns.manifold = phase.fresh_manifold.data();
  columns.features = phase.fresh_features.data();
  columns.surface = phase.fresh_surface.data();
  columns.anchor = phase.fresh_anchor.data();
  columns.points = phase.fresh_points.data();
  return columns;
}

// Adds rows behind all others; see provide_rows().
void add_rows(Contacts& contacts, std::size_t count, std::size_t expected, bool with_forces) {
  if (count == 0) return;
  const std::size_t first = contacts.now.pair.size();
  const std::size_t size = first + count;
  const bool grows = size * sizeof(Manifold) > contacts.now.manifold.capacity_bytes();
  const std::size_t reserved = grows ? std::max(size, std::min(size + expected, 2 * first)) : size;
  contacts.now.for_each_column([&](ColumnKind, const char*, auto& column) { column.reserve(reserved); });
  // To zero, because not every contact writes all of its row, and state must not depend on old bytes.
  contacts.now.resize(size);
  if (with_forces) contacts.forces.resize(size);
}

// Makes the pair's contact at `place` of the round one of the world's.
void add_contact(Contacts& contacts, const NarrowPhase& phase, std::int32_t place, std::int32_t pair,
                 std::int32_t row, bool has_anchor) {
  ContactRows& now = contacts.now;
  now.manifold[row] = phase.fresh_manifold[place];
  now.features[row] = phase.fresh_features[place];
  now.surface[row] = phase.fresh_surface[place];
  now.anchor[row] = phase.fresh_anchor[place];
  now.points[row] = phase.fresh_points[place];
  clear_unwritten(now, row, has_anchor);
  now.pair[row] = contacts.pairs.pair[pair];
  now.color[row] = kNoColor;
  now.next[row] = 0;
  contacts.pairs.contact[pair] = row;
  if (!contacts.forces.empty()) contacts.forces[row] = {};
}

// Collides the pairs that are no contacts, a round at a time. Those that touch take the last free rows, then
// new ones, in the order of their groups: where rounds end, which depends on the pairs that are clear, must
// not be seen in the rows.
void collide_others(WorldData& data, NarrowPhase& phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const simd::CollideKernels& kernels = crew.kernels().collide;
  const TypeChunks chunks(phase, simd::kCollideTypes);
  std::size_t collided = 0, touching = 0;  // so far; of no consequence but how memory grows
  for (int round = 0; round < chunks.count(); round += kRoundChunks) {
    const int round_end = std::min(round + kRoundChunks, chunks.count());
    const int first = chunks.begin(round);
    const auto size = static_cast<std::size_t>(chunks.begin(round_end) - first);
    const simd::CollideColumns columns = fresh_columns(data, phase, size);
    crew.run(round_end - round, [&](int place, int) {
      const int chunk = round + place;
      const int begin = chunks.begin(chunk), count = chunks.begin(chunk + 1) - begin;
      CollideItem items[simd::kCollideChunk]{};
      for (int k = 0; k < count; ++k) {
        items[k] = make_item(data, phase.order[begin + k]);
        items[k].row = begin - first + k;
      }
      kernels.collide[chunks.type_of(chunk)](columns, items, count);
    });
    list_where(crew, size, phase.places, phase.fresh,
               [&](std::int32_t i) { return phase.fresh_points[i] != 0; });
    const std::size_t count = phase.fresh.size();
    collided += size;
    touching += count;
    if (count == 0) continue;
    const auto left = static_cast<std::size_t>(chunks.begin(chunks.count()) - chunks.begin(round_end));
    const double share = static_cast<double>(touching) / static_cast<double>(collided);
    const auto expected = static_cast<std::size_t>(share * static_cast<double>(left));
    const std::size_t from_free = std::min(count, contacts.free_rows.size());
    const std::size_t first_new = contacts.now.pair.size();
    add_rows(contacts, count - from_free, expected, data.settings.contact_forces);
    const std::int32_t* const behind = contacts.free_rows.end();
    const auto row_of = [&](std::size_t i) {
      return i < from_free ? *(behind - 1 - i) : static_cast<std::int32_t>(first_new + (i - from_free));
    };
    crew.run_ranges(static_cast<int>(count), simd::kCollideChunk, [&](int begin, int end, int) {
      for (int i = begin; i < end; ++i) {
        const std::int32_t place = phase.fresh[i], pair = phase.order[first + place];
        add_contact(contacts, phase, place, pair, row_of(static_cast<std::size_t>(i)),
                    writes_anchor(phase.kind[pair]));
      }
    });
    contacts.free_rows.drop_back(from_free);
    contacts.free_mark.cut(contacts.free_rows.size());
  }
}

// Decides about the contacts of the pairs [begin, end). Calls touches(contact), rests() or loses(contact).
// What loses() returns true for is taken out of the pair's list.
template <class Touches, class Rests, class Loses>
void judge_contacts(Contacts& contacts, const NarrowPhase& phase, int begin, int end, Touches&& touches,
                    Rests&& rests, Loses&& loses) {
  for (int i = begin; i < end; ++i) {
    std::int32_t before = -1;
    for (std::int32_t contact = contacts.pairs.contact[i]; contact >= 0;) {
      const std::int32_t next = next_contact(contacts.now, contact);
      bool stays = true;
      if (phase.kind[i] == kSkipped) {
        rests();
      } else if (contacts.now.points[contact] != 0) {
        touches(contact);
      } else {
        stays = !loses(contact);
      }
      if (stays) {
        before = contact;
      } else if (before >= 0) {
        contacts.now.next[before] = next + 1;
      } else {
        contacts.pairs.contact[i] = next;
      }
      contact = next;
    }
  }
}

void list_contacts(WorldData& data, NarrowPhase& phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const int rows = static_cast<int>(contacts.pairs.pair.size());
  crew.run_ranges(rows, kPairChunk, [&](int begin, int end, int) {
    PairOutcome outcome{};
    judge_contacts(
        contacts, phase, begin, end, [&](std::int32_t) { ++outcome.active; }, [&] { ++outcome.resting; },
        [&](std::int32_t) {
          ++outcome.lost;
          return false;
        });
    phase.outcomes[begin / kPairChunk] = outcome;
  });
  PairOutcome all{};
  const auto place = [](std::int32_t& count, std::int32_t& sum) { sum += std::exchange(count, sum); };
  const std::size_t free = contacts.free_rows.size();
  all.lost = static_cast<std::int32_t>(free);
  for (PairOutcome& outcome : phase.outcomes) {
    place(outcome.active, all.active);
    place(outcome.lost, all.lost);
    all.resting += outcome.resting;
  }
  contacts.active.resize_discarding(all.active);
  contacts.free_rows.resize_for_overwrite(all.lost);
  data.stats.contacts = std::int64_t{all.active} + all.resting + contacts.resting_contacts;
  crew.run_ranges(rows, kPairChunk, [&](int begin, int end, int) {
    PairOutcome to = phase.outcomes[begin / kPairChunk];
    judge_contacts(
        contacts, phase, begin, end, [&](std::int32_t contact) { contacts.active[to.active++] = contact; },
        [] {},
        [&](std::int32_t contact) {
          contacts.free_rows[to.lost++] = contact;
          return true;
        });
  });
  for (std::size_t i = free; i < contacts.free_rows.size(); ++i) contacts.marks.mark(contacts.free_rows[i]);
}

}  // namespace

CollideItem make_item(const WorldData& data, std::int32_t place) {
  const ShapePair pair = data.contacts.pairs.pair[place];
  CollideItem item{};
  item.shape_1 = pair.a;
  item.shape_2 = pair.b;
  if (rank_of(data.shapes.type[pair.a]) > rank_of(data.shapes.type[pair.b])) {
    std::swap(item.shape_1, item.shape_2);
  }
  item.body_1 = data.shapes.body[item.shape_1];
  item.body_2 = data.shapes.body[item.shape_2];
  item.row = data.contacts.pairs.contact[place];
  item.pair = place;
  const BodyType type_1 = data.bodies.type[item.body_1];
  const BodyType type_2 = data.bodies.type[item.body_2];
  SCREE_ASSERT(item.body_1 != item.body_2);
  SCREE_ASSERT(is_dynamic(type_1) || is_dynamic(type_2));
  const BodyType type_a = is_dynamic(type_2) ? type_1 : type_2;
  if (!is_dynamic(type_2)) item.flags |= simd::kItemFlip;
  if (!is_dynamic(type_a)) item.flags |= simd::kItemStatic;
  if (type_a == BodyType::fixed) item.flags |= simd::kItemFixed;
  if (item.row >= 0) item.flags |= simd::kItemKnown;
  return item;
}

simd::CollideColumns collide_columns(WorldData& data) {
  Contacts& contacts = data.contacts;
  NarrowPhase& phase = static_cast<NarrowPhase&>(*data.narrow_phase);
  return {
      .shape_pose = data.shapes.pose.data(),
      .shape_extent = data.shapes.extent.data(),
      .shape_material = data.shapes.material.data(),
      .shape_hull = data.shapes.hull.data(),
      .hulls = data.hulls.data.data(),
      .shape_mesh = data.shapes.mesh.data(),
      .meshes = data.meshes.data.data(),
      .shape_type = reinterpret_cast<const std::uint8_t*>(data.shapes.type.data()),
      .body_pose = data.bodies.pose.data(),
      .body_velocity = data.bodies.velocity.data(),
      .dt = data.last_dt,
      .manifold = contacts.now.manifold.data(),
      .features = contacts.now.features.data(),
      .surface = contacts.now.surface.data(),
      .anchor = contacts.now.anchor.data(),
      .axis = contacts.pairs.axis.data(),
      .points = contacts.now.points.data(),
      .clearance = phase.clearance.empty() ? nullptr : phase.clearance.data(),
  };
}

void provide_rows(Contacts& contacts, std::size_t count, std::size_t expected, bool with_forces) {
  if (contacts.free_rows.size() >= count) return;
  const std::size_t first = contacts.now.pair.size();
  contacts.free_rows.reserve(count);
  add_rows(contacts, count - contacts.free_rows.size(), expected, with_forces);
  for (std::size_t row = first; row < contacts.now.pair.size(); ++row) {
    contacts.free_rows.push_back(static_cast<std::int32_t>(row));
  }
}

void clear_unwritten(ContactRows& rows, std::int32_t row, bool has_anchor) {
  if (!has_anchor) rows.anchor[row] = {};
  if ((rows.manifold[row].info & kManifoldRich) == 0) rows.surface[row] = {};
}

void collide(WorldData& data, Crew& crew) {
  if (!data.narrow_phase) data.narrow_phase = std::make_unique<NarrowPhase>();
  NarrowPhase& phase = static_cast<NarrowPhase&>(*data.narrow_phase);
  data.contacts.forces.resize(data.settings.contact_forces ? data.contacts.now.pair.size() : 0);
  carry_clearance(data, phase, crew);
  count_groups(data, phase, filter(data, phase, crew), crew);
  sort_by_group(data, phase, crew);
  collide_contacts(data, phase, crew);
  collide_others(data, phase, crew);
  collide_meshes(data, phase, crew);
  rule_contacts(data, phase, crew);
  list_contacts(data, phase, crew);
  data.contacts.manifolds_stale = false;
  forget_displaced(data);
}

}  // namespace scree
