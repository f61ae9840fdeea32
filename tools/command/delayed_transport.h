// Messages that take longer than they do: to see on one machine what a slower network would cost.
#pragma once

#include <scree/transport.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace scree::command {

// Each message arrives no sooner than `latency` after it was sent. The ranks share a machine, and so a clock.
class DelayedTransport final : public Transport {
 public:
  DelayedTransport(Transport& transport, std::chrono::nanoseconds latency)
      : transport_(transport), latency_(latency.count()) {}
  int rank() const override { return transport_.rank(); }
  int ranks() const override { return transport_.ranks(); }
  void send(int to, std::span<const std::byte> message) override {
    const std::int64_t now = time();
    stamped_.resize(sizeof now + message.size());
    std::memcpy(stamped_.data(), &now, sizeof now);
    if (!message.empty()) std::memcpy(stamped_.data() + sizeof now, message.data(), message.size());
    transport_.send(to, stamped_);
  }
  std::span<const std::byte> receive(int from) override {
    const std::span<const std::byte> stamped = transport_.receive(from);
    std::int64_t sent = 0;
    std::memcpy(&sent, stamped.data(), sizeof sent);
    while (time() < sent + latency_) {
    }
    return stamped.subspan(sizeof sent);
  }
  void write_together(const std::string& file, std::uint64_t offset,
                      std::span<const std::byte> part) override {
    transport_.write_together(file, offset, part);
  }

 private:
  static std::int64_t time() {  // ns
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }

  Transport& transport_;
  std::int64_t latency_;  // ns
  std::vector<std::byte> stamped_;
};

}  // namespace scree::command
