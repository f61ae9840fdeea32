// See give_calls.h. A message tells whether more follow, then the solids that none before has told of, then
// calls; or it tells what the calls have thrown.
#include <core/state/recording_format/call_bytes.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/give_calls.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/send_bodies.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace scree {

namespace {

// Whoever makes many bodies, does so in parts: what other ranks do not need of one goes before the next
// comes.
constexpr std::size_t kPartBytes = std::size_t{1} << 22;

enum class Follows : std::uint8_t { more, nothing, error };

// Sends the calls of this rank while it is there. A recorder is told of them, too.
class CallSender final : public CallSink {
 public:
  CallSender(WorldData& data, Transport& transport, const AfterCalls& after)
      : data_(data), transport_(transport), after_(after), before_(data.recording.sink) {
    data.recording.sink = this;
  }
  ~CallSender() {
    if (data_.recording.sink == this) data_.recording.sink = before_;
  }
  CallSender(const CallSender&) = delete;
  CallSender& operator=(const CallSender&) = delete;

  void called(const MadeCall& call) noexcept override {
    if (before_ != nullptr) before_->called(call);
    if (data_.recording.sink != this) {  // a recorder that cannot go on has let go of the world
      before_ = nullptr;
      data_.recording.sink = this;
    }
    if (problem_ != nullptr) return;
    try {
      CallWriter writer(calls_, solids_);
      write_call(call, writer);
      if (calls_.size() >= kPartBytes) {
        send(Follows::more);
        after_();
      }
    } catch (...) {
      problem_ = std::current_exception();
    }
  }
  void restored(const WorldData&) noexcept override {}  // parts of a world refuse that ...
  void stepped(const WorldData&, float, std::uint64_t) noexcept override {
  }  // ... and while they are given this
  void world_ended() noexcept override {}
  void step_failed() noexcept override {}

  // What is left; throws what has kept calls from being sent.
  void finish() {
    if (problem_ != nullptr) std::rethrow_exception(problem_);
    send(Follows::nothing);
  }
  void finish(const Error& error) {
    if (problem_ != nullptr) std::rethrow_exception(problem_);
    send(Follows::more);
    after_();
    ByteWriter message;
    message.put(static_cast<std::uint8_t>(Follows::error));
    message.put(static_cast<std::uint32_t>(error.code()));
    const std::string_view text = error.what();
    message.put_bytes(text.data(), text.size());
    send_to_all(message);
  }

 private:
  void send(Follows follows) {
    ByteWriter message;
    message.put(static_cast<std::uint8_t>(follows));
    const SolidViews all = solids_.solids();
    write_solids(all.hulls.subspan(std::exchange(hulls_told_, all.hulls.size())), message);
    write_mesh_solids(all.meshes.subspan(std::exchange(meshes_told_, all.meshes.size())), message);
    message.put_bytes(calls_.bytes().data(), calls_.size());
    calls_.shrink(0);
    send_to_all(message);
  }
  void send_to_all(const ByteWriter& message) {
    for (int to = 0; to < transport_.ranks(); ++to) {
      if (to != transport_.rank()) transport_.send(to, message.bytes());
    }
  }

  WorldData& data_;
  Transport& transport_;
  const AfterCalls& after_;
  CallSink* before_;
  ByteWriter calls_;
  SolidList solids_;  // of all calls
  std::size_t hulls_told_ = 0, meshes_told_ = 0;
  std::exception_ptr problem_;
};

}  // namespace

std::optional<Error> send_calls(World& world, Transport& transport, const std::function<void(World&)>& calls,
                                const AfterCalls& after) {
  CallSender sender(internals(world), transport, after);
  std::optional<Error> problem;
  try {
    if (calls) calls(world);
  } catch (const Error& error) {
    problem = error;
  } catch (const std::exception& error) {
    problem = Error(error.what());
  } catch (...) {
    problem = Error("DistributedWorld::give: the calls have thrown what is no std::exception");
  }
  if (problem) {
    sender.finish(*problem);
  } else {
    sender.finish();
  }
  after();
  return problem;
}

std::optional<Error> take_calls(World& world, Transport& transport, int from, const AfterCalls& after) {
  SolidVectors solids;
  for (Follows follows = Follows::more; follows == Follows::more;) {
    const std::span<const std::byte> received = transport.receive(from);
    const std::vector<std::byte> message(received.begin(), received.end());
    try {
      ByteReader head(message, "the message");
      follows = static_cast<Follows>(head.take<std::uint8_t>());
      if (follows == Follows::error) {
        const auto code = static_cast<ErrorCode>(head.take<std::uint32_t>());
        const std::size_t length = head.left();
        const Error problem(std::string(reinterpret_cast<const char*>(head.take_bytes(length)), length),
                            code);
        after();
        return problem;
      }
      read_solids(head, solids.hulls);
      read_mesh_solids(head, solids.meshes);
      const std::span<const std::byte> rest = std::span<const std::byte>(message).subspan(head.at());
      CallReader calls(rest, SolidViews{solids.hulls, solids.meshes});
      while (calls.left() > 0)
        take_call(static_cast<RecordedCall>(calls.take<std::uint8_t>()), calls, &world);
    } catch (const RefusedBytes&) {
      refuse_world_of(from);
    }
    after();
  }
  return {};
}

void let_go_of_given(WorldData& data, Border& border) {
  const std::vector<std::int32_t> before = border.ghosts;
  adopt_calls(data, border);
  std::vector<std::int32_t> come;
  std::set_difference(border.ghosts.begin(), border.ghosts.end(), before.begin(), before.end(),
                      std::back_inserter(come));
  for (const std::int32_t body : come) set_absent(data, body, true);
  std::erase_if(border.ghosts,
                [&](std::int32_t body) { return std::binary_search(come.begin(), come.end(), body); });
  // Calls may have written to rows of shapes whose bodies went before.
  std::vector<std::int32_t> changed;
  const Column<std::int32_t>& dirty = data.shapes.dirty;
  for (std::size_t i = std::min(border.dirty_before, dirty.size()); i < dirty.size(); ++i) {
    if (is_absent(data.bodies, data.shapes.body[dirty[i]])) changed.push_back(dirty[i]);
  }
  border.dirty_before = dirty.size();
  give_up_rows_among(data, come, changed);
}

}  // namespace scree
