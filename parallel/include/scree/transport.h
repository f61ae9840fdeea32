// Transport: messages between the ranks of a distributed world, see scree/distributed_world.h. MpiTransport
// of scree/mpi.h connects processes, LocalRanks connects threads.
#pragma once

#include <scree/export.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace scree {

/// One rank's end of the connections to all others. Used by one thread at a time. Ranks are numbered from 0.
class SCREE_API Transport {
 public:
  virtual ~Transport();
  virtual int rank() const = 0;   ///< this one
  virtual int ranks() const = 0;  ///< how many there are, at least 1
  /// Hands a message, which may be empty, to another rank. Does not wait until that one takes it.
  virtual void send(int to, std::span<const std::byte> message) = 0;
  /// Waits for the next message of another rank; those of one rank arrive in the order in which it sent them.
  /// It stays valid until the next call of receive() or add_up(). Throws Error, which names the rank, if that
  /// one has left and the transport can tell: MPI cannot, and ends all ranks instead where one dies.
  virtual std::span<const std::byte> receive(int from) = 0;
  /// Adds up, place by place, what all ranks give. All ranks call it, with as many values; throws Error where
  /// ranks give different numbers of them. As it is here, rank 0 adds and sends, and it alone can tell.
  virtual void add_up(std::span<std::int64_t> values);
  /// Writes a part, which may be empty, into a file that is there, from `offset` on; the file grows where it
  /// must. All ranks call it together, with parts that do not overlap. Throws Error on all ranks unless all
  /// parts have been written to the disk. As it is here, each rank opens the file by itself.
  virtual void write_together(const std::string& file, std::uint64_t offset, std::span<const std::byte> part);
};

/// Ranks that are threads of one process: for tests, which reach any number of them without a launcher.
class SCREE_API LocalRanks {
 public:
  /// Throws Error for less than 1 or more than 256.
  explicit LocalRanks(int ranks);
  ~LocalRanks();
  LocalRanks(const LocalRanks&) = delete;
  LocalRanks& operator=(const LocalRanks&) = delete;
  Transport& at(int rank);  ///< for the thread of this rank; throws Error if there is no such rank
  /// The rank sends nothing any more: who waits for it gets an error instead of waiting for ever.
  void leave(int rank);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree
