// Laws of what players measure besides the recorded world: it is what that world would have measured, and
// changes nothing that is recorded.
#include <scree/recording.h>
#include <tests/parallel/recording/recording_fixture.h>

#include <cstddef>
#include <span>
#include <vector>

namespace scree::test {
namespace {

TEST(PlayerMeasures, AreThoseOfAWorldThatMeasuredAllAlong) {
  TemporaryFile silent, logged;
  std::vector<std::size_t> begins, forces;
  for (const bool measured : {true, false}) {
    Heap heap;
    WorldSettings settings = heap.world.settings();
    settings.contact_forces = measured;
    settings.measure_residual = measured;
    settings.contact_events = measured ? ContactEvents::all : ContactEvents::none;
    heap.world.set_settings(settings);
    Recorder recorder(heap.world, (measured ? logged : silent).path(), {.keyframe_spacing = 9});
    for (int i = 0; i < 40; ++i) {
      if (i == 20) heap.world.set_settings(settings);
      step(heap.world, kDt, heap.workers);
      if (!measured) continue;
      begins.push_back(heap.world.contact_begins().size());
      forces.push_back(heap.world.contact_forces(std::span<ContactForces>{}));
    }
    recorder.finish();
  }
  Player player(silent.path());
  Workers workers(1);
  player.measure({.contact_forces = true, .residual = true, .contact_events = ContactEvents::begin_end});
  EXPECT_FALSE(player.recorded_dt());
  for (std::size_t i = 0; i < begins.size(); ++i) {
    ASSERT_TRUE(player.step(workers));
    EXPECT_EQ(player.world().hash(), *player.recorded_hash());
    EXPECT_EQ(player.world().contact_begins().size(), begins[i]) << i;
    EXPECT_EQ(player.world().contact_forces(std::span<ContactForces>{}), forces[i]) << i;
    EXPECT_EQ(*player.recorded_dt(), kDt);
  }
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

}  // namespace
}  // namespace scree::test
