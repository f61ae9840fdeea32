// Laws of snapshots that share pages and are used by several threads at once: each holds its own world.
#include <gtest/gtest.h>
#include <scree/scree.h>

#include <atomic>
#include <thread>
#include <vector>

namespace scree {
namespace {

World field() {
  World world;
  std::vector<BodyId> bodies(800);
  world.create_bodies(std::vector<BodyDef>(800, BodyDef{.type = BodyType::fixed}), std::vector<Geometry>(800),
                      {}, {}, bodies);
  return world;
}

BodyId nth(const World& world, std::uint32_t index) { return world.body_at(index); }

// A world of its own for each thread, all last saved, by their own records, to the same snapshot.
TEST(SavingThreads, MaySaveWorldsThatComeFromOneSnapshot) {
  World origin = field();
  std::vector<Snapshot> shared(2);
  for (int round = 0; round < 6; ++round) {
    save(origin, shared[0]);
    save(origin, shared[1]);
    std::vector<World> worlds(3);
    for (World& world : worlds) restore(world, shared[0]);
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < worlds.size(); ++i) {
      threads.emplace_back([&, i] {
        World& world = worlds[i];
        Snapshot own;
        for (std::uint32_t k = 0; k < 10; ++k) {
          const BodyId body = nth(world, 20 + 60 * k + static_cast<std::uint32_t>(i));
          world.set_user_data(body, 1 + i);
          save(world, own);
          World copy;
          restore(copy, own);
          if (copy.user_data(body) != 1 + i) ++wrong;
          if (write_snapshot(own) != write_snapshot(read_snapshot(write_snapshot(own)))) ++wrong;
        }
      });
    }
    // Meanwhile their base is read, saved into in place, and destroyed.
    threads.emplace_back([&] {
      const std::vector<std::byte> before = write_snapshot(shared[1]);
      origin.set_user_data(nth(origin, 300), static_cast<std::uint64_t>(round) + 5);
      save(origin, shared[0]);
      if (write_snapshot(shared[1]) != before) ++wrong;
      shared[0] = Snapshot();
    });
    for (std::thread& thread : threads) thread.join();
    ASSERT_EQ(wrong.load(), 0);
  }
}

}  // namespace
}  // namespace scree
