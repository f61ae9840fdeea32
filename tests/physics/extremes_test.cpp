// Every state stays finite with the most extreme numbers that calls accept.
#include <core/world/limits.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

namespace scree::physics {
namespace {

struct Extreme {
  std::string name;
  std::function<void(World&, BodyId, ShapeId)> make;
};

void add_extremes_of_motion(std::vector<Extreme>& list) {
  const auto add = [&](const char* name, auto make) {
    list.push_back({name, [make](World& world, BodyId body, ShapeId) { make(world, body); }});
  };
  for (const float sign : {1.0f, -1.0f}) {
    const Vec3 all{sign, -sign, sign}, one{0, sign, 0};
    for (const Vec3 way : {all, one}) {
      add("velocity", [=](World& w, BodyId b) { w.set_linear_velocity(b, kMaxSpeed * way); });
      add("spin", [=](World& w, BodyId b) { w.set_angular_velocity(b, kMaxSpeed * way); });
      add("place", [=](World& w, BodyId b) { w.set_pose(b, {kMaxPosition * way, {}}); });
      add("force", [=](World& w, BodyId b) {
        w.add_force(b, (0.99f * kMaxAcceleration * w.mass_properties(b).mass) * way);
      });
      add("torque", [=](World& w, BodyId b) {
        const MassProperties mass = w.mass_properties(b);
        const float* inertia = mass.inertia;
        w.add_torque(b, (0.3f * kMaxAcceleration * std::min({inertia[0], inertia[1], inertia[2]})) * way);
      });
      add("impulse", [=](World& w, BodyId b) {
        w.add_impulse(b, (0.9f * kMaxSpeed * w.mass_properties(b).mass) * way);
      });
    }
    add("distant force", [=](World& w, BodyId b) {
      w.add_force_at(b, 1e3f * all, kMaxPosition * Vec3{1, 1, -1});
    });
    add("distant impulse", [=](World& w, BodyId b) {
      w.add_impulse_at(b, 10.0f * all, kMaxPosition * Vec3{-1, 1, 1});
    });
    add("gravity factor", [=](World& w, BodyId b) { w.set_gravity_factor(b, sign * kMaxGravityFactor); });
  }
  add("dampings", [](World& w, BodyId b) {
    w.set_linear_damping(b, kMaxRate);
    w.set_angular_damping(b, kMaxRate);
  });
  for (const float mass : {kMinMass, 1e-10f, 1.0f, 1e15f, kMaxMass}) {
    for (const float inertia : {1e-30f, 1e-15f, 1.0f, 1e18f, 9e34f}) {
      list.push_back({"mass " + std::to_string(mass) + " inertia " + std::to_string(inertia),
                      [=](World& w, BodyId b, ShapeId) {
                        w.set_mass_properties(b, {.mass = mass, .inertia = {inertia, inertia, inertia}});
                      }});
    }
  }
  for (const float slender : {1e-30f, 1e-10f, 1e30f}) {
    list.push_back({"slender inertia", [=](World& w, BodyId b, ShapeId) {
                      w.set_mass_properties(b, {.inertia = {slender, 1e4f * slender, 1e4f * slender}});
                    }});
  }
  add("distant center", [](World& w, BodyId b) {
    w.set_mass_properties(b, {.center = {1e5f, -1e5f, 1e5f}});
  });
}

void add_extremes_of_shapes(std::vector<Extreme>& list) {
  const auto add = [&](const char* name, auto make) {
    list.push_back({name, [make](World& world, BodyId, ShapeId shape) { make(world, shape); }});
  };
  const float low = kMinExtent, high = kMaxExtent;
  for (const Geometry& geometry :
       {Geometry{Sphere{low}}, Geometry{Sphere{high}}, Geometry{Capsule{high, low}},
        Geometry{Capsule{low, low}}, Geometry{Capsule{low, high}}, Geometry{Box{{low, low, low}}},
        Geometry{Box{{high, low, high}}}, Geometry{Box{{low, high, low}}},
        Geometry{Box{{high, high, high}}}}) {
    add("geometry", [=](World& w, ShapeId s) { w.set_geometry(s, geometry); });
  }
  const auto material = [&](const char* name, const Material& what) {
    add(name, [=](World& w, ShapeId s) { w.set_material(s, what); });
  };
  material("friction", {.friction = kMaxFriction});
  material("bounce", {.restitution = 1.0f});
  material("rolling resistance", {.rolling_resistance = kMaxRollingResistance});
  material("light", {.density = kMinDensity});
  material("heavy", {.density = kMaxDensity});
  material("belt", {.friction = kMaxFriction, .surface_velocity = {1e6f, -1e6f, 1e6f}});
  add("distant shape", [](World& w, ShapeId s) { w.set_local_pose(s, {{1e5f, 1e5f, -1e5f}, {}}); });
}

void add_extremes_of_settings(std::vector<Extreme>& list) {
  const auto add = [&](const char* name, auto change) {
    list.push_back({name, [change](World& world, BodyId, ShapeId) {
                      WorldSettings settings = world.settings();
                      change(settings);
                      world.set_settings(settings);
                    }});
  };
  add("gravity", [](WorldSettings& s) { s.gravity = {kMaxGravity, -kMaxGravity, kMaxGravity}; });
  add("one substep", [](WorldSettings& s) { s.substeps = 1; });
  add("many substeps", [](WorldSettings& s) { s.substeps = kMaxSubsteps; });
  add("softest", [](WorldSettings& s) { s.contact_hertz = kMinHertz, s.contact_damping_ratio = 0.0f; });
  add("stiffest",
      [](WorldSettings& s) { s.contact_hertz = kMaxHertz, s.contact_damping_ratio = kMaxDampingRatio; });
  add("push", [](WorldSettings& s) { s.push_speed = kMaxRate; });
  add("slowest",
      [](WorldSettings& s) { s.max_linear_speed = kMinSpeedLimit, s.max_angular_speed = kMinSpeedLimit; });
  add("fastest",
      [](WorldSettings& s) { s.max_linear_speed = kMaxSpeedLimit, s.max_angular_speed = kMaxSpeedLimit; });
  // The direct one would take seconds a step.
  for (const Solver solver :
       {Solver::sequential_impulse, Solver::jacobi, Solver::gauss_seidel, Solver::over_relaxation,
        Solver::conjugate_gradient, Solver::accelerated_gradient}) {
    add(solver_name(solver), [=](WorldSettings& s) { s.solver = solver, s.solver_options.baumgarte = 1.0f; });
  }
  add("thresholds", [](WorldSettings& s) {
    s.restitution_threshold = s.sleep_linear_speed = s.sleep_angular_speed = s.sleep_time = kMaxThreshold;
  });
}

// Joints with the world only, so that only this body can be at fault.
void add_extremes_of_joints(std::vector<Extreme>& list) {
  const auto add = [&](const char* name, const JointDef& def, const Joint& joint) {
    list.push_back({std::string(name) + ", kind " + std::to_string(joint.index()),
                    [=](World& world, BodyId body, ShapeId) {
                      JointDef with_body = def;
                      with_body.body_a = kWorld;
                      with_body.body_b = body;
                      world.create_joint(with_body, joint);
                    }});
  };
  const float far = kMaxPosition, most = kMaxJointValue;
  for (const Joint& joint : test::plain_joints()) {
    add("distant anchors", {.frame_a = {{far, -far, far}, {}}, .frame_b = {{-1e5f, 1e5f, 1e5f}, {}}}, joint);
    add("stiffest joint", {.hertz = kMaxHertz, .damping_ratio = kMaxDampingRatio}, joint);
    add("softest joint", {.hertz = kMinHertz, .damping_ratio = 0.0f}, joint);
    add("weakest joint", {.break_force = 1e-38f, .break_torque = 1e-38f}, joint);
  }
  const auto axis = [&](const char* name, const JointAxis& wild) {
    const JointAxis turn{-kMaxJointAngle, kMaxJointAngle, wild.drive,         wild.target,
                         wild.speed,      wild.hertz,     wild.damping_ratio, wild.max_force};
    JointAxis length = wild;
    length.lower = 0.0f;
    length.target = std::abs(wild.target);
    add(name, {}, HingeJoint{turn});
    add(name, {}, SliderJoint{wild});
    add(name, {}, DistanceJoint{length});
    add(name, {}, SixDegreeJoint{{wild, wild, wild}, {turn, turn, turn}});
    add(name, {}, WheelJoint{.suspension = wild});
    add(name, {}, UniversalJoint{turn, turn});
    add(name, {}, PlanarJoint{wild, wild, turn});
  };
  axis("motor", {-most, most, Drive::motor, 0.0f, most});
  axis("spring", {-most, most, Drive::spring, -most, most, kMaxHertz, kMaxDampingRatio});
  axis("soft spring", {-most, most, Drive::spring, most, -most, kMinHertz, 0.0f});
  const RotationDrive turn{.drive = Drive::spring, .velocity = {most, -most, most}, .hertz = kMaxHertz};
  add("drive", {}, BallJoint{.cone_limit = 0.0f, .twist_lower = 0.0f, .twist_upper = 0.0f, .drive = turn});
  add("drive", {},
      MotorJoint{.rotation = turn, .target = {most, most, -most}, .velocity = {most, most, most}});
  add("drive", {}, MouseJoint{.target = {far, far, -far}, .hertz = kMaxHertz, .damping_ratio = 0.0f});
  for (const float ratio : {kMinRatio, kMaxRatio}) {
    add("ratio", {}, GearJoint{-ratio});
    add("ratio", {}, RackAndPinionJoint{ratio});
    add("ratio", {}, PulleyJoint{.point_b = {far, far, far}, .ratio = ratio, .length = 0.0f, .rigid = true});
  }
}

std::vector<Extreme> extremes() {
  std::vector<Extreme> list;
  add_extremes_of_motion(list);
  add_extremes_of_shapes(list);
  add_extremes_of_settings(list);
  add_extremes_of_joints(list);
  return list;
}

// Sets the force for one body's acceleration, then the mass for the target acceleration.
void accelerate(World& world, BodyId body, float acceleration, Vec3 way, bool turns) {
  constexpr float kMostLoad = 1e30f;
  const float load = std::min(acceleration, kMostLoad), inertia = load / acceleration;
  world.set_mass_properties(body, {.mass = 1e16f, .inertia = {1e16f, 1e16f, 1e16f}});
  turns ? world.add_torque(body, load * way) : world.add_force(body, load * way);
  world.set_mass_properties(body, {.mass = inertia, .inertia = {inertia, inertia, inertia}});
}

// Such speeds are finite, but their squares are not.
TEST(Extremes, AnAccelerationBeyondTheSpeedLimitIsLimitedOrQuarantinesTheBody) {
  int limited = 0, quarantined = 0;
  for (const bool turns : {false, true}) {
    for (int exponent = 16; exponent <= 37; ++exponent) {
      for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0.6f, -0.8f, 0}}) {
        SCOPED_TRACE(std::to_string(exponent) + (turns ? ", turning" : ""));
        Lab lab(without_gravity());
        const BodyId body = lab.add({.position = {1, 2, 3}}, Sphere{0.5f});
        const BodyId other = lab.add({.position = {9, 2, 3}, .linear_velocity = {1, 0, 0}}, Sphere{0.5f});
        accelerate(lab.world, body, std::pow(10.0f, static_cast<float>(exponent)), way, turns);
        lab.run(1);
        EXPECT_FALSE(lab.world.is_quarantined(other));
        EXPECT_TRUE(lab.all_finite());
        if (lab.world.is_quarantined(body)) {
          ++quarantined;
          EXPECT_EQ(lab.world.restored_bodies().size(), 1u);
          EXPECT_EQ(lab.world.quarantined_bodies().size(), 1u);
          EXPECT_EQ(lab.position(body), Eigen::Vector3d(1, 2, 3));
          continue;
        }
        ++limited;
        const WorldSettings& settings = lab.world.settings();
        const float limit = turns ? settings.max_angular_speed : settings.max_linear_speed;
        const Eigen::Vector3d expected = static_cast<double>(limit) * to_eigen(way);
        const Eigen::Vector3d actual = turns ? lab.spin(body) : lab.velocity(body);
        EXPECT_LT((actual - expected).norm(), 1e-3 * expected.norm()) << actual.transpose();
      }
    }
  }
  EXPECT_GE(limited, 16);
  EXPECT_GE(quarantined, 16);
}

