// See partition.h. All groups of ranks are cut at once, level by level. A cut is found as the ranks add up
// histograms of weight along its axis, each round of a finer one within the bin that the cut is in.
#include <parallel/distributed/messages.h>
#include <parallel/distributed/partition.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scree {

namespace {

constexpr int kBins = 32, kRounds = 5;  // 2^25 places, as many as a float has digits

// Ranks that have not been parted yet.
struct Group {
  std::int32_t begin, end;                         // ranks
  float lower[3], upper[3];                        // around its points
  float inner_lower[3] = {}, inner_upper[3] = {};  // around most of them
  std::int32_t axis = 0;                           // of the cut that is sought
  float from = 0, to = 0;                          // which is in here
  std::int64_t below = 0;                          // weight before `from`
  std::int64_t wanted = 0;                         // weight for the lower half of the ranks
};

bool is_parted(const Group& group) { return group.end - group.begin < 2; }
float reach_of(const Group& group, int axis) { return group.inner_upper[axis] - group.inner_lower[axis]; }
std::int32_t middle_of(const Group& group) { return group.begin + (group.end - group.begin) / 2; }

Group group_of_all(Transport& transport, std::span<const WeightedPoint> points) {
  struct Reach {
    float lower[3], upper[3];
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Reach own{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const WeightedPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      own.lower[axis] = std::min(own.lower[axis], point.position[axis]);
      own.upper[axis] = std::max(own.upper[axis], point.position[axis]);
    }
  }
  Group all{0, transport.ranks(), {}, {}};
  std::copy(std::begin(own.lower), std::end(own.lower), all.lower);
  std::copy(std::begin(own.upper), std::end(own.upper), all.upper);
  for (const Reach& reach : gather_rows<Reach>(transport, own)) {
    for (int axis = 0; axis < 3; ++axis) {
      all.lower[axis] = std::min(all.lower[axis], reach.lower[axis]);
      all.upper[axis] = std::max(all.upper[axis], reach.upper[axis]);
    }
  }
  return all;
}

// The place of a point in the histogram of its group: 0 before `from`, kBins + 1 from `to` on. Strays count
// where the range of most points ends.
int bin_of(const Group& group, const WeightedPoint& point) {
  const float at = std::max(group.inner_lower[group.axis],
                            std::min(point.position[group.axis], group.inner_upper[group.axis]));
  if (!(at >= group.from)) return 0;
  if (at >= group.to) return kBins + 1;
  const double from = group.from, share = (at - from) / (group.to - from);
  return 1 + std::min(kBins - 1, static_cast<int>(share * kBins));
}

// Where a bin begins. Rounded as it may be, it only moves a cut.
float begin_of(const Group& group, int bin) {
  const double from = group.from;
  return static_cast<float>(from + (group.to - from) * (static_cast<double>(bin) / kBins));
}

// In double precision, as most points may lie close together at one end of it.
struct Range {
  double lower, upper;
  double length() const { return upper - lower; }
};

// Of these, what lies within three standard deviations around the mean of the points there. `sums`: how many
// these are, and their places and squares of places, in `units` of the range.
Range trimmed(const Range& range, std::span<const std::int64_t, 3> sums, double units) {
  constexpr double kDeviations = 3.0;
  if (sums[0] == 0) return range;
  const auto count = static_cast<double>(sums[0]);
  const double mean = static_cast<double>(sums[1]) / count;
  const double variance = std::max(static_cast<double>(sums[2]) / count - mean * mean, 0.0);
  const double most = kDeviations * std::sqrt(variance) + 1.0;
  return {range.lower + range.length() * (std::max(mean - most, 0.0) / units),
          range.lower + range.length() * (std::min(mean + most, units) / units)};
}

// -> Group::inner_lower, inner_upper. A few bodies that have fallen off the world must not decide across
// which axis a pile is cut, nor how finely, so the range is trimmed to where most points are, and again as
// that is known better.
void find_inner(Transport& transport, std::span<const WeightedPoint> points,
                std::span<const std::int32_t> group_of, std::vector<Group>& groups) {
  constexpr double kUnits = 1024.0, kHardlyLess = 0.8;
  constexpr int kMostTrims = 20;
  std::vector<Range> ranges;
  for (const Group& group : groups) {
    for (int axis = 0; axis < 3; ++axis) ranges.push_back({group.lower[axis], group.upper[axis]});
  }
  bool is_trimmed = true;
  for (int trim = 0; trim < kMostTrims && is_trimmed; ++trim) {
    std::vector<std::int64_t> sums(ranges.size() * 3, 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t place = static_cast<std::size_t>(group_of[i]) * 3 + axis;
        const Range& range = ranges[place];
        const double share = (points[i].position[axis] - range.lower) / range.length();
        if (!(share >= 0.0 && share <= 1.0)) continue;
        const auto unit = static_cast<std::int64_t>(kUnits * share);
        sums[place * 3] += 1;
        sums[place * 3 + 1] += unit;
        sums[place * 3 + 2] += unit * unit;
      }
    }
    transport.add_up(sums);
    is_trimmed = false;
    for (std::size_t place = 0; place < ranges.size(); ++place) {
      const Range before = ranges[place];
      ranges[place] = trimmed(before, std::span(sums).subspan(place * 3).first<3>(), kUnits);
      is_trimmed = is_trimmed || ranges[place].length() < kHardlyLess * before.length();
    }
  }
  for (std::size_t place = 0; place < ranges.size(); ++place) {
    Group& group = groups[place / 3];
    const std::size_t axis = place % 3;
    group.inner_lower[axis] = std::max(static_cast<float>(ranges[place].lower), group.lower[axis]);
    group.inner_upper[axis] = std::min(static_cast<float>(ranges[place].upper), group.upper[axis]);
  }
}

