// Box3D behind the engine interface: its own scheduler with one worker per thread, everything else at its
// defaults.
#include "bench/engine.h"

#include <box3d/box3d.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace scree::bench {
namespace {

b3Vec3 to_box3d(Vec3 v) { return {v.x, v.y, v.z}; }
b3Quat to_box3d(Quat q) { return {{q.x, q.y, q.z}, q.w}; }
Vec3 from_box3d(b3Vec3 v) { return {v.x, v.y, v.z}; }

b3BodyType to_box3d(BodyType type) {
  if (type == BodyType::fixed) return b3_staticBody;
  return type == BodyType::kinematic ? b3_kinematicBody : b3_dynamicBody;
}

b3MotionLocks to_box3d(AxisLocks locks) {
  const auto has = [&](AxisLocks bit) {
    return (static_cast<unsigned>(locks) & static_cast<unsigned>(bit)) != 0;
  };
  b3MotionLocks result{};
  result.linearX = has(AxisLocks::translation_x);
  result.linearY = has(AxisLocks::translation_y);
  result.linearZ = has(AxisLocks::translation_z);
  result.angularX = has(AxisLocks::rotation_x);
  result.angularY = has(AxisLocks::rotation_y);
  result.angularZ = has(AxisLocks::rotation_z);
  return result;
}

// Box3D has no half-spaces. Instead of one its users take a box of this size (m, half) below the plane.
constexpr float kGroundHalfWidth = 500.0f;
constexpr float kGroundHalfHeight = 10.0f;

// Hulls and meshes, built once for each shape of the scene. The worlds keep copies of hulls, but not of
// meshes: destroy it after them.
class Forms {
 public:
  Forms() = default;
  ~Forms() {
    // Null where one was refused.
    for (const auto& [shape, hull] : hulls_) {
      if (hull != nullptr) b3DestroyHull(hull);
    }
    for (const auto& [shape, mesh] : meshes_) {
      if (mesh != nullptr) b3DestroyMesh(mesh);
    }
  }
  Forms(const Forms&) = delete;
  Forms& operator=(const Forms&) = delete;

  // In the body's frame, as shapes of meshes have no place of their own.
  const b3MeshData* mesh_of(const scenes::SceneShape& shape) {
    b3MeshData*& data = meshes_[&shape];
    if (data != nullptr) return data;
    const auto& mesh = std::get<TriangleMesh>(shape.geometry);
    refuse_mesh_materials("Box3D", mesh);
    const Pose& local = shape.options.local_pose;
    std::vector<b3Vec3> vertices;
    for (const Vec3 v : mesh.vertices()) {
      vertices.push_back(
          b3Add(to_box3d(local.position), b3RotateVector(to_box3d(local.rotation), to_box3d(v))));
    }
    std::vector<std::int32_t> indices;
    for (const MeshTriangle& t : triangles_of(mesh)) {
      for (const std::uint32_t corner : {t.a, t.b, t.c}) indices.push_back(static_cast<std::int32_t>(corner));
    }
    b3MeshDef def{};
    def.vertices = vertices.data();
    def.vertexCount = static_cast<int>(vertices.size());
    def.indices = indices.data();
    def.triangleCount = static_cast<int>(indices.size() / 3);
    def.identifyEdges = true;  // against ghost collisions, as its own samples have it
    data = b3CreateMesh(&def, nullptr, 0);
    if (data == nullptr) {
      unsupported("Box3D", "a mesh of " + std::to_string(def.triangleCount) + " triangles as it is");
    }
    return data;
  }

  const b3HullData* hull_of(const scenes::SceneShape& shape) {
    b3HullData*& hull = hulls_[&shape];
    if (hull != nullptr) return hull;
    const auto& convex = std::get<ConvexHull>(shape.geometry);
    std::vector<b3Vec3> points;
    for (const Vec3 v : convex.hull.vertices()) {
      points.push_back({v.x * convex.scale.x, v.y * convex.scale.y, v.z * convex.scale.z});
    }
    const auto count = static_cast<int>(points.size());
    hull = b3CreateHull(points.data(), count, count);
    // Box3D allows at most 128 edges, and it merges points close to a plane.
    if (hull == nullptr || hull->vertexCount != count) {
      unsupported("Box3D", "a hull of " + std::to_string(count) + " vertices and " +
                               std::to_string(convex.hull.edge_count()) + " edges as it is");
    }
    return hull;
  }

