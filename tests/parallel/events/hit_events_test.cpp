// Laws of hits: they are the contacts that are pressed at no less than the threshold, and nothing else.
#include <core/world/world_data.h>
#include <scree/height_field.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace scree::physics {
namespace {

WorldSettings hitting(WorldSettings settings = without_sleep(), float speed = 1.0f) {
  settings.contact_events = ContactEvents::hit;
  settings.hit_event_speed = speed;
  return settings;
}

using Hits = std::vector<ContactEvent>;

Hits hits_of(const World& world) { return {world.contact_hits().begin(), world.contact_hits().end()}; }

Hits hits_over(Lab& lab, int steps) {
  Hits hits;
  for (int i = 0; i < steps; ++i) {
    lab.run(1);
    hits.insert(hits.end(), lab.world.contact_hits().begin(), lab.world.contact_hits().end());
  }
  return hits;
}

// By what the events say; handles of other worlds that were built alike are the same.
bool same_events(const Hits& a, const Hits& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ContactEvent& x, const ContactEvent& y) {
    return x.shape_a.index == y.shape_a.index && x.shape_b.index == y.shape_b.index &&
           x.body_a.index == y.body_a.index && x.body_b.index == y.body_b.index && x.normal == y.normal &&
           x.normal_impulse == y.normal_impulse && x.approach_speed == y.approach_speed &&
           x.point_count == y.point_count && std::memcmp(x.points, y.points, sizeof x.points) == 0;
  });
}

// The same list made from those of all contacts.
Hits hits_among_all(const World& world, float speed) {
  Hits hits;
  for (const auto& list : {world.contact_begins(), world.contact_persists()}) {
    std::copy_if(list.begin(), list.end(), std::back_inserter(hits), [&](const ContactEvent& event) {
      return event.approach_speed >= speed && event.normal_impulse > 0.0f;
    });
  }
  std::sort(hits.begin(), hits.end(), [](const ContactEvent& x, const ContactEvent& y) {
    return std::pair(x.shape_a.index, x.shape_b.index) < std::pair(y.shape_a.index, y.shape_b.index);
  });
  return hits;
}

TEST(HitEvents, OfABallThatFallsTellTheSpeedOfItsFall) {
  for (const int substeps : {1, 2, 4, 8}) {
    for (const float restitution : {0.0f, 0.5f, 1.0f}) {
      for (const float height : {0.3f, 1.0f, 3.7f, 20.0f}) {
        WorldSettings settings = hitting();
        settings.substeps = substeps;
        Lab lab(settings);
        const BodyId ground = lab.add_ground();
        const BodyId ball =
            lab.add({.position = {0, 0.5f + height, 0}}, Sphere{0.5f}, {.restitution = restitution});
        Hits hits;
        for (int i = 0; i < 200 && hits.empty(); ++i) hits = hits_over(lab, 1);
        const double speed = std::sqrt(2.0 * kGravity * static_cast<double>(height));
        const std::string what = std::to_string(substeps) + " substeps, restitution " +
                                 std::to_string(restitution) + ", height " + std::to_string(height);
        ASSERT_EQ(hits.size(), 1u) << what;
        // The speed when the step begins: up to a step's gravity is still to come.
        EXPECT_LE(hits[0].approach_speed, speed + 0.03) << what;
        EXPECT_GE(hits[0].approach_speed, speed - kGravity * static_cast<double>(kStep) - 0.01) << what;
        EXPECT_GT(hits[0].normal_impulse, 0.0f) << what;
        EXPECT_EQ(hits[0].body_a, ground);
        EXPECT_EQ(hits[0].body_b, ball);
        EXPECT_NEAR(hits[0].normal.y, 1.0f, 1e-5f);
      }
    }
  }
}

TEST(HitEvents, AreOneForEachBounce) {
  Lab lab(hitting());
  lab.add_ground();
  const BodyId ball = lab.add({.position = {0, 2, 0}}, Sphere{0.5f}, {.restitution = 0.9f});
  int bounces = 0;
  for (int i = 0; i < 400; ++i) {
    const double before = lab.velocity(ball).y();
    lab.run(1);
    const bool bounced = before < 0.0 && lab.velocity(ball).y() > 0.0;
    bounces += bounced ? 1 : 0;
    ASSERT_EQ(lab.world.contact_hits().size(), bounced ? 1u : 0u) << i;
  }
  EXPECT_GT(bounces, 5);
}

