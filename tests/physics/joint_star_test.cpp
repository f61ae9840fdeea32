// Laws of stars: many bodies joined to one body, the hub.
#include <tests/physics/lab.h>

#include <algorithm>
#include <numbers>

namespace scree::physics {
namespace {

constexpr float kStarRadius = 0.5f;  // m, of all bodies

struct StarPlan {
  int leaves = 16;
  float hub_mass = 33.0f, leaf_mass = 33.0f;
  bool box_hub = false;
  float hub_arm = 0.5f, leaf_arm = 0.5f;  // m, from the centers to the anchor between them
  bool in_plane = false;                  // else in all directions
  Joint joint = BallJoint{};
};

struct Star {
  BodyId hub;
  std::vector<BodyId> leaves;
  std::vector<JointId> joints;

  std::vector<BodyId> bodies() const {
    std::vector<BodyId> all = leaves;
    all.push_back(hub);
    return all;
  }
};

Vec3 to_vec3(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// Shapes that touch nothing.
BodyId add_loose(Lab& lab, const Eigen::Vector3d& at, float mass, bool box = false) {
  const float volume = box ? 8.0f * kStarRadius * kStarRadius * kStarRadius
                           : 4.18879f * kStarRadius * kStarRadius * kStarRadius;
  const BodyId body = lab.world.create_body({.position = to_vec3(at)});
  const Geometry geometry =
      box ? Geometry(Box{{kStarRadius, kStarRadius, kStarRadius}}) : Geometry(Sphere{kStarRadius});
  lab.world.add_shape(body, geometry, {.density = mass / volume}, {.filter = {.category = 0, .mask = 0}});
  return body;
}

// Joins two bodies that have not turned yet, at a point.
JointId join_at(Lab& lab, BodyId a, BodyId b, const Eigen::Vector3d& point, const Joint& joint) {
  JointDef def{.body_a = a, .body_b = b};
  def.frame_a.position = to_vec3(a == kWorld ? point : Eigen::Vector3d(point - lab.position(a)));
  def.frame_b.position = to_vec3(point - lab.position(b));
  return lab.world.create_joint(def, joint);
}

Eigen::Vector3d direction_of(const StarPlan& plan, int leaf, Random& random) {
  if (plan.in_plane) {
    const double angle = 2.0 * std::numbers::pi * leaf / plan.leaves;
    return {std::cos(angle), std::sin(angle), 0.0};
  }
  Eigen::Vector3d way;
  do way = to_eigen(random.vector(1.0f));
  while (way.norm() > 1.0 || way.norm() < 0.1);
  return way.normalized();
}

Star add_star(Lab& lab, const StarPlan& plan, const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  Random random(static_cast<std::uint64_t>(plan.leaves));
  Star star{add_loose(lab, center, plan.hub_mass, plan.box_hub), {}, {}};
  for (int i = 0; i < plan.leaves; ++i) {
    const Eigen::Vector3d way = direction_of(plan, i, random);
    const auto hub_arm = static_cast<double>(plan.hub_arm), leaf_arm = static_cast<double>(plan.leaf_arm);
    star.leaves.push_back(add_loose(lab, center + way * (hub_arm + leaf_arm), plan.leaf_mass));
    star.joints.push_back(join_at(lab, star.hub, star.leaves.back(), center + way * hub_arm, plan.joint));
  }
  return star;
}

void kick(Lab& lab, const std::vector<BodyId>& bodies, float speed) {
  Random random(5);
  for (const BodyId body : bodies) lab.world.set_linear_velocity(body, random.vector(speed));
}

struct Sums {
  double mass = 0.0, energy = 0.0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular_momentum = Eigen::Vector3d::Zero();
};
Sums sums_of(const Lab& lab, const std::vector<BodyId>& bodies) {
  Sums sums;
  for (const BodyId body : bodies) {
    const Eigen::Vector3d momentum = lab.mass(body) * lab.velocity(body);
    sums.mass += lab.mass(body);
    sums.energy += lab.kinetic_energy(body);
    sums.momentum += momentum;
    sums.angular_momentum += lab.position(body).cross(momentum) + lab.angular_momentum(body);
  }
  return sums;
}

// Largest distance in m between the joint's anchors where they are held.
double gap_of(const Lab& lab, JointId joint) {
  const Vec3 offset = lab.world.joint_pose(joint).position;
  const bool slides = lab.world.joint_type(joint) == JointType::slider;
  return to_eigen(Vec3{slides ? 0.0f : offset.x, offset.y, offset.z}).norm();
}

// Expects that bodies set in motion without gravity never gain energy and keep their momentum. The angular
// momentum may change by the couples of forces over the gap between two anchors. `scale`: the masses' speeds,
// kg m/s; arms are about 1 m long.
void expect_passive(Lab& lab, const std::vector<BodyId>& bodies, const std::vector<JointId>& joints,
                    int steps, double scale) {
  const Sums before = sums_of(lab, bodies);
  double most = 0.0, gap = 0.0;
  for (int i = 0; i < steps; ++i) {
    lab.run(1);
    most = std::max(most, sums_of(lab, bodies).energy);
    for (const JointId joint : joints) gap = std::max(gap, gap_of(lab, joint));
  }
  const Sums after = sums_of(lab, bodies);
  EXPECT_LT(most, before.energy * 1.001);
  EXPECT_LT(gap, 0.2);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-4 * scale);
  EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), (1e-3 + gap) * scale);
}

