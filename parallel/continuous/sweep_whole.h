// Sweeps of whole shapes, for bodies with BodyDef::full_sweep; part of sweep_fast_bodies.cpp.
#pragma once

#include <core/world/world_data.h>
#include <parallel/continuous/sweep_motion.h>
#include <simd/queries/query_kernels.h>

#include <cstdint>

namespace scree::sweeps {

bool is_swept_whole(const WorldData& data, std::int32_t body);

// m, from the center of mass around all shapes of a body.
float reach_of(const WorldData& data, std::int32_t body);

// Whether any point of the body moves farther in the step than contacts look ahead.
bool moves_far(const WorldData& data, std::int32_t body);

// When shapes of two bodies meet after `from`, so that one would be deeper in the other when the step ends
// than a contact leaves it; kNever if they do not. What touches as the step begins is its contact's business.
// Triangles of a mesh stop what comes from their front. The first one is no half-space, and at most one is a
// mesh.
float whole_meeting(const WorldData& data, const simd::QueryKernels& kernels, const std::int32_t (&shapes)[2],
                    const Mover (&movers)[2], float from);

}  // namespace scree::sweeps
