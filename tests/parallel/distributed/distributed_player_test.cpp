// Laws of playing and verifying recordings on many ranks.
#include <core/world/world_data.h>
#include <gtest/gtest.h>
#include <parallel/distributed/border.h>
#include <scree/distributed_player.h>
#include <scree/error.h>
#include <scree/recording.h>
#include <scree/step.h>
#include <tests/parallel/distributed/eventful_pile.h>
#include <tests/parallel/distributed/local_ranks.h>
#include <tests/physics/lab.h>
#include <tools/scenes/scene.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scree {
namespace {

using distributed_tests::all_of;
using distributed_tests::run_ranks;
using physics::kStep;

constexpr int kPlayed = 420;
constexpr RecorderOptions kPlayedOptions{.keyframe_spacing = 60};

std::string player_file(const std::string& name) {
  const std::string own = "scree_player_" + std::to_string(getpid()) + "_" + name + ".scree";
  return (std::filesystem::temp_directory_path() / own).string();
}

// With a chain.
World make_played(std::vector<BodyId>& bodies, std::vector<JointId>& joints) {
  distributed_tests::EventfulPile pile = distributed_tests::make_eventful_pile(45);
  World& world = pile.world;
  bodies = pile.bodies;
  BodyId last = pile.gate;
  for (int i = 0; i < 12; ++i) {
    const BodyId link = world.create_body({.position = {-3.0f + 0.5f * static_cast<float>(i), 9, 0}});
    world.add_shape(link, Box{{0.22f, 0.1f, 0.1f}});
    joints.push_back(world.create_joint({.body_a = last,
                                         .body_b = link,
                                         .frame_a = {i == 0 ? Vec3{-3.25f, 9, 0} : Vec3{0.25f, 0, 0}, {}},
                                         .frame_b = {{-0.25f, 0, 0}, {}}},
                                        BallJoint{}));
    bodies.push_back(last = link);
  }
  return std::move(world);
}

void act_on_played(World& world, const std::vector<BodyId>& bodies, const std::vector<JointId>& joints,
                   int step) {
  if (step == 40) world.set_linear_velocity(bodies.back(), {2, 6, 1});
  if (step == 55) world.destroy_body(bodies[bodies.size() / 2]);
  if (step == 65) world.destroy_joint(joints[7]);
  if (step == 70)
    world.add_shape(world.create_body({.position = {0.2f, 9, 0.1f}}), Sphere{0.4f}, {.density = 4000});
  if (step == 75 || step == 130)
    world.set_body_type(bodies[12], step == 75 ? BodyType::kinematic : BodyType::dynamic);
  if (step == 350) world.set_linear_velocity(bodies[4], {1, 5, 0});
}

void record_by_one(const std::string& file) {
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  World world = make_played(bodies, joints);
  Recorder recorder(world, file, kPlayedOptions);
  Workers workers(1);
  for (int i = 0; i < kPlayed; ++i) {
    act_on_played(world, bodies, joints, i);
    step(world, kStep, workers);
  }
  recorder.finish();
}

void record_by_ranks(const std::string& file, int ranks) {
  const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
    std::vector<BodyId> bodies;
    std::vector<JointId> joints;
    World whole = make_played(bodies, joints);
    DistributedWorld world(std::move(whole), transport, {.steps_per_look = 7, .imbalance = 1.0f});
    Workers workers(1);
    world.record(file, workers, kPlayedOptions);
    for (int i = 0; i < kPlayed; ++i) {
      act_on_played(world.world(), bodies, joints, i);
      world.step(kStep, workers);
    }
    world.finish_recording(workers);
  });
  EXPECT_EQ(all_of(errors), "");
}

// Of a recording of one process, or of three ranks.
class DistributedPlayers : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { GetParam() == 1 ? record_by_one(file_) : record_by_ranks(file_, GetParam()); }
  void TearDown() override { std::remove(file_.c_str()); }
  const std::string file_ = player_file("of_" + std::to_string(GetParam()));
};
INSTANTIATE_TEST_SUITE_P(Writers, DistributedPlayers, testing::Values(1, 3));

