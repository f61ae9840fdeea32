// The byte form of a snapshot: numbers one behind the other in little-endian order, without gaps but before
// the columns' rows.
//
//   8 bytes  "SCREESNP"
//   u32      kSnapshotVersion
//   u32      kByteOrderMark
//   u64      layout_of_columns()
//   u64      number of all bytes
//   u64      xxHash64 of what follows
//   ...      settings and the like: for_each_field
//   ...      hulls: snapshot_hulls.h
//   u64      number of the bytes that follow, to the end: SnapshotData::columns
#pragma once

#include <core/snapshot.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace scree {

inline constexpr std::uint32_t kSnapshotVersion = 1;
inline constexpr std::uint32_t kByteOrderMark = 0x01020304;

// Throws Error "read_snapshot: byte <offset>: <reason>".
[[noreturn]] void refuse_snapshot(std::size_t offset, const std::string& reason);

// Writes number of bytes and hash into the head of bytes that are complete otherwise.
void seal_snapshot(std::span<std::byte> bytes);

class ByteWriter {
 public:
  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    put_bytes(&number, sizeof number);
  }
  void put_bytes(const void* from, std::size_t count) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + count);
    if (count > 0) std::memcpy(bytes_.data() + at, from, count);
  }
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// Refuses what ends too early.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

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
    if (left() < count) refuse_snapshot(bytes_.size(), "the snapshot ends too early");
    at_ += count;
    return bytes_.data() + at_ - count;
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

}  // namespace scree