// Whenever in a step it comes.
TEST(HitEvents, AreOneForEachImpactThatSticks) {
  for (const int substeps : {1, 2, 4, 8}) {
    for (int i = 0; i < 60; ++i) {
      WorldSettings settings = hitting(without_gravity(), 0.1f);
      settings.substeps = substeps;
      Lab lab(settings);
      lab.add_ground();
      lab.add({.position = {0, 1.5f + 0.0031f * static_cast<float>(i), 0}, .linear_velocity = {0, -6, 0}},
              Sphere{0.5f});
      const Hits hits = hits_over(lab, 60);
      ASSERT_EQ(hits.size(), 1u) << substeps << " substeps, " << i;
      EXPECT_NEAR(hits[0].approach_speed, 6.0f, 1e-3f) << substeps << " substeps, " << i;
    }
  }
}

TEST(HitEvents, BeginAtTheThresholdItself) {
  const auto count = [](float threshold) {
    Lab lab(hitting(without_gravity(), threshold));
    lab.add_ground();
    lab.add({.position = {0, 1, 0}, .linear_velocity = {0, -3, 0}}, Sphere{0.5f}, {.restitution = 1.0f});
    return hits_over(lab, 30).size();
  };
  EXPECT_EQ(count(0.0f), 1u);
  EXPECT_EQ(count(3.0f), 1u);
  EXPECT_EQ(count(std::nextafter(3.0f, 4.0f)), 0u);
  EXPECT_EQ(count(1e6f), 0u);
}

TEST(HitEvents, AreNoneOfWhatRestsRollsOrSlides) {
  Lab lab(hitting(without_sleep(), 0.25f));
  std::vector<float> heights(30 * 90);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = 0.0f;
  lab.add({.type = BodyType::fixed, .position = {0, 0, -50}},
          height_field_mesh({.columns = 30, .rows = 90, .heights = heights}));
  lab.add_ground({.friction = 0.1f});
  lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.add({.position = {0, 1.5f, 0}}, Box{});
  lab.add({.position = {5, 0.5f, 0}, .linear_velocity = {0, 0, 5}, .angular_velocity = {10, 0, 0}},
          Sphere{0.5f});
  lab.add({.position = {8, 0.5f, 0}, .linear_velocity = {0, 0, 15}}, Box{}, {.friction = 0.05f});
  EXPECT_TRUE(hits_over(lab, 120).empty());
}

TEST(HitEvents, AreThePressedContactsAtTheThresholdOrAbove) {
  for (const float speed : {0.0f, 0.5f, 2.0f}) {
    Lab all(WorldSettings{}), only(hitting(WorldSettings{}, speed)), none(WorldSettings{});
    WorldSettings settings;
    settings.contact_events = ContactEvents::all;
    settings.hit_event_speed = speed;
    all.world.set_settings(settings);
    std::vector<BodyId> bodies[3];
    Lab* const labs[] = {&all, &only, &none};
    const Material material{.friction = 0.6f, .restitution = 0.3f};
    for (int i = 0; i < 3; ++i) bodies[i] = add_heap(*labs[i], 100, 7, material);
    Random random(11);
    std::size_t hits = 0;
    for (int i = 0; i < 300; ++i) {
      const auto pick = static_cast<std::size_t>(random.uniform(0, 99.5f));
      const float dt = i % 50 == 49 ? 0.0f : kStep;
      const float fling = random.uniform(-8, 8);
      for (int k = 0; k < 3; ++k) {
        if (i % 5 == 2) labs[k]->world.set_linear_velocity(bodies[k][pick], {0, fling, 0});
        labs[k]->run(1, dt);
      }
      const Hits expected = hits_among_all(all.world, speed);
      ASSERT_TRUE(same_events(hits_of(all.world), expected)) << speed << ", step " << i;
      ASSERT_TRUE(same_events(hits_of(only.world), expected)) << speed << ", step " << i;
      ASSERT_TRUE(only.world.contact_begins().empty() && only.world.contact_persists().empty() &&
                  only.world.contact_ends().empty());
      ASSERT_TRUE(none.world.contact_hits().empty());
      ASSERT_EQ(only.world.hash(), none.world.hash()) << "asking for hits changes no motion";
      ASSERT_TRUE(dt > 0.0f || expected.empty()) << "nothing is pressed in a step of no length";
      hits += expected.size();
    }
    EXPECT_GT(hits, 50u) << speed;
    const Events& events = internals(only.world).events;
    EXPECT_TRUE(events.touching.empty()) << "hits need not be remembered";
    EXPECT_EQ(events.resting_touches, 0);
  }
}

