// See recording_writer.h.
#include <core/state/recording_format/recorded_state.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <parallel/recording/recording_writer.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#ifndef SCREE_VERSION
#error "the build says which version this is"
#endif

namespace scree {

namespace {

constexpr std::size_t kMostPendingBytes = std::size_t{64} << 20;  // beyond that the recorder waits
constexpr std::size_t kMuchBytes = std::size_t{1} << 20;          // the writer begins without being asked
constexpr std::size_t kMostSpareStates = 2;                       // one in writing, one being filled
constexpr const char* kOutOfMemory = "memory ran out";

#define SCREE_TEXT_OF(number) #number
#define SCREE_TEXT(number) SCREE_TEXT_OF(number)
#if defined(__clang__)
constexpr const char* kCompiler = "clang++ " SCREE_TEXT(__clang_major__) "." SCREE_TEXT(__clang_minor__);
#else
constexpr const char* kCompiler = "g++ " SCREE_TEXT(__GNUC__) "." SCREE_TEXT(__GNUC_MINOR__);
#endif
#if defined(SCREE_SANITIZED)
constexpr const char* kBuild = "sanitized";
#elif defined(NDEBUG)
constexpr const char* kBuild = "release";
#else
constexpr const char* kBuild = "debug";
#endif

std::string writer_name() { return std::string("Scree " SCREE_VERSION ", ") + kCompiler + ", " + kBuild; }

// Threads inherit blocked signals. Blocks all signals in the writer's thread: the caller's are not for it,
// and a limit of the file's size or a pipe without a reader must be an error of writing, not the end of the
// process. Leaves those of a crash: they must reach the host's handlers.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t blocked;
    sigfillset(&blocked);
    for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) sigdelset(&blocked, fault);
    pthread_sigmask(SIG_SETMASK, &blocked, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

std::size_t bytes_of(const StateToRecord& state) {
  return state.snapshot.pages->sheets.bytes() +
         (state.solids.hulls.size() + state.solids.meshes.size()) * sizeof(std::int32_t);
}

bool is_regular(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

// Descriptors 0 to 2 are free where the host has closed its standard streams. If the recording had one, a
// write to that stream would go into the recording.
int above_standard_streams(int descriptor) {
  if (descriptor < 0 || descriptor > STDERR_FILENO) return descriptor;
  const int higher = fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int problem = errno;
  close(descriptor);
  errno = problem;
  return higher;
}

// Opens or creates the file, and keeps its content. The lock belongs to the file under all of its names;
// players take none. Other recorders go unnoticed where the file system has no locks.
int open_recording(const std::string& file) {
  int descriptor = -1;
  do {
    descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOCTTY, 0666);
  } while (descriptor < 0 && errno == EINTR);
  descriptor = above_standard_streams(descriptor);
  if (descriptor < 0) {
    throw Error(file + ": cannot be created: " + std::strerror(errno), ErrorCode::io_failure);
  }
  if (is_regular(descriptor) && flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor);
    throw Error(file + ": another recorder is writing to this file", ErrorCode::already_recording);
  }
  return descriptor;
}

}  // namespace

// Releases the lock explicitly: a process that the host has forked may keep the file open.
int RecordingWriter::Close::operator()(std::FILE* file) const {
  flock(fileno(file), LOCK_UN);
  return std::fclose(file);
}

RecordingWriter::RecordingWriter(const std::string& file, const RecorderOptions& options)
    : name_(file), flush_interval_(options.flush_interval), packer_(options.compression_level) {
  const int descriptor = open_recording(file);
  file_.reset(fdopen(descriptor, "wb"));
  if (file_ == nullptr) {
    close(descriptor);
    throw std::bad_alloc();
  }
  // Chunks are written whole, so a buffer would only copy them.
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  start();
  {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return !writing_; });
  }
  if (!has_failed()) return;
  stop();
  throw_error("");
}

RecordingWriter::~RecordingWriter() { stop(); }

void RecordingWriter::start() {
  const BlockedSignals blocked;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    throw Error(name_ + ": a thread to write it cannot be started: " + error.what(), ErrorCode::io_failure);
  }
}

