// Lists the joints to solve: flags of joints and bodies -> Joints::active. Calls, joints that break, and
// bodies that fall asleep, wake or change note the joints that this may concern, and the list is updated for
// these: the cost depends on what is active and what changed, not on what rests. After a restore, and where
// most joints have changed, the list is rebuilt.
#include <core/constraints/joint_parameters.h>
#include <core/world/wake.h>
#include <parallel/crew/list_where.h>
#include <parallel/distributed/border.h>
#include <parallel/islands/islands.h>
#include <parallel/islands/take_up.h>

#include <algorithm>

namespace scree {

namespace {

// Updating is serial, and costs more for each row than rebuilding does.
constexpr std::size_t kCostOfActive = 4, kCostOfChanged = 16;

bool is_active(const WorldData& data, std::int32_t joint) {
  const JointBodies bodies = data.joints.bodies[joint];
  return is_enabled(data.joints, joint) && takes_part(data, joint_ends(data, joint)) &&
         knows(border_of(data), bodies.a, bodies.b);
}

bool is_fixed(const Bodies& bodies, std::int32_t body) { return bodies.type[body] == BodyType::fixed; }

// Joints read the rows of their fixed bodies, whose scratch columns no kernel writes.
void still_fixed(Bodies& bodies, std::int32_t body) {
  bodies.delta[body] = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, 0.0f};
  bodies.inertia[body] = {};
}

void make_active(WorldData& data, Islands& islands, Crew& crew) {
  constexpr int kChunk = 2048;  // joints of one task
  Joints& joints = data.joints;
  for (const std::int32_t joint : joints.active) joints.marks.mark(joint);
  crew.run_ranges(static_cast<int>(joints.active.size()), kChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t joint = joints.active[i];
      if (!is_active(data, joint)) joints.reaction[joint] = {};
    }
  });
  list_where(crew, joints.flags.size(), islands.places, joints.active,
             [&](std::int32_t joint) { return is_active(data, joint); });
  const auto ends_of = [&](std::int32_t i) { return joints.bodies[joints.active[i]]; };
  list_where(
      crew, joints.active.size(), islands.places, islands.fixed_ends,
      [&](std::int32_t i) {
        return is_fixed(data.bodies, ends_of(i).a) || is_fixed(data.bodies, ends_of(i).b);
      },
      [&](std::int32_t i) { return is_fixed(data.bodies, ends_of(i).a) ? ends_of(i).a : ends_of(i).b; });
  for (const std::int32_t body : islands.fixed_ends) still_fixed(data.bodies, body);
  islands.joints_judged += static_cast<std::int64_t>(joints.flags.size());
}

// The other active joints were active before, with the same bodies: a body that was fixed still is.
void change_active(WorldData& data, Islands& islands) {
  Joints& joints = data.joints;
  std::sort(joints.changed.begin(), joints.changed.end());
  for (const std::int32_t joint : joints.changed) joints.marks.mark(joint);
  take_up(joints.active, joints.changed, joints.is_changed, islands.places,
          [&](std::int32_t joint) { return is_active(data, joint); });
  for (const std::int32_t changed : joints.changed) {
    if (!is_active(data, changed)) {
      joints.reaction[changed] = {};
      continue;
    }
    const JointBodies ends = joints.bodies[changed];
    for (const std::int32_t body : {ends.a, ends.b}) {
      if (is_fixed(data.bodies, body)) still_fixed(data.bodies, body);
    }
  }
  islands.joints_judged += static_cast<std::int64_t>(joints.changed.size());
}

}  // namespace

void note_joints(WorldData& data) {
  const Bodies& bodies = data.bodies;
  Joints& joints = data.joints;
  if (joints.flags.empty()) return;
  if (bodies.all_changed || kCostOfChanged * bodies.changed.size() > joints.flags.size()) {
    joints.all_changed = true;
    return;
  }
  for (const std::int32_t body : bodies.changed) {
    for (std::int32_t joint = bodies.first_joint[body]; joint >= 0; joint = next_joint(joints, joint, body)) {
      note_change(joints, joint);
    }
  }
}

void refresh_joints(WorldData& data, Crew& crew) {
  Islands& islands = islands_of(data);
  Joints& joints = data.joints;
  if (!joints.all_changed && joints.changed.empty()) return;
  if (joints.all_changed ||
      kCostOfActive * joints.active.size() + kCostOfChanged * joints.changed.size() > joints.flags.size()) {
    make_active(data, islands, crew);
  } else {
    change_active(data, islands);
  }
  forget_changes(joints);
  joints.all_changed = false;
}

}  // namespace scree
