// Islands: sets of bodies that hang together by contacts, and union-find over them.
#pragma once

#include <core/world_data.h>

namespace scree {

struct Islands : Part {
  Column<std::int32_t> parent;      // scratch; find_islands; by body: towards the island's smallest body
  Column<std::uint8_t> kept_awake;  // scratch; find_islands; by root: somebody in it is not tired
  Column<std::int32_t> candidates;  // scratch; find_islands; bodies that may fall asleep, ascending
  Column<std::int32_t> to_wake;     // scratch; find_islands; sleeping bodies that were touched

  void report(const Visit& visit) const override;
};

Islands& islands_of(WorldData& data);

}  // namespace scree