// How far it is from point to point in their order, along each axis of each group, as a share of the group's
// reach: so often a cut at any place has the two on different sides.
std::vector<std::int64_t> add_up_ways(Transport& transport, std::span<const WeightedPoint> points,
                                      std::span<const std::int32_t> group_of,
                                      const std::vector<Group>& groups) {
  constexpr float kUnits = 1024.0f;  // of a way across the group
  std::vector<std::int64_t> ways(groups.size() * 3, 0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (group_of[i] != group_of[i - 1]) continue;
    const auto place = static_cast<std::size_t>(group_of[i]);
    for (int axis = 0; axis < 3; ++axis) {
      const float way =
          std::abs(points[i].position[axis] - points[i - 1].position[axis]) / reach_of(groups[place], axis);
      if (way > 0.0f)
        ways[place * 3 + static_cast<std::size_t>(axis)] +=
            static_cast<std::int64_t>(kUnits * std::min(way, 1.0f));
    }
  }
  transport.add_up(ways);
  return ways;
}

// Cuts across the longest axis, or one that is hardly shorter across which points of successive rows are on
// the same side more often. For a rank whose rows come in short runs reads memory as slowly as if it had all:
// 500,000 bodies of a pile, whose rows run along x, take 1.2 to 1.35 times as long on two ranks cut across x
// as cut across z.
void choose_axes(Transport& transport, std::span<const WeightedPoint> points,
                 std::span<const std::int32_t> group_of, std::vector<Group>& groups) {
  constexpr float kHardlyShorter = 0.7f;
  find_inner(transport, points, group_of, groups);
  const std::vector<std::int64_t> ways = add_up_ways(transport, points, group_of, groups);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Group& group = groups[i];
    const auto reach = [&](int axis) { return reach_of(group, axis); };
    const auto way = [&](int axis) { return ways[i * 3 + static_cast<std::size_t>(axis)]; };
    int longest = 0;
    for (const int axis : {1, 2}) {
      if (reach(axis) > reach(longest)) longest = axis;
    }
    group.axis = longest;
    for (const int axis : {0, 1, 2}) {
      if (reach(axis) >= kHardlyShorter * reach(longest) && way(axis) < way(group.axis)) group.axis = axis;
    }
    group.from = group.inner_lower[group.axis];
    group.to = std::nextafter(group.inner_upper[group.axis], std::numeric_limits<float>::max());
    group.below = 0;
  }
}

