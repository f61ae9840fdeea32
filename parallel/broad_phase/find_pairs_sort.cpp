// Sorting for the broad phase: the canonical list of pairs from the unsorted chunks of the join, and a radix
// sort for places along the curve, for long rows and for unsorted rows of pairs.
//
// Groups the pairs into buckets by their smaller shape (the owner), sorts each bucket by owner with a
// counting sort, and ranks each owner's short row by comparing all of its entries. Keys are unique, so the
// result does not depend on how the join was split.
#include <core/world/pair_key.h>
#include <parallel/broad_phase/broad_phase.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace scree {

namespace {

constexpr std::size_t kMaxBuckets = 256;     // write streams that caches and address translation bear
constexpr std::size_t kMinBucketWidth = 64;  // owners
constexpr int kMaxGroups = 64;               // of join chunks, each with counts of its own
constexpr std::int32_t kHeavyRow = 4096;     // pairs; longer rows are sorted by the whole crew
constexpr std::size_t kOwnersPerPair = 64;   // shapes a pair, above which pairs are few
constexpr std::size_t kFewRows = 2048;       // that comparing sorts sooner

std::uint64_t key_of(const SortKey& row) { return row.key; }

// Radix sort from the least significant digit, one stable pass for each; skips digits that all keys share.
template <class Row>
Row* radix_sort(Row* from, Row* to, std::int32_t count, Column<std::uint32_t>& digit_counts, Crew& crew) {
  constexpr int kDigits = 256;
  if (count < 2) return from;
  const int chunks = std::clamp(count / 4096, 1, 64);
  const int chunk_size = (count + chunks - 1) / chunks;
  digit_counts.resize_discarding(static_cast<std::size_t>(chunks) * kDigits);
  std::atomic<std::uint64_t> varying{0};
  crew.run_ranges(count, chunk_size, [&](int begin, int end, int) {
    std::uint64_t bits = 0;
    for (int i = begin; i < end; ++i) bits |= key_of(from[i]) ^ key_of(from[0]);
    varying.fetch_or(bits, std::memory_order_relaxed);
  });
  for (int shift = 0; shift < 64; shift += 8) {
    if ((varying.load(std::memory_order_relaxed) >> shift & 0xff) == 0) continue;
    const auto counts_of = [&](int begin) {
      return digit_counts.data() + static_cast<std::size_t>(begin / chunk_size) * kDigits;
    };
    std::fill(digit_counts.begin(), digit_counts.end(), 0u);
    crew.run_ranges(count, chunk_size, [&](int begin, int end, int) {
      std::uint32_t* counts = counts_of(begin);
      for (int i = begin; i < end; ++i) ++counts[key_of(from[i]) >> shift & 0xff];
    });
    std::uint32_t place = 0;
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
      for (std::size_t chunk = 0; chunk < static_cast<std::size_t>(chunks); ++chunk) {
        place += std::exchange(digit_counts[chunk * kDigits + digit], place);
      }
    }
    crew.run_ranges(count, chunk_size, [&](int begin, int end, int) {
      std::uint32_t* places = counts_of(begin);
      for (int i = begin; i < end; ++i) to[places[key_of(from[i]) >> shift & 0xff]++] = from[i];
    });
    std::swap(from, to);
  }
  return from;
}

struct Buckets {
  int shift;  // bucket of an owner: owner >> shift
  std::size_t count;
  std::size_t width() const { return std::size_t{1} << shift; }
};

Buckets choose_buckets(std::size_t shapes) {
  const std::size_t width =
      std::bit_ceil(std::max(kMinBucketWidth, (shapes + kMaxBuckets - 1) / kMaxBuckets));
  return {std::countr_zero(width), (shapes + width - 1) / width};
}

