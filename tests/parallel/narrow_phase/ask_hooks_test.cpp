// Hooks of contacts: which pairs and contacts they are asked about, what their answers bring about, and what
// happens when they throw or answer nonsense.
#include <gtest/gtest.h>
#include <scree/scree.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace scree {
namespace {

using test::TemporaryFile;

constexpr float kStep = 1.0f / 60.0f;
constexpr float kGravity = 9.81f;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Hooked {
  explicit Hooked(const WorldSettings& settings = {.sleeping = false}, int threads = 1,
                  Isa isa = Isa::automatic)
      : world(settings), workers({threads, isa}) {}
  BodyId add(const BodyDef& def, const Geometry& geometry, const Material& material = {},
             ContactHooks hooks = ContactHooks::none) {
    const BodyId body = world.create_body(def);
    shapes.push_back(world.add_shape(body, geometry, material, {.contact_hooks = hooks}));
    return body;
  }
  BodyId add_floor(ContactHooks hooks, const Material& material = {}) {
    return add({.type = BodyType::fixed, .position = {0, -1, 0}}, Box{{50, 1, 50}}, material, hooks);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step(world, kStep, workers);
  }

  World world;
  Workers workers;
  std::vector<ShapeId> shapes;
};

ContactFilter refuse_all() {
  return [](const ContactFilterBatch& batch) {
    std::fill(batch.collide.begin(), batch.collide.end(), std::uint8_t{0});
  };
}

// A rule that changes each contact by itself.
template <class Change>
ContactRule changing(Change change) {
  return [change](const ContactRuleBatch& batch) {
    for (ContactRules& rules : batch.rules) change(rules);
  };
}

// Boxes, balls, capsules and hulls that fall into a heap on a floor and a mesh that ask for both hooks.
struct Pile : Hooked {
  explicit Pile(int threads = 1, Isa isa = Isa::automatic) : Hooked({}, threads, isa) {
    add_floor(ContactHooks::all);
    const std::vector<Vec3> corners = {{-6, 1, -6}, {6, 1, -6}, {6, 1.5f, 6}, {-6, 0.2f, 6}};
    const std::vector<MeshTriangle> triangles = {{0, 2, 1}, {0, 3, 2}};
    add({.type = BodyType::fixed}, TriangleMesh(corners, triangles), {}, ContactHooks::all);
    for (int i = 0; i < 160; ++i) {
      const auto at = [i](int each) { return 1.1f * static_cast<float>(i / each % 5) - 2.2f; };
      const Vec3 position{at(1), 2.5f + 1.1f * static_cast<float>(i / 25), at(5)};
      const Geometry forms[] = {Box{{0.5f, 0.3f, 0.4f}}, Sphere{0.4f}, Capsule{0.3f, 0.25f},
                                ConvexHull{test::wedge()}};
      add({.position = position}, forms[i % 4], {.restitution = i % 3 == 0 ? 0.5f : 0.0f},
          i % 5 == 0 ? ContactHooks::all : ContactHooks::none);
    }
  }
};

// Answers that depend on the batch alone.
void set_lively_hooks(World& world) {
  const auto number = [](const HookedPair& pair) { return pair.shape_a.index + 3 * pair.shape_b.index; };
  world.set_contact_filter([number](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.collide[i] = number(batch.pairs[i]) % 11 == 0 ? 0 : 1;
  });
  world.set_contact_rule([number](const ContactRuleBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
      ContactRules& rules = batch.rules[i];
      const std::uint32_t kind = number(batch.pairs[i]) % 7;
      if (kind == 0) rules.acts = batch.contacts[i].points[0].separation > -0.05f;
      if (kind == 1) rules.friction = 0.1f;
      if (kind == 2) rules.restitution = 0.7f;
      if (kind == 3) rules.surface_velocity = {1, 0, 0.5f};
      if (kind == 4) rules.rolling_resistance = 0.05f;
      if (kind == 5) rules.friction = kNan;
    }
  });
}

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

TEST(ContactRule, ReachesEachContactOfAMeshByItself) {
  // A ball in the corner of a floor and a wall, which are one mesh.
  Hooked hooked;
  const std::vector<Vec3> corners = {{0, 0, -9}, {0, 0, 9}, {9, 0, 9}, {9, 0, -9}, {0, 9, -9}, {0, 9, 9}};
  const std::vector<MeshTriangle> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {1, 4, 5}};
  hooked.add({.type = BodyType::fixed}, TriangleMesh(corners, triangles), {}, ContactHooks::rule);
  const BodyId ball = hooked.add({.position = {0.5f, 0.5f, 0}, .linear_velocity = {-1, 0, 0}}, Sphere{0.5f});
  hooked.world.set_contact_rule([](const ContactRuleBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.rules[i].acts = std::abs(batch.contacts[i].normal.y) > 0.5f;
  });
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

// --- answers without hooks ---

