// Forces of contacts: World::contact_forces reports all that contacts did to the bodies.
#include <core/world/math.h>
#include <tests/physics/lab.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace scree::physics {
namespace {

WorldSettings measured(WorldSettings settings = without_sleep()) {
  settings.contact_forces = true;
  return settings;
}

std::vector<ContactForces> all_contacts(const World& world) {
  std::vector<ContactForces> found(world.contact_forces({}));
  EXPECT_EQ(world.contact_forces(found), found.size());
  return found;
}
template <class Id>
std::vector<ContactForces> contacts_of(const World& world, Id id) {
  std::vector<ContactForces> found(world.contact_forces_of(id, {}));
  EXPECT_EQ(world.contact_forces_of(id, found), found.size());
  return found;
}

struct Wrench {
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  double size = 0.0;  // N s, the sum of impulses of the contacts
};

// About a point; in double precision.
Wrench wrench_on(const World& world, BodyId body, const Eigen::Vector3d& about) {
  Wrench sum;
  for (const ContactForces& contact : contacts_of(world, body)) {
    const double side = contact.body_b == body ? 1.0 : -1.0;
    EXPECT_TRUE(contact.body_b == body || contact.body_a == body);
    const Eigen::Vector3d normal = side * to_eigen(contact.normal);
    const Eigen::Vector3d friction = side * to_eigen(contact.friction_impulse);
    sum.impulse += friction;
    sum.moment += (to_eigen(contact.friction_center) - about).cross(friction) +
                  static_cast<double>(contact.twist_impulse) * normal +
                  side * to_eigen(contact.rolling_impulse);
    sum.size += friction.norm();
    for (const ContactForcePoint& point : contact.points) {
      const double pressed = static_cast<double>(point.normal_impulse);
      sum.impulse += pressed * normal;
      sum.moment += pressed * (to_eigen(point.position) - about).cross(normal);
      sum.size += pressed;
    }
  }
  return sum;
}

struct Motion {
  Eigen::Vector3d center, momentum, angular_momentum;
  double spin;  // rad/s
};
Motion motion_of(const Lab& lab, BodyId body) {
  return {lab.position(body), lab.mass(body) * lab.velocity(body), lab.angular_momentum(body),
          lab.spin(body).norm()};
}

// Steps once, and compares the change of each body's momentum with its contacts. Within a step the inertia of
// a touching body does not turn with it: its angular momentum may be wrong by the angle of that turn. Beside
// that `spin_tolerance` is a share of the contacts' impulses, times a meter.
void step_and_balance(Lab& lab, const std::vector<BodyId>& bodies, double spin_tolerance, float dt = kStep) {
  std::vector<Motion> before;
  for (const BodyId body : bodies) before.push_back(motion_of(lab, body));
  lab.run(1, dt);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Motion after = motion_of(lab, bodies[i]);
    const Wrench wrench = wrench_on(lab.world, bodies[i], before[i].center);
    const Eigen::Vector3d weight = lab.mass(bodies[i]) * to_eigen(lab.world.settings().gravity);
    const Eigen::Vector3d pushed = after.momentum - before[i].momentum - static_cast<double>(dt) * weight;
    const double scale = wrench.size + after.momentum.norm() + weight.norm() * static_cast<double>(dt);
    ASSERT_LT((pushed - wrench.impulse).norm(), 5e-6 * scale)
        << "body " << i << ": " << pushed.transpose() << " and " << wrench.impulse.transpose();
    const Eigen::Vector3d turned = after.angular_momentum - before[i].angular_momentum;
    const double angle = static_cast<double>(dt) * std::max(before[i].spin, after.spin);
    const double momentum = std::max(before[i].angular_momentum.norm(), after.angular_momentum.norm());
    ASSERT_LT((turned - wrench.moment).norm(), spin_tolerance * scale + angle * momentum)
        << "body " << i << ": " << turned.transpose() << " and " << wrench.moment.transpose();
  }
}

