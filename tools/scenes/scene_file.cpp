// Scene files -> scenes. README.md beside this file states the schema.
#include <tools/scenes/angles.h>
#include <tools/scenes/scene_file.h>
#include <tools/scenes/scene_file_parts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>

namespace scree::scenes {

Range between(float low, float high) {
  const auto decimal = [](float limit) {
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", double{limit});
    return std::strtod(text, nullptr);
  };
  return {decimal(low), decimal(high)};
}

Quat read_rotation(const Node& node) {
  if (node.is_object()) {
    Members members(node);
    const Vec3 axis = members.require("axis").vector({-1e6, 1e6});
    if (axis == Vec3{}) members.require("axis").fail("must not be zero");
    const double degrees = members.require("degrees").precise_number({-1e6, 1e6});
    members.finish();
    return rotation_about(axis, degrees);
  }
  if (!node.is_array())
    node.fail("expected a quaternion [x, y, z, w] or {\"axis\": [x, y, z], \"degrees\": d}");
  const std::vector<Node> parts = node.elements(4, "numbers (x, y, z, w)");
  constexpr Range kUnit{-2.0, 2.0};  // its length is checked, too
  const Quat q{parts[0].number(kUnit), parts[1].number(kUnit), parts[2].number(kUnit),
               parts[3].number(kUnit)};
  const double length = std::sqrt(static_cast<double>(q.x) * q.x + static_cast<double>(q.y) * q.y +
                                  static_cast<double>(q.z) * q.z + static_cast<double>(q.w) * q.w);
  if (!(std::abs(length - 1.0) <= double{kUnitTolerance}))
    node.fail("a quaternion must have length 1 within 0.001");
  return q;
}

void read_rotation(Members& members, Quat& out) {
  if (const Node* node = members.find("rotation")) out = read_rotation(*node);
}

namespace {

// The library's own limits. Checking them here lets errors name the place.
const Range kLength = between(kMinExtent, kMaxExtent);  // m, of shapes
const Range kRounding = between(0.0f, kMaxExtent);      // m, of boxes and hulls
const Range kHullPoint = within(kMaxExtent);            // m
const Range kHullScale = between(kMinHullScale, kMaxHullScale);
const Range kPosition = within(kMaxPosition);            // m
const Range kLocalPosition = within(kMaxLocalPosition);  // m
const Range kSpeed = within(kMaxSpeed);                  // m/s, rad/s
const Range kDamping = up_to(kMaxRate);                  // 1/s
const Range kGravityFactor = within(kMaxGravityFactor);
const Range kMass = between(kMinMass, kMaxMass);  // kg
const Range kFriction = up_to(kMaxFriction);
const Range kPatchRadius = up_to(kMaxPatchRadius);              // m
const Range kRollingResistance = up_to(kMaxRollingResistance);  // m
const Range kDensityRange = between(kMinDensity, kMaxDensity);  // kg/m^3
const Range kSurfaceVelocity = within(kMaxSurfaceSpeed);        // m/s
constexpr std::int64_t kMostSteps = 1'000'000'000;

using Materials = std::map<std::string, Material>;
using NamedHulls = std::map<std::string, Hull>;
using NamedShapes = std::map<std::string, SceneShape>;

// The objects that shapes may name.
struct Named {
  Materials materials;
  NamedHulls hulls;
  NamedShapes shapes;
  MeshReader& meshes;
};

void read_mix(Members& members, const char* key, MixRule& out) {
  constexpr const char* kRules[] = {"minimum", "average", "product", "geometric_mean", "maximum"};
  if (const Node* node = members.find(key)) out = static_cast<MixRule>(node->choice(kRules));
}

Material read_material(const Node& node) {
  Material material;
  Members members(node);
  members.read("friction", material.friction, kFriction);
  members.read("restitution", material.restitution, {0.0, 1.0});
  members.read("rolling_resistance", material.rolling_resistance, kRollingResistance);
  if (const Node* radius = members.find("patch_radius")) {
    material.patch_radius = radius->number(kPatchRadius);
  }
  members.read("density", material.density, kDensityRange);
  members.read("surface_velocity", material.surface_velocity, kSurfaceVelocity);
  read_mix(members, "friction_mix", material.friction_mix);
  read_mix(members, "restitution_mix", material.restitution_mix);
  members.finish();
  return material;
}

Filter read_filter(const Node& node) {
  Filter filter;
  Members members(node);
  constexpr std::int64_t kMostBits = 0xffffffff;
  if (const Node* bits = members.find("category")) {
    filter.category = static_cast<std::uint32_t>(bits->integer(0, kMostBits));
  }
  if (const Node* bits = members.find("mask")) {
    filter.mask = static_cast<std::uint32_t>(bits->integer(0, kMostBits));
  }
  if (const Node* group = members.find("group")) {
    filter.group = static_cast<std::int32_t>(group->integer(-0x7fffffff, 0x7fffffff));
  }
  members.finish();
  return filter;
}

Hull read_hull(const Node& node) {
  Members members(node);
  std::vector<Vec3> points;
  for (const Node& point : members.require("points").elements()) points.push_back(point.vector(kHullPoint));
  HullOptions options;
  members.read("max_vertices", options.max_vertices, 4, options.max_vertices);
  members.finish();
  try {
    return Hull(points, options);
  } catch (const Error& error) {
    node.fail(error.what());
  }
}

ConvexHull read_convex_hull(Members& members, const NamedHulls& named) {
  ConvexHull convex;
  const Node& hull = members.require("hull");
  if (hull.is_string()) {
    const auto found = named.find(hull.string());
    if (found == named.end()) hull.fail("no hull \"" + hull.string() + "\" in /hulls; " + known_names(named));
    convex.hull = found->second;
  } else if (hull.is_object()) {
    convex.hull = read_hull(hull);
  } else {
    hull.fail("expected the name of a hull or an object");
  }
  members.read("scale", convex.scale, kHullScale);
  members.read("rounding", convex.rounding, kRounding);
  return convex;
}

Geometry read_geometry(Members& members, const Named& named) {
  constexpr const char* kTypes[] = {"sphere", "capsule",    "box",      "hull",
                                    "mesh",   "half_space", "cylinder", "cone"};
  switch (members.require("type").choice(kTypes)) {
    case 0:
      return Sphere{members.require("radius").number(kLength)};
    case 1: {
      const float half_height = members.require("half_height").number(kLength);
      return Capsule{half_height, members.require("radius").number(kLength)};
    }
    case 3:
      return read_convex_hull(members, named.hulls);
    case 4:
      return named.meshes.read(members);
    case 5:
      return HalfSpace{};
    case 6: {
      const float half_height = members.require("half_height").number(kLength);
      return Cylinder{half_height, members.require("radius").number(kLength)};
    }
    case 7: {
      const float half_height = members.require("half_height").number(kLength);
      return Cone{half_height, members.require("radius").number(kLength)};
    }
    default: {
      Box box{members.require("half_extents").vector(kLength)};
      members.read("rounding", box.rounding, kRounding);
      return box;
    }
  }
}

SceneShape read_shape(const Node& node, const Named& named) {
  if (node.is_string()) {
    const auto found = named.shapes.find(node.string());
    if (found == named.shapes.end()) {
      node.fail("no shape \"" + node.string() + "\" in /shapes; " + known_names(named.shapes));
    }
    return found->second;
  }
  if (!node.is_object()) node.fail("expected the name of a shape or an object");
  SceneShape shape;
  Members members(node);
  shape.geometry = read_geometry(members, named);
  if (const Node* material = members.find("material")) {
    if (material->is_string()) {
      const auto found = named.materials.find(material->string());
      if (found == named.materials.end()) {
        material->fail("no material \"" + material->string() + "\" in /materials; " +
                       known_names(named.materials));
      }
      shape.material = found->second;
    } else if (material->is_object()) {
      shape.material = read_material(*material);
    } else {
      material->fail("expected the name of a material or an object");
    }
  }
  members.read("position", shape.options.local_pose.position, kLocalPosition);
  read_rotation(members, shape.options.local_pose.rotation);
  if (const Node* filter = members.find("filter")) shape.options.filter = read_filter(*filter);
  if (const Node* data = members.find("user_data")) shape.options.user_data = data->bits64();
  if (const Node* sensor = members.find("sensor")) shape.options.sensor = sensor->boolean();
  members.finish();
  return shape;
}

AxisLocks read_locks(const Node& node) {
  constexpr const char* kLocks[] = {"translation_x", "translation_y", "translation_z",
                                    "rotation_x",    "rotation_y",    "rotation_z"};
  AxisLocks locks = AxisLocks::none;
  for (const Node& element : node.elements()) {
    locks = locks | static_cast<AxisLocks>(1u << element.choice(kLocks));
  }
  return locks;
}

BodyDef read_body_def(Members& members) {
  constexpr const char* kTypes[] = {"fixed", "kinematic", "dynamic"};
  BodyDef def;
  if (const Node* type = members.find("type")) def.type = static_cast<BodyType>(type->choice(kTypes));
  members.read("position", def.position, kPosition);
  read_rotation(members, def.rotation);
  members.read("linear_velocity", def.linear_velocity, kSpeed);
  members.read("angular_velocity", def.angular_velocity, kSpeed);
  members.read("linear_damping", def.linear_damping, kDamping);
  members.read("angular_damping", def.angular_damping, kDamping);
  members.read("gravity_factor", def.gravity_factor, kGravityFactor);
  if (const Node* locks = members.find("locks")) def.locks = read_locks(*locks);
  if (const Node* mass = members.find("mass")) def.mass = mass->number(kMass);
  members.read("can_sleep", def.can_sleep);
  members.read("full_sweep", def.full_sweep);
  if (const Node* data = members.find("user_data")) def.user_data = data->bits64();
  return def;
}

struct Repeat {
  std::array<std::int64_t, 3> count{1, 1, 1};
  Vec3 spacing;
};

Repeat read_repeat(const Node& node, std::int64_t most_bodies) {
  Repeat repeat;
  Members members(node);
  const Node& count = members.require("count");
  const std::vector<Node> counts = count.elements(3, "whole numbers");
  for (std::size_t axis = 0; axis < 3; ++axis) repeat.count[axis] = counts[axis].integer(1, most_bodies);
  const double total = static_cast<double>(repeat.count[0]) * static_cast<double>(repeat.count[1]) *
                       static_cast<double>(repeat.count[2]);
  if (total > static_cast<double>(most_bodies)) {
    count.fail("more than " + std::to_string(most_bodies) + " bodies");
  }
  repeat.spacing = members.require("spacing").vector(kPosition);
  members.finish();
  return repeat;
}

// Some limits concern sums, such as mass and inertia of all shapes, which only a world can check: one world
// for all bodies, in turn.
class Trial {
 public:
  void run(const Node& node, const BodyDef& def, std::span<const SceneShape> shapes) {
    try {
      const BodyId body = world_.create_body(def);
      for (const SceneShape& shape : shapes) {
        world_.add_shape(body, shape.geometry, shape.material, shape.options);
      }
      world_.destroy_body(body);
    } catch (const Error& error) {
      node.fail(error.what());
    }
  }

