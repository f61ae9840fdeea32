// A body whose state becomes non-finite is quarantined at its last pose. Other bodies that it makes
// non-finite are restored at rest.
#include <core/world/world_data.h>
#include <tests/parallel/bodies/overload.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <span>
#include <string>

namespace scree::physics {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<BodyId> listed(std::span<const BodyId> list) { return {list.begin(), list.end()}; }

bool same_bits(const Pose& a, const Pose& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

ShapeId shape_of(const World& world, BodyId body) {
  ShapeId shape;
  EXPECT_EQ(world.shapes_of(body, {&shape, 1}), 1u);
  return shape;
}

TEST(Quarantine, ABodyThatBecomesNonFiniteInAHeapStaysAndTheOthersGoOn) {
  Lab lab;
  const std::vector<BodyId> heap = add_heap(lab, 40, 8);
  lab.run(150);
  // Two bodies pressed against each other.
  const Contacts& contacts = internals(lab.world).contacts;
  BodyId faulty;
  for (const std::int32_t row : contacts.active) {
    const Manifold& manifold = contacts.now.manifold[static_cast<std::size_t>(row)];
    if ((manifold.info & kManifoldStatic) == 0 && manifold.normal_impulse[0] > 0.0f) {
      faulty = lab.world.body_at(static_cast<std::uint32_t>(manifold.row_b));
    }
  }
  const Pose place = lab.world.pose(faulty);
  ASSERT_FALSE(lab.world.is_quarantined(faulty));
  overload(lab.world, faulty);
  lab.run(1);
  EXPECT_EQ(listed(lab.world.quarantined_bodies()), std::vector<BodyId>{faulty});
  const std::vector<BodyId> restored = listed(lab.world.restored_bodies());
  EXPECT_TRUE(std::binary_search(restored.begin(), restored.end(), faulty));
  EXPECT_GT(restored.size(), 1u) << "the bodies that it touches become non-finite, too";
  for (const BodyId body : restored) EXPECT_EQ(lab.velocity(body).norm(), 0.0);
  EXPECT_TRUE(lab.all_finite());
  for (int i = 0; i < 200; ++i) {
    lab.run(1);
    EXPECT_TRUE(lab.world.restored_bodies().empty() && lab.world.quarantined_bodies().empty()) << i;
  }
  EXPECT_TRUE(same_bits(lab.world.pose(faulty), place));
  EXPECT_TRUE(lab.world.is_quarantined(faulty));
  for (const BodyId body : heap) EXPECT_EQ(lab.world.is_quarantined(body), body == faulty);
  EXPECT_TRUE(lab.all_finite());
}

struct QuarantinedBox {
  explicit QuarantinedBox(const WorldSettings& settings = without_sleep()) : lab(settings) {
    lab.add_ground();
    box = lab.add({.position = {0, 5, 0}}, Box{});
    twin = lab.add({.position = {20, 5, 0}}, Box{});
    lab.run(3);
    quarantine();
  }
  void quarantine() {
    // No call accepts this value.
    internals(lab.world).bodies.force[box.index].force[1] = kInfinity;
    lab.run(1);
    ASSERT_TRUE(lab.world.is_quarantined(box));
    place = lab.world.pose(box);
  }
  void expect_stays() {
    lab.run(30);
    EXPECT_TRUE(lab.world.is_quarantined(box));
    EXPECT_TRUE(same_bits(lab.world.pose(box), place));
    EXPECT_EQ(lab.velocity(box).norm() + lab.spin(box).norm(), 0.0);
  }
  Lab lab;
  BodyId box, twin;
  Pose place;
};

TEST(Quarantine, NoPushMovesTheBody) {
  QuarantinedBox f;
  World& world = f.lab.world;
  EXPECT_FALSE(world.is_awake(f.box));
  f.expect_stays();
  world.add_force(f.box, {1e6f, 1e6f, 0});
  world.add_torque(f.box, {1e6f, 1e6f, 0});
  world.add_impulse(f.box, {1e4f, 0, 1e4f});
  world.add_angular_impulse(f.box, {1e4f, 0, 1e4f});
  f.expect_stays();
  const BodyId ball =
      f.lab.add({.position = {-3, 5, 0}, .linear_velocity = {20, 0, 0}, .mass = 1e4f}, Sphere{});
  f.expect_stays();
  EXPECT_LT(f.lab.velocity(ball).x(), 1.0) << "the quarantined body acts as a wall";
  const double top = f.lab.height(f.box) + 0.5;
  const BodyId rider =
      f.lab.add({.position = {0, static_cast<float>(top) + 0.3f, 0}}, Box{{0.3f, 0.3f, 0.3f}});
  f.expect_stays();
  f.expect_stays();
  EXPECT_NEAR(f.lab.height(rider), top + 0.3, 0.01) << "the quarantined body carries the rider";
  f.lab.run(1, 0.0f);
  f.expect_stays();
}

TEST(Quarantine, OnlyCallsThatSetTheMotionEndIt) {
  using Change = std::function<void(World&, BodyId)>;
  const Change ending[] = {
      [](World& w, BodyId b) { w.set_pose(b, w.pose(b)); },
      [](World& w, BodyId b) { w.set_linear_velocity(b, {}); },
      [](World& w, BodyId b) { w.set_angular_velocity(b, {}); },
      [](World& w, BodyId b) { w.set_body_type(b, BodyType::dynamic); },
      [](World& w, BodyId b) { w.wake(b); },
  };
  const Change others[] = {
      [](World& w, BodyId b) { w.set_mass_properties(b, {}); },
      [](World& w, BodyId b) { w.reset_mass(b); },
      [](World& w, BodyId b) { w.set_linear_damping(b, 0.0f); },
      [](World& w, BodyId b) { w.set_angular_damping(b, 0.0f); },
      [](World& w, BodyId b) { w.set_gravity_factor(b, 1.0f); },
      [](World& w, BodyId b) { w.set_locks(b, AxisLocks::none); },
      [](World& w, BodyId b) { w.set_can_sleep(b, false); },
      [](World& w, BodyId b) {
        w.add_force(b, {0, 1, 0});
      },
      [](World& w, BodyId b) {
        w.add_impulse(b, {0, 1, 0});
      },
      [](World& w, BodyId b) { w.set_material(shape_of(w, b), {.density = 500.0f}); },
      [](World& w, BodyId b) { w.set_geometry(shape_of(w, b), Box{}); },
      [](World& w, BodyId b) { w.set_local_pose(shape_of(w, b), {}); },
      [](World& w, BodyId b) { w.set_filter(shape_of(w, b), {}); },
      [](World& w, BodyId b) { w.destroy_shape(w.add_shape(b, Sphere{})); },
      [](World& w, BodyId) {
        WorldSettings settings = w.settings();
        settings.gravity.y = -9.0f;
        w.set_settings(settings);
        settings.gravity.y = -9.81f;
        w.set_settings(settings);
      },
  };
  for (std::size_t i = 0; i < std::size(ending); ++i) {
    SCOPED_TRACE(i);
    QuarantinedBox f;
    World& world = f.lab.world;
    for (const Change& change : others) change(world, f.box);
    f.expect_stays();
    world.set_pose(f.twin, {{20, f.place.position.y, 0}, f.place.rotation});
    world.set_linear_velocity(f.twin, {});
    world.set_angular_velocity(f.twin, {});
    ending[i](world, f.box);
    EXPECT_FALSE(world.is_quarantined(f.box));
    EXPECT_TRUE(world.is_awake(f.box));
    f.lab.run(20);
    EXPECT_LT(f.lab.velocity(f.box).y(), -3.0);
    EXPECT_EQ(f.lab.velocity(f.box), f.lab.velocity(f.twin))
        << "the body falls like one that was never quarantined";
    EXPECT_EQ(f.lab.height(f.box), f.lab.height(f.twin));
    // The body may become non-finite again.
    f.quarantine();
    f.expect_stays();
  }
}

TEST(Quarantine, KeepsTheSettingsOfTheBody) {
  QuarantinedBox f;
  World& world = f.lab.world;
  EXPECT_EQ(world.body_type(f.box), BodyType::dynamic);
  EXPECT_EQ(world.mass_properties(f.box).mass, world.mass_properties(f.twin).mass);
  world.add_shape(f.box, Sphere{0.5f}, {}, {.local_pose = {{1, 0, 0}, {}}});
  world.add_shape(f.twin, Sphere{0.5f}, {}, {.local_pose = {{1, 0, 0}, {}}});
  world.set_locks(f.box, AxisLocks::translation_x);
  const MassProperties mass = world.mass_properties(f.box), expected = world.mass_properties(f.twin);
  EXPECT_EQ(mass.mass, expected.mass);
  EXPECT_EQ(mass.center, expected.center);
  EXPECT_TRUE(std::equal(std::begin(mass.inertia), std::end(mass.inertia), std::begin(expected.inertia)));
  f.expect_stays();
  world.set_linear_velocity(f.box, {3, 1, 2});
  EXPECT_EQ(world.linear_velocity(f.box), (Vec3{0, 1, 2}));
  f.lab.run(5);
  EXPECT_EQ(world.mass_properties(f.box).mass, expected.mass);
  f.quarantine();
  world.set_body_type(f.box, BodyType::fixed);
  EXPECT_FALSE(world.is_quarantined(f.box));
  EXPECT_EQ(world.body_type(f.box), BodyType::fixed);
  world.set_linear_velocity(f.box, {1, 0, 0});
  EXPECT_TRUE(same_bits(world.pose(f.box), f.place));
  f.lab.run(5);
  EXPECT_TRUE(same_bits(world.pose(f.box), f.place));
  world.destroy_body(f.box);
  const BodyId heir = f.lab.add({.position = {0, 5, 0}}, Box{});
  EXPECT_EQ(heir.index, f.box.index);
  EXPECT_FALSE(world.is_quarantined(heir));
  EXPECT_THROW(world.is_quarantined(f.box), Error);
}

TEST(Quarantine, KinematicBodiesAreQuarantinedToo) {
  Lab lab;
  const BodyId lift = lab.add({.type = BodyType::kinematic, .linear_velocity = {0, 1, 0}}, Box{{2, 0.5f, 2}});
  const BodyId crate = lab.add({.position = {0, 1, 0}}, Box{});
  lab.run(30);
  const Pose place = lab.world.pose(lift);
  internals(lab.world).bodies.velocity[lift.index].linear[0] = kNan;
  lab.run(1);
  EXPECT_EQ(listed(lab.world.quarantined_bodies()), std::vector<BodyId>{lift});
  EXPECT_EQ(listed(lab.world.restored_bodies()), (std::vector<BodyId>{lift, crate}));
  lab.run(60);
  EXPECT_TRUE(same_bits(lab.world.pose(lift), place));
  EXPECT_EQ(lab.world.body_type(lift), BodyType::kinematic);
  EXPECT_NEAR(lab.height(crate), static_cast<double>(place.position.y) + 1.0, 0.01);
  EXPECT_THROW(lab.world.set_kinematic_target(crate, {}, kStep), Error);
  Pose target = place;
  target.position.y += 0.1f;
  lab.world.set_kinematic_target(lift, target, 0.5f);
  EXPECT_FALSE(lab.world.is_quarantined(lift));
  lab.run(30);
  EXPECT_NEAR(lab.height(lift), static_cast<double>(target.position.y), 1e-4);
}

TEST(Quarantine, TakesAllBodiesThatBecameNonFiniteTogetherIfNoneDidAlone) {
  Lab lab;
  lab.add_ground();
  std::vector<BodyId> boxes;
  for (const float x : {0.0f, 10.0f}) {
    for (const float y : {0.5f, 1.5f, 2.5f}) boxes.push_back(lab.add({.position = {x, y, 0}}, Box{}));
  }
  lab.run(60);
  // The first stack becomes non-finite by a contact's impulse, the second by the top box's own motion.
  Contacts& contacts = internals(lab.world).contacts;
  const auto of_first = std::find_if(contacts.active.begin(), contacts.active.end(), [&](std::int32_t row) {
    return contacts.now.manifold[static_cast<std::size_t>(row)].row_b ==
           static_cast<std::int32_t>(boxes[0].index);
  });
  ASSERT_NE(of_first, contacts.active.end());
  contacts.now.manifold[static_cast<std::size_t>(*of_first)].normal_impulse[0] = kNan;
  internals(lab.world).bodies.velocity[boxes[5].index].angular[2] = kInfinity;
  lab.run(1);
  EXPECT_EQ(listed(lab.world.restored_bodies()), boxes);
  EXPECT_EQ(listed(lab.world.quarantined_bodies()),
            (std::vector<BodyId>{boxes[0], boxes[1], boxes[2], boxes[5]}));
  for (const BodyId body : boxes) lab.world.wake(body);
  lab.run(120);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_FALSE(lab.world.is_quarantined(boxes[i]));
    EXPECT_NEAR(lab.height(boxes[i]), 0.5 + static_cast<double>(i % 3), 0.02);
  }
}

TEST(Quarantine, SleepersThatRestOnTheBodyWakeWhenItEnds) {
  QuarantinedBox f{WorldSettings{}};
  const auto top = static_cast<float>(f.lab.height(f.box)) + 0.5f;
  const BodyId rider = f.lab.add({.position = {0, top + 0.3f, 0}}, Box{{0.3f, 0.3f, 0.3f}});
  f.lab.run(120);
  ASSERT_FALSE(f.lab.world.is_awake(rider));
  f.lab.world.wake(f.box);
  f.lab.run(1);
  EXPECT_TRUE(f.lab.world.is_awake(rider));
  f.lab.run(30);
  EXPECT_LT(f.lab.height(rider), static_cast<double>(top) - 0.5);
}

TEST(Quarantine, ItsContactsEndAndBeginAgain) {
  WorldSettings settings = without_sleep();
  settings.contact_events = ContactEvents::begin_end;
  Lab lab(settings);
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  int begins = 0, ends = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      lab.run(1);
      begins += static_cast<int>(lab.world.contact_begins().size());
      ends += static_cast<int>(lab.world.contact_ends().size());
    }
  };
  run(30);
  EXPECT_EQ(begins, 1);
  internals(lab.world).bodies.force[box.index].torque[0] = kNan;
  run(30);
  ASSERT_TRUE(lab.world.is_quarantined(box));
  EXPECT_EQ(begins, 1);
  EXPECT_EQ(ends, 1);
  lab.world.wake(box);
  run(30);
  EXPECT_EQ(begins, 2);
  EXPECT_EQ(ends, 1);
}

