// Lists of pairs by definition, and who follows them from step to step: for tests of find_pairs.
#pragma once

#include <gtest/gtest.h>
#include <parallel/broad_phase/broad_phase.h>
#include <tests/parallel/hand_made_world.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace scree::testing {

using Pair = std::pair<std::int32_t, std::int32_t>;

inline constexpr float kPairStep = 1.0f / 60.0f;

inline bool fat_bounds_meet(const BoundsRow& x, const BoundsRow& y) {
  float distance = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    if (x.lower[axis] > y.upper[axis] || y.lower[axis] > x.upper[axis]) return false;
    const float offset = (x.lower[axis] + x.upper[axis]) * 0.5f - (y.lower[axis] + y.upper[axis]) * 0.5f;
    distance += offset * offset;
  }
  const float sum = x.sphere_radius + y.sphere_radius;
  return distance <= sum * sum;
}

// The definition: every pair of living shapes whose bounds meet and that may collide, unless both are frozen.
inline std::set<Pair> brute_force(const WorldData& data) {
  std::set<Pair> result;
  const Shapes& shapes = data.shapes;
  const auto count = static_cast<std::int32_t>(shapes.type.size());
  for (std::int32_t a = 0; a < count; ++a) {
    const auto index_a = static_cast<std::size_t>(a);
    if ((shapes.flags[index_a] & kShapeAlive) == 0) continue;
    for (std::int32_t b = a + 1; b < count; ++b) {
      const auto index_b = static_cast<std::size_t>(b);
      if ((shapes.flags[index_b] & kShapeAlive) == 0) continue;
      if (shapes.tree[index_a] == TreeKind::frozen && shapes.tree[index_b] == TreeKind::frozen) continue;
      if (fat_bounds_meet(shapes.fat_bounds[index_a], shapes.fat_bounds[index_b]) &&
          may_collide(data, a, b)) {
        result.insert({a, b});
      }
    }
  }
  return result;
}

inline bool is_frozen(const WorldData& data, std::int32_t shape) {
  return data.shapes.tree[static_cast<std::size_t>(shape)] == TreeKind::frozen;
}

// Both lists as one.
inline std::vector<Pair> listed(const WorldData& data) {
  std::vector<Pair> result;
  for (const ShapePair& pair : data.contacts.pairs.pair) result.emplace_back(pair.a, pair.b);
  for (const ShapePair& pair : data.contacts.resting.pair) {
    EXPECT_TRUE(is_frozen(data, pair.a) && is_frozen(data, pair.b)) << pair.a << " " << pair.b;
    result.emplace_back(pair.a, pair.b);
  }
  const auto resting = result.begin() + static_cast<std::ptrdiff_t>(data.contacts.pairs.pair.size());
  EXPECT_TRUE(std::is_sorted(result.begin(), resting));
  std::sort(result.begin(), result.end());
  return result;
}

inline void expect_canonical(const std::vector<Pair>& list) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_LT(list[i].first, list[i].second);
    if (i > 0) {
      EXPECT_LT(list[i - 1], list[i]);
    }
  }
}

// Makes three of four pairs contacts, as collide would, so that histories can be followed.
class Follower {
 public:
  // After find_pairs; returns the number of pairs with a history.
  int check_and_move(WorldData& data) {
    Contacts& contacts = data.contacts;
    int kept = 0;
    std::int64_t resting_contacts = 0;
    std::map<Pair, std::int32_t> contact_of;
    for (PairRows* rows : {&contacts.pairs, &contacts.resting}) {
      EXPECT_EQ(rows->contact.size(), rows->pair.size());
      for (std::size_t row = 0; row < rows->pair.size(); ++row) {
        const Pair pair{rows->pair[row].a, rows->pair[row].b};
        const auto known = contact_of_.find(pair);
        if (rows == &contacts.pairs && !contacts.list_kept) {
          EXPECT_EQ(contacts.last_place[row] >= 0, known != contact_of_.end())
              << pair.first << " " << pair.second;
        }
        std::int32_t& contact = rows->contact[row];
        if (known != contact_of_.end()) {
          EXPECT_EQ(contact, known->second);
          ++kept;
        } else {
          EXPECT_TRUE(rows == &contacts.pairs) << "a new pair is never a resting pair";
          EXPECT_EQ(contact, -1);
          if ((pair.first + pair.second) % 4 != 0) contact = take_row(contacts);
        }
        if (rows == &contacts.resting && contact >= 0) ++resting_contacts;
        contact_of[pair] = contact;
      }
    }
    EXPECT_EQ(contacts.resting_contacts, resting_contacts);
    contact_of_ = std::move(contact_of);
    expect_rows_once(contacts);
    return kept;
  }
  void forget(std::int32_t shape) {
    std::erase_if(contact_of_, [&](const auto& entry) {
      return entry.first.first == shape || entry.first.second == shape;
    });
  }

 private:
  static std::int32_t take_row(Contacts& contacts) {
    if (contacts.free_rows.empty()) {
      contacts.free_rows.push_back(static_cast<std::int32_t>(contacts.now.pair.size()));
      contacts.now.resize(contacts.now.pair.size() + 1);
    }
    const std::int32_t row = contacts.free_rows.back();
    contacts.free_rows.pop_back();
    contacts.now.points[static_cast<std::size_t>(row)] = 1;
    return row;
  }
  // Each row is free or the contact of one pair.
  void expect_rows_once(const Contacts& contacts) const {
    std::vector<int> users(contacts.now.pair.size());
    for (const auto& [pair, contact] : contact_of_) {
      if (contact < 0) continue;
      ++users[static_cast<std::size_t>(contact)];
      EXPECT_EQ(contacts.now.points[static_cast<std::size_t>(contact)], 1);
    }
    for (const std::int32_t row : contacts.free_rows) {
      ++users[static_cast<std::size_t>(row)];
      EXPECT_EQ(contacts.now.points[static_cast<std::size_t>(row)], 0);
    }
    EXPECT_EQ(users, std::vector<int>(users.size(), 1));
  }

  std::map<Pair, std::int32_t> contact_of_;  // -1: does not touch
};

inline void step(HandMadeWorld& world, Workers& workers) {
  Crew crew(workers);
  world.refresh();
  find_pairs(world.data, crew);
  world.integrate(kPairStep);
  update_bounds(world.data, kPairStep, crew);
}

inline std::int32_t add_random_body(HandMadeWorld& world, Random& random, BodyType type, Vec3 half,
                                    float speed, int shapes = 1, Filter filter = {}) {
  const std::int32_t body = world.add_body(type, random.point(half), random.rotation());
  VelocityRow& velocity = world.data.bodies.velocity[static_cast<std::size_t>(body)];
  if (type != BodyType::fixed) {
    for (int axis = 0; axis < 3; ++axis) {
      velocity.linear[axis] = random.uniform(-speed, speed);
      velocity.angular[axis] = random.uniform(-speed, speed);
    }
  }
  for (int i = 0; i < shapes; ++i) {
    const Pose local = shapes == 1 ? Pose{} : Pose{random.point({0.5f, 0.5f, 0.5f}), random.rotation()};
    world.add_random_shape(body, random, local, filter);
  }
  return body;
}

inline Filter random_filter(Random& random) {
  if (random.below(2) == 0) return {};
  return {random.below(8), random.below(8), static_cast<std::int32_t>(random.below(5)) - 2};
}

}  // namespace scree::testing
