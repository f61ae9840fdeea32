// Typed, checked access to a JSON document; see json_node.h.
#include <tools/scenes/json_node.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>

namespace scree::scenes {
namespace {

std::string escape(const std::string& key) {  // RFC 6901, section 3
  std::string escaped;
  for (const char character : key) {
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

std::string text(double value) {
  std::ostringstream out;
  out.precision(9);
  out << value;
  return out.str();
}

std::string text(Range range) {
  if (std::isinf(range.low) && std::isinf(range.high)) return "finite";
  if (std::isinf(range.high)) return "at least " + text(range.low);
  if (std::isinf(range.low)) return "at most " + text(range.high);
  return "from " + text(range.low) + " to " + text(range.high);
}

// Follows the parser through the document to tell where a key stands twice.
class DuplicateWatch {
 public:
  explicit DuplicateWatch(const std::string& file) : file_(file) {}

  bool operator()(int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    switch (event) {
      case Event::object_start:
      case Event::array_start:
        open_.push_back({event == Event::array_start, 0, {}, {}});
        break;
      case Event::object_end:
      case Event::array_end:
        open_.pop_back();
        count_element();
        break;
      case Event::value:
        count_element();
        break;
      case Event::key:
        open_.back().key = parsed.get<std::string>();
        if (!open_.back().seen.insert(open_.back().key).second) {
          throw Error(file_ + ": " + place() + ": the key stands twice in its object");
        }
        break;
    }
    return true;
  }

  // Of the value that comes next.
  std::string place() const {
    std::string path;
    for (const Level& level : open_) {
      path += '/';
      path += level.array ? std::to_string(level.index) : escape(level.key);
    }
    return path.empty() ? "the document" : path;
  }

 private:
  struct Level {
    bool array = false;
    std::size_t index = 0;
    std::string key;
    std::set<std::string> seen;
  };

  void count_element() {
    if (!open_.empty() && open_.back().array) ++open_.back().index;
  }

  std::string file_;
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
    fail(text(number) + " must be " + text(range));
  }
  return number;
}

float Node::number(Range range) const {
  const double precise = precise_number(range);
  const float number = static_cast<float>(precise);
  if (!std::isfinite(number)) fail(text(precise) + " is too large for single precision");
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
  DuplicateWatch watch(file);
  try {
    return nlohmann::json::parse(source, std::ref(watch));
  } catch (const nlohmann::json::parse_error& error) {
    // error.byte is the count of bytes read when the text stopped making sense.
    const std::size_t end = std::min(error.byte > 0 ? error.byte - 1 : 0, source.size());
    const auto line = 1 + std::count(source.begin(), source.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    const std::size_t line_start = end == 0 ? std::string::npos : source.rfind('\n', end - 1);
    const std::size_t column = line_start == std::string::npos ? end + 1 : end - line_start;
    // "[json.exception.parse_error.101] parse error at line 1, column 2: <reason>"
    std::string reason = error.what();
    if (const std::size_t colon = reason.find(": "); colon != std::string::npos) reason.erase(0, colon + 2);
    throw Error(file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": not JSON: " + reason);
  } catch (const nlohmann::json::exception& error) {  // a number that no double holds
    std::string reason = error.what();
    if (const std::size_t bracket = reason.find("] "); bracket != std::string::npos) {
      reason.erase(0, bracket + 2);
    }
    throw Error(file + ": " + watch.place() + ": " + reason);
  }
}

}  // namespace scree::scenes
