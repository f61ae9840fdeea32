// Walks the state table: every member of a world, with its kind and whatever else is known of it. Saving,
// the memory report and the comparison of worlds are made from it; so is whatever else must not forget a
// column.
#pragma once

#include <core/geometry/hull/hull_store.h>
#include <core/geometry/mesh/mesh_store.h>
#include <core/world/world_data.h>

#include <utility>

namespace scree {

// Calls visit(Member, member) for the members of the public stores, in a fixed order.
template <class Data, class Visit>
void for_each_member(Data& data, Visit&& visit) {
  WorldData::visit_members(data, TablePlace{"world"}, visit);
}

// Calls visit(Member, column) for those that are columns.
template <class Data, class Visit>
void for_each_column_member(Data& data, Visit&& visit) {
  for_each_member(data, [&visit](const Member& member, auto& it) {
    if constexpr (kIsColumn<std::remove_cvref_t<decltype(it)>>) visit(member, it);
  });
}

// Calls visit(kind, store, name, column) for them.
template <class Visit>
void for_each_column(WorldData& data, Visit&& visit) {
  for_each_column_member(data, [&visit](const Member& member, auto& column) {
    visit(member.kind, member.store, member.name, column);
  });
}

// Calls visit(name, part) for the stages' parts that there are.
template <class Visit>
void for_each_part(const WorldData& data, Visit&& visit) {
  for_each_member(data, [&visit](const Member& member, const auto& it) {
    if constexpr (std::is_same_v<decltype(it), const PartOwner&>) {
      if (it != nullptr) visit(member.name, *it);
    }
  });
}

// Bytes that a value holds elsewhere.
inline std::size_t held_elsewhere(const auto&) { return 0; }
inline std::size_t held_elsewhere(const SharedHulls& hulls) { return hull_bytes(hulls); }
inline std::size_t held_elsewhere(const SharedMeshes& meshes) { return mesh_bytes(meshes); }
inline std::size_t held_elsewhere(const ContentSlots& slots) {
  return slots.size() * sizeof(ContentSlots::value_type);
}
inline std::size_t held_elsewhere(const BodyMoments& moments) { return moments.size() * sizeof(MassMoments); }

// Calls visit(kind, store, name, bytes, capacity_bytes) for all members of the stores and of the stages'
// parts.
template <class Visit>
void for_each_member_size(const WorldData& data, Visit&& visit) {
  for_each_member(data, [&visit](const Member& member, const auto& it) {
    if constexpr (kIsColumn<std::remove_cvref_t<decltype(it)>>) {
      visit(member.kind, member.store, member.name, it.span().size_bytes(), it.capacity_bytes());
    } else {
      const std::size_t bytes = sizeof it + held_elsewhere(it);
      visit(member.kind, member.store, member.name, bytes, bytes);
    }
  });
  for_each_part(data, [&visit](const char* name, const Part& part) {
    part.report(name, [&visit](const Member& member, const void*, std::size_t, std::size_t bytes,
                               std::size_t capacity_bytes) {
      visit(member.kind, member.store, member.name, bytes, capacity_bytes);
    });
  });
}

}  // namespace scree
