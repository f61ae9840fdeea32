// Cylinders, cones, rounded boxes and rounded hulls against each other and all other convex shapes: one pair
// after the other, by the stages in collide_smooth.h. Lanes only load and store, so that the bits are those
// of scalar code.
#include <simd/collide/collide_smooth.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The normal of the pair's last manifold, from the first shape to the second. False: there is none.
bool last_normal(const CollideColumns& columns, const CollideItem& item, D3& normal) {
  if ((item.flags & kItemKnown) == 0) return false;
  const Manifold& manifold = columns.manifold[item.row];
  if ((manifold.info & kManifoldPointMask) == 0) return false;
  const D3 stored = to_d3(manifold.normal);
  const double squared = dot(stored, stored);
  if (!(squared > 0.5 && squared < 2.0)) return false;
  normal = ((item.flags & kItemFlip) != 0 ? -1.0 : 1.0) / root(squared) * stored;
  return true;
}

bool collide_pair(const CollideColumns& columns, const CollideItem& item, double reach,
                  SmoothContact& contact) {
  const float(&origin)[3] = columns.shape_pose[item.shape_1].position;
  const D3 offset = to_d3(columns.shape_pose[item.shape_2].position) - to_d3(origin);
  Core a, b;
  if (!make_core(columns, item.shape_1, {0.0, 0.0, 0.0}, a)) return false;
  if (!make_core(columns, item.shape_2, offset, b)) return false;
  const double most = a.size + b.size + reach;
  if (!(dot(offset, offset) <= most * most)) return false;
  D3 known;
  const bool is_known = last_normal(columns, item, known);
  Gap gap;
  if (!find_gap(a, b, is_known ? &known : nullptr, reach, gap)) return false;
  find_points(a, b, gap, reach, motion_of(columns, item.body_1, item.body_2, origin, a, b), contact);
  return contact.count > 0;
}

}  // namespace

void SmoothStore::put(int item, const SmoothContact& contact) {
  which_[count_] = item;
  waiting_[count_++] = contact;
  if (count_ == kLanes) flush();
}

void SmoothStore::flush() {
  if (count_ == 0) return;
  alignas(64) std::int32_t which[kLanes];
  alignas(64) float normal[3][kLanes], point[kMaxManifoldPoints][3][kLanes];
  alignas(64) float separation[kMaxManifoldPoints][kLanes], radius[3][kLanes], at_edges[kLanes],
      in_strip[kLanes];
  alignas(64) std::int32_t id[kMaxManifoldPoints][kLanes];
  const auto put3 = [](float(&to)[3][kLanes], int lane, D3 v) {
    to[0][lane] = static_cast<float>(v.x);
    to[1][lane] = static_cast<float>(v.y);
    to[2][lane] = static_cast<float>(v.z);
  };
  for (int lane = 0; lane < kLanes; ++lane) {
    const int from = lane < count_ ? lane : count_ - 1;
    const SmoothContact& contact = waiting_[from];
    which[lane] = which_[from];
    put3(normal, lane, contact.normal);
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      const bool exists = k < contact.count;
      put3(point[k], lane, exists ? contact.point[k] : D3{0.0, 0.0, 0.0});
      separation[k][lane] = exists ? static_cast<float>(contact.separation[k]) : kAbsentSeparation;
      id[k][lane] = exists ? static_cast<std::int32_t>(contact.id[k]) : 0;
    }
    radius[0][lane] = static_cast<float>(contact.core_1);
    radius[1][lane] = static_cast<float>(contact.core_2);
    radius[2][lane] = static_cast<float>(contact.curvature_radius);
    at_edges[lane] = contact.at_edges ? 1.0f : 0.0f;
    in_strip[lane] = contact.in_strip ? 1.0f : 0.0f;
  }
  Block block;
  load_block(items_, which, count_, block);
  const WidePair pair = load_pair(columns_, block);
  const auto load3 = [](const float(&from)[3][kLanes]) {
    return V3{load(from[0]), load(from[1]), load(from[2])};
  };
  WideContact<kMaxManifoldPoints> contact;
  contact.normal = load3(normal);
  for (int k = 0; k < kMaxManifoldPoints; ++k) {
    contact.point[k] = load3(point[k]);
    contact.separation[k] = load(separation[k]);
    contact.id[k] = load(id[k]);
  }
  contact.radius_1 = load(radius[0]);
  contact.radius_2 = load(radius[1]);
  contact.curvature_radius = load(radius[2]);
  contact.in_strip = load(in_strip) > F(0.0f);
  contact.at_edges = load(at_edges) > F(0.0f);
  store_contacts<kMaxManifoldPoints, true>(columns_, items_, which, block, pair.first.position, pair.reach,
                                           contact);
  count_ = 0;
}

void collide_smooth(const CollideColumns& columns, const CollideItem* items, int count) {
  collide_smooth_pairs(columns, items, count, collide_pair);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
