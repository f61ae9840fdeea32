// Slots of what shapes share: hulls and meshes, one slot for all shapes of the same content.
//
// For the stores Hulls and Meshes, whose columns are the same. `content` tells by its hash what a slot holds,
// `slot_of` finds slots by that.
#pragma once

#include <core/plain/assert.h>
#include <core/world/world_data.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace scree {

template <class Store>
void resize_slots(Store& store, std::size_t slots) {
  store.resize(slots);
  store.shared.resize(slots);
}

// The slot with this content for which is_same(shared) holds, or -1.
template <class Store, class IsSame>
std::int32_t find_slot(const Store& store, std::uint64_t content, IsSame&& is_same) {
  const auto [first, last] = store.slot_of.equal_range(content);
  for (auto entry = first; entry != last; ++entry) {
    if (is_same(store.shared[static_cast<std::size_t>(entry->second)])) return entry->second;
  }
  return -1;
}

// Makes a slot that one shape uses; if it throws, nothing has changed.
template <class Store, class Shared, class Data>
std::int32_t make_slot(Store& store, std::uint64_t content, Shared shared, const Data* data) {
  const std::size_t old_slots = store.shared.size();
  std::int32_t slot = static_cast<std::int32_t>(old_slots);
  if (!store.free_slots.empty()) {
    slot = store.free_slots.back();
  } else {
    store.free_slots.reserve(old_slots + 1);  // so that releasing cannot fail
  }
  try {
    if (store.free_slots.empty()) resize_slots(store, old_slots + 1);
    store.slot_of.emplace(content, slot);
  } catch (...) {
    resize_slots(store, old_slots);
    throw;
  }
  if (!store.free_slots.empty()) store.free_slots.pop_back();
  store.content[slot] = content;
  store.shapes[slot] = 1;
  store.data[slot] = data;
  store.shared[static_cast<std::size_t>(slot)] = std::move(shared);
  return slot;
}

// Empties a slot that no shape uses.
template <class Store>
void clear_slot(Store& store, std::int32_t slot) {
  SCREE_ASSERT(store.shapes[slot] == 0);
  const auto [first, last] = store.slot_of.equal_range(store.content[slot]);
  const auto own = std::find_if(first, last, [&](const auto& entry) { return entry.second == slot; });
  SCREE_ASSERT(own != last);
  store.slot_of.erase(own);
  store.content[slot] = 0;
  store.data[slot] = nullptr;
  store.shared[static_cast<std::size_t>(slot)] = {};
}

// Counts one shape fewer; -1 does nothing. A slot without shapes is free.
template <class Store>
void release_slot(Store& store, std::int32_t slot) {
  if (slot < 0 || --store.shapes[slot] > 0) return;
  clear_slot(store, slot);
  store.free_slots.push_back(slot);
}

// Undoes the acquiring of a slot, the latest call first: removes the slots from `old_slots` on.
template <class Store>
void undo_slot(Store& store, std::int32_t slot, std::size_t old_slots) {
  if (slot < 0 || --store.shapes[slot] > 0) return;
  clear_slot(store, slot);
  if (std::cmp_less(slot, old_slots)) {
    store.free_slots.push_back(slot);
  } else {
    resize_slots(store, static_cast<std::size_t>(slot));
  }
}

}  // namespace scree
