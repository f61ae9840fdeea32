// Hulls: contact points of a face, for polygons of any size. The other hull's face is clipped against it, and
// at most four of the corners of the overlap are kept.
//
// Lanes are edges of the clipped face, then corners. Clipping of all edges at once: Cyrus and Beck, 1978.
#include <simd/kernels/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kMaxCorners = kMaxHullVertices;
constexpr int kMaxCandidates = 3 * kMaxCorners;
int padded(int count) { return (count + kHullPadding - 1) / kHullPadding * kHullPadding; }

// The deciding face's coordinates: x and y in the face, z outward from it.
struct FaceFrame {
  Vec x, y, z;
  float offset;

  Vec to_face(Vec p) const { return {dot(x, p), dot(y, p), dot(z, p) - offset}; }
  Vec from_face(float px, float py, float pz) const { return px * x + py * y + (pz + offset) * z; }
};
FaceFrame face_frame(const HullData& hull, int face) {
  FaceFrame f;
  f.z = normal(hull, face);
  f.offset = hull.offset[face];
  // As tangent_of().
  const float sign = f.z.z < 0.0f ? -1.0f : 1.0f;
  const float a = -1.0f / (sign + f.z.z);
  const float b = f.z.x * f.z.y * a;
  f.x = {1.0f + sign * f.z.x * f.z.x * a, sign * b, -sign * f.z.x};
  f.y = cross(f.z, f.x);
  return f;
}

// Corners in the deciding face's coordinates; behind the last one the first follows, up to the next block.
struct Polygon {
  int count;
  alignas(64) float x[kMaxCorners + kHullPadding];
  alignas(64) float y[kMaxCorners + kHullPadding];
  alignas(64) float z[kMaxCorners + kHullPadding];

  void put(int k, Vec v) {
    x[k] = v.x;
    y[k] = v.y;
    z[k] = v.z;
  }
  void pad() {
    const int end = padded(count);
    for (int k = count; k <= end && k < kMaxCorners + kHullPadding; ++k) put(k, {x[0], y[0], z[0]});
  }
};

struct Candidates {
  int count;  // with padding
  alignas(64) float x[kMaxCandidates];
  alignas(64) float y[kMaxCandidates];
  alignas(64) float separation[kMaxCandidates];
  alignas(64) float number[kMaxCandidates];
};

// Side planes of the deciding face: outward normal in the face, and distance.
struct Sides {
  float x[kMaxCorners], y[kMaxCorners], offset[kMaxCorners];
};
void make_sides(const Polygon& p, Sides& sides) {
  for (int k = 0; k < p.count; ++k) {
    const float dx = p.x[k + 1] - p.x[k], dy = p.y[k + 1] - p.y[k];
    const float inverse = 1.0f / square_root(larger(dx * dx + dy * dy, 1e-30f));
    sides.x[k] = dy * inverse;
    sides.y[k] = -dx * inverse;
    sides.offset[k] = sides.x[k] * p.x[k] + sides.y[k] * p.y[k];
  }
}

// Both ends of each incident edge within the deciding face, grown by the tolerance.
void clip_edges(const HullPair& pair, const Polygon& incident, const Sides& sides, int side_count,
                Candidates& out) {
  const int block = padded(incident.count);
  const F tolerance(pair.border), reach(pair.reach), absent(kAbsentSeparation), tiny(1e-12f);
  F number = first_indices();
  for (int k = 0; k < block; k += kLanes) {
    const F x = load(incident.x + k), y = load(incident.y + k), z = load(incident.z + k);
    const F way_x = load_unaligned(incident.x + k + 1) - x, way_y = load_unaligned(incident.y + k + 1) - y,
            way_z = load_unaligned(incident.z + k + 1) - z;
    F begin(0.0f), end(1.0f);
    for (int s = 0; s < side_count; ++s) {
      const F side_x(sides.x[s]), side_y(sides.y[s]);
      const F beyond = side_x * x + side_y * y - (F(sides.offset[s]) + tolerance);
      const F approach = side_x * way_x + side_y * way_y;
      const M enters = approach < F(0.0f);
      const F share = -beyond / select(enters, min(approach, -tiny), max(approach, tiny));
      begin = select(enters, max(share, begin), begin);
      end = select(enters, end, min(share, end));
    }
    const M exists = (begin <= end) & (number < F(static_cast<float>(incident.count)));
    const F z_begin = z + begin * way_z, z_end = z + end * way_z;
    store(out.x + k, x + begin * way_x);
    store(out.y + k, y + begin * way_y);
    store(out.separation + k, select(exists & (z_begin <= reach), z_begin, absent));
    store(out.number + k, number + number);
    const int other = block + k;
    store(out.x + other, x + end * way_x);
    store(out.y + other, y + end * way_y);
    // The end of an edge that is not cut is the beginning of the next.
    store(out.separation + other, select(exists & (end < F(1.0f)) & (z_end <= reach), z_end, absent));
    store(out.number + other, number + number + F(1.0f));
    number = number + F(static_cast<float>(kLanes));
  }
  out.count = 2 * block;
}

