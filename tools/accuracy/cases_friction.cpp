// Friction: rolling, sliding that becomes rolling, the turntable, and when a box begins to slip.
#include <tools/accuracy/cases.h>
#include <tools/accuracy/truth.h>
#include <tools/accuracy/vector.h>
#include <tools/scenes/builders.h>

#include <algorithm>
#include <cmath>

namespace scree::accuracy {
namespace {

using scenes::Scene;

Scene start(const char* name) {
  Scene scene;
  scene.name = name;
  scene.settings.gravity = {0.0f, static_cast<float>(-kGravity), 0.0f};
  return scene;
}

}  // namespace

// SimBenchmark's `rolling` (Kang and Hwangbo, 2018): a plate of 20 x 20 x 1 m, 10 kg, with 25 balls on it, is
// pushed with 150 N at 60 degrees to its sides; a pyramid instead of the cone of friction shows in the
// direction.
std::vector<double> measure_rolling(Run& run) {
  constexpr double kSeconds = 4.0;
  constexpr double kForce = 150.0;
  constexpr double kPlateMass = 10.0;
  constexpr int kBalls = 25;
  // Mixed by the geometric mean: 0.8 between ball and plate, 0.4 between plate and ground.
  const auto rough = [](float friction) { return Material{.friction = friction, .patch_radius = 0.0f}; };
  Scene scene = start("rolling");
  scenes::add_ground(scene, 500.0f, rough(0.2f));
  const std::uint32_t plate_shape = scenes::add_shape(scene, Box{{10.0f, 0.5f, 10.0f}}, rough(0.8f));
  const std::uint32_t plate = scenes::add_body(
      scene, {.position = {0.0f, 0.5f, 0.0f}, .mass = static_cast<float>(kPlateMass)}, plate_shape);
  const std::uint32_t ball_shape = scenes::add_shape(scene, Sphere{0.5f}, rough(0.8f));
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      BodyDef def;
      def.position = {2.0f * static_cast<float>(i) - 4.0f, 1.5f, 2.0f * static_cast<float>(j) - 4.0f};
      def.mass = 1.0f;
      scenes::add_body(scene, def, ball_shape);
    }
  }
  Trial trial(run, scene);
  const Vector direction{0.5, 0.0, 0.866025403784439};
  const Rolling truth = rolling_accelerations(kForce, kPlateMass, 1.0, kBalls, 0.4, kGravity);
  const int steps = trial.steps_in(kSeconds);
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    // The published error is that of the plate and of the first ball.
    const Vector of_plate =
        to_vector(trial.body(plate).linear_velocity) - truth.plate * trial.time() * direction;
    const Vector of_ball =
        to_vector(trial.body(plate + 1).linear_velocity) - truth.ball * trial.time() * direction;
    sum += dot(of_plate, of_plate) + dot(of_ball, of_ball);
    trial.push(plate, to_float(kForce * direction));
    trial.step();
  }
  return {sum / steps};
}

// A ball that slides at first: friction slows it and makes it turn until it rolls.
std::vector<double> measure_slide_to_roll(Run& run) {
  constexpr double kSpeed = 5.0;
  constexpr double kFriction = 0.3;
  const Material material{.friction = static_cast<float>(kFriction), .patch_radius = 0.0f};
  Scene scene = start("slide_to_roll");
  scenes::add_ground(scene, 50.0f, material);
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{0.5f}, material);
  const std::uint32_t ball = scenes::add_body(
      scene, {.position = {0.0f, 0.5f, 0.0f}, .linear_velocity = {static_cast<float>(kSpeed), 0.0f, 0.0f}},
      shape);
  Trial trial(run, scene);
  const int steps = trial.steps_in(1.0);
  for (int i = 0; i < steps; ++i) trial.step();
  const double rolls = 5.0 / 7.0 * kSpeed;
  const double sliding = 2.0 * kSpeed / (7.0 * kFriction * kGravity);
  const double way =
      kSpeed * sliding - 0.5 * kFriction * kGravity * sliding * sliding + rolls * (trial.time() - sliding);
  const BodyMotion& motion = trial.body(ball);
  return {std::abs(double{motion.linear_velocity.x} / rolls - 1.0),
          std::abs(double{motion.pose.position.x} / way - 1.0)};
}

