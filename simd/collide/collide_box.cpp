// Boxes against boxes: tests 15 separating axes, then either clips the incident face against the reference
// face and reduces it to 4 points, or takes the closest points of two edges.
//
// Works in the first box's frame until the final rotation into world axes. Separating axes of boxes:
// Gottschalk, Lin and Manocha, "OBBTree", 1996. Clipping by slabs: Cyrus and Beck, 1978.
#include <simd/collide/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Two edges span no axis if the squared sine of their angle is below this: then the faces decide.
constexpr float kParallelEdges = 1e-5f;
// An edge axis must beat the best face by this share of the depth (or by the feature tolerance): a face gives
// up to four points, which is worth more than a slightly better depth.
constexpr float kEdgeShare = 0.05f;
// Cosine of 18 degrees. An edge axis closer than this to the face's normal must also beat the depth of the
// faces' overlap.
constexpr float kBesideFace = 0.95f;
// A candidate must be deeper than each earlier one by this share of the feature tolerance to become the
// deepest. So equal candidates do not alternate while a box at rest jitters.
constexpr float kTieShare = 0.04f;
constexpr int kCandidates = 12;

// Hint bits of a pair: the face axis, whether it is the second box's, the edge axis (3 i + j) and whether the
// edge wins.
constexpr int kHintSecond = 4;
constexpr int kHintEdgeShift = 4;
constexpr int kHintEdgeMask = 15;
constexpr int kHintEdgeWins = 256;

// The second box in the frame of the first: axes as columns, center, half extents of both.
struct BoxFrame {
  F axis[3][3];  // [row][column]: component along the first box's axis `row` of the second's axis `column`
  F center[3];
  F half_1[3], half_2[3];
  F tolerance;
  F reach;  // gap below which there are points
};

BoxFrame to_frame(const WidePair& pair) {
  const M3 r = to_matrix(conjugate(pair.first.rotation) * pair.second.rotation);
  const V3 center = rotate_back(pair.first.rotation, pair.offset);
  const V3 h1 = pair.extent_1.half, h2 = pair.extent_2.half;
  BoxFrame frame{{{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}},
                 {center.x, center.y, center.z},
                 {h1.x, h1.y, h1.z},
                 {h2.x, h2.y, h2.z},
                 F(0.0f),
                 pair.reach};
  const F smallest = min(min(h1.x, min(h1.y, h1.z)), min(h2.x, min(h2.y, h2.z)));
  frame.tolerance = min(F(kFeatureTolerance), F(kFeatureShare) * smallest);
  return frame;
}

// Best axis so far. Among equal axes the first in a fixed order wins.
struct Best {
  F separation;
  I code;
  void offer(F separation_of, std::int32_t code_of) {
    const M better = separation_of > separation;
    separation = select(better, separation_of, separation);
    code = select(better, I(code_of), code);
  }
};

// A face of the second box must win by the tolerance, so that boxes at rest on each other do not swap roles.
Best best_face(const BoxFrame& f, F absolute[3][3]) {
  Best first{F(-1e30f), I(0)}, second{F(-1e30f), I(0)};
  for (int i = 0; i < 3; ++i) {
    const F reach =
        absolute[i][0] * f.half_2[0] + absolute[i][1] * f.half_2[1] + absolute[i][2] * f.half_2[2];
    first.offer(abs(f.center[i]) - (f.half_1[i] + reach), i);
  }
  for (int j = 0; j < 3; ++j) {
    const F reach =
        absolute[0][j] * f.half_1[0] + absolute[1][j] * f.half_1[1] + absolute[2][j] * f.half_1[2];
    const F distance = f.axis[0][j] * f.center[0] + f.axis[1][j] * f.center[1] + f.axis[2][j] * f.center[2];
    second.offer(abs(distance) - (f.half_2[j] + reach), kHintSecond + j);
  }
  const M use_second = second.separation > first.separation + f.tolerance;
  return {select(use_second, second.separation, first.separation),
          select(use_second, second.code, first.code)};
}

