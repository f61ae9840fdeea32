// DistributedWorld: one world that many ranks step together, with the bits of a single process for every
// number of ranks.
#pragma once

#include <scree/recording.h>
#include <scree/snapshot.h>
#include <scree/transport.h>
#include <scree/workers.h>
#include <scree/world.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace scree {

struct FileShare;

/// How bodies are shared out among ranks. No result depends on it.
struct DistributedOptions {
  /// Steps from one look at the shares to the next, at which bodies that have left their rank's part of the
  /// space go to another rank; 0: never, else up to 1e6. A step before which calls have created many bodies
  /// looks, too.
  int steps_per_look = 16;
  /// From which load on, relative to the mean of all ranks, the space is cut anew; at least 1.
  float imbalance = 1.1f;
};

/// What a rank has, and what the last step took.
struct RankStats {
  std::int64_t bodies = 0;           ///< dynamic ones that it owns
  std::int64_t awake_bodies = 0;     ///< of these
  std::int64_t ghosts = 0;           ///< bodies of others that its own ones may meet
  std::int64_t contacts = 0;         ///< touching manifolds of its bodies
  std::int64_t border_contacts = 0;  ///< of these, those with bodies of other ranks, which have them, too
  std::int64_t messages = 0;         ///< that it has sent
  std::int64_t bytes = 0;            ///< in these
  double step_ms = 0.0;              ///< of the whole step on this rank
  double waiting_ms = 0.0;           ///< of this, for messages of others
  double load = 0.0;                 ///< of the bodies and their contacts, relative to the mean of all ranks
};

/// A part of a world on each rank. Each moves the bodies that it owns, and has what it needs to know of those
/// near them. Of other bodies it knows little more than that they are there: pose(), mass_properties() and
/// all else that World reads of them say nothing, and so do shapes of theirs. Kinematic and fixed bodies are
/// on every rank. Calls that change the world are made on all ranks alike, between two steps, or on one rank
/// by give().
///
/// An Error that a call throws because of what a body is, as of a mass that is too large, is thrown by those
/// ranks that know the body: end the run, as for step().
///
/// Dynamic bodies, and fixed ones that become dynamic, must be created within 16384 m of the origin along
/// each axis. Where one is farther out, what all ranks do together, such as step() and hash(), throws an
/// Error on all of them, and goes on when the body is destroyed. Bodies may move farther; who goes on from a
/// file goes on with these, too.
///
/// An Error of step() on one rank leaves the others waiting for it: end the run, as `MPI_Abort` does.
///
/// Solvers over the whole system (see Solver) run on rank 0 alone, for all ranks. Calls that need the whole
/// world, such as World::hash, scree::save and scree::clone, refuse its parts. Queries to world() find what a
/// rank has; those of scree/distributed_queries.h ask all ranks.
///
/// A rank lists the events of its bodies. Those of a contact, sensor or joint between bodies of two ranks are
/// listed on both: count them where owns() holds for the first of the two that is dynamic.
///
/// Joints that went with their bodies are listed on all ranks. What joints bear is known of a rank's bodies;
/// where owners have changed, after the next step with dt > 0. World::stats() counts what the rank has;
/// the residual is that of the whole world.
///
/// Hooks of contacts and the callback of user joints are set on all ranks alike. Hooks are asked about the
/// pairs of a rank's bodies, so both ranks of a pair across a border must get the same answer. The callback
/// is called on one rank for each joint, within the step: it may read the motion of the joint's bodies, but
/// no events or stats of the step before. Where it throws, its rank's joints keep their numbers, and step()
/// throws when the step has come to its end on all ranks, as with hooks.
class SCREE_API DistributedWorld {
 public:
  /// Takes a world that all ranks have filled alike. `transport` must outlive this. All ranks call it
  /// together. Throws Error on all ranks where the worlds or the builds differ, for what is not supported,
  /// and for dynamic bodies that are more than 16384 m from the origin along an axis.
  DistributedWorld(World world, Transport& transport, const DistributedOptions& options = {});
  ~DistributedWorld();
  DistributedWorld(DistributedWorld&&) noexcept;  ///< the other one can only be assigned to or destroyed
  DistributedWorld& operator=(
      DistributedWorld&&) noexcept;  ///< the other one can only be assigned to or destroyed

  int rank() const noexcept;            ///< this one, from 0
  int ranks() const noexcept;           ///< how many there are
  World& world() noexcept;              ///< this rank's part
  const World& world() const noexcept;  ///< as the other one
  /// Whether the body is this rank's to move. False for kinematic and fixed bodies, which are everybody's,
  /// and for dead ones. Bodies that are new have an owner from the next step on.
  bool owns(BodyId body) const;

