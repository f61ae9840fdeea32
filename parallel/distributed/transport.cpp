// See scree/transport.h.
#include <fcntl.h>
#include <scree/error.h>
#include <scree/transport.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

namespace scree {

namespace {

constexpr int kMostLocalRanks = 256;

// Values may be hashes, whose sums wrap around.
std::int64_t sum_of(std::int64_t one, std::int64_t other) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(one) + static_cast<std::uint64_t>(other));
}

void check_rank(int rank, int ranks) {
  if (rank >= 0 && rank < ranks) return;
  throw Error("LocalRanks: there is no rank " + std::to_string(rank) + " of " + std::to_string(ranks));
}

// Receives as many values as there are, and no others.
void receive_values(Transport& transport, int from, std::span<std::int64_t> values) {
  const std::span<const std::byte> message = transport.receive(from);
  if (message.size() != values.size_bytes()) {
    throw Error("rank " + std::to_string(from) + " has sent " + std::to_string(message.size()) +
                " bytes instead of " + std::to_string(values.size_bytes()) + ": its world is another one");
  }
  std::memcpy(values.data(), message.data(), message.size());
}

}  // namespace

Transport::~Transport() = default;

void Transport::add_up(std::span<std::int64_t> values) {
  const int all = ranks();
  if (rank() != 0) {
    send(0, std::as_bytes(values));
    receive_values(*this, 0, values);
    return;
  }
  std::vector<std::int64_t> part(values.size());
  for (int from = 1; from < all; ++from) {
    receive_values(*this, from, part);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = sum_of(values[i], part[i]);
  }
  for (int to = 1; to < all; ++to) send(to, std::as_bytes(values));
}

namespace {

// errno, or 0.
int write_part(const std::string& file, std::uint64_t offset, std::span<const std::byte> part) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  while (!part.empty()) {
    const ssize_t written = pwrite(descriptor, part.data(), part.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) break;
    part = part.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  const bool is_written = part.empty() && fsync(descriptor) == 0;
  const int problem = is_written ? 0 : errno != 0 ? errno : EIO;
  return close(descriptor) != 0 && problem == 0 ? errno : problem;
}

// Throws on all ranks if one has a problem; `problem` is this rank's.
void check_together(Transport& transport, const std::string& file, int problem) {
  std::int64_t failures = problem != 0 ? 1 : 0;
  transport.add_up({&failures, 1});
  if (failures == 0) return;
  throw Error(file + ": cannot be written: " +
                  (problem != 0 ? std::strerror(problem) : std::to_string(failures) + " other ranks failed"),
              ErrorCode::io_failure);
}

}  // namespace

void Transport::write_together(const std::string& file, std::uint64_t offset,
                               std::span<const std::byte> part) {
  check_together(*this, file, write_part(file, offset, part));
}

// The messages from one rank to another, and who waits for them.
struct Lane {
  std::mutex mutex;
  std::condition_variable arrived;
  std::deque<std::vector<std::byte>> messages;
  bool closed = false;
};

struct LocalRanks::State {
  class End final : public Transport {
   public:
    End(State& state, int rank) : state_(state), rank_(rank) {}
    int rank() const override { return rank_; }
    int ranks() const override { return state_.ranks; }
    void send(int to, std::span<const std::byte> message) override {
      check_rank(to, state_.ranks);
      Lane& lane = state_.lane(rank_, to);
      {
        const std::lock_guard lock(lane.mutex);
        lane.messages.emplace_back(message.begin(), message.end());
      }
      lane.arrived.notify_one();
    }
    std::span<const std::byte> receive(int from) override {
      check_rank(from, state_.ranks);
      Lane& lane = state_.lane(from, rank_);
      std::unique_lock lock(lane.mutex);
      lane.arrived.wait(lock, [&] { return lane.closed || !lane.messages.empty(); });
      if (lane.messages.empty()) throw Error("rank " + std::to_string(from) + " has left");
      last_ = std::move(lane.messages.front());
      lane.messages.pop_front();
      return last_;
    }

   private:
    State& state_;
    int rank_;
    std::vector<std::byte> last_;
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

LocalRanks::LocalRanks(int ranks) {
  if (ranks < 1 || ranks > kMostLocalRanks) {
    throw Error("LocalRanks: " + std::to_string(ranks) + " ranks were asked for; there may be 1 to " +
                std::to_string(kMostLocalRanks));
  }
  state_ = std::make_unique<State>(ranks);
}
LocalRanks::~LocalRanks() = default;
Transport& LocalRanks::at(int rank) {
  check_rank(rank, state_->ranks);
  return *state_->ends[static_cast<std::size_t>(rank)];
}

void LocalRanks::leave(int rank) {
  check_rank(rank, state_->ranks);
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
