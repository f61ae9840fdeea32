// Coloring: gives every touching contact a color such that no two contacts of one color share a dynamic body.
//
// A contact keeps its color while it touches, so that one new contact does not reshuffle the Gauss-Seidel
// order of a resting pile; new ones take the lowest free color in the canonical order of the rows. Contacts
// against bodies that cannot be pushed have colors of their own and are solved last.
#include <parallel/constraints.h>
#include <parallel/stages.h>

#include <bit>

namespace scree {

Constraints& constraints_of(WorldData& data) {
  if (data.constraints == nullptr) data.constraints = std::make_unique<Constraints>();
  return static_cast<Constraints&>(*data.constraints);
}

void Constraints::report(const Visit& visit) const {
  const auto column = [&](const char* name, const auto& cells) {
    visit(ColumnKind::scratch, name, cells.data(), cells.size() * sizeof(*cells.data()),
          cells.capacity_bytes());
  };
  column("dynamic_colors", dynamic_colors);
  column("static_colors", static_colors);
  column("uncolored", uncolored);
  column("histogram", histogram);
  column("keys", keys);
  column("points", points);
  column("rows", rows);
  column("blocks", blocks);
  column("chunks", chunks);
  column("stages", stages);
  column("residual", residual);
  column("depth", depth);
  column("depths", depths);
  column("moving", moving);
  column("kinetic_energy", kinetic_energy);
  column("broken", broken);
}

namespace {

// The masks that a contact's color must be free in, and enters.
struct Masks {
  std::uint64_t& a;
  std::uint64_t& b;
};

Masks masks_of(Constraints& constraints, const Manifold& manifold) {
  const auto a = static_cast<std::size_t>(manifold.row_a), b = static_cast<std::size_t>(manifold.row_b);
  if ((manifold.info & kManifoldStatic) != 0) {
    return {constraints.static_colors[b], constraints.static_colors[b]};
  }
  return {constraints.dynamic_colors[a], constraints.dynamic_colors[b]};
}

}  // namespace

void color_constraints(WorldData& data, Crew&) {
  Constraints& constraints = constraints_of(data);
  ContactRows& contacts = data.contacts.now;
  const std::size_t bodies = data.bodies.pose.size();
  constraints.dynamic_colors.resize(bodies);
  constraints.static_colors.resize(bodies);
  for (const std::int32_t body : data.bodies.awake) {
    constraints.dynamic_colors[static_cast<std::size_t>(body)] = 0;
    constraints.static_colors[static_cast<std::size_t>(body)] = 0;
  }

  constraints.uncolored.clear();
  for (const std::int32_t touching : data.contacts.touching) {
    const auto row = static_cast<std::size_t>(touching);
    const std::uint8_t color = contacts.color[row];
    if (color < kColorLimit) {
      const Masks masks = masks_of(constraints, contacts.manifold[row]);
      const std::uint64_t bit = std::uint64_t{1} << color;
      // A kept color can clash after a body has changed its type or woken.
      if (((masks.a | masks.b) & bit) == 0) {
        masks.a |= bit;
        masks.b |= bit;
        continue;
      }
    }
    constraints.uncolored.push_back(touching);
  }
  for (const std::int32_t touching : constraints.uncolored) {
    const auto row = static_cast<std::size_t>(touching);
    const Masks masks = masks_of(constraints, contacts.manifold[row]);
    const std::uint64_t used = masks.a | masks.b;
    const int color = std::countr_one(used);
    contacts.color[row] = color < kColorLimit ? static_cast<std::uint8_t>(color) : kOverflowColor;
    if (color < kColorLimit) {
      masks.a |= std::uint64_t{1} << color;
      masks.b |= std::uint64_t{1} << color;
    }
  }
}

}  // namespace scree
