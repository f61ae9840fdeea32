// Spheres, capsules, boxes and hulls against half-spaces. The half-space is the second shape: all that lies
// below the plane y = 0 of its frame. Lane = pair; the corners of a hull are chosen pair by pair.
//
// Any depth is pushed out by the shortest way, so nothing comes out on the other side. A box has the four
// corners of the face that faces the plane most, and a hull up to four of such a face, near or not: a plane
// has no border that far points could reach across.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The plane as seen from the first shape's origin.
struct WidePlane {
  V3 up;     // unit, out of the half-space
  F height;  // of the origin above the plane
};
WidePlane plane_of(const WidePair& pair) {
  const V3 up = to_matrix(pair.second.rotation).y;
  return {up, -dot(up, pair.offset)};
}

M is_near(const WidePair& pair, F lowest) {
  return (lowest <= pair.reach) & is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation);
}

// A point in the middle between the plane and a surface that is lowest at `place`.
template <int kPoints>
void set_point(WideContact<kPoints>& contact, int k, const WidePlane& plane, V3 place, I id) {
  contact.separation[k] = plane.height + dot(plane.up, place);
  contact.point[k] = place - plane.up * (F(0.5f) * contact.separation[k]);
  contact.id[k] = id;
}

struct SphereHalfSpace {
  using Contact = WideContact<1>;

  static M may_touch(const WidePair& pair, I&) {
    return is_near(pair, plane_of(pair).height - pair.extent_1.radius);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const WidePlane plane = plane_of(pair);
    contact.normal = -plane.up;
    set_point(contact, 0, plane, -plane.up * pair.extent_1.radius, I(1));
    set_radius(contact, pair.extent_1.radius);
  }
};

struct CapsuleHalfSpace {
  using Contact = WideContact<2>;

  // Half of the segment, in world axes.
  static V3 half_of(const WidePair& pair) { return to_matrix(pair.first.rotation).y * pair.extent_1.half.y; }

  static M may_touch(const WidePair& pair, I&) {
    const WidePlane plane = plane_of(pair);
    return is_near(pair, plane.height - abs(dot(plane.up, half_of(pair))) - pair.extent_1.radius);
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const WidePlane plane = plane_of(pair);
    const V3 half = half_of(pair), lowest = -plane.up * pair.extent_1.radius;
    contact.normal = -plane.up;
    set_radius(contact, pair.extent_1.radius);
    Contact ends;
    set_point(ends, 0, plane, lowest - half, I(1));
    set_point(ends, 1, plane, lowest + half, I(2));
    contact.point[0] = ends.point[0];
    contact.separation[0] = ends.separation[0];
    contact.id[0] = I(1);
    set_absent(contact, 1);
    use_ends(contact, pair.reach, !never(), ends.point, ends.separation);
  }
};

struct BoxHalfSpace {
  using Contact = WideContact<4>;

  static M may_touch(const WidePair& pair, I&) {
    const WidePlane plane = plane_of(pair);
    const V3 up = rotate_back(pair.first.rotation, plane.up), half = pair.extent_1.half;
    return is_near(pair, plane.height - (abs(up.x) * half.x + abs(up.y) * half.y + abs(up.z) * half.z));
  }

  static void collide(const WidePair& pair, I, Contact& contact) {
    const WidePlane plane = plane_of(pair);
    const V3 up = rotate_back(pair.first.rotation, plane.up);
    const F x = abs(up.x), y = abs(up.y), z = abs(up.z);
    const M faces_x = (x >= y) & (x >= z), faces_y = (!faces_x) & (y >= z);
    const F down = -select(faces_x, sign_of(up.x), select(faces_y, sign_of(up.y), sign_of(up.z)));
    contact.normal = -plane.up;
    for (int k = 0; k < 4; ++k) {
      const F first((k & 1) != 0 ? 1.0f : -1.0f), second((k & 2) != 0 ? 1.0f : -1.0f);
      const V3 sign{select(faces_x, down, first), select(faces_x, first, select(faces_y, down, second)),
                    select(faces_x | faces_y, second, down)};
      const V3 half = pair.extent_1.half;
      const I id = I(1) + count_if(sign.x > F(0.0f)) + shift_left<1>(count_if(sign.y > F(0.0f))) +
                   shift_left<2>(count_if(sign.z > F(0.0f)));
      const V3 corner{half.x * sign.x, half.y * sign.y, half.z * sign.z};
      set_point(contact, k, plane, rotate(pair.first.rotation, corner), id);
    }
    contact.in_strip = contact.at_edges = never();
  }
};

