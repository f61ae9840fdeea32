// Joints against closed-form mechanics: pendulums, chains, tops.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace scree::physics {
namespace {

constexpr double kPi = std::numbers::pi;

JointDef to_world(BodyId body, Vec3 anchor_in_world, Vec3 anchor_in_body) {
  return {
      .body_a = kWorld, .body_b = body, .frame_a = {anchor_in_world, {}}, .frame_b = {anchor_in_body, {}}};
}

WorldSettings with_substeps(int substeps) {
  WorldSettings settings = without_sleep();
  settings.substeps = substeps;
  return settings;
}

// The z axis of frames whose x axis is the world's z axis: pendulums swing in the plane of x and y.
const Quat kAboutZ = rotation_about({0, 1, 0}, -0.5 * kPi);

// A rod that hangs from the origin and is turned out by an angle about z.
constexpr float kArm = 1.0f;  // m, from the origin to the center of the rod
struct Pendulum {
  Lab lab;
  BodyId body;

  Pendulum(const Joint& joint, double angle) {
    const Quat turn = rotation_about({0, 0, 1}, angle);
    const Eigen::Vector3d center = to_eigen(turn) * Eigen::Vector3d(0, -kArm, 0);
    body = lab.add({.position = {static_cast<float>(center.x()), static_cast<float>(center.y()), 0.0f},
                    .rotation = turn},
                   Box{{0.1f, 0.5f, 0.1f}});
    JointDef def = to_world(body, {}, {0, kArm, 0});
    def.frame_a.rotation = def.frame_b.rotation = kAboutZ;
    lab.world.create_joint(def, joint);
  }
  double angle() const { return std::atan2(lab.position(body).x(), -lab.position(body).y()); }

  // Mean of the first periods.
  double period(int periods) {
    std::vector<double> crossings;
    double last = angle();
    for (int i = 0; crossings.size() < static_cast<std::size_t>(periods) + 1 && i < 6000; ++i) {
      lab.run(1);
      const double now = angle();
      if (last < 0 && now >= 0) crossings.push_back(static_cast<double>(kStep) * (i + last / (last - now)));
      last = now;
    }
    if (crossings.size() < 2) return 0.0;
    return (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  }
  double small_period() const {
    const double mass = lab.mass(body), arm = static_cast<double>(kArm);
    const double inertia = lab.inertia(body)(2, 2) + mass * arm * arm;
    return 2 * kPi * std::sqrt(inertia / (mass * kGravity * arm));
  }
};

// Ratio of a pendulum's period to that of small swings: 1 / AGM(1, cos(angle / 2)), by Gauss.
double stretch_of_period(double angle) {
  double a = 1.0, b = std::cos(0.5 * angle);
  for (int i = 0; i < 30; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 1.0 / a;
}

class PendulumPeriod : public testing::TestWithParam<std::tuple<JointType, double>> {};

Joint plain(JointType type) { return type == JointType::hinge ? Joint(HingeJoint{}) : Joint(BallJoint{}); }

TEST_P(PendulumPeriod, IsThatOfTheEllipticIntegral) {
  const auto [type, angle] = GetParam();
  Pendulum pendulum(plain(type), angle);
  const double expected = pendulum.small_period() * stretch_of_period(angle);
  const double measured = pendulum.period(5);
  RecordProperty("error", std::to_string(measured / expected - 1.0));
  EXPECT_NEAR(measured / expected, 1.0, 0.005);
}

INSTANTIATE_TEST_SUITE_P(SmallAndLarge, PendulumPeriod,
                         testing::Combine(testing::Values(JointType::ball, JointType::hinge),
                                          testing::Values(0.05, 1.0, 2.0)),
                         [](const auto& parameters) {
                           const bool hinge = std::get<0>(parameters.param) == JointType::hinge;
                           return std::string(hinge ? "Hinge" : "Ball") +
                                  std::to_string(static_cast<int>(std::get<1>(parameters.param) * 100));
                         });

double potential_energy(const Lab& lab, BodyId body, double rest_height) {
  return lab.mass(body) * kGravity * (lab.height(body) - rest_height);
}
double kinetic_energy(const Lab& lab, BodyId body) {
  const Eigen::Vector3d v = lab.velocity(body), w = lab.spin(body);
  return 0.5 * lab.mass(body) * v.squaredNorm() + 0.5 * w.dot(lab.inertia(body) * w);
}

TEST(DoublePendulum, KeepsItsEnergyForAMinute) {
  Lab lab(with_substeps(8));
  std::vector<BodyId> rods;
  const Vec3 half{0.5f, 0.05f, 0.05f};
  for (int i = 0; i < 2; ++i) {
    rods.push_back(
        lab.add({.position = {0.5f + static_cast<float>(i), 0, 0}}, Box{half}, {.density = 500.0f}));
  }
  lab.world.create_joint(to_world(rods[0], {}, {-0.5f, 0, 0}), BallJoint{});
  lab.world.create_joint(
      {.body_a = rods[0], .body_b = rods[1], .frame_a = {{0.5f, 0, 0}, {}}, .frame_b = {{-0.5f, 0, 0}, {}}},
      BallJoint{});
  const auto energy = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < rods.size(); ++i) {
      sum += kinetic_energy(lab, rods[i]) + potential_energy(lab, rods[i], -0.5 - static_cast<double>(i));
    }
    return sum;
  };
  const double first = energy();
  double least = first, most = first;
  for (int i = 0; i < 3600; ++i) {
    lab.run(1);
    least = std::min(least, energy());
    most = std::max(most, energy());
  }
  RecordProperty("least", std::to_string(least / first));
  RecordProperty("most", std::to_string(most / first));
  EXPECT_LE(most, 1.01 * first);
  EXPECT_GE(least, 0.80 * first);
}

// A chain of links of one meter that hangs from the origin.
struct Chain {
  Lab lab;
  std::vector<BodyId> links;

