// Laws of movers in worlds that are stepped: many of them push, ride and climb to the same bits on every
// backend, and go on from a snapshot as they would have gone on.
#include <gtest/gtest.h>
#include <tests/determinism/many_threads.h>
#include <tests/parallel/queries/query_fixture.h>

#include <vector>

namespace scree::determinism {
namespace {

constexpr float kStep = 1.0f / 60.0f;  // s

// Handles name the world, and each has another one.
MoverState without_world(MoverState state) {
  state.ground_body.world = state.ground_shape.world = 0;
  return state;
}

// Movers in a crowd of bodies of all types and shapes.
struct Crowd {
  testing::MixedWorld mixed{29, 200, 5.0f};
  std::vector<MoverState> movers;

  Crowd() {
    testing::Dice dice(5);
    for (int i = 0; i < 8; ++i) movers.push_back({.position = dice.within({4, 4, 4})});
  }
};

void go_on(World& world, std::vector<MoverState>& movers, int first, int steps, Workers& workers) {
  for (int i = first; i < first + steps; ++i) {
    step(world, kStep, workers);
    for (std::size_t k = 0; k < movers.size(); ++k) {
      MoverState& mover = movers[k];
      testing::Dice dice(static_cast<std::uint64_t>(i / 20) * 100 + k);
      Vec3 wanted = dice.within({4, 0, 4});
      if (mover.ground != MoverGround::firm) wanted.y = mover.velocity.y - 9.81f * kStep;
      if (mover.ground == MoverGround::firm && i % 50 == 7) wanted.y = 4.0f;
      move(world, mover, {.push_force = 2000.0f}, wanted, kStep);
    }
  }
}

class Movers : public ManyThreads {};

TEST_F(Movers, GoTheSameWaysOnEveryBackend) {
  std::vector<MoverState> expected;
  std::uint64_t hash = 0;
  for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (!is_supported(isa)) continue;
    for (const int threads : {1, 3}) {
      Workers workers({.threads = threads, .isa = isa});
      Crowd crowd;
      go_on(crowd.mixed.world, crowd.movers, 0, 240, workers);
      std::vector<MoverState> found;
      for (const MoverState& mover : crowd.movers) found.push_back(without_world(mover));
      if (expected.empty()) {
        expected = found;
        hash = crowd.mixed.world.hash();
      }
      EXPECT_EQ(found, expected);
      EXPECT_EQ(crowd.mixed.world.hash(), hash);
    }
  }
}

TEST_F(Movers, GoOnFromASnapshotAsTheyWouldHave) {
  Workers workers(2);
  Crowd crowd;
  World& world = crowd.mixed.world;
  go_on(world, crowd.movers, 0, 60, workers);
  Snapshot snapshot;
  save(world, snapshot);
  const std::vector<MoverState> saved = crowd.movers;
  go_on(world, crowd.movers, 60, 90, workers);
  const std::uint64_t hash = world.hash();
  const std::vector<MoverState> expected = crowd.movers;
  restore(world, snapshot);
  crowd.movers = saved;
  go_on(world, crowd.movers, 60, 90, workers);
  EXPECT_EQ(world.hash(), hash);
  EXPECT_EQ(crowd.movers, expected);
}

}  // namespace
}  // namespace scree::determinism
