// Boxes and hulls against triangles of a mesh: the points of contacts, from two faces clipped against each
// other as those of two hulls.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

constexpr std::uint8_t kLoop[6] = {0, 1, 2, 0, 2, 1};
constexpr std::uint16_t kLoopBegin[3] = {0, 3, 6};
// Points this close to a corner of the hull, as a share of its radius, have its name: it stays the same while
// the shape slides from triangle to triangle.
constexpr float kAtCorner = 1e-4f;

constexpr HullFrame kSameFrame{{{{1, 0, 0}, 0}, {{0, 1, 0}, 0}, {{0, 0, 1}, 0}}};

float distance_2(Vec a, Vec b) {
  const Vec apart = a - b;
  return dot(apart, apart);
}

// A contact without points yet.
void begin_contact(const TriangleDecision& decision, TriangleContact& to) {
  to = {};
  to.triangle = decision.triangle;
  to.normal[0] = -decision.axis.x;
  to.normal[1] = -decision.axis.y;
  to.normal[2] = -decision.axis.z;
  for (float& separation : to.separation) separation = kAbsentSeparation;
}

// Copies the points that are within reach. None may be deeper than the overlap along the least axis.
// `corner_at(p)` is the hull's vertex at p, -1: none.
template <class CornerAt>
void take(const HullContact& from, Vec axis, float largest, float reach, CornerAt&& corner_at,
          TriangleContact& to) {
  int count = 0;
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    const bool is_edges = (from.id[k] & kFeatureKind) == kFeatureEdges;
    if (from.id[k] == 0 || (!is_edges && (from.id[k] & kLostNumber) == kLostNumber)) continue;
    const float separation = larger(from.separation[k], largest);
    if (!(separation <= reach)) continue;
    const Vec point = from.point[k];
    to.point[count][0] = point.x;
    to.point[count][1] = point.y;
    to.point[count][2] = point.z;
    to.separation[count] = separation;
    const int corner = corner_at(point + (0.5f * from.separation[k]) * axis);
    to.id[count] =
        corner >= 0 ? 1u + static_cast<std::uint32_t>(corner) : mixed_name(to.triangle, from.id[k]);
    ++count;
  }
  if (count == 0) to.triangle = -1;
}

}  // namespace

TriangleHull::TriangleHull() : hull{}, vertex{}, normal{}, offset{}, edge{} {
  hull.vertex_count = 3;
  hull.edge_count = 3;
  hull.face_count = 2;
  for (int axis = 0; axis < 3; ++axis) {
    hull.vertex[axis] = vertex[axis];
    hull.normal[axis] = normal[axis];
  }
  hull.offset = offset;
  hull.edge = edge;
  hull.loop = kLoop;
  hull.loop_begin = kLoopBegin;
  for (int k = 0; k < 3; ++k) {
    edge[k].vertex[0] = k;
    edge[k].vertex[1] = (k + 1) % 3;
    edge[k].face[1] = 1;
  }
}

void TriangleHull::set(const Vec (&corner)[3], Vec front) {
  for (int k = 0; k < 3; ++k) {
    vertex[0][k] = corner[k].x;
    vertex[1][k] = corner[k].y;
    vertex[2][k] = corner[k].z;
  }
  const float n[3] = {front.x, front.y, front.z};
  for (int axis = 0; axis < 3; ++axis) {
    normal[axis][0] = n[axis];
    normal[axis][1] = -n[axis];
  }
  offset[0] = dot(front, corner[0]);
  offset[1] = -offset[0];
  for (int k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      edge[k].point[axis] = vertex[axis][k];
      edge[k].along[axis] = vertex[axis][(k + 1) % 3] - vertex[axis][k];
      edge[k].normal_0[axis] = n[axis];
      edge[k].normal_1[axis] = -n[axis];
    }
  }
}

MeshClips::MeshClips() : pair_{}, at_corner_(0.0f) {
  pair_.frame[0] = pair_.frame[1] = kSameFrame;
  pair_.hull[1] = &triangle_.hull;
}

void MeshClips::set_pair(const MeshPair& pair) {
  pair_.hull[0] = pair.hulls.hull[0];
  pair_.reach = pair.hulls.reach;
  set_tolerances(pair_);
  pair_.border = smaller(kFeatureTolerance, kFeatureShare * pair_.hull[0]->inner_radius);
  at_corner_ = kAtCorner * pair_.hull[0]->outer_radius;
  is_held_ = has_beside_ = false;
}

