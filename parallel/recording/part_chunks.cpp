// See part_chunks.h.
#include <parallel/recording/part_chunks.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>

namespace scree {

PartChunks::PartChunks(RecordingFile& file, std::size_t keyframe) : file_(file), keyframe_(keyframe) {
  while (keyframe + 1 < file.chunks().size() && file.chunks()[keyframe + 1].head.kind == ChunkKind::part)
    ++keyframe;
  parts_ = static_cast<int>(std::min<std::size_t>(keyframe - keyframe_, kMostRanks));
  if (parts_ == 0) file.refuse_content(keyframe_, 0, "its parts are missing");
}

std::vector<std::byte> PartChunks::part(int rank) {
  const std::uint64_t all = file_.chunks()[chunk_of(rank)].head.count;
  if (std::cmp_not_equal(all, ranks()))
    refuse(rank, 0, "there are " + std::to_string(ranks()) + " parts, of " + std::to_string(all) + " ranks");
  std::vector<std::byte> bytes = file_.content(chunk_of(rank));
  std::uint64_t layout = 0;
  if (bytes.size() < sizeof layout) refuse(rank, 0, "the part ends too early");
  std::memcpy(&layout, bytes.data(), sizeof layout);
  if (layout != layout_of_parts())
    file_.refuse_content(chunk_of(rank), 0, "a version of Scree with other columns has written this",
                         ErrorCode::wrong_version);
  bytes.erase(bytes.begin(), bytes.begin() + sizeof layout);
  return bytes;
}

void PartChunks::refuse(int rank, std::size_t at, const std::string& reason) const {
  file_.refuse_content(chunk_of(rank), sizeof(std::uint64_t) + at, reason);
}

}  // namespace scree
