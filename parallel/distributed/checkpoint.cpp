// See checkpoint.h.
#include <core/geometry/balls.h>
#include <core/state/recording_format/recording_chunks.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/world/edit.h>
#include <fcntl.h>
#include <parallel/distributed/border.h>
#include <parallel/distributed/checkpoint.h>
#include <parallel/distributed/local_columns.h>
#include <parallel/distributed/messages.h>
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

// Of the columns that snapshots hold, and of those that travel in messages.
std::uint64_t layout_of_file() {
  const WorldData none;
  std::vector<std::uint64_t> layout{layout_of_columns()};
  const auto note = [&](const auto& column) { layout.push_back(sizeof *column.data()); };
  for_each_local_column(none.bodies, LocalColumns::travelling, note);
  for_each_local_column(none.shapes, LocalColumns::travelling, note);
  return hash_of_bytes(std::as_bytes(std::span(layout)));
}

// Keeps what is sent, whoever it is for.
class MessageWriter final : public Transport {
 public:
  MessageWriter(int rank, int ranks) : rank_(rank), ranks_(ranks) {}
  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  void send(int, std::span<const std::byte> message) override {
    bytes_.put(std::uint64_t{message.size()});
    bytes_.put_bytes(message.data(), message.size());
  }
  std::span<const std::byte> receive(int) override { throw Error("MessageWriter: there is nobody to hear"); }
  std::vector<std::byte> take() { return bytes_.take(); }

 private:
  int rank_, ranks_;
  ByteWriter bytes_;
};

// Says of which file it is.
struct RefusedFile : Error {
  using Error::Error;
};

// What a file holds.
struct CheckpointFile {
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
  std::vector<std::byte> part(std::size_t rank) {
    std::vector<std::byte> bytes = read(begin[rank], static_cast<std::size_t>(parts[rank].bytes));
    if (hash_of_bytes(bytes) != parts[rank].hash)
      refuse(begin[rank], "the checksum of the part of rank " + std::to_string(rank) + " is wrong");
    return bytes;
  }
};

