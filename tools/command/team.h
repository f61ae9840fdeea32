// The processes of a distributed run.
#pragma once

#include <scree/scree.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scree::command {

// In a build without MPI there is none.
class Team {
 public:
  virtual ~Team() = default;
  virtual bool leads() const = 0;                 // one of them, which prints
  virtual int threads_each(int asked) const = 0;  // 0: the cores of this machine are shared out
  virtual int processes() const = 0;
  virtual int processes_here() const = 0;  // on this machine, which share its memory
  // The world becomes this process's part of it. `latency`: us, that each message takes longer than it would.
  virtual void take(World world, double latency) = 0;
  virtual DistributedWorld& world() = 0;
  // A checkpoint as read_checkpoint() reads it; then what is in place of the world.
  virtual DistributedWorld read(const std::string& checkpoint, double latency, Workers& workers) = 0;
  virtual void replace(DistributedWorld world) = 0;
  // A recording, from a step, or else from its first one.
  virtual DistributedPlayer play(const std::string& recording, std::optional<std::uint64_t> from,
                                 Workers& workers) = 0;
  virtual std::int64_t add_up(std::int64_t own) = 0;  // of all processes, which call it together
  // Before the world is taken: goes on when all processes have come here; throws Error where one has failed.
  virtual void meet() = 0;
  // What is told besides where the run ends before its time: all steps until this one are in the file.
  virtual void note_checkpoint(const std::string& file, std::uint64_t step) = 0;
  // Ends all processes with the message. Before the world is taken all of them fail alike: then one tells.
  [[noreturn]] virtual void fail(const std::exception& error, int exit_code) = 0;
};

// Throws Error in a build without MPI.
std::unique_ptr<Team> make_team();

}  // namespace scree::command
