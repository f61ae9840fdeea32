// Answers of hooks without hooks: those that programs give, and those that recordings hold.
#include <core/world/world_data.h>
#include <gtest/gtest.h>
#include <tests/parallel/narrow_phase/hooks_fixture.h>

#include <stdexcept>
#include <string>

namespace scree::hooks_test {
namespace {

using test::TemporaryFile;

TEST(ContactAnswers, StandForTheHooksInOneStep) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  const BodyId body = hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  int asked = 0;
  hooked.world.set_contact_filter([&](const ContactFilterBatch&) { ++asked; });
  hooked.world.set_contact_rule([&](const ContactRuleBatch&) { ++asked; });
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  hooked.world.answer_contact_hooks({&refusal, 1});
  const float before = hooked.world.linear_velocity(body).y;
  hooked.run(1);
  EXPECT_EQ(asked, 0);
  EXPECT_NEAR(hooked.world.linear_velocity(body).y, before - kGravity * kStep, 1e-5f);
  hooked.run(1);
  EXPECT_EQ(asked, 2);
  EXPECT_GT(hooked.world.linear_velocity(body).y, before - kGravity * kStep);
  const ContactAnswer belt{
      hooked.shapes[0], hooked.shapes[1], 0, {.friction = 1e6f, .surface_velocity = {-1, 0, 0}}};
  for (int i = 0; i < 30; ++i) {
    hooked.world.answer_contact_hooks({&belt, 1});
    hooked.run(1);
  }
  EXPECT_NEAR(hooked.world.linear_velocity(body).x, 1.0f, 1e-3f);
}

TEST(ContactAnswers, ArePartOfTheState) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  World unanswered = clone(hooked.world);
  hooked.world.answer_contact_hooks({&refusal, 1});
  World copy = clone(hooked.world);
  Snapshot snapshot;
  save(hooked.world, snapshot);
  World restored;
  restore(restored, read_snapshot(write_snapshot(snapshot)));
  for (World* world : {&hooked.world, &copy, &restored, &unanswered}) step(*world, kStep, hooked.workers);
  EXPECT_EQ(copy.hash(), hooked.world.hash());
  EXPECT_EQ(restored.hash(), hooked.world.hash());
  EXPECT_NE(unanswered.hash(), hooked.world.hash());
}

TEST(ContactAnswers, AboutShapesThatAreReplacedHaveNoEffect) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  const BodyId body = hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  const ContactAnswer refusal{hooked.shapes[0], hooked.shapes[1], -1, {}};
  hooked.world.answer_contact_hooks({&refusal, 1});
  hooked.world.destroy_shape(hooked.shapes[1]);
  const ShapeId next = hooked.world.add_shape(body, Box{});
  ASSERT_EQ(next.index, hooked.shapes[1].index);
  hooked.run(1);
  EXPECT_NEAR(hooked.world.linear_velocity(body).y, 0.0f, 1e-2f);
}

TEST(ContactAnswers, ThatAreWrongAreRefusedByNameAndChangeNothing) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  for (int i = 0; i < 3; ++i) hooked.add({.position = {2.0f * static_cast<float>(i), 0.5f, 0}}, Box{});
  hooked.run(5);
  const auto& s = hooked.shapes;
  const ContactAnswer sound[] = {{s[0], s[1], -1, {}}, {s[0], s[2], 0, {.friction = 1}}};
  hooked.world.answer_contact_hooks(sound);
  Snapshot before;
  save(hooked.world, before);
  const auto refuse = [&](std::vector<ContactAnswer> answers, const std::string& message) {
    try {
      hooked.world.answer_contact_hooks(answers);
      ADD_FAILURE() << "not refused: " << message;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
    Snapshot after;
    save(hooked.world, after);
    EXPECT_EQ(write_snapshot(after), write_snapshot(before));
  };
  refuse({{s[1], s[0], -1, {}}},
         "answer_contact_hooks: shape_a has the index 1, which must be below shape_b's, 0");
  refuse({{s[1], s[1], -1, {}}}, "must be below");
  refuse({{s[0], s[1], -2, {}}}, "contact is -2; it must be -1 or more");
  refuse({{s[0], s[1], 0, {}}, {s[0], s[1], 0, {}}}, "answer 1: it must come before the answer ahead of it");
  refuse({{s[0], s[2], 0, {}}, {s[0], s[1], 0, {}}}, "answer 1: it must come before");
  refuse({{s[0], {s[1].index, s[1].generation + 1, s[1].world}, 0, {}}}, "shape");
  refuse({{s[0], s[1], 0, {.friction = kNan}}}, "friction");
  refuse({{s[0], s[1], 0, {.restitution = 1.5f}}}, "restitution is 1.5");
  refuse({{s[0], s[1], 0, {.rolling_resistance = -1}}}, "rolling_resistance");
  refuse({{s[0], s[1], 0, {.surface_velocity = {0, 3e6f, 0}}}}, "surface_velocity");
  EXPECT_THROW(hooked.world.set_contact_hooks(s[1], static_cast<ContactHooks>(4)), Error);
  EXPECT_THROW(hooked.world.add_shape(hooked.world.body_of(s[1]), Box{}, {},
                                      {.contact_hooks = static_cast<ContactHooks>(9)}),
               Error);
}

