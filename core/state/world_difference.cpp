// See world_difference.h.
#include <core/state/recording_format/value_bytes.h>
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

// Bytes of the columns of kind state; stages' parts have none.
struct StateColumn {
  std::string name;
  std::size_t row_bytes;
  std::vector<std::byte> bytes;
};

std::vector<StateColumn> state_columns(const World& world) {
  std::vector<StateColumn> columns;
  for_each_column_member(internals(world), [&columns](const Member& member, const auto& column) {
    if (member.kind != ColumnKind::state) return;
    columns.push_back({std::string(member.store) + "." + member.name, sizeof(*column.data()), {}});
    const auto* const first = reinterpret_cast<const std::byte*>(column.data());
    if (!column.empty()) columns.back().bytes.assign(first, first + column.span().size_bytes());
  });
  return columns;
}

// A value of kind state as its fields are written.
struct StateValue {
  std::string name;
  std::vector<std::byte> bytes;
};

std::vector<StateValue> state_values(const SavedWorld& world) {
  std::vector<StateValue> values;
  SavedWorld::visit_members(world, TablePlace{"world"}, [&values](const Member& member, const auto& value) {
    ByteWriter writer;
    write_value(writer, value);
    values.push_back({std::string(member.store) + "." + member.name, writer.take()});
  });
  return values;
}

// What stands in no column. Hulls do: Hulls::content stands for them.
std::string first_setting_difference(const World& expected, const World& actual) {
  SavedWorld a, b;
  internals(expected).save_values(a);
  internals(actual).save_values(b);
  if (a.step_count != b.step_count) {
    return "the step counter is " + std::to_string(b.step_count) + " instead of " +
           std::to_string(a.step_count);
  }
  const std::vector<StateValue> left = state_values(a), right = state_values(b);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i].bytes != right[i].bytes) return left[i].name;
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
        {{"angular_velocity", left.velocity[row].angular}, {"", right.velocity[row].angular}},
        {{"lag", std::span(&left.velocity[row].lag, 1)}, {"", std::span(&right.velocity[row].lag, 1)}}};
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

std::string first_difference_of_copies(const World& expected, const World& actual) {
  const std::string body = first_body_difference(expected, actual);
  if (!body.empty()) return body;
  const std::string column = first_column_difference(expected, actual);
  return column.empty() ? first_setting_difference(expected, actual) : column;
}

std::string first_state_difference(const World& expected, const World& actual) {
  const std::string body = first_body_difference(expected, actual);  // which needs no copies
  return body.empty() ? first_difference_of_copies(clone(expected), clone(actual)) : body;
}

}  // namespace scree
