// Hooks of contacts: which pairs and contacts they are asked about, what their answers bring about, and what
// happens when they throw or answer nonsense.
#include <gtest/gtest.h>
#include <tests/parallel/narrow_phase/hooks_fixture.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

namespace scree::hooks_test {
namespace {

using test::TemporaryFile;

TEST(ContactFilter, LetsRefusedPairsPassAsIfTheyWereAlone) {
  Hooked alone, hooked;
  const BodyId free = alone.add({.position = {0, 2, 0}, .angular_velocity = {1, 2, 3}}, Box{});
  hooked.add_floor(ContactHooks::filter);
  const BodyId body = hooked.add({.position = {0, 2, 0}, .angular_velocity = {1, 2, 3}}, Box{});
  hooked.world.set_contact_filter(refuse_all());
  alone.run(90);
  hooked.run(90);
  EXPECT_EQ(hooked.world.pose(body), alone.world.pose(free));
  EXPECT_LT(hooked.world.pose(body).position.y, -5.0f);
}

TEST(ContactFilter, IsNoObstacleToFastBodies) {
  for (const bool filters : {true, false}) {
    Hooked hooked({.gravity = {}, .sleeping = false});
    hooked.add({.type = BodyType::fixed}, Box{{2, 0.005f, 2}}, {}, ContactHooks::all);
    const BodyId moving =
        hooked.add({.type = BodyType::kinematic, .position = {0, -20, 0}, .linear_velocity = {1, 0, 0}},
                   Box{{2, 0.005f, 2}}, {}, ContactHooks::all);
    const BodyId bullet =
        hooked.add({.position = {0, 10, 0}, .linear_velocity = {0, -300, 0}}, Sphere{0.05f});
    if (filters) {
      hooked.world.set_contact_filter(refuse_all());
    } else {
      hooked.world.set_contact_rule(changing([](ContactRules& rules) { rules.acts = false; }));
    }
    hooked.run(10);
    EXPECT_EQ(hooked.world.linear_velocity(bullet), (Vec3{0, -300, 0}));
    // A rule is asked once a contact is there, so a bullet may be held at a plate for the rest of a step.
    EXPECT_NEAR(hooked.world.pose(bullet).position.y, -40.0f, filters ? 1e-3f : 10.1f);
    hooked.world.destroy_body(moving);
  }
}

TEST(ContactRule, ThatLetsNothingActIsAsNoContact) {
  Hooked alone, hooked;
  const BodyId free = alone.add({.position = {0, 2, 0}, .angular_velocity = {1, 2, 3}}, Box{});
  hooked.add_floor(ContactHooks::rule);
  const BodyId body = hooked.add({.position = {0, 2, 0}, .angular_velocity = {1, 2, 3}}, Box{});
  hooked.world.set_contact_rule(changing([](ContactRules& rules) { rules.acts = false; }));
  alone.run(90);
  hooked.run(90);
  EXPECT_EQ(hooked.world.pose(body), alone.world.pose(free));
  EXPECT_EQ(hooked.world.stats().contacts, 0);
}

TEST(ContactRule, ThatChangesNothingChangesNoBit) {
  Pile plain, hooked;
  hooked.world.set_contact_filter([](const ContactFilterBatch&) {});
  hooked.world.set_contact_rule([](const ContactRuleBatch&) {});
  for (int i = 0; i < 120; ++i) {
    plain.run(1);
    hooked.run(1);
    ASSERT_EQ(hooked.world.hash(), plain.world.hash()) << "step " << i;
  }
}

// v^2 / (2 mu g), for a block that slides.
TEST(ContactRule, GivesFriction) {
  for (const float friction : {0.0f, 0.2f, 0.8f}) {
    Hooked hooked;
    hooked.add_floor(ContactHooks::rule);
    const BodyId body =
        hooked.add({.position = {0, 0.5f, 0}, .linear_velocity = {4, 0, 0}}, Box{{1, 0.5f, 1}});
    hooked.world.set_contact_rule(changing([=](ContactRules& rules) { rules.friction = friction; }));
    hooked.run(180);
    const float expected = friction > 0.0f ? 16.0f / (2.0f * friction * kGravity) : 12.0f;
    EXPECT_NEAR(hooked.world.pose(body).position.x, expected, 0.02f * expected) << friction;
  }
}

TEST(ContactRule, GivesRestitution) {
  for (const float restitution : {0.5f, 0.8f, 1.0f}) {
    Hooked hooked;
    hooked.add_floor(ContactHooks::rule);
    const BodyId ball = hooked.add({.position = {0, 2.25f, 0}}, Sphere{0.25f});
    hooked.world.set_contact_rule(changing([=](ContactRules& rules) { rules.restitution = restitution; }));
    float highest = 0.0f;
    for (int i = 0; i < 200; ++i) {
      hooked.run(1);
      const float up = hooked.world.linear_velocity(ball).y;
      if (up > 0.0f && highest == 0.0f) {
        highest = hooked.world.pose(ball).position.y - 0.25f + up * up / (2.0f * kGravity);
      }
    }
    EXPECT_NEAR(highest, 2.0f * restitution * restitution, 0.03f) << restitution;
  }
}

TEST(ContactRule, MovesASurface) {
  for (const bool floor_first : {true, false}) {
    Hooked hooked;
    const auto add_crate = [&] { return hooked.add({.position = {0, 0.5f, 0}}, Box{}); };
    BodyId crate{};
    if (!floor_first) crate = add_crate();
    hooked.add_floor(ContactHooks::rule);
    if (floor_first) crate = add_crate();
    const ShapeId floor = hooked.shapes[floor_first ? 0 : 1];
    hooked.world.set_contact_rule([=](const ContactRuleBatch& batch) {
      for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
        const float side = batch.pairs[i].shape_a == floor ? -1.0f : 1.0f;
        batch.rules[i].surface_velocity = {side * 2.0f, side * 9.0f,
                                           side * 1.0f};  // of it the plane's part acts
      }
    });
    hooked.run(120);
    const Vec3 velocity = hooked.world.linear_velocity(crate);
    EXPECT_NEAR(velocity.x, 2.0f, 1e-3f);
    EXPECT_NEAR(velocity.y, 0.0f, 1e-3f);
    EXPECT_NEAR(velocity.z, 1.0f, 1e-3f);
  }
}

// A ball that rolls on a surface that resists by r loses 5/7 g r / R of its speed a second.
TEST(ContactRule, ResistsRolling) {
  Hooked hooked({.sleeping = false});
  hooked.add_floor(ContactHooks::rule);
  const BodyId ball =
      hooked.add({.position = {-20, 0.5f, 0}, .linear_velocity = {4, 0, 0}, .angular_velocity = {0, 0, -8}},
                 Sphere{0.5f});
  hooked.world.set_contact_rule(changing([](ContactRules& rules) { rules.rolling_resistance = 0.02f; }));
  hooked.run(120);
  EXPECT_NEAR(hooked.world.linear_velocity(ball).x, 4.0f - 2.0f * 5.0f / 7.0f * kGravity * 0.02f / 0.5f,
              0.02f);
}

TEST(ContactRule, HoldsForOneStepOnly) {
  Hooked hooked({.gravity = {0, -kGravity, 0}, .sleeping = false});
  hooked.add_floor(ContactHooks::rule);
  const BodyId body = hooked.add({.position = {0, 0.5f, 0}}, Box{{1, 0.5f, 1}}, {.friction = 0.5f});
  hooked.world.set_contact_rule(changing([](ContactRules& rules) {
    EXPECT_NEAR(rules.friction, std::sqrt(0.5f * 0.6f), 1e-6f);
    EXPECT_EQ(rules.restitution, 0.0f);
    EXPECT_EQ(rules.surface_velocity, Vec3{});
    rules.friction = 0.0f;
    rules.restitution = 0.3f;
    rules.surface_velocity = {1, 0, 0};
  }));
  hooked.run(20);
  hooked.world.set_contact_rule({});
  hooked.world.set_linear_velocity(body, {2, 0, 0});
  hooked.run(60);
  EXPECT_NEAR(hooked.world.linear_velocity(body).x, 0.0f, 1e-3f);
}

TEST(ContactRule, SeesPairsAscendingEachOnceWithUnitNormalsFromAToB) {
  Pile pile;
  struct Seen {
    HookedPair pair;
    int batch;
    bool operator==(const Seen&) const = default;
  };
  std::mutex mutex;
  std::vector<HookedPair> seen;
  pile.world.set_contact_rule([&](const ContactRuleBatch& batch) {
    ASSERT_EQ(batch.pairs.size(), batch.contacts.size());
    ASSERT_EQ(batch.pairs.size(), batch.rules.size());
    EXPECT_EQ(&batch.world, &pile.world);
    EXPECT_EQ(batch.dt, kStep);
    const std::scoped_lock lock(mutex);
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
      const HookedPair& pair = batch.pairs[i];
      const HookedContact& contact = batch.contacts[i];
      seen.push_back(pair);
      EXPECT_LT(pair.shape_a.index, pair.shape_b.index);
      EXPECT_EQ(batch.world.body_of(pair.shape_a), pair.body_a);
      EXPECT_EQ(batch.world.body_of(pair.shape_b), pair.body_b);
      EXPECT_TRUE(contains(batch.world.contact_hooks(pair.shape_a) | batch.world.contact_hooks(pair.shape_b),
                           ContactHooks::rule));
      EXPECT_NEAR(length(contact.normal), 1.0f, 1e-5f);
      const bool is_on_floor = pair.shape_a == pile.shapes[0];
      EXPECT_TRUE(!is_on_floor || contact.normal.y > 0.99f) << contact.normal.y;
      ASSERT_GE(contact.point_count, 1);
      ASSERT_LE(contact.point_count, 4);
    }
  });
  for (int i = 0; i < 100; ++i) {
    seen.clear();
    pile.run(1);
    const auto place = [](const HookedPair& pair) {
      return std::pair(pair.shape_a.index, pair.shape_b.index);
    };
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end(),
                               [&](const auto& x, const auto& y) { return place(x) < place(y); }));
  }
  EXPECT_GT(seen.size(), 20u);
}

