// The catalog of built-in scenes: names, parameters, their limits, and the parts that builders share.
#include <tools/scenes/builders.h>
#include <tools/scenes/frames.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace scree::scenes {
namespace {

struct ParameterRule {
  const char* name;
  double value;  // default
  double low;
  double high;
  bool whole = true;
};

struct Entry {
  const char* name;
  const char* summary;
  std::vector<ParameterRule> parameters;
  std::vector<Scene> (*build)(const Parameters& parameters);
};

template <Scene (*builder)(const Parameters&)>
std::vector<Scene> one_world(const Parameters& parameters) {
  std::vector<Scene> worlds;
  worlds.push_back(builder(parameters));
  return worlds;
}

constexpr double kMostOfScene = 1e7;      // about 5 GB of world; more is surely a typing error
constexpr double kMostSeed = 0x1p53 - 1;  // whole numbers that a double holds exactly

const std::vector<Entry>& entries() {
  static const std::vector<Entry> kEntries = {
      {"large_pyramid",
       "one pyramid of boxes, 100 wide at its base: 5050 boxes, 14,950 contacts",
       {{"base", 100, 1, 1000}},
       one_world<large_pyramid>},
      {"many_pyramids",
       "14 x 14 small pyramids of boxes, 10 wide: 10,780 boxes, 28,420 contacts",
       {{"base", 10, 1, 100}, {"columns", 14, 1, 100}, {"rows", 14, 1, 100}},
       one_world<many_pyramids>},
      {"convex_pile",
       "a tower of 5120 copies of one hull of 32 corners that collapses into a pile",
       {{"columns", 8, 1, 100}, {"layers", 80, 1, 1000}},
       one_world<convex_pile>},
      {"junkyard",
       "10,584 rocks dropped into a walled yard, where a prism drives through them",
       {{"columns", 21, 1, 21}, {"layers", 24, 1, 1000}},
       one_world<junkyard>},
      {"pile",
       "mixed boxes, spheres, capsules and hulls poured into a walled pit",
       {{"bodies", 20000, 10, kMostOfScene}, {"seed", 1, 0, kMostSeed}},
       one_world<pile>},
      {"hull_zoo",
       "hulls of 4 to 256 corners, slivers, plates and needles in one pile",
       {{"bodies", 2000, 10, kMostOfScene}, {"max_vertices", 256, 4, 256}, {"seed", 1, 0, kMostSeed}},
       one_world<hull_zoo>},
      {"stack", "boxes of 1 m, one on top of the other", {{"bodies", 100, 1, 10000}}, one_world<stack>},
      {"wall",
       "a brick wall in running bond",
       {{"columns", 40, 1, 1000}, {"rows", 20, 1, 1000}},
       one_world<wall>},
      {"kapla",
       "a tower of crossed planks",
       {{"planks", 102, 1, kMostOfScene}, {"base", 4, 2, 5}},
       one_world<kapla>},
      {"card_house",
       "a house of cards 1 cm thick, leaning pairs under flat ones",
       {{"stories", 4, 1, 20}},
       one_world<card_house>},
      {"slope",
       "boxes of several frictions on a ramp; those below tan(angle) slide",
       {{"angle", 20, 0, 60, false},
        {"boxes", 11, 1, 1000},
        {"friction_max", 0.6, 0, 10, false},
        {"friction_min", 0.1, 0, 10, false}},
       one_world<slope>},
      {"spheres_in_box",
       "equal spheres dropped into a closed box",
       {{"bodies", 1000, 1, kMostOfScene}, {"seed", 1, 0, kMostSeed}},
       one_world<spheres_in_box>},
      {"many_worlds",
       "independent small piles, each a world of its own",
       {{"bodies", 100, 10, 100000}, {"seed", 1, 0, kMostSeed - 100000}, {"worlds", 1000, 1, 100000}},
       many_worlds},
      {"joint_grid",
       "a net of 100 x 100 spheres on ball joints that hangs from its upper row: 19,800 joints",
       {{"columns", 100, 1, 1000}, {"rows", 100, 1, 1000}},
       one_world<joint_grid>},
      {"chain",
       "a chain that is let go level, with a weight of as many links at its end as one likes",
       {{"links", 100, 1, 100000}, {"weight", 0, 0, 1e6, false}},
       one_world<chain>},
      {"bridge",
       "a hanging bridge of hinged planks under falling loads",
       {{"loads", 12, 0, 10000}, {"planks", 40, 1, 10000}},
       one_world<bridge>},
      {"wrecking_ball",
       "a ball of 17 t on a chain swings into a brick wall",
       {{"columns", 20, 1, 1000}, {"links", 16, 1, 1000}, {"rows", 16, 1, 1000}},
       one_world<wrecking_ball>},
      {"ragdolls",
       "humans of 14 capsules on balls and hinges with limits, dropped into a pit",
       {{"ragdolls", 100, 1, 100000}, {"seed", 1, 0, kMostSeed}},
       one_world<ragdolls>},
      {"vehicles",
       "cars with sprung, driven and steered wheels on their way over bumps",
       {{"cars", 32, 1, 10000}},
       one_world<vehicles>},
      {"motors",
       "machines with every kind of joint: gears, racks, cranks, pulleys, shafts, springs",
       {{"machines", 8, 1, 10000}},
       one_world<motors>},
      {"card_catapult",
       "a sprung lever throws a stone at a house of cards",
       {{"stories", 4, 1, 20}},
       one_world<card_catapult>},
      {"large_world",
       "a plain of 1,000,000 fixed boxes onto which balls drop one at a time and fall asleep",
       {{"bodies", 1000000, 10, kMostOfScene}, {"interval", 10, 1, 1000}, {"seed", 1, 0, kMostSeed}},
       one_world<large_world>},
      {"streaming",
       "blocks of fixed boxes that come ahead of a camera and go behind it, once a second",
       {{"blocks", 40, 2, 1000}, {"bodies", 1000, 10, 10000}, {"seed", 1, 0, kMostSeed}},
       one_world<streaming>},
      {"spawning",
       "in every step 100 bodies come into a pit and the 100 oldest go",
       {{"bodies", 100, 10, 1000}, {"life", 100, 1, 1000}, {"seed", 1, 0, kMostSeed}},
       one_world<spawning>},
      {"heavy_stack",
       "a heavy box on light ones",
       {{"bodies", 5, 1, 1000}, {"ratio", 1000, 1e-3, 1e5, false}},
       one_world<heavy_stack>},
      {"arch",
       "a half circle of stones, by its own weight; below a thickness of 0.107 of the radius none stands",
       {{"stones", 21, 3, 1001}, {"thickness", 0.2, 0.01, 1, false}},
       one_world<arch>},
      {"solver_sampler",
       "a heavy stack, a small arch, a chain and balls, solved by a method by its number",
       {{"solver", 0, 0, kSolverCount - 1}},
       one_world<solver_sampler>},
      {"wheel_pile",
       "wheels of 37 hulls each, dropped into a pit",
       {{"seed", 1, 0, kMostSeed}, {"wheels", 300, 1, 100000}},
       one_world<wheel_pile>},
      {"drum",
       "small boxes in a drum with paddles that turns slowly",
       {{"bodies", 8000, 1, kMostOfScene}},
       one_world<drum>},
      {"terrain",
       "mixed bodies rain on hills, a mesh of 200,000 triangles",
       {{"bodies", 5000, 1, kMostOfScene}, {"seed", 1, 0, kMostSeed}, {"triangles", 200000, 2, 1e7}},
       one_world<terrain>},
      {"ragdoll_rain",
       "humans of 14 capsules rain on hills, a mesh of 20,000 triangles",
       {{"ragdolls", 200, 1, 100000}, {"seed", 1, 0, kMostSeed}, {"triangles", 20000, 2, 1e7}},
       one_world<ragdoll_rain>},
      {"height_field",
       "mixed bodies rain on hills with holes, a height field of 100,000 cells",
       {{"bodies", 5000, 1, kMostOfScene}, {"cells", 100000, 1, 5e6}, {"seed", 1, 0, kMostSeed}},
       one_world<height_field>},
      {"bullets",
       "bullets on a wall of bricks, on a plate of 1 cm, and on each other",
       {{"bullets", 400, 1, kMostOfScene},
        {"columns", 16, 1, 1000},
        {"rows", 10, 1, 1000},
        {"seed", 1, 0, kMostSeed},
        {"speed", 1000, 1, 1e4, false}},
       one_world<bullets>},
  };
  return kEntries;
}

std::string text(double value) {
  std::ostringstream out;
  out.precision(15);
  out << value;
  return out.str();
}

template <class List, class Name>
std::string join(const List& list, Name name) {
  std::string joined;
  for (const auto& item : list) joined += (joined.empty() ? "" : ", ") + std::string(name(item));
  return joined;
}

const Entry& find_entry(const std::string& name) {
  for (const Entry& entry : entries()) {
    if (name == entry.name) return entry;
  }
  throw Error("unknown scene \"" + name +
              "\"; there are: " + join(entries(), [](const Entry& entry) { return entry.name; }));
}

void check_value(const Entry& entry, const ParameterRule& rule, double value) {
  const std::string start =
      "scene " + std::string(entry.name) + ": " + rule.name + " = " + text(value) + " must be ";
  if (rule.whole && value != std::floor(value)) throw Error(start + "a whole number");
  // Written so that NaN fails the check.
  if (!(value >= rule.low && value <= rule.high)) {
    throw Error(start + "from " + text(rule.low) + " to " + text(rule.high));
  }
}

// The defaults overlaid with what the caller gave.
Parameters complete(const Entry& entry, const Parameters& given) {
  Parameters all;
  for (const ParameterRule& rule : entry.parameters) all[rule.name] = rule.value;
  for (const auto& [name, value] : given) {
    const auto rule =
        std::find_if(entry.parameters.begin(), entry.parameters.end(),
                     [&, &asked = name](const ParameterRule& candidate) { return asked == candidate.name; });
    if (rule == entry.parameters.end()) {
      throw Error("scene " + std::string(entry.name) + " has no parameter \"" + name + "\"; it has: " +
                  join(entry.parameters, [](const ParameterRule& candidate) { return candidate.name; }));
    }
    check_value(entry, *rule, value);
    all[name] = value;
  }
  return all;
}

}  // namespace

