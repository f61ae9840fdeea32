// Extreme and invalid input. A call either throws an Error and changes nothing, or the simulation stays
// finite. The world can be stepped afterwards.
#include <core/world/world_data.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <utility>

namespace scree::physics {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Drops a box beside the scene and expects that it comes to rest on the ground.
void expect_usable(Lab& lab, float x = 50.0f, float z = 0.0f) {
  EXPECT_TRUE(lab.all_finite());
  const BodyId box = lab.add({.position = {x, 1.5f, z}}, Box{});
  lab.run(180);
  EXPECT_TRUE(lab.all_finite());
  EXPECT_NEAR(lab.height(box), 0.5, 0.05);
  EXPECT_LT(lab.velocity(box).norm(), 0.01);
  lab.world.destroy_body(box);
  lab.run(1);
}

TEST(BadInput, AnImpossibleTimeStepIsAnErrorThatChangesNothing) {
  Lab lab;
  lab.add_ground();
  lab.add({.position = {0, 3, 0}}, Box{});
  lab.run(10);
  const std::uint64_t hash = lab.world.hash();
  for (const float dt : {kNan, -kNan, -1.0f / 60.0f, -1e-30f, 1.5f, 1e30f, kInfinity, -kInfinity}) {
    EXPECT_THROW(step(lab.world, dt, lab.workers), Error) << dt;
    EXPECT_EQ(lab.world.hash(), hash);
  }
  expect_usable(lab);
}

TEST(BadInput, SteppingAWorldThatWasMovedFromIsAnErrorThatSaysSo) {
  Lab lab;
  const BodyId ball = lab.add({}, Sphere{});
  World other = std::move(lab.world);
  try {
    lab.run(1);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "step: the world has been moved from");
  }
  step(other, kStep, lab.workers);
  EXPECT_LT(other.linear_velocity(ball).y, 0.0f);
}

// The error of stepping a list of worlds. Expects that it steps none of them.
std::string refusal(std::span<World* const> worlds, float dt) {
  Workers workers(1);
  try {
    step(worlds, dt, workers);
  } catch (const Error& error) {
    for (World* world : worlds) EXPECT_TRUE(world == nullptr || world->stats().step == 0);
    return error.what();
  }
  return "stepped";
}

TEST(BadInput, AListOfWorldsIsSteppedWholeOrNotAtAll) {
  World first, second;
  World* const twice[] = {&first, &second, &first};
  EXPECT_EQ(refusal(twice, kStep), "step: world 2 of the list stands in it before, at 0");
  World* const with_null[] = {&first, nullptr, &second};
  EXPECT_EQ(refusal(with_null, kStep), "step: world 1 of the list is a null pointer");
  World* const sound[] = {&first, &second};
  EXPECT_EQ(refusal(sound, -1.0f), "step: the time step is -1.000000 s; it must be in [0, 1]");
  EXPECT_EQ(refusal({}, kStep), "stepped");
  EXPECT_EQ(refusal(sound, kStep), "stepped");
  EXPECT_EQ(first.stats().step + second.stats().step, 2u);
  World moved = std::move(first);
  Workers workers(1);
  EXPECT_THROW(step(sound, kStep, workers), Error);
  EXPECT_EQ(second.stats().step, 1u);
}

TEST(BadInput, ATimeStepOfZeroMovesNothing) {
  Lab lab;
  lab.add_ground();
  lab.add({.position = {0, 0.49f, 0}, .linear_velocity = {1, -2, 0}}, Box{});
  const std::uint64_t hash = lab.world.hash();
  lab.run(3, 0.0f);
  EXPECT_EQ(lab.world.hash(), hash);
  EXPECT_EQ(lab.world.stats().contacts, 1);
  expect_usable(lab);
}

