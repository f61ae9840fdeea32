// Every call refuses NaN and infinite numbers. For the largest numbers that calls accept see
// extremes_test.cpp.
#include <tests/core/constraints/joint_samples.h>
#include <tests/physics/lab.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <regex>
#include <set>
#include <string>

namespace scree::physics {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

// Replaces one number among the arguments of a call. Bindings name all members, so that a new member does not
// compile before it is covered here.
class Poke {
 public:
  Poke(int which, float value) : which_(which), value_(value) {}
  int count() const { return count_; }  // numbers so far

  template <class Value>
  Value operator()(Value value) {
    change(value);
    return value;
  }
  float bound(float value) {  // which may be infinite
    change_bound(value, kInfinite);
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
    auto& [half_extents, rounding] = box;
    change(half_extents), change(rounding);
  }
  void change(Cylinder& cylinder) {
    auto& [half_height, radius] = cylinder;
    change(half_height), change(radius);
  }
  void change(Cone& cone) {
    auto& [half_height, radius] = cone;
    change(half_height), change(radius);
  }
  void change(ConvexHull& convex) {
    auto& [hull, scale, rounding] = convex;
    change(scale), change(rounding);
  }
  void change(TriangleMesh&) {}
  void change(HalfSpace&) {}
  void change(Geometry& geometry) {
    std::visit([this](auto& solid) { change(solid); }, geometry);
  }
  void change(Material& material) {
    auto& [friction, restitution, rolling_resistance, density, patch_radius, surface_velocity, friction_mix,
           restitution_mix] = material;
    change(friction), change(restitution), change(rolling_resistance), change(density);
    change(*patch_radius);
    change(surface_velocity);
  }
  void change(ShapeOptions& options) {
    auto& [local_pose, filter, user_data, contact_events, sensor, contact_hooks] = options;
    change(local_pose);
  }
  // A number that may be infinite with one sign: the test replaces it by the other infinity.
  void change_bound(float& number, float sound) {
    if (count_++ == which_) number = value_ == sound ? -sound : value_;
  }
  void change(JointAxis& axis) {
    auto& [lower, upper, drive, target, speed, hertz, damping_ratio, max_force] = axis;
    change_bound(lower, -kInfinite), change_bound(upper, kInfinite), change(target), change(speed);
    change(hertz), change(damping_ratio), change_bound(max_force, kInfinite);
  }
  void change(RotationDrive& rotation) {
    auto& [drive, target, velocity, hertz, damping_ratio, max_torque] = rotation;
    change(target), change(velocity), change(hertz), change(damping_ratio);
    change_bound(max_torque, kInfinite);
  }
  void change(BallJoint& ball) {
    auto& [cone_limit, twist_lower, twist_upper, drive] = ball;
    change_bound(cone_limit, kInfinite), change_bound(twist_lower, -kInfinite);
    change_bound(twist_upper, kInfinite), change(drive);
  }
  void change(HingeJoint& hinge) {
    auto& [angle] = hinge;
    change(angle);
  }
  void change(SliderJoint& slider) {
    auto& [offset] = slider;
    change(offset);
  }
  void change(DistanceJoint& distance) {
    auto& [length] = distance;
    change(length);
  }
  void change(WeldJoint& weld) {
    auto& [angular_hertz, angular_damping_ratio] = weld;
    change(angular_hertz), change(angular_damping_ratio);
  }
  void change(SixDegreeJoint& joint) {
    auto& [offset, angle] = joint;
    for (JointAxis& axis : offset) change(axis);
    for (JointAxis& axis : angle) change(axis);
  }
  void change(WheelJoint& wheel) {
    auto& [suspension, steering, spin] = wheel;
    change(suspension), change(steering), change(spin);
  }
  void change(UniversalJoint& universal) {
    auto& [first, second] = universal;
    change(first), change(second);
  }
  void change(PlanarJoint& planar) {
    auto& [offset_y, offset_z, angle] = planar;
    change(offset_y), change(offset_z), change(angle);
  }
  void change(GearJoint& gear) {
    auto& [ratio] = gear;
    change(ratio);
  }
  void change(RackAndPinionJoint& rack) {
    auto& [radius] = rack;
    change(radius);
  }
  void change(PulleyJoint& pulley) {
    auto& [point_a, point_b, ratio, length, rigid] = pulley;
    change(point_a), change(point_b), change(ratio), change(length);
  }
  void change(MotorJoint& motor) {
    auto& [rotation, drive, target, velocity, hertz, damping_ratio, max_force] = motor;
    change(rotation), change(target), change(velocity), change(hertz), change(damping_ratio);
    change_bound(max_force, kInfinite);
  }
  void change(MouseJoint& mouse) {
    auto& [target, hertz, damping_ratio, max_force] = mouse;
    change(target), change(hertz), change(damping_ratio), change_bound(max_force, kInfinite);
  }
  void change(UserJoint& user) {  // which has kinds of rows only, no numbers
    auto& [rows] = user;
    static_assert(std::is_same_v<decltype(rows), RowKind[kMaxUserRows]>);
  }
  void change(UserRow& row) {
    auto& [jacobian, target, bounds] = row;
    auto& [linear_a, angular_a, linear_b, angular_b] = jacobian;
    change(linear_a), change(angular_a), change(linear_b), change(angular_b);
    auto& [error, speed, hertz, damping_ratio] = target;
    change(error), change(speed), change(hertz), change(damping_ratio);
    auto& [lower, upper] = bounds;
    change_bound(lower, -kInfinite), change_bound(upper, kInfinite);
  }
  void change(ContactAnswer& answer) {
    auto& [shape_a, shape_b, contact, rules] = answer;
    auto& [acts, friction, restitution, rolling_resistance, surface_velocity] = rules;
    change(friction), change(restitution), change(rolling_resistance), change(surface_velocity);
  }
  void change(Joint& joint) {
    std::visit([this](auto& kind) { change(kind); }, joint);
  }
  void change(JointDef& def) {
    auto& [body_a, body_b, frame_a, frame_b, collide_connected, enabled, hertz, damping_ratio, break_force,
           break_torque, event_force, event_torque, user_data] = def;
    change(frame_a), change(frame_b), change(hertz), change(damping_ratio);
    change_bound(break_force, kInfinite), change_bound(break_torque, kInfinite);
    change_bound(event_force, kInfinite), change_bound(event_torque, kInfinite);
  }
  void change(WorldSettings& settings) {
    auto& [gravity, substeps, contact_hertz, contact_damping_ratio, push_speed, restitution_threshold,
           max_linear_speed, max_angular_speed, continuous, warm_start, sleeping, sleep_linear_speed,
           sleep_angular_speed, sleep_time, contact_events, hit_event_speed, contact_forces, measure_residual,
           measure_penetration, solver, solver_options] = settings;
    change(gravity), change(contact_hertz), change(contact_damping_ratio), change(push_speed);
    change(restitution_threshold), change(max_linear_speed), change(max_angular_speed);
    change(sleep_linear_speed), change(sleep_angular_speed), change(sleep_time), change(hit_event_speed);
    change(solver_options.tolerance), change(solver_options.relaxation), change(solver_options.baumgarte);
    change(solver_options.slop);
  }

