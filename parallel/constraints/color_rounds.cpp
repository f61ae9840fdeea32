// Colors constraints in their order (coloring.h): one by one, or in rounds with all threads. Both give the
// same colors, so it does not matter which is used when.
//
// For rounds the order is cut into parts. In a round, each part claims the bodies of its constraints, and the
// first one of a body has it. Then each goes through its constraints in order, and colors those whose bodies
// it has and that wait for no earlier one: what could still change their colors has one already (Blelloch,
// Fineman, Gibbons and Shun, "Internally deterministic parallel algorithms can be fast", 2012).
#include <parallel/constraints/coloring.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

namespace scree {

namespace {

constexpr int kPartEdges = 2048;
constexpr int kOrders = 1 << kOrderBits;

// So many edges or fewer are sorted by comparing them.
constexpr std::size_t kFewEdges = 128;
// What rounds leave to one thread: all, once a round colors less than this part of what was left, as along a
// chain of bodies.
constexpr std::int64_t kSlowRound = 8;

// Calls work(body) for the bodies in whose masks the edge's color must be free.
template <class Work>
void for_each_masked_body(const Edge& edge, Work&& work) {
  if (edge.kind == EdgeKind::dynamic || edge.kind == EdgeKind::hub_b) work(edge.body_a);
  if (edge.kind != EdgeKind::hub_b && edge.kind != EdgeKind::two_hubs) work(edge.body_b);
}

// Calls work(part, places) for all parts of Constraints::ordered, with what they have left.
template <class Work>
void for_each_part(Constraints& constraints, Crew& crew, Work&& work) {
  crew.run(static_cast<int>(constraints.part_counts.size()), [&](int part, int) {
    std::int32_t* const first = constraints.ordered.data() + static_cast<std::ptrdiff_t>(part) * kPartEdges;
    work(part, std::span(first, static_cast<std::size_t>(constraints.part_counts[part])));
  });
}

void claim_bodies(Constraints& constraints, Crew& crew) {
  Column<BodyClaim>& claims = constraints.claims;
  for_each_part(constraints, crew, [&](int, std::span<const std::int32_t> places) {
    for (const std::int32_t place : places) {
      for_each_masked_body(constraints.edges[place], [&](std::int32_t body) {
        std::atomic_ref(claims[body].part)
            .store(std::numeric_limits<std::int32_t>::max(), std::memory_order_relaxed);
        std::atomic_ref(claims[body].waits).store(0, std::memory_order_relaxed);
      });
    }
  });
  for_each_part(constraints, crew, [&](int part, std::span<const std::int32_t> places) {
    for (const std::int32_t place : places) {
      for_each_masked_body(constraints.edges[place], [&](std::int32_t body) {
        const std::atomic_ref<std::int32_t> lowest(claims[body].part);
        std::int32_t before = lowest.load(std::memory_order_relaxed);
        while (part < before && !lowest.compare_exchange_weak(before, part, std::memory_order_relaxed)) {
        }
      });
    }
  });
}

// Colors what it can; returns how much is left.
std::int64_t run_round(Constraints& constraints, Crew& crew) {
  claim_bodies(constraints, crew);
  Column<BodyClaim>& claims = constraints.claims;
  for_each_part(constraints, crew, [&](int part, std::span<std::int32_t> places) {
    std::int32_t left = 0;
    for (const std::int32_t place : places) {
      Edge& edge = constraints.edges[place];
      bool waits = false;
      for_each_masked_body(edge, [&](std::int32_t body) {
        waits = waits || claims[body].part != part || claims[body].waits != 0;
      });
      if (!waits) {
        take_lowest_color(constraints.body_colors, edge);
        continue;
      }
      for_each_masked_body(edge, [&](std::int32_t body) {
        if (claims[body].part == part) claims[body].waits = 1;
      });
      places[static_cast<std::size_t>(left++)] = place;
    }
    constraints.part_counts[part] = left;
  });
  std::int64_t left = 0;
  for (const std::int32_t count : constraints.part_counts) left += count;
  return left;
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

void color_in_rounds(Constraints& constraints, Crew& crew) {
  sort_by_order(constraints, constraints.uncolored.span());
  const auto count = static_cast<std::int64_t>(constraints.uncolored.size());
  constraints.claims.resize_discarding(constraints.body_colors.size());
  constraints.part_counts.resize_discarding((count + kPartEdges - 1) / kPartEdges);
  for (std::size_t part = 0; part < constraints.part_counts.size(); ++part) {
    const auto begin = static_cast<std::int64_t>(part) * kPartEdges;
    constraints.part_counts[part] =
        static_cast<std::int32_t>(std::min<std::int64_t>(kPartEdges, count - begin));
  }
  std::int64_t left = count;
  for (bool slow = false; left > 0 && !slow;) {
    const std::int64_t before = std::exchange(left, run_round(constraints, crew));
    slow = before - left < before / kSlowRound;
  }
  for (std::size_t part = 0; part < constraints.part_counts.size(); ++part) {
    for (std::int32_t i = 0; i < constraints.part_counts[part]; ++i) {
      const std::int32_t place = constraints.ordered[part * kPartEdges + static_cast<std::size_t>(i)];
      take_lowest_color(constraints.body_colors, constraints.edges[place]);
    }
  }
}

}  // namespace scree
