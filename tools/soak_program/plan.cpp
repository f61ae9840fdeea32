// See plan.h.
#include <tools/scenes/golden_file.h>
#include <tools/soak_program/plan.h>

#include <algorithm>
#include <cmath>

namespace scree::soak {
namespace {

// Bodies times steps of a round: a few seconds with the slowest instruction set.
constexpr double kWork = 300'000.0;
constexpr int kFewestSteps = 40;
constexpr int kMostSteps = 400;
constexpr double kWide = 50.0;  // of a parameter's range

struct Range {
  const char* name;
  double low;
  double high;
  bool whole = true;
};

struct Sizes {
  const char* scene;
  std::vector<Range> ranges;
};

const std::vector<Sizes>& all_sizes() {
  static const std::vector<Sizes> kSizes = {
      {"large_pyramid", {{"base", 2, 120}}},
      {"many_pyramids", {{"base", 2, 10}, {"columns", 1, 14}, {"rows", 1, 14}}},
      {"convex_pile", {{"columns", 1, 8}, {"layers", 1, 60}}},
      {"junkyard", {{"columns", 2, 21}, {"layers", 1, 12}}},
      {"pile", {{"bodies", 10, 20000}, {"seed", 0, 1e9}}},
      {"hull_zoo", {{"bodies", 10, 5000}, {"max_vertices", 4, 256}, {"seed", 0, 1e9}}},
      {"stack", {{"bodies", 1, 100}}},
      {"wall", {{"columns", 2, 60}, {"rows", 1, 30}}},
      {"kapla", {{"planks", 4, 150}, {"base", 2, 5}}},
      {"card_house", {{"stories", 1, 8}}},
      {"slope",
       {{"angle", 5, 50, false},
        {"boxes", 1, 40},
        {"friction_max", 0.5, 1.0, false},
        {"friction_min", 0.0, 0.5, false}}},
      {"spheres_in_box", {{"bodies", 1, 20000}, {"seed", 0, 1e9}}},
      {"many_worlds", {{"bodies", 10, 200}, {"seed", 0, 1e9}, {"worlds", 1, 12}}},
      {"joint_grid", {{"columns", 1, 100}, {"rows", 1, 100}}},
      {"chain", {{"links", 1, 1000}, {"weight", 0, 1000, false}}},
      {"bridge", {{"loads", 0, 200}, {"planks", 1, 400}}},
      {"wrecking_ball", {{"columns", 1, 40}, {"links", 1, 100}, {"rows", 1, 30}}},
      {"ragdolls", {{"ragdolls", 1, 400}, {"seed", 0, 1e9}}},
      {"vehicles", {{"cars", 1, 400}}},
      {"motors", {{"machines", 1, 100}}},
      {"card_catapult", {{"stories", 1, 8}}},
      {"large_world", {{"bodies", 10, 50000}, {"interval", 1, 30}, {"seed", 0, 1e9}}},
      {"streaming", {{"blocks", 2, 20}, {"bodies", 10, 500}, {"seed", 0, 1e9}}},
      {"spawning", {{"bodies", 10, 60}, {"life", 1, 200}, {"seed", 0, 1e9}}},
      {"heavy_stack", {{"bodies", 1, 12}, {"ratio", 1, 1000, false}}},
      {"arch", {{"stones", 3, 40}, {"thickness", 0.05, 0.4, false}}},
      {"solver_sampler", {{"solver", 0, 6}}},
      {"wheel_pile", {{"seed", 0, 1e9}, {"wheels", 1, 60}}},
      {"drum", {{"bodies", 1, 8000}}},
      {"terrain", {{"bodies", 1, 5000}, {"seed", 0, 1e9}, {"triangles", 2, 100000}}},
      {"ragdoll_rain", {{"ragdolls", 1, 200}, {"seed", 0, 1e9}, {"triangles", 2, 20000}}},
      {"height_field", {{"bodies", 1, 3000}, {"cells", 1, 50000}, {"seed", 0, 1e9}}},
      {"bullets",
       {{"bullets", 1, 1000},
        {"columns", 1, 40},
        {"rows", 1, 20},
        {"seed", 0, 1e9},
        {"speed", 1, 2000, false}}},
  };
  return kSizes;
}

void vary(WorldSettings& settings, scenes::Random& random) {
  constexpr int kSubsteps[] = {1, 2, 3, 4, 4, 4, 4, 8};
  settings.substeps = kSubsteps[random.below(8)];
  settings.continuous = random.below(4) != 0;
  settings.warm_start = random.below(8) != 0;
  settings.sleeping = random.below(4) != 0;
  settings.sleep_time = random.between(0.05f, 1.0f);
  if (random.below(2) == 0) settings.contact_events = static_cast<ContactEvents>(random.below(8));
}

}  // namespace

scenes::Parameters draw_parameters(const std::string& scene, scenes::Random& random) {
  const auto sizes = std::find_if(all_sizes().begin(), all_sizes().end(),
                                  [&](const Sizes& candidate) { return scene == candidate.scene; });
  if (sizes == all_sizes().end()) throw Error("the soak has no sizes for the scene " + scene);
  const bool large = random.below(12) == 0;
  scenes::Parameters parameters;
  for (const Range& range : sizes->ranges) {
    // Draws wide ranges mostly at their lower end: small scenes take little time and show defects more
    // plainly.
    const double at = static_cast<double>(random.unit());
    const bool wide = range.high - range.low > kWide && !large;
    const double value = range.low + (range.high - range.low) * (wide ? at * at * at * at : at);
    parameters[range.name] = range.whole ? std::floor(value + 0.5) : value;
  }
  return parameters;
}

Plan draw_plan(scenes::Random& random) {
  Plan plan;
  const std::vector<scenes::SceneInfo>& catalog = scenes::catalog();
  const std::string& scene = catalog[random.below(static_cast<std::uint32_t>(catalog.size()))].name;
  const scenes::Parameters parameters = draw_parameters(scene, random);
  plan.name = scene + " " + scenes::text_of(parameters);
  plan.scenes = scenes::build(scene, parameters);
  std::size_t bodies = 0;
  for (scenes::Scene& one : plan.scenes) {
    vary(one.settings, random);
    bodies += one.bodies.size();
  }
  const double affordable = kWork / static_cast<double>(std::max<std::size_t>(bodies, 1));
  const int most = std::clamp(static_cast<int>(affordable), kFewestSteps, kMostSteps);
  plan.steps =
      kFewestSteps + static_cast<int>(random.below(static_cast<std::uint32_t>(most - kFewestSteps + 1)));
  constexpr float kTimeSteps[] = {1.0f / 60.0f, 1.0f / 60.0f, 1.0f / 60.0f, 1.0f / 120.0f, 1.0f / 30.0f};
  plan.dt = {kTimeSteps[random.below(5)]};
  if (random.below(6) == 0) plan.dt = {1.0f / 60.0f, 1.0f / 90.0f, 0.0f, 1.0f / 50.0f};
  plan.pause = 1 + random.below(20);
  plan.keyframe_spacing = 1 + static_cast<int>(random.below(random.below(2) == 0 ? 10u : 150u));
  return plan;
}

}  // namespace scree::soak
