// Smooth shapes: the direction along which two overlapping cores come apart by the shortest way.
//
// The depth along a direction n is h(n) = max n . a - min n . b over the points of both cores. Its least is
// looked for in two ways.
//
// From a direction that is nearly right, as that of the last step: the second core is moved out along it, and
// the direction of the closest points there is the better one. Where the cores' difference has a radius of
// curvature R and the depth is D, this brings the error down to D / R of itself, and at a face at once. It
// stays at the same local least, and so does a contact while its bodies jitter.
//
// Where nothing is known, or the overlap is deep: by a polytope within the cores' difference that grows where
// its face nearest to the origin is (G. van den Bergen, "Proximity queries and penetration depth computation
// on 3D game objects", GDC 2001). Every step measures h along a direction, and the least of all counts, so
// that the answer is sound wherever the search ends.
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The shares of the shapes' sizes by which the depth may be off, at the end and before it is refined.
constexpr double kEnough = 1e-7, kRoughly = 1e-3;
constexpr int kMostRefinements = 12;
// How far a core is moved beyond the other one, as shares of the thinner one's half thickness and of the
// depth; and of their sizes, for the sake of rounding.
constexpr double kBeyondThin = 1e-3, kBeyondDepth = 0.02, kBeyondSize = 2e-8;

constexpr int kMostCornersOfPolytope = 80;
constexpr int kMostFaces = 2 * kMostCornersOfPolytope;
// By which share of the sizes a core is made rounder where both are flat.
constexpr double kRoundingShare = 1e-3;
// Below this share of the sizes a difference has no thickness.
constexpr double kFlat = 1e-10;

// A known direction counts as long as it is at most this much deeper than any other.
constexpr double kKnownShare = 0.1;
constexpr double kKnownDepth = 0.5 * double{kLinearSlop};  // m
// An overlap below this share of the thinner shape's half thickness is shallow.
constexpr double kShallowShare = 0.1;
constexpr double kShallowDepth = 2.0 * double{kLinearSlop};  // m

double size_of(const Core& a, const Core& b) { return lesser_of(a.size, b.size); }

// Improves the direction of `gap`, whose separation along it is measured.
void refine(const Core& a, const Core& b, Gap& gap) {
  const double size = size_of(a, b);
  const double beyond_by = kBeyondThin * lesser_of(a.thinness, b.thinness) + kBeyondSize * (a.size + b.size);
  for (int step = 0; step < kMostRefinements; ++step) {
    const double depth = greater_of(-gap.separation, 0.0);
    const D3 shift = (depth * (1.0 + kBeyondDepth) + beyond_by) * gap.normal;
    Core moved = b;
    moved.center = b.center + shift;
    if (b.kind == CoreKind::triangle) {
      for (D3& corner : moved.corner) corner = corner + shift;
    }
    Gap beyond;
    if (find_distance(a, moved, gap.normal, 1e300, beyond) != Nearness::apart) return;
    Gap next{0.0, beyond.normal, {}, {}};
    measure_along(a, b, next);
    next.on_1 = beyond.on_1;
    next.on_2 = beyond.on_2 - shift;
    const double gain = next.separation - gap.separation;
    if (gain > 0.0) gap = next;
    if (gain <= 0.0 && dot(next.normal, gap.normal) > 0.9999) {
      gap.on_1 = next.on_1;
      gap.on_2 = next.on_2;
    }
    if (!(gain > kEnough * size)) return;
  }
}

// Face of a polytope: corners counterclockwise seen from outside, and the faces behind its sides.
struct Face {
  int corner[3];
  int neighbor[3];  // behind the side from corner k to corner k + 1
  D3 normal;
  double distance;
  bool is_alive, is_seen;
};

// A growing polytope within the difference of two cores.
class Polytope {
 public:
  Polytope(const Core& a, const Core& b, double rounding) : a_(a), b_(b), rounding_(rounding) {}

  // False: the difference is flat.
  bool begin();
  // The least depth that is found, at `gap.normal`.
  void grow(double enough, Gap& gap);

