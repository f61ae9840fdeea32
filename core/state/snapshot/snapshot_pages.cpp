// Pages of saved rows; see snapshot_pages.h.
#include <core/state/snapshot/snapshot_pages.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>

namespace scree {

namespace {

// Pages whose content changes in size now and then, as they do where all rows become equal, keep their place.
constexpr std::size_t kCapacityStep = 16;

PageOwner make_page(std::size_t bytes) {
  const std::size_t capacity = (bytes + kCapacityStep - 1) / kCapacityStep * kCapacityStep;
  auto* page = new (::operator new(sizeof(SavedPage) + capacity)) SavedPage;
  page->capacity = static_cast<std::uint32_t>(capacity);
  return PageOwner(page);
}

// Small worlds have a page of most sheets, large ones hardly more groups than they need.
GroupOwner make_group(std::size_t pages) {
  const std::size_t capacity = std::min(std::bit_ceil(pages), PageGroup::kMost);
  auto* group = new (::operator new(sizeof(PageGroup) + capacity * sizeof(PageOwner))) PageGroup;
  group->capacity = static_cast<std::uint32_t>(capacity);
  for (std::size_t page = 0; page < capacity; ++page) new (group->pages() + page) PageOwner;
  return GroupOwner(group);
}

std::uint64_t bytes_of(const SavedPage* page) {
  return page != nullptr ? sizeof(SavedPage) + page->capacity : 0;
}

}  // namespace

static_assert(sizeof(PageOwner) == sizeof(void*));
static_assert(sizeof(PageGroup) % alignof(PageOwner) == 0);

bool SavedPage::holds(const PageContent& what, const std::byte* bytes) const {
  return content == what && std::memcmp(data(), bytes, what.bytes) == 0;
}

void SavedPage::destroy() noexcept {
  this->~SavedPage();
  ::operator delete(this);
}

void PageGroup::destroy() noexcept {
  for (std::size_t page = 0; page < capacity; ++page) pages()[page].~PageOwner();
  this->~PageGroup();
  ::operator delete(this);
}

std::size_t Sheet::bytes() const {
  std::size_t sum = groups.size() * sizeof(GroupOwner);
  for (const GroupOwner& group : groups) {
    sum += sizeof(PageGroup) + group->capacity * sizeof(PageOwner) + static_cast<std::size_t>(group->bytes);
  }
  return sum;
}

void PagePacker::pack(std::span<const PageSource> columns, std::uint64_t present, bool is_dense) {
  const int count = std::popcount(present);
  const bool is_run = is_dense || present == rows_mask(static_cast<std::size_t>(count));
  std::byte* out = bytes_.data();
  content_.present = present;
  content_.equal = 0;
  if (count == 0) columns = {};
  std::uint32_t bit = 1;
  for (const PageSource& column : columns) {
    const std::size_t row_bytes = column.row_bytes, all = static_cast<std::size_t>(count) * row_bytes;
    const std::byte* rows = column.first;
    if (!is_run) {
      std::byte* to = out;
      for (std::uint64_t left = present; left != 0; left &= left - 1, to += row_bytes) {
        std::memcpy(to, rows + static_cast<std::size_t>(std::countr_zero(left)) * row_bytes, row_bytes);
      }
      rows = out;
    }
    const bool equal = std::memcmp(rows, rows + row_bytes, all - row_bytes) == 0;
    if (equal) content_.equal |= bit;
    const std::size_t bytes = equal ? row_bytes : all;
    if (rows != out) std::memcpy(out, rows, bytes);
    out += bytes;
    bit <<= 1;
  }
  content_.bytes = static_cast<std::uint32_t>(out - bytes_.data());
}

SheetEditor::SheetEditor(Sheet& sheet, Sheet& used, std::size_t rows)
    : sheet_(sheet), used_(used), base_pages_(pages_of(sheet.rows)), pages_(pages_of(rows)) {
  sheet.groups.resize((pages_ + PageGroup::kMost - 1) / PageGroup::kMost);
  sheet.rows = rows;
}

bool SheetEditor::must_open(std::size_t group) const {
  return pages_ < base_pages_ && group + 1 == sheet_.groups.size() && pages_ % PageGroup::kMost != 0;
}

void SheetEditor::open(std::size_t group) {
  const std::size_t count = std::min(PageGroup::kMost, pages_ - group * PageGroup::kMost);
  group_ = group;
  GroupOwner& mine = sheet_.groups[group];
  if (mine.is_sole() && mine->capacity >= count) {
    next_ = std::move(mine);
    return;
  }
  before_ = std::move(mine);
  const bool is_there = group < used_.groups.size() && used_.groups[group].is_sole();
  next_ =
      is_there && used_.groups[group]->capacity >= count ? std::move(used_.groups[group]) : make_group(count);
  next_->bytes = before_ ? before_->bytes : 0;
}

const SavedPage* SheetEditor::base_of(std::size_t page) const {
  if (page >= base_pages_) return nullptr;
  return (before_ ? *before_ : *next_).pages()[page % PageGroup::kMost].get();
}

void SheetEditor::keep(std::size_t page) {
  if (before_) place_of(page) = before_->pages()[page % PageGroup::kMost];
}

void SheetEditor::replace(std::size_t page, const PageContent& content, const std::byte* bytes) {
  const SavedPage* base = base_of(page);
  if (base != nullptr && base->holds(content, bytes)) return keep(page);
  next_->bytes -= bytes_of(base);
  PageOwner& place = place_of(page);
  if (!place.is_sole() || place->capacity < content.bytes) place = make_page(content.bytes);
  place->content = content;
  std::memcpy(place->data(), bytes, content.bytes);
  next_->bytes += bytes_of(place.get());
}

void SheetEditor::replace(std::size_t page, const PageOwner& with) {
  next_->bytes -= bytes_of(base_of(page));
  place_of(page) = with;
  next_->bytes += bytes_of(with.get());
}

void SheetEditor::close() {
  const std::size_t first = group_ * PageGroup::kMost;
  const std::size_t count = std::min(PageGroup::kMost, pages_ - first);
  for (std::size_t page = count; page < PageGroup::kMost; ++page) {
    next_->bytes -= bytes_of(base_of(first + page));
    if (page < next_->capacity) place_of(page) = PageOwner();
  }
  before_ = GroupOwner();
  sheet_.groups[group_] = std::move(next_);
}

}  // namespace scree
