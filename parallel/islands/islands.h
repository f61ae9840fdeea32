// Islands: sets of bodies that hang together by contacts and joints, and union-find over them.
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>

namespace scree {

struct Islands : Part {
  Column<std::int32_t> parent;      // scratch; find_islands; by body: towards the island's smallest body
  Column<std::uint8_t> tired;       // scratch; find_islands; by body: may fall asleep; zero between the steps
  Column<std::uint8_t> kept_awake;  // scratch; find_islands; by root: somebody in it is not tired
  Column<std::int32_t> candidates;  // scratch; find_islands; bodies that may fall asleep or wake, ascending
  Column<std::int32_t> touched;     // scratch; find_islands; contacts of an awake and a sleeping body
  Column<std::int32_t> pulled;      // scratch; find_islands; joints of an awake and a sleeping body
  Column<std::uint8_t> reached;     // scratch; rouse_islands; by body: see there; zero between the steps
  Column<std::int32_t> remaining;   // scratch; find_islands; touching contacts after some fell asleep
  Column<std::int32_t>
      fixed_ends;  // scratch; find_islands; of the active joints, a body as often as it has some
  std::int64_t joints_judged = 0;  // derived; refresh_joints; looked at in this step for who is active
  Column<std::int32_t> places;     // scratch; find_islands, refresh_lists; by chunk: where its part begins

  void report(const Visit& visit) const override;
  void forget() noexcept override;
};

Islands& islands_of(WorldData& data);

// Bodies::changed -> Joints::changed. Called by refresh_lists, before it forgets them.
void note_joints(WorldData& data);
// Joints::changed -> Joints::active.
void refresh_joints(WorldData& data, Islands& islands, Crew& crew);

// Wakes the islands of the sleeping bodies that Islands::touched and Islands::pulled name, and lists their
// contacts at rest, in the order of the pairs: Contacts::roused.
void rouse_islands(WorldData& data, Islands& islands, Crew& crew);

}  // namespace scree
