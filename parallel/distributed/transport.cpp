// See transport.h.
#include <parallel/distributed/transport.h>
#include <scree/error.h>

#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>

namespace scree {

namespace {

// Receives as many values as there are, and no others.
void receive_values(Transport& transport, int from, std::span<std::int64_t> values) {
  std::vector<std::byte> message;
  transport.receive(from, message);
  if (message.size() != values.size_bytes()) {
    throw Error("rank " + std::to_string(from) + " has sent " + std::to_string(message.size()) +
                " bytes instead of " + std::to_string(values.size_bytes()) + ": its world is another one");
  }
  std::memcpy(values.data(), message.data(), message.size());
}

}  // namespace

void add_up(Transport& transport, std::span<std::int64_t> values) {
  const int ranks = transport.ranks();
  if (transport.rank() != 0) {
    transport.send(0, std::as_bytes(values));
    receive_values(transport, 0, values);
    return;
  }
  std::vector<std::int64_t> part(values.size());
  for (int from = 1; from < ranks; ++from) {
    receive_values(transport, from, part);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += part[i];
  }
  for (int to = 1; to < ranks; ++to) transport.send(to, std::as_bytes(values));
}

// The messages from one rank to another, and who waits for them.
struct Lane {
  std::mutex mutex;
  std::condition_variable arrived;
  std::deque<std::vector<std::byte>> messages;
  bool closed = false;
};

struct Meeting::State {
  class End final : public Transport {
   public:
    End(State& state, int rank) : state_(state), rank_(rank) {}
    int rank() const override { return rank_; }
    int ranks() const override { return state_.ranks; }
    void send(int to, std::span<const std::byte> message) override {
      Lane& lane = state_.lane(rank_, to);
      {
        const std::lock_guard lock(lane.mutex);
        lane.messages.emplace_back(message.begin(), message.end());
      }
      lane.arrived.notify_one();
    }
    void receive(int from, std::vector<std::byte>& message) override {
      Lane& lane = state_.lane(from, rank_);
      std::unique_lock lock(lane.mutex);
      lane.arrived.wait(lock, [&] { return lane.closed || !lane.messages.empty(); });
      if (lane.messages.empty()) throw Error("rank " + std::to_string(from) + " has left");
      message = std::move(lane.messages.front());
      lane.messages.pop_front();
    }

   private:
    State& state_;
    int rank_;
  };

  explicit State(int count)
      : ranks(count), lanes(static_cast<std::size_t>(count) * static_cast<std::size_t>(count)) {
    for (int rank = 0; rank < count; ++rank) ends.push_back(std::make_unique<End>(*this, rank));
  }
  Lane& lane(int from, int to) {
    return lanes[static_cast<std::size_t>(from) * static_cast<std::size_t>(ranks) +
                 static_cast<std::size_t>(to)];
  }

  int ranks;
  std::vector<Lane> lanes;  // by sender and receiver
  std::vector<std::unique_ptr<End>> ends;
};

Meeting::Meeting(int ranks) : state_(std::make_unique<State>(ranks)) {}
Meeting::~Meeting() = default;
Transport& Meeting::at(int rank) { return *state_->ends[static_cast<std::size_t>(rank)]; }

void Meeting::leave(int rank) {
  for (int to = 0; to < state_->ranks; ++to) {
    Lane& lane = state_->lane(rank, to);
    {
      const std::lock_guard lock(lane.mutex);
      lane.closed = true;
    }
    lane.arrived.notify_one();
  }
}

}  // namespace scree
