// Jolt behind the engine interface: a thread pool besides the calling thread, capacities far above what the
// scenes need (a full buffer is a complaint), damping as the scene has it.
#include <Jolt/Jolt.h>
// Jolt's headers need the one above first.
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/GroupFilterTable.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/Collision/Shape/PlaneShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/Constraints/SwingTwistConstraint.h>
#include <Jolt/Physics/PhysicsSettings.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include "bench/engine.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>

namespace scree::bench {
namespace {

constexpr JPH::ObjectLayer kFixedLayer = 0;
constexpr JPH::ObjectLayer kMovingLayer = 1;
constexpr unsigned kPairsPerBody = 24;     // candidate pairs; a settled pile has about 10
constexpr unsigned kContactsPerBody = 16;  // touching pairs; a settled pile has about 6
constexpr std::size_t kTempPerContact =
    1024;  // bytes of temporary memory a contact; more falls back to malloc

class BroadPhaseLayers final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(static_cast<JPH::BroadPhaseLayer::Type>(layer));
  }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "layer"; }
#endif
};

class FixedAgainstMoving final : public JPH::ObjectVsBroadPhaseLayerFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer object, JPH::BroadPhaseLayer layer) const override {
    return object == kMovingLayer || layer == JPH::BroadPhaseLayer(kMovingLayer);
  }
};

class NotBothFixed final : public JPH::ObjectLayerPairFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override {
    return a == kMovingLayer || b == kMovingLayer;
  }
};

JPH::Vec3 to_jolt(Vec3 v) { return {v.x, v.y, v.z}; }
JPH::Quat to_jolt(Quat q) { return {q.x, q.y, q.z, q.w}; }
Vec3 from_jolt(JPH::Vec3Arg v) { return {v.GetX(), v.GetY(), v.GetZ()}; }

std::uint32_t code_of(const JPH::Body& body) { return static_cast<std::uint32_t>(body.GetUserData()); }

void check_material(const scenes::SceneShape& shape, const Material& first) {
  const Filter& filter = shape.options.filter;
  if (filter.category != 1 || filter.mask != 0xffffffffu || filter.group != 0) unsupported("Jolt", "filters");
  if (shape.material.rolling_resistance != 0.0f) unsupported("Jolt", "rolling resistance");
  if (shape.material.surface_velocity != Vec3{}) unsupported("Jolt", "surface velocity");
  if (shape.material.friction != first.friction || shape.material.restitution != first.restitution ||
      mix_code(shape.material) != mix_code(first)) {
    unsupported("Jolt", "several materials on one body");
  }
}

// Rounded inside by Jolt's convex radius, or by less where the hull is too thin for it.
JPH::Ref<JPH::Shape> make_hull(const scenes::SceneShape& shape) {
  const auto& convex = std::get<ConvexHull>(shape.geometry);
  JPH::Array<JPH::Vec3> points;
  for (const Vec3 v : convex.hull.vertices()) {
    points.push_back({v.x * convex.scale.x, v.y * convex.scale.y, v.z * convex.scale.z});
  }
  JPH::ConvexHullShapeSettings settings(points);
  settings.mDensity = shape.material.density;
  const JPH::ShapeSettings::ShapeResult result = settings.Create();
  if (result.HasError()) {
    unsupported("Jolt",
                "a hull of " + std::to_string(points.size()) + " vertices: " + result.GetError().c_str());
  }
  return result.Get();
}

// With Jolt's defaults: its quality of the tree, and edges active from 5 degrees on.
JPH::Ref<JPH::Shape> make_mesh(const TriangleMesh& mesh) {
  refuse_mesh_materials("Jolt", mesh);
  JPH::VertexList vertices;
  for (const Vec3 v : mesh.vertices()) vertices.emplace_back(v.x, v.y, v.z);
  JPH::IndexedTriangleList triangles;
  for (const MeshTriangle& t : triangles_of(mesh)) triangles.emplace_back(t.a, t.b, t.c);
  const JPH::ShapeSettings::ShapeResult result =
      JPH::MeshShapeSettings(std::move(vertices), std::move(triangles)).Create();
  if (result.HasError()) unsupported("Jolt", std::string("a mesh as it is: ") + result.GetError().c_str());
  return result.Get();
}