TEST(ContactForces, OfABoxAtRestAreItsWeight) {
  for (const int substeps : {1, 4, 7}) {
    WorldSettings settings = measured();
    settings.substeps = substeps;
    Lab lab(settings);
    lab.add_ground();
    const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{}, {.density = 700});
    lab.run(120);
    const std::vector<ContactForces> contacts = all_contacts(lab.world);
    ASSERT_EQ(contacts.size(), 1u);
    const double impulse = lab.mass(box) * kGravity * static_cast<double>(kStep);
    EXPECT_NEAR(static_cast<double>(normal_impulse(contacts[0])), impulse, 1e-4 * impulse);
    EXPECT_EQ(contacts[0].body_b, box);
    EXPECT_EQ(contacts[0].normal, (Vec3{0, 1, 0}));
    EXPECT_EQ(contacts[0].point_count, 4);
    for (const ContactForcePoint& point : contacts[0].points) {
      EXPECT_NEAR(std::abs(point.position.x), 0.5f, 1e-4f);
      EXPECT_NEAR(point.position.y, 0.0f, 0.005f);
      EXPECT_NEAR(static_cast<double>(point.normal_impulse), 0.25 * impulse, 0.01 * impulse);
    }
    EXPECT_LT(length(contacts[0].friction_impulse), 1e-4f * static_cast<float>(impulse));
  }
}

TEST(ContactForces, OfASlidingBoxObeyCoulombsLaw) {
  Lab lab(measured());
  lab.add_ground({.friction = 0.4f});
  const BodyId box = lab.add({.position = {0, 0.25f, 0}, .linear_velocity = {6, 0, -2}},
                             Box{{0.5f, 0.25f, 0.5f}}, {.friction = 0.4f});
  lab.run(20);
  for (int i = 0; i < 20; ++i) {
    const Vec3 way = normalize(lab.world.linear_velocity(box));
    step_and_balance(lab, {box}, 1e-4);
    const std::vector<ContactForces> contacts = contacts_of(lab.world, box);
    ASSERT_EQ(contacts.size(), 1u);
    const float limit = 0.4f * normal_impulse(contacts[0]);
    EXPECT_LT(length(contacts[0].friction_impulse + limit * way), 1e-3f * limit);
  }
}

// Friction holds a box on a slope with the downhill part of its weight, at the center of its load.
TEST(ContactForces, HoldABoxOnASlope) {
  Lab lab(measured());
  const double angle = 0.3;
  const Quat tilt = rotation_about({0, 0, 1}, angle);
  lab.add_ground({}, tilt);
  const Eigen::Vector3d up = to_eigen(tilt) * Eigen::Vector3d(0, 0.5, 0);
  const BodyId box = lab.add(
      {.position = {static_cast<float>(up.x()), static_cast<float>(up.y()), 0}, .rotation = tilt}, Box{});
  lab.run(300);
  const Wrench wrench = wrench_on(lab.world, box, lab.position(box));
  const double weight = lab.mass(box) * kGravity * static_cast<double>(kStep);
  EXPECT_LT((wrench.impulse - Eigen::Vector3d(0, weight, 0)).norm(), 1e-3 * weight);
  EXPECT_LT(wrench.moment.norm(), 1e-3 * weight);
  const ContactForces contact = contacts_of(lab.world, box).at(0);
  EXPECT_NEAR(static_cast<double>(length(contact.friction_impulse)), weight * std::sin(angle), 1e-3 * weight);
}

const std::pair<const char*, Geometry>& shape(int which) {
  static const std::vector<Vec3> points = [] {
    std::vector<Vec3> corners;
    for (int i = 0; i < 12; ++i) {
      const float turn = 2.4f * static_cast<float>(i);
      corners.push_back(
          {0.5f * std::cos(turn), 0.06f * static_cast<float>(i) - 0.33f, 0.4f * std::sin(turn)});
    }
    return corners;
  }();
  static const std::pair<const char*, Geometry> shapes[] = {{"box", Box{{0.5f, 0.3f, 0.4f}}},
                                                            {"sphere", Sphere{0.4f}},
                                                            {"capsule", Capsule{0.4f, 0.2f}},
                                                            {"hull", ConvexHull{Hull(points)}}};
  return shapes[which];
}

// The change of momentum equals the impulses of contacts and gravity, for bodies that fall, bounce, roll,
// slide and spin.
TEST(ContactForces, AreTheChangeOfMomentumOfBodiesThatFallRollAndSpin) {
  for (int which = 0; which < 4; ++which) {
    for (const bool rich : {false, true}) {
      SCOPED_TRACE(std::string(shape(which).first) + (rich ? ", rich" : ""));
      Lab lab(measured());
      Material material{.friction = 0.5f};
      if (rich) material = {.friction = 0.5f, .restitution = 0.6f, .rolling_resistance = 0.02f};
      lab.add_ground(material);
      const BodyId body = lab.add({.position = {0, 1.2f, 0},
                                   .rotation = rotation_about({1, 2, 3}, 0.7),
                                   .linear_velocity = {3, -2, 1},
                                   .angular_velocity = {1, 4, -2}},
                                  shape(which).second, material);
      double bore = 0.0;
      for (int i = 0; i < 120; ++i) {
        // A sphere's inertia does not change as it turns.
        step_and_balance(lab, {body}, which == 1 ? 2e-5 : 0.005);
        if (HasFatalFailure()) FAIL() << "step " << i;
        bore += wrench_on(lab.world, body, lab.position(body)).size;
      }
      EXPECT_GT(bore, 0.5 * lab.mass(body) * kGravity);
    }
  }
}

