// Notes the approach speeds of contacts, before the solver changes the velocities.
#include <parallel/events/contact_questions.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

constexpr int kContactsPerChunk = 1024;

float approach_speed(const WorldData& data, const Manifold& manifold, float dt) {
  const VelocityRow& a = data.bodies.velocity[manifold.row_a];
  const VelocityRow& b = data.bodies.velocity[manifold.row_b];
  const Vec3 normal = to_vec3(manifold.normal);
  const Vec3 tangent_1 = tangent_of(normal), tangent_2 = cross(normal, tangent_1);
  const Vec3 spin = to_vec3(b.angular) - to_vec3(a.angular);
  const Vec3 relative = to_vec3(b.linear) + cross(to_vec3(b.angular), to_vec3(manifold.arm_b)) -
                        to_vec3(a.linear) - cross(to_vec3(a.angular), to_vec3(manifold.arm_a));
  const float at_center = dot(relative, normal);
  const float spin_1 = dot(spin, tangent_1), spin_2 = dot(spin, tangent_2);
  // The nearest point, and those that have met or will within the step.
  const float near = std::max(nearest_of(manifold), kLinearSlop);
  float fastest = 0.0f;
  for (unsigned k = 0; k < (manifold.info & kManifoldPointMask); ++k) {
    const float approach = -(at_center + manifold.point_v[k] * spin_1 - manifold.point_u[k] * spin_2);
    if (!(manifold.separation[k] <= std::max(near, approach * dt))) continue;
    fastest = approach > fastest ? approach : fastest;
  }
  return fastest;
}

}  // namespace

void note_approach(WorldData& data, float dt, Crew& crew) {
  if (!asks_for_events(data)) return;
  const Contacts& contacts = data.contacts;
  data.events.approach.resize_discarding(contacts.now.pair.size());
  crew.run_ranges(static_cast<int>(contacts.active.size()), kContactsPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const std::int32_t row = contacts.active[i];
      if (asked_about(data, contacts.now.pair[row]) == ContactEvents::none) continue;
      data.events.approach[row] = approach_speed(data, contacts.now.manifold[row], dt);
    }
  });
}

}  // namespace scree