  int which_;
  float value_;
  int count_ = 0;
};

// A crate on the ground beside a kinematic capsule, and a disabled joint of each kind.
struct Stage {
  Stage() {
    EXPECT_EQ(lab.world.shapes_of(lab.add_ground(), {&ground, 1}), 1u);
    crate = lab.add({.position = {0, 0.5f, 0}}, Box{});
    roller = lab.add({.type = BodyType::kinematic, .position = {5, 1, 0}}, Capsule{});
    EXPECT_EQ(lab.world.shapes_of(crate, {&shape, 1}), 1u);
    for (const Joint& joint : test::plain_joints()) {
      joints.push_back(lab.world.create_joint({.body_a = kWorld, .body_b = crate, .enabled = false}, joint));
    }
    lab.run(5);
  }
  Lab lab;
  BodyId crate, roller;
  ShapeId ground, shape;
  std::vector<JointId> joints;
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

void add_joint_calls(std::vector<NumberCall>& calls) {
  calls.push_back({"set_user_rows", [](World& world, const Stage& s, Poke& poke) {
                     const UserRow row = poke(UserRow{});
                     world.set_user_rows(s.joints[static_cast<std::size_t>(JointType::user)], {&row, 1});
                   }});
  for (const Joint& joint : test::plain_joints()) {
    calls.push_back({"create_joints", [=](World& world, const Stage& s, Poke& poke) {
                       const JointDef defs[] = {{.body_a = kWorld, .body_b = s.crate},
                                                poke(JointDef{.body_a = kWorld, .body_b = s.crate})};
                       const Joint joints[] = {joint, poke(joint)};
                       JointId ids[2];
                       world.create_joints(defs, joints, ids);
                     }});
    if (std::holds_alternative<UserJoint>(joint)) continue;  // has no numbers
    calls.push_back({"create_joint", [=](World& world, const Stage& s, Poke& poke) {
                       world.create_joint({.body_a = kWorld, .body_b = s.crate}, poke(joint));
                     }});
    calls.push_back({"set_joint", [=](World& world, const Stage& s, Poke& poke) {
                       world.set_joint(s.joints[joint.index()], poke(joint));
                     }});
  }
}

// Every call of scree/world.h that takes a number, with valid arguments except for the replaced number.
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
      {"set_material", [](World& world, const Stage& s,
                          Poke& poke) { world.set_material(s.shape, poke(Material{.patch_radius = 0.1f})); }},
      {"answer_contact_hooks",
       [](World& world, const Stage& s, Poke& poke) {
         const ContactAnswer answer = poke(ContactAnswer{s.ground, s.shape, 0, {}});
         world.answer_contact_hooks({&answer, 1});
       }},
      {"set_local_pose",
       [](World& world, const Stage& s, Poke& poke) { world.set_local_pose(s.shape, poke(Pose{})); }},
      {"set_settings",
       [](World& world, const Stage&, Poke& poke) { world.set_settings(poke(WorldSettings{})); }},
      {"create_joint",
       [](World& world, const Stage& s, Poke& poke) {
         world.create_joint(poke(JointDef{.body_a = s.crate, .body_b = s.roller}), HingeJoint{});
       }},
      {"set_joint_frames",
       [](World& world, const Stage& s, Poke& poke) {
         const Pose frame_a = poke(Pose{});
         world.set_joint_frames(s.joints[0], frame_a, poke(Pose{}));
       }},
      {"set_joint_stiffness",
       [](World& world, const Stage& s, Poke& poke) {
         const float hertz = poke(1.0f);
         world.set_joint_stiffness(s.joints[0], hertz, poke(1.0f));
       }},
      {"set_joint_strength",
       [](World& world, const Stage& s, Poke& poke) {
         const float force = poke.bound(1.0f);
         world.set_joint_strength(s.joints[0], force, poke.bound(1.0f));
       }},
      {"set_joint_event_thresholds",
       [](World& world, const Stage& s, Poke& poke) {
         const float force = poke.bound(1.0f);
         world.set_joint_event_thresholds(s.joints[0], force, poke.bound(1.0f));
       }},
  };
  add_joint_calls(calls);
  for (const Geometry& geometry : geometries()) {
    calls.push_back({"create_bodies", [=](World& world, const Stage&, Poke& poke) {
                       const Geometry solid = poke(geometry);
                       const Material material = poke(Material{.patch_radius = 0.1f});
                       const ShapeOptions options = poke(ShapeOptions{});
                       BodyId id;
                       world.create_bodies({&def, 1}, {&solid, 1}, material, options, {&id, 1});
                     }});
    calls.push_back({"add_shape", [=](World& world, const Stage& s, Poke& poke) {
                       const Geometry solid = poke(geometry);
                       const Material material = poke(Material{.patch_radius = 0.1f});
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

TEST(NonFinite, EveryCallRefusesNonFiniteNumbersAndChangesNothing) {
  Stage stage;
  World& world = stage.lab.world;
  const std::vector<std::byte> before = state_of(world);
  for (const NumberCall& call : number_calls()) {
    World copy = clone(world);
    Poke none(-1, 0.0f);
    EXPECT_EQ(error_of([&] { call.make(copy, stage, none); }), "") << call.name << " with sound arguments";
    EXPECT_GT(none.count(), 0) << call.name;
    for (int number = 0; number < none.count(); ++number) {
      for (const float bad : {kNotANumber, kInfinite, -kInfinite}) {
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
      "ShapeOptions|WorldSettings|JointDef|Joint|UserRow|ContactAnswer)\\b");
  std::set<std::string> names;
  for (std::sregex_iterator it(bare.begin(), bare.end(), call), last; it != last; ++it) {
    if (std::regex_search((*it)[2].str(), number)) names.insert((*it)[1].str());
  }
  names.erase("user_rows");          // hands them out
  names.erase("refresh_user_rows");  // freezes the joint instead, see user_rows_callback_test.cpp
  return names;
}

TEST(NonFinite, EveryCallThatTakesANumberIsTested) {
  std::set<std::string> tested;
  for (const NumberCall& call : number_calls()) tested.insert(call.name);
  EXPECT_EQ(tested, calls_with_numbers());
}

}  // namespace
}  // namespace scree::physics
