// Spheres and capsules against hulls. With lane = pair: drops pairs by bounding spheres and boxes. Pair by
// pair, with lane = face or edge: searches the remaining pairs. With lane = pair again: completes the
// contacts.
//
// The largest distance over the faces' planes never exceeds the true distance. If its point lies over that
// same face, it is the distance, and no edge must be tested.
#include <simd/collide/collide_contact.h>
#include <simd/collide/hull_segment.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// A point closer to the hull than these shares of the radius and of the hull's radius counts as inside: the
// direction from the closest point to it is noise.
constexpr float kInside = 1e-4f;
constexpr float kInsideHull = 1e-5f;
// Heights below this share of the hull's radius are rounding.
constexpr float kNoise = 1e-6f;
// A normal with this much of a face's normal leans on the face.
constexpr float kFaceCosine = 0.98f;
// How far a capsule along a face's side may lie beyond it, in meters and as a share of the radius. More than
// the jitter of shapes at rest, but small: where two sides meet at a small angle it reaches far.
constexpr float kBorder = 1e-4f;
constexpr float kBorderShare = 2e-3f;
// Depth that a contact may lose to a face or to a second point, as a share of the smaller shape's size; at
// most kFeatureTolerance.
constexpr float kDepthShare = 5e-5f;
// How much a capsule may lean before its surface is no longer a radius below its axis, as a share of the
// radius; at most kLinearSlop.
constexpr float kLeanShare = 0.1f;
// How far a capsule beside an edge may leave the plane of the normal, as a share of the radius; at most half
// of kLinearSlop.
constexpr float kBesideShare = 0.05f;

// Result of the search for one touching pair, in the hull's frame.
struct alignas(16) Found {
  float normal[3];  // out of the hull
  float separation;
  float t;             // where on the segment
  float end[2];        // ends of the stretch that lies on a face or along an edge
  float is_stretched;  // 1 or 0
  float end_separation[2];
  float padding[2];
};

struct RoundPair {
  Segment segment;
  float radius, reach;
};

void set_normal(Found& found, Point normal) {
  found.normal[0] = normal.x;
  found.normal[1] = normal.y;
  found.normal[2] = normal.z;
}

float inside_limit(const HullData& hull, float radius) {
  return kInside * radius + kInsideHull * hull.outer_radius;
}

struct SphereHull {
  using Contact = WideContact<1>;

  static V3 half_segment(const WidePair&) { return {F(0.0f), F(0.0f), F(0.0f)}; }

  static bool find(const HullData& hull, const RoundPair& pair, Found& found) {
    const float limit = pair.radius + pair.reach;
    const AboveFace above = find_face<true>(hull, pair.segment);
    if (!(above.separation <= limit)) return false;
    found = {};
    set_normal(found, above.normal);
    found.separation = above.separation - pair.radius;
    const Point center = pair.segment.center;
    if (above.separation <= kNoise * hull.outer_radius || is_over_face(hull, above.face, center)) return true;
    const NearEdge near = find_edge(hull, center);
    if (!(near.distance <= limit)) return false;
    if (near.distance > inside_limit(hull, pair.radius)) {
      set_normal(found, (1.0f / near.distance) * near.apart);
      found.separation = near.distance - pair.radius;
    }
    return true;
  }

  static void complete(const WidePair& pair, const Found* rows, const std::int32_t* which, Contact& contact) {
    V3 normal;
    load_rows(rows->normal, sizeof(Found) / sizeof(float), which, normal.x, normal.y, normal.z,
              contact.separation[0]);
    contact.normal = -rotate(pair.second.rotation, normal);
    contact.point[0] = contact.normal * (pair.extent_1.radius + F(0.5f) * contact.separation[0]);
    contact.id[0] = I(1);
    set_radius(contact, pair.extent_1.radius);
  }
};

// The capsule is the first shape.
struct CapsuleHull {
  using Contact = WideContact<2>;

  static V3 half_segment(const WidePair& pair) { return half_segment_in_second(pair); }

