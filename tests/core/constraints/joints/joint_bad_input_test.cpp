// Laws of invalid joints: every call that refuses one names itself, the value and the limit, and changes
// nothing.
#include <scree/scree.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/world/world_fixture.h>

#include <functional>
#include <limits>

namespace scree::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<std::byte> bytes_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

// Two bodies, a joint of each kind and a free slot.
struct Workshop {
  World world;
  BodyId a = world.create_body({}), b = world.create_body({.position = {1, 0, 0}}), dead;
  std::vector<JointId> joints;

  Workshop() {
    dead = world.create_body({});
    world.destroy_body(dead);
    for (const Joint& joint : sound_joints())
      joints.push_back(world.create_joint({.body_a = kWorld, .body_b = b}, joint));
    world.destroy_joint(world.create_joint({.body_a = a, .body_b = b}, BallJoint{}));
  }

  // Expects that the error contains each text of `said`.
  void refuse(const std::function<void()>& call, const std::vector<std::string>& said) {
    const std::vector<std::byte> before = bytes_of(world);
    const std::string error = error_of(call);
    for (const std::string& part : said) {
      EXPECT_NE(error.find(part), std::string::npos) << '"' << error << "\" without \"" << part << '"';
    }
    EXPECT_TRUE(bytes_of(world) == before) << error;
  }
  void refuse_def(const JointDef& def, const std::vector<std::string>& said,
                  const Joint& joint = BallJoint{}) {
    refuse([&] { world.create_joint(def, joint); }, said);
  }
  // Both by the calls that create joints and by the calls that change them.
  void refuse_joint(const Joint& joint, std::vector<std::string> said) {
    said.push_back("World::create_joint: ");
    refuse_def({.body_a = kWorld, .body_b = b}, said, joint);
    said.back() = "World::set_joint: ";
    refuse([&] { world.set_joint(joints[joint.index()], joint); }, said);
  }
};

// Default bodies: almost always an end that the caller forgot to set.
TEST(JointBadInput, AnOmittedBodyIsNotTheWorld) {
  Workshop w;
  w.refuse_def({.body_a = w.a}, {"body_b names no body; kWorld stands for the world"});
  w.refuse_def({.body_a = {}, .body_b = w.b}, {"body_a names no body; kWorld stands for the world"});
  w.refuse_def({.body_a = kWorld}, {"body_b names no body"});
  w.refuse_def({}, {"body_a names no body"});
  const JointId joint = w.world.create_joint({.body_a = w.a, .body_b = kWorld}, BallJoint{});
  EXPECT_EQ(w.world.joint_def(joint).body_b, kWorld);
}

TEST(JointBadInput, OnlyJointsTakeTheWorldForABody) {
  Workshop w;
  EXPECT_FALSE(w.world.is_alive(kWorld));
  w.refuse([&] { w.world.pose(kWorld); }, {"World::pose: the handle is kWorld, which only joints take"});
  w.refuse([&] { w.world.destroy_body(kWorld); }, {"which only joints take"});
  w.refuse([&] { w.world.add_shape(kWorld, Box{}); }, {"which only joints take"});
}

TEST(JointBadInput, IsRefusedInTheBodiesOfAJoint) {
  Workshop w;
  w.refuse_def({.body_a = kWorld, .body_b = kWorld}, {"World::create_joint: ", "both the world"});
  w.refuse_def({.body_a = w.a, .body_b = w.a}, {"body_a and body_b are both body 4"});
  w.refuse_def({.body_a = w.dead, .body_b = w.b}, {"no body lives under index 6, generation 1"});
  w.refuse_def({.body_a = w.a, .body_b = w.dead}, {"no body lives under index 6, generation 1"});
  w.refuse_def({.body_a = w.a, .body_b = {7, 0}}, {"names no body"});
  w.refuse_def({.body_a = w.a, .body_b = {0, 1}}, {"no body lives under index 0"});
  w.refuse_def({.body_a = {1, 1}, .body_b = w.b}, {"no body lives under index 1"});
  w.refuse_def({.body_a = w.a, .body_b = w.b}, {"body_a of a mouse joint is body 4, must be the world"},
               MouseJoint{});
  w.refuse_def({.body_a = w.a, .body_b = kWorld}, {"body_a of a mouse joint is body 4, must be the world"},
               MouseJoint{});
}

