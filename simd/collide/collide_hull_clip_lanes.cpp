// Hulls: contact points of faces with few corners, lane = pair. Uses the method of collide_hull_clip.cpp.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kCandidates = 3 * kSmallFace;

V3 get(const float (&v)[3][kLanes]) { return {load(v[0]), load(v[1]), load(v[2])}; }

// The height of a face's plane at (x, y).
struct Plane {
  F height, slope_x, slope_y;

  F at(F x, F y) const { return height + slope_x * x + slope_y * y; }
};

// Both faces in the contact's coordinates: z along the axis, from the surface of the first face's hull
// outward.
struct Faces {
  V3 x_axis, y_axis, z_axis;
  F offset;
  F x[kSmallFace + 1], y[kSmallFace + 1];  // of the first face; then its first corner again
  V3 incident[kSmallFace + 1];
  F side_x[kSmallFace], side_y[kSmallFace], side[kSmallFace];  // outward normals and distances of its sides
  Plane floor, ceiling;  // of the first and of the incident face; zero where the axis is the first one's own
  M faces;               // the incident face is not seen from its edge
  V3 support;            // deepest vertex
  M crosses;             // edges decided; where they cross:
  F crossing_x, crossing_y;
  F least;  // lower bound on separations: planes that are askew would give depths beyond that of the edges
  F reach, tolerance, border;
};

Plane plane_of(V3 corner, V3 normal, M is_plane) {
  const F inverse = F(-1.0f) / select(is_plane, normal.z, F(-1.0f)), none(0.0f);
  const F slope_x = normal.x * inverse, slope_y = normal.y * inverse;
  return {select(is_plane, corner.z - (slope_x * corner.x + slope_y * corner.y), none),
          select(is_plane, slope_x, none), select(is_plane, slope_y, none)};
}

Faces set_up(const FaceQueue& queue) {
  Faces f;
  f.z_axis = get(queue.axis);
  f.x_axis = tangent_of(f.z_axis);
  f.y_axis = cross(f.z_axis, f.x_axis);
  f.offset = load(queue.offset);
  f.reach = load(queue.reach);
  f.tolerance = load(queue.tolerance);
  f.border = load(queue.border);
  const V3 row_x = get(queue.row[0]), row_y = get(queue.row[1]), row_z = get(queue.row[2]);
  const auto turn = [&](V3 v) {
    const V3 p{dot(row_x, v), dot(row_y, v), dot(row_z, v)};
    return V3{dot(f.x_axis, p), dot(f.y_axis, p), dot(f.z_axis, p)};
  };
  const V3 center = get(queue.center);
  const V3 origin{dot(f.x_axis, center), dot(f.y_axis, center), dot(f.z_axis, center) - f.offset};
  const auto to_face = [&](V3 v) {
    return V3{dot(f.x_axis, v), dot(f.y_axis, v), dot(f.z_axis, v) - f.offset};
  };
  for (int k = 0; k < kSmallFace; ++k) {
    const V3 corner = to_face(get(queue.deciding[k]));
    f.x[k] = corner.x;
    f.y[k] = corner.y;
    f.incident[k] = turn(get(queue.incident[k])) + origin;
  }
  f.x[kSmallFace] = f.x[0];
  f.y[kSmallFace] = f.y[0];
  f.incident[kSmallFace] = f.incident[0];
  f.support = turn(get(queue.support)) + origin;
  f.crosses = load(queue.crossing[3]) > F(0.0f);
  const V3 crossing = to_face({load(queue.crossing[0]), load(queue.crossing[1]), load(queue.crossing[2])});
  f.least = select(f.crosses, load(queue.separation), F(-kAbsentSeparation));
  f.crossing_x = crossing.x;
  f.crossing_y = crossing.y;
  const V3 n = get(queue.deciding_normal), against = turn(get(queue.incident_normal));
  f.floor = plane_of(to_face(get(queue.deciding[0])), {dot(f.x_axis, n), dot(f.y_axis, n), dot(f.z_axis, n)},
                     f.crosses);
  f.faces = against.z < F(-kSteepFace);
  f.ceiling = plane_of(f.incident[0], against, f.faces);
  for (int k = 0; k < kSmallFace; ++k) {
    const F dx = f.x[k + 1] - f.x[k], dy = f.y[k + 1] - f.y[k];
    const F inverse = F(1.0f) / sqrt(max(dx * dx + dy * dy, F(1e-30f)));
    f.side_x[k] = dy * inverse;
    f.side_y[k] = -dx * inverse;
    f.side[k] = f.side_x[k] * f.x[k] + f.side_y[k] * f.y[k];
  }
  return f;
}

