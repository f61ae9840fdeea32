// Hulls: contact points of faces with few corners, lane = pair. As collide_hull_clip.cpp does for one pair.
#include <simd/kernels/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kCandidates = 3 * kSmallFace;

V3 get(const float (&v)[3][kLanes]) { return {load(v[0]), load(v[1]), load(v[2])}; }

// The faces in the deciding one's coordinates: x and y in it, z outward from it.
struct Faces {
  V3 x_axis, y_axis, z_axis;
  F offset;
  F x[kSmallFace + 1], y[kSmallFace + 1];  // of the deciding face; then the first again
  V3 incident[kSmallFace + 1];
  F side_x[kSmallFace], side_y[kSmallFace], side[kSmallFace];  // outward normals and distances of its sides
  V3 plane;                                                    // normal of the incident face
  V3 support;                                                  // deepest vertex
  F reach, tolerance, border;
};

Faces set_up(const FaceQueue& queue) {
  Faces f;
  f.z_axis = get(queue.deciding_normal);
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
  for (int k = 0; k < kSmallFace; ++k) {
    const V3 corner = get(queue.deciding[k]);
    f.x[k] = dot(f.x_axis, corner);
    f.y[k] = dot(f.y_axis, corner);
    f.incident[k] = turn(get(queue.incident[k])) + origin;
  }
  f.x[kSmallFace] = f.x[0];
  f.y[kSmallFace] = f.y[0];
  f.incident[kSmallFace] = f.incident[0];
  f.plane = turn(get(queue.incident_normal));
  f.support = turn(get(queue.support)) + origin;
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

// Both ends of each incident edge within the deciding face, grown by the tolerance.
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
    const F z_begin = from.z + begin * way.z, z_end = from.z + end * way.z;
    out.x[k] = from.x + begin * way.x;
    out.y[k] = from.y + begin * way.y;
    out.separation[k] = select(exists & (z_begin <= f.reach), z_begin, absent);
    // The end of an edge that is not cut is the beginning of the next.
    const int other = kSmallFace + k;
    out.x[other] = from.x + end * way.x;
    out.y[other] = from.y + end * way.y;
    out.separation[other] = select(exists & (end < F(1.0f)) & (z_end <= f.reach), z_end, absent);
  }
}

// Corners of the deciding face within the incident one, shrunk by the tolerance: near its border the incident
// edges have found them already.
void add_corners(const Faces& f, F count, F incident_count, Candidates& out) {
  const M faces = f.plane.z < F(-kSteepFace);
  const F inverse = F(-1.0f) / select(faces, f.plane.z, F(-1.0f));
  const F slope_x = f.plane.x * inverse, slope_y = f.plane.y * inverse;
  F least[kSmallFace];
  for (int s = 0; s < kSmallFace; ++s) {
    const F dx = f.incident[s + 1].x - f.incident[s].x, dy = f.incident[s + 1].y - f.incident[s].y;
    // Corners that only fill up the lane hold nothing back.
    least[s] =
        select(F(static_cast<float>(s)) < incident_count, -f.border * sqrt(dx * dx + dy * dy), F(1e30f));
  }
  for (int k = 0; k < kSmallFace; ++k) {
    const F x = f.x[k], y = f.y[k];
    M inside = faces & (F(static_cast<float>(k)) < count);
    for (int s = 0; s < kSmallFace; ++s) {
      const F dx = f.incident[s + 1].x - f.incident[s].x, dy = f.incident[s + 1].y - f.incident[s].y;
      // Seen from the deciding face the loop runs clockwise.
      inside = inside & (dx * (y - f.incident[s].y) - dy * (x - f.incident[s].x) < least[s]);
    }
    const F z = f.incident[0].z + slope_x * (x - f.incident[0].x) + slope_y * (y - f.incident[0].y);
    const int to = 2 * kSmallFace + k;
    out.x[to] = x;
    out.y[to] = y;
    out.separation[to] = select(inside & (z <= f.reach), z, F(kAbsentSeparation));
  }
}

struct Chosen {
  F x, y, separation;
  I number;
  M found;
};

