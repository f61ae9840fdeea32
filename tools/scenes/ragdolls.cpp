// Humans of capsules, dropped into a pit.
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace scree::scenes {
namespace {

constexpr Vec3 kRight{1.0f, 0.0f, 0.0f};
constexpr Vec3 kUp{0.0f, 1.0f, 0.0f};
constexpr Vec3 kDown{0.0f, -1.0f, 0.0f};
constexpr Vec3 kFront{0.0f, 0.0f, 1.0f};

// A human of 1.77 m and about 70 kg who stands upright with hanging arms and looks along z. The origin lies
// between the feet.
struct Bone {
  Vec3 center;  // m
  Vec3 direction;
  float half_height;  // m, of the capsule's inner segment
  float radius;       // m
};
enum : std::size_t {
  kPelvis,
  kBelly,
  kChest,
  kHead,
  kUpperArm,  // the right one; the left one follows each
  kForearm = 6,
  kThigh = 8,
  kShin = 10,
  kFoot = 12,
  kBones = 14,
};
constexpr std::array<Bone, kBones> kSkeleton = {{
    {{0.0f, 0.95f, 0.0f}, kRight, 0.07f, 0.11f},
    {{0.0f, 1.11f, 0.0f}, kRight, 0.06f, 0.11f},
    {{0.0f, 1.31f, 0.0f}, kRight, 0.09f, 0.13f},
    {{0.0f, 1.63f, 0.0f}, kUp, 0.04f, 0.10f},
    {{0.25f, 1.26f, 0.0f}, kUp, 0.095f, 0.045f},
    {{-0.25f, 1.26f, 0.0f}, kUp, 0.095f, 0.045f},
    {{0.25f, 0.98f, 0.0f}, kUp, 0.10f, 0.04f},
    {{-0.25f, 0.98f, 0.0f}, kUp, 0.10f, 0.04f},
    {{0.09f, 0.70f, 0.0f}, kUp, 0.13f, 0.07f},
    {{-0.09f, 0.70f, 0.0f}, kUp, 0.13f, 0.07f},
    {{0.09f, 0.29f, 0.0f}, kUp, 0.16f, 0.05f},
    {{-0.09f, 0.29f, 0.0f}, kUp, 0.16f, 0.05f},
    {{0.09f, 0.05f, 0.05f}, kFront, 0.07f, 0.045f},
    {{-0.09f, 0.05f, 0.05f}, kFront, 0.07f, 0.045f},
}};
constexpr Vec3 kMiddle{0.0f, 0.885f, 0.0f};
constexpr float kRagdollReach = 0.91f;  // m, from there to the farthest point

Pose pose_of(const Bone& bone) { return {bone.center, turn_between(kUp, bone.direction)}; }

// Muscles at rest: dry friction.
constexpr float kTrunkFriction = 4.0f;  // N m
constexpr float kLimbFriction = 2.0f;   // N m

struct Link {
  std::uint32_t a, b;  // bones
  JointDef def;        // frames in them
  Joint joint;
};

// A ball whose cone opens about a direction; `bone` is where b's axis points at first.
Link ball(std::size_t a, std::size_t b, Vec3 at, Vec3 cone, Vec3 bone, double degrees, double twist,
          float friction) {
  BallJoint joint{
      .cone_limit = radians(degrees), .twist_lower = radians(-twist), .twist_upper = radians(twist)};
  joint.drive = {.drive = Drive::motor, .max_torque = friction};
  // From one axis to the other by the shortest turn: at first there is no twist.
  const Quat cone_frame = along(cone);
  const Quat bone_frame = turned(turn_between(cone, bone), cone_frame);
  Link link{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), {}, joint};
  link.def.frame_a = seen_from(pose_of(kSkeleton[a]), {at, cone_frame});
  link.def.frame_b = seen_from(pose_of(kSkeleton[b]), {at, bone_frame});
  return link;
}

// A hinge about the axis from left to right.
Link hinge(std::size_t a, std::size_t b, Vec3 at, double lower, double upper) {
  HingeJoint joint;
  joint.angle = {
      .lower = radians(lower), .upper = radians(upper), .drive = Drive::motor, .max_force = kLimbFriction};
  Link link{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), {}, joint};
  link.def.frame_a = seen_from(pose_of(kSkeleton[a]), {at, {}});
  link.def.frame_b = seen_from(pose_of(kSkeleton[b]), {at, {}});
  return link;
}