TEST(ContactAnswers, StandForTheHooksInOneStep) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  const BodyId body = hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  int asked = 0;
  hooked.world.set_contact_filter([&](const ContactFilterBatch&) { ++asked; });
  hooked.world.set_contact_rule([&](const ContactRuleBatch&) { ++asked; });
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  hooked.world.answer_contact_hooks({&refusal, 1});
  const float before = hooked.world.linear_velocity(body).y;
  hooked.run(1);
  EXPECT_EQ(asked, 0);
  EXPECT_NEAR(hooked.world.linear_velocity(body).y, before - kGravity * kStep, 1e-5f);
  hooked.run(1);
  EXPECT_EQ(asked, 2);
  EXPECT_GT(hooked.world.linear_velocity(body).y, before - kGravity * kStep);
  const ContactAnswer belt{
      hooked.shapes[0], hooked.shapes[1], 0, {.friction = 1e6f, .surface_velocity = {-1, 0, 0}}};
  for (int i = 0; i < 30; ++i) {
    hooked.world.answer_contact_hooks({&belt, 1});
    hooked.run(1);
  }
  EXPECT_NEAR(hooked.world.linear_velocity(body).x, 1.0f, 1e-3f);
}

TEST(ContactAnswers, ArePartOfTheState) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  World unanswered = clone(hooked.world);
  hooked.world.answer_contact_hooks({&refusal, 1});
  World copy = clone(hooked.world);
  Snapshot snapshot;
  save(hooked.world, snapshot);
  World restored;
  restore(restored, read_snapshot(write_snapshot(snapshot)));
  for (World* world : {&hooked.world, &copy, &restored, &unanswered}) step(*world, kStep, hooked.workers);
  EXPECT_EQ(copy.hash(), hooked.world.hash());
  EXPECT_EQ(restored.hash(), hooked.world.hash());
  EXPECT_NE(unanswered.hash(), hooked.world.hash());
}

TEST(ContactAnswers, AboutShapesThatAreReplacedHaveNoEffect) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  const BodyId body = hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  hooked.world.answer_contact_hooks({&refusal, 1});
  hooked.world.destroy_shape(hooked.shapes[1]);
  const ShapeId next = hooked.world.add_shape(body, Box{});
  ASSERT_EQ(next.index, hooked.shapes[1].index);
  hooked.run(1);
  EXPECT_NEAR(hooked.world.linear_velocity(body).y, 0.0f, 1e-2f);
}

TEST(ContactAnswers, ThatAreWrongAreRefusedByNameAndChangeNothing) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  for (int i = 0; i < 3; ++i) hooked.add({.position = {2.0f * static_cast<float>(i), 0.5f, 0}}, Box{});
  hooked.run(5);
  const auto& s = hooked.shapes;
  const ContactAnswer sound[] = {{s[0], s[1], -1, {}}, {s[0], s[2], 0, {.friction = 1}}};
  hooked.world.answer_contact_hooks(sound);
  Snapshot before;
  save(hooked.world, before);
  const auto refuse = [&](std::vector<ContactAnswer> answers, const std::string& message) {
    try {
      hooked.world.answer_contact_hooks(answers);
      ADD_FAILURE() << "not refused: " << message;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
    Snapshot after;
    save(hooked.world, after);
    EXPECT_EQ(write_snapshot(after), write_snapshot(before));
  };
  refuse({{s[1], s[0], -1, {}}},
         "answer_contact_hooks: shape_a has the index 1, which must be below shape_b's, 0");
  refuse({{s[1], s[1], -1, {}}}, "must be below");
  refuse({{s[0], s[1], -2, {}}}, "contact is -2; it must be -1 or more");
  refuse({{s[0], s[1], 0, {}}, {s[0], s[1], 0, {}}}, "answer 1: it must come before the answer ahead of it");
  refuse({{s[0], s[2], 0, {}}, {s[0], s[1], 0, {}}}, "answer 1: it must come before");
  refuse({{s[0], {s[1].index, s[1].generation + 1, s[1].world}, 0, {}}}, "shape");
  refuse({{s[0], s[1], 0, {.friction = kNan}}}, "friction");
  refuse({{s[0], s[1], 0, {.restitution = 1.5f}}}, "restitution is 1.5");
  refuse({{s[0], s[1], 0, {.rolling_resistance = -1}}}, "rolling_resistance");
  refuse({{s[0], s[1], 0, {.surface_velocity = {0, 3e6f, 0}}}}, "surface_velocity");
  EXPECT_THROW(hooked.world.set_contact_hooks(s[1], static_cast<ContactHooks>(4)), Error);
  EXPECT_THROW(hooked.world.add_shape(hooked.world.body_of(s[1]), Box{}, {},
                                      {.contact_hooks = static_cast<ContactHooks>(9)}),
               Error);
}

}  // namespace
}  // namespace scree