// Corners of the deciding face within the incident one, shrunk by the tolerance: near its border the incident
// edges have found them already.
void add_corners(const HullPair& pair, const Polygon& deciding, const Polygon& incident, Vec plane,
                 Candidates& out) {
  if (!(plane.z < -kSteepFace)) return;
  const F slope_x(-plane.x / plane.z), slope_y(-plane.y / plane.z);
  const F x_0(incident.x[0]), y_0(incident.y[0]), z_0(incident.z[0]);
  const F reach(pair.reach), absent(kAbsentSeparation);
  F number = first_indices();
  const int block = padded(deciding.count);
  for (int k = 0; k < block; k += kLanes) {
    const F x = load(deciding.x + k), y = load(deciding.y + k);
    M inside = number < F(static_cast<float>(deciding.count));
    for (int s = 0; s < incident.count; ++s) {
      const float dx = incident.x[s + 1] - incident.x[s], dy = incident.y[s + 1] - incident.y[s];
      const float least = pair.border * square_root(dx * dx + dy * dy);
      // Seen from the deciding face the loop runs clockwise.
      const F left = F(dx) * (y - F(incident.y[s])) - F(dy) * (x - F(incident.x[s]));
      inside = inside & (left < F(-least));
    }
    const F z = z_0 + slope_x * (x - x_0) + slope_y * (y - y_0);
    store(out.x + out.count, x);
    store(out.y + out.count, y);
    store(out.separation + out.count, select(inside & (z <= reach), z, absent));
    store(out.number + out.count, number + F(static_cast<float>(2 * incident.count)));
    out.count += kLanes;
    number = number + F(static_cast<float>(kLanes));
  }
}

// Place of the first candidate whose score is the largest, or less by the share or the slack, -1: none is
// above `least`.
template <class Score>
int choose(const Candidates& c, float reach, float least, float share, float slack, Score&& score) {
  alignas(64) float scores[kMaxCandidates];
  F top(least);
  for (int k = 0; k < c.count; k += kLanes) {
    const F separation = load(c.separation + k);
    const F value = score(load(c.x + k), load(c.y + k), separation);
    const F present = select(separation <= F(reach), value, F(-1e30f));
    store(scores + k, present);
    top = max(present, top);
  }
  const float highest = reduce_max(top);
  if (!(highest > least)) return -1;
  const F enough(larger(highest - share * highest - slack, least));
  int k = 0;
  std::uint32_t found = 0;
  for (; found == 0; k += kLanes) found = bits(load(scores + k) >= enough);
  return k - kLanes + __builtin_ctz(found);
}

