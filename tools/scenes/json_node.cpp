// Typed, checked access to a JSON document; see json_node.h.
#include <tools/scenes/json_node.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace scree::scenes {
namespace {

// RFC 6901, section 3. Control characters are written as JSON does: a zero would end the message.
std::string escape(const std::string& key) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string escaped;
  for (const char character : key) {
    const auto code = static_cast<unsigned char>(character);
    if (code < 0x20) {
      escaped += "\\u00";
      escaped += kDigits[code >> 4];
      escaped += kDigits[code & 0xf];
      continue;
    }
    if (character == '~') {
      escaped += "~0";
    } else if (character == '/') {
      escaped += "~1";
    } else {
      escaped += character;
    }
  }
  return escaped;
}

std::string printed(double value) {
  std::ostringstream out;
  out.precision(9);
  out << value;
  return out.str();
}

std::string printed(Range range) {
  if (std::isinf(range.low) && std::isinf(range.high)) return "finite";
  if (std::isinf(range.high)) return "at least " + printed(range.low);
  if (std::isinf(range.low)) return "at most " + printed(range.high);
  return "from " + printed(range.low) + " to " + printed(range.high);
}

// Builds the document while the parser reads its text, and reports duplicate keys. With a callback for keys,
// the library's own builder would search the whole enclosing value at the end of each object or array.
class Builder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  Builder(const std::string& source, const std::string& file) : source_(source), file_(file) {}

  nlohmann::json take() { return std::move(document_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t& value) override { return add(std::move(value)); }  // not in JSON

  bool start_object(std::size_t) override { return open(nlohmann::json::object()); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(nlohmann::json::array()); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    Level& level = open_.back();
    auto& members = level.value->get_ref<nlohmann::json::object_t&>();
    const auto [member, is_new] = members.emplace(std::move(key), nullptr);
    level.key = &member->first;
    level.member = &member->second;
    if (!is_new) throw Error(file_ + ": " + place() + ": the key stands twice in its object");
    return true;
  }

  bool parse_error(std::size_t bytes_read, const std::string&,
                   const nlohmann::json::exception& error) override {
    std::string reason = error.what();
    if (dynamic_cast<const nlohmann::json::parse_error*>(&error) ==
        nullptr) {  // a number that no double holds
      if (const std::size_t bracket = reason.find("] "); bracket != std::string::npos) {
        reason.erase(0, bracket + 2);
      }
      throw Error(file_ + ": " + place() + ": " + reason);
    }
    // "[json.exception.parse_error.101] parse error at line 1, column 2: <reason>"
    if (const std::size_t colon = reason.find(": "); colon != std::string::npos) reason.erase(0, colon + 2);
    throw Error(file_ + ":" + line_and_column(bytes_read) + ": not JSON: " + reason);
  }

 private:
  // An object or array that has not ended.
  struct Level {
    nlohmann::json* value;
    const std::string* key = nullptr;  // of an object: of the value that comes next
    nlohmann::json* member = nullptr;  // and where that goes
  };

  // Puts a value where the next one belongs. It stays there until its own level has ended.
  nlohmann::json* place_value(nlohmann::json value) {
    if (open_.empty()) {
      document_ = std::move(value);
      return &document_;
    }
    const Level& level = open_.back();
    if (level.value->is_array())
      return &level.value->get_ref<nlohmann::json::array_t&>().emplace_back(std::move(value));
    *level.member = std::move(value);
    return level.member;
  }

  bool add(nlohmann::json value) {
    place_value(std::move(value));
    return true;
  }

  bool open(nlohmann::json value) {
    nlohmann::json* const placed = place_value(std::move(value));
    open_.push_back({placed});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  // Of the value that comes next.
  std::string place() const {
    std::string path;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const nlohmann::json& value = *open_[i].value;
      // What is open itself is in its array already.
      const std::size_t index = value.size() - (value.is_array() && i + 1 < open_.size() ? 1 : 0);
      path += '/';
      path += value.is_array() ? std::to_string(index) : escape(*open_[i].key);
    }
    return path.empty() ? "the document" : path;
  }

  std::string line_and_column(std::size_t bytes_read) const {
    // The text became invalid at its last byte.
    const std::size_t end = std::min(bytes_read > 0 ? bytes_read - 1 : 0, source_.size());
    const auto line =
        1 + std::count(source_.begin(), source_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    const std::size_t line_start = end == 0 ? std::string::npos : source_.rfind('\n', end - 1);
    const std::size_t column = line_start == std::string::npos ? end + 1 : end - line_start;
    return std::to_string(line) + ":" + std::to_string(column);
  }

  const std::string& source_;
  const std::string& file_;
  nlohmann::json document_;
  std::vector<Level> open_;
};

}  // namespace

void Node::fail(const std::string& reason) const {
  throw Error(file_ + ": " + (pointer_.empty() ? "the document" : pointer_) + ": " + reason);
}