// Groups the join's pairs by bucket.
void scatter_pairs(BroadPhase& broad_phase, const Buckets& buckets, Crew& crew) {
  const auto chunks = static_cast<int>(broad_phase.found.size());
  const int groups = std::min(chunks, kMaxGroups);
  const auto count = buckets.count;
  Column<std::int32_t>& places = broad_phase.bucket_counts;
  places.resize_discarding(static_cast<std::size_t>(groups) * count);
  const auto for_each_pair = [&](int group, auto&& visit) {
    const auto begin = static_cast<std::size_t>(static_cast<std::int64_t>(group) * chunks / groups);
    const auto end = static_cast<std::size_t>((static_cast<std::int64_t>(group) + 1) * chunks / groups);
    for (std::size_t chunk = begin; chunk < end; ++chunk) {
      for (const ShapePair& pair : broad_phase.found[chunk]) visit(pair);
    }
  };
  crew.run(groups, [&](int group, int) {
    std::int32_t* counts = places.data() + static_cast<std::size_t>(group) * count;
    std::fill(counts, counts + count, 0);
    for_each_pair(group, [&](const ShapePair& pair) { ++counts[pair.a >> buckets.shift]; });
  });
  broad_phase.bucket_begins.resize_discarding(count + 1);
  std::int32_t place = 0;
  for (std::size_t bucket = 0; bucket < count; ++bucket) {
    broad_phase.bucket_begins[bucket] = place;
    for (std::size_t group = 0; group < static_cast<std::size_t>(groups); ++group) {
      place += std::exchange(places[group * count + bucket], place);
    }
  }
  broad_phase.bucket_begins[count] = place;
  crew.run(groups, [&](int group, int) {
    std::int32_t* to = places.data() + static_cast<std::size_t>(group) * count;
    for_each_pair(group,
                  [&](const ShapePair& pair) { broad_phase.bucketed[to[pair.a >> buckets.shift]++] = pair; });
  });
}

// Radix sort of the larger shapes of a row, which are not negative. Comparing sorts of a ground's 2,800 pairs
// took 8 % of the time to find all pairs.
void sort_long_row(std::int32_t* row, std::int32_t count) {
  constexpr int kBits = 11, kDigits = 1 << kBits;
  std::int32_t buffer[kHeavyRow], *from = row, *to = buffer;
  std::uint32_t varying = 0;
  for (std::int32_t i = 0; i < count; ++i) varying |= static_cast<std::uint32_t>(row[i] ^ row[0]);
  for (int shift = 0; shift < 32; shift += kBits) {
    if ((varying >> shift & (kDigits - 1)) == 0) continue;
    std::int32_t places[kDigits] = {};
    for (std::int32_t i = 0; i < count; ++i) ++places[from[i] >> shift & (kDigits - 1)];
    std::int32_t place = 0;
    for (std::int32_t& it : places) place += std::exchange(it, place);
    for (std::int32_t i = 0; i < count; ++i) to[places[from[i] >> shift & (kDigits - 1)]++] = from[i];
    std::swap(from, to);
  }
  if (from != row) std::copy(from, from + count, row);
}

// Sorts the rows that the kernel has left. `others` are those of the task.
void sort_long_rows(const simd::RankTask& task, std::int32_t* others) {
  std::int32_t begin = 0;
  for (std::int32_t owner = 0; owner < task.owners; ++owner) {
    const std::int32_t end = task.row_ends[owner];
    if (end - begin > simd::kRankedRow) {
      sort_long_row(others + begin, end - begin);
      for (std::int32_t i = begin; i < end; ++i) task.pairs[i] = {task.first_owner + owner, others[i]};
    }
    begin = end;
  }
}

// Sorts one bucket, or marks it as heavy. `begins` has one more place than the bucket has owners.
void sort_bucket(BroadPhase& broad_phase, const Buckets& buckets, std::size_t bucket, std::int32_t* begins,
                 const simd::PairKernels& kernels) {
  const std::int64_t first = broad_phase.bucket_begins[bucket];
  const auto count = static_cast<std::int32_t>(broad_phase.bucket_begins[bucket + 1] - first);
  const ShapePair* from = broad_phase.bucketed.data() + first;
  ShapePair* to = broad_phase.sorted.data() + first;
  std::int32_t* others =
      broad_phase.others.data() + first + static_cast<std::ptrdiff_t>(bucket * simd::kBlock);
  const auto width = buckets.width();
  const auto first_owner = static_cast<std::int32_t>(bucket << buckets.shift);
  broad_phase.bucket_is_heavy[bucket] = 0;
  if (count == 0) return;
  std::fill(begins, begins + width + 1, 0);
  for (std::int32_t i = 0; i < count; ++i) ++begins[from[i].a - first_owner];
  std::int32_t place = 0;
  std::int32_t longest = 0;
  for (std::size_t owner = 0; owner < width; ++owner) {
    longest = std::max(longest, begins[owner]);
    place += std::exchange(begins[owner], place);
  }
  if (longest > kHeavyRow) {
    broad_phase.bucket_is_heavy[bucket] = 1;
    return;
  }
  for (std::int32_t i = 0; i < count; ++i) others[begins[from[i].a - first_owner]++] = from[i].b;
  // Each owner's place has moved to its row's end.
  const simd::RankTask task{others, begins, first_owner, static_cast<std::int32_t>(width), to};
  kernels.rank_rows(task);
  if (longest > simd::kRankedRow) sort_long_rows(task, others);
}