TEST(ContactForces, AreTheChangeOfMomentumInAPile) {
  for (const bool warm_start : {true, false}) {
    WorldSettings settings = measured();
    settings.warm_start = warm_start;
    Lab lab(settings);
    const BodyId ground = lab.add_ground({.friction = 0.6f});
    std::vector<BodyId> bodies;
    for (int i = 0; i < 60; ++i) {
      const float layer = static_cast<float>(i / 9);
      bodies.push_back(
          lab.add({.position = {static_cast<float>(i % 3) * 0.7f - 0.7f + 0.05f * layer, 0.6f + 0.9f * layer,
                                static_cast<float>(i / 3 % 3) * 0.7f - 0.7f}},
                  shape(i % 4).second, {.friction = 0.6f, .restitution = i % 5 == 0 ? 0.5f : 0.0f}));
    }
    for (int i = 0; i < 120; ++i) {
      step_and_balance(lab, bodies, 0.01, i % 10 == 0 ? 0.5f * kStep : kStep);
      if (HasFatalFailure()) FAIL() << "step " << i;
    }
    // Forces between the bodies cancel: the ground carries their weight.
    const Wrench on_ground = wrench_on(lab.world, ground, Eigen::Vector3d::Zero());
    Wrench on_bodies;
    for (const BodyId body : bodies) on_bodies.impulse += wrench_on(lab.world, body, {0, 0, 0}).impulse;
    EXPECT_LT((on_ground.impulse + on_bodies.impulse).norm(), 1e-5 * on_ground.size);
    EXPECT_GE(all_contacts(lab.world).size(), 60u);
  }
}

// A slab with more neighbors than there are colors is a hub.
TEST(ContactForces, AreTheChangeOfMomentumOfAHub) {
  Lab lab(measured());
  lab.add_ground();
  const BodyId slab = lab.add({.position = {0, 0.25f, 0}}, Box{{6, 0.25f, 6}});
  std::vector<BodyId> bodies{slab};
  for (int i = 0; i < 100; ++i) {
    bodies.push_back(
        lab.add({.position = {static_cast<float>(i % 10) - 4.5f, 0.9f + 0.02f * static_cast<float>(i % 7),
                              static_cast<float>(i / 10) - 4.5f}},
                Box{{0.3f, 0.3f, 0.3f}}));
  }
  for (int i = 0; i < 60; ++i) {
    step_and_balance(lab, bodies, 0.002);
    if (HasFatalFailure()) FAIL() << "step " << i;
  }
}

TEST(ContactForces, StayWithinCoulombsCone) {
  SceneLab pile("pile", {{"bodies", 300}, {"seed", 3}});
  WorldSettings settings = measured(pile.lab.world.settings());
  pile.lab.world.set_settings(settings);
  pile.lab.run(150);
  int sliding = 0;
  for (const ContactForces& contact : all_contacts(pile.lab.world)) {
    const float coefficient = std::sqrt(pile.lab.world.material(contact.shape_a).friction *
                                        pile.lab.world.material(contact.shape_b).friction);
    const float limit = coefficient * normal_impulse(contact);
    const float friction = length(contact.friction_impulse);
    ASSERT_LE(friction, limit * 1.0001f + 1e-6f);
    ASSERT_LT(std::abs(dot(contact.friction_impulse, contact.normal)), 1e-5f * limit + 1e-6f);
    for (const ContactForcePoint& point : contact.points) ASSERT_GE(point.normal_impulse, 0.0f);
    if (friction > 0.99f * limit && limit > 0.0f) ++sliding;
  }
  EXPECT_GT(sliding, 0);
}