// A ball that rolls on a turning table goes round in a circle, 2/7 as fast as the table, wherever it starts.
std::vector<double> measure_turntable(Run& run) {
  constexpr double kTable =
      1.75;  // rad/s about +y; some engines clamp a ball that turns faster than 47 rad/s
  constexpr double kCircle = 2.0 / 7.0 * kTable;
  constexpr double kRadius = 0.1;
  const Material material{.friction = 1.0f, .patch_radius = 0.0f};
  Scene scene = start("turntable");
  const std::uint32_t table_shape = scenes::add_shape(scene, Box{{5.0f, 0.5f, 5.0f}}, material);
  BodyDef table;
  table.type = BodyType::kinematic;
  table.position.y = -0.5f;
  table.angular_velocity.y = static_cast<float>(kTable);
  const std::uint32_t table_body = scenes::add_body(scene, table, table_shape);
  scene.drives.push_back(
      {table_body, {table.position, {}}, table.position, {0.0f, 1.0f, 0.0f}, kTable * 180.0 / kPi});
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{static_cast<float>(kRadius)}, material);
  const Vector place{0.7, kRadius, 0.0};
  const Vector velocity{0.0, 0.0, 0.25};
  // It rolls: its lowest point moves as the table does there. w x (-r up) = table x place - velocity.
  const Vector up{0.0, 1.0, 0.0};
  const Vector slip = velocity - kTable * cross(up, place);
  BodyDef def;
  def.position = to_float(place);
  def.linear_velocity = to_float(velocity);
  def.angular_velocity = to_float(1.0 / kRadius * cross(up, slip));
  const std::uint32_t ball = scenes::add_body(scene, def, shape);
  Trial trial(run, scene);
  const int steps = trial.steps_in(4.0 * kPi / kCircle);
  double turned = 0.0;
  double sink = 0.0;
  Vector last = velocity;
  for (int i = 0; i < steps; ++i) {
    trial.step();
    Vector now = to_vector(trial.body(ball).linear_velocity);
    now.y = 0.0;
    turned += std::atan2(dot(up, cross(last, now)), dot(last, now));
    last = now;
    sink = std::max(sink, std::abs(double{trial.body(ball).pose.position.y} / kRadius - 1.0));
  }
  const double seconds = trial.time();
  // The velocity turns about `up`; the path is the integral.
  const double angle = kCircle * seconds;
  const Vector side = cross(up, velocity);
  const Vector truth =
      place + (1.0 / kCircle) * (std::sin(angle) * velocity + (1.0 - std::cos(angle)) * side);
  const double radius = length(velocity) / kCircle;
  const Vector end = to_vector(trial.body(ball).pose.position);
  return {std::abs(turned / angle - 1.0), length({end.x - truth.x, 0.0, end.z - truth.z}) / radius,
          std::abs(length(last) / length(velocity) - 1.0), sink};
}

// --- slip onset ---

namespace {

constexpr double kSlipFriction = 0.5;

// m, how far a box comes down a slope of the given tangent; gravity is turned instead of the ground.
double slide_down(Run& run, double tangent, double seconds) {
  const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
  const Material material{.friction = static_cast<float>(kSlipFriction)};
  Scene scene = start("slip_onset");
  scene.settings.gravity = to_float(kGravity * cosine * Vector{tangent, -1.0, 0.0});
  scenes::add_ground(scene, 50.0f, material);
  const std::uint32_t shape = scenes::add_shape(scene, Box{{0.5f, 0.25f, 0.5f}}, material);
  const std::uint32_t box = scenes::add_body(scene, {.position = {0.0f, 0.25f, 0.0f}}, shape);
  Trial trial(run, scene);
  const int steps = trial.steps_in(seconds);
  for (int i = 0; i < steps; ++i) trial.step();
  return std::abs(double{trial.body(box).pose.position.x});
}

}  // namespace

std::vector<double> measure_slip_onset(Run& run) {
  constexpr double kSeconds = 2.0;
  constexpr double kSlips = 0.005;  // m: reached in that time where the slope is 0.06 % too steep
  double low = 0.5 * kSlipFriction;
  double high = 1.5 * kSlipFriction;
  if (slide_down(run, low, kSeconds) > kSlips) high = low;
  while (high - low > 1e-4 * kSlipFriction) {
    const double middle = 0.5 * (low + high);
    (slide_down(run, middle, kSeconds) > kSlips ? high : low) = middle;
  }
  const double creep = slide_down(run, 0.95 * kSlipFriction, 10.0);
  return {std::abs(0.5 * (low + high) / kSlipFriction - 1.0), 100.0 * creep};
}

}  // namespace scree::accuracy