std::uint64_t size_of(CheckpointFile& file) {
  file.stream.open(file.name, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.stream.is_open() ? std::streamoff{file.stream.tellg()} : -1;
  if (size >= 0) return static_cast<std::uint64_t>(size);
  throw Error(std::string(kCall) + ": " + file.name + ": cannot be opened", ErrorCode::io_failure);
}

CheckpointFile open_checkpoint(const std::string& name) {
  CheckpointFile file{name, {}, {}, {}};
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
  if (reader.take<std::uint64_t>() != layout_of_file())
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

// Plays the messages of a file's parts.
class MessageReader final : public Transport {
 public:
  explicit MessageReader(CheckpointFile& file) : file_(file) {}
  int rank() const override { return 0; }
  int ranks() const override { return static_cast<int>(file_.parts.size()); }
  void send(int, std::span<const std::byte>) override {
    throw Error("MessageReader: there is nobody to hear");
  }
  // One rank's messages after those of the rank before.
  std::span<const std::byte> receive(int from) override {
    if (from != from_) {
      check_end();
      part_ = file_.part(static_cast<std::size_t>(from));
      from_ = from;
      at_ = 0;
    }
    const auto place = [&] { return file_.begin[static_cast<std::size_t>(from)] + at_; };
    std::uint64_t bytes = 0;
    if (part_.size() - at_ < sizeof bytes) file_.refuse(place(), "the part of a rank ends too early");
    std::memcpy(&bytes, part_.data() + at_, sizeof bytes);
    if (bytes > part_.size() - at_ - sizeof bytes) file_.refuse(place(), "a message is longer than its part");
    const std::span<const std::byte> message =
        std::span(part_).subspan(at_ + sizeof bytes, static_cast<std::size_t>(bytes));
    at_ += sizeof bytes + message.size();
    return message;
  }
  // All messages of the part have been read.
  void check_end() const {
    if (at_ != part_.size())
      file_.refuse(file_.begin[static_cast<std::size_t>(from_)] + at_,
                   "more follows than the part should have");
  }

 private:
  CheckpointFile& file_;
  std::vector<std::byte> part_;
  std::size_t at_ = 0;
  int from_ = -1;
};

std::vector<std::byte> make_head(std::span<const PartEntry> parts) {
  ByteWriter head;
  head.put_bytes(kMagic, sizeof kMagic);
  head.put(kCheckpointVersion);
  head.put(kByteOrderMark);
  head.put(layout_of_file());
  head.put(std::uint64_t{parts.size()});
  for (const PartEntry& part : parts) {
    head.put(part.bytes);
    head.put(part.hash);
  }
  head.put(hash_of_bytes(head.bytes()));
  return head.take();
}

// Of the type that a shape has; hulls are those that they are.
Geometry plain_geometry(const WorldData& data, std::int32_t shape) {
  switch (data.shapes.type[shape]) {
    case ShapeType::sphere:
      return Sphere{};
    case ShapeType::capsule:
      return Capsule{};
    case ShapeType::cylinder:
      return Cylinder{};
    case ShapeType::cone:
      return Cone{};
    case ShapeType::box:
      return Box{};
    case ShapeType::rounded_box:
      return Box{.rounding = 0.1f};
    case ShapeType::hull:
    case ShapeType::rounded_hull:
    case ShapeType::mesh:
    case ShapeType::half_space:
      break;
  }
  return geometry_of(data, shape);
}

// A snapshot must be that of some world, in which all bodies are there. Those that are absent are plain ones
// until other ranks' parts are read.
void write_plain_body(Bodies& bodies, std::int32_t body) {
  zero_row(bodies, body, LocalColumns::all);
  bodies.pose[body].rotation[3] = 1.0f;
  bodies.transform[body] = {};
  const bool jointed = bodies.first_joint[body] >= 0;
  bodies.motion[body] = {0.0f, 0.0f, 1.0f, jointed ? std::uint32_t{kMotionJointed} : 0u};
  bodies.local_mass[body].inverse_mass = 1.0f;
  bodies.marks.mark(body);
}

void write_plain_shape(WorldData& data, std::int32_t shape) {
  Shapes& shapes = data.shapes;
  const Geometry geometry = plain_geometry(data, shape);
  zero_row(shapes, shape, LocalColumns::all);
  write_extent(data, shape, geometry, slots_of(shapes, shape));
  write_material(shapes, shape, Material{});
  shapes.given_pose[shape] = {};
  place_shape_in_body(data, shape);
  shapes.pose[shape].rotation[3] = 1.0f;
  shapes.tree[shape] = tree_of(data.bodies, shapes.body[shape]);
}

void show_absent_bodies(WorldData& data) {
  for (std::size_t row = kFirstBody; row < data.bodies.flags.size(); ++row) {
    const auto body = static_cast<std::int32_t>(row);
    if ((data.bodies.flags[row] & kBodyAlive) == 0 || !is_absent(data.bodies, body)) continue;
    write_plain_body(data.bodies, body);
    for (std::int32_t shape = data.bodies.first_shape[row]; shape >= 0; shape = data.shapes.next[shape])
      write_plain_shape(data, shape);
    measure_core(data, body);
  }
}

void hide_absent_bodies(WorldData& data, Border& border) {
  for (std::size_t row = 0; row < data.shapes.flags.size(); ++row) {
    if ((data.shapes.flags[row] & kShapeAlive) == 0 || !is_absent(data.bodies, data.shapes.body[row]))
      continue;
    data.shapes.tree[row] = TreeKind::none;
    data.shapes.marks.mark(static_cast<std::int32_t>(row));
  }
  border.gone = data.bodies.flags.size();  // the memory of plain ones
}

// The world with what its other ranks have sent, which is all of it then.
void add_parts(World& world, CheckpointFile& file) {
  WorldData& data = internals(world);
  MessageReader messages(file);
  Workers workers(1);
  Crew crew(workers);
  divide_world(data, messages, std::vector<std::int32_t>(data.bodies.flags.size(), 0));
  receive_all_bodies(data, messages, crew);
  messages.check_end();
  data.border.reset();
}

}  // namespace

std::vector<std::byte> checkpoint_part(World& world, Crew& crew) {
  WorldData& data = internals(world);
  Border* const border = border_of(data);
  if (border != nullptr && border->here != 0) {
    MessageWriter messages(border->here, border->transport.ranks());
    send_all_bodies(data, messages, crew);
    return messages.take();
  }
  PartOwner part = std::move(data.border);  // else save() refuses it
  Snapshot snapshot;
  std::exception_ptr problem;
  try {
    if (border != nullptr) show_absent_bodies(data);
    save(world, snapshot);
  } catch (...) {
    problem = std::current_exception();
  }
  if (border != nullptr) hide_absent_bodies(data, *border);
  data.border = std::move(part);
  if (problem != nullptr) std::rethrow_exception(problem);
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
  try {
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
  std::int64_t problem = transport.rank() == 0 ? put_in_place(draft, target) : 0;
  transport.add_up({&problem, 1});
  if (problem == 0) return;
  if (transport.rank() == 0) std::remove(draft.c_str());
  throw Error(file + ": cannot be replaced: " + std::strerror(static_cast<int>(problem)),
              ErrorCode::io_failure);
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
    restore(world, read_snapshot(parts.part(0)));
    if (parts.parts.size() == 1) return world;
    add_parts(world, parts);
    Snapshot snapshot;
    save(world, snapshot);
    const auto checked = read_snapshot(write_snapshot(snapshot));  // what ranks have sent was not, so far
    restore(world, checked);
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
