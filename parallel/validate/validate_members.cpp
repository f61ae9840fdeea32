// Validation of the lists of bodies, shapes and joints that take part; see validate_stages.h.
#ifdef SCREE_ASSERTIONS

#include <core/constraints/joint_parameters.h>
#include <core/world/wake.h>
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/distributed/border.h>
#include <parallel/validate/validate_stages.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace scree {

namespace {

// The list ascends, and names a row exactly if `belongs` holds for it. Rows for which `may_differ` holds are
// excepted: there the list will change.
template <class Belongs, class MayDiffer>
void validate_list(const Column<std::int32_t>& list, std::size_t rows, Belongs&& belongs,
                   MayDiffer&& may_differ) {
  SCREE_ASSERT(ascends(list));
  std::size_t place = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const bool is_listed = place < list.size() && std::cmp_equal(list[place], row);
    place += is_listed ? 1 : 0;
    SCREE_ASSERT(is_listed == belongs(row) || may_differ(row));
  }
  SCREE_ASSERT(place == list.size());
}

bool is_changed(const Bodies& bodies, std::int32_t body) {
  return bodies.all_changed || bodies.is_changed[body] != 0;
}

// Each own shape that rests is in the list and in its box, and in that of each halo whose box it meets and
// that has seen all of the list; but those that will be taken up in the next step.
void validate_resting(const WorldData& data, const Border& border) {
  const Shapes& shapes = data.shapes;
  const RestingShapes& resting = border.resting;
  std::vector<std::uint8_t> is_pending(shapes.flags.size(), 0), is_listed(shapes.flags.size(), 0);
  for (const std::int32_t shape : static_cast<const BroadPhase&>(*data.broad_phase).changed)
    is_pending[static_cast<std::size_t>(shape)] = 1;
  for (const std::int32_t shape : resting.shapes) is_listed[static_cast<std::size_t>(shape)] = 1;
  const auto is_in_box = [&](const BoundsRow& bounds) {
    bool is_inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      is_inside = is_inside && !(bounds.lower[axis] < resting.box.lower[axis]) &&
                  !(bounds.upper[axis] > resting.box.upper[axis]);
    }
    return is_inside;
  };
  std::vector<std::int32_t> settled;
  for (std::size_t row = 0; row < is_pending.size(); ++row) {
    const auto shape = static_cast<std::int32_t>(row);
    if (is_pending[row] != 0 || shapes.is_changed[shape] != 0 || !rests_here(data, border, shape)) continue;
    SCREE_ASSERT(is_listed[row] != 0);
    SCREE_ASSERT(is_in_box(shapes.fat_bounds[shape]));
    settled.push_back(shape);
  }
  for (const Halo& halo : border.halos) {
    if (halo.resting_list != resting.lists || halo.resting_seen != resting.shapes.size()) continue;
    std::vector<std::int32_t> near = halo.near_resting;
    std::sort(near.begin(), near.end());
    for (const std::int32_t shape : settled) {
      SCREE_ASSERT(!bounds_meet(shapes.fat_bounds[shape], halo.resting_box) ||
                   std::binary_search(near.begin(), near.end(), shape));
    }
  }
}

}  // namespace

void validate_members(const WorldData& data) {
  if (!is_validated(data)) return;
  const Bodies& bodies = data.bodies;
  const Shapes& shapes = data.shapes;
  const Joints& joints = data.joints;
  const auto is_of = [&](std::size_t body, BodyType type) {
    return (bodies.flags[body] & (kBodyAlive | kBodyAsleep)) == kBodyAlive && bodies.type[body] == type &&
           bodies.is_absent[body] == 0;
  };
  const auto body_changed = [&](std::size_t body) {
    return is_changed(bodies, static_cast<std::int32_t>(body));
  };
  if (const Border* const border = border_of(data)) validate_resting(data, *border);
  validate_list(
      bodies.awake, bodies.flags.size(), [&](std::size_t body) { return is_of(body, BodyType::dynamic); },
      body_changed);
  validate_list(
      bodies.kinematic, bodies.flags.size(),
      [&](std::size_t body) { return is_of(body, BodyType::kinematic); }, body_changed);
  validate_list(
      shapes.moving, shapes.flags.size(),
      [&](std::size_t shape) {
        return shapes.tree[shape] == TreeKind::awake || shapes.tree[shape] == TreeKind::kinematic;
      },
      [&](std::size_t shape) { return bodies.all_changed || shapes.is_changed[shape] != 0; });
  validate_list(
      joints.active, joints.flags.size(),
      [&](std::size_t joint) {
        const JointBodies ends = joints.bodies[joint];
        constexpr std::uint8_t kWhole = kJointAlive | kJointEnabled;
        return (joints.flags[joint] & kWhole) == kWhole &&
               (is_awake_dynamic(bodies, ends.a) || is_awake_dynamic(bodies, ends.b)) &&
               knows(border_of(data), ends.a, ends.b);
      },
      [&](std::size_t joint) {
        const JointBodies ends = joints.bodies[joint];
        return joints.all_changed || joints.is_changed[joint] != 0 || is_changed(bodies, ends.a) ||
               is_changed(bodies, ends.b);
      });
}

}  // namespace scree

#endif
