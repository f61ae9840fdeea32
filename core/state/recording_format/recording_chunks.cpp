// See recording_chunks.h.
#define XXH_INLINE_ALL
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <new>

namespace scree {

namespace {

constexpr char kMagic[8] = {'S', 'C', 'R', 'E', 'E', 'R', 'E', 'C'};
constexpr std::uint8_t kKnownFlags = kChunkCompressed | kChunkMayBeSkipped;
constexpr std::size_t kStoredBytesOffset = 40, kStoredHashOffset = 48, kHeadHashOffset = 56;
constexpr std::size_t kLeastCompressed = 128;                  // bytes; less is not worth a frame
constexpr std::size_t kFrameHead = 2 * sizeof(std::uint32_t);  // of one that zstd skips

void write_chunk_head(const ChunkHead& head, ByteWriter& writer) {
  const std::size_t begin = writer.size();
  writer.put(kChunkMarker);
  writer.put(static_cast<std::uint8_t>(head.kind));
  writer.put(head.flags);
  writer.put(std::uint16_t{0});
  for (const std::uint64_t number :
       {head.step, head.steps, head.count, head.content_bytes, head.stored_bytes, head.stored_hash}) {
    writer.put(number);
  }
  writer.put(hash_of_bytes(writer.bytes().subspan(begin)));
}

// The least number of bytes that must be stored for content of this size.
std::uint64_t least_stored(ChunkKind kind, std::uint64_t content) {
  const Expansion most = most_expansion(kind);
  return content > most.free ? (content - most.free + most.times - 1) / most.times : 0;
}

// A frame that zstd skips, behind `size` bytes, so that there are at least as many as asked for.
std::size_t fill_up(std::vector<std::byte>& bytes, std::size_t size, std::size_t least) {
  if (size >= least) return size;
  least = std::max(least, size + kFrameHead);
  const std::uint32_t head[] = {ZSTD_MAGIC_SKIPPABLE_START,
                                static_cast<std::uint32_t>(least - size - kFrameHead)};
  bytes.resize(std::max(bytes.size(), least));
  std::memcpy(bytes.data() + size, head, sizeof head);
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(size + kFrameHead),
            bytes.begin() + static_cast<std::ptrdiff_t>(least), std::byte{});
  return least;
}

}  // namespace

std::uint64_t hash_of_bytes(std::span<const std::byte> bytes) { return XXH64(bytes.data(), bytes.size(), 0); }

std::vector<std::byte> write_recording_head(const std::string& name) {
  const std::size_t length = std::min(name.size(), kMostWriterBytes);
  ByteWriter writer;
  writer.put_bytes(kMagic, sizeof kMagic);
  writer.put(kRecordingVersion);
  writer.put(kRecordingMinor);
  writer.put(kByteOrderMark);
  writer.put(static_cast<std::uint32_t>(length));
  writer.put(layout_of_columns());
  writer.put_bytes(name.data(), length);
  writer.put(hash_of_bytes(writer.bytes()));
  return writer.take();
}

RecordingHead read_recording_head(std::span<const std::byte> bytes) {
  ByteReader reader(bytes, "the recording");
  RecordingHead head;
  if (std::memcmp(reader.take_bytes(sizeof kMagic), kMagic, sizeof kMagic) != 0) {
    refuse_bytes(0, "this is no recording");
  }
  const std::size_t version_at = reader.at();
  head.version = reader.take<std::uint32_t>();
  if (head.version != kRecordingVersion) {
    refuse_bytes(version_at,
                 "the recording has version " + std::to_string(head.version) + ", this is version " +
                     std::to_string(kRecordingVersion),
                 ErrorCode::wrong_version);
  }
  head.minor = reader.take<std::uint32_t>();
  std::size_t at = reader.at();
  if (reader.take<std::uint32_t>() != kByteOrderMark) {
    refuse_bytes(at, "the bytes are not in little-endian order");
  }
  at = reader.at();
  const auto length = reader.take<std::uint32_t>();
  if (length > kMostWriterBytes) refuse_bytes(at, "the writer's name is too long");
  const std::size_t layout_at = reader.at();
  const auto layout = reader.take<std::uint64_t>();
  head.writer.assign(reinterpret_cast<const char*>(reader.take_bytes(length)), length);
  at = reader.at();
  if (reader.take<std::uint64_t>() != hash_of_bytes(bytes.first(at))) {
    refuse_bytes(at, "the checksum of the head is wrong");
  }
  if (layout != layout_of_columns()) {
    refuse_bytes(layout_at, "this was recorded by a version with other columns: " + head.writer,
                 ErrorCode::wrong_version);
  }
  head.bytes = reader.at();
  return head;
}