JPH::Ref<JPH::Shape> make_shape(const scenes::SceneShape& shape) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry)) return make_mesh(*mesh);
  if (std::holds_alternative<HalfSpace>(shape.geometry))
    return new JPH::PlaneShape(JPH::Plane(JPH::Vec3::sAxisY(), 0.0f));  // ends at Jolt's default 1000 m
  if (std::holds_alternative<ConvexHull>(shape.geometry)) return make_hull(shape);
  JPH::Ref<JPH::ConvexShape> result;
  if (const auto* box = std::get_if<Box>(&shape.geometry)) {
    // The rounding lies inside the box; it must not be larger than the box.
    const Vec3 h = box->half_extents;
    result = new JPH::BoxShape(to_jolt(h), std::min({JPH::cDefaultConvexRadius, h.x, h.y, h.z}));
  } else if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) {
    result = new JPH::CapsuleShape(capsule->half_height, capsule->radius);
  } else {
    result = new JPH::SphereShape(std::get<Sphere>(shape.geometry).radius);
  }
  result->SetDensity(shape.material.density);
  return result.GetPtr();
}

// Shapes of bodies that exist already, by the run of the scene's shapes: its first one and their number.
using Shapes = std::map<std::pair<std::uint32_t, std::uint32_t>, JPH::Ref<JPH::Shape>>;

JPH::Ref<JPH::Shape> make_body_shape(const scenes::Scene& scene, const scenes::SceneBody& body,
                                     Shapes& shapes) {
  if (body.shape_count == 0) unsupported("Jolt", "bodies without shapes");
  JPH::Ref<JPH::Shape>& shared = shapes[{body.first_shape, body.shape_count}];
  if (shared != nullptr) return shared;
  const scenes::SceneShape& first = scene.shapes[body.first_shape];
  if (body.shape_count == 1 && first.options.local_pose == Pose{}) {
    check_material(first, first.material);
    shared = make_shape(first);
    return shared;
  }
  JPH::StaticCompoundShapeSettings settings;
  for (std::uint32_t s = 0; s < body.shape_count; ++s) {
    const scenes::SceneShape& shape = scene.shapes[body.first_shape + s];
    check_material(shape, first.material);
    const Pose& local = shape.options.local_pose;
    settings.AddShape(to_jolt(local.position), to_jolt(local.rotation), make_shape(shape).GetPtr());
  }
  const JPH::ShapeSettings::ShapeResult result = settings.Create();
  if (result.HasError()) unsupported("Jolt", std::string("a compound: ") + result.GetError().c_str());
  shared = result.Get();
  return shared;
}

JPH::BodyCreationSettings make_body(const scenes::Scene& scene, const scenes::SceneBody& body,
                                    bool continuous, Shapes& shapes) {
  const BodyDef& def = body.def;
  const JPH::EMotionType type = def.type == BodyType::fixed       ? JPH::EMotionType::Static
                                : def.type == BodyType::kinematic ? JPH::EMotionType::Kinematic
                                                                  : JPH::EMotionType::Dynamic;
  JPH::BodyCreationSettings settings(make_body_shape(scene, body, shapes), JPH::RVec3(to_jolt(def.position)),
                                     to_jolt(def.rotation).Normalized(), type,
                                     def.type == BodyType::fixed ? kFixedLayer : kMovingLayer);
  const scenes::SceneShape& first = scene.shapes[body.first_shape];
  settings.mFriction = first.material.friction;  // mixed as sqrt(a b), restitution as max: Jolt's defaults
  settings.mRestitution = first.material.restitution;
  settings.mUserData = mix_code(first.material);
  settings.mMaxLinearVelocity = std::max(settings.mMaxLinearVelocity, scene.settings.max_linear_speed);
  settings.mLinearVelocity = to_jolt(def.linear_velocity);
  settings.mAngularVelocity = to_jolt(def.angular_velocity);
  settings.mLinearDamping = def.linear_damping;
  settings.mAngularDamping = def.angular_damping;
  settings.mGravityFactor = def.gravity_factor;
  settings.mAllowSleeping = def.can_sleep && scene.settings.sleeping;
  settings.mAllowedDOFs = static_cast<JPH::EAllowedDOFs>(0x3f & ~static_cast<unsigned>(def.locks));
  if (continuous && def.type == BodyType::dynamic) settings.mMotionQuality = JPH::EMotionQuality::LinearCast;
  if (def.mass) {
    settings.mOverrideMassProperties = JPH::EOverrideMassProperties::CalculateInertia;
    settings.mMassPropertiesOverride.mMass = *def.mass;
  }
  return settings;
}