TEST(ContactForces, AreListedByPairsAndAgreeBetweenBodyShapeAndWorldQueries) {
  SceneLab pile("pile", {{"bodies", 100}, {"seed", 5}});
  pile.lab.world.set_settings(measured(pile.lab.world.settings()));
  pile.lab.run(120);
  const World& world = pile.lab.world;
  const std::vector<ContactForces> all = all_contacts(world);
  ASSERT_GT(all.size(), 100u);
  const auto same = [](const ContactForces& x, const ContactForces& y) {
    return x.shape_a == y.shape_a && x.shape_b == y.shape_b && impulse_on_b(x) == impulse_on_b(y) &&
           moment_on_b(x, {}) == moment_on_b(y, {});
  };
  const auto key = [](const ContactForces& c) { return std::pair(c.shape_a.index, c.shape_b.index); };
  for (std::size_t i = 1; i < all.size(); ++i) ASSERT_LT(key(all[i - 1]), key(all[i]));
  for (std::uint32_t index = 0; index < world.poses().size(); ++index) {
    const BodyId body = world.body_at(index);
    if (body == BodyId{}) continue;
    std::vector<ContactForces> expected;
    std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                 [&](const ContactForces& c) { return c.body_a == body || c.body_b == body; });
    const std::vector<ContactForces> found = contacts_of(world, body);
    ASSERT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end(), same));
    std::vector<ShapeId> shapes(world.shapes_of(body, {}));
    world.shapes_of(body, shapes);
    std::size_t by_shapes = 0;
    for (const ShapeId shape : shapes) by_shapes += contacts_of(world, shape).size();
    ASSERT_EQ(by_shapes, found.size());
  }
  ContactForces first[1];
  EXPECT_EQ(world.contact_forces(first), all.size());
  EXPECT_TRUE(same(first[0], all[0]));
}

TEST(ContactForces, HaveTheSameBitsOnEveryInstructionSetAndThreadCount) {
  std::vector<ContactForces> expected;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      SceneLab pile("pile", {{"bodies", 150}, {"seed", 4}});
      pile.lab.world.set_settings(measured(pile.lab.world.settings()));
      pile.lab.workers = Workers(WorkersOptions{.threads = threads, .isa = isa});
      pile.lab.run(120);
      const std::vector<ContactForces> found = all_contacts(pile.lab.world);
      if (expected.empty()) expected = found;
      ASSERT_GT(found.size(), 150u);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        const ContactForces &x = found[i], &y = expected[i];
        ASSERT_TRUE(x.shape_a.index == y.shape_a.index && x.shape_b.index == y.shape_b.index);
        ASSERT_EQ(x.point_count, y.point_count);
        ASSERT_EQ(x.color, y.color);
        ASSERT_EQ(x.friction_center, y.friction_center);
        ASSERT_EQ(x.friction_impulse, y.friction_impulse) << isa_name(isa) << " " << threads;
        ASSERT_EQ(x.rolling_impulse, y.rolling_impulse);
        ASSERT_EQ(x.twist_impulse, y.twist_impulse);
        for (int k = 0; k < 4; ++k) {
          ASSERT_EQ(x.points[k].position, y.points[k].position);
          ASSERT_EQ(x.points[k].normal_impulse, y.points[k].normal_impulse);
        }
      }
    }
  }
}

TEST(ContactForces, OfOneColorShareNoBodyThatCanBePushed) {
  SceneLab pile("pile", {{"bodies", 200}, {"seed", 6}});
  pile.lab.world.set_settings(measured(pile.lab.world.settings()));
  pile.lab.run(120);
  const World& world = pile.lab.world;
  std::set<std::tuple<bool, std::int32_t, std::uint32_t>> taken;
  for (const ContactForces& contact : all_contacts(world)) {
    ASSERT_GE(contact.color, 0);
    ASSERT_LT(contact.color, 64);
    const auto is_pushed = [&](BodyId body) { return world.body_type(body) == BodyType::dynamic; };
    const bool both = is_pushed(contact.body_a) && is_pushed(contact.body_b);
    for (const BodyId body : {contact.body_a, contact.body_b}) {
      if (!is_pushed(body)) continue;
      ASSERT_TRUE(taken.insert({both, contact.color, body.index}).second)
          << "color " << contact.color << ", body " << body.index;
    }
  }
  EXPECT_GT(taken.size(), 300u);
}

TEST(ContactForces, OfAReboundDoNotDependOnNeighboringContacts) {
  // The square of the slow ball's speed underflows to zero.
  WorldSettings settings = measured();
  settings.gravity = {};
  std::vector<float> friction;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    Lab lab(settings);
    const Material bouncy{.restitution = 0.5f};
    lab.add_ground(bouncy);
    const BodyId slow =
        lab.add({.position = {0, 0.5f, 0}, .linear_velocity = {1e-27f, 0, 0}}, Sphere{}, bouncy);
    const BodyId fast = lab.add({.position = {3, 0.5f, 0}, .linear_velocity = {0, -3, 0}}, Sphere{}, bouncy);
    Workers workers(WorkersOptions{.threads = 1, .isa = isa});
    step(lab.world, kStep, workers);
    EXPECT_GT(lab.world.linear_velocity(fast).y, 1.0f);
    friction.push_back(contacts_of(lab.world, slow).at(0).friction_impulse.x);
    EXPECT_EQ(friction.back(), friction.front()) << static_cast<int>(isa);
  }
}

