// DistributedPlayer: plays a recording on many ranks, and verifies it.
#pragma once

#include <scree/distributed_world.h>
#include <scree/export.h>
#include <scree/recording.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace scree {

/// Plays a finished recording on many ranks, whoever has recorded it: each has its part of the world. No rank
/// needs room for more, but for keyframes of a single process, which each rank reads as a whole. All ranks
/// make the same calls together, with the same file and options; what is wrong with the file throws the same
/// Error on all of them.
class SCREE_API DistributedPlayer {
 public:
  /// Goes to a step, or where none is given to the first one: from the last keyframe at or before it.
  /// `transport` must outlive this. Throws Error for what is no recording, was changed, or has no such step,
  /// where ranks have files of different content, and as read_checkpoint().
  DistributedPlayer(const std::string& file, std::optional<std::uint64_t> from, Transport& transport,
                    Workers& workers, const DistributedOptions& options = {});
  ~DistributedPlayer();
  DistributedPlayer(DistributedPlayer&&) noexcept;  ///< the other one can only be assigned to or destroyed
  DistributedPlayer& operator=(
      DistributedPlayer&&) noexcept;  ///< the other one can only be assigned to or destroyed

  const RecordingInfo& info() const noexcept;                      ///< what the recording holds
  std::span<const std::uint64_t> keyframe_steps() const noexcept;  ///< where its whole states are, ascending
  DistributedWorld& world() noexcept;                              ///< after the last step
  std::uint64_t position() const noexcept;                         ///< info().first_step and the steps since
  std::optional<std::uint64_t> recorded_hash() const noexcept;     ///< as Player::recorded_hash

  /// Plays on: the calls up to the next step, and that step. False, and nothing happens, at the end. Throws
  /// Error for a snapshot that was restored meanwhile, which ranks cannot take.
  bool step(Workers& workers);
  /// Plays on to a step and compares every hash, and the state at every keyframe, also at one where it
  /// begins: each rank compares what it has, but for what is derived of it. Returns the same on all ranks:
  /// nothing if all agree. Where a hash differs it plays on to the next keyframe, if there is one, as
  /// Player::verify. Ranks that find other differences are named in Divergence::difference. Where a state
  /// differs although the hash of the step agrees, both hashes are that one. The next call goes back to what
  /// was recorded, with a new world, whose hooks are not set. A hook that throws on one rank leaves the
  /// others waiting: end the run. Throws Error for a step that is behind, or beyond the last one.
  std::optional<Divergence> verify(std::uint64_t to, Workers& workers);

 private:
  friend SCREE_API DistributedWorld play_recording(const std::string& file, std::uint64_t from,
                                                   std::uint64_t to, Transport& transport, Workers& workers,
                                                   const DistributedOptions& options);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace scree