// Which joined bodies may not touch: a table of pairs for each group of bodies that joints connect.
class Groups {
 public:
  explicit Groups(const scenes::Scene& scene) : root_(scene.bodies.size()), member_(scene.bodies.size()) {
    std::iota(root_.begin(), root_.end(), 0u);
    for (const scenes::SceneJoint& joint : scene.joints) {
      if (parts(joint)) root_[find(joint.body_a)] = find(joint.body_b);
    }
    std::vector<unsigned> sizes(scene.bodies.size());
    for (std::uint32_t body = 0; body < root_.size(); ++body) member_[body] = sizes[find(body)]++;
    tables_.resize(sizes.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      if (sizes[i] > 1) tables_[i] = new JPH::GroupFilterTable(sizes[i]);
    }
    for (const scenes::SceneJoint& joint : scene.joints) {
      if (!parts(joint) || member_[joint.body_a] == member_[joint.body_b]) continue;
      tables_[find(joint.body_a)]->DisableCollision(member_[joint.body_a], member_[joint.body_b]);
    }
  }

  JPH::CollisionGroup of(std::uint32_t body) {
    const std::uint32_t root = find(body);
    if (tables_[root] == nullptr) return {};
    return {tables_[root], root, member_[body]};
  }

 private:
  static bool parts(const scenes::SceneJoint& joint) {
    return !joint.def.collide_connected && joint.body_a != scenes::kWorldItself &&
           joint.body_b != scenes::kWorldItself;
  }

  std::uint32_t find(std::uint32_t body) {
    while (root_[body] != body) body = root_[body] = root_[root_[body]];
    return body;
  }

  std::vector<std::uint32_t> root_;  // a forest
  std::vector<unsigned> member_;     // the body's number in its group
  std::vector<JPH::Ref<JPH::GroupFilterTable>> tables_;
};

// A joint's frame in the world, where the scene starts.
struct Frame {
  JPH::RVec3 anchor;
  JPH::Quat axes;
};

Frame start_frame(const scenes::Scene& scene, std::uint32_t body, const Pose& local) {
  const JPH::Quat axes = to_jolt(local.rotation).Normalized();
  if (body == scenes::kWorldItself) return {JPH::RVec3(to_jolt(local.position)), axes};
  const BodyDef& place = scene.bodies[body].def;
  const JPH::Quat turn = to_jolt(place.rotation).Normalized();
  return {JPH::RVec3(to_jolt(place.position) + turn * to_jolt(local.position)), turn * axes};
}

// The torque of a drive that does nothing but brake; refuses others.
float friction_of(Drive drive, bool stands, float max_torque) {
  if (drive == Drive::none) return 0.0f;
  if (drive == Drive::spring || !stands || max_torque == kNoLimit) {
    unsupported("Jolt", "drives of joints other than friction");
  }
  return max_torque;
}

JPH::Ref<JPH::TwoBodyConstraint> make_ball(const BallJoint& ball, const Frame& a, const Frame& b,
                                           JPH::Body& body_a, JPH::Body& body_b) {
  if (ball == BallJoint{}) {
    JPH::PointConstraintSettings settings;
    settings.mPoint1 = a.anchor;
    settings.mPoint2 = b.anchor;
    return settings.Create(body_a, body_b);
  }
  JPH::SwingTwistConstraintSettings settings;
  settings.mPosition1 = a.anchor;
  settings.mPosition2 = b.anchor;
  settings.mTwistAxis1 = a.axes.RotateAxisX();
  settings.mPlaneAxis1 = a.axes.RotateAxisY();
  settings.mTwistAxis2 = b.axes.RotateAxisX();
  settings.mPlaneAxis2 = b.axes.RotateAxisY();
  settings.mNormalHalfConeAngle = std::min(ball.cone_limit, JPH::JPH_PI);
  settings.mPlaneHalfConeAngle = settings.mNormalHalfConeAngle;
  settings.mTwistMinAngle = std::max(ball.twist_lower, -JPH::JPH_PI);
  settings.mTwistMaxAngle = std::min(ball.twist_upper, JPH::JPH_PI);
  settings.mMaxFrictionTorque =
      friction_of(ball.drive.drive, ball.drive.velocity == Vec3{}, ball.drive.max_torque);
  return settings.Create(body_a, body_b);
}

