// See mcap.h. Names of records and fields are those of the specification. Checksums are left out, as it
// permits.
#include <tools/export/mcap.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace scree::exports {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kChunkSize = 1 << 20;  // bytes, from which on a chunk is closed
constexpr int kCompressionLevel = 3;

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

template <class Number>
void put(Number number, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void put_text(std::string_view text, std::string& bytes) {
  put(static_cast<std::uint32_t>(text.size()), bytes);
  bytes += text;
}

void put_record(std::uint8_t opcode, std::string_view content, std::string& bytes) {
  put(opcode, bytes);
  put(static_cast<std::uint64_t>(content.size()), bytes);
  bytes += content;
}

template <class Key, class Value>
void put_map(const std::map<Key, Value>& map, std::string& bytes) {
  put(static_cast<std::uint32_t>(map.size() * (sizeof(Key) + sizeof(Value))), bytes);
  for (const auto& [key, value] : map) {
    put(key, bytes);
    put(value, bytes);
  }
}

std::string compress(const std::string& bytes) {
  std::string result(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), kCompressionLevel);
  if (ZSTD_isError(size) != 0) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  result.resize(size);
  return result;
}

}  // namespace

McapWriter::McapWriter() : bytes_(kMagic) {
  std::string header;
  put_text("", header);  // no profile
  put_text("scree", header);
  put_record(kHeader, header, bytes_);
}

std::uint16_t McapWriter::add_channel(std::string_view topic, std::string_view schema_name,
                                      std::string_view schema) {
  const std::uint16_t id = ++channel_count_;  // 0 is no schema
  std::string content;
  put(id, content);
  put_text(schema_name, content);
  put_text("jsonschema", content);
  put_text(schema, content);
  put_record(kSchema, content, schemas_);
  put_record(kSchema, content, bytes_);
  content.clear();
  put(id, content);
  put(id, content);  // of the schema
  put_text(topic, content);
  put_text("json", content);
  put(std::uint32_t{0}, content);  // no metadata
  put_record(kChannel, content, channels_);
  put_record(kChannel, content, bytes_);
  counts_[id] = 0;
  return id;
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  if (open_.empty()) chunk_.start = time;
  if (chunks_.empty() && open_.empty()) start_ = time;
  chunk_.end = end_ = time;
  index_[channel].emplace_back(time, open_.size());
  std::string content;
  put(channel, content);
  put(static_cast<std::uint32_t>(counts_[channel]++), content);
  put(time, content);  // logged
  put(time, content);  // published
  content += data;
  put_record(kMessage, content, open_);
  if (open_.size() >= kChunkSize) close_chunk();
}

void McapWriter::close_chunk() {
  if (open_.empty()) return;
  const std::string records = compress(open_);
  std::string content;
  put(chunk_.start, content);
  put(chunk_.end, content);
  put(static_cast<std::uint64_t>(open_.size()), content);
  put(std::uint32_t{0}, content);  // no checksum
  put_text("zstd", content);
  put(static_cast<std::uint64_t>(records.size()), content);
  content += records;
  chunk_.size = open_.size();
  chunk_.stored = records.size();
  chunk_.offset = bytes_.size();
  put_record(kChunk, content, bytes_);
  chunk_.length = bytes_.size() - chunk_.offset;
  for (const auto& [channel, entries] : index_) {
    chunk_.index_offsets[channel] = bytes_.size();
    content.clear();
    put(channel, content);
    put(static_cast<std::uint32_t>(entries.size() * 2 * sizeof(std::uint64_t)), content);
    for (const auto& [time, offset] : entries) {
      put(time, content);
      put(offset, content);
    }
    put_record(kMessageIndex, content, bytes_);
  }
  chunk_.index_length = bytes_.size() - chunk_.offset - chunk_.length;
  chunks_.push_back(chunk_);
  chunk_ = {};
  index_.clear();
  open_.clear();
}

std::uint64_t McapWriter::put_group(std::uint8_t opcode, const std::string& records, std::string& offsets) {
  const std::uint64_t start = bytes_.size();
  if (records.empty()) return start;
  bytes_ += records;
  std::string content;
  put(opcode, content);
  put(start, content);
  put(static_cast<std::uint64_t>(records.size()), content);
  put_record(kSummaryOffset, content, offsets);
  return start;
}

std::string McapWriter::finish() {
  close_chunk();
  std::string content;
  put(std::uint32_t{0}, content);  // no checksum
  put_record(kDataEnd, content, bytes_);

  std::string offsets;
  const std::uint64_t summary_start = put_group(kSchema, schemas_, offsets);
  put_group(kChannel, channels_, offsets);
  std::string records;
  for (const Chunk& chunk : chunks_) {
    content.clear();
    put(chunk.start, content);
    put(chunk.end, content);
    put(chunk.offset, content);
    put(chunk.length, content);
    put_map(chunk.index_offsets, content);
    put(chunk.index_length, content);
    put_text("zstd", content);
    put(chunk.stored, content);
    put(chunk.size, content);
    put_record(kChunkIndex, content, records);
  }
  put_group(kChunkIndex, records, offsets);
  std::uint64_t messages = 0;
  for (const auto& [channel, count] : counts_) messages += count;
  content.clear();
  put(messages, content);
  put(channel_count_, content);                 // schemas
  put(std::uint32_t{channel_count_}, content);  // channels
  put(std::uint32_t{0}, content);               // attachments
  put(std::uint32_t{0}, content);               // metadata
  put(static_cast<std::uint32_t>(chunks_.size()), content);
  put(start_, content);
  put(end_, content);
  put_map(counts_, content);
  records.clear();
  put_record(kStatistics, content, records);
  put_group(kStatistics, records, offsets);

  const std::uint64_t offsets_start = bytes_.size();
  bytes_ += offsets;
  content.clear();
  put(summary_start, content);
  put(offsets_start, content);
  put(std::uint32_t{0}, content);  // no checksum
  put_record(kFooter, content, bytes_);
  bytes_ += kMagic;
  return std::move(bytes_);
}

}  // namespace scree::exports