constexpr float kKick = 0.1f;  // m/s

void expect_passive(const StarPlan& plan, int steps, int substeps = 4) {
  SCOPED_TRACE(std::to_string(plan.leaves) + " leaves of " + std::to_string(plan.leaf_mass) + " kg on " +
               std::to_string(plan.hub_mass) + " kg, " + std::to_string(substeps) + " substeps");
  WorldSettings settings = without_gravity();
  settings.substeps = substeps;
  Lab lab(settings);
  const Star star = add_star(lab, plan);
  kick(lab, star.leaves, kKick);
  expect_passive(lab, star.bodies(), star.joints, steps,
                 static_cast<double>(kKick) *
                     static_cast<double>(static_cast<float>(plan.leaves) * plan.leaf_mass + plan.hub_mass));
}

struct Masses {
  float hub, leaf;
};
constexpr Masses kMasses[] = {{33, 33}, {330, 33}, {33, 330}};

void expect_rest_in_free_fall(const StarPlan& plan, int steps) {
  SCOPED_TRACE(std::to_string(plan.leaves) + " leaves of " + std::to_string(plan.leaf_mass) + " kg on " +
               std::to_string(plan.hub_mass) + " kg");
  Lab lab;
  const Star star = add_star(lab, plan);
  lab.run(steps);
  const Eigen::Vector3d falls(0.0, -kGravity * steps * static_cast<double>(kStep), 0.0);
  double fastest = 0.0, spin = 0.0;
  for (const BodyId body : star.bodies()) {
    fastest = std::max(fastest, (lab.velocity(body) - falls).norm());
    spin = std::max(spin, lab.spin(body).norm());
  }
  EXPECT_LT(fastest, 1e-3);
  EXPECT_LT(spin, 2e-3);
}

TEST(JointStar, StaysAtRestInFreeFall) {
  for (const Masses& masses : kMasses) {
    for (const int leaves : {3, 4, 8, 16, 32, 33, 64, 65, 100, 700}) {
      for (const bool box : {false, true}) {
        expect_rest_in_free_fall(
            {.leaves = leaves, .hub_mass = masses.hub, .leaf_mass = masses.leaf, .box_hub = box}, 60);
      }
    }
  }
}

TEST(JointStar, OfThousandsStaysAtRestInFreeFall) {
  expect_rest_in_free_fall({.leaves = 3000}, 40);
  expect_rest_in_free_fall({.leaves = 10000}, 20);
}

TEST(JointStar, GainsNoEnergyAndKeepsMomentumAfterAKick) {
  for (const Masses& masses : kMasses) {
    for (const int leaves : {3, 4, 8, 16, 32, 33, 64, 100}) {
      for (const int substeps : {1, 4, 16}) {
        expect_passive({.leaves = leaves, .hub_mass = masses.hub, .leaf_mass = masses.leaf}, 120, substeps);
      }
    }
    expect_passive({.leaves = 700, .hub_mass = masses.hub, .leaf_mass = masses.leaf}, 60);
  }
}

TEST(JointStar, GainsNoEnergyForAnyLengthsOfItsArms) {
  for (const int leaves : {4, 8, 16, 33, 100}) {
    for (const bool in_plane : {false, true}) {
      expect_passive({.leaves = leaves, .hub_arm = 0.05f, .in_plane = in_plane}, 120);
      expect_passive({.leaves = leaves, .hub_arm = 2.0f, .leaf_arm = 0.1f, .in_plane = in_plane}, 120);
      expect_passive({.leaves = leaves, .hub_arm = 0.2f, .leaf_arm = 3.0f, .in_plane = in_plane}, 120);
    }
  }
}

