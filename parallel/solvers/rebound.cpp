// Restitution: the impacts within a substep, before it moves its bodies, pass by pass. In a pass each body
// has its earliest impacts; what these set in motion comes in the next one. See
// simd/constraints/contact/contact_rebound.cpp for the law.
#include <parallel/solvers/solve_step.h>

#include <algorithm>

namespace scree {

namespace {

// Impacts go on from body to body, one a pass, until none is left. Where that takes longer, the next substep
// goes on; what is left is braked without a rebound where it touches already.
constexpr int kMostPasses = 256;
// Sweeps over the contacts that act at one moment: one suffices for pairs, and 30 for a break of fifteen
// balls.
constexpr int kMostSweeps = 256;
// Passes of a substep that may end before their sweeps have settled, and sweeps of all passes. A block of 27
// cubes that burst apart took 8,800 sweeps in 126 passes, of which 17 had not settled; where masses of 1e30
// kg meet light ones, none settles.
constexpr int kMostUnsettled = 32;
constexpr int kMostSweepsInAll = 16384;

// Fewer chunks than this are not worth waking helpers.
constexpr int kFewChunks = 4;

using ContactKernel = void (*)(const simd::ContactArgs&, const simd::ConstraintChunk&);

// Of all ranks, if the world is divided.
std::int64_t add_up_ranks(const SolveStep& step, std::int64_t count) {
  if (Border* const border = border_of(step.data)) border->transport.add_up({&count, 1});
  return count;
}

// Calls the kernel for all chunks with impacts, or for all that might have any, and returns the number of
// chunks whose state is `state` then. `changed`: what it changes of bodies. `before_turn` is called with the
// turn of each stage.
template <class BeforeTurn>
std::int64_t over_impacts(const SolveStep& step, ContactKernel kernel, bool all, simd::ImpactState state,
                          Refreshed changed, BeforeTurn&& before_turn) {
  const Constraints& constraints = step.constraints;
  std::int64_t count = 0;
  RefreshedPass pass(border_of(step.data), step.data.bodies, changed);
  for (const ColorStage& stage : constraints.stages) {
    pass.before(stage.turn);
    before_turn(stage.turn);
    if (!stage.rich) continue;
    const simd::ConstraintChunk* chunks = constraints.contact_chunks.data() + stage.first_contact_chunk;
    const auto is_asked = [&](const simd::ConstraintChunk& chunk) {
      return simd::is_rich(chunk.variant) && (all || constraints.impacts[chunk.number] != simd::kNoImpacts);
    };
    const auto chunks_end = chunks + stage.contact_chunk_count;
    const auto asked = std::count_if(chunks, chunks_end, is_asked);
    if (asked == 0) continue;
    const auto run_chunk = [&](const simd::ConstraintChunk& chunk) {
      if (is_asked(chunk)) kernel(step.contact, chunk);
    };
    if (stage.serial || (!all && asked < kFewChunks)) {
      step.crew.run_alone(stage.contact_chunk_count, [&](int chunk) { run_chunk(chunks[chunk]); });
    } else {
      over_stage(
          step, stage, run_chunk, [](const simd::ConstraintChunk&) {}, __func__);
    }
    count += std::count_if(chunks, chunks_end, [&](const simd::ConstraintChunk& chunk) {
      return simd::is_rich(chunk.variant) && constraints.impacts[chunk.number] == state;
    });
  }
  pass.finish();
  return add_up_ranks(step, count);
}

std::int64_t over_impacts(const SolveStep& step, ContactKernel kernel, simd::ImpactState state,
                          Refreshed changed) {
  return over_impacts(step, kernel, false, state, changed, [](std::int32_t) {});
}

// Finds the earliest impacts of all bodies; returns the number of chunks that have any.
std::int64_t find_impacts(const SolveStep& step) {
  SharedImpactTimes times(step.constraints, border_of(step.data));
  const std::int64_t found =
      over_impacts(step, step.crew.kernels().contact.find_impacts, true, simd::kImpactsFound,
                   Refreshed::velocity, [&](std::int32_t turn) { times.before(turn); });
  times.finish(found > 0);
  return found;
}

// Contacts that act at one moment push each other until none changes any more. Returns the number of sweeps.
int sweep_impacts(SolveStep& step, ContactKernel kernel) {
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    step.contact.first_sweep = sweep == 0;
    if (over_impacts(step, kernel, simd::kImpactsChange, Refreshed::velocity) == 0) return sweep + 1;
  }
  return kMostSweeps;
}

void forget_times(SolveStep& step) {
  const Constraints& constraints = step.constraints;
  step.crew.run_ranges(step.dynamic_count, kSolveBodyChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i)
      step.contact.impact_times[constraints.moving_bodies[static_cast<std::size_t>(i)]] = {simd::kNoImpact,
                                                                                           simd::kNoImpact};
  });
}

void keep_velocities(SolveStep& step) {
  Constraints& constraints = step.constraints;
  step.crew.run_ranges(step.moving_count, kSolveBodyChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i) {
      const auto row = static_cast<std::size_t>(constraints.moving_bodies[static_cast<std::size_t>(i)]);
      constraints.velocity_before[row] = step.contact.velocity[row];
    }
  });
  step.body.velocity_before = step.contact.velocity_before = constraints.velocity_before.data();
}

}  // namespace

void begin_rebounds(SolveStep& step) {
  Constraints& constraints = step.constraints;
  const bool may_rebound = std::any_of(constraints.stages.begin(), constraints.stages.end(),
                                       [](const ColorStage& stage) { return stage.rich; });
  step.may_rebound = add_up_ranks(step, may_rebound ? 1 : 0) > 0;
  if (!step.may_rebound) return;
  constraints.impacts.resize_discarding(constraints.contact_chunks.size() + constraints.joint_chunks.size());
  constraints.impact_times.resize_discarding(step.data.bodies.velocity.size());
  constraints.velocity_before.resize_discarding(step.data.bodies.velocity.size());
  step.contact.impacts = constraints.impacts.data();
  step.contact.impact_times = constraints.impact_times.data();
  forget_times(step);
}

void rebound(SolveStep& step) {
  if (!step.may_rebound) return;
  const simd::ContactKernels& kernels = step.crew.kernels().contact;
  step.body.velocity_before = step.contact.velocity_before = step.contact.velocity;
  int unsettled = 0, sweeps = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    if (unsettled >= kMostUnsettled || sweeps >= kMostSweepsInAll) return;
    if (find_impacts(step) == 0) return;
    if (pass == 0) keep_velocities(step);
    const int pushes = sweep_impacts(step, kernels.push_impacts);
    const int rubs = sweep_impacts(step, kernels.rub_impacts);
    unsettled += std::max(pushes, rubs) < kMostSweeps ? 0 : 1;
    sweeps += pushes + rubs;
    over_impacts(step, kernels.finish_impacts, simd::kImpactsFound, Refreshed::delta);
    forget_times(step);
  }
}

}  // namespace scree
