// Updates bounds: poses of bodies -> poses and fat bounds of shapes, and whether any shape left its fat
// bounds, and which if these are few.
//
// Runs at the end of each step for the shapes that may have moved, and before find_pairs for the shapes that
// calls have changed. find_pairs keeps its list while no shape leaves its fat bounds.
#include <core/state/hash.h>
#include <core/world/edit.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/crew/list_where.h>
#include <parallel/stages.h>

#include <algorithm>
#include <span>

namespace scree {

namespace {

constexpr int kBoundsPerChunk = 256;  // 5 to 10 microseconds
// Where more than one of so many moving shapes has left its bounds, pairs are found anew for all.
constexpr std::size_t kMovingPerLeft = 2;

static_assert(static_cast<int>(ShapeType::sphere) == simd::kBoundsSphere);
static_assert(static_cast<int>(ShapeType::capsule) == simd::kBoundsCapsule);
static_assert(static_cast<int>(ShapeType::hull) == simd::kBoundsHull);
static_assert(static_cast<int>(ShapeType::mesh) == simd::kBoundsMesh);
static_assert(static_cast<int>(ShapeType::rounded_box) == simd::kBoundsRoundedBox);
static_assert(static_cast<int>(ShapeType::rounded_hull) == simd::kBoundsRoundedHull);
static_assert(static_cast<int>(ShapeType::cylinder) == simd::kBoundsCylinder);
static_assert(static_cast<int>(ShapeType::cone) == simd::kBoundsCone);
static_assert(static_cast<int>(BodyType::fixed) == simd::kBoundsFixedBody);
static_assert(sizeof(ShapeType) == 1 && sizeof(BodyType) == 1);
static_assert(sizeof(PoseRow) == 32 && sizeof(VelocityRow) == 32 && sizeof(BoundsRow) == 32 &&
              sizeof(ExtentRow) == 16);

// With `hashes`, an additional task computes the hash of a recorded world: poses and velocities are final
// here, and two threads share the work. Not with a single chunk of shapes: such worlds step without helpers.
// `has_left`: by place in the list, or null. Returns the number of shapes that left their bounds.
int update_list(WorldData& data, BroadPhase& broad_phase, std::span<const std::int32_t> list, float dt,
                std::uint8_t* has_left, bool force, bool hashes, Crew& crew) {
  if (list.empty()) return 0;
  const simd::BoundsTask task{
      .list = list.data(),
      .shape_body = data.shapes.body.data(),
      .shape_type = reinterpret_cast<const std::uint8_t*>(data.shapes.type.data()),
      .body_type = reinterpret_cast<const std::uint8_t*>(data.bodies.type.data()),
      .extent = data.shapes.extent.data(),
      .local_pose = data.shapes.local_pose.data(),
      .body_pose = data.bodies.pose.data(),
      .body_velocity = data.bodies.velocity.data(),
      .shape_pose = data.shapes.pose.data(),
      .fat_bounds = data.shapes.fat_bounds.data(),
      .motion = data.shapes.motion.data(),
      .left = has_left,
      .dt = dt,
      .force = force,
  };
  const auto update = crew.kernels().pair.update_bounds;
  const int count = static_cast<int>(list.size()), first = hashes && count > kBoundsPerChunk ? 1 : 0;
  std::atomic<int> left{0};
  crew.run((count + kBoundsPerChunk - 1) / kBoundsPerChunk + first, [&](int chunk, int) {
    if (chunk < first) {
      data.recording.hash = hash_of(data.bodies);
      return;
    }
    const int begin = (chunk - first) * kBoundsPerChunk, end = std::min(begin + kBoundsPerChunk, count);
    const int here = update(task, begin, end);
    if (here > 0) left.fetch_add(here, std::memory_order_relaxed);
  });
  const int all = left.load(std::memory_order_relaxed);
  if (all > 0) broad_phase.bounds_left.store(true, std::memory_order_relaxed);
  return all;
}

}  // namespace

void update_dirty_bounds(WorldData& data, BroadPhase& broad_phase, float dt, Crew& crew) {
  Shapes& shapes = data.shapes;
  if (shapes.dirty.empty()) return;
  // The list from calls may name shapes that were destroyed later.
  const std::size_t first = broad_phase.displaced.size();
  for (const std::int32_t shape : shapes.dirty) {
    const std::uint8_t flags = shapes.flags[shape];
    shapes.flags[shape] = static_cast<std::uint8_t>(flags & ~kShapeDirty);
    shapes.marks.mark(shape);  // of its bounds, too
    broad_phase.changed.push_back(shape);
    if ((flags & kShapeAlive) == 0) continue;
    broad_phase.dirty.push_back(shape);
    if (!is_absent(data.bodies, shapes.body[shape])) broad_phase.displaced.push_back(shape);
  }
  shapes.dirty.clear();
  broad_phase.left_is_known = false;
  broad_phase.bounds_left.store(true, std::memory_order_relaxed);
  const auto changed = broad_phase.displaced.span().subspan(first);
  update_list(data, broad_phase, changed, dt, nullptr, true, false, crew);
}

void forget_displaced(WorldData& data) {
  Column<std::int32_t>& displaced = broad_phase_of(data).displaced;
  for (const std::int32_t shape : displaced) {
    data.shapes.motion[shape] = motion_at_rest(data.shapes.pose[shape]);
  }
  displaced.clear();
}

void update_bounds(WorldData& data, float dt, Crew& crew) {
  BroadPhase& broad_phase = broad_phase_of(data);
  const bool hashes = data.recording.sink != nullptr && data.border == nullptr;
  const Column<std::int32_t>& moving = data.shapes.moving;
  broad_phase.has_left.resize_discarding(moving.size());
  const int left =
      update_list(data, broad_phase, moving.span(), dt, broad_phase.has_left.data(), false, hashes, crew);
  const bool is_few = kMovingPerLeft * static_cast<std::size_t>(left) <= moving.size();
  const bool is_known = broad_phase.left_is_known && broad_phase.left.empty() && is_few;
  broad_phase.left_is_known = false;
  if (left > 0 && is_known) {
    list_where(
        crew, moving.size(), broad_phase.places, broad_phase.left,
        [&](std::int32_t i) { return broad_phase.has_left[i] != 0; },
        [&](std::int32_t i) { return moving[i]; });
  }
  broad_phase.left_is_known = is_known;
  update_dirty_bounds(data, broad_phase, dt, crew);
}

}  // namespace scree
