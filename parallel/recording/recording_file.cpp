// See recording_file.h.
#include <core/state/recording_format/recorded_state.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <parallel/recording/part_chunks.h>
#include <parallel/recording/recording_file.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace scree {

namespace {

const char* name_of(ChunkKind kind) {
  switch (kind) {
    case ChunkKind::hulls:
      return "hulls";
    case ChunkKind::keyframe:
      return "a keyframe";
    case ChunkKind::restored:
      return "a restored state";
    case ChunkKind::calls:
      return "calls";
    case ChunkKind::end:
      return "the end";
    case ChunkKind::meshes:
      return "meshes";
    case ChunkKind::part:
      return "a part of a keyframe";
  }
  return "an unknown kind";
}

bool is_known(ChunkKind kind) { return kind >= ChunkKind::hulls && kind <= ChunkKind::part; }
bool has_solids(ChunkKind kind) { return kind == ChunkKind::hulls || kind == ChunkKind::meshes; }

}  // namespace

void refuse_recording(std::uint64_t offset, const std::string& reason, ErrorCode code) {
  throw RefusedRecording("Player: byte " + std::to_string(offset) + ": " + reason, code);
}

RecordingFile::RecordingFile(const std::string& file) {
  stream_.rdbuf()->pubsetbuf(nullptr, 0);  // chunks are read whole
  stream_.open(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream_ ? static_cast<std::streamoff>(stream_.tellg()) : -1;
  if (size < 0) throw Error("Player: " + file + ": cannot be read", ErrorCode::io_failure);
  size_ = static_cast<std::uint64_t>(size);
  scan();
}

RecordingFile::RecordingFile(std::span<const std::byte> bytes)
    : bytes_(bytes.begin(), bytes.end()), size_(bytes.size()) {
  scan();
}

std::vector<std::byte> RecordingFile::bytes_at(std::uint64_t offset, std::size_t count) {
  std::vector<std::byte> bytes(count);
  if (!stream_.is_open()) {
    if (count > 0) std::memcpy(bytes.data(), bytes_.data() + offset, count);
    return bytes;
  }
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(offset));
  stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (!stream_) refuse_recording(offset, "cannot be read any more", ErrorCode::io_failure);
  return bytes;
}

void RecordingFile::scan() {
  check_byte_order("Player");
  try {
    const RecordingHead head = read_recording_head(
        bytes_at(0, static_cast<std::size_t>(std::min<std::uint64_t>(size_, kMostHeadBytes))));
    info_.version = head.version;
    info_.writer = head.writer;
    info_.file_bytes = size_;
    end_of_data_ = find_end_of_data();
    for (std::uint64_t offset = head.bytes; scan_chunk(offset);) {
    }
  } catch (const RefusedBytes& refused) {
    refuse_recording(refused.offset, refused.reason, refused.code());
  }
  if (keyframes_.empty()) refuse_recording(size_, "the recording ends before its first state");
}

// After a loss of power a file may end in blocks that were never written. Searches back at most this many
// bytes, because sparse files may be longer than any disk.
std::uint64_t RecordingFile::find_end_of_data() {
  constexpr std::uint64_t kMostZeros = std::uint64_t{1} << 28, kBlock = std::uint64_t{1} << 16;
  const std::uint64_t least = size_ - std::min(size_, kMostZeros);
  for (std::uint64_t end = size_; end > least;) {
    const std::uint64_t begin = end - std::min(end - least, kBlock);
    const std::vector<std::byte> bytes = bytes_at(begin, static_cast<std::size_t>(end - begin));
    const auto last =
        std::find_if(bytes.rbegin(), bytes.rend(), [](std::byte b) { return b != std::byte{}; });
    if (last != bytes.rend()) return begin + static_cast<std::uint64_t>(bytes.rend() - last);
    end = begin;
  }
  return least;
}

bool RecordingFile::is_intact(const RecordedChunk& chunk) {
  return hash_of_bytes(bytes_at(chunk.offset + kChunkHeadBytes,
                                static_cast<std::size_t>(chunk.head.stored_bytes))) == chunk.head.stored_hash;
}

