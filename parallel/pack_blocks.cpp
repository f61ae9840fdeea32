// Packing: sorts the touching contacts by color and block variant and lays out the blocks.
//
// The sort is a counting sort in parts of fixed size, so within each color contacts keep the order of the
// touching list, which is that of their pairs, and nothing depends on threads. Contacts with hubs are then
// grouped by hub.
#include <parallel/constraints.h>
#include <parallel/stages.h>

#include <algorithm>
#include <numeric>

namespace scree {

namespace {

constexpr int kPartRows = 4096;  // rows of the touching list that one task counts and scatters
constexpr int kChunkManifolds =
    128;                            // a solver chunk: 2 to 5 us, long against a claim, short against a stage
constexpr int kTailManifolds = 64;  // a color of so many or fewer is run by one thread, without a barrier
constexpr int kKindsPerColor = simd::kPointBuckets * 2;

// Places in the order in which they are solved: the overflow, each hub color with the hub as A and as B, the
// dynamic colors, the static ones.
constexpr int kFirstHubPlace = 1;
constexpr int kFirstDynamicPlace = kFirstHubPlace + 2 * kHubColorLimit;
constexpr int kFirstStaticPlace = kFirstDynamicPlace + kColorLimit;
constexpr int kColorPlaces = kFirstStaticPlace + kColorLimit;
constexpr int kKeys = kColorPlaces * kKindsPerColor;

bool is_hub_place(int place) { return place >= kFirstHubPlace && place < kFirstDynamicPlace; }

int bucket_of(std::uint32_t points) { return points == 1 ? 0 : points == 2 ? 1 : 2; }

int place_of(const ContactEdge& edge) {
  // Whatever found no color shares the overflow's place: the variant tells static contacts apart.
  if (edge.color == kOverflowColor) return 0;
  switch (edge.kind) {
    case EdgeKind::pushed_b:
      return kFirstStaticPlace + edge.color;
    case EdgeKind::hub_a:
      return kFirstHubPlace + 2 * edge.color;
    case EdgeKind::hub_b:
      return kFirstHubPlace + 2 * edge.color + 1;
    default:
      return kFirstDynamicPlace + edge.color;
  }
}

int key_of(const ContactEdge& edge) {
  return place_of(edge) * kKindsPerColor + bucket_of(edge.info & kManifoldPointMask) * 2 +
         ((edge.info & kManifoldRich) != 0 ? 1 : 0);
}

// The sorted list: rows by key, and where each key's lanes begin.
struct KeyTable {
  std::int32_t totals[kKeys];
  std::int32_t first_lane[kKeys + 1];
};

// Turns counts by part and key into places: rows of one key lie together, parts in their order.
void place_keys(Column<std::int32_t>& histogram, int parts, int lanes, KeyTable& table) {
  std::fill(std::begin(table.totals), std::end(table.totals), 0);
  for (int part = 0; part < parts; ++part) {
    for (int key = 0; key < kKeys; ++key) {
      std::int32_t& count = histogram[static_cast<std::size_t>(part * kKeys + key)];
      const std::int32_t before = table.totals[key];
      table.totals[key] += count;
      count = before;
    }
  }
  // A hub's run begins with a block of its own. Two hubs may share a contact, in the overflow only.
  const std::int32_t hub_ends =
      std::accumulate(table.totals, table.totals + kFirstDynamicPlace * kKindsPerColor, 0) +
      std::accumulate(table.totals, table.totals + kKindsPerColor, 0);
  const std::int32_t most_hubs = hub_ends / (kHubDegree + 1);
  table.first_lane[0] = 0;
  for (int key = 0; key < kKeys; ++key) {
    const int place = key / kKindsPerColor;
    const std::int32_t total = table.totals[key];
    std::int32_t padded = (total + lanes - 1) / lanes * lanes;
    if (place == 0) padded = total * lanes;  // solved one by one: a block each
    if (is_hub_place(place)) padded += std::min(total, most_hubs) * lanes;
    table.first_lane[key + 1] = table.first_lane[key] + padded;
  }
}

// Touching list -> constraints.rows, sorted by key; counts the points on the way.
void sort_rows(WorldData& data, Constraints& constraints, Crew& crew, int lanes, KeyTable& table) {
  const Column<std::int32_t>& touching = data.contacts.touching;
  const int rows = static_cast<int>(touching.size());
  const int parts = (rows + kPartRows - 1) / kPartRows;
  constraints.keys.resize_discarding(touching.size());
  constraints.points.resize_discarding(static_cast<std::size_t>(parts));
  constraints.histogram.resize_discarding(static_cast<std::size_t>(parts) * kKeys);
  crew.run_ranges(rows, kPartRows, [&](int begin, int end, int) {
    const int part = begin / kPartRows;
    std::int32_t* counts = constraints.histogram.data() + static_cast<std::size_t>(part) * kKeys;
    std::fill(counts, counts + kKeys, 0);
    std::int32_t points = 0;
    for (int i = begin; i < end; ++i) {
      const ContactEdge& edge = constraints.edges[static_cast<std::size_t>(i)];
      const int key = key_of(edge);
      points += static_cast<std::int32_t>(edge.info & kManifoldPointMask);
      constraints.keys[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(key);
      ++counts[key];
    }
    constraints.points[static_cast<std::size_t>(part)] = points;
  });
  data.stats.contact_points =
      std::accumulate(constraints.points.begin(), constraints.points.end(), std::int64_t{0});

  place_keys(constraints.histogram, parts, lanes, table);
  constraints.rows.resize_discarding(static_cast<std::size_t>(table.first_lane[kKeys]));
  crew.run_ranges(rows, kPartRows, [&](int begin, int end, int) {
    std::int32_t* places = constraints.histogram.data() + static_cast<std::size_t>(begin / kPartRows) * kKeys;
    for (int i = begin; i < end; ++i) {
      const int key = constraints.keys[static_cast<std::size_t>(i)];
      const int place = places[key]++;
      const int lane = table.first_lane[key] + (key < kKindsPerColor ? place * lanes : place);
      constraints.rows[static_cast<std::size_t>(lane)] = touching[static_cast<std::size_t>(i)];
    }
  });
}

// Lays out chunks and stages one after the other.
class Layout {
 public:
  Layout(WorldData& data, Constraints& constraints, const simd::Kernels& kernels)
      : contacts_(data.contacts.now), constraints_(constraints), kernels_(kernels) {
    constraints.chunks.clear();
    constraints.stages.clear();
  }

  // A stage that one thread runs is joined to one before it: neither needs a barrier.
  void begin_stage(bool serial) {
    Column<ColorStage>& stages = constraints_.stages;
    if (!stages.empty() && serial && stages.back().serial) return;
    stages.push_back({static_cast<std::int32_t>(constraints_.chunks.size()), 0, serial, false});
  }

  // Rows that lie at `lane` and after become a chunk; the last block is filled up with its last row.
  void add_chunk(int key, bool is_static, int lane, int count, simd::BodySide hub = simd::BodySide::none) {
    const int lanes = kernels_.lanes;
    const int end = lane + (count + lanes - 1) / lanes * lanes;
    Column<std::int32_t>& rows = constraints_.rows;
    for (int pad = lane + count; pad < end; ++pad) {
      rows[static_cast<std::size_t>(pad)] = rows[static_cast<std::size_t>(lane + count - 1)];
    }
    const int kind = key % kKindsPerColor;
    const bool rich = kind % 2 != 0;
    const int variant = simd::contact_variant(kind / 2, rich, is_static);
    const int blocks = (end - lane) / lanes;
    constraints_.chunks.push_back({variant, blocks, count, lane, offset_,
                                   static_cast<std::int32_t>(constraints_.chunks.size()), hub,
                                   simd::BodySide::none});
    offset_ += static_cast<std::size_t>(blocks) * kernels_.contact.block_bytes[variant];
    used_blocks_ += blocks;
    ColorStage& stage = constraints_.stages.back();
    stage.rich = stage.rich || rich;
    ++stage.chunk_count;
  }

  // One by one.
  void add_overflow(int key, int first_lane, int count) {
    for (int lane = first_lane; lane < first_lane + count * kernels_.lanes; lane += kernels_.lanes) {
      const auto row = static_cast<std::size_t>(constraints_.rows[static_cast<std::size_t>(lane)]);
      add_chunk(key, (contacts_.manifold[row].info & kManifoldStatic) != 0, lane, 1);
    }
  }

  void add_color(int key, bool is_static, int first_lane, int count) {
    const int chunk_size = std::max(kChunkManifolds, kernels_.lanes);
    for (int begin = 0; begin < count; begin += chunk_size) {
      add_chunk(key, is_static, first_lane + begin, std::min(chunk_size, count - begin));
    }
  }

  // The contacts of each hub become one chunk, hubs in the order of their first contacts.
  void add_hubs(int key, simd::BodySide side, int first_lane, int count) {
    Column<BodyColors>& bodies = constraints_.body_colors;
    Column<std::int32_t>& counts = constraints_.hub_counts;
    const auto hub_of = [&](std::int32_t row) -> BodyColors& {
      const Manifold& manifold = contacts_.manifold[static_cast<std::size_t>(row)];
      return bodies[static_cast<std::size_t>(side == simd::BodySide::a ? manifold.row_a : manifold.row_b)];
    };
    std::int32_t* rows = constraints_.rows.data() + first_lane;
    counts.clear();
    constraints_.hub_rows.resize_discarding(static_cast<std::size_t>(count));
    std::copy(rows, rows + count, constraints_.hub_rows.begin());
    for (const std::int32_t row : constraints_.hub_rows) {
      BodyColors& hub = hub_of(row);
      if (hub.number < 0) {
        hub.number = static_cast<std::int32_t>(counts.size());
        counts.push_back(0);
      }
      ++counts[static_cast<std::size_t>(hub.number)];
    }
    std::int32_t lane = 0;
    for (std::int32_t& hub_count : counts) {  // -> where the hub's run begins
      const std::int32_t size = hub_count;
      hub_count = lane;
      lane += (size + kernels_.lanes - 1) / kernels_.lanes * kernels_.lanes;
    }
    for (const std::int32_t row : constraints_.hub_rows) {
      rows[counts[static_cast<std::size_t>(hub_of(row).number)]++] = row;
    }
    lane = 0;
    for (const std::int32_t end : counts) {
      add_chunk(key, false, first_lane + lane, end - lane, side);
      lane = (end + kernels_.lanes - 1) / kernels_.lanes * kernels_.lanes;
    }
    for (const std::int32_t row : constraints_.hub_rows) hub_of(row).number = -1;
  }

  std::size_t bytes() const { return offset_; }
  std::int32_t used_blocks() const { return used_blocks_; }

 private:
  const ContactRows& contacts_;
  Constraints& constraints_;
  const simd::Kernels& kernels_;
  std::size_t offset_ = 0;
  std::int32_t used_blocks_ = 0;
};

}  // namespace

void pack_blocks(WorldData& data, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  const int lanes = crew.kernels().lanes;
  KeyTable table;
  sort_rows(data, constraints, crew, lanes, table);

  Layout layout(data, constraints, crew.kernels());
  std::int32_t colors = 0;
  for (int place = 0; place < kColorPlaces; ++place) {
    const std::int32_t* totals = table.totals + place * kKindsPerColor;
    const std::int32_t in_color = std::accumulate(totals, totals + kKindsPerColor, 0);
    if (in_color == 0) continue;
    ++colors;
    const bool is_static = place >= kFirstStaticPlace;
    if (!is_hub_place(place)) layout.begin_stage(place == 0 || in_color <= kTailManifolds);
    for (int key = place * kKindsPerColor; key < (place + 1) * kKindsPerColor; ++key) {
      const int count = table.totals[key], first_lane = table.first_lane[key];
      if (count == 0) continue;
      if (is_hub_place(place)) {
        // Two kinds may have contacts of the same hub.
        layout.begin_stage(in_color <= kTailManifolds);
        layout.add_hubs(key, (place - kFirstHubPlace) % 2 == 0 ? simd::BodySide::a : simd::BodySide::b,
                        first_lane, count);
      } else if (place == 0) {
        layout.add_overflow(key, first_lane, count);
      } else {
        layout.add_color(key, is_static, first_lane, count);
      }
    }
  }
  constraints.blocks.resize_discarding(layout.bytes());
  data.stats.colors = colors;
  const double rows = static_cast<double>(data.contacts.touching.size());
  data.stats.lane_fill =
      layout.used_blocks() == 0 ? 1.0 : rows / (static_cast<double>(layout.used_blocks()) * lanes);
}

}  // namespace scree
