// The thread behind a recorder: compresses records and writes them to the file.
//
// The recorder's thread appends to the last batch of a list under a lock. The writer takes the whole list,
// every flush interval or when it is long, and works on it without the lock. While many ranks write a
// keyframe, the file is the recorder's thread's.
#pragma once

#include <core/state/recording_format/call_bytes.h>
#include <core/state/recording_format/recording_chunks.h>
#include <scree/recording.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace scree {

// A state on its way to the file.
struct StateToRecord {
  ChunkKind kind = ChunkKind::keyframe;
  SnapshotData snapshot;
  SlotNumbers solids;  // as from SolidList::numbers_of
};

// What becomes a chunk: steps and calls, or a state, or solids alone.
struct RecordingBatch {
  std::uint64_t step = 0;              // before it
  std::uint64_t steps = 0, calls = 0;  // in it
  SolidVectors solids;                 // that occur in it for the first time
  ByteWriter bytes;
  std::unique_ptr<StateToRecord> state;
};

class RecordingWriter {
 public:
  // Starts the thread and waits until it has written the head. Throws Error where the file cannot be written,
  // and where another writer is at work on it, which goes on unharmed.
  RecordingWriter(const std::string& file, const RecorderOptions& options);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  // Calls add(batch) with the batch that takes steps and calls after `step` steps; what add has put into its
  // bytes when it throws is taken out again. Waits while too much is pending.
  template <class Add>
  void add(std::uint64_t step, Add&& add_to) {
    std::unique_lock lock = lock_with_room();
    RecordingBatch& batch = open_batch(step);
    const std::size_t before = batch.bytes.size();
    try {
      add_to(batch);
    } catch (...) {
      batch.bytes.shrink(before);
      throw;
    }
    pending_bytes_ += batch.bytes.size() - before;
    hurry_if_much();
  }
  void add_state(std::uint64_t step, std::unique_ptr<StateToRecord> state, SolidVectors new_solids);
  void add_solids(std::uint64_t step, SolidVectors new_solids);
  // Returns a used one, if there is one, for its memory.
  std::unique_ptr<StateToRecord> take_spare_state();

  void wait_until_written();
  // For who has waited until all was written, and has added nothing since: the thread behind is at rest.
  // All of these throw Error.
  void write_packed(const ChunkPacker::Packed& packed);
  // Lets others write into the file, whose name this is; releases its lock, as those of network file systems
  // keep away who has opened it by name, too.
  void share(const std::string& name);
  // Goes on behind so many bytes that others have written.
  void take_back(const std::string& name, std::uint64_t bytes);
  bool is_regular_file() const;
  // Writes the rest, and if nothing has failed, the end, and closes the file. Does nothing the second time.
  void stop() noexcept;
  // The recording ends with what is there now, unfinished, for a reason.
  void fail(const char* reason, ErrorCode code) noexcept;
  // Throws why it has failed; `call` begins the message.
  [[noreturn]] void throw_error(const char* call) const;

  bool has_failed() const noexcept { return failed_.load(std::memory_order_relaxed); }
  std::string error() const;
  std::uint64_t bytes_written() const noexcept { return bytes_written_.load(std::memory_order_relaxed); }

 private:
  std::unique_lock<std::mutex> lock_with_room();
  RecordingBatch& open_batch(std::uint64_t step);
  void hurry_if_much();
  void start();
  void run() noexcept;
  template <class Work>
  void attempt(Work&& work) noexcept;
  void clear_file();
  void write_all(std::vector<RecordingBatch>& batches);
  void write_batch(RecordingBatch& batch);
  void write_chunk(const ChunkHead& head, std::span<const std::byte> content);
  void write_bytes(std::span<const std::byte> bytes);
  void flush();
  [[noreturn]] void fail_to_write();

  struct Close {
    int operator()(std::FILE* file) const;  // as fclose
  };
  const std::string name_;
  const std::chrono::duration<double> flush_interval_;
  std::unique_ptr<std::FILE, Close> file_;  // the writer's from its start to its end, but while it is shared
  ChunkPacker packer_;
  std::uint64_t last_step_ = 0;  // writer; after the last batch

  mutable std::mutex mutex_;      // guards all that follows
  std::condition_variable wake_;  // the writer: the list is long, or a caller waits
  std::condition_variable room_;  // the recorder: something has been written
  std::vector<RecordingBatch> pending_;
  std::vector<std::unique_ptr<StateToRecord>> spare_;
  std::size_t pending_bytes_ = 0;  // what the writer is at work on included
  bool urgent_ = false;
  bool stopping_ = false;
  bool writing_ = true;  // at first the head
  std::string error_;
  ErrorCode error_code_ = ErrorCode::io_failure;
  std::atomic<bool> failed_ = false;
  std::atomic<std::uint64_t> bytes_written_ = 0;
  std::thread thread_;
};

}  // namespace scree
