// Cars on wheel joints.
#include <tools/scenes/angles.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>

#include <cstdint>
#include <numbers>

namespace scree::scenes {
namespace {

constexpr Vec3 kChassis{1.3f, 0.25f, 0.5f};  // m, half-extents
constexpr float kWheelRadius = 0.35f;        // m; balls, whose outer halves stand out
constexpr float kAxle = 0.85f;               // m, from the middle to each axle
constexpr float kTrack = 0.6f;               // m, from the middle to each wheel
constexpr float kAxleDrop = 0.15f;           // m, of the axles below the chassis' center
constexpr float kTravel = 0.12f;             // m, of the suspension, up and down
constexpr float kPace = 14.0f;               // rad/s, of driven wheels: 4.9 m/s

struct CarShapes {
  std::uint32_t chassis, wheel;
};

// A car that looks along x. Its rear wheels are driven, its front wheels hold an angle against a spring.
void add_car(Scene& scene, Vec3 at, const CarShapes& shapes, double steer_degrees) {
  BodyDef def;
  def.position = at;
  const std::uint32_t chassis = add_body(scene, def, shapes.chassis);
  // x up, along the suspension; z across, along the axles.
  const Quat frame = rotation_about({0.0f, 0.0f, 1.0f}, 90.0);
  for (const float end : {1.0f, -1.0f}) {
    for (const float side : {1.0f, -1.0f}) {
      def.position = {at.x + end * kAxle, at.y - kAxleDrop, at.z + side * kTrack};
      const std::uint32_t wheel = add_body(scene, def, shapes.wheel);
      WheelJoint joint;
      joint.suspension.lower = -kTravel;
      joint.suspension.upper = kTravel;
      joint.suspension.hertz = 2.5f;
      if (end > 0.0f) {
        constexpr float kMostSteering = 0.6f;  // rad
        joint.steering = {.lower = -kMostSteering,
                          .upper = kMostSteering,
                          .drive = Drive::spring,
                          .target = static_cast<float>(steer_degrees * (std::numbers::pi / 180.0)),
                          .hertz = 8.0f};
      } else {
        // Forwards along x is backwards about z.
        joint.spin = {.drive = Drive::motor, .speed = -kPace, .max_force = 300.0f};
      }
      add_joint_at(scene, chassis, wheel, {def.position, frame}, joint);
    }
  }
}

}  // namespace

Scene vehicles(const Parameters& parameters) {
  constexpr float kLane = 3.0f;        // m
  constexpr float kRow = 5.0f;         // m
  constexpr float kWay = 40.0f;        // m of bumps before the first row
  constexpr float kBumpPitch = 4.0f;   // m
  constexpr float kBumpRadius = 0.3f;  // m
  constexpr float kBumpHeight = 0.1f;  // m, above the ground
  const int cars = whole(parameters, "cars");
  int lanes = 1;
  while (lanes * lanes < cars) ++lanes;
  const int rows = (cars + lanes - 1) / lanes;
  const float half_breadth = 0.5f * kLane * static_cast<float>(lanes);
  const float length = kRow * static_cast<float>(rows);
  Scene scene = start_scene("vehicles", 600);
  add_ground(scene, length + half_breadth + kWay + 50.0f);
  const std::uint32_t bump =
      add_shape(scene, Capsule{.half_height = half_breadth + 5.0f, .radius = kBumpRadius});
  for (float x = kBumpPitch; x < kWay; x += kBumpPitch) {
    BodyDef def;
    def.type = BodyType::fixed;
    def.position = {x, kBumpHeight - kBumpRadius, 0.0f};
    def.rotation = rotation_about({1.0f, 0.0f, 0.0f}, 90.0);
    add_body(scene, def, bump);
  }
  const CarShapes shapes{add_shape(scene, Box{kChassis}, {.density = 300.0f}),
                         add_shape(scene, Sphere{kWheelRadius}, {.friction = 1.0f, .density = 150.0f})};
  for (int i = 0; i < cars; ++i) {
    const Vec3 at{-kRow * static_cast<float>(i / lanes), kWheelRadius + kAxleDrop,
                  kLane * (static_cast<float>(i % lanes) + 0.5f) - half_breadth};
    add_car(scene, at, shapes, 1.0 * (i % 5 - 2));
  }
  return scene;
}

}  // namespace scree::scenes
