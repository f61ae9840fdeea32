// The reader of scene files as a target.
#include <scree/scree.h>
#include <tests/fuzz/laws.h>
#include <tests/fuzz/memory_watch.h>
#include <tools/scenes/scene_file.h>

#include <optional>

namespace scree::fuzz {

namespace {

constexpr char kFile[] = "fuzz.json";
// A short text can repeat a body ten million times; the target limits repeats.
constexpr std::int64_t kMostBodies = 2000;
// Larger worlds are only populated: a step of many bodies in one place takes seconds with sanitizers.
constexpr std::size_t kMostSteppedBodies = 40, kMostSteppedShapesOfScene = 80, kMostSteppedJoints = 80;
constexpr int kSteps = 3;

// "fuzz.json:LINE:COLUMN: not JSON: ..." or "fuzz.json: PLACE: ...", where the place is a JSON pointer or the
// document.
bool names_place(const std::string& message, std::size_t bytes) {
  const std::string file = kFile;
  if (message.rfind(file + ": /", 0) == 0) return message.find(": ", file.size() + 2) != std::string::npos;
  if (message.rfind(file + ": the document: ", 0) == 0) return true;
  const std::size_t column = message.find(':', file.size() + 1);
  return column != std::string::npos &&
         names_offset(message.substr(0, column + 2), file + ":", ":", bytes + 1) &&
         names_offset(message, message.substr(0, column + 1), ": not JSON: ", bytes + 2);
}

std::size_t shapes_of(const scenes::Scene& scene) {
  std::size_t shapes = 0;
  for (const scenes::SceneBody& body : scene.bodies) shapes += body.shape_count;
  return shapes;
}

// A body's mass is made anew with each of its shapes, so that a body of n shapes takes n * n / 2 of their
// masses.
bool is_quickly_populated(const scenes::Scene& scene) {
  constexpr std::uint64_t kMostMasses = 10'000'000;
  std::uint64_t masses = 0;
  for (const scenes::SceneBody& body : scene.bodies)
    masses += std::uint64_t{body.shape_count} * body.shape_count / 2;
  return masses <= kMostMasses;
}

std::optional<scenes::Scene> read(Input input) {
  const std::string text(input.begin(), input.end());
  const MemoryWatch memory;
  std::optional<scenes::Scene> scene;
  try {
    scene = scenes::parse_scene(text, kFile, kMostBodies);
  } catch (const Error& error) {
    require(names_place(error.what(), text.size()),
            std::string("a refusal without a place: ") + error.what());
  }
  memory.require_within(kSceneBound, text.size(), "parse_scene");
  return scene;
}

}  // namespace

void scene_target(Input input) {
  const std::optional<scenes::Scene> scene = read(input);
  if (!scene) return;
  require(scene->bodies.size() <= static_cast<std::size_t>(kMostBodies),
          "there are more bodies than allowed");
  require(scene->joints.size() <= static_cast<std::size_t>(kMostBodies),
          "there are more joints than allowed");
  if (!is_quickly_populated(*scene)) return;
  World world(scene->settings);
  try {
    scenes::populate(world, *scene);
  } catch (const Error& error) {
    throw BrokenLaw(std::string("no world takes a scene that was accepted: ") + error.what());
  }
  require(world.body_count() == scene->bodies.size(), "bodies are missing");
  require(world.joint_count() == scene->joints.size(), "joints are missing");
  if (scene->bodies.size() > kMostSteppedBodies || shapes_of(*scene) > kMostSteppedShapesOfScene ||
      scene->joints.size() > kMostSteppedJoints)
    return;
  require_laws_of_steps(world, scene->dt, kSteps);
}

}  // namespace scree::fuzz
