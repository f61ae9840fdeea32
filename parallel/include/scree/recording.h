// Recordings: all that happened to a world, in a file that plays again.
//
// A recording is the world's first snapshot, then every call that changed the world and every step with the
// hash of its poses and velocities (World::hash), and keyframes: whole snapshots now and then, to seek from
// and to compare with. Steps are counted on from the step counter that the world had at first, also where a
// snapshot was restored into it meanwhile, so that each step of a recording has a number of its own. It plays
// with the same bits on every instruction set, thread count and compiler, so a difference is a defect, and
// the player says where. The format is written down in core/README.md.
#pragma once

#include <scree/snapshot.h>
#include <scree/step.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace scree {

/// How a recording is written.
struct RecorderOptions {
  int keyframe_spacing = 300;   ///< steps from one keyframe to the next, in [1, 1e9]
  int compression_level = 1;    ///< zstd's, in [1, 19]; another thread compresses
  float flush_interval = 0.5f;  ///< s, in [0.01, 60]; what happened so long ago is in the file
};

/// Records a world from now on, until finish() or its end, or until the world is destroyed or assigned to.
/// The world may be moved meanwhile. A thread of the recorder's own compresses and writes; a process that
/// dies loses what happened in the last flush interval, and the file still plays to its last whole step.
///
/// It costs a hash of all living bodies a step (sleepers included), a saved snapshot a keyframe and a
/// restore(), and memory for each different hull that the world has ever had. What waits to be written is
/// bounded by 64 MiB: a world whose states are larger waits for them.
///
/// Where the file cannot be written any more, or memory runs out, the world goes on unharmed and the
/// recording ends there: error() says why, and finish() throws. The recording also ends where a step throws
/// std::bad_alloc, but that world can only be destroyed.
class SCREE_API Recorder {
 public:
  /// Creates or replaces the file and saves the world into it. Throws Error for options outside their ranges,
  /// a world that was moved from or is being recorded already, a file that cannot be written, and one that
  /// another recorder, of any process, is writing to: that one goes on. (Recorders hold a lock on their file,
  /// as flock makes it; players need none, and may read what is being recorded.)
  Recorder(World& world, const std::string& file, const RecorderOptions& options = {});
  /// As finish(), but silent about errors; where an exception on its way destroys the recorder, what was
  /// recorded is written, and is not finished.
  ~Recorder();
  Recorder(Recorder&&) noexcept;             ///< goes on with the other one's recording
  Recorder& operator=(Recorder&&) noexcept;  ///< ends its own recording as ~Recorder does

  /// Ends the recording: a last keyframe, unless calls have changed the world since its last step, then the
  /// rest of the file. Throws Error if not all could be written. Nothing happens the second time.
  void finish();
  bool is_recording() const noexcept;            ///< false after finish() and once the recording ended
  std::string error() const;                     ///< what went wrong; empty: nothing
  std::uint64_t steps() const noexcept;          ///< recorded so far
  std::uint64_t bytes_written() const noexcept;  ///< to the file, so far

 private:
  friend struct SharedRecorder;
  struct Impl;
  Recorder() noexcept;
  void begin(World& world, const std::string& file, const RecorderOptions& options);
  std::unique_ptr<Impl> impl_;
};

/// What a recording holds.
struct RecordingInfo {
  std::uint32_t version = 0;     ///< of the format
  std::string writer;            ///< version of Scree, compiler and build that recorded
  std::uint64_t first_step = 0;  ///< the step counter of the first snapshot
  std::uint64_t last_step = 0;   ///< after the last whole step
  std::uint64_t calls = 0;       ///< that changed the world, restored snapshots among them, but no steps
  std::uint64_t keyframes = 0;   ///< the first snapshot among them
  std::uint64_t hulls = 0;       ///< geometries, each stored once
  std::uint64_t meshes = 0;      ///< triangle meshes, each stored once
  std::uint64_t file_bytes = 0;  ///< bytes of the file
  std::uint64_t raw_bytes = 0;   ///< of all chunks before compression
  std::uint64_t lost_bytes = 0;  ///< at the end of the file, of what was not written whole
  bool finished = false;         ///< false: the recorder did not come to the end
};

/// The first place where a replay, or another recording, differs.
struct Divergence {
  std::uint64_t step = 0;           ///< position() after the step that differs first
  std::uint64_t expected_hash = 0;  ///< recorded (in the first recording)
  std::uint64_t actual_hash = 0;    ///< of the replay (in the second recording)
  std::uint64_t compared_at = 0;    ///< the step at which the states were compared; 0: they were not
  /// First body and field there that differ; empty: none was found. Where nothing was compared, the error
  /// that kept a replay from going on so far, such as a call that its world refuses; empty: no keyframe
  /// followed.
  std::string difference{};
};

