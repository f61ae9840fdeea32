// A world in a file that many ranks write at once, each its part; see world_parts.h.
//
// Numbers are in little-endian order:
//   8 bytes  "SCREEPTS"
//   u32      kCheckpointVersion
//   u32      kByteOrderMark
//   u64      layout_of_parts()
//   u64      number of ranks R, in [1, kMostRanks]
//   R times  u64, u64: bytes and xxHash64 of a rank's part
//   u64      xxHash64 of all of the above
//   R parts  of rank 0: write_snapshot; of others: messages_of_part
#pragma once

#include <core/world/world_data.h>
#include <parallel/crew/crew.h>
#include <scree/transport.h>
#include <scree/world.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scree {

inline constexpr std::uint32_t kCheckpointVersion = 2;

// This rank's part of the file. The world stays what it is.
std::vector<std::byte> checkpoint_part(World& world, Crew& crew);
// Writes the parts of all ranks into a file beside it, which replaces it when all is there. All ranks call it
// together, and throw the same Error.
void write_parts(Transport& transport, const std::string& file, std::span<const std::byte> part);

}  // namespace scree
