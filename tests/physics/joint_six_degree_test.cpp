// Joints of six degrees of freedom: they can act as each of the other joints, and have modes of their own.
#include <tests/physics/lab.h>

#include <cmath>
#include <functional>
#include <string>

namespace scree::physics {
namespace {

constexpr JointAxis kHeld{.lower = 0, .upper = 0};

SixDegreeJoint holding(std::initializer_list<int> offsets, std::initializer_list<int> angles) {
  SixDegreeJoint joint;
  for (const int i : offsets) joint.offset[i] = kHeld;
  for (const int i : angles) joint.angle[i] = kHeld;
  return joint;
}
SixDegreeJoint with_offset(SixDegreeJoint joint, const JointAxis& axis) {
  joint.offset[0] = axis;
  return joint;
}
SixDegreeJoint with_angle(SixDegreeJoint joint, const JointAxis& axis) {
  joint.angle[0] = axis;
  return joint;
}

// A joint that a joint of six degrees must match.
struct Likeness {
  std::string name;
  Joint other;
  SixDegreeJoint six;
};

std::vector<Likeness> likenesses() {
  const JointAxis slide{
      .lower = -0.4f, .upper = 0.6f, .drive = Drive::spring, .hertz = 1.5f, .damping_ratio = 0.3f};
  const JointAxis swing{.lower = -0.5f, .upper = 0.3f, .drive = Drive::motor, .speed = 1, .max_force = 500};
  const JointAxis sprung{.drive = Drive::spring, .target = 0.3f, .hertz = 1.0f, .damping_ratio = 0.2f};
  const SixDegreeJoint ball = holding({0, 1, 2}, {}), hinge = holding({0, 1, 2}, {1, 2}),
                       slider = holding({1, 2}, {0, 1, 2}), weld = holding({0, 1, 2}, {0, 1, 2});
  return {{"Ball", BallJoint{}, ball},
          {"Hinge", HingeJoint{}, hinge},
          {"LimitedHinge", HingeJoint{swing}, with_angle(hinge, swing)},
          {"SprungHinge", HingeJoint{sprung}, with_angle(hinge, sprung)},
          {"Slider", SliderJoint{}, slider},
          {"LimitedSlider", SliderJoint{slide}, with_offset(slider, slide)},
          {"Weld", WeldJoint{}, weld}};
}

class SixDegreeAs : public testing::TestWithParam<Likeness> {};

// A box on the world and a second box on the first; both start moving.
struct Arm {
  Lab lab;
  BodyId upper, lower;

  explicit Arm(const Joint& joint) {
    upper = lab.add({.position = {0.5f, 0, 0}}, Box{{0.5f, 0.2f, 0.1f}});
    lower = lab.add({.position = {1.5f, 0, 0.1f}}, Box{{0.5f, 0.1f, 0.2f}});
    const Quat frame = rotation_about({1, 2, 3}, 0.7);
    lab.world.create_joint(
        {.body_a = kWorld, .body_b = upper, .frame_a = {{}, frame}, .frame_b = {{-0.5f, 0, 0}, frame}},
        joint);
    lab.world.create_joint({.body_a = upper,
                            .body_b = lower,
                            .frame_a = {{0.5f, 0, 0}, frame},
                            .frame_b = {{-0.5f, 0, -0.1f}, frame}},
                           joint);
    lab.world.set_angular_velocity(lower, {0.5f, 0.5f, 0});
  }
};

TEST_P(SixDegreeAs, MovesNearlyAlike) {
  Arm other(GetParam().other), six(GetParam().six);
  double worst = 0.0;
  for (int i = 0; i < 60; ++i) {
    other.lab.run(1);
    six.lab.run(1);
    for (const auto body : {&Arm::upper, &Arm::lower}) {
      worst = std::max(worst, (other.lab.position(other.*body) - six.lab.position(six.*body)).norm());
    }
  }
  RecordProperty("apart", std::to_string(worst));
  EXPECT_LT(worst, 5e-3);
  EXPECT_TRUE(six.lab.all_finite());
}

INSTANTIATE_TEST_SUITE_P(EachKind, SixDegreeAs, testing::ValuesIn(likenesses()),
                         [](const auto& parameters) { return parameters.param.name; });

TEST(SixDegreeJoint, HoldsAPoseUnderAWeightBesideIt) {
  Lab lab;
  const BodyId cube = lab.add({.position = {0, 0, 0.5f}}, Box{{0.5f, 0.5f, 0.5f}});
  SixDegreeJoint joint = holding({0, 1, 2}, {0, 1, 2});
  joint.offset[1] = {.lower = 0.2f, .upper = 0.2f};
  joint.angle[2] = {.lower = 0.8f, .upper = 0.8f};
  lab.world.create_joint({.body_a = kWorld, .body_b = cube, .frame_b = {{0, 0, -0.5f}, {}}}, joint);
  lab.run(300);
  const Pose pose = lab.world.pose(cube);
  EXPECT_LT(to_eigen(pose.rotation).angularDistance(to_eigen(rotation_about({0, 0, 1}, 0.8))), 1e-4);
  EXPECT_LT((to_eigen(pose.position) - Eigen::Vector3d(0, 0.2, 0.5)).norm(), 1e-4);
}

TEST(SixDegreeJoint, StopsEachOffsetAtItsLimit) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 pull{};
    (axis == 0 ? pull.x : axis == 1 ? pull.y : pull.z) = 9.81f;
    WorldSettings settings = without_sleep();
    settings.gravity = pull;
    Lab lab(settings);
    const BodyId cube = lab.add({}, Box{{0.5f, 0.5f, 0.5f}});
    SixDegreeJoint joint;
    for (JointAxis& offset : joint.offset) offset = {.lower = -0.1f, .upper = 0.2f};
    lab.world.create_joint({.body_a = kWorld, .body_b = cube}, joint);
    double most = 0.0;
    for (int i = 0; i < 240; ++i) {
      lab.run(1);
      most = std::max(most, lab.position(cube)[axis]);
    }
    EXPECT_LT(most, 0.202);
    EXPECT_NEAR(lab.position(cube)[axis], 0.2, 1e-3);
  }
}

}  // namespace
}  // namespace scree::physics
