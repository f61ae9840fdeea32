// Spreads marks of bodies over ranks: an island is marked as a whole, wherever its bodies are.
#pragma once

#include <parallel/distributed/messages.h>

#include <cstdint>

namespace scree {

// Tells ghosts' holders which bodies are marked, again and again, until nobody has news. is_marked(body): of
// own bodies. mark(body): of ghosts; returns whether that is news. settle(): follows what mark() has begun,
// before marks are told. `here`: whether this rank has any marks to tell or to take; all ranks call this, and
// where none of them has, they only agree on that.
template <class IsMarked, class Mark, class Settle>
void spread(Border& border, bool here, IsMarked&& is_marked, Mark&& mark, Settle&& settle) {
  std::int64_t news = here ? 1 : 0;
  border.transport.add_up({&news, 1});
  while (news > 0) {
    news = 0;
    share_halos<std::uint8_t>(
        border, [](std::int32_t) { return true; },
        [&](std::int32_t body) { return std::uint8_t{is_marked(body)}; },
        [&](std::int32_t body, std::uint8_t is) {
          if (is != 0 && mark(body)) news = 1;
        });
    settle();
    border.transport.add_up({&news, 1});
  }
}

}  // namespace scree
