// Laws of joints in scene files: they have the stated values, and mistakes are reported with their place.
#include <gtest/gtest.h>
#include <tools/scenes/scene_file.h>

#include <cmath>
#include <string>
#include <utility>

namespace scree::scenes {
namespace {

constexpr float kDegree = 3.14159265f / 180.0f;

// Four bodies a meter apart along x, and one turned by a quarter about z.
std::string with_joints(const std::string& joints) {
  return R"({"bodies": [{"name": "bead", "repeat": {"count": [4, 1, 1], "spacing": [1, 0, 0]}},
    {"name": "turned", "position": [0, 5, 0], "rotation": {"axis": [0, 0, 1], "degrees": 90}}],
    "joints": [)" +
         joints + "]}";
}
std::string with_joint(const std::string& members) {
  return with_joints(R"({"body_a": 0, "body_b": 1, )" + members + "}");
}
Scene parse(const std::string& text) { return parse_scene(text, "scene.json"); }
template <class Kind>
Kind kind_of(const std::string& members) {
  return std::get<Kind>(parse(with_joint(members)).joints.at(0).joint);
}
std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(SceneFileJoints, KnowEveryKind) {
  const char* kinds[] = {"ball",      "hinge",  "slider", "distance",        "weld",   "six_degree", "wheel",
                         "universal", "planar", "gear",   "rack_and_pinion", "pulley", "motor"};
  for (std::size_t i = 0; i < std::size(kinds); ++i) {
    const Scene scene = parse(with_joint(R"("type": ")" + std::string(kinds[i]) + "\""));
    EXPECT_EQ(scene.joints.at(0).joint.index(), i) << kinds[i];
  }
  const Scene scene = parse(with_joints(R"({"type": "mouse", "body_b": 1, "pull": {"target": [1, 2, 3]}})"));
  EXPECT_EQ(std::get<MouseJoint>(scene.joints.at(0).joint).target, (Vec3{1, 2, 3}));
}

TEST(SceneFileJoints, OfUsersHaveTheirRowsAndTheirNumbers) {
  const Scene scene = parse(with_joint(R"("type": "user", "rows": [
    {"kind": "held", "linear_a": [1, 2, 3], "angular_a": [4, 5, 6], "linear_b": [7, 8, 9],
     "angular_b": [10, 11, 12], "error": 0.5, "speed": -1},
    {"kind": "limit"}, {"kind": "motor", "lower": -2, "upper": 3},
    {"kind": "spring", "hertz": 4, "damping_ratio": 0.25}])"));
  const SceneJoint& joint = scene.joints.at(0);
  EXPECT_EQ(std::get<UserJoint>(joint.joint),
            (UserJoint{{RowKind::held, RowKind::limit, RowKind::motor, RowKind::spring}}));
  ASSERT_EQ(joint.rows.size(), 4u);
  EXPECT_EQ(joint.rows[0],
            (UserRow{{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}, {.error = 0.5f, .speed = -1}, {}}));
  EXPECT_EQ(joint.rows[1], UserRow{});
  EXPECT_EQ(joint.rows[2], (UserRow{.bounds = {-2, 3}}));
  EXPECT_EQ(joint.rows[3], (UserRow{.target = {.hertz = 4, .damping_ratio = 0.25f}}));
  EXPECT_NE(error_of(with_joint(R"("type": "user")")).find("rows"), std::string::npos);
  EXPECT_NE(error_of(with_joint(R"("type": "user", "rows": [])")).find("must have 1 to 6 rows"),
            std::string::npos);
  EXPECT_NE(error_of(with_joint(R"("type": "user", "rows": [{"kind": "soft"}])")).find("kind"),
            std::string::npos);
  EXPECT_NE(error_of(with_joint(R"("type": "user", "rows": [{"kind": "motor", "lower": 2, "upper": 1}])"))
                .find("lower must be at most upper"),
            std::string::npos);
}

TEST(SceneFileJoints, MissingKeysTakeTheLibrarysDefaults) {
  EXPECT_EQ(kind_of<BallJoint>(R"("type": "ball")"), BallJoint{});
  EXPECT_EQ(kind_of<WheelJoint>(R"("type": "wheel")"), WheelJoint{});
  EXPECT_EQ(kind_of<MotorJoint>(R"("type": "motor")"), MotorJoint{});
  const WheelJoint wheel = kind_of<WheelJoint>(R"("type": "wheel", "suspension": {"lower": -0.1})");
  EXPECT_EQ(wheel.suspension.lower, -0.1f);
  EXPECT_EQ(wheel.suspension.hertz, WheelJoint{}.suspension.hertz);
  EXPECT_EQ(parse(with_joint(R"("type": "ball")")).joints[0].def, JointDef{});
}

