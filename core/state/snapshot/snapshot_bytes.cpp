// Writing and reading the byte form of snapshots; see snapshot_bytes.h.
#define XXH_INLINE_ALL
#include <core/state/recording_format/value_bytes.h>
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/snapshot/snapshot_check.h>
#include <core/state/snapshot/snapshot_columns.h>
#include <core/state/snapshot/snapshot_hulls.h>
#include <core/state/snapshot/snapshot_meshes.h>
#include <core/state/snapshot/snapshot_refusal.h>
#include <core/world/check.h>
#include <core/world/fp_environment.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace scree {

namespace {

constexpr char kMagic[8] = {'S', 'C', 'R', 'E', 'E', 'S', 'N', 'P'};
constexpr std::size_t kSizeOffset = 24, kHashOffset = 32, kHeadBytes = 40;

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  const std::span<const std::byte> hashed = bytes.subspan(kHeadBytes);
  return XXH64(hashed.data(), hashed.size(), 0);
}

// Writes number of bytes and hash into the head of bytes that `rest` follows.
void seal(std::span<std::byte> begin, std::span<const std::byte> rest) {
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  XXH64_update(&state, begin.data() + kHeadBytes, begin.size() - kHeadBytes);
  if (!rest.empty()) XXH64_update(&state, rest.data(), rest.size());
  const std::uint64_t size = begin.size() + rest.size(), hash = XXH64_digest(&state);
  std::memcpy(begin.data() + kSizeOffset, &size, sizeof size);
  std::memcpy(begin.data() + kHashOffset, &hash, sizeof hash);
}

void read_head(ByteReader& reader, std::span<const std::byte> bytes) {
  if (std::memcmp(reader.take_bytes(sizeof kMagic), kMagic, sizeof kMagic) != 0) {
    refuse_bytes(0, "this is no snapshot");
  }
  std::size_t at = reader.at();
  if (const auto version = reader.take<std::uint32_t>(); version != kSnapshotVersion) {
    refuse_bytes(at,
                 "the snapshot has version " + std::to_string(version) + ", this is version " +
                     std::to_string(kSnapshotVersion),
                 ErrorCode::wrong_version);
  }
  at = reader.at();
  if (reader.take<std::uint32_t>() != kByteOrderMark) {
    refuse_bytes(at, "the bytes are not in little-endian order");
  }
  at = reader.at();
  if (reader.take<std::uint64_t>() != layout_of_columns()) {
    refuse_bytes(at, "a version of Scree with other columns has written this", ErrorCode::wrong_version);
  }
  at = reader.at();
  if (const auto size = reader.take<std::uint64_t>(); size != bytes.size()) {
    refuse_bytes(at, "the snapshot has " + std::to_string(size) + " bytes, but here are " +
                         std::to_string(bytes.size()));
  }
  at = reader.at();
  const auto hash = reader.take<std::uint64_t>();  // before there are bytes to hash
  if (hash != hash_of(bytes)) refuse_bytes(at, "the checksum is wrong");
}

}  // namespace

RefusedBytes::RefusedBytes(std::size_t wrong_byte, const std::string& why, ErrorCode code)
    : Error("read_snapshot: byte " + std::to_string(wrong_byte) + ": " + why, code),
      offset(wrong_byte),
      reason(why) {}

void refuse_bytes(std::size_t offset, const std::string& reason, ErrorCode code) {
  throw RefusedBytes(offset, reason, code);
}

void ByteWriter::put_bytes(const void* from, std::size_t count) {
  const auto* first = static_cast<const std::byte*>(from);
  bytes_.insert(bytes_.end(), first, first + count);
}

void check_byte_order(const char* call) {
  if constexpr (std::endian::native != std::endian::little) {
    throw Error(std::string(call) + ": snapshots are in little-endian order, but this machine is not",
                ErrorCode::not_supported);
  }
}

void write_world(const SavedWorld& world, ByteWriter& writer) { write_value(writer, world); }