TEST(JointBadInput, IsRefusedInFrames) {
  Workshop w;
  const JointDef def{.body_a = kWorld, .body_b = w.b};
  const auto frames = [&](const Pose& frame_a, const Pose& frame_b, std::vector<std::string> said) {
    JointDef wrong = def;
    wrong.frame_a = frame_a;
    wrong.frame_b = frame_b;
    said.push_back("World::create_joint: ");
    w.refuse_def(wrong, said);
    said.back() = "World::set_joint_frames: ";
    w.refuse([&] { w.world.set_joint_frames(w.joints[0], frame_a, frame_b); }, said);
  };
  frames({{2e7f, 0, 0}, {}}, {}, {"frame_a.position is 20000000, must lie in [-10000000, 10000000]"});
  frames({}, {{0, 2e5f, 0}, {}}, {"frame_b.position is 200000, must lie in [-100000, 100000]"});
  frames({{0, 0, kNan}, {}}, {}, {"frame_a.position is nan"});
  frames({{}, {0, 0, 0, 0}}, {}, {"frame_a.rotation has length 0, must be 1 within 0.001"});
  frames({}, {{}, {0, 0, 0, 1.01f}}, {"frame_b.rotation has length 1.00999999, must be 1 within 0.001"});
  frames({}, {{}, {0, 0, 0, kNan}}, {"frame_b.rotation has length"});
  // In the world an anchor may lie as far away as a body.
  EXPECT_NO_THROW(w.world.set_joint_frames(w.joints[0], {{1e7f, -1e7f, 0}, {}}, {{1e5f, 0, 0}, {}}));
}

TEST(JointBadInput, IsRefusedInStiffnessAndStrength) {
  Workshop w;
  for (const float hertz : {-1.0f, 1e-4f, 2e4f, kNan, kNoLimit}) {
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .hertz = hertz},
                 {"hertz is ", "must lie in [0.001", "10000] or be 0"});
    w.refuse([&] { w.world.set_joint_stiffness(w.joints[0], hertz, 1.0f); },
             {"World::set_joint_stiffness: hertz is ", "must lie in [0.001", "10000] or be 0"});
    w.refuse_joint(WeldJoint{.angular_hertz = hertz}, {"weld angular_hertz is ", "10000] or be 0"});
  }
  for (const float ratio : {-1.0f, 2e4f, kNan}) {
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .damping_ratio = ratio},
                 {"damping_ratio is ", "must lie in [0, 10000]"});
    w.refuse([&] { w.world.set_joint_stiffness(w.joints[0], 1.0f, ratio); },
             {"damping_ratio is ", "must lie in [0, 10000]"});
    w.refuse_joint(WeldJoint{.angular_damping_ratio = ratio}, {"weld angular_damping_ratio is "});
  }
  for (const float strength : {0.0f, -1.0f, kNan}) {
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .break_force = strength},
                 {"break_force is ", "must be above 0"});
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .break_torque = strength},
                 {"break_torque is ", "must be above 0"});
    w.refuse([&] { w.world.set_joint_strength(w.joints[0], strength, 1.0f); },
             {"World::set_joint_strength: break_force is ", "must be above 0"});
    w.refuse([&] { w.world.set_joint_strength(w.joints[0], 1.0f, strength); }, {"break_torque is "});
  }
  for (const float threshold : {-1e-30f, -kNoLimit, kNan}) {
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .event_force = threshold},
                 {"event_force is ", "must be at least 0"});
    w.refuse_def({.body_a = kWorld, .body_b = w.b, .event_torque = threshold},
                 {"event_torque is ", "must be at least 0"});
    w.refuse([&] { w.world.set_joint_event_thresholds(w.joints[0], threshold, 1.0f); },
             {"World::set_joint_event_thresholds: event_force is ", "must be at least 0"});
    w.refuse([&] { w.world.set_joint_event_thresholds(w.joints[0], 1.0f, threshold); }, {"event_torque is "});
  }
}

