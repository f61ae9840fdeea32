// Machines that show every kind of joint at work, and a catapult.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>
#include <tools/scenes/hulls.h>

#include <cstdint>
#include <vector>

namespace scree::scenes {
namespace {

constexpr Vec3 kX{1.0f, 0.0f, 0.0f};
constexpr Vec3 kY{0.0f, 1.0f, 0.0f};
constexpr Vec3 kZ{0.0f, 0.0f, 1.0f};

// For parts that would block each other as drawn, such as gears.
constexpr Filter kTouchesNothing{.category = 1, .mask = 0};

Vec3 sum(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

// Bodies and joints around a point of a scene, each in coordinates relative to that.
class Workshop {
 public:
  Workshop(Scene& scene, Vec3 origin) : scene_(scene), origin_(origin) {}

  std::uint32_t add(const Geometry& geometry, Vec3 position, const ShapeOptions& options = {},
                    float density = 1000.0f, Quat rotation = {}) {
    BodyDef def;
    def.position = sum(origin_, position);
    def.rotation = rotation;
    return add_body(scene_, def, add_shape(scene_, geometry, {.density = density}, options));
  }
  std::uint32_t add_ghost(const Geometry& geometry, Vec3 position, Quat rotation = {}) {
    return add(geometry, position, {.filter = kTouchesNothing}, 1000.0f, rotation);
  }
  // At one place for both, or at the place of each.
  void join(std::uint32_t a, std::uint32_t b, const Pose& place, const Joint& joint) {
    add_joint_at(scene_, a, b, {in_world(place.position), place.rotation}, joint);
  }
  void join(std::uint32_t a, std::uint32_t b, Vec3 position, Vec3 axis, const Joint& joint) {
    join(a, b, {position, along(axis)}, joint);
  }
  void join(std::uint32_t a, const Pose& place_a, std::uint32_t b, const Pose& place_b, const Joint& joint) {
    add_joint(scene_, a, b, joint, {.frame_a = frame_in(a, place_a), .frame_b = frame_in(b, place_b)});
  }
  // To the world.
  void hold(std::uint32_t b, Vec3 position, Vec3 axis, const Joint& joint) {
    join(kWorldItself, b, position, axis, joint);
  }
  // To the last joint.
  void give_rows(const std::vector<UserRow>& rows) { scene_.joints.back().rows = rows; }
  Vec3 in_world(Vec3 position) const { return sum(origin_, position); }

 private:
  Pose frame_in(std::uint32_t body, const Pose& place) const {
    const Pose there{in_world(place.position), place.rotation};
    if (body == kWorldItself) return there;
    const BodyDef& def = scene_.bodies[body].def;
    return seen_from({def.position, def.rotation}, there);
  }

  Scene& scene_;
  Vec3 origin_;
};

// A motor turns the first of four gears about z. The last moves a rack until the rack meets its stop.
void add_gears(Workshop shop) {
  constexpr float kRadii[] = {0.3f, 0.6f, 0.4f, 0.5f};  // m
  constexpr float kHalfThickness = 0.1f;                // m
  constexpr float kRackTravel = 2.0f;                   // m
  constexpr float kHeight = 1.5f;                       // m, of the axles
  const HingeJoint driven{.angle = {.drive = Drive::motor, .speed = 4.0f, .max_force = 200.0f}};
  float x = 0.0f;
  std::uint32_t last = kWorldItself;
  float last_radius = 0.0f;
  for (const float radius : kRadii) {
    if (last != kWorldItself) x += last_radius + radius;
    const Hull disk(moved(prism_points(16, radius, 2.0f * kHalfThickness), {0.0f, -kHalfThickness, 0.0f}));
    const std::uint32_t gear =
        shop.add_ghost(ConvexHull{.hull = disk}, {x, kHeight, 0.0f}, rotation_about(kX, 90.0));
    shop.hold(gear, {x, kHeight, 0.0f}, kZ, last == kWorldItself ? driven : HingeJoint{});
    // Teeth go equally far on both sides, turning the other way.
    if (last != kWorldItself) shop.join(last, gear, {x, kHeight, 0.0f}, kZ, GearJoint{radius / last_radius});
    last = gear;
    last_radius = radius;
  }
  const Vec3 rack_at{x, kHeight - last_radius - 0.1f, 0.0f};
  const std::uint32_t rack = shop.add_ghost(Box{{1.0f, 0.1f, 0.1f}}, rack_at);
  shop.hold(rack, rack_at, kX, SliderJoint{.offset = {.lower = -kRackTravel, .upper = kRackTravel}});
  // The pinion turns about z, the rack goes along x.
  shop.join(last, {{x, kHeight, 0.0f}, along(kZ)}, rack, {rack_at, along(kX)},
            RackAndPinionJoint{.radius = last_radius});
}

// A crank drives a piston by a rod.
void add_piston(Workshop shop) {
  constexpr float kCrank = 0.4f;   // m
  constexpr float kRod = 1.2f;     // m
  constexpr float kHeight = 1.0f;  // m
  const Vec3 axle{0.0f, kHeight, 0.0f}, pin{kCrank, kHeight, 0.0f}, wrist{kCrank + kRod, kHeight, 0.0f};
  const std::uint32_t crank = shop.add_ghost(Box{{kCrank, 0.1f, 0.05f}}, axle);
  shop.hold(crank, axle, kZ,
            HingeJoint{.angle = {.drive = Drive::motor, .speed = 6.0f, .max_force = 500.0f}});
  const std::uint32_t rod =
      shop.add_ghost(Box{{0.5f * kRod, 0.05f, 0.05f}}, {kCrank + 0.5f * kRod, kHeight, 0.0f});
  shop.join(crank, rod, pin, kZ, HingeJoint{});
  const std::uint32_t piston = shop.add_ghost(Box{{0.2f, 0.2f, 0.2f}}, wrist);
  shop.join(rod, piston, wrist, kZ, HingeJoint{});
  shop.hold(piston, wrist, kX, SliderJoint{});
}

// A lift with a crate, and two weights over a pulley.
void add_lift(Workshop shop) {
  const Vec3 floor{0.0f, 0.2f, 0.0f};  // of the cabin
  const std::uint32_t cabin = shop.add(Box{{0.6f, 0.1f, 0.6f}}, floor);
  shop.add(Box{{0.3f, 0.3f, 0.3f}}, {0.0f, 0.61f, 0.0f});
  shop.hold(
      cabin, floor, kY,
      SliderJoint{.offset = {.upper = 3.0f, .drive = Drive::motor, .speed = 0.8f, .max_force = 20000.0f}});
  const Vec3 light_at{1.5f, 2.0f, 0.0f}, heavy_at{3.0f, 2.0f, 0.0f};
  const std::uint32_t light = shop.add(Box{{0.2f, 0.2f, 0.2f}}, light_at);
  const std::uint32_t heavy = shop.add(Box{{0.23f, 0.23f, 0.23f}}, heavy_at);
  const auto wheel_over = [&](Vec3 at) { return shop.in_world({at.x, 4.0f, at.z}); };
  shop.join(light, {light_at, {}}, heavy, {heavy_at, {}},
            PulleyJoint{.point_a = wheel_over(light_at), .point_b = wheel_over(heavy_at), .length = 4.0f});
}

// A shaft with a motor turns a second one, 25 degrees aside, through a cardan joint. A weld makes the second
// one's blade.
void add_shafts(Workshop shop) {
  constexpr float kHalf = 0.5f;    // m, of each shaft
  constexpr float kHeight = 1.2f;  // m
  const Capsule shape{.half_height = kHalf - 0.08f, .radius = 0.08f};
  constexpr double kBend = 25.0;  // degrees
  const auto [sine, cosine] = sine_cosine(kBend);
  const Vec3 away{static_cast<float>(cosine), 0.0f, static_cast<float>(sine)};
  const Vec3 cross{0.0f, kHeight, 0.0f};
  const auto on_second = [&](float way) { return Vec3{away.x * way, kHeight, away.z * way}; };
  const std::uint32_t first = shop.add_ghost(shape, {-kHalf, kHeight, 0.0f}, turn_between(kY, kX));
  shop.hold(first, {-kHalf, kHeight, 0.0f}, kX,
            HingeJoint{.angle = {.drive = Drive::motor, .speed = 8.0f, .max_force = 300.0f}});
  const std::uint32_t second = shop.add_ghost(shape, on_second(kHalf), turn_between(kY, away));
  // The cross' arms: x up, square to both shafts, and y square to the second one.
  const Quat arms = turned(rotation_about(kY, -kBend), Quat{0.5f, 0.5f, 0.5f, 0.5f});
  shop.join(first, second, {cross, arms}, UniversalJoint{});
  shop.hold(second, on_second(2.0f * kHalf), away, BallJoint{});
  const std::uint32_t blade = shop.add_ghost(Box{{0.05f, 0.5f, 0.05f}}, on_second(2.0f * kHalf));
  shop.join(second, blade, on_second(2.0f * kHalf), away, WeldJoint{});
}

// A nut that turns and climbs an upright screw: what no kind of joint holds, the rows of a user joint do.
void add_nut(Workshop shop, Vec3 at) {
  constexpr float kRise = 0.05f;  // m a radian
  const std::uint32_t nut = shop.add_ghost(Box{{0.2f, 0.05f, 0.2f}}, at);
  UserJoint screw;
  std::vector<UserRow> rows;
  const auto add = [&](RowKind kind, Vec3 linear, Vec3 angular, const RowTarget& target) {
    screw.rows[rows.size()] = kind;
    rows.push_back({{.linear_b = linear, .angular_b = angular}, target, {}});
  };
  add(RowKind::held, kX, {}, {});
  add(RowKind::held, kZ, {}, {});
  add(RowKind::held, {}, kX, {});
  add(RowKind::held, {}, kZ, {});
  add(RowKind::held, kY, {0.0f, -kRise, 0.0f}, {});
  add(RowKind::motor, {}, kY, {.speed = 3.0f});
  shop.hold(nut, at, kY, screw);
  shop.give_rows(rows);
}

// Hanging and floating bodies: a rope, a rod, a spring, a platform on six springs, a puck on a plane, a drone
// held in the air, and a box dragged by a mouse.
void add_toys(Workshop shop) {
  const auto box = [](float half) { return Box{{half, half, half}}; };
  const auto hang = [&](float x, const JointAxis& length) {
    const Vec3 at{x, 1.5f, 0.0f}, hook{x, 3.1f, -1.2f};  // 2 m away
    const std::uint32_t weight = shop.add(box(0.2f), at);
    shop.join(kWorldItself, {hook, {}}, weight, {at, {}}, DistanceJoint{length});
  };
  hang(0.0f, {.lower = 0.0f, .upper = 2.2f});
  hang(1.5f, {.lower = 2.0f, .upper = 2.0f});
  hang(3.0f, {.lower = 0.0f, .drive = Drive::spring, .target = 1.5f, .hertz = 1.5f, .damping_ratio = 0.1f});

  const Vec3 platform_at{5.0f, 1.0f, 0.0f};
  const std::uint32_t platform = shop.add(Box{{0.8f, 0.1f, 0.8f}}, platform_at);
  SixDegreeJoint springs;
  for (JointAxis& offset : springs.offset) {
    offset = {.lower = -0.5f, .upper = 0.5f, .drive = Drive::spring, .hertz = 2.0f, .damping_ratio = 0.2f};
  }
  for (JointAxis& angle : springs.angle) {
    angle = {.lower = -0.3f, .upper = 0.3f, .drive = Drive::spring, .hertz = 2.0f, .damping_ratio = 0.2f};
  }
  shop.hold(platform, platform_at, kX, springs);
  shop.add(box(0.25f), {5.3f, 1.8f, 0.2f});

  const Vec3 puck_at{7.5f, 1.0f, 0.0f};
  const std::uint32_t puck = shop.add_ghost(box(0.2f), puck_at);
  PlanarJoint plane;
  plane.offset_y = {.lower = -0.6f, .upper = 0.6f};
  plane.offset_z = {.drive = Drive::spring, .target = 0.3f, .hertz = 0.7f, .damping_ratio = 0.05f};
  plane.angle = {.drive = Drive::motor, .speed = 2.0f, .max_force = 50.0f};
  shop.hold(puck, puck_at, kZ, plane);

  const Vec3 drone_at{9.0f, 2.0f, 0.0f};
  const std::uint32_t drone = shop.add(box(0.2f), drone_at);
  MotorJoint motor;
  motor.target = {0.5f, 0.5f, 0.0f};
  motor.max_force = 2000.0f;
  motor.rotation.target = rotation_about(kY, 60.0);
  motor.rotation.max_torque = 200.0f;
  shop.hold(drone, drone_at, kX, motor);

  const Vec3 dragged_at{10.5f, 0.21f, 0.0f};
  const std::uint32_t dragged = shop.add(box(0.2f), dragged_at);
  MouseJoint mouse;
  mouse.target = shop.in_world({10.5f, 1.5f, 0.5f});
  mouse.max_force = 1000.0f;
  const Vec3 corner = sum(dragged_at, {0.2f, 0.2f, 0.2f});
  shop.join(kWorldItself, {corner, {}}, dragged, {corner, {}}, mouse);

  add_nut(shop, {12.0f, 0.5f, 0.0f});
}

}  // namespace

Scene motors(const Parameters& parameters) {
  constexpr float kLane = 3.0f;     // m, from machine to machine
  constexpr float kLength = 36.0f;  // m
  const int machines = whole(parameters, "machines");
  const float breadth = kLane * static_cast<float>(machines);
  Scene scene = start_scene("motors", 600);
  add_ground(scene, kLength + breadth);
  for (int i = 0; i < machines; ++i) {
    const float z = kLane * static_cast<float>(i) - 0.5f * breadth;
    const auto shop_at = [&](float x) { return Workshop(scene, {x - 0.5f * kLength, 0.0f, z}); };
    add_gears(shop_at(0.0f));
    add_piston(shop_at(9.0f));
    add_lift(shop_at(13.0f));
    add_shafts(shop_at(19.0f));
    add_toys(shop_at(22.0f));
  }
  return scene;
}

// The lever lies towards -x, with the stone at its end against a rim. It stops where the stone must fly off.
Scene card_catapult(const Parameters& parameters) {
  constexpr float kHalfLength = 1.0f;      // m, of the lever
  constexpr float kHalfThickness = 0.05f;  // m
  constexpr float kHalfBreadth = 0.15f;    // m
  constexpr float kStone = 0.15f;          // m, radius
  constexpr Vec3 kPivot{-6.0f, 0.35f, 0.0f};
  constexpr double kRelease = 60.0;  // degrees
  Scene scene = card_house(parameters);
  scene.name = "card_catapult";
  scene.steps = 300;
  const std::uint32_t lever_shape =
      add_shape(scene, Box{{kHalfLength, kHalfThickness, kHalfBreadth}}, {.density = 600.0f});
  add_shape(scene, Box{{0.03f, 0.1f, kHalfBreadth}}, {.density = 600.0f},
            {.local_pose = {{-kHalfLength + 0.03f, kHalfThickness + 0.1f, 0.0f}, {}}});
  BodyDef def;
  def.position = {kPivot.x - kHalfLength, kPivot.y, 0.0f};
  const std::uint32_t lever = add_body(scene, def, lever_shape, 2);
  const HingeJoint spring{.angle = {.lower = 0.0f,
                                    .upper = radians(kRelease),
                                    .drive = Drive::spring,
                                    .target = radians(90.0),
                                    .hertz = 0.8f,
                                    .damping_ratio = 0.0f}};
  add_joint_at(scene, kWorldItself, lever, {kPivot, turn_between(kX, {0.0f, 0.0f, -1.0f})}, spring);
  def.position = {kPivot.x - 2.0f * kHalfLength + 0.07f + kStone, kPivot.y + kHalfThickness + kStone, 0.0f};
  add_body(scene, def, add_shape(scene, Sphere{kStone}));
  return scene;
}

}  // namespace scree::scenes
