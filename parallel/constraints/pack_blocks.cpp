// Packs blocks: sorts the active contacts and the active joints by color and block variant, lays out the
// blocks, and groups constraints with hubs by hub.
#include <core/world/mix.h>
#include <parallel/constraints/level_overflow.h>
#include <parallel/constraints/order_chunks.h>
#include <parallel/constraints/sort_constraints.h>
#include <parallel/distributed/border.h>
#include <parallel/stages.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

namespace scree {

namespace {

// Rows of a solver chunk: 2 to 5 us, long against a claim, short against a stage. Stages of few rows are cut
// finer, so that threads end together: on 2 threads ragdoll_rain solves 2 to 5 % faster so, but drum, whose
// stages are long, loses 1 % with short chunks throughout.
constexpr int kChunkRows = 128, kShortChunkRows = 64, kFewRows = 1024;
static_assert(kShortChunkRows % simd::kBlock == 0);
constexpr int kTailRows = 64;  // a color of so many or fewer is run by one thread, without a barrier

// Numbers the kinds that occur among the joints without gaps, so that the sort has few keys.
struct JointBlockKindNumbers {
  static_assert(kJointBlockKinds <= 256, "numbers of kinds are bytes");
  int count = 0;
  std::uint8_t number[kJointBlockKinds];
  std::uint8_t kind[kJointBlockKinds];  // by number

  explicit JointBlockKindNumbers(const Column<JointBlockKindSet>& parts) {
    for (int word = 0; word < static_cast<int>(std::size(JointBlockKindSet{}.bits)); ++word) {
      std::uint64_t present = 0;
      for (const JointBlockKindSet& part : parts) present |= part.bits[word];
      for (; present != 0; present &= present - 1) {
        const int k = word * 64 + std::countr_zero(present);
        number[k] = static_cast<std::uint8_t>(count);
        kind[count++] = static_cast<std::uint8_t>(k);
      }
    }
  }
};

// The edges of joints come behind those of contacts.
std::int32_t first_joint_of(const WorldData& data) {
  return static_cast<std::int32_t>(data.contacts.active.size());
}

// Of the edges from `first` on.
void find_joint_block_kinds(Constraints& constraints, std::int32_t first, Crew& crew) {
  const int count = static_cast<int>(constraints.edges.size()) - first;
  constraints.joint_block_kinds.resize_discarding((count + kSortRows - 1) / kSortRows);
  crew.run_ranges(count, kSortRows, [&](int begin, int end, int) {
    JointBlockKindSet present{};
    for (int i = begin; i < end; ++i) {
      const std::uint16_t kind = constraints.edges[first + i].info;
      present.bits[kind / 64] |= std::uint64_t{1} << (kind % 64);
    }
    constraints.joint_block_kinds[begin / kSortRows] = present;
  });
}

// Contacts or joints: their list, its first edge, their sorted rows and where their chunks go.
struct Family {
  const Column<std::int32_t>& list;
  std::int32_t first_edge;
  const KeyTable& keys;
  Column<std::int32_t>& rows;
  Column<simd::ConstraintChunk>& chunks;
  std::int32_t ColorStage::*chunk_count;
};

// What the blocks of a chunk have in common.
struct BlockKind {
  int variant;
  simd::BodySide fixed;  // joints only
  bool breaks;           // of joints
  bool rich;             // contacts only
  std::size_t bytes;
};

// Lays out chunks and stages one after the other.
class Layout {
 public:
  Layout(const WorldData& data, Constraints& constraints, const JointBlockKindNumbers& joint_block_kinds,
         const simd::Kernels& kernels)
      : contacts{data.contacts.active,       0,
                 constraints.contact_keys,   constraints.contact_lanes,
                 constraints.contact_chunks, &ColorStage::contact_chunk_count},
        joints{data.joints.active,      first_joint_of(data),     constraints.joint_keys,
               constraints.joint_lanes, constraints.joint_chunks, &ColorStage::joint_chunk_count},
        data_(data),
        constraints_(constraints),
        block_kinds_(joint_block_kinds),
        kernels_(kernels) {
    constraints.contact_chunks.clear();
    constraints.joint_chunks.clear();
    constraints.stages.clear();
  }

