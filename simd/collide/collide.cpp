// Makes the table of collide kernels, and writes the rare part of a contact (restitution, rolling, moving
// surfaces).
#include <simd/collide/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void collide_sphere_sphere(const CollideColumns& columns, const CollideItem* items, int count);
void collide_sphere_capsule(const CollideColumns& columns, const CollideItem* items, int count);
void collide_sphere_box(const CollideColumns& columns, const CollideItem* items, int count);
void collide_capsule_capsule(const CollideColumns& columns, const CollideItem* items, int count);
void collide_capsule_box(const CollideColumns& columns, const CollideItem* items, int count);
void collide_box_box(const CollideColumns& columns, const CollideItem* items, int count);
void collide_sphere_hull(const CollideColumns& columns, const CollideItem* items, int count);
void collide_capsule_hull(const CollideColumns& columns, const CollideItem* items, int count);
void collide_box_hull(const CollideColumns& columns, const CollideItem* items, int count);
void collide_hull_hull(const CollideColumns& columns, const CollideItem* items, int count);
void collide_sphere_half_space(const CollideColumns& columns, const CollideItem* items, int count);
void collide_capsule_half_space(const CollideColumns& columns, const CollideItem* items, int count);
void collide_box_half_space(const CollideColumns& columns, const CollideItem* items, int count);
void collide_hull_half_space(const CollideColumns& columns, const CollideItem* items, int count);
void collide_smooth(const CollideColumns& columns, const CollideItem* items, int count);
void collide_smooth_half_space(const CollideColumns& columns, const CollideItem* items, int count);
int recycle_boxes(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left);
int recycle_hulls(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left);
int recycle_capsules(const CollideColumns& columns, const CollideItem* items, int count, CollideItem* left);
void follow_mesh_manifolds(const CollideColumns& columns, const CollideItem* items, int count,
                           FollowedManifold* followed);
bool collide_meshes(const MeshTask& task);
void store_mesh_manifolds(const CollideColumns& columns, const CollideItem* items, const MeshManifold* found,
                          int count, std::int32_t first_type);

CollideKernels make_collide_kernels() {
  CollideKernels kernels{};
  kernels.collide[kSphereSphere] = collide_sphere_sphere;
  kernels.collide[kSphereCapsule] = collide_sphere_capsule;
  kernels.collide[kSphereBox] = collide_sphere_box;
  kernels.collide[kCapsuleCapsule] = collide_capsule_capsule;
  kernels.collide[kCapsuleBox] = collide_capsule_box;
  kernels.collide[kBoxBox] = collide_box_box;
  kernels.collide[kSphereHull] = collide_sphere_hull;
  kernels.collide[kCapsuleHull] = collide_capsule_hull;
  kernels.collide[kBoxHull] = collide_box_hull;
  kernels.collide[kHullHull] = collide_hull_hull;
  kernels.collide[kSphereHalfSpace] = collide_sphere_half_space;
  kernels.collide[kCapsuleHalfSpace] = collide_capsule_half_space;
  kernels.collide[kBoxHalfSpace] = collide_box_half_space;
  kernels.collide[kHullHalfSpace] = collide_hull_half_space;
  kernels.collide[kSmooth] = collide_smooth;
  kernels.collide[kSmoothHalfSpace] = collide_smooth_half_space;
  kernels.recycle_boxes = recycle_boxes;
  kernels.recycle_hulls = recycle_hulls;
  kernels.recycle_capsules = recycle_capsules;
  kernels.follow_mesh_manifolds = follow_mesh_manifolds;
  kernels.collide_meshes = collide_meshes;
  kernels.store_mesh_manifolds = store_mesh_manifolds;
  return kernels;
}

namespace {

// Computes v + 2 r x (r x v + w v) for the unit quaternion q = (r, w).
void rotate_in_place(const float q[4], float v[3]) {
  const float tx = 2.0f * (q[1] * v[2] - q[2] * v[1]);
  const float ty = 2.0f * (q[2] * v[0] - q[0] * v[2]);
  const float tz = 2.0f * (q[0] * v[1] - q[1] * v[0]);
  const float x = v[0] + q[3] * tx + (q[1] * tz - q[2] * ty);
  const float y = v[1] + q[3] * ty + (q[2] * tx - q[0] * tz);
  const float z = v[2] + q[3] * tz + (q[0] * ty - q[1] * tx);
  v[0] = x;
  v[1] = y;
  v[2] = z;
}

}  // namespace

void store_rich_surface(const CollideColumns& columns, const CollideItem& item, float restitution,
                        float rolling_resistance, bool keep_rolling) {
  float speed[2][3];
  const std::int32_t shapes[2] = {item.shape_1, item.shape_2};
  for (int side = 0; side < 2; ++side) {
    for (int k = 0; k < 3; ++k) speed[side][k] = columns.shape_material[shapes[side]].surface_velocity[k];
    rotate_in_place(columns.shape_pose[shapes[side]].rotation, speed[side]);
  }
  const int a = (item.flags & kItemFlip) != 0 ? 1 : 0;
  const float* normal = columns.manifold[item.row].normal;
  float relative[3];
  for (int k = 0; k < 3; ++k) relative[k] = speed[1 - a][k] - speed[a][k];
  const float along = relative[0] * normal[0] + relative[1] * normal[1] + relative[2] * normal[2];
  ContactSurface& surface = columns.surface[item.row];
  for (int k = 0; k < 3; ++k) {
    surface.surface_velocity[k] = relative[k] - along * normal[k];
    if (!keep_rolling) surface.rolling_impulse[k] = 0.0f;
  }
  surface.restitution = restitution;
  surface.rolling_resistance = rolling_resistance;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
