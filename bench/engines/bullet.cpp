// Bullet behind the engine interface: sequential impulses with its default 10 iterations on one thread, the
// scene's mixing rules, exact inertia instead of its box approximation. A margin rounds its hulls; the
// adapter shrinks them by the same amount before, so that their faces lie where the scene has them. Meshes
// are as Bullet makes them by default, without its correction of contacts with inner edges.
#include "bench/engine.h"

#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace scree::bench {
namespace {

btVector3 to_bullet(Vec3 v) { return {btScalar{v.x}, btScalar{v.y}, btScalar{v.z}}; }
Vec3 from_bullet(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btTransform to_bullet(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                     to_bullet(Eigen::Vector3d(pose.translation())));
}
Eigen::Isometry3d to_isometry(const Pose& pose) {
  return Eigen::Translation3d(to_double(pose.position)) * to_double(pose.rotation);
}

// Largest share of a hull's inner ball that the margin may take.
constexpr btScalar kMostShrink = btScalar(0.5);
// The ball that Bullet sweeps for a fast body, as a share of the body's inner ball: it must not catch on
// floors.
constexpr double kSweptShare = 0.5;

std::uint32_t code_of(const btCollisionObject* object) {
  return static_cast<std::uint32_t>(object->getUserIndex());
}

btScalar mix_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return btScalar{mixed_friction(static_cast<float>(a->getFriction()), code_of(a),
                                 static_cast<float>(b->getFriction()), code_of(b))};
}

btScalar mix_restitution(const btCollisionObject* a, const btCollisionObject* b) {
  return btScalar{mixed_restitution(static_cast<float>(a->getRestitution()), code_of(a),
                                    static_cast<float>(b->getRestitution()), code_of(b))};
}

class World {
 public:
  World(const scenes::Scene& scene, bool continuous)
      : polytopes_(make_polytopes(scene)), continuous_(continuous) {
    world_.setGravity(to_bullet(scene.settings.gravity));
    world_.getSolverInfo().m_restitutionVelocityThreshold = btScalar{scene.settings.restitution_threshold};
    for (const scenes::SceneBody& body : scene.bodies) add_body(scene, body);
    for (const scenes::SceneJoint& joint : scene.joints) add_joint(joint, scene.dt);
  }
  ~World() {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const Body& body : bodies_) world_.removeRigidBody(body.object.get());
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void step(float dt) { world_.stepSimulation(btScalar{dt}, 0); }  // 0: one step of exactly dt

  // Bullet expects a kinematic body at its target and derives the velocity from the path there.
  void move_kinematic(std::uint32_t body, const Pose& target) {
    bodies_[body].object->setWorldTransform(to_bullet(to_isometry(target) * bodies_[body].frame));
  }

  // stepSimulation(dt, 0) clears forces at the end of the step.
  void push(std::uint32_t body, Vec3 force) { bodies_[body].object->applyCentralForce(to_bullet(force)); }

  void read(std::vector<BodyState>& states) const {
    states.clear();
    for (const auto& [object, frame] : bodies_) {
      const btVector3& p = object->getWorldTransform().getOrigin();
      const btQuaternion r = object->getWorldTransform().getRotation();
      const Eigen::Isometry3d placed =
          Eigen::Translation3d(double{p.x()}, double{p.y()}, double{p.z()}) *
          Eigen::Quaterniond(double{r.w()}, double{r.x()}, double{r.y()}, double{r.z()}).normalized();
      const Eigen::Isometry3d pose = placed * frame.inverse();
      const Eigen::Quaterniond q(pose.linear());
      const Eigen::Vector3f origin = pose.translation().cast<float>();
      const Quat rotation{static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                          static_cast<float>(q.w())};
      states.push_back({{{origin.x(), origin.y(), origin.z()}, rotation},
                        from_bullet(object->getLinearVelocity()),
                        from_bullet(object->getAngularVelocity())});
    }
  }

  std::int64_t awake() const {
    return std::count_if(bodies_.begin(), bodies_.end(), [](const Body& body) {
      return !body.object->isStaticOrKinematicObject() && body.object->isActive();
    });
  }

