// Colors constraints in the order of their pairs' hashes: one by one, or in rounds with all threads. Both
// give the same colors, so it does not matter which is used when.
//
// In a round, each constraint claims its bodies, and one that comes first at all of them takes its color:
// what could still change it has one already (Blelloch, Fineman, Gibbons and Shun, "Internally deterministic
// parallel algorithms can be fast", 2012). Rounds run over a part of the order at a time, in which few
// constraints share a body.
#include <parallel/constraints/coloring.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

namespace scree {

namespace {

constexpr int kPartEdges = 2048;      // of one task
constexpr int kClaimsPerTask = 8192;  // bodies of one task
constexpr int kOrders = 1 << kOrderBits;

// Parts of the order that have rounds of their own. A body of seven new contacts has one in each then.
constexpr int kWindowBits = 3, kWindows = 1 << kWindowBits;
static_assert(kWindowBits <= kOrderBits);

// So many edges or fewer are sorted by comparing them.
constexpr std::size_t kFewEdges = 128;
// What rounds leave to one thread: so many edges, or all, once a round colors less than a part of them.
constexpr std::size_t kLastEdges = 512;
constexpr std::size_t kSlowRound = 16;

// A claim is the lower the later its round and the earlier its edge in the order, so those of earlier rounds
// need not be removed.
constexpr std::uint64_t kNoClaim = std::numeric_limits<std::uint64_t>::max();
constexpr int kRoundShift = 32 + kOrderBits;

std::uint64_t claim_of(const Edge& edge, std::int32_t place, std::uint64_t round) {
  const std::uint64_t later = (kNoClaim >> kRoundShift) - 1 - round;
  return later << kRoundShift | std::uint64_t{order_of(edge)} << 32 | static_cast<std::uint32_t>(place);
}

void claim(std::uint64_t& body, std::uint64_t value) {
  const std::atomic_ref<std::uint64_t> lowest(body);
  std::uint64_t before = lowest.load(std::memory_order_relaxed);
  while (value < before && !lowest.compare_exchange_weak(before, value, std::memory_order_relaxed)) {
  }
}

// Calls work(body) for the bodies in whose masks the edge's color must be free.
template <class Work>
void for_each_masked_body(const Edge& edge, Work&& work) {
  if (edge.kind == EdgeKind::dynamic || edge.kind == EdgeKind::hub_b) work(edge.body_a);
  if (edge.kind != EdgeKind::hub_b && edge.kind != EdgeKind::two_hubs) work(edge.body_b);
}

// Constraints::uncolored -> Constraints::windowed, window by window; ascending within each. Writes where they
// begin.
void cut_into_windows(Constraints& constraints, std::int32_t (&begins)[kWindows + 1], Crew& crew) {
  const auto window_of = [&](std::int32_t edge) {
    return order_of(constraints.edges[edge]) >> (kOrderBits - kWindowBits);
  };
  const int count = static_cast<int>(constraints.uncolored.size());
  const int parts = (count + kPartEdges - 1) / kPartEdges;
  Column<std::int32_t>& counts = constraints.part_counts;  // by part and window
  counts.resize_discarding(static_cast<std::size_t>(parts) * kWindows);
  constraints.windowed.resize_discarding(constraints.uncolored.size());
  crew.run_ranges(count, kPartEdges, [&](int begin, int end, int) {
    std::int32_t* const here = counts.data() + static_cast<std::ptrdiff_t>(begin / kPartEdges) * kWindows;
    std::fill(here, here + kWindows, 0);
    for (int i = begin; i < end; ++i) ++here[window_of(constraints.uncolored[i])];
  });
  std::int32_t before = 0;
  for (int window = 0; window < kWindows; ++window) {
    begins[window] = before;
    for (int part = 0; part < parts; ++part) {
      before += std::exchange(counts[static_cast<std::ptrdiff_t>(part) * kWindows + window], before);
    }
  }
  begins[kWindows] = before;
  crew.run_ranges(count, kPartEdges, [&](int begin, int end, int) {
    std::int32_t* const to = counts.data() + static_cast<std::ptrdiff_t>(begin / kPartEdges) * kWindows;
    for (int i = begin; i < end; ++i) {
      const std::int32_t edge = constraints.uncolored[i];
      constraints.windowed[to[window_of(edge)]++] = edge;
    }
  });
}

// One round over `places`. Those that get no color are moved to the front and counted.
std::size_t run_round(Constraints& constraints, std::span<std::int32_t> places, std::uint64_t round,
                      Crew& crew) {
  const int count = static_cast<int>(places.size()), parts = (count + kPartEdges - 1) / kPartEdges;
  Column<std::uint64_t>& claims = constraints.claims;
  crew.run_ranges(count, kPartEdges, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const Edge& edge = constraints.edges[places[static_cast<std::size_t>(i)]];
      const std::uint64_t own = claim_of(edge, places[static_cast<std::size_t>(i)], round);
      for_each_masked_body(edge, [&](std::int32_t body) { claim(claims[body], own); });
    }
  });
  constraints.part_counts.resize_discarding(parts);
  crew.run_ranges(count, kPartEdges, [&](int begin, int end, int) {
    int left = begin;
    for (int i = begin; i < end; ++i) {
      const std::int32_t place = places[static_cast<std::size_t>(i)];
      Edge& edge = constraints.edges[place];
      const std::uint64_t own = claim_of(edge, place, round);
      bool first = true;
      for_each_masked_body(edge, [&](std::int32_t body) { first = first && claims[body] == own; });
      if (first) {
        take_lowest_color(constraints.body_colors, edge);
      } else {
        places[static_cast<std::size_t>(left++)] = place;
      }
    }
    constraints.part_counts[begin / kPartEdges] = left - begin;
  });
  return join_parts(places.data(), constraints.part_counts, kPartEdges);
}

}  // namespace