struct Candidates {
  F x[kCandidates], y[kCandidates], separation[kCandidates];
};

// Both ends of each incident edge within the first face, grown by the tolerance.
void clip_edges(const Faces& f, F count, Candidates& out) {
  const F absent(kAbsentSeparation), tiny(1e-12f);
  for (int k = 0; k < kSmallFace; ++k) {
    const V3 from = f.incident[k], way = f.incident[k + 1] - from;
    F begin(0.0f), end(1.0f);
    for (int s = 0; s < kSmallFace; ++s) {
      const F beyond = f.side_x[s] * from.x + f.side_y[s] * from.y - (f.side[s] + f.border);
      const F approach = f.side_x[s] * way.x + f.side_y[s] * way.y;
      const M enters = approach < F(0.0f);
      const F share = -beyond / select(enters, min(approach, -tiny), max(approach, tiny));
      begin = select(enters, max(share, begin), begin);
      end = select(enters, end, min(share, end));
    }
    const M exists = (begin <= end) & (F(static_cast<float>(k)) < count);
    const auto put = [&](int to, F share, M is_there) {
      out.x[to] = from.x + share * way.x;
      out.y[to] = from.y + share * way.y;
      out.separation[to] =
          select(is_there, max(from.z + share * way.z - f.floor.at(out.x[to], out.y[to]), f.least), absent);
    };
    put(k, begin, exists);
    // The end of an edge that is not cut is the beginning of the next.
    put(kSmallFace + k, end, exists & (end < F(1.0f)));
  }
}

// Corners of the first face within the incident face. The incident face is shrunk by the tolerance: near its
// border the incident edges have found these corners already.
void add_corners(const Faces& f, F count, F incident_count, Candidates& out) {
  F least[kSmallFace];
  for (int s = 0; s < kSmallFace; ++s) {
    const F dx = f.incident[s + 1].x - f.incident[s].x, dy = f.incident[s + 1].y - f.incident[s].y;
    // Corners that only fill up the lane exclude nothing.
    least[s] =
        select(F(static_cast<float>(s)) < incident_count, -f.border * sqrt(dx * dx + dy * dy), F(1e30f));
  }
  for (int k = 0; k < kSmallFace; ++k) {
    const F x = f.x[k], y = f.y[k];
    M inside = f.faces & (F(static_cast<float>(k)) < count);
    for (int s = 0; s < kSmallFace; ++s) {
      const F dx = f.incident[s + 1].x - f.incident[s].x, dy = f.incident[s + 1].y - f.incident[s].y;
      // Seen from the first face the loop runs clockwise.
      inside = inside & (dx * (y - f.incident[s].y) - dy * (x - f.incident[s].x) < least[s]);
    }
    const int to = 2 * kSmallFace + k;
    out.x[to] = x;
    out.y[to] = y;
    out.separation[to] =
        select(inside, max(f.ceiling.at(x, y) - f.floor.at(x, y), f.least), F(kAbsentSeparation));
  }
}

struct Chosen {
  F x, y, separation;
  I number;
  M found;
};

