// Smooth and rounded shapes against half-spaces: the features that face the plane most, and the heights of
// their corners. The half-space is the second shape, all that lies below the plane y = 0 of its frame; see
// collide_half_space.cpp.
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Heights are above the plane.
void list_candidates(const Core& core, const Feature& feature, D3 normal, double plane, double tolerance,
                     SmoothCandidates& candidates) {
  const Tangents tangents = tangents_of(normal);
  double deepest = 1e300;
  const auto put = [&](D3 p, std::uint32_t id) {
    const double height = dot(normal, p) + core.margin, separation = plane - height;
    deepest = lesser_of(separation, deepest);
    candidates.of[candidates.count++] = {dot(tangents.u, p), dot(tangents.v, p), 0.5 * (height + plane),
                                         separation, id};
  };
  for (int k = 0; k < feature.count; ++k) {
    put(feature.point[k], kOfFirst | static_cast<std::uint32_t>(feature.name[k]) << 8);
  }
  // A steep face may miss the lowest corner.
  const D3 lowest = farthest_point(core, normal);
  if (plane - dot(normal, lowest) - core.margin < deepest - tolerance) put(lowest, kOfSearch);
}

bool collide_pair(const CollideColumns& columns, const CollideItem& item, double reach,
                  SmoothContact& contact) {
  const PoseRow &shape = columns.shape_pose[item.shape_1], &ground = columns.shape_pose[item.shape_2];
  const D3 offset = to_d3(ground.position) - to_d3(shape.position);
  Core core, plane_frame;
  if (!make_core(columns, item.shape_1, {0.0, 0.0, 0.0}, core)) return false;
  if (!make_frame(ground, offset, plane_frame)) return false;
  const D3 normal = -plane_frame.axis[1];
  const double plane = dot(normal, offset);
  const double lowest = dot(normal, farthest_point(core, normal)) + core.margin;
  if (!(plane - lowest <= reach)) return false;
  Feature feature;
  find_feature(core, normal, {lean_of(core, normal), false, normal}, feature);
  const double tolerance = lesser_of(double{kFeatureTolerance}, double{kFeatureShare} * core.thinness);
  SmoothCandidates candidates;
  list_candidates(core, feature, normal, plane, tolerance, candidates);
  const double nearest = plane - lowest + tolerance;
  const PairMotion motion = motion_of(columns, item.body_1, item.body_2, shape.position, core, plane_frame);
  const bool keeps_all = feature.count > 2 && !feature.is_rim;
  if (!keeps_all) {
    drop_far(motion, normal, tangents_of(normal), feature.is_rim ? 0.0 : reach, nearest, candidates);
  }
  if (feature.is_disk) {
    choose_steady(candidates, true, false, false, normal, tolerance, contact);
  } else {
    choose_points(candidates, normal, tolerance, tolerance, contact);
  }
  const Roundness round = find_roundness(core, feature, contact, 1.0, motion.body[0].whole_angular);
  contact.core_1 = round.core;
  contact.core_2 = 0.0;
  contact.curvature_radius = round.curvature;
  contact.at_edges = contact.in_strip = false;
  return contact.count > 0;
}

}  // namespace

void collide_smooth_half_space(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_smooth_pairs(columns, items, count, collide_pair);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
