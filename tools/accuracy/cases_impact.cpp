// Impacts: energy, heights of rebound and rows of balls.
//
// `bouncing`, `666` and elastic `666` are those of SimBenchmark (Kang and Hwangbo, 2018), read from its
// sources: sizes, masses, gaps, times and the definitions of the errors. Its random numbers are its own;
// these are the scenes'.
#include <tools/accuracy/cases.h>
#include <tools/accuracy/vector.h>
#include <tools/scenes/builders.h>
#include <tools/scenes/random.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scree::accuracy {
namespace {

using scenes::Scene;

constexpr float kSceneGravity = 9.81f;

Scene impact_scene(const char* name) {
  Scene scene;
  scene.name = name;
  scene.settings.gravity = {0.0f, -kSceneGravity, 0.0f};
  return scene;
}

double ball_energy(const BodyMotion& ball, double mass, double radius) {
  const Vector v = to_vector(ball.linear_velocity);
  const Vector w = to_vector(ball.angular_velocity);
  return mass * (0.5 * dot(v, v) + 0.2 * radius * radius * dot(w, w) +
                 double{kSceneGravity} * double{ball.pose.position.y});
}

double energy_of_balls(const Trial& trial, double mass, double radius) {
  double energy = 0.0;
  for (std::uint32_t i = 0; i < trial.scene().bodies.size(); ++i) {
    if (trial.scene().bodies[i].def.type == BodyType::fixed) continue;
    energy += ball_energy(trial.body(i), mass, radius);
  }
  return energy;
}

// The mean of the squared deviation of the balls' energy from the one at the start, sampled before each step.
double mean_squared_energy_error(Trial& trial, double seconds, double mass, double radius) {
  const double first = energy_of_balls(trial, mass, radius);
  const int steps = trial.steps_in(seconds);
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double error = energy_of_balls(trial, mass, radius) - first;
    sum += error * error;
    trial.step();
  }
  return sum / steps;
}

// SimBenchmark's 6 x 6 x 6 balls above a plane.
constexpr float kBallRadius = 0.1f;
constexpr double kBallMass = 10.0;

Scene cube_of_balls(const char* name, float height, float restitution) {
  constexpr float kGap = 0.21f;            // m, from center to center
  constexpr float kPerturbation = 0.001f;  // m
  constexpr float kThreshold = 0.01f;      // m/s, the default of RaiSim, whose figures are cited
  Scene scene = impact_scene(name);
  scene.settings.restitution_threshold = kThreshold;
  const Material smooth{.friction = 0.0f, .restitution = restitution, .patch_radius = 0.0f};
  scenes::add_ground(scene, 500.0f, smooth);
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{kBallRadius}, smooth);
  scenes::Random random(42);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) {
        const auto place = [&](int index) {
          return static_cast<float>(index) * kGap + random.unit() * kPerturbation;
        };
        BodyDef def;
        def.position = {place(i), place(k) + height, place(j)};
        def.mass = static_cast<float>(kBallMass);
        scenes::add_body(scene, def, shape);
      }
    }
  }
  return scene;
}

// The heights, over the floor, of the tops of a falling ball's bounces; the first is where it starts. A
// bounce that does not come has the height 0.
std::vector<double> bounce_heights(Run& run, double height, double restitution, int bounces) {
  constexpr float kRadius = 0.1f;
  Scene scene = impact_scene("bounce");
  const Material material{
      .friction = 0.0f, .restitution = static_cast<float>(restitution), .patch_radius = 0.0f};
  scenes::add_ground(scene, 10.0f, material);
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{kRadius}, material);
  BodyDef def;
  def.position.y = static_cast<float>(height) + kRadius;
  const std::uint32_t ball = scenes::add_body(scene, def, shape);
  Trial trial(run, scene);
  std::vector<double> heights{height};
  const double fall = std::sqrt(2.0 * height / double{kSceneGravity});
  const int most = trial.steps_in(fall * (2.0 * bounces + 2.0) * 1.5);
  const auto wanted = static_cast<std::size_t>(bounces) + 1;
  float last_speed = 0.0f;
  while (trial.steps() < most && heights.size() < wanted) {
    trial.step();
    const float speed = trial.body(ball).linear_velocity.y;
    const double y = double{trial.body(ball).pose.position.y} - double{kRadius};
    if (last_speed > 0.0f && speed <= 0.0f) {
      // The speed is small here: what is left of it counts as height.
      heights.push_back(y + 0.5 * double{speed} * double{speed} / double{kSceneGravity});
    }
    last_speed = speed;
  }
  heights.resize(wanted);
  return heights;
}

struct CradleResult {
  double passed = 0.0;  // the largest error of a ball's speed that should leave, over the speed at the start
  double others = 0.0;  // the largest speed of those that should rest, over that speed
  double energy = 0.0;  // over that at the start, less 1
};

