// A world that many ranks have, as bytes: what all ranks have in common, and the messages in which each rank
// would give all of its bodies away. Whoever reads these takes the bodies of some ranks or of all, whatever
// number of ranks there was. So no process needs room for more than its share, neither to write nor to read.
// Checkpoints and keyframes of recordings are made so.
#pragma once

#include <core/state/snapshot/snapshot.h>
#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <scree/error.h>
#include <scree/snapshot.h>
#include <scree/transport.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace scree {

inline constexpr std::uint64_t kMostRanks = 1'000'000;

// Tells other columns apart: those that snapshots hold, and those that travel in messages.
std::uint64_t layout_of_parts();

// Whether a world's bytes are parts; else a snapshot says it all.
bool has_parts(const World& world);
// What all ranks have in common: a part in which all dynamic bodies are absent. Of a world without parts,
// all. The world stays what it is, and still measures changes from the save that it remembers.
void save_common(World& world, SnapshotData& snapshot);
// A rank's bodies: message by message u64 its bytes, and these. The world stays what it is.
std::vector<std::byte> messages_of_part(World& world, Crew& crew);

// Saves the whole world on rank 0, of all ranks' messages; elsewhere `snapshot` stays as it is. The world
// stays what it is. What is wrong is the same on all ranks, which call it together.
std::optional<Error> save_whole(World& world, Snapshot& snapshot, Crew& crew);

// What this rank has of the world, without ghosts, as a world to compare: it cannot be stepped.
World copy_part(World& world, Crew& crew);

// Where the messages of ranks are read.
class PartSource {
 public:
  virtual int ranks() const = 0;
  virtual std::vector<std::byte> part(int rank) = 0;
  // Throws what names the byte of the rank's part, and the reason.
  [[noreturn]] virtual void refuse(int rank, std::size_t at, const std::string& reason) const = 0;

 protected:
  ~PartSource() = default;
};

// The whole world, of what all ranks had in common and all their messages. What has come of it is checked.
// Throws what the source throws, and Error where messages do not fit.
Snapshot add_parts(World common, PartSource& source);

// Of `parts` ranks that have written messages, which reader takes those of `part`. Those of ranks that were
// side by side stay together.
constexpr int reader_of(int part, int parts, int readers) {
  return static_cast<int>(std::int64_t{part} * readers / parts);
}
// By row of bodies: whose messages have it, -1 where all ranks have it. All readers call it together; each of
// them looks into the messages that it will take. Throws the same Error on all of them.
std::vector<std::int32_t> find_owners(const World& common, PartSource& source, Transport& transport);
// A reader's share of the world, of which `common` is what all ranks had: `part_of` says of each row of
// bodies whose messages have it, -1 where all ranks have it. The world is divided then. What has come is
// checked, and throws as above; so each reader knows of its own share alone whether that can be read.
World read_share(World common, PartSource& source, std::span<const std::int32_t> part_of,
                 Transport& transport, Crew& crew);

}  // namespace scree
