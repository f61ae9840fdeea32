// Hulls: contact points of two faces, for polygons of any size. Clips one face against the other, seen along
// the contact axis, and keeps at most four corners of the overlap. Where edges decide, the first point is
// their crossing, and the faces at these edges give the others: a hull would rock and sink in on a single
// point.
//
// Lanes are edges of the clipped face, then corners. Clipping of all edges at once: Cyrus and Beck, 1978.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kMaxCorners = kMaxHullVertices;
constexpr int kMaxCandidates = 3 * kMaxCorners;
int padded(int count) { return (count + kHullPadding - 1) / kHullPadding * kHullPadding; }

// Coordinates of the contact: z along the axis, from the surface of the first face's hull outward.
struct FaceFrame {
  Vec x, y, z;
  float offset;

  Vec to_face(Vec p) const { return {dot(x, p), dot(y, p), dot(z, p) - offset}; }
  Vec from_face(float px, float py, float pz) const { return px * x + py * y + (pz + offset) * z; }
};
FaceFrame face_frame(const FacePair& faces) {
  FaceFrame f;
  f.z = faces.axis;
  f.offset = faces.offset;
  // As tangent_of().
  const float sign = f.z.z < 0.0f ? -1.0f : 1.0f;
  const float a = -1.0f / (sign + f.z.z);
  const float b = f.z.x * f.z.y * a;
  f.x = {1.0f + sign * f.z.x * f.z.x * a, sign * b, -sign * f.z.x};
  f.y = cross(f.z, f.x);
  return f;
}

// Corners in the contact's coordinates. Copies of the first corner follow the last, up to the next block.
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

// The height of a face's plane at (x, y). Zero slopes: the face is perpendicular to the axis.
struct Plane {
  float height = 0.0f, slope_x = 0.0f, slope_y = 0.0f;

  F at(F x, F y) const { return F(height) + F(slope_x) * x + F(slope_y) * y; }
  float at(float x, float y) const { return height + slope_x * x + slope_y * y; }
};
Plane plane_of(const Polygon& polygon, const FaceFrame& frame, Vec n) {
  const float inverse = -1.0f / dot(frame.z, n);
  const float slope_x = dot(frame.x, n) * inverse, slope_y = dot(frame.y, n) * inverse;
  return {polygon.z[0] - (slope_x * polygon.x[0] + slope_y * polygon.y[0]), slope_x, slope_y};
}

struct Candidates {
  int count;  // with padding
  alignas(64) float x[kMaxCandidates];
  alignas(64) float y[kMaxCandidates];
  alignas(64) float separation[kMaxCandidates];
  alignas(64) float number[kMaxCandidates];
};

// Sides of the first face, seen along the axis: outward normals and distances.
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

// Both ends of each incident edge within the first face, grown by the tolerance. No end gets deeper than
// `least`.
void clip_edges(const Polygon& incident, const Sides& sides, int side_count, float border, const Plane& floor,
                float least, Candidates& out) {
  const int block = padded(incident.count);
  const F tolerance(border), absent(kAbsentSeparation), tiny(1e-12f);
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
    const auto put = [&](int to, F share, M is_there) {
      const F point_x = x + share * way_x, point_y = y + share * way_y;
      store(out.x + to, point_x);
      store(out.y + to, point_y);
      const F separation = max(z + share * way_z - floor.at(point_x, point_y), F(least));
      store(out.separation + to, select(is_there, separation, absent));
    };
    const int other = block + k;
    put(k, begin, exists);
    // The end of an edge that is not cut is the beginning of the next.
    put(other, end, exists & (end < F(1.0f)));
    store(out.number + k, number + number);
    store(out.number + other, number + number + F(1.0f));
    number = number + F(static_cast<float>(kLanes));
  }
  out.count = 2 * block;
}

// Corners of the first face within the incident face. The incident face is shrunk by the tolerance: near its
// border the incident edges have found these corners already.
void add_corners(const HullPair& pair, const Polygon& deciding, const Polygon& incident, const Plane& floor,
                 const Plane& ceiling, float least, Candidates& out) {
  const F absent(kAbsentSeparation);
  F number = first_indices();
  const int block = padded(deciding.count);
  for (int k = 0; k < block; k += kLanes) {
    const F x = load(deciding.x + k), y = load(deciding.y + k);
    M inside = number < F(static_cast<float>(deciding.count));
    for (int s = 0; s < incident.count; ++s) {
      const float dx = incident.x[s + 1] - incident.x[s], dy = incident.y[s + 1] - incident.y[s];
      const float inward = pair.border * square_root(dx * dx + dy * dy);
      // Seen from the first face the loop runs clockwise.
      const F left = F(dx) * (y - F(incident.y[s])) - F(dy) * (x - F(incident.x[s]));
      inside = inside & (left < F(-inward));
    }
    store(out.x + out.count, x);
    store(out.y + out.count, y);
    const F separation = max(ceiling.at(x, y) - floor.at(x, y), F(least));
    store(out.separation + out.count, select(inside, separation, absent));
    store(out.number + out.count, number + F(static_cast<float>(2 * incident.count)));
    out.count += kLanes;
    number = number + F(static_cast<float>(kLanes));
  }
}