  // Data of a pair that several steps of the search use.
  struct State {
    const HullData& hull;
    const RoundPair& pair;
    float length_2;   // of half the segment
    float tolerance;  // depth by which an edge must beat a face, and which two points may lose against one
    float margin;     // overlap of a face's border that counts as still over it
  };

  static State make_state(const HullData& hull, const RoundPair& pair) {
    const float length_2 = dot(pair.segment.half, pair.segment.half);
    const float size = smaller_of(hull.outer_radius, root(length_2) + pair.radius);
    return {hull, pair, length_2, smaller_of(kFeatureTolerance, kDepthShare * size),
            smaller_of(kBorder, kBorderShare * pair.radius)};
  }

  static bool find(const HullData& hull, const RoundPair& pair, Found& found) {
    const Segment& segment = pair.segment;
    const State state = make_state(hull, pair);
    const float limit = pair.radius + pair.reach, noise = kNoise * hull.outer_radius;
    const AboveFace above = find_face<false>(hull, segment);
    if (!(above.separation <= limit)) return false;
    const Stretch over = clip_to_face(hull, above.face, segment.center, segment.half, 0.0f);
    found = {};
    if (above.separation > noise && over.exists() && rest_on_face(state, above, over, found)) {
      return found.separation <= pair.reach;
    }
    Crossing crossing{-1, above.normal, -kNothing, 0.0f};
    if (above.separation <= noise) crossing = find_crossing(hull, segment);
    if (above.separation > noise || crossing.separation > noise) {
      const NearEdge near = find_edge(hull, segment);
      if (!(near.distance <= limit)) return false;
      if (near.distance > inside_limit(hull, pair.radius)) {
        rest_on_edge(state, above, near, found);
        return true;
      }
    }
    leave(state, above, crossing, found);
    return true;
  }

  // The face is closest if the segment's lowest point over its plane lies over the face.
  static bool rest_on_face(const State& state, const AboveFace& above, const Stretch& over, Found& found) {
    const float radius = state.pair.radius;
    const float height[2] = {above.height + over.t[0] * above.slope, above.height + over.t[1] * above.slope};
    const int lower = height[0] <= height[1] ? 0 : 1;
    if (height[lower] > above.separation) return false;
    set_normal(found, above.normal);
    found.t = over.t[lower];
    found.separation = height[lower] - radius;
    stretch_over_face(state, above, above.normal, 1.0f, found);
    return true;
  }

  // For a segment that passes through the hull: out by a face, or by an edge that wins by the tolerance.
  static void leave(const State& state, const AboveFace& above, const Crossing& crossing, Found& found) {
    const float radius = state.pair.radius;
    if (crossing.edge >= 0 && crossing.separation > above.separation + state.tolerance) {
      set_normal(found, crossing.normal);
      found.separation = crossing.separation - radius;
      found.t = crossing.t;
      return;
    }
    set_normal(found, above.normal);
    found.separation = above.separation - radius;
    found.t = above.slope > 0.0f ? -1.0f : 1.0f;  // the end that is deepest along the normal
    stretch_over_face(state, above, above.normal, 1.0f, found);
  }

  static void rest_on_edge(const State& state, const AboveFace& above, const NearEdge& near, Found& found) {
    const HullData& hull = state.hull;
    const Segment& segment = state.pair.segment;
    const Point normal = (1.0f / near.distance) * near.apart;
    set_normal(found, normal);
    found.separation = near.distance - state.pair.radius;
    found.t = near.t;
    if (!lies_level(state, dot(normal, segment.half))) return;
    // The face whose normal is closest to the contact normal.
    std::int32_t face = above.face;
    float cosine = dot(above.normal, normal);
    for (const std::int32_t* faces : hull.round.edge_face) {
      const float other = dot(row_of(hull.normal, faces[near.aligned]), normal);
      if (!(other > cosine)) continue;
      cosine = other;
      face = faces[near.aligned];
    }
    if (cosine > kFaceCosine) {
      stretch_over_face(state, above_face(hull, segment, face), normal, cosine, found);
    } else {
      stretch_along_edge(state, near.aligned, normal, found);
    }
  }

