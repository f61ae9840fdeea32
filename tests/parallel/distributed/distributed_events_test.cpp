// The law of events across ranks: together they list what one process lists, each where it moves one of the
// bodies.
#include <gtest/gtest.h>
#include <parallel/distributed/border.h>
#include <scree/distributed_world.h>
#include <scree/snapshot.h>
#include <scree/step.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/parallel/distributed/step_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::redraw_owners;
using distributed_tests::run_ranks;
using physics::kStep;

using EventsOfStep = std::set<std::string>;

std::string text_of(BodyId body) { return std::to_string(body.index); }
std::string text_of(const ContactEvent& event) {
  return std::to_string(event.shape_a.index) + " " + std::to_string(event.shape_b.index) + " " +
         std::to_string(event.point_count) + " " + std::to_string(event.normal_impulse) + " " +
         std::to_string(event.approach_speed) + " " + std::to_string(event.normal.y);
}
std::string text_of(const ContactEnd& end) {
  return std::to_string(end.shape_a.index) + " " + std::to_string(end.shape_b.index);
}
std::string text_of(const SensorEvent& event) {
  return std::to_string(event.sensor.index) + " " + std::to_string(event.visitor.index);
}
std::string text_of(const JointEvent& event) {
  return std::to_string(event.joint.index) + " " + std::to_string(event.force) + " " +
         std::to_string(event.torque);
}
std::string text_of(JointId joint) { return std::to_string(joint.index); }

void add_events(const World& world, EventsOfStep& events) {
  const auto add = [&](const char* kind, const auto& list) {
    for (const auto& event : list) events.insert(std::string(kind) + " " + text_of(event));
  };
  add("begins", world.contact_begins());
  add("persists", world.contact_persists());
  add("ends", world.contact_ends());
  add("hits", world.contact_hits());
  add("enters", world.sensor_begins());
  add("leaves", world.sensor_ends());
  add("falls asleep", world.sleep_begins());
  add("wakes", world.sleep_ends());
  add("bears", world.joint_events());
  add("breaks", world.broken_joints());
}

// A pile on a tray that counts many contacts, a sensor in it, and a chain that falls on it and breaks.
World make_eventful(std::vector<BodyId>& bodies) {
  scenes::Scene scene = scenes::build("pile", {{"bodies", 100}}).front();
  scene.settings.contact_events = ContactEvents::all;
  scene.settings.hit_event_speed = 0.5f;
  World world(scene.settings);
  bodies = scenes::populate(world, scene);
  const BodyId gate = world.create_body({.type = BodyType::fixed});
  world.add_shape(gate, Box{{6, 0.6f, 6}}, {}, {.local_pose = {{0, 2.5f, 0}, {}}, .sensor = true});
  const BodyId tray = world.create_body({.position = {0, 6, 0}});  // on which more than 32 lie
  world.add_shape(tray, Box{{3, 0.1f, 3}});
  for (int i = 0; i < 40; ++i) {
    const BodyId ball = world.create_body(
        {.position = {0.8f * static_cast<float>(i % 7 - 3), 6.4f + static_cast<float>(i / 21),
                      0.8f * static_cast<float>(i / 7 - 3)}});
    world.add_shape(ball, Sphere{0.25f});
    bodies.push_back(ball);
  }
  BodyId last = world.create_body({.type = BodyType::fixed});
  for (int i = 0; i < 8; ++i) {
    const BodyId link = world.create_body({.position = {-3.0f + 0.5f * static_cast<float>(i), 9, 0}});
    world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
    world.create_joint({.body_a = last,
                        .body_b = link,
                        .frame_a = {i == 0 ? Vec3{-3.25f, 9, 0} : Vec3{0.25f, 0, 0}, {}},
                        .frame_b = {{-0.25f, 0, 0}, {}},
                        .break_force = 1500,
                        .event_force = 200},
                       BallJoint{});
    last = link;
  }
  return world;
}

