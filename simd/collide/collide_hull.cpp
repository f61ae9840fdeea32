// Hulls against hulls and boxes: the stages of one chunk of pairs.
//
// First, with lane = pair: tests bounding spheres, and moves each remaining pair into the first hull's frame.
// Then pair by pair, wide within the pair: the axis that separated it last time, the axis between the
// centers, faces, edges, contact points. Last, with lane = pair again: manifolds of the touching pairs.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// An axis of lower rank must win by this share of the smaller hull's radius: depths are exact within it.
constexpr float kAxisShare = 5e-5f;
// Bounds and gaps are computed in different orders of operations, and corners lie off their faces by a few
// roundings: a share of all lengths involved.
constexpr float kRoundingShare = 4e-6f;

// Pairs whose spheres touch: their items and their geometry.
struct Survivors {
  int count = 0;
  std::int32_t which[kCollideChunk];
  HullPair pair[kCollideChunk + 1];  // the last one is for unused lanes
};

// Touching pairs, consecutively, in columns.
struct Touching {
  int count = 0;
  alignas(64) std::int32_t which[kCollideChunk + kLanes];
  alignas(64) float normal[3][kCollideChunk + kLanes];
  alignas(64) float point[4][3][kCollideChunk + kLanes];
  alignas(64) float separation[4][kCollideChunk + kLanes];
  alignas(64) std::int32_t id[4][kCollideChunk + kLanes];

  void put(int item, Vec axis, const HullContact& contact) {
    const int to = count++;
    which[to] = item;
    normal[0][to] = axis.x;
    normal[1][to] = axis.y;
    normal[2][to] = axis.z;
    for (int k = 0; k < 4; ++k) {
      point[k][0][to] = contact.point[k].x;
      point[k][1][to] = contact.point[k].y;
      point[k][2][to] = contact.point[k].z;
      separation[k][to] = contact.separation[k];
      id[k][to] = static_cast<std::int32_t>(contact.id[k]);
    }
  }

  // Fills the last block up with copies of its last lane.
  void fill_block() {
    for (int to = count; to % kLanes != 0; ++to) {
      which[to] = which[count - 1];
      for (auto& axis : normal) axis[to] = axis[count - 1];
      for (int k = 0; k < 4; ++k) {
        for (auto& axis : point[k]) axis[to] = axis[count - 1];
        separation[k][to] = separation[k][count - 1];
        id[k][to] = id[k][count - 1];
      }
    }
  }
};

const HullData* hull_of(const CollideColumns& columns, std::int32_t shape) {
  return columns.hulls[columns.shape_hull[shape]];
}

// A box as the first hull. Lanes hold half extents; the pair holds a hull made when its turn comes.
template <bool kBoxFirst>
F radius_1(const WidePair& pair) {
  if constexpr (kBoxFirst) return length(pair.extent_1.half);
  return pair.extent_1.radius;
}

void remember(const CollideColumns& columns, std::int32_t pair, Vec axis, std::uint32_t feature) {
  columns.axis[pair] = {{axis.x, axis.y, axis.z}, feature};
}

void clear_row(const CollideColumns& columns, std::int32_t row, std::int32_t pair, Vec axis) {
  columns.points[row] = 0;
  remember(columns, pair, axis, 0);
}
// A pair whose spheres do not meet keeps the axis that separated it.
void clear_far_row(const CollideColumns& columns, std::int32_t row, std::int32_t pair) {
  columns.points[row] = 0;
  if (columns.axis[pair].feature != 0) remember(columns, pair, {0.0f, 0.0f, 0.0f}, 0);
}

// `lever`: 0 where the balls about both shapes are apart, which turns do not change.
void keep_clear(const CollideColumns& columns, std::int32_t pair, float gap, float lever) {
  if (columns.clearance != nullptr) columns.clearance[pair] = {gap, lever};
}