TEST_P(DistributedPlayers, AgreeWithASinglePlayer) {
  Player single(file_);
  Workers workers(1);
  const auto found = single.verify(0, kPlayed, workers);
  EXPECT_FALSE(found) << found->step << " " << found->difference;
  single.seek(100, workers);
  const std::uint64_t hash = single.world().hash();
  single.step(workers);
  for (const int ranks : {1, 2, 4}) {
    const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
      Workers own(1);
      DistributedPlayer player(file_, 100, transport, own);
      EXPECT_EQ(player.position(), 100u);
      EXPECT_EQ(player.info().last_step, static_cast<std::uint64_t>(kPlayed));
      EXPECT_EQ(player.keyframe_steps().size(), 8u);
      EXPECT_EQ(player.world().hash(), hash);
      EXPECT_TRUE(player.step(own));
      EXPECT_EQ(player.recorded_hash(), single.world().hash());
      EXPECT_EQ(player.world().hash(), single.world().hash());
    });
    EXPECT_EQ(all_of(errors), "");
  }
}

TEST_P(DistributedPlayers, VerifyEveryHashAndEveryState) {
  for (const int ranks : {1, 2, 5}) {
    const auto errors = run_ranks(ranks, [&](int, Transport& transport) {
      Workers own(1);
      DistributedPlayer player(file_, 0, transport, own, {.steps_per_look = 5, .imbalance = 1.0f});
      const auto found = player.verify(kPlayed, own);
      EXPECT_FALSE(found) << ranks << " ranks: " << found->step << " " << found->difference;
      EXPECT_EQ(player.position(), static_cast<std::uint64_t>(kPlayed));
      EXPECT_FALSE(player.step(own));
      EXPECT_THROW(player.verify(kPlayed - 1, own), Error);
      EXPECT_THROW(player.verify(kPlayed + 1, own), Error);
    });
    EXPECT_EQ(all_of(errors), "");
  }
}

// What a rank alone can know of, and what no hash shows.
TEST_P(DistributedPlayers, FindWhatDiffers) {
  struct Change {
    std::uint64_t at;  // after this step
    std::function<void(World&)> make;
    std::uint64_t step;      // where it shows
    const char* difference;  // a part of what is told
  };
  const auto body = [](World& world, std::uint32_t place) { return world.body_at(kFirstBody + place); };
  const auto shape = [&](World& world, std::uint32_t place) {
    ShapeId id;
    world.shapes_of(body(world, place), {&id, 1});
    return id;
  };
  const Change changes[] = {
      {310,
       [&](World& world) {
         world.set_linear_velocity(body(world, 20), {0, 1, 0});
       },
       311, "body "},
      {310, [&](World& world) { world.set_user_data(body(world, 30), 7); }, 360, "bodies.user_data, row "},
      {310, [&](World& world) { world.set_user_data(shape(world, 40), 9); }, 360, "shapes.user_data, row "},
      {360,
       [&](World& world) {  // of one rank's own body
         WorldData& data = internals(world, "test");
         const auto row = static_cast<std::int32_t>(body(world, 35).index);
         if (border_of(data)->owns(row)) data.bodies.sleep_time[row] += 0.001f;
       },
       360, "bodies.sleep_time, row "},
      {310, [&](World& world) { world.destroy_body(body(world, 25)); }, 311, "body "},
      {360,
       [&](World& world) {  // what all ranks have, on one of them
         WorldData& data = internals(world, "test");
         if (border_of(data)->here == 1) data.bodies.type[body(world, 15).index] = BodyType::kinematic;
       },
       360, "rank 1: body "},
  };
  for (const Change& change : changes) {
    std::vector<std::optional<Divergence>> found(3);
    const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
      Workers own(1);
      DistributedPlayer player(file_, change.at - 1, transport, own);
      player.step(own);
      change.make(player.world().world());
      found[static_cast<std::size_t>(rank)] = player.verify(kPlayed, own);
      const auto again = player.verify(kPlayed, own);  // of what was recorded
      EXPECT_FALSE(again) << again->difference;
    });
    EXPECT_EQ(all_of(errors), "");
    ASSERT_TRUE(found[0] && found[1] && found[2]) << change.difference;
    EXPECT_EQ(found[0]->step, change.step) << found[0]->difference;
    EXPECT_EQ(found[0]->compared_at, 360u);
    EXPECT_NE(found[0]->difference.find(change.difference), std::string::npos) << found[0]->difference;
    EXPECT_EQ(found[0]->expected_hash == found[0]->actual_hash, change.step == 360);
    for (const auto& other : found) {
      EXPECT_EQ(other->difference, found[0]->difference);
      EXPECT_EQ(other->actual_hash, found[0]->actual_hash);
    }
  }
}

