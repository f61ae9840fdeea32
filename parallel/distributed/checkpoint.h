// A world in a file that many ranks write at once, each its parts; see world_parts.h.
//
// Numbers are in little-endian order:
//   8 bytes  "SCREEPTS"
//   u32      kCheckpointVersion
//   u32      kByteOrderMark
//   u64      layout_of_parts()
//   u64      number of parts P: 1, or R + 2 of R ranks; R in [2, kMostRanks]
//   P times  u64, u64: bytes and xxHash64 of a part
//   u64      xxHash64 of all of the above
//   1 part   write_snapshot of the whole world, or
//   R + 2    write_snapshot of save_common; i32 for each row of bodies, the rank whose messages have it, -1
//            where all ranks have it; messages_of_part of each rank
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <scree/distributed_world.h>
#include <scree/export.h>
#include <scree/transport.h>
#include <scree/workers.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scree {

inline constexpr std::uint32_t kCheckpointVersion = 3;

// This rank's parts of the file, one behind the other. The world stays what it is.
struct OwnParts {
  std::vector<std::byte> bytes;        // rank 0's begin with the head, which write_parts() fills in
  std::vector<std::uint64_t> lengths;  // of each part
};
OwnParts checkpoint_parts(World& world, Crew& crew);
// Writes the parts of all ranks into a file beside it, which replaces it when all is there. All ranks call it
// together, and throw the same Error.
void write_parts(Transport& transport, const std::string& file, OwnParts parts);

// This rank's share of what a file holds.
struct FileShare {
  World world;             // divided, unless it is whole
  bool is_whole;           // as the file has no parts of ranks
  std::uint64_t identity;  // of the file's content
};
// Throws Error, on some ranks only.
FileShare read_file_share(const std::string& file, Transport& transport, Crew& crew);
// Of a share, which all ranks have by now: `what` was read. Throws as read_checkpoint().
struct SCREE_HIDDEN SharedReader {
  static DistributedWorld make(FileShare share, const char* what, Transport& transport, Workers& workers,
                               const DistributedOptions& options);
};

}  // namespace scree
