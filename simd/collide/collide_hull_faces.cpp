// Hulls: finds the face along whose normal a pair overlaps least.
//
// A full search takes the farthest vertex of the other hull for every face. Bounds rule most faces out
// before: any point of the other hull, and the ball inside it, bound the gap from above. A face is searched
// only while its bound can beat the best gap so far. Each vertex found is one more bounding point (the
// cutting planes of Kelley, 1960). The search starts at the face that decided last time, which changes only
// its duration.
#include <simd/collide/collide_hull.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr int kPaddedFaces = (kMaxHullFaces + kHullPadding - 1) / kHullPadding * kHullPadding;
constexpr int kMaxWitnesses = 6;

// Points of the other hull, in the frame of the hull whose faces are searched.
struct Witnesses {
  Vec point[kMaxWitnesses];
  int count = 0;

  void add(Vec x) {
    if (count < kMaxWitnesses) point[count++] = x;
  }
};

struct BestFace {
  float separation;
  int face;     // -1: none is above the floor
  int support;  // the other hull's deepest vertex
};

class FaceSearch {
 public:
  FaceSearch(const HullPair& pair, int side)
      : hull_(*pair.hull[side]), other_(*pair.hull[1 - side]), frame_(pair.frame[side]), pair_(pair) {}

  // Finds the best face above the floor, or any face that separates the pair.
  BestFace run(int start, const Witnesses& witnesses, float floor) {
    best_ = {floor, -1, 0};
    Vec latest{};
    if (start >= 0) latest = search(start);
    if (best_.face >= 0 && best_.separation > pair_.reach) return best_;
    int top = bound_all(witnesses, start, latest);
    while (top >= 0 && bound_[top] >= best_.separation - pair_.rounding) {
      const Vec found = search(top);
      if (best_.face >= 0 && best_.separation > pair_.reach) break;
      top = lower_bounds(found, top);
    }
    return best_;
  }

 private:
  // Gap of one face; returns the other hull's deepest vertex.
  Vec search(int face) {
    const Vec n = normal(hull_, face);
    const int support = farthest_vertex(other_, -frame_.turn_back(n));
    const Vec x = frame_.place(vertex(other_, support));
    const float separation = dot(n, x) - hull_.offset[face];
    if (separation > best_.separation ||
        (separation == best_.separation && best_.face >= 0 && face < best_.face)) {
      best_ = {separation, face, support};
    }
    return x;
  }

  V3 normals(int k) const {
    return {load(hull_.normal[0] + k), load(hull_.normal[1] + k), load(hull_.normal[2] + k)};
  }

  // Bounds of all faces but `done`; returns the face with the largest.
  int bound_all(const Witnesses& witnesses, int done, Vec latest) {
    const V3 center = wide(frame_.center()), last = wide(latest);
    const F ball(other_.inner_radius), searched(static_cast<float>(done));
    const bool has_latest = done >= 0;
    Largest largest;
    F index = first_indices();
    for (int k = 0; k < hull_.padded_faces; k += kLanes) {
      const V3 n = normals(k);
      const F offset = load(hull_.offset + k);
      F bound = dot(n, center) - ball;
      if (has_latest) bound = min(dot(n, last), bound);
      for (int w = 0; w < witnesses.count; ++w) bound = min(dot(n, wide(witnesses.point[w])), bound);
      bound = select(index == searched, F(-1e30f), bound - offset);
      store(bound_ + k, bound);
      largest.offer(bound, index);
      index = index + F(static_cast<float>(kLanes));
    }
    return largest.index();
  }

  // Updates the bounds with one more point; `done` has just been searched.
  int lower_bounds(Vec point, int done) {
    const V3 x = wide(point);
    const F searched(static_cast<float>(done));
    Largest largest;
    F index = first_indices();
    for (int k = 0; k < hull_.padded_faces; k += kLanes) {
      F bound = min(dot(normals(k), x) - load(hull_.offset + k), load(bound_ + k));
      bound = select(index == searched, F(-1e30f), bound);
      store(bound_ + k, bound);
      largest.offer(bound, index);
      index = index + F(static_cast<float>(kLanes));
    }
    return largest.index();
  }

  const HullData& hull_;
  const HullData& other_;
  const HullFrame& frame_;
  const HullPair& pair_;
  BestFace best_{};
  alignas(64) float bound_[kPaddedFaces];
};

void add_ends(const HullEdge& edge, const HullFrame& frame, Witnesses& witnesses) {
  const Vec begin = vec(edge.point);
  witnesses.add(frame.place(begin));
  witnesses.add(frame.place(begin + vec(edge.along)));
}

