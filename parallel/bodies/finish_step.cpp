// The end of a step: adds the motion of the step to the poses, then updates all that depends on a pose:
// transforms for the caller, bounds for the next pairs, sleep timers, energy.
#include <parallel/constraints/constraints.h>
#include <parallel/distributed/border.h>
#include <parallel/stages.h>

namespace scree {

namespace {

constexpr int kBodyChunk = 512;  // bodies of one task

// Each body counts on one rank.
bool is_counted(const Border* border, std::int32_t body) {
  return border == nullptr || speaks_for(*border, body);
}

bool any_of_all_ranks(const WorldData& data, bool any) {
  Border* const border = border_of(data);
  return border == nullptr ? any : !border->transport.holds_everywhere(!any);
}

}  // namespace

void finish_step(WorldData& data, float dt, Crew& crew) {
  Constraints& constraints = constraints_of(data);
  Bodies& bodies = data.bodies;
  const int moving = static_cast<int>(constraints.moving_bodies.size());
  const int dynamic_count = static_cast<int>(bodies.awake.size());
  SCREE_ASSERT(constraints.moving_bodies.size() == bodies.awake.size() + bodies.kinematic.size());
  constraints.kinetic_energy.resize_discarding(constraints.moving_bodies.size());
  constraints.non_finite.resize_discarding(constraints.moving_bodies.size());

  constraints.finish_sums.resize_discarding((moving + kBodyChunk - 1) / kBodyChunk);

  const simd::BodyArgs args = body_args(data, dt);
  crew.run_ranges(moving, kBodyChunk, [&](int begin, int end, int) {
    crew.kernels().body.finish(args, begin, end);
    FinishSum sum{};
    const Border* const border = border_of(data);
    for (int i = begin; i < end; ++i) {
      bodies.force[constraints.moving_bodies[i]] = ForceRow{};
      if (i < dynamic_count) sum.kinetic_energy += static_cast<double>(constraints.kinetic_energy[i]);
      if (constraints.non_finite[i] != 0 && is_counted(border, constraints.moving_bodies[i])) ++sum.restored;
    }
    constraints.finish_sums[begin / kBodyChunk] = sum;
  });

  // In the order of the chunks, so that the sum has the same bits for every thread count.
  FinishSum all{};
  for (const FinishSum& sum : constraints.finish_sums) {
    all.kinetic_energy += sum.kinetic_energy;
    all.restored += sum.restored;
  }
  data.stats.kinetic_energy = all.kinetic_energy;
  data.stats.restored_bodies = all.restored;
  data.stats.awake_bodies = dynamic_count;
  update_bounds(data, dt, crew);
  bring_sights(data, crew);  // before types of bodies change, which ranks take up in the next step
  if (any_of_all_ranks(data, data.stats.restored_bodies > 0)) {
    quarantine_bodies(data);
    data.recording.hash.reset();
  }
}

}  // namespace scree