// An invalid axis, and the text of its error.
struct WrongAxis {
  JointAxis axis;
  std::vector<std::string> said;
};
const std::vector<WrongAxis>& wrong_axes() {
  static const std::vector<WrongAxis> all = {
      {{.lower = 2.0f, .upper = 1.0f}, {"lower is 2, must be at most ", "upper, which is 1"}},
      {{.lower = kNan}, {"lower is nan", "or be -inf"}},
      {{.lower = kNoLimit}, {"lower is inf", "or be -inf"}},
      {{.lower = -2e6f}, {"lower is -2000000"}},
      {{.upper = kNan}, {"upper is nan", "or be inf"}},
      {{.upper = -kNoLimit}, {"upper is -inf", "or be inf"}},
      {{.upper = 2e6f}, {"upper is 2000000"}},
      {{.drive = static_cast<Drive>(3)}, {"drive is 3, must lie in [0, 2]"}},
      {{.target = kNan}, {"target is nan, must lie in [-1000000, 1000000]"}},
      {{.target = 2e6f}, {"target is 2000000, must lie in"}},
      {{.speed = kNoLimit}, {"speed is inf, must lie in [-1000000, 1000000]"}},
      {{.hertz = 0.0f}, {"hertz is 0, must lie in [0.001"}},
      {{.hertz = 2e4f}, {"hertz is 20000, must lie in"}},
      {{.damping_ratio = -1.0f}, {"damping_ratio is -1, must lie in [0, 10000]"}},
      {{.max_force = -1.0f}, {"max_force is -1, must lie in [0, inf]"}},
      {{.max_force = kNan}, {"max_force is nan"}}};
  return all;
}

TEST(JointBadInput, IsRefusedOnEveryAxisOfEveryKind) {
  Workshop w;
  const auto place = [](const char* name, auto set) {
    return std::pair<std::string, std::function<Joint(const JointAxis&)>>(name, set);
  };
  const auto six_degree = [](bool angle, int which) {
    return [=](const JointAxis& axis) {
      SixDegreeJoint joint;
      (angle ? joint.angle : joint.offset)[which] = axis;
      return Joint(joint);
    };
  };
  const std::vector<std::pair<std::string, std::function<Joint(const JointAxis&)>>> places = {
      place("hinge angle.", [](const JointAxis& axis) { return HingeJoint{axis}; }),
      place("slider offset.", [](const JointAxis& axis) { return SliderJoint{axis}; }),
      place("distance length.", [](const JointAxis& axis) { return DistanceJoint{axis}; }),
      place("six_degree offset[0].", six_degree(false, 0)),
      place("six_degree offset[1].", six_degree(false, 1)),
      place("six_degree offset[2].", six_degree(false, 2)),
      place("six_degree angle[0].", six_degree(true, 0)),
      place("six_degree angle[1].", six_degree(true, 1)),
      place("six_degree angle[2].", six_degree(true, 2)),
      place("wheel suspension.", [](const JointAxis& axis) { return WheelJoint{.suspension = axis}; }),
      place("wheel steering.", [](const JointAxis& axis) { return WheelJoint{.steering = axis}; }),
      place("wheel spin.", [](const JointAxis& axis) { return WheelJoint{.spin = axis}; }),
      place("universal first.", [](const JointAxis& axis) { return UniversalJoint{.first = axis}; }),
      place("universal second.", [](const JointAxis& axis) { return UniversalJoint{.second = axis}; }),
      place("planar offset_y.", [](const JointAxis& axis) { return PlanarJoint{.offset_y = axis}; }),
      place("planar offset_z.", [](const JointAxis& axis) { return PlanarJoint{.offset_z = axis}; }),
      place("planar angle.", [](const JointAxis& axis) { return PlanarJoint{.angle = axis}; })};
  for (const auto& [name, joint_with] : places) {
    const bool angular = name.find("angle") != std::string::npos || name.find("universal") == 0;
    for (const WrongAxis& wrong : wrong_axes()) {
      std::vector<std::string> said = wrong.said;
      said[0] = name + said[0];
      JointAxis axis = wrong.axis;
      if (axis.lower == 2.0f && name == "wheel steering.") {
        axis.lower = 1.5f;
        said[0] = name + "lower is 1.5, must be at most ";
      }
      w.refuse_joint(joint_with(axis), said);
    }
    if (!angular) continue;
    w.refuse_joint(joint_with({.lower = -3.2f}), {name + "lower is -3.2"});
    w.refuse_joint(joint_with({.upper = 3.2f}), {name + "upper is 3.2"});
    EXPECT_NO_THROW(w.world.create_joint({.body_a = kWorld, .body_b = w.b},
                                         joint_with({.lower = -3.14159274f, .upper = 3.14159274f})));
  }
}

