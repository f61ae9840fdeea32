// What differs between two snapshots: the pages of the later one that are not those of the base.
//
// Pages that the two share are not looked into, nor are groups of them: of two snapshots of one world that is
// all that has not changed. Where they share nothing, as with snapshots that were read, pages of equal
// bytes are the same, too.
#include <core/state/snapshot/snapshot.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace scree {

namespace {

bool are_equal(const SavedPage& a, const SavedPage& b) { return &a == &b || a.holds(b.content, b.data()); }

void keep_pages(SheetId id, const Sheet& base, const Sheet& later, SnapshotChangesData& to) {
  const std::size_t pages = pages_of(later.rows), base_pages = pages_of(base.rows);
  for (std::size_t page = 0; page < pages; ++page) {
    if (page % PageGroup::kMost == 0) {
      const std::size_t group = page / PageGroup::kMost;
      if (group < base.groups.size() && base.groups[group].get() == later.groups[group].get()) {
        page += PageGroup::kMost - 1;
        continue;
      }
    }
    const PageOwner& now = later.page(page);
    if (page < base_pages && are_equal(*base.page(page), *now)) continue;
    to.pages.push_back({id, static_cast<std::uint32_t>(page), now});
    to.page_bytes += sizeof *now + now->capacity;
  }
}

// Gives the sheet, which is the base's, the pages [kept, end) of the changes. Returns the end.
const KeptPage* put_pages(const KeptPage* kept, const KeptPage* end, SheetId id, std::size_t rows,
                          Sheet& sheet, Sheet& used) {
  SheetEditor editor(sheet, used, rows);
  const auto is_of = [&](std::size_t last) {
    return kept != end && kept->sheet == id && kept->number < last;
  };
  for (std::size_t group = 0; group < sheet.groups.size(); ++group) {
    const std::size_t first = group * PageGroup::kMost;
    const std::size_t last = std::min(first + PageGroup::kMost, editor.pages());
    if (!is_of(last) && !editor.must_open(group)) continue;
    editor.open(group);
    for (std::size_t page = first; page < last; ++page) {
      if (is_of(page + 1)) {
        editor.replace(page, kept->page);
        ++kept;
      } else {
        editor.keep(page);
      }
    }
    editor.close();
  }
  return kept;
}

}  // namespace

SnapshotChanges::SnapshotChanges() noexcept = default;
SnapshotChanges::~SnapshotChanges() = default;
SnapshotChanges::SnapshotChanges(SnapshotChanges&&) noexcept = default;
SnapshotChanges& SnapshotChanges::operator=(SnapshotChanges&&) noexcept = default;

bool SnapshotChanges::is_empty() const noexcept { return data_ == nullptr || !data_->is_full; }

std::size_t SnapshotChanges::bytes() const noexcept {
  if (is_empty()) return 0;
  return sizeof *data_ + data_->pages.size() * sizeof(KeptPage) + data_->page_bytes + bytes_of_slots(*data_);
}

void keep_changes(const Snapshot& base, const Snapshot& later, SnapshotChanges& changes) {
  constexpr const char* kName = "keep_changes";
  const SnapshotData &from = filled(base, kName), &data = filled(later, kName);
  std::unique_ptr<SnapshotChangesData>& to = SnapshotAccess::data(changes);
  if (to == nullptr) to = std::make_unique<SnapshotChangesData>();
  to->is_full = false;
  to->base = from.id;
  to->handle_tag = data.handle_tag;
  to->world = data.world;
  copy_slots(data.hulls, data.meshes, *to);
  to->pages.clear();
  to->page_bytes = 0;
  for (std::size_t i = 0; i < kSheetCount; ++i) {
    to->rows[i] = data.pages->sheets.sheet[i].rows;
    keep_pages(static_cast<SheetId>(i), from.pages->sheets.sheet[i], data.pages->sheets.sheet[i], *to);
  }
  to->is_full = true;
}

void apply_changes(const Snapshot& base, const SnapshotChanges& changes, Snapshot& later) {
  constexpr const char* kName = "apply_changes";
  const SnapshotData& from = filled(base, kName);
  if (changes.is_empty()) {
    throw Error(std::string(kName) + ": the changes are empty", ErrorCode::wrong_state);
  }
  const SnapshotChangesData& data = *SnapshotAccess::data(changes);
  if (data.base != from.id) {
    throw Error(std::string(kName) + ": the changes were made with another snapshot than the base is now",
                ErrorCode::wrong_state);
  }
  std::unique_ptr<SnapshotData>& to = SnapshotAccess::data(later);
  if (to.get() == &from) throw Error(std::string(kName) + ": the base cannot be the later snapshot, too");
  if (to == nullptr) to = std::make_unique<SnapshotData>();
  to->is_full = false;
  to->handle_tag = data.handle_tag;
  to->world = data.world;
  try {
    copy_slots(data.hulls, data.meshes, *to);
    to->id = next_snapshot_id();
    begin_pages(*to, from.pages, from.id);
    const KeptPage *kept = data.pages.data(), *const end = kept + data.pages.size();
    for (std::size_t i = 0; i < kSheetCount; ++i) {
      kept = put_pages(kept, end, static_cast<SheetId>(i), data.rows[i], to->pages->sheets.sheet[i],
                       to->used.sheet[i]);
    }
    finish_pages(*to);
  } catch (...) {
    drop_pages(*to);
    throw;
  }
  to->is_full = true;
}

}  // namespace scree
