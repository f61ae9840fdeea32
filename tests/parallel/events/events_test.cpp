// Laws of events: every contact begins, persists and ends, once each, in order, with the impulses that acted.
#include <core/world/world_data.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace scree::physics {
namespace {

// A lab whose shapes all report events.
WorldSettings told(WorldSettings settings = without_sleep(), ContactEvents events = ContactEvents::all) {
  settings.contact_events = events;
  return settings;
}

ShapeId shape_of(const World& world, BodyId body) {
  ShapeId shape;
  world.shapes_of(body, {&shape, 1});
  return shape;
}

std::pair<ShapeId, ShapeId> pair_of(const auto& event) { return {event.shape_a, event.shape_b}; }

// By the indices of both shapes, each pair once.
bool ascends(const auto& events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (!(events[i].shape_a.index < events[i].shape_b.index)) return false;
    if (i == 0) continue;
    const auto key = [](const auto& e) { return std::pair(e.shape_a.index, e.shape_b.index); };
    if (!(key(events[i - 1]) < key(events[i]))) return false;
  }
  return true;
}

struct Counts {
  std::size_t begins = 0, persists = 0, ends = 0;
};
Counts count_over(Lab& lab, int steps) {
  Counts counts;
  for (int i = 0; i < steps; ++i) {
    lab.run(1);
    counts.begins += lab.world.contact_begins().size();
    counts.persists += lab.world.contact_persists().size();
    counts.ends += lab.world.contact_ends().size();
  }
  return counts;
}

TEST(Events, ABoxThatLandsAndIsTakenAwayBeginsOncePersistsAndEndsOnce) {
  Lab lab(told());
  const BodyId ground = lab.add_ground();
  const BodyId box = lab.add({.position = {0, 1.5f, 0}}, Box{});
  std::size_t begins = 0, persists = 0;
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    for (const ContactEvent& event : lab.world.contact_begins()) {
      ++begins;
      EXPECT_EQ(event.shape_a, shape_of(lab.world, ground));
      EXPECT_EQ(event.shape_b, shape_of(lab.world, box));
      EXPECT_EQ(event.body_a, ground);
      EXPECT_EQ(event.body_b, box);
      EXPECT_EQ(event.point_count, 4);
      EXPECT_NEAR(event.approach_speed, std::sqrt(2.0 * kGravity * 1.0), 0.3);
    }
    persists += lab.world.contact_persists().size();
    EXPECT_TRUE(lab.world.contact_ends().empty());
  }
  EXPECT_EQ(begins, 1u);
  EXPECT_GT(persists, 80u);
  lab.world.set_pose(box, {{0, 5, 0}, {}});
  lab.run(1);
  ASSERT_EQ(lab.world.contact_ends().size(), 1u);
  EXPECT_EQ(lab.world.contact_ends()[0].body_b, box);
  EXPECT_TRUE(lab.world.contact_persists().empty());
  lab.run(1);
  EXPECT_TRUE(lab.world.contact_ends().empty());
}

TEST(Events, ARestingBodyIsPressedByItsWeight) {
  Lab lab(told());
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.run(200);
  ASSERT_EQ(lab.world.contact_persists().size(), 1u);
  const double expected = lab.mass(box) * kGravity * static_cast<double>(kStep);
  EXPECT_NEAR(lab.world.contact_persists()[0].normal_impulse, expected, 1e-3 * expected);
  EXPECT_NEAR(lab.world.contact_persists()[0].approach_speed, 0.0f, 1e-3f);
  lab.run(1, 0.5f * kStep);  // the impulse is that of the step, not of a substep
  EXPECT_NEAR(lab.world.contact_persists()[0].normal_impulse, 0.5 * expected, 2e-2 * expected);
}

