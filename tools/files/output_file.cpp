// See output_file.h.
#include <fcntl.h>
#include <scree/error.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <tools/files/output_file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <utility>

namespace scree::files {
namespace {

namespace fs = std::filesystem;

using Status = struct stat;

// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return descriptor_; }
  bool close() {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor < 0 || ::close(descriptor) == 0;
  }

 private:
  int descriptor_;
};

std::string reason(int error) { return std::strerror(error); }

std::optional<Status> status_of(const std::string& path) {
  Status status{};
  if (stat(path.c_str(), &status) != 0) return {};
  return status;
}

bool is_same(const Status& a, const Status& b) { return a.st_dev == b.st_dev && a.st_ino == b.st_ino; }

// The path at which a file will be created: follows links whose targets do not exist.
fs::path behind_links(fs::path path) {
  constexpr int kMostLinks = 40;  // as the system follows
  std::error_code problem;
  for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(path, problem)); ++i) {
    const fs::path target = fs::read_symlink(path, problem);
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  return path;
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Identity of a file: device and inode, or for a new file those of its folder and its name there.
struct Identity {
  dev_t device;
  ino_t number;
  std::string name;

  bool operator==(const Identity&) const = default;
};

// Empty for targets that several outputs may share: devices, such as /dev/null, and files that do not exist.
std::optional<Identity> identity_of(const std::string& path) {
  if (const std::optional<Status> status = status_of(path)) {
    if (S_ISCHR(status->st_mode)) return {};
    return Identity{status->st_dev, status->st_ino, ""};
  }
  const fs::path target = behind_links(path);
  if (const std::optional<Status> folder = status_of(folder_of(target).string())) {
    return Identity{folder->st_dev, folder->st_ino, target.filename().string()};
  }
  return {};
}

// Recorders lock their files; see Recorder.
bool is_being_recorded(const std::string& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  return file.get() >= 0 && flock(file.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

bool is_permitted(const std::string& path, int how) {
  return faccessat(AT_FDCWD, path.c_str(), how, AT_EACCESS) == 0;
}

// The reason why the file cannot be written; empty if it can.
std::string problem_with(const std::string& path) {
  if (const std::optional<Status> status = status_of(path)) {
    if (S_ISDIR(status->st_mode)) return reason(EISDIR);
    if (!is_permitted(path, W_OK)) return reason(errno);
    if (S_ISREG(status->st_mode) && is_being_recorded(path)) return "a recorder is writing to it";
    return {};
  }
  if (errno != ENOENT) return reason(errno);
  const fs::path target = behind_links(path);
  if (!target.has_filename()) return reason(ENOENT);
  return is_permitted(folder_of(target).string(), W_OK | X_OK) ? std::string() : reason(errno);
}

std::string text_of(const NamedFile& file) {
  return file.argument + (file.argument.empty() ? "" : " ") + file.path;
}

[[noreturn]] void fail_to_write(const NamedFile& file, const std::string& why) {
  throw std::runtime_error(text_of(file) + ": writing failed: " + why);
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// A descriptor of the process that leads to the file, such as 1 for /dev/stdout. The program that opened it
// would not see a file put in its place.
int open_descriptor_of(const Status& status) {
  constexpr int kMostDescriptors = 1024;
  for (int descriptor = 0; descriptor < kMostDescriptors; ++descriptor) {
    Status open{};
    if (fstat(descriptor, &open) == 0 && is_same(open, status) &&
        (fcntl(descriptor, F_GETFL) & O_ACCMODE) != O_RDONLY) {
      return descriptor;
    }
  }
  return -1;
}

// Copies owner and permissions of the replaced file.
bool take_over(int descriptor, const Status& from) {
  Status own{};
  if (fstat(descriptor, &own) != 0) return false;
  if ((own.st_uid != from.st_uid || own.st_gid != from.st_gid) &&
      fchown(descriptor, from.st_uid, from.st_gid) != 0) {
    return false;
  }
  return fchmod(descriptor, from.st_mode & 07777) == 0;
}

// A new file beside the target. The destructor deletes it unless it replaced the target.
class Draft {
 public:
  explicit Draft(const fs::path& target) : target_(target) {
    for (int i = 0; i < 1000; ++i) {
      path_ = folder_of(target) / (".scree_" + std::to_string(getpid()) + "_" + std::to_string(i));
      descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      exists_ = descriptor_ >= 0;
      if (exists_ || errno != EEXIST) return;
    }
  }
  ~Draft() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (exists_) unlink(path_.c_str());
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  int descriptor() const { return descriptor_; }
  // Returns false, with errno, if the text does not reach the disk.
  bool fill(std::string_view text) {
    if (!write_all(descriptor_, text)) return false;
    // Not every file system supports this.
    if (fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) return false;
    return ::close(std::exchange(descriptor_, -1)) == 0;
  }
  bool put_in_place() {
    exists_ = std::rename(path_.c_str(), target_.c_str()) != 0;
    return !exists_;
  }

 private:
  fs::path target_, path_;
  int descriptor_ = -1;
  bool exists_ = false;
};

// Returns false if the folder accepts no new file, or none in place of the old one.
bool replace(const NamedFile& file, const std::optional<Status>& old, std::string_view text) {
  fs::path target = behind_links(file.path);
  if (old) {
    std::error_code problem;
    target = fs::canonical(file.path, problem);
    if (problem) fail_to_write(file, problem.message());
  }
  Draft draft(target);
  // The folder's permissions forbid it, or the file is a mount point.
  const auto is_forbidden = [](int error) {
    return error == EACCES || error == EPERM || error == EROFS || error == EBUSY || error == EXDEV;
  };
  if (draft.descriptor() < 0 && is_forbidden(errno)) return false;
  if (draft.descriptor() < 0) fail_to_write(file, reason(errno));
  if (old && !take_over(draft.descriptor(), *old)) return false;
  if (!draft.fill(text)) fail_to_write(file, reason(errno));
  if (draft.put_in_place()) return true;
  if (!is_forbidden(errno)) fail_to_write(file, reason(errno));
  return false;
}

void write_in_place(const NamedFile& file, std::string_view text) {
  Descriptor out(open(file.path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, 0666));
  if (out.get() < 0 || !write_all(out.get(), text) || !out.close()) fail_to_write(file, reason(errno));
}

}  // namespace

void prepare_process() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest free one, so this one. Nothing can be read from what is open for writing only, and the like.
    [[maybe_unused]] const int taken = open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

bool is_standard_stream(const std::string& path, int stream) {
  const std::optional<Status> status = status_of(path);
  Status standard{};
  if (!status || fstat(stream, &standard) != 0 || !is_same(*status, standard)) return false;
  return !S_ISCHR(standard.st_mode) || isatty(stream) == 1;
}

void check_outputs(std::span<const NamedFile> inputs, std::span<const NamedFile> outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& output = outputs[i];
    if (const std::string problem = problem_with(output.path); !problem.empty()) {
      throw Error(text_of(output) + ": cannot be written: " + problem);
    }
    const std::optional<Identity> identity = identity_of(output.path);
    if (!identity) continue;
    for (const std::span<const NamedFile> others : {inputs, outputs.first(i)}) {
      for (const NamedFile& other : others) {
        if (identity_of(other.path) != identity) continue;
        throw Error(text_of(output) + ": is the same file as " + text_of(other));
      }
    }
  }
}

void write_file(const NamedFile& file, std::string_view text) {
  const std::optional<Status> old = status_of(file.path);
  if (old && !S_ISREG(old->st_mode)) return write_in_place(file, text);
  if (old) {
    if (const int open = open_descriptor_of(*old); open >= 0) {
      if (!write_all(open, text)) fail_to_write(file, reason(errno));
      return;
    }
    if (is_being_recorded(file.path)) fail_to_write(file, "a recorder is writing to it");
  }
  if (!replace(file, old, text)) write_in_place(file, text);
}

void write_standard_output(std::string_view text) {
  errno = 0;
  const bool written = (std::cout << std::flush) &&
                       std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
                       std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (!written) {
    throw std::runtime_error("standard output cannot be written" + (errno != 0 ? ": " + reason(errno) : ""));
  }
}

}  // namespace scree::files