void sort_by_order(Constraints& constraints, std::span<const std::int32_t> places) {
  // As long as the list of edges, which settles: a step with more new ones than any before allocates nothing.
  constraints.ordered.resize_discarding(constraints.edges.size());
  const auto order_at = [&](std::int32_t place) { return order_of(constraints.edges[place]); };
  if (places.size() <= kFewEdges) {
    std::uint64_t keys[kFewEdges];
    std::size_t count = 0;
    for (const std::int32_t place : places) {
      keys[count++] = std::uint64_t{order_at(place)} << 32 | static_cast<std::uint32_t>(place);
    }
    std::sort(keys, keys + count);
    for (std::size_t i = 0; i < count; ++i) constraints.ordered[i] = static_cast<std::int32_t>(keys[i]);
    return;
  }
  std::int32_t counts[kOrders] = {};
  for (const std::int32_t place : places) ++counts[order_at(place)];
  std::int32_t before = 0;
  for (std::int32_t& count : counts) before += std::exchange(count, before);
  for (const std::int32_t place : places) constraints.ordered[counts[order_at(place)]++] = place;
}

void color_in_order(Constraints& constraints, std::span<const std::int32_t> places) {
  sort_by_order(constraints, places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    take_lowest_color(constraints.body_colors, constraints.edges[constraints.ordered[i]]);
  }
}

void color_in_rounds(const WorldData& data, Constraints& constraints, Crew& crew) {
  std::int32_t begins[kWindows + 1];
  cut_into_windows(constraints, begins, crew);
  const Column<std::int32_t>& awake = data.bodies.awake;
  constraints.claims.resize_discarding(constraints.body_colors.size());
  crew.run_ranges(static_cast<int>(awake.size()), kClaimsPerTask, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) constraints.claims[awake[i]] = kNoClaim;
  });
  std::uint64_t round = 0;
  for (int window = 0; window < kWindows; ++window) {
    std::span<std::int32_t> left =
        constraints.windowed.span().subspan(static_cast<std::size_t>(begins[window]),
                                            static_cast<std::size_t>(begins[window + 1] - begins[window]));
    for (bool slow = false; left.size() > kLastEdges && !slow;) {
      const std::size_t rest = run_round(constraints, left, round++, crew);
      slow = left.size() - rest < left.size() / kSlowRound;
      left = left.first(rest);
    }
    color_in_order(constraints, left);
  }
}

}  // namespace scree