TEST(JointBadInput, IsRefusedByTheRulesOfEachKind) {
  Workshop w;
  w.refuse_joint(BallJoint{.cone_limit = -0.1f}, {"ball cone_limit is -0.1", "must lie in [0, 3.14159"});
  w.refuse_joint(BallJoint{.cone_limit = 3.2f}, {"ball cone_limit is 3.2"});
  w.refuse_joint(BallJoint{.cone_limit = kNan}, {"ball cone_limit is nan"});
  w.refuse_joint(BallJoint{.twist_lower = 1.0f, .twist_upper = 0.5f},
                 {"ball twist_lower is 1, must be at most ball twist_upper, which is 0.5"});
  w.refuse_joint(BallJoint{.twist_lower = -4.0f}, {"ball twist_lower is -4"});
  w.refuse_joint(BallJoint{.twist_upper = kNan}, {"ball twist_upper is nan"});
  w.refuse_joint(DistanceJoint{{.lower = -1.0f}}, {"distance length.lower is -1, must lie in [0, 1000000]"});
  w.refuse_joint(DistanceJoint{{.upper = -1.0f}}, {"distance length.upper is -1"});
  w.refuse_joint(DistanceJoint{{.target = -1.0f}},
                 {"distance length.target is -1, must lie in [0, 1000000]"});
  w.refuse_joint(WheelJoint{.steering = {.lower = -1.6f}}, {"wheel steering.lower is -1.6", "1.5707"});
  w.refuse_joint(WheelJoint{.steering = {.upper = 1.6f}}, {"wheel steering.upper is 1.6", "1.5707"});
  w.refuse_joint(WheelJoint{.spin = {.lower = 0.0f}}, {"wheel spin.lower is 0, ", "no limits"});
  w.refuse_joint(WheelJoint{.spin = {.upper = 3.0f}}, {"wheel spin.upper is 3, ", "no limits"});
  w.refuse_joint(WheelJoint{.spin = {.drive = Drive::spring}}, {"wheel spin.drive is a spring"});
  for (const float factor : {0.0f, 1e-4f, -1e-4f, 2e3f, -2e3f, kNan, kNoLimit}) {
    w.refuse_joint(GearJoint{factor}, {"gear ratio is ", "its size must lie in [0.001", "1000]"});
    w.refuse_joint(RackAndPinionJoint{factor}, {"rack_and_pinion radius is ", "its size must lie in [0.001"});
  }
  for (const float ratio : {0.0f, -1.0f, 1e-4f, 2e3f, kNan}) {
    w.refuse_joint(PulleyJoint{.ratio = ratio}, {"pulley ratio is ", "must lie in [0.001", "1000]"});
  }
  for (const float length : {-1.0f, 2e6f, kNan}) {
    w.refuse_joint(PulleyJoint{.length = length}, {"pulley length is ", "must lie in [0, 1000000]"});
  }
  w.refuse_joint(PulleyJoint{.point_a = {0, 2e7f, 0}}, {"pulley point_a is 20000000"});
  w.refuse_joint(PulleyJoint{.point_b = {0, 0, kNan}}, {"pulley point_b is nan"});
  w.refuse_joint(MouseJoint{.target = {2e7f, 0, 0}}, {"mouse target is 20000000"});
  w.refuse_joint(MouseJoint{.hertz = 0.0f}, {"mouse hertz is 0"});
  w.refuse_joint(MouseJoint{.damping_ratio = kNan}, {"mouse damping_ratio is nan"});
  w.refuse_joint(MouseJoint{.max_force = -1.0f}, {"mouse max_force is -1"});
}

TEST(JointBadInput, IsRefusedInRotationDrives) {
  Workshop w;
  const std::vector<std::pair<RotationDrive, std::string>> wrong = {
      {{.drive = static_cast<Drive>(9)}, "drive is 9, must lie in [0, 2]"},
      {{.target = {0, 0, 0, 0}}, "target has length 0, must be 1 within 0.001"},
      {{.target = {0, kNan, 0, 1}}, "target has length"},
      {{.velocity = {0, 0, 2e6f}}, "velocity is 2000000, must lie in [-1000000, 1000000]"},
      {{.hertz = 0.0f}, "hertz is 0, must lie in"},
      {{.damping_ratio = 2e4f}, "damping_ratio is 20000, must lie in [0, 10000]"},
      {{.max_torque = -1.0f}, "max_torque is -1, must lie in [0, inf]"}};
  for (const auto& [drive, said] : wrong) {
    w.refuse_joint(BallJoint{.drive = drive}, {"ball drive." + said});
    w.refuse_joint(MotorJoint{.rotation = drive}, {"motor rotation." + said});
  }
  w.refuse_joint(MotorJoint{.drive = static_cast<Drive>(3)}, {"motor drive is 3"});
  w.refuse_joint(MotorJoint{.target = {kNan, 0, 0}}, {"motor target is nan"});
  w.refuse_joint(MotorJoint{.velocity = {0, 2e6f, 0}}, {"motor velocity is 2000000"});
  w.refuse_joint(MotorJoint{.hertz = -1.0f}, {"motor hertz is -1"});
  w.refuse_joint(MotorJoint{.damping_ratio = kNan}, {"motor damping_ratio is nan"});
  w.refuse_joint(MotorJoint{.max_force = kNan}, {"motor max_force is nan"});
}

