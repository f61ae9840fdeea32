// See link.h.
#include <tools/rollback/link.h>

#include <algorithm>
#include <utility>

namespace scree::rollback {

void Link::send(int tick, Packet packet) {
  ++sent_;
  // Both are drawn for every packet: the fate of one does not change that of the next.
  const bool is_lost = static_cast<double>(random_.unit()) * 100.0 < options_.loss;
  const int late = static_cast<int>(random_.below(static_cast<std::uint32_t>(options_.jitter) + 1));
  if (is_lost) {
    ++lost_;
    return;
  }
  under_way_.push_back({tick + options_.delay + late, std::move(packet)});
}

std::vector<Packet> Link::receive(int tick) {
  const auto arrived = std::stable_partition(under_way_.begin(), under_way_.end(),
                                             [&](const Traveler& one) { return one.arrival > tick; });
  std::stable_sort(arrived, under_way_.end(),
                   [](const Traveler& a, const Traveler& b) { return a.arrival < b.arrival; });
  std::vector<Packet> packets;
  for (auto one = arrived; one != under_way_.end(); ++one) packets.push_back(std::move(one->packet));
  under_way_.erase(arrived, under_way_.end());
  return packets;
}

}  // namespace scree::rollback