TEST(Events, TheImpulseOfAnImpactIsTheChangeOfMomentum) {
  for (const float restitution : {0.0f, 0.5f, 0.9f}) {
    WorldSettings settings = told(without_gravity());
    Lab lab(settings);
    lab.add_ground({.restitution = restitution});
    const BodyId ball = lab.add({.position = {0, 1, 0}, .linear_velocity = {0, -6, 0}}, Sphere{0.3f},
                                {.restitution = restitution});
    double impulse = 0.0, approach = 0.0;
    for (int i = 0; i < 30; ++i) {
      lab.run(1);
      for (const auto& list : {lab.world.contact_begins(), lab.world.contact_persists()}) {
        for (const ContactEvent& event : list) {
          impulse += event.normal_impulse;
          approach = std::max(approach, static_cast<double>(event.approach_speed));
        }
      }
    }
    const double turned = lab.mass(ball) * (lab.velocity(ball).y() + 6.0);
    EXPECT_NEAR(impulse, turned, 1e-3 * turned) << restitution;
    EXPECT_NEAR(approach, 6.0, 1e-3) << restitution;
  }
}

TEST(Events, AReboundingBallBeginsAndEndsEveryContact) {
  Lab lab(told());
  lab.add_ground();
  const BodyId ball = lab.add({.position = {0, 2, 0}}, Sphere{0.5f}, {.restitution = 1.0f});
  lab.run(0);
  const Counts counts = count_over(lab, 600);
  EXPECT_GT(counts.begins, 5u);
  const bool down = internals(lab.world).events.touching.size() == 1;
  EXPECT_EQ(counts.ends + (down ? 1 : 0), counts.begins);
  EXPECT_GT(lab.height(ball), 0.4);
}

TEST(Events, TheNormalPointsFromTheLowerShapeToTheHigher) {
  for (const bool ground_first : {true, false}) {
    for (const BodyType type : {BodyType::fixed, BodyType::kinematic, BodyType::dynamic}) {
      Lab lab(told(without_gravity()));
      const BodyDef below{.type = type, .position = {0, -0.5f, 0}, .mass = 100.0f};
      const BodyDef above{.position = {0, 0.495f, 0}};
      BodyId bodies[2];
      bodies[0] = lab.add(ground_first ? below : above, Box{});
      bodies[1] = lab.add(ground_first ? above : below, Box{});
      lab.run(1);
      ASSERT_EQ(lab.world.contact_begins().size(), 1u);
      const ContactEvent& event = lab.world.contact_begins()[0];
      EXPECT_EQ(event.body_a, bodies[0]);
      EXPECT_EQ(event.body_b, bodies[1]);
      EXPECT_NEAR(event.normal.y, ground_first ? 1.0f : -1.0f, 1e-5f);
      ASSERT_EQ(event.point_count, 4);
      for (const ContactPoint& point : event.points) {
        EXPECT_NEAR(std::abs(point.position.x), 0.5f, 1e-3f);
        EXPECT_NEAR(std::abs(point.position.z), 0.5f, 1e-3f);
        EXPECT_NEAR(point.position.y, 0.0f, 0.01f);
        EXPECT_NEAR(point.separation, -0.005f, 1e-4f);
      }
    }
  }
}

TEST(Events, NearbyShapesDoNotTouch) {
  Lab lab(told(without_gravity()));
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.51f, 0}}, Box{});
  const Counts counts = count_over(lab, 20);
  EXPECT_EQ(lab.world.stats().contacts, 1) << "within the speculative distance";
  EXPECT_EQ(counts.begins, 0u);
  // After the shapes have touched, a jitter of less than 5 mm does not end the contact.
  lab.world.set_pose(box, {{0, 0.499f, 0}, {}});
  lab.run(1);
  EXPECT_EQ(lab.world.contact_begins().size(), 1u);
  for (const float gap : {0.003f, 0.004f, 0.001f}) {
    lab.world.set_pose(box, {{0, 0.5f + gap, 0}, {}});
    lab.world.set_linear_velocity(box, {});
    lab.run(1);
    EXPECT_EQ(lab.world.contact_persists().size(), 1u) << gap;
  }
  lab.world.set_pose(box, {{0, 0.51f, 0}, {}});
  lab.world.set_linear_velocity(box, {});
  lab.run(1);
  EXPECT_EQ(lab.world.contact_ends().size(), 1u);
}

