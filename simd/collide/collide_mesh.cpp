// Convex shapes against triangle meshes: finds the triangles near the shape, and has them tested in lanes.
//
// The mesh's tree is walked with the box around the shape, 16 children at once. Of the triangles of a leaf,
// again 16 at once, those are left out whose boxes or planes are out of reach, and those that the shape's
// origin lies behind. The others fill the lanes. Contacts come in the order of the triangles, whatever the
// number of lanes. Merging them to few manifolds is done by parallel/narrow_phase/mesh_manifolds.cpp;
// store_mesh_manifolds then writes these into the rows of contacts.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Of boxes: they are made with a few roundings.
constexpr float kBoxSlack = 1e-6f;

int touch(std::int32_t type, const MeshPair& pair, const TriangleBatch& batch, TriangleContact* out) {
  switch (type) {
    case kMeshSphere:
      return touch_sphere(pair, batch, out);
    case kMeshCapsule:
      return touch_capsule(pair, batch, out);
    default:
      return touch_polytope(pair, batch, out);
  }
}

// Of `type` MeshFirstType. A box's hull is `box`, made here.
void make_pair(const CollideColumns& columns, const CollideItem& item, std::int32_t type, BoxHull& box,
               MeshPair& pair) {
  alignas(64) std::int32_t which[kLanes]{}, slot[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) slot[lane] = lane == 0 ? 0 : 1;
  Block block;
  load_block(&item, which, 1, block);
  HullPair frames[2];
  store_frames(load_pair(columns, block), frames, slot);
  pair.hulls = frames[0];
  pair.mesh = columns.meshes[columns.shape_mesh[item.shape_2]];
  const ExtentRow& extent = columns.shape_extent[item.shape_1];
  for (int axis = 0; axis < 3; ++axis) pair.extent[axis] = extent.half[axis];
  pair.radius = extent.radius;
  pair.hulls.hull[0] = pair.hulls.hull[1] = nullptr;
  Vec half = vec(extent.half);
  switch (type) {
    case kMeshSphere:
      half = {0.0f, 0.0f, 0.0f};
      pair.outer_radius = extent.radius;
      break;
    case kMeshCapsule:
      pair.outer_radius = extent.half[1] + extent.radius;
      break;
    case kMeshBox:
      box.set_faces(extent.half);
      box.set_edges();
      pair.hulls.hull[0] = &box.hull;
      pair.outer_radius = box.hull.outer_radius;
      break;
    default:
      pair.hulls.hull[0] = columns.hulls[columns.shape_hull[item.shape_1]];
      pair.outer_radius = pair.hulls.hull[0]->outer_radius;
      break;
  }
  const bool is_round = type == kMeshSphere || type == kMeshCapsule;
  const HullFrame& frame = pair.hulls.frame[1];
  for (int axis = 0; axis < 3; ++axis) {
    const HullFrame::Row& row = frame.row[axis];
    float reach = size(row.axis.x) * half.x + size(row.axis.y) * half.y + size(row.axis.z) * half.z;
    if (is_round) reach += extent.radius;
    reach += pair.hulls.reach + kBoxSlack * (reach + size(row.center));
    pair.lower[axis] = row.center - reach;
    pair.upper[axis] = row.center + reach;
  }
}

// Lanes: children of a block, from `first` on.
std::uint32_t boxes_met(const MeshPair& pair, const float (&bounds)[6][kTreeBlock], int first) {
  M met = (F(pair.lower[0]) <= load(&bounds[3][first])) & (load(&bounds[0][first]) <= F(pair.upper[0]));
  for (int axis = 1; axis < 3; ++axis) {
    met = met & (F(pair.lower[axis]) <= load(&bounds[axis + 3][first])) &
          (load(&bounds[axis][first]) <= F(pair.upper[axis]));
  }
  return bits(met);
}
std::uint32_t children_met(const MeshPair& pair, const NodeBlock& node) {
  std::uint32_t met = 0;
  for (int first = 0; first < kTreeBlock; first += kLanes) {
    met |= boxes_met(pair, node.bounds, first) << first;
  }
  return met;
}

