// What differs between two snapshots: of each column the pages that are not the same bytes.
//
// A column is compared in its packed form, at equal places. While nobody is created or destroyed these hold
// the same rows; where a column packs otherwise than before, more is kept than need be. Of each column there
// are the numbers of its rows and its bytes, a byte for each page, 1 where it is kept, and the kept pages.
#include <core/snapshot.h>
#include <core/snapshot_columns.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace scree {

namespace {

constexpr std::size_t kPage = 256;  // bytes; larger ones keep more that has not changed

std::size_t pages_of(std::size_t bytes) { return (bytes + kPage - 1) / kPage; }

void put(Column<std::byte>& out, const void* from, std::size_t bytes) {
  const std::size_t at = out.size();
  out.resize_for_overwrite(at + bytes);
  if (bytes > 0) std::memcpy(out.data() + at, from, bytes);
}

// The pages of `later` that differ from those of `base` at the same place.
void keep_pages(const std::byte* base, std::size_t base_bytes, const std::byte* later, std::size_t bytes,
                Column<std::byte>& out) {
  const std::size_t flags = out.size();
  out.reserve(flags + pages_of(bytes) + bytes);
  out.resize_for_overwrite(flags + pages_of(bytes));
  for (std::size_t at = 0; at < bytes; at += kPage) {
    const std::size_t page = std::min(kPage, bytes - at);
    const bool same = at + page <= base_bytes && std::memcmp(base + at, later + at, page) == 0;
    out[flags + at / kPage] = std::byte{!same};
    if (!same) put(out, later + at, page);
  }
}

// Takes the column's bytes from `from`, which moves on, and from the base.
void take_pages(const std::byte* base, const std::byte*& from, std::size_t bytes, std::byte* to) {
  const std::byte* flags = from;
  from += pages_of(bytes);
  for (std::size_t at = 0; at < bytes; at += kPage) {
    const std::size_t page = std::min(kPage, bytes - at);
    const bool kept = *flags++ != std::byte{0};
    std::memcpy(to + at, kept ? from : base + at, page);
    if (kept) from += page;
  }
}

}  // namespace

SnapshotChanges::SnapshotChanges() noexcept = default;
SnapshotChanges::~SnapshotChanges() = default;
SnapshotChanges::SnapshotChanges(SnapshotChanges&&) noexcept = default;
SnapshotChanges& SnapshotChanges::operator=(SnapshotChanges&&) noexcept = default;

bool SnapshotChanges::is_empty() const noexcept { return data_ == nullptr || !data_->is_full; }

std::size_t SnapshotChanges::bytes() const noexcept {
  if (is_empty()) return 0;
  return sizeof *data_ + data_->columns.size() + data_->hulls.size() * sizeof(SharedHull);
}

void keep_changes(const Snapshot& base, const Snapshot& later, SnapshotChanges& changes) {
  constexpr const char* kName = "keep_changes";
  const SnapshotData &from = filled(base, kName), &data = filled(later, kName);
  std::unique_ptr<SnapshotChangesData>& to = SnapshotAccess::data(changes);
  if (to == nullptr) to = std::make_unique<SnapshotChangesData>();
  to->is_full = false;
  to->base = from.id;
  to->world = data.world;
  if (!same_hulls(to->hulls, data.hulls)) to->hulls = data.hulls;
  const SavedColumns before = find_columns(from.columns), after = find_columns(data.columns);
  to->columns.clear();
  for (std::size_t i = 0; i < after.count; ++i) {
    const SavedColumn &old = before.column[i], &column = after.column[i];
    put(to->columns, data.columns.data() + column.begin - kColumnHeadBytes, kColumnHeadBytes);
    keep_pages(from.columns.data() + old.begin, old.bytes, data.columns.data() + column.begin, column.bytes,
               to->columns);
  }
  to->is_full = true;
}

void apply_changes(const Snapshot& base, const SnapshotChanges& changes, Snapshot& later) {
  constexpr const char* kName = "apply_changes";
  const SnapshotData& from = filled(base, kName);
  if (changes.is_empty()) throw Error(std::string(kName) + ": the changes are empty");
  const SnapshotChangesData& data = *SnapshotAccess::data(changes);
  if (data.base != from.id) {
    throw Error(std::string(kName) + ": the changes were made with another snapshot than the base is now");
  }
  std::unique_ptr<SnapshotData>& to = SnapshotAccess::data(later);
  if (to.get() == &from) throw Error(std::string(kName) + ": the base can not be the later snapshot, too");
  if (to == nullptr) to = std::make_unique<SnapshotData>();
  to->is_full = false;
  to->world = data.world;
  if (!same_hulls(to->hulls, data.hulls)) to->hulls = data.hulls;
  const SavedColumns before = find_columns(from.columns);
  Column<std::byte>& out = to->columns;
  out.clear();
  const std::byte* kept = data.columns.data();
  for (std::size_t i = 0; i < before.count; ++i) {
    while (out.size() % kColumnAlignment != 0) out.push_back(std::byte{0});
    std::uint64_t numbers[2];
    std::memcpy(numbers, kept, sizeof numbers);
    put(out, numbers, sizeof numbers);
    kept += sizeof numbers;
    const std::size_t begin = out.size(), bytes = static_cast<std::size_t>(numbers[1]);
    out.resize_for_overwrite(begin + bytes);
    take_pages(from.columns.data() + before.column[i].begin, kept, bytes, out.data() + begin);
  }
  while (out.size() % kColumnAlignment != 0) out.push_back(std::byte{0});
  const SavedColumns after = find_columns(out);
  const SavedColumn& points = after.find("contacts.now", "points");
  list_contacts(reinterpret_cast<const std::uint8_t*>(out.data() + points.begin), points.rows, to->contacts);
  to->id = next_snapshot_id();
  to->is_full = true;
}

}  // namespace scree
