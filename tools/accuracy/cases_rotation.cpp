// Rotation: the heavy top, the T-handle that flips, and pendulums.
#include <tools/accuracy/cases.h>
#include <tools/accuracy/truth.h>
#include <tools/accuracy/vector.h>
#include <tools/scenes/builders.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace scree::accuracy {
namespace {

using scenes::Scene;

Scene rotation_scene(const char* name) {
  Scene scene;
  scene.name = name;
  scene.settings.gravity = {0.0f, static_cast<float>(-kGravity), 0.0f};
  return scene;
}

// Times at which a sampled function has maxima, by a parabola through three samples.
class Maxima {
 public:
  void add(double time, double value) {
    if (samples_ >= 2 && middle_ > before_ && middle_ >= value) {
      const double curvature = before_ - 2.0 * middle_ + value;
      const double shift = curvature < 0.0 ? 0.5 * (before_ - value) / curvature : 0.0;
      times_.push_back(middle_time_ + shift * (time - middle_time_));
      values_.push_back(middle_ - 0.25 * (before_ - value) * shift);
    }
    before_ = middle_;
    middle_ = value;
    middle_time_ = time;
    ++samples_;
  }
  std::size_t count() const { return times_.size(); }
  double value(std::size_t i) const { return values_[i]; }
  /// s, from one to the next, over all of them.
  double mean_period() const {
    return times_.size() < 2 ? kNone
                             : (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1);
  }

 private:
  std::vector<double> times_, values_;
  double before_ = 0.0, middle_ = 0.0, middle_time_ = 0.0;
  int samples_ = 0;
};

// Times at which a sampled function changes its sign, by a straight line.
class Crossings {
 public:
  void add(double time, double value) {
    if (samples_ > 0 && (last_ < 0.0) != (value < 0.0)) {
      times_.push_back(last_time_ + (time - last_time_) * last_ / (last_ - value));
    }
    last_ = value;
    last_time_ = time;
    ++samples_;
  }
  /// s, from one to the next; an even number of intervals, which need not be equally long.
  double mean_interval() const {
    if (times_.size() < 3) return kNone;
    const std::size_t intervals = (times_.size() - 1) / 2 * 2;
    return (times_[intervals] - times_.front()) / static_cast<double>(intervals);
  }

 private:
  std::vector<double> times_;
  double last_ = 0.0, last_time_ = 0.0;
  int samples_ = 0;
};

// --- the top: a flat box on a thin stem without mass, its tip at the world's origin ---

constexpr double kTopWide = 0.2;   // m, half
constexpr double kTopHigh = 0.05;  // m, half
constexpr double kStem = 0.15;     // m, from the tip to the center
constexpr double kDensity = 1000.0;
constexpr double kSpin = 40.0;  // rad/s
constexpr double kLean = 30.0 * kPi / 180.0;

Top top_of_scene() {
  const double mass = 8.0 * kTopWide * kTopHigh * kTopWide * kDensity;
  const double across = mass / 3.0 * (kTopWide * kTopWide + kTopHigh * kTopHigh);
  return {across + mass * kStem * kStem, mass / 3.0 * 2.0 * kTopWide * kTopWide, mass * kGravity * kStem,
          kSpin};
}

Scene top_scene(double precession) {
  Scene scene = rotation_scene("top");
  const std::uint32_t shape = scenes::add_shape(
      scene, Box{{static_cast<float>(kTopWide), static_cast<float>(kTopHigh), static_cast<float>(kTopWide)}});
  const Vector axis{std::sin(kLean), std::cos(kLean), 0.0};
  const Vector up{0.0, 1.0, 0.0};
  // The spin is the whole angular velocity along the axis, so that what the precession has along it comes
  // off.
  const Vector turn = precession * up + (kSpin - precession * std::cos(kLean)) * axis;
  BodyDef def;
  def.position = to_float(kStem * axis);
  def.rotation = {0.0f, 0.0f, static_cast<float>(-std::sin(0.5 * kLean)),
                  static_cast<float>(std::cos(0.5 * kLean))};
  def.angular_velocity = to_float(turn);
  def.linear_velocity = to_float(kStem * cross(turn, axis));
  const std::uint32_t body = scenes::add_body(scene, def, shape);
  JointDef joint;
  joint.frame_b.position.y = static_cast<float>(-kStem);
  scenes::add_joint(scene, scenes::kWorldItself, body, BallJoint{}, joint);
  return scene;
}

Vector top_axis(const Trial& trial) { return rotate(trial.body(0).pose.rotation, Vector{0.0, 1.0, 0.0}); }

double lean_of(Vector axis) { return std::acos(std::clamp(axis.y / length(axis), -1.0, 1.0)); }

}  // namespace