  /// Makes calls that each rank has for the whole world: rank 0 those of its `calls`, then rank 1, and so on,
  /// as if one process made them all in this order. So each rank can create what lies in its part of the
  /// space, and handles are those of such a process. They are made on the other ranks, too, where nothing is
  /// kept of new bodies but what all ranks have. All ranks call it together, between two steps. `calls` may
  /// be empty, and reads what this rank has; hooks and callbacks are not for it to set. What all ranks do
  /// together, such as step() and hash(), throws an Error in it.
  ///
  /// What `calls` throws on a rank ends the turns; all ranks throw that as an Error. What was called before
  /// stands.
  void give(const std::function<void(World&)>& calls, Workers& workers);
  /// As scree::step. All ranks call it together, with the same time step.
  void step(float dt, Workers& workers);
  /// World::hash of the whole world. All ranks call it together and get the same.
  std::uint64_t hash();
  /// By rank, of which there are ranks(); throws Error for another length. All ranks call it together.
  void stats(std::span<RankStats> by_rank);
  /// Saves the whole world on rank 0; any number of ranks, or a single process, goes on from there with the
  /// same bits. On other ranks `snapshot` stays as it is. All ranks call it together.
  void save(Snapshot& snapshot, Workers& workers);
  /// Writes the whole world into a file, each rank its part, for read_checkpoint(). A file of the name stays
  /// as it is until the new one is there as a whole: it is written beside it, behind links, as FILE.draft.
  /// All ranks call it together; all throw Error if it cannot be written.
  void checkpoint(const std::string& file, Workers& workers);
  /// Records the whole world from now on; Player and compare() take the file for one of a single process.
  /// Rank 0 writes calls and steps as a Recorder would. Keyframes take longer than a Recorder's: within the
  /// step after which one is due, all ranks compress and write their parts of it, and wait until these are on
  /// the disk. So the file must be a regular one, which has the same name on all ranks, and keeps it. All
  /// ranks call it together, with the same options; all of them throw what Recorder() throws, or where one
  /// cannot write its part. Later, that ends the recording, not the step: see Recorder::error.
  void record(const std::string& file, Workers& workers, const RecorderOptions& options = {});
  /// Recorder::finish, on all ranks together; all throw Error if not all could be written. Nothing happens
  /// where nothing is recorded. A recording that is not finished when this ends plays to its last whole step.
  void finish_recording(Workers& workers);
  /// As Recorder::error, bytes_written and steps, of rank 0; elsewhere there is none.
  const Recorder* recorder() const noexcept;

 private:
  friend struct SharedReader;
  DistributedWorld(FileShare share, const char* what, Transport& transport, Workers& workers,
                   const DistributedOptions& options);
  void share_out(World world, Transport& transport, const DistributedOptions& options);
  friend class DistributedPlayer;
  void take_up_calls(Workers& workers);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The world that DistributedWorld::checkpoint or write_checkpoint has written, whatever number of ranks
/// wrote it. No rank needs room for more than its share, and what all ranks have; where write_checkpoint has
/// written it, each rank reads all. It goes on with the same bits. `transport` must outlive it. All ranks
/// call it together, with the same file and options. Throws the same Error on all ranks: as the other one, as
/// the constructor of DistributedWorld but for bodies that are far out, and where ranks read files of
/// different content.
SCREE_API DistributedWorld read_checkpoint(const std::string& file, Transport& transport, Workers& workers,
                                           const DistributedOptions& options = {});

/// The whole world that DistributedWorld::checkpoint or write_checkpoint has written, whatever number of
/// ranks wrote it. It goes on with the same bits. Throws Error, which names the file and what is wrong with
/// it, for what cannot be read, is no checkpoint, was changed or cut off, or was written by another version.
SCREE_API World read_checkpoint(const std::string& file);

/// How many ranks have written a checkpoint, each its part; 1: it is whole, so that each rank reads all of
/// it. Looks at the begin of the file alone. Throws Error as read_checkpoint.
SCREE_API int checkpoint_ranks(const std::string& file);

/// As DistributedWorld::checkpoint, by a single process. Throws Error as that one, and for a world that was
/// moved from.
SCREE_API void write_checkpoint(const World& world, const std::string& file);

/// The world of a recording after `to` steps, on many ranks, whoever has recorded it; it goes on with the
/// same bits. Each rank reads its share of the last keyframe at or before step `from`, or where a single
/// process has recorded it all of it, and plays the calls and steps that follow. The hash after each of these
/// is compared with the recorded one, so that playing all steps of its RecordingInfo verifies a recording.
/// `transport` must outlive the world. All ranks call it together, with the same file, steps and options.
/// Throws the same Error on all ranks: for what is no recording, was changed, or has no such steps, where a
/// hash differs, as read_checkpoint(), and for a snapshot that was restored meanwhile, which ranks cannot
/// take.
SCREE_API DistributedWorld play_recording(const std::string& file, std::uint64_t from, std::uint64_t to,
                                          Transport& transport, Workers& workers,
                                          const DistributedOptions& options = {});

}  // namespace scree