TEST(Quarantine, IsPartOfSnapshots) {
  QuarantinedBox f;
  Snapshot snapshot;
  save(f.lab.world, snapshot);
  World other;
  other.share_handles(f.lab.world);
  restore(other, read_snapshot(write_snapshot(snapshot)));
  EXPECT_TRUE(other.is_quarantined(f.box));
  for (int i = 0; i < 40; ++i) {
    if (i == 20) other.wake(f.box), f.lab.world.wake(f.box);
    step(other, kStep, f.lab.workers);
    f.lab.run(1);
    ASSERT_EQ(other.hash(), f.lab.world.hash()) << i;
  }
  EXPECT_LT(f.lab.velocity(f.box).y(), -1.0);
}

TEST(Quarantine, SnapshotsOfAnImpossibleQuarantineAreRefused) {
  const auto refusal = [](auto change) {
    QuarantinedBox f;
    change(internals(f.lab.world).bodies, f.box, f.twin);
    Snapshot snapshot;
    save(f.lab.world, snapshot);
    try {
      read_snapshot(write_snapshot(snapshot));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal([](Bodies&, BodyId, BodyId) {}), "");
  const std::string moves = refusal(
      [](Bodies& bodies, BodyId, BodyId twin) { bodies.flags[twin.index] |= kBodyQuarantinedDynamic; });
  EXPECT_NE(moves.find("quarantined bodies take part as fixed"), std::string::npos) << moves;
  const std::string both = refusal(
      [](Bodies& bodies, BodyId box, BodyId) { bodies.flags[box.index] |= kBodyQuarantinedKinematic; });
  EXPECT_NE(both.find("one type only"), std::string::npos) << both;
}

// Makes one body of a heap after the other non-finite, with a snapshot in between, and ends some of the
// quarantines.
std::string history(Isa isa, int threads, bool restores) {
  Lab lab{WorldSettings{}};
  lab.workers = Workers({.threads = threads, .isa = isa});
  const std::vector<BodyId> heap = add_heap(lab, 60, 21);
  lab.run(60);
  std::string text;
  for (std::size_t i = 0; i < 100; ++i) {
    const BodyId body = heap[i * 7 % heap.size()];
    if (i % 10 == 0) overload(lab.world, body);
    if (i % 25 == 9) internals(lab.world).bodies.velocity[body.index].angular[1] = kNan;
    if (i % 10 == 5) lab.world.wake(heap[(i - 5) * 7 % heap.size()]);
    if (restores && i % 5 == 1) {
      Snapshot snapshot;
      save(lab.world, snapshot);
      lab.run(2);
      restore(lab.world, read_snapshot(write_snapshot(snapshot)));
    }
    lab.run(1);
    EXPECT_TRUE(lab.all_finite()) << i;
    text += std::to_string(lab.world.hash()) + ":";
    for (const BodyId quarantined : lab.world.quarantined_bodies())
      text += std::to_string(quarantined.index) + " ";
    text += "of " + std::to_string(lab.world.restored_bodies().size()) + "\n";
  }
  return text;
}

TEST(Quarantine, HasTheSameBitsOnEveryInstructionSetAndThreadCount) {
  const std::string expected = history(Isa::scalar, 1, false);
  const auto restored_several = [&] {
    for (std::size_t at = expected.find("of "); at != std::string::npos; at = expected.find("of ", at + 1)) {
      if (std::stoi(expected.substr(at + 3)) > 1) return true;
    }
    return false;
  };
  EXPECT_TRUE(restored_several()) << "some bodies make others non-finite:\n" << expected;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 2, 4}) {
      EXPECT_EQ(history(isa, threads, threads != 2), expected) << isa_name(isa) << " " << threads;
    }
  }
}

}  // namespace
}  // namespace scree::physics
