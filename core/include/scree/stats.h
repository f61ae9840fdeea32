// What the last step did: counts, times, energy and, on request, quality.
#pragma once

#include <cstdint>

namespace scree {

/// The phases of a step, in order; see scree::phase_name.
enum class Phase : std::uint8_t {
  refresh_user_rows,  ///< the callback of user joints
  find_pairs,         ///< candidate pairs from bounds
  collide,            ///< contacts of the pairs
  find_islands,       ///< which bodies wake and fall asleep
  color_constraints,  ///< independent batches of contacts and joints
  pack_blocks,        ///< constraint blocks for the solver
  solve,              ///< velocities and poses
  store_impulses,     ///< impulses for the next step, and joints that break
  list_events,        ///< events of contacts
  sweep_fast_bodies,  ///< continuous collision
  finish_step,        ///< bounds, sleep timers and energy
};
/// The number of phases.
inline constexpr int kPhaseCount = 11;

/// The name of the function that is the phase ("find_pairs", ...).
constexpr const char* phase_name(Phase phase) {
  constexpr const char* kNames[kPhaseCount] = {
      "refresh_user_rows", "find_pairs",        "collide",    "find_islands",
      "color_constraints", "pack_blocks",       "solve",      "store_impulses",
      "list_events",       "sweep_fast_bodies", "finish_step"};
  return kNames[static_cast<int>(phase)];
}

/// Figures of the last step. Times differ from run to run; everything else is deterministic. A step of no
/// length solves nothing: its solver's figures are those of a new StepStats, and the kinetic energy is that
/// of the step before.
struct StepStats {
  std::uint64_t step = 0;            ///< steps taken since the world was created
  double phase_ms[kPhaseCount]{};    ///< milliseconds spent in each phase
  double step_ms = 0.0;              ///< milliseconds of the whole step
  std::int64_t pairs = 0;            ///< candidate pairs of the broad phase
  std::int64_t contacts = 0;         ///< manifolds with at least one point, those of sleeping bodies included
  std::int64_t contact_points = 0;   ///< of the contacts that were solved, so none of sleeping bodies; those
                                     ///< that lie apart and are only watched included
  std::int64_t joints = 0;           ///< of awake bodies: those that were solved
  std::int64_t awake_bodies = 0;     ///< dynamic bodies that are not asleep
  std::int64_t restored_bodies = 0;  ///< bodies whose state became non-finite in this step: they were put
                                     ///< back to where the step found them, at rest
  std::int64_t swept_bodies = 0;     ///< bodies fast enough to be swept, with WorldSettings::continuous
  std::int64_t sweep_hits = 0;       ///< of them, those that were put back to where they met something
  std::int64_t islands =
      0;           ///< islands examined for sleep in this step; 0 where no body was slow for long enough
  int colors = 0;  ///< independent batches, those against fixed bodies included
  int stages = 0;  ///< parallel stages of the whole step
  std::int64_t unsound_rules = 0;  ///< contacts for which a hook gave rules out of range: they kept their own
  double lane_fill = 1.0;        ///< used lanes over all lanes of the constraint blocks; depends on the width
  double kinetic_energy = 0.0;   ///< J, at the end of the step
  double residual = 0.0;         ///< m/s, only with WorldSettings::measure_residual: the largest velocity
                                 ///< error of a contact, or of what a joint
                                 ///< holds, as the last relax pass met it. Of other solvers than the soft
                                 ///< step the largest change of speed that any row still asks for; methods
                                 ///< over the whole system always fill it
  int solver_iterations = 0;     ///< of methods over the whole system, see Solver: the most of a substep
  bool solver_singular = false;  ///< Solver::direct: rows contradicted each other, and a residual is left
  std::int64_t overlaps = 0;     ///< manifolds of awake bodies that overlap at the end of the step; this and
                                 ///< penetration only with WorldSettings::measure_penetration
  double penetration_mean =
      0.0;  ///< m, the deepest point of each overlapping manifold, mean over all of them
  double penetration_p999 = 0.0;  ///< m, 99.9 % of the overlapping manifolds are at most this deep
  double penetration_max = 0.0;   ///< m
};

}  // namespace scree
