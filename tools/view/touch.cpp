// See touch.h.
#include <tools/view/touch.h>

#include <cmath>
#include <limits>
#include <vector>

namespace scree::view {
namespace {

Vec3 vector_of(const Json& what, const char* name) {
  const Json& list = what.at(name);
  if (!list.is_array() || list.size() != 3) throw Error(std::string(name) + " must be three numbers");
  return {list[0].get<float>(), list[1].get<float>(), list[2].get<float>()};
}

BodyId body_of(const World& world, const Json& what) {
  const auto index = what.at("body").get<std::uint32_t>();
  const BodyId body = index < world.poses().size() ? world.body_at(index) : BodyId{};
  if (!world.is_alive(body)) throw Error("there is no body " + std::to_string(index) + " at this step");
  return body;
}

constexpr std::uint64_t kHeld = 0x7363726565766965;  // JointDef::user_data of what a page holds

void release(World& world, JointId& held) {
  if (world.is_alive(held)) world.destroy_joint(held);
  held = {};
}

void drag(World& world, const Json& what, JointId& held) {
  const BodyId body = body_of(world, what);
  if (world.body_type(body) != BodyType::dynamic)
    throw Error("body " + std::to_string(body.index) + " is not dynamic and cannot be dragged");
  const Vec3 point = vector_of(what, "point");
  // Strong enough to lift the body and some of what lies on it.
  constexpr float kAcceleration = 300.0f;  // m/s^2
  const MouseJoint mouse{.target = point, .max_force = kAcceleration * world.mass_properties(body).mass};
  const JointId joint = world.create_joint({.body_a = kWorld,
                                            .body_b = body,
                                            .frame_a = {point, {}},
                                            .frame_b = {transform_back(world.pose(body), point), {}},
                                            .user_data = kHeld},
                                           mouse);
  release(world, held);
  held = joint;
}

void move(World& world, const Json& what, JointId held) {
  if (!world.is_alive(held)) return;  // the body is gone
  auto mouse = std::get<MouseJoint>(world.joint(held));
  mouse.target = vector_of(what, "to");
  world.set_joint(held, mouse);
}

void shoot(World& world, const Json& what) {
  const float speed = what.value("speed", 30.0f), radius = what.value("radius", 0.25f);
  const Vec3 direction = normalize(vector_of(what, "toward"));
  const BodyDef ball{.position = vector_of(what, "from"), .linear_velocity = speed * direction};
  const Geometry shape = Sphere{radius};
  BodyId body;
  world.create_bodies({&ball, 1}, {&shape, 1}, {.density = what.value("density", 500.0f)}, {}, {&body, 1});
}

Solver solver_called(const std::string& name) {
  for (int i = 0; i < kSolverCount; ++i) {
    if (name == solver_name(static_cast<Solver>(i))) return static_cast<Solver>(i);
  }
  throw Error("there is no solver " + name);
}

// Calls change(material) for all shapes.
template <class Change>
void change_materials(World& world, const Change& change) {
  std::vector<ShapeId> shapes;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (!world.is_alive(body)) continue;
    shapes.resize(world.shapes_of(body, {}));
    world.shapes_of(body, shapes);
    for (const ShapeId shape : shapes) {
      Material material = world.material(shape);
      change(material);
      world.set_material(shape, material);
    }
    if (world.body_type(body) == BodyType::dynamic && !world.is_quarantined(body)) world.wake(body);
  }
}

void change_settings(World& world, const Json& what) {
  WorldSettings settings = world.settings();
  if (what.contains("gravity")) settings.gravity = vector_of(what, "gravity");
  settings.substeps = what.value("substeps", settings.substeps);
  if (what.contains("solver")) settings.solver = solver_called(what["solver"].get<std::string>());
  settings.solver_options.iterations = what.value("iterations", settings.solver_options.iterations);
  constexpr float kMostFriction = 1e6f;
  for (const auto& [name, most] : {std::pair("friction", kMostFriction), std::pair("restitution", 1.0f)}) {
    if (!what.contains(name)) continue;
    const float value = what[name].get<float>();
    if (!(value >= 0.0f && value <= most))
      throw Error(std::string(name) + " " + std::to_string(value) + " must be from 0 to " +
                  std::to_string(static_cast<int>(most)));
  }
  world.set_settings(settings);
  if (!what.contains("friction") && !what.contains("restitution")) return;
  change_materials(world, [&](Material& material) {
    material.friction = what.value("friction", material.friction);
    material.restitution = what.value("restitution", material.restitution);
  });
}

void nudge(World& world, const Json& what) {
  const BodyId body = body_of(world, what);
  Pose pose = world.pose(body);
  pose.position.x = std::nextafter(pose.position.x, std::numeric_limits<float>::infinity());
  world.set_pose(body, pose);
}

}  // namespace

void release_all(World& world) {
  std::vector<JointId> joints;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (!world.is_alive(body)) continue;
    joints.resize(world.joints_of(body, {}));
    world.joints_of(body, joints);
    for (const JointId joint : joints) {
      if (world.joint_type(joint) == JointType::mouse && world.user_data(joint) == kHeld)
        world.destroy_joint(joint);
    }
  }
}

void touch(World& world, const Json& what, JointId& held) {
  const auto kind = what.at("kind").get<std::string>();
  if (kind == "drag") return drag(world, what, held);
  if (kind == "move") return move(world, what, held);
  if (kind == "release") return release(world, held);
  if (kind == "shoot") return shoot(world, what);
  if (kind == "delete") return world.destroy_body(body_of(world, what));
  if (kind == "settings") return change_settings(world, what);
  if (kind == "nudge") return nudge(world, what);
  throw Error("a page asks for " + kind + ", which is not known");
}

}  // namespace scree::view
