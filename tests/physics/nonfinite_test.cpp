// Numbers that are none are refused by every call; the most extreme numbers that calls accept keep every
// state finite.
#include <core/limits.h>
#include <tests/physics/lab.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <regex>
#include <set>
#include <string>
#include <utility>

namespace scree::physics {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Replaces one number among the arguments of a call. Bindings name all members, so that a new one does not
// compile before it is poked, too.
class Poke {
 public:
  Poke(int which, float value) : which_(which), value_(value) {}
  int count() const { return count_; }  // of the numbers so far

  template <class Value>
  Value operator()(Value value) {
    change(value);
    return value;
  }

 private:
  void change(float& number) {
    if (count_++ == which_) number = value_;
  }
  void change(Vec3& v) {
    auto& [x, y, z] = v;
    change(x), change(y), change(z);
  }
  void change(Quat& q) {
    auto& [x, y, z, w] = q;
    change(x), change(y), change(z), change(w);
  }
  void change(Pose& pose) {
    auto& [position, rotation] = pose;
    change(position), change(rotation);
  }
  void change(BodyDef& def) {
    auto& [type, position, rotation, linear_velocity, angular_velocity, linear_damping, angular_damping,
           gravity_factor, locks, mass, can_sleep, user_data] = def;
    change(position), change(rotation), change(linear_velocity), change(angular_velocity);
    change(linear_damping), change(angular_damping), change(gravity_factor), change(*mass);
  }
  void change(MassProperties& properties) {
    auto& [mass, center, inertia] = properties;
    change(mass), change(center);
    for (float& moment : inertia) change(moment);
  }
  void change(Sphere& sphere) {
    auto& [radius] = sphere;
    change(radius);
  }
  void change(Capsule& capsule) {
    auto& [half_height, radius] = capsule;
    change(half_height), change(radius);
  }
  void change(Box& box) {
    auto& [half_extents] = box;
    change(half_extents);
  }
  void change(ConvexHull& convex) {
    auto& [hull, scale] = convex;
    change(scale);
  }
  void change(Geometry& geometry) {
    std::visit([this](auto& solid) { change(solid); }, geometry);
  }
  void change(Material& material) {
    auto& [friction, restitution, rolling_resistance, density, surface_velocity, friction_mix,
           restitution_mix] = material;
    change(friction), change(restitution), change(rolling_resistance), change(density);
    change(surface_velocity);
  }
  void change(ShapeOptions& options) {
    auto& [local_pose, filter, user_data, contact_events] = options;
    change(local_pose);
  }
  void change(WorldSettings& settings) {
    auto& [gravity, substeps, contact_hertz, contact_damping_ratio, push_speed, restitution_threshold,
           max_linear_speed, max_angular_speed, continuous, warm_start, sleeping, sleep_linear_speed,
           sleep_angular_speed, sleep_time, contact_events, measure_residual, measure_penetration] = settings;
    change(gravity), change(contact_hertz), change(contact_damping_ratio), change(push_speed);
    change(restitution_threshold), change(max_linear_speed), change(max_angular_speed);
    change(sleep_linear_speed), change(sleep_angular_speed), change(sleep_time);
  }