// Ranks write their parts of a keyframe at once: where one has died meanwhile, some are missing, anywhere
// among those that are there. Then nothing follows them.
bool RecordingFile::has_all_parts(const RecordedChunk& keyframe, std::uint64_t begin) {
  if (keyframe.head.count > size_ - begin) return false;
  const std::uint64_t end = begin + keyframe.head.count;
  if (end < end_of_data_) return true;
  for (std::uint64_t at = begin; at < end;) {
    if (end - at < kChunkHeadBytes) return false;
    RecordedChunk part{{}, at, 0, 0};
    try {
      part.head = read_chunk_head(bytes_at(at, kChunkHeadBytes));
    } catch (const RefusedBytes&) {
      return false;
    }
    if (part.head.stored_bytes > end - at - kChunkHeadBytes || !is_intact(part)) return false;
    at += kChunkHeadBytes + part.head.stored_bytes;
  }
  return true;
}

// Lists the chunk at `offset`, which moves on; false if there is no whole one. One that reaches into zeros at
// the end of the file may have them of its own.
bool RecordingFile::scan_chunk(std::uint64_t& offset) {
  const std::uint64_t left = size_ - offset;
  if (left == 0) return false;
  if (info_.finished) refuse_recording(offset, "something follows the end of the recording");
  info_.lost_bytes = left;  // unless it turns out to be whole
  if (left < kChunkHeadBytes) return false;
  RecordedChunk chunk{{}, offset, info_.hulls, info_.meshes};
  try {
    chunk.head = read_chunk_head(bytes_at(offset, kChunkHeadBytes));
  } catch (const RefusedBytes& refused) {
    if (offset + kChunkHeadBytes > end_of_data_) return false;
    refuse_recording(offset + refused.offset, refused.reason, refused.code());
  }
  if (chunk.head.stored_bytes > left - kChunkHeadBytes) return false;
  const std::uint64_t end = offset + kChunkHeadBytes + chunk.head.stored_bytes;
  if (end > end_of_data_ && !is_intact(chunk)) return false;
  if (chunk.head.kind == ChunkKind::keyframe && chunk.head.count > 0 && !has_all_parts(chunk, end))
    return false;
  info_.lost_bytes = 0;
  list_chunk(chunk);
  offset = end;
  return true;
}

void RecordingFile::list_chunk(const RecordedChunk& chunk) {
  const ChunkHead& head = chunk.head;
  const auto require = [&chunk](bool holds, const char* problem, ErrorCode code = ErrorCode::corrupt_data) {
    if (!holds) refuse_recording(chunk.offset, problem, code);
  };
  info_.raw_bytes += head.content_bytes;
  const std::uint64_t end = chunk.offset + kChunkHeadBytes + head.stored_bytes;
  require((head.kind == ChunkKind::part) == (chunk.offset < end_of_parts_) &&
              (head.kind != ChunkKind::part || end <= end_of_parts_),
          "the parts of a keyframe are not those that its head says");
  if (!is_known(head.kind)) {
    require((head.flags & kChunkMayBeSkipped) != 0, "a later version of Scree has written this chunk",
            ErrorCode::wrong_version);
    return;
  }
  const bool has_steps = head.kind == ChunkKind::calls;
  const bool has_count = has_steps || has_solids(head.kind);
  require(has_steps ? head.steps <= head.content_bytes / kStepRecordBytes : head.steps == 0,
          "the chunk has a wrong number of steps");
  const bool is_shared = head.kind == ChunkKind::keyframe || head.kind == ChunkKind::part;
  require(has_count ? head.count <= head.content_bytes : is_shared || head.count == 0,
          "the chunk has a wrong count");
  if (keyframes_.empty()) {
    require(has_solids(head.kind) || head.kind == ChunkKind::keyframe,
            "the recording does not begin with a state");
    info_.first_step = info_.last_step = head.step;
  }
  require(head.step == info_.last_step && head.steps <= ~head.step, "the chunk's step does not follow");
  switch (head.kind) {
    case ChunkKind::hulls:
      info_.hulls += head.count;
      break;
    case ChunkKind::meshes:
      info_.meshes += head.count;
      break;
    case ChunkKind::keyframe:
      require(keyframes_.empty() || keyframe_steps_.back() < head.step, "two keyframes of one step");
      keyframes_.push_back(chunks_.size());
      keyframe_steps_.push_back(head.step);
      ++info_.keyframes;
      if (head.count > 0) end_of_parts_ = end + head.count;
      break;
    case ChunkKind::calls:
      info_.calls += head.count;
      info_.last_step += head.steps;
      break;
    case ChunkKind::restored:
      ++info_.calls;
      break;
    case ChunkKind::end:
      info_.finished = true;
      break;
    case ChunkKind::part:
      break;
  }
  chunks_.push_back(chunk);
}

