// Laws of the accuracy suite's formulas: known values, and equations of motion integrated in small steps.
#include <gtest/gtest.h>
#include <tools/accuracy/truth.h>

#include <array>
#include <cmath>
#include <functional>

namespace {

using scree::accuracy::kPi;

template <std::size_t N>
using State = std::array<double, N>;

// Classical Runge-Kutta of fourth order.
template <std::size_t N>
State<N> advance(const State<N>& state, double dt, const std::function<State<N>(const State<N>&)>& rate) {
  const auto moved = [&](const State<N>& slope, double by) {
    State<N> result = state;
    for (std::size_t i = 0; i < N; ++i) result[i] += by * slope[i];
    return result;
  };
  const State<N> a = rate(state);
  const State<N> b = rate(moved(a, 0.5 * dt));
  const State<N> c = rate(moved(b, 0.5 * dt));
  const State<N> d = rate(moved(c, dt));
  State<N> result = state;
  for (std::size_t i = 0; i < N; ++i) result[i] += dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
  return result;
}

TEST(AccuracyTruth, EllipticIntegralHasItsTabulatedValues) {
  // Abramowitz and Stegun, table 17.1.
  EXPECT_NEAR(scree::accuracy::elliptic_k(0.0), 1.570796326794897, 1e-14);
  EXPECT_NEAR(scree::accuracy::elliptic_k(0.5), 1.854074677301372, 1e-14);
  EXPECT_NEAR(scree::accuracy::elliptic_k(0.99), 3.695637362989875, 1e-13);
}

TEST(AccuracyTruth, PendulumSwingsWithTheIntegratedPeriod) {
  constexpr double kOmega = 3.7;
  const std::function<State<2>(const State<2>&)> rate = [](const State<2>& s) {
    return State<2>{s[1], -kOmega * kOmega * std::sin(s[0])};
  };
  for (const double degrees : {10.0, 90.0, 170.0}) {
    const double amplitude = degrees * kPi / 180.0;
    constexpr int kSteps = 20000;
    const double quarter = 0.25 * scree::accuracy::pendulum_period(kOmega, amplitude);
    State<2> state{amplitude, 0.0};
    for (int i = 0; i < kSteps; ++i) state = advance(state, quarter / kSteps, rate);
    EXPECT_NEAR(state[0], 0.0, 1e-9) << degrees;
  }
}

// Inclination, its rate and the azimuth of a top; the momentum about the vertical is given.
std::function<State<3>(const State<3>&)> top_motion(const scree::accuracy::Top& top, double vertical) {
  return [=](const State<3>& s) {
    const double sine = std::sin(s[0]);
    const double cosine = std::cos(s[0]);
    const double turn = (vertical - top.inertia_axis * top.spin * cosine) / (top.inertia_tip * sine * sine);
    const double bend = turn * turn * sine * cosine -
                        (top.inertia_axis * top.spin * turn - top.torque) * sine / top.inertia_tip;
    return State<3>{s[1], bend, turn};
  };
}

constexpr scree::accuracy::Top kTop{.inertia_tip = 0.59, .inertia_axis = 0.43, .torque = 23.0, .spin = 40.0};

TEST(AccuracyTruth, SteadyPrecessionKeepsTheInclination) {
  constexpr double kLean = 0.5;
  const double precession = scree::accuracy::steady_precession(kTop, std::cos(kLean));
  const double vertical = kTop.inertia_tip * std::sin(kLean) * std::sin(kLean) * precession +
                          kTop.inertia_axis * kTop.spin * std::cos(kLean);
  State<3> state{kLean, 0.0, 0.0};
  for (int i = 0; i < 30000; ++i) state = advance(state, 1e-4, top_motion(kTop, vertical));
  EXPECT_NEAR(state[0], kLean, 1e-9);
  EXPECT_NEAR(state[2], 3.0 * precession, 1e-8);
}

TEST(AccuracyTruth, TopReleasedAtRestNutatesAsDeepAndAsLongAsIntegrated) {
  constexpr double kLean = 0.5;
  const scree::accuracy::Nutation nutation = scree::accuracy::nutation_from_rest(kTop, std::cos(kLean));
  const double vertical = kTop.inertia_axis * kTop.spin * std::cos(kLean);
  constexpr int kSteps = 20000;
  State<3> state{kLean, 0.0, 0.0};
  double deepest = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    state = advance(state, nutation.period / kSteps, top_motion(kTop, vertical));
    deepest = std::max(deepest, state[0]);
  }
  EXPECT_NEAR(deepest, std::acos(nutation.lowest_cosine), 1e-9);
  EXPECT_NEAR(state[0], kLean, 1e-9);
  EXPECT_NEAR(state[1], 0.0, 1e-7);
}