  const Family contacts, joints;

  // Stages that begin from here on belong to this turn.
  void begin_turn(std::int32_t turn) { turn_ = turn; }

  // Merges a stage that one thread runs with such a stage before it: neither needs a barrier. Not where ranks
  // exchange velocities between turns.
  void begin_stage(bool serial) {
    Column<ColorStage>& stages = constraints_.stages;
    if (!stages.empty() && serial && stages.back().serial &&
        (data_.border == nullptr || stages.back().turn == turn_))
      return;
    stages.push_back({static_cast<std::int32_t>(constraints_.contact_chunks.size()), 0,
                      static_cast<std::int32_t>(constraints_.joint_chunks.size()), 0, turn_, serial, false});
  }

  // Lays out a level of the constraints without a color, from `lane` on; returns the lane behind it.
  std::int32_t add_level(const Family& family, std::size_t level, std::int32_t lane) {
    for_each_overflow_run(constraints_, family.keys, level, [&](int begin, int end, int kind) {
      for (int place = begin; place < end; ++place) {
        const std::int32_t edge = family.keys.overflow[place];
        family.rows[lane + place - begin] = family.list[edge - family.first_edge];
      }
      add_color(family, kind_of(family, kind, false), lane, end - begin);
      lane += padded(end - begin);
    });
    return lane;
  }

  // The rows of one kind in one color; `hubs` have a stage of their own for each kind, as two kinds may have
  // constraints of the same hub.
  void add_kind(const Family& family, int place, int kind, bool serial) {
    const int key = place * family.keys.kinds + kind;
    const int count = family.keys.totals[key];
    if (count == 0) return;
    const int first_lane = family.keys.first_lane[key];
    if (is_hub_place(place)) {
      begin_stage(serial);
      const BlockKind block = kind_of(family, kind, place == kStaticHubPlace);
      const bool hub_is_a =
          place == kStaticHubPlace ? block.fixed == simd::BodySide::b : (place - kFirstHubPlace) % 2 == 0;
      add_hubs(family, block, hub_is_a ? simd::BodySide::a : simd::BodySide::b, first_lane, count);
    } else {
      add_color(family, kind_of(family, kind, place >= kFirstStaticPlace), first_lane, count);
    }
  }

  std::size_t bytes() const { return offset_; }
  std::int32_t used_blocks() const { return used_blocks_; }

 private:
  BlockKind kind_of(const Family& family, int kind, bool is_static) const {
    if (&family == &joints) {
      const JointBlockKind joint = joint_block_kind(block_kinds_.kind[kind]);
      return {joint.variant, joint.fixed, joint.breaks, false,
              kernels_.joint.variant[joint.variant].block_bytes};
    }
    const bool rich = kind % 2 != 0;
    const int variant = simd::contact_variant(kind / 2, rich, is_static);
    return {variant, simd::BodySide::none, false, rich, kernels_.contact.block_bytes[variant]};
  }

  // Makes a chunk of the rows from `lane` on; repeats the last row to fill the last block.
  void add_chunk(const Family& family, const BlockKind& kind, int lane, int count,
                 simd::BodySide hub = simd::BodySide::none) {
    const int lanes = kernels_.lanes;
    SCREE_ASSERT(count > 0);
    const int end = lane + padded(count);
    for (int pad = lane + count; pad < end; ++pad) {
      family.rows[pad] = family.rows[lane + count - 1];
    }
    const int blocks = (end - lane) / lanes;
    const bool peaks = kind.breaks || (&family == &joints &&
                                       reports({family.rows.data() + lane, static_cast<std::size_t>(count)}));
    family.chunks.push_back(
        {kind.variant, blocks, count, lane, offset_, chunk_count_++, hub, kind.fixed, peaks});
    offset_ += static_cast<std::size_t>(blocks) * kind.bytes;
    used_blocks_ += blocks;
    ColorStage& stage = constraints_.stages.back();
    stage.rich = stage.rich || kind.rich;
    ++(stage.*family.chunk_count);
  }