TEST(SceneFileJoints, AnglesAreInDegreesAndLengthsInMeters) {
  const HingeJoint hinge = kind_of<HingeJoint>(
      R"("type": "hinge", "angle": {"lower": -30, "upper": 180, "target": 10, "speed": 3, "drive": "spring"})");
  EXPECT_FLOAT_EQ(hinge.angle.lower, -30.0f * kDegree);
  EXPECT_FLOAT_EQ(hinge.angle.upper, 180.0f * kDegree);
  EXPECT_FLOAT_EQ(hinge.angle.target, 10.0f * kDegree);
  EXPECT_EQ(hinge.angle.speed, 3.0f);
  EXPECT_EQ(hinge.angle.drive, Drive::spring);
  const SliderJoint slider =
      kind_of<SliderJoint>(R"("type": "slider", "offset": {"lower": -30, "upper": 180, "max_force": 7})");
  EXPECT_EQ(slider.offset.lower, -30.0f);
  EXPECT_EQ(slider.offset.upper, 180.0f);
  EXPECT_EQ(slider.offset.max_force, 7.0f);
}

TEST(SceneFileJoints, BodiesAreNamedByNumberByNameOrByPlaceInARun) {
  const Scene scene = parse(with_joints(R"({"type": "ball", "body_a": 3, "body_b": "turned"},
    {"type": "ball", "body_a": ["bead", 2], "body_b": "bead"},
    {"type": "ball", "body_a": "world", "body_b": 1}, {"type": "ball", "body_a": 1})"));
  const auto ends = [&](std::size_t joint) {
    return std::pair{scene.joints.at(joint).body_a, scene.joints.at(joint).body_b};
  };
  EXPECT_EQ(ends(0), (std::pair{3u, 4u}));
  EXPECT_EQ(ends(1), (std::pair{2u, 0u}));
  EXPECT_EQ(ends(2), (std::pair{kWorldItself, 1u}));
  EXPECT_EQ(ends(3), (std::pair{1u, kWorldItself}));
}

TEST(SceneFileJoints, AFrameInTheWorldIsSeenFromBothBodies) {
  const Scene scene = parse(with_joints(
      R"({"type": "ball", "body_a": "bead", "body_b": "turned", "frame": {"position": [2, 5, 0]}})"));
  const JointDef& def = scene.joints.at(0).def;
  EXPECT_EQ(def.frame_a.position, (Vec3{2, 5, 0}));
  // Two meters along x of the world are two along -y of a body that has turned by a quarter about z.
  EXPECT_NEAR(def.frame_b.position.x, 0.0f, 1e-6f);
  EXPECT_NEAR(def.frame_b.position.y, -2.0f, 1e-6f);
  EXPECT_NEAR(def.frame_b.rotation.z, -std::sqrt(0.5f), 1e-6f);
}

TEST(SceneFileJoints, RepeatsGoOnFromBodyToBody) {
  const Scene scene = parse(with_joints(R"({"type": "ball", "body_a": 0, "body_b": 1,
    "frame": {"position": [0.5, 0, 0]}, "repeat": {"count": 3, "spacing": [1, 0, 0]}},
    {"type": "ball", "body_b": 0, "repeat": {"count": 2, "step": [5, 3]}})"));
  ASSERT_EQ(scene.joints.size(), 5u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.joints[i].body_a, i);
    EXPECT_EQ(scene.joints[i].body_b, i + 1);
    EXPECT_EQ(scene.joints[i].def.frame_a.position, (Vec3{0.5f, 0, 0}));
    EXPECT_EQ(scene.joints[i].def.frame_b.position, (Vec3{-0.5f, 0, 0}));
  }
  EXPECT_EQ(scene.joints[4].body_a, kWorldItself);
  EXPECT_EQ(scene.joints[4].body_b, 3u);
}

std::string names_of_kinds() {
#define SCREE_JOINT_TYPE(kind, Struct) ", " #kind
  const std::string names = SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE);
#undef SCREE_JOINT_TYPE
  return names.substr(2);
}

