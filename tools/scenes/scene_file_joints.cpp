// The joints of scene files. README.md beside this file states the schema.
#include <tools/scenes/frames.h>
#include <tools/scenes/scene_file_parts.h>

#include <array>
#include <cmath>
#include <optional>

namespace scree::scenes {
namespace {

const Range kValue = within(kMaxJointValue);  // m, m/s, rad/s
const Range kAngle{-180.0, 180.0};            // degrees
const Range kSteering{-90.0, 90.0};           // degrees
const Range kHertz = between(kMinHertz, kMaxHertz);
const Range kStrength{0.0};  // N, N m

void read_angle(Members& members, const char* key, float& out, Range degrees) {
  if (const Node* node = members.find(key)) out = radians(node->precise_number(degrees));
}

void read_drive(Members& members, Drive& out) {
  constexpr const char* kDrives[] = {"none", "motor", "spring"};
  if (const Node* node = members.find("drive")) out = static_cast<Drive>(node->choice(kDrives));
}

void read_spring(Members& members, float& hertz, float& damping_ratio) {
  members.read("hertz", hertz, kHertz);
  members.read("damping_ratio", damping_ratio, up_to(kMaxDampingRatio));
}

// Stiffness of held axes: 0 is as stiff as the step allows.
void read_stiffness(Members& members, const char* hertz_key, float& hertz, const char* ratio_key,
                    float& ratio) {
  if (const Node* node = members.find(hertz_key)) {
    hertz = node->number();
    if (hertz != 0.0f) hertz = node->number(kHertz);
  }
  members.read(ratio_key, ratio, up_to(kMaxDampingRatio));
}

enum class Unit { meters, degrees };

void read_axis(Members& joint, const char* key, JointAxis& axis, Unit unit, Range limits) {
  const Node* node = joint.find(key);
  if (node == nullptr) return;
  Members members(*node);
  if (unit == Unit::degrees) {
    read_angle(members, "lower", axis.lower, limits);
    read_angle(members, "upper", axis.upper, limits);
    read_angle(members, "target", axis.target, {-1e7, 1e7});
  } else {
    members.read("lower", axis.lower, limits);
    members.read("upper", axis.upper, limits);
    members.read("target", axis.target, limits);
  }
  if (!(axis.lower <= axis.upper)) node->fail("lower must be at most upper");
  read_drive(members, axis.drive);
  members.read("speed", axis.speed, kValue);
  read_spring(members, axis.hertz, axis.damping_ratio);
  members.read("max_force", axis.max_force, kStrength);
  members.finish();
}
void read_offset(Members& joint, const char* key, JointAxis& axis) {
  read_axis(joint, key, axis, Unit::meters, kValue);
}
void read_turn(Members& joint, const char* key, JointAxis& axis, Range limits = kAngle) {
  read_axis(joint, key, axis, Unit::degrees, limits);
}

void read_rotation_drive(Members& joint, const char* key, RotationDrive& drive) {
  const Node* node = joint.find(key);
  if (node == nullptr) return;
  Members members(*node);
  read_drive(members, drive.drive);
  if (const Node* target = members.find("target")) drive.target = read_rotation(*target);
  members.read("velocity", drive.velocity, kValue);
  read_spring(members, drive.hertz, drive.damping_ratio);
  members.read("max_torque", drive.max_torque, kStrength);
  members.finish();
}

// The kinds of joints, each built from its own keys.
void read_kind(Members& members, BallJoint& ball) {
  read_angle(members, "cone_limit", ball.cone_limit, {0.0, 180.0});
  read_angle(members, "twist_lower", ball.twist_lower, kAngle);
  read_angle(members, "twist_upper", ball.twist_upper, kAngle);
  read_rotation_drive(members, "drive", ball.drive);
}
void read_kind(Members& members, HingeJoint& hinge) { read_turn(members, "angle", hinge.angle); }
void read_kind(Members& members, SliderJoint& slider) { read_offset(members, "offset", slider.offset); }
void read_kind(Members& members, DistanceJoint& distance) {
  read_axis(members, "length", distance.length, Unit::meters, up_to(kMaxJointValue));
}
void read_kind(Members& members, WeldJoint& weld) {
  read_stiffness(members, "angular_hertz", weld.angular_hertz, "angular_damping_ratio",
                 weld.angular_damping_ratio);
}
void read_kind(Members& members, SixDegreeJoint& joint) {
  constexpr const char* kOffsets[] = {"offset_x", "offset_y", "offset_z"};
  constexpr const char* kAngles[] = {"angle_x", "angle_y", "angle_z"};
  for (int i = 0; i < 3; ++i) {
    read_offset(members, kOffsets[i], joint.offset[i]);
    read_turn(members, kAngles[i], joint.angle[i]);
  }
}
void read_kind(Members& members, WheelJoint& wheel) {
  read_offset(members, "suspension", wheel.suspension);
  read_turn(members, "steering", wheel.steering, kSteering);
  read_turn(members, "spin", wheel.spin);
}
void read_kind(Members& members, UniversalJoint& universal) {
  read_turn(members, "first", universal.first);
  read_turn(members, "second", universal.second);
}
void read_kind(Members& members, PlanarJoint& planar) {
  read_offset(members, "offset_y", planar.offset_y);
  read_offset(members, "offset_z", planar.offset_z);
  read_turn(members, "angle", planar.angle);
}
void read_kind(Members& members, GearJoint& gear) { members.read("ratio", gear.ratio, within(kMaxRatio)); }
void read_kind(Members& members, RackAndPinionJoint& rack) {
  members.read("radius", rack.radius, within(kMaxRatio));
}
void read_kind(Members& members, PulleyJoint& pulley) {
  members.read("point_a", pulley.point_a, within(kMaxPosition));
  members.read("point_b", pulley.point_b, within(kMaxPosition));
  members.read("ratio", pulley.ratio, between(kMinRatio, kMaxRatio));
  members.read("length", pulley.length, up_to(kMaxRope));
  members.read("rigid", pulley.rigid);
}
void read_kind(Members& members, MotorJoint& motor) {
  read_rotation_drive(members, "rotation", motor.rotation);
  const Node* node = members.find("offset");
  if (node == nullptr) return;
  Members offset(*node);
  read_drive(offset, motor.drive);
  offset.read("target", motor.target, kValue);
  offset.read("velocity", motor.velocity, kValue);
  read_spring(offset, motor.hertz, motor.damping_ratio);
  offset.read("max_force", motor.max_force, kStrength);
  offset.finish();
}
void read_kind(Members& members, MouseJoint& mouse) {
  const Node& node = members.require("pull");
  Members pull(node);
  pull.read("target", mouse.target, within(kMaxPosition));
  read_spring(pull, mouse.hertz, mouse.damping_ratio);
  pull.read("max_force", mouse.max_force, kStrength);
  pull.finish();
}

// A row of a user joint, with constant numbers.
void read_row(const Node& node, RowKind& kind, UserRow& row) {
  constexpr const char* kRows[] = {"held", "limit", "motor", "spring"};
  Members members(node);
  kind = static_cast<RowKind>(1 + members.require("kind").choice(kRows));
  members.read("linear_a", row.jacobian.linear_a, kValue);
  members.read("angular_a", row.jacobian.angular_a, kValue);
  members.read("linear_b", row.jacobian.linear_b, kValue);
  members.read("angular_b", row.jacobian.angular_b, kValue);
  members.read("error", row.target.error, kValue);
  members.read("speed", row.target.speed, kValue);
  read_spring(members, row.target.hertz, row.target.damping_ratio);
  members.read("lower", row.bounds.lower);
  members.read("upper", row.bounds.upper);
  if (!(row.bounds.lower <= row.bounds.upper)) node.fail("lower must be at most upper");
  members.finish();
}
void read_user(Members& members, UserJoint& user, std::vector<UserRow>& rows) {
  const Node& node = members.require("rows");
  const std::vector<Node> given = node.elements();
  if (given.empty() || given.size() > kMaxUserRows) node.fail("must have 1 to 6 rows");
  rows.resize(given.size());
  for (std::size_t i = 0; i < given.size(); ++i) read_row(given[i], user.rows[i], rows[i]);
}

// The alternative of Joint that has this place in it.
template <std::size_t kIndex = 0>
Joint joint_of_kind(std::size_t kind) {
  if constexpr (kIndex + 1 < std::variant_size_v<Joint>) {
    if (kind != kIndex) return joint_of_kind<kIndex + 1>(kind);
  }
  return std::variant_alternative_t<kIndex, Joint>{};
}

// JointType's names in its order.
#define SCREE_JOINT_TYPE(kind, Struct) #kind,
constexpr std::array<const char*, kJointTypeCount> kKinds = {SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)};
#undef SCREE_JOINT_TYPE

// A body's place in Scene::bodies: its number, its name, or the name of a run and the place in it.
std::uint32_t read_end(const Node& node, const BodyNames& names, std::size_t bodies) {
  if (node.is_array()) {
    const std::vector<Node> parts = node.elements(2, "parts, a body's name and a number");
    const auto found = names.find(parts[0].string());
    if (found == names.end()) parts[0].fail("no body \"" + parts[0].string() + "\"; " + known_names(names));
    return found->second.first + static_cast<std::uint32_t>(parts[1].integer(0, found->second.count - 1));
  }
  if (node.is_string()) {
    const std::string name = node.string();
    if (name == kWorldName) return kWorldItself;
    const auto found = names.find(name);
    if (found == names.end()) node.fail("no body \"" + name + "\"; " + known_names(names));
    return found->second.first;
  }
  if (bodies == 0) node.fail("there are no bodies");
  return static_cast<std::uint32_t>(node.integer(0, static_cast<std::int64_t>(bodies) - 1));
}

Pose read_pose(const Node& node, float reach) {
  Pose pose;
  Members members(node);
  members.read("position", pose.position, within(reach));
  read_rotation(members, pose.rotation);
  members.finish();
  return pose;
}

// Repeats the joint: each time its bodies' indices advance by a fixed amount.
struct JointRepeat {
  std::int64_t count = 1;
  std::array<std::int64_t, 2> step{1, 1};
  Vec3 spacing;
};

JointRepeat read_repeat(const Node& node, bool has_place, std::int64_t most) {
  JointRepeat repeat;
  Members members(node);
  repeat.count = members.require("count").integer(1, most);
  if (const Node* step = members.find("step")) {
    const std::vector<Node> steps = step->elements(2, "whole numbers");
    for (std::size_t end = 0; end < 2; ++end) repeat.step[end] = steps[end].integer(-most, most);
  }
  if (const Node* spacing = members.find("spacing")) {
    if (!has_place) spacing->fail("moves \"frame\", which is missing");
    repeat.spacing = spacing->vector(within(kMaxPosition));
  }
  members.finish();
  return repeat;
}

void read_def(Members& members, JointDef& def) {
  members.read("collide_connected", def.collide_connected);
  members.read("enabled", def.enabled);
  read_stiffness(members, "hertz", def.hertz, "damping_ratio", def.damping_ratio);
  const auto read_strength = [&](const char* key, float& out) {
    const Node* node = members.find(key);
    if (node == nullptr) return;
    out = node->number(kStrength);
    if (out == 0.0f) node->fail("must be above 0");
  };
  read_strength("break_force", def.break_force);
  read_strength("break_torque", def.break_torque);
  if (const Node* force = members.find("event_force")) def.event_force = force->number(kStrength);
  if (const Node* torque = members.find("event_torque")) def.event_torque = torque->number(kStrength);
  if (const Node* data = members.find("user_data")) def.user_data = data->bits64();
}

// Some limits can only be checked by a world: one world with two bodies to join.
class JointTrial {
 public:
  JointTrial() : bodies_{world_.create_body({}), world_.create_body({})} {}

