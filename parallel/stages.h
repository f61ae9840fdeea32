// The phases of a step; step.cpp calls them in order.
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <simd/bodies/body_kernels.h>

namespace scree {

// The callback of user joints -> their numbers; throws what it throws, and has changed nothing then.
void list_asked_joints(WorldData& data);  // whose numbers a callback makes
void refresh_user_rows(const World& world, WorldData& data, float dt, Crew& crew);
void refresh_lists(WorldData& data,
                   Crew& crew);  // flags -> lists of awake and kinematic bodies, moving shapes
void update_bounds(WorldData& data, float dt, Crew& crew);  // poses -> shape poses, fat bounds
void find_pairs(WorldData& data, Crew& crew);               // bounds -> candidate pairs
void collide(WorldData& data, Crew& crew);                  // pairs -> manifolds
bool wake_pulled_bodies(WorldData& data);  // moving kinematic bodies -> those asleep that joints tie to them
void wake_touched_islands(WorldData& data, Crew& crew);  // contacts, joints -> sleeping islands that wake
void put_islands_to_sleep(WorldData& data, Crew& crew);  // slow bodies -> islands that fall asleep
void refresh_joints(WorldData& data, Crew& crew);        // joints of awake bodies -> joints to solve
void color_constraints(WorldData& data, Crew& crew);     // new contacts -> independent batches
void pack_blocks(WorldData& data, Crew& crew);           // manifolds -> layout of wide constraint blocks
void solve(WorldData& data, float dt, Crew& crew);       // blocks -> velocities, motion since the step began
void store_impulses(WorldData& data, float dt, Crew& crew);  // blocks -> manifolds, for the next warm start
void break_joints(WorldData& data, Crew& crew);              // reactions -> joints that break
void list_joint_events(WorldData& data, Crew& crew);         // reactions -> joints that bore more than asked
// velocities -> approach speeds, where events are asked for
void note_approach(WorldData& data, float dt, Crew& crew);
void list_body_events(WorldData& data);  // sleep, waking and lost joints -> their events
void list_contact_events(WorldData& data, float dt, Crew& crew);  // manifolds -> begins, persists, ends, hits
void list_sensor_events(WorldData& data, float dt, Crew& crew);   // poses -> what sensors see, begins, ends
// Moves the touch rows of these resting pairs, given in the order of the pairs, to those of moving pairs.
void move_touching(WorldData& data, const Column<std::int32_t>& rows);
void sweep_fast_bodies(WorldData& data, float dt, Crew& crew);  // motion -> shorter motion of those that hit
void finish_step(WorldData& data, float dt, Crew& crew);  // motion -> poses, transforms, bounds, sleep timers
void quarantine_bodies(WorldData& data);                  // bodies that became non-finite -> quarantined ones

simd::BodyArgs body_args(WorldData& data,
                         float dt);  // for the kernels over bodies; list: Constraints::moving_bodies

// Whether events of contacts are asked for, or a listed begin still needs its end.
inline bool asks_for_events(const WorldData& data) {
  return data.settings.contact_events != ContactEvents::none || data.shapes.asking > 0 ||
         !data.events.touching.empty() || data.events.resting_touches > 0;
}

float substep_of(const WorldData& data, float dt);  // s
// What a stored impulse, which acted for `last_substep`, is multiplied with as the first guess for `substep`;
// exactly 1 while nothing changes.
float warm_start_scale(float substep, float last_substep);

}  // namespace scree