CradleResult run_cradle(Run& run, double gap, int incoming, bool on_plane) {
  constexpr int kBalls = 5;
  constexpr float kRadius = 0.125f;
  constexpr double kSpeed = 2.0;   // m/s, above every engine's threshold of restitution
  constexpr double kBefore = 0.2;  // m
  Scene scene = impact_scene("cradle");
  if (!on_plane) scene.settings.gravity = {};
  const Material elastic{.friction = 0.0f, .restitution = 1.0f, .patch_radius = 0.0f};
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{kRadius}, elastic);
  for (int i = 0; i < kBalls; ++i) {
    BodyDef def;
    const bool moves = i < incoming;
    def.position = {static_cast<float>(i * (2.0 * double{kRadius} + gap) - (moves ? kBefore : 0.0)), kRadius,
                    0.0f};
    if (moves) def.linear_velocity.x = static_cast<float>(kSpeed);
    scenes::add_body(scene, def, shape);
  }
  if (on_plane) scenes::add_ground(scene, 50.0f, elastic);
  Trial trial(run, scene);
  const int steps = trial.steps_in((kBefore + kBalls * gap) / kSpeed + 0.25);
  for (int i = 0; i < steps; ++i) trial.step();
  CradleResult result;
  double energy = 0.0;
  for (int i = 0; i < kBalls; ++i) {
    const Vector v = to_vector(trial.body(static_cast<std::uint32_t>(i)).linear_velocity);
    energy += dot(v, v) / (kSpeed * kSpeed * incoming);
    if (i >= kBalls - incoming) {
      result.passed = std::max(result.passed, length(v - Vector{kSpeed, 0.0, 0.0}) / kSpeed);
    } else {
      result.others = std::max(result.others, length(v) / kSpeed);
    }
  }
  result.energy = std::abs(energy - 1.0);
  return result;
}

}  // namespace

std::vector<double> measure_bouncing(Run& run) {
  Scene scene = impact_scene("bouncing");
  const Material elastic{.friction = 0.0f, .restitution = 1.0f, .patch_radius = 0.0f};
  scenes::add_ground(scene, 100.0f, elastic);
  const std::uint32_t shape = scenes::add_shape(scene, Sphere{kBallRadius}, elastic);
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) {
      BodyDef def;
      def.position = {2.0f * static_cast<float>(i), 5.0f, 2.0f * static_cast<float>(j)};
      def.mass = static_cast<float>(kBallMass);
      scenes::add_body(scene, def, shape);
    }
  }
  Trial trial(run, scene);
  return {mean_squared_energy_error(trial, 20.0, kBallMass, double{kBallRadius})};
}

std::vector<double> measure_height(Run& run) {
  double worst = 0.0;
  for (const double height : bounce_heights(run, 1.0, 1.0, 100))
    worst = std::max(worst, std::abs(height - 1.0));
  return {worst};
}

std::vector<double> measure_rebound(Run& run) {
  constexpr double kHeight = 2.0;                                // m
  const double threshold = 1.0 / (2.0 * double{kSceneGravity});  // m, from which a ball comes with 1 m/s
  std::vector<double> errors;
  for (const double e : {0.3, 0.6, 0.8, 0.9}) {
    int bounces = 0;
    double height = kHeight;
    for (; bounces < 10 && height > 1.3 * threshold; ++bounces) height *= e * e;
    const std::vector<double> heights = bounce_heights(run, kHeight, e, bounces);
    double worst = 0.0;
    for (std::size_t i = 1; i < heights.size() && heights[i - 1] > 0.0; ++i) {
      worst = std::max(worst, std::abs(heights[i] / (e * e * heights[i - 1]) - 1.0));
    }
    errors.push_back(worst);
  }
  return errors;
}

std::vector<double> measure_cradle(Run& run) {
  std::vector<double> errors;
  for (const bool on_plane : {false, true}) {
    CradleResult one, two;
    for (const double gap : {0.0, 1e-4, 1e-3, 1e-2}) {
      for (const int incoming : {1, 2}) {
        const CradleResult result = run_cradle(run, gap, incoming, on_plane);
        CradleResult& worst = incoming == 1 ? one : two;
        worst.passed = std::max(worst.passed, result.passed);
        worst.others = std::max(worst.others, result.others);
        worst.energy = std::max(worst.energy, result.energy);
      }
    }
    errors.insert(errors.end(), {one.passed, one.others, std::max(two.passed, two.others),
                                 std::max(one.energy, two.energy)});
  }
  return errors;
}

std::vector<double> measure_666(Run& run) {
  Trial trial(run, cube_of_balls("666", 0.101f, 0.0f));
  const auto count = static_cast<std::uint32_t>(trial.scene().bodies.size());
  const double radius = double{kBallRadius};
  const int steps = trial.steps_in(10.0);
  double sum = 0.0;
  for (int step = 0; step < steps; ++step) {
    for (std::uint32_t i = 1; i < count; ++i) {
      const Vector at = to_vector(trial.body(i).pose.position);
      const double into_ground = std::max(0.0, radius - at.y);
      sum += into_ground * into_ground;
      for (std::uint32_t j = i + 1; j < count; ++j) {
        const Vector apart = to_vector(trial.body(j).pose.position) - at;
        const double square = dot(apart, apart);
        if (square >= 4.0 * radius * radius) continue;
        const double overlap = 2.0 * radius - std::sqrt(square);
        sum += overlap * overlap;
      }
    }
    trial.step();
  }
  return {sum / steps};
}

std::vector<double> measure_elastic_666(Run& run) {
  Trial trial(run, cube_of_balls("elastic_666", 1.101f, 1.0f));
  const double first = energy_of_balls(trial, kBallMass, double{kBallRadius});
  const double squared = mean_squared_energy_error(trial, 10.0, kBallMass, double{kBallRadius});
  return {squared, std::abs(energy_of_balls(trial, kBallMass, double{kBallRadius}) / first - 1.0)};
}

}  // namespace scree::accuracy
