// See checkpoint.h.
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <fcntl.h>
#include <parallel/distributed/agree.h>
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
#include <memory>
#include <numeric>
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

constexpr std::size_t kCommonParts = 2;  // before those of ranks

std::size_t head_bytes(std::size_t parts) {
  return kFixedHeadBytes + parts * sizeof(PartEntry) + sizeof(std::uint64_t);
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
  std::uint64_t identity = 0;

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
  bool is_whole() const { return parts.size() == 1; }
  std::vector<std::byte> read_part(std::size_t part) {
    std::vector<std::byte> bytes = read(begin[part], static_cast<std::size_t>(parts[part].bytes));
    if (hash_of_bytes(bytes) != parts[part].hash)
      refuse(begin[part], "the checksum of part " + std::to_string(part) + " is wrong");
    return bytes;
  }
  int ranks() const override { return static_cast<int>(parts.size() - kCommonParts); }
  std::vector<std::byte> part(int rank) override {
    return read_part(kCommonParts + static_cast<std::size_t>(rank));
  }
  [[noreturn]] void refuse(int rank, std::size_t at, const std::string& reason) const override {
    refuse(begin[kCommonParts + static_cast<std::size_t>(rank)] + at, reason);
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
  const auto parts = reader.take<std::uint64_t>();
  if (parts != 1 && (parts < kCommonParts + 2 || parts > kCommonParts + kMostRanks))
    file.refuse(24, "there are " + std::to_string(parts) + " parts; it must be 1 or in [4, 1000002]");
  const std::size_t begin = head_bytes(static_cast<std::size_t>(parts));
  if (size < begin) file.refuse(size, "the file ends too early");
  const std::vector<std::byte> all = file.read(0, begin);
  std::uint64_t hash = 0;
  std::memcpy(&hash, all.data() + begin - sizeof hash, sizeof hash);
  if (hash != hash_of_bytes(std::span(all).first(begin - sizeof hash)))
    file.refuse(begin - sizeof hash, "the checksum is wrong");
  file.identity = hash;
  file.parts.resize(static_cast<std::size_t>(parts));
  std::memcpy(file.parts.data(), all.data() + kFixedHeadBytes, file.parts.size() * sizeof(PartEntry));
  std::uint64_t at = begin;
  for (const PartEntry& part : file.parts) {
    if (part.bytes > size - at) file.refuse(size, "the file ends too early");
    file.begin.push_back(at);
    at += part.bytes;
  }
  if (at != size) file.refuse(at, "more follows than the parts");
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

// The bytes are gone then.
Snapshot read_common(CheckpointFile& file) {
  const std::vector<std::byte> bytes = file.read_part(0);
  return read_part_snapshot(bytes);
}

// By row of bodies: the rank whose messages have it.
std::vector<std::int32_t> read_owners(CheckpointFile& file, const WorldData& common) {
  const Bodies& bodies = common.bodies;
  const std::vector<std::byte> bytes = file.read_part(1);
  std::vector<std::int32_t> owners(bodies.flags.size());
  if (bytes.size() != owners.size() * sizeof(std::int32_t))
    file.refuse(file.begin[1], "the owners are not as many as the bodies");
  std::memcpy(owners.data(), bytes.data(), bytes.size());
  for (std::size_t row = 0; row < owners.size(); ++row) {
    const bool is_of_all = bodies.is_absent[row] == 0;
    if (is_of_all ? owners[row] != kEveryRank : owners[row] < 0 || owners[row] >= file.ranks()) {
      file.refuse(file.begin[1] + row * sizeof(std::int32_t), "the owner of body " + std::to_string(row) +
                                                                  " is rank " + std::to_string(owners[row]) +
                                                                  " of " + std::to_string(file.ranks()));
    }
  }
  return owners;
}

// Adds the name of the file to what says nothing of it.
template <class Work>
auto read_named(const std::string& file, Work&& work) {
  try {
    return work();
  } catch (const RefusedFile&) {
    throw;
  } catch (const Error& error) {  // as a rank refuses messages
    const bool is_told = error.code() != ErrorCode::invalid_value;
    throw Error(std::string(kCall) + ": " + file + ": " + error.what(),
                is_told ? error.code() : ErrorCode::corrupt_data);
  }
}

// Of this world's border, without what it says of the dead.
std::vector<std::int32_t> owners_of_dynamic(const WorldData& data) {
  std::vector<std::int32_t> owners = border_of(data)->owner;
  for (std::size_t row = 0; row < owners.size(); ++row) {
    if ((data.bodies.flags[row] & kBodyAlive) == 0) owners[row] = kEveryRank;
  }
  return owners;
}

template <class Row>
void append(std::span<const Row> rows, OwnParts& parts) {
  const std::span<const std::byte> bytes = std::as_bytes(rows);
  parts.bytes.insert(parts.bytes.end(), bytes.begin(), bytes.end());
  parts.lengths.push_back(bytes.size());
}

void append_snapshot(const Snapshot& snapshot, OwnParts& parts) {
  const std::size_t before = parts.bytes.size();
  detail::write_snapshot(
      snapshot,
      [](void* context, std::span<const std::byte> bytes, std::size_t) {
        auto& all = *static_cast<std::vector<std::byte>*>(context);
        all.insert(all.end(), bytes.begin(), bytes.end());
      },
      &parts.bytes);
  parts.lengths.push_back(parts.bytes.size() - before);
}

}  // namespace

OwnParts checkpoint_parts(World& world, Crew& crew) {
  const Border& border = *border_of(internals(world));
  const auto ranks = static_cast<std::size_t>(border.transport.ranks());
  OwnParts parts;
  if (border.here == 0) {
    Snapshot common;
    SnapshotAccess::data(common) = std::make_unique<SnapshotData>();
    save_common(world, *SnapshotAccess::data(common));
    parts.bytes.resize(head_bytes(has_parts(world) ? kCommonParts + ranks : 1));
    append_snapshot(common, parts);
    if (!has_parts(world)) return parts;
    append<std::int32_t>(owners_of_dynamic(internals(world)), parts);
  }
  append<std::byte>(messages_of_part(world, crew), parts);
  return parts;
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
  }
  target = tell_all(transport, target);
  problem = tell_all(transport, problem);
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

void write_parts(Transport& transport, const std::string& file, OwnParts own) {
  const std::string target = agree_on_target(transport, file), draft = target + ".draft";
  const bool is_first = transport.rank() == 0;
  std::vector<PartEntry> entries;
  std::size_t end = own.bytes.size();
  for (std::size_t i = own.lengths.size(); i-- > 0;) {
    const std::size_t begin = end - own.lengths[i];
    entries.insert(entries.begin(),
                   {own.lengths[i], hash_of_bytes(std::span(own.bytes).subspan(begin, own.lengths[i]))});
    end = begin;
  }
  const std::vector<std::uint64_t> all_bytes = gather_rows(transport, std::uint64_t{own.bytes.size()});
  const auto is_sound = [](const PartEntry&) { return true; };
  const std::vector<PartEntry> parts = gather_lists(transport, entries, is_sound);
  if (is_first) {
    const std::vector<std::byte> head = make_head(parts);
    std::copy(head.begin(), head.end(), own.bytes.begin());
  }
  const auto before = static_cast<std::size_t>(transport.rank());
  const std::uint64_t offset = std::accumulate(
      all_bytes.begin(), all_bytes.begin() + static_cast<std::ptrdiff_t>(before), std::uint64_t{0});
  const auto on_first = [&](auto&& work) {
    std::int64_t problem = is_first ? work() : 0;
    transport.add_up({&problem, 1});
    return static_cast<int>(problem);
  };
  if (const int problem = on_first([&] { return create_file(draft); }))
    throw Error(file + ": cannot be written: " + std::strerror(problem), ErrorCode::io_failure);
  try {
    const NoFileSignal guard;
    transport.write_together(draft, offset, own.bytes);
  } catch (...) {
    if (is_first) std::remove(draft.c_str());
    throw;
  }
  const int problem = on_first([&] { return put_in_place(draft, target); });
  if (problem == 0) return;
  if (is_first) std::remove(draft.c_str());
  throw Error(file + ": cannot be replaced: " + std::strerror(problem), ErrorCode::io_failure);
}

void write_checkpoint(const World& world, const std::string& file) {
  check_byte_order("write_checkpoint");
  check_whole(internals(world, "write_checkpoint"), "write_checkpoint");
  Snapshot snapshot;
  save(world, snapshot);
  OwnParts parts;
  parts.bytes.resize(head_bytes(1));
  append_snapshot(snapshot, parts);
  LocalRanks alone(1);
  write_parts(alone.at(0), file, std::move(parts));
}

namespace {

World read_whole(CheckpointFile& file) {
  const std::vector<std::byte> bytes = file.read_part(0);
  World world;
  restore(world, read_snapshot(bytes));
  return world;
}

}  // namespace

World read_checkpoint(const std::string& name) {
  check_byte_order(kCall);
  CheckpointFile file = open_checkpoint(name);
  return read_named(name, [&] {
    if (file.is_whole()) return read_whole(file);
    World world;
    restore(world, read_common(file));
    read_owners(file, internals(world));  // which must be sound
    restore(world, add_parts(std::exchange(world, World{}), file));
    return world;
  });
}

int checkpoint_ranks(const std::string& file) {
  check_byte_order(kCall);
  const CheckpointFile opened = open_checkpoint(file);
  return opened.is_whole() ? 1 : opened.ranks();
}

FileShare read_file_share(const std::string& name, Transport& transport, Crew& crew) {
  check_byte_order(kCall);
  CheckpointFile file = open_checkpoint(name);
  return read_named(name, [&] {
    if (file.is_whole()) return FileShare{read_whole(file), true, file.identity};
    World common;
    restore(common, read_common(file));
    const std::vector<std::int32_t> owners = read_owners(file, internals(common));
    return FileShare{read_share(std::move(common), file, owners, transport, crew), false, file.identity};
  });
}

}  // namespace scree