std::vector<Link> make_links() {
  std::vector<Link> links;
  links.push_back(ball(kPelvis, kBelly, {0.0f, 1.03f, 0.0f}, kUp, kUp, 25.0, 15.0, kTrunkFriction));
  links.push_back(ball(kBelly, kChest, {0.0f, 1.20f, 0.0f}, kUp, kUp, 25.0, 20.0, kTrunkFriction));
  links.push_back(ball(kChest, kHead, {0.0f, 1.47f, 0.0f}, kUp, kUp, 40.0, 50.0, kTrunkFriction));
  for (const std::size_t left : {std::size_t{0}, std::size_t{1}}) {
    const float side = left == 0 ? 1.0f : -1.0f;
    // Arms go up, out and to the front, legs mostly to the front.
    links.push_back(ball(kChest, kUpperArm + left, {side * 0.24f, 1.39f, 0.0f}, {side * 0.7f, -0.6f, 0.4f},
                         kDown, 85.0, 60.0, kLimbFriction));
    links.push_back(hinge(kUpperArm + left, kForearm + left, {side * 0.25f, 1.12f, 0.0f}, -140.0, 2.0));
    links.push_back(ball(kPelvis, kThigh + left, {side * 0.09f, 0.89f, 0.0f}, {side * 0.15f, -0.8f, 0.6f},
                         kDown, 60.0, 30.0, kLimbFriction));
    links.push_back(hinge(kThigh + left, kShin + left, {side * 0.09f, 0.49f, 0.0f}, -2.0, 140.0));
    links.push_back(hinge(kShin + left, kFoot + left, {side * 0.09f, 0.09f, 0.0f}, -40.0, 30.0));
  }
  return links;
}

void add_human(Scene& scene, const Pose& middle, const std::vector<Link>& links, std::uint32_t first_shape) {
  const auto first = static_cast<std::uint32_t>(scene.bodies.size());
  for (std::size_t i = 0; i < kBones; ++i) {
    Pose local = pose_of(kSkeleton[i]);
    local.position.y -= kMiddle.y;
    const Pose pose = placed(middle, local);
    BodyDef def;
    def.position = pose.position;
    def.rotation = pose.rotation;
    // Left limbs share the shapes of right ones.
    const std::size_t shape = i < kUpperArm ? i : i - i % 2;
    add_body(scene, def, first_shape + static_cast<std::uint32_t>(shape));
  }
  for (const Link& link : links) add_joint(scene, first + link.a, first + link.b, link.joint, link.def);
}

std::uint32_t add_bones(Scene& scene) {
  const auto first = static_cast<std::uint32_t>(scene.shapes.size());
  for (const Bone& bone : kSkeleton)
    add_shape(scene, Capsule{.half_height = bone.half_height, .radius = bone.radius});
  return first;
}

}  // namespace

Scene ragdolls(const Parameters& parameters) {
  constexpr float kCell = 2.0f * kRagdollReach;  // m: they touch in no orientation
  constexpr int kLayers = 8;
  const int count = whole(parameters, "ragdolls");
  int side = 1;
  while (std::int64_t{side} * side * kLayers < count) ++side;
  const int layers = (count + side * side - 1) / (side * side);
  Scene scene = start_scene("ragdolls", 400);
  scene.bodies.reserve(1 + kBones * static_cast<std::size_t>(count));
  add_pit(scene, 0.5f * kCell * static_cast<float>(side), kCell * static_cast<float>(layers + 1));
  const std::uint32_t first_shape = add_bones(scene);
  const std::vector<Link> links = make_links();
  scene.joints.reserve(links.size() * static_cast<std::size_t>(count));
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const float corner = -0.5f * kCell * static_cast<float>(side);
  const auto place = [&](int cell) { return kCell * (static_cast<float>(cell) + 0.5f); };
  for (int i = 0; i < count; ++i) {
    const Vec3 middle{corner + place(i % side), place(i / (side * side)), corner + place(i / side % side)};
    add_human(scene, {middle, random.rotation()}, links, first_shape);
  }
  return scene;
}

Scene ragdoll_rain(const Parameters& parameters) {
  constexpr float kCell = 2.0f * kRagdollReach;
  constexpr int kLayers = 4;
  const int count = whole(parameters, "ragdolls");
  int side = 1;
  while (std::int64_t{side} * side * kLayers < count) ++side;
  Scene scene = start_scene("ragdoll_rain", 600);
  add_hills(scene, whole(parameters, "triangles"), std::max(10.0f, 1.4f * kCell * static_cast<float>(side)));
  const std::uint32_t first_shape = add_bones(scene);
  const std::vector<Link> links = make_links();
  Random random(static_cast<std::uint64_t>(parameters.at("seed")));
  const float corner = -0.5f * kCell * static_cast<float>(side - 1);
  const auto place = [&](int cell) { return kCell * static_cast<float>(cell); };
  for (int i = 0; i < count; ++i) {
    const Vec3 middle{corner + place(i % side), 5.0f + place(i / (side * side)),
                      corner + place(i / side % side)};
    add_human(scene, {middle, random.rotation()}, links, first_shape);
  }
  return scene;
}

}  // namespace scree::scenes