void stir(World& world, const std::vector<BodyId>& bodies, int step) {
  if (step == 90) world.destroy_body(bodies[bodies.size() / 3]);
  if (step == 200 || step == 240) {  // some of which are in the gate
    for (std::size_t i = 7; i < bodies.size(); i += 20) {
      if (world.is_alive(bodies[i]))
        world.set_body_type(bodies[i], step == 200 ? BodyType::kinematic : BodyType::dynamic);
    }
  }
  if (step == 380) world.set_linear_velocity(bodies[bodies.size() / 2], {0.5f, 6, 0});
}

TEST(DistributedEvents, AreThoseOfOneProcessOnTheOwners) {
  constexpr int kSteps = 460;
  std::vector<BodyId> bodies;
  World one = make_eventful(bodies);
  Workers one_thread(1);
  std::vector<EventsOfStep> expected(kSteps);
  std::map<std::string, int> kinds;
  for (int i = 0; i < kSteps; ++i) {
    stir(one, bodies, i);
    step(one, kStep, one_thread);
    add_events(one, expected[static_cast<std::size_t>(i)]);
    for (const std::string& event : expected[static_cast<std::size_t>(i)])
      ++kinds[event.substr(0, event.find(' '))];
  }
  EXPECT_EQ(kinds.size(), 10u);  // all of them occur
  for (const bool at_random : {false, true}) {
    std::mutex mutex;
    std::vector<EventsOfStep> found(kSteps);
    const auto errors = run_ranks(4, [&](int, Transport& transport) {
      std::vector<BodyId> all;
      World whole = make_eventful(all);
      DistributedWorld world(std::move(whole), transport,
                             {.steps_per_look = at_random ? 0 : 5, .imbalance = 1.0f});
      Workers workers(1);
      for (int i = 0; i < kSteps; ++i) {
        stir(world.world(), all, i);
        if (at_random) redraw_owners(world.world(), i, 4, 10, workers);
        world.step(kStep, workers);
        for (const ContactEvent& event : world.world().contact_begins())
          EXPECT_TRUE(world.owns(event.body_a) || world.owns(event.body_b));
        for (const BodyId body : world.world().sleep_begins()) EXPECT_TRUE(world.owns(body));
        const std::lock_guard lock(mutex);
        add_events(world.world(), found[static_cast<std::size_t>(i)]);
      }
    });
    EXPECT_EQ(all_of(errors), "");
    for (std::size_t i = 0; i < kSteps; ++i) ASSERT_EQ(found[i], expected[i]) << "step " << i;
  }
}

// A rank knows pairs at rest of its body and another's. Where calls make its body everybody's, it gets the
// other one with the pair that it knows.
TEST(DistributedEvents, OfSleepersEndOnceWhereNeighborsBecomeKinematicAndOwnersChange) {
  constexpr int kRanks = 4;
  WorldSettings settings;
  settings.contact_events = ContactEvents::all;
  World one(settings);
  one.add_shape(one.create_body({.type = BodyType::fixed}), HalfSpace{});
  std::vector<std::uint32_t> rows;
  for (int i = 0; i < 200; ++i) {
    const Vec3 at = {static_cast<float>(i % 10), 0.5f + 0.99f * static_cast<float>(i / 100),
                     static_cast<float>(i / 10 % 10)};
    const BodyId box = one.create_body({.position = at});
    one.add_shape(box, Box{{0.5f, 0.5f, 0.5f}});
    rows.push_back(box.index);
  }
  Workers one_thread(1);
  for (int i = 0; i < 200; ++i) step(one, kStep, one_thread);
  EXPECT_EQ(one.stats().awake_bodies, 0);
  Snapshot sleeping;
  save(one, sleeping);
  const auto change = [&](World& world, int at) {
    if (at != 2) return;
    for (std::size_t i = 0; i < rows.size(); i += 7)
      world.set_body_type(world.body_at(rows[i]), BodyType::kinematic);
  };
  constexpr int kSteps = 6;
  std::vector<EventsOfStep> expected(kSteps), found(kSteps);
  for (int i = 0; i < kSteps; ++i) {
    change(one, i);
    step(one, kStep, one_thread);
    add_events(one, expected[static_cast<std::size_t>(i)]);
  }
  std::mutex mutex;
  const auto errors = run_ranks(kRanks, [&](int, Transport& transport) {
    World restored;
    restore(restored, sleeping);
    DistributedWorld world(std::move(restored), transport, {.steps_per_look = 0});
    Workers workers(1);
    for (int i = 0; i < kSteps; ++i) {
      change(world.world(), i);
      if (i == 2) redraw_owners(world.world(), i, kRanks, 2, workers);
      world.step(kStep, workers);
      const std::lock_guard lock(mutex);
      add_events(world.world(), found[static_cast<std::size_t>(i)]);
    }
  });
  EXPECT_EQ(all_of(errors), "");
  for (std::size_t i = 0; i < kSteps; ++i) EXPECT_EQ(found[i], expected[i]) << "step " << i;
}