struct Point {
  float x, y;
};
Point point_at(const Candidates& c, int k) { return {c.x[k], c.y[k]}; }
// Twice the area of the triangle (a, b, (x, y)), positive to the left of a -> b.
F area(Point a, Point b, F x, F y) { return F(b.x - a.x) * (y - F(a.y)) - F(b.y - a.y) * (x - F(a.x)); }
float area(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Four of the candidates: the deepest, the farthest from it, the farthest from the line through these two,
// and the one that adds most area to that triangle. Points nearer than the tolerance to what is there are
// dropped. Returns their number.
int reduce(const HullPair& pair, const Candidates& c, int chosen[4]) {
  const float border = pair.border;
  const auto spread = [&](float least, auto&& score) {
    return choose(c, pair.reach, least, kTieShare, 0.0f, [&](F x, F y, F) { return score(x, y); });
  };
  chosen[0] =
      choose(c, pair.reach, -1e29f, 0.0f, pair.tolerance, [](F, F, F separation) { return -separation; });
  if (chosen[0] < 0) return 0;
  const Point a = point_at(c, chosen[0]);
  chosen[1] = spread(border * border, [&](F x, F y) { return square(x - F(a.x)) + square(y - F(a.y)); });
  if (chosen[1] < 0) return 1;
  const Point b = point_at(c, chosen[1]);
  const float least = border * square_root((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
  chosen[2] = spread(least, [&](F x, F y) { return abs(area(a, b, x, y)); });
  if (chosen[2] < 0) return 2;
  const Point d = point_at(c, chosen[2]);
  const F turn(area(a, b, d) < 0.0f ? 1.0f : -1.0f);
  chosen[3] = spread(least, [&](F x, F y) {
    return max(turn * area(a, b, x, y), max(turn * area(b, d, x, y), turn * area(d, a, x, y)));
  });
  return chosen[3] < 0 ? 3 : 4;
}

void write_point(const HullPair& pair, int side, Vec point, float separation, std::uint32_t id, int k,
                 HullContact& contact) {
  contact.point[k] = side == 0 ? point : pair.frame[0].place(point);
  contact.separation[k] = separation;
  contact.id[k] = id;
}

}  // namespace

void clip_faces(const HullPair& pair, const Decision& decision, int face_2, HullContact& contact) {
  const int side = decision.side;
  const HullData &hull = *pair.hull[side], &other = *pair.hull[1 - side];
  const FaceFrame frame = face_frame(hull, decision.face);

  Polygon deciding, incident;
  deciding.count = corner_count(hull, decision.face);
  for (int k = 0; k < deciding.count; ++k) {
    deciding.put(k, frame.to_face(vertex(hull, hull.loop[hull.loop_begin[decision.face] + k])));
  }
  deciding.pad();
  incident.count = corner_count(other, face_2);
  for (int k = 0; k < incident.count; ++k) {
    const Vec corner = vertex(other, other.loop[other.loop_begin[face_2] + k]);
    incident.put(k, frame.to_face(pair.frame[side].place(corner)));
  }
  incident.pad();

  Sides sides;
  make_sides(deciding, sides);
  Candidates candidates;
  clip_edges(pair, incident, sides, deciding.count, candidates);
  const Vec plane = pair.frame[side].turn(normal(other, face_2));
  add_corners(pair, deciding, incident, {dot(frame.x, plane), dot(frame.y, plane), dot(frame.z, plane)},
              candidates);
  int chosen[4];
  const int count = reduce(pair, candidates, chosen);

  const std::uint32_t id = face_id(decision, face_2);
  for (int k = 0; k < 4; ++k) {
    if (k >= count) {
      write_point(pair, 0, {0.0f, 0.0f, 0.0f}, kAbsentSeparation, 0, k, contact);
      continue;
    }
    const int place = chosen[k];
    const float separation = candidates.separation[place];
    write_point(pair, side, frame.from_face(candidates.x[place], candidates.y[place], 0.5f * separation),
                separation, id | static_cast<std::uint32_t>(candidates.number[place]), k, contact);
  }
  // Faces that overlap along every axis and still share no point (an edge nearly as good as the face): the
  // deepest vertex, moved onto the face.
  if (count == 0 && decision.separation <= 0.0f) {
    const Vec deepest = pair.frame[side].place(vertex(other, decision.support));
    const Vec point =
        point_within_face(hull, decision.face, deepest) + (0.5f * decision.separation) * frame.z;
    write_point(pair, side, point, decision.separation, id | kLostNumber, 0, contact);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
