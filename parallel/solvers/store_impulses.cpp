// After the substeps: impulses go back to manifolds and joints, for the warm start of the next step, and to
// code that asks for them.
#include <parallel/constraints/constraints.h>
#include <parallel/distributed/border.h>
#include <parallel/solvers/over_blocks.h>
#include <parallel/stages.h>

#include <algorithm>

namespace scree {

namespace {

// Mean, 99.9th percentile and maximum over the manifolds that overlap at the step's end.
void measure_penetration(WorldData& data, const simd::ContactArgs& contact, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  crew.run(static_cast<int>(constraints.contact_chunks.size()), [&](int chunk, int) {
    crew.kernels().contact.measure_depth(contact, constraints.contact_chunks[chunk]);
  });
  constraints.depths.clear();
  double sum = 0.0;
  for (const simd::ConstraintChunk& chunk : constraints.contact_chunks) {
    for (int lane = 0; lane < chunk.lanes; ++lane) {
      const float depth = constraints.depth[chunk.first_lane + lane];
      if (!(depth > 0.0f)) continue;
      constraints.depths.push_back(depth);
      sum += static_cast<double>(depth);
    }
  }
  StepStats& stats = data.stats;
  stats.penetration_mean = stats.penetration_p999 = stats.penetration_max = 0.0;
  const std::size_t count = constraints.depths.size();
  stats.overlaps = static_cast<std::int64_t>(count);
  if (count == 0) return;
  stats.penetration_mean = sum / static_cast<double>(count);
  // Rounded up: of few manifolds this is the deepest.
  float* rank = constraints.depths.begin() + ((count * 999 + 999) / 1000 - 1);
  std::nth_element(constraints.depths.begin(), rank, constraints.depths.end());
  stats.penetration_p999 = static_cast<double>(*rank);
  stats.penetration_max = static_cast<double>(*std::max_element(rank, constraints.depths.end()));
}

// By lane -> by contact row.
void store_impulse_sums(WorldData& data, Crew& crew) {
  const Constraints& constraints = constraints_of(data);
  data.events.impulse.resize_discarding(data.contacts.now.pair.size());
  crew.run(static_cast<int>(constraints.contact_chunks.size()), [&](int index, int) {
    const simd::ConstraintChunk& chunk = constraints.contact_chunks[index];
    for (int lane = chunk.first_lane; lane < chunk.first_lane + chunk.lanes; ++lane) {
      const std::int32_t row = constraints.contact_lanes[lane];
      data.events.impulse[row] = constraints.impulse_sum[lane];
    }
  });
}

}  // namespace

void store_impulses(WorldData& data, float dt, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  if (data.settings.measure_penetration)
    constraints.depth.resize_discarding(constraints.contact_lanes.size());
  const simd::ContactKernels& kernels = crew.kernels().contact;
  const simd::ContactArgs contact = contact_args(data, constraints, dt);
  const simd::JointArgs joint = joint_args(data, constraints, dt);
  // Methods over the whole system have stored theirs.
  const bool in_blocks = data.settings.solver <= Solver::sequential_impulse;
  over_blocks(
      constraints, crew,
      [&](const simd::ConstraintChunk& chunk) {
        if (in_blocks) kernels.store(contact, chunk);
        if (contact.force_sum != nullptr) kernels.store_forces(contact, chunk);
      },
      [&](const simd::ConstraintChunk& chunk) {
        if (in_blocks) crew.kernels().joint.variant[chunk.variant].store(joint, chunk);
      });
  if (asks_for_events(data)) store_impulse_sums(data, crew);
  if (Border* const border = border_of(data)) share_impulses(constraints, *border, data);
  if (data.settings.measure_penetration) measure_penetration(data, contact, crew);
}

}  // namespace scree