TEST(BadInput, ExtremeTimeStepsStayFinite) {
  for (const float dt : {1e-45f, 1e-38f, 1e-30f, 1e-20f, 1e-10f, 1e-5f, 0.5f, 1.0f}) {
    Lab lab;
    const std::vector<BodyId> heap = add_heap(lab, 20, 3);
    lab.run(60);
    lab.run(10, dt);
    EXPECT_TRUE(lab.all_finite()) << dt;
    std::vector<Eigen::Vector3d> before;
    for (const BodyId body : heap) before.push_back(lab.position(body));
    lab.run(10);
    // In one step of half a second bodies fall through one another. Shorter steps make no body fast ...
    for (std::size_t i = 0; i < heap.size() && dt < 0.5f; ++i) {
      EXPECT_LT((lab.position(heap[i]) - before[i]).norm(), 0.5) << dt;
      EXPECT_LT(lab.velocity(heap[i]).norm(), 2.0) << dt;
    }
    // ... and leave no body in quarantine.
    const float x = static_cast<float>(lab.position(heap[0]).x());
    lab.world.set_pose(heap[0], {{x, 20.0f, 0.0f}, {}});
    lab.world.set_linear_velocity(heap[0], {});
    lab.run(10);
    EXPECT_LT(lab.height(heap[0]), 19.95) << dt;
    expect_usable(lab);
  }
}

TEST(BadInput, MotionAtAMillionMetersPerSecondStaysFinite) {
  for (const float limit : {400.0f, 1e6f}) {
    WorldSettings settings = without_sleep();
    settings.max_linear_speed = limit;
    settings.max_angular_speed = limit;
    Lab lab(settings);
    add_heap(lab, 30, 9);
    lab.run(60);
    lab.add({.position = {0, 5, 0}, .linear_velocity = {0, -1e6f, 0}}, Box{});
    lab.add({.position = {-8, 0.5f, 0.2f}, .linear_velocity = {1e6f, 0, 1e5f}}, Sphere{0.4f});
    lab.add({.position = {0, 8, 0}, .linear_velocity = {0, 1e6f, 0}, .angular_velocity = {1e6f, -1e6f, 1e6f}},
            Capsule{});
    lab.run(120);
    expect_usable(lab);
  }
}

TEST(BadInput, CoordinatesOfAMillionMetersStayFinite) {
  Lab lab;
  lab.add_ground();
  for (const float x : {1e6f, -1e6f}) {
    lab.add({.type = BodyType::fixed, .position = {x, -1, 1e6f}}, Box{{50, 1, 50}});
    std::vector<BodyId> boxes;
    for (int i = 0; i < 4; ++i) {
      boxes.push_back(lab.add({.position = {x, 0.5f + static_cast<float>(i), 1e6f}}, Box{}));
    }
    lab.add({.position = {x + 3, 1, 1e6f}}, Sphere{});
    lab.add({.position = {x - 3, 1, 1e6f}, .angular_velocity = {1, 2, 3}}, Capsule{});
    lab.run(240);
    // Floats are 6 cm apart there.
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_NEAR(lab.height(boxes[i]), 0.5 + static_cast<double>(i), 0.1);
    }
  }
  expect_usable(lab);
}

TEST(BadInput, BodiesAtTheSamePlaceComeApart) {
  const Geometry geometries[] = {Sphere{0.5f}, Capsule{0.3f, 0.3f}, Box{{0.5f, 0.5f, 0.5f}}};
  for (const Geometry& first : geometries) {
    for (const Geometry& second : geometries) {
      Lab lab;
      lab.add_ground();
      const BodyId a = lab.add({.position = {0, 2, 0}}, first), b = lab.add({.position = {0, 2, 0}}, second);
      lab.run(300);
      EXPECT_TRUE(lab.all_finite());
      EXPECT_GT((lab.position(a) - lab.position(b)).norm(), 0.3) << first.index() << " " << second.index();
      EXPECT_LT((lab.position(a) - lab.position(b)).norm(), 20.0) << first.index() << " " << second.index();
      expect_usable(lab);
    }
  }
}

TEST(BadInput, ManyBodiesAtTheSamePlaceStayFinite) {
  Lab lab;
  lab.add_ground();
  for (int i = 0; i < 100; ++i) {
    const Geometry geometry = i % 2 == 0 ? Geometry{Sphere{0.5f}} : Geometry{Box{}};
    lab.add({.position = {0, 2, 0}}, geometry);
  }
  lab.run(240);
  expect_usable(lab, 80.0f, 80.0f);
}