// More calls before a step than a rank makes before it lets go of bodies that others have: those that follow
// find most bodies absent.
TEST(DistributedPlayer, MakesManyCallsBeforeAStep) {
  const std::string file = player_file("many_calls");
  constexpr std::uint32_t kMany = 36'000;
  std::uint64_t hash = 0;
  {
    World world;
    world.add_shape(world.create_body({.type = BodyType::fixed}), HalfSpace{});
    Recorder recorder(world, file, {.keyframe_spacing = 2});
    const auto body = [&](std::uint32_t place) { return world.body_at(kFirstBody + 1 + place); };
    for (std::uint32_t i = 0; i < kMany; ++i) {
      const auto x = static_cast<float>(i % 200), z = static_cast<float>(i / 200);
      world.add_shape(world.create_body({.position = {1.1f * x, 0.6f, 1.1f * z}}), Box{{0.5f, 0.5f, 0.5f}});
      if (i % 1000 == 999) world.destroy_body(body(i / 2));
      if (i % 500 == 0) world.set_linear_velocity(body(i / 3), {0.2f, 0.5f, 0});
    }
    const BodyId far = world.create_body({.position = {0, 1e5f, 0}});  // until the last call
    for (std::uint32_t i = 0; i < kMany; i += 7) {
      if (world.is_alive(body(i))) world.set_user_data(body(i), i);
    }
    for (std::uint32_t i = 0; i < 2 * kMany; ++i) {
      if (world.is_alive(body(i / 2))) world.set_gravity_factor(body(i / 2), 0.9f);
    }
    world.destroy_body(far);
    Workers workers(1);
    for (int i = 0; i < 3; ++i) step(world, kStep, workers);
    hash = world.hash();
    recorder.finish();
  }
  const auto errors = run_ranks(3, [&](int, Transport& transport) {
    Workers own(1);
    DistributedPlayer player(file, {}, transport, own);
    const auto found = player.verify(3, own);
    EXPECT_FALSE(found) << found->step << " " << found->difference;
    EXPECT_EQ(player.world().hash(), hash);
  });
  EXPECT_EQ(all_of(errors), "");
  std::remove(file.c_str());
}

