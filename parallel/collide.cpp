// Narrow phase: candidate pairs -> manifolds. Written: contacts.now (all but the pairs) and
// contacts.touching. Read by find_islands, color_constraints and pack_blocks.
//
// Rows are grouped by type pair with a counting sort, each group goes through its kernel in chunks, and the
// touching rows are listed. Every pass runs in parallel over fixed chunks, and nothing depends on their
// order.
#include <core/wake.h>
#include <parallel/narrow_phase.h>
#include <parallel/stages.h>

#include <numeric>

namespace scree {

namespace {

using simd::CollideItem;

// NarrowPhase::kind: a simd::CollideType, or that the row is left alone, or that its pair cannot collide.
static_assert(simd::kCollideTypes <= 14);
constexpr std::uint8_t kSkipped = 14;  // nobody moves: the row keeps its contents
constexpr std::uint8_t kNever = 15;    // no dynamic body

bool is_dynamic(BodyType type) { return type == BodyType::dynamic; }

simd::CollideType collide_type(ShapeType a, ShapeType b) {
  constexpr simd::CollideType kTypes[kShapeTypeCount][kShapeTypeCount] = {
      {simd::kSphereSphere, simd::kSphereCapsule, simd::kSphereBox, simd::kSphereHull},
      {simd::kSphereCapsule, simd::kCapsuleCapsule, simd::kCapsuleBox, simd::kCapsuleHull},
      {simd::kSphereBox, simd::kCapsuleBox, simd::kBoxBox, simd::kBoxHull},
      {simd::kSphereHull, simd::kCapsuleHull, simd::kBoxHull, simd::kHullHull}};
  return kTypes[static_cast<int>(a)][static_cast<int>(b)];
}

// Nobody found this row in the last list. One of two resting shapes must have come by a call then, and what
// sleeps there is collided to see whether it must wake.
bool is_new(const Contacts& contacts, std::size_t row) {
  return !contacts.list_kept && contacts.previous[row] < 0;
}

// Whether the body may push what it touches. One that rests was put or stopped by a call, which has woken
// whatever sleeps near it: see wake_neighbors.
bool moves(const WorldData& data, std::size_t body) {
  switch (data.bodies.type[body]) {
    case BodyType::fixed:
      return false;
    case BodyType::kinematic:
      return !is_still(data.bodies.velocity[body]);
    case BodyType::dynamic:
      break;
  }
  return (data.bodies.flags[body] & kBodyAsleep) == 0;
}

// Whatever is collided is listed where it touches: what sleeps in it must wake.
std::uint8_t classify(const WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.now.pair[row];
  const std::size_t body_a = static_cast<std::size_t>(data.shapes.body[static_cast<std::size_t>(pair.a)]);
  const std::size_t body_b = static_cast<std::size_t>(data.shapes.body[static_cast<std::size_t>(pair.b)]);
  if (!is_dynamic(data.bodies.type[body_a]) && !is_dynamic(data.bodies.type[body_b])) return kNever;
  if (!moves(data, body_a) && !moves(data, body_b) && !is_new(data.contacts, row)) return kSkipped;
  return static_cast<std::uint8_t>(collide_type(data.shapes.type[static_cast<std::size_t>(pair.a)],
                                                data.shapes.type[static_cast<std::size_t>(pair.b)]));
}

CollideItem make_item(const WorldData& data, std::size_t row) {
  const ShapePair pair = data.contacts.now.pair[row];
  CollideItem item{};
  item.shape_1 = pair.a;
  item.shape_2 = pair.b;
  if (data.shapes.type[static_cast<std::size_t>(pair.a)] >
      data.shapes.type[static_cast<std::size_t>(pair.b)]) {
    std::swap(item.shape_1, item.shape_2);
  }
  item.body_1 = data.shapes.body[static_cast<std::size_t>(item.shape_1)];
  item.body_2 = data.shapes.body[static_cast<std::size_t>(item.shape_2)];
  item.row = static_cast<std::int32_t>(row);
  item.previous = data.contacts.list_kept ? item.row : data.contacts.previous[row];
  const BodyType type_1 = data.bodies.type[static_cast<std::size_t>(item.body_1)];
  const BodyType type_2 = data.bodies.type[static_cast<std::size_t>(item.body_2)];
  const BodyType type_a = is_dynamic(type_2) ? type_1 : type_2;
  if (!is_dynamic(type_2)) item.flags |= simd::kItemFlip;
  if (!is_dynamic(type_a)) item.flags |= simd::kItemStatic;
  if (type_a == BodyType::fixed) item.flags |= simd::kItemFixed;
  return item;
}

// A row that nobody collides takes its contents along where the list has changed.
void keep_row(Contacts& contacts, std::size_t row) {
  if (contacts.list_kept) return;
  if (contacts.previous[row] < 0) {
    contacts.now.manifold[row].info = 0;
    contacts.now.axis[row] = {};
    return;
  }
  const std::size_t from = static_cast<std::size_t>(contacts.previous[row]);
  contacts.now.manifold[row] = contacts.before.manifold[from];
  contacts.now.features[row] = contacts.before.features[from];
  contacts.now.surface[row] = contacts.before.surface[from];
  contacts.now.anchor[row] = contacts.before.anchor[from];
  contacts.now.axis[row] = contacts.before.axis[from];
}

void count_types(WorldData& data, NarrowPhase& phase, Crew& crew) {
  const int rows = static_cast<int>(data.contacts.now.pair.size());
  const int chunks = (rows + NarrowPhase::kRowChunk - 1) / NarrowPhase::kRowChunk;
  phase.kind.resize_discarding(static_cast<std::size_t>(rows));
  phase.points.resize_discarding(static_cast<std::size_t>(rows));
  phase.items.resize_discarding(static_cast<std::size_t>(rows));
  phase.chunk_counts.resize_discarding(static_cast<std::size_t>(chunks));
  phase.chunk_touching.resize_discarding(static_cast<std::size_t>(chunks));
  phase.chunk_resting.resize_discarding(static_cast<std::size_t>(chunks));
  crew.run_ranges(rows, NarrowPhase::kRowChunk, [&](int begin, int end, int) {
    NarrowPhase::Counts counts{};
    for (int i = begin; i < end; ++i) {
      const std::size_t row = static_cast<std::size_t>(i);
      const std::uint8_t type = classify(data, row);
      phase.kind[row] = type;
      if (type < simd::kCollideTypes) {
        ++counts[type];
      } else if (type == kSkipped) {
        keep_row(data.contacts, row);
      } else {
        data.contacts.now.manifold[row].info = 0;
        data.contacts.now.axis[row] = {};
      }
      if (type >= simd::kCollideTypes) {
        phase.points[row] =
            static_cast<std::uint8_t>(data.contacts.now.manifold[row].info & kManifoldPointMask);
      }
    }
    phase.chunk_counts[static_cast<std::size_t>(begin / NarrowPhase::kRowChunk)] = counts;
  });
  // Counts become places: by type, then by chunk.
  std::int32_t place = 0;
  for (std::size_t type = 0; type < simd::kCollideTypes; ++type) {
    phase.type_begin[type] = place;
    for (NarrowPhase::Counts& counts : phase.chunk_counts) {
      const std::int32_t count = counts[type];
      counts[type] = place;
      place += count;
    }
  }
  phase.type_begin[simd::kCollideTypes] = place;
}

void sort_by_type(const WorldData& data, NarrowPhase& phase, Crew& crew) {
  const int rows = static_cast<int>(data.contacts.now.pair.size());
  crew.run_ranges(rows, NarrowPhase::kRowChunk, [&](int begin, int end, int) {
    NarrowPhase::Counts place = phase.chunk_counts[static_cast<std::size_t>(begin / NarrowPhase::kRowChunk)];
    for (int i = begin; i < end; ++i) {
      const std::size_t row = static_cast<std::size_t>(i);
      const std::size_t type = phase.kind[row];
      if (type >= simd::kCollideTypes) continue;
      phase.items[static_cast<std::size_t>(place[type]++)] = make_item(data, row);
    }
  });
}

// Null where manifolds of the type are not recycled.
simd::CollideKernels::Recycle recycle_of(const simd::CollideKernels& kernels, std::size_t type) {
  if (type == simd::kBoxBox) return kernels.recycle_boxes;
  return type == simd::kBoxHull || type == simd::kHullHull ? kernels.recycle_hulls : nullptr;
}

void run_kernels(WorldData& data, NarrowPhase& phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const ContactRows& previous = contacts.list_kept ? contacts.now : contacts.before;
  const simd::CollideColumns columns{
      .shape_pose = data.shapes.pose.data(),
      .shape_extent = data.shapes.extent.data(),
      .shape_material = data.shapes.material.data(),
      .shape_hull = data.shapes.hull.data(),
      .hulls = data.hulls.data.data(),
      .body_pose = data.bodies.pose.data(),
      .body_velocity = data.bodies.velocity.data(),
      .dt = data.last_dt,
      .previous_manifold = previous.manifold.data(),
      .previous_features = previous.features.data(),
      .previous_surface = previous.surface.data(),
      .previous_anchor = previous.anchor.data(),
      .previous_axis = previous.axis.data(),
      .manifold = contacts.now.manifold.data(),
      .features = contacts.now.features.data(),
      .surface = contacts.now.surface.data(),
      .anchor = contacts.now.anchor.data(),
      .axis = contacts.now.axis.data(),
      .points = phase.points.data(),
  };
  std::array<int, simd::kCollideTypes + 1> chunk_begin{};
  for (std::size_t type = 0; type < simd::kCollideTypes; ++type) {
    const int count = phase.type_begin[type + 1] - phase.type_begin[type];
    chunk_begin[type + 1] = chunk_begin[type] + (count + simd::kCollideChunk - 1) / simd::kCollideChunk;
  }
  const simd::CollideKernels& kernels = crew.kernels().collide;
  crew.run(chunk_begin[simd::kCollideTypes], [&](int chunk, int) {
    std::size_t type = 0;
    while (chunk >= chunk_begin[type + 1]) ++type;
    const int begin = phase.type_begin[type] + (chunk - chunk_begin[type]) * simd::kCollideChunk;
    const int count = std::min(phase.type_begin[type + 1] - begin, simd::kCollideChunk);
    const CollideItem* items = phase.items.data() + begin;
    const simd::CollideKernels::Recycle recycle = recycle_of(kernels, type);
    if (recycle == nullptr || contacts.manifolds_stale) {
      kernels.collide[type](columns, items, count);
      return;
    }
    CollideItem left[simd::kCollideChunk];
    const int left_count = recycle(columns, items, count, left);
    if (left_count > 0) kernels.collide[type](columns, left, left_count);
  });
}

// A contact keeps its color while it touches.
std::uint8_t color_of(const Contacts& contacts, std::size_t row, bool touches) {
  if (!touches) return kNoColor;
  if (contacts.list_kept) return contacts.now.color[row];
  const std::int32_t previous = contacts.previous[row];
  return previous < 0 ? kNoColor : contacts.before.color[static_cast<std::size_t>(previous)];
}

bool is_listed(const NarrowPhase& phase, std::size_t row) {
  return phase.points[row] != 0 && phase.kind[row] < simd::kCollideTypes;
}

void list_touching(WorldData& data, NarrowPhase& phase, Crew& crew) {
  Contacts& contacts = data.contacts;
  const int rows = static_cast<int>(contacts.now.pair.size());
  crew.run_ranges(rows, NarrowPhase::kRowChunk, [&](int begin, int end, int) {
    std::int32_t touching = 0, resting = 0;
    for (int i = begin; i < end; ++i) {
      const std::size_t row = static_cast<std::size_t>(i);
      contacts.now.color[row] = color_of(contacts, row, phase.points[row] != 0);
      const bool listed = is_listed(phase, row);
      touching += listed ? 1 : 0;
      resting += !listed && phase.points[row] != 0 ? 1 : 0;
    }
    phase.chunk_resting[static_cast<std::size_t>(begin / NarrowPhase::kRowChunk)] = resting;
    phase.chunk_touching[static_cast<std::size_t>(begin / NarrowPhase::kRowChunk)] = touching;
  });
  std::int32_t place = 0;
  for (std::int32_t& count : phase.chunk_touching) {
    const std::int32_t touching = count;
    count = place;
    place += touching;
  }
  contacts.touching.resize_discarding(static_cast<std::size_t>(place));
  data.stats.contacts = std::accumulate(phase.chunk_resting.begin(), phase.chunk_resting.end(),
                                        static_cast<std::int64_t>(place));
  crew.run_ranges(rows, NarrowPhase::kRowChunk, [&](int begin, int end, int) {
    std::int32_t to = phase.chunk_touching[static_cast<std::size_t>(begin / NarrowPhase::kRowChunk)];
    for (int i = begin; i < end; ++i) {
      if (is_listed(phase, static_cast<std::size_t>(i)))
        contacts.touching[static_cast<std::size_t>(to++)] = i;
    }
  });
}

}  // namespace

void NarrowPhase::report(const Visit& visit) const {
  const auto column = [&](const char* name, const auto& rows) {
    visit(ColumnKind::scratch, name, rows.data(), rows.size() * sizeof(rows[0]), rows.capacity_bytes());
  };
  column("narrow_phase.kind", kind);
  column("narrow_phase.points", points);
  column("narrow_phase.chunk_counts", chunk_counts);
  column("narrow_phase.chunk_touching", chunk_touching);
  column("narrow_phase.chunk_resting", chunk_resting);
  column("narrow_phase.items", items);
}

void collide(WorldData& data, Crew& crew) {
  if (!data.narrow_phase) data.narrow_phase = std::make_unique<NarrowPhase>();
  NarrowPhase& phase = static_cast<NarrowPhase&>(*data.narrow_phase);
  count_types(data, phase, crew);
  sort_by_type(data, phase, crew);
  run_kernels(data, phase, crew);
  list_touching(data, phase, crew);
  data.contacts.manifolds_stale = false;
}

}  // namespace scree
