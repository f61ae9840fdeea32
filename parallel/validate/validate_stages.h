// Validation of what the stages of a step leave behind, called by step.cpp after each of them in builds with
// assertions only; see core/validate/validate.h.
#pragma once

#include <core/validate/validate.h>
#include <parallel/crew/crew.h>

namespace scree {

#ifdef SCREE_ASSERTIONS

// Lists of bodies and joints that take part ascend and are exact, or `changed` lists what differs.
void validate_members(const WorldData& data);
// Each shape is in the tree that it belongs to, and the boxes of its tree hold its bounds. Pairs rest where
// both shapes stand in frozen trees.
void validate_trees(const WorldData& data);
// Touching contacts come in the order of their pairs, and their manifolds name their bodies.
void validate_contacts(const WorldData& data);
// Islands are awake or asleep as a whole; what joins awake bodies is listed.
void validate_islands(const WorldData& data);
// No two constraints of one color share a body that they push, but a hub.
void validate_colors(const WorldData& data);
// Every constraint has one lane, no lane names a row that is not there, and chunks that are solved side by
// side share no body that they push.
void validate_blocks(const WorldData& data, const Crew& crew);
// What stands for the fixed world has not moved; impulses of contacts push.
void validate_impulses(const WorldData& data);
// Events ascend.
void validate_events(const WorldData& data);
// Poses and velocities are finite, and rotations of unit length.
void validate_motion(const WorldData& data);

#else

inline void validate_members(const WorldData&) {}
inline void validate_trees(const WorldData&) {}
inline void validate_contacts(const WorldData&) {}
inline void validate_islands(const WorldData&) {}
inline void validate_colors(const WorldData&) {}
inline void validate_blocks(const WorldData&, const Crew&) {}
inline void validate_impulses(const WorldData&) {}
inline void validate_events(const WorldData&) {}
inline void validate_motion(const WorldData&) {}

#endif

}  // namespace scree
