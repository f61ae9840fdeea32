// See state_system.h.
#include <parallel/solvers/whole_system/state_system.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

struct GatheredRows {
  std::int32_t item, body_a, body_b;
  StatedLane lane;
  ConstraintRows rows;
};
using Gathered = std::vector<GatheredRows>;

StatedLane lane_of(const simd::ConstraintChunk& chunk, std::int32_t lane, const simd::Kernels& kernels) {
  const std::int32_t lanes = kernels.lanes, first = lane - (lane - chunk.first_lane) % lanes;
  return {lane, first, lanes, false, false};
}

void sort_joints(Gathered& list) {
  std::sort(list.begin(), list.end(), [](const auto& x, const auto& y) { return x.item < y.item; });
}

// In the order of their pairs: which row a contact has depends on the contacts before it.
void sort_contacts(const Contacts& contacts, Gathered& list) {
  std::vector<std::int32_t> place(contacts.now.pair.size());
  std::int32_t next = 0;
  for (const std::int32_t contact : contacts.active) place[static_cast<std::size_t>(contact)] = next++;
  std::sort(list.begin(), list.end(), [&](const auto& x, const auto& y) {
    return place[static_cast<std::size_t>(x.item)] < place[static_cast<std::size_t>(y.item)];
  });
}

Gathered gather_joints(const WorldData& data, const Constraints& constraints, const simd::JointArgs& args,
                       Crew& crew) {
  Gathered gathered;
  std::vector<ConstraintRows> rows(constraints.joint_lanes.size());
  for (const simd::ConstraintChunk& chunk : constraints.joint_chunks) {
    crew.kernels().joint.variant[chunk.variant].state_rows(args, chunk, rows.data());
    for (int lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const std::int32_t joint = constraints.joint_lanes[lane];
      const JointFrames& frames = data.joints.frames[joint];
      StatedLane at = lane_of(chunk, lane, crew.kernels());
      at.peaks = chunk.peaks;
      at.remembers = crew.kernels().joint.variant[chunk.variant].remembers;
      gathered.push_back({joint, frames.row_a, frames.row_b, at, rows[static_cast<std::size_t>(lane)]});
    }
  }
  sort_joints(gathered);
  return gathered;
}

Gathered gather_contacts(const WorldData& data, const Constraints& constraints, const simd::ContactArgs& args,
                         Crew& crew) {
  Gathered gathered;
  std::vector<ConstraintRows> rows(constraints.contact_lanes.size());
  for (const simd::ConstraintChunk& chunk : constraints.contact_chunks) {
    crew.kernels().contact.state_rows(args, chunk, rows.data());
    for (int lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const std::int32_t contact = constraints.contact_lanes[lane];
      const Manifold& manifold = data.contacts.now.manifold[contact];
      gathered.push_back({contact, manifold.row_a, manifold.row_b, lane_of(chunk, lane, crew.kernels()),
                          rows[static_cast<std::size_t>(lane)]});
    }
  }
  sort_contacts(data.contacts, gathered);
  return gathered;
}

}  // namespace

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

  const Gathered joints = gather_joints(data, constraints, joint, crew);
  const Gathered contacts = gather_contacts(data, constraints, contact, crew);
  for (const Gathered* list : {&joints, &contacts}) {
    for (const GatheredRows& each : *list) {
      stated.constraints.push_back({each.rows, place[static_cast<std::size_t>(each.body_a)],
                                    place[static_cast<std::size_t>(each.body_b)]});
      stated.is_contact.push_back(list == &contacts);
      stated.item.push_back(each.item);
      stated.lane.push_back(each.lane);
    }
  }
  return stated;
}

std::vector<ConstraintRows> state_joints(SolveStep& step, const simd::JointArgs& joint) {
  std::vector<ConstraintRows> rows;
  for (const GatheredRows& each : gather_joints(step.data, step.constraints, joint, step.crew))
    rows.push_back(each.rows);
  return rows;
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

SystemPolicy rigid_policy_of(const WorldData& data, float substep) {
  SystemPolicy policy;
  policy.pass = SystemPolicy::Pass::rigid;
  policy.substep = double{substep};
  policy.push_speed = data.settings.push_speed;
  policy.max_hertz = 0.25 / policy.substep;
  policy.baumgarte = data.settings.solver_options.baumgarte;
  policy.slop = data.settings.solver_options.slop;
  return policy;
}

}  // namespace scree