// A floor and a wall at x = 0, which are one mesh.
TriangleMesh corner_mesh() {
  const std::vector<Vec3> corners = {{0, 0, -9}, {0, 0, 9}, {9, 0, 9}, {9, 0, -9}, {0, 9, -9}, {0, 9, 9}};
  const std::vector<MeshTriangle> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {1, 4, 5}};
  return TriangleMesh(corners, triangles);
}

// The rule by which the wall does nothing.
ContactRule open_wall() {
  return [](const ContactRuleBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.rules[i].acts = std::abs(batch.contacts[i].normal.y) > 0.5f;
  };
}

TEST(ContactRule, ThatTookAContactOfAMeshOutGivesItBack) {
  Hooked hooked;
  hooked.add({.type = BodyType::fixed}, corner_mesh(), {.friction = 0}, ContactHooks::rule);
  const BodyId box = hooked.add({.position = {0.485f, 0.5f, 0}}, Box{}, {.friction = 0});
  hooked.world.set_contact_rule(open_wall());
  hooked.run(30);
  EXPECT_NEAR(hooked.world.pose(box).position.x, 0.485f, 1e-5f);
  hooked.world.set_contact_rule({});
  hooked.run(60);
  EXPECT_GT(hooked.world.pose(box).position.x, 0.49f);
}

