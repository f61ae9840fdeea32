// The player's joint calls, and its record of joints; see player.h.
#include <core/constraints/joint_parameters.h>
#include <tests/determinism/player.h>

#include <cmath>
#include <limits>

namespace scree::determinism {
namespace {

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

bool is_finite_vector(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

JointId Player::some_joint(std::uint32_t which) const {
  if (model_.joints.empty()) return {};
  return std::next(model_.joints.begin(), static_cast<std::ptrdiff_t>(which % model_.joints.size()))->first;
}

// A joint between the body of the call's slot and another body or the world. Without bodies, no call is made.
std::pair<JointDef, Joint> Player::random_joining(Random& random, const Call& call) {
  const auto type = static_cast<JointType>(random.below(kJointTypeCount));
  const Joint joint = random_joint(random, type);
  const bool with_world = type == JointType::mouse || random.below(4) == 0;
  const bool turned = random.below(2) == 0 && type != JointType::mouse;
  const Slot* first = model_.slots.empty() ? nullptr : occupied(call.slot);
  const Slot* second = first == nullptr ? nullptr : occupied(random.below(kBulkSlots));
  BodyId a = kWorld, b = kWorld;
  if (first != nullptr) b = first->body;
  if (second != nullptr && second != first && !with_world) a = second->body;
  if (turned) std::swap(a, b);
  const auto pose = [this](BodyId body) { return body == kWorld ? Pose{} : world_.pose(body); };
  JointDef def = random_joint_def(random, pose(a), pose(b));
  def.body_a = a;
  def.body_b = b;
  return {def, joint};
}

void Player::keep_joint(JointId joint, const JointDef& def) {
  model_.joints[joint] = {def.body_a, def.body_b, def.enabled};
}

void Player::create_joint(const Call& call) {
  Random random(call.seed);
  const auto [def, joint] = random_joining(random, call);
  if (def.body_a == def.body_b) return;
  tell("create_joint", def, joint);
  keep_joint(world_.create_joint(def, joint), def);
}

void Player::create_joints(const Call& call) {
  Random random(call.seed);
  std::vector<JointDef> defs;
  std::vector<Joint> joints;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto [def, joint] = random_joining(random, {call.kind, call.slot + i, call.seed});
    if (def.body_a == def.body_b) return;
    defs.push_back(def);
    joints.push_back(joint);
  }
  tell("create_joints", defs[0], joints[0], defs[1], joints[1], defs[2], joints[2], defs[3], joints[3]);
  std::vector<JointId> ids(defs.size());
  world_.create_joints(defs, joints, ids);
  for (std::size_t i = 0; i < ids.size(); ++i) keep_joint(ids[i], defs[i]);
}

void Player::destroy_joint(const Call& call) {
  const JointId joint = some_joint(call.slot);
  if (joint == JointId{}) return;
  tell("destroy_joint", joint);
  world_.destroy_joint(joint);
  model_.joints.erase(joint);
  if (world_.is_alive(joint)) fail("a destroyed joint lives on");
}

void Player::set_joint(const Call& call) {
  Random random(call.seed);
  const JointId joint = some_joint(call.slot);
  if (joint == JointId{}) return;
  const Joint to = random_joint(random, world_.joint_type(joint));
  tell("set_joint", joint, to);
  world_.set_joint(joint, to);
}

void Player::change_joint(const Call& call) {
  Random random(call.seed);
  const JointId joint = some_joint(call.slot);
  if (joint == JointId{}) return;
  if (world_.joint_type(joint) == JointType::user && random.below(2) == 0) {
    return change_user_rows(joint, random);
  }
  switch (random.below(7)) {
    case 0: {
      const Pose a{random_vector(random, 0.5f), random.rotation()}, b{random_vector(random, 0.5f), {}};
      tell("set_joint_frames", joint, a, b);
      return world_.set_joint_frames(joint, a, b);
    }
    case 1: {
      const float hertz = random.below(2) == 0 ? 0.0f : random.between(0.5f, 60.0f), ratio = random.unit();
      tell("set_joint_stiffness", joint, hertz, ratio);
      return world_.set_joint_stiffness(joint, hertz, ratio);
    }
    case 2: {
      const float force = random.between(1.0f, 20000.0f), torque = random.between(1.0f, 20000.0f);
      tell("set_joint_strength", joint, force, torque);
      return world_.set_joint_strength(joint, force, torque);
    }
    case 3: {
      const bool enabled = random.below(2) == 0;
      tell("set_joint_enabled", joint, enabled);
      model_.joints[joint].enabled = enabled;
      return world_.set_joint_enabled(joint, enabled);
    }
    case 4: {
      const bool collide = random.below(2) == 0;
      tell("set_collide_connected", joint, collide);
      return world_.set_collide_connected(joint, collide);
    }
    case 5: {
      const float force = random.between(0.0f, 20000.0f), torque = random.between(0.0f, 20000.0f);
      tell("set_joint_event_thresholds", joint, force, torque);
      return world_.set_joint_event_thresholds(joint, force, torque);
    }
    default: {
      const std::uint64_t data = random.next();
      tell("set_user_data", joint, static_cast<std::uint32_t>(data));
      world_.set_user_data(joint, data);
      if (world_.user_data(joint) != data) fail("a joint forgets its user data");
      return;
    }
  }
}

// Numbers for the rows of a user joint; as those of a callback some are unsound.
void Player::change_user_rows(JointId joint, Random& random) {
  std::vector<UserRow> rows(world_.user_rows(joint, {}));
  for (UserRow& row : rows) row = random_user_row(random);
  tell("set_user_rows", joint, rows[0].target.error);
  if (random.below(2) == 0) return world_.set_user_rows(joint, rows);
  const bool sound = random.below(4) != 0;
  if (!sound) rows.back().target.error = kNoNumber;
  world_.refresh_user_rows({&joint, 1}, rows);
  if (world_.is_frozen(joint) == sound)
    fail("a user joint acts with unsound numbers, or not with sound ones");
}

void Player::make_wrong_call_of_joints(std::uint32_t which, BodyId body) {
  const JointId joint = some_joint(which);
  switch (which) {
    case 0:
      world_.create_joint({.body_a = body, .body_b = body}, HingeJoint{});
      return;
    case 1:
      world_.create_joint({.body_a = kWorld, .body_b = body, .frame_b = {{0.0f, kNoNumber, 0.0f}, {}}},
                          BallJoint{});
      return;
    case 2: {
      JointId ids[2];
      const JointDef defs[2] = {{.body_a = kWorld, .body_b = body}, {.body_a = kWorld, .body_b = body}};
      const Joint joints[2] = {WeldJoint{}, GearJoint{0.0f}};
      world_.create_joints(defs, joints, ids);
      return;
    }
    case 3:
      world_.set_joint(joint, SliderJoint{{.lower = 1.0f, .upper = -1.0f}});
      return;
    case 4:
      world_.set_joint_stiffness(joint, kNoNumber, 1.0f);
      return;
    case 5:
      world_.set_joint_frames(joint, {{}, {0.0f, 0.0f, 0.0f, 0.5f}}, {});
      return;
    case 6:
      world_.set_joint_event_thresholds(joint, 1.0f, -1.0f);
      return;
    default:
      world_.destroy_joint({joint.index, joint.generation + 1});
      return;
  }
}

// Call before the body is destroyed.
void Player::lose_joints(BodyId body) {
  std::erase_if(model_.joints, [&](const auto& entry) {
    const bool goes = entry.second.a == body || entry.second.b == body;
    if (goes) model_.lost.insert(entry.first);
    return goes;
  });
}

void Player::check_lost_joints() {
  const std::span<const JointId> told = world_.destroyed_joints();
  if (std::set<JointId>(told.begin(), told.end()) != model_.lost || told.size() != model_.lost.size()) {
    fail("the joints that went with their bodies are not those that are told of");
  }
  model_.lost.clear();
  for (const JointId joint : world_.broken_joints()) {
    const auto found = model_.joints.find(joint);
    if (found == model_.joints.end() || !found->second.enabled) fail("a joint breaks that did not hold");
    found->second.enabled = false;
  }
}

void Player::check_joint_events() {
  for (const JointEvent& event : world_.joint_events()) {
    const auto found = model_.joints.find(event.joint);
    if (found == model_.joints.end()) fail("a joint that is not there bears too much");
    const JointDef def = world_.joint_def(event.joint);
    if (!(event.force > def.event_force || event.torque > def.event_torque))
      fail("a joint is told of that bears what it may");
    if (!std::isfinite(event.force) || !std::isfinite(event.torque)) fail("what a joint bears is not finite");
  }
  joint_events_ += world_.joint_events().size();
}

void Player::check_joints() {
  check_joint_events();
  if (world_.joint_count() != model_.joints.size()) fail("joint_count is wrong");
  std::map<BodyId, std::size_t> counts;
  for (const auto& [joint, joined] : model_.joints) {
    const std::string name = "joint " + std::to_string(joint.index);
    if (!world_.is_alive(joint)) fail(name + ": the handle died");
    const JointDef def = world_.joint_def(joint);
    if (def.body_a != joined.a || def.body_b != joined.b) fail(name + " has changed its bodies");
    if (def.enabled != joined.enabled) fail(name + " was enabled or disabled without a call");
    const Pose pose = world_.joint_pose(joint);
    if (!is_finite_vector(pose.position) || !std::isfinite(pose.rotation.w))
      fail(name + ": its pose is not finite");
    const JointReaction reaction = world_.joint_reaction(joint);
    if (!is_finite_vector(reaction.force) || !is_finite_vector(reaction.torque))
      fail(name + ": its reaction is not finite");
    for (const BodyId body : {joined.a, joined.b}) ++counts[body];
  }
  for (const Slot& slot : model_.slots) {
    if (slot.body == BodyId{}) continue;
    if (world_.joints_of(slot.body, {}) != counts[slot.body]) fail("a body has other joints");
  }
}

}  // namespace scree::determinism