// Applies extreme input to a body in a heap. Expects in the steps that follow that all stays finite, that no
// other body is quarantined, and that the events list this body if it is. Returns the number of restored
// bodies.
std::size_t suffer(const std::function<void(World&, BodyId, ShapeId)>& make, bool half_space = false) {
  Lab lab;
  if (half_space) lab.add({.type = BodyType::fixed, .position = {0, -0.5f, 0}}, HalfSpace{});
  const std::vector<BodyId> heap = add_heap(lab, 12, 3);
  lab.run(40);
  const BodyId body = heap[4];
  ShapeId shape;
  EXPECT_EQ(lab.world.shapes_of(body, {&shape, 1}), 1u);
  make(lab.world, body, shape);
  std::size_t restored = 0;
  for (int i = 0; i < 200; ++i) {
    lab.run(1);
    restored += lab.world.restored_bodies().size();
    for (const BodyId& quarantined : lab.world.quarantined_bodies()) {
      EXPECT_EQ(quarantined, body) << "step " << i;
      EXPECT_TRUE(lab.world.is_quarantined(quarantined));
      EXPECT_TRUE(
          std::count(lab.world.restored_bodies().begin(), lab.world.restored_bodies().end(), quarantined));
    }
    EXPECT_TRUE(lab.all_finite()) << "step " << i;
    if (testing::Test::HasFailure()) return restored;
  }
  for (const BodyId& other : heap) EXPECT_TRUE(other == body || !lab.world.is_quarantined(other));
  return restored;
}