TEST(JointStar, OfAnyKindGainsNoEnergy) {
  SixDegreeJoint six;
  for (JointAxis& offset : six.offset) offset.lower = offset.upper = 0.0f;
  six.angle[1].lower = six.angle[1].upper = 0.0f;
  const Joint kinds[] = {HingeJoint{},
                         SliderJoint{},
                         DistanceJoint{.length = {.lower = 0.0f, .upper = 0.0f}},
                         WeldJoint{},
                         six,
                         UniversalJoint{},
                         BallJoint{.cone_limit = 0.3f}};
  for (const Joint& kind : kinds) {
    SCOPED_TRACE("kind " + std::to_string(kind.index()));
    for (const Masses& masses : {Masses{33, 33}, Masses{33, 330}}) {
      for (const int leaves : {4, 8, 16, 40, 100}) {
        expect_passive({.leaves = leaves, .hub_mass = masses.hub, .leaf_mass = masses.leaf, .joint = kind},
                       120);
      }
    }
  }
}

TEST(JointStar, OfStarsGainsNoEnergy) {
  for (const int arms : {4, 8, 16, 33}) {
    for (const int fingers : {5, 12}) {
      SCOPED_TRACE(std::to_string(arms) + " stars of " + std::to_string(fingers));
      Lab lab(without_gravity());
      const Star star = add_star(lab, {.leaves = arms});
      std::vector<BodyId> bodies = star.bodies();
      std::vector<JointId> joints = star.joints;
      Random random(3);
      for (const BodyId leaf : star.leaves) {
        for (int i = 0; i < fingers; ++i) {
          const Eigen::Vector3d way = direction_of({}, i, random);
          bodies.push_back(add_loose(lab, lab.position(leaf) + way, 33.0f));
          joints.push_back(join_at(lab, leaf, bodies.back(), lab.position(leaf) + 0.5 * way, BallJoint{}));
        }
      }
      kick(lab, bodies, kKick);
      expect_passive(lab, bodies, joints, 120,
                     33.0 * static_cast<double>(kKick) * static_cast<double>(bodies.size()));
    }
  }
}

TEST(JointStar, ThatIsAWheelGainsNoEnergy) {
  for (const int spokes : {4, 8, 16, 33, 100}) {
    SCOPED_TRACE(std::to_string(spokes) + " spokes");
    Lab lab(without_gravity());
    Star star = add_star(lab, {.leaves = spokes, .in_plane = true});
    for (std::size_t i = 0; i < star.leaves.size(); ++i) {
      const BodyId one = star.leaves[i], next = star.leaves[(i + 1) % star.leaves.size()];
      const Eigen::Vector3d between = 0.5 * (lab.position(one) + lab.position(next));
      star.joints.push_back(join_at(lab, one, next, between, BallJoint{}));
    }
    kick(lab, star.leaves, kKick);
    expect_passive(lab, star.bodies(), star.joints, 120, 33.0 * static_cast<double>(kKick) * (spokes + 1));
  }
}

// Sprung leaves in pairs about a hub that stays at rest. A spring's frequency is that of both masses; with
// the hub at rest each leaf swings slower by the root of two. The springs keep their stiffness whatever
// number of leaves shares the hub.
TEST(JointStar, SpringsHaveTheGivenStiffness) {
  constexpr double kHertz = 2.0;
  for (const int leaves : {2, 8, 16, 40, 100}) {
    SCOPED_TRACE(std::to_string(leaves) + " leaves");
    WorldSettings settings = without_gravity();
    settings.substeps = 16;
    Lab lab(settings);
    Star star{add_loose(lab, Eigen::Vector3d::Zero(), 33.0f), {}, {}};
    Random random(4);
    const DistanceJoint spring{.length = {.lower = 0.0f,
                                          .drive = Drive::spring,
                                          .target = 1.9f,
                                          .hertz = static_cast<float>(kHertz),
                                          .damping_ratio = 0.0f}};
    for (int i = 0; i < leaves / 2; ++i) {
      const Eigen::Vector3d way = 2.0 * direction_of({}, i, random);
      for (const double side : {1.0, -1.0}) {
        star.leaves.push_back(add_loose(lab, side * way, 33.0f));
        lab.world.create_joint({.body_a = star.hub, .body_b = star.leaves.back()}, spring);
      }
    }
    // A quarter of the period passes from the outer end to the first crossing of the target.
    int steps = 0;
    while (lab.position(star.leaves[0]).norm() > 1.9 && steps < 600) {
      lab.run(1);
      ++steps;
    }
    const double period = 4.0 * steps * static_cast<double>(kStep);
    EXPECT_NEAR(period, std::sqrt(2.0) / kHertz, 4.5 * static_cast<double>(kStep));
  }
}

