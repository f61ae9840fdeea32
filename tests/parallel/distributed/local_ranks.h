// Runs what each rank does on a thread of its own, for the tests of this folder.
#pragma once

#include <scree/transport.h>

#include <exception>
#include <string>
#include <thread>
#include <vector>

namespace scree::distributed_tests {

// Calls work(rank, transport) for each rank. What a rank throws ends all of them. By rank: what it has
// thrown, or nothing.
template <class Work>
std::vector<std::string> run_ranks(int ranks, Work&& work) {
  LocalRanks local(ranks);
  std::vector<std::string> errors(static_cast<std::size_t>(ranks));
  const auto run_rank = [&](int rank) {
    try {
      work(rank, local.at(rank));
    } catch (const std::exception& error) {
      errors[static_cast<std::size_t>(rank)] = error.what();
    }
    local.leave(rank);
  };
  std::vector<std::thread> threads;
  for (int rank = 1; rank < ranks; ++rank) threads.emplace_back(run_rank, rank);
  run_rank(0);
  for (std::thread& thread : threads) thread.join();
  return errors;
}

inline std::string all_of(const std::vector<std::string>& errors) {
  std::string all;
  for (const std::string& error : errors) all += error;
  return all;
}

}  // namespace scree::distributed_tests
