// A recorder, as a world sees it: it is notified of each call. A world that is not recorded has none.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

namespace scree {

class CallWriter;
struct WorldData;
enum class RecordedCall : std::uint8_t;

// A call that has been made, and how its arguments are written.
struct MadeCall {
  RecordedCall call;
  const void* arguments;
  void (*write)(const void* arguments, CallWriter& writer);
};

// Notified by the thread that uses the world, after the call has succeeded. So a sink must not throw; one
// that cannot go on detaches itself from the world.
class CallSink {
 public:
  virtual void called(const MadeCall& call) noexcept = 0;
  virtual void restored(const WorldData& data) noexcept = 0;
  virtual void stepped(const WorldData& data, float dt, std::uint64_t hash) noexcept = 0;
  // The world is no more: destroyed or assigned to.
  virtual void world_ended() noexcept = 0;
  // A step has thrown, because memory ran out: the world can only be destroyed.
  virtual void step_failed() noexcept = 0;

 protected:
  ~CallSink() = default;
};

// The world's end of the link. Declared last in the world, so that it goes first.
struct SinkLink {
  CallSink* sink = nullptr;
  std::optional<std::uint64_t> hash;  // of the step that ends, where a stage has made it beside its own work

  SinkLink() = default;
  SinkLink(SinkLink&&) noexcept {}  // stays with the data that the sink knows
  SinkLink& operator=(SinkLink&&) = delete;
  ~SinkLink() { end(); }
  void end() noexcept {
    if (CallSink* const ended = std::exchange(sink, nullptr)) ended->world_ended();
  }
  void fail() noexcept {
    if (CallSink* const ended = std::exchange(sink, nullptr)) ended->step_failed();
  }
};

}  // namespace scree
