// See golden.h.
#include <tests/determinism/golden.h>
#include <tests/determinism/random_calls.h>

#include <cstdio>
#include <fstream>
#include <sstream>

namespace scree::determinism {
namespace {

[[noreturn]] void fail(const std::string& path, int line, const std::string& problem) {
  throw Error(path + ":" + std::to_string(line) + ": " + problem);
}

// "bodies=300,seed=1", or "-" for none. Values are written as integers wherever they are.
std::string text_of(const scenes::Parameters& parameters) {
  std::ostringstream out;
  out.precision(17);
  for (const auto& [key, value] : parameters) {
    out << (out.tellp() > 0 ? "," : "") << key << "=" << value;
  }
  return out.tellp() > 0 ? out.str() : "-";
}

scenes::Parameters parameters_of(const std::string& text, const std::string& path, int line) {
  scenes::Parameters parameters;
  if (text == "-") return parameters;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const std::size_t equals = item.find('=');
    std::istringstream number(equals == std::string::npos ? "" : item.substr(equals + 1));
    double value = 0.0;
    if (!(number >> value) || !number.eof()) fail(path, line, "'" + item + "' is not key=number");
    parameters[item.substr(0, equals)] = value;
  }
  return parameters;
}

bool is_comment(const std::string& line) { return line.empty() || line.front() == '#'; }

std::vector<std::string> read_lines(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(path + ": cannot be read");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::string format(const Golden& golden) {
  char line[256];
  std::snprintf(line, sizeof line, "%-15s %-27s %5d  %s  %s", golden.what.scene.c_str(),
                text_of(golden.what.parameters).c_str(), golden.what.steps, hex(golden.digest.last).c_str(),
                hex(golden.digest.all).c_str());
  return line;
}

}  // namespace

std::string Golden::name() const { return what.scene + " " + text_of(what.parameters); }

std::ostream& operator<<(std::ostream& out, const Golden& golden) { return out << golden.name(); }

std::vector<std::uint64_t> play_run(const SceneCase& what, const Schedule& schedule) {
  if (is_scene(what)) return play(what, schedule);
  const auto seed = static_cast<std::uint64_t>(what.parameters.at("seed"));
  const auto bodies = static_cast<int>(what.parameters.at("bodies"));
  return play(random_sequence(seed, what.steps, bodies), schedule, false).hashes;
}

std::string golden_path() { return SCREE_GOLDEN_FOLDER "/hashes.txt"; }

std::vector<Golden> read_goldens(const std::string& path) {
  const std::vector<std::string> lines = read_lines(path);
  std::vector<Golden> goldens;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (is_comment(lines[i])) continue;
    const int line = static_cast<int>(i) + 1;
    std::istringstream words(lines[i]);
    Golden golden;
    std::string parameters, rest;
    words >> golden.what.scene >> parameters >> golden.what.steps >> std::hex >> golden.digest.last >>
        golden.digest.all;
    if (!words || (words >> rest)) {
      fail(path, line, "expected scene, parameters, steps and two hashes of 16 hexadecimal digits");
    }
    if (golden.what.steps < 1) fail(path, line, "the number of steps must be positive");
    golden.what.parameters = parameters_of(parameters, path, line);
    goldens.push_back(golden);
  }
  return goldens;
}

void write_goldens(const std::string& path, const std::vector<Golden>& goldens) {
  std::vector<std::string> lines = read_lines(path);
  std::size_t next = 0;
  for (std::string& line : lines) {
    if (!is_comment(line)) line = format(goldens.at(next++));
  }
  std::ofstream file(path);
  for (const std::string& line : lines) file << line << "\n";
  file.close();
  if (!file) throw Error(path + ": cannot be written");
}

}  // namespace scree::determinism