// Gap along edge axis (i, j) times the axis's length, which is at most 1, and the length squared.
void edge_gap(const BoxFrame& f, const F absolute[3][3], int i, int j, F& gap, F& length_2) {
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const F distance = abs(f.center[i2] * f.axis[i1][j] - f.center[i1] * f.axis[i2][j]);
  const F reach_1 = f.half_1[i1] * absolute[i2][j] + f.half_1[i2] * absolute[i1][j];
  const F reach_2 = f.half_2[j1] * absolute[i][j2] + f.half_2[j2] * absolute[i][j1];
  gap = distance - (reach_1 + reach_2);
  length_2 = square(f.axis[i1][j]) + square(f.axis[i2][j]);
}

// Tests the 15 axes. Skips the nine divisions where no edge can win: dividing a negative gap by a length of
// at most 1 only lowers it.
M find_axis(const BoxFrame& f, I& hint) {
  F absolute[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) absolute[i][j] = abs(f.axis[i][j]);
  }
  const Best face = best_face(f, absolute);
  hint = face.code;
  const M near_faces = face.separation <= f.reach;
  if (!any(near_faces)) return near_faces;
  const F to_beat = face.separation + max(f.tolerance, F(kEdgeShare) * abs(face.separation));
  const F could_win = min(to_beat, F(0.0f));
  F gap[9], length_2[9];
  M candidate = never();
  for (int k = 0; k < 9; ++k) {
    edge_gap(f, absolute, k / 3, k % 3, gap[k], length_2[k]);
    candidate = candidate | (gap[k] > could_win);
  }
  if (!any(candidate & near_faces)) return near_faces;
  Best edge{to_beat, I(-1)};
  for (int k = 0; k < 9; ++k) {
    const M crossing = length_2[k] > F(kParallelEdges);
    const F separation = gap[k] / min(sqrt(length_2[k]), F(1.0f));
    edge.offer(select(crossing, separation, F(-1e30f)), k);
  }
  const M wins = edge.code > I(-1);
  hint = select(wins, hint | shift_left<kHintEdgeShift>(edge.code) | I(kHintEdgeWins), hint);
  return near_faces & !(wins & (edge.separation > f.reach));
}

// Selects one of three values by a lane's number 0, 1 or 2.
struct Choice {
  M is_1, is_2;
  explicit Choice(I number) : is_1(number == I(1)), is_2(number == I(2)) {}
  F operator()(F a, F b, F c) const { return select(is_2, c, select(is_1, b, a)); }
  F operator()(const F v[3]) const { return (*this)(v[0], v[1], v[2]); }
  F next(const F v[3]) const { return (*this)(v[1], v[2], v[0]); }
  F last(const F v[3]) const { return (*this)(v[2], v[0], v[1]); }
};

// The clipping problem in the reference face's coordinates: x and y in the face (along the reference box's
// axes after the face's, cyclically), z outward from it. The incident face is center + s side_1 + t side_2
// with |s| <= half_1 and |t| <= half_2.
struct Clipping {
  F half_x, half_y;
  F center_x, center_y, center_z;
  F side_1x, side_1y, side_1z, side_2x, side_2y, side_2z;
  F half_1, half_2;
  I feature;  // identity of the two faces, shifted above the candidates' numbers
  F outward;  // sign of the reference axis that the face looks along
  M second;   // the reference face is the second box's
  I axis;     // its axis
  F half_z;
  F reach;
  F tolerance;
};

