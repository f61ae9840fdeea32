// Arrays in NumPy's format, stored in a ZIP archive. The format of an array: "NPY Format" of NumPy's manual,
// version 1.0. All numbers are little-endian, as this machine's are.
#include <archive.h>
#include <archive_entry.h>
#include <tools/extract/tables.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

namespace scree::extract {
namespace {

static_assert(std::endian::native == std::endian::little);

// The text of a shape, as Python writes a tuple.
std::string tuple_of(std::span<const std::size_t> shape) {
  std::string text = "(";
  for (const std::size_t count : shape) text += std::to_string(count) + ",";
  return text + ")";
}

std::string array_head(const std::string& type, std::span<const std::size_t> shape) {
  constexpr std::size_t kAlignment = 64, kPrefix = 10;
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + tuple_of(shape) + ", }";
  const std::size_t size = kPrefix + text.size() + 1;
  text.append((kAlignment - size % kAlignment) % kAlignment, ' ');
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += static_cast<char>(text.size() & 0xff);
  head += static_cast<char>(text.size() >> 8);
  return head + text;
}

// A ZIP archive in memory.
class Archive {
 public:
  Archive() : archive_(archive_write_new(), archive_write_free) {
    if (archive_ == nullptr) throw std::bad_alloc();
    check(archive_write_set_format_zip(archive_.get()));
    check(archive_write_zip_set_compression_store(archive_.get()));
    check(archive_write_set_bytes_per_block(archive_.get(), 0));
    check(archive_write_open(archive_.get(), &bytes_, nullptr, &Archive::take, nullptr));
  }

  template <class Number>
  void add(const std::string& name, const std::string& type, std::vector<std::size_t> shape,
           std::span<const Number> numbers) {
    add_bytes(name, array_head(type, shape), reinterpret_cast<const char*>(numbers.data()),
              numbers.size_bytes());
  }
  std::string finish() {
    check(archive_write_close(archive_.get()));
    return std::move(bytes_);
  }

 private:
  static la_ssize_t take(archive*, void* bytes, const void* from, std::size_t size) {
    try {
      static_cast<std::string*>(bytes)->append(static_cast<const char*>(from), size);
    } catch (...) {
      return -1;
    }
    return static_cast<la_ssize_t>(size);
  }
  void check(int result) const {
    if (result == ARCHIVE_OK) return;
    const char* reason = archive_error_string(archive_.get());
    throw std::runtime_error(std::string("ZIP archive: ") + (reason != nullptr ? reason : "out of memory"));
  }
  void add_bytes(const std::string& name, const std::string& head, const char* data, std::size_t size) {
    const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(),
                                                                              archive_entry_free);
    if (entry == nullptr) throw std::bad_alloc();
    archive_entry_set_pathname(entry.get(), (name + ".npy").c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(head.size() + size));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), 0, 0);  // the same bytes at any time
    check(archive_write_header(archive_.get(), entry.get()));
    write(head.data(), head.size());
    write(data, size);
    check(archive_write_finish_entry(archive_.get()));
  }
  void write(const char* data, std::size_t size) {
    while (size > 0) {
      const la_ssize_t written = archive_write_data(archive_.get(), data, size);
      if (written <= 0) check(ARCHIVE_FATAL);
      data += written;
      size -= static_cast<std::size_t>(written);
    }
  }

  std::string bytes_;
  std::unique_ptr<archive, decltype(&archive_write_free)> archive_;
};

void add_signal(const Extract& extract, Signal signal, Archive& archive) {
  const SignalInfo& info = info_of(signal);
  const Values& values = extract.values[static_cast<std::size_t>(signal)];
  std::vector<std::size_t> shape = {extract.steps.size()};
  if (info.owner != Owner::world) shape.push_back(extract.rows_of(info.owner));
  if (info.width > 1) shape.push_back(static_cast<std::size_t>(info.width));
  if (info.is_wide) {
    archive.add<double>(info.name, "<f8", shape, values.wide);
  } else {
    archive.add<float>(info.name, "<f4", shape, values.single);
  }
}

template <class Member>
void add_event_column(const Extract& extract, const std::string& name, const std::string& type, Member member,
                      Archive& archive) {
  using Number = std::decay_t<decltype(extract.events.front().*member)>;
  std::vector<Number> column;
  for (const EventRow& event : extract.events) column.push_back(event.*member);
  archive.add<Number>(name, type, {column.size()}, column);
}

void add_events(const Extract& extract, Archive& archive) {
  constexpr std::size_t kNameSize = 16;
  add_event_column(extract, "event_step", "<u8", &EventRow::step, archive);
  add_event_column(extract, "event_time", "<f8", &EventRow::time, archive);
  std::vector<char> names(kNameSize * extract.events.size());
  for (std::size_t i = 0; i < extract.events.size(); ++i) {
    const char* name = name_of(extract.events[i].kind);
    std::memcpy(names.data() + kNameSize * i, name, std::min(std::strlen(name), kNameSize));
  }
  archive.add<char>("event_kind", "|S" + std::to_string(kNameSize), {extract.events.size()}, names);
  add_event_column(extract, "event_body_a", "<i8", &EventRow::body_a, archive);
  add_event_column(extract, "event_body_b", "<i8", &EventRow::body_b, archive);
  add_event_column(extract, "event_shape_a", "<i8", &EventRow::shape_a, archive);
  add_event_column(extract, "event_shape_b", "<i8", &EventRow::shape_b, archive);
  add_event_column(extract, "event_joint", "<i8", &EventRow::joint, archive);
  add_event_column(extract, "event_value", "<f8", &EventRow::value, archive);
}

}  // namespace

std::string to_npz(const Extract& extract) {
  Archive archive;
  archive.add<std::uint64_t>("step", "<u8", {extract.steps.size()}, extract.steps);
  archive.add<double>("time", "<f8", {extract.times.size()}, extract.times);
  if (extract.wanted.has(Owner::body))
    archive.add<std::uint32_t>("body", "<u4", {extract.bodies.size()}, extract.bodies);
  if (extract.wanted.has(Owner::joint))
    archive.add<std::uint32_t>("joint", "<u4", {extract.joints.size()}, extract.joints);
  for (const Signal signal : extract.wanted.signals) add_signal(extract, signal, archive);
  if (extract.wanted.events) add_events(extract, archive);
  return archive.finish();
}

}  // namespace scree::extract