// Runs a world with hooks and records it; playing it without them must take the same steps.
template <class Work>
void expect_to_play(Hooked& hooked, Work&& work) {
  const TemporaryFile file;
  Recorder recorder(hooked.world, file.path(), {.keyframe_spacing = 10});
  work();
  recorder.finish();
  Player player(file.path());
  const auto found = player.verify(player.info().first_step, player.info().last_step, hooked.workers);
  EXPECT_FALSE(found.has_value()) << found->difference;
  EXPECT_EQ(player.world().hash(), hooked.world.hash());
}

// A contact that ends as a call takes its body away has been taken out by no rule: what then flies back, too
// fast for the kernels to see, is swept.
TEST(ContactAnswers, AreAlikeWhereContactsEndByThemselves) {
  Hooked hooked;
  hooked.add({.type = BodyType::fixed}, Box{{9, 0.02f, 9}}, {}, ContactHooks::rule);
  hooked.add({.position = {3, 0.52f, 0}}, Box{});
  const BodyId ball = hooked.add({.position = {0, 0.27f, 0}}, Sphere{0.25f});
  hooked.world.set_contact_rule([](const ContactRuleBatch&) {});
  expect_to_play(hooked, [&] {
    hooked.run(10);
    for (int i = 0; i < 5; ++i) {
      hooked.world.set_pose(ball, {{0, 1.5f, 0}, {}});
      hooked.world.set_linear_velocity(ball, {0, -300, 0});
      hooked.run(3);
      EXPECT_GT(hooked.world.pose(ball).position.y, 0.0f);
    }
  });
}

TEST(ContactAnswers, AreAlikeWhileARuleThrowsAndAFilterRefuses) {
  Pile pile;
  pile.world.set_contact_filter([](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.collide[i] = batch.pairs[i].shape_b.index % 3 != 0;
  });
  pile.world.set_contact_rule([](const ContactRuleBatch&) { throw std::runtime_error("no"); });
  expect_to_play(pile, [&] {
    for (int i = 0; i < 60; ++i) {
      try {
        pile.run(1);
      } catch (const std::runtime_error&) {
      }
    }
  });
}

TEST(ContactAnswers, AreAlikeForAFilterAlone) {
  Pile pile;
  pile.world.set_contact_filter([](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i)
      batch.collide[i] = batch.pairs[i].shape_b.index % 5 != 0;
  });
  expect_to_play(pile, [&] { pile.run(90); });
}

TEST(ContactAnswers, OfASnapshotThatNoCallWouldTakeAreRefused) {
  Hooked hooked;
  hooked.add_floor(ContactHooks::all);
  hooked.add({.position = {0, 0.5f, 0}}, Box{});
  hooked.run(5);
  const ContactAnswer answers[] = {{hooked.shapes[0], hooked.shapes[1], -1, {}},
                                   {hooked.shapes[0], hooked.shapes[1], 0, {.friction = 1}}};
  hooked.world.answer_contact_hooks(answers);
  const auto refuses = [&](auto spoil) {
    World copy = clone(hooked.world);
    spoil(internals(copy).hooks.answers);
    Snapshot snapshot;
    save(copy, snapshot);
    EXPECT_THROW(read_snapshot(write_snapshot(snapshot)), Error);
  };
  refuses([](Column<HookAnswer>& rows) { rows[1].friction = kNan; });
  refuses([](Column<HookAnswer>& rows) { rows[1].contact = -1; });
  refuses([](Column<HookAnswer>& rows) { rows[0].acts = 2; });
  refuses([](Column<HookAnswer>& rows) { rows[0].contact = -2; });
  refuses([](Column<HookAnswer>& rows) { std::swap(rows[0], rows[1]); });
  refuses([](Column<HookAnswer>& rows) { std::swap(rows[0].shape_a, rows[0].shape_b); });
}

}  // namespace
}  // namespace scree::hooks_test
