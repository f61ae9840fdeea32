// Scenes of many equal joints in rows: a net, a chain, a bridge, a wrecking ball.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>

#include <cstdint>
#include <numbers>

namespace scree::scenes {
namespace {

// Links are capsules along y that hang from one another by balls half a pitch from their centers.
constexpr float kLinkPitch = 0.5f;  // m
struct LinkKind {
  float radius;   // m
  float density;  // kg/m^3
};

float mass_of(const LinkKind& link) {
  const float disk = std::numbers::pi_v<float> * link.radius * link.radius;
  const float half_height = 0.5f * kLinkPitch - link.radius;
  return link.density * disk * (2.0f * half_height + 4.0f / 3.0f * link.radius);
}

// A chain from a point of the world, that makes an angle with the way down, turned about z towards -x.
// Returns its last link.
std::uint32_t add_chain(Scene& scene, Vec3 from, double degrees, int links, const LinkKind& kind) {
  const std::uint32_t shape =
      add_shape(scene, Capsule{.half_height = 0.5f * kLinkPitch - kind.radius, .radius = kind.radius},
                {.density = kind.density});
  const Pose start{from, rotation_about({0.0f, 0.0f, 1.0f}, -degrees)};
  std::uint32_t above = kWorldItself;
  for (int i = 0; i < links; ++i) {
    const float top = -kLinkPitch * static_cast<float>(i);
    const Pose pose = placed(start, {{0.0f, top - 0.5f * kLinkPitch, 0.0f}, {}});
    BodyDef def;
    def.position = pose.position;
    def.rotation = pose.rotation;
    const std::uint32_t link = add_body(scene, def, shape);
    JointDef joint;
    joint.frame_a.position = {0.0f, -0.5f * kLinkPitch, 0.0f};
    if (above == kWorldItself) joint.frame_a = start;
    joint.frame_b.position = {0.0f, 0.5f * kLinkPitch, 0.0f};
    add_joint(scene, above, link, BallJoint{}, joint);
    above = link;
  }
  return above;
}

// A ball on a chain's last link.
void add_weight(Scene& scene, std::uint32_t link, float radius, const Material& material, float mass) {
  const BodyDef& last = scene.bodies[link].def;
  const Pose pose = placed({last.position, last.rotation}, {{0.0f, -0.5f * kLinkPitch - radius, 0.0f}, {}});
  BodyDef def;
  def.position = pose.position;
  def.rotation = pose.rotation;
  if (mass > 0.0f) def.mass = mass;
  const std::uint32_t ball = add_body(scene, def, add_shape(scene, Sphere{radius}, material));
  add_joint(scene, link, ball, BallJoint{},
            {.frame_a = {{0.0f, -0.5f * kLinkPitch, 0.0f}, {}}, .frame_b = {{0.0f, radius, 0.0f}, {}}});
}

}  // namespace

// Bodies go down a column and then to the next one, each followed by the joints to the body above it and to
// its left: the order of the published scene.
Scene joint_grid(const Parameters& parameters) {
  constexpr float kRadius = 0.4f;      // m
  constexpr std::uint32_t kClass = 2;  // of spheres, which do not collide with each other
  const int columns = whole(parameters, "columns");
  const int rows = whole(parameters, "rows");
  Scene scene = start_scene("joint_grid", 100);
  scene.settings.sleeping = false;
  scene.settings.continuous = false;
  const std::uint32_t sphere =
      add_shape(scene, Sphere{kRadius}, {}, {.filter = {.category = kClass, .mask = ~kClass}});
  const JointDef below{.frame_a = {{0.0f, -0.5f, 0.0f}, {}}, .frame_b = {{0.0f, 0.5f, 0.0f}, {}}};
  const JointDef right{.frame_a = {{0.5f, 0.0f, 0.0f}, {}}, .frame_b = {{-0.5f, 0.0f, 0.0f}, {}}};
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < rows; ++row) {
      BodyDef def;
      def.type = row == 0 ? BodyType::fixed : BodyType::dynamic;
      def.position = {static_cast<float>(column), static_cast<float>(-row), 0.0f};
      const std::uint32_t body = add_body(scene, def, sphere);
      if (row > 0) add_joint(scene, body - 1, body, BallJoint{}, below);
      if (column > 0) add_joint(scene, body - static_cast<std::uint32_t>(rows), body, BallJoint{}, right);
    }
  }
  return scene;
}

Scene chain(const Parameters& parameters) {
  constexpr float kWeightRadius = 0.4f;  // m
  constexpr LinkKind kLink{.radius = 0.08f, .density = 1000.0f};
  const int links = whole(parameters, "links");
  const float weight = real(parameters, "weight");
  const float reach = kLinkPitch * static_cast<float>(links) + 2.0f * kWeightRadius;
  Scene scene = start_scene("chain", 600);
  add_ground(scene, reach + 10.0f);
  // Let go level, it swings through above the ground.
  const std::uint32_t last = add_chain(scene, {0.0f, reach + 1.0f, 0.0f}, 90.0, links, kLink);
  if (weight > 0.0f) add_weight(scene, last, kWeightRadius, {}, weight * mass_of(kLink));
  return scene;
}