void read_world(ByteReader& reader, SavedWorld& world) {
  const std::size_t at = reader.at();
  read_value(reader, world);
  try {
    constexpr Call call{"read_snapshot"};
    check_settings(call, world.settings);
    check_values(call, world);
  } catch (const Error& error) {
    refuse_bytes(at, error.what());
  }
}

void write_columns(const Column<std::byte>& columns, ByteWriter& writer) {
  writer.put(std::uint64_t{columns.size()});
  writer.put_bytes(columns.data(), columns.size());
}

void read_columns(ByteReader& reader, SnapshotData& snapshot) {
  const std::size_t at = reader.at();
  if (reader.take<std::uint64_t>() != reader.left()) {
    refuse_bytes(at, "the columns have more or fewer bytes than are left");
  }
  const std::size_t offset = reader.at(), count = reader.left();
  PackedColumns packed;
  packed.bytes.resize_for_overwrite(count);
  if (count > 0) std::memcpy(packed.bytes.data(), reader.take_bytes(count), count);
  const SavedColumns saved = check_columns(packed, snapshot, offset);
  snapshot.id = next_snapshot_id();
  begin_pages(snapshot, nullptr, 0);
  unpack_columns(packed, saved, snapshot.pages->sheets);
  finish_pages(snapshot);
}

void check_saved(const SnapshotData& snapshot) {
  const FpEnvironment environment;
  PackedColumns packed;
  pack_columns(snapshot.pages->sheets, packed.bytes);
  check_columns(packed, snapshot, 0);
}

std::uint64_t hash_of_state(const SavedWorld& world, const Column<std::byte>& columns) {
  ByteWriter writer;
  write_world(world, writer);
  XXH64_state_t state;
  XXH64_reset(&state, 0);
  XXH64_update(&state, writer.bytes().data(), writer.size());
  XXH64_update(&state, columns.data(), columns.size());
  return XXH64_digest(&state);
}

std::uint64_t hash_of_state(const SnapshotData& snapshot) {
  Column<std::byte> columns;
  pack_columns(snapshot.pages->sheets, columns);
  return hash_of_state(snapshot.world, columns);
}

void seal_snapshot(std::span<std::byte> bytes) { seal(bytes, {}); }

void detail::write_snapshot(const Snapshot& snapshot, const TakeBytes take, void* context) {
  constexpr const char* kName = "write_snapshot";
  const SnapshotData& data = filled(snapshot, kName);
  check_byte_order(kName);
  Column<std::byte> packed;
  pack_columns(data.pages->sheets, packed);
  ByteWriter writer;  // of all before the columns
  writer.put_bytes(kMagic, sizeof kMagic);
  writer.put(kSnapshotVersion);
  writer.put(kByteOrderMark);
  writer.put(layout_of_columns());
  writer.put(std::uint64_t{0});  // these two by seal
  writer.put(std::uint64_t{0});
  write_world(data.world, writer);
  write_hulls(data.hulls, writer);
  write_meshes(data.meshes, writer);
  writer.put(std::uint64_t{packed.size()});
  std::vector<std::byte> begin = writer.take();
  const std::span<const std::byte> columns = std::as_const(packed).span();
  seal(begin, columns);
  take(context, begin, begin.size() + columns.size());
  take(context, columns, begin.size() + columns.size());
}

namespace {

Snapshot read_snapshot(std::span<const std::byte> bytes, bool is_part) {
  check_byte_order("read_snapshot");
  const FpEnvironment environment;
  ByteReader reader(bytes);
  read_head(reader, bytes);
  Snapshot snapshot;
  SnapshotAccess::data(snapshot) = std::make_unique<SnapshotData>();
  SnapshotData& data = *SnapshotAccess::data(snapshot);
  data.is_part = is_part;
  read_world(reader, data.world);
  data.hulls = read_hulls(reader);
  data.meshes = read_meshes(reader);
  read_columns(reader, data);
  data.is_full = true;
  return snapshot;
}

}  // namespace

Snapshot read_snapshot(std::span<const std::byte> bytes) { return read_snapshot(bytes, false); }
Snapshot read_part_snapshot(std::span<const std::byte> bytes) { return read_snapshot(bytes, true); }

}  // namespace scree