  void run(const Node& node, const SceneJoint& joint) {
    JointDef def = joint.def;
    def.body_a = joint.body_a != kWorldItself ? bodies_[0] : kWorld;
    def.body_b = joint.body_b != kWorldItself ? bodies_[1] : kWorld;
    try {
      const JointId made = world_.create_joint(def, joint.joint);
      if (!joint.rows.empty()) world_.set_user_rows(made, joint.rows);
      world_.destroy_joint(made);
    } catch (const Error& error) {
      node.fail(error.what());
    }
  }

 private:
  World world_;
  std::array<BodyId, 2> bodies_;
};

class Reader {
 public:
  Reader(const BodyNames& names, std::int64_t most, Scene& scene)
      : names_(names), most_(most), scene_(scene) {}

  void read(const Node& node) {
    Members members(node);
    SceneJoint joint;
    joint.joint = joint_of_kind(members.require("type").choice(kKinds));
    if (const Node* end = members.find("body_a")) joint.body_a = read_end(*end, names_, bodies());
    if (const Node* end = members.find("body_b")) joint.body_b = read_end(*end, names_, bodies());
    const auto reach = [](std::uint32_t body) {
      return body == kWorldItself ? kMaxPosition : kMaxLocalPosition;
    };
    const Node* place_node = members.find("frame");
    const auto read_frame = [&](const char* key, std::uint32_t body, Pose& frame) {
      const Node* frame_node = members.find(key);
      if (frame_node == nullptr) return;
      if (place_node != nullptr) frame_node->fail("\"frame\" says both frames already");
      frame = read_pose(*frame_node, reach(body));
    };
    read_frame("frame_a", joint.body_a, joint.def.frame_a);
    read_frame("frame_b", joint.body_b, joint.def.frame_b);
    std::optional<Pose> place;
    if (place_node != nullptr) place = read_pose(*place_node, kMaxPosition);
    read_def(members, joint.def);
    std::visit(
        [&](auto& kind) {
          if constexpr (std::is_same_v<std::remove_reference_t<decltype(kind)>, UserJoint>) {
            read_user(members, kind, joint.rows);
          } else {
            read_kind(members, kind);
          }
        },
        joint.joint);
    JointRepeat repeat;
    if (const Node* again = members.find("repeat")) repeat = read_repeat(*again, place.has_value(), most_);
    members.finish();
    trial_.run(node, joint);
    add(node, joint, place, repeat);
  }