TEST(SceneFileJoints, EveryMistakeIsReportedWithItsPlaceAndReason) {
  const auto ball = [](const std::string& members) { return with_joint(R"("type": "ball", )" + members); };
  const auto bare = [](const std::string& members) {
    return with_joints(R"({"type": "ball", )" + members + "}");
  };
  const std::pair<std::string, std::string> mistakes[] = {
      {R"({"bodies": [], "joints": {}})", "/joints: expected an array, found an object"},
      {with_joint("\"hertz\": 1"), "/joints/0: the key \"type\" is missing"},
      {with_joint(R"("type": "rope")"), "/joints/0/type: \"rope\" is none of: " + names_of_kinds()},
      {bare(R"("body_a": 5)"), "/joints/0/body_a: 5 must be a whole number from 0 to 4"},
      {bare(R"("body_a": "cup")"), "/joints/0/body_a: no body \"cup\"; defined are: bead, turned"},
      {bare(R"("body_a": ["bead", 4])"), "/joints/0/body_a/1: 4 must be a whole number from 0 to 3"},
      {bare(R"("body_a": 1, "body_b": 1)"), "/joints/0: body_a and body_b are both body 1"},
      {R"({"bodies": [], "joints": [{"type": "ball", "body_a": 0}]})",
       "/joints/0/body_a: there are no bodies"},
      {ball(R"("cone_limit": 181)"), "/joints/0/cone_limit: 181 must be from 0 to 180"},
      {ball(R"("hertz": 1e-4)"), "/joints/0/hertz: 0.0001 must be from 0.001 to 10000"},
      {ball(R"("break_force": 0)"), "/joints/0/break_force: must be above 0"},
      {ball(R"("event_force": -1)"), "/joints/0/event_force: -1 must be at least 0"},
      {ball(R"("drive": {"max_torque": -1})"), "/joints/0/drive/max_torque: -1 must be at least 0"},
      {ball(R"("drive": {"drive": "engine"})"),
       "/joints/0/drive/drive: \"engine\" is none of: none, motor, spring"},
      {ball(R"("frame_a": {"position": [0, 2e5, 0]})"),
       "/joints/0/frame_a/position/1: 200000 must be from -100000 to 100000"},
      {ball(R"("frame": {}, "frame_b": {})"), "/joints/0/frame_b: \"frame\" says both frames already"},
      {ball(R"("frame": {"position": [1e6, 0, 0]})"),
       "/joints/0: the joint lies too far from its bodies or the origin"},
      {ball(R"("repeat": {"count": 5})"), "/joints/0: a repeat joins body 5, the last one is 4"},
      {ball(R"("repeat": {"count": 2, "step": [-1, 0]})"),
       "/joints/0: a repeat joins body -1, the last one is 4"},
      {ball(R"("repeat": {"count": 2, "step": [1, 0]})"), "/joints/0: body_a and body_b are both body 1"},
      {ball(R"("repeat": {"count": 2, "spacing": [1, 0, 0]})"),
       "/joints/0/repeat/spacing: moves \"frame\", which is missing"},
      {with_joint(R"("type": "hinge", "angle": {"lower": 20, "upper": 10})"),
       "/joints/0/angle: lower must be at most upper"},
      {with_joint(R"("type": "hinge", "cone_limit": 20)"),
       "/joints/0/cone_limit: unknown key; known here: type, body_a, body_b, frame, frame_a, frame_b, "
       "collide_connected, enabled, hertz, damping_ratio, break_force, break_torque, event_force, "
       "event_torque, user_data, angle, repeat"},
      {with_joint(R"("type": "wheel", "steering": {"upper": 91})"),
       "/joints/0/steering/upper: 91 must be from -90 to 90"},
      {with_joint(R"("type": "distance", "length": {"lower": -1})"),
       "/joints/0/length/lower: -1 must be from 0 to 1000000"},
      {with_joint(R"("type": "pulley", "ratio": 0)"), "/joints/0/ratio: 0 must be from 0.001 to 1000"},
      {R"({"bodies": [{"name": "world"}]})", "/bodies/0/name: \"world\" is the world itself"},
      {R"({"bodies": [{"name": "a"}, {"name": "a"}]})", "/bodies/1/name: two bodies have this name"},
  };
  for (const auto& [text, message] : mistakes) EXPECT_EQ(error_of(text), "scene.json: " + message) << text;
}

TEST(SceneFileJoints, WhatOnlyAWorldCanTellIsReportedWithItsPlace) {
  const std::string mistakes[] = {
      with_joints(R"({"type": "ball"})"),           // between the world and itself
      with_joint(R"("type": "gear", "ratio": 0)"),  // too small in size
      with_joint(R"("type": "ball", "twist_lower": 5, "twist_upper": 1)"),
      with_joint(R"("type": "wheel", "spin": {"lower": 0})"),  // a spin has no limits
      with_joint(R"("type": "mouse", "pull": {})"),            // of a body that is not the world
  };
  for (const std::string& text : mistakes) {
    EXPECT_EQ(error_of(text).rfind("scene.json: /joints/0: World::create_joint", 0), 0u) << text << "\n"
                                                                                         << error_of(text);
  }
}

TEST(SceneFileJoints, NoFileHasMoreOfThemThanBodies) {
  const std::string many = with_joint(R"("type": "ball", "repeat": {"count": 30, "step": [0, 0]})");
  EXPECT_EQ(parse_scene(many, "scene.json", 30).joints.size(), 30u);
  try {
    parse_scene(with_joints(R"({"type": "ball", "body_a": 0, "body_b": 1},
      {"type": "ball", "body_a": 0, "body_b": 1, "repeat": {"count": 30, "step": [0, 0]}})"),
                "scene.json", 30);
    FAIL() << "31 joints";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "scene.json: /joints/1: with this joint the scene has more than 30 joints");
  }
}

}  // namespace
}  // namespace scree::scenes