const char* Node::kind() const {
  switch (value_->type()) {
    case nlohmann::json::value_t::null:
      return "null";
    case nlohmann::json::value_t::object:
      return "an object";
    case nlohmann::json::value_t::array:
      return "an array";
    case nlohmann::json::value_t::string:
      return "a string";
    case nlohmann::json::value_t::boolean:
      return "a boolean";
    default:
      return "a number";
  }
}

Node Node::child(const nlohmann::json& value, const std::string& key) const {
  return {value, file_, pointer_ + "/" + escape(key)};
}

double Node::precise_number(Range range) const {
  if (!value_->is_number()) fail(std::string("expected a number, found ") + kind());
  const double number = value_->get<double>();
  if (!(number >= range.low && number <= range.high)) {
    fail(printed(number) + " must be " + printed(range));
  }
  return number;
}

float Node::number(Range range) const {
  const double precise = precise_number(range);
  const float number = static_cast<float>(precise);
  if (!std::isfinite(number)) fail(printed(precise) + " is too large for single precision");
  return number;
}

std::int64_t Node::integer(std::int64_t low, std::int64_t high) const {
  const std::string limits = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  if (!value_->is_number()) fail("expected " + limits + ", found " + kind());
  const double number = value_->get<double>();
  if (!(number >= static_cast<double>(low) && number <= static_cast<double>(high)) ||
      number != std::floor(number)) {
    fail(value_->dump() + " must be " + limits);
  }
  return static_cast<std::int64_t>(number);
}

std::uint64_t Node::bits64() const {
  if (!value_->is_number_unsigned()) fail("expected a whole number from 0 to 2^64 - 1");
  return value_->get<std::uint64_t>();
}

bool Node::boolean() const {
  if (!value_->is_boolean()) fail(std::string("expected true or false, found ") + kind());
  return value_->get<bool>();
}

std::string Node::string() const {
  if (!value_->is_string()) fail(std::string("expected a string, found ") + kind());
  return value_->get<std::string>();
}

Vec3 Node::vector(Range range) const {
  const std::vector<Node> parts = elements(3, "numbers");
  return {parts[0].number(range), parts[1].number(range), parts[2].number(range)};
}

std::size_t Node::choice(std::span<const char* const> choices) const {
  const std::string chosen = string();
  std::string all;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (chosen == choices[i]) return i;
    all += (i == 0 ? "" : ", ") + std::string(choices[i]);
  }
  fail("\"" + chosen + "\" is none of: " + all);
}

std::vector<Node> Node::elements() const {
  if (!value_->is_array()) fail(std::string("expected an array, found ") + kind());
  std::vector<Node> list;
  for (std::size_t i = 0; i < value_->size(); ++i) list.push_back(child((*value_)[i], std::to_string(i)));
  return list;
}

std::vector<Node> Node::elements(std::size_t count, const char* of_what) const {
  const std::string expected = "expected an array of " + std::to_string(count) + " " + of_what;
  if (!value_->is_array()) fail(expected + ", found " + kind());
  if (value_->size() != count) fail(expected + ", found " + std::to_string(value_->size()));
  return elements();
}

std::vector<std::pair<std::string, Node>> Node::members() const {
  if (!value_->is_object()) fail(std::string("expected an object, found ") + kind());
  std::vector<std::pair<std::string, Node>> list;
  for (const auto& [key, value] : value_->items()) list.emplace_back(key, child(value, key));
  return list;
}

Members::Members(const Node& object) : object_(object), members_(object.members()), asked_(members_.size()) {}

const Node* Members::find(const char* key) {
  known_.push_back(key);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].first != key) continue;
    asked_[i] = true;
    return &members_[i].second;
  }
  return nullptr;
}

const Node& Members::require(const char* key) {
  const Node* node = find(key);
  if (node == nullptr) object_.fail(std::string("the key \"") + key + "\" is missing");
  return *node;
}

void Members::finish() const {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (asked_[i]) continue;
    std::string known;
    for (const char* key : known_) known += (known.empty() ? "" : ", ") + std::string(key);
    members_[i].second.fail("unknown key; known here: " + known);
  }
}

void Members::read(const char* key, float& out, Range range) {
  if (const Node* node = find(key)) out = node->number(range);
}
void Members::read(const char* key, bool& out) {
  if (const Node* node = find(key)) out = node->boolean();
}
void Members::read(const char* key, int& out, int low, int high) {
  if (const Node* node = find(key)) out = static_cast<int>(node->integer(low, high));
}
void Members::read(const char* key, Vec3& out, Range range) {
  if (const Node* node = find(key)) out = node->vector(range);
}
void Members::read(const char* key, std::string& out) {
  if (const Node* node = find(key)) out = node->string();
}

nlohmann::json parse_json(const std::string& source, const std::string& file) {
  Builder builder(source, file);
  nlohmann::json::sax_parse(source, &builder);
  return builder.take();
}

}  // namespace scree::scenes