 private:
  std::size_t bodies() const { return scene_.bodies.size(); }

  // The body of one end in a repeat.
  std::uint32_t end_at(const Node& node, std::uint32_t first, std::int64_t advance) const {
    if (first == kWorldItself) return first;
    const std::int64_t body = std::int64_t{first} + advance;
    if (body < 0 || body >= static_cast<std::int64_t>(bodies())) {
      node.fail("a repeat joins body " + std::to_string(body) + ", the last one is " +
                std::to_string(bodies() - 1));
    }
    return static_cast<std::uint32_t>(body);
  }

  Pose frame_in(const Node& node, std::uint32_t body, const Pose& place) const {
    Pose frame = place;
    float reach = kMaxPosition;
    if (body != kWorldItself) {
      const BodyDef& def = scene_.bodies[body].def;
      frame = seen_from({def.position, def.rotation}, place);
      reach = kMaxLocalPosition;
    }
    for (const float x : {frame.position.x, frame.position.y, frame.position.z}) {
      if (!(std::abs(x) <= reach)) node.fail("the joint lies too far from its bodies or the origin");
    }
    return frame;
  }

  void add(const Node& node, SceneJoint joint, const std::optional<Pose>& place, const JointRepeat& repeat) {
    const std::size_t total = scene_.joints.size() + static_cast<std::size_t>(repeat.count);
    if (total > static_cast<std::size_t>(most_)) {
      node.fail("with this joint the scene has more than " + std::to_string(most_) + " joints");
    }
    if (total > 2 * scene_.joints.size()) scene_.joints.reserve(total);  // else room comes by itself
    const std::uint32_t first_a = joint.body_a, first_b = joint.body_b;
    for (std::int64_t i = 0; i < repeat.count; ++i) {
      joint.body_a = end_at(node, first_a, i * repeat.step[0]);
      joint.body_b = end_at(node, first_b, i * repeat.step[1]);
      if (joint.body_a == joint.body_b) {
        node.fail("body_a and body_b are both body " + std::to_string(joint.body_a));
      }
      if (place) {
        const auto moved = [i](float start, float by) { return start + static_cast<float>(i) * by; };
        const Vec3 at{moved(place->position.x, repeat.spacing.x), moved(place->position.y, repeat.spacing.y),
                      moved(place->position.z, repeat.spacing.z)};
        joint.def.frame_a = frame_in(node, joint.body_a, {at, place->rotation});
        joint.def.frame_b = frame_in(node, joint.body_b, {at, place->rotation});
      }
      scene_.joints.push_back(joint);
    }
  }

  const BodyNames& names_;
  std::int64_t most_;
  Scene& scene_;
  JointTrial trial_;
};

}  // namespace

void read_joints(const Node& array, const BodyNames& names, std::int64_t most, Scene& scene) {
  Reader reader(names, most, scene);
  for (const Node& joint : array.elements()) reader.read(joint);
}

}  // namespace scree::scenes