// Planks across the way from one tower to the other, with hinges along their edges.
Scene bridge(const Parameters& parameters) {
  constexpr Vec3 kPlank{0.25f, 0.06f, 1.0f};  // m, half-extents
  constexpr Vec3 kLoad{0.3f, 0.3f, 0.3f};
  constexpr Vec3 kTower{1.0f, 4.0f, 1.5f};
  constexpr float kFall = 1.0f;  // m, of the first loads, and from one to the next above it
  const int planks = whole(parameters, "planks");
  const int loads = whole(parameters, "loads");
  const float deck = 2.0f * kTower.y - kPlank.y;  // m, height of the planks' centers
  const float half_length = kPlank.x * static_cast<float>(planks);
  Scene scene = start_scene("bridge", 600);
  add_ground(scene, half_length + 50.0f);
  const std::uint32_t tower_shape = add_shape(scene, Box{kTower});
  const std::uint32_t plank_shape = add_shape(scene, Box{kPlank}, {.density = 600.0f});
  const std::uint32_t load_shape = add_shape(scene, Box{kLoad});
  const auto add_tower = [&](float side) {
    BodyDef def;
    def.type = BodyType::fixed;
    def.position = {side * (half_length + kTower.x), kTower.y, 0.0f};
    return add_body(scene, def, tower_shape);
  };
  const std::uint32_t left = add_tower(-1.0f);
  const std::uint32_t right = add_tower(1.0f);
  const Quat across = along({0.0f, 0.0f, 1.0f});
  const auto hinge = [&](std::uint32_t a, std::uint32_t b, float x) {
    add_joint_at(scene, a, b, {{x, deck, 0.0f}, across}, HingeJoint{});
  };
  std::uint32_t last = left;
  for (int i = 0; i < planks; ++i) {
    const float edge = -half_length + 2.0f * kPlank.x * static_cast<float>(i);
    BodyDef def;
    def.position = {edge + kPlank.x, deck, 0.0f};
    const std::uint32_t plank = add_body(scene, def, plank_shape);
    hinge(last, plank, edge);
    last = plank;
  }
  hinge(last, right, half_length);
  // On every other plank at most, or they would overlap; further ones above them.
  const int slots = (planks + 1) / 2;
  const bool few = loads <= slots;
  for (int i = 0; i < loads; ++i) {
    const int slot = few ? static_cast<int>(std::int64_t{i} * slots / loads) : i % slots;
    const int level = few ? 0 : i / slots;
    BodyDef def;
    def.position = {-half_length + kPlank.x * static_cast<float>(4 * slot + 1),
                    deck + kFall * static_cast<float>(1 + level), 0.0f};
    add_body(scene, def, load_shape);
  }
  return scene;
}

Scene wrecking_ball(const Parameters& parameters) {
  constexpr Vec3 kBrick{0.25f, 0.25f, 0.5f};  // m, half-extents; every other row starts with half a brick
  constexpr float kRadius = 0.8f;             // m, of the ball
  constexpr float kSteel = 7800.0f;           // kg/m^3
  constexpr LinkKind kLink{.radius = 0.12f, .density = kSteel};
  constexpr double kSwing = 60.0;  // degrees
  constexpr float kLowest = 1.5f;  // m, of the ball's underside
  const int columns = whole(parameters, "columns");
  const int rows = whole(parameters, "rows");
  const int links = whole(parameters, "links");
  const float reach = kLinkPitch * static_cast<float>(links) + 2.0f * kRadius;
  Scene scene = start_scene("wrecking_ball", 600);
  add_ground(scene, reach + static_cast<float>(columns + rows) + 50.0f);
  const std::uint32_t last = add_chain(scene, {0.0f, kLowest + reach, 0.0f}, kSwing, links, kLink);
  add_weight(scene, last, kRadius, {.density = kSteel}, 0.0f);
  // The wall stands just past the lowest point of the swing.
  const float wall = kRadius + kBrick.x + 0.1f;
  const std::uint32_t brick = add_shape(scene, Box{kBrick});
  const std::uint32_t half_brick = add_shape(scene, Box{{kBrick.x, kBrick.y, 0.5f * kBrick.z}});
  const float end = 0.5f * static_cast<float>(columns);
  for (int row = 0; row < rows; ++row) {
    BodyDef def;
    def.position = {wall, kBrick.y * static_cast<float>(2 * row + 1), 0.0f};
    const bool shifted = row % 2 == 1;
    for (int i = 0; i < (shifted ? columns - 1 : columns); ++i) {
      def.position.z = static_cast<float>(i) - end + (shifted ? 1.0f : 0.5f);
      add_body(scene, def, brick);
    }
    if (!shifted) continue;
    for (const float side : {-1.0f, 1.0f}) {
      def.position.z = side * (end - 0.25f);
      add_body(scene, def, half_brick);
    }
  }
  return scene;
}

}  // namespace scree::scenes
