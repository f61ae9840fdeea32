// See golden.h.
#include <tests/determinism/golden.h>
#include <tests/determinism/random_calls.h>

namespace scree::determinism {

std::string golden_path() { return SCREE_GOLDEN_FOLDER "/hashes.txt"; }

std::vector<Golden> scene_goldens() {
  std::vector<Golden> goldens = scenes::read_goldens(golden_path());
  std::erase_if(goldens, [](const Golden& golden) { return !is_scene(golden.what); });
  return goldens;
}

std::vector<std::uint64_t> play_run(const SceneCase& what, const Schedule& schedule) {
  if (is_scene(what)) return play(what, schedule);
  const auto seed = static_cast<std::uint64_t>(what.parameters.at("seed"));
  const auto bodies = static_cast<int>(what.parameters.at("bodies"));
  return play(random_sequence(seed, what.steps, bodies), schedule, false).hashes;
}

}  // namespace scree::determinism