// Sorts by keys alone: for lists with few pairs for the number of shapes, where most owners have none.
void sort_few(BroadPhase& broad_phase, Crew& crew) {
  ShapePair* to = broad_phase.bucketed.data();
  for (const Column<ShapePair>& pairs : broad_phase.found) to = std::copy(pairs.begin(), pairs.end(), to);
  const auto count = static_cast<std::int32_t>(broad_phase.sorted.size());
  const ShapePair* result = radix_sort(broad_phase.bucketed.data(), broad_phase.sorted.data(), count,
                                       broad_phase.digit_counts, crew);
  if (result != broad_phase.sorted.data()) broad_phase.sorted.swap(broad_phase.bucketed);
}

}  // namespace

SortKey* sort_by_key(SortKey* rows, SortKey* other, std::int32_t count, Column<std::uint32_t>& digit_counts,
                     Crew& crew) {
  return radix_sort(rows, other, count, digit_counts, crew);
}

ShapePair* sort_by_key(ShapePair* rows, ShapePair* other, std::int32_t count,
                       Column<std::uint32_t>& digit_counts, Crew& crew) {
  return radix_sort(rows, other, count, digit_counts, crew);
}

void sort_by_pair(BroadPhase& broad_phase, const Column<ShapePair>& pair_of, Column<std::int32_t>& rows,
                  Crew& crew) {
  const std::size_t count = rows.size();
  const auto key_at = [&](std::int32_t row) { return key_of(pair_of[row]); };
  const auto before = [&](std::int32_t x, std::int32_t y) { return key_at(x) < key_at(y); };
  if (std::is_sorted(rows.begin(), rows.end(), before)) return;  // as those that came to rest together
  if (count < kFewRows) {
    std::sort(rows.begin(), rows.end(), before);
    return;
  }
  broad_phase.sort_keys.resize_discarding(count);
  broad_phase.sort_keys_other.resize_discarding(count);
  SortKey* const keys = broad_phase.sort_keys.data();
  const auto all = static_cast<int>(count);
  crew.run_ranges(all, 4096, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) keys[i] = {key_at(rows[i]), rows[i], 0};
  });
  const SortKey* const sorted =
      sort_by_key(keys, broad_phase.sort_keys_other.data(), all, broad_phase.digit_counts, crew);
  crew.run_ranges(all, 4096, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) rows[i] = sorted[i].shape;
  });
  if (count <= kSortedMemory) return;
  broad_phase.sort_keys = {};
  broad_phase.sort_keys_other = {};
}

void sort_pairs(BroadPhase& broad_phase, std::size_t shapes, std::int64_t pairs, Crew& crew) {
  const auto count = static_cast<std::size_t>(pairs);
  broad_phase.bucketed.resize_discarding(count);
  broad_phase.sorted.resize_discarding(count);
  if (count == 0) return;
  if (count * kOwnersPerPair < shapes) {
    sort_few(broad_phase, crew);
    return;
  }
  const Buckets buckets = choose_buckets(shapes);
  // Kernels read a block beyond a bucket's last row, so no other thread may write there.
  broad_phase.others.resize_discarding(count + buckets.count * simd::kBlock);
  scatter_pairs(broad_phase, buckets, crew);
  broad_phase.bucket_is_heavy.resize_discarding(buckets.count);
  const std::size_t stride = (buckets.width() + 1 + 15) / 16 * 16;  // whole cache lines
  broad_phase.owner_begins.resize_discarding(static_cast<std::size_t>(crew.threads()) * stride);
  crew.run(static_cast<int>(buckets.count), [&](int bucket, int worker) {
    sort_bucket(broad_phase, buckets, static_cast<std::size_t>(bucket),
                broad_phase.owner_begins.data() + static_cast<std::size_t>(worker) * stride,
                crew.kernels().pair);
  });
  for (std::size_t bucket = 0; bucket < buckets.count; ++bucket) {
    if (broad_phase.bucket_is_heavy[bucket] == 0) continue;
    const std::int64_t first = broad_phase.bucket_begins[bucket];
    const auto length = static_cast<std::int32_t>(broad_phase.bucket_begins[bucket + 1] - first);
    ShapePair* to = broad_phase.sorted.data() + first;
    const ShapePair* result =
        sort_by_key(broad_phase.bucketed.data() + first, to, length, broad_phase.digit_counts, crew);
    if (result != to) {
      crew.run_ranges(length, 4096,
                      [&](int begin, int end, int) { std::copy(result + begin, result + end, to + begin); });
    }
  }
}

}  // namespace scree