  std::int64_t contacts() const {
    std::int64_t count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      if (dispatcher_.getManifoldByIndexInternal(i)->getNumContacts() > 0) ++count;
    }
    return count;
  }

 private:
  struct Body {
    std::unique_ptr<btRigidBody> object;
    Eigen::Isometry3d frame;  // Bullet's in the body's
  };
  // What Bullet keeps pointers to.
  struct Mesh {
    std::vector<int> indices;
    std::vector<btScalar> vertices;
    std::unique_ptr<btTriangleIndexVertexArray> arrays;
  };
  // Data that bodies with the same shapes share.
  struct Shared {
    btCollisionShape* shape;
    Eigen::Isometry3d frame;
    Eigen::Vector3d inertia;  // in that frame, for the mass below; of dynamic bodies
    double mass;
    double inner_radius;
  };

  static void check_material(const scenes::SceneShape& shape, const Material& first) {
    const Filter& filter = shape.options.filter;
    const Material& material = shape.material;
    if (filter.category != 1 || filter.mask != 0xffffffffu || filter.group != 0)
      unsupported("Bullet", "filters");
    if (material.rolling_resistance != 0.0f) unsupported("Bullet", "rolling resistance");
    if (material.surface_velocity != Vec3{}) unsupported("Bullet", "surface velocity");
    if (material.friction != first.friction || material.restitution != first.restitution ||
        mix_code(material) != mix_code(first)) {
      unsupported("Bullet", "several materials on one body");
    }
  }

  // In the frame at `pose`.
  static std::unique_ptr<btConvexHullShape> make_hull(const Polytope& polytope,
                                                      const Eigen::Isometry3d& pose) {
    std::vector<btVector3> points;
    for (const Eigen::Vector3d& vertex : polytope.vertices) {
      points.push_back(to_bullet(Eigen::Vector3d(pose * (polytope.centroid + vertex))));
    }
    btConvexHullComputer computer;
    const btScalar shrunk =
        computer.compute(points.front().m_floats, static_cast<int>(sizeof(btVector3)),
                         static_cast<int>(points.size()), CONVEX_DISTANCE_MARGIN, kMostShrink);
    if (shrunk < 0 || computer.vertices.size() < 4) unsupported("Bullet", "a hull as thin as this");
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < computer.vertices.size(); ++i) hull->addPoint(computer.vertices[i], false);
    hull->setMargin(shrunk);
    hull->recalcLocalAabb();
    return hull;
  }

  std::unique_ptr<btCollisionShape> make_mesh(const TriangleMesh& mesh) {
    refuse_mesh_materials("Bullet", mesh);
    Mesh& kept = *meshes_.emplace_back(std::make_unique<Mesh>());
    for (const Vec3 v : mesh.vertices()) kept.vertices.insert(kept.vertices.end(), {v.x, v.y, v.z});
    for (const MeshTriangle& t : triangles_of(mesh)) {
      for (const std::uint32_t corner : {t.a, t.b, t.c}) kept.indices.push_back(static_cast<int>(corner));
    }
    kept.arrays = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(kept.indices.size() / 3), kept.indices.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(kept.vertices.size() / 3), kept.vertices.data(),
        static_cast<int>(3 * sizeof(btScalar)));
    return std::make_unique<btBvhTriangleMeshShape>(kept.arrays.get(), true);
  }

  // In the frame at `pose`; all but hulls must stand upright there.
  btCollisionShape* make_shape(const scenes::SceneShape& shape, const Polytope* polytope,
                               const Eigen::Isometry3d& pose) {
    if (polytope != nullptr) {
      shapes_.push_back(make_hull(*polytope, pose));
    } else if (const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry)) {
      shapes_.push_back(make_mesh(*mesh));
    } else if (std::holds_alternative<HalfSpace>(shape.geometry)) {
      shapes_.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
    } else if (const auto* box = std::get_if<Box>(&shape.geometry)) {
      shapes_.push_back(std::make_unique<btBoxShape>(to_bullet(box->half_extents)));
    } else if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) {
      const btScalar length = 2 * btScalar{capsule->half_height};
      shapes_.push_back(std::make_unique<btCapsuleShape>(btScalar{capsule->radius}, length));
    } else {
      shapes_.push_back(std::make_unique<btSphereShape>(btScalar{std::get<Sphere>(shape.geometry).radius}));
    }
    return shapes_.back().get();
  }

  // A single hull, or a single other shape at the frame's origin, as it is; else a compound.
  btCollisionShape* make_body_shape(const scenes::Scene& scene, const scenes::SceneBody& body,
                                    const Eigen::Isometry3d& frame) {
    const scenes::SceneShape& first = scene.shapes[body.first_shape];
    const Eigen::Isometry3d to_frame = frame.inverse();
    const Eigen::Isometry3d first_pose = to_frame * to_isometry(first.options.local_pose);
    const Polytope* first_polytope = polytopes_[body.first_shape].get();
    check_material(first, first.material);
    if (body.shape_count == 1 &&
        (first_polytope != nullptr || first_pose.isApprox(Eigen::Isometry3d::Identity(), 1e-9))) {
      return make_shape(first, first_polytope, first_pose);
    }
    auto compound = std::make_unique<btCompoundShape>();
    for (std::uint32_t s = body.first_shape; s < body.first_shape + body.shape_count; ++s) {
      const scenes::SceneShape& shape = scene.shapes[s];
      check_material(shape, first.material);
      compound->addChildShape(to_bullet(to_frame * to_isometry(shape.options.local_pose)),
                              make_shape(shape, polytopes_[s].get(), Eigen::Isometry3d::Identity()));
    }
    shapes_.push_back(std::move(compound));
    return shapes_.back().get();
  }

  const Shared& shared_of(const scenes::Scene& scene, const scenes::SceneBody& body) {
    if (body.shape_count == 0) unsupported("Bullet", "bodies without shapes");
    const bool is_dynamic = body.def.type == BodyType::dynamic;
    const auto [place, is_new] = shared_.try_emplace({body.first_shape, body.shape_count, is_dynamic});
    Shared& shared = place->second;
    if (!is_new) return shared;
    shared.frame = Eigen::Isometry3d::Identity();
    if (is_dynamic) {
      const BodyMass mass = body_mass(scene, body, polytopes_);
      const PrincipalFrame frame = principal_frame(mass);
      shared.frame = Eigen::Translation3d(frame.center) * frame.rotation;
      shared.inertia = frame.inertia;
      shared.mass = mass.mass;
    }
    shared.shape = make_body_shape(scene, body, shared.frame);
    if (!is_dynamic) return shared;
    shared.inner_radius = std::numeric_limits<double>::infinity();
    for (std::uint32_t s = body.first_shape; s < body.first_shape + body.shape_count; ++s) {
      shared.inner_radius =
          std::min(shared.inner_radius, inner_radius(scene.shapes[s].geometry, polytopes_[s].get()));
    }
    return shared;
  }

  void add_body(const scenes::Scene& scene, const scenes::SceneBody& body) {
    const BodyDef& def = body.def;
    const Shared& shared = shared_of(scene, body);
    const bool is_dynamic = def.type == BodyType::dynamic;
    const double mass = !is_dynamic ? 0.0 : def.mass ? double{*def.mass} : shared.mass;
    const Eigen::Vector3d inertia =
        is_dynamic ? Eigen::Vector3d(shared.inertia * (mass / shared.mass)) : Eigen::Vector3d::Zero();
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shared.shape,
                                                  to_bullet(inertia));
    info.m_startWorldTransform = to_bullet(to_isometry({def.position, def.rotation}) * shared.frame);
    info.m_friction = btScalar{scene.shapes[body.first_shape].material.friction};
    info.m_restitution = btScalar{scene.shapes[body.first_shape].material.restitution};
    info.m_linearDamping = btScalar{def.linear_damping};
    info.m_angularDamping = btScalar{def.angular_damping};
    auto object = std::make_unique<btRigidBody>(info);
    object->setUserIndex(static_cast<int>(mix_code(scene.shapes[body.first_shape].material)));
    object->setLinearVelocity(to_bullet(def.linear_velocity));
    object->setAngularVelocity(to_bullet(def.angular_velocity));
    if (def.type == BodyType::kinematic) {
      object->setCollisionFlags(object->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      object->setActivationState(DISABLE_DEACTIVATION);
    }
    if (continuous_ && is_dynamic) {
      object->setCcdMotionThreshold(static_cast<btScalar>(shared.inner_radius));
      object->setCcdSweptSphereRadius(static_cast<btScalar>(kSweptShare * shared.inner_radius));
    }
    if (!def.can_sleep || !scene.settings.sleeping) object->setActivationState(DISABLE_DEACTIVATION);
    const auto free = [&](AxisLocks bit) {
      return (static_cast<unsigned>(def.locks) & static_cast<unsigned>(bit)) != 0 ? btScalar{0} : btScalar{1};
    };
    object->setLinearFactor(
        {free(AxisLocks::translation_x), free(AxisLocks::translation_y), free(AxisLocks::translation_z)});
    object->setAngularFactor(
        {free(AxisLocks::rotation_x), free(AxisLocks::rotation_y), free(AxisLocks::rotation_z)});
    world_.addRigidBody(object.get());
    if (is_dynamic && def.gravity_factor != 1.0f) {
      object->setFlags(object->getFlags() | BT_DISABLE_WORLD_GRAVITY);
      object->setGravity(to_bullet(scene.settings.gravity) * btScalar{def.gravity_factor});
    }
    bodies_.push_back({std::move(object), shared.frame});
  }

  // The end of a joint: a body, or Bullet's for the world, and the frame in it.
  struct End {
    btRigidBody& body;
    Eigen::Isometry3d frame;
  };
  End end_of(std::uint32_t body, const Pose& frame) {
    if (body == scenes::kWorldItself) return {btTypedConstraint::getFixedBody(), to_isometry(frame)};
    return {*bodies_[body].object, bodies_[body].frame.inverse() * to_isometry(frame)};
  }

  // The torque of a drive that does nothing but brake; refuses others.
  static float friction_of(Drive drive, bool stands, float max_torque) {
    if (drive == Drive::none) return 0.0f;
    if (drive == Drive::spring || !stands || max_torque == kNoLimit) {
      unsupported("Bullet", "drives of joints other than friction");
    }
    return max_torque;
  }

  // Bullet's cone has no dry friction. Its general joint has, on every axis by itself, and limits the angles
  // of Euler about z, y and x: a pyramid around the cone. It counts angles the other way.
  static std::unique_ptr<btTypedConstraint> make_ball(const BallJoint& ball, const End& a, const End& b) {
    if (ball == BallJoint{}) {
      return std::make_unique<btPoint2PointConstraint>(a.body, b.body,
                                                       to_bullet(Eigen::Vector3d(a.frame.translation())),
                                                       to_bullet(Eigen::Vector3d(b.frame.translation())));
    }
    auto joint = std::make_unique<btGeneric6DofSpring2Constraint>(a.body, b.body, to_bullet(a.frame),
                                                                  to_bullet(b.frame));
    constexpr int kTwist = 3, kSwing = 4;  // the axis x of the angles, and y with z behind it
    for (int axis = 0; axis < kTwist; ++axis) joint->setLimit(axis, 0, 0);
    const bool twists = ball.twist_lower == -kNoLimit && ball.twist_upper == kNoLimit;
    if (!twists && (ball.twist_lower == -kNoLimit || ball.twist_upper == kNoLimit)) {
      unsupported("Bullet", "balls with one limit of twist");
    }
    const btScalar cone{ball.cone_limit}, low{ball.twist_lower}, high{ball.twist_upper};
    joint->setLimit(kTwist, twists ? 1 : -high, twists ? -1 : -low);
    for (const int axis : {kSwing, kSwing + 1}) {
      const bool swings = ball.cone_limit == kNoLimit;
      joint->setLimit(axis, swings ? 1 : -cone, swings ? -1 : cone);
    }
    const float friction =
        friction_of(ball.drive.drive, ball.drive.velocity == Vec3{}, ball.drive.max_torque);
    for (int axis = kTwist; axis < kTwist + 3 && friction > 0.0f; ++axis) {
      joint->enableMotor(axis, true);
      joint->setTargetVelocity(axis, 0);
      joint->setMaxMotorForce(axis, btScalar{friction});
    }
    return joint;
  }

  // Bullet's hinge turns about z, and counts its angle the other way.
  static std::unique_ptr<btTypedConstraint> make_hinge(const HingeJoint& hinge, const End& a, const End& b,
                                                       float dt) {
    const Eigen::Quaterniond z_to_x(0.5, 0.5, 0.5, 0.5);
    auto joint = std::make_unique<btHingeConstraint>(a.body, b.body, to_bullet(a.frame * z_to_x),
                                                     to_bullet(b.frame * z_to_x));
    const JointAxis& angle = hinge.angle;
    if (angle.lower != -kNoLimit || angle.upper != kNoLimit) {
      if (angle.lower == -kNoLimit || angle.upper == kNoLimit) unsupported("Bullet", "hinges with one limit");
      joint->setLimit(-btScalar{angle.upper}, -btScalar{angle.lower});
    }
    const float friction = friction_of(angle.drive, angle.speed == 0.0f, angle.max_force);
    if (friction > 0.0f) joint->enableAngularMotor(true, 0, btScalar{friction * dt});  // N m s a step
    return joint;
  }

  void add_joint(const scenes::SceneJoint& joint, float dt) {
    const JointDef& def = joint.def;
    const bool plain =
        def.enabled && def.hertz == 0.0f && def.break_force == kNoLimit && def.break_torque == kNoLimit;
    if (!plain) unsupported("Bullet", "joints that are soft, break or are disabled");
    const End a = end_of(joint.body_a, def.frame_a), b = end_of(joint.body_b, def.frame_b);
    if (const auto* ball = std::get_if<BallJoint>(&joint.joint)) {
      joints_.push_back(make_ball(*ball, a, b));
    } else if (const auto* hinge = std::get_if<HingeJoint>(&joint.joint)) {
      joints_.push_back(make_hinge(*hinge, a, b, dt));
    } else {
      unsupported("Bullet", "joints that are neither balls nor hinges");
    }
    world_.addConstraint(joints_.back().get(), !def.collide_connected);
  }

  const std::vector<std::shared_ptr<const Polytope>> polytopes_;
  const bool continuous_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::map<std::tuple<std::uint32_t, std::uint32_t, bool>, Shared> shared_;
  std::vector<std::unique_ptr<Mesh>> meshes_;
  std::vector<Body> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

