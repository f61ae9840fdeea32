// The data of the island phases. See islands.h.
#include <parallel/islands/islands.h>

namespace scree {

Islands& islands_of(WorldData& data) {
  if (data.islands == nullptr) data.islands = std::make_unique<Islands>();
  return static_cast<Islands&>(*data.islands);
}

void Islands::report(const Visit& visit) const {
  const auto column = [&](const char* name, const auto& cells) {
    visit(ColumnKind::scratch, name, cells.data(), cells.size() * sizeof(*cells.data()),
          cells.capacity_bytes());
  };
  column("parent", parent);
  column("tired", tired);
  column("kept_awake", kept_awake);
  column("candidates", candidates);
  column("touched", touched);
  column("pulled", pulled);
  column("fallen_asleep", fallen_asleep);
  column("reached", reached);
  column("remaining", remaining);
  column("fixed_ends", fixed_ends);
  column("places", places);
}

void Islands::forget() noexcept {  // marks of a step that ran out of memory
  tired.clear();
  reached.clear();
}

}  // namespace scree