TEST(Extremes, AnAccelerationBeyondTheSpeedLimitInAHeapQuarantinesNoOtherBody) {
  for (const bool turns : {false, true}) {
    for (int exponent = 20; exponent <= 37; exponent += turns ? 4 : 2) {
      SCOPED_TRACE(std::to_string(exponent) + (turns ? ", turning" : ""));
      suffer([=](World& world, BodyId body, ShapeId) {
        accelerate(world, body, std::pow(10.0f, static_cast<float>(exponent)), {0.6f, 0, 0.8f}, turns);
      });
      if (HasFailure()) return;
    }
  }
}

TEST(Extremes, EachAloneStaysFinite) {
  for (const Extreme& extreme : extremes()) {
    SCOPED_TRACE(extreme.name);
    suffer(extreme.make);
    if (HasFailure()) return;
  }
}

TEST(Extremes, EachAloneStaysFiniteOverAHalfSpace) {
  for (const Extreme& extreme : extremes()) {
    SCOPED_TRACE(extreme.name);
    suffer(extreme.make, true);
    if (HasFailure()) return;
  }
}

TEST(Extremes, SeveralTogetherStayFinite) {
  const std::vector<Extreme> list = extremes();
  int breaking = 0;  // trials in which a body was restored
  std::vector<std::uint64_t> trials(150);
  std::iota(trials.begin(), trials.end(), std::uint64_t{0});
  trials.push_back(577);  // a mass of 1e30 kg with a moment of inertia of 1 kg m^2
  for (const std::uint64_t trial : trials) {
    Random random(trial);
    std::vector<const Extreme*> chosen;
    std::string names;
    for (int i = 0; i < 5; ++i) {
      chosen.push_back(
          &list[static_cast<std::size_t>(random.uniform(0.0f, static_cast<float>(list.size()) - 0.5f))]);
      names += chosen.back()->name + "; ";
    }
    SCOPED_TRACE(std::to_string(trial) + ": " + names);
    const std::size_t restored = suffer([&](World& world, BodyId body, ShapeId shape) {
      for (const Extreme* extreme : chosen) {
        try {
          extreme->make(world, body, shape);
        } catch (const Error&) {  // too large together with earlier input
        }
      }
    });
    if (HasFailure()) return;
    breaking += restored > 0 ? 1 : 0;
  }
  RecordProperty("breaking", breaking);
  EXPECT_GT(breaking, 0) << "else nothing of this is extreme";
}

}  // namespace
}  // namespace scree::physics