// Start of the search: the side, its face, and known bounds of the other side.
struct Start {
  int side = 0;
  int face = -1;
  Witnesses witnesses;
};
Start start_at(const HullPair& pair, std::uint32_t hint) {
  Start start;
  const std::uint32_t kind = hint & kFeatureKind;
  if (kind == kFeatureFace1 || kind == kFeatureFace2) {
    start.side = kind == kFeatureFace2 ? 1 : 0;
    start.face = at_most(hint & kFeatureIndex, pair.hull[start.side]->face_count);
  } else if (kind == kFeatureEdges) {
    const HullData &first = *pair.hull[0], &second = *pair.hull[1];
    start.face = first.edge[at_most(hint >> kFeatureShift & kFeatureIndex, first.edge_count)].face[0];
    add_ends(second.edge[at_most(hint & kFeatureIndex, second.edge_count)], pair.frame[0], start.witnesses);
  }
  return start;
}

// Up to four corners of the face that bound the gaps of the other hull's faces.
Witnesses corners_for_other(const HullPair& pair, int side, int face) {
  Witnesses witnesses;
  const HullData& hull = *pair.hull[side];
  const int count = corner_count(hull, face), used = count < 4 ? count : 4;
  for (int k = 0; k < used; ++k) {
    const int corner = hull.loop[hull.loop_begin[face] + k * count / used];
    witnesses.add(pair.frame[1 - side].place(vertex(hull, corner)));
  }
  return witnesses;
}

void decide(const HullPair& pair, int side, const BestFace& best, Decision& decision) {
  const Vec n = normal(*pair.hull[side], best.face);
  decision.separation = best.separation;
  decision.side = side;
  decision.face = best.face;
  decision.support = best.support;
  decision.axis = side == 0 ? n : -pair.frame[0].turn(n);
  decision.feature = (side == 0 ? kFeatureFace1 : kFeatureFace2) | static_cast<std::uint32_t>(best.face);
}

}  // namespace

bool may_beat(const HullPair& pair, const int edge[2], float floor) {
  for (int side = 0; side < 2; ++side) {
    Witnesses witnesses;
    add_ends(pair.hull[1 - side]->edge[edge[1 - side]], pair.frame[side], witnesses);
    if (FaceSearch(pair, side).run(-1, witnesses, floor).face >= 0) return true;
  }
  return false;
}

bool query_faces(const HullPair& pair, std::uint32_t hint, Decision& decision) {
  const Start start = start_at(pair, hint);
  const int side = start.side;
  const BestFace one = FaceSearch(pair, side).run(start.face, start.witnesses, -1e30f);
  decide(pair, side, one, decision);
  if (one.separation > pair.reach) return false;
  // A face of the second hull must win by the tolerance.
  const float floor =
      side == 0 ? one.separation + pair.tolerance : one.separation - pair.tolerance - pair.rounding;
  const BestFace other = FaceSearch(pair, 1 - side).run(-1, corners_for_other(pair, side, one.face), floor);
  if (other.face < 0) return true;
  if (side == 1 && one.separation > other.separation + pair.tolerance) return true;
  decide(pair, 1 - side, other, decision);
  return other.separation <= pair.reach;
}

FacePair pair_faces(const HullPair& pair, const Decision& decision) {
  constexpr float kPlaneShare = 1e-4f;  // of the radius; how far corners may lie off their face's plane
  const HullData &deciding = *pair.hull[decision.side], &hull = *pair.hull[1 - decision.side];
  const Vec axis = normal(deciding, decision.face);
  const Vec against = pair.frame[decision.side].turn_back(-axis);
  const V3 direction = wide(against), support = wide(vertex(hull, decision.support));
  const F least(-kPlaneShare * hull.outer_radius - pair.rounding);
  Largest facing_most;
  F index = first_indices();
  for (int k = 0; k < hull.padded_faces; k += kLanes) {
    const V3 n{load(hull.normal[0] + k), load(hull.normal[1] + k), load(hull.normal[2] + k)};
    const M at_support = dot(n, support) - load(hull.offset + k) > least;
    facing_most.offer(select(at_support, dot(n, direction), F(-1e30f)), index);
    index = index + F(static_cast<float>(kLanes));
  }
  const int incident = facing_most.index();
  return {decision.side,
          decision.face,
          incident >= 0 ? incident : 0,
          axis,
          deciding.offset[decision.face],
          false,
          {}};
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
