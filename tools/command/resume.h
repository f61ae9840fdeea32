// Goes on from checkpoints.
#pragma once

#include <scree/scree.h>
#include <tools/command/run.h>
#include <tools/command/team.h>
#include <tools/scenes/scene.h>

#include <vector>

namespace scree::command {

// Makes a world that is filled with a scene what the checkpoint of the options has, by the settings of the
// world, and returns how many of so many steps it has taken. `bodies` are those of the whole scene; those
// that have come and gone until then do so here, too, which takes no steps: `bodies` has their handles then.
// Throws Error where the checkpoint is of another scene, or has taken all steps.
int resume(World& world, const scenes::Scene& script, std::vector<BodyId>& bodies, const RunOptions& options,
           int steps);
// The same of a team's world. `checkpoint` was read by the team, which is what it becomes.
int resume(Team& team, DistributedWorld checkpoint, const scenes::Scene& script, std::vector<BodyId>& bodies,
           const RunOptions& options, int steps);

}  // namespace scree::command