// A hub on one joint under the world, with leaves that hang straight down from points about it. A joint
// yields by its load over m omega^2, where omega is that of 3/16 of the substeps' rate, and m the mass of a
// leaf against its part of the hub: one of (leaves + 16) / 2 at most, whose response is 3.5 times that of the
// mass alone, because it may turn. The hook yields by the whole weight over that of the hub alone.
TEST(JointStar, ThatHangsCarriesItsLeaves) {
  for (const int leaves : {4, 16, 33, 100}) {
    SCOPED_TRACE(std::to_string(leaves) + " leaves");
    Lab lab;
    Star star{add_loose(lab, Eigen::Vector3d::Zero(), 33.0f), {}, {}};
    const JointId hook = join_at(lab, kWorld, star.hub, {0.0, 0.5, 0.0}, BallJoint{});
    for (int i = 0; i < leaves; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / leaves;
      const Eigen::Vector3d at(0.5 * std::cos(angle), -0.5, 0.5 * std::sin(angle));
      star.leaves.push_back(add_loose(lab, at - Eigen::Vector3d(0.0, 0.5, 0.0), 33.0f));
      star.joints.push_back(join_at(lab, star.hub, star.leaves.back(), at, BallJoint{}));
    }
    lab.run(600);
    double fastest = 0.0, deepest = 0.0;
    for (const BodyId body : star.bodies()) fastest = std::max(fastest, std::abs(lab.velocity(body).y()));
    for (const BodyId leaf : star.leaves) deepest = std::max(deepest, -1.0 - lab.height(leaf));
    EXPECT_LT(fastest, 5e-3);
    const double omega = 2.0 * std::numbers::pi * 0.1875 * 240.0;
    const double share = 1.0 + 3.5 * 0.5 * (leaves + 16), hooked = leaves + 1;
    EXPECT_LT(deepest, (share + hooked) * kGravity / (omega * omega));
    const double weight = 33.0 * kGravity;
    const auto carried = static_cast<double>(lab.world.joint_reaction(hook).force.y);
    EXPECT_NEAR(carried, (leaves + 1) * weight, 0.01 * (leaves + 1) * weight);
    for (const JointId joint : star.joints) {
      EXPECT_NEAR(static_cast<double>(lab.world.joint_reaction(joint).force.y), weight, 0.02 * weight);
    }
  }
}

TEST(JointStar, OfABodyThatBecomesFixedLeavesNothingBehind) {
  for (const BodyType type : {BodyType::fixed, BodyType::kinematic}) {
    Lab lab;
    const Star star = add_star(lab, {.leaves = 16});
    kick(lab, star.leaves, kKick);
    lab.run(2);
    lab.world.set_body_type(star.hub, type);
    Snapshot snapshot;
    save(lab.world, snapshot);
    Lab other;
    restore(other.world, snapshot);
    lab.run(10);
    other.run(10);
    EXPECT_EQ(lab.world.hash(), other.world.hash());
  }
}

TEST(JointStar, DoesNotDependOnLaneWidthOrThreads) {
  std::vector<std::uint64_t> expected;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Lab lab;
      int number = 0;
      for (const Joint& kind : {Joint(BallJoint{}), Joint(HingeJoint{}), Joint(WeldJoint{})}) {
        for (const int leaves : {5, 16, 45}) {
          const Eigen::Vector3d center(20.0 * number++, 0.0, 0.0);
          const Star star = add_star(lab, {.leaves = leaves, .leaf_mass = 100.0f, .joint = kind}, center);
          kick(lab, star.leaves, kKick);
          join_at(lab, kWorld, star.hub, center, BallJoint{});
        }
      }
      Workers workers(WorkersOptions{.threads = threads, .isa = isa});
      std::vector<std::uint64_t> hashes;
      for (int i = 0; i < 60; ++i) {
        step(lab.world, kStep, workers);
        hashes.push_back(lab.world.hash());
      }
      if (expected.empty()) expected = hashes;
      EXPECT_EQ(hashes, expected) << static_cast<int>(isa) << ", " << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace scree::physics
