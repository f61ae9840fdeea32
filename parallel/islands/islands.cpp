// The data of the island phases. See islands.h.
#include <parallel/islands/islands.h>

namespace scree {

Islands& islands_of(WorldData& data) {
  if (data.islands == nullptr) data.islands = std::make_unique<Islands>();
  return static_cast<Islands&>(*data.islands);
}

}  // namespace scree