TEST(Events, OfAHullThatTipsOverOnlyTheEdgeTouchesUntilItsFaceLands) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back({k & 1 ? 0.5f : -0.5f, k & 2 ? 0.5f : -0.5f, k & 4 ? 0.5f : -0.5f});
  }
  Lab lab(told());
  lab.add_ground({.friction = 1.0f});
  // Stands on its lower left edge, leans by 30 degrees and turns about that edge.
  const float cosine = std::sqrt(0.75f), sine = 0.5f, spin = 2.0f;
  const float arm_x = 0.5f * (cosine - sine), arm_y = 0.5f * (cosine + sine);
  lab.add({.position = {0, arm_y - 0.001f, 0},
           .rotation = rotation_about({0, 0, 1}, std::numbers::pi / 6),
           .linear_velocity = {spin * arm_y, -spin * arm_x, 0},
           .angular_velocity = {0, 0, -spin}},
          ConvexHull{Hull(corners)}, {.friction = 1.0f});
  int before = 0;
  float landing = 0.0f;
  for (int i = 0; i < 30 && landing == 0.0f; ++i) {
    lab.run(1);
    const auto events = i == 0 ? lab.world.contact_begins() : lab.world.contact_persists();
    ASSERT_EQ(events.size(), 1u) << i;
    const ContactEvent& event = events[0];
    if (event.point_count == 4) {
      landing = event.approach_speed;
      continue;
    }
    ++before;
    EXPECT_EQ(event.point_count, 2) << i;
    EXPECT_LT(event.approach_speed, 0.5f) << i;
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(event.points[k].separation, 0.0f, kSpeculativeDistance) << i;
  }
  EXPECT_GT(before, 5);
  // By conservation of energy it turns at 3 rad/s when the face lands.
  EXPECT_NEAR(landing, 3.0f, 0.6f);
}

TEST(Events, ContactsOutlastSleep) {
  Lab lab(told(WorldSettings{}));
  lab.add_ground();
  const BodyId lower = lab.add({.position = {0, 0.5f, 0}}, Box{});
  const BodyId upper = lab.add({.position = {0, 1.5f, 0}}, Box{});
  Counts counts = count_over(lab, 200);
  ASSERT_FALSE(lab.world.is_awake(lower));
  EXPECT_EQ(counts.begins, 2u);
  EXPECT_EQ(counts.ends, 0u);
  counts = count_over(lab, 20);
  EXPECT_EQ(counts.begins + counts.persists + counts.ends, 0u) << "sleepers have nothing to tell";
  lab.world.wake(upper);
  counts = count_over(lab, 10);
  EXPECT_EQ(counts.begins + counts.ends, 0u);
  EXPECT_EQ(counts.persists, 20u);
  lab.run(200);
  ASSERT_FALSE(lab.world.is_awake(lower));
  lab.world.destroy_body(lower);
  lab.run(1);
  EXPECT_EQ(lab.world.contact_ends().size(), 2u);
}

TEST(Events, ContactsOfDestroyedShapesEndInOrderWithDeadHandles) {
  Lab lab(told());
  const BodyId ground = lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 6; ++i)
    boxes.push_back(lab.add({.position = {3.0f * static_cast<float>(i), 0.5f, 0}}, Box{}));
  lab.run(30);
  const ShapeId shape = shape_of(lab.world, boxes[1]);
  lab.world.destroy_body(boxes[4]);
  lab.world.destroy_shape(shape);
  lab.world.set_pose(boxes[2], {{6, 9, 0}, {}});
  lab.run(1);
  const auto ends = lab.world.contact_ends();
  ASSERT_EQ(ends.size(), 3u);
  EXPECT_TRUE(ascends(ends));
  EXPECT_EQ(ends[0].shape_b, shape);
  EXPECT_EQ(ends[0].body_a, ground);
  EXPECT_FALSE(lab.world.is_alive(ends[0].shape_b));
  EXPECT_TRUE(lab.world.is_alive(ends[0].body_b));
  EXPECT_TRUE(lab.world.is_alive(ends[1].shape_b));
  EXPECT_EQ(ends[2].body_b, boxes[4]);
  EXPECT_FALSE(lab.world.is_alive(ends[2].body_b));
  // The ground takes all of the remaining tangential momentum.
  lab.world.destroy_body(ground);
  lab.run(1);
  EXPECT_EQ(lab.world.contact_ends().size(), 3u);
  EXPECT_TRUE(lab.world.contact_persists().empty());
}