void MeshClips::note_beside(const TriangleDecision& decision) {
  if (has_beside_ && !(decision.separation > beside_.separation)) return;
  beside_ = decision;
  has_beside_ = true;
}

int MeshClips::touch_beside(TriangleContact* out) {
  if (is_held_ || !has_beside_) return 0;
  touch(beside_, *out);
  return 1;
}

void MeshClips::touch(const TriangleDecision& decision, TriangleContact& to) {
  begin_contact(decision, to);
  triangle_.set(decision.corner, decision.normal);
  Decision own{};
  own.separation = decision.separation;
  own.axis = -decision.axis;
  switch (decision.decider) {
    case kTriangleDecides:
      own.side = 1;
      own.support = decision.support;
      own.feature = kFeatureFace2;
      clip(decision, own, pair_faces(pair_, own), to);
      break;
    case kFaceDecides:
      own.face = decision.feature;
      own.feature = kFeatureFace1;
      clip(decision, own, {0, own.face, 0, own.axis, pair_.hull[0]->offset[own.face], false, {}}, to);
      break;
    default:
      touch_edges(decision, own, to);
      break;
  }
}

void MeshClips::touch_edges(const TriangleDecision& decision, Decision& own, TriangleContact& to) {
  own.edge[0] = decision.feature >> 2;
  own.edge[1] = decision.feature & 3;
  own.feature = kFeatureEdges | static_cast<std::uint32_t>(own.edge[0]) << kFeatureShift |
                static_cast<std::uint32_t>(own.edge[1]);
  const EdgeCrossing crossing = cross_deciding_edges(pair_, own);
  FacePair faces;
  if (pass_beside(pair_, own, crossing)) {
    to.triangle = -1;
  } else if (pair_edge_faces(pair_, own, crossing, faces) && faces.incident == 0) {
    clip(decision, own, faces, to);
  } else {
    const HullData& hull = *pair_.hull[0];
    const std::int32_t(&ends)[2] = hull.edge[own.edge[0]].vertex;
    HullContact contact;
    touch_crossing(own, crossing, contact);
    const auto corner_at = [&](Vec p) {
      for (const std::int32_t end : ends) {
        if (distance_2(vertex(hull, end), p) <= at_corner_ * at_corner_) return end;
      }
      return -1;
    };
    take(contact, decision.axis, decision.largest, pair_.reach, corner_at, to);
  }
}

void MeshClips::clip(const TriangleDecision& decision, const Decision& own, const FacePair& faces,
                     TriangleContact& to) {
  const HullData& hull = *pair_.hull[0];
  const int face = faces.side == 0 ? faces.face : faces.incident;
  const int corners = corner_count(hull, face);
  const std::uint8_t* const loop = hull.loop + hull.loop_begin[face];
  if (corners > kSmallFace) {
    HullContact contact;
    clip_faces(pair_, own, faces, contact);
    const auto corner_at = [&](Vec p) {
      for (int k = 0; k < corners; ++k) {
        if (distance_2(vertex(hull, loop[k]), p) <= at_corner_ * at_corner_) return static_cast<int>(loop[k]);
      }
      return -1;
    };
    take(contact, decision.axis, decision.largest, pair_.reach, corner_at, to);
    return;
  }
  Waiting& waiting = waiting_[queue_.count];
  waiting = {&to, decision.axis, decision.largest, pair_.reach, at_corner_, faces.side, corners, {}};
  for (int k = 0; k < corners; ++k) waiting.corner[k] = loop[k];
  queue_.put(pair_, own, faces);
  if (queue_.count == kLanes) flush();
}

void MeshClips::flush() {
  const int count = queue_.count;
  if (count == 0) return;
  HullContact contacts[kLanes];
  clip_queue(queue_, contacts);
  for (int lane = 0; lane < count; ++lane) {
    const Waiting& waiting = waiting_[lane];
    const auto& of_hull = waiting.hull_side == 0 ? queue_.deciding : queue_.incident;
    const auto corner_at = [&](Vec p) {
      for (int k = 0; k < waiting.corners; ++k) {
        const Vec corner{of_hull[k][0][lane], of_hull[k][1][lane], of_hull[k][2][lane]};
        if (distance_2(corner, p) <= waiting.at_corner * waiting.at_corner) {
          return static_cast<int>(waiting.corner[k]);
        }
      }
      return -1;
    };
    take(contacts[lane], waiting.axis, waiting.largest, waiting.reach, corner_at, *waiting.to);
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