void RecordingFile::refuse_content(std::size_t chunk, std::size_t offset, const std::string& reason,
                                   ErrorCode code) const {
  const RecordedChunk& where = chunks_[chunk];
  refuse_recording(where.offset,
                   "in the chunk of " + std::string(name_of(where.head.kind)) + " that begins here, byte " +
                       std::to_string(offset) + " of its content: " + reason,
                   code);
}

std::vector<std::byte> RecordingFile::content(std::size_t chunk) {
  const RecordedChunk& where = chunks_[chunk];
  std::vector<std::byte> stored =
      bytes_at(where.offset + kChunkHeadBytes, static_cast<std::size_t>(where.head.stored_bytes));
  try {
    return unpack_chunk(where.head, std::move(stored));
  } catch (const RefusedBytes& refused) {
    refuse_recording(where.offset + refused.offset, refused.reason, refused.code());
  }
}

// Reads the solids of a chunk behind those that are known; if it throws, these stay.
template <class Pointer, class Read>
void RecordingFile::append_solids(std::size_t chunk, std::vector<Pointer>& known, Read&& read) {
  const std::vector<std::byte> bytes = content(chunk);
  const std::size_t before = known.size();
  try {
    read_content(chunk, bytes, [&](std::span<const std::byte> content) {
      ByteReader reader(content, "the chunk");
      read(reader, known);
      const std::string kind = name_of(chunks_[chunk].head.kind);
      if (reader.left() > 0) refuse_bytes(reader.at(), "something follows the last of the " + kind);
      if (known.size() - before != chunks_[chunk].head.count)
        refuse_bytes(0, "the chunk's head says another number of " + kind);
    });
  } catch (...) {
    known.resize(before);
    throw;
  }
}

SolidViews RecordingFile::solids_before(std::size_t chunk) {
  for (; solids_until_ < chunk; ++solids_until_) {
    const ChunkKind kind = chunks_[solids_until_].head.kind;
    if (kind == ChunkKind::hulls) append_solids(solids_until_, solids_.hulls, read_solids);
    if (kind == ChunkKind::meshes) append_solids(solids_until_, solids_.meshes, read_mesh_solids);
  }
  const RecordedChunk& next = chunks_[chunk];
  return {std::span<const SolidPointer>(solids_.hulls).first(static_cast<std::size_t>(next.hulls_before)),
          std::span<const MeshPointer>(solids_.meshes).first(static_cast<std::size_t>(next.meshes_before))};
}

void RecordingFile::check_step(std::uint64_t step, const std::string& call) const {
  if (step >= info_.first_step && step <= info_.last_step) return;
  throw Error(call + "step is " + std::to_string(step) + ", must lie in [" +
              std::to_string(info_.first_step) + ", " + std::to_string(info_.last_step) + "]");
}

std::size_t RecordingFile::keyframe_before(std::uint64_t step) const {
  const auto after = std::upper_bound(keyframe_steps_.begin(), keyframe_steps_.end(), step);
  return static_cast<std::size_t>(after - keyframe_steps_.begin()) - 1;
}

std::size_t RecordingFile::keyframe_after(std::uint64_t step) const {
  const auto found = std::lower_bound(keyframe_steps_.begin(), keyframe_steps_.end(), step);
  return static_cast<std::size_t>(found - keyframe_steps_.begin());
}