TEST(ContactRule, ReachesEachContactOfAMeshByItself) {
  Hooked hooked;
  hooked.add({.type = BodyType::fixed}, corner_mesh(), {}, ContactHooks::rule);
  const BodyId ball = hooked.add({.position = {0.5f, 0.5f, 0}, .linear_velocity = {-1, 0, 0}}, Sphere{0.5f});
  hooked.world.set_contact_rule(open_wall());
  hooked.run(10);
  EXPECT_LT(hooked.world.pose(ball).position.x, 0.45f);          // into the wall
  EXPECT_NEAR(hooked.world.pose(ball).position.y, 0.5f, 0.01f);  // but not into the floor
}

TEST(ContactRule, OutOfRangeChangesNothingAndIsCounted) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<std::function<void(ContactRules&)>> spoils = {
      [](ContactRules& rules) { rules.friction = kNan; },
      [](ContactRules& rules) { rules.friction = -0.1f; },
      [=](ContactRules& rules) { rules.friction = inf; },
      [](ContactRules& rules) { rules.friction = 1.1e6f; },
      [](ContactRules& rules) { rules.restitution = 1.01f; },
      [](ContactRules& rules) { rules.restitution = kNan; },
      [](ContactRules& rules) { rules.rolling_resistance = -1.0f; },
      [=](ContactRules& rules) { rules.rolling_resistance = inf; },
      [](ContactRules& rules) { rules.surface_velocity.y = kNan; },
      [=](ContactRules& rules) { rules.surface_velocity.z = -inf; },
      [](ContactRules& rules) { rules = {.acts = false, .friction = kNan}; },
  };
  Pile plain;
  plain.run(80);
  const std::uint64_t expected = plain.world.hash();
  for (std::size_t i = 0; i < spoils.size(); ++i) {
    Pile pile;
    pile.world.set_contact_rule(changing(spoils[i]));
    pile.run(80);
    EXPECT_EQ(pile.world.hash(), expected) << i;
    EXPECT_GT(pile.world.stats().unsound_rules, 0) << i;
    EXPECT_LE(pile.world.stats().unsound_rules, pile.world.stats().contacts) << i;
  }
  EXPECT_EQ(plain.world.stats().unsound_rules, 0);
}

