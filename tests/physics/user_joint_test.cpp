// User joints that state the rows of other kinds of joints move as these do, and hold what they are told to.
#include <tests/physics/user_rows.h>

#include <algorithm>
#include <functional>

namespace scree::physics {
namespace {

constexpr RowKind kHeldRow = RowKind::held;
constexpr Quat kXToZ{0, -0.70710678f, 0, 0.70710678f};  // takes the x axis to the z axis

enum class By { joint, rows };

struct Link {
  Stated at;
  Joint joint;   // of another kind
  Quat frame{};  // of both bodies
  UserJoint user;
  MakeRows rows;
};

// A rig of boxes whose links are joints, or rows that say the same.
struct Rig {
  Rig(const WorldSettings& settings, By which) : lab(settings), by(which) {}

  BodyId add_box(Vec3 position, Vec3 half, float density = 1000) {
    bodies.push_back(lab.add({.position = position}, Box{half}, {.density = density}));
    return bodies.back();
  }
  JointId join(const Link& link, JointDef def = {}) {
    def.body_a = link.at.a;
    def.body_b = link.at.b;
    def.frame_a = {link.at.anchor_a, link.frame};
    def.frame_b = {link.at.anchor_b, link.frame};
    const JointId id =
        by == By::joint ? lab.world.create_joint(def, link.joint) : lab.world.create_joint(def, link.user);
    if (by == By::rows) rows[id] = link.rows;
    return id;
  }
  void run(int steps, float dt = kStep) {
    if (by == By::rows) state_rows(lab.world, rows);
    lab.run(steps, dt);
  }

