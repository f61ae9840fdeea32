// Writing and reading the byte form of snapshots; see snapshot_bytes.h.
#define XXH_INLINE_ALL
#include <core/check.h>
#include <core/fp_environment.h>
#include <core/snapshot_bytes.h>
#include <core/snapshot_check.h>
#include <core/snapshot_columns.h>
#include <core/snapshot_hulls.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>

namespace scree {

namespace {

constexpr char kMagic[8] = {'S', 'C', 'R', 'E', 'E', 'S', 'N', 'P'};
constexpr std::size_t kSizeOffset = 24, kHashOffset = 32, kHeadBytes = 40;

// Calls visit(value) for all that is in no column, in the order of the bytes.
template <class World, class Visit>
void for_each_field(World& world, Visit&& visit) {
  auto& settings = world.settings;
  static_assert(sizeof(WorldSettings) == 60, "a new setting goes here, too, and raises kSnapshotVersion");
  for (auto* axis : {&settings.gravity.x, &settings.gravity.y, &settings.gravity.z}) visit(*axis);
  visit(settings.substeps);
  visit(settings.contact_hertz);
  visit(settings.contact_damping_ratio);
  visit(settings.push_speed);
  visit(settings.restitution_threshold);
  visit(settings.max_linear_speed);
  visit(settings.max_angular_speed);
  visit(settings.continuous);
  visit(settings.warm_start);
  visit(settings.sleeping);
  visit(settings.sleep_linear_speed);
  visit(settings.sleep_angular_speed);
  visit(settings.sleep_time);
  visit(settings.contact_events);
  visit(settings.measure_residual);
  visit(settings.measure_penetration);
  visit(world.step_count);
  visit(world.last_dt);
  visit(world.last_substep);
  visit(world.wake_requested);
  visit(world.manifolds_stale);
  visit(world.pairs_stale);
}

template <class Value>
void write_field(ByteWriter& writer, const Value& value) {
  if constexpr (std::is_same_v<Value, bool> || std::is_enum_v<Value>) {
    writer.put(static_cast<std::uint8_t>(value));
  } else {
    writer.put(value);
  }
}

template <class Value>
void read_field(ByteReader& reader, Value& value) {
  const std::size_t at = reader.at();
  if constexpr (std::is_same_v<Value, bool>) {
    const auto byte = reader.take<std::uint8_t>();
    if (byte > 1) refuse_snapshot(at, "a yes or no is " + std::to_string(byte));
    value = byte == 1;
  } else if constexpr (std::is_enum_v<Value>) {
    value = static_cast<Value>(reader.take<std::uint8_t>());
  } else {
    value = reader.take<Value>();
  }
}

void check_byte_order(const char* call) {
  if constexpr (std::endian::native != std::endian::little) {
    throw Error(std::string(call) + ": snapshots are in little-endian order, but this machine is not");
  }
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  const std::span<const std::byte> hashed = bytes.subspan(kHeadBytes);
  return XXH64(hashed.data(), hashed.size(), 0);
}

void read_head(ByteReader& reader, std::span<const std::byte> bytes) {
  if (std::memcmp(reader.take_bytes(sizeof kMagic), kMagic, sizeof kMagic) != 0) {
    refuse_snapshot(0, "this is no snapshot");
  }
  std::size_t at = reader.at();
  if (const auto version = reader.take<std::uint32_t>(); version != kSnapshotVersion) {
    refuse_snapshot(at, "the snapshot has version " + std::to_string(version) + ", this is version " +
                            std::to_string(kSnapshotVersion));
  }
  at = reader.at();
  if (reader.take<std::uint32_t>() != kByteOrderMark) {
    refuse_snapshot(at, "the bytes are not in little-endian order");
  }
  at = reader.at();
  if (reader.take<std::uint64_t>() != layout_of_columns()) {
    refuse_snapshot(at, "a version of Scree with other columns has written this");
  }
  at = reader.at();
  if (const auto size = reader.take<std::uint64_t>(); size != bytes.size()) {
    refuse_snapshot(at, "the snapshot has " + std::to_string(size) + " bytes, but here are " +
                            std::to_string(bytes.size()));
  }
  at = reader.at();
  const auto hash = reader.take<std::uint64_t>();  // before there are bytes to hash
  if (hash != hash_of(bytes)) refuse_snapshot(at, "the checksum is wrong");
}

void read_world(ByteReader& reader, SavedWorld& world) {
  const std::size_t at = reader.at();
  for_each_field(world, [&reader](auto& value) { read_field(reader, value); });
  try {
    constexpr Call call{"read_snapshot"};
    check_settings(call, world.settings);
    check_range(call, "last time step", world.last_dt, 0.0f, 1.0f);
    check_range(call, "last substep", world.last_substep, 0.0f, 1.0f);
  } catch (const Error& error) {
    refuse_snapshot(at, error.what());
  }
}

}  // namespace

void refuse_snapshot(std::size_t offset, const std::string& reason) {
  throw Error("read_snapshot: byte " + std::to_string(offset) + ": " + reason);
}

void seal_snapshot(std::span<std::byte> bytes) {
  const std::uint64_t size = bytes.size(), hash = hash_of(bytes);
  std::memcpy(bytes.data() + kSizeOffset, &size, sizeof size);
  std::memcpy(bytes.data() + kHashOffset, &hash, sizeof hash);
}

std::vector<std::byte> write_snapshot(const Snapshot& snapshot) {
  constexpr const char* kName = "write_snapshot";
  const SnapshotData& data = filled(snapshot, kName);
  check_byte_order(kName);
  ByteWriter writer;
  writer.reserve(data.columns.size() + 4096);
  writer.put_bytes(kMagic, sizeof kMagic);
  writer.put(kSnapshotVersion);
  writer.put(kByteOrderMark);
  writer.put(layout_of_columns());
  writer.put(std::uint64_t{0});  // these two by seal_snapshot
  writer.put(std::uint64_t{0});
  for_each_field(data.world, [&writer](const auto& value) { write_field(writer, value); });
  write_hulls(data.hulls, writer);
  writer.put(std::uint64_t{data.columns.size()});
  writer.put_bytes(data.columns.data(), data.columns.size());
  std::vector<std::byte> bytes = writer.take();
  seal_snapshot(bytes);
  return bytes;
}

Snapshot read_snapshot(std::span<const std::byte> bytes) {
  check_byte_order("read_snapshot");
  const FpEnvironment environment;
  ByteReader reader(bytes);
  read_head(reader, bytes);
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  SnapshotData& data = *SnapshotAccess::data(snapshot);
  read_world(reader, data.world);
  data.hulls = read_hulls(reader);
  const std::size_t at = reader.at();
  if (reader.take<std::uint64_t>() != reader.left()) {
    refuse_snapshot(at, "the columns have more or fewer bytes than are left");
  }
  const std::size_t offset = reader.at();
  data.columns.resize_for_overwrite(reader.left());
  if (!data.columns.empty()) std::memcpy(data.columns.data(), bytes.data() + offset, data.columns.size());
  check_columns(data, offset);
  data.id = next_snapshot_id();
  data.is_full = true;
  return snapshot;
}

}  // namespace scree