const std::vector<SceneInfo>& catalog() {
  static const std::vector<SceneInfo> kCatalog = [] {
    std::vector<SceneInfo> list;
    for (const Entry& entry : entries()) list.push_back({entry.name, entry.summary, complete(entry, {})});
    return list;
  }();
  return kCatalog;
}

void check(const std::string& name, const Parameters& parameters) { complete(find_entry(name), parameters); }

std::vector<Scene> build(const std::string& name, const Parameters& parameters) {
  const Entry& entry = find_entry(name);
  return entry.build(complete(entry, parameters));
}

Scene start_scene(const char* name, int steps) {
  Scene scene;
  scene.name = name;
  scene.settings.gravity = {0.0f, -10.0f, 0.0f};
  scene.steps = steps;
  return scene;
}

std::uint32_t add_shape(Scene& scene, const Geometry& geometry, const Material& material,
                        const ShapeOptions& options) {
  scene.shapes.push_back({geometry, material, options});
  return static_cast<std::uint32_t>(scene.shapes.size() - 1);
}

std::uint32_t add_body(Scene& scene, const BodyDef& def, std::uint32_t first_shape,
                       std::uint32_t shape_count) {
  scene.bodies.push_back({def, first_shape, shape_count});
  return static_cast<std::uint32_t>(scene.bodies.size() - 1);
}