 private:
  // The point of the difference a - b that is farthest along a unit direction.
  D3 farthest(D3 along) const {
    return farthest_point(a_, along) - farthest_point(b_, -along) + rounding_ * along;
  }
  void set_plane(Face& face) const;
  bool add(D3 point, int seen);
  bool collect_rim(int face, D3 point);
  int nearest_face() const;

  struct Side {
    int face, side;
  };

  const Core &a_, &b_;
  double rounding_;
  int corners_ = 0, faces_ = 0, rim_count_ = 0;
  double slack_ = 0.0;
  D3 corner_[kMostCornersOfPolytope];
  Face face_[kMostFaces + kMostFaces];
  Side rim_[kMostFaces];
};

D3 unit(D3 v) { return (1.0 / length(v)) * v; }

void Polytope::set_plane(Face& face) const {
  const D3 p = corner_[face.corner[0]];
  const D3 across = cross(corner_[face.corner[1]] - p, corner_[face.corner[2]] - p);
  const double size = length(across);
  // A face without area is never the nearest.
  face.normal = size > 0.0 ? (1.0 / size) * across : D3{0.0, 0.0, 0.0};
  face.distance = size > 0.0 ? dot(face.normal, p) : 1e300;
  face.is_alive = true;
  face.is_seen = false;
}