Clipping set_up(const BoxFrame& f, I hint) {
  Clipping c;
  c.second = (hint & I(kHintSecond)) == I(kHintSecond);
  c.axis = hint & I(3);
  c.tolerance = f.tolerance;
  c.reach = f.reach;
  // The incident box as the reference box sees it: rows along the reference axes.
  F row[3][3], center[3], half_reference[3], half_incident[3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) row[i][j] = select(c.second, f.axis[j][i], f.axis[i][j]);
    const F back = -(f.axis[0][i] * f.center[0] + f.axis[1][i] * f.center[1] + f.axis[2][i] * f.center[2]);
    center[i] = select(c.second, back, f.center[i]);
    half_reference[i] = select(c.second, f.half_2[i], f.half_1[i]);
    half_incident[i] = select(c.second, f.half_1[i], f.half_2[i]);
  }
  const Choice reference(c.axis);
  c.half_z = reference(half_reference);
  c.half_x = reference.next(half_reference);
  c.half_y = reference.last(half_reference);
  c.outward = sign_of(reference(center));
  F x[3], y[3], z[3];
  for (int j = 0; j < 3; ++j) {
    z[j] = c.outward * reference(row[0][j], row[1][j], row[2][j]);
    x[j] = reference(row[1][j], row[2][j], row[0][j]);
    y[j] = reference(row[2][j], row[0][j], row[1][j]);
  }
  // The incident face looks against the reference face: its normal has the largest component along z.
  const M is_1 = abs(z[1]) > abs(z[0]);
  const M is_2 = abs(z[2]) > select(is_1, abs(z[1]), abs(z[0]));
  const I face = select(is_2, I(2), select(is_1, I(1), I(0)));
  const Choice incident(face);
  const F facing = -sign_of(incident(z));
  const F reach = facing * incident(half_incident);
  c.center_x = reference.next(center) + reach * incident(x);
  c.center_y = reference.last(center) + reach * incident(y);
  c.center_z = c.outward * reference(center) - c.half_z + reach * incident(z);
  c.side_1x = incident.next(x);
  c.side_1y = incident.next(y);
  c.side_1z = incident.next(z);
  c.side_2x = incident.last(x);
  c.side_2y = incident.last(y);
  c.side_2z = incident.last(z);
  c.half_1 = incident.next(half_incident);
  c.half_2 = incident.last(half_incident);
  const I reference_code =
      select(c.second, I(kHintSecond), I(0)) + c.axis + select(c.outward < F(0.0f), I(8), I(0));
  const I incident_code = face + select(facing < F(0.0f), I(4), I(0));
  c.feature = shift_left<8>(reference_code) + shift_left<4>(incident_code) + I(1);
  return c;
}

// Corners of the overlap of the two faces: the two ends of each incident edge within the reference face, and
// the reference corners within the incident face. Absent candidates have separation kAbsentSeparation.
struct Candidates {
  F x[kCandidates], y[kCandidates], separation[kCandidates];
};

// Parameters, as shares of the edge, at which an incident edge that starts at (x, y) enters and leaves the
// reference face grown by the tolerance.
void clip_edge(const Clipping& c, F x, F y, F inverse_dx, F inverse_dy, F& begin, F& end) {
  const F reach_x = c.half_x + c.tolerance, reach_y = c.half_y + c.tolerance;
  const F x_1 = (-reach_x - x) * inverse_dx, x_2 = (reach_x - x) * inverse_dx;
  const F y_1 = (-reach_y - y) * inverse_dy, y_2 = (reach_y - y) * inverse_dy;
  begin = max(max(min(x_1, x_2), min(y_1, y_2)), F(0.0f));
  end = min(min(max(x_1, x_2), max(y_1, y_2)), F(1.0f));
}

F safe_inverse(F a) { return F(1.0f) / copy_sign(max(abs(a), F(1e-12f)), a); }