// The triangles of a leaf, in columns.
struct Leaf {
  alignas(64) float corner[3][3][kTreeBlock];
};
void load_leaf(const MeshData& mesh, std::int32_t leaf, Leaf& to) {
  const MeshCorners* const corners = mesh.corners + std::ptrdiff_t{leaf} * kTreeBlock;
  for (int lane = 0; lane < kTreeBlock; ++lane) {
    for (int k = 0; k < 3; ++k) {
      const float* vertex = mesh.vertex + std::ptrdiff_t{3} * corners[lane].vertex[k];
      for (int axis = 0; axis < 3; ++axis) to.corner[k][axis][lane] = vertex[axis];
    }
  }
}

// Lanes: triangles of the leaf, from `first` on, whose boxes and planes are within reach, and that face the
// shape's origin.
std::uint32_t triangles_met(const MeshPair& pair, const Leaf& leaf, int first) {
  V3 corner[3];
  for (int k = 0; k < 3; ++k) {
    corner[k] = {load(&leaf.corner[k][0][first]), load(&leaf.corner[k][1][first]),
                 load(&leaf.corner[k][2][first])};
  }
  const auto meets = [&](F a, F b, F c, int axis) {
    return (F(pair.lower[axis]) <= max(a, max(b, c))) & (min(a, min(b, c)) <= F(pair.upper[axis]));
  };
  const M met = meets(corner[0].x, corner[1].x, corner[2].x, 0) &
                meets(corner[0].y, corner[1].y, corner[2].y, 1) &
                meets(corner[0].z, corner[1].z, corner[2].z, 2);
  const V3 across = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const F height = dot(across, wide(pair.hulls.frame[1].center()) - corner[0]);
  const F limit = F(pair.outer_radius + pair.hulls.reach) * length(across);
  return bits(met & (height >= F(0.0f)) & (height <= limit));
}

void put_triangle(const MeshData& mesh, const Leaf& leaf, int lane, std::int32_t triangle,
                  TriangleBatch& batch) {
  const int to = batch.count++;
  for (int k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) batch.corner[k][axis][to] = leaf.corner[k][axis][lane];
    const EdgeTurn& turn = mesh.turns[triangle].edge[k];
    constexpr float kUnit = 1.0f / kTurnUnit;
    batch.cosine[k][to] = kUnit * static_cast<float>(turn.cosine);
    batch.sine[k][to] = kUnit * static_cast<float>(turn.sine);
  }
  batch.triangle[to] = triangle;
}

void fill_up(TriangleBatch& batch) {
  if constexpr (kLanes > 1) {
    const int last = batch.count - 1;
    for (int to = batch.count; to < kLanes; ++to) {
      for (int k = 0; k < 3; ++k) {
        for (auto& axis : batch.corner[k]) axis[to] = axis[last];
        batch.cosine[k][to] = batch.cosine[k][last];
        batch.sine[k][to] = batch.sine[k][last];
      }
      batch.triangle[to] = batch.triangle[last];
    }
  }
}

// A walk through the tree that may be stopped behind a leaf, and goes on there later.
class Walk {
 public:
  Walk(const MeshPair& pair, std::int32_t type, const MeshTask& task, MeshState& state)
      : pair_(pair), type_(type), task_(task), state_(state) {}

  // False: stopped for lack of room.
  bool visit(int level, std::int32_t block) {
    const int shift = 4 * level;  // a child spans 16^level leaves
    for (std::uint32_t met = children_met(pair_, pair_.mesh->nodes[level][block]); met != 0; met &= met - 1) {
      const std::int32_t child = block * kTreeBlock + __builtin_ctz(met);
      if (((child + std::int64_t{1}) << shift) <= state_.next_leaf) continue;
      if (level > 0 ? !visit(level - 1, child) : !visit_leaf(child)) return false;
    }
    return true;
  }
  void flush() {
    if (batch_.count == 0) return;
    fill_up(batch_);
    state_.count += touch(type_, pair_, batch_, task_.contacts + state_.count);
    batch_.count = 0;
  }