  Chain(int count, const WorldSettings& settings) : lab(settings) {
    BodyId above = kWorld;
    for (int i = 0; i < count; ++i) {
      const BodyId link = lab.add({.position = {0, -0.5f - static_cast<float>(i), 0}}, Capsule{0.4f, 0.1f});
      JointDef def{.body_a = above, .body_b = link, .frame_b = {{0, 0.5f, 0}, {}}};
      if (i > 0) def.frame_a.position = {0, -0.5f, 0};
      lab.world.create_joint(def, BallJoint{});
      links.push_back(above = link);
    }
  }
  // Error of the last link's end, over the length of the chain.
  double stretch() const {
    const Pose pose = lab.world.pose(links.back());
    const Eigen::Vector3d end =
        to_eigen(pose.position) + to_eigen(pose.rotation) * Eigen::Vector3d(0, -0.5, 0);
    return end.norm() / static_cast<double>(links.size()) - 1.0;
  }
};

TEST(Chain, OfAHundredLinksStretchesByLessThanTwoPercent) {
  Chain chain(100, with_substeps(8));
  double worst = 0.0;
  for (int i = 0; i < 20; ++i) {
    chain.lab.run(60);
    if (i >= 10) worst = std::max(worst, std::abs(chain.stretch()));
  }
  RecordProperty("stretch", std::to_string(worst));
  EXPECT_LT(worst, 0.02);
}

TEST(Chain, OfAThousandLinksStaysFinite) {
  Chain chain(1000, with_substeps(8));
  chain.lab.run(600);
  RecordProperty("stretch", std::to_string(chain.stretch()));
  EXPECT_TRUE(std::isfinite(chain.stretch()));
  EXPECT_EQ(chain.lab.world.stats().restored_bodies, 0);
}

TEST(Chain, BearsAThousandTimesTheWeightOfALink) {
  Chain chain(10, with_substeps(16));
  const float link_mass = chain.lab.world.mass_properties(chain.links[0]).mass;
  const BodyId weight =
      chain.lab.add({.position = {0, -10.5f, 0}, .mass = 1000.0f * link_mass}, Box{{0.5f, 0.5f, 0.5f}});
  chain.lab.world.create_joint({.body_a = chain.links.back(),
                                .body_b = weight,
                                .frame_a = {{0, -0.5f, 0}, {}},
                                .frame_b = {{0, 0.5f, 0}, {}}},
                               BallJoint{});
  double worst = 0.0;
  for (int i = 0; i < 240 * 20; ++i) {
    chain.lab.run(1, 1.0f / 240.0f);
    if (i >= 240 * 10) worst = std::max(worst, std::abs(chain.stretch()));
  }
  RecordProperty("stretch", std::to_string(worst));
  EXPECT_LT(worst, 0.05);
}

// A disk on a rod that starts with the steady precession of a level axle: I3 spin rate = m g arm.
TEST(SpinningTop, PrecessesAtThePredictedRate) {
  for (const double spin : {30.0, 100.0}) {
    Lab lab;
    const BodyId top = lab.world.create_body({.position = {0.5f, 0, 0}});
    lab.world.set_mass_properties(top, {.mass = 2.0f, .inertia = {0.09f, 0.05f, 0.05f}});
    const double rate = 2.0 * kGravity * 0.5 / (0.09 * spin);
    lab.world.set_angular_velocity(top, {static_cast<float>(spin), static_cast<float>(rate), 0});
    lab.world.set_linear_velocity(top, {0, 0, static_cast<float>(-0.5 * rate)});
    lab.world.create_joint(to_world(top, {}, {-0.5f, 0, 0}), BallJoint{});
    double turned = 0.0, last = 0.0;
    const int steps = 300;
    for (int i = 0; i < steps; ++i) {
      lab.run(1);
      const double now = std::atan2(-lab.position(top).z(), lab.position(top).x());
      turned += std::remainder(now - last, 2 * kPi);
      last = now;
    }
    const double measured = turned / (steps * static_cast<double>(kStep));
    RecordProperty("ratio_" + std::to_string(static_cast<int>(spin)), std::to_string(measured / rate));
    EXPECT_NEAR(measured / rate, 1.0, 0.03) << "spin " << spin;
    EXPECT_LT(std::abs(lab.height(top)), 0.1) << "spin " << spin;
  }
}

}  // namespace
}  // namespace scree::physics
