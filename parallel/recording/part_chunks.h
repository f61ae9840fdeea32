// The parts of a keyframe of many ranks: the chunks behind it.
#pragma once

#include <parallel/distributed/world_parts.h>
#include <parallel/recording/recording_file.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scree {

class PartChunks final : public PartSource {
 public:
  // Throws Error where the parts are missing.
  PartChunks(RecordingFile& file, std::size_t keyframe);
  int ranks() const override { return parts_; }
  std::vector<std::byte> part(int rank) override;
  [[noreturn]] void refuse(int rank, std::size_t at, const std::string& reason) const override;

 private:
  std::size_t chunk_of(int rank) const { return keyframe_ + 1 + static_cast<std::size_t>(rank); }

  RecordingFile& file_;
  std::size_t keyframe_;
  int parts_ = 0;
};

}  // namespace scree
