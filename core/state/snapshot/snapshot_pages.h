// Pages of saved rows, which all snapshots that hold the same rows share.
//
// A page holds kPageRows rows of a sheet, which is some columns of a store: of each column one row if all are
// equal, else all. It is never written to while it has more than one owner. Groups of pages are shared in the
// same way, so that copying a sheet costs by its groups. Owners are counted atomically: snapshots of one
// world may live and die on different threads.
#pragma once

#include <core/state/snapshot/change_marks.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace scree {

// Owns a T with others. T has `owners`, which begins at 1, and destroy().
template <class T>
class Shared {
 public:
  Shared() noexcept = default;
  explicit Shared(T* made) noexcept : it_(made) {}
  Shared(const Shared& other) noexcept : it_(other.it_) {
    if (it_ != nullptr) it_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  Shared(Shared&& other) noexcept : it_(std::exchange(other.it_, nullptr)) {}
  Shared& operator=(const Shared& other) noexcept {
    if (it_ != other.it_) Shared(other).swap(*this);
    return *this;
  }
  Shared& operator=(Shared&& other) noexcept {
    Shared(std::move(other)).swap(*this);
    return *this;
  }
  ~Shared() {
    if (it_ != nullptr && it_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) it_->destroy();
  }
  void swap(Shared& other) noexcept { std::swap(it_, other.it_); }

  T* get() const { return it_; }
  T* operator->() const { return it_; }
  T& operator*() const { return *it_; }
  explicit operator bool() const { return it_ != nullptr; }
  // No other owner can appear then: only owners hand it on.
  bool is_sole() const { return it_ != nullptr && it_->owners.load(std::memory_order_acquire) == 1; }

 private:
  T* it_ = nullptr;
};

// What is in a page, without its bytes.
struct PageContent {
  std::uint64_t present = 0;  // a bit for each row, 0: a free row, which is not saved
  std::uint32_t equal = 0;    // a bit for each column, 1: all of its rows are equal
  std::uint32_t bytes = 0;    // columns one behind the other, each one row or all that are present

  friend bool operator==(const PageContent&, const PageContent&) = default;
};

// Its bytes follow it.
struct SavedPage {
  std::atomic<std::uint32_t> owners{1};
  std::uint32_t capacity = 0;  // bytes
  PageContent content;

  std::byte* data() { return reinterpret_cast<std::byte*>(this + 1); }
  const std::byte* data() const { return reinterpret_cast<const std::byte*>(this + 1); }
  bool holds(const PageContent& what, const std::byte* bytes) const;
  void destroy() noexcept;
};
using PageOwner = Shared<SavedPage>;

// Its pages follow it; those behind the sheet's last one are null.
struct PageGroup {
  static constexpr std::size_t kMost = 128;

  std::atomic<std::uint32_t> owners{1};
  std::uint32_t capacity = 0;  // pages
  std::uint64_t bytes = 0;     // of all pages

  PageOwner* pages() { return reinterpret_cast<PageOwner*>(this + 1); }
  const PageOwner* pages() const { return reinterpret_cast<const PageOwner*>(this + 1); }
  void destroy() noexcept;
};
using GroupOwner = Shared<PageGroup>;

// Rows [0, rows) of some columns.
struct Sheet {
  std::vector<GroupOwner> groups;
  std::size_t rows = 0;

  const PageOwner& page(std::size_t number) const {
    return groups[number / PageGroup::kMost]->pages()[number % PageGroup::kMost];
  }
  std::size_t bytes() const;  // of memory, as if it were not shared
  void clear() noexcept {
    groups.clear();
    rows = 0;
  }
};

// A column's part of a page.
struct PageColumn {
  const std::byte* bytes;
  bool is_equal;  // one row stands for all
};

// Rows that a page is made of: `first` points to the first one's, `row_bytes` apart.
struct PageSource {
  const std::byte* first;
  std::size_t row_bytes;
};

// Makes one page after the other in a place of its own.
class PagePacker {
 public:
  // Sheets have at most so many bytes a row.
  static constexpr std::size_t kMostRowBytes = 512;

  // Free rows may lie between those that are present, unless the caller says that there are none.
  void pack(std::span<const PageSource> columns, std::uint64_t present, bool is_dense = false);
  const PageContent& content() const { return content_; }
  const std::byte* bytes() const { return bytes_.data(); }

 private:
  PageContent content_;
  alignas(64) std::array<std::byte, kPageRows * kMostRowBytes> bytes_;
};

// Gives a sheet that is a copy of its base other pages, group by group; groups that are not opened stay. What
// no other owner has of a sheet that is done with is used again, page by page at the same places. Throws
// std::bad_alloc; the sheet is of no use then.
class SheetEditor {
 public:
  SheetEditor(Sheet& sheet, Sheet& used, std::size_t rows);

  std::size_t pages() const { return pages_; }
  // Pages from here on are not in the base.
  std::size_t base_pages() const { return base_pages_; }
  // Whether the group has other pages behind its last one than the base.
  bool must_open(std::size_t group) const;
  void open(std::size_t group);
  // For every page of the open group one of these.
  void keep(std::size_t page);
  void replace(std::size_t page, const PageContent& content, const std::byte* bytes);
  void replace(std::size_t page, const PageOwner& with);
  void close();

 private:
  PageOwner& place_of(std::size_t page) { return next_->pages()[page % PageGroup::kMost]; }
  const SavedPage* base_of(std::size_t page) const;

  Sheet& sheet_;
  Sheet& used_;
  std::size_t base_pages_, pages_;
  std::size_t group_ = 0;
  GroupOwner before_;  // null where the group is edited in place
  GroupOwner next_;
};

// The low bits of as many rows.
constexpr std::uint64_t rows_mask(std::size_t rows) {
  return rows >= kPageRows ? ~std::uint64_t{0} : (std::uint64_t{1} << rows) - 1;
}

}  // namespace scree
