// Convex shapes against triangle meshes: finds the triangles near the shape, and has them tested in lanes.
//
// The mesh's tree is walked with the box around the shape, 16 children at once. Of the triangles of a leaf,
// again 16 at once, those are left out that the shape's own box does not reach along the axes of both frames
// and the triangle's normal, and those that the shape's origin lies behind. The others fill the lanes.
// Contacts come in the order of the triangles, whatever the number of lanes. Merging them to few manifolds is
// done by parallel/narrow_phase/mesh_manifolds.cpp; store_mesh_manifolds then writes these into the rows of
// contacts.
#include <simd/collide/collide_mesh.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

namespace {

// Of boxes: they are made with a few roundings.
constexpr float kBoxSlack = 1e-6f;

int touch(MeshFirstType type, const MeshPair& pair, const TriangleBatch& batch, MeshClips& clips,
          MeshBeside& beside, TriangleContact* out) {
  switch (type) {
    case kMeshSphere:
      return touch_sphere(pair, batch, out);
    case kMeshCapsule:
      return touch_capsule(pair, batch, out);
    case kMeshSmooth:
      return touch_smooth(pair, batch, beside, out);
    default:
      return touch_polytope(pair, batch, clips, out);
  }
}

// Frames and reaches of the items; the last pair is for unused lanes.
void load_frames(const CollideColumns& columns, const CollideItem* items, int count,
                 HullPair (&pairs)[kMeshChunk + 1]) {
  for (int begin = 0; begin < count; begin += kLanes) {
    alignas(64) std::int32_t which[kLanes], slot[kLanes];
    Block block;
    const int lanes = take_block(items, count, begin, which, block);
    for (int lane = 0; lane < kLanes; ++lane) slot[lane] = lane < lanes ? which[lane] : kMeshChunk;
    store_frames(load_pair(columns, block), pairs, slot);
  }
}

// A box's hull is `box`, made here.
void make_pair(const CollideColumns& columns, const CollideItem& item, MeshFirstType type,
               const HullPair& frames, BoxHull& box, MeshPair& pair) {
  pair.hulls = frames;
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
    case kMeshSmooth:
      if (!set_smooth(columns, item, pair)) pair.smooth.size = -1.0;
      if (pair.smooth.kind == CoreKind::box) {
        half = {half.x + extent.radius, half.y + extent.radius, half.z + extent.radius};
      }
      pair.outer_radius = static_cast<float>(pair.smooth.size);
      break;
    default:
      pair.hulls.hull[0] = columns.hulls[columns.shape_hull[item.shape_1]];
      pair.outer_radius = pair.hulls.hull[0]->outer_radius;
      break;
  }
  pair.half[0] = half.x;
  pair.half[1] = half.y;
  pair.half[2] = half.z;
  pair.round_reach = 0.0f;
  pair.is_ball = type == kMeshSphere;
  const bool is_round = type == kMeshSphere || type == kMeshCapsule;
  const HullFrame& frame = pair.hulls.frame[1];
  for (int axis = 0; axis < 3; ++axis) {
    const HullFrame::Row& row = frame.row[axis];
    float reach = size(row.axis.x) * half.x + size(row.axis.y) * half.y + size(row.axis.z) * half.z;
    if (is_round) reach += extent.radius;
    const float slack = kBoxSlack * (reach + size(row.center));
    reach += pair.hulls.reach + slack;
    pair.lower[axis] = row.center - reach;
    pair.upper[axis] = row.center + reach;
    pair.round_reach = larger(slack, pair.round_reach);
  }
  pair.round_reach += pair.hulls.reach + (is_round ? extent.radius : 0.0f);
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

// Lanes: triangles of the leaf, from `first` on.
void load_corners(const MeshData& mesh, std::int32_t leaf, int first, V3 (&corner)[3]) {
  const MeshCorners* const corners = mesh.corners + (std::ptrdiff_t{leaf} * kTreeBlock + first);
  for (int k = 0; k < 3; ++k) {
    load_triples(mesh.vertex, corners->vertex + k, 3, corner[k].x, corner[k].y, corner[k].z);
  }
}

// The corners of a leaf's triangles.
struct Leaf {
  alignas(64) float corner[3][3][kTreeBlock];

  void put(const V3 (&corners)[3], int first) {
    for (int k = 0; k < 3; ++k) {
      store(&corner[k][0][first], corners[k].x);
      store(&corner[k][1][first], corners[k].y);
      store(&corner[k][2][first], corners[k].z);
    }
  }
};

// Triangles that the shape's box may reach, along the axes of both frames and the triangles' normals, and
// that face the shape's origin.
std::uint32_t triangles_met(const MeshPair& pair, const V3 (&corner)[3]) {
  const auto meets = [&](F a, F b, F c, F lower, F upper) {
    return (lower <= max(a, max(b, c))) & (min(a, min(b, c)) <= upper);
  };
  M met = meets(corner[0].x, corner[1].x, corner[2].x, F(pair.lower[0]), F(pair.upper[0])) &
          meets(corner[0].y, corner[1].y, corner[2].y, F(pair.lower[1]), F(pair.upper[1])) &
          meets(corner[0].z, corner[1].z, corner[2].z, F(pair.lower[2]), F(pair.upper[2]));
  if (!any(met)) return 0;
  const V3 across = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const F height = dot(across, wide(pair.hulls.frame[1].center()) - corner[0]);
  const F size = length(across), ball = F(pair.outer_radius + pair.hulls.reach) * size;
  F limit = F(pair.round_reach) * size;
  met = met & (height >= F(0.0f));
  if (pair.is_ball) return bits(met & (height <= ball));  // no other axes tell more
  for (int axis = 0; axis < 3; ++axis) {
    // Column `axis` of the shape's turn: its axis in the mesh's frame.
    const HullFrame::Row& row = pair.hulls.frame[0].row[axis];
    const V3 way = wide(row.axis);
    const F half(pair.half[axis]), reach = half + F(pair.round_reach), center(row.center);
    limit = limit + half * abs(dot(across, way));
    met = met & meets(dot(way, corner[0]) + center, dot(way, corner[1]) + center,
                      dot(way, corner[2]) + center, -reach, reach);
  }
  return bits(met & (height <= min(limit, ball)));
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

// What a visit of the leaf reads: meshes are larger than the caches, and pairs jump about in them. Fetching
// the leaves of the next pair, too, gained nothing.
void fetch_leaf(const MeshData& mesh, std::int32_t leaf) {
  const auto fetch = [&](const auto* rows) {
    const char* const begin = reinterpret_cast<const char*>(rows + std::ptrdiff_t{leaf} * kTreeBlock);
    for (std::size_t at = 0; at < sizeof(*rows) * kTreeBlock; at += 64) __builtin_prefetch(begin + at);
  };
  fetch(mesh.corners);
  fetch(mesh.turns);
}

// A walk through the tree with one shape.
class Walk {
 public:
  Walk(const MeshPair& pair, MeshFirstType type, const MeshTask& task, MeshClips& clips, int& count)
      : pair_(pair), type_(type), task_(task), clips_(clips), count_(count) {}

  // False: stopped for lack of room.
  bool visit(int level, std::int32_t block) {
    const std::uint32_t all = children_met(pair_, pair_.mesh->nodes[level][block]);
    for (std::uint32_t met = level == 0 ? all : 0; met != 0; met &= met - 1) {
      fetch_leaf(*pair_.mesh, block * kTreeBlock + __builtin_ctz(met));
    }
    for (std::uint32_t met = all; met != 0; met &= met - 1) {
      const std::int32_t child = block * kTreeBlock + __builtin_ctz(met);
      if (level > 0 ? !visit(level - 1, child) : !visit_leaf(child)) return false;
    }
    return true;
  }
  void flush() {
    if (batch_.count == 0) return;
    fill_up(batch_);
    count_ += touch(type_, pair_, batch_, clips_, beside_, task_.contacts + count_);
    batch_.count = 0;
  }
  // After all: there is room for one more.
  void touch_beside() {
    if (pair_.hulls.hull[0] != nullptr) {
      count_ += clips_.touch_beside(task_.contacts + count_);
    } else if (!beside_.is_held && beside_.triangle >= 0) {
      task_.contacts[count_++] = beside_.contact;
    }
  }

 private:
  bool visit_leaf(std::int32_t leaf) {
    if (count_ + kLanes + kTreeBlock > task_.capacity) return false;  // for what waits and all of the leaf
    Leaf columns;
    const std::int32_t begin = leaf * kTreeBlock;
    const std::int32_t left = pair_.mesh->triangle_count - begin;
    std::uint32_t met = 0;
    for (int first = 0; first < kTreeBlock; first += kLanes) {
      V3 corner[3];
      load_corners(*pair_.mesh, leaf, first, corner);
      const std::uint32_t here = triangles_met(pair_, corner);
      if (here == 0) continue;
      columns.put(corner, first);
      met |= here << first;
    }
    if (left < kTreeBlock) met &= (1u << left) - 1u;
    for (; met != 0; met &= met - 1) {
      const int lane = __builtin_ctz(met);
      put_triangle(*pair_.mesh, columns, lane, begin + lane, batch_);
      if (batch_.count == kLanes) flush();
    }
    return true;
  }

  const MeshPair& pair_;
  MeshFirstType type_;
  const MeshTask& task_;
  MeshClips& clips_;
  int& count_;
  TriangleBatch batch_;
  MeshBeside beside_;
};

// Takes out contacts of which no point was left.
void close_gaps(const MeshTask& task) {
  int count = 0, from = 0;
  for (int item = 0; item < task.count; ++item) {
    for (; from < task.ends[item]; ++from) {
      if (task.contacts[from].triangle < 0) continue;
      if (count < from) task.contacts[count] = task.contacts[from];
      ++count;
    }
    task.ends[item] = count;
  }
}

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
    for (float& each : contact.separation) each = kAbsentSeparation;
    int points = 0;
    for (int k = 0; k < 2; ++k) {
      if (id[k][lane] == 0) continue;
      for (int axis = 0; axis < 3; ++axis) contact.point[points][axis] = point[k][axis][lane];
      contact.separation[points] = separation[k][lane];
      contact.id[points++] = static_cast<std::uint32_t>(id[k][lane]);
    }
  }
  return count;
}

bool collide_meshes(const MeshTask& task) {
  HullPair frames[kMeshChunk + 1];
  load_frames(task.columns, task.items, task.count, frames);
  BoxHull box;
  MeshClips clips;
  int count = 0;
  for (int item = 0; item < task.count; ++item) {
    const MeshFirstType type = task.first_types[item];
    MeshPair pair;
    make_pair(task.columns, task.items[item], type, frames[item], box, pair);
    if (pair.hulls.hull[0] != nullptr) clips.set_pair(pair);
    Walk walk(pair, type, task, clips, count);
    if (!walk.visit(pair.mesh->levels - 1, 0)) return false;
    walk.flush();
    walk.touch_beside();
    task.ends[item] = count;
  }
  clips.flush();
  close_gaps(task);
  return true;
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