TEST(ContactForces, AgreeWithEventsOnTheImpulseOfAnImpact) {
  WorldSettings settings = measured();
  settings.contact_events = ContactEvents::all;
  Lab lab(settings);
  lab.add_ground({.restitution = 0.7f});
  const BodyId ball = lab.add({.position = {0, 2, 0}}, Sphere{0.5f}, {.restitution = 0.7f});
  for (int i = 0; i < 120; ++i) {
    lab.run(1);
    for (const auto events : {lab.world.contact_begins(), lab.world.contact_persists()}) {
      for (const ContactEvent& event : events) {
        const std::vector<ContactForces> contacts = contacts_of(lab.world, ball);
        ASSERT_EQ(contacts.size(), event.normal_impulse > 0.0f ? 1u : contacts.size());
        if (contacts.empty()) continue;
        EXPECT_NEAR(normal_impulse(contacts[0]), event.normal_impulse, 1e-4f * event.normal_impulse);
      }
    }
  }
}

TEST(ContactForces, OfSleepersAreThoseOfTheirLastAwakeStepAlsoInARestoredWorld) {
  Lab lab(measured(WorldSettings{}));
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.add({.position = {5, 0.5f, 0}, .can_sleep = false}, Box{});  // one body stays awake
  lab.run(200);
  ASSERT_FALSE(lab.world.is_awake(box));
  const float weight = static_cast<float>(lab.mass(box) * kGravity) * kStep;
  const auto load = [&](const World& world) {
    const std::vector<ContactForces> contacts = contacts_of(world, box);
    return contacts.size() == 1 ? normal_impulse(contacts[0]) : -1.0f;
  };
  const float bore = load(lab.world);
  EXPECT_NEAR(bore, weight, 1e-3f * weight);
  World copy = clone(lab.world);
  EXPECT_EQ(load(copy), bore);
  step(copy, kStep, lab.workers);
  EXPECT_EQ(load(copy), bore);
  EXPECT_EQ(all_contacts(copy).size(), 2u);
}

TEST(ContactForces, AreZeroInAStepOfNoLengthAndBeforeTheFirst) {
  Lab lab;
  lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  lab.run(60);
  lab.world.set_settings(measured());
  const auto load = [&] { return normal_impulse(contacts_of(lab.world, box).at(0)); };
  EXPECT_EQ(load(), 0.0f);
  EXPECT_NEAR(contacts_of(lab.world, box).at(0).points[0].position.y, 0.0f, 0.005f);
  lab.run(1);
  const float weight = load();
  EXPECT_GT(weight, 0.0f);
  lab.run(1, 0.0f);
  EXPECT_EQ(load(), 0.0f);
  lab.run(1);
  EXPECT_NEAR(load(), weight, 1e-3f * weight);
}

TEST(ContactForces, OfDestroyedOrReplacedShapesAreNotReported) {
  Lab lab(measured());
  const BodyId ground = lab.add_ground();
  const BodyId box = lab.add({.position = {0, 0.5f, 0}}, Box{});
  const BodyId other = lab.add({.position = {3, 0.5f, 0}}, Box{});
  lab.run(10);
  EXPECT_EQ(contacts_of(lab.world, ground).size(), 2u);
  lab.world.destroy_body(other);
  EXPECT_EQ(contacts_of(lab.world, ground).size(), 1u);
  const BodyId late = lab.add({.position = {3, 0.5f, 0}}, Box{});  // in the same slots
  EXPECT_EQ(contacts_of(lab.world, ground).size(), 1u);
  EXPECT_TRUE(contacts_of(lab.world, late).empty());
  EXPECT_THROW(lab.world.contact_forces_of(other, {}), Error);
  ShapeId shape[1];
  lab.world.shapes_of(box, shape);
  lab.world.set_geometry(shape[0], Sphere{0.5f});
  EXPECT_TRUE(all_contacts(lab.world).empty());
}

TEST(ContactForces, ThrowUnlessTheSettingIsOn) {
  Lab lab;
  const BodyId ground = lab.add_ground();
  lab.run(1);
  EXPECT_THROW(lab.world.contact_forces({}), Error);
  EXPECT_THROW(lab.world.contact_forces_of(ground, {}), Error);
  EXPECT_EQ(lab.world.settings().contact_forces, false);
}

}  // namespace
}  // namespace scree::physics
