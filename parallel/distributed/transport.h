// Messages between the ranks of a distributed world. A rank is one of the processes, or of the threads of a
// test, that hold a part of the world each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace scree {

// One rank's end of the connections to all others. Used by one thread at a time.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual int rank() const = 0;
  virtual int ranks() const = 0;
  // Hands a message to another rank. Does not wait until that one takes it.
  virtual void send(int to, std::span<const std::byte> message) = 0;
  // Waits for the next message of another rank; those of one rank arrive in the order in which it sent them.
  // Throws Error, which names the rank, if that one has left.
  virtual void receive(int from, std::vector<std::byte>& message) = 0;
};

// Adds up, place by place, what all ranks give. Each rank calls it.
void add_up(Transport& transport, std::span<std::int64_t> values);

// Ranks that are threads of one process: tests reach any number of them without a launcher.
class Meeting {
 public:
  explicit Meeting(int ranks);
  ~Meeting();
  Meeting(const Meeting&) = delete;
  Meeting& operator=(const Meeting&) = delete;
  Transport& at(int rank);
  // The rank sends nothing any more: who waits for it gets an error instead of waiting for ever.
  void leave(int rank);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree
