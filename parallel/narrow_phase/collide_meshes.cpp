// The narrow phase of pairs with a mesh: a pair may have several contacts, one for each direction in which
// the mesh pushes. They are linked by ContactRows::next, from PairRows::contact on.
//
// While the shape has hardly moved since all of these were made, they are recycled (collide_recycle.cpp).
// Else the pair is collided anew, merged to few manifolds (mesh_manifolds.cpp), and these are matched with
// its contacts by their normals: those that match go on in their rows, the others end. New ones take free
// rows in the order of the pairs. All passes run over fixed chunks of pairs.
#include <core/world/edit.h>
#include <core/world/math.h>
#include <parallel/narrow_phase/mesh_manifolds.h>
#include <parallel/narrow_phase/narrow_phase.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace scree {

namespace {

using simd::CollideItem;
using simd::MeshManifold;

// Cosine of the turn of a normal within a step by which it is still that of the same contact.
constexpr float kSameContact = 0.9f;
// The least distance of two points, as a share of the smaller shape.
constexpr float kSpreadShare = 0.01f;
constexpr float kMostSpread = 0.1f * kLinearSlop;  // m

struct PairRange {
  int begin, end;
};
PairRange pairs_of(const NarrowPhase& phase, int chunk) {
  const int count = static_cast<int>(phase.mesh_pairs.size());
  return {chunk * simd::kMeshChunk, std::min((chunk + 1) * simd::kMeshChunk, count)};
}

simd::MeshFirstType first_type_of(const WorldData& data, const CollideItem& item) {
  const ShapeType type = data.shapes.type[item.shape_1];
  return is_smooth(type) ? simd::kMeshSmooth : static_cast<simd::MeshFirstType>(type);
}

float spread_of(const ExtentRow& extent) {
  const float size = std::max({extent.half[0], extent.half[1], extent.half[2], extent.radius});
  return std::min(kSpreadShare * size, kMostSpread);
}

// Pairs of one chunk, as kernels take them.
struct MeshPairs {
  int count = 0;

  void add(const CollideItem& item, simd::MeshFirstType type) {
    const auto k = static_cast<std::size_t>(count++);
    items[k] = item;
    types[k] = type;
  }

  std::array<CollideItem, simd::kMeshChunk> items;
  std::array<simd::MeshFirstType, simd::kMeshChunk> types;
  std::array<int, simd::kMeshChunk> ends;  // of their contacts with triangles
};

void find_contacts(const simd::CollideColumns& columns, const simd::CollideKernels& kernels, MeshPairs& pairs,
                   Column<simd::TriangleContact>& contacts) {
  constexpr std::size_t kAtFirst = std::size_t{8} * simd::kLeastMeshCapacity;
  if (contacts.empty()) contacts.resize_for_overwrite(kAtFirst);
  while (!kernels.collide_meshes({columns, pairs.items.data(), pairs.types.data(), pairs.count,
                                  contacts.data(), static_cast<int>(contacts.size()), pairs.ends.data()})) {
    contacts.resize_for_overwrite(2 * contacts.size());
  }
}

// Gives the manifolds from `first` on the rows of the pair's contacts whose normals they continue, each to
// the one that it agrees with most. Contacts without a manifold end.
void match_contacts(const WorldData& data, ContactRows& now, std::int32_t contact, const CollideItem& item,
                    std::size_t first, Column<MeshManifold>& found) {
  const Quat rotation = to_quat(data.shapes.pose[item.shape_1].rotation);
  const float side = (item.flags & simd::kItemFlip) != 0 ? -1.0f : 1.0f;
  for (; contact >= 0; contact = next_contact(now, contact)) {
    const Vec3 before = rotate(conjugate(rotation), side * to_vec3(now.manifold[contact].normal));
    float most = kSameContact;
    MeshManifold* same = nullptr;
    for (std::size_t i = first; i < found.size(); ++i) {
      const float agrees = dot(to_vec3(found[i].contact.normal), before);
      if (found[i].row >= 0 || !(agrees > most)) continue;
      most = agrees;
      same = &found[i];
    }
    if (same == nullptr) {
      now.points[contact] = 0;
    } else {
      same->row = contact;
      same->is_known = 1;
    }
  }
}

// Lists the contacts of a pair behind the first `count` items. Returns the number of items then, or `count`
// if the pair has no contacts, too many of them, or such as are never recycled.
int list_contacts_of(const ContactRows& now, const CollideItem& item, simd::MeshFirstType type, int count,
                     std::array<CollideItem, simd::kCollideChunk>& items) {
  if (type == simd::kMeshSphere || type == simd::kMeshSmooth) return count;
  int end = count;
  for (std::int32_t contact = item.row; contact >= 0; contact = next_contact(now, contact)) {
    if (end == simd::kCollideChunk) return count;
    items[static_cast<std::size_t>(end)] = item;
    items[static_cast<std::size_t>(end++)].row = contact;
  }
  return end;
}

// Recycles the contacts of pairs whose shapes have hardly moved since; the other pairs go to `left`.
void recycle_pairs(WorldData& data, const simd::CollideColumns& columns, const simd::CollideKernels& kernels,
                   const MeshPairs& pairs, MeshPairs& left) {
  std::array<CollideItem, simd::kCollideChunk> items;
  std::array<simd::FollowedManifold, simd::kCollideChunk> followed;
  std::array<int, simd::kMeshChunk> ends{};
  int count = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(pairs.count); ++k) {
    if (!data.contacts.manifolds_stale) {
      count = list_contacts_of(data.contacts.now, pairs.items[k], pairs.types[k], count, items);
    }
    ends[k] = count;
  }
  if (count > 0) kernels.follow_mesh_manifolds(columns, items.data(), count, followed.data());
  int begin = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(pairs.count); ++k) {
    const auto first = followed.begin() + std::exchange(begin, ends[k]), end = followed.begin() + ends[k];
    const bool stays = first != end && std::all_of(first, end, [](const auto& f) { return f.keeps != 0; });
    if (!stays) left.add(pairs.items[k], pairs.types[k]);
    for (auto f = first; stays && f != end; ++f) {
      const std::int32_t row = items[static_cast<std::size_t>(f - followed.begin())].row;
      std::copy(std::begin(f->separation), std::end(f->separation), columns.manifold[row].separation);
    }
  }
}

void find_in_chunk(WorldData& data, NarrowPhase& phase, const simd::CollideColumns& columns,
                   const simd::CollideKernels& kernels, int chunk, const MeshScratch& scratch) {
  Column<MeshManifold>& found = phase.mesh_found[static_cast<std::size_t>(chunk)];
  found.clear();
  const PairRange range = pairs_of(phase, chunk);
  MeshPairs all, pairs;
  for (int i = range.begin; i < range.end; ++i) {
    const CollideItem item = make_item(data, phase.mesh_pairs[i]);
    all.add(item, first_type_of(data, item));
  }
  recycle_pairs(data, columns, kernels, all, pairs);
  find_contacts(columns, kernels, pairs, scratch.contacts);
  int begin = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(pairs.count); ++k) {
    const CollideItem& item = pairs.items[k];
    const std::size_t first = found.size();
    const auto count = static_cast<std::size_t>(pairs.ends[k] - std::exchange(begin, pairs.ends[k]));
    if (count > 0) {
      const MeshData& mesh = *data.meshes.data[data.shapes.mesh[item.shape_2]];
      const std::span<const simd::TriangleContact> own(scratch.contacts.data() + begin - count, count);
      merge_contacts(mesh, own, pairs.types[k], item.pair, spread_of(data.shapes.extent[item.shape_1]),
                     scratch, found);
    }
    match_contacts(data, data.contacts.now, data.contacts.pairs.contact[item.pair], item, first, found);
  }
  phase.mesh_fresh[chunk] = static_cast<std::int32_t>(
      std::count_if(found.begin(), found.end(), [](const MeshManifold& m) { return m.row < 0; }));
}

// Appends a new contact to those of a pair.
void link_contact(Contacts& contacts, std::int32_t pair, std::int32_t row) {
  std::int32_t last = -1;
  for_each_contact(contacts, contacts.pairs.contact[pair], [&](std::int32_t contact) { last = contact; });
  if (last < 0) {
    contacts.pairs.contact[pair] = row;
  } else {
    contacts.now.next[last] = row + 1;
  }
  contacts.now.next[row] = 0;
  contacts.now.pair[row] = contacts.pairs.pair[pair];
  contacts.now.color[row] = kNoColor;
  if (!contacts.forces.empty()) contacts.forces[row] = {};
}

// Manifolds whose first shapes are stored by the same kernel, up to the number of one call.
struct StoreQueue {
  std::int32_t first_type = simd::kMeshSphere;
  int count = 0;
  std::array<CollideItem, simd::kCollideChunk> items;
  std::array<MeshManifold, simd::kCollideChunk> found;