template <bool kBoxFirst>
void pass_spheres(const CollideColumns& columns, const CollideItem* items, int count, Survivors& out) {
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    const WidePair pair = load_pair(columns, block);
    const F radii = radius_1<kBoxFirst>(pair) + pair.extent_2.radius;
    const std::uint32_t near = bits(spheres_touch(pair, radius_1<kBoxFirst>(pair), pair.extent_2.radius) &
                                    is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation));
    const F distance = length(pair.offset);
    alignas(64) float gap[kLanes];
    store(gap, distance - radii - F(2.0f * kRoundingShare) * (distance + radii));
    alignas(64) std::int32_t slot[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) slot[lane] = kCollideChunk;
    for (int lane = 0; lane < lanes; ++lane) {
      const std::int32_t row = block.row[lane];
      if ((near >> lane & 1u) == 0) {
        clear_far_row(columns, row, items[which[lane]].pair);
        keep_clear(columns, items[which[lane]].pair, gap[lane], 0.0f);
        continue;
      }
      slot[lane] = out.count;
      HullPair& hulls = out.pair[out.count];
      out.which[out.count++] = which[lane];
      hulls.hull[0] = kBoxFirst ? nullptr : hull_of(columns, block.shape_1[lane]);
      hulls.hull[1] = hull_of(columns, block.shape_2[lane]);
    }
    if (near != 0) store_frames(pair, out.pair, slot);
  }
}

// Returns the gap along the last axis or the one between the centers, if it separates a pair that did not
// touch, or else 0.
float separation_of(const HullPair& pair, const ContactAxis& last, Vec& axis) {
  axis = vec(last.axis);
  const float length_2 = dot(axis, axis);
  if (length_2 > 0.99f && length_2 < 1.01f) {
    const float gap = gap_along(pair, axis);
    if (gap > pair.reach) return gap;
  }
  const Vec center = pair.frame[0].center();
  const float distance = square_root(dot(center, center));
  const float inner = pair.hull[0]->inner_radius + pair.hull[1]->inner_radius;
  if (!(distance > inner + pair.reach)) return 0.0f;
  axis = (1.0f / distance) * center;
  const float gap = gap_along(pair, axis);
  return gap > pair.reach ? gap : 0.0f;
}

// The axis turns with the first hull, and so moves against the points of the second one, however far they
// come while the gap lasts. One that came from a snapshot may be of another length than 1. Twice the
// rounding: of this gap, and of the one that a later look would find.
void keep_clear_along(const CollideColumns& columns, std::int32_t place, const HullPair& pair, Vec axis,
                      float gap) {
  constexpr float kUnit = 1e-5f;
  if (!(size(dot(axis, axis) - 1.0f) < kUnit)) return;
  const Vec center = pair.frame[0].center();
  const float farthest = square_root(dot(center, center)) + pair.hull[1]->outer_radius;
  keep_clear(columns, place, gap - 2.0f * pair.rounding - kUnit * gap, farthest + gap);
}

// Returns false if the pair is separated along the decision's axis.
bool find_axis(const HullPair& pair, const ContactAxis& last, Decision& decision) {
  if ((last.feature & kFeatureKind) == kFeatureEdges) {
    const Remembered edges = query_remembered_edges(pair, last.feature, decision);
    if (edges != Remembered::fails) return edges == Remembered::decides;
  }
  return query_faces(pair, last.feature, decision) && query_edges(pair, decision);
}

// Pairs whose spheres touch, by state: contacts that wait for their points, and contacts that have them.
struct Results {
  const CollideColumns& columns;
  const CollideItem* items;
  Touching& touching;
  FaceQueue queue;
  struct Waiting {
    const HullPair* pair;
    int item;
    int side;
    Vec axis;
    std::uint32_t feature;
  } waiting[kLanes];

  void finish(int item, Vec axis, std::uint32_t feature, const HullContact& contact) {
    const std::int32_t row = items[item].row, pair = items[item].pair;
    if (contact.id[0] != 0) {
      remember(columns, pair, axis, feature);
      touching.put(item, axis, contact);
    } else {
      clear_row(columns, row, pair, axis);
    }
  }