TEST(Events, AReusedSlotEndsTheOldContactAndBeginsTheNewOne) {
  Lab lab(told());
  lab.add_ground();
  const BodyId old_box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  const ShapeId old_shape = shape_of(lab.world, old_box);
  lab.run(30);
  lab.world.destroy_body(old_box);
  const BodyId box = lab.add({.position = {0, 0.499f, 0}}, Box{});
  const ShapeId shape = shape_of(lab.world, box);
  ASSERT_EQ(shape.index, old_shape.index);
  lab.run(1);
  ASSERT_EQ(lab.world.contact_ends().size(), 1u);
  EXPECT_EQ(lab.world.contact_ends()[0].shape_b, old_shape);
  EXPECT_EQ(lab.world.contact_ends()[0].body_b, old_box);
  ASSERT_EQ(lab.world.contact_begins().size(), 1u);
  EXPECT_EQ(lab.world.contact_begins()[0].shape_b, shape);
  EXPECT_TRUE(lab.world.contact_persists().empty());
}

TEST(Events, OnlyShapesThatRequestEventsGetThem) {
  Lab lab;
  lab.add_ground();
  const auto add = [&](float x, ContactEvents events) {
    const BodyId body = lab.world.create_body({.position = {x, 0.499f, 0}});
    return lab.world.add_shape(body, Box{}, {}, {.contact_events = events});
  };
  add(0, ContactEvents::none);
  const ShapeId begin_end = add(3, ContactEvents::begin_end);
  const ShapeId persist = add(6, ContactEvents::persist);
  const ShapeId all = add(9, ContactEvents::all);
  EXPECT_EQ(lab.world.contact_events(persist), ContactEvents::persist);
  lab.run(1);
  ASSERT_EQ(lab.world.contact_begins().size(), 2u);
  EXPECT_EQ(lab.world.contact_begins()[0].shape_b, begin_end);
  EXPECT_EQ(lab.world.contact_begins()[1].shape_b, all);
  EXPECT_TRUE(lab.world.contact_persists().empty());
  lab.run(1);
  EXPECT_TRUE(lab.world.contact_begins().empty());
  ASSERT_EQ(lab.world.contact_persists().size(), 2u);
  EXPECT_EQ(lab.world.contact_persists()[0].shape_b, persist);
  // A shape that stops asking gets the end of its contact; one that asks again gets a begin.
  lab.world.set_contact_events(begin_end, ContactEvents::none);
  lab.world.set_contact_events(persist, ContactEvents::all);
  lab.run(1);
  ASSERT_EQ(lab.world.contact_ends().size(), 1u);
  EXPECT_EQ(lab.world.contact_ends()[0].shape_b, begin_end);
  ASSERT_EQ(lab.world.contact_begins().size(), 1u);
  EXPECT_EQ(lab.world.contact_begins()[0].shape_b, persist);
  for (const ShapeId shape : {persist, all}) lab.world.set_contact_events(shape, ContactEvents::none);
  lab.run(1);
  EXPECT_EQ(lab.world.contact_ends().size(), 2u);
  const Counts counts = count_over(lab, 10);
  EXPECT_EQ(counts.begins + counts.persists + counts.ends, 0u);
  EXPECT_TRUE(internals(lab.world).events.touching.empty());
}