 private:
  World world_;
};

// The body at every place of the grid; x runs fastest, then y, then z.
void add_repeated(Scene& scene, const Node& body, const BodyDef& def, std::uint32_t first_shape,
                  std::uint32_t shape_count, const Repeat& repeat, std::int64_t most_bodies) {
  const double total = static_cast<double>(repeat.count[0] * repeat.count[1] * repeat.count[2]);
  if (static_cast<double>(scene.bodies.size()) + total > static_cast<double>(most_bodies)) {
    body.fail("with this body the scene has more than " + std::to_string(most_bodies) + " bodies");
  }
  if (total > static_cast<double>(scene.bodies.size())) {  // else room for many comes by itself
    scene.bodies.reserve(scene.bodies.size() + static_cast<std::size_t>(total));
  }
  for (std::int64_t z = 0; z < repeat.count[2]; ++z) {
    for (std::int64_t y = 0; y < repeat.count[1]; ++y) {
      for (std::int64_t x = 0; x < repeat.count[0]; ++x) {
        SceneBody copy{def, first_shape, shape_count};
        copy.def.position.x += static_cast<float>(x) * repeat.spacing.x;
        copy.def.position.y += static_cast<float>(y) * repeat.spacing.y;
        copy.def.position.z += static_cast<float>(z) * repeat.spacing.z;
        scene.bodies.push_back(copy);
      }
    }
  }
  const Vec3 last = scene.bodies.back().def.position;
  for (const float component : {last.x, last.y, last.z}) {
    if (!(std::abs(component) <= kMaxPosition))
      body.fail("the repeats reach further than 1e7 m from the origin");
  }
}

void read_name(const Node& node, std::uint32_t first, BodyNames& names) {
  const std::string name = node.string();
  if (name == kWorldName) node.fail("\"world\" is the world itself");
  if (!names.emplace(name, NamedBodies{first}).second) node.fail("two bodies have this name");
}

// Adds the bodies of an array to the scene.
class BodyReader {
 public:
  BodyReader(const Named& named, std::int64_t most_bodies, BodyNames& names, Scene& scene)
      : named_(named), most_bodies_(most_bodies), names_(names), scene_(scene) {}

