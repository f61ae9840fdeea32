// A transport that counts what a rank sends and how long it waits.
#pragma once

#include <scree/transport.h>

#include <chrono>

namespace scree {

class CountedTransport final : public Transport {
 public:
  struct Sent {
    std::int64_t messages = 0, bytes = 0;
    double waiting_ms = 0.0;  // for what others send
  };

  explicit CountedTransport(Transport& transport) : transport_(transport) {}
  int rank() const override { return transport_.rank(); }
  int ranks() const override { return transport_.ranks(); }
  void send(int to, std::span<const std::byte> message) override {
    transport_.send(to, message);
    ++sent_.messages;
    sent_.bytes += static_cast<std::int64_t>(message.size());
  }
  std::span<const std::byte> receive(int from) override {
    const Waiting waiting(sent_);
    return transport_.receive(from);
  }
  void add_up(std::span<std::int64_t> values) override {
    const Waiting waiting(sent_);
    transport_.add_up(values);
    ++sent_.messages;
    sent_.bytes += static_cast<std::int64_t>(values.size_bytes());
  }

  void write_together(const std::string& file, std::uint64_t offset,
                      std::span<const std::byte> part) override {
    transport_.write_together(file, offset, part);
  }

  // Whether what a rank says holds on all ranks. All ranks call it together.
  bool holds_everywhere(bool holds) {
    std::int64_t failures = holds ? 0 : 1;
    add_up({&failures, 1});
    return failures == 0;
  }

  // Counts anew.
  void begin_step() { sent_ = {}; }
  const Sent& sent() const { return sent_; }

 private:
  using Clock = std::chrono::steady_clock;
  class Waiting {
   public:
    explicit Waiting(Sent& sent) : sent_(sent) {}
    ~Waiting() {
      sent_.waiting_ms += std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

   private:
    Sent& sent_;
    Clock::time_point begin_ = Clock::now();
  };

  Transport& transport_;
  Sent sent_;
};

}  // namespace scree