  Lab lab;
  By by;
  std::vector<BodyId> bodies;
  std::map<JointId, MakeRows> rows;
};

Link ball(const Stated& at) {
  return {at, BallJoint{}, {}, {{kHeldRow, kHeldRow, kHeldRow}}, [at](const World& w) {
            return ball_rows(w, at);
          }};
}
Link hinge(const Stated& at, const JointAxis& angle = {}) {
  return {at,
          HingeJoint{angle},
          kXToZ,
          {{kHeldRow, kHeldRow, kHeldRow, kHeldRow, kHeldRow}},
          [at](const World& w) { return hinge_rows(w, at); }};
}

using Build = std::function<void(Rig&)>;

// The largest distance that bodies of the two rigs come to have in so many steps.
double largest_gap(const WorldSettings& settings, const Build& build, int steps, float dt = kStep) {
  Rig joints(settings, By::joint), rows(settings, By::rows);
  build(joints);
  build(rows);
  double gap = 0;
  for (int i = 0; i < steps; ++i) {
    joints.run(1, dt);
    rows.run(1, dt);
    for (std::size_t k = 0; k < rows.bodies.size(); ++k) {
      gap = std::max(gap, (joints.lab.position(joints.bodies[k]) - rows.lab.position(rows.bodies[k])).norm());
    }
  }
  return gap;
}

// Two links, let go level from a point of the world.
void build_pendulum(Rig& rig, Link (*link)(const Stated&)) {
  const Vec3 half{0.5f, 0.1f, 0.1f};
  const BodyId first = rig.add_box({0.5f, 0, 0}, half), second = rig.add_box({1.5f, 0, 0}, half);
  rig.join(link({kWorld, first, {0, 0, 0}, {-0.5f, 0, 0}}));
  rig.join(link({first, second, {0.5f, 0, 0}, {-0.5f, 0, 0}}));
}

TEST(UserJoint, WithTheRowsOfBallsSwingsAsBallsDo) {
  const Build build = [](Rig& rig) { build_pendulum(rig, ball); };
  // A double pendulum of 2 m falls from level for a second. Rows stay while a step lasts, which is an error
  // of first order.
  EXPECT_LT(largest_gap(without_sleep(), build, 60), 0.04);
  EXPECT_LT(largest_gap(without_sleep(), build, 960, 1.0f / 960.0f), 0.0025);
}

TEST(UserJoint, WithTheRowsOfHingesSwingsAsHingesDo) {
  const Build build = [](Rig& rig) { build_pendulum(rig, [](const Stated& at) { return hinge(at); }); };
  EXPECT_LT(largest_gap(without_sleep(), build, 60), 0.04);
  EXPECT_LT(largest_gap(without_sleep(), build, 960, 1.0f / 960.0f), 0.0025);
}

// A weight at the world's origin by one row of their distance, which is to be `wanted`.
Build on_a_rod(const JointAxis& axis, RowKind kind, float wanted) {
  return [=](Rig& rig) {
    const BodyId weight = rig.add_box({1, 0, 0}, {0.1f, 0.1f, 0.1f});
    const Stated ends{kWorld, weight, {0, 0, 0}, {0, 0, 0}};
    rig.join({ends, DistanceJoint{axis}, {}, {{kind}}, [=](const World& world) {
                std::vector<UserRow> rows = distance_row(world, ends, wanted);
                rows[0].target.hertz = axis.hertz;
                rows[0].target.damping_ratio = axis.damping_ratio;
                return rows;
              }});
  };
}

TEST(UserJoint, WithTheRowOfARodOrASpringMovesAsADistanceJointDoes) {
  const JointAxis rod{.lower = 1, .upper = 1};
  const JointAxis spring{
      .lower = 0, .drive = Drive::spring, .target = 0.5f, .hertz = 2, .damping_ratio = 0.3f};
  const Build held = on_a_rod(rod, kHeldRow, 1), sprung = on_a_rod(spring, RowKind::spring, 0.5f);
  EXPECT_LT(largest_gap(without_sleep(), held, 60), 0.06);
  EXPECT_LT(largest_gap(without_sleep(), held, 960, 1.0f / 960.0f), 0.004);
  EXPECT_LT(largest_gap(without_sleep(), sprung, 60), 0.09);
  EXPECT_LT(largest_gap(without_sleep(), sprung, 960, 1.0f / 960.0f), 0.006);
}

// The same rod where the target's speed is the mean one at which the circle leaves its tangent in a step.
TEST(UserJoint, IsOfSecondOrderWhereItsTargetFollowsTheTurnOfTheRow) {
  WorldSettings settings = without_sleep();
  settings.substeps = 1;
  const auto gap = [&](float share, int rate) {
    const float dt = 1.0f / static_cast<float>(rate);
    const Build build = [=](Rig& rig) {
      const BodyId weight = rig.add_box({1, 0, 0}, {0.1f, 0.1f, 0.1f});
      const Stated ends{kWorld, weight, {0, 0, 0}, {0, 0, 0}};
      rig.join({ends, DistanceJoint{{.lower = 1, .upper = 1}}, {}, {{kHeldRow}}, [=](const World& world) {
                  std::vector<UserRow> rows = distance_row(world, ends, 1);
                  const Vec3 v = world.linear_velocity(weight), out = rows[0].jacobian.linear_b;
                  const Vec3 across = v - dot(v, out) * out;
                  rows[0].target.speed = -share * 0.5f * dt * dot(across, across);
                  return rows;
                }});
    };
    return largest_gap(settings, build, rate, dt);
  };
  const double ratio_without = gap(0, 240) / gap(0, 480), ratio_with = gap(1, 240) / gap(1, 480);
  EXPECT_NEAR(ratio_without, 2, 0.3);
  EXPECT_NEAR(ratio_with, 4, 1);
  EXPECT_LT(gap(1, 240), gap(0, 240) / 10);
}

TEST(UserJoint, WithAMotorRowTurnsAsAHingeWithAMotorDoes) {
  const JointAxis motor{.drive = Drive::motor, .speed = 6, .max_force = 40};
  const Build build = [&](Rig& rig) {
    const BodyId body = rig.add_box({0, 0, 0}, {0.4f, 0.1f, 0.1f});
    const Stated at{kWorld, body, {0, 0, 0}, {0, 0, 0}};
    Link link = hinge(at, motor);
    link.user.rows[5] = RowKind::motor;
    link.rows = [at](const World& w) {
      std::vector<UserRow> rows = hinge_rows(w, at);
      rows.push_back(about({0, 0, 1}, 0));
      rows.back().target.speed = 6;
      rows.back().bounds = {-40, 40};
      return rows;
    };
    rig.join(link);
  };
  Rig joints(without_gravity(), By::joint), rows(without_gravity(), By::rows);
  build(joints);
  build(rows);
  const auto spin = [](const Rig& rig) { return rig.lab.spin(rig.bodies[0]).z(); };
  for (int i = 0; i < 120; ++i) {
    joints.run(1);
    rows.run(1);
    // While its torque is bounded both gain the same speed, and then keep it.
    EXPECT_NEAR(spin(rows), spin(joints), 1e-3);
  }
  EXPECT_NEAR(spin(rows), 6, 1e-3);
}

TEST(UserJoint, GivesTheFirstSubstepTheImpulseOfTheJointWhoseRowsItHas) {
  WorldSettings settings = without_sleep();
  settings.substeps = 1;
  constexpr float kShort = 1e-4f;  // s, in which hardly anything turns
  Rig joints(settings, By::joint), rows(settings, By::rows);
  JointId last[2];
  for (Rig* rig : {&joints, &rows}) {
    const BodyId body = rig->add_box({0.5f, 0, 0}, {0.5f, 0.1f, 0.1f});
    rig->lab.world.set_angular_velocity(body, {1, 2, 3});
    last[rig == &rows] = rig->join(ball({kWorld, body, {0, 0, 0}, {-0.5f, 0, 0}}));
    rig->run(1, kShort);
  }
  const Eigen::Vector3d expected = to_eigen(joints.lab.world.joint_reaction(last[0]).force);
  const Eigen::Vector3d force = to_eigen(rows.lab.world.joint_reaction(last[1]).force);
  EXPECT_GT(expected.norm(), 1e5);  // stops the anchor at once
  EXPECT_LT((force - expected).norm(), 1e-3 * expected.norm());
}

// A hanging box bears its weight, and the joint says so.
TEST(UserJoint, BearsAWeightAndReportsItAsItsReaction) {
  Rig rig(without_sleep(), By::rows);
  const BodyId body = rig.add_box({0, -0.5f, 0}, {0.1f, 0.1f, 0.1f});
  const JointId joint = rig.join(ball({kWorld, body, {0, 0, 0}, {0, 0.5f, 0}}));
  rig.run(120);
  EXPECT_NEAR(rig.lab.height(body), -0.5, 1e-3);
  EXPECT_NEAR(to_eigen(rig.lab.world.joint_reaction(joint).force).y(), 8 * kGravity, 0.1);
}

TEST(UserJoint, BreaksUnderALoadAboveItsStrengthAndNotUnderALowerOne) {
  for (const float strength : {60.0f, 100.0f}) {  // N; the weight is 78.5 N
    Rig rig(without_sleep(), By::rows);
    const BodyId body = rig.add_box({0, -0.5f, 0}, {0.1f, 0.1f, 0.1f});
    const JointId joint = rig.join(ball({kWorld, body, {0, 0, 0}, {0, 0.5f, 0}}), {.break_force = strength});
    std::size_t broken = 0;
    for (int i = 0; i < 60; ++i) {
      rig.run(1);
      broken += rig.lab.world.broken_joints().size();
    }
    EXPECT_EQ(broken, strength < 78 ? 1u : 0u);
    EXPECT_EQ(rig.lab.world.is_enabled(joint), strength > 78);
  }
}

// A limit at y = 0 catches a box that falls on it and lets it rise again.
TEST(UserJoint, ALimitRowPushesOnly) {
  Rig rig(without_sleep(), By::rows);
  const BodyId body = rig.add_box({0, 1, 0}, {0.1f, 0.1f, 0.1f});
  const JointId floor =
      rig.lab.world.create_joint({.body_a = kWorld, .body_b = body}, UserJoint{{RowKind::limit}});
  rig.rows[floor] = [body](const World& world) {
    return std::vector<UserRow>{
        {.jacobian = {.linear_b = {0, 1, 0}}, .target = {.error = world.pose(body).position.y}}};
  };
  rig.run(20);
  EXPECT_NEAR(rig.lab.velocity(body).y(), -20 * kGravity / 60, 1e-3);  // not slower before it gets there
  rig.run(100);
  EXPECT_NEAR(rig.lab.height(body), 0, 1e-3);
  rig.lab.world.set_linear_velocity(body, {0, 2, 0});
  rig.run(1);
  EXPECT_NEAR(rig.lab.velocity(body).y(), 2 - kGravity / 60, 1e-4);
}

TEST(UserJoint, AMotorRowPushesNoHarderThanItsBoundsOnEitherSide) {
  for (const RowBounds bounds : {RowBounds{-3, 5}, RowBounds{2, 2}, RowBounds{-5, -1}}) {
    Rig rig(without_gravity(), By::rows);
    const BodyId body = rig.add_box({0, 0, 0}, {0.1f, 0.1f, 0.1f});
    const JointId motor =
        rig.lab.world.create_joint({.body_a = kWorld, .body_b = body}, UserJoint{{RowKind::motor}});
    const UserRow row{.jacobian = {.linear_b = {1, 0, 0}}, .target = {.speed = 1e5f}, .bounds = bounds};
    rig.lab.world.set_user_rows(motor, {&row, 1});
    rig.lab.run(60);
    EXPECT_NEAR(rig.lab.velocity(body).x(), static_cast<double>(bounds.upper) / rig.lab.mass(body), 1e-4);
  }
}

TEST(UserJoint, RowsThatPushBothBodiesAlikeKeepMomentum) {
  Rig rig(without_gravity(), By::rows);
  std::vector<BodyId>& bodies = rig.bodies;
  for (int i = 0; i < 8; ++i) {
    rig.add_box({static_cast<float>(i), 0, 0}, {0.3f, 0.2f, 0.1f}, 500.0f * static_cast<float>(i + 1));
    rig.lab.world.set_linear_velocity(bodies.back(), {0, static_cast<float>(i % 3), 1});
    rig.lab.world.set_angular_velocity(bodies.back(), {1, static_cast<float>(i), -2});
    if (i > 0) rig.join(ball({bodies[bodies.size() - 2], bodies.back(), {0.5f, 0, 0}, {-0.5f, 0, 0}}));
  }
  const auto momentum = [&] {
    Eigen::Vector3d sum(0, 0, 0);
    for (const BodyId body : bodies) sum += rig.lab.mass(body) * rig.lab.velocity(body);
    return sum;
  };
  const Eigen::Vector3d before = momentum();
  rig.run(120);
  EXPECT_LT((momentum() - before).norm(), 1e-4 * before.norm());
}

// --- rows that say too little, too much or the same twice ---

TEST(UserJoint, RowsOfZerosChangeNoBit) {
  const auto run = [](bool with_joint) {
    Lab lab;
    const BodyId a = lab.add({.angular_velocity = {1, 2, 3}}, Box{}),
                 b = lab.add({.position = {3, 0, 0}}, Box{});
    const JointDef def{.body_a = a, .body_b = b};
    const UserRow zero[4]{};
    if (with_joint) {
      const UserJoint all{{kHeldRow, RowKind::limit, RowKind::motor, RowKind::spring}};
      lab.world.set_user_rows(lab.world.create_joint(def, all), zero);
    } else {
      lab.world.create_joint(def, UserJoint{});  // as it is before it has numbers
    }
    lab.run(60);
    return lab.world.hash();
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(UserJoint, RowsThatAreStatedTwiceOrWithTheOtherSignHoldAsOnce) {
  const auto fall = [](float again) {
    Rig rig(without_sleep(), By::rows);
    const BodyId body = rig.add_box({0.5f, 0, 0}, {0.5f, 0.1f, 0.1f});
    const Stated at{kWorld, body, {0, 0, 0}, {-0.5f, 0, 0}};
    Link link = ball(at);
    link.user = {{kHeldRow, kHeldRow, kHeldRow, kHeldRow, kHeldRow, kHeldRow}};
    link.rows = [=](const World& world) {
      std::vector<UserRow> rows = ball_rows(world, at);
      for (std::size_t i = 0; i < 3; ++i) {
        UserRow row = again == 0 ? UserRow{} : rows[i];
        row.jacobian.linear_a = again * row.jacobian.linear_a;
        row.jacobian.angular_a = again * row.jacobian.angular_a;
        row.jacobian.linear_b = again * row.jacobian.linear_b;
        row.jacobian.angular_b = again * row.jacobian.angular_b;
        row.target.error *= again;
        rows.push_back(row);
      }
      return rows;
    };
    rig.join(link);
    rig.run(60);
    return rig.lab.position(body);
  };
  const Eigen::Vector3d once = fall(0);
  EXPECT_LT((fall(1) - once).norm(), 1e-3);
  EXPECT_LT((fall(-1) - once).norm(), 1e-3);
}

TEST(UserJoint, NumbersAtTheEndsOfTheirRangesLeaveAllBodiesFinite) {
  for (const float size : {1e-45f, 1e-39f, 1e-30f, 1e-20f, 1e-10f, 1.0f, 1e6f}) {
    for (const float error : {0.0f, 1e-45f, 1.0f, 1e6f}) {
      for (const RowKind kind : {kHeldRow, RowKind::limit, RowKind::motor, RowKind::spring}) {
        Lab lab;
        const BodyId a = lab.add({}, Box{}), b = lab.add({.position = {3, 0, 0}}, Box{});
        const BodyId apart = lab.add({.position = {0, 50, 0}}, Box{});
        const JointId joint =
            lab.world.create_joint({.body_a = a, .body_b = b}, UserJoint{{kind, kind, kind, kind}});
        std::vector<UserRow> rows;
        for (int i = 0; i < 4; ++i) {
          const Vec3 n = size * kAxes[i % 3];
          rows.push_back({.jacobian = {-1.0f * n, n, n, -1.0f * n},
                          .target = {error, i % 2 == 0 ? error : -error, 1e4f, 0.0f},
                          .bounds = {-1e30f, 1e30f}});
        }
        lab.world.set_user_rows(joint, rows);
        lab.run(30);
        SCOPED_TRACE(std::to_string(size) + ", " + std::to_string(error));
        EXPECT_TRUE(lab.all_finite());
        EXPECT_NEAR(lab.velocity(apart).y(), -0.5 * kGravity, 1e-3);
      }
    }
  }
}

// --- chains, hubs and unequal masses ---

TEST(UserJoint, AThousandAtOneBodyStayTogetherAtRest) {
  for (const int substeps : {1, 4, 16}) {
    WorldSettings settings = without_gravity();
    settings.substeps = substeps;
    Rig rig(settings, By::rows);
    const BodyId hub = rig.add_box({0, 0, 0}, {2, 2, 2});
    for (int i = 0; i < 1000; ++i) {
      const float angle = 0.1f * static_cast<float>(i), z = 0.01f * static_cast<float>(i) - 5;
      const Vec3 out{3 * std::cos(angle), 3 * std::sin(angle), z};
      const BodyId leaf = rig.add_box(out, {0.1f, 0.1f, 0.1f});
      rig.join(ball({hub, leaf, out, {0, 0, 0}}));
    }
    rig.lab.world.set_angular_velocity(hub, {0, 0, 1});
    rig.run(60);
    ASSERT_TRUE(rig.lab.all_finite()) << substeps;
    double fastest = 0;
    for (const BodyId body : rig.bodies) fastest = std::max(fastest, rig.lab.velocity(body).norm());
    EXPECT_LT(fastest, 7) << substeps;  // 5.8 m/s at first where the farthest leaf is
  }
}

TEST(UserJoint, AChainBearsAThousandTimesTheWeightOfALink) {
  for (const int substeps : {4, 16}) {
    WorldSettings settings = without_sleep();
    settings.substeps = substeps;
    double lowest[2];
    for (const By by : {By::joint, By::rows}) {
      Rig rig(settings, by);
      BodyId last = kWorld;
      for (int i = 0; i < 5; ++i) {
        const bool heavy = i == 4;
        const BodyId link =
            rig.add_box({0, -0.5f - static_cast<float>(i), 0}, {0.1f, 0.1f, 0.1f}, heavy ? 1e6f : 1e3f);
        rig.join(ball({last, link, last == kWorld ? Vec3{0, 0, 0} : Vec3{0, -0.5f, 0}, {0, 0.5f, 0}}));
        last = link;
      }
      rig.run(240);
      lowest[by == By::rows] = rig.lab.height(last);
      ASSERT_TRUE(rig.lab.all_finite());
    }
    EXPECT_NEAR(lowest[1], lowest[0], 0.01) << substeps;  // hanging straight, rows are those of balls
  }
}

}  // namespace
}  // namespace scree::physics