 private:
  std::map<const scenes::SceneShape*, b3HullData*> hulls_;
  std::map<const scenes::SceneShape*, b3MeshData*> meshes_;
};

void add_shape(b3BodyId body, const scenes::SceneShape& shape, Forms& forms) {
  b3ShapeDef def = b3DefaultShapeDef();
  def.baseMaterial.friction = shape.material.friction;
  def.baseMaterial.restitution = shape.material.restitution;
  def.baseMaterial.tangentVelocity = to_box3d(shape.material.surface_velocity);
  def.baseMaterial.userMaterialId = mix_code(shape.material);
  def.density = shape.material.density;
  def.filter.categoryBits = shape.options.filter.category;
  def.filter.maskBits = shape.options.filter.mask;
  def.filter.groupIndex = shape.options.filter.group;
  const Pose& local = shape.options.local_pose;
  const b3Vec3 position = to_box3d(local.position);
  const b3Quat rotation = to_box3d(local.rotation);
  if (std::holds_alternative<ConvexHull>(shape.geometry)) {
    if (local == Pose{}) {
      b3CreateHullShape(body, &def, forms.hull_of(shape));
    } else {
      b3CreateTransformedHullShape(body, &def, forms.hull_of(shape), {position, rotation},
                                   {1.0f, 1.0f, 1.0f});
    }
  } else if (std::holds_alternative<TriangleMesh>(shape.geometry)) {
    if (b3Body_GetType(body) != b3_staticBody) {
      unsupported("Box3D", "meshes of kinematic bodies: it collides those of fixed ones only");
    }
    b3CreateMeshShape(body, &def, forms.mesh_of(shape), {1.0f, 1.0f, 1.0f});
  } else if (std::holds_alternative<HalfSpace>(shape.geometry)) {
    const b3Vec3 center = b3Add(position, b3RotateVector(rotation, {0.0f, -kGroundHalfHeight, 0.0f}));
    const b3BoxHull hull =
        b3MakeTransformedBoxHull(kGroundHalfWidth, kGroundHalfHeight, kGroundHalfWidth, {center, rotation});
    b3CreateHullShape(body, &def, &hull.base);
  } else if (const auto* box = std::get_if<Box>(&shape.geometry)) {
    const Vec3 h = box->half_extents;
    const b3BoxHull hull = b3MakeTransformedBoxHull(h.x, h.y, h.z, {position, rotation});
    b3CreateHullShape(body, &def, &hull.base);
  } else if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) {
    // Box3D multiplies the coefficient by the radius.
    def.baseMaterial.rollingResistance = shape.material.rolling_resistance / capsule->radius;
    const b3Vec3 half = b3RotateVector(rotation, {0.0f, capsule->half_height, 0.0f});
    const b3Capsule round{b3Sub(position, half), b3Add(position, half), capsule->radius};
    b3CreateCapsuleShape(body, &def, &round);
  } else {
    const float radius = std::get<Sphere>(shape.geometry).radius;
    def.baseMaterial.rollingResistance = shape.material.rolling_resistance / radius;
    const b3Sphere round{position, radius};
    b3CreateSphereShape(body, &def, &round);
  }
}

b3BodyId add_body(b3WorldId world, const scenes::Scene& scene, const scenes::SceneBody& body, Forms& forms) {
  b3BodyDef def = b3DefaultBodyDef();
  def.type = to_box3d(body.def.type);
  def.position = {body.def.position.x, body.def.position.y, body.def.position.z};
  def.rotation = to_box3d(body.def.rotation);
  def.linearVelocity = to_box3d(body.def.linear_velocity);
  def.angularVelocity = to_box3d(body.def.angular_velocity);
  def.linearDamping = body.def.linear_damping;
  def.angularDamping = body.def.angular_damping;
  def.gravityScale = body.def.gravity_factor;
  def.motionLocks = to_box3d(body.def.locks);
  def.enableSleep = body.def.can_sleep;
  const b3BodyId id = b3CreateBody(world, &def);
  for (std::uint32_t s = 0; s < body.shape_count; ++s) {
    add_shape(id, scene.shapes[body.first_shape + s], forms);
  }
  if (body.def.mass && body.def.type == BodyType::dynamic) {
    b3MassData data = b3Body_GetMassData(id);
    const float scale = *body.def.mass / data.mass;
    data.mass = *body.def.mass;
    for (b3Vec3* column : {&data.inertia.cx, &data.inertia.cy, &data.inertia.cz})
      *column = b3MulSV(scale, *column);
    b3Body_SetMassData(id, data);
  }
  return id;
}

// Adds joints to a world. Its balls and hinges turn about z where the scene's turn about x.
class Joints {
 public:
  Joints(b3WorldId world, const std::vector<b3BodyId>& bodies) : world_(world), bodies_(bodies) {}

  void add(const scenes::SceneJoint& joint) {
    if (const auto* ball = std::get_if<BallJoint>(&joint.joint)) {
      add(joint, *ball);
    } else if (const auto* hinge = std::get_if<HingeJoint>(&joint.joint)) {
      add(joint, *hinge);
    } else {
      unsupported("Box3D", "joints that are neither balls nor hinges");
    }
  }