  // Whether some of the joints do. Kinds of blocks do not tell these apart, as then asking for events would
  // change the order in which joints are solved.
  bool reports(std::span<const std::int32_t> rows) const {
    const Joints& all = data_.joints;
    return all.reporting > 0 && std::any_of(rows.begin(), rows.end(), [&](std::int32_t joint) {
             return (all.flags[joint] & kJointReports) != 0;
           });
  }

  int padded(int rows) const { return (rows + kernels_.lanes - 1) / kernels_.lanes * kernels_.lanes; }

  void add_color(const Family& family, const BlockKind& kind, int first_lane, int count) {
    const int chunk_size = count <= kFewRows ? kShortChunkRows : kChunkRows;
    for (int begin = 0; begin < count; begin += chunk_size) {
      add_chunk(family, kind, first_lane + begin, std::min(chunk_size, count - begin));
    }
  }

  std::int32_t hub_of(const Family& family, std::int32_t row, simd::BodySide side) const {
    if (&family == &joints) {
      const JointBodies bodies = data_.joints.bodies[row];
      return side == simd::BodySide::a ? bodies.a : bodies.b;
    }
    const Manifold& manifold = data_.contacts.now.manifold[row];
    return side == simd::BodySide::a ? manifold.row_a : manifold.row_b;
  }

  // Makes one chunk of the constraints of each hub, hubs in the order of their first constraints.
  void add_hubs(const Family& family, const BlockKind& kind, simd::BodySide side, int first_lane, int count) {
    Column<std::int32_t>& counts = constraints_.hub_counts;
    const auto colors_of = [&](std::int32_t row) -> BodyColors& {
      return constraints_.body_colors[hub_of(family, row, side)];
    };
    std::int32_t* rows = family.rows.data() + first_lane;
    counts.clear();
    constraints_.hub_rows.resize_discarding(count);
    std::copy(rows, rows + count, constraints_.hub_rows.begin());
    for (const std::int32_t row : constraints_.hub_rows) {
      BodyColors& hub = colors_of(row);
      if (hub.number < 0) {
        hub.number = static_cast<std::int32_t>(counts.size());
        counts.push_back(0);
      }
      ++counts[hub.number];
    }
    std::int32_t lane = 0;
    for (std::int32_t& hub_count : counts) {  // -> where the hub's run begins
      const std::int32_t size = hub_count;
      hub_count = lane;
      lane += padded(size);
    }
    for (const std::int32_t row : constraints_.hub_rows) {
      rows[counts[colors_of(row).number]++] = row;
    }
    lane = 0;
    for (const std::int32_t end : counts) {
      add_chunk(family, kind, first_lane + lane, end - lane, side);
      lane = padded(end);
    }
    for (const std::int32_t row : constraints_.hub_rows) colors_of(row).number = -1;
  }

