// Spreads marks of bodies over ranks: an island is marked as a whole, wherever its bodies are.
#pragma once

#include <parallel/distributed/messages.h>

#include <cstdint>
#include <vector>

namespace scree {

// Tells ghosts' holders which bodies are marked, again and again, until nobody has news. is_marked(body): of
// own bodies. mark(body): of ghosts; returns whether that is news. settle(): follows what mark() has begun,
// before marks are told. `here`: whether this rank has any marks to tell or to take; all ranks call this, and
// where none of them has, they only agree on that.
template <class IsMarked, class Mark, class Settle>
void spread(Border& border, bool here, IsMarked&& is_marked, Mark&& mark, Settle&& settle) {
  const auto ranks = static_cast<std::int32_t>(border.halos.size());
  const auto halo_of = [&](std::int32_t rank) -> const Halo& {
    return border.halos[static_cast<std::size_t>(rank)];
  };
  std::int64_t news = here ? 1 : 0;
  border.transport.add_up({&news, 1});
  while (news > 0) {
    for (std::int32_t to = 0; to < ranks; ++to) {
      if (halo_of(to).lent.empty()) continue;
      send_rows<std::uint8_t>(border.transport, to, halo_of(to).lent,
                              [&](std::int32_t body) { return std::uint8_t{is_marked(body)}; });
    }
    news = 0;
    for (std::int32_t from = 0; from < ranks; ++from) {
      if (halo_of(from).borrowed.empty()) continue;
      receive_rows<std::uint8_t>(border.transport, from, halo_of(from).borrowed,
                                 [&](std::int32_t body, std::uint8_t is) {
                                   if (is != 0 && mark(body)) news = 1;
                                 });
    }
    settle();
    border.transport.add_up({&news, 1});
  }
}

}  // namespace scree
