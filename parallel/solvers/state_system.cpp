// See state_system.h.
#include <parallel/solvers/state_system.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

StatedWorld state_world(WorldData& data, const simd::ContactArgs& contact, const simd::JointArgs& joint,
                        Crew& crew) {
  const Constraints& constraints = constraints_of(data);
  const Bodies& bodies = data.bodies;
  StatedWorld stated;
  std::vector<std::int32_t> place(bodies.flags.size(), 0);
  stated.bodies.push_back({});
  stated.row.push_back(kFixedRow);
  const auto add_bodies = [&](const Column<std::int32_t>& list) {
    for (const std::int32_t body : list) {
      place[static_cast<std::size_t>(body)] = static_cast<std::int32_t>(stated.bodies.size());
      stated.bodies.push_back({bodies.inertia[body], bodies.velocity[body]});
      stated.row.push_back(body);
    }
  };
  add_bodies(bodies.awake);
  add_bodies(bodies.kinematic);

  const auto add = [&](const ConstraintRows& rows, std::int32_t a, std::int32_t b, bool is_contact,
                       std::int32_t item) {
    stated.constraints.push_back(
        {rows, place[static_cast<std::size_t>(a)], place[static_cast<std::size_t>(b)]});
    stated.is_contact.push_back(is_contact);
    stated.item.push_back(item);
  };
  std::vector<ConstraintRows> rows(constraints.joint_lanes.size());
  for (const simd::ConstraintChunk& chunk : constraints.joint_chunks) {
    crew.kernels().joint.variant[chunk.variant].state_rows(joint, chunk, rows.data());
    for (int lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const JointFrames& frames = data.joints.frames[constraints.joint_lanes[lane]];
      add(rows[static_cast<std::size_t>(lane)], frames.row_a, frames.row_b, false,
          constraints.joint_lanes[lane]);
    }
  }
  rows.resize(constraints.contact_lanes.size());
  for (const simd::ConstraintChunk& chunk : constraints.contact_chunks) {
    crew.kernels().contact.state_rows(contact, chunk, rows.data());
    for (int lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const Manifold& manifold = data.contacts.now.manifold[constraints.contact_lanes[lane]];
      add(rows[static_cast<std::size_t>(lane)], manifold.row_a, manifold.row_b, true,
          constraints.contact_lanes[lane]);
    }
  }
  return stated;
}

SystemPolicy policy_of(const WorldData& data, float dt, SystemPolicy::Pass pass) {
  const WorldSettings& settings = data.settings;
  SystemPolicy policy;
  policy.pass = pass;
  policy.substep = double{dt} / settings.substeps;
  policy.push_speed = settings.push_speed;
  policy.max_hertz = 0.25 / policy.substep;
  policy.joint_hertz = policy.max_hertz;
  policy.joint_damping_ratio = 2;
  policy.contact_hertz = std::min<double>(settings.contact_hertz, 0.125 / policy.substep);
  policy.contact_damping_ratio = settings.contact_damping_ratio;
  policy.static_contact_hertz = 2 * policy.contact_hertz;
  policy.static_contact_damping_ratio = 0.5 * policy.contact_damping_ratio;
  return policy;
}

}  // namespace scree