// Fixed plates under sleepers and sliders become dynamic: who owns them then knows what lies on them. Some
// were there at first, some come later.
TEST(DistributedEvents, OfWhatBecomesDynamicBeginNotAgain) {
  constexpr int kSteps = 330;
  const auto add_plate = [](World& world, float x) {
    const BodyId plate = world.create_body({.type = BodyType::fixed, .position = {x, 0.0f, 0}});
    world.add_shape(plate, Box{{0.45f, 0.2f, 2}});
    return plate;
  };
  const auto run = [&](World& world, auto&& take_step, auto&& note) {
    std::vector<BodyId> plates;
    for (int i = 0; i < kSteps; ++i) {
      if (i == 0 || i == 20) {
        for (int k = i == 0 ? 0 : 1; k < 12; k += 2) {
          const float x = static_cast<float>(k) - 6;
          plates.push_back(add_plate(world, x));
          for (const float z : {-1.0f, 0.0f, 1.0f}) {
            const BodyId box = world.create_body({.position = {x, 0.52f, z}});
            world.add_shape(box, Box{{0.6f, 0.3f, 0.3f}});  // over the next plates, too
            if (z > 0) world.set_linear_velocity(box, {0, 0, 0.4f});
          }
        }
      }
      if (i == 30) world.set_body_type(plates[7], BodyType::dynamic);  // under what is awake
      if (i == 300) {
        for (const std::size_t plate : {1u, 4u, 9u, 10u})
          world.set_body_type(plates[plate], BodyType::dynamic);
      }
      take_step();
      note(i);
    }
  };
  const auto make = [] {
    WorldSettings settings;
    settings.contact_events = ContactEvents::all;
    World world(settings);
    world.add_shape(world.create_body({.type = BodyType::fixed}), Box{{30, 0.5f, 30}}, {},
                    {.local_pose = {{0, -0.75f, 0}, {}}});
    return world;
  };
  std::vector<EventsOfStep> expected(kSteps), found(kSteps);
  World one = make();
  Workers one_thread(1);
  std::int64_t awake = 0;  // before those that sleep are disturbed
  run(
      one, [&] { step(one, kStep, one_thread); },
      [&](int i) {
        add_events(one, expected[static_cast<std::size_t>(i)]);
        if (i == 299) awake = one.stats().awake_bodies;
      });
  EXPECT_LT(awake, 18) << "half of the boxes";
  std::mutex mutex;
  const auto errors = run_ranks(4, [&](int, Transport& transport) {
    DistributedWorld world(make(), transport, {.steps_per_look = 5, .imbalance = 1.0f});
    Workers workers(1);
    run(
        world.world(), [&] { world.step(kStep, workers); },
        [&](int i) {
          const std::lock_guard lock(mutex);
          add_events(world.world(), found[static_cast<std::size_t>(i)]);
        });
  });
  EXPECT_EQ(all_of(errors), "");
  for (std::size_t i = 0; i < kSteps; ++i) ASSERT_EQ(found[i], expected[i]) << "step " << i;
}

}  // namespace
}  // namespace scree