// A step that all ranks refuse is refused again, not left out.
TEST(DistributedPlayer, LeavesNoStepOutThatWasRefused) {
  const std::string file = player_file("refused_step");
  {
    World world;
    world.add_shape(world.create_body({.position = {0, 5, 0}}), Sphere{0.5f});
    Recorder recorder(world, file, kPlayedOptions);
    Workers workers(1);
    BodyId far;
    for (int i = 0; i < 9; ++i) {
      if (i == 4) far = world.create_body({.position = {0, 20'000, 0}});
      if (i == 6) world.destroy_body(far);
      step(world, kStep, workers);
    }
    recorder.finish();
  }
  const auto errors = run_ranks(2, [&](int, Transport& transport) {
    Workers own(1);
    DistributedPlayer player(file, {}, transport, own);
    EXPECT_FALSE(player.verify(4, own));
    for (int i = 0; i < 3; ++i) {
      EXPECT_THROW(player.step(own), Error);
      EXPECT_THROW(player.verify(9, own), Error);
      EXPECT_EQ(player.position(), 4u);
    }
  });
  EXPECT_EQ(all_of(errors), "");
  std::remove(file.c_str());
}

void record_with_hooks(const std::string& file) {
  scenes::Scene scene = scenes::build("pile", {{"bodies", 60}}).front();
  for (scenes::SceneShape& shape : scene.shapes) shape.options.contact_hooks = ContactHooks::all;
  World world(scene.settings);
  scenes::populate(world, scene);
  Recorder recorder(world, file, kPlayedOptions);
  Workers workers(1);
  for (int i = 0; i < 130; ++i) step(world, kStep, workers);
  recorder.finish();
}

// A hook that throws on one rank keeps no rank from taking the step.
TEST(DistributedPlayer, GoesOnWhereAHookThrows) {
  const std::string file = player_file("hook");
  record_with_hooks(file);
  const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
    Workers own(1);
    DistributedPlayer player(file, {}, transport, own);
    bool throws = rank == 1;
    int thrown = 0;
    player.world().world().set_contact_rule([&](const ContactRuleBatch&) {
      if (throws) throw std::runtime_error("a rule that fails");
    });
    for (int i = 0; i < 110; ++i) {
      try {
        player.step(own);
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "a rule that fails");
        ++thrown;
      }
    }
    throws = false;
    EXPECT_EQ(thrown > 0, rank == 1) << thrown;
    EXPECT_EQ(player.position(), 110u);
    const auto found = player.verify(130, own);
    EXPECT_FALSE(found) << found->difference;
  });
  EXPECT_EQ(all_of(errors), "");
  std::remove(file.c_str());
}

TEST(DistributedPlayer, GoesBackToWhatWasRecordedWhereItFailsToTellADifference) {
  const std::string file = player_file("fails_to_tell");
  record_with_hooks(file);
  const auto errors = run_ranks(1, [&](int, Transport& transport) {
    Workers own(1);
    DistributedPlayer player(file, 100, transport, own);
    World& world = player.world().world();
    world.set_linear_velocity(world.body_at(kFirstBody + 20), {0, 1, 0});  // shows in the next step
    std::uint64_t steps = 0;
    world.set_contact_rule([&](const ContactRuleBatch&) {
      steps = player.position() - 100;
      if (steps == 3) throw std::runtime_error("a rule that fails");
    });
    EXPECT_THROW(player.verify(130, own), std::runtime_error);
    EXPECT_EQ(steps, 3u);
    const auto found = player.verify(130, own);
    EXPECT_FALSE(found) << found->difference;
  });
  EXPECT_EQ(all_of(errors), "");
  std::remove(file.c_str());
}

TEST(DistributedPlayer, RefusesOtherFilesAndSteps) {
  const std::string file = player_file("one"), other = player_file("other");
  record_by_ranks(file, 2);
  record_by_one(other);
  const auto told = [&](const std::string& of_last, std::uint64_t from, std::uint64_t from_of_last) {
    const auto errors = run_ranks(3, [&](int rank, Transport& transport) {
      Workers own(1);
      const bool is_last = rank == 2;
      DistributedPlayer player(is_last ? of_last : file, is_last ? from_of_last : from, transport, own);
    });
    EXPECT_NE(errors[0], "");
    return errors[2];
  };
  EXPECT_NE(told(file, 421, 421).find("step is 421, must lie in [0, 420]"), std::string::npos);
  EXPECT_NE(told(other, 4, 4).find("ranks play other recordings"), std::string::npos);
  EXPECT_NE(told(file, 4, 5).find("ranks play other recordings, or other steps"), std::string::npos);
  std::remove(file.c_str());
  std::remove(other.c_str());
}

}  // namespace
}  // namespace scree
