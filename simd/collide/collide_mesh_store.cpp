// Manifolds with meshes -> rows of contacts: as those of any other pair, but that the surface is that of the
// triangles.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// The two shapes of each manifold in rows of their own, the mesh with the triangles' material.
struct Shapes {
  PoseRow pose[2 * kCollideChunk];
  ExtentRow extent[2 * kCollideChunk];
  MaterialRow material[2 * kCollideChunk];
  CollideItem item[kCollideChunk];
};

void copy_shapes(const CollideColumns& columns, const CollideItem* items, const MeshManifold* found,
                 int count, Shapes& to) {
  for (int i = 0; i < count; ++i) {
    const std::int32_t shapes[2] = {items[i].shape_1, items[i].shape_2};
    for (int side = 0; side < 2; ++side) {
      to.pose[2 * i + side] = columns.shape_pose[shapes[side]];
      to.extent[2 * i + side] = columns.shape_extent[shapes[side]];
      to.material[2 * i + side] = columns.shape_material[shapes[side]];
    }
    if (found[i].material != kShapeMaterial) {
      const MeshData& mesh = *columns.meshes[columns.shape_mesh[items[i].shape_2]];
      to.material[2 * i + 1] = mesh.materials[found[i].material];
    }
    to.item[i] = items[i];
    to.item[i].shape_1 = 2 * i;
    to.item[i].shape_2 = 2 * i + 1;
    to.item[i].row = found[i].row;
  }
}

template <int kPoints>
void store_block(const CollideColumns& columns, const CollideItem* items, const MeshManifold* found,
                 const std::int32_t* which, int lanes) {
  Block block;
  load_block(items, which, lanes, block);
  const WidePair pair = load_pair(columns, block);
  alignas(64) float normal[3][kLanes], point[kPoints][3][kLanes], separation[kPoints][kLanes];
  alignas(64) std::int32_t id[kPoints][kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const TriangleContact& from = found[which[lane]].contact;
    for (int axis = 0; axis < 3; ++axis) normal[axis][lane] = from.normal[axis];
    for (int k = 0; k < kPoints; ++k) {
      for (int axis = 0; axis < 3; ++axis) point[k][axis][lane] = from.point[k][axis];
      separation[k][lane] = from.separation[k];
      id[k][lane] = static_cast<std::int32_t>(from.id[k]);
    }
  }
  const auto turn = [&](const float(&v)[3][kLanes]) {
    return rotate(pair.first.rotation, {load(v[0]), load(v[1]), load(v[2])});
  };
  WideContact<kPoints> contact;
  contact.normal = turn(normal);
  for (int k = 0; k < kPoints; ++k) {
    contact.point[k] = turn(point[k]);
    contact.separation[k] = load(separation[k]);
    contact.id[k] = load(id[k]);
  }
  if constexpr (kPoints < kMaxManifoldPoints) {
    set_radius(contact, pair.extent_1.radius);
  } else {
    contact.in_strip = contact.at_edges = never();  // seams do not stop what slides over them
  }
  store_contacts(columns, items, which, block, pair.first.position, pair.reach, contact);
}

}  // namespace

void store_mesh_manifolds(const CollideColumns& columns, const CollideItem* items, const MeshManifold* found,
                          int count, std::int32_t first_type) {
  Shapes shapes;
  copy_shapes(columns, items, found, count, shapes);
  CollideColumns own = columns;
  own.shape_pose = shapes.pose;
  own.shape_extent = shapes.extent;
  own.shape_material = shapes.material;
  own.shape_hull = nullptr;
  if (first_type == kMeshSmooth) {
    store_smooth_mesh_manifolds(columns, items, found, count, own, shapes.item);
    return;
  }
  for (int begin = 0; begin < count; begin += kLanes) {
    const int lanes = count - begin < kLanes ? count - begin : kLanes;
    alignas(64) std::int32_t which[kLanes];
    number_lanes(begin, lanes, which);
    if (first_type == kMeshSphere) {
      store_block<1>(own, shapes.item, found, which, lanes);
    } else if (first_type == kMeshCapsule) {
      store_block<2>(own, shapes.item, found, which, lanes);
    } else {
      store_block<4>(own, shapes.item, found, which, lanes);
    }
  }
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