 private:
  bool visit_leaf(std::int32_t leaf) {
    // Room for what waits and for all of the leaf.
    if (state_.count + kLanes + kTreeBlock > task_.capacity) {
      flush();
      if (state_.count + kLanes + kTreeBlock > task_.capacity) return false;
    }
    Leaf columns;
    load_leaf(*pair_.mesh, leaf, columns);
    const std::int32_t begin = leaf * kTreeBlock;
    const std::int32_t left = pair_.mesh->triangle_count - begin;
    std::uint32_t met = 0;
    for (int first = 0; first < kTreeBlock; first += kLanes) {
      met |= triangles_met(pair_, columns, first) << first;
    }
    if (left < kTreeBlock) met &= (1u << left) - 1u;
    for (; met != 0; met &= met - 1) {
      const int lane = __builtin_ctz(met);
      put_triangle(*pair_.mesh, columns, lane, begin + lane, batch_);
      if (batch_.count == kLanes) flush();
    }
    state_.next_leaf = leaf + 1;
    return true;
  }

  const MeshPair& pair_;
  std::int32_t type_;
  const MeshTask& task_;
  MeshState& state_;
  TriangleBatch batch_;
};

}  // namespace

WideTriangles place_triangles(const MeshPair& pair, const TriangleBatch& batch) {
  V3 corner[3], along[3];
  for (int k = 0; k < 3; ++k) {
    corner[k] = {load(batch.corner[k][0]), load(batch.corner[k][1]), load(batch.corner[k][2])};
  }
  for (int k = 0; k < 3; ++k) along[k] = corner[(k + 1) % 3] - corner[k];
  // In the mesh's frame, where a flat mesh along its axes has exact normals.
  const V3 across = cross(along[0], -along[2]);
  const V3 normal = across * (F(1.0f) / sqrt(max(length_squared(across), F(1e-37f))));
  const HullFrame& frame = pair.hulls.frame[0];
  const V3 row[3] = {wide(frame.row[0].axis), wide(frame.row[1].axis), wide(frame.row[2].axis)};
  const auto turn = [&](V3 v) { return V3{dot(row[0], v), dot(row[1], v), dot(row[2], v)}; };
  const V3 center = wide(frame.center());
  WideTriangles t;
  t.normal = turn(normal);
  for (int k = 0; k < 3; ++k) {
    const V3 outward = cross(along[k], normal) * (F(1.0f) / sqrt(max(length_squared(along[k]), F(1e-37f))));
    const F cosine = load(batch.cosine[k]);
    t.ridge[k] = load(batch.sine[k]);
    t.corner[k] = turn(corner[k]) + center;
    t.along[k] = turn(along[k]);
    t.outward[k] = turn(outward);
    t.behind[k] = turn(cosine * outward - t.ridge[k] * normal);
  }
  return t;
}

int put_touches(const TriangleBatch& batch, const WideTouch& touch, TriangleContact* out) {
  alignas(64) float normal[3][kLanes], point[2][3][kLanes], separation[2][kLanes];
  alignas(64) std::int32_t id[2][kLanes];
  const auto write = [](float(&to)[3][kLanes], V3 v) {
    store(to[0], v.x);
    store(to[1], v.y);
    store(to[2], v.z);
  };
  write(normal, touch.normal);
  for (int k = 0; k < 2; ++k) {
    write(point[k], touch.point[k]);
    store(separation[k], touch.separation[k]);
    store(id[k], touch.id[k]);
  }
  const std::uint32_t touching = bits(touch.touches);
  int count = 0;
  for (int lane = 0; lane < batch.count; ++lane) {
    if ((touching >> lane & 1u) == 0) continue;
    TriangleContact& contact = out[count++];
    contact = {};
    contact.triangle = batch.triangle[lane];
    for (int axis = 0; axis < 3; ++axis) contact.normal[axis] = normal[axis][lane];
    for (int k = 0; k < kMaxManifoldPoints; ++k) {
      contact.separation[k] = kAbsentSeparation;
      if (k >= 2 || id[k][lane] == 0) continue;
      for (int axis = 0; axis < 3; ++axis) contact.point[k][axis] = point[k][axis][lane];
      contact.separation[k] = separation[k][lane];
      contact.id[k] = static_cast<std::uint32_t>(id[k][lane]);
    }
  }
  return count;
}

bool collide_mesh(const MeshTask& task, MeshState& state) {
  BoxHull box;
  MeshPair pair;
  make_pair(task.columns, task.item, task.first_type, box, pair);
  Walk walk(pair, task.first_type, task, state);
  const bool finished = walk.visit(pair.mesh->levels - 1, 0);
  walk.flush();
  return finished;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
