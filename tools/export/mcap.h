// Messages in an MCAP file (https://mcap.dev/spec), for the viewers of robotics: compressed chunks with an
// index.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace scree::exports {

// Writes a file in memory. Call add_channel for all channels, then add messages by ascending time, then
// finish.
class McapWriter {
 public:
  McapWriter();

  // Of JSON messages; the schema is one of JSON Schema. Returns the channel's number.
  std::uint16_t add_channel(std::string_view topic, std::string_view schema_name, std::string_view schema);
  // `time`: ns.
  void add_message(std::uint16_t channel, std::uint64_t time, std::string_view data);
  // The whole file.
  std::string finish();

 private:
  struct Chunk {
    std::uint64_t start = 0, end = 0;  // ns
    std::uint64_t offset = 0, length = 0, index_length = 0;
    std::uint64_t stored = 0, size = 0;  // bytes of the records, compressed and not
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };

  void close_chunk();
  std::uint64_t put_group(std::uint8_t opcode, const std::string& records, std::string& offsets);

  std::string bytes_;
  std::string schemas_, channels_;  // their records, for the summary
  std::uint16_t channel_count_ = 0;
  std::string open_;  // records of the chunk that is being filled
  Chunk chunk_;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index_;  // time and offset
  std::vector<Chunk> chunks_;
  std::map<std::uint16_t, std::uint64_t> counts_;  // messages by channel
  std::uint64_t start_ = 0, end_ = 0;              // ns
};

}  // namespace scree::exports