class BulletEngine final : public Engine {
 public:
  BulletEngine(std::span<const scenes::Scene> scenes, const EngineOptions& options) {
    gCalculateCombinedFrictionCallback = mix_friction;
    gCalculateCombinedRestitutionCallback = mix_restitution;
    for (const scenes::Scene& scene : scenes) {
      worlds_.push_back(std::make_unique<World>(scene, options.continuous));
    }
  }
  void step(float dt) override {
    for (const auto& world : worlds_) world->step(dt);
  }
  void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float) override {
    worlds_[world]->move_kinematic(body, target);
  }
  void push(std::size_t world, std::uint32_t body, Vec3 force) override { worlds_[world]->push(body, force); }
  void read(std::size_t world, std::vector<BodyState>& states) const override {
    worlds_[world]->read(states);
  }
  std::int64_t awake() const override {
    std::int64_t sum = 0;
    for (const auto& world : worlds_) sum += world->awake();
    return sum;
  }
  std::int64_t contacts() const override {
    std::int64_t sum = 0;
    for (const auto& world : worlds_) sum += world->contacts();
    return sum;
  }

 private:
  std::vector<std::unique_ptr<World>> worlds_;
};

}  // namespace

EngineInfo bullet_engine() {
  const int version = btGetVersion();
  return {.name = "bullet",
          .title = "Bullet " + std::to_string(version / 100) + "." + std::to_string(version % 100),
          .settings = std::to_string(btContactSolverInfo{}.m_numIterations) +
                      " iterations (its default); hulls rounded by its margin, inside",
          .continuous =
              "a ball of half the inner radius is swept for every dynamic body that moves by more than "
              "that radius",
          .multithreaded = false,
          .joints = true,
          .create = [](std::span<const scenes::Scene> scenes, const EngineOptions& options)
              -> std::unique_ptr<Engine> { return std::make_unique<BulletEngine>(scenes, options); }};
}

}  // namespace scree::bench
