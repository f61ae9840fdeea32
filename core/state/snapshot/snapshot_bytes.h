// The byte form of a snapshot: numbers one behind the other in little-endian order, without gaps but before
// the columns' rows.
//
//   8 bytes  "SCREESNP"
//   u32      kSnapshotVersion
//   u32      kByteOrderMark
//   u64      layout_of_columns()
//   u64      number of all bytes
//   u64      xxHash64 of what follows
//   ...      settings and the like: the fields of SavedWorld, see value_bytes.h
//   ...      hulls: snapshot_hulls.h
//   ...      meshes: snapshot_meshes.h
//   u64      number of the bytes that follow, to the end: snapshot_columns.h
#pragma once

#include <core/state/snapshot/snapshot.h>
#include <scree/error.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace scree {

inline constexpr std::uint32_t kSnapshotVersion = 7;
inline constexpr std::uint32_t kByteOrderMark = 0x01020304;

// What is wrong with bytes from outside, and where: "read_snapshot: byte <offset>: <reason>".
struct RefusedBytes : Error {
  RefusedBytes(std::size_t wrong_byte, const std::string& why, ErrorCode code);
  std::size_t offset;
  std::string reason;
};
[[noreturn]] void refuse_bytes(std::size_t offset, const std::string& reason,
                               ErrorCode code = ErrorCode::corrupt_data);

void check_byte_order(const char* call);  // throws Error unless this machine is little-endian

// Writes number of bytes and hash into the head of bytes that are complete otherwise.
void seal_snapshot(std::span<std::byte> bytes);

class ByteWriter {
 public:
  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    put_bytes(&number, sizeof number);
  }
  // Not inlined: GCC 12 takes what grows there for an overflow.
  [[gnu::noinline]] void put_bytes(const void* from, std::size_t count);
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  void shrink(std::size_t bytes) { bytes_.resize(bytes); }  // forgets what was written since
  std::size_t size() const { return bytes_.size(); }
  std::span<const std::byte> bytes() const { return bytes_; }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// Refuses what ends too early.
class ByteReader {
 public:
  // `what` they are, for the message.
  explicit ByteReader(std::span<const std::byte> bytes, const char* what = "the snapshot")
      : bytes_(bytes), what_(what) {}

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  template <class Number>
  Number take() {
    static_assert(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>);
    Number number;
    std::memcpy(&number, take_bytes(sizeof number), sizeof number);
    return number;
  }
  const std::byte* take_bytes(std::size_t count) {
    if (left() < count) refuse_bytes(bytes_.size(), std::string(what_) + " ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

 private:
  std::span<const std::byte> bytes_;
  const char* what_;
  std::size_t at_ = 0;
};

// The parts of the byte form: what is in no column, and the columns. The reader checks them; the columns end
// with its bytes, and the snapshot's hulls and is_part must be there already.
void write_world(const SavedWorld& world, ByteWriter& writer);
void read_world(ByteReader& reader, SavedWorld& world);
void write_columns(const Column<std::byte>& columns, ByteWriter& writer);
void read_columns(ByteReader& reader, SnapshotData& snapshot);
// As read_snapshot, of a part of a world: SnapshotData::is_part.
Snapshot read_part_snapshot(std::span<const std::byte> bytes);
// Checks what was saved as if it had been read: throws RefusedBytes, with offsets from where the columns
// begin.
void check_saved(const SnapshotData& snapshot);

// Equal for equal states: xxHash64 of the two parts. With the columns at hand they need not be packed.
std::uint64_t hash_of_state(const SavedWorld& world, const Column<std::byte>& columns);
std::uint64_t hash_of_state(const SnapshotData& snapshot);

}  // namespace scree