JPH::Ref<JPH::TwoBodyConstraint> make_hinge(const HingeJoint& hinge, const Frame& a, const Frame& b,
                                            JPH::Body& body_a, JPH::Body& body_b) {
  JPH::HingeConstraintSettings settings;
  settings.mPoint1 = a.anchor;
  settings.mPoint2 = b.anchor;
  settings.mHingeAxis1 = a.axes.RotateAxisX();
  settings.mNormalAxis1 = a.axes.RotateAxisY();
  settings.mHingeAxis2 = b.axes.RotateAxisX();
  settings.mNormalAxis2 = b.axes.RotateAxisY();
  settings.mLimitsMin = std::max(hinge.angle.lower, -JPH::JPH_PI);
  settings.mLimitsMax = std::min(hinge.angle.upper, JPH::JPH_PI);
  settings.mMaxFrictionTorque =
      friction_of(hinge.angle.drive, hinge.angle.speed == 0.0f, hinge.angle.max_force);
  return settings.Create(body_a, body_b);
}

// Balls and hinges with limits and friction.
JPH::Ref<JPH::TwoBodyConstraint> make_joint(const scenes::Scene& scene, const scenes::SceneJoint& joint,
                                            JPH::Body& body_a, JPH::Body& body_b) {
  const JointDef& def = joint.def;
  const bool plain =
      def.enabled && def.hertz == 0.0f && def.break_force == kNoLimit && def.break_torque == kNoLimit;
  if (!plain) unsupported("Jolt", "joints that are soft, break or are disabled");
  const Frame a = start_frame(scene, joint.body_a, def.frame_a);
  const Frame b = start_frame(scene, joint.body_b, def.frame_b);
  if (const auto* ball = std::get_if<BallJoint>(&joint.joint)) return make_ball(*ball, a, b, body_a, body_b);
  const auto* hinge = std::get_if<HingeJoint>(&joint.joint);
  if (hinge == nullptr) unsupported("Jolt", "joints that are neither balls nor hinges");
  return make_hinge(*hinge, a, b, body_a, body_b);
}

// Data that Jolt keeps once per process.
class Process {
 public:
  Process() {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory();
    JPH::RegisterTypes();
  }
  ~Process() {
    JPH::UnregisterTypes();
    delete JPH::Factory::sInstance;
    JPH::Factory::sInstance = nullptr;
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
};

class JoltEngine final : public Engine {
 public:
  JoltEngine(std::span<const scenes::Scene> scenes, const EngineOptions& options)
      : jobs_(JPH::cMaxPhysicsJobs, JPH::cMaxPhysicsBarriers, options.threads - 1) {
    std::size_t most_contacts = 0;
    for (const scenes::Scene& scene : scenes) {
      most_contacts = std::max(most_contacts, std::size_t{kContactsPerBody} * scene.bodies.size() + 1024);
      add_world(scene, options.continuous);
    }
    temp_ = std::make_unique<JPH::TempAllocatorImplWithMallocFallback>(
        std::min(most_contacts * kTempPerContact, std::size_t{1} << 30));
  }

  void step(float dt) override {
    for (World& world : worlds_)
      errors_ |= static_cast<unsigned>(world.system->Update(dt, 1, temp_.get(), &jobs_));
  }

  void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) override {
    worlds_[world].system->GetBodyInterfaceNoLock().MoveKinematic(worlds_[world].bodies[body],
                                                                  JPH::RVec3(to_jolt(target.position)),
                                                                  to_jolt(target.rotation).Normalized(), dt);
  }

  void push(std::size_t world, std::uint32_t body, Vec3 force) override {
    worlds_[world].system->GetBodyInterfaceNoLock().AddForce(worlds_[world].bodies[body], to_jolt(force));
  }

  void read(std::size_t world, std::vector<BodyState>& states) const override {
    states.clear();
    const JPH::BodyInterface& bodies = worlds_[world].system->GetBodyInterfaceNoLock();
    for (const JPH::BodyID body : worlds_[world].bodies) {
      const JPH::Quat q = bodies.GetRotation(body);
      states.push_back(
          {{from_jolt(JPH::Vec3(bodies.GetPosition(body))), {q.GetX(), q.GetY(), q.GetZ(), q.GetW()}},
           from_jolt(bodies.GetLinearVelocity(body)),
           from_jolt(bodies.GetAngularVelocity(body))});
    }
  }