 private:
  void add(const scenes::SceneJoint& joint, const BallJoint& ball) {
    b3SphericalJointDef def = b3DefaultSphericalJointDef();
    set_base(def.base, joint);
    def.enableConeLimit = ball.cone_limit != kNoLimit;
    if (def.enableConeLimit) def.coneAngle = ball.cone_limit;
    def.enableTwistLimit = ball.twist_lower != -kNoLimit || ball.twist_upper != kNoLimit;
    if (def.enableTwistLimit) {
      def.lowerTwistAngle = std::max(ball.twist_lower, -kMostAngle);
      def.upperTwistAngle = std::min(ball.twist_upper, kMostAngle);
    }
    if (ball.drive.drive == Drive::spring) unsupported("Box3D", "springs of balls");
    if (ball.drive.drive == Drive::motor) {
      if (ball.drive.velocity != Vec3{}) unsupported("Box3D", "motors of ball joints other than friction");
      def.enableMotor = true;
      def.maxMotorTorque = ball.drive.max_torque;
    }
    b3CreateSphericalJoint(world_, &def);
  }

  void add(const scenes::SceneJoint& joint, const HingeJoint& hinge) {
    b3RevoluteJointDef def = b3DefaultRevoluteJointDef();
    set_base(def.base, joint);
    const JointAxis& angle = hinge.angle;
    def.enableLimit = angle.lower != -kNoLimit || angle.upper != kNoLimit;
    if (def.enableLimit) {
      def.lowerAngle = std::max(angle.lower, -kMostAngle);
      def.upperAngle = std::min(angle.upper, kMostAngle);
    }
    if (angle.drive == Drive::spring) unsupported("Box3D", "springs of hinges");
    if (angle.drive == Drive::motor) {
      def.enableMotor = true;
      def.maxMotorTorque = angle.max_force;
      def.motorSpeed = angle.speed;
    }
    b3CreateRevoluteJoint(world_, &def);
  }

  void set_base(b3JointDef& base, const scenes::SceneJoint& joint) {
    const JointDef& def = joint.def;
    if (!def.enabled) unsupported("Box3D", "disabled joints");
    if (def.break_force != kNoLimit || def.break_torque != kNoLimit) {
      unsupported("Box3D", "joints that break");
    }
    if (def.hertz != 0.0f) {
      base.constraintHertz = def.hertz;
      base.constraintDampingRatio = def.damping_ratio;
    }
    base.bodyIdA = body(joint.body_a);
    base.bodyIdB = body(joint.body_b);
    base.localFrameA = frame(def.frame_a);
    base.localFrameB = frame(def.frame_b);
    base.collideConnected = def.collide_connected;
  }

  b3BodyId body(std::uint32_t index) {
    if (index != scenes::kWorldItself) return bodies_[index];
    if (B3_IS_NULL(itself_)) {
      const b3BodyDef def = b3DefaultBodyDef();  // fixed at the origin
      itself_ = b3CreateBody(world_, &def);
    }
    return itself_;
  }

  // Turned so that its z axis is the frame's x axis, its x the frame's y.
  static b3Transform frame(const Pose& pose) {
    const b3Quat z_to_x{{0.5f, 0.5f, 0.5f}, 0.5f};
    return {to_box3d(pose.position), b3MulQuat(to_box3d(pose.rotation), z_to_x)};
  }

  static constexpr float kMostAngle = 0.99f * 3.14159265f;  // rad, of its limits

  b3WorldId world_;
  const std::vector<b3BodyId>& bodies_;
  b3BodyId itself_ = b3_nullBodyId;
};

class Box3dEngine final : public Engine {
 public:
  Box3dEngine(std::span<const scenes::Scene> scenes, const EngineOptions& options) {
    if (scenes.size() > B3_MAX_WORLDS) {
      unsupported("Box3D", std::to_string(scenes.size()) + " worlds (its limit is " +
                               std::to_string(B3_MAX_WORLDS) + ")");
    }
    for (const scenes::Scene& scene : scenes) {
      b3WorldDef def = b3DefaultWorldDef();
      def.gravity = to_box3d(scene.settings.gravity);
      def.restitutionThreshold = scene.settings.restitution_threshold;
      def.enableSleep = scene.settings.sleeping;
      def.enableContinuous = options.continuous;
      def.workerCount = static_cast<std::uint32_t>(options.threads);
      def.maximumLinearSpeed = scene.settings.max_linear_speed;
      if (mixes_otherwise(scene)) {
        def.frictionCallback = [](float a, std::uint64_t code_a, float b, std::uint64_t code_b) {
          return mixed_friction(a, static_cast<std::uint32_t>(code_a), b, static_cast<std::uint32_t>(code_b));
        };
        def.restitutionCallback = [](float a, std::uint64_t code_a, float b, std::uint64_t code_b) {
          return mixed_restitution(a, static_cast<std::uint32_t>(code_a), b,
                                   static_cast<std::uint32_t>(code_b));
        };
      }
      World world{b3CreateWorld(&def), scene.settings.substeps, {}, &scene, std::make_unique<Forms>()};
      for (const scenes::SceneBody& body : scene.bodies) {
        world.bodies.push_back(body.comes_later ? b3_nullBodyId
                                                : add_body(world.id, scene, body, *world.forms));
      }
      Joints joints(world.id, world.bodies);
      for (const scenes::SceneJoint& joint : scene.joints) joints.add(joint);
      worlds_.push_back(std::move(world));
    }
  }