// The first candidate whose score equals the largest up to the share or the slack.
template <class Score>
Chosen choose(const Candidates& c, F least, F share, F slack, Score&& score) {
  F scores[kCandidates], top = least;
  for (int k = 0; k < kCandidates; ++k) {
    scores[k] = select(c.separation[k] < F(0.5f * kAbsentSeparation), score(c.x[k], c.y[k], c.separation[k]),
                       F(-1e30f));
    top = max(scores[k], top);
  }
  Chosen chosen{F(0.0f), F(0.0f), F(kAbsentSeparation), I(0), top > least};
  const F enough = max(top - share * top - slack, least);
  for (int k = kCandidates - 1; k >= 0; --k) {
    const M takes = scores[k] >= enough;
    chosen.x = select(takes, c.x[k], chosen.x);
    chosen.y = select(takes, c.y[k], chosen.y);
    chosen.separation = select(takes, c.separation[k], chosen.separation);
    chosen.number = select(takes, I(k), chosen.number);
  }
  return chosen;
}

// Twice the area of the triangle (a, b, (x, y)), positive to the left of a -> b.
F area(const Chosen& a, const Chosen& b, F x, F y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// Selects the crossing of edges, or the deepest candidate if it is within reach. Adds up to three others,
// within reach or not: the farthest from it, the farthest from the line through these two, and the one that
// adds most area to that triangle. Drops candidates nearer than the tolerance to a selected point.
void reduce(const Faces& f, const Candidates& c, F separation, Chosen chosen[4]) {
  const F none(0.0f), share(kTieShare), never_enough(1e30f);
  Chosen& first = chosen[0];
  first = choose(c, F(-1e29f), none, f.tolerance, [](F, F, F depth) { return -depth; });
  first.x = select(f.crosses, f.crossing_x, first.x);
  first.y = select(f.crosses, f.crossing_y, first.y);
  first.separation = select(f.crosses, separation, first.separation);
  first.found = f.crosses | (first.found & (first.separation <= f.reach));
  chosen[1] = choose(c, select(first.found, square(f.border), never_enough), share, none,
                     [&](F x, F y, F) { return square(x - first.x) + square(y - first.y); });
  const F along = sqrt(square(chosen[1].x - first.x) + square(chosen[1].y - first.y));
  const F least = select(chosen[1].found, f.border * along, never_enough);
  chosen[2] = choose(c, least, share, none, [&](F x, F y, F) { return abs(area(first, chosen[1], x, y)); });
  const M right = area(first, chosen[1], chosen[2].x, chosen[2].y) < F(0.0f);
  const F turn = select(right, F(1.0f), F(-1.0f));
  chosen[3] = choose(c, select(chosen[2].found, least, never_enough), share, none, [&](F x, F y, F) {
    return max(turn * area(first, chosen[1], x, y),
               max(turn * area(chosen[1], chosen[2], x, y), turn * area(chosen[2], first, x, y)));
  });
}

// Faces that overlap along every axis can still share no point (if an edge is nearly as good as the face).
// Then takes the deepest vertex, moved onto the face towards its middle.
void take_support(const Faces& f, F separation, F count, Chosen& chosen) {
  const M lost = (!chosen.found) & (separation <= F(0.0f));
  if (!any(lost)) return;
  F middle_x(0.0f), middle_y(0.0f);
  for (int k = 0; k < kSmallFace; ++k) {
    const M present = F(static_cast<float>(k)) < count;
    middle_x += select(present, f.x[k], F(0.0f));
    middle_y += select(present, f.y[k], F(0.0f));
  }
  middle_x = middle_x / count;
  middle_y = middle_y / count;
  F share(1.0f);
  for (int s = 0; s < kSmallFace; ++s) {
    const F inside = f.side_x[s] * middle_x + f.side_y[s] * middle_y - f.side[s];
    const F beyond = f.side_x[s] * f.support.x + f.side_y[s] * f.support.y - f.side[s];
    const M cut = (beyond > F(0.0f)) & (inside < F(0.0f));
    share = select(cut, min(inside / (inside - beyond), share), share);
  }
  chosen.x = select(lost, middle_x + share * (f.support.x - middle_x), chosen.x);
  chosen.y = select(lost, middle_y + share * (f.support.y - middle_y), chosen.y);
  chosen.separation = select(lost, separation, chosen.separation);
  chosen.number = select(lost, I(static_cast<std::int32_t>(kLostNumber)), chosen.number);
  chosen.found = chosen.found | lost;
}

}  // namespace