void add_joint(Scene& scene, std::uint32_t body_a, std::uint32_t body_b, const Joint& joint,
               const JointDef& def) {
  scene.joints.push_back({def, joint, body_a, body_b});
}

void add_joint_at(Scene& scene, std::uint32_t body_a, std::uint32_t body_b, const Pose& place,
                  const Joint& joint, JointDef def) {
  const auto frame_in = [&](std::uint32_t body) {
    if (body == kWorldItself) return place;
    const BodyDef& at = scene.bodies[body].def;
    return seen_from({at.position, at.rotation}, place);
  };
  def.frame_a = frame_in(body_a);
  def.frame_b = frame_in(body_b);
  add_joint(scene, body_a, body_b, joint, def);
}

void add_ground(Scene& scene, float half_width, const Material& material) {
  const std::uint32_t shape = add_shape(scene, Box{{half_width, 1.0f, half_width}}, material);
  add_body(scene, {.type = BodyType::fixed, .position = {0.0f, -1.0f, 0.0f}}, shape);
}

void add_pit(Scene& scene, float half_width, float height, bool lid) {
  constexpr float kThick = 1.0f;  // m, half: no body that falls 50 m crosses it within a step
  const float outer = half_width + 2.0f * kThick;
  const auto add = [&](Vec3 half_extents, Vec3 position) {
    return add_shape(scene, Box{half_extents}, {}, {.local_pose = {position, {}}});
  };
  const std::uint32_t first = add({outer, kThick, outer}, {0.0f, -kThick, 0.0f});
  for (const float side : {-1.0f, 1.0f}) {
    const float center = side * (half_width + kThick);
    add({kThick, 0.5f * height, outer}, {center, 0.5f * height, 0.0f});
    add({half_width, 0.5f * height, kThick}, {0.0f, 0.5f * height, center});
  }
  if (lid) add({outer, kThick, outer}, {0.0f, height + kThick, 0.0f});
  add_body(scene, {.type = BodyType::fixed}, first, lid ? 6 : 5);
}

int whole(const Parameters& parameters, const char* name) { return static_cast<int>(parameters.at(name)); }
float real(const Parameters& parameters, const char* name) { return static_cast<float>(parameters.at(name)); }

}  // namespace scree::scenes
