// One hull against one segment or point, wide within the pair: a lane is a face, an edge or a side of a face.
//
// Included by collide_round_hull.cpp only. Everything is in the hull's frame, relative to its centroid. Each
// lane keeps its best feature and the feature's number; the search then takes the best of all lanes, and the
// lowest number among equals. So the result does not depend on the number of lanes.
#pragma once

#include <core/plain/hull.h>
#include <simd/wide/wide_math.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// A vector of one pair.
struct Point {
  float x, y, z;
};
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator*(float s, Point a) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float smaller_of(float a, float b) { return a < b ? a : b; }
inline float larger_of(float a, float b) { return a > b ? a : b; }
inline float clamp_to(float a, float low, float high) { return smaller_of(larger_of(a, low), high); }
inline float absolute(float a) { return a < 0.0f ? -a : a; }
inline float root(float a) { return __builtin_sqrtf(a); }

inline V3 broadcast(Point a) { return {F(a.x), F(a.y), F(a.z)}; }
inline V3 load_column(const float* const column[3], std::int32_t at) {
  return {load(column[0] + at), load(column[1] + at), load(column[2] + at)};
}
inline Point row_of(const float* const column[3], std::int32_t at) {
  return {column[0][at], column[1][at], column[2][at]};
}

// The points center + t half with t in [-1, 1].
struct Segment {
  Point center, half;
};
inline Point point_on(const Segment& segment, float t) { return segment.center + t * segment.half; }

inline constexpr float kNothing = 1e30f;

// The best value that each lane has seen, with its number.
struct Search {
  F best, number;
  F current = to_float(lane_numbers());

  explicit Search(float worst) : best(worst), number(-1.0f) {}
  M offer_larger(F value, M valid) { return take(value, valid & (value > best)); }
  // Blocks may come in any order here: the smaller number wins among equals.
  M offer_smaller(F value) { return take(value, (value < best) | ((value == best) & (current < number))); }
  void move_to(std::int32_t begin) { current = to_float(lane_numbers() + I(begin)); }
  void advance() { current += F(float(kLanes)); }
  // Number of the first of the best; -1 if there is none.
  std::int32_t first_largest() const { return first(F(reduce_max(best))); }
  std::int32_t first_smallest() const { return first(F(reduce_min(best))); }

 private:
  M take(F value, M wins) {
    best = select(wins, value, best);
    number = select(wins, current, number);
    return wins;
  }
  std::int32_t first(F top) const {
    return static_cast<std::int32_t>(reduce_min(select(best == top, number, F(kNothing))));
  }
};
inline float lane_of(F a, std::int32_t number) {
  alignas(64) float lanes[kLanes];
  store(lanes, a);
  return lanes[number % kLanes];
}

// The face whose plane a segment is farthest above.
struct AboveFace {
  std::int32_t face;
  Point normal;
  float height;      // of the segment's center over the plane
  float slope;       // height gained from the center to t = 1
  float separation;  // height of the lower end
};
inline AboveFace above_face(const HullData& hull, const Segment& segment, std::int32_t face) {
  AboveFace above;
  above.face = face;
  above.normal = row_of(hull.normal, face);
  above.height = dot(above.normal, segment.center) - hull.offset[face];
  above.slope = dot(above.normal, segment.half);
  above.separation = above.height - absolute(above.slope);
  return above;
}
template <bool kIsPoint>
AboveFace find_face(const HullData& hull, const Segment& segment) {
  const V3 center = broadcast(segment.center), half = broadcast(segment.half);
  const M all = center.x == center.x;
  Search search(-kNothing);
  for (std::int32_t at = 0; at < hull.face_count; at += kLanes) {
    const V3 normal = load_column(hull.normal, at);
    F separation = dot(normal, center) - load(hull.offset + at);
    if constexpr (!kIsPoint) separation -= abs(dot(normal, half));
    search.offer_larger(separation, all);
    search.advance();
  }
  const std::int32_t found = search.first_largest();
  return above_face(hull, segment, found < 0 ? 0 : found);
}

// Squared sine of the angle below which a segment follows a side rather than crosses it.
inline constexpr float kAlongSide = 0.01f;