/// What a player's world measures although the recorded one did not. It changes no pose, velocity or hash.
struct PlayerMeasures {
  bool contact_forces = false;  ///< as WorldSettings::contact_forces: those of sleepers begin when they wake
  bool residual = false;        ///< as WorldSettings::measure_residual
  bool penetration = false;     ///< as WorldSettings::measure_penetration
  /// Besides those that WorldSettings and shapes ask for. Contacts that exist already begin in the next step.
  ContactEvents contact_events = ContactEvents::none;
};

/// Plays a recording.
class SCREE_API Player {
 public:
  /// Opens a file, or bytes, which are copied. Every byte is checked before it is used; memory is taken in
  /// proportion to what the recorded world had. Throws Error, which names the offset and the reason, for what
  /// is no recording, was changed, or was written by a later version. A recording that was cut off plays to
  /// its last whole step.
  explicit Player(const std::string& file);
  /// Plays bytes, which are copied. Checks and throws as the constructor for files.
  explicit Player(std::span<const std::byte> bytes);
  ~Player();
  Player(Player&&) noexcept;             ///< the other one can only be destroyed or assigned to
  Player& operator=(Player&&) noexcept;  ///< the other one can only be destroyed or assigned to

  const RecordingInfo& info() const noexcept;  ///< what the recording holds
  /// Where the keyframes are, ascending, the first snapshot among them; as long as the player lives.
  std::span<const std::uint64_t> keyframe_steps() const noexcept;
  /// The world after `position()` steps: calls that were made after that step come with the next one, or with
  /// make_calls(). Its events and stats are those of the step; after a seek there are none.
  const World& world() const noexcept;
  std::uint64_t position() const noexcept;  ///< info().first_step and the steps since

  /// Plays on: the calls up to the next step, and that step. False, and nothing happens, at the end.
  bool step(Workers& workers);
  /// Makes the recorded calls that come before the next step, without the step, so that world() is what the
  /// step begins with; position() and recorded_hash() stay those of the step before, unless the world must be
  /// sought again first, as after measure() or an error: then as after a seek. Nothing happens the second
  /// time, and at the end.
  void make_calls(Workers& workers);
  /// Goes to any step from info().first_step to last_step: from the last keyframe before it, or on from here
  /// if that is nearer. Throws Error outside.
  void seek(std::uint64_t step, Workers& workers);
  /// Measures from the next step on, also after seeks, until the next such call or verify(). Worlds that
  /// branch() makes go on measuring.
  void measure(const PlayerMeasures& measures);
  /// s, the time step of the last step played; nothing where the beginning or a seek to a keyframe has
  /// brought the world without a step.
  std::optional<float> recorded_dt() const noexcept;
  /// The hash that was recorded after the last step played; nothing where the beginning or a seek to a
  /// keyframe has brought the world without a step.
  std::optional<std::uint64_t> recorded_hash() const noexcept;
  /// A world of its own in the same state, to go another way.
  World branch() const;

  /// Plays from step `from` to step `to` and compares every hash, and the whole state at every keyframe.
  /// Returns nothing if all agree. Where a hash differs it plays on to the next keyframe, if there is one, to
  /// find body and field. Where a state differs at a keyframe although poses and velocities agree, it returns
  /// the hashes of the whole state. Ends measure(). Throws as seek.
  std::optional<Divergence> verify(std::uint64_t from, std::uint64_t to, Workers& workers);

 private:
  friend std::optional<Divergence> compare(Player& a, Player& b, Workers& workers);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Finds the first step at which two recordings part, by their hashes, and then plays both to it to find body
/// and field. Where the replays agree although the hashes do not, it compares the keyframes that follow.
/// Where all hashes agree, it compares the states at the keyframes of the same steps, and returns the hashes
/// of the whole state if these differ. Returns nothing if all that both have agrees. Ends Player::measure of
/// both. Throws Error where they have no step in common.
SCREE_API std::optional<Divergence> compare(Player& a, Player& b, Workers& workers);

/// The first body and field in which two worlds differ by a bit, such as "body 7, position.y is 1.5
/// (3fc00000) instead of 1.25 (3fa00000)", or, where poses and velocities agree, the first column of the
/// state; empty if the worlds are in the same state.
SCREE_API std::string first_difference(const World& expected, const World& actual);

}  // namespace scree