  // The part of the segment whose image along the normal lies on the face.
  static void stretch_over_face(const State& state, const AboveFace& above, Point normal, float cosine,
                                Found& found) {
    const Segment& segment = state.pair.segment;
    const float lean = dot(normal, segment.half);
    if (!lies_level(state, lean)) return;
    const float height = above.height / cosine, slope = above.slope / cosine;
    const Stretch over = clip_to_face(state.hull, above.face, segment.center - height * normal,
                                      segment.half - slope * normal, state.margin);
    const float heights[2] = {height + over.t[0] * slope, height + over.t[1] * slope};
    use_stretch(state, over, heights, found);
  }

  // The part of the segment between the planes at an edge's ends, where all of it is beside the edge.
  static void stretch_along_edge(const State& state, std::int32_t edge, Point normal, Found& found) {
    const Segment& segment = state.pair.segment;
    const Point from = segment.center - row_of(state.hull.round.edge_point, edge);
    const Point way = row_of(state.hull.round.edge_way, edge);
    const float inverse = state.hull.round.edge_inverse[edge];
    const float share = dot(way, from) * inverse, gain = dot(way, segment.half) * inverse;
    if (!(gain * gain > 0.5f * state.length_2 * inverse)) return;  // crosses rather than follows it
    const float begin = -share / gain, end = (1.0f - share) / gain;
    const Stretch along{{clamp_to(smaller_of(begin, end), -1.0f, 1.0f),  //
                         clamp_to(larger_of(begin, end), -1.0f, 1.0f)}};
    const float limit = smaller_of(0.5f * kLinearSlop, kBesideShare * state.pair.radius);
    float distance[2];
    for (int k = 0; k < 2; ++k) {
      const float u = clamp_to(share + along.t[k] * gain, 0.0f, 1.0f);
      const Point apart = from + along.t[k] * segment.half - u * way;
      const Point aside = apart - dot(apart, normal) * normal;
      if (!(dot(aside, aside) <= limit * limit)) return;
      distance[k] = root(dot(apart, apart));
    }
    use_stretch(state, along, distance, found);
  }

  // Whether the capsule's surface lies a radius below its axis along the normal, not only at its lower end.
  static bool lies_level(const State& state, float slope) {
    const float radius = state.pair.radius;
    return slope * slope * radius <= smaller_of(kLinearSlop, kLeanShare * radius) * state.length_2;
  }

  static void use_stretch(const State& state, const Stretch& stretch, const float (&distance)[2],
                          Found& found) {
    const float radius = state.pair.radius, least = kMinimumSpread * radius;
    const float length = stretch.t[1] - stretch.t[0];
    const bool is_long = stretch.exists() && length * length * state.length_2 > least * least;
    const float deepest = smaller_of(distance[0], distance[1]) - radius;
    if (!is_long || !(deepest <= found.separation + state.tolerance)) return;
    found.is_stretched = 1.0f;
    for (int k = 0; k < 2; ++k) {
      found.end[k] = stretch.t[k];
      // A point over a face's plane but beyond its border is farther away than the plane.
      found.end_separation[k] = larger_of(distance[k] - radius, found.separation);
    }
  }

  static void complete(const WidePair& pair, const Found* rows, const std::int32_t* which, Contact& contact) {
    constexpr int kStride = sizeof(Found) / sizeof(float);
    const float* numbers = rows->normal;
    V3 normal;
    F separation, t, end[2], is_stretched, end_separation[2], padding[2];
    load_rows(numbers, kStride, which, normal.x, normal.y, normal.z, separation);
    load_rows(numbers + 4, kStride, which, t, end[0], end[1], is_stretched);
    load_rows(numbers + 8, kStride, which, end_separation[0], end_separation[1], padding[0], padding[1]);
    const F radius = pair.extent_1.radius;
    const V3 half = half_segment_in_second(pair);
    // Halfway between the surfaces, relative to the capsule's center, in world axes.
    const auto point_at = [&](F at, F gap) {
      return rotate(pair.second.rotation, at * half - normal * (radius + F(0.5f) * gap));
    };
    contact.normal = -rotate(pair.second.rotation, normal);
    contact.point[0] = point_at(t, separation);
    contact.separation[0] = separation;
    contact.id[0] = I(3);
    set_radius(contact, radius);
    set_absent(contact, 1);
    const V3 point[2] = {point_at(end[0], end_separation[0]), point_at(end[1], end_separation[1])};
    use_ends(contact, pair.reach, is_stretched > F(0.0f), point, end_separation);
  }
};

