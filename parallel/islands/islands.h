// Islands: sets of bodies that hang together by contacts and joints, and union-find over them.
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>

namespace scree {

// clang-format off
#define SCREE_ISLAND_MEMBERS(ROWS, LIST, VALUE, TABLE, OTHER)                                                   \
  LIST (scratch, std::int32_t, parent)     /* find_islands; by body: towards the island's smallest body */      \
  LIST (scratch, std::uint8_t, tired)      /* find_islands; by body: may fall asleep; zero between the steps */ \
  LIST (scratch, std::uint8_t, kept_awake) /* find_islands; by root: somebody in it is not tired */             \
  LIST (scratch, std::int32_t, candidates) /* find_islands; bodies that may fall asleep or wake, ascending */   \
  LIST (scratch, std::int32_t, touched)    /* find_islands; contacts of an awake and a sleeping body */         \
  LIST (scratch, std::int32_t, pulled)     /* find_islands; joints of an awake and a sleeping body */           \
  LIST (scratch, std::uint8_t, reached)    /* rouse_islands; by body: see there; zero between the steps */      \
  LIST (scratch, std::int32_t, remaining)  /* find_islands; touching contacts after some fell asleep */         \
  LIST (scratch, std::int32_t, fixed_ends) /* find_islands; of the active joints, a body as often as it has some */ \
  VALUE(derived, std::int64_t, joints_judged, 0) /* refresh_joints; looked at in this step for who is active */ \
  LIST (scratch, std::int32_t, places)     /* find_islands, refresh_lists; by chunk: where its part begins */
// clang-format on
SCREE_PART(Islands, SCREE_ISLAND_MEMBERS)

Islands& islands_of(WorldData& data);

// Bodies::changed -> Joints::changed. Called by refresh_lists, before it forgets them.
void note_joints(WorldData& data);
// Joints::changed -> Joints::active.
void refresh_joints(WorldData& data, Islands& islands, Crew& crew);

// Wakes the islands of the sleeping bodies that Islands::touched and Islands::pulled name, and lists their
// contacts at rest, in the order of the pairs: Contacts::roused.
void rouse_islands(WorldData& data, Islands& islands, Crew& crew);

}  // namespace scree
