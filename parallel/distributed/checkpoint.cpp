// See checkpoint.h.
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <fcntl.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/checkpoint.h>
#include <parallel/distributed/messages.h>
#include <parallel/distributed/no_file_signal.h>
#include <parallel/distributed/world_parts.h>
#include <scree/distributed_world.h>
#include <scree/error.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace scree {

namespace {

constexpr char kMagic[8] = {'S', 'C', 'R', 'E', 'E', 'P', 'T', 'S'};
constexpr std::size_t kFixedHeadBytes = 32;  // before the table of parts
constexpr const char* kCall = "read_checkpoint";

struct PartEntry {
  std::uint64_t bytes, hash;
};

std::size_t head_bytes(std::size_t ranks) {
  return kFixedHeadBytes + ranks * sizeof(PartEntry) + sizeof(std::uint64_t);
}

// Says of which file it is.
struct RefusedFile : Error {
  using Error::Error;
};

// What a file holds.
struct CheckpointFile final : PartSource {
  std::string name;
  std::ifstream stream;
  std::vector<PartEntry> parts;
  std::vector<std::uint64_t> begin;  // of each part

  [[noreturn]] void refuse(std::uint64_t offset, const std::string& reason,
                           ErrorCode code = ErrorCode::corrupt_data) const {
    throw RefusedFile(std::string(kCall) + ": " + name + ", byte " + std::to_string(offset) + ": " + reason,
                      code);
  }
  std::vector<std::byte> read(std::uint64_t offset, std::size_t count) {
    std::vector<std::byte> bytes(count);
    stream.seekg(static_cast<std::streamoff>(offset));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
    if (!stream) refuse(offset, "the file cannot be read", ErrorCode::io_failure);
    return bytes;
  }
  int ranks() const override { return static_cast<int>(parts.size()); }
  std::vector<std::byte> part(int of_rank) override {
    const auto rank = static_cast<std::size_t>(of_rank);
    std::vector<std::byte> bytes = read(begin[rank], static_cast<std::size_t>(parts[rank].bytes));
    if (hash_of_bytes(bytes) != parts[rank].hash)
      refuse(begin[rank], "the checksum of the part of rank " + std::to_string(rank) + " is wrong");
    return bytes;
  }
  [[noreturn]] void refuse(int rank, std::size_t at, const std::string& reason) const override {
    refuse(begin[static_cast<std::size_t>(rank)] + at, reason);
  }
};

std::uint64_t size_of(CheckpointFile& file) {
  file.stream.open(file.name, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.stream.is_open() ? std::streamoff{file.stream.tellg()} : -1;
  if (size >= 0) return static_cast<std::uint64_t>(size);
  throw Error(std::string(kCall) + ": " + file.name + ": cannot be opened", ErrorCode::io_failure);
}

CheckpointFile open_checkpoint(const std::string& name) {
  CheckpointFile file;
  file.name = name;
  const std::uint64_t size = size_of(file);
  if (size < head_bytes(1)) file.refuse(size, "the file ends too early");
  const std::vector<std::byte> head = file.read(0, kFixedHeadBytes);
  ByteReader reader(head);
  if (std::memcmp(reader.take_bytes(sizeof kMagic), kMagic, sizeof kMagic) != 0)
    file.refuse(0, "this is no checkpoint");
  if (const auto version = reader.take<std::uint32_t>(); version != kCheckpointVersion) {
    file.refuse(8,
                "the checkpoint has version " + std::to_string(version) + ", this is version " +
                    std::to_string(kCheckpointVersion),
                ErrorCode::wrong_version);
  }
  if (reader.take<std::uint32_t>() != kByteOrderMark)
    file.refuse(12, "the bytes are not in little-endian order");
  if (reader.take<std::uint64_t>() != layout_of_parts())
    file.refuse(16, "a version of Scree with other columns has written this", ErrorCode::wrong_version);
  const auto ranks = reader.take<std::uint64_t>();
  if (ranks == 0 || ranks > kMostRanks)
    file.refuse(24, "there are " + std::to_string(ranks) + " ranks; it must be in [1, 1000000]");
  const std::size_t begin = head_bytes(static_cast<std::size_t>(ranks));
  if (size < begin) file.refuse(size, "the file ends too early");
  const std::vector<std::byte> all = file.read(0, begin);
  std::uint64_t hash = 0;
  std::memcpy(&hash, all.data() + begin - sizeof hash, sizeof hash);
  if (hash != hash_of_bytes(std::span(all).first(begin - sizeof hash)))
    file.refuse(begin - sizeof hash, "the checksum is wrong");
  file.parts.resize(static_cast<std::size_t>(ranks));
  std::memcpy(file.parts.data(), all.data() + kFixedHeadBytes, file.parts.size() * sizeof(PartEntry));
  std::uint64_t at = begin;
  for (const PartEntry& part : file.parts) {
    if (part.bytes > size - at) file.refuse(size, "the file ends too early");
    file.begin.push_back(at);
    at += part.bytes;
  }
  if (at != size) file.refuse(at, "more follows than the parts of all ranks");
  return file;
}

std::vector<std::byte> make_head(std::span<const PartEntry> parts) {
  ByteWriter head;
  head.put_bytes(kMagic, sizeof kMagic);
  head.put(kCheckpointVersion);
  head.put(kByteOrderMark);
  head.put(layout_of_parts());
  head.put(std::uint64_t{parts.size()});
  for (const PartEntry& part : parts) {
    head.put(part.bytes);
    head.put(part.hash);
  }
  head.put(hash_of_bytes(head.bytes()));
  return head.take();
}

}  // namespace

std::vector<std::byte> checkpoint_part(World& world, Crew& crew) {
  const Border* const border = border_of(internals(world));
  if (border != nullptr && border->here != 0) return messages_of_part(world, crew);
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  save_first_part(world, *SnapshotAccess::data(snapshot));
  return write_snapshot(snapshot);
}

namespace {

// Where the file is, behind links; rank 0 looks, and all ranks throw what it finds wrong.
std::string agree_on_target(Transport& transport, const std::string& file) {
  std::string target = file, problem;
  if (transport.rank() == 0) {
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::file_status status = fs::status(file, failure);
    if (fs::exists(status)) {
      if (!fs::is_regular_file(status)) problem = "it is no regular file";
      target = fs::canonical(file, failure).string();
      if (failure) problem = failure.message();
    } else if (fs::is_symlink(fs::symlink_status(file, failure))) {  // to what is not there yet
      target = (fs::path(file).parent_path() / fs::read_symlink(file, failure)).string();
      if (failure) problem = failure.message();
    }
    const std::string told = problem.empty() ? "+" + target : "-" + problem;
    for (std::int32_t to = 1; to < transport.ranks(); ++to)
      send_list<char>(transport, to, std::span(told.data(), told.size()));
  } else {
    const std::vector<char> told = receive_list<char>(transport, 0);
    (told.at(0) == '+' ? target : problem).assign(told.begin() + 1, told.end());
  }
  if (!problem.empty()) throw Error(file + ": cannot be written: " + problem, ErrorCode::io_failure);
  return target;
}

int create_file(const std::string& file) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  return descriptor < 0 || close(descriptor) != 0 ? errno : 0;
}

// errno, or 0. The folder is synchronized, too: else the old file may be back after a power failure.
int put_in_place(const std::string& draft, const std::string& target) {
  if (std::rename(draft.c_str(), target.c_str()) != 0) return errno;
  const std::string folder = std::filesystem::path(target).parent_path().string();
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return 0;  // a folder that may be written but not read
  fsync(descriptor);
  close(descriptor);
  return 0;
}

}  // namespace

