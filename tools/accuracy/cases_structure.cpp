// Structures: dominoes that fall, an arch that just stands, towers that must not move.
#include <tools/accuracy/cases.h>
#include <tools/accuracy/truth.h>
#include <tools/accuracy/vector.h>
#include <tools/scenes/builders.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace scree::accuracy {
namespace {

using scenes::Scene;

Scene structure_scene(const char* name) {
  Scene scene;
  scene.name = name;
  scene.settings.gravity = {0.0f, static_cast<float>(-kGravity), 0.0f};
  return scene;
}

// --- dominoes: hinged at their front edges, with a limit instead of the ground, falling towards +z ---

constexpr int kDominoes = 32;

Scene domino_scene(const Dominoes& dominoes) {
  constexpr float kWide = 0.12f;  // m, half
  Scene scene = structure_scene("dominoes");
  const Vector half{double{kWide}, 0.5 * dominoes.height, 0.5 * dominoes.thickness};
  const Material smooth{.friction = 0.0f, .restitution = 0.0f};
  const std::uint32_t shape = scenes::add_shape(scene, Box{to_float(half)}, smooth);
  for (int i = 0; i < kDominoes; ++i) {
    const Vector edge{0.0, 0.0, i * (dominoes.spacing + dominoes.thickness)};
    const Vector to_center{0.0, half.y, -half.z};
    BodyDef def;
    def.position = to_float(edge + to_center);
    if (i == 0) {
      const Vector turn{dominoes.first_speed, 0.0, 0.0};
      def.angular_velocity = to_float(turn);
      def.linear_velocity = to_float(cross(turn, to_center));
    }
    const std::uint32_t body = scenes::add_body(scene, def, shape);
    JointDef joint;
    joint.frame_a.position = to_float(edge);
    joint.frame_b.position = to_float(-1.0 * to_center);
    scenes::add_joint(scene, scenes::kWorldItself, body, HingeJoint{{.lower = 0.0f}}, joint);
  }
  return scene;
}

double inclination(const BodyMotion& motion) {
  const Vector up = rotate(motion.pose.rotation, Vector{0.0, 1.0, 0.0});
  return std::atan2(up.z, up.y);
}

}  // namespace

std::vector<double> measure_dominoes(Run& run) {
  constexpr std::size_t kFrom = 10, kTo = 30;
  const Dominoes dominoes;
  const double angle = 0.5 * domino_hit_angle(dominoes);
  const std::vector<double> truth = domino_times(dominoes, kDominoes, angle);
  Trial trial(run, domino_scene(dominoes));
  std::vector<double> times;
  double before = 0.0;
  const int most = trial.steps_in(2.0 * truth.back());
  while (times.size() <= kTo && trial.steps() < most) {
    const double earlier = trial.time();
    const auto next = static_cast<std::uint32_t>(times.size());
    before = inclination(trial.body(next));
    trial.step();
    const double now = inclination(trial.body(next));
    // At most one domino passes within a step: the train needs 4 steps of 1/60 s from one to the next.
    if (now >= angle) times.push_back(earlier + (trial.time() - earlier) * (angle - before) / (now - before));
  }
  if (times.size() <= kTo) return {kNone, kNone};
  return {std::abs((truth[kTo] - truth[kFrom]) / (times[kTo] - times[kFrom]) - 1.0),
          std::abs(times[kFrom] / truth[kFrom] - 1.0)};
}

// --- the arch: wedges on radial joints, its ends on the ground ---

