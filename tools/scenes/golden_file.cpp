// See golden_file.h.
#include <tools/files/output_file.h>
#include <tools/scenes/golden_file.h>

#include <cstdio>
#include <fstream>
#include <ostream>
#include <sstream>

namespace scree::scenes {
namespace {

[[noreturn]] void fail(const std::string& file, std::size_t line, const std::string& problem) {
  throw Error(file + ":" + std::to_string(line) + ": " + problem);
}

Parameters parameters_of(const std::string& text, const std::string& file, std::size_t line) {
  Parameters parameters;
  if (text == "-") return parameters;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const std::size_t equals = item.find('=');
    std::istringstream number(equals == std::string::npos ? "" : item.substr(equals + 1));
    double value = 0.0;
    if (!(number >> value) || !number.eof()) fail(file, line, "'" + item + "' is not key=number");
    parameters[item.substr(0, equals)] = value;
  }
  return parameters;
}

bool is_comment(const std::string& line) { return line.empty() || line.front() == '#'; }

std::vector<std::string> read_lines(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw Error(file + ": cannot be read");
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// The line up to the steps; its author chose the columns.
std::string without_hashes(const std::string& line) {
  constexpr const char* kBlanks = " \t";
  std::size_t end = line.find_last_not_of(kBlanks) + 1;
  for (int hash = 0; hash < 2; ++hash) {
    end = line.find_last_of(kBlanks, end - 1);
    end = line.find_last_not_of(kBlanks, end) + 1;
  }
  return line.substr(0, end);
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const RunHashes& hashes) {
  return out << hex(hashes.last) << " after the last step, " << hex(hashes.all) << " over all";
}

std::string Golden::name() const { return what.scene + " " + text_of(what.parameters); }

std::ostream& operator<<(std::ostream& out, const Golden& golden) { return out << golden.name(); }

std::vector<Golden> read_goldens(const std::string& file) {
  const std::vector<std::string> lines = read_lines(file);
  std::vector<Golden> goldens;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (is_comment(lines[i])) continue;
    std::istringstream words(lines[i]);
    Golden golden;
    std::string parameters, rest;
    words >> golden.what.scene >> parameters >> golden.what.steps >> std::hex >> golden.digest.last >>
        golden.digest.all;
    if (!words || (words >> rest)) {
      fail(file, i + 1, "expected scene, parameters, steps and two hashes of 16 hexadecimal digits");
    }
    if (golden.what.steps < 1) fail(file, i + 1, "the number of steps must be positive");
    golden.what.parameters = parameters_of(parameters, file, i + 1);
    goldens.push_back(golden);
  }
  return goldens;
}

void write_goldens(const std::string& file, const std::vector<Golden>& goldens) {
  std::vector<std::string> lines = read_lines(file);
  std::size_t next = 0;
  for (std::string& line : lines) {
    if (is_comment(line)) continue;
    const RunHashes& hashes = goldens.at(next++).digest;
    line = without_hashes(line) + "  " + hex(hashes.last) + "  " + hex(hashes.all);
  }
  std::string text;
  for (const std::string& line : lines) text.append(line).append("\n");
  files::write_file({"", file}, text);
}

std::string text_of(const Parameters& parameters) {
  std::ostringstream text;
  text.precision(17);
  for (const auto& [key, value] : parameters) text << (text.tellp() > 0 ? "," : "") << key << "=" << value;
  return text.tellp() > 0 ? text.str() : "-";
}

std::string hex(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace scree::scenes