std::unique_lock<std::mutex> RecordingWriter::lock_with_room() {
  std::unique_lock lock(mutex_);
  if (pending_bytes_ >= kMostPendingBytes) {
    room_.wait(lock, [this] { return pending_bytes_ < kMostPendingBytes || has_failed(); });
  }
  return lock;
}

RecordingBatch& RecordingWriter::open_batch(std::uint64_t step) {
  if (pending_.empty() || pending_.back().state != nullptr || pending_.back().bytes.size() >= kMuchBytes) {
    pending_.emplace_back().step = step;
  }
  return pending_.back();
}

void RecordingWriter::hurry_if_much() {
  if (pending_bytes_ < kMuchBytes || urgent_) return;
  urgent_ = true;
  wake_.notify_one();
}

void RecordingWriter::add_state(std::uint64_t step, std::unique_ptr<StateToRecord> state,
                                SolidVectors new_solids) {
  const std::unique_lock lock = lock_with_room();
  const std::size_t bytes = bytes_of(*state);
  RecordingBatch& batch = pending_.emplace_back();
  batch.step = step;
  batch.solids = std::move(new_solids);
  batch.state = std::move(state);
  pending_bytes_ += bytes;
  hurry_if_much();
}

void RecordingWriter::add_solids(std::uint64_t step, SolidVectors new_solids) {
  if (new_solids.hulls.empty() && new_solids.meshes.empty()) return;
  const std::unique_lock lock = lock_with_room();
  RecordingBatch& batch = pending_.emplace_back();
  batch.step = step;
  batch.solids = std::move(new_solids);
}

std::unique_ptr<StateToRecord> RecordingWriter::take_spare_state() {
  const std::lock_guard lock(mutex_);
  if (spare_.empty()) return nullptr;
  std::unique_ptr<StateToRecord> state = std::move(spare_.back());
  spare_.pop_back();
  return state;
}

void RecordingWriter::wait_until_written() {
  std::unique_lock lock(mutex_);
  urgent_ = true;
  wake_.notify_one();
  room_.wait(lock, [this] { return (pending_.empty() && !writing_) || has_failed(); });
}

bool RecordingWriter::is_regular_file() const { return is_regular(fileno(file_.get())); }

void RecordingWriter::write_packed(const ChunkPacker::Packed& packed) {
  write_bytes(packed.head);
  write_bytes(packed.stored);
  flush();
}

void RecordingWriter::share(const std::string& name) {
  const int descriptor = fileno(file_.get());
  struct stat named {
  }, own{};
  const bool is_same = stat(name.c_str(), &named) == 0 && fstat(descriptor, &own) == 0 &&
                       named.st_dev == own.st_dev && named.st_ino == own.st_ino;
  if (!is_same)
    throw Error(name + ": was moved or removed, so other ranks cannot write to it", ErrorCode::io_failure);
  // Else a loss of power may leave a gap before what others have written.
  if (fdatasync(descriptor) != 0) fail_to_write();
  flock(descriptor, LOCK_UN);
}

void RecordingWriter::take_back(const std::string& name, std::uint64_t bytes) {
  const int descriptor = fileno(file_.get());
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw Error(name + ": another recorder is writing to this file", ErrorCode::already_recording);
  const std::uint64_t end = bytes_written() + bytes;
  struct stat status {};
  const int opened = open(name.c_str(), O_RDONLY | O_CLOEXEC);  // so that its size is not an old one
  const bool is_whole =
      opened >= 0 && fstat(opened, &status) == 0 && static_cast<std::uint64_t>(status.st_size) >= end;
  if (opened >= 0) close(opened);
  if (!is_whole)
    throw Error(name + ": lacks what other ranks have written; it must be the same file on all of them",
                ErrorCode::io_failure);
  if (fseeko(file_.get(), static_cast<off_t>(end), SEEK_SET) != 0) fail_to_write();
  bytes_written_.store(end, std::memory_order_relaxed);
}

void RecordingWriter::stop() noexcept {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    wake_.notify_one();
  }
  thread_.join();
  file_.reset();
}

void RecordingWriter::fail(const char* reason, ErrorCode code) noexcept {
  const std::lock_guard lock(mutex_);
  if (has_failed()) return;
  error_code_ = code;
  try {
    error_ = reason;
  } catch (const std::bad_alloc&) {
    error_ = kOutOfMemory;  // short enough to need no memory
  }
  failed_.store(true, std::memory_order_relaxed);
}

