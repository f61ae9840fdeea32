// Packing: sorts the touching contacts by color and block variant and lays out the blocks.
//
// The sort is a counting sort in parts of fixed size, so its result is the canonical order of the rows within
// each color and does not depend on threads.
#include <parallel/constraints.h>
#include <parallel/stages.h>

#include <algorithm>
#include <numeric>

namespace scree {

namespace {

constexpr int kPartRows = 4096;  // rows of the touching list that one task counts and scatters
constexpr int kChunkManifolds =
    128;  // a solver chunk: 2 to 5 us, long against a claim, short against a stage
constexpr int kKindsPerColor = simd::kPointBuckets * 2;
constexpr int kColorPlaces = 1 + 2 * kColorLimit;  // overflow, dynamic colors, static colors: solver order
constexpr int kKeys = kColorPlaces * kKindsPerColor;

int bucket_of(std::uint32_t points) { return points == 1 ? 0 : points == 2 ? 1 : 2; }

int key_of(std::uint32_t info, std::uint8_t color) {
  const bool is_static = (info & kManifoldStatic) != 0;
  // Static contacts that found no color share the overflow's place: their variant tells them apart.
  const int place = color >= kColorLimit ? 0 : 1 + color + (is_static ? kColorLimit : 0);
  return place * kKindsPerColor + bucket_of(info & kManifoldPointMask) * 2 +
         ((info & kManifoldRich) != 0 ? 1 : 0);
}

// Turns counts by part and key into places: rows of one key lie together, parts in their order. Returns the
// number of rows by key in `totals`, and where each key's lanes begin in `first_lane`.
void place_keys(Column<std::int32_t>& histogram, int parts, int lanes, std::int32_t (&totals)[kKeys],
                std::int32_t (&first_lane)[kKeys + 1]) {
  std::fill(std::begin(totals), std::end(totals), 0);
  for (int part = 0; part < parts; ++part) {
    for (int key = 0; key < kKeys; ++key) {
      std::int32_t& count = histogram[static_cast<std::size_t>(part * kKeys + key)];
      const std::int32_t before = totals[key];
      totals[key] += count;
      count = before;
    }
  }
  first_lane[0] = 0;
  for (int key = 0; key < kKeys; ++key) {
    // The overflow is solved one by one: a block each.
    const int padded = key < kKindsPerColor ? totals[key] * lanes : (totals[key] + lanes - 1) / lanes * lanes;
    first_lane[key + 1] = first_lane[key] + padded;
  }
}

}  // namespace

void pack_blocks(WorldData& data, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  const ContactRows& contacts = data.contacts.now;
  const Column<std::int32_t>& touching = data.contacts.touching;
  const simd::ContactKernels& kernels = crew.kernels().contact;
  const int lanes = crew.kernels().lanes;
  const int rows = static_cast<int>(touching.size());
  const int parts = (rows + kPartRows - 1) / kPartRows;

  constraints.keys.resize_discarding(touching.size());
  constraints.points.resize_discarding(static_cast<std::size_t>(parts));
  constraints.histogram.resize_discarding(static_cast<std::size_t>(parts) * kKeys);
  crew.run(parts, [&](int part, int) {
    std::int32_t* counts = constraints.histogram.data() + static_cast<std::size_t>(part) * kKeys;
    std::fill(counts, counts + kKeys, 0);
    std::int32_t points = 0;
    for (int i = part * kPartRows; i < std::min((part + 1) * kPartRows, rows); ++i) {
      const auto row = static_cast<std::size_t>(touching[static_cast<std::size_t>(i)]);
      const std::uint32_t info = contacts.manifold[row].info;
      const int key = key_of(info, contacts.color[row]);
      points += static_cast<std::int32_t>(info & kManifoldPointMask);
      constraints.keys[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(key);
      ++counts[key];
    }
    constraints.points[static_cast<std::size_t>(part)] = points;
  });

  data.stats.contact_points =
      std::accumulate(constraints.points.begin(), constraints.points.end(), std::int64_t{0});

  std::int32_t totals[kKeys], first_lane[kKeys + 1];
  place_keys(constraints.histogram, parts, lanes, totals, first_lane);
  constraints.rows.resize_discarding(static_cast<std::size_t>(first_lane[kKeys]));
  crew.run(parts, [&](int part, int) {
    std::int32_t* places = constraints.histogram.data() + static_cast<std::size_t>(part) * kKeys;
    for (int i = part * kPartRows; i < std::min((part + 1) * kPartRows, rows); ++i) {
      const int key = constraints.keys[static_cast<std::size_t>(i)];
      const int place = places[key]++;
      const int lane = first_lane[key] + (key < kKindsPerColor ? place * lanes : place);
      constraints.rows[static_cast<std::size_t>(lane)] = touching[static_cast<std::size_t>(i)];
    }
  });

  constraints.chunks.clear();
  constraints.stages.clear();
  std::size_t offset = 0;
  std::int32_t used_blocks = 0, colors = 0;
  for (int place = 0; place < kColorPlaces; ++place) {
    ColorStage stage{static_cast<std::int32_t>(constraints.chunks.size()), 0, place == 0, false};
    for (int kind = 0; kind < kKindsPerColor; ++kind) {
      const int key = place * kKindsPerColor + kind;
      if (totals[key] == 0) continue;
      const bool rich = kind % 2 != 0;
      const int manifolds_per_chunk = place == 0 ? 1 : std::max(kChunkManifolds, lanes);
      stage.rich = stage.rich || rich;
      for (int begin = 0; begin < totals[key]; begin += manifolds_per_chunk) {
        const int count = std::min(manifolds_per_chunk, totals[key] - begin);
        const int lane = first_lane[key] + (place == 0 ? begin * lanes : begin);
        const int end = lane + (count + lanes - 1) / lanes * lanes;
        for (int pad = lane + count; pad < end; ++pad) {
          constraints.rows[static_cast<std::size_t>(pad)] =
              constraints.rows[static_cast<std::size_t>(lane + count - 1)];
        }
        bool is_static = place > kColorLimit;
        if (place == 0) {
          const auto row = static_cast<std::size_t>(constraints.rows[static_cast<std::size_t>(lane)]);
          is_static = (contacts.manifold[row].info & kManifoldStatic) != 0;
        }
        const int variant = simd::contact_variant(kind / 2, rich, is_static);
        const int blocks = (end - lane) / lanes;
        constraints.chunks.push_back(
            {variant, blocks, count, lane, offset, static_cast<std::int32_t>(constraints.chunks.size())});
        offset += static_cast<std::size_t>(blocks) * kernels.block_bytes[variant];
        used_blocks += blocks;
        ++stage.chunk_count;
      }
    }
    if (stage.chunk_count > 0) {
      constraints.stages.push_back(stage);
      ++colors;
    }
  }
  constraints.blocks.resize_discarding(offset);
  data.stats.colors = colors;
  data.stats.lane_fill =
      used_blocks == 0 ? 1.0 : static_cast<double>(rows) / (static_cast<double>(used_blocks) * lanes);
}

}  // namespace scree
