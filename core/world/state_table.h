// Walks the state table: every column of a world, with its kind and its store's name. The memory report and
// the tests' comparison of whole states are made from it; so is whatever else must not forget a column.
#pragma once

#include <core/geometry/hull/hull_store.h>
#include <core/world/world_data.h>

namespace scree {

// Calls visit(kind, store, name, column) for the columns of the public stores, in a fixed order.
template <class Visit>
void for_each_column(WorldData& data, Visit&& visit) {
  const auto within = [&visit](const char* store) {
    return [&visit, store](ColumnKind kind, const char* name, auto& column) {
      visit(kind, store, name, column);
    };
  };
  data.bodies.for_each_column(within("bodies"));
  visit(ColumnKind::derived, "bodies", "marks", data.bodies.marks.pages);
  visit(ColumnKind::state, "bodies", "free_slots", data.bodies.free_slots);
  visit(ColumnKind::derived, "bodies", "awake", data.bodies.awake);
  visit(ColumnKind::derived, "bodies", "kinematic", data.bodies.kinematic);
  visit(ColumnKind::derived, "bodies", "to_place", data.bodies.to_place);
  visit(ColumnKind::scratch, "bodies", "to_wake", data.bodies.to_wake);
  visit(ColumnKind::derived, "bodies", "changed", data.bodies.changed);
  data.shapes.for_each_column(within("shapes"));
  visit(ColumnKind::derived, "shapes", "marks", data.shapes.marks.pages);
  visit(ColumnKind::state, "shapes", "free_slots", data.shapes.free_slots);
  visit(ColumnKind::derived, "shapes", "moving", data.shapes.moving);
  visit(ColumnKind::state, "shapes", "dirty", data.shapes.dirty);
  visit(ColumnKind::derived, "shapes", "wakers", data.shapes.wakers);
  visit(ColumnKind::derived, "shapes", "changed", data.shapes.changed);
  data.hulls.for_each_column(within("hulls"));
  visit(ColumnKind::state, "hulls", "free_slots", data.hulls.free_slots);
  data.contacts.pairs.for_each_column(within("contacts.pairs"));
  data.contacts.resting.for_each_column(within("contacts.resting"));
  visit(ColumnKind::derived, "contacts", "resting_marks", data.contacts.resting_marks.pages);
  visit(ColumnKind::derived, "contacts", "resting_links", data.contacts.resting_links);
  visit(ColumnKind::derived, "contacts", "resting_order", data.contacts.resting_order);
  visit(ColumnKind::scratch, "contacts", "roused", data.contacts.roused);
  data.contacts.pairs_before.for_each_column([&visit](ColumnKind, const char* name, auto& column) {
    visit(ColumnKind::scratch, "contacts.pairs_before", name, column);
  });
  data.contacts.now.for_each_column(within("contacts.now"));
  visit(ColumnKind::derived, "contacts", "marks", data.contacts.marks.pages);
  visit(ColumnKind::state, "contacts", "free_rows", data.contacts.free_rows);
  visit(ColumnKind::scratch, "contacts", "last_place", data.contacts.last_place);
  visit(ColumnKind::derived, "contacts", "touching", data.contacts.touching);
  visit(ColumnKind::state, "contacts", "forces", data.contacts.forces);
  visit(ColumnKind::derived, "contacts", "by_shape", data.contacts.by_shape);
  visit(ColumnKind::derived, "contacts", "by_shape_end", data.contacts.by_shape_end);
  visit(ColumnKind::scratch, "contacts", "found", data.contacts.found);
  data.joints.for_each_column(within("joints"));
  visit(ColumnKind::derived, "joints", "marks", data.joints.marks.pages);
  visit(ColumnKind::state, "joints", "free_slots", data.joints.free_slots);
  visit(ColumnKind::derived, "joints", "active", data.joints.active);
  visit(ColumnKind::derived, "joints", "changed", data.joints.changed);
  visit(ColumnKind::state, "events", "touching", data.events.touching);
  visit(ColumnKind::state, "events", "resting", data.events.resting);
  visit(ColumnKind::derived, "events", "asked_of", data.events.asked_of);
  visit(ColumnKind::scratch, "events", "before", data.events.before);
  visit(ColumnKind::scratch, "events", "begins", data.events.begins);
  visit(ColumnKind::scratch, "events", "persists", data.events.persists);
  visit(ColumnKind::scratch, "events", "ends", data.events.ends);
  visit(ColumnKind::scratch, "events", "restored", data.events.restored);
  visit(ColumnKind::scratch, "events", "quarantined", data.events.quarantined);
  visit(ColumnKind::state, "events", "woken", data.events.woken);
  visit(ColumnKind::scratch, "events", "sleep_begins", data.events.sleep_begins);
  visit(ColumnKind::scratch, "events", "sleep_ends", data.events.sleep_ends);
  visit(ColumnKind::state, "events", "lost", data.events.lost);
  visit(ColumnKind::scratch, "events", "broken", data.events.broken);
  visit(ColumnKind::scratch, "events", "destroyed", data.events.destroyed);
  visit(ColumnKind::scratch, "events", "moved", data.events.moved);
  visit(ColumnKind::scratch, "events", "judged", data.events.judged);
  visit(ColumnKind::scratch, "events", "judged_pairs", data.events.judged_pairs);
  visit(ColumnKind::scratch, "events", "pairs", data.events.pairs);
  visit(ColumnKind::scratch, "events", "contacts", data.events.contacts);
  visit(ColumnKind::scratch, "events", "rows", data.events.rows);
  visit(ColumnKind::scratch, "events", "impulse", data.events.impulse);
  visit(ColumnKind::scratch, "events", "approach", data.events.approach);
  visit(ColumnKind::scratch, "events", "verdicts", data.events.verdicts);
  visit(ColumnKind::scratch, "events", "counts", data.events.counts);
}

// Calls visit(kind, store, name, bytes, capacity_bytes) for the columns of the stores and of the stages'
// parts.
template <class Visit>
void for_each_column_size(WorldData& data, Visit&& visit) {
  for_each_column(data, [&visit](ColumnKind kind, const char* store, const char* name, auto& column) {
    visit(kind, store, name, column.span().size_bytes(), column.capacity_bytes());
  });
  const std::size_t geometry = hull_bytes(data.hulls);
  visit(ColumnKind::state, "hulls", "geometry", geometry, geometry);
  const std::size_t moments = data.bodies.moments.size() * sizeof(MassMoments);
  visit(ColumnKind::derived, "bodies", "moments", moments, moments);
  const auto report = [&visit](const std::unique_ptr<Part>& part, const char* store) {
    if (part == nullptr) return;
    part->report(
        [&visit, store](ColumnKind kind, const char* name, const void*, std::size_t bytes,
                        std::size_t capacity_bytes) { visit(kind, store, name, bytes, capacity_bytes); });
  };
  report(data.broad_phase, "broad_phase");
  report(data.narrow_phase, "narrow_phase");
  report(data.constraints, "constraints");
  report(data.islands, "islands");
}

}  // namespace scree
