// Laws of touch: what a page asks for happens to the world, and what cannot be done is said and changes
// nothing.
#include <gtest/gtest.h>
#include <tools/scenes/scene.h>
#include <tools/scenes/stage.h>
#include <tools/view/touch.h>

#include <cmath>
#include <limits>

namespace scree::view {
namespace {

constexpr float kTouchStep = 1.0f / 60.0f;

class TouchTest : public ::testing::Test {
 protected:
  TouchTest() : stage_(scenes::build("stack", {{"bodies", 3}})) { run(30); }

  World& world() { return stage_.worlds().front(); }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) stage_.advance(kTouchStep, workers_);
  }
  void ask(const Json& what) { touch(world(), what, held_); }
  // The highest body.
  BodyId top() {
    BodyId highest;
    for (std::uint32_t i = 0; i < world().poses().size(); ++i) {
      const BodyId body = world().body_at(i);
      if (!world().is_alive(body) || world().body_type(body) != BodyType::dynamic) continue;
      if (highest == BodyId{} || world().pose(body).position.y > world().pose(highest).position.y)
        highest = body;
    }
    return highest;
  }
  BodyId ground() {
    for (std::uint32_t i = 0; i < world().poses().size(); ++i) {
      if (world().is_alive(world().body_at(i)) && world().body_type(world().body_at(i)) == BodyType::fixed)
        return world().body_at(i);
    }
    return {};
  }

  Workers workers_{WorkersOptions{.threads = 1}};
  scenes::Stage stage_;
  JointId held_{};
};

TEST_F(TouchTest, DragsABodyToWhereItIsHeldAndLetsGo) {
  const BodyId box = top();
  const Vec3 start = world().pose(box).position;
  ask({{"kind", "drag"}, {"body", box.index}, {"point", json_of(start)}});
  EXPECT_EQ(world().joint_count(), 1u);
  const Vec3 goal = start + Vec3{0.0f, 2.0f, 0.0f};
  for (int i = 0; i < 240; ++i) {
    ask({{"kind", "move"}, {"to", json_of(goal)}});
    run(1);
  }
  EXPECT_LT(length(world().pose(box).position - goal), 0.1f);
  ask({{"kind", "release"}});
  EXPECT_EQ(world().joint_count(), 0u);
  run(240);
  EXPECT_LT(world().pose(box).position.y, start.y + 0.05f) << "it falls";
  ask({{"kind", "release"}});  // once more
  ask({{"kind", "move"}, {"to", json_of(goal)}});
}

TEST_F(TouchTest, TakesHoldOfOneBodyAtATime) {
  const Vec3 point = world().pose(top()).position;
  ask({{"kind", "drag"}, {"body", top().index}, {"point", json_of(point)}});
  ask({{"kind", "drag"}, {"body", top().index}, {"point", json_of(point)}});
  EXPECT_EQ(world().joint_count(), 1u);
  ask({{"kind", "delete"}, {"body", top().index}});
  EXPECT_EQ(world().joint_count(), 0u);
  ask({{"kind", "move"}, {"to", json_of(point)}});  // what was held is gone
}

TEST_F(TouchTest, ShootsABallThatHits) {
  const std::size_t before = world().body_count();
  const Vec3 goal = world().pose(top()).position;
  ask({{"kind", "shoot"},
       {"from", json_of(goal + Vec3{0.0f, 0.0f, 5.0f})},
       {"toward", json_of({0.0f, 0.0f, -3.0f})},
       {"radius", 0.5f},
       {"density", 5000.0f},
       {"speed", 20.0f}});
  EXPECT_EQ(world().body_count(), before + 1);
  run(40);
  EXPECT_GT(
      std::abs(world().pose(top()).position.z - goal.z) + std::abs(world().pose(top()).position.y - goal.y),
      0.1f);
}

TEST_F(TouchTest, ChangesSettingsAndTheirMaterials) {
  ask({{"kind", "settings"},
       {"gravity", {0.0f, 1.5f, 0.0f}},
       {"substeps", 2},
       {"solver", "gauss_seidel"},
       {"iterations", 40},
       {"friction", 0.25f},
       {"restitution", 0.5f}});
  const WorldSettings& settings = world().settings();
  EXPECT_EQ(settings.gravity, (Vec3{0.0f, 1.5f, 0.0f}));
  EXPECT_EQ(settings.substeps, 2);
  EXPECT_EQ(settings.solver, Solver::gauss_seidel);
  EXPECT_EQ(settings.solver_options.iterations, 40);
  ShapeId shape;
  world().shapes_of(ground(), {&shape, 1});
  EXPECT_EQ(world().material(shape).friction, 0.25f);
  EXPECT_EQ(world().material(shape).restitution, 0.5f);
  const float mass = world().mass_properties(top()).mass;
  ask({{"kind", "settings"}, {"friction", 0.5f}});
  EXPECT_EQ(world().material(shape).restitution, 0.5f) << "what was not named stays";
  EXPECT_EQ(world().mass_properties(top()).mass, mass);
}

TEST_F(TouchTest, NudgesByOneUnitInTheLastPlace) {
  const float x = world().pose(top()).position.x;
  ask({{"kind", "nudge"}, {"body", top().index}});
  EXPECT_EQ(world().pose(top()).position.x, std::nextafter(x, std::numeric_limits<float>::infinity()));
}

TEST_F(TouchTest, RefusesWhatCannotBeDoneAndChangesNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Json point = json_of(world().pose(top()).position);
  const Json bad[] = {
      {{"kind", "drag"}, {"body", 1000000}, {"point", point}},
      {{"kind", "drag"}, {"body", ground().index}, {"point", point}},
      {{"kind", "drag"}, {"body", top().index}, {"point", {1.0f, 2.0f}}},
      {{"kind", "drag"}, {"body", top().index}, {"point", {nan, 0.0f, 0.0f}}},
      {{"kind", "drag"}, {"body", top().index}},
      {{"kind", "delete"}, {"body", 77}},
      {{"kind", "delete"}, {"body", "box"}},
      {{"kind", "shoot"}, {"from", point}, {"toward", {1.0f, 0.0f, 0.0f}}, {"radius", -1.0f}},
      {{"kind", "shoot"}, {"from", point}, {"toward", {1.0f, 0.0f, 0.0f}}, {"speed", nan}},
      {{"kind", "shoot"}, {"from", point}, {"toward", {1.0f, 0.0f, 0.0f}}, {"density", -5.0f}},
      {{"kind", "settings"}, {"substeps", 0}},
      {{"kind", "settings"}, {"solver", "magic"}},
      {{"kind", "settings"}, {"gravity", {0.0f, 0.0f, 1e30f}}},
      {{"kind", "settings"}, {"friction", -1.0f}},
      {{"kind", "settings"}, {"restitution", 1.5f}},
      {{"kind", "settings"}, {"friction", nan}},
      {{"kind", "wish"}},
      Json::object(),
      Json::array(),
  };
  const std::uint64_t before = world().hash();
  const std::size_t bodies = world().body_count();
  const WorldSettings settings = world().settings();
  for (const Json& what : bad) {
    EXPECT_ANY_THROW(ask(what)) << what;
    EXPECT_EQ(world().hash(), before) << what;
    EXPECT_EQ(world().body_count(), bodies) << what;
    EXPECT_EQ(world().joint_count(), 0u) << what;
    EXPECT_EQ(world().settings().substeps, settings.substeps) << what;
    EXPECT_EQ(world().settings().gravity, settings.gravity) << what;
  }
}

}  // namespace
}  // namespace scree::view
