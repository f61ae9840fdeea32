// Laws of the validation of stages: what a step leaves behind is sound, and whatever else stands there
// instead is found by the stage that it concerns.
#include <parallel/broad_phase/broad_phase.h>
#include <parallel/constraints/constraints.h>
#include <parallel/islands/islands.h>
#include <parallel/stages.h>
#include <parallel/validate/validate_stages.h>
#include <tests/core/validate/damaged_world.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <utility>

namespace scree::test {
namespace {

class ValidateStagesDeathTest : public DamagedWorld {
 protected:
  // Bounds that follow the step are newer than the trees: the next list of pairs takes them up.
  void find_all_pairs() {
    Crew crew(workers);
    find_pairs(data, crew);
  }
  BroadPhase& broad_phase() { return broad_phase_of(data); }
  Constraints& constraints() { return constraints_of(data); }
  void validate_packed() {
    const Crew crew(workers);
    validate_blocks(data, crew);
  }
};

TEST_F(ValidateStagesDeathTest, AStepFindsBodiesOutOfOrderInBuildsWithAssertionsOnly) {
  const auto step_damaged = [&] {
    std::swap(data.bodies.awake[0], data.bodies.awake[1]);
    step(world, kDt, workers);
    std::exit(0);
  };
#ifdef SCREE_ASSERTIONS
  EXPECT_DEATH(step_damaged(), "ascends");
#else
  EXPECT_EXIT(step_damaged(), testing::ExitedWithCode(0), "");
#endif
}

#ifdef SCREE_ASSERTIONS

TEST_F(ValidateStagesDeathTest, WhatAStepLeavesIsSound) {
  validate_members(data);
  validate_contacts(data);
  validate_islands(data);
  validate_colors(data);
  validate_packed();
  validate_impulses(data);
  validate_events(data);
  validate_motion(data);
  find_all_pairs();
  validate_trees(data);
}

TEST_F(ValidateStagesDeathTest, AListOfBodiesThatDoesNotAscendIsFound) {
  Column<std::int32_t>& awake = data.bodies.awake;
  EXPECT_DEATH((std::swap(awake[0], awake[1]), validate_members(data)), "ascends");
}

TEST_F(ValidateStagesDeathTest, ABodyThatIsMissingFromItsListIsFound) {
  EXPECT_DEATH((data.bodies.awake.pop_back(), validate_members(data)), "is_listed == belongs");
  EXPECT_DEATH((data.bodies.kinematic.clear(), validate_members(data)), "is_listed == belongs");
  EXPECT_DEATH((data.shapes.moving.pop_back(), validate_members(data)), "is_listed == belongs");
  EXPECT_DEATH((data.joints.active.pop_back(), validate_members(data)), "is_listed == belongs");
}

TEST_F(ValidateStagesDeathTest, AJointThatIsDisabledWithoutNoteIsFound) {
  EXPECT_DEATH((data.joints.flags[0] &= 0xff & ~kJointEnabled, validate_members(data)),
               "is_listed == belongs");
}

TEST_F(ValidateStagesDeathTest, ATreeWhoseBoxesDoNotHoldAShapeIsFound) {
  find_all_pairs();
  EXPECT_DEATH((data.shapes.fat_bounds[shape_of(boxes[0])].upper[1] += 10, validate_trees(data)),
               "fat_bounds");
  EXPECT_DEATH((data.shapes.fat_bounds[shape_of(floor)].lower[0] -= 10, validate_trees(data)), "fat_bounds");
  simd::NodeBlock& root = broad_phase().trees[kAwakeTree].nodes[0][0];
  EXPECT_DEATH((root.bounds[3][0] = root.bounds[0][0], validate_trees(data)), "holds");
}

TEST_F(ValidateStagesDeathTest, AShapeInAnotherTreeIsFound) {
  find_all_pairs();
  EXPECT_DEATH((broad_phase().tree_of[shape_of(boxes[0])] = kKinematicTree, validate_trees(data)), "tree_of");
  EXPECT_DEATH((broad_phase().trees[kAwakeTree].order[0] = -1, validate_trees(data)), "leaf.shape");
  EXPECT_DEATH((--broad_phase().trees[kKinematicTree].members, validate_trees(data)), "members");
}

TEST_F(ValidateStagesDeathTest, ContactsThatDoNotComeInTheOrderOfTheirPairsAreFound) {
  Column<std::int32_t>& touching = data.contacts.active;
  EXPECT_DEATH((std::swap(touching[0], touching[1]), validate_contacts(data)), "comes_before");
}

TEST_F(ValidateStagesDeathTest, AManifoldOfOtherBodiesIsFound) {
  Manifold& manifold = data.contacts.now.manifold[data.contacts.active[0]];
  EXPECT_DEATH((manifold.row_b = row_of(kinematic), validate_contacts(data)), "row_b");
  EXPECT_DEATH((manifold.row_a = row_of(kinematic), validate_contacts(data)), "row_a");
  EXPECT_DEATH((manifold.info ^= kManifoldStatic, validate_contacts(data)), "kManifoldStatic");
}

TEST_F(ValidateStagesDeathTest, AnIslandThatSleepsInPartIsFound) {
  EXPECT_DEATH((data.bodies.flags[boxes[1].index] |= kBodyAsleep, validate_islands(data)), "is_asleep");
}

TEST_F(ValidateStagesDeathTest, AContactOfAnAwakeBodyThatIsNotListedIsFound) {
  EXPECT_DEATH((data.contacts.active.pop_back(), validate_islands(data)), "count_parts");
}

TEST_F(ValidateStagesDeathTest, MarksThatAStepLeavesAreFound) {
  const auto leave = [&] {
    Islands& islands = islands_of(data);
    islands.tired.resize(1);
    islands.tired[0] = 1;
    validate_islands(data);
  };
  EXPECT_DEATH(leave(), "is_zero");
}

TEST_F(ValidateStagesDeathTest, TwoConstraintsOfOneColorAtABodyAreFound) {
  const auto paint = [&] {
    for (const std::int32_t contact : data.contacts.active) data.contacts.now.color[contact] = 0;
    for (Edge& edge : constraints().edges) edge.color = 0;
    for (const std::int32_t joint : data.joints.active) data.joints.color[joint] = 0;
    validate_colors(data);
  };
  EXPECT_DEATH(paint(), "bit.* == 0");
}

TEST_F(ValidateStagesDeathTest, AnEdgeOfOtherBodiesOrAnotherColorIsFound) {
  EXPECT_DEATH((constraints().edges[0].body_b = row_of(kinematic), validate_colors(data)), "edge.body_a");
  EXPECT_DEATH((++constraints().edges[0].color, validate_colors(data)), "edge.color");
  EXPECT_DEATH((constraints().edges.pop_back(), validate_colors(data)), "edges.size");
}

TEST_F(ValidateStagesDeathTest, ALaneWithoutARowOrWithAnotherIsFound) {
  simd::ConstraintChunk& chunk = constraints().contact_chunks[0];
  std::int32_t& row = constraints().contact_lanes[chunk.first_lane];
  EXPECT_DEATH((row = 1 << 20, validate_packed()), "store_rows");
  EXPECT_DEATH((row = -1, validate_packed()), "store_rows");
  EXPECT_DEATH((chunk.first_lane = 1 << 20, validate_packed()), "rows.size");
  EXPECT_DEATH((++chunk.lanes, validate_packed()), "chunk.blocks ==|has_lane\\[row\\] == 0");
}

TEST_F(ValidateStagesDeathTest, BlocksThatOverlapAreFound) {
  EXPECT_DEATH((constraints().contact_chunks.back().offset += 64, validate_packed()), "offset");
  EXPECT_DEATH((constraints().blocks.resize(constraints().blocks.size() + 64), validate_packed()), "offset");
}

TEST_F(ValidateStagesDeathTest, ChunksOfOneStageThatPushTheSameBodyAreFound) {
  const auto join = [&] {  // of all stages that one thread runs, one that many do
    for (ColorStage& stage : constraints().stages) stage.serial = false;
    validate_packed();
  };
  EXPECT_DEATH(join(), "is_serial");
}

TEST_F(ValidateStagesDeathTest, AChunkThatPushesABodyTwiceIsFound) {
  const auto turn = [&] {
    for (Manifold& manifold : data.contacts.now.manifold) manifold.row_b = row_of(boxes[0]);
    validate_packed();
  };
  EXPECT_DEATH(turn(), "chunk.hub == side");
}

TEST_F(ValidateStagesDeathTest, AFixedWorldThatMovesIsFound) {
  EXPECT_DEATH((data.bodies.velocity[kFixedRow].linear[1] = 1, validate_impulses(data)), "velocity");
}

TEST_F(ValidateStagesDeathTest, ABrokenJointThatIsStillEnabledIsFound) {
  EXPECT_DEATH((data.events.broken.push_back(joints[0]), validate_impulses(data)), "kJointEnabled");
}

TEST_F(ValidateStagesDeathTest, AContactThatPullsIsFound) {
  Manifold& manifold = data.contacts.now.manifold[data.contacts.active[0]];
  EXPECT_DEATH((manifold.normal_impulse[0] = -1, validate_impulses(data)), "normal_impulse");
}

TEST_F(ValidateStagesDeathTest, EventsThatDoNotAscendAreFound) {
  Column<TouchRow>& touching = data.events.touching;
  ASSERT_GE(touching.size(), 2u);
  EXPECT_DEATH((std::swap(touching[0], touching[1]), validate_events(data)), "ascends");
  EXPECT_DEATH((touching[0].events = 0, validate_events(data)), "row.events != 0");
  EXPECT_DEATH((++data.events.resting_touches, validate_events(data)), "resting_touches");
  const auto list_backward = [&](Column<BodyId>& list) {
    list.clear();
    list.push_back(boxes[1]);
    list.push_back(boxes[0]);
    validate_events(data);
  };
  EXPECT_DEATH(list_backward(data.events.sleep_begins), "ascends.events.sleep_begins");
  EXPECT_DEATH(list_backward(data.events.sleep_ends), "ascends.events.sleep_ends");
  const auto list_joints_backward = [&] {
    data.events.strained.push_back({JointId{2, 1}, 1.0f, 1.0f});
    data.events.strained.push_back({JointId{1, 1}, 1.0f, 1.0f});
    validate_events(data);
  };
  EXPECT_DEATH(list_joints_backward(), "ascends.events.strained");
  EXPECT_DEATH((touching[0].events = 4, validate_events(data)), "kTouchEvents");
  EXPECT_DEATH((data.events.lost.push_back({}), validate_events(data)), "lost.empty");
}

TEST_F(ValidateStagesDeathTest, ARotationThatCallsAcceptIsSound) {
  PoseRow& pose = data.bodies.pose[boxes[0].index];
  for (const float length : {1.0f - 0.8f * kUnitTolerance, 1.0f + 0.8f * kUnitTolerance}) {
    pose.rotation[0] = pose.rotation[1] = pose.rotation[2] = 0.0f;
    pose.rotation[3] = length;
    validate_motion(data);
  }
}

TEST_F(ValidateStagesDeathTest, ABodyThatIsNowhereIsFound) {
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  EXPECT_DEATH((data.bodies.pose[boxes[0].index].position[0] = kNowhere, validate_motion(data)), "is_finite");
  EXPECT_DEATH((data.bodies.pose[boxes[0].index].rotation[3] = 0.5f, validate_motion(data)), "is_unit");
  EXPECT_DEATH((data.bodies.velocity[boxes[0].index].linear[0] = kNowhere, validate_motion(data)),
               "is_finite");
}

#endif

}  // namespace
}  // namespace scree::test