  void touch(const HullPair& pair, int item, const Decision& decision) {
    if (!decision.has_edges()) {
      touch_faces(pair, item, decision, pair_faces(pair, decision));
      return;
    }
    const EdgeCrossing crossing = cross_deciding_edges(pair, decision);
    FacePair faces;
    if (pass_beside(pair, decision, crossing)) {
      clear_row(columns, items[item].row, items[item].pair, decision.axis);
    } else if (pair_edge_faces(pair, decision, crossing, faces)) {
      touch_faces(pair, item, decision, faces);
    } else {
      HullContact contact;
      touch_crossing(decision, crossing, contact);
      finish(item, decision.axis, decision.feature, contact);
    }
  }

  void touch_faces(const HullPair& pair, int item, const Decision& decision, const FacePair& faces) {
    const int corners = corner_count(*pair.hull[faces.side], faces.face);
    const int others = corner_count(*pair.hull[1 - faces.side], faces.incident);
    if (corners > kSmallFace || others > kSmallFace) {
      HullContact contact;
      clip_faces(pair, decision, faces, contact);
      finish(item, decision.axis, decision.feature, contact);
      return;
    }
    waiting[queue.count] = {&pair, item, faces.side, decision.axis, decision.feature};
    queue.put(pair, decision, faces);
    if (queue.count == kLanes) flush();
  }

  void flush() {
    const int count = queue.count;
    if (count == 0) return;
    HullContact contacts[kLanes];
    clip_queue(queue, contacts);
    for (int lane = 0; lane < count; ++lane) {
      const Waiting& w = waiting[lane];
      if (w.side == 1) {
        for (Vec& point : contacts[lane].point) point = w.pair->frame[0].place(point);
      }
      finish(w.item, w.axis, w.feature, contacts[lane]);
    }
  }
};

template <bool kBoxFirst>
void pass_pairs(const CollideColumns& columns, const CollideItem* items, Survivors& survivors,
                Touching& out) {
  BoxHull box;
  Results results{columns, items, out, {}, {}};
  for (int k = 0; k < survivors.count; ++k) {
    const CollideItem& item = items[survivors.which[k]];
    HullPair& pair = survivors.pair[k];
    if constexpr (kBoxFirst) {
      box.set_faces(columns.shape_extent[item.shape_1].half);
      pair.hull[0] = &box.hull;
    }
    set_tolerances(pair);
    const ContactAxis last = columns.axis[item.pair];
    Decision decision;
    if (last.feature == 0) {
      const float gap = separation_of(pair, last, decision.axis);
      if (gap > 0.0f) {
        clear_row(columns, item.row, item.pair, decision.axis);
        keep_clear_along(columns, item.pair, pair, decision.axis, gap);
        continue;
      }
    }
    if constexpr (kBoxFirst) box.set_edges();
    if (find_axis(pair, last, decision)) {
      results.touch(pair, survivors.which[k], decision);
    } else {
      clear_row(columns, item.row, item.pair, decision.axis);
    }
  }
  results.flush();
}

// Points of faces may lie beyond the reach, so that they show the overlap of the faces.
void look_ahead(F thinnest, WideContact<4>& contact) {
  const V3 tangent_1 = tangent_of(contact.normal), tangent_2 = cross(contact.normal, tangent_1);
  F u[4], v[4];
  for (int k = 0; k < 4; ++k) {
    const V3 point = select(contact.id[k] > I(0), contact.point[k], contact.point[0]);
    u[k] = dot(point, tangent_1);
    v[k] = dot(point, tangent_2);
  }
  constexpr auto kKind = static_cast<std::int32_t>(kFeatureKind);
  constexpr auto kEdges = static_cast<std::int32_t>(kFeatureEdges);
  contact.at_edges = ((contact.id[0] & I(kKind)) == I(kEdges)) & !(contact.id[1] > I(0));
  contact.in_strip = (width_of(u, v) < min(F(kStrip), thinnest)) & !contact.at_edges;
}

