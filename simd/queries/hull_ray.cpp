// Rays against hulls: lane = face. Single precision tells which part of a ray may lie in the hull and which
// faces may cut that part; whoever asks cuts it by these in double precision.
#include <simd/queries/query_kernels.h>
#include <simd/wide/wide.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

// With d the distance of the stretch's beginning from a face's plane, less the margin, and s the distance by
// which the stretch rises over it, the point at the fraction t lies before the plane where d + s t > 0. A
// face may cut what is left of the stretch if an end of that lies no farther behind its plane than the
// margin.
int cut_hull(const HullData& hull, const HullStretch& stretch, std::int32_t* faces);
int cut_hull(const HullData& hull, const HullStretch& stretch, std::int32_t* faces) {
  const F zero(0.0f), one(1.0f), margin(stretch.margin);
  F base[3], way[3];
  for (int axis = 0; axis < 3; ++axis) {
    base[axis] = F(stretch.base[axis]);
    way[axis] = F(stretch.way[axis]);
  }
  const auto distances = [&](int face) {
    return load(&hull.normal[0][face]) * base[0] + load(&hull.normal[1][face]) * base[1] +
           load(&hull.normal[2][face]) * base[2] - load(&hull.offset[face]);
  };
  const auto rises = [&](int face) {
    return load(&hull.normal[0][face]) * way[0] + load(&hull.normal[1][face]) * way[1] +
           load(&hull.normal[2][face]) * way[2];
  };
  F enters = zero, leaves = one;
  for (int face = 0; face < hull.face_count; face += kLanes) {
    const F distance = distances(face) - margin, rise = rises(face);
    const M falls = (rise < zero);
    const M climbs = (rise > zero);
    const F crosses = select(falls | climbs, (zero - distance) / select(falls | climbs, rise, one), zero);
    enters = max(enters, select(falls, crosses, zero));
    // What stays before a plane never enters.
    leaves = min(leaves, select(climbs, crosses, select((!falls) & (distance > zero), F(-1.0f), one)));
  }
  const F begin(reduce_max(enters)), end(reduce_min(leaves));
  if (bits(begin <= end) == 0) return -1;
  int count = 0;
  for (int face = 0; face < hull.face_count; face += kLanes) {
    const F distance = distances(face), rise = rises(face);
    std::uint32_t near = bits(max(distance + begin * rise, distance + end * rise) >= zero - margin);
    for (; near != 0; near &= near - 1) faces[count++] = face + __builtin_ctz(near);
  }
  return count;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
