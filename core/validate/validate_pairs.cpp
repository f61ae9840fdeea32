// Validation of pairs and their contacts; see validate.h.
#ifdef SCREE_ASSERTIONS

#include <core/validate/validate.h>
#include <core/world/pair_key.h>

#include <algorithm>
#include <utility>

namespace scree {

namespace {

// The contact of a row of pairs. That a contact names its pair shows that it belongs to no other one.
void validate_contact(const WorldData& data, const ShapePair& pair, std::int32_t contact) {
  const ContactRows& rows = data.contacts.now;
  const Manifold& manifold = rows.manifold[contact];
  const auto bodies = static_cast<std::int32_t>(data.bodies.flags.size());
  SCREE_ASSERT(rows.pair[contact].a == pair.a && rows.pair[contact].b == pair.b);
  SCREE_ASSERT(rows.points[contact] > 0 && rows.points[contact] <= kMaxManifoldPoints);
  SCREE_ASSERT((manifold.info & kManifoldPointMask) == rows.points[contact]);
  SCREE_ASSERT(manifold.row_a == kFixedRow || (manifold.row_a >= kFirstBody && manifold.row_a < bodies));
  SCREE_ASSERT(manifold.row_b >= kFirstBody && manifold.row_b < bodies);
}

// Returns how many touch.
std::size_t validate_rows(const WorldData& data, const PairRows& pairs) {
  const std::size_t count = pairs.pair.size();
  const auto shapes = static_cast<std::int32_t>(data.shapes.flags.size());
  SCREE_ASSERT(pairs.contact.size() == count);
  SCREE_ASSERT(pairs.axis.empty() || pairs.axis.size() == count);
  std::size_t contacts = 0;
  for (std::size_t row = 0; row < count; ++row) {
    const ShapePair pair = pairs.pair[row];
    SCREE_ASSERT(pair.a >= 0 && pair.a < pair.b && pair.b < shapes);
    SCREE_ASSERT(pairs.contact[row] >= -1);
    for_each_contact(data.contacts, pairs.contact[row], [&](std::int32_t contact) {
      validate_contact(data, pair, contact);
      SCREE_ASSERT(++contacts <= data.contacts.now.pair.size());  // and no list runs in a circle
    });
  }
  return contacts;
}

// An end names a row of `resting` and one of its sides; see RestingLinks.
std::int32_t shape_at(const Contacts& contacts, std::uint32_t end) {
  const ShapePair pair = contacts.resting.pair[(end - 1) / 2];
  return (end - 1) % 2 == 0 ? pair.a : pair.b;
}

// Each side of each row stands once in the list of its shape, whose links back agree.
void validate_resting_lists(const WorldData& data) {
  const Contacts& contacts = data.contacts;
  const std::size_t ends = 2 * contacts.resting.pair.size();
  SCREE_ASSERT(contacts.resting_links.size() == contacts.resting.pair.size());
  std::size_t listed = 0;
  for (std::size_t row = 0; row < data.shapes.first_resting.size(); ++row) {
    std::uint32_t before = 0;
    for (std::uint32_t end = data.shapes.first_resting[row]; end != 0;) {
      SCREE_ASSERT(end <= ends);
      SCREE_ASSERT(std::cmp_equal(shape_at(contacts, end), row));
      const RestingLinks& links = contacts.resting_links[(end - 1) / 2];
      SCREE_ASSERT(links.previous[(end - 1) % 2] == before);
      SCREE_ASSERT(++listed <= ends);  // and does not run in a circle
      before = end;
      end = links.next[(end - 1) % 2];
    }
  }
  SCREE_ASSERT(listed == ends);
}

void validate_events_at_rest(const WorldData& data) {
  const Events& events = data.events;
  const PairRows& pairs = data.contacts.resting;
  SCREE_ASSERT(events.resting.empty() || events.resting.size() == pairs.pair.size());
  std::int64_t touches = 0;
  for (std::size_t row = 0; row < events.resting.size(); ++row) {
    if (events.resting[row].events == 0) continue;
    SCREE_ASSERT(key_of(events.resting[row]) == key_of(pairs.pair[row]));
    SCREE_ASSERT(pairs.contact[row] >= 0);
    ++touches;
  }
  SCREE_ASSERT(events.resting_touches == touches);
}

}  // namespace

void validate_pairs(const WorldData& data) {
  if (!is_validated(data)) return;
  const Contacts& contacts = data.contacts;
  SCREE_ASSERT(ascends(contacts.pairs.pair, comes_before));
  const std::size_t moving = validate_rows(data, contacts.pairs);
  const std::size_t resting = validate_rows(data, contacts.resting);
  SCREE_ASSERT(std::cmp_equal(contacts.resting_contacts, resting));
  validate_resting_lists(data);
  for (const ShapePair& pair : contacts.resting.pair) {
    SCREE_ASSERT(
        !std::binary_search(contacts.pairs.pair.begin(), contacts.pairs.pair.end(), pair, comes_before));
  }
  SCREE_ASSERT(lists_exactly(contacts.free_rows, contacts.now.pair.size(),
                             [&](std::size_t row) { return contacts.now.points[row] == 0; }));
  SCREE_ASSERT(contacts.free_rows.size() + moving + resting == contacts.now.pair.size());
  validate_events_at_rest(data);
}

}  // namespace scree

#endif
