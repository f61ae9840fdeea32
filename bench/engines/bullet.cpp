// Bullet behind the engine interface: sequential impulses with its default 10 iterations on one thread,
// mixing rules as the scene has them, exact inertia instead of its box approximation for capsules.
#include "bench/engine.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <string>

namespace scree::bench {
namespace {

btVector3 to_bullet(Vec3 v) { return {btScalar{v.x}, btScalar{v.y}, btScalar{v.z}}; }
btTransform to_bullet(Vec3 position, Quat q) {
  return btTransform(btQuaternion(q.x, q.y, q.z, q.w), to_bullet(position));
}
Vec3 from_bullet(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

btScalar mix_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return std::sqrt(a->getFriction() * b->getFriction());
}

btScalar mix_restitution(const btCollisionObject* a, const btCollisionObject* b) {
  return a->getRestitution() > b->getRestitution() ? a->getRestitution() : b->getRestitution();
}

class World {
 public:
  explicit World(const scenes::Scene& scene) {
    world_.setGravity(to_bullet(scene.settings.gravity));
    for (const scenes::SceneBody& body : scene.bodies) add_body(scene, body);
  }
  ~World() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void step(float dt) { world_.stepSimulation(btScalar{dt}, 0); }  // 0: one step of exactly dt

  void read(std::vector<BodyState>& states) const {
    states.clear();
    for (const auto& body : bodies_) {
      const btQuaternion q = body->getWorldTransform().getRotation();
      const Quat rotation{static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                          static_cast<float>(q.w())};
      states.push_back({{from_bullet(body->getWorldTransform().getOrigin()), rotation},
                        from_bullet(body->getLinearVelocity()),
                        from_bullet(body->getAngularVelocity())});
    }
  }

  std::int64_t contacts() const {
    std::int64_t count = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      if (dispatcher_.getManifoldByIndexInternal(i)->getNumContacts() > 0) ++count;
    }
    return count;
  }

 private:
  btCollisionShape* make_shape(const scenes::SceneShape& shape, const Material& first) {
    const Filter& filter = shape.options.filter;
    const Material& material = shape.material;
    if (filter.category != 1 || filter.mask != 0xffffffffu || filter.group != 0)
      unsupported("Bullet", "filters");
    if (material.rolling_resistance != 0.0f) unsupported("Bullet", "rolling resistance");
    if (material.surface_velocity != Vec3{}) unsupported("Bullet", "surface velocity");
    if (material.friction != first.friction || material.restitution != first.restitution) {
      unsupported("Bullet", "several materials on one body");
    }
    if (const auto* box = std::get_if<Box>(&shape.geometry)) {
      shapes_.push_back(std::make_unique<btBoxShape>(to_bullet(box->half_extents)));
    } else if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) {
      const btScalar length = 2 * btScalar{capsule->half_height};
      shapes_.push_back(std::make_unique<btCapsuleShape>(btScalar{capsule->radius}, length));
    } else {
      shapes_.push_back(std::make_unique<btSphereShape>(btScalar{std::get<Sphere>(shape.geometry).radius}));
    }
    return shapes_.back().get();
  }

  btCollisionShape* make_body_shape(const scenes::Scene& scene, const scenes::SceneBody& body) {
    if (body.shape_count == 0) unsupported("Bullet", "bodies without shapes");
    const scenes::SceneShape& first = scene.shapes[body.first_shape];
    if (body.shape_count == 1 && first.options.local_pose == Pose{}) return make_shape(first, first.material);
    auto compound = std::make_unique<btCompoundShape>();
    for (std::uint32_t s = 0; s < body.shape_count; ++s) {
      const scenes::SceneShape& shape = scene.shapes[body.first_shape + s];
      const Pose& local = shape.options.local_pose;
      compound->addChildShape(to_bullet(local.position, local.rotation), make_shape(shape, first.material));
    }
    shapes_.push_back(std::move(compound));
    return shapes_.back().get();
  }

  void add_body(const scenes::Scene& scene, const scenes::SceneBody& body) {
    const BodyDef& def = body.def;
    btCollisionShape* shape = make_body_shape(scene, body);
    const bool is_dynamic = def.type == BodyType::dynamic;
    const BodyMass mass = is_dynamic ? body_mass(scene, body) : BodyMass{};
    const Eigen::Vector3d inertia = mass.inertia.diagonal();
    const bool is_central =
        mass.center.norm() < 1e-5 &&
        (mass.inertia - Eigen::Matrix3d(inertia.asDiagonal())).norm() < 1e-5 * (inertia.norm() + 1e-30);
    if (is_dynamic && !is_central)
      unsupported("Bullet", "a center of mass or inertia axes off the body's frame");
    btRigidBody::btRigidBodyConstructionInfo info(
        static_cast<btScalar>(mass.mass), nullptr, shape,
        {static_cast<btScalar>(inertia.x()), static_cast<btScalar>(inertia.y()),
         static_cast<btScalar>(inertia.z())});
    info.m_startWorldTransform = to_bullet(def.position, def.rotation);
    info.m_friction = btScalar{scene.shapes[body.first_shape].material.friction};
    info.m_restitution = btScalar{scene.shapes[body.first_shape].material.restitution};
    info.m_linearDamping = btScalar{def.linear_damping};
    info.m_angularDamping = btScalar{def.angular_damping};
    auto object = std::make_unique<btRigidBody>(info);
    object->setLinearVelocity(to_bullet(def.linear_velocity));
    object->setAngularVelocity(to_bullet(def.angular_velocity));
    if (def.type == BodyType::kinematic) {
      object->setCollisionFlags(object->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
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
    bodies_.push_back(std::move(object));
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

class BulletEngine final : public Engine {
 public:
  explicit BulletEngine(std::span<const scenes::Scene> scenes) {
    gCalculateCombinedFrictionCallback = mix_friction;
    gCalculateCombinedRestitutionCallback = mix_restitution;
    for (const scenes::Scene& scene : scenes) worlds_.push_back(std::make_unique<World>(scene));
  }
  void step(float dt) override {
    for (const auto& world : worlds_) world->step(dt);
  }
  void read(std::size_t world, std::vector<BodyState>& states) const override {
    worlds_[world]->read(states);
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
  return {
      .name = "bullet",
      .title = "Bullet " + std::to_string(version / 100) + "." + std::to_string(version % 100),
      .settings = std::to_string(btContactSolverInfo{}.m_numIterations) + " iterations (its default)",
      .multithreaded = false,
      .create = [](std::span<const scenes::Scene> scenes, const EngineOptions&) -> std::unique_ptr<Engine> {
        return std::make_unique<BulletEngine>(scenes);
      }};
}

}  // namespace scree::bench