// The part of a segment whose image on a face lies within the face's sides. A segment that follows a side may
// lie beyond it by `margin`.
struct Stretch {
  float t[2];
  bool exists() const { return t[0] <= t[1]; }
};
inline Stretch clip_to_face(const HullData& hull, std::int32_t face, Point center, Point half, float margin) {
  const V3 wide_center = broadcast(center), wide_half = broadcast(half);
  const std::int32_t begin = hull.round.side_begin[face], count = hull.round.side_begin[face + 1] - begin;
  F low(-1.0f), high(1.0f), number = to_float(lane_numbers());
  for (std::int32_t k = 0; k < count; k += kLanes) {
    const float* const* column = hull.round.side_normal;
    const V3 side{load_unaligned(column[0] + begin + k), load_unaligned(column[1] + begin + k),
                  load_unaligned(column[2] + begin + k)};
    const F run = dot(side, wide_half);
    const F border = select(run * run <= F(kAlongSide) * length_squared(wide_half), F(margin), F(0.0f));
    const F room = load_unaligned(hull.round.side_offset + begin + k) + border - dot(side, wide_center);
    const F step = copy_sign(max(abs(run), F(1e-18f)), run), t = room / step;
    const M valid = number < F(float(count));
    const M leaves = step > F(0.0f);
    high = select(valid & leaves, min(high, t), high);
    low = select(valid & !leaves, max(low, t), low);
    number += F(float(kLanes));
  }
  // The sum turns -0 into 0.
  return {{reduce_max(low) + 0.0f, reduce_min(high) + 0.0f}};
}
inline bool is_over_face(const HullData& hull, std::int32_t face, Point point) {
  const V3 wide = broadcast(point);
  const std::int32_t begin = hull.round.side_begin[face], count = hull.round.side_begin[face + 1] - begin;
  F number = to_float(lane_numbers());
  for (std::int32_t k = 0; k < count; k += kLanes) {
    const float* const* column = hull.round.side_normal;
    const V3 side{load_unaligned(column[0] + begin + k), load_unaligned(column[1] + begin + k),
                  load_unaligned(column[2] + begin + k)};
    const M beyond = dot(side, wide) > load_unaligned(hull.round.side_offset + begin + k);
    if (bits(beyond & (number < F(float(count)))) != 0) return false;
    number += F(float(kLanes));
  }
  return true;
}

// The edge that is closest to a point or segment, and the closest points.
struct NearEdge {
  std::int32_t edge;
  std::int32_t aligned;  // among equally close edges, the one most parallel to the segment
  float t;               // on the segment
  Point apart;           // from the edge to the segment
  float distance;
};

// Bounds on distances leave out this share of the shapes' sizes for rounding.
inline constexpr float kBoundSlack = 1e-5f;
inline constexpr int kMostBlocks = 48;
static_assert(kMostBlocks * kHullPadding >= kMaxHullEdges && kMostBlocks % kHullPadding == 0);

// Calls visit(number of its first edge) for each block of edges that may hold the closest edge. `visit`
// returns the squared distance of the best edge so far. The block whose ball is closest comes first, then the
// blocks whose balls are no farther away than the best edge.
template <class Visit>
void visit_edges(const HullData& hull, const Segment& segment, Visit&& visit) {
  const std::int32_t blocks = hull.round.edge_blocks;
  std::int32_t nearest = 0;
  alignas(64) float bound[kMostBlocks];
  if (blocks > 1) {
    const V3 center = broadcast(segment.center), half = broadcast(segment.half);
    const float squared = dot(segment.half, segment.half);
    const F inverse(1.0f / larger_of(squared, 1e-30f)),
        slack(kBoundSlack * (hull.outer_radius + root(squared)));
    Search search(kNothing);
    for (std::int32_t at = 0; at < blocks; at += kLanes) {
      const V3 from = center - load_column(hull.round.block_center, at);
      const F t = clamp(-dot(from, half) * inverse, F(-1.0f), F(1.0f));
      const F gap = length(from + t * half) - load(hull.round.block_radius + at);
      const F room = max(gap - slack, F(0.0f));
      store(bound + at, room * room);
      search.offer_smaller(room * room);
      search.advance();
    }
    nearest = search.first_smallest();
    nearest = nearest < 0 ? 0 : nearest;
  }
  float best = visit(nearest * kHullPadding);
  for (std::int32_t block = 0; block < blocks; ++block) {
    if (block != nearest && bound[block] <= best) best = visit(block * kHullPadding);
  }
}

inline NearEdge find_edge(const HullData& hull, Point point) {
  const V3 x = broadcast(point);
  Search search(kNothing);
  F share(0.0f);
  visit_edges(hull, {point, {0.0f, 0.0f, 0.0f}}, [&](std::int32_t begin) {
    search.move_to(begin);
    for (std::int32_t at = begin; at < begin + kHullPadding; at += kLanes) {
      const V3 from = x - load_column(hull.round.edge_point, at), way = load_column(hull.round.edge_way, at);
      const F u = clamp(dot(way, from) * load(hull.round.edge_inverse + at), F(0.0f), F(1.0f));
      share = select(search.offer_smaller(length_squared(from - u * way)), u, share);
      search.advance();
    }
    return reduce_min(search.best);
  });
  const std::int32_t found = search.first_smallest(), edge = found < 0 ? 0 : found;
  const Point apart =
      point - row_of(hull.round.edge_point, edge) - lane_of(share, edge) * row_of(hull.round.edge_way, edge);
  return {edge, edge, 0.0f, apart, root(dot(apart, apart))};
}

// Squared sine of the angle below which a segment and an edge count as parallel.
inline constexpr float kParallelLines = 1e-10f;