  void read(const Node& node) {
    Members members(node);
    const auto first_body = static_cast<std::uint32_t>(scene_.bodies.size());
    const Node* name = members.find("name");
    if (name != nullptr) read_name(*name, first_body, names_);
    const BodyDef def = read_body_def(members);
    const std::size_t first_shape = scene_.shapes.size();
    if (const Node* shapes = members.find("shapes")) {
      for (const Node& shape : shapes->elements()) scene_.shapes.push_back(read_shape(shape, named_));
    }
    Repeat repeat;
    if (const Node* grid = members.find("repeat")) repeat = read_repeat(*grid, most_bodies_);
    members.finish();
    const std::span<const SceneShape> shapes = std::span(scene_.shapes).subspan(first_shape);
    trial_.run(node, def, shapes);
    add_repeated(scene_, node, def, static_cast<std::uint32_t>(first_shape),
                 static_cast<std::uint32_t>(shapes.size()), repeat, most_bodies_);
    if (name != nullptr) {
      names_[name->string()].count = static_cast<std::int64_t>(scene_.bodies.size() - first_body);
    }
  }

 private:
  const Named& named_;
  std::int64_t most_bodies_;
  BodyNames& names_;
  Scene& scene_;
  Trial trial_;
};

Solver read_solver(const Node& node) {
  std::array<const char*, kSolverCount> names{};
  for (int i = 0; i < kSolverCount; ++i)
    names[static_cast<std::size_t>(i)] = solver_name(static_cast<Solver>(i));
  return static_cast<Solver>(node.choice(names));
}

void read_solver_options(const Node& node, SolverOptions& options) {
  Members members(node);
  members.read("iterations", options.iterations, 1, kMaxIterations);
  members.read("tolerance", options.tolerance, up_to(kMaxTolerance));
  members.read("relaxation", options.relaxation, up_to(kMaxRelaxation));
  members.read("baumgarte", options.baumgarte, up_to(1.0f));
  members.read("slop", options.slop, up_to(kMaxSlop));
  if (const Node* seed = members.find("shuffle_seed"))
    options.shuffle_seed = static_cast<std::uint32_t>(seed->integer(0, 0xffffffff));
  members.read("points_together", options.points_together);
  members.finish();
}

void read_settings(const Node& node, WorldSettings& settings) {
  Members members(node);
  members.read("substeps", settings.substeps, 1, kMaxSubsteps);
  members.read("contact_hertz", settings.contact_hertz, between(kMinHertz, kMaxHertz));
  members.read("contact_damping_ratio", settings.contact_damping_ratio, up_to(kMaxDampingRatio));
  members.read("push_speed", settings.push_speed, up_to(kMaxRate));
  members.read("restitution_threshold", settings.restitution_threshold, up_to(kMaxThreshold));
  members.read("max_linear_speed", settings.max_linear_speed, between(kMinSpeedLimit, kMaxSpeedLimit));
  members.read("max_angular_speed", settings.max_angular_speed, between(kMinSpeedLimit, kMaxSpeedLimit));
  members.read("warm_start", settings.warm_start);
  members.read("continuous", settings.continuous);
  members.read("sleeping", settings.sleeping);
  members.read("sleep_linear_speed", settings.sleep_linear_speed, up_to(kMaxThreshold));
  members.read("sleep_angular_speed", settings.sleep_angular_speed, up_to(kMaxThreshold));
  members.read("sleep_time", settings.sleep_time, up_to(kMaxThreshold));
  if (const Node* solver = members.find("solver")) settings.solver = read_solver(*solver);
  if (const Node* options = members.find("solver_options"))
    read_solver_options(*options, settings.solver_options);
  members.finish();
}

}  // namespace

Scene parse_scene(const std::string& source, const std::string& file, std::int64_t most_bodies,
                  const std::optional<std::string>& folder) {
  const nlohmann::json document = parse_json(source, file);
  const Node root(document, file);
  Members members(root);
  Scene scene;
  scene.name = std::filesystem::path(file).stem().string();
  members.read("name", scene.name);
  members.read("gravity", scene.settings.gravity, within(kMaxGravity));
  if (const Node* settings = members.find("settings")) read_settings(*settings, scene.settings);
  if (const Node* steps = members.find("steps")) {
    scene.steps = static_cast<int>(steps->integer(1, kMostSteps));
  }
  members.read("dt", scene.dt, {0.0, 1.0});
  MeshReader meshes(folder);
  Named named{{}, {}, {}, meshes};
  if (const Node* list = members.find("materials")) {
    for (const auto& [name, node] : list->members()) named.materials[name] = read_material(node);
  }
  if (const Node* list = members.find("hulls")) {
    for (const auto& [name, node] : list->members()) named.hulls[name] = read_hull(node);
  }
  if (const Node* list = members.find("shapes")) {
    NamedShapes shapes;  // shapes may not name each other
    for (const auto& [name, node] : list->members()) {
      if (!node.is_object()) node.fail("expected an object");
      shapes[name] = read_shape(node, named);
    }
    named.shapes = std::move(shapes);
  }
  const Node& bodies = members.require("bodies");
  const Node* joints = members.find("joints");
  members.finish();
  BodyNames names;
  BodyReader reader(named, most_bodies, names, scene);
  for (const Node& body : bodies.elements()) reader.read(body);
  if (joints != nullptr) read_joints(*joints, names, most_bodies, scene);
  return scene;
}

Scene read_scene_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  // A directory opens and then fails to read.
  if (!stream || std::filesystem::is_directory(path) || !(text << stream.rdbuf())) {
    throw Error(path + ": cannot be read, or is empty");
  }
  return parse_scene(text.str(), path, kMostBodies, std::filesystem::path(path).parent_path().string());
}

}  // namespace scree::scenes
