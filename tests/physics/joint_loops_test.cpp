// Laws of joints in closed loops, which are overconstrained.
#include <tests/physics/lab.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace scree::physics {
namespace {

constexpr double kLoopPi = std::numbers::pi;
// The z axis of frames whose x axis is the world's z axis: everything turns in the plane of x and y.
const Quat kLoopsAboutZ = rotation_about({0, 1, 0}, -0.5 * kLoopPi);

Vec3 to_vec(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// A bar between two points of the plane z = 0.
BodyId add_bar(Lab& lab, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d along = to - from;
  const Quat turn = rotation_about({0, 0, 1}, std::atan2(along.y(), along.x()));
  return lab.add({.position = to_vec(0.5 * (from + to)), .rotation = turn},
                 Box{{0.5f * static_cast<float>(along.norm()), 0.05f, 0.05f}});
}

// A frame at a point of the world.
JointId add_hinge(Lab& lab, BodyId a, BodyId b, const Eigen::Vector3d& at, const JointAxis& angle = {}) {
  const auto frame = [&](BodyId body) {
    const Eigen::Quaterniond turn =
        body == kWorld ? Eigen::Quaterniond::Identity() : to_eigen(lab.world.pose(body).rotation);
    const Eigen::Vector3d center = body == kWorld ? Eigen::Vector3d(0, 0, 0) : lab.position(body);
    const Eigen::Quaterniond q = turn.conjugate() * to_eigen(kLoopsAboutZ);
    return Pose{to_vec(turn.conjugate() * (at - center)),
                {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                 static_cast<float>(q.w())}};
  };
  return lab.world.create_joint({.body_a = a, .body_b = b, .frame_a = frame(a), .frame_b = frame(b)},
                                HingeJoint{angle});
}

// Two equal cranks side by side and a coupler bar between their ends, which does not turn: a pendulum.
TEST(JointLoop, AParallelogramSwingsAsThePendulumThatItIs) {
  constexpr double kLength = 1.5, kWidth = 2.0, kAngle = 0.1;
  Lab lab(without_sleep());
  const Eigen::Vector3d left(0, 0, 0), right(kWidth, 0, 0);
  const Eigen::Vector3d hang(kLength * std::sin(kAngle), -kLength * std::cos(kAngle), 0);
  const BodyId crank = add_bar(lab, left, left + hang), other = add_bar(lab, right, right + hang);
  const BodyId coupler = add_bar(lab, left + hang, right + hang);
  add_hinge(lab, kWorld, crank, left);
  add_hinge(lab, kWorld, other, right);
  add_hinge(lab, crank, coupler, left + hang);
  add_hinge(lab, coupler, other, right + hang);
  const double rod = lab.mass(crank), bar = lab.mass(coupler), half = 0.5 * kLength;
  const double inertia = 2 * (lab.inertia(crank)(2, 2) + rod * half * half) + bar * kLength * kLength;
  const double expected = 2 * kLoopPi * std::sqrt(inertia / ((2 * rod * half + bar * kLength) * kGravity)) *
                          (1 + kAngle * kAngle / 16);
  std::vector<double> crossings;
  double last = kAngle;
  for (int i = 0; i < 1200; ++i) {
    lab.run(1);
    const double now = lab.position(coupler).x() - 0.5 * kWidth;
    if (last < 0 && now >= 0) crossings.push_back(static_cast<double>(kStep) * (i + last / (last - now)));
    last = now;
    EXPECT_LT(std::abs(lab.spin(coupler).z()), 2e-3) << "step " << i;
  }
  ASSERT_GT(crossings.size(), 4u);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(period / expected, 1.0, 0.005);
}

// A motor drives the short bar of a four-bar linkage. Plane geometry gives the position of the joint between
// the other two bars.
TEST(JointLoop, ACrankRockerKeepsToItsGeometry) {
  constexpr double kCrank = 1.0, kCoupler = 3.5, kRocker = 3.0, kSpeed = 3.0;
  const Eigen::Vector3d at_crank(0, 0, 0), at_rocker(4, 0, 0);
  const auto meeting = [&](const Eigen::Vector3d& end) {  // of the circles about both ends, above
    const Eigen::Vector3d way = at_rocker - end;
    const double distance = way.norm();
    const double along = (kCoupler * kCoupler - kRocker * kRocker + distance * distance) / (2 * distance);
    const Eigen::Vector3d unit = way / distance, up(-unit.y(), unit.x(), 0);
    return Eigen::Vector3d(end + along * unit + std::sqrt(kCoupler * kCoupler - along * along) * up);
  };
  Lab lab(without_sleep());
  const Eigen::Vector3d end(kCrank, 0, 0), top = meeting(end);
  const BodyId crank = add_bar(lab, at_crank, end), coupler = add_bar(lab, end, top);
  const BodyId rocker = add_bar(lab, at_rocker, top);
  add_hinge(lab, kWorld, crank, at_crank, {.drive = Drive::motor, .speed = static_cast<float>(kSpeed)});
  add_hinge(lab, crank, coupler, end);
  add_hinge(lab, coupler, rocker, top);
  add_hinge(lab, kWorld, rocker, at_rocker);
  double turned = 0.0, last = 0.0;
  for (int i = 0; i < 600; ++i) {
    lab.run(1);
    const Eigen::Vector3d now = 2.0 * lab.position(crank);
    const double angle = std::atan2(now.y(), now.x());
    turned += std::remainder(angle - last, 2 * kLoopPi);
    last = angle;
    const Eigen::Vector3d tip = at_rocker + 2.0 * (lab.position(rocker) - at_rocker);
    // The unbounded motor starts with a shock.
    EXPECT_LT((tip - meeting(now)).norm(), i < 10 ? 2e-2 : 2e-3) << "step " << i;
  }
  EXPECT_NEAR(turned, kSpeed * 10.0, 0.1);
}

TEST(JointLoop, AFlyingNecklaceKeepsItsMomentumAndGainsNoEnergy) {
  constexpr int kBeads = 24;
  constexpr double kRadius = 2.0;
  WorldSettings settings = without_gravity();
  settings.substeps = 8;
  Lab lab(settings);
  Random random(11);
  std::vector<BodyId> beads;
  const auto at = [&](double place) {
    const double turn = 2 * kLoopPi * place / kBeads;
    return Eigen::Vector3d(kRadius * std::cos(turn), kRadius * std::sin(turn), 0);
  };
  for (int i = 0; i < kBeads; ++i) {
    beads.push_back(lab.add({.position = to_vec(at(i)),
                             .linear_velocity = random.vector(1),
                             .angular_velocity = random.vector(2)},
                            Sphere{0.2f}));
  }
  std::vector<JointId> joints;
  for (int i = 0; i < kBeads; ++i) {
    const std::size_t next = static_cast<std::size_t>(i + 1) % kBeads;
    const Eigen::Vector3d middle = 0.5 * (at(i) + at(i + 1));
    const BodyId a = beads[static_cast<std::size_t>(i)], b = beads[next];
    joints.push_back(lab.world.create_joint({.body_a = a,
                                             .body_b = b,
                                             .frame_a = {to_vec(middle - lab.position(a)), {}},
                                             .frame_b = {to_vec(middle - lab.position(b)), {}}},
                                            BallJoint{}));
  }
  const auto sum = [&](Eigen::Vector3d& linear, Eigen::Vector3d& angular) {
    linear = angular = Eigen::Vector3d::Zero();
    double energy = 0.0;
    for (const BodyId bead : beads) {
      const Eigen::Vector3d momentum = lab.mass(bead) * lab.velocity(bead);
      linear += momentum;
      angular += lab.position(bead).cross(momentum) + lab.angular_momentum(bead);
      energy += lab.kinetic_energy(bead);
    }
    return energy;
  };
  Eigen::Vector3d linear, angular, linear_now, angular_now;
  double energy = sum(linear, angular);
  const double scale = std::sqrt(2.0 * energy * kBeads * lab.mass(beads[0]));
  for (int i = 0; i < 30; ++i) {
    lab.run(10);
    const double now = sum(linear_now, angular_now);
    EXPECT_LT((linear_now - linear).norm(), 1e-4 * scale) << "step " << 10 * i;
    EXPECT_LT((angular_now - angular).norm(), 1e-2 * scale * kRadius) << "step " << 10 * i;
    EXPECT_LT(now, 1.001 * energy) << "step " << 10 * i;
    energy = now;
    for (const JointId joint : joints)
      EXPECT_LT(to_eigen(lab.world.joint_pose(joint).position).norm(), 5e-3) << "step " << 10 * i;
  }
  EXPECT_GT(energy, 0.0);
}

}  // namespace
}  // namespace scree::physics