ChunkHead read_chunk_head(std::span<const std::byte> bytes) {
  ByteReader reader(bytes, "the chunk");
  if (reader.take<std::uint32_t>() != kChunkMarker) refuse_bytes(0, "no chunk begins here");
  ChunkHead head;
  head.kind = static_cast<ChunkKind>(reader.take<std::uint8_t>());
  head.flags = reader.take<std::uint8_t>();
  const auto zero = reader.take<std::uint16_t>();
  for (std::uint64_t* number :
       {&head.step, &head.steps, &head.count, &head.content_bytes, &head.stored_bytes, &head.stored_hash}) {
    *number = reader.take<std::uint64_t>();
  }
  if (reader.take<std::uint64_t>() != hash_of_bytes(bytes.first(kHeadHashOffset))) {
    refuse_bytes(kHeadHashOffset, "the checksum of the chunk's head is wrong");
  }
  if ((head.flags & ~kKnownFlags) != 0 || zero != 0) refuse_bytes(5, "the chunk has unknown flags");
  const bool compressed = (head.flags & kChunkCompressed) != 0;
  const bool fits = head.content_bytes <= kMostContentBytes &&
                    (compressed ? head.stored_bytes >= least_stored(head.kind, head.content_bytes) &&
                                      head.stored_bytes < head.content_bytes + kFrameHead
                                : head.content_bytes == head.stored_bytes);
  if (!fits) refuse_bytes(kStoredBytesOffset, "the chunk has a wrong number of bytes");
  return head;
}

struct ChunkPacker::Zstd {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  int level = 1;
  ~Zstd() { ZSTD_freeCCtx(context); }
};

ChunkPacker::ChunkPacker(int compression_level) : zstd_(std::make_unique<Zstd>()) {
  if (zstd_->context == nullptr) throw std::bad_alloc();
  zstd_->level = compression_level;
}
ChunkPacker::~ChunkPacker() = default;

ChunkPacker::Packed ChunkPacker::pack(ChunkHead head, std::span<const std::byte> content) {
  if (content.size() > kMostContentBytes) {
    throw Error("a chunk of the recording would have " + std::to_string(content.size()) + " bytes; at most " +
                    std::to_string(kMostContentBytes) + " can be recorded at once",
                ErrorCode::too_many);
  }
  head.content_bytes = content.size();
  stored_ = content;
  if (content.size() >= kLeastCompressed) {
    compressed_.resize(ZSTD_compressBound(content.size()));
    const std::size_t size = ZSTD_compressCCtx(zstd_->context, compressed_.data(), compressed_.size(),
                                               content.data(), content.size(), zstd_->level);
    // What zstd cannot do is stored as it is.
    if (!ZSTD_isError(size) && size < content.size()) {
      const auto least = static_cast<std::size_t>(least_stored(head.kind, content.size()));
      const std::size_t filled = fill_up(compressed_, size, least);
      stored_ = std::span(compressed_).first(filled);
      head.flags |= kChunkCompressed;
    }
  }
  head.stored_bytes = stored_.size();
  head.stored_hash = hash_of_bytes(stored_);
  last_ = head;
  write_head();
  return packed();
}

ChunkPacker::Packed ChunkPacker::place(std::uint64_t step, std::uint64_t count) {
  last_.step = step;
  last_.count = count;
  write_head();
  return packed();
}

void ChunkPacker::write_head() {
  ByteWriter writer;
  write_chunk_head(last_, writer);
  head_ = writer.take();
}

std::vector<std::byte> unpack_chunk(const ChunkHead& head, std::vector<std::byte> stored) {
  if (stored.size() != head.stored_bytes) refuse_bytes(kStoredBytesOffset, "the chunk ends too early");
  if (hash_of_bytes(stored) != head.stored_hash) {
    refuse_bytes(kStoredHashOffset, "the checksum of the chunk's bytes is wrong");
  }
  if ((head.flags & kChunkCompressed) == 0) return stored;
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != head.content_bytes) {
    refuse_bytes(kChunkHeadBytes, "the chunk's bytes do not hold its content");
  }
  std::vector<std::byte> content(static_cast<std::size_t>(head.content_bytes));
  const std::size_t size = ZSTD_decompress(content.data(), content.size(), stored.data(), stored.size());
  if (ZSTD_isError(size) || size != content.size()) {
    refuse_bytes(kChunkHeadBytes, "the chunk's bytes cannot be decompressed");
  }
  return content;
}

}  // namespace scree