  int which_;
  float value_;
  int count_ = 0;
};

// A crate on the ground beside a kinematic capsule.
struct Stage {
  Stage() {
    lab.add_ground();
    crate = lab.add({.position = {0, 0.5f, 0}}, Box{});
    roller = lab.add({.type = BodyType::kinematic, .position = {5, 1, 0}}, Capsule{});
    EXPECT_EQ(lab.world.shapes_of(crate, {&shape, 1}), 1u);
    lab.run(5);
  }
  Lab lab;
  BodyId crate, roller;
  ShapeId shape;
};

const std::vector<Geometry>& geometries() {
  static const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const std::vector<Geometry> kGeometries = {Sphere{}, Capsule{}, Box{}, ConvexHull{Hull(kCorners)}};
  return kGeometries;
}

struct NumberCall {
  const char* name;
  std::function<void(World&, const Stage&, Poke&)> make;
};

// Every call of scree/world.h that takes a number, with sound arguments but for what is poked.
std::vector<NumberCall> number_calls() {
  const BodyDef def{.mass = 1.0f};
  const MassProperties mass{.mass = 2.0f, .inertia = {1.0f, 1.1f, 1.2f, 0.01f, 0.02f, 0.03f}};
  const Vec3 v{1, 2, 3};
  std::vector<NumberCall> calls = {
      {"World", [](World&, const Stage&, Poke& poke) { const World another(poke(WorldSettings{})); }},
      {"create_body", [=](World& world, const Stage&, Poke& poke) { world.create_body(poke(def)); }},
      {"create_bodies",
       [=](World& world, const Stage&, Poke& poke) {
         const BodyDef defs[] = {poke(def), poke(def)};
         BodyId ids[2];
         world.create_bodies(defs, ids);
       }},
      {"set_pose",
       [](World& world, const Stage& s, Poke& poke) { world.set_pose(s.crate, poke(world.pose(s.crate))); }},
      {"velocity_at", [=](World& world, const Stage& s, Poke& poke) { world.velocity_at(s.crate, poke(v)); }},
      {"set_linear_velocity",
       [=](World& world, const Stage& s, Poke& poke) { world.set_linear_velocity(s.crate, poke(v)); }},
      {"set_angular_velocity",
       [=](World& world, const Stage& s, Poke& poke) { world.set_angular_velocity(s.crate, poke(v)); }},
      {"set_kinematic_target",
       [](World& world, const Stage& s, Poke& poke) {
         const Pose target = poke(world.pose(s.roller));
         world.set_kinematic_target(s.roller, target, poke(kStep));
       }},
      {"set_mass_properties",
       [=](World& world, const Stage& s, Poke& poke) { world.set_mass_properties(s.crate, poke(mass)); }},
      {"set_linear_damping",
       [](World& world, const Stage& s, Poke& poke) { world.set_linear_damping(s.crate, poke(1.0f)); }},
      {"set_angular_damping",
       [](World& world, const Stage& s, Poke& poke) { world.set_angular_damping(s.crate, poke(1.0f)); }},
      {"set_gravity_factor",
       [](World& world, const Stage& s, Poke& poke) { world.set_gravity_factor(s.crate, poke(2.0f)); }},
      {"add_force", [=](World& world, const Stage& s, Poke& poke) { world.add_force(s.crate, poke(v)); }},
      {"add_force_at",
       [=](World& world, const Stage& s, Poke& poke) {
         const Vec3 force = poke(v);
         world.add_force_at(s.crate, force, poke(v));
       }},
      {"add_torque", [=](World& world, const Stage& s, Poke& poke) { world.add_torque(s.crate, poke(v)); }},
      {"add_impulse", [=](World& world, const Stage& s, Poke& poke) { world.add_impulse(s.crate, poke(v)); }},
      {"add_impulse_at",
       [=](World& world, const Stage& s, Poke& poke) {
         const Vec3 impulse = poke(v);
         world.add_impulse_at(s.crate, impulse, poke(v));
       }},
      {"add_angular_impulse",
       [=](World& world, const Stage& s, Poke& poke) { world.add_angular_impulse(s.crate, poke(v)); }},
      {"set_material",
       [](World& world, const Stage& s, Poke& poke) { world.set_material(s.shape, poke(Material{})); }},
      {"set_local_pose",
       [](World& world, const Stage& s, Poke& poke) { world.set_local_pose(s.shape, poke(Pose{})); }},
      {"set_settings",
       [](World& world, const Stage&, Poke& poke) { world.set_settings(poke(WorldSettings{})); }},
  };
  for (const Geometry& geometry : geometries()) {
    calls.push_back({"create_bodies", [=](World& world, const Stage&, Poke& poke) {
                       const Geometry solid = poke(geometry);
                       const Material material = poke(Material{});
                       const ShapeOptions options = poke(ShapeOptions{});
                       BodyId id;
                       world.create_bodies({&def, 1}, {&solid, 1}, material, options, {&id, 1});
                     }});
    calls.push_back({"add_shape", [=](World& world, const Stage& s, Poke& poke) {
                       const Geometry solid = poke(geometry);
                       const Material material = poke(Material{});
                       world.add_shape(s.crate, solid, material, poke(ShapeOptions{}));
                     }});
    calls.push_back({"set_geometry", [=](World& world, const Stage& s, Poke& poke) {
                       world.set_geometry(s.shape, poke(geometry));
                     }});
  }
  return calls;
}

std::vector<std::byte> state_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(NonFinite, EveryCallRefusesWhatIsNoNumberAndChangesNothing) {
  Stage stage;
  World& world = stage.lab.world;
  const std::vector<std::byte> before = state_of(world);
  for (const NumberCall& call : number_calls()) {
    World copy = clone(world);
    Poke none(-1, 0.0f);
    EXPECT_EQ(error_of([&] { call.make(copy, stage, none); }), "") << call.name << " with sound arguments";
    EXPECT_GT(none.count(), 0) << call.name;
    for (int number = 0; number < none.count(); ++number) {
      for (const float bad : {kNan, kInfinity, -kInfinity}) {
        Poke poke(number, bad);
        const std::string error = error_of([&] { call.make(world, stage, poke); });
        SCOPED_TRACE(call.name + (", number " + std::to_string(number)) + ": " + error);
        EXPECT_EQ(error.rfind(std::string("World::") + call.name + ": ", 0), 0u);
        EXPECT_NE(error.find(std::isnan(bad) ? "nan" : "inf"), std::string::npos);
        ASSERT_TRUE(state_of(world) == before);
      }
    }
  }
  stage.lab.run(60);
  EXPECT_NEAR(stage.lab.height(stage.crate), 0.5, 0.01);
}

// Names of the members of World with a parameter that is or holds a number.
std::set<std::string> calls_with_numbers() {
  std::ifstream file(SCREE_WORLD_HEADER);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t begin = text.find("class SCREE_API World {"), end = text.find("private:", begin);
  EXPECT_LT(begin, end);
  EXPECT_LT(end, text.size());
  if (!(begin < end && end < text.size())) return {};
  const std::string bare =
      std::regex_replace(text.substr(begin, end - begin), std::regex("//[^\n]*"), std::string());
  const std::regex call("([A-Za-z_]+)\\(([^()]*)\\)");
  const std::regex number(
      "\\b(float|double|Vec3|Quat|Pose|BodyDef|MassProperties|Geometry|Sphere|Capsule|Box|ConvexHull|"
      "Material|"
      "ShapeOptions|WorldSettings)\\b");
  std::set<std::string> names;
  for (std::sregex_iterator it(bare.begin(), bare.end(), call), last; it != last; ++it) {
    if (std::regex_search((*it)[2].str(), number)) names.insert((*it)[1].str());
  }
  return names;
}

TEST(NonFinite, NoCallThatTakesANumberIsForgotten) {
  std::set<std::string> tested;
  for (const NumberCall& call : number_calls()) tested.insert(call.name);
  EXPECT_EQ(tested, calls_with_numbers());
}

// --- the largest and smallest numbers ---

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
  add("thresholds", [](WorldSettings& s) {
    s.restitution_threshold = s.sleep_linear_speed = s.sleep_angular_speed = s.sleep_time = kMaxThreshold;
  });
}