// Penalty, as a share of its squared distance, of an edge perpendicular to the segment against a parallel
// edge: where several edges meet in the closest corner, the capsule may lie along one of them.
inline constexpr float kAlignment = 1e-5f;

// The closest points of the lines, clamped one after the other (Ericson, "Real-Time Collision Detection",
// 5.1.9). Uses cross products where the usual determinant cancels.
inline NearEdge find_edge(const HullData& hull, const Segment& segment) {
  const V3 center = broadcast(segment.center), half = broadcast(segment.half);
  const float squared = larger_of(dot(segment.half, segment.half), 1e-30f);
  const F half_squared(squared), half_inverse(1.0f / squared), zero(0.0f), one(1.0f);
  Search search(kNothing), aligned(kNothing);
  F share(0.0f), place(0.0f);
  const auto offer = [&](std::int32_t at) {
    const V3 from = center - load_column(hull.round.edge_point, at);
    const V3 way = load_column(hull.round.edge_way, at);
    const F inverse = load(hull.round.edge_inverse + at);
    const F along = dot(half, way), way_from = dot(way, from), half_from = dot(half, from);
    const V3 across = cross(half, way);
    const F across_squared = length_squared(across);
    const M crossing = across_squared * inverse > F(kParallelLines) * half_squared;
    const F on_line = dot(cross(way, from), across) / select(crossing, across_squared, one);
    const F t_line = select(crossing, clamp(on_line, -one, one), zero);
    const F u = clamp((way_from + t_line * along) * inverse, zero, one);
    const F t = clamp((u * along - half_from) * half_inverse, -one, one);
    const F distance = length_squared(from + t * half - u * way);
    const F crossing_share = F(kAlignment) * (across_squared * inverse * half_inverse);
    aligned.offer_smaller(distance + distance * crossing_share);
    const M wins = search.offer_smaller(distance);
    share = select(wins, u, share);
    place = select(wins, t, place);
  };
  visit_edges(hull, segment, [&](std::int32_t begin) {
    search.move_to(begin);
    aligned.move_to(begin);
    for (std::int32_t at = begin; at < begin + kHullPadding; at += kLanes) {
      offer(at);
      search.advance();
      aligned.advance();
    }
    return reduce_min(search.best);
  });
  const std::int32_t found = search.first_smallest(), edge = found < 0 ? 0 : found;
  const std::int32_t along = aligned.first_smallest();
  const float t = lane_of(place, edge);
  const Point apart = point_on(segment, t) - row_of(hull.round.edge_point, edge) -
                      lane_of(share, edge) * row_of(hull.round.edge_way, edge);
  return {edge, along < 0 ? 0 : along, t, apart, root(dot(apart, apart))};
}

// The edge that a segment is farthest outside of, along the common perpendicular of the two, and the
// parameter at which the segment's line passes it. Only edges of the hull's silhouette, seen along the
// segment, have a supporting plane parallel to the segment: their faces look to different sides.
struct Crossing {
  std::int32_t edge;  // -1: none
  Point normal;
  float separation;
  float t;
};
inline Crossing find_crossing(const HullData& hull, const Segment& segment) {
  const V3 center = broadcast(segment.center), half = broadcast(segment.half);
  const F half_squared(dot(segment.half, segment.half)), zero(0.0f), one(1.0f);
  Search search(-kNothing);
  V3 normal{zero, zero, zero};
  F place(0.0f);
  for (std::int32_t at = 0; at < hull.edge_count; at += kLanes) {
    const V3 normal_0 = load_column(hull.round.edge_normal_0, at);
    const V3 normal_1 = load_column(hull.round.edge_normal_1, at);
    const M up_0 = dot(normal_0, half) > zero, up_1 = dot(normal_1, half) > zero;
    const M silhouette = (up_0 & !up_1) | (up_1 & !up_0);
    if (bits(silhouette) != 0) {
      const V3 from = center - load_column(hull.round.edge_point, at);
      const V3 way = load_column(hull.round.edge_way, at);
      const V3 across = cross(half, way);
      const F across_squared = length_squared(across);
      const M crossing = across_squared > F(kParallelLines) * half_squared * length_squared(way);
      const F safe = select(crossing, across_squared, one);
      const F outward = copy_sign(one, dot(across, normal_0 + normal_1));
      const V3 unit = across * (outward / sqrt(safe));
      const M wins = search.offer_larger(dot(unit, from), silhouette & crossing);
      normal = select(wins, unit, normal);
      place = select(wins, dot(cross(way, from), across) / safe, place);
    }
    search.advance();
  }
  const std::int32_t found = search.first_largest();
  if (found < 0) return {-1, {0.0f, 0.0f, 0.0f}, -kNothing, 0.0f};
  const Point unit{lane_of(normal.x, found), lane_of(normal.y, found), lane_of(normal.z, found)};
  const float separation = dot(unit, segment.center - row_of(hull.round.edge_point, found));
  return {found, unit, separation, clamp_to(lane_of(place, found), -1.0f, 1.0f)};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