// The first candidate whose score is the largest, or less by the share or the slack.
template <class Score>
Chosen choose(const Candidates& c, F reach, F least, F share, F slack, Score&& score) {
  F scores[kCandidates], top = least;
  for (int k = 0; k < kCandidates; ++k) {
    scores[k] = select(c.separation[k] <= reach, score(c.x[k], c.y[k], c.separation[k]), F(-1e30f));
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

// Four of the candidates: the deepest, the farthest from it, the farthest from the line through these two,
// and the one that adds most area to that triangle. Points nearer than the tolerance to what is there are
// dropped.
void reduce(const Faces& f, const Candidates& c, Chosen chosen[4]) {
  const F none(0.0f), share(kTieShare), never_enough(1e30f);
  chosen[0] =
      choose(c, f.reach, F(-1e29f), none, f.tolerance, [](F, F, F separation) { return -separation; });
  chosen[1] = choose(c, f.reach, select(chosen[0].found, square(f.border), never_enough), share, none,
                     [&](F x, F y, F) { return square(x - chosen[0].x) + square(y - chosen[0].y); });
  const F along = sqrt(square(chosen[1].x - chosen[0].x) + square(chosen[1].y - chosen[0].y));
  const F least = select(chosen[1].found, f.border * along, never_enough);
  chosen[2] = choose(c, f.reach, least, share, none,
                     [&](F x, F y, F) { return abs(area(chosen[0], chosen[1], x, y)); });
  const M right = area(chosen[0], chosen[1], chosen[2].x, chosen[2].y) < F(0.0f);
  const F turn = select(right, F(1.0f), F(-1.0f));
  chosen[3] = choose(c, f.reach, select(chosen[2].found, least, never_enough), share, none, [&](F x, F y, F) {
    return max(turn * area(chosen[0], chosen[1], x, y),
               max(turn * area(chosen[1], chosen[2], x, y), turn * area(chosen[2], chosen[0], x, y)));
  });
}

// Faces that overlap along every axis and still share no point (an edge nearly as good as the face): the
// deepest vertex, moved onto the face towards its middle.
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

void FaceQueue::put(const HullPair& pair, const Decision& decision, int incident_face) {
  const int to = count++, side = decision.side;
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
  deciding_count[to] = write_loop(deciding, hull, decision.face);
  incident_count[to] = write_loop(incident, other, incident_face);
  for (int k = 0; k < 3; ++k) write(row[k], frame.row[k].axis);
  write(center, frame.center());
  write(deciding_normal, normal(hull, decision.face));
  offset[to] = hull.offset[decision.face];
  write(incident_normal, normal(other, incident_face));
  write(support, vertex(other, decision.support));
  separation[to] = decision.separation;
  reach[to] = pair.reach;
  tolerance[to] = pair.tolerance;
  border[to] = pair.border;
  id[to] = static_cast<std::int32_t>(face_id(decision, incident_face));
}

void clip_queue(FaceQueue& queue, HullContact contacts[kLanes]) {
  const Faces f = set_up(queue);
  const F count = load(queue.deciding_count), incident_count = load(queue.incident_count);
  Candidates candidates;
  clip_edges(f, incident_count, candidates);
  add_corners(f, count, incident_count, candidates);
  Chosen chosen[4];
  reduce(f, candidates, chosen);
  take_support(f, load(queue.separation), count, chosen[0]);
  const I id = load(queue.id);
  for (int k = 0; k < 4; ++k) {
    const F height = f.offset + F(0.5f) * chosen[k].separation;
    const V3 point = chosen[k].x * f.x_axis + chosen[k].y * f.y_axis + height * f.z_axis;
    alignas(64) float lanes[4][kLanes];
    alignas(64) std::int32_t ids[kLanes];
    store(lanes[0], point.x);
    store(lanes[1], point.y);
    store(lanes[2], point.z);
    store(lanes[3], select(chosen[k].found, chosen[k].separation, F(kAbsentSeparation)));
    store(ids, select(chosen[k].found, id + chosen[k].number, I(0)));
    for (int lane = 0; lane < queue.count; ++lane) {
      contacts[lane].point[k] = {lanes[0][lane], lanes[1][lane], lanes[2][lane]};
      contacts[lane].separation[k] = lanes[3][lane];
      contacts[lane].id[k] = static_cast<std::uint32_t>(ids[lane]);
    }
  }
  queue.count = 0;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