std::string RecordingWriter::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void RecordingWriter::throw_error(const char* call) const {
  const std::lock_guard lock(mutex_);
  throw Error(call + error_, error_code_);
}

// --- the writer's thread ---

// Does the work, or closes the file if that fails: data after a gap would be useless.
template <class Work>
void RecordingWriter::attempt(Work&& work) noexcept {
  try {
    work();
  } catch (const std::bad_alloc&) {
    file_.reset();
    fail(kOutOfMemory, ErrorCode::out_of_memory);
  } catch (const Error& error) {
    file_.reset();
    fail(error.what(), error.code());
  } catch (const std::exception& error) {
    file_.reset();
    fail(error.what(), ErrorCode::io_failure);
  }
}

void RecordingWriter::run() noexcept {
  attempt([this] {
    clear_file();
    write_bytes(write_recording_head(writer_name()));
    flush();
  });
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    room_.notify_all();
  }
  std::vector<RecordingBatch> batches;
  for (bool last = false; !last;) {
    std::size_t bytes = 0;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, flush_interval_, [this] { return urgent_ || stopping_; });
      batches.swap(pending_);
      bytes = pending_bytes_;
      urgent_ = false;
      last = stopping_;
      writing_ = true;
    }
    attempt([&] {
      write_all(batches);
      if (last && !has_failed()) {
        write_chunk({.kind = ChunkKind::end, .step = last_step_}, {});
        if (Close{}(file_.release()) != 0) fail_to_write();
      }
    });
    const std::lock_guard lock(mutex_);
    batches.clear();
    pending_bytes_ -= bytes;
    writing_ = false;
    room_.notify_all();
  }
}

// Empties a file that held an earlier recording.
void RecordingWriter::clear_file() {
  const int descriptor = fileno(file_.get());
  if (is_regular(descriptor) && ftruncate(descriptor, 0) != 0) fail_to_write();
}

void RecordingWriter::write_all(std::vector<RecordingBatch>& batches) {
  for (RecordingBatch& batch : batches) {
    if (file_ == nullptr) return;
    write_batch(batch);
    if (batch.state == nullptr) continue;
    const std::lock_guard lock(mutex_);
    if (spare_.size() < kMostSpareStates) spare_.push_back(std::move(batch.state));
  }
}

void RecordingWriter::write_batch(RecordingBatch& batch) {
  if (const auto& hulls = batch.solids.hulls; !hulls.empty()) {
    ByteWriter content;
    write_solids(hulls, content);
    write_chunk({.kind = ChunkKind::hulls, .step = batch.step, .count = hulls.size()}, content.bytes());
  }
  if (const auto& meshes = batch.solids.meshes; !meshes.empty()) {
    ByteWriter content;
    write_mesh_solids(meshes, content);
    write_chunk({.kind = ChunkKind::meshes, .step = batch.step, .count = meshes.size()}, content.bytes());
  }
  last_step_ = batch.step + batch.steps;
  if (batch.state == nullptr) {
    if (batch.steps == 0 && batch.calls == 0) return;
    write_chunk({.kind = ChunkKind::calls, .step = batch.step, .steps = batch.steps, .count = batch.calls},
                batch.bytes.bytes());
    return;
  }
  ByteWriter content;
  write_state(batch.state->snapshot, batch.state->solids, content);
  write_chunk({.kind = batch.state->kind, .step = batch.step}, content.bytes());
}

void RecordingWriter::write_chunk(const ChunkHead& head, std::span<const std::byte> content) {
  write_packed(packer_.pack(head, content));
}

void RecordingWriter::write_bytes(std::span<const std::byte> bytes) {
  const std::size_t written = bytes.empty() ? 0 : std::fwrite(bytes.data(), 1, bytes.size(), file_.get());
  bytes_written_.fetch_add(written, std::memory_order_relaxed);
  if (written != bytes.size()) fail_to_write();
}

void RecordingWriter::flush() {
  if (std::fflush(file_.get()) != 0) fail_to_write();
}

void RecordingWriter::fail_to_write() {
  throw Error(name_ + ": cannot be written: " + std::strerror(errno), ErrorCode::io_failure);
}

}  // namespace scree
