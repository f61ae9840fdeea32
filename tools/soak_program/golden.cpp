// See golden.h.
#include <scree/recording.h>
#include <tools/scenes/digest.h>
#include <tools/scenes/stage.h>
#include <tools/soak_program/golden.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

namespace scree::soak {
namespace {

constexpr int kGoldenThreadCounts[] = {1, 2, 3, 8};
constexpr Vec3 kThrow{0.0f, 5.0f, 0.0f};  // m/s

// The hash after each step. At two thirds of the steps bodies are thrown up, which wakes sleeping bodies.
// With a file, records the first world.
std::vector<std::uint64_t> play(const scenes::Run& run, Backend backend, const std::string& record = "") {
  const std::vector<scenes::Scene> built = scenes::build(run.scene, run.parameters);
  scenes::Stage stage(built);
  Workers workers(WorkersOptions{.threads = backend.threads, .isa = backend.isa});
  std::optional<Recorder> recorder;
  if (!record.empty()) recorder.emplace(stage.worlds().front(), record);
  std::vector<std::uint64_t> hashes;
  for (int step = 0; step < run.steps; ++step) {
    if (step == 2 * run.steps / 3) stage.throw_up(kThrow);
    stage.advance(built.front().dt, workers);
    hashes.push_back(scenes::hash_of(stage.worlds()));
  }
  if (recorder) recorder->finish();
  return hashes;
}

scenes::RunHashes digest_of(const std::vector<std::uint64_t>& hashes) {
  scenes::Digest digest;
  for (const std::uint64_t hash : hashes) digest.add(hash);
  return {hashes.back(), digest.value()};
}

std::vector<Backend> matrix() {
  std::vector<Backend> backends;
  // The widest first: the others are compared with it.
  for (const Isa isa : {Isa::avx512, Isa::avx2, Isa::sse2, Isa::scalar}) {
    if (!is_supported(isa)) {
      std::printf("%s is not supported here, and NOT compared\n", isa_name(isa));
      continue;
    }
    for (const int threads : kGoldenThreadCounts) backends.push_back({isa, threads});
  }
  return backends;
}

}  // namespace

GoldenMatrix::GoldenMatrix(std::string file, std::string folder)
    : file_(std::move(file)), folder_(std::move(folder)) {}

Failure GoldenMatrix::failure(const scenes::Golden& golden, Backend backend, std::size_t step) {
  const std::string record = folder_ + "/golden_" + golden.what.scene + ".scree";
  play(golden.what, backend, record);
  const Backend reference = matrix().front();
  return {record + ": " + golden.name() + " on " + name_of(backend) + " differs from " + name_of(reference) +
              " in step " + std::to_string(step + 1),
          "scree replay " + record + " --verify " + options_of(reference)};
}

std::optional<Failure> GoldenMatrix::check() {
  const std::vector<Backend> backends = matrix();
  for (const scenes::Golden& golden : scenes::read_goldens(file_)) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<std::uint64_t> expected = play(golden.what, backends.front());
    for (std::size_t i = 1; i < backends.size(); ++i) {
      const std::vector<std::uint64_t> actual = play(golden.what, backends[i]);
      const auto place = std::mismatch(expected.begin(), expected.end(), actual.begin(), actual.end());
      hashes_ += static_cast<std::int64_t>(expected.size());
      if (place.first == expected.end()) continue;
      return failure(golden, backends[i], static_cast<std::size_t>(place.first - expected.begin()));
    }
    if (digest_of(expected) != golden.digest) {
      return Failure{golden.name() + ": all backends agree, but not with the golden hash in " + file_,
                     "scree_soak --update-golden, if results were meant to change"};
    }
    std::printf("golden %s: %zu backends and the recorded hash agree in %d steps, %.1f s\n",
                golden.name().c_str(), backends.size(), golden.what.steps,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    std::fflush(stdout);
  }
  return {};
}

void GoldenMatrix::update() {
  std::vector<scenes::Golden> goldens = scenes::read_goldens(file_);
  for (scenes::Golden& golden : goldens) {
    const scenes::RunHashes found = digest_of(play(golden.what, {Isa::automatic, 0}));
    if (found == golden.digest) continue;
    std::printf("%s: %s -> %s\n", golden.name().c_str(), scenes::hex(golden.digest.all).c_str(),
                scenes::hex(found.all).c_str());
    std::fflush(stdout);
    golden.digest = found;
  }
  scenes::write_goldens(file_, goldens);
}

}  // namespace scree::soak
