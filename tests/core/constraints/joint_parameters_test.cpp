// Laws of joints as the parameters that kernels read: they hold exactly the given values.
#include <core/constraints/joint_parameters.h>
#include <core/world/edit.h>
#include <core/world/math.h>
#include <tests/core/constraints/joint_samples.h>
#include <tests/core/world/world_fixture.h>

#include <cstring>

namespace scree::test {
namespace {

JointType type_at(std::size_t i) { return static_cast<JointType>(i); }

TEST(JointParameters, EveryNumberHasAnEntryOfItsOwn) {
  std::vector<Joint> joints = filled_joints();
  joints.push_back(PulleyJoint{.rigid = false});
  for (const Joint& joint : joints) {
    SCOPED_TRACE(name_of(type_of(joint)));
    const JointParameters rows = parameters_of(joint, 2.0f, 0.5f);
    EXPECT_TRUE(joint_of(type_of(joint), rows) == joint);
    EXPECT_EQ(rows.hertz, 2.0f);
    EXPECT_EQ(rows.damping_ratio, 0.5f);
    const bool weld = type_of(joint) == JointType::weld;
    EXPECT_EQ(rows.angular_hertz == 2.0f && rows.angular_damping_ratio == 0.5f, !weld);
  }
}

TEST(JointParameters, UnusedEntriesRequestNothing) {
  const JointParameters rows = parameters_of(WeldJoint{}, 0.0f, 1.0f);
  for (const JointAxisRow& axis : rows.axis) {
    EXPECT_EQ(axis.lower, -kNoLimit);
    EXPECT_EQ(axis.upper, kNoLimit);
    EXPECT_EQ(axis.drive, kDriveNone);
  }
}

TEST(JointParameters, TypesAreInTheOrderOfTheKinds) {
  const std::vector<Joint> joints = plain_joints();
  for (std::size_t i = 0; i < joints.size(); ++i) EXPECT_EQ(type_of(joints[i]), type_at(i));
  EXPECT_EQ(type_of(HingeJoint{}), JointType::hinge);
  EXPECT_EQ(type_of(SixDegreeJoint{}), JointType::six_degree);
  EXPECT_EQ(type_of(RackAndPinionJoint{}), JointType::rack_and_pinion);
  EXPECT_EQ(type_of(MouseJoint{}), JointType::mouse);
}

TEST(JointParameters, ALimitOrADriveMakesAJointRich) {
  for (const Joint& joint :
       {Joint{BallJoint{}}, Joint{HingeJoint{}}, Joint{SliderJoint{}}, Joint{WeldJoint{}},
        Joint{SixDegreeJoint{}}, Joint{UniversalJoint{}}, Joint{PlanarJoint{}}, Joint{GearJoint{}}}) {
    EXPECT_FALSE(is_rich(joint)) << name_of(type_of(joint));
  }
  SixDegreeJoint one;
  one.angle[2].upper = 1.0f;
  for (const Joint& joint :
       {Joint{BallJoint{.cone_limit = 1.0f}}, Joint{BallJoint{.twist_lower = -1.0f}},
        Joint{BallJoint{.drive = {.drive = Drive::motor}}}, Joint{HingeJoint{{.lower = -1.0f}}},
        Joint{SliderJoint{{.drive = Drive::spring}}}, Joint{DistanceJoint{}}, Joint{one}, Joint{WheelJoint{}},
        Joint{PlanarJoint{.angle = {.upper = 0.0f}}}, Joint{PulleyJoint{}}, Joint{MotorJoint{}},
        Joint{MouseJoint{}}}) {
    EXPECT_TRUE(is_rich(joint)) << name_of(type_of(joint));
  }
}

// --- frames ---

Quat turn(Vec3 axis, float half) { return normalize({axis.x * half, axis.y * half, axis.z * half, 1.0f}); }

void expect_near(Vec3 a, Vec3 b, float tolerance = 2e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// The anchors of a joint in the world, from the frames that the solver reads.
Vec3 anchor(const World& world, JointId joint, bool of_b) {
  const WorldData& data = internals(world);
  const JointFrames& frames = data.joints.frames[joint.index];
  const PoseRow& pose = data.bodies.pose[static_cast<std::size_t>(of_b ? frames.row_b : frames.row_a)];
  const float* p = pose.position;
  const float* q = pose.rotation;
  const float* r = of_b ? frames.anchor_b : frames.anchor_a;
  return Vec3{p[0], p[1], p[2]} + rotate(Quat{q[0], q[1], q[2], q[3]}, Vec3{r[0], r[1], r[2]});
}

// Two bodies whose centers of mass lie off their origins, and a joint between them.
struct Lever {
  World world;
  BodyId a = world.create_body({.position = {1, 2, 3}, .rotation = turn({1, 0, 0.5f}, 0.3f)});
  BodyId b = world.create_body({.position = {1.5f, 2, 3}, .rotation = turn({0, 1, 0.5f}, -0.4f)});
  Pose frame_a{{0.5f, 0.25f, -0.5f}, turn({1, 1, 0}, 0.2f)}, frame_b{{-1, 0, 0.5f}, turn({0, 1, 1}, 0.7f)};
  ShapeId shape = world.add_shape(a, Sphere{0.3f}, {}, {.local_pose = {{0.5f, 0.5f, 0}, {}}});
  JointId joint =
      world.create_joint({.body_a = a, .body_b = b, .frame_a = frame_a, .frame_b = frame_b}, BallJoint{});

  void expect_anchors_in_place() {
    place_matter(internals(world));
    const Pose at_a = world.pose(a), at_b = world.pose(b);
    expect_near(anchor(world, joint, false), at_a.position + rotate(at_a.rotation, frame_a.position));
    expect_near(anchor(world, joint, true), at_b.position + rotate(at_b.rotation, frame_b.position));
  }
};

TEST(JointFrames, StayInTheBodiesWhenTheCenterOfMassMoves) {
  Lever lever;
  World& world = lever.world;
  lever.expect_anchors_in_place();
  const ShapeId another = world.add_shape(lever.b, Box{}, {}, {.local_pose = {{0, 2, 1}, {}}});
  lever.expect_anchors_in_place();
  world.set_mass_properties(lever.a, {.center = {3, -1, 2}});
  lever.expect_anchors_in_place();
  world.set_material(another, {.density = 10.0f});
  world.set_local_pose(lever.shape, {{0, 0, 1}, {}});
  world.reset_mass(lever.a);
  lever.expect_anchors_in_place();
  world.destroy_shape(another);
  world.set_body_type(lever.b, BodyType::fixed);
  world.set_pose(lever.b, {{4, 5, 6}, {0, 1, 0, 0}});
  lever.expect_anchors_in_place();
  lever.frame_b = {{0, 0, 2}, {}};
  world.set_joint_frames(lever.joint, lever.frame_a, lever.frame_b);
  lever.expect_anchors_in_place();
}

TEST(JointFrames, TheWorldIsABodyAtItsOrigin) {
  World world;
  const BodyId body = world.create_body({.position = {5, 0, 0}});
  const JointId first = world.create_joint(
      {.body_a = kWorld, .body_b = body, .frame_a = {{4, 1, 2}, {}}, .frame_b = {{1, 0, 0}, {}}},
      BallJoint{});
  const JointId second =
      world.create_joint({.body_a = body, .body_b = kWorld, .frame_b = {{4, 1, 2}, {}}}, BallJoint{});
  const WorldData& data = internals(world);
  EXPECT_EQ(data.joints.frames[first.index].row_a, kFixedRow);
  EXPECT_EQ(data.joints.frames[second.index].row_b, kFixedRow);
  expect_near(anchor(world, first, false), {4, 1, 2});
  expect_near(anchor(world, first, true), {6, 0, 0});
  expect_near(anchor(world, second, true), {4, 1, 2});
}

TEST(JointFrames, JointPoseIsFrameBSeenFromFrameA) {
  Lever lever;
  const World& world = lever.world;
  const Pose a = world.pose(lever.a), b = world.pose(lever.b), seen = world.joint_pose(lever.joint);
  const Quat axes_a = a.rotation * lever.frame_a.rotation, axes_b = b.rotation * lever.frame_b.rotation;
  const Vec3 from = a.position + rotate(a.rotation, lever.frame_a.position);
  const Vec3 to = b.position + rotate(b.rotation, lever.frame_b.position);
  expect_near(seen.position, rotate_back(axes_a, to - from));
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    expect_near(rotate(axes_a, rotate(seen.rotation, axis)), rotate(axes_b, axis));
  }
}

TEST(JointFrames, JointPoseIsExactFarFromTheOrigin) {
  World world;
  const BodyId a = world.create_body({.position = {1e6f, -1e6f, 0}});
  const BodyId b = world.create_body({.position = {1e6f + 2.0f, -1e6f, 0}});
  const JointId joint = world.create_joint(
      {.body_a = a, .body_b = b, .frame_a = {{0.75f, 0.0009765625f, 0}, {}}, .frame_b = {{-1, 0, 0}, {}}},
      BallJoint{});
  EXPECT_EQ(world.joint_pose(joint).position, (Vec3{0.25f, -0.0009765625f, 0}));
}

}  // namespace
}  // namespace scree::test