void write_parts(Transport& transport, const std::string& file, std::span<const std::byte> part) {
  const std::string target = agree_on_target(transport, file), draft = target + ".draft";
  const std::vector<PartEntry> parts = gather_rows(transport, PartEntry{part.size(), hash_of_bytes(part)});
  const std::vector<std::byte> head = make_head(parts);
  std::uint64_t offset = head.size();
  for (int rank = 0; rank < transport.rank(); ++rank) offset += parts[static_cast<std::size_t>(rank)].bytes;
  const auto on_first = [&](auto&& work) {
    std::int64_t problem = transport.rank() == 0 ? work() : 0;
    transport.add_up({&problem, 1});
    return static_cast<int>(problem);
  };
  if (const int problem = on_first([&] { return create_file(draft); }))
    throw Error(file + ": cannot be written: " + std::strerror(problem), ErrorCode::io_failure);
  try {
    const NoFileSignal guard;
    if (transport.rank() == 0) {
      std::vector<std::byte> first(head);
      first.insert(first.end(), part.begin(), part.end());
      transport.write_together(draft, 0, first);
    } else {
      transport.write_together(draft, offset, part);
    }
  } catch (...) {
    if (transport.rank() == 0) std::remove(draft.c_str());
    throw;
  }
  const int problem = on_first([&] { return put_in_place(draft, target); });
  if (problem == 0) return;
  if (transport.rank() == 0) std::remove(draft.c_str());
  throw Error(file + ": cannot be replaced: " + std::strerror(problem), ErrorCode::io_failure);
}

void write_checkpoint(const World& world, const std::string& file) {
  check_byte_order("write_checkpoint");
  check_whole(internals(world, "write_checkpoint"), "write_checkpoint");
  Snapshot snapshot;
  save(world, snapshot);
  LocalRanks alone(1);
  write_parts(alone.at(0), file, write_snapshot(snapshot));
}

World read_checkpoint(const std::string& file) {
  check_byte_order(kCall);
  CheckpointFile parts = open_checkpoint(file);
  World world{WorldSettings{}};
  try {
    Snapshot state = read_snapshot(parts.part(0));
    if (parts.ranks() > 1) state = add_parts(std::move(state), parts);
    restore(world, state);
  } catch (const RefusedFile&) {
    throw;
  } catch (const Error& error) {  // as a rank refuses messages
    const bool is_told = error.code() != ErrorCode::invalid_value;
    throw Error(std::string(kCall) + ": " + file + ": " + error.what(),
                is_told ? error.code() : ErrorCode::corrupt_data);
  }
  return world;
}

}  // namespace scree
