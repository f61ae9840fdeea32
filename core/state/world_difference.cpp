// See world_difference.h.
#include <core/state/snapshot/snapshot_bytes.h>
#include <core/state/world_difference.h>
#include <core/world/state_table.h>

#include <bit>
#include <cstdio>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace scree {

namespace {

std::string bits_text(float value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.9g (%08x)", static_cast<double>(value), std::bit_cast<unsigned>(value));
  return text;
}

struct Field {
  const char* name;
  std::span<const float> values;
};

// "name.y is ... instead of ..." for the first value whose bits differ.
std::string difference(const Field& expected, const Field& actual) {
  for (std::size_t i = 0; i < expected.values.size(); ++i) {
    if (std::memcmp(&expected.values[i], &actual.values[i], sizeof(float)) == 0) continue;
    return std::string(expected.name) + "." + "xyzw"[i] + " is " + bits_text(actual.values[i]) +
           " instead of " + bits_text(expected.values[i]);
  }
  return {};
}

// Bytes of the columns of kind state, stage parts included.
struct StateColumn {
  std::string name;
  std::size_t row_bytes;
  std::vector<std::byte> bytes;
};

std::vector<StateColumn> state_columns(const World& world) {
  std::vector<StateColumn> columns;
  const auto add = [&columns](ColumnKind kind, std::string name, const void* rows, std::size_t row_bytes,
                              std::size_t bytes) {
    if (kind != ColumnKind::state) return;
    const auto* first = static_cast<const std::byte*>(rows);
    columns.push_back({std::move(name), row_bytes, {}});
    if (bytes > 0) columns.back().bytes.assign(first, first + bytes);
  };
  auto& data = const_cast<WorldData&>(internals(world));  // its columns are read only
  for_each_column(data, [&add](ColumnKind kind, const char* store, const char* name, auto& column) {
    add(kind, std::string(store) + "." + name, column.data(), sizeof(*column.data()),
        column.span().size_bytes());
  });
  for (const Part* part :
       {data.broad_phase.get(), data.narrow_phase.get(), data.constraints.get(), data.islands.get()}) {
    if (part == nullptr) continue;
    part->report([&add](ColumnKind kind, const char* name, const void* rows, std::size_t bytes, std::size_t) {
      add(kind, std::string("part.") + name, rows, 1, bytes);
    });
  }
  return columns;
}

// What stands in no column.
std::string first_setting_difference(const World& expected, const World& actual) {
  Snapshot left, right;
  save(expected, left);
  save(actual, right);
  const SavedWorld &a = SnapshotAccess::data(left)->world, &b = SnapshotAccess::data(right)->world;
  if (a.step_count != b.step_count) {
    return "the step counter is " + std::to_string(b.step_count) + " instead of " +
           std::to_string(a.step_count);
  }
  if (hash_of_state(*SnapshotAccess::data(left)) != hash_of_state(*SnapshotAccess::data(right))) {
    return "the settings, the last time step, or what calls have left for the next step to do";
  }
  return {};
}

}  // namespace

std::string first_body_difference(const World& expected, const World& actual) {
  const Bodies& left = internals(expected).bodies;
  const Bodies& right = internals(actual).bodies;
  if (left.flags.size() != right.flags.size()) return "the number of body rows";
  for (std::size_t row = 0; row < left.flags.size(); ++row) {
    if (((left.flags[row] ^ right.flags[row]) & kBodyAlive) != 0) {
      return "body " + std::to_string(row) + ", whether it is alive";
    }
    if ((left.flags[row] & kBodyAlive) == 0) continue;
    const Field fields[][2] = {
        {{"position", left.pose[row].position}, {"", right.pose[row].position}},
        {{"rotation", left.pose[row].rotation}, {"", right.pose[row].rotation}},
        {{"linear_velocity", left.velocity[row].linear}, {"", right.velocity[row].linear}},
        {{"angular_velocity", left.velocity[row].angular}, {"", right.velocity[row].angular}}};
    for (const auto& [left_field, right_field] : fields) {
      const std::string found = difference(left_field, right_field);
      if (!found.empty()) return "body " + std::to_string(row) + ", " + found;
    }
  }
  return {};
}

std::string first_column_difference(const World& expected, const World& actual) {
  const std::vector<StateColumn> left = state_columns(expected);
  const std::vector<StateColumn> right = state_columns(actual);
  if (left.size() != right.size()) return "number of columns";
  for (std::size_t i = 0; i < left.size(); ++i) {
    const std::vector<std::byte>& a = left[i].bytes;
    const std::vector<std::byte>& b = right[i].bytes;
    if (a.size() != b.size()) {
      return left[i].name + ": " + std::to_string(b.size() / left[i].row_bytes) + " rows instead of " +
             std::to_string(a.size() / left[i].row_bytes);
    }
    for (std::size_t at = 0; at < a.size(); ++at) {
      if (a[at] == b[at]) continue;
      return left[i].name + ", row " + std::to_string(at / left[i].row_bytes) + ", byte " +
             std::to_string(at % left[i].row_bytes) + " of " + std::to_string(left[i].row_bytes);
    }
  }
  return {};
}

std::string first_state_difference(const World& expected, const World& actual) {
  const std::string body = first_body_difference(expected, actual);
  if (!body.empty()) return body;
  // Of copies, whose free rows are empty.
  const std::string column = first_column_difference(clone(expected), clone(actual));
  return column.empty() ? first_setting_difference(expected, actual) : column;
}

}  // namespace scree
