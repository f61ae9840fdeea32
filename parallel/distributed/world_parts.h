// A world that many ranks have, as bytes of each rank. Rank 0 gives a snapshot of what it has, in which
// bodies that are absent are plain ones; each other rank gives the messages in which it would give all of its
// bodies to rank 0. Who reads them does what rank 0 would, and has the whole world, whatever number of ranks
// there was. Checkpoints and keyframes of recordings are made so.
#pragma once

#include <core/state/snapshot/snapshot.h>
#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <scree/snapshot.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scree {

inline constexpr std::uint64_t kMostRanks = 1'000'000;

// Tells other columns apart: those that snapshots hold, and those that travel in messages.
std::uint64_t layout_of_parts();

// Of rank 0, or of a world that no ranks share. The world stays what it is. The world still measures changes
// from the save that it remembers.
void save_first_part(World& world, SnapshotData& snapshot);
// Of any other rank: message by message u64 its bytes, and these.
std::vector<std::byte> messages_of_part(World& world, Crew& crew);

// Where the parts of other ranks are read.
class PartSource {
 public:
  virtual int ranks() const = 0;
  virtual std::vector<std::byte> part(int rank) = 0;
  // Throws what names the byte of the rank's part, and the reason.
  [[noreturn]] virtual void refuse(int rank, std::size_t at, const std::string& reason) const = 0;

 protected:
  ~PartSource() = default;
};

// The whole world of which `first` is the first part. What the parts hold has been checked. Throws what the
// source throws, and Error where messages do not fit.
Snapshot add_parts(Snapshot first, PartSource& source);

}  // namespace scree
