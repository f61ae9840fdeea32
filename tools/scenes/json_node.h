// A value of a JSON document that knows its place: every reader below checks type and range and reports file,
// place and reason. Used only by scene_file.cpp.
#pragma once

#include <scree/error.h>
#include <scree/math_types.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree::scenes {

struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

class Node {
 public:
  Node(const nlohmann::json& value, std::string file, std::string pointer = "")
      : value_(&value), file_(std::move(file)), pointer_(std::move(pointer)) {}

  [[noreturn]] void fail(const std::string& reason) const;

  bool is_object() const { return value_->is_object(); }
  bool is_array() const { return value_->is_array(); }
  bool is_string() const { return value_->is_string(); }

  float number(Range range = {}) const;
  double precise_number(Range range = {}) const;
  std::int64_t integer(std::int64_t low, std::int64_t high) const;
  std::uint64_t bits64() const;
  bool boolean() const;
  std::string string() const;
  Vec3 vector(Range range = {}) const;  // each component within the range
  // The index of the text among `choices`.
  std::size_t choice(std::span<const char* const> choices) const;

  std::vector<Node> elements() const;                                        // of an array
  std::vector<Node> elements(std::size_t count, const char* of_what) const;  // exactly that many
  std::vector<std::pair<std::string, Node>> members() const;                 // of an object

 private:
  const char* kind() const;
  Node child(const nlohmann::json& value, const std::string& key) const;

  const nlohmann::json* value_;
  std::string file_;
  std::string pointer_;  // RFC 6901
};

// Hands out the members of an object by key; a member that no reader requested is an error.
class Members {
 public:
  explicit Members(const Node& object);

  const Node* find(const char* key);     // nullptr if absent
  const Node& require(const char* key);  // an error if absent
  void finish() const;                   // throws for a member that no reader requested

  void read(const char* key, float& out, Range range = {});
  void read(const char* key, bool& out);
  void read(const char* key, int& out, int low, int high);
  void read(const char* key, Vec3& out, Range range = {});
  void read(const char* key, std::string& out);

 private:
  const Node& object_;
  std::vector<std::pair<std::string, Node>> members_;
  std::vector<bool> asked_;
  std::vector<const char*> known_;
};

// Parses a text; errors carry line and column. A duplicate key in one object is an error, too.
nlohmann::json parse_json(const std::string& text, const std::string& file);

}  // namespace scree::scenes
