// Wakes sleeping bodies that joints tie to kinematic bodies which move.
#include <core/constraints/joint_parameters.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>

namespace scree {

bool wake_pulled_bodies(WorldData& data) {
  const Bodies& bodies = data.bodies;
  bool any = false;
  for (const std::int32_t body : bodies.kinematic) {
    if (bodies.first_joint[body] < 0 || is_still(bodies.velocity[body])) continue;
    for (std::int32_t joint = bodies.first_joint[body]; joint >= 0;
         joint = next_joint(data.joints, joint, body)) {
      const Ends ends = joint_ends(data, joint);
      const std::int32_t other = ends.a == body ? ends.b : ends.a;
      if (!is_enabled(data.joints, joint) || !is_asleep(bodies, other)) continue;
      wake_body(data, other);
      any = true;
    }
  }
  return any;
}

}  // namespace scree