std::vector<Extreme> extremes() {
  std::vector<Extreme> list;
  add_extremes_of_motion(list);
  add_extremes_of_shapes(list);
  add_extremes_of_settings(list);
  return list;
}

// The force for one body's acceleration, then the mass for the one that it shall have.
void accelerate(World& world, BodyId body, float acceleration, Vec3 way, bool turns) {
  constexpr float kMostLoad = 1e30f;
  const float load = std::min(acceleration, kMostLoad), inertia = load / acceleration;
  world.set_mass_properties(body, {.mass = 1e16f, .inertia = {1e16f, 1e16f, 1e16f}});
  turns ? world.add_torque(body, load * way) : world.add_force(body, load * way);
  world.set_mass_properties(body, {.mass = inertia, .inertia = {inertia, inertia, inertia}});
}

// Squares of such speeds are no numbers, though the speeds are.
TEST(NonFinite, AnAccelerationBeyondAllSpeedsIsLimitedOrFreezes) {
  int limited = 0, frozen = 0;
  for (const bool turns : {false, true}) {
    for (int exponent = 16; exponent <= 37; ++exponent) {
      for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0.6f, -0.8f, 0}}) {
        SCOPED_TRACE(std::to_string(exponent) + (turns ? ", turning" : ""));
        Lab lab(without_gravity());
        const BodyId body = lab.add({.position = {1, 2, 3}}, Sphere{0.5f});
        const BodyId other = lab.add({.position = {9, 2, 3}, .linear_velocity = {1, 0, 0}}, Sphere{0.5f});
        accelerate(lab.world, body, std::pow(10.0f, static_cast<float>(exponent)), way, turns);
        lab.run(1);
        EXPECT_FALSE(lab.world.is_frozen(other));
        EXPECT_TRUE(lab.all_finite());
        if (lab.world.is_frozen(body)) {
          ++frozen;
          EXPECT_EQ(lab.world.restored_bodies().size(), 1u);
          EXPECT_EQ(lab.world.frozen_bodies().size(), 1u);
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
  EXPECT_GE(frozen, 16);
}

// Does something extreme to a body in a heap and requires of the steps that follow that all stays finite,
// that nobody else is frozen, and that the events tell who is. Returns how many bodies were restored.
std::size_t suffer(const std::function<void(World&, BodyId, ShapeId)>& make) {
  Lab lab;
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
    for (const BodyId& frozen : lab.world.frozen_bodies()) {
      EXPECT_EQ(frozen, body) << "step " << i;
      EXPECT_TRUE(lab.world.is_frozen(frozen));
      EXPECT_TRUE(std::count(lab.world.restored_bodies().begin(), lab.world.restored_bodies().end(), frozen));
    }
    EXPECT_TRUE(lab.all_finite()) << "step " << i;
    if (testing::Test::HasFailure()) return restored;
  }
  for (const BodyId& other : heap) EXPECT_TRUE(other == body || !lab.world.is_frozen(other));
  return restored;
}

TEST(NonFinite, AnAccelerationBeyondAllSpeedsInAHeapHarmsNobodyElse) {
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

TEST(NonFinite, ExtremesStayFiniteOneByOne) {
  for (const Extreme& extreme : extremes()) {
    SCOPED_TRACE(extreme.name);
    suffer(extreme.make);
    if (HasFailure()) return;
  }
}

TEST(NonFinite, ExtremesStayFiniteTogether) {
  const std::vector<Extreme> list = extremes();
  int breaking = 0;  // trials in which somebody was restored
  for (std::uint64_t trial = 0; trial < 150; ++trial) {
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
        } catch (const Error&) {  // too much after what came before
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