bool Polytope::begin() {
  const D3 x{1.0, 0.0, 0.0};
  D3 p[4] = {farthest(x), farthest(-x), {}, {}};
  const double size = a_.size + b_.size;
  if (!(length(p[1] - p[0]) > kFlat * size)) return false;
  const Tangents across = tangents_of(unit(p[1] - p[0]));
  double most = 0.0;
  const D3 around[4] = {across.u, -across.u, across.v, -across.v};
  for (const D3& d : around) {
    const D3 q = farthest(d);
    const double height = absolute(dot(d, q - p[0]));
    if (height > most) {
      most = height;
      p[2] = q;
    }
  }
  if (!(most > kFlat * size)) return false;
  const D3 up = cross(p[1] - p[0], p[2] - p[0]);
  if (!(length(up) > 0.0)) return false;
  const D3 n = unit(up);
  const D3 above = farthest(n), below = farthest(-n);
  const double rise = dot(n, above - p[0]), fall = dot(n, p[0] - below);
  if (!(greater_of(rise, fall) > kFlat * size)) return false;
  p[3] = rise >= fall ? above : below;
  if (rise >= fall) {  // the fourth corner lies behind the first three
    const D3 other = p[1];
    p[1] = p[2];
    p[2] = other;
  }
  for (int k = 0; k < 4; ++k) corner_[k] = p[k];
  corners_ = faces_ = 4;
  constexpr int kCorner[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  constexpr int kNeighbor[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int f = 0; f < 4; ++f) {
    for (int k = 0; k < 3; ++k) {
      face_[f].corner[k] = kCorner[f][k];
      face_[f].neighbor[k] = kNeighbor[f][k];
    }
    set_plane(face_[f]);
  }
  slack_ = 1e-13 * size;
  return true;
}

int Polytope::nearest_face() const {
  int best = -1;
  for (int f = 0; f < faces_; ++f) {
    if (!face_[f].is_alive || face_[f].distance >= 1e299) continue;
    if (best < 0 || face_[f].distance < face_[best].distance) best = f;
  }
  return best;
}

// Marks the faces that the point sees, from `face` on, and lists the sides around them in order.
bool Polytope::collect_rim(int face, D3 point) {
  struct Visit {
    int face, first, step;
  };
  Visit stack[kMostFaces];
  int depth = 0;
  face_[face].is_seen = true;
  stack[depth++] = {face, 0, 0};
  rim_count_ = 0;
  while (depth > 0) {
    Visit& top = stack[depth - 1];
    if (top.step == 3) {
      --depth;
      continue;
    }
    const int side = (top.first + top.step++) % 3;
    const int next = face_[top.face].neighbor[side];
    Face& other = face_[next];
    if (other.is_seen) continue;
    int back = 0;
    while (back < 3 && other.neighbor[back] != top.face) ++back;
    if (back == 3) return false;
    if (other.distance < 1e299 && dot(other.normal, point) <= other.distance + slack_) {
      if (rim_count_ == kMostFaces) return false;
      rim_[rim_count_++] = {next, back};
      continue;
    }
    if (depth == kMostFaces) return false;
    other.is_seen = true;
    stack[depth++] = {next, (back + 1) % 3, 0};
  }
  return rim_count_ >= 3;
}

// Replaces the faces that the point sees by those to it. False: no room, or rounding spoils the polytope.
bool Polytope::add(D3 point, int seen) {
  if (corners_ == kMostCornersOfPolytope || !collect_rim(seen, point)) return false;
  if (faces_ + rim_count_ > 2 * kMostFaces) return false;
  const int corner = corners_++, first = faces_;
  corner_[corner] = point;
  for (int k = 0; k < rim_count_; ++k) {
    Face& outer = face_[rim_[k].face];
    const int side = rim_[k].side;
    Face& face = face_[faces_++];
    // Against the outer face's direction.
    face.corner[0] = outer.corner[(side + 1) % 3];
    face.corner[1] = outer.corner[side];
    face.corner[2] = corner;
    face.neighbor[0] = rim_[k].face;
    face.neighbor[1] = first + (k + 1) % rim_count_;
    face.neighbor[2] = first + (k + rim_count_ - 1) % rim_count_;
    outer.neighbor[side] = first + k;
    set_plane(face);
  }
  for (int k = 0; k < rim_count_; ++k) {
    if (face_[first + k].corner[1] != face_[first + (k + 1) % rim_count_].corner[0]) return false;
  }
  int kept = 0;
  for (int f = 0; f < first; ++f) {
    if (face_[f].is_seen) face_[f].is_alive = false;
    kept += face_[f].is_alive ? 1 : 0;
  }
  return kept > 0;
}

void Polytope::grow(double enough, Gap& gap) {
  double least = 1e300;
  for (int step = 0; step < kMostCornersOfPolytope; ++step) {
    const int f = nearest_face();
    if (f < 0) return;
    const D3 normal = face_[f].normal, point = farthest(normal);
    const double depth = dot(normal, point) - rounding_;
    if (depth < least) {
      least = depth;
      gap.normal = normal;
    }
    // No direction has less than the nearest face's distance.
    if (depth + rounding_ - face_[f].distance <= enough || least + rounding_ - face_[f].distance <= enough) {
      return;
    }
    if (!add(point, f)) return;
  }
}

// Without a direction to begin with.
void search_all(const Core& a, const Core& b, Gap& gap) {
  const double size = a.size + b.size;
  gap.normal = {0.0, 1.0, 0.0};
  Polytope polytope(a, b, 0.0);
  if (polytope.begin()) {
    polytope.grow(kRoughly * size_of(a, b), gap);
  } else {
    Polytope rounded(a, b, kRoundingShare * size);
    if (rounded.begin()) rounded.grow(kRoughly * size, gap);
  }
  measure_along(a, b, gap);
  refine(a, b, gap);
}

}  // namespace

// Cores that reach beyond each other along a direction of least depth by a small share of their thickness do
// overlap.
bool is_shallow_overlap(const Core& a, const Core& b, D3 known, Gap& gap) {
  const double most = lesser_of(kShallowDepth, kShallowShare * lesser_of(a.thinness, b.thinness));
  gap.normal = known;
  measure_along(a, b, gap);
  if (!(gap.separation < 0.0 && -gap.separation <= most)) return false;
  refine(a, b, gap);
  return gap.separation < 0.0;
}

void find_depth(const Core& a, const Core& b, const D3* known, Gap& gap) {
  const double thin = lesser_of(a.thinness, b.thinness);
  if (known == nullptr) {
    search_all(a, b, gap);
    return;
  }
  gap.normal = *known;
  measure_along(a, b, gap);
  refine(a, b, gap);
  if (-gap.separation <= lesser_of(kShallowDepth, kShallowShare * thin)) return;
  Gap best;
  search_all(a, b, best);
  const double allowed = kKnownShare * -best.separation + lesser_of(kKnownDepth, kKnownShare * thin);
  if (gap.separation < best.separation - allowed) gap = best;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
