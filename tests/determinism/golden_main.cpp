// scree_golden: the program behind tools/update_goldens.
//   scree_golden update FILE   plays every run of the file, rewrites the hashes that changed and prints them;
//                              a run whose backends disagree has no hash, so it stops there
//   scree_golden backend       prints the instruction set that steps take by themselves, and a hash
#include <tests/determinism/golden.h>
#include <tests/determinism/replay.h>

#include <tbb/global_control.h>

#include <cstdio>
#include <cstring>
#include <exception>

namespace scree::determinism {
namespace {

Digest checked_digest(const Golden& golden) {
  const std::vector<std::uint64_t> expected = play_run(golden.what, {kReference});
  for (const Schedule& schedule : schedules(false)) {
    if (play_run(golden.what, schedule) == expected) continue;
    throw Error(golden.name() + " on " + name_of(schedule) + " differs from " + name_of({kReference}) +
                (is_scene(golden.what) ? ": " + where_they_part(golden.what, schedule) : ""));
  }
  return digest_of(expected);
}

void update(const std::string& path) {
  std::vector<Golden> goldens = scenes::read_goldens(path);
  for (Golden& golden : goldens) {
    const Digest digest = checked_digest(golden);
    if (digest == golden.digest) continue;
    std::printf("%s: %s -> %s\n", golden.name().c_str(), hex(golden.digest.all).c_str(),
                hex(digest.all).c_str());
    std::fflush(stdout);
    golden.digest = digest;
  }
  scenes::write_goldens(path, goldens);
}

void print_backend() {
  Workers workers;
  Playback playback({"pile", {{"bodies", 60}}, 40});
  for (int i = 0; i < 40; ++i) playback.advance(workers);
  std::printf("%s hash %s\n", isa_name(workers.isa()), hex(playback.hash()).c_str());
}

}  // namespace
}  // namespace scree::determinism

int main(int count, char** arguments) {
  // TBB lends one thread per core unless told otherwise; schedules use more.
  const tbb::global_control more_threads(tbb::global_control::max_allowed_parallelism, 8);
  try {
    if (count == 3 && std::strcmp(arguments[1], "update") == 0) {
      scree::determinism::update(arguments[2]);
    } else if (count == 2 && std::strcmp(arguments[1], "backend") == 0) {
      scree::determinism::print_backend();
    } else {
      std::fprintf(stderr, "usage: scree_golden update FILE | backend\n");
      return 2;
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scree_golden: %s\n", error.what());
    return 1;
  }
}