Candidates clip(const Clipping& c) {
  // The incident normal is side_1 x side_2, up to sign.
  const F normal_x = c.side_1y * c.side_2z - c.side_1z * c.side_2y;
  const F normal_y = c.side_1z * c.side_2x - c.side_1x * c.side_2z;
  const F normal_z = c.side_1x * c.side_2y - c.side_1y * c.side_2x;  // at least 1/sqrt(3) in size
  const F inverse_z = F(1.0f) / normal_z;
  const F slope_x = -normal_x * inverse_z, slope_y = -normal_y * inverse_z;  // of the incident face
  Candidates out;
  const auto put = [&](int k, F x, F y, M exists) {
    out.x[k] = clamp(x, -c.half_x, c.half_x);
    out.y[k] = clamp(y, -c.half_y, c.half_y);
    const F height = c.center_z + slope_x * (out.x[k] - c.center_x) + slope_y * (out.y[k] - c.center_y);
    out.separation[k] = select(exists & (height <= c.reach), height, F(kAbsentSeparation));
  };

  const F two(2.0f);
  const F run_1x = c.half_1 * c.side_1x, run_1y = c.half_1 * c.side_1y;
  const F run_2x = c.half_2 * c.side_2x, run_2y = c.half_2 * c.side_2y;
  const F corner_x[4] = {c.center_x - run_1x - run_2x, c.center_x + run_1x - run_2x,
                         c.center_x + run_1x + run_2x, c.center_x - run_1x + run_2x};
  const F corner_y[4] = {c.center_y - run_1y - run_2y, c.center_y + run_1y - run_2y,
                         c.center_y + run_1y + run_2y, c.center_y - run_1y + run_2y};
  const F inverse[4] = {safe_inverse(two * run_1x), safe_inverse(two * run_1y), safe_inverse(two * run_2x),
                        safe_inverse(two * run_2y)};
  for (int edge = 0; edge < 4; ++edge) {
    const bool along_1 = edge % 2 == 0;
    const F way = edge < 2 ? two : F(-2.0f);
    const F dx = way * (along_1 ? run_1x : run_2x), dy = way * (along_1 ? run_1y : run_2y);
    const F inverse_x = edge < 2 ? inverse[along_1 ? 0 : 2] : -inverse[along_1 ? 0 : 2];
    const F inverse_y = edge < 2 ? inverse[along_1 ? 1 : 3] : -inverse[along_1 ? 1 : 3];
    F begin, end;
    clip_edge(c, corner_x[edge], corner_y[edge], inverse_x, inverse_y, begin, end);
    const M inside = begin <= end;
    put(2 * edge, corner_x[edge] + begin * dx, corner_y[edge] + begin * dy, inside);
    put(2 * edge + 1, corner_x[edge] + end * dx, corner_y[edge] + end * dy, inside & (end < F(1.0f)));
  }

  // Reference corners in the incident face's coordinates. The face is shrunk by the tolerance: near its
  // border the incident edges have found the corner already.
  const F reach_1 = c.half_1 - c.tolerance, reach_2 = c.half_2 - c.tolerance;
  for (int corner = 0; corner < 4; ++corner) {
    const F x = (corner & 1) != 0 ? c.half_x : -c.half_x, y = (corner & 2) != 0 ? c.half_y : -c.half_y;
    const F from_x = x - c.center_x, from_y = y - c.center_y;
    const F s = (from_x * c.side_2y - from_y * c.side_2x) * inverse_z;
    const F t = (c.side_1x * from_y - c.side_1y * from_x) * inverse_z;
    put(8 + corner, x, y, (abs(s) < reach_1) & (abs(t) < reach_2));
  }
  return out;
}

// Whether the faces overlap only in a strip, at any distance from each other. The strip must be thinner than
// both faces: the whole of a thin face is no strip.
M overlap_in_strip(const Clipping& clipping) {
  Clipping c = clipping;
  c.reach = F(0.5f * kAbsentSeparation);
  const Candidates candidates = clip(c);
  F x[kCandidates], y[kCandidates], some_x(0.0f), some_y(0.0f);
  const auto exists = [&](int k) { return candidates.separation[k] <= c.reach; };
  for (int k = 0; k < kCandidates; ++k) {
    some_x = select(exists(k), candidates.x[k], some_x);
    some_y = select(exists(k), candidates.y[k], some_y);
  }
  for (int k = 0; k < kCandidates; ++k) {
    x[k] = select(exists(k), candidates.x[k], some_x);
    y[k] = select(exists(k), candidates.y[k], some_y);
  }
  const F thinnest = min(min(c.half_x, c.half_y), min(c.half_1, c.half_2));
  return width_of(x, y) < min(F(kStrip), thinnest);
}

