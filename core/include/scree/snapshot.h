// Snapshots: the whole state of a world, to come back to, to copy, and to send.
//
// A world that is restored goes on with the same bits as the one that was saved would have, on every
// instruction set and thread count. Handles, user data, settings and the step counter come back, too.
#pragma once

#include <scree/export.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace scree {

struct SnapshotData;
struct SnapshotChangesData;

/// The state of a world at one time. It shares hulls and meshes with the world, and with all other
/// snapshots of it; with these it shares the memory of all that they have in common, too. Any thread may read
/// it while no thread saves into it, whatever becomes of the others meanwhile.
class SCREE_API Snapshot {
 public:
  Snapshot() noexcept;  ///< of no world
  ~Snapshot();
  Snapshot(Snapshot&&) noexcept;             ///< the other one becomes empty
  Snapshot& operator=(Snapshot&&) noexcept;  ///< the other one becomes empty

  bool is_empty() const noexcept;       ///< of no world
  std::size_t bytes() const noexcept;   ///< of memory, as if nothing were shared; without hulls and meshes
  std::uint64_t step() const noexcept;  ///< steps that the world had taken; 0 if empty

 private:
  friend struct SnapshotAccess;
  std::unique_ptr<SnapshotData> data_;
};

/// Saves the world. It costs by what has changed since the world was last saved or restored: by the bodies,
/// contacts and joints that move, by what calls have changed, and a few nanoseconds for 100 bodies that rest.
/// That holds while the snapshot of that last save (or of the restore) is still there and holds the same; the
/// first save, and one after that snapshot has gone or been saved into from another world, costs by all that
/// there is. What this snapshot held is replaced, and its memory is used again: snapshots that are saved into
/// in turn allocate little, and nothing where nothing has grown. Throws Error for a world that was moved
/// from, and std::bad_alloc, which leaves the snapshot empty. Reading calls may go on in other threads
/// meanwhile; saves and clones of one world wait for one another.
SCREE_API void save(const World& world, Snapshot& snapshot);

/// Makes the world what the saved one was, whatever it has been before, and uses its memory again. The events
/// of the last step are not part of the state: the lists are empty afterwards, and of StepStats there is
/// `step` only. Bulk columns may move. Throws Error for an empty snapshot or a world that was moved from, and
/// std::bad_alloc, and then has changed nothing.
///
/// Handles: those that were valid when the world was saved are valid again, and those that were not are
/// not, whatever has been created or destroyed since. So what a handle from after the save names is gone, and
/// calls reject it, until a body or shape is created that takes its place: generations have come back as
/// well, and the newcomer gets the very same handle. A world that becomes what another one was
/// gives that one's handles from then on, and still takes its own, of the same indices and generations. A
/// world that is restored from bytes keeps its own.
SCREE_API void restore(World& world, const Snapshot& snapshot);

/// Another world in the same state.
SCREE_API World clone(const World& world);

namespace detail {
using TakeBytes = void (*)(void* context, std::span<const std::byte> part, std::size_t all);
/// Calls take(context, part, all) with part after part of as many bytes.
SCREE_API void write_snapshot(const Snapshot& snapshot, TakeBytes take, void* context);
}  // namespace detail

/// The snapshot as bytes, the same for equal states on every machine; each hull or mesh once. Throws Error
/// for an empty snapshot and where bytes are not in little-endian order, and std::bad_alloc.
///
/// A template, so that each program gets a copy for its own std::vector: with _GLIBCXX_DEBUG that is not the
/// library's.
template <class Bytes = std::vector<std::byte>>
Bytes write_snapshot(const Snapshot& snapshot) {
  Bytes result;
  detail::write_snapshot(
      snapshot,
      [](void* context, std::span<const std::byte> part, std::size_t all) {
        Bytes& bytes = *static_cast<Bytes*>(context);
        bytes.reserve(all);
        bytes.insert(bytes.end(), part.begin(), part.end());
      },
      &result);
  return result;
}

/// The snapshot that the bytes were written from. They may come from anywhere: all that a world relies on is
/// checked, and memory is taken in proportion to their number (restoring then takes what the saved world
/// had). Throws Error, which names the offset of the first byte that is wrong and the reason, for bytes that
/// were changed or cut off, or that another version of Scree wrote; and std::bad_alloc.
SCREE_API Snapshot read_snapshot(std::span<const std::byte> bytes);

/// What one snapshot has that another one of the same world has not. It knows the snapshot that it is based
/// on, and is worth nothing without. It shares its memory with the later snapshot while that is there: a
/// window of snapshots needs no changes to be small, because snapshots share what they have in common anyway.
class SCREE_API SnapshotChanges {
 public:
  SnapshotChanges() noexcept;  ///< of no snapshots
  ~SnapshotChanges();
  SnapshotChanges(SnapshotChanges&&) noexcept;             ///< the other one becomes empty
  SnapshotChanges& operator=(SnapshotChanges&&) noexcept;  ///< the other one becomes empty

  bool is_empty() const noexcept;      ///< of no snapshots
  std::size_t bytes() const noexcept;  ///< of memory, as if it shared no pages; without hulls and meshes

 private:
  friend struct SnapshotAccess;
  std::unique_ptr<SnapshotChangesData> data_;
};

/// Keeps what of `later` is not in `base`, in units of 64 bodies, shapes, contacts or joints. Any two
/// snapshots will do. Between those of one world it costs by what differs; between others, as when one was
/// read from bytes, all of both is compared. Throws Error for empty snapshots, and std::bad_alloc, which
/// leaves the changes empty.
SCREE_API void keep_changes(const Snapshot& base, const Snapshot& later, SnapshotChanges& changes);

/// Makes the later snapshot again; it shares the memory of `base` and of the changes. Throws Error for empty
/// changes and where `base` is not the snapshot that they were made with, or has been saved into since; and
/// std::bad_alloc, which leaves the later snapshot empty. `base` and `later` cannot be the same.
SCREE_API void apply_changes(const Snapshot& base, const SnapshotChanges& changes, Snapshot& later);

}  // namespace scree