TEST(AccuracyTruth, FreeBodyFlipsAfterTheIntegratedTime) {
  // Disturbed about the axis of the least inertia, then of the largest.
  for (const std::array<double, 3>& velocity : {std::array{0.1, 6.0, 0.0}, std::array{0.0, 6.0, 0.1}}) {
    scree::accuracy::FreeBody body;
    for (std::size_t i = 0; i < 3; ++i) body.velocity[i] = velocity[i];
    const auto& inertia = body.inertia;
    const std::function<State<3>(const State<3>&)> euler = [&](const State<3>& w) {
      return State<3>{(inertia[1] - inertia[2]) / inertia[0] * w[1] * w[2],
                      (inertia[2] - inertia[0]) / inertia[1] * w[2] * w[0],
                      (inertia[0] - inertia[1]) / inertia[2] * w[0] * w[1]};
    };
    constexpr int kSteps = 20000;
    const double flip = scree::accuracy::flip_time(body);
    State<3> state = velocity;
    for (int i = 0; i < kSteps; ++i) state = advance(state, flip / kSteps, euler);
    EXPECT_NEAR(state[1], -velocity[1], 1e-8);
    EXPECT_NEAR(std::abs(state[0]), velocity[0], 1e-8);
    EXPECT_NEAR(std::abs(state[2]), velocity[2], 1e-8);
  }
}

TEST(AccuracyTruth, PlateAndBallsObeyNewtonAndTheBallsRoll) {
  const auto [plate, ball] = scree::accuracy::rolling_accelerations(150.0, 10.0, 1.0, 25, 0.4, 9.81);
  EXPECT_NEAR(10.0 * plate + 25.0 * ball + 0.4 * 35.0 * 9.81, 150.0, 1e-12);
  EXPECT_NEAR(ball, 2.0 / 7.0 * plate, 1e-12);
  EXPECT_GT(plate, 0.0);
}

TEST(AccuracyTruth, FirstDominoFallsAsIntegrated) {
  const scree::accuracy::Dominoes dominoes;
  const double angle = scree::accuracy::domino_hit_angle(dominoes);
  EXPECT_NEAR(std::sin(angle) * dominoes.height, dominoes.spacing, 1e-15);
  const double time = scree::accuracy::domino_times(dominoes, 1, angle).front();
  const double inertia = (dominoes.height * dominoes.height + dominoes.thickness * dominoes.thickness) / 3.0;
  const std::function<State<2>(const State<2>&)> rate = [&](const State<2>& s) {
    const double arm = 0.5 * (dominoes.height * std::sin(s[0]) - dominoes.thickness * std::cos(s[0]));
    return State<2>{s[1], dominoes.gravity * arm / inertia};
  };
  State<2> state{0.0, dominoes.first_speed};
  for (int i = 0; i < 10000; ++i) state = advance(state, time / 10000, rate);
  EXPECT_NEAR(state[0], angle, 1e-9);
}

TEST(AccuracyTruth, DominoWaveForgetsHowItBegan) {
  scree::accuracy::Dominoes slow;
  scree::accuracy::Dominoes fast;
  fast.first_speed = 5.0;
  const std::vector<double> a = scree::accuracy::domino_times(slow, 40, 0.1);
  const std::vector<double> b = scree::accuracy::domino_times(fast, 40, 0.1);
  EXPECT_GT(a[1] - a[0], 1.5 * (b[1] - b[0]));
  EXPECT_NEAR(a[39] - a[38], b[39] - b[38], 1e-8);
}

TEST(AccuracyTruth, ArchOfManyVoussoirsStandsFromMilankovitchsThicknessOn) {
  EXPECT_NEAR(scree::accuracy::least_arch_thickness(2001), 0.1075, 1e-4);
  const double least = scree::accuracy::least_arch_thickness(17);
  EXPECT_FALSE(scree::accuracy::arch_thrust(17, 0.999 * least).stands);
  const scree::accuracy::ThrustRange thin = scree::accuracy::arch_thrust(17, 1.001 * least);
  const scree::accuracy::ThrustRange thick = scree::accuracy::arch_thrust(17, 1.5 * least);
  EXPECT_TRUE(thin.stands);
  EXPECT_LT(thin.most - thin.least, 0.01 * thin.least);  // at the limit there is one line of thrust only
  EXPECT_LT(thick.least, thin.least);
  EXPECT_GT(thick.most, thin.most);
}

}  // namespace