// --- hulls ---

// Up to four corners of a hull.
struct Corners {
  int count = 0;
  int vertex[4];
};

// The face that looks most along d.
int face_along(const HullData& hull, Vec d) {
  const V3 direction = wide(d);
  Largest largest;
  F index = first_indices();
  for (int k = 0; k < hull.padded_faces; k += kLanes) {
    const V3 n{load(hull.normal[0] + k), load(hull.normal[1] + k), load(hull.normal[2] + k)};
    largest.offer(dot(direction, n), index);
    index = index + F(static_cast<float>(kLanes));
  }
  return at_most(static_cast<std::uint32_t>(largest.index()), hull.face_count);
}

// Of a face's corners besides `first`: the farthest from it, the farthest from the line through these two,
// and the farthest on the line's other side. The first of nearly equal ones counts.
Corners spread_corners(const HullData& hull, int face, int first) {
  const int begin = hull.loop_begin[face], count = corner_count(hull, face);
  Corners corners{1, {first}};
  const auto take_best = [&](auto&& score) {
    float most = 0.0f;
    int best = -1;
    for (int i = 0; i < count; ++i) {
      const int candidate = hull.loop[begin + i];
      const float value = score(vertex(hull, candidate));
      if (!(value > most * (1.0f + kTieShare))) continue;
      most = value;
      best = candidate;
    }
    if (best >= 0) corners.vertex[corners.count++] = best;
    return best >= 0;
  };
  const Vec a = vertex(hull, first), up = normal(hull, face);
  if (!take_best([&](Vec v) { return dot(v - a, v - a); })) return corners;
  const Vec way = vertex(hull, corners.vertex[1]) - a;
  const auto side_of = [&](Vec v) { return dot(cross(way, v - a), up); };
  if (!take_best([&](Vec v) { return size(side_of(v)); })) return corners;
  const float side = side_of(vertex(hull, corners.vertex[2])) > 0.0f ? -1.0f : 1.0f;
  take_best([&](Vec v) { return side * side_of(v); });
  return corners;
}

// `up`: out of the half-space, in the hull's frame. Corners are those of the face that faces it most, by the
// face alone, so that they stay while the hull rocks; but the deepest corner is among them.
Corners corners_of(const HullData& hull, Vec up) {
  const float tolerance = smaller(kFeatureTolerance, kFeatureShare * hull.inner_radius);
  const int face = face_along(hull, -up), begin = hull.loop_begin[face], count = corner_count(hull, face);
  Corners corners;
  if (count <= 4) {
    for (; corners.count < count; ++corners.count)
      corners.vertex[corners.count] = hull.loop[begin + corners.count];
  } else {
    corners = spread_corners(hull, face, hull.loop[begin]);
  }
  const int deepest = farthest_vertex(hull, -up);
  float lowest = 1e30f;
  for (int i = 0; i < corners.count; ++i) lowest = smaller(dot(up, vertex(hull, corners.vertex[i])), lowest);
  if (dot(up, vertex(hull, deepest)) < lowest - tolerance) corners = spread_corners(hull, face, deepest);
  return corners;
}

// Pairs whose hull is within reach, in columns.
struct HullPoints {
  int count = 0;
  alignas(64) std::int32_t which[kCollideChunk + kLanes];
  alignas(64) float corner[4][3][kCollideChunk + kLanes];
  alignas(64) float present[4][kCollideChunk + kLanes];  // 1 or 0
  alignas(64) std::int32_t id[4][kCollideChunk + kLanes];

  void put(int item, const HullData& hull, const Corners& corners) {
    for (int k = 0; k < 4; ++k) {
      const bool exists = k < corners.count;
      const Vec place = vertex(hull, corners.vertex[exists ? k : 0]);
      corner[k][0][count] = place.x;
      corner[k][1][count] = place.y;
      corner[k][2][count] = place.z;
      present[k][count] = exists ? 1.0f : 0.0f;
      id[k][count] = exists ? 1 + corners.vertex[k] : 0;
    }
    which[count++] = item;
  }
  // Fills the last block up with copies of its last lane.
  void fill_block() {
    for (int to = count; to % kLanes != 0; ++to) {
      which[to] = which[count - 1];
      for (int k = 0; k < 4; ++k) {
        for (auto& axis : corner[k]) axis[to] = axis[count - 1];
        present[k][to] = present[k][count - 1];
        id[k][to] = id[k][count - 1];
      }
    }
  }
};

// Chooses corners, and drops the pairs that are apart.
void choose_corners(const CollideColumns& columns, const CollideItem* items, int count, HullPoints& points) {
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    const WidePair pair = load_pair(columns, block);
    const WidePlane plane = plane_of(pair);
    const std::uint32_t near = bits(is_near(pair, plane.height - pair.extent_1.radius));
    const V3 wide_up = rotate_back(pair.first.rotation, plane.up);
    alignas(64) float up[3][kLanes], height[kLanes], reach[kLanes];
    store(up[0], wide_up.x);
    store(up[1], wide_up.y);
    store(up[2], wide_up.z);
    store(height, plane.height);
    store(reach, pair.reach);
    for (int lane = 0; lane < lanes; ++lane) {
      columns.points[block.row[lane]] = 0;
      if ((near >> lane & 1u) == 0) continue;
      const HullData& hull = *columns.hulls[columns.shape_hull[block.shape_1[lane]]];
      const Vec direction{up[0][lane], up[1][lane], up[2][lane]};
      if (height[lane] - farthest_distance(hull, -direction) > reach[lane]) continue;
      points.put(begin + lane, hull, corners_of(hull, direction));
    }
  }
}

void store_points(const CollideColumns& columns, const CollideItem* items, HullPoints& points) {
  if (points.count == 0) return;
  points.fill_block();
  for (int begin = 0; begin < points.count; begin += kLanes) {
    const int lanes = points.count - begin < kLanes ? points.count - begin : kLanes;
    Block block;
    load_block(items, points.which + begin, lanes, block);
    const WidePair pair = load_pair(columns, block);
    const WidePlane plane = plane_of(pair);
    WideContact<4> contact;
    contact.normal = -plane.up;
    for (int k = 0; k < 4; ++k) {
      const V3 corner{load(points.corner[k][0] + begin), load(points.corner[k][1] + begin),
                      load(points.corner[k][2] + begin)};
      set_point(contact, k, plane, rotate(pair.first.rotation, corner), load(points.id[k] + begin));
      const M absent = !(load(points.present[k] + begin) > F(0.0f));
      contact.separation[k] = select(absent, F(kAbsentSeparation), contact.separation[k]);
      const V3 nowhere{F(0.0f), F(0.0f), F(0.0f)};
      contact.point[k] = select(absent, nowhere, contact.point[k]);
    }
    contact.in_strip = contact.at_edges = never();
    store_contacts(columns, items, points.which + begin, block, pair.first.position, pair.reach, contact);
  }
}

}  // namespace

void collide_sphere_half_space(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<SphereHalfSpace>(columns, items, count);
}
void collide_capsule_half_space(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<CapsuleHalfSpace>(columns, items, count);
}
void collide_box_half_space(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<BoxHalfSpace>(columns, items, count);
}
void collide_hull_half_space(const CollideColumns& columns, const CollideItem* items, int count) {
  HullPoints points;
  choose_corners(columns, items, count, points);
  store_points(columns, items, points);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