TEST(Events, RequestingEventsChangesNoMotion) {
  std::uint64_t hashes[2];
  for (const bool asked : {false, true}) {
    Lab lab(asked ? told() : without_sleep());
    add_heap(lab, 60, 4, {.friction = 0.6f, .restitution = 0.3f});
    lab.run(120);
    hashes[asked ? 1 : 0] = lab.world.hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Events, AreSortedAndEveryBeginHasOneEnd) {
  Lab lab(told(WorldSettings{}));
  std::vector<BodyId> bodies = add_heap(lab, 120, 9);
  Random random(5);
  std::set<std::pair<ShapeId, ShapeId>> touching;
  std::size_t begins = 0, ends = 0;
  for (int i = 0; i < 400; ++i) {
    lab.run(1);
    const World& world = lab.world;
    ASSERT_TRUE(ascends(world.contact_begins()));
    ASSERT_TRUE(ascends(world.contact_persists()));
    ASSERT_TRUE(ascends(world.contact_ends()));
    for (const ContactEnd& end : world.contact_ends()) ASSERT_EQ(touching.erase(pair_of(end)), 1u);
    for (const ContactEvent& event : world.contact_persists()) {
      ASSERT_TRUE(touching.contains(pair_of(event)));
      ASSERT_GE(event.normal_impulse, 0.0f);
    }
    for (const ContactEvent& begin : world.contact_begins()) {
      ASSERT_TRUE(touching.insert(pair_of(begin)).second);
      ASSERT_EQ(world.body_of(begin.shape_a), begin.body_a);
      ASSERT_EQ(world.body_of(begin.shape_b), begin.body_b);
    }
    begins += world.contact_begins().size();
    ends += world.contact_ends().size();
    const auto pick = static_cast<std::size_t>(random.uniform(0, static_cast<float>(bodies.size())));
    if (i % 7 == 3) lab.world.set_linear_velocity(bodies[pick], {0, 6, 0});
    if (i % 20 == 11) {
      lab.world.destroy_body(bodies[pick]);
      bodies[pick] = lab.add({.position = {random.uniform(-1, 1), 5, random.uniform(-1, 1)}}, Sphere{0.2f});
    }
  }
  EXPECT_GT(begins, 300u);
  EXPECT_GT(ends, 100u);
}

TEST(Events, AStepOfNoLengthListsTouchingPairsWithoutImpulse) {
  Lab lab(told());
  lab.add_ground();
  lab.add({.position = {0, 0.499f, 0}}, Box{});
  lab.run(1, 0.0f);
  ASSERT_EQ(lab.world.contact_begins().size(), 1u);
  EXPECT_EQ(lab.world.contact_begins()[0].normal_impulse, 0.0f);
  lab.run(1, 0.0f);
  EXPECT_EQ(lab.world.contact_persists().size(), 1u);
  EXPECT_TRUE(lab.world.contact_begins().empty());
}

TEST(Events, RestoredBodiesAreListedInOrder) {
  Lab lab;
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (int i = 0; i < 4; ++i)
    boxes.push_back(lab.add({.position = {5.0f * static_cast<float>(i), 3, 0}}, Box{}));
  lab.run(5);
  EXPECT_TRUE(lab.world.restored_bodies().empty());
  // No call accepts such a force; a step must stay sound all the same.
  for (const std::size_t lost : {3u, 1u})
    internals(lab.world).bodies.force[boxes[lost].index].force[0] = std::numeric_limits<float>::infinity();
  lab.run(1);
  ASSERT_EQ(lab.world.restored_bodies().size(), 2u);
  EXPECT_EQ(lab.world.restored_bodies()[0], boxes[1]);
  EXPECT_EQ(lab.world.restored_bodies()[1], boxes[3]);
  lab.run(1);
  EXPECT_TRUE(lab.world.restored_bodies().empty());
}

TEST(Events, AMovedFromWorldHasNone) {
  Lab lab(told());
  lab.add_ground();
  lab.add({.position = {0, 0.499f, 0}}, Box{});
  lab.run(1);
  World other = std::move(lab.world);
  EXPECT_EQ(other.contact_begins().size(), 1u);
  EXPECT_TRUE(lab.world.contact_begins().empty());
  EXPECT_TRUE(lab.world.contact_persists().empty());
  EXPECT_TRUE(lab.world.contact_ends().empty());
  EXPECT_TRUE(lab.world.restored_bodies().empty());
}

TEST(Events, AnUnknownKindOfEventIsAnError) {
  Lab lab;
  const BodyId body = lab.add({}, Box{});
  const ShapeId shape = shape_of(lab.world, body);
  const auto wrong = static_cast<ContactEvents>(8);
  EXPECT_THROW(lab.world.set_contact_events(shape, wrong), Error);
  EXPECT_THROW(lab.world.add_shape(body, Box{}, {}, {.contact_events = wrong}), Error);
  WorldSettings settings = lab.world.settings();
  settings.contact_events = wrong;
  EXPECT_THROW(lab.world.set_settings(settings), Error);
  EXPECT_EQ(lab.world.contact_events(shape), ContactEvents::none);
  lab.world.destroy_body(body);
  EXPECT_THROW(lab.world.contact_events(shape), Error);
  EXPECT_THROW(lab.world.set_contact_events(shape, ContactEvents::all), Error);
}

}  // namespace
}  // namespace scree::physics