TEST(ContactHooks, GiveTheSameBitsOnEveryBackend) {
  std::vector<std::uint64_t> expected;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Pile pile(threads, isa);
      set_lively_hooks(pile.world);
      std::vector<std::uint64_t> hashes;
      for (int i = 0; i < 150; ++i) {
        pile.run(1);
        hashes.push_back(pile.world.hash());
      }
      if (expected.empty()) expected = hashes;
      EXPECT_EQ(hashes, expected) << isa_name(isa) << ", " << threads << " threads";
    }
  }
}

TEST(ContactHooks, AreNotAskedAboutShapesThatDoNotAskOrSleep) {
  Hooked hooked({.contact_forces = false});
  hooked.add_floor(ContactHooks::none);
  hooked.add({.position = {0, 0.5f, 0}}, Box{});
  const BodyId sleeper = hooked.add({.position = {9, 0.5f, 0}}, Box{}, {}, ContactHooks::all);
  int filtered = 0, ruled = 0;
  hooked.world.set_contact_filter(
      [&](const ContactFilterBatch& batch) { filtered += static_cast<int>(batch.pairs.size()); });
  hooked.world.set_contact_rule(
      [&](const ContactRuleBatch& batch) { ruled += static_cast<int>(batch.pairs.size()); });
  hooked.run(10);
  EXPECT_EQ(filtered, 10);
  EXPECT_EQ(ruled, 10);
  hooked.run(200);
  ASSERT_FALSE(hooked.world.is_awake(sleeper));
  filtered = ruled = 0;
  hooked.run(10);
  EXPECT_EQ(filtered, 0);
  EXPECT_EQ(ruled, 0);
  hooked.world.set_contact_hooks(hooked.shapes[2], ContactHooks::none);
  hooked.world.wake(sleeper);
  hooked.run(10);
  EXPECT_EQ(filtered, 0);
  hooked.world.set_contact_hooks(hooked.shapes[0], ContactHooks::filter);
  hooked.world.wake(sleeper);
  hooked.run(10);
  EXPECT_GE(filtered, 10);
  EXPECT_EQ(ruled, 0);
}

TEST(ContactHooks, EndTheEventsOfContactsThatTheyTakeOut) {
  for (const bool filters : {true, false}) {
    Hooked hooked({.sleeping = false, .contact_events = ContactEvents::begin_end});
    hooked.add_floor(ContactHooks::all);
    hooked.add({.position = {0, 0.5f, 0}}, Box{});
    hooked.run(5);
    if (filters) {
      hooked.world.set_contact_filter(refuse_all());
    } else {
      hooked.world.set_contact_rule(changing([](ContactRules& rules) { rules.acts = false; }));
    }
    hooked.run(1);
    EXPECT_EQ(hooked.world.contact_ends().size(), 1u);
    hooked.run(1);
    EXPECT_EQ(hooked.world.contact_ends().size(), 0u);
    hooked.world.set_contact_filter({});
    hooked.world.set_contact_rule({});
    hooked.run(1);
    EXPECT_EQ(hooked.world.contact_begins().size(), 1u);
  }
}

TEST(ContactHooks, ThatThrowAreAsThoseThatAnswerNothing) {
  for (const bool filters : {true, false}) {
    for (const int threads : {1, 3}) {
      Pile plain, hooked(threads);
      plain.run(60);
      hooked.run(60);
      if (filters) {
        hooked.world.set_contact_filter([](const ContactFilterBatch& batch) {
          batch.collide[0] = 0;
          throw std::runtime_error("batch " + std::to_string(batch.pairs[0].shape_b.index));
        });
      } else {
        hooked.world.set_contact_rule([](const ContactRuleBatch& batch) {
          batch.rules[0].acts = false;
          throw std::runtime_error("batch " + std::to_string(batch.pairs[0].shape_b.index));
        });
      }
      std::string first;
      for (int i = 0; i < 10; ++i) {
        plain.run(1);
        try {
          hooked.run(1);
          FAIL() << "nothing was thrown";
        } catch (const std::runtime_error& error) {
          first = error.what();
        }
        EXPECT_EQ(hooked.world.hash(), plain.world.hash());
        EXPECT_EQ(hooked.world.stats().step, plain.world.stats().step);
      }
      EXPECT_NE(first, "");
      hooked.world.set_contact_filter({});
      hooked.world.set_contact_rule({});
      plain.run(10);
      EXPECT_NO_THROW(hooked.run(10));
      EXPECT_EQ(hooked.world.hash(), plain.world.hash());
    }
  }
}