std::vector<double> measure_top(Run& run) {
  const Top top = top_of_scene();
  const double rate = steady_precession(top, std::cos(kLean));
  double precession_error = 0.0;
  double lean_error = 0.0;
  {
    Trial trial(run, top_scene(rate));
    const int steps = trial.steps_in(3.0);
    double turned = 0.0;
    Vector last = top_axis(trial);
    for (int i = 0; i < steps; ++i) {
      trial.step();
      const Vector axis = top_axis(trial);
      turned += std::atan2(last.z * axis.x - last.x * axis.z, last.x * axis.x + last.z * axis.z);
      lean_error = std::max(lean_error, std::abs(lean_of(axis) - kLean));
      last = axis;
    }
    precession_error = std::abs(turned / (rate * trial.time()) - 1.0);
  }
  Trial trial(run, top_scene(0.0));
  const Nutation truth = nutation_from_rest(top, std::cos(kLean));
  Maxima lowest;
  const int steps = trial.steps_in(3.0);
  for (int i = 0; i < steps; ++i) {
    trial.step();
    lowest.add(trial.time(), lean_of(top_axis(trial)));
  }
  if (lowest.count() < 2) return {precession_error, lean_error * 180.0 / kPi, kNone, kNone};
  const double depth = std::acos(truth.lowest_cosine) - kLean;
  double worst = 0.0;
  for (std::size_t i = 0; i < lowest.count(); ++i) {
    worst = std::max(worst, std::abs((lowest.value(i) - kLean) / depth - 1.0));
  }
  return {precession_error, lean_error * 180.0 / kPi, worst,
          std::abs(lowest.mean_period() / truth.period - 1.0)};
}

// --- the T-handle: a bar along z, a handle along x from its middle, the origin at the center of mass ---

namespace {

struct Handle {
  Scene scene;
  FreeBody body;
  std::array<int, 3> axis{};  // of the body, for each of FreeBody's
};

Handle t_handle() {
  const Vector bar{0.05, 0.05, 0.4};
  const Vector rod{0.15, 0.05, 0.05};
  const double bar_mass = 8.0 * bar.x * bar.y * bar.z * kDensity;
  const double rod_mass = 8.0 * rod.x * rod.y * rod.z * kDensity;
  const double apart = bar.x + rod.x;
  const double bar_x = -apart * rod_mass / (bar_mass + rod_mass);
  const double rod_x = bar_x + apart;
  Handle handle;
  handle.scene = rotation_scene("t_handle");
  handle.scene.settings.gravity = {};
  const auto add = [&](Vector half, double x) {
    return scenes::add_shape(handle.scene, Box{to_float(half)}, {},
                             {.local_pose = {{static_cast<float>(x), 0.0f, 0.0f}, {}}});
  };
  const std::uint32_t first = add(bar, bar_x);
  add(rod, rod_x);
  double inertia[3] = {};
  for (const auto& [half, mass, x] : {std::tuple{bar, bar_mass, bar_x}, std::tuple{rod, rod_mass, rod_x}}) {
    inertia[0] += mass / 3.0 * (half.y * half.y + half.z * half.z);
    inertia[1] += mass / 3.0 * (half.x * half.x + half.z * half.z) + mass * x * x;
    inertia[2] += mass / 3.0 * (half.x * half.x + half.y * half.y) + mass * x * x;
  }
  // About the bar (z) it is least, about the handle (x) in between, about y most.
  handle.axis = {2, 0, 1};
  const double velocity[3] = {0.0, 6.0, 0.06};
  for (std::size_t i = 0; i < 3; ++i) {
    handle.body.inertia[i] = inertia[handle.axis[i]];
    handle.body.velocity[i] = velocity[i];
  }
  BodyDef def;
  for (std::size_t i = 0; i < 3; ++i) def.angular_velocity[handle.axis[i]] = static_cast<float>(velocity[i]);
  scenes::add_body(handle.scene, def, first, 2);
  return handle;
}

struct RotationState {
  double middle = 0.0;  // rad/s, about the middle axis
  double energy = 0.0;
  Vector momentum;
};

RotationState rotation_of(const Handle& handle, const BodyMotion& motion) {
  const Vector w = rotate_back(motion.pose.rotation, to_vector(motion.angular_velocity));
  const double components[3] = {w.x, w.y, w.z};
  double momentum[3] = {};
  RotationState state;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(handle.axis[i]);
    momentum[axis] = handle.body.inertia[i] * components[axis];
    state.energy += 0.5 * momentum[axis] * components[axis];
  }
  state.middle = components[handle.axis[1]];
  state.momentum = rotate(motion.pose.rotation, Vector{momentum[0], momentum[1], momentum[2]});
  return state;
}

}  // namespace