TEST(HitEvents, ComeForShapesThatAskForThem) {
  Lab lab(without_sleep());
  lab.add_ground();
  std::vector<ShapeId> shapes;
  for (const ContactEvents asked : {ContactEvents::none, ContactEvents::begin_end, ContactEvents::hit,
                                    ContactEvents::persist | ContactEvents::hit, ContactEvents::all}) {
    const float x = 3.0f * static_cast<float>(shapes.size());
    shapes.push_back(lab.world.add_shape(lab.world.create_body({.position = {x, 2, 0}}), Box{}, {},
                                         {.contact_events = asked}));
  }
  Hits hits, begins, persists;
  for (int i = 0; i < 60; ++i) {
    lab.run(1);
    const auto add = [](Hits& to, std::span<const ContactEvent> from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    add(hits, lab.world.contact_hits());
    add(begins, lab.world.contact_begins());
    add(persists, lab.world.contact_persists());
  }
  const auto has = [](const Hits& list, ShapeId shape) {
    return std::any_of(list.begin(), list.end(), [&](const ContactEvent& e) { return e.shape_b == shape; });
  };
  const auto told = [&](std::size_t i) {
    return std::vector<bool>{has(hits, shapes[i]), has(begins, shapes[i]), has(persists, shapes[i])};
  };
  EXPECT_EQ(told(0), (std::vector<bool>{false, false, false}));
  EXPECT_EQ(told(1), (std::vector<bool>{false, true, false}));
  EXPECT_EQ(told(2), (std::vector<bool>{true, false, false}));
  EXPECT_EQ(told(3), (std::vector<bool>{true, false, true}));
  EXPECT_EQ(told(4), (std::vector<bool>{true, true, true}));
  // Who asks for more than hits gets a begin of the contact that goes on, and who no longer does its end.
  lab.world.set_contact_events(shapes[2], ContactEvents::all);
  lab.run(1);
  ASSERT_EQ(lab.world.contact_begins().size(), 1u);
  EXPECT_EQ(lab.world.contact_begins()[0].shape_b, shapes[2]);
  lab.world.set_contact_events(shapes[2], ContactEvents::hit);
  lab.run(1);
  ASSERT_EQ(lab.world.contact_ends().size(), 1u);
  EXPECT_EQ(lab.world.contact_ends()[0].shape_b, shapes[2]);
}

// A gutter: the ball meets both of its sides, each with a manifold of its own.
TEST(HitEvents, OfAPairWithSeveralManifoldsAreOne) {
  Lab lab(hitting());
  const std::vector<Vec3> vertices{{-2, 2, -5}, {-2, 2, 5}, {0, 0, -5}, {0, 0, 5}, {2, 2, -5}, {2, 2, 5}};
  const std::vector<MeshTriangle> triangles{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
  lab.add({.type = BodyType::fixed}, TriangleMesh(vertices, triangles));
  lab.add({.position = {0, 3, 0}}, Sphere{0.5f});
  Hits hits;
  for (int i = 0; i < 120 && hits.empty(); ++i) hits = hits_over(lab, 1);
  EXPECT_EQ(lab.world.stats().contacts, 2);
  ASSERT_EQ(hits.size(), 1u);
  const double fall = std::sqrt(2.0 * kGravity * (3.0 - 0.5 * std::sqrt(2.0)));
  EXPECT_NEAR(hits[0].approach_speed, fall * std::sqrt(0.5), 0.15);
  double impulse = 0.0;
  for (const std::int32_t contact : internals(lab.world).contacts.active)
    impulse += static_cast<double>(internals(lab.world).events.impulse[contact]);
  EXPECT_NEAR(hits[0].normal_impulse, impulse, 1e-4 * impulse);
}

// The floor and the wall are one mesh: the ball presses on the one while it comes closer to the other.
TEST(HitEvents, AreNoneBeforeTheBallReachesAWallOfTheMeshThatItSlidesOn) {
  const std::vector<Vec3> vertices{{-9, 0, -5}, {-9, 0, 5}, {0, 0, -5}, {0, 0, 5}, {0, 5, -5}, {0, 5, 5}};
  const std::vector<MeshTriangle> triangles{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
  for (int i = 0; i < 50; ++i) {
    Lab lab(hitting(without_sleep(), 0.5f));
    lab.add({.type = BodyType::fixed}, TriangleMesh(vertices, triangles), {.friction = 0.0f});
    const BodyId ball = lab.add(
        {.position = {-1.5f - 0.0007f * static_cast<float>(i), 0.5f, 0}, .linear_velocity = {1.1f, 0, 0}},
        Sphere{0.5f}, {.friction = 0.0f});
    Hits hits;
    double before = 0.0;
    for (int step = 0; step < 120 && hits.empty(); ++step) {
      before = lab.velocity(ball).x();
      hits = hits_over(lab, 1);
    }
    ASSERT_EQ(hits.size(), 1u) << i;
    EXPECT_NEAR(hits[0].approach_speed, before, 1e-3) << i;
    EXPECT_LT(lab.velocity(ball).x(), 0.999 * before) << i << ": nothing but the wall slows it down";
  }
}

TEST(HitEvents, OfABoxThatTipsOverIsOneWhenItsFaceLands) {
  constexpr float kFineStep = 1.0f / 240.0f;
  Lab lab(hitting(without_sleep(), 0.5f));
  lab.add_ground({.friction = 10.0f});
  // On its lower edge, its center a little beyond it.
  const float lean = 0.9f;
  const double reach = std::sqrt(0.5), angle = 0.25 * 3.14159265358979 + static_cast<double>(lean);
  const BodyId box = lab.add({.position = {static_cast<float>(reach * std::cos(angle)),
                                           static_cast<float>(reach * std::sin(angle)), 0},
                              .rotation = from_axis_angle({0, 0, 1}, lean)},
                             Box{}, {.friction = 10.0f});
  Hits hits;
  double spin = 0.0;
  for (int step = 0; step < 600 && hits.empty(); ++step) {
    spin = std::abs(static_cast<double>(lab.world.angular_velocity(box).z));
    hits.clear();
    lab.run(1, kFineStep);
    hits = hits_of(lab.world);
  }
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_GT(spin, 1.0);
  EXPECT_NEAR(hits[0].approach_speed, spin, 0.05 * spin)
      << "its free edge is 1 m from the one that it turns on";
  EXPECT_LT(std::abs(static_cast<double>(lab.world.angular_velocity(box).z)), 0.9 * spin)
      << "the face landed in this step";
}

TEST(HitEvents, OfABulletThatASweepStopsTellItsSpeed) {
  for (int i = 0; i < 40; ++i) {
    Lab lab(hitting(without_gravity()));
    lab.add({.type = BodyType::fixed}, Box{{0.02f, 2, 2}});
    const float speed = 200.0f;
    lab.add({.position = {-7.0f - 0.11f * static_cast<float>(i), 0, 0}, .linear_velocity = {speed, 0, 0}},
            Sphere{0.05f}, {.restitution = i % 2 == 0 ? 0.0f : 0.8f});
    const Hits hits = hits_over(lab, 30);
    ASSERT_EQ(hits.size(), 1u) << i;
    EXPECT_NEAR(hits[0].approach_speed, speed, 1e-3 * speed) << i;
  }
}

TEST(HitEvents, OfAKinematicHammerTellItsSpeedEvenAtASleeper) {
  for (const bool asleep : {false, true}) {
    Lab lab(hitting(asleep ? WorldSettings{} : without_sleep()));
    lab.add_ground();
    const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{}, {.restitution = 0.5f});
    const BodyId hammer = lab.add({.type = BodyType::kinematic, .position = {-9, 0.6f, 0}}, Box{});
    if (asleep) lab.run(120);
    ASSERT_EQ(lab.world.is_awake(box), !asleep);
    lab.world.set_pose(hammer, {{-3, 0.6f, 0}, {}});
    lab.world.set_linear_velocity(hammer, {5, 0, 0});
    Hits hits = hits_over(lab, 30);
    ASSERT_EQ(hits.size(), 1u) << asleep;
    EXPECT_EQ(hits[0].body_b, hammer);
    EXPECT_NEAR(hits[0].approach_speed, 5.0f, 0.05f);
    EXPECT_NEAR(hits[0].normal.x, -1.0f, 1e-4f);
  }
}

TEST(HitEvents, AreNoneOfSleepersWhateverTheThreshold) {
  Lab lab(hitting(WorldSettings{}, 0.0f));
  lab.add_ground();
  const BodyId lower = lab.add({.position = {0, 0.5f, 0}}, Box{});
  const BodyId upper = lab.add({.position = {0, 1.5f, 0}}, Box{});
  lab.run(10);
  EXPECT_EQ(lab.world.contact_hits().size(), 2u);
  lab.run(200);
  ASSERT_FALSE(lab.world.is_awake(lower));
  EXPECT_TRUE(hits_over(lab, 10).empty());
  lab.world.wake(upper);
  lab.run(1);
  EXPECT_EQ(lab.world.contact_hits().size(), 2u);
}

// The row passes the blow on within the step; its inner contacts were not approaching.
TEST(HitEvents, OfACradleAreOnTheSideThatIsStruck) {
  constexpr int kBalls = 5;
  constexpr float kRadius = 0.1f, kRope = 1.0f;
  Lab lab(hitting(without_sleep(), 0.5f));
  std::vector<BodyId> balls;
  const double lift = 0.6;  // rad
  for (int i = 0; i < kBalls; ++i) {
    const float x = 2.0f * kRadius * static_cast<float>(i);
    const Vec3 hung = {x, -kRope, 0};
    const Vec3 drawn = {x - kRope * static_cast<float>(std::sin(lift)),
                        -kRope * static_cast<float>(std::cos(lift)), 0};
    balls.push_back(lab.add({.position = i == 0 ? drawn : hung}, Sphere{kRadius},
                            {.friction = 0.0f, .restitution = 1.0f}));
    lab.world.create_joint({.body_a = kWorld, .body_b = balls.back(), .frame_a = {{x, 0, 0}, {}}},
                           DistanceJoint{{.lower = kRope, .upper = kRope}});
  }
  const double speed = std::sqrt(2.0 * kGravity * static_cast<double>(kRope) * (1.0 - std::cos(lift)));
  const Hits hits = hits_over(lab, 220);
  ASSERT_GE(hits.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const bool left = i % 2 == 0;
    EXPECT_EQ(hits[i].body_a, balls[left ? 0 : kBalls - 2]) << i;
    EXPECT_EQ(hits[i].body_b, balls[left ? 1 : kBalls - 1]) << i;
    EXPECT_NEAR(hits[i].approach_speed, speed, 0.1 * speed) << i;
  }
}

TEST(HitEvents, AfterARestoreAreThoseWithoutIt) {
  Lab lab(hitting(WorldSettings{}, 0.5f));
  add_heap(lab, 40, 3, {.restitution = 0.4f});
  lab.run(15);
  Snapshot snapshot;
  save(lab.world, snapshot);
  const Hits expected = hits_over(lab, 60);
  EXPECT_GT(expected.size(), 20u);
  restore(lab.world, snapshot);
  EXPECT_EQ(lab.world.settings().hit_event_speed, 0.5f);
  EXPECT_TRUE(same_events(hits_over(lab, 60), expected));
  Lab other(without_gravity());
  restore(other.world, snapshot);
  EXPECT_TRUE(same_events(hits_over(other, 60), expected));
}

TEST(HitEvents, OfAWorldThatWasMovedFromAreNone) {
  Lab lab(hitting(without_gravity()));
  lab.add_ground();
  lab.add({.position = {0, 0.51f, 0}, .linear_velocity = {0, -6, 0}}, Sphere{0.5f});
  lab.run(1);
  World other = std::move(lab.world);
  EXPECT_EQ(other.contact_hits().size(), 1u);
  EXPECT_TRUE(lab.world.contact_hits().empty());
  EXPECT_TRUE(lab.world.joint_events().empty());
}

}  // namespace
}  // namespace scree::physics