V3 center_in_hull(const WidePair& pair) { return rotate_back(pair.second.rotation, -pair.offset); }

// Whether a segment comes close to the hull's bounding sphere and to the box about its centroid.
M is_near_hull(const WidePair& pair, V3 center, V3 half) {
  const F limit = pair.extent_1.radius + pair.reach;
  const F length_2 = max(length_squared(half), F(1e-30f));
  const F t = clamp(-dot(center, half) / length_2, F(-1.0f), F(1.0f));
  const V3 gap{abs(center.x) - abs(half.x) - pair.extent_2.half.x,
               abs(center.y) - abs(half.y) - pair.extent_2.half.y,
               abs(center.z) - abs(half.z) - pair.extent_2.half.z};
  return (length_squared(center + t * half) <= square(pair.extent_2.radius + limit)) &
         (max(gap.x, max(gap.y, gap.z)) <= limit);
}

// The pairs of a call that touch.
struct Touching {
  alignas(64) std::int32_t item[kCollideChunk + kLanes];
  Found found[kCollideChunk + kLanes];
  int count = 0;
};

void set_untouched(const CollideColumns& columns, std::int32_t row) { columns.points[row] = 0; }

// Searches up to kLanes pairs, one by one.
template <class Pair>
void search_block(const CollideColumns& columns, const Block& block, const std::int32_t* which,
                  Touching& touching) {
  const WidePair pair = load_pair(columns, block);
  const V3 center = center_in_hull(pair), half = Pair::half_segment(pair);
  const F size = pair.extent_1.half.y + pair.extent_1.radius;
  const std::uint32_t near =
      bits(spheres_touch(pair, size, pair.extent_2.radius) & is_rotation(pair.first.rotation) &
           is_rotation(pair.second.rotation) & is_near_hull(pair, center, half));
  alignas(64) float number[8][kLanes];
  const F numbers[8] = {center.x,  center.y, center.z, half.x, half.y, half.z, pair.extent_1.radius,
                        pair.reach};
  for (int k = 0; k < 8; ++k) store(number[k], numbers[k]);
  for (int lane = 0; lane < block.count; ++lane) {
    bool touches = false;
    if ((near >> lane & 1u) != 0) {
      const RoundPair one{{{number[0][lane], number[1][lane], number[2][lane]},
                           {number[3][lane], number[4][lane], number[5][lane]}},
                          number[6][lane],
                          number[7][lane]};
      const HullData& hull = *columns.hulls[columns.shape_hull[block.shape_2[lane]]];
      touches = Pair::find(hull, one, touching.found[touching.count]);
    }
    if (touches) {
      touching.item[touching.count++] = which[lane];
    } else {
      set_untouched(columns, block.row[lane]);
    }
  }
}

template <class Pair>
void collide_with_hulls(const CollideColumns& columns, const CollideItem* items, int count) {
  Touching touching;
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    take_block(items, count, begin, which, block);
    search_block<Pair>(columns, block, which, touching);
  }
  for (int lane = 0; lane < kLanes && touching.count > 0; ++lane) {
    touching.item[touching.count + lane] = touching.item[touching.count - 1];
  }
  for (int begin = 0; begin < touching.count; begin += kLanes) {
    const int lanes = touching.count - begin < kLanes ? touching.count - begin : kLanes;
    Block block;
    load_block(items, touching.item + begin, lanes, block);
    const WidePair pair = load_pair(columns, block);
    alignas(64) std::int32_t which[kLanes];
    number_lanes(begin, lanes, which);
    typename Pair::Contact contact;
    Pair::complete(pair, touching.found, which, contact);
    store_contacts(columns, items, touching.item + begin, block, pair.first.position, pair.reach, contact);
  }
}

}  // namespace

void collide_sphere_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_with_hulls<SphereHull>(columns, items, count);
}
void collide_capsule_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_with_hulls<CapsuleHull>(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