void pass_store(const CollideColumns& columns, const CollideItem* items, Touching& touching) {
  if (touching.count == 0) return;
  touching.fill_block();
  for (int begin = 0; begin < touching.count; begin += kLanes) {
    const int lanes = touching.count - begin < kLanes ? touching.count - begin : kLanes;
    Block block;
    load_block(items, touching.which + begin, lanes, block);
    const WidePair pair = load_pair(columns, block);
    const auto turn = [&](const float(&v)[3][kCollideChunk + kLanes]) {
      return rotate(pair.first.rotation, {load(v[0] + begin), load(v[1] + begin), load(v[2] + begin)});
    };
    WideContact<4> contact;
    contact.normal = turn(touching.normal);
    for (int k = 0; k < 4; ++k) {
      contact.point[k] = turn(touching.point[k]);
      contact.separation[k] = load(touching.separation[k] + begin);
      contact.id[k] = load(touching.id[k] + begin);
    }
    contact.in_strip = contact.at_edges = never();
    if (any(pair.reach > F(kSpeculativeDistance))) {
      const V3 half = pair.extent_1.half;  // of a box; the second one is a hull
      const F of_box = min(min(half.x, half.y), half.z);
      const F thinness_1 = thinness(columns, block.shape_1, of_box);
      look_ahead(min(thinness_1, thinness(columns, block.shape_2, of_box)), contact);
    }
    store_contacts(columns, items, touching.which + begin, block, pair.first.position, pair.reach, contact);
    for (int lane = 0; lane < lanes; ++lane) {  // contacts that will only graze have been dropped
      if (columns.points[block.row[lane]] == 0)
        columns.axis[items[touching.which[begin + lane]].pair].feature = 0;
    }
  }
}

template <bool kBoxFirst>
void collide_hulls(const CollideColumns& columns, const CollideItem* items, int count) {
  Survivors survivors;
  pass_spheres<kBoxFirst>(columns, items, count, survivors);
  Touching touching;
  pass_pairs<kBoxFirst>(columns, items, survivors, touching);
  pass_store(columns, items, touching);
}

}  // namespace

void store_frames(const WidePair& wide_pair, HullPair* pairs, const std::int32_t* slot) {
  const M3 r = to_matrix(conjugate(wide_pair.first.rotation) * wide_pair.second.rotation);
  const V3 c = rotate_back(wide_pair.first.rotation, wide_pair.offset);
  float* rows = reinterpret_cast<float*>(pairs);
  constexpr std::ptrdiff_t kStride = sizeof(HullPair) / sizeof(float);
  const auto write = [&](int group, F x, F y, F z, F w) {
    store_rows(rows + 4 * group, kStride, slot, kLanes, x, y, z, w);
  };
  write(0, r.x.x, r.y.x, r.z.x, c.x);
  write(1, r.x.y, r.y.y, r.z.y, c.y);
  write(2, r.x.z, r.y.z, r.z.z, c.z);
  write(3, r.x.x, r.x.y, r.x.z, -dot(r.x, c));
  write(4, r.y.x, r.y.y, r.y.z, -dot(r.y, c));
  write(5, r.z.x, r.z.y, r.z.z, -dot(r.z, c));
  const F zero(0.0f);
  write(6, wide_pair.reach, zero, zero, zero);
}

void set_tolerances(HullPair& pair) {
  const HullData &first = *pair.hull[0], &second = *pair.hull[1];
  const float outer = smaller(first.outer_radius, second.outer_radius);
  const float inner = smaller(first.inner_radius, second.inner_radius);
  pair.tolerance = smaller(kFeatureTolerance, kAxisShare * outer);
  pair.border = smaller(kFeatureTolerance, kFeatureShare * inner);
  const Vec c = pair.frame[0].center();
  pair.rounding =
      kRoundingShare * (first.outer_radius + second.outer_radius + size(c.x) + size(c.y) + size(c.z));
}

void collide_hull_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_hulls<false>(columns, items, count);
}
void collide_box_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_hulls<true>(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