std::vector<double> measure_t_handle(Run& run) {
  const Handle handle = t_handle();
  const double flip = flip_time(handle.body);
  Trial trial(run, handle.scene);
  const RotationState first = rotation_of(handle, trial.body(0));
  Crossings flips;
  double energy = 0.0;
  double momentum = 0.0;
  const int steps = trial.steps_in(10.5 * flip);
  for (int i = 0; i < steps; ++i) {
    trial.step();
    const RotationState now = rotation_of(handle, trial.body(0));
    flips.add(trial.time(), now.middle);
    energy = std::max(energy, std::abs(now.energy / first.energy - 1.0));
    momentum = std::max(momentum, length(now.momentum - first.momentum) / length(first.momentum));
  }
  return {std::abs(flips.mean_interval() / flip - 1.0), energy, momentum};
}

// --- pendulums: a bar on a hinge at its end, released at rest ---

namespace {

struct PendulumErrors {
  double period = kNone;
  double energy = 0.0;
};

PendulumErrors swing(Run& run, double degrees) {
  constexpr double kHalf = 0.5;   // m, of the bar
  constexpr double kThin = 0.05;  // m, half
  constexpr int kSwings = 20;
  const double amplitude = degrees * kPi / 180.0;
  Scene scene = rotation_scene("pendulum");
  const auto half = static_cast<float>(kHalf);
  const auto thin = static_cast<float>(kThin);
  const std::uint32_t shape = scenes::add_shape(scene, Box{{thin, half, thin}});
  const Vector down{0.0, -std::cos(amplitude), -std::sin(amplitude)};
  BodyDef def;
  def.position = to_float(kHalf * down);
  def.rotation = {static_cast<float>(std::sin(0.5 * amplitude)), 0.0f, 0.0f,
                  static_cast<float>(std::cos(0.5 * amplitude))};
  const std::uint32_t body = scenes::add_body(scene, def, shape);
  JointDef joint;
  joint.frame_b.position.y = half;
  scenes::add_joint(scene, scenes::kWorldItself, body, HingeJoint{}, joint);
  // Over the mass.
  const double center_inertia = (kHalf * kHalf + kThin * kThin) / 3.0;
  const double omega = std::sqrt(kGravity * kHalf / (center_inertia + kHalf * kHalf));
  const double period = pendulum_period(omega, amplitude);
  Trial trial(run, scene);
  const auto energy = [&] {
    const BodyMotion& motion = trial.body(body);
    const Vector v = to_vector(motion.linear_velocity);
    const Vector w = to_vector(motion.angular_velocity);
    return 0.5 * dot(v, v) + 0.5 * center_inertia * dot(w, w) + kGravity * double{motion.pose.position.y};
  };
  const double first = energy();
  // What swings: the energy over that at the lowest point.
  const double whole = kGravity * kHalf * (1.0 - std::cos(amplitude));
  PendulumErrors errors;
  Crossings crossings;
  const int steps = trial.steps_in(period * (kSwings + 0.6));
  for (int i = 0; i < steps; ++i) {
    trial.step();
    crossings.add(trial.time(), rotate(trial.body(body).pose.rotation, Vector{0.0, 1.0, 0.0}).z);
    errors.energy = std::max(errors.energy, std::abs(energy() - first) / whole);
  }
  errors.period = std::abs(2.0 * crossings.mean_interval() / period - 1.0);
  return errors;
}

}  // namespace

std::vector<double> measure_pendulum(Run& run) {
  const PendulumErrors small = swing(run, 10.0);
  const PendulumErrors wide = swing(run, 90.0);
  const PendulumErrors widest = swing(run, 170.0);
  return {small.period, wide.period, widest.period, std::max({small.energy, wide.energy, widest.energy})};
}

}  // namespace scree::accuracy