Snapshot RecordingFile::first_state(std::size_t chunk) {
  const SolidViews solids = solids_before(chunk);
  return read_content(chunk, content(chunk), [&](std::span<const std::byte> bytes) {
    return read_state(bytes, solids, is_shared(chunk));
  });
}

Snapshot RecordingFile::state(std::size_t chunk) {
  if (!is_shared(chunk)) return first_state(chunk);
  World common;
  restore(common, first_state(chunk));
  PartChunks parts(*this, chunk);
  try {
    return add_parts(std::move(common), parts);
  } catch (const RefusedRecording&) {
    throw;
  } catch (const Error& error) {  // as a rank refuses messages
    refuse_content(chunk, 0, std::string("its parts do not fit: ") + error.what());
  }
}

std::uint64_t RecordingFile::hash_of_state(std::size_t chunk) {
  if (is_shared(chunk)) return scree::hash_of_state(*SnapshotAccess::data(state(chunk)));
  return read_content(chunk, content(chunk),
                      [](std::span<const std::byte> bytes) { return recorded_state_hash(bytes); });
}

// --- records ---

void RecordStream::go_behind(std::size_t chunk) {
  chunk_ = chunk;
  content_.clear();
  at_ = 0;
  steps_ = calls_ = 0;
}

void RecordStream::close_chunk() const {
  const RecordedChunk& chunk = file_.chunks()[chunk_];
  if (chunk.head.kind != ChunkKind::calls) return;
  if (steps_ != chunk.head.steps || calls_ != chunk.head.count) {
    file_.refuse_content(chunk_, at_, "the chunk's head says another number of steps or calls");
  }
}

void RecordStream::open_next_chunk(World* world) {
  const std::size_t next = chunk_ + 1;
  if (next >= file_.chunks().size()) file_.refuse_content(chunk_, at_, "there is no further step");
  const ChunkKind kind = file_.chunks()[next].head.kind;
  std::vector<std::byte> content;
  if (kind == ChunkKind::calls) content = file_.content(next);
  if (kind == ChunkKind::restored && world != nullptr) {
    if (internals(*world).border != nullptr) {
      file_.refuse_content(next, 0, "a snapshot was restored here, which the ranks of a world cannot do",
                           ErrorCode::wrong_state);
    }
    restore(*world, file_.state(next));
  }
  go_behind(next);
  content_ = std::move(content);
}

bool RecordStream::take_record(World* world, Step& step) {
  std::optional<SolidViews> solids;
  if (world != nullptr) solids = file_.solids_before(chunk_);
  CallReader reader(std::span<const std::byte>(content_).subspan(at_), solids);
  bool is_step = false;
  file_.read_content(chunk_, content_, [&](std::span<const std::byte>) {
    try {
      const auto call = static_cast<RecordedCall>(reader.take<std::uint8_t>());
      is_step = call == RecordedCall::step;
      if (is_step) {
        step.dt = reader.take<float>();
        if (!(step.dt >= 0.0f && step.dt <= 1.0f)) refuse_bytes(1, "the time step is out of range");
        step.hash = reader.take<std::uint64_t>();
      } else {
        take_call(call, reader, world);
      }
    } catch (const RefusedBytes& refused) {
      refuse_bytes(at_ + refused.offset, refused.reason, refused.code());
    } catch (const Error& error) {
      refuse_bytes(at_, std::string("the world refuses the call: ") + error.what());
    }
  });
  at_ += reader.at();
  ++(is_step ? steps_ : calls_);
  if (steps_ > file_.chunks()[chunk_].head.steps) close_chunk();
  return is_step;
}

RecordStream::Step RecordStream::next_step(World* world) {
  return *next_step_within(world, std::numeric_limits<std::uint64_t>::max());
}

std::optional<RecordStream::Step> RecordStream::next_step_within(World* world, std::uint64_t most_calls) {
  for (Step step{}; most_calls > 0;) {
    if (at_ < content_.size()) {
      if (take_record(world, step)) return step;
      --most_calls;
      continue;
    }
    close_chunk();
    open_next_chunk(world);
  }
  return {};
}

}  // namespace scree