  const WorldData& data_;
  Constraints& constraints_;
  const JointBlockKindNumbers& block_kinds_;
  const simd::Kernels& kernels_;
  std::size_t offset_ = 0;
  std::int32_t turn_ = 0;
  std::int32_t used_blocks_ = 0;
  std::int32_t chunk_count_ = 0;
};

// Even colors are solved before odd ones. In layers of planks the contacts below every other layer have the
// lower colors, and the rest have the upper ones. In ascending order a sweep carries a load only two layers
// far, and a tower of 25 swings for ever. (Worse: reversing the order from sweep to sweep; with an order by
// the golden section a pyramid of 100 rows falls.)
int turn_of_color(int color) { return (color % 2) * kColorLimit + color / 2; }

bool is_serial(std::int64_t in_color) { return in_color <= kTailRows; }

// The places that have constraints, in the order of solving; returns their number.
template <class InColor>
int list_places(const InColor& in_color_at, int (&places)[kColorPlaces]) {
  int count = 0;
  int *first_color = places, *last_color = places;
  for (int place = 0; place < kColorPlaces; ++place) {
    if (place == kFirstDynamicPlace) first_color = places + count;
    if (place == kFirstStaticPlace) last_color = places + count;
    if (in_color_at(place) != 0) places[count++] = place;
  }
  std::sort(first_color, last_color, [&](int one, int other) {
    const bool serial = is_serial(in_color_at(one));
    if (serial != is_serial(in_color_at(other))) return !serial;
    return turn_of_color(one - kFirstDynamicPlace) < turn_of_color(other - kFirstDynamicPlace);
  });
  return count;
}

// SplitMix64, see core/world/mix.h.
std::uint64_t split_mix(std::uint64_t& state) { return mixed(state += 0x9e3779b97f4a7c15u); }

// SolverOptions::shuffle_seed (Fisher and Yates).
void shuffle_places(const WorldData& data, int count, int (&places)[kColorPlaces]) {
  const std::uint32_t seed = data.settings.solver_options.shuffle_seed;
  if (data.settings.solver != Solver::sequential_impulse || seed == 0) return;
  std::uint64_t state = (std::uint64_t{seed} << 32) ^ data.step_count;
  for (int left = count; left > 1; --left) {
    const auto other = static_cast<int>(split_mix(state) % static_cast<std::uint64_t>(left));
    std::swap(places[left - 1], places[other]);
  }
}

// Lists what is solved together, in order.
void list_solving(Constraints& constraints, std::span<const int> places,
                  std::span<const std::int64_t> in_color) {
  Column<SolvedTogether>& solving = constraints.solving;
  solving.clear();
  const auto add_levels = [&](const Column<std::int32_t>& sizes, bool joints) {
    for (std::size_t level = 0; level < sizes.size(); ++level)
      solving.push_back({0, static_cast<std::int32_t>(level), joints, !joints, is_serial(sizes[level])});
  };
  for (const int place : places) {
    if (place != 0) {
      solving.push_back({place, 0, true, true, is_serial(in_color[static_cast<std::size_t>(place)])});
      continue;
    }
    add_levels(constraints.joint_keys.level_sizes, true);
    add_levels(constraints.contact_keys.level_sizes, false);
  }
}

// Lays out parts of these one after the other.
class Placer {
 public:
  Placer(Layout& layout, const JointBlockKindNumbers& numbers) : layout_(layout), numbers_(numbers) {}
  void begin(const SolvedTogether& item) {
    if (!is_hub_place(item.place)) layout_.begin_stage(item.serial);
  }
  void add_joints(const SolvedTogether& item) {
    if (!item.joints) return;
    if (item.place == 0) {
      joint_lane_ = layout_.add_level(layout_.joints, static_cast<std::size_t>(item.level), joint_lane_);
    } else {
      for (int kind = 0; kind < numbers_.count; ++kind)
        layout_.add_kind(layout_.joints, item.place, kind, item.serial);
    }
  }
  void add_contacts(const SolvedTogether& item) {
    if (!item.contacts) return;
    if (item.place == 0) {
      contact_lane_ =
          layout_.add_level(layout_.contacts, static_cast<std::size_t>(item.level), contact_lane_);
    } else {
      for (int kind = 0; kind < kContactKinds; ++kind)
        layout_.add_kind(layout_.contacts, item.place, kind, item.serial);
    }
  }