  std::int64_t awake() const override {
    std::int64_t count = 0;
    for (const World& world : worlds_) {
      const JPH::BodyInterface& bodies = world.system->GetBodyInterfaceNoLock();
      count += std::count_if(world.bodies.begin(), world.bodies.end(), [&](const JPH::BodyID& body) {
        return bodies.GetMotionType(body) == JPH::EMotionType::Dynamic && bodies.IsActive(body);
      });
    }
    return count;
  }

  std::string complaint() const override {
    return errors_ == 0 ? std::string{}
                        : "dropped contacts: a capacity was full (flags " + std::to_string(errors_) + ")";
  }

 private:
  struct World {
    std::unique_ptr<JPH::PhysicsSystem> system;
    std::vector<JPH::BodyID> bodies;
  };

  void add_world(const scenes::Scene& scene, bool continuous) {
    const auto count = static_cast<unsigned>(scene.bodies.size());
    World world{std::make_unique<JPH::PhysicsSystem>(), {}};
    world.system->Init(count + 1, 0, kPairsPerBody * count + 1024, kContactsPerBody * count + 1024, layers_,
                       fixed_against_moving_, not_both_fixed_);
    world.system->SetGravity(to_jolt(scene.settings.gravity));
    JPH::PhysicsSettings settings = world.system->GetPhysicsSettings();
    settings.mMinVelocityForRestitution = scene.settings.restitution_threshold;
    world.system->SetPhysicsSettings(settings);
    if (mixes_otherwise(scene)) set_mixing(*world.system);
    JPH::BodyInterface& bodies = world.system->GetBodyInterfaceNoLock();
    Shapes shapes;
    Groups groups(scene);
    for (std::uint32_t i = 0; i < count; ++i) {
      const bool is_fixed = scene.bodies[i].def.type == BodyType::fixed;
      JPH::BodyCreationSettings body = make_body(scene, scene.bodies[i], continuous, shapes);
      body.mCollisionGroup = groups.of(i);
      world.bodies.push_back(bodies.CreateAndAddBody(
          body, is_fixed ? JPH::EActivation::DontActivate : JPH::EActivation::Activate));
    }
    const auto body_of = [&](std::uint32_t index) -> JPH::Body& {
      if (index == scenes::kWorldItself) return JPH::Body::sFixedToWorld;
      return *world.system->GetBodyLockInterfaceNoLock().TryGetBody(world.bodies[index]);
    };
    for (const scenes::SceneJoint& joint : scene.joints) {
      world.system->AddConstraint(make_joint(scene, joint, body_of(joint.body_a), body_of(joint.body_b)));
    }
    world.system->OptimizeBroadPhase();
    worlds_.push_back(std::move(world));
  }

  static void set_mixing(JPH::PhysicsSystem& system) {
    system.SetCombineFriction(
        [](const JPH::Body& a, const JPH::SubShapeID&, const JPH::Body& b, const JPH::SubShapeID&) {
          return mixed_friction(a.GetFriction(), code_of(a), b.GetFriction(), code_of(b));
        });
    system.SetCombineRestitution(
        [](const JPH::Body& a, const JPH::SubShapeID&, const JPH::Body& b, const JPH::SubShapeID&) {
          return mixed_restitution(a.GetRestitution(), code_of(a), b.GetRestitution(), code_of(b));
        });
  }

  Process process_;  // first: everything below needs it
  BroadPhaseLayers layers_;
  FixedAgainstMoving fixed_against_moving_;
  NotBothFixed not_both_fixed_;
  JPH::JobSystemThreadPool jobs_;
  std::unique_ptr<JPH::TempAllocator> temp_;
  std::vector<World> worlds_;
  unsigned errors_ = 0;
};

}  // namespace

EngineInfo jolt_engine() {
  const JPH::PhysicsSettings defaults;
  return {.name = "jolt",
          .title = "Jolt " + std::to_string(JPH_VERSION_MAJOR) + "." + std::to_string(JPH_VERSION_MINOR) +
                   "." + std::to_string(JPH_VERSION_PATCH),
          .settings = std::to_string(defaults.mNumVelocitySteps) + " velocity and " +
                      std::to_string(defaults.mNumPositionSteps) +
                      " position iterations (its defaults), the scene's damping",
          .continuous = "every dynamic body is cast along its way (EMotionQuality::LinearCast)",
          .multithreaded = true,
          .joints = true,
          .create = [](std::span<const scenes::Scene> scenes, const EngineOptions& options)
              -> std::unique_ptr<Engine> { return std::make_unique<JoltEngine>(scenes, options); }};
}

}  // namespace scree::bench
