// Jolt behind the engine interface: a thread pool besides the calling thread, capacities far above what the
// scenes need (a full buffer is a complaint), damping as the scene has it.
#include <Jolt/Jolt.h>
// Jolt's headers need the one above first.
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/PhysicsSettings.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include "bench/engine.h"

#include <algorithm>
#include <map>
#include <string>

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

void check_material(const scenes::SceneShape& shape, const Material& first) {
  const Filter& filter = shape.options.filter;
  if (filter.category != 1 || filter.mask != 0xffffffffu || filter.group != 0) unsupported("Jolt", "filters");
  if (shape.material.rolling_resistance != 0.0f) unsupported("Jolt", "rolling resistance");
  if (shape.material.surface_velocity != Vec3{}) unsupported("Jolt", "surface velocity");
  if (shape.material.friction != first.friction || shape.material.restitution != first.restitution) {
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

JPH::Ref<JPH::Shape> make_shape(const scenes::SceneShape& shape) {
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

// Shapes of the scene that exist already, by their place.
using Shapes = std::map<std::uint32_t, JPH::Ref<JPH::Shape>>;

JPH::Ref<JPH::Shape> make_body_shape(const scenes::Scene& scene, const scenes::SceneBody& body,
                                     Shapes& shapes) {
  if (body.shape_count == 0) unsupported("Jolt", "bodies without shapes");
  const scenes::SceneShape& first = scene.shapes[body.first_shape];
  if (body.shape_count == 1 && first.options.local_pose == Pose{}) {
    check_material(first, first.material);
    JPH::Ref<JPH::Shape>& shared = shapes[body.first_shape];
    if (shared == nullptr) shared = make_shape(first);
    return shared;
  }
  JPH::StaticCompoundShapeSettings settings;
  for (std::uint32_t s = 0; s < body.shape_count; ++s) {
    const scenes::SceneShape& shape = scene.shapes[body.first_shape + s];
    check_material(shape, first.material);
    const Pose& local = shape.options.local_pose;
    settings.AddShape(to_jolt(local.position), to_jolt(local.rotation), make_shape(shape).GetPtr());
  }
  return settings.Create().Get();
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

// Balls, and hinges with limits, that hold a body to the world. Bodies that two joined bodies may not touch
// would need a group filter.
JPH::Ref<JPH::TwoBodyConstraint> make_joint(const scenes::Scene& scene, const scenes::SceneJoint& joint,
                                            JPH::Body& body) {
  if (joint.body_a != scenes::kWorldItself || joint.body_b == scenes::kWorldItself) {
    unsupported("Jolt", "joints between two bodies");
  }
  const JointDef& def = joint.def;
  const BodyDef& place = scene.bodies[joint.body_b].def;
  const bool plain =
      def.enabled && def.hertz == 0.0f && def.break_force == kNoLimit && def.break_torque == kNoLimit;
  if (!plain) unsupported("Jolt", "joints that are soft, break or are disabled");
  const JPH::Vec3 anchor_b =
      to_jolt(place.position) + to_jolt(place.rotation).Normalized() * to_jolt(def.frame_b.position);
  const JPH::Quat frame_a = to_jolt(def.frame_a.rotation).Normalized();
  const JPH::Quat frame_b = (to_jolt(place.rotation) * to_jolt(def.frame_b.rotation)).Normalized();
  if (const auto* ball = std::get_if<BallJoint>(&joint.joint); ball != nullptr && *ball == BallJoint{}) {
    JPH::PointConstraintSettings settings;
    settings.mPoint1 = JPH::RVec3(to_jolt(def.frame_a.position));
    settings.mPoint2 = JPH::RVec3(anchor_b);
    return settings.Create(JPH::Body::sFixedToWorld, body);
  }
  const auto* hinge = std::get_if<HingeJoint>(&joint.joint);
  if (hinge == nullptr || hinge->angle.drive != Drive::none) {
    unsupported("Jolt", "joints other than plain balls and hinges without drives");
  }
  JPH::HingeConstraintSettings settings;
  settings.mPoint1 = JPH::RVec3(to_jolt(def.frame_a.position));
  settings.mPoint2 = JPH::RVec3(anchor_b);
  settings.mHingeAxis1 = frame_a.RotateAxisX();
  settings.mNormalAxis1 = frame_a.RotateAxisY();
  settings.mHingeAxis2 = frame_b.RotateAxisX();
  settings.mNormalAxis2 = frame_b.RotateAxisY();
  settings.mLimitsMin = std::max(hinge->angle.lower, -JPH::JPH_PI);
  settings.mLimitsMax = std::min(hinge->angle.upper, JPH::JPH_PI);
  return settings.Create(JPH::Body::sFixedToWorld, body);
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
    JPH::BodyInterface& bodies = world.system->GetBodyInterfaceNoLock();
    Shapes shapes;
    for (const scenes::SceneBody& body : scene.bodies) {
      const JPH::EActivation activation =
          body.def.type == BodyType::fixed ? JPH::EActivation::DontActivate : JPH::EActivation::Activate;
      world.bodies.push_back(bodies.CreateAndAddBody(make_body(scene, body, continuous, shapes), activation));
    }
    for (const scenes::SceneJoint& joint : scene.joints) {
      if (joint.body_b == scenes::kWorldItself) unsupported("Jolt", "joints of the world with a body");
      world.system->AddConstraint(make_joint(
          scene, joint, *world.system->GetBodyLockInterfaceNoLock().TryGetBody(world.bodies[joint.body_b])));
    }
    world.system->OptimizeBroadPhase();
    worlds_.push_back(std::move(world));
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