// Narrows the place of each group's cut to one bin. `group_of`: of each point.
void narrow(Transport& transport, std::span<const WeightedPoint> points,
            std::span<const std::int32_t> group_of, std::vector<Group>& groups, bool first) {
  std::vector<std::int64_t> weights(groups.size() * kBins, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto group = static_cast<std::size_t>(group_of[i]);
    const int bin = bin_of(groups[group], points[i]);
    if (bin >= 1 && bin <= kBins)
      weights[group * kBins + static_cast<std::size_t>(bin - 1)] += points[i].weight;
  }
  transport.add_up(weights);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    Group& group = groups[i];
    const std::span<const std::int64_t> bins = std::span(weights).subspan(i * kBins, kBins);
    if (first) {
      std::int64_t all = 0;
      for (const std::int64_t weight : bins) all += weight;
      group.wanted = all * (middle_of(group) - group.begin) / std::max(group.end - group.begin, 1);
    }
    int bin = 0;
    while (bin < kBins - 1 && group.below + bins[static_cast<std::size_t>(bin)] <= group.wanted)
      group.below += bins[static_cast<std::size_t>(bin++)];
    const float from = begin_of(group, bin), to = begin_of(group, bin + 1);
    group.from = from;
    group.to = to;
  }
}

// Each group that has a cut becomes two.
void part(std::vector<Group>& groups, Partition& partition, std::span<const WeightedPoint> points,
          std::span<std::int32_t> group_of) {
  std::vector<Group> parts;
  std::vector<std::int32_t> lower_part(groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Group& group = groups[i];
    lower_part[i] = static_cast<std::int32_t>(parts.size());
    if (is_parted(group)) {
      parts.push_back(group);
      continue;
    }
    const std::int32_t middle = middle_of(group);
    partition.cuts[static_cast<std::size_t>(middle)] = {group.axis, group.from};
    Group lower = group, upper = group;
    lower.end = upper.begin = middle;
    lower.upper[group.axis] = upper.lower[group.axis] = group.from;
    parts.push_back(lower);
    parts.push_back(upper);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Group& group = groups[static_cast<std::size_t>(group_of[i])];
    const bool is_upper = !is_parted(group) && !(points[i].position[group.axis] < group.from);
    group_of[i] = lower_part[static_cast<std::size_t>(group_of[i])] + (is_upper ? 1 : 0);
  }
  groups = std::move(parts);
}

}  // namespace

PartitionBox box_of(const Partition& partition, std::int32_t rank) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  PartitionBox box{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
  std::int32_t begin = 0, end = static_cast<std::int32_t>(partition.cuts.size());
  while (end - begin > 1) {
    const std::int32_t middle = begin + (end - begin) / 2;
    const Cut& cut = partition.cuts[static_cast<std::size_t>(middle)];
    (rank < middle ? box.upper : box.lower)[cut.axis] = cut.at;
    (rank < middle ? end : begin) = middle;
  }
  return box;
}

Partition cut_space(Transport& transport, std::span<const WeightedPoint> points) {
  Partition partition;
  partition.cuts.resize(static_cast<std::size_t>(transport.ranks()));
  std::vector<Group> groups{group_of_all(transport, points)};
  std::vector<std::int32_t> group_of(points.size(), 0);
  while (!std::all_of(groups.begin(), groups.end(), is_parted)) {
    choose_axes(transport, points, group_of, groups);
    for (int round = 0; round < kRounds; ++round) narrow(transport, points, group_of, groups, round == 0);
    part(groups, partition, points, group_of);
  }
  return partition;
}

}  // namespace scree