TEST(BadInput, ABodyWithoutShapesFallsFreely) {
  Lab lab;
  lab.add_ground();
  const BodyId ghost = lab.world.create_body({.position = {0, 1, 0}});
  lab.world.create_body({.type = BodyType::fixed});
  lab.world.create_body({.type = BodyType::kinematic, .linear_velocity = {1, 0, 0}});
  lab.run(60);
  EXPECT_NEAR(lab.height(ghost), 1.0 - 0.5 * kGravity, 0.1);
  expect_usable(lab);
}

TEST(BadInput, ExtremeMassesAndSizesStayFinite) {
  Lab lab;
  lab.add_ground();
  lab.add({.position = {0, 1, 0}}, Sphere{1e-4f});
  lab.add({.position = {3, 1, 0}, .mass = 1e-10f}, Box{});
  lab.add({.position = {6, 1, 0}, .mass = 1e20f}, Box{});
  lab.add({.position = {9, 1, 0}}, Box{{1e-3f, 0.5f, 20.0f}});
  lab.add({.position = {12, 1, 0}, .gravity_factor = 1e5f}, Sphere{});
  lab.add({.position = {15, 1, 0}, .linear_damping = 1e5f, .angular_damping = 1e5f}, Capsule{});
  lab.add({.position = {18, 1, 0}, .angular_velocity = {1e8f, 0, 1e8f}}, Box{{0.1f, 0.5f, 0.3f}});
  lab.run(120);
  expect_usable(lab);
}

TEST(BadInput, HugeForcesStayFinite) {
  Lab lab;
  const std::vector<BodyId> heap = add_heap(lab, 20, 4);
  lab.run(30);
  for (const BodyId body : heap) {
    lab.world.add_force(body, {1e15f, -1e15f, 1e14f});
    lab.world.add_torque(body, {1e12f, 1e12f, -1e12f});
    lab.run(1);
  }
  lab.run(60);
  expect_usable(lab);
}

using ImpulsePart = float* (*)(Manifold&, ContactSurface&);

bool impulses_are_finite(const World& world) {
  const Contacts& contacts = internals(world).contacts;
  const auto all = [](std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
  };
  return std::all_of(contacts.active.begin(), contacts.active.end(), [&](std::int32_t touching) {
    const auto row = static_cast<std::size_t>(touching);
    const Manifold& m = contacts.now.manifold[row];
    const bool rich = (m.info & kManifoldRich) != 0;
    return all(m.normal_impulse) && all(m.friction_impulse) && std::isfinite(m.twist_impulse) &&
           (!rich || all(contacts.now.surface[row].rolling_impulse));
  });
}

// A body at rest on a heavier box that stands on the ground.
struct Stack {
  Stack(const Geometry& upper, const Material& material, Isa isa) {
    lab.workers = Workers({.threads = 1, .isa = isa});
    lab.add_ground(material);
    const Quat lying = rotation_about({0, 0, 1}, 0.5 * std::numbers::pi);  // so that a capsule has two points
    bodies = {lab.add({.position = {0, 0.5f, 0}}, Box{}, material),
              lab.add({.position = {0, 1.3f, 0}, .rotation = lying}, upper, material)};
    lab.run(60);
  }

  Lab lab;
  std::vector<BodyId> bodies;
};

