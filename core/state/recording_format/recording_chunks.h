// The byte form of a recording: a head, then chunks to the end of the file. README.md says what is in them
// and how versions go on; all numbers are in little-endian order.
//
//   8 bytes  "SCREEREC"
//   u32 x 2  version, minor version
//   u32      kByteOrderMark
//   u32      length of the writer's name, at most kMostWriterBytes
//   u64      layout_of_columns()
//   ...      the writer's name
//   u64      xxHash64 of all before
//
// A chunk:
//   u32      kChunkMarker
//   u8 x 2   ChunkKind, ChunkFlag
//   u16      0
//   u64      step: steps of the recording so far, from the step counter of its first state
//   u64      steps in the chunk
//   u64      count: of hulls, meshes or calls in the chunk; of a keyframe, bytes of the parts that follow;
//            of a part, ranks
//   u64 x 2  bytes of the content, and as they are stored
//   u64      xxHash64 of the stored bytes
//   u64      xxHash64 of the chunk's head so far
//   ...      the stored bytes: the content, or compressed by zstd
#pragma once

#include <core/state/snapshot/snapshot_bytes.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace scree {

inline constexpr std::uint32_t kRecordingVersion = 11;
inline constexpr std::uint32_t kRecordingMinor = 0;
inline constexpr std::size_t kMostWriterBytes = 256;

enum class ChunkKind : std::uint8_t {
  hulls = 1,  // write_solids; numbered through the whole recording
  keyframe,   // the state after `step` steps, before the calls that follow: write_state. Where parts follow,
              // of what all ranks have in common: SnapshotData::is_part
  restored,   // the state that a snapshot has just put into the world
  calls,      // steps and calls, see call_bytes.h; a step is 0, its dt as f32 and the world's hash after it
  end,        // nothing; the recording was ended by its recorder
  meshes,     // write_mesh_solids; numbered as hulls are, but apart from them
  part,       // one rank's part of the keyframe before it: u64 layout_of_parts(), then messages_of_part()
};
enum ChunkFlag : std::uint8_t {
  kChunkCompressed = 1,
  kChunkMayBeSkipped = 2,  // by readers that do not know its kind
};

struct ChunkHead {
  ChunkKind kind = ChunkKind::end;
  std::uint8_t flags = 0;
  std::uint64_t step = 0;
  std::uint64_t steps = 0;
  std::uint64_t count = 0;
  std::uint64_t content_bytes = 0;
  std::uint64_t stored_bytes = 0;
  std::uint64_t stored_hash = 0;
};
inline constexpr std::uint32_t kChunkMarker = 0x4b484353;  // "SCHK"
inline constexpr std::size_t kChunkHeadBytes = 64;
inline constexpr std::size_t kStepRecordBytes = 1 + sizeof(float) + sizeof(std::uint64_t);

// What a reader takes from stored bytes at most: `times` as much and `free` bytes. Less for what costs more
// than its bytes: a hull or mesh is built anew, rows of a state that are all alike are packed. Writers fill
// up what is smaller.
struct Expansion {
  std::uint64_t times, free;
};
constexpr Expansion most_expansion(ChunkKind kind) {
  if (kind == ChunkKind::hulls || kind == ChunkKind::meshes) return {16, 4096};
  if (kind == ChunkKind::calls) return {64, 4096};
  return {32, 4096};
}
inline constexpr std::uint64_t kMostContentBytes = std::uint64_t{1} << 36;  // 64 GiB

std::uint64_t hash_of_bytes(std::span<const std::byte> bytes);  // xxHash64

std::vector<std::byte> write_recording_head(const std::string& writer);
struct RecordingHead {
  std::uint32_t version = 0;
  std::uint32_t minor = 0;
  std::string writer;
  std::size_t bytes = 0;
};
inline constexpr std::size_t kMostHeadBytes = 40 + kMostWriterBytes;
// Of bytes that begin with a head. Throws RefusedBytes.
RecordingHead read_recording_head(std::span<const std::byte> bytes);

// Of bytes that begin with a head. Throws RefusedBytes, with offsets in the head, for one that is damaged,
// ends too early or breaks a limit.
ChunkHead read_chunk_head(std::span<const std::byte> bytes);

// Makes chunks; holds zstd's memory, and that of the last chunk.
class ChunkPacker {
 public:
  explicit ChunkPacker(int compression_level);
  ~ChunkPacker();
  ChunkPacker(const ChunkPacker&) = delete;
  ChunkPacker& operator=(const ChunkPacker&) = delete;

  struct Packed {
    std::span<const std::byte> head, stored;  // until the next one
    std::size_t bytes() const { return head.size() + stored.size(); }
  };
  // Fills in what `head` says of bytes. Throws Error for content beyond the limit, and std::bad_alloc. What
  // does not compress is not copied: the content must stay until it is written.
  Packed pack(ChunkHead head, std::span<const std::byte> content);
  // The last one, with what is known only later.
  Packed place(std::uint64_t step, std::uint64_t count);
  Packed packed() const { return {head_, stored_}; }

 private:
  struct Zstd;
  void write_head();

  std::unique_ptr<Zstd> zstd_;
  ChunkHead last_;
  std::vector<std::byte> head_;
  std::vector<std::byte> compressed_;
  std::span<const std::byte> stored_;  // these, or what the caller has packed
};

// The content of a chunk. Throws RefusedBytes, with offsets from the chunk's beginning, for bytes that were
// changed.
std::vector<std::byte> unpack_chunk(const ChunkHead& head, std::vector<std::byte> stored);

}  // namespace scree
