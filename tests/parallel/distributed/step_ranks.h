// Steps a scene on ranks that are divided as a test says, and holds the sum of their hashes to a single
// world's.
#pragma once

#include <core/world/edit.h>
#include <gtest/gtest.h>
#include <parallel/distributed/border.h>
#include <tests/parallel/distributed/absent_rows.h>
#include <tests/physics/lab.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scree::distributed_tests {

using physics::kStep;
using physics::Lab;
using Fill = std::function<void(Lab&)>;
using Owners = std::function<std::int32_t(std::int32_t body, int ranks)>;

inline WorldSettings settings_for_ranks(bool sleeping = false, bool continuous = true) {
  WorldSettings settings = physics::without_sleep();
  settings.sleeping = sleeping;
  settings.continuous = continuous;
  return settings;
}

struct RunPlan {
  int ranks = 2;
  int steps = 60;
  int threads = 1;                           // of each rank
  std::vector<Isa> sets = {Isa::automatic};  // rank by rank, over and over
  bool sleeping = false;
  int steps_per_draw = 0;  // how often bodies get new owners, drawn at random; 0: never
  int one_in = 1;          // bodies, drawn at random, does
};

inline std::vector<std::uint64_t> hashes_of_one_world(const Fill& fill, const RunPlan& run) {
  Lab lab(settings_for_ranks(run.sleeping));
  fill(lab);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < run.steps; ++i) {
    lab.run(1);
    hashes.push_back(lab.world.hash());
  }
  return hashes;
}

// Drawn for each body.
inline std::int32_t random_owner(std::int32_t body, int ranks) {
  physics::Random random(static_cast<std::uint64_t>(body) + 77);
  return static_cast<std::int32_t>(random.uniform(0, static_cast<float>(ranks) - 1e-4f));
}
inline std::int32_t owner_by_blocks(std::int32_t body, int ranks) { return body / 10 % ranks; }

// Gives one in so many of this rank's bodies to owners that are drawn anew.
inline void redraw_owners(World& world, int draw, int ranks, int one_in, Workers& workers) {
  WorldData& data = internals(world);
  Border& border = *border_of(data);
  adopt_calls(data, border);
  std::vector<GivenBody> given;
  for (std::int32_t body = 0; std::cmp_less(body, border.owner.size()); ++body) {
    if (border.owns(body) && random_owner(body + 3000 * draw, one_in) == 0)
      given.push_back({body, random_owner(body + 1000 * draw, ranks)});
  }
  Crew crew(workers);
  give_bodies(data, given, crew);
}

// Each rank on a thread of its own. `hashes`: what each adds to that of the whole world, step by step. What a
// rank throws ends all of them, and is returned.
inline std::string step_ranks(const Fill& fill, const Owners& owner_of, const RunPlan& run,
                              std::vector<std::vector<std::uint64_t>>& hashes) {
  LocalRanks local(run.ranks);
  std::vector<std::string> errors(static_cast<std::size_t>(run.ranks));
  hashes.assign(static_cast<std::size_t>(run.ranks), {});
  const auto step_rank = [&](int rank) {
    const auto place = static_cast<std::size_t>(rank);
    try {
      Lab lab(settings_for_ranks(run.sleeping));
      lab.workers = Workers(WorkersOptions{.threads = run.threads, .isa = run.sets[place % run.sets.size()]});
      fill(lab);
      WorldData& data = internals(lab.world);
      std::vector<std::int32_t> owners(data.bodies.flags.size());
      for (std::size_t body = 0; body < owners.size(); ++body)
        owners[body] = owner_of(static_cast<std::int32_t>(body), run.ranks);
      divide_world(data, local.at(rank), owners);
      for (int i = 0; i < run.steps; ++i) {
        if (run.steps_per_draw > 0 && i % run.steps_per_draw == 0)
          redraw_owners(lab.world, i + 1, run.ranks, run.one_in, lab.workers);
        distributed_tests::scramble_absent_rows(data);
        lab.run(1);
        hashes[place].push_back(hash_of_part(data, *border_of(data)));
      }
    } catch (const std::exception& error) {
      errors[place] = error.what();
    }
    local.leave(rank);
  };
  std::vector<std::thread> threads;
  for (int rank = 1; rank < run.ranks; ++rank) threads.emplace_back(step_rank, rank);
  step_rank(0);
  for (std::thread& thread : threads) thread.join();
  std::string all;
  for (const std::string& error : errors) all += error;
  return all;
}

inline void expect_same_bits(const Fill& fill, const Owners& owner_of, const RunPlan& run) {
  const std::vector<std::uint64_t> expected = hashes_of_one_world(fill, run);
  std::vector<std::vector<std::uint64_t>> hashes;
  ASSERT_EQ(step_ranks(fill, owner_of, run, hashes), "");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::uint64_t sum = 0;
    for (const std::vector<std::uint64_t>& of_rank : hashes) sum += of_rank.at(i);
    ASSERT_EQ(sum, expected[i]) << run.ranks << " ranks, step " << i;
  }
}

// A scene of the catalog, of the motion that it has without drives and changes.
inline Fill scene(const std::string& name, const scenes::Parameters& parameters) {
  return [=](Lab& lab) { populate(lab.world, scenes::build(name, parameters).front()); };
}

}  // namespace scree::distributed_tests