  void flush(const simd::CollideColumns& columns, const simd::CollideKernels& kernels) {
    if (count > 0) kernels.store_mesh_manifolds(columns, items.data(), found.data(), count, first_type);
    count = 0;
  }
};

// 0: spheres, 1: capsules, 2: boxes and hulls, 3: smooth shapes.
std::size_t store_group(std::int32_t first_type) {
  if (first_type == simd::kMeshSmooth) return 3;
  return static_cast<std::size_t>(std::min<std::int32_t>(first_type, simd::kMeshBox));
}

// `rows`: of the chunk's new contacts.
void store_chunk(WorldData& data, NarrowPhase& phase, const simd::CollideColumns& columns,
                 const simd::CollideKernels& kernels, int chunk, const std::int32_t* rows) {
  Contacts& contacts = data.contacts;
  Column<MeshManifold>& found = phase.mesh_found[static_cast<std::size_t>(chunk)];
  std::array<StoreQueue, 4> queues;
  for (MeshManifold& manifold : found) {
    if (manifold.is_known == 0) {
      manifold.row = *rows++;
      link_contact(contacts, manifold.place, manifold.row);
    }
    CollideItem item = make_item(data, manifold.place);
    item.row = manifold.row;
    item.flags = (item.flags & ~simd::kItemKnown) | (manifold.is_known != 0 ? simd::kItemKnown : 0);
    const simd::MeshFirstType type = first_type_of(data, item);
    StoreQueue& queue = queues[store_group(type)];
    queue.first_type = type;
    queue.items[static_cast<std::size_t>(queue.count)] = item;
    queue.found[static_cast<std::size_t>(queue.count++)] = manifold;
    if (queue.count == simd::kCollideChunk) queue.flush(columns, kernels);
  }
  for (StoreQueue& queue : queues) queue.flush(columns, kernels);
  for (const MeshManifold& manifold : found) {
    if (manifold.is_known != 0) continue;
    const bool is_sphere = data.shapes.type[make_item(data, manifold.place).shape_1] == ShapeType::sphere;
    clear_unwritten(contacts.now, manifold.row, !is_sphere);
  }
}

}  // namespace

void collide_meshes(WorldData& data, NarrowPhase& phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  phase.mesh_pairs.clear();
  if (data.meshes.data.empty()) return;
  list_where(crew, contacts.pairs.pair.size(), phase.places, phase.mesh_pairs,
             [&](std::int32_t i) { return phase.kind[i] == kMeshPair; });
  if (phase.mesh_pairs.empty()) return;
  const int chunks = (static_cast<int>(phase.mesh_pairs.size()) + simd::kMeshChunk - 1) / simd::kMeshChunk;
  if (phase.mesh_found.size() < static_cast<std::size_t>(chunks)) {
    phase.mesh_found.resize(static_cast<std::size_t>(chunks));
  }
  const auto threads = static_cast<std::size_t>(crew.threads());
  phase.mesh_contacts.resize(threads);
  phase.mesh_order.resize(threads);
  phase.mesh_cluster.resize(threads);
  phase.mesh_points.resize(threads);
  phase.mesh_fresh.resize_discarding(chunks);
  const simd::CollideKernels& kernels = crew.kernels().collide;
  const simd::CollideColumns before = collide_columns(data);
  crew.run(chunks, [&](int chunk, int worker) {
    const auto own = static_cast<std::size_t>(worker);
    const MeshScratch scratch{phase.mesh_contacts[own], phase.mesh_order[own], phase.mesh_cluster[own],
                              phase.mesh_points[own]};
    find_in_chunk(data, phase, before, kernels, chunk, scratch);
  });
  std::int32_t fresh = 0;
  for (std::int32_t& count : phase.mesh_fresh) {
    const std::int32_t of_chunk = count;
    count = fresh;
    fresh += of_chunk;
  }
  const auto needed = static_cast<std::size_t>(fresh);
  provide_rows(contacts, needed, 0, data.settings.contact_forces);
  const std::int32_t* const rows = contacts.free_rows.end() - needed;
  const simd::CollideColumns columns = collide_columns(data);
  crew.run(chunks, [&](int chunk, int) {
    store_chunk(data, phase, columns, kernels, chunk, rows + phase.mesh_fresh[chunk]);
  });
  contacts.free_rows.drop_back(needed);
  contacts.free_mark.cut(contacts.free_rows.size());
}

}  // namespace scree