// Makes an impulse of one contact non-finite. Expects that the step discards it and that the stack stands as
// before.
std::uint64_t make_impulse_non_finite(Stack stack, std::size_t contact, ImpulsePart part, float value) {
  Lab& lab = stack.lab;
  Contacts& contacts = internals(lab.world).contacts;
  EXPECT_EQ(contacts.active.size(), 2u);
  const auto row = static_cast<std::size_t>(contacts.active[contact]);
  std::vector<Eigen::Vector3d> places;
  for (const BodyId body : stack.bodies) places.push_back(lab.position(body));
  *part(contacts.now.manifold[row], contacts.now.surface[row]) = value;
  for (int i = 0; i < 30; ++i) {
    lab.run(1);
    EXPECT_TRUE(lab.all_finite()) << i;
    EXPECT_TRUE(impulses_are_finite(lab.world)) << i;
    // No single body was at fault: those that became non-finite stay quarantined until they are woken.
    EXPECT_EQ(lab.world.quarantined_bodies().empty(), i > 0) << i;
    for (const BodyId body : stack.bodies) lab.world.wake(body);
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_LT((lab.position(stack.bodies[i]) - places[i]).norm(), 0.01) << i;
    EXPECT_LT(lab.velocity(stack.bodies[i]).norm(), 0.01) << i;
  }
  // A body that every step restores would not move either.
  lab.world.set_linear_velocity(stack.bodies[1], {0, 2, 0});
  lab.run(1);
  EXPECT_GT(lab.velocity(stack.bodies[1]).y(), 1.0);
  return lab.world.hash();
}

TEST(BadInput, AnImpulseThatIsNotFiniteIsForgottenWithTheStep) {
  const ImpulsePart parts[] = {
      [](Manifold& m, ContactSurface&) { return &m.normal_impulse[0]; },
      [](Manifold& m, ContactSurface&) { return &m.friction_impulse[1]; },
      [](Manifold& m, ContactSurface&) { return &m.twist_impulse; },
      [](Manifold&, ContactSurface& s) { return &s.rolling_impulse[2]; },  // of rich contacts only
  };
  // One, two and four points.
  const Geometry uppers[] = {Sphere{0.3f}, Capsule{0.3f, 0.3f}, Box{{0.3f, 0.3f, 0.3f}}};
  for (int trial = 0; trial < 3 * 2 * 2 * 4 * 3; ++trial) {
    const auto upper = static_cast<std::size_t>(trial % 3), contact = static_cast<std::size_t>(trial / 3 % 2);
    const auto part = static_cast<std::size_t>(trial / 12 % 4);
    const float rolling_resistance = trial / 6 % 2 == 0 ? 0.0f : 0.01f;
    const float value = std::array{kNan, kInfinity, -kInfinity}[static_cast<std::size_t>(trial / 48)];
    if (rolling_resistance == 0.0f && part == 3) continue;
    std::set<std::uint64_t> hashes;
    for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
      if (!is_supported(isa)) continue;
      SCOPED_TRACE("upper " + std::to_string(upper) + " contact " + std::to_string(contact) + " part " +
                   std::to_string(part) + " value " + std::to_string(value) + " rolling resistance " +
                   std::to_string(rolling_resistance) + " " + isa_name(isa));
      Stack stack(uppers[upper], {.rolling_resistance = rolling_resistance}, isa);
      hashes.insert(make_impulse_non_finite(std::move(stack), contact, parts[part], value));
    }
    EXPECT_EQ(hashes.size(), 1u);
  }
}

TEST(BadInput, ANonFiniteBodyIsQuarantinedAndItsNeighborsRecover) {
  Stack stack(Box{{0.3f, 0.3f, 0.3f}}, {}, Isa::automatic);
  Lab& lab = stack.lab;
  // No call accepts this value.
  internals(lab.world).bodies.force[stack.bodies[1].index].force[1] = -kInfinity;
  for (int i = 0; i < 30; ++i) {
    lab.run(1);
    EXPECT_TRUE(lab.all_finite()) << i;
    EXPECT_TRUE(impulses_are_finite(lab.world)) << i;
    EXPECT_TRUE(lab.world.is_quarantined(stack.bodies[1]));
    EXPECT_FALSE(lab.world.is_quarantined(stack.bodies[0]));
  }
  EXPECT_NEAR(lab.height(stack.bodies[0]), 0.5, 0.01);
  EXPECT_NEAR(lab.height(stack.bodies[1]), 1.3, 0.01);
  lab.world.set_linear_velocity(stack.bodies[0], {2, 0, 0});
  lab.run(1);
  EXPECT_GT(lab.velocity(stack.bodies[0]).x(), 1.0);
}

}  // namespace
}  // namespace scree::physics