struct Chosen {
  F x, y, separation;
  I number;
  M found;
};

// The candidate with the largest score above `least`. Among equal candidates the first wins.
template <class Score>
Chosen choose(const Candidates& candidates, F least, Score&& score) {
  Chosen best{F(0.0f), F(0.0f), F(kAbsentSeparation), I(0), never()};
  F best_score = least;
  for (int k = 0; k < kCandidates; ++k) {
    const F score_k = score(k);
    const M better = score_k > best_score;
    best_score = select(better, score_k, best_score);
    best.x = select(better, candidates.x[k], best.x);
    best.y = select(better, candidates.y[k], best.y);
    best.separation = select(better, candidates.separation[k], best.separation);
    best.number = select(better, I(k), best.number);
    best.found = best.found | better;
  }
  return best;
}

// Twice the area of the triangle (a, b, point k), positive to the left of a -> b.
F area(const Chosen& a, const Chosen& b, F x, F y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// Selects four candidates: the deepest, the farthest from it, the farthest from the line through these two,
// and the one that adds most area to that triangle. Drops candidates nearer than the tolerance to a selected
// one.
void reduce(const Clipping& c, Candidates& candidates, Chosen chosen[4]) {
  const F step = F(kTieShare) * c.tolerance;
  chosen[0] = choose(candidates, F(-1e9f),
                     [&](int k) { return -candidates.separation[k] - F(static_cast<float>(k)) * step; });
  // Absent candidates fall on the first point, where they add neither distance nor area.
  for (int k = 0; k < kCandidates; ++k) {
    const M absent = candidates.separation[k] > c.reach;
    candidates.x[k] = select(absent, chosen[0].x, candidates.x[k]);
    candidates.y[k] = select(absent, chosen[0].y, candidates.y[k]);
  }
  chosen[1] = choose(candidates, square(c.tolerance), [&](int k) {
    return square(candidates.x[k] - chosen[0].x) + square(candidates.y[k] - chosen[0].y);
  });
  const F long_side = sqrt(square(chosen[1].x - chosen[0].x) + square(chosen[1].y - chosen[0].y));
  const F least_area = select(chosen[1].found, c.tolerance * long_side, F(1e30f));
  chosen[2] = choose(candidates, least_area, [&](int k) {
    return abs(area(chosen[0], chosen[1], candidates.x[k], candidates.y[k]));
  });
  const F turn = sign_of(area(chosen[0], chosen[1], chosen[2].x, chosen[2].y));
  const F least_gain = select(chosen[2].found, least_area, F(1e30f));
  chosen[3] = choose(candidates, least_gain, [&](int k) {
    const F x = candidates.x[k], y = candidates.y[k];
    const F outside_1 = -turn * area(chosen[0], chosen[1], x, y);
    const F outside_2 = -turn * area(chosen[1], chosen[2], x, y);
    const F outside_3 = -turn * area(chosen[2], chosen[0], x, y);
    return max(outside_1, max(outside_2, outside_3));
  });
}

struct BoxBox {
  using Contact = WideContact<4>;

  static M may_touch(const WidePair& pair, I& hint) {
    const M near = spheres_touch(pair, length(pair.extent_1.half), length(pair.extent_2.half)) &
                   is_rotation(pair.first.rotation) & is_rotation(pair.second.rotation);
    if (!any(near)) return near;
    return near & find_axis(to_frame(pair), hint);
  }

  static void collide(const WidePair& pair, I hint, Contact& contact) {
    const BoxFrame frame = to_frame(pair);
    const M edge_wins = (hint & I(kHintEdgeWins)) == I(kHintEdgeWins);
    const F deepest = collide_faces(pair, frame, hint, contact);
    if (any(edge_wins)) collide_edges(pair, frame, hint, edge_wins, deepest, contact);
  }

  // Returns the separation of the deepest corner of the faces' overlap; a very low value if there is none.
  static F collide_faces(const WidePair& pair, const BoxFrame& frame, I hint, Contact& contact) {
    const Clipping c = set_up(frame, hint);
    Candidates candidates = clip(c);
    contact.in_strip = contact.at_edges = never();
    if (any(c.reach > F(kSpeculativeDistance))) contact.in_strip = overlap_in_strip(c);
    Chosen chosen[4];
    reduce(c, candidates, chosen);
    const F of_overlap = select(chosen[0].found, chosen[0].separation, F(-1e30f));

    // Faces that overlap along every axis can still share no point (if an edge is nearly as good as the
    // face). Then takes the deepest incident corner, moved onto the face.
    const F toward_1 = -sign_of(c.side_1z) * c.half_1, toward_2 = -sign_of(c.side_2z) * c.half_2;
    const F deepest = c.center_z + toward_1 * c.side_1z + toward_2 * c.side_2z;
    const M lost = (!chosen[0].found) & (deepest <= F(0.0f));
    const F corner_x = c.center_x + toward_1 * c.side_1x + toward_2 * c.side_2x;
    const F corner_y = c.center_y + toward_1 * c.side_1y + toward_2 * c.side_2y;
    chosen[0].x = select(lost, clamp(corner_x, -c.half_x, c.half_x), chosen[0].x);
    chosen[0].y = select(lost, clamp(corner_y, -c.half_y, c.half_y), chosen[0].y);
    chosen[0].separation = select(lost, deepest, chosen[0].separation);
    chosen[0].number = select(lost, I(kCandidates), chosen[0].number);
    chosen[0].found = chosen[0].found | lost;

    const Q4 q1 = pair.first.rotation, q2 = pair.second.rotation;
    const Q4 q{select(c.second, q2.x, q1.x), select(c.second, q2.y, q1.y), select(c.second, q2.z, q1.z),
               select(c.second, q2.w, q1.w)};
    const M3 m = to_matrix(q);
    const Choice axis(c.axis);
    const V3 along_z{axis(m.x.x, m.y.x, m.z.x), axis(m.x.y, m.y.y, m.z.y), axis(m.x.z, m.y.z, m.z.z)};
    const V3 along_x{axis(m.y.x, m.z.x, m.x.x), axis(m.y.y, m.z.y, m.x.y), axis(m.y.z, m.z.z, m.x.z)};
    const V3 along_y{axis(m.z.x, m.x.x, m.y.x), axis(m.z.y, m.x.y, m.y.y), axis(m.z.z, m.x.z, m.y.z)};
    const V3 outward = along_z * c.outward;
    contact.normal = select(c.second, -outward, outward);
    const F zero(0.0f);
    const V3 origin = select(c.second, pair.offset, V3{zero, zero, zero}) + outward * c.half_z;
    for (int k = 0; k < 4; ++k) {
      contact.point[k] = origin + chosen[k].x * along_x + chosen[k].y * along_y +
                         (F(0.5f) * select(chosen[k].found, chosen[k].separation, zero)) * outward;
      contact.separation[k] = select(chosen[k].found, chosen[k].separation, F(kAbsentSeparation));
      contact.id[k] = select(chosen[k].found, c.feature + chosen[k].number, I(0));
    }
    return of_overlap;
  }

  // Takes the closest points of the two edges where the edge axis wins. An edge axis near the face's normal
  // must also beat the depth of the faces' overlap. Planks that cross each other with hardly any tilt have
  // such axes. The face's own depth is that of a plank's far end, and a single point instead of four lets a
  // tower of planks rock and fall.
  static void collide_edges(const WidePair& pair, const BoxFrame& f, I hint, M edge_wins, F of_overlap,
                            Contact& contact) {
    const I edge = shift_right<kHintEdgeShift>(hint) & I(kHintEdgeMask);
    const I i = select(edge > I(5), I(2), select(edge > I(2), I(1), I(0)));
    const I j = edge - (i + i + i);
    const Choice choose_i(i), choose_j(j);
    const F zero(0.0f), one(1.0f);
    const V3 direction_1{choose_i(one, zero, zero), choose_i(zero, one, zero), choose_i(zero, zero, one)};
    const V3 direction_2{choose_j(f.axis[0]), choose_j(f.axis[1]), choose_j(f.axis[2])};
    const V3 center{f.center[0], f.center[1], f.center[2]};
    const V3 product = cross(direction_1, direction_2);
    const F length_2 = max(length_squared(product), F(1e-12f));
    const V3 normal = product * (sign_of(dot(product, center)) / sqrt(length_2));
    const F n[3] = {normal.x, normal.y, normal.z};

    // Middles of the edges: the farthest of the first box along the normal, of the second against it.
    I corners(0);
    F corner_1[3];
    V3 middle_2 = center;
    for (int k = 0; k < 3; ++k) {
      const M other_1 = !(i == I(k)), other_2 = !(j == I(k));
      const F along_2 = n[0] * f.axis[0][k] + n[1] * f.axis[1][k] + n[2] * f.axis[2][k];
      corner_1[k] = select(other_1, copy_sign(f.half_1[k], n[k]), zero);
      const F back = select(other_2, copy_sign(f.half_2[k], -along_2), zero);
      middle_2 = middle_2 + V3{f.axis[0][k], f.axis[1][k], f.axis[2][k]} * back;
      corners = corners + select(other_1 & (n[k] < zero), I(1 << k), I(0)) +
                select(other_2 & (along_2 > zero), I(8 << k), I(0));
    }
    const V3 middle_1{corner_1[0], corner_1[1], corner_1[2]};
    const V3 apart = middle_2 - middle_1;
    const F half_1 = choose_i(f.half_1), half_2 = choose_j(f.half_2);
    // By triple products: differences of products cancel where edges are nearly parallel.
    const F s = clamp(dot(cross(apart, direction_2), product) / length_2, -half_1, half_1);
    const F t = clamp(dot(cross(apart, direction_1), product) / length_2, -half_2, half_2);
    const V3 point_1 = middle_1 + s * direction_1, point_2 = middle_2 + t * direction_2;
    const V3 difference = point_2 - point_1;
    const F separation = dot(normal, difference);
    // Edges that pass each other sideways do not touch yet.
    const M beside =
        (separation > zero) & !is_beside(difference, normal, square(min(F(kSpeculativeDistance), f.reach)));
    const M touches = (!beside) & (separation <= f.reach);

    const V3 world_normal = rotate(pair.first.rotation, normal);
    const M beside_face = dot(world_normal, contact.normal) > F(kBesideFace);
    const M shallower = separation > of_overlap + max(f.tolerance, F(kEdgeShare) * abs(of_overlap));
    const M wins = edge_wins & (shallower | !beside_face);

    contact.in_strip = contact.in_strip & !wins;
    contact.at_edges = wins;
    contact.normal = select(wins, world_normal, contact.normal);
    const V3 middle = rotate(pair.first.rotation, F(0.5f) * (point_1 + point_2));
    contact.point[0] = select(wins, middle, contact.point[0]);
    contact.separation[0] =
        select(wins, select(touches, separation, F(kAbsentSeparation)), contact.separation[0]);
    const I id = I(0x10000) + shift_left<6>(edge) + corners;
    contact.id[0] = select(wins, select(touches, id, I(0)), contact.id[0]);
    for (int k = 1; k < 4; ++k) {
      contact.separation[k] = select(wins, F(kAbsentSeparation), contact.separation[k]);
      contact.id[k] = select(wins, I(0), contact.id[k]);
    }
  }
};

}  // namespace

void collide_box_box(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_pairs<BoxBox>(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
