// Laws of what players measure besides the recorded world: it is what that world would have measured, and
// changes nothing that is recorded.
#include <scree/recording.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace scree::test {
namespace {

TEST(PlayerMeasures, AreThoseOfAWorldThatMeasuredAllAlong) {
  TemporaryFile silent, logged;
  struct Measured {
    std::vector<ContactEvent> begins, hits;
    std::vector<ContactForces> forces;
    double residual = 0.0, penetration = 0.0;
  };
  std::vector<Measured> expected;
  const auto read = [](const World& world) {
    Measured measured;
    measured.begins.assign(world.contact_begins().begin(), world.contact_begins().end());
    measured.hits.assign(world.contact_hits().begin(), world.contact_hits().end());
    measured.forces.resize(world.contact_forces(std::span<ContactForces>{}));
    world.contact_forces(measured.forces);
    measured.residual = world.stats().residual;
    measured.penetration = world.stats().penetration_max;
    return measured;
  };
  for (const bool measured : {true, false}) {
    Heap heap;
    WorldSettings settings = heap.world.settings();
    settings.contact_forces = measured;
    settings.measure_residual = settings.measure_penetration = measured;
    settings.contact_events = measured ? ContactEvents::all : ContactEvents::none;
    heap.world.set_settings(settings);
    Recorder recorder(heap.world, (measured ? logged : silent).path(), {.keyframe_spacing = 9});
    for (int i = 0; i < 40; ++i) {
      if (i == 20) heap.world.set_settings(settings);
      step(heap.world, kDt, heap.workers);
      if (measured) expected.push_back(read(heap.world));
    }
    recorder.finish();
  }
  Player player(silent.path());
  Workers workers(1);
  player.measure({.contact_forces = true,
                  .residual = true,
                  .penetration = true,
                  .contact_events = ContactEvents::begin_end | ContactEvents::hit});
  EXPECT_FALSE(player.recorded_dt());
  std::size_t hits = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(player.step(workers));
    EXPECT_EQ(player.world().hash(), *player.recorded_hash());
    EXPECT_EQ(*player.recorded_dt(), kDt);
    const Measured measured = read(player.world());
    EXPECT_EQ(measured.residual, expected[i].residual);
    EXPECT_EQ(measured.penetration, expected[i].penetration);
    const auto same = [](const ContactEvent& a, const ContactEvent& b) {
      return a.shape_a.index == b.shape_a.index && a.shape_b.index == b.shape_b.index &&
             a.normal_impulse == b.normal_impulse && a.approach_speed == b.approach_speed;
    };
    EXPECT_TRUE(std::equal(measured.begins.begin(), measured.begins.end(), expected[i].begins.begin(),
                           expected[i].begins.end(), same));
    EXPECT_TRUE(std::equal(measured.hits.begin(), measured.hits.end(), expected[i].hits.begin(),
                           expected[i].hits.end(), same));
    EXPECT_TRUE(std::equal(measured.forces.begin(), measured.forces.end(), expected[i].forces.begin(),
                           expected[i].forces.end(), [](const ContactForces& a, const ContactForces& b) {
                             return a.shape_a.index == b.shape_a.index &&
                                    a.shape_b.index == b.shape_b.index && impulse_on_b(a) == impulse_on_b(b);
                           }));
    hits += measured.hits.size();
  }
  EXPECT_GT(hits, 0u);
  EXPECT_GT(player.world().stats().residual, 0.0);
  player.seek(15, workers);  // through a keyframe
  ASSERT_TRUE(player.step(workers));
  EXPECT_GT(player.world().contact_forces(std::span<ContactForces>{}), 0u);
  EXPECT_EQ(player.world().hash(), *player.recorded_hash());
  EXPECT_TRUE(player.branch().settings().contact_forces);

  EXPECT_FALSE(player.verify(0, 40, workers));  // all states agree again
  EXPECT_FALSE(player.world().settings().contact_forces);
  player.measure({.contact_forces = true});
  ASSERT_TRUE(player.world().settings().contact_forces == false && player.position() == 40);
  player.seek(30, workers);
  ASSERT_TRUE(player.step(workers));
  player.measure({});
  player.seek(32, workers);
  EXPECT_FALSE(player.world().settings().contact_forces);
}

TEST(PlayerCalls, AreMadeOnceBeforeTheStep) {
  TemporaryFile file;
  World world({.gravity = {}});
  const BodyId body = world.create_body({});
  Workers workers(1);
  {
    Recorder recorder(world, file.path(), {.keyframe_spacing = 4});
    for (int i = 0; i < 10; ++i) {
      world.set_pose(body, {{static_cast<float>(i + 1), 0.0f, 0.0f}, {}});
      step(world, kDt, workers);
    }
    recorder.finish();
  }
  Player player(file.path());
  const auto place = [&] { return player.world().pose(player.world().body_at(body.index)).position.x; };
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(place(), static_cast<float>(i));
    if (i == 6) player.measure({.residual = true});
    if (i == 7) player.measure({});  // the world is another one now, until it is sought again
    player.make_calls(workers);
    EXPECT_EQ(place(), static_cast<float>(i + 1));
    EXPECT_EQ(player.position(), static_cast<std::uint64_t>(i));
    player.make_calls(workers);
    if (i % 3 == 1) {  // a seek to where it is goes back behind the calls
      player.seek(static_cast<std::uint64_t>(i), workers);
      EXPECT_EQ(place(), static_cast<float>(i));
    }
    ASSERT_TRUE(player.step(workers));
    EXPECT_EQ(player.world().hash(), *player.recorded_hash());
  }
  player.make_calls(workers);  // there is no next step
  EXPECT_EQ(place(), 10.0f);
  player.seek(5, workers);
  player.make_calls(workers);
  player.seek(7, workers);  // on from the calls
  EXPECT_EQ(player.world().hash(), *player.recorded_hash());
  player.seek(5, workers);
  player.make_calls(workers);
  EXPECT_FALSE(player.verify(5, 10, workers));
}

}  // namespace
}  // namespace scree::test