// Index of the first candidate whose score equals the largest up to the share or the slack. -1: no score is
// above `least`.
template <class Score>
int choose(const Candidates& c, float least, float share, float slack, Score&& score) {
  alignas(64) float scores[kMaxCandidates];
  F top(least);
  for (int k = 0; k < c.count; k += kLanes) {
    const F separation = load(c.separation + k);
    const F value = score(load(c.x + k), load(c.y + k), separation);
    const F present = select(separation < F(0.5f * kAbsentSeparation), value, F(-1e30f));
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

// Selects up to three candidates besides a first point: the farthest from it, the farthest from the line
// through these two, and the one that adds most area to that triangle. Drops candidates nearer than the
// tolerance to a selected point. Candidates may lie beyond the reach: a body that tips over meets the ground
// there before the step ends. Returns their number.
int spread(const Candidates& c, Point a, float border, int chosen[3]) {
  const auto farthest = [&](float least, auto&& score) {
    return choose(c, least, kTieShare, 0.0f, [&](F x, F y, F) { return score(x, y); });
  };
  chosen[0] = farthest(border * border, [&](F x, F y) { return square(x - F(a.x)) + square(y - F(a.y)); });
  if (chosen[0] < 0) return 0;
  const Point b = point_at(c, chosen[0]);
  const float least = border * square_root((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
  chosen[1] = farthest(least, [&](F x, F y) { return abs(area(a, b, x, y)); });
  if (chosen[1] < 0) return 1;
  const Point d = point_at(c, chosen[1]);
  const F turn(area(a, b, d) < 0.0f ? 1.0f : -1.0f);
  chosen[2] = farthest(least, [&](F x, F y) {
    return max(turn * area(a, b, x, y), max(turn * area(b, d, x, y), turn * area(d, a, x, y)));
  });
  return chosen[2] < 0 ? 2 : 3;
}

void write_point(const HullPair& pair, int side, Vec point, float separation, std::uint32_t id, int k,
                 HullContact& contact) {
  contact.point[k] = side == 0 ? point : pair.frame[0].place(point);
  contact.separation[k] = separation;
  contact.id[k] = id;
}
void write_candidate(const HullPair& pair, const FacePair& faces, const FaceFrame& frame, const Plane& floor,
                     const Candidates& c, int place, int k, HullContact& contact) {
  const float x = c.x[place], y = c.y[place], separation = c.separation[place];
  write_point(pair, faces.side, frame.from_face(x, y, 0.5f * separation + floor.at(x, y)), separation,
              face_id(faces) | static_cast<std::uint32_t>(c.number[place]), k, contact);
}

// The first point: the crossing of edges, or the deepest candidate. Returns false if it is out of reach.
bool find_first(const HullPair& pair, const Decision& decision, const FacePair& faces, const FaceFrame& frame,
                const Plane& floor, const Candidates& c, Point& first, HullContact& contact) {
  if (faces.crosses) {
    touch_crossing(decision, faces.crossing, contact);
    const Vec point = frame.to_face(contact.point[0]);
    first = {point.x, point.y};
    return true;
  }
  const int k = choose(c, -1e29f, 0.0f, pair.tolerance, [](F, F, F separation) { return -separation; });
  if (k < 0 || c.separation[k] > pair.reach) return false;
  first = point_at(c, k);
  write_candidate(pair, faces, frame, floor, c, k, 0, contact);
  return true;
}

}  // namespace

void clip_faces(const HullPair& pair, const Decision& decision, const FacePair& faces, HullContact& contact) {
  const int side = faces.side;
  const HullData &hull = *pair.hull[side], &other = *pair.hull[1 - side];
  const FaceFrame frame = face_frame(faces);

  Polygon deciding, incident;
  deciding.count = corner_count(hull, faces.face);
  for (int k = 0; k < deciding.count; ++k) {
    deciding.put(k, frame.to_face(vertex(hull, hull.loop[hull.loop_begin[faces.face] + k])));
  }
  deciding.pad();
  incident.count = corner_count(other, faces.incident);
  for (int k = 0; k < incident.count; ++k) {
    const Vec corner = vertex(other, other.loop[other.loop_begin[faces.incident] + k]);
    incident.put(k, frame.to_face(pair.frame[side].place(corner)));
  }
  incident.pad();

  Sides sides;
  make_sides(deciding, sides);
  // Planes that are askew would give depths beyond that of the edges.
  const Plane floor = faces.crosses ? plane_of(deciding, frame, normal(hull, faces.face)) : Plane{};
  const float least = faces.crosses ? decision.separation : -kAbsentSeparation;
  Candidates candidates;
  clip_edges(incident, sides, deciding.count, pair.border, floor, least, candidates);
  const Vec against = pair.frame[side].turn(normal(other, faces.incident));
  if (dot(frame.z, against) < -kSteepFace) {
    add_corners(pair, deciding, incident, floor, plane_of(incident, frame, against), least, candidates);
  }

  for (int k = 0; k < 4; ++k) set_absent(contact, k);
  Point first;
  if (find_first(pair, decision, faces, frame, floor, candidates, first, contact)) {
    int chosen[3];
    const int count = spread(candidates, first, pair.border, chosen);
    for (int k = 0; k < count; ++k) {
      write_candidate(pair, faces, frame, floor, candidates, chosen[k], k + 1, contact);
    }
  } else if (decision.separation <= 0.0f) {
    // Faces that overlap along every axis can still share no point (if an edge is nearly as good as the
    // face). Then takes the deepest vertex, moved onto the face.
    const Vec deepest = pair.frame[side].place(vertex(other, decision.support));
    const Vec point = point_within_face(hull, faces.face, deepest) + (0.5f * decision.separation) * frame.z;
    write_point(pair, side, point, decision.separation, face_id(faces) | kLostNumber, 0, contact);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