  ~Box3dEngine() override {
    for (const World& world : worlds_) b3DestroyWorld(world.id);
  }

  void step(float dt) override {
    for (const World& world : worlds_) b3World_Step(world.id, dt, world.substeps);
  }

  void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) override {
    const Vec3 p = target.position;
    b3Body_SetTargetTransform(worlds_[world].bodies[body], {{p.x, p.y, p.z}, to_box3d(target.rotation)}, dt,
                              true);
  }

  void push(std::size_t world, std::uint32_t body, Vec3 force) override {
    b3Body_ApplyForceToCenter(worlds_[world].bodies[body], to_box3d(force), true);
  }

  void make_change(std::size_t world, const scenes::SceneChange& change) override {
    World& to = worlds_[world];
    for (std::uint32_t i = change.first; i < change.first + change.count; ++i) {
      if (change.creates) {
        to.bodies[i] = add_body(to.id, *to.scene, to.scene->bodies[i], *to.forms);
      } else {
        b3DestroyBody(to.bodies[i]);
        to.bodies[i] = b3_nullBodyId;
      }
    }
  }

  void read(std::size_t world, std::vector<BodyState>& states) const override {
    states.clear();
    for (const b3BodyId body : worlds_[world].bodies) {
      if (B3_IS_NULL(body)) {
        states.push_back({{}, {}, {}, false});
        continue;
      }
      const b3Pos p = b3Body_GetPosition(body);
      const b3Quat q = b3Body_GetRotation(body);
      const Vec3 position{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      states.push_back({{position, {q.v.x, q.v.y, q.v.z, q.s}},
                        from_box3d(b3Body_GetLinearVelocity(body)),
                        from_box3d(b3Body_GetAngularVelocity(body))});
    }
  }

  std::int64_t awake() const override {
    std::int64_t count = 0;
    for (const World& world : worlds_) {
      for (const b3BodyId body : world.bodies) {
        if (B3_IS_NON_NULL(body) && b3Body_GetType(body) == b3_dynamicBody && b3Body_IsAwake(body)) ++count;
      }
    }
    return count;
  }

  std::int64_t contacts() const override {
    std::int64_t sum = 0;
    for (const World& world : worlds_) sum += b3World_GetCounters(world.id).contactCount;
    return sum;
  }

  std::vector<std::pair<std::string, double>> phases() const override {
    double pairs = 0.0, collide = 0.0, constraints = 0.0, transforms = 0.0, refit = 0.0, sleep = 0.0;
    for (const World& world : worlds_) {
      const b3Profile profile = b3World_GetProfile(world.id);
      pairs += double{profile.pairs};
      collide += double{profile.collide};
      constraints += double{profile.constraints};
      transforms += double{profile.transforms};
      refit += double{profile.refit};
      sleep += double{profile.sleepIslands};
    }
    return {{"pairs", pairs},           {"collide", collide}, {"constraints", constraints},
            {"transforms", transforms}, {"refit", refit},     {"sleep", sleep}};
  }

 private:
  struct World {
    b3WorldId id;
    int substeps;
    std::vector<b3BodyId> bodies;
    const scenes::Scene* scene;
    std::unique_ptr<Forms> forms;
  };
  std::vector<World> worlds_;
};

std::string title() {
  const b3Version version = b3GetVersion();
  return "Box3D " + std::to_string(version.major) + "." + std::to_string(version.minor) + "." +
         std::to_string(version.revision);
}

}  // namespace

EngineInfo box3d_engine() {
  return {.name = "box3d",
          .title = title(),
          .settings = "soft step, the scene's substeps, its own scheduler",
          .continuous = "bodies that move fast are swept against fixed ones (enableContinuous)",
          .multithreaded = true,
          .substeps = true,
          .joints = true,
          .changes = true,
          .create = [](std::span<const scenes::Scene> scenes, const EngineOptions& options)
              -> std::unique_ptr<Engine> { return std::make_unique<Box3dEngine>(scenes, options); }};
}

}  // namespace scree::bench