 private:
  Layout& layout_;
  const JointBlockKindNumbers& numbers_;
  std::int32_t joint_lane_ = 0, contact_lane_ = 0;  // of the next level
};

void lay_out_places(Layout& layout, const JointBlockKindNumbers& numbers,
                    std::span<const SolvedTogether> items) {
  Placer placer(layout, numbers);
  for (const SolvedTogether& item : items) {
    placer.begin(item);
    placer.add_joints(item);
    placer.add_contacts(item);
  }
}

// The same where ranks exchange velocities between turns. What one thread runs makes one stage in a single
// process, in which all joints come before all contacts: so do their turns here.
Turns lay_out_turns(Layout& layout, const JointBlockKindNumbers& numbers,
                    std::span<const SolvedTogether> items) {
  Turns turns;
  Placer placer(layout, numbers);
  const auto begin_turn = [&](const SolvedTogether& item) {
    layout.begin_turn(turns.count);
    placer.begin(item);
    return turns.count++;
  };
  const auto note_joints = [&](const SolvedTogether& item, std::int32_t turn) {
    if (item.place == 0) turns.of_joint_levels.push_back(turn);
    turns.of_joints[item.place] = turn;
  };
  const auto note_contacts = [&](const SolvedTogether& item, std::int32_t turn) {
    if (item.place == 0) turns.of_contact_levels.push_back(turn);
    turns.of_contacts[item.place] = turn;
  };
  for (std::size_t i = 0; i < items.size();) {
    if (!items[i].serial) {
      const std::int32_t turn = begin_turn(items[i]);
      if (items[i].joints) note_joints(items[i], turn);
      if (items[i].contacts) note_contacts(items[i], turn);
      placer.add_joints(items[i]);
      placer.add_contacts(items[i]);
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < items.size() && items[end].serial) ++end;
    for (std::size_t k = i; k < end; ++k) {
      if (!items[k].joints) continue;
      note_joints(items[k], begin_turn(items[k]));
      placer.add_joints(items[k]);
    }
    for (; i < end; ++i) {
      if (!items[i].contacts) continue;
      note_contacts(items[i], begin_turn(items[i]));
      placer.add_contacts(items[i]);
    }
  }
  return turns;
}

}  // namespace

void pack_blocks(WorldData& data, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  const int lanes = crew.kernels().lanes;
  const Column<std::int32_t>& contacts = data.contacts.active;
  const Column<std::int32_t>& joints = data.joints.active;
  data.stats.joints = static_cast<std::int64_t>(joints.size());
  const std::int32_t first_joint = first_joint_of(data);
  find_joint_block_kinds(constraints, first_joint, crew);
  const JointBlockKindNumbers numbers(constraints.joint_block_kinds);
  KeyTable &contact_keys = constraints.contact_keys, &joint_keys = constraints.joint_keys;
  contact_keys.kinds = kContactKinds;
  joint_keys.kinds = numbers.count;
  constraints.keys.resize_discarding(constraints.edges.size());
  Border* const border = border_of(data);
  const auto is_here = [&](const Edge& edge) { return border == nullptr || computes(*border, edge); };
  data.stats.contact_points =  // those that are only watched included
      count_keys(
          constraints, 0, contacts, kManifoldPointMask, contact_keys, crew,
          [](const Edge& edge) { return contact_kind(edge); }, is_here);
  count_keys(
      constraints, first_joint, joints, 0, joint_keys, crew,
      [&](const Edge& edge) { return int{numbers.number[edge.info]}; }, is_here);
  // A body that is a hub because of its contacts may have a single joint, and the other way round.
  const std::int32_t hubs = most_hubs(contact_keys, joint_keys);
  std::int64_t in_color[kColorPlaces];
  for (int place = 0; place < kColorPlaces; ++place) {
    in_color[place] = contact_keys.in_place[place] + joint_keys.in_place[place];
  }
  if (border != nullptr) count_everywhere(constraints, *border, in_color);
  level_overflow(data, constraints, 0, contacts.size(), in_color[0] == 0, lanes, contact_keys, crew);
  level_overflow(data, constraints, first_joint, joints.size(), in_color[0] == 0, lanes, joint_keys, crew);
  place_keys(lanes, hubs, contact_keys);
  place_keys(lanes, hubs, joint_keys);
  scatter_rows(constraints, 0, contacts, contact_keys, constraints.contact_lanes, crew);
  scatter_rows(constraints, first_joint, joints, joint_keys, constraints.joint_lanes, crew);
  const auto in_color_at = [&](int place) { return in_color[place]; };
  int places[kColorPlaces];
  const int colors = list_places(in_color_at, places);
  shuffle_places(data, colors, places);
  Layout layout(data, constraints, numbers, crew.kernels());
  const std::span<const int> used(places, static_cast<std::size_t>(colors));
  list_solving(constraints, used, in_color);
  const std::span<const SolvedTogether> items = std::as_const(constraints.solving).span();
  if (border != nullptr) {
    plan_refreshes(constraints, *border, first_joint, lay_out_turns(layout, numbers, items));
  } else {
    lay_out_places(layout, numbers, items);
  }
  order_chunks(data, constraints);
  constraints.blocks.resize_discarding(layout.bytes());
  data.stats.colors = colors;
  const auto rows = static_cast<double>(contacts.size() + joints.size());
  data.stats.lane_fill =
      layout.used_blocks() == 0 ? 1.0 : rows / (static_cast<double>(layout.used_blocks()) * lanes);
}

}  // namespace scree
