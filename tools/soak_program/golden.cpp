// See golden.h.
#include <scree/recording.h>
#include <tools/scenes/digest.h>
#include <tools/soak_program/golden.h>
#include <tools/soak_program/stage.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

namespace scree::soak {
namespace {

constexpr int kThreadCounts[] = {1, 2, 3, 8};

std::string text_of(const scenes::Parameters& parameters) {
  std::ostringstream text;
  text.precision(17);
  for (const auto& [key, value] : parameters) text << (text.tellp() > 0 ? "," : "") << key << "=" << value;
  return text.tellp() > 0 ? text.str() : "-";
}

std::string name_of(const Golden& golden) { return golden.scene + " " + text_of(golden.parameters); }

bool is_comment(const std::string& line) { return line.empty() || line.front() == '#'; }

std::vector<std::string> read_lines(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw Error(file + ": cannot be read");
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool parse(const std::string& line, Golden& golden) {
  std::istringstream words(line);
  std::string parameters, rest;
  words >> golden.scene >> parameters >> golden.steps >> std::hex >> golden.last >> golden.all;
  if (!words || (words >> rest) || golden.steps < 1) return false;
  if (parameters == "-") return true;
  std::istringstream items(parameters);
  for (std::string item; std::getline(items, item, ',');) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos) return false;
    std::istringstream number(item.substr(equals + 1));
    double value = 0.0;
    if (!(number >> value) || !number.eof()) return false;
    golden.parameters[item.substr(0, equals)] = value;
  }
  return true;
}

std::string format(const Golden& golden) {
  char line[256];
  std::snprintf(line, sizeof line, "%-15s %-32s %5d  %016llx  %016llx", golden.scene.c_str(),
                text_of(golden.parameters).c_str(), golden.steps,
                static_cast<unsigned long long>(golden.last), static_cast<unsigned long long>(golden.all));
  return line;
}

std::uint64_t hash_of(const std::vector<World>& worlds) {
  if (worlds.size() == 1) return worlds.front().hash();
  scenes::Digest digest;
  for (const World& world : worlds) digest.add(world.hash());
  return digest.value();
}

// The hash after each step. At two thirds of them bodies are thrown up: what has come to rest wakes. With a
// file, the first world is recorded.
std::vector<std::uint64_t> play(const Golden& golden, Backend backend, const std::string& record = "") {
  const std::vector<scenes::Scene> built = scenes::build(golden.scene, golden.parameters);
  Stage stage(built);
  Workers workers(WorkersOptions{.threads = backend.threads, .isa = backend.isa});
  std::optional<Recorder> recorder;
  if (!record.empty()) recorder.emplace(stage.worlds().front(), record);
  std::vector<std::uint64_t> hashes;
  for (int step = 0; step < golden.steps; ++step) {
    if (step == 2 * golden.steps / 3) stage.throw_up();
    stage.advance(built.front().dt, workers);
    hashes.push_back(hash_of(stage.worlds()));
  }
  if (recorder) recorder->finish();
  return hashes;
}

Golden with_hashes(Golden golden, const std::vector<std::uint64_t>& hashes) {
  scenes::Digest digest;
  for (const std::uint64_t hash : hashes) digest.add(hash);
  golden.last = hashes.back();
  golden.all = digest.value();
  return golden;
}

std::vector<Backend> matrix() {
  std::vector<Backend> backends;
  // The widest first: the others are compared with it.
  for (const Isa isa : {Isa::avx512, Isa::avx2, Isa::sse2, Isa::scalar}) {
    if (!is_supported(isa)) {
      std::printf("%s is not supported here, and NOT compared\n", isa_name(isa));
      continue;
    }
    for (const int threads : kThreadCounts) backends.push_back({isa, threads});
  }
  return backends;
}

}  // namespace

std::vector<Golden> read_goldens(const std::string& file) {
  std::vector<Golden> goldens;
  int number = 0;
  for (const std::string& line : read_lines(file)) {
    ++number;
    if (is_comment(line)) continue;
    Golden golden;
    if (!parse(line, golden)) {
      throw Error(file + ":" + std::to_string(number) +
                  ": expected scene, parameters, steps and two hashes of 16 hexadecimal digits");
    }
    goldens.push_back(std::move(golden));
  }
  return goldens;
}

void write_goldens(const std::string& file, const std::vector<Golden>& goldens) {
  std::vector<std::string> lines = read_lines(file);
  std::size_t next = 0;
  for (std::string& line : lines) {
    if (!is_comment(line)) line = format(goldens.at(next++));
  }
  std::ofstream stream(file);
  for (const std::string& line : lines) stream << line << "\n";
  stream.close();
  if (!stream) throw Error(file + ": cannot be written");
}

GoldenMatrix::GoldenMatrix(std::string file, std::string folder)
    : file_(std::move(file)), folder_(std::move(folder)) {}

Failure GoldenMatrix::failure(const Golden& golden, Backend backend, std::size_t step) {
  const std::string record = folder_ + "/golden_" + golden.scene + ".scree";
  play(golden, backend, record);
  const Backend reference = matrix().front();
  return {record + ": " + name_of(golden) + " on " + soak::name_of(backend) + " differs from " +
              soak::name_of(reference) + " in step " + std::to_string(step + 1),
          "scree replay " + record + " --verify " + options_of(reference)};
}

std::optional<Failure> GoldenMatrix::check() {
  const std::vector<Backend> backends = matrix();
  for (const Golden& golden : read_goldens(file_)) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<std::uint64_t> expected = play(golden, backends.front());
    for (std::size_t i = 1; i < backends.size(); ++i) {
      const std::vector<std::uint64_t> actual = play(golden, backends[i]);
      const auto place = std::mismatch(expected.begin(), expected.end(), actual.begin(), actual.end());
      hashes_ += static_cast<std::int64_t>(expected.size());
      if (place.first == expected.end()) continue;
      return failure(golden, backends[i], static_cast<std::size_t>(place.first - expected.begin()));
    }
    const Golden found = with_hashes(golden, expected);
    if (found.last != golden.last || found.all != golden.all) {
      return Failure{name_of(golden) + ": all backends agree, but not with the golden hash in " + file_,
                     "scree_soak --update-golden, if results were meant to change"};
    }
    std::printf("golden %s: %zu backends and the recorded hash agree in %d steps, %.1f s\n",
                name_of(golden).c_str(), backends.size(), golden.steps,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    std::fflush(stdout);
  }
  return {};
}

void GoldenMatrix::update() {
  std::vector<Golden> goldens = read_goldens(file_);
  for (Golden& golden : goldens) {
    const Golden found = with_hashes(golden, play(golden, {Isa::automatic, 0}));
    if (found.last == golden.last && found.all == golden.all) continue;
    std::printf("%s: %016llx -> %016llx\n", name_of(golden).c_str(),
                static_cast<unsigned long long>(golden.all), static_cast<unsigned long long>(found.all));
    std::fflush(stdout);
    golden = found;
  }
  write_goldens(file_, goldens);
}

}  // namespace scree::soak
