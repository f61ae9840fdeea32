// Small helpers that the tests of the World calls share.
#pragma once

#include <core/world/world_data.h>
#include <scree/world.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace scree::test {

// SplitMix64 (Steele, Lea and Flood, 2014): the same numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }
  float between(float low, float high) {
    return low + (high - low) * static_cast<float>(next() >> 40) * (1.0f / 16777216.0f);
  }

 private:
  std::uint64_t state_;
};

// The error text of a call; empty if it does not throw.
template <class Work>
std::string error_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

inline std::size_t row_of(BodyId body) { return body.index; }
inline std::size_t row_of(ShapeId shape) { return shape.index; }

// Adds a pair of shapes that does not touch, as find_pairs would leave it.
inline void add_pair(World& world, ShapeId a, ShapeId b) {
  PairRows& pairs = internals(world).contacts.pairs;
  pairs.resize(pairs.pair.size() + 1);
  pairs.pair.back() = {static_cast<std::int32_t>(a.index), static_cast<std::int32_t>(b.index)};
  pairs.contact.back() = -1;
}

// Adds a contact with one point between two shapes, as collide would leave it.
inline void add_touching(World& world, ShapeId a, ShapeId b) {
  add_pair(world, a, b);
  Contacts& contacts = internals(world).contacts;
  const std::size_t row = contacts.now.pair.size();
  contacts.now.resize(row + 1);
  contacts.now.pair[row] = contacts.pairs.pair.back();
  contacts.now.points[row] = 1;
  contacts.now.manifold[row].info = 1;
  contacts.pairs.contact.back() = static_cast<std::int32_t>(row);
}

// Puts a body to sleep, as put_islands_to_sleep would.
inline void put_to_sleep(World& world, BodyId body) {
  WorldData& data = internals(world);
  data.bodies.flags[body.index] |= kBodyAsleep;
  ++data.bodies.asleep;
  for (std::int32_t shape = data.bodies.first_shape[body.index]; shape >= 0;
       shape = data.shapes.next[static_cast<std::size_t>(shape)]) {
    data.shapes.tree[static_cast<std::size_t>(shape)] = TreeKind::frozen;
  }
}

// Processes the shapes that calls marked, as the broad phase does.
inline void consume_dirty(World& world) {
  WorldData& data = internals(world);
  for (const std::int32_t shape : data.shapes.dirty) {
    std::uint8_t& flags = data.shapes.flags[static_cast<std::size_t>(shape)];
    flags = static_cast<std::uint8_t>(flags & ~(kShapeDirty | kShapeNew));
  }
  data.shapes.dirty.clear();
  data.contacts.pairs_stale = false;
  data.bodies.lists_dirty = false;
}

}  // namespace scree::test