TEST(JointBadInput, ValuesOfAnotherKindOfJointAreRefused) {
  Workshop w;
  w.refuse([&] { w.world.set_joint(w.joints[0], SliderJoint{}); },
           {"World::set_joint: the value is of a slider joint, must be of a ball joint"});
}

TEST(JointBadInput, OneBadJointOfAListRefusesTheWholeList) {
  Workshop w;
  JointDef defs[3] = {{.body_a = kWorld, .body_b = w.b},
                      {.body_a = kWorld, .body_b = w.b},
                      {.body_a = kWorld, .body_b = w.b, .hertz = -1.0f}};
  const Joint joints[3] = {BallJoint{}, GearJoint{2.0f}, HingeJoint{}};
  JointId ids[3] = {};
  w.refuse([&] { w.world.create_joints(defs, joints, ids); },
           {"World::create_joints: definition 2: hertz is -1"});
  EXPECT_EQ(ids[0], JointId{});
  w.refuse(
      [&] {
        w.world.create_joints(defs, {joints, 2}, ids);
      },
      {"World::create_joints: 3 definitions, but 2 joints and room for 3 ids"});
  w.refuse([&] { w.world.create_joints(defs, joints, {ids, 1}); }, {"room for 1 ids"});
  defs[2].hertz = 1.0f;
  w.world.create_joints(defs, joints, ids);
  EXPECT_EQ(w.world.joint_type(ids[2]), JointType::hinge);
}

TEST(JointBadInput, EveryCallRefusesDeadHandles) {
  Workshop w;
  World& world = w.world;
  const JointId dead = w.joints[3];
  world.destroy_joint(dead);
  const std::pair<const char*, std::function<void()>> calls[] = {
      {"destroy_joint", [&] { world.destroy_joint(dead); }},
      {"joint_type", [&] { world.joint_type(dead); }},
      {"joint", [&] { world.joint(dead); }},
      {"joint_def", [&] { world.joint_def(dead); }},
      {"set_joint", [&] { world.set_joint(dead, DistanceJoint{}); }},
      {"set_joint_frames", [&] { world.set_joint_frames(dead, {}, {}); }},
      {"set_joint_stiffness", [&] { world.set_joint_stiffness(dead, 1.0f, 1.0f); }},
      {"set_joint_strength", [&] { world.set_joint_strength(dead, 1.0f, 1.0f); }},
      {"set_joint_event_thresholds", [&] { world.set_joint_event_thresholds(dead, 1.0f, 1.0f); }},
      {"is_enabled", [&] { world.is_enabled(dead); }},
      {"set_joint_enabled", [&] { world.set_joint_enabled(dead, true); }},
      {"collides_connected", [&] { world.collides_connected(dead); }},
      {"set_collide_connected", [&] { world.set_collide_connected(dead, true); }},
      {"user_data", [&] { world.user_data(dead); }},
      {"set_user_data", [&] { world.set_user_data(dead, 1); }},
      {"joint_pose", [&] { world.joint_pose(dead); }},
      {"joint_reaction", [&] { world.joint_reaction(dead); }}};
  for (const auto& [name, call] : calls) {
    w.refuse(call, {std::string("World::") + name + ": no joint lives under index 3, generation 1"});
  }
  w.refuse([&] { world.joints_of(w.dead, {}); }, {"World::joints_of: no body lives"});
  w.refuse([&] { world.joints_of({}, {}); }, {"World::joints_of: the handle names no body"});
}

TEST(JointBadInput, SpringsAndRopesWithoutALowerEndAreSound) {
  World world;
  const BodyId body = world.create_body({});
  EXPECT_NO_THROW(
      world.create_joint({.body_a = kWorld, .body_b = body}, DistanceJoint{.length = {.upper = 2.0f}}));
  EXPECT_NO_THROW(world.create_joint({.body_a = kWorld, .body_b = body},
                                     WheelJoint{.steering = {.drive = Drive::spring, .target = 0.3f}}));
}

}  // namespace
}  // namespace scree::test
