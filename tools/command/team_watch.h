// Tells which rank of a distributed run has died, and from where the run can go on. What starts the ranks
// ends all of them with SIGTERM where one dies; then the lowest rank of each machine tells what it sees.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scree::command {

struct RankProcess {
  int rank;
  pid_t process;
};

// Of this machine, this one among them, ascending. Takes over SIGTERM. Once in a process.
void watch_ranks(const std::vector<RankProcess>& ranks, int own_rank);
// All steps until this one are in the file.
void note_checkpoint(const std::string& file, std::uint64_t step);
// The run fails and tells so itself: a signal says nothing more.
void stop_watching();
// What a run that fails tells besides the reason: ranks that have died, and the last checkpoint. May be
// empty.
std::string describe_losses();

}  // namespace scree::command
