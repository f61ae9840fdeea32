// Laws of the validation of stores: what calls leave behind is sound, and whatever else stands there instead
// is found. Of the stages' own: tests/parallel/validate.
#include <core/validate/validate.h>
#include <scree/scree.h>
#include <tests/core/validate/damaged_world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace scree::test {
namespace {

class ValidateDeathTest : public DamagedWorld {};

TEST_F(ValidateDeathTest, AStepFindsAWrongCountInBuildsWithAssertionsOnly) {
  const auto step_damaged = [&] {
    ++data.bodies.alive;
    step(world, kDt, workers);
    std::exit(0);
  };
#ifdef SCREE_ASSERTIONS
  EXPECT_DEATH(step_damaged(), "bodies.alive == alive");
#else
  EXPECT_EXIT(step_damaged(), testing::ExitedWithCode(0), "");
#endif
}

#ifdef SCREE_ASSERTIONS

TEST_F(ValidateDeathTest, WhatCallsAndStepsLeaveIsSound) {
  validate_stores(data);
  validate_pairs(data);
  world.destroy_joint(joints[0]);
  world.set_joint_enabled(joints[1], false);
  world.destroy_body(boxes[1]);
  validate_stores(data);
}

TEST_F(ValidateDeathTest, ABodyThatIsCountedWronglyIsFound) {
  EXPECT_DEATH((++data.bodies.alive, validate_stores(data)), "bodies.alive == alive");
  EXPECT_DEATH((++data.bodies.asleep, validate_stores(data)), "bodies.asleep == asleep");
  EXPECT_DEATH((data.bodies.flags[boxes[0].index] &= 0xff & ~kBodyAlive, validate_stores(data)),
               "bodies.alive == alive");
}

TEST_F(ValidateDeathTest, AShapeOrJointThatIsCountedWronglyIsFound) {
  EXPECT_DEATH((++data.shapes.alive, validate_stores(data)), "shapes.alive == alive");
  EXPECT_DEATH((++data.shapes.asking, validate_stores(data)), "shapes.asking == asking");
  EXPECT_DEATH((++data.joints.alive, validate_stores(data)), "joints.alive == alive");
  EXPECT_DEATH((++data.joints.reporting, validate_stores(data)), "joints.reporting == reporting");
}

TEST_F(ValidateDeathTest, AMarkThatACallLeavesIsFound) {
  EXPECT_DEATH((data.bodies.flags[boxes[0].index] |= kBodyMarked, validate_stores(data)), "kBodyMarked");
}

TEST_F(ValidateDeathTest, ABodyToPlaceThatIsNotListedIsFound) {
  EXPECT_DEATH((data.bodies.unplaced[boxes[0].index] = 1, validate_stores(data)), "to_place");
}

TEST_F(ValidateDeathTest, ABoxWithAHullAndAHullWithoutAreFound) {
  EXPECT_DEATH((data.shapes.hull[shape_of(boxes[0])] = 0, validate_stores(data)), "== is_hull");
  EXPECT_DEATH((data.shapes.type[shape_of(boxes[0])] = ShapeType::hull, validate_stores(data)), "== is_hull");
}

TEST_F(ValidateDeathTest, ADeadBodyWithShapesOrJointsIsFound) {
  const auto damage = [&](Column<std::int32_t>& first) {
    const BodyId body = world.create_body({});
    world.destroy_body(body);
    first[body.index] = 0;
    validate_stores(data);
  };
  EXPECT_DEATH(damage(data.bodies.first_shape), "first_shape");
  EXPECT_DEATH(damage(data.bodies.first_joint), "first == -1");
}

TEST_F(ValidateDeathTest, AJointOfABodyWithItselfIsFound) {
  EXPECT_DEATH((data.joints.bodies[0].b = data.joints.bodies[0].a, validate_stores(data)),
               "ends.a != ends.b");
}

TEST_F(ValidateDeathTest, AnEventAtRestOfAnotherPairIsFound) {
  Column<TouchRow>& resting = data.events.resting;
  std::size_t row = 0;
  while (row < resting.size() && resting[row].events == 0) ++row;
  ASSERT_LT(row, resting.size());
  EXPECT_DEATH((++resting[row].pair.shape_b.index, validate_pairs(data)), "key_of");
  EXPECT_DEATH((resting.pop_back(), validate_pairs(data)), "events.resting.size");
}

TEST_F(ValidateDeathTest, AFixedBodyThatSleepsIsFound) {
  EXPECT_DEATH((data.bodies.flags[floor.index] |= kBodyAsleep, validate_stores(data)), "is_asleep");
}

TEST_F(ValidateDeathTest, ASlotThatIsFreeAndAliveIsFound) {
  const auto slot = static_cast<std::int32_t>(boxes[0].index);
  EXPECT_DEATH((data.bodies.free_slots.push_back(slot), validate_stores(data)), "lists_exactly");
  EXPECT_DEATH((data.shapes.free_slots.push_back(0), validate_stores(data)), "lists_exactly");
  EXPECT_DEATH((data.joints.free_slots.push_back(0), validate_stores(data)), "lists_exactly");
}

TEST_F(ValidateDeathTest, AChangeThatIsNotListedIsFound) {
  EXPECT_DEATH((data.bodies.is_changed[boxes[0].index] = 1, validate_stores(data)), "is_changed");
  EXPECT_DEATH((data.shapes.is_changed[0] = 1, validate_stores(data)), "is_changed");
  EXPECT_DEATH((data.joints.changed.push_back(0), validate_stores(data)), "is_changed");
}

TEST_F(ValidateDeathTest, ADirtyShapeThatIsNotListedIsFound) {
  EXPECT_DEATH((data.shapes.flags[0] |= kShapeDirty, validate_stores(data)), "dirty");
  EXPECT_DEATH((data.shapes.wakers.push_back(0), validate_stores(data)), "wakers");
}

TEST_F(ValidateDeathTest, AShapeInTheListOfAnotherBodyIsFound) {
  EXPECT_DEATH((data.shapes.body[shape_of(boxes[0])] = row_of(boxes[1]), validate_stores(data)),
               "shapes.body\\[shape\\], body");
}

TEST_F(ValidateDeathTest, ABrokenLinkBetweenShapesIsFound) {
  const std::int32_t first = shape_of(compound);
  const std::int32_t second = data.shapes.next[first];
  ASSERT_GE(second, 0);
  EXPECT_DEATH((data.shapes.previous[second] = -1, validate_stores(data)), "previous");
  EXPECT_DEATH((data.shapes.next[first] = -1, validate_stores(data)), "listed == shapes.alive");
  EXPECT_DEATH((data.shapes.next[second] = first, validate_stores(data)), "previous");
}

TEST_F(ValidateDeathTest, AShapeThatBelongsToAnotherTreeIsFound) {
  EXPECT_DEATH((data.shapes.tree[shape_of(boxes[0])] = TreeKind::frozen, validate_stores(data)), "tree_of");
}

TEST_F(ValidateDeathTest, ABrokenLinkBetweenJointsIsFound) {
  const std::int32_t middle = row_of(boxes[1]);
  const std::int32_t first = data.bodies.first_joint[middle];
  ASSERT_GE(first, 0);
  EXPECT_DEATH((data.bodies.first_joint[middle] = -1, validate_stores(data)), "listed == wanted");
  EXPECT_DEATH((data.joints.previous[first] = {first, first}, validate_stores(data)), "previous");
  EXPECT_DEATH((data.joints.bodies[first] = {row_of(kinematic), row_of(floor)}, validate_stores(data)),
               "ends.a == body");
}

TEST_F(ValidateDeathTest, PairsThatDoNotAscendAreFound) {
  Column<ShapePair>& pairs = data.contacts.pairs.pair;
  ASSERT_GE(pairs.size(), 2u);
  EXPECT_DEATH((pairs[0] = pairs[1], validate_pairs(data)), "ascends");
  EXPECT_DEATH((std::swap(pairs.back().a, pairs.back().b), validate_pairs(data)), "pair.a < pair.b");
}

TEST_F(ValidateDeathTest, AContactOfTwoPairsIsFound) {
  const auto [first, second] = two_contacts();
  Column<std::int32_t>& contact = data.contacts.pairs.contact;
  EXPECT_DEATH((contact[first] = contact[second], validate_pairs(data)), "rows.pair");
}

TEST_F(ValidateDeathTest, AContactWithoutAPairIsFound) {
  const auto [first, second] = two_contacts();
  EXPECT_DEATH((data.contacts.pairs.contact[first] = -1, validate_pairs(data)), "free_rows.size");
}

TEST_F(ValidateDeathTest, AFreeRowThatIsLostOrTakenIsFound) {
  world.destroy_body(boxes[3]);  // whose contact leaves a free row
  step(world, kDt, workers);
  const std::int32_t row = data.contacts.pairs.contact[two_contacts().first];
  EXPECT_DEATH((data.contacts.free_rows.push_back(row), validate_pairs(data)), "free_rows");
  ASSERT_FALSE(data.contacts.free_rows.empty());
  EXPECT_DEATH((data.contacts.free_rows.pop_back(), validate_pairs(data)), "free_rows");
}

TEST_F(ValidateDeathTest, AManifoldWithAnotherNumberOfPointsIsFound) {
  const std::int32_t row = data.contacts.pairs.contact[two_contacts().first];
  EXPECT_DEATH((data.contacts.now.manifold[row].info ^= 1, validate_pairs(data)), "kManifoldPointMask");
  EXPECT_DEATH((data.contacts.now.manifold[row].row_b = 1 << 20, validate_pairs(data)), "row_b");
}

TEST_F(ValidateDeathTest, ABrokenListOfPairsAtRestIsFound) {
  ASSERT_FALSE(data.contacts.resting.pair.empty());
  const ShapePair pair = data.contacts.resting.pair[0];
  EXPECT_DEATH((data.shapes.first_resting[pair.a] = 0, validate_pairs(data)), "listed == ends");
  EXPECT_DEATH((data.contacts.resting_links[0].previous[0] ^= 1, validate_pairs(data)), "previous");
  EXPECT_DEATH((data.contacts.resting_links[0].next[1] = 1 << 20, validate_pairs(data)), "end <= ends");
  EXPECT_DEATH((++data.contacts.resting_contacts, validate_pairs(data)), "resting_contacts");
}

TEST_F(ValidateDeathTest, APairThatMovesAndRestsIsFound) {
  ASSERT_FALSE(data.contacts.resting.pair.empty());
  const auto add = [&] {
    PairRows& pairs = data.contacts.pairs;
    pairs.resize(pairs.pair.size() + 1);
    pairs.pair.back() = data.contacts.resting.pair[0];
    pairs.contact.back() = -1;
    std::sort(pairs.pair.begin(), pairs.pair.end(),
              [](const ShapePair& x, const ShapePair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    std::fill(pairs.contact.begin(), pairs.contact.end(), -1);
    for (std::size_t row = 0; row < data.contacts.now.pair.size(); ++row) {
      const ShapePair& own = data.contacts.now.pair[row];
      for (std::size_t i = 0; i < pairs.pair.size(); ++i) {
        const bool same = pairs.pair[i].a == own.a && pairs.pair[i].b == own.b;
        if (same && data.contacts.now.points[row] > 0 && !rests(own))
          pairs.contact[i] = static_cast<std::int32_t>(row);
      }
    }
    validate_pairs(data);
  };
  EXPECT_DEATH(add(), "binary_search");
}

TEST_F(ValidateDeathTest, ARestoredWorldIsSoundAndAStepFindsWhatIsNot) {
  Snapshot snapshot;
  save(world, snapshot);
  restore(world, snapshot);
  EXPECT_DEATH((data.shapes.previous[data.shapes.next[shape_of(compound)]] = -1, step(world, kDt, workers)),
               "previous");
}

TEST(Validate, ALargeWorldIsValidatedInEveryKthStep) {
  WorldData data;
  data.bodies.resize(2 * kValidatedRows);
  int validated = 0;
  for (data.step_count = 0; data.step_count < 30; ++data.step_count) validated += is_validated(data) ? 1 : 0;
  EXPECT_EQ(validated, 10);
}

#endif

}  // namespace
}  // namespace scree::test