void FaceQueue::put(const HullPair& pair, const Decision& decision, const FacePair& faces) {
  const int to = count++, side = faces.side;
  const HullData &hull = *pair.hull[side], &other = *pair.hull[1 - side];
  const HullFrame& frame = pair.frame[side];
  const auto write = [to](float(&column)[3][kLanes], Vec v) {
    column[0][to] = v.x;
    column[1][to] = v.y;
    column[2][to] = v.z;
  };
  const auto write_loop = [&](float(&columns)[kSmallFace][3][kLanes], const HullData& of, int face) {
    const int corners = corner_count(of, face);
    const std::uint8_t* loop = of.loop + of.loop_begin[face];
    for (int k = 0; k < kSmallFace; ++k) write(columns[k], vertex(of, loop[k < corners ? k : 0]));
    return static_cast<float>(corners);
  };
  deciding_count[to] = write_loop(deciding, hull, faces.face);
  incident_count[to] = write_loop(incident, other, faces.incident);
  for (int k = 0; k < 3; ++k) write(row[k], frame.row[k].axis);
  write(center, frame.center());
  write(axis, faces.axis);
  offset[to] = faces.offset;
  write(deciding_normal, normal(hull, faces.face));
  write(incident_normal, normal(other, faces.incident));
  write(support, vertex(other, decision.support));
  const Vec between = 0.5f * (faces.crossing.on_1 + faces.crossing.on_2);
  crossing[0][to] = between.x;
  crossing[1][to] = between.y;
  crossing[2][to] = between.z;
  crossing[3][to] = faces.crosses ? 1.0f : 0.0f;
  edges_id[to] = static_cast<std::int32_t>(decision.feature);
  separation[to] = decision.separation;
  reach[to] = pair.reach;
  tolerance[to] = pair.tolerance;
  border[to] = pair.border;
  id[to] = static_cast<std::int32_t>(face_id(faces));
}

void clip_queue(FaceQueue& queue, HullContact contacts[kLanes]) {
  const Faces f = set_up(queue);
  const F count = load(queue.deciding_count), incident_count = load(queue.incident_count);
  const F separation = load(queue.separation);
  Candidates candidates;
  clip_edges(f, incident_count, candidates);
  add_corners(f, count, incident_count, candidates);
  Chosen chosen[4];
  reduce(f, candidates, separation, chosen);
  take_support(f, separation, count, chosen[0]);
  const I id = load(queue.id);
  for (int k = 0; k < 4; ++k) {
    const Chosen& c = chosen[k];
    // The crossing's height is half its separation: the axis is offset by the first edge itself.
    const F floor = f.floor.at(c.x, c.y);
    const F height = f.offset + F(0.5f) * c.separation + (k == 0 ? select(f.crosses, F(0.0f), floor) : floor);
    const V3 point = c.x * f.x_axis + c.y * f.y_axis + height * f.z_axis;
    I number = id + c.number;
    if (k == 0) number = select(f.crosses, load(queue.edges_id), number);
    alignas(64) float lanes[4][kLanes];
    alignas(64) std::int32_t ids[kLanes];
    store(lanes[0], point.x);
    store(lanes[1], point.y);
    store(lanes[2], point.z);
    store(lanes[3], select(c.found, c.separation, F(kAbsentSeparation)));
    store(ids, select(c.found, number, I(0)));
    for (int lane = 0; lane < queue.count; ++lane) {
      contacts[lane].point[k] = {lanes[0][lane], lanes[1][lane], lanes[2][lane]};
      contacts[lane].separation[k] = lanes[3][lane];
      contacts[lane].id[k] = static_cast<std::uint32_t>(ids[lane]);
    }
  }
  queue.count = 0;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