TEST(ContactHooks, ThatThrowLeaveTheAnswersOfTheOther) {
  Pile filtered, both;
  const auto filter = [](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) batch.collide[i] = batch.pairs[i].shape_b.index % 2;
  };
  filtered.world.set_contact_filter(filter);
  both.world.set_contact_filter(filter);
  both.world.set_contact_rule([](const ContactRuleBatch&) { throw 7; });
  for (int i = 0; i < 60; ++i) {
    filtered.run(1);
    try {
      both.run(1);
    } catch (int) {
    }
    ASSERT_EQ(both.world.hash(), filtered.world.hash());
  }
}

TEST(ContactHooks, OfAListOfWorldsAreAskedForTheirOwn) {
  for (const int threads : {1, 4}) {
    Workers workers(threads);
    std::vector<std::unique_ptr<Pile>> piles;
    std::vector<World*> list;
    for (int i = 0; i < 3; ++i) {
      piles.push_back(std::make_unique<Pile>());
      list.push_back(&piles.back()->world);
    }
    set_lively_hooks(piles[1]->world);
    piles[2]->world.set_contact_rule([](const ContactRuleBatch& batch) {
      if (!batch.pairs.empty()) throw std::runtime_error("third");
    });
    Pile plain, lively;
    set_lively_hooks(lively.world);
    int thrown = 0;
    for (int i = 0; i < 60; ++i) {
      plain.run(1);
      lively.run(1);
      try {
        step(list, kStep, workers);
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "third");
        ++thrown;
      }
      ASSERT_EQ(piles[0]->world.hash(), plain.world.hash());
      ASSERT_EQ(piles[1]->world.hash(), lively.world.hash());
      ASSERT_EQ(piles[2]->world.hash(), plain.world.hash());
    }
    EXPECT_GT(thrown, 10);
  }
}

TEST(ContactHooks, AreNotNeededToPlayARecording) {
  const TemporaryFile file;
  Pile pile;
  set_lively_hooks(pile.world);
  pile.run(5);
  Recorder recorder(pile.world, file.path(), {.keyframe_spacing = 20});
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 120; ++i) {
    pile.run(1);
    hashes.push_back(pile.world.hash());
  }
  pile.world.set_contact_hooks(pile.shapes[0], ContactHooks::none);
  pile.run(10);
  recorder.finish();
  for (const int threads : {1, 3}) {
    Player player(file.path());
    Workers workers(threads);
    const auto found = player.verify(player.info().first_step, player.info().last_step, workers);
    EXPECT_FALSE(found.has_value()) << found->difference;
    player.seek(5 + 33, workers);
    EXPECT_EQ(player.world().hash(), hashes[32]);
    player.seek(5 + 130, workers);
    EXPECT_EQ(player.world().hash(), pile.world.hash());
    EXPECT_FALSE(player.world().has_contact_filter());
    EXPECT_FALSE(player.world().has_contact_rule());
  }
}

TEST(ContactHooks, RecordOnlyWhatTheyChange) {
  const TemporaryFile file;
  Pile pile;
  pile.world.set_contact_filter([](const ContactFilterBatch&) {});
  pile.world.set_contact_rule([](const ContactRuleBatch&) {});
  Recorder recorder(pile.world, file.path());
  pile.run(60);
  recorder.finish();
  EXPECT_EQ(Player(file.path()).info().calls, 0u);
}

TEST(ContactHooks, AreNoPartOfTheState) {
  Pile pile;
  set_lively_hooks(pile.world);
  pile.run(30);
  Snapshot snapshot;
  save(pile.world, snapshot);
  World other;
  other.set_contact_rule([](const ContactRuleBatch&) {});
  restore(other, snapshot);
  EXPECT_TRUE(other.has_contact_rule());
  EXPECT_FALSE(other.has_contact_filter());
  World copy = clone(pile.world);
  EXPECT_FALSE(copy.has_contact_filter());
  EXPECT_FALSE(copy.has_contact_rule());
  EXPECT_EQ(copy.contact_hooks(pile.shapes[0]), ContactHooks::all);
  set_lively_hooks(copy);
  pile.run(60);
  for (int i = 0; i < 60; ++i) step(copy, kStep, pile.workers);
  EXPECT_EQ(copy.hash(), pile.world.hash());
}

}  // namespace
}  // namespace scree::hooks_test
