// Reads a recording: lists its chunks when it is opened, and checks the content of each when it is asked for.
#pragma once

#include <core/state/recording_format/call_bytes.h>
#include <core/state/recording_format/recording_chunks.h>
#include <scree/recording.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace scree {

// "Player: byte <offset>: <reason>".
struct RefusedRecording : Error {
  using Error::Error;
};
[[noreturn]] void refuse_recording(std::uint64_t offset, const std::string& reason,
                                   ErrorCode code = ErrorCode::corrupt_data);

struct RecordedChunk {
  ChunkHead head;
  std::uint64_t offset = 0;        // of its head in the file
  std::uint64_t hulls_before = 0;  // in the chunks before it
  std::uint64_t meshes_before = 0;
};

class RecordingFile {
 public:
  explicit RecordingFile(const std::string& file);
  explicit RecordingFile(std::span<const std::byte> bytes);

  const RecordingInfo& info() const { return info_; }
  const std::vector<RecordedChunk>& chunks() const { return chunks_; }
  const std::vector<std::size_t>& keyframes() const { return keyframes_; }  // their places among the chunks
  std::span<const std::uint64_t> keyframe_steps() const { return keyframe_steps_; }
  // Throws Error, which begins with `call`, where the recording has no such step.
  void check_step(std::uint64_t step, const std::string& call) const;
  // Numbers of keyframes: the last one at or before a step of the recording, and the first one at or after
  // it, or how many there are.
  std::size_t keyframe_before(std::uint64_t step) const;
  std::size_t keyframe_after(std::uint64_t step) const;
  std::vector<std::byte> content(std::size_t chunk);
  // All hulls and meshes of the chunks before one.
  SolidViews solids_before(std::size_t chunk);
  Snapshot state(std::size_t chunk);               // of a keyframe, or what was restored
  Snapshot first_state(std::size_t chunk);         // where is_shared(), what all ranks have in common
  std::uint64_t hash_of_state(std::size_t chunk);  // as it was recorded
  // A keyframe of many ranks: its contacts are in another order than those of a replay.
  bool is_shared(std::size_t chunk) const {
    return chunks_[chunk].head.kind == ChunkKind::keyframe && chunks_[chunk].head.count > 0;
  }
  // Calls work(content) with the content of a chunk, and adds its place to errors.
  template <class Work>
  auto read_content(std::size_t chunk, std::span<const std::byte> content, Work&& work) {
    try {
      return work(content);
    } catch (const RefusedBytes& refused) {
      refuse_content(chunk, refused.offset, refused.reason, refused.code());
    }
  }
  [[noreturn]] void refuse_content(std::size_t chunk, std::size_t offset, const std::string& reason,
                                   ErrorCode code = ErrorCode::corrupt_data) const;

 private:
  void scan();
  bool scan_chunk(std::uint64_t& offset);
  bool has_all_parts(const RecordedChunk& keyframe, std::uint64_t begin);
  std::uint64_t find_end_of_data();
  bool is_intact(const RecordedChunk& chunk);
  void list_chunk(const RecordedChunk& chunk);
  template <class Pointer, class Read>
  void append_solids(std::size_t chunk, std::vector<Pointer>& known, Read&& read);
  std::vector<std::byte> bytes_at(std::uint64_t offset, std::size_t count);

  std::ifstream stream_;  // or else
  std::vector<std::byte> bytes_;
  std::uint64_t size_ = 0;
  std::uint64_t end_of_data_ = 0;   // what follows is zero
  std::uint64_t end_of_parts_ = 0;  // of the last keyframe, where it has any
  RecordingInfo info_;
  std::vector<RecordedChunk> chunks_;
  std::vector<std::size_t> keyframes_;
  std::vector<std::uint64_t> keyframe_steps_;  // of each keyframe, ascending
  SolidVectors solids_;
  std::size_t solids_until_ = 0;  // chunks before it have been looked into for solids
};

// Goes over the steps and calls of a recording.
class RecordStream {
 public:
  explicit RecordStream(RecordingFile& file) : file_(file) {}
  // To what follows the chunk.
  void go_behind(std::size_t chunk);

  struct Step {
    float dt;
    std::uint64_t hash;
  };
  // To the next step, over the calls before it. Those are made in the world, and what was restored is
  // restored there, if there is one. There must be such a step. Throws Error, and then is where it was before
  // what is wrong.
  Step next_step(World* world);
  // The same, but for no more calls than that: returns nothing where others come before the step.
  std::optional<Step> next_step_within(World* world, std::uint64_t most_calls);

 private:
  // The next record of the chunk: true if it is the step.
  bool take_record(World* world, Step& step);
  void open_next_chunk(World* world);
  void close_chunk() const;

  RecordingFile& file_;
  std::size_t chunk_ = 0;  // being read
  std::vector<std::byte> content_;
  std::size_t at_ = 0;
  std::uint64_t steps_ = 0, calls_ = 0;  // read of the chunk
};

}  // namespace scree