namespace {

constexpr int kVoussoirs = 17;
constexpr double kRadius = 5.0;  // m, of the middle line
constexpr double kDeep = 0.5;    // m, half
constexpr double kBlockDensity = 2000.0;

Scene arch_scene(double thickness) {
  Scene scene = structure_scene("arch");
  const Material stone{.friction = 0.9f, .density = static_cast<float>(kBlockDensity)};
  scenes::add_ground(scene, 20.0f, stone);
  const double inner = kRadius * (1.0 - 0.5 * thickness);
  const double outer = kRadius * (1.0 + 0.5 * thickness);
  const double half = 0.5 * kPi / kVoussoirs;
  std::vector<Vec3> corners;
  for (const double radius : {inner, outer}) {
    for (const double side : {-1.0, 1.0}) {
      for (const double depth : {-kDeep, kDeep}) {
        corners.push_back(
            to_float({side * radius * std::sin(half), radius * std::cos(half) - kRadius, depth}));
      }
    }
  }
  const std::uint32_t shape = scenes::add_shape(scene, ConvexHull{Hull(corners)}, stone);
  for (int i = 0; i < kVoussoirs; ++i) {
    const double angle = (2.0 * i + 1.0) * half - 0.5 * kPi;  // from the crown
    BodyDef def;
    def.position = to_float({kRadius * std::sin(angle), kRadius * std::cos(angle), 0.0});
    def.rotation = {0.0f, 0.0f, static_cast<float>(-std::sin(0.5 * angle)),
                    static_cast<float>(std::cos(0.5 * angle))};
    scenes::add_body(scene, def, shape);
  }
  return scene;
}

// Whether the crown has come down by less than a hundredth of the radius after 10 s.
bool arch_stands(Run& run, double thickness) {
  Trial trial(run, arch_scene(thickness));
  constexpr std::uint32_t kCrown = 1 + kVoussoirs / 2;
  const int steps = trial.steps_in(10.0);
  for (int i = 0; i < steps; ++i) {
    trial.step();
    const BodyMotion& crown = trial.body(kCrown);
    if (!(std::abs(double{crown.pose.position.y} - kRadius) < 0.1 * kRadius)) return false;
  }
  return std::abs(double{trial.body(kCrown).pose.position.y} - kRadius) < 0.01 * kRadius;
}

struct ThrustErrors {
  double horizontal = kNone;
  double vertical = kNone;
};

// An arch half as thick again as it must be: each end pushes with the half weight, and outward within the
// range.
ThrustErrors thrust_errors(Run& run, double thickness) {
  constexpr std::uint32_t kGround = 0, kFoot = 1;
  Scene scene = arch_scene(thickness);
  scene.settings.contact_forces = true;
  Trial trial(run, std::move(scene));
  const int steps = trial.steps_in(10.0);
  for (int i = 0; i < steps; ++i) trial.step();
  const std::optional<Vec3> force = trial.contact_force(kGround, kFoot);
  if (!force) return {};
  const double volume = double{std::get<ConvexHull>(trial.scene().shapes[1].geometry).hull.volume()};
  const double half_weight = 0.5 * kVoussoirs * volume * kBlockDensity * kGravity;
  const ThrustRange range = arch_thrust(kVoussoirs, thickness);
  const double thrust = std::abs(double{force->x}) / half_weight;
  const double outside = std::max({0.0, range.least - thrust, thrust - range.most});
  return {outside / range.least, std::abs(double{force->y} / half_weight - 1.0)};
}

}  // namespace

std::vector<double> measure_arch(Run& run) {
  const double truth = least_arch_thickness(kVoussoirs);
  double low = 0.5 * truth;
  double high = 2.0 * truth;
  const ThrustErrors thrust = thrust_errors(run, 1.5 * truth);
  if (!arch_stands(run, high)) return {kNone, thrust.horizontal, thrust.vertical};
  while (high - low > 5e-3 * truth) {
    const double middle = 0.5 * (low + high);
    (arch_stands(run, middle) ? high : low) = middle;
  }
  return {std::abs(high / truth - 1.0), thrust.horizontal, thrust.vertical};
}

// --- kapla towers ---

std::vector<double> measure_kapla(Run& run) {
  std::vector<double> errors;
  for (const double planks : {60.0, 240.0}) {
    Scene scene = scenes::build("kapla", {{"planks", planks}}).front();
    Trial trial(run, scene);
    const int steps = trial.steps_in(20.0);
    for (int i = 0; i < steps; ++i) trial.step();
    double sideways = 0.0;
    for (std::uint32_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].def.type == BodyType::fixed) continue;
      const Vector moved = to_vector(trial.body(i).pose.position) - to_vector(scene.bodies[i].def.position);
      sideways = std::max(sideways, length({moved.x, 0.0, moved.z}));
    }
    const std::uint32_t top = static_cast<std::uint32_t>(scene.bodies.size()) - 1;
    const double start_height = double{scene.bodies[top].def.position.y};
    errors.push_back(1000.0 * sideways);
    errors.push_back(std::abs(double{trial.body(top).pose.position.y} / start_height - 1.0));
  }
  return errors;
}

}  // namespace scree::accuracy
