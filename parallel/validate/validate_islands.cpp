// Validation of contacts after collide, and of what is awake after the phases of islands; see
// validate_stages.h.
#ifdef SCREE_ASSERTIONS

#include <core/world/pair_key.h>
#include <core/world/wake.h>
#include <parallel/islands/islands.h>
#include <parallel/validate/validate_stages.h>

#include <algorithm>

namespace scree {

namespace {

bool pair_takes_part(const WorldData& data, const ShapePair& pair) {
  return takes_part(data, {data.shapes.body[pair.a], data.shapes.body[pair.b]});
}

// The body that can be pushed, or of two the one that the kernel chose, is B. What is fixed is row 0.
void validate_bodies_of(const WorldData& data, const ShapePair& pair, const Manifold& manifold) {
  const std::int32_t first = data.shapes.body[pair.a], second = data.shapes.body[pair.b];
  SCREE_ASSERT(first != second);
  SCREE_ASSERT(manifold.row_b == first || manifold.row_b == second);
  const std::int32_t other = manifold.row_b == first ? second : first;
  const BodyType type = data.bodies.type[other];
  SCREE_ASSERT(data.bodies.type[manifold.row_b] == BodyType::dynamic);
  SCREE_ASSERT(manifold.row_a == (type == BodyType::fixed ? kFixedRow : other));
  SCREE_ASSERT(((manifold.info & kManifoldStatic) != 0) == (type != BodyType::dynamic));
}

void validate_active_contacts(const WorldData& data) {
  const Contacts& contacts = data.contacts;
  SCREE_ASSERT(ascends(contacts.active, [&](std::int32_t x, std::int32_t y) {
    return comes_before(contacts.now.pair[x], contacts.now.pair[y]) || next_contact(contacts.now, x) == y;
  }));
  for (const std::int32_t contact : contacts.active) {
    SCREE_ASSERT(contacts.now.points[contact] > 0);
    validate_bodies_of(data, contacts.now.pair[contact], contacts.now.manifold[contact]);
  }
}

std::size_t count_parts(const WorldData& data, const PairRows& pairs) {
  std::size_t count = 0;
  for (std::size_t row = 0; row < pairs.pair.size(); ++row) {
    if (!pair_takes_part(data, pairs.pair[row])) continue;
    for_each_contact(data.contacts, pairs.contact[row], [&](std::int32_t) { ++count; });
  }
  return count;
}

bool is_zero(const Column<std::uint8_t>& marks) {
  return std::all_of(marks.begin(), marks.end(), [](std::uint8_t mark) { return mark == 0; });
}

}  // namespace

void validate_contacts(const WorldData& data) {
  if (!is_validated(data)) return;
  const Contacts& contacts = data.contacts;
  for (const ShapePair& pair : contacts.pairs.pair) {
    SCREE_ASSERT((data.shapes.flags[pair.a] & data.shapes.flags[pair.b] & kShapeAlive) != 0);
  }
  validate_active_contacts(data);
  SCREE_ASSERT(contacts.forces.empty() || contacts.forces.size() == contacts.now.pair.size());
}

void validate_islands(const WorldData& data) {
  if (!is_validated(data)) return;
  const Contacts& contacts = data.contacts;
  validate_active_contacts(data);
  if (data.settings.sleeping) {
    std::size_t parts = 0;
    for (const std::int32_t contact : contacts.active) {
      const ShapePair pair = contacts.now.pair[contact];
      SCREE_ASSERT(pair_takes_part(data, pair));
      SCREE_ASSERT(!is_asleep(data.bodies, data.shapes.body[pair.a]) &&
                   !is_asleep(data.bodies, data.shapes.body[pair.b]));
      ++parts;
    }
    SCREE_ASSERT(parts == count_parts(data, contacts.pairs) + count_parts(data, contacts.resting));
  }
  for (const std::int32_t joint : data.joints.active) {
    const JointBodies ends = data.joints.bodies[joint];
    SCREE_ASSERT(!is_asleep(data.bodies, ends.a) && !is_asleep(data.bodies, ends.b));
  }
  const auto& islands = static_cast<const Islands&>(*data.islands);
  SCREE_ASSERT(is_zero(islands.tired));
  SCREE_ASSERT(is_zero(islands.reached));
  SCREE_ASSERT(ascends(islands.fallen_asleep));
}

}  // namespace scree

#endif
