// Column: one growing array of rows, aligned for wide loads.
#pragma once

#include <core/plain/assert.h>
#include <core/world/column_memory.h>

#include <concepts>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace scree {

// What a column means for snapshots and hashes.
enum class ColumnKind {
  state,    // changes future results
  derived,  // can be recomputed exactly from state
  scratch,  // lives within one step
};

// A vector of trivially copyable rows on 64-byte lines. New rows are zero bytes. The allocation ends at least
// kPaddingBytes after the last row, so that wide loads may run past it. Shrinking keeps the memory.
//
// A large column lies in pages of its own, where unwritten rows take no memory and growing copies nothing.
// Rows beyond size() must not be written to: the column relies on their being zero.
template <class Row>
class Column {
  static_assert(std::is_trivially_copyable_v<Row>);

 public:
  static constexpr std::size_t kAlignment = 64;
  static constexpr std::size_t kPaddingBytes = 64;

  Column() = default;
  Column(const Column&) = delete;
  Column& operator=(const Column&) = delete;
  Column(Column&& other) noexcept { swap(other); }
  Column& operator=(Column&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Column() { release(); }

  void swap(Column& other) noexcept {
    std::swap(rows_, other.rows_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    std::swap(written_, other.written_);
    std::swap(room_, other.room_);
  }

  Row* data() { return rows_; }
  const Row* data() const { return rows_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t capacity_bytes() const { return capacity_ * sizeof(Row); }
  // Rows are numbered by any integers; a negative number is out of bounds.
  Row& operator[](std::integral auto row) { return rows_[checked(row)]; }
  const Row& operator[](std::integral auto row) const { return rows_[checked(row)]; }
  Row* begin() { return rows_; }
  Row* end() { return rows_ + size_; }
  const Row* begin() const { return rows_; }
  const Row* end() const { return rows_ + size_; }
  Row& back() {
    SCREE_ASSERT(size_ > 0);
    return rows_[size_ - 1];
  }
  std::span<Row> span() { return {rows_, size_}; }
  std::span<const Row> span() const { return {rows_, size_}; }

  void push_back(const Row& row) {
    const Row copy = row;
    if (size_ == capacity_) reserve_for(size_ + 1);
    rows_[size_++] = copy;
    if (written_ < size_) written_ = size_;
  }
  void append(std::span<const Row> rows) {  // of another column
    SCREE_ASSERT(rows.empty() || std::less<>()(rows.data(), rows_) ||
                 std::greater_equal<>()(rows.data(), rows_ + capacity_));
    const std::size_t old = size_;
    resize_rows_for_overwrite(old + rows.size());
    if (!rows.empty()) std::memcpy(static_cast<void*>(rows_ + old), rows.data(), rows.size_bytes());
  }
  void pop_back() { drop_back(1); }
  void clear() { size_ = 0; }
  void drop_back(std::integral auto count) { drop_rows(checked_size(count)); }

  // Sizes are any integers, too; debug builds refuse negative ones.

  // Makes sure that pushing and resizing up to `size` rows cannot fail.
  void reserve(std::integral auto size) { reserve_rows(checked_size(size)); }
  // Keeps the common rows; new ones are zero bytes.
  void resize(std::integral auto size) { resize_rows(checked_size(size)); }
  // Keeps the common rows; new ones are indeterminate.
  void resize_for_overwrite(std::integral auto size) { resize_rows_for_overwrite(checked_size(size)); }
  // Sets rows [first, end) to zero. Pages that hold nothing else go back to the system.
  void zero(std::integral auto first, std::integral auto end) {
    zero_rows(checked_size(first), checked_size(end));
  }
  // For scratch that is wholly written before it is read: contents are indeterminate afterwards. The old
  // memory goes before the new comes, so that a step's peak does not hold both.
  void resize_discarding(std::integral auto size) { resize_rows_discarding(checked_size(size)); }

 private:
  // Large columns grow by less: what they have is copied seldom, but where it is, the copy lies beside it.
  static constexpr std::size_t kLargeBytes = std::size_t{1} << 22;
  static constexpr std::size_t kPagedBytes = std::size_t{1} << 18;
  static constexpr std::size_t kPageBytes = 4096;
  // Packed bytes come and go with snapshots and are written to as a whole: new pages would only be dear.
  static constexpr bool kMayBePaged = !std::is_same_v<Row, std::byte>;
  static constexpr std::size_t kRoom = 4;  // times their memory, columns in pages have addresses to grow into

  std::size_t checked(std::integral auto row) const {
    const std::size_t index = static_cast<std::size_t>(row);
    SCREE_ASSERT(index < size_);
    return index;
  }
  static std::size_t checked_size(std::integral auto size) {
    SCREE_ASSERT(std::in_range<std::size_t>(size));
    return static_cast<std::size_t>(size);
  }

  void drop_rows(std::size_t count) {
    SCREE_ASSERT(count <= size_);
    size_ -= count;
  }

  void zero_rows(std::size_t first, std::size_t end) {
    SCREE_ASSERT(first <= end && end <= size_);
    std::size_t begin_byte = first * sizeof(Row), end_byte = end * sizeof(Row);
    auto* const bytes = reinterpret_cast<char*>(rows_);
    const std::size_t first_page = (begin_byte + kPageBytes - 1) / kPageBytes * kPageBytes;
    const std::size_t end_page = end_byte / kPageBytes * kPageBytes;
    if (room_ > 0 && first_page < end_page &&
        drop_pages(reinterpret_cast<std::byte*>(bytes) + first_page, end_page - first_page)) {
      std::memset(bytes + begin_byte, 0, first_page - begin_byte);
      begin_byte = end_page;
    }
    if (begin_byte < end_byte) std::memset(bytes + begin_byte, 0, end_byte - begin_byte);
  }

  void reserve_rows(std::size_t size) {
    if (size > capacity_) reserve_for(size);
  }

  void resize_rows(std::size_t size) {
    const std::size_t old = size_;
    if (size > capacity_) reserve_for(size);
    const std::size_t last = size < written_ ? size : written_;  // the rest is zero
    if (last > old) std::memset(static_cast<void*>(rows_ + old), 0, (last - old) * sizeof(Row));
    size_ = size;
    // They count as written from here on, so that shrinking and growing zeroes them again.
    if (written_ < size_) written_ = size_;
  }

  void resize_rows_for_overwrite(std::size_t size) {
    if (size > capacity_) reserve_for(size);
    size_ = size;
    if (written_ < size_) written_ = size_;
  }

  void resize_rows_discarding(std::size_t size) {
    if (size > capacity_) {
      const std::size_t grown = grown_capacity(size);
      if (allocation_of(grown, kPageBytes) <= room_) {  // pages of its own that it has touched cost nothing
        capacity_ = grown;
      } else {
        release();
        allocate(grown);
      }
    }
    size_ = size;
    if (written_ < size_) written_ = size_;
  }

  std::size_t grown_capacity(std::size_t size) const {
    const std::size_t more = capacity_bytes() < kLargeBytes ? capacity_ / 2 : capacity_ / 8;
    return size > capacity_ + more ? size : capacity_ + more;
  }

  static std::size_t allocation_of(std::size_t capacity, std::size_t unit) {
    return (capacity * sizeof(Row) + kPaddingBytes + unit - 1) / unit * unit;
  }

  // Of a column that has no memory.
  void allocate(std::size_t capacity) {
    if (kMayBePaged && capacity * sizeof(Row) >= kPagedBytes && has_page_memory()) {
      const std::size_t bytes = allocation_of(capacity, kPageBytes);
      std::size_t room = kRoom * bytes;
      rows_ = reinterpret_cast<Row*>(take_pages(bytes, room));
      room_ = room;
      written_ = 0;
    } else {
      const std::size_t bytes = allocation_of(capacity, kAlignment);
      void* memory = std::aligned_alloc(kAlignment, bytes);
      if (memory == nullptr) throw std::bad_alloc();
      const std::size_t rows = capacity * sizeof(Row);
      std::memset(static_cast<char*>(memory) + rows, 0, bytes - rows);
      rows_ = static_cast<Row*>(memory);
      written_ = capacity;
    }
    capacity_ = capacity;
  }

  void release() noexcept {
    if (room_ > 0) {
      free_pages(reinterpret_cast<std::byte*>(rows_), room_);
    } else {
      std::free(rows_);
    }
    rows_ = nullptr;
    size_ = capacity_ = written_ = room_ = 0;
  }

  void reserve_for(std::size_t size) {
    const std::size_t grown = grown_capacity(size);
    if (room_ == 0) {
      Column larger;
      larger.allocate(grown);
      if (size_ > 0)
        std::memcpy(static_cast<void*>(larger.rows_), static_cast<const void*>(rows_), size_ * sizeof(Row));
      larger.size_ = size_;
      if (larger.written_ < size_) larger.written_ = size_;
      swap(larger);
      return;
    }
    const std::size_t bytes = allocation_of(grown, kPageBytes);
    if (bytes > room_) {
      std::size_t room = kRoom * bytes;
      rows_ = reinterpret_cast<Row*>(grow_pages(reinterpret_cast<std::byte*>(rows_), room_, bytes, room));
      room_ = room;
    }
    capacity_ = grown;
  }

  Row* rows_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  std::size_t written_ = 0;  // rows behind these are zero
  std::size_t room_ = 0;     // bytes of addresses, of a column in pages
};

}  // namespace scree
