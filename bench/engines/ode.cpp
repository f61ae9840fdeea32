// ODE behind the engine interface: QuickStep with its default 20 iterations on one thread, contacts with the
// friction pyramid that its documentation recommends. Its hulls collide through libccd, one point a pair.
#include "bench/engine.h"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <string>
#include <vector>

namespace scree::bench {
namespace {

constexpr int kContactsPerPair = 8;  // what dCollide yields at most for two boxes

Vec3 from_ode(const dReal* v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

struct Finish {  // of a shape's surface
  float friction;
  float restitution;
  std::uint32_t mix;
};

class World {
 public:
  explicit World(const scenes::Scene& scene)
      : polytopes_(make_polytopes(scene)),
        world_(dWorldCreate()),
        space_(dHashSpaceCreate(nullptr)),
        contact_joints_(dJointGroupCreate(0)) {
    const Vec3 g = scene.settings.gravity;
    dWorldSetGravity(world_, dReal{g.x}, dReal{g.y}, dReal{g.z});
    dWorldSetAutoDisableFlag(world_, scene.settings.sleeping ? 1 : 0);
    for (const scenes::SceneBody& body : scene.bodies) add_body(scene, body);
  }
  ~World() {
    dJointGroupDestroy(contact_joints_);
    dSpaceDestroy(space_);
    for (const Mesh& mesh : meshes_) dGeomTriMeshDataDestroy(mesh.data);
    dWorldDestroy(world_);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void step(float dt) {
    contacts_ = 0;
    dSpaceCollide(space_, this,
                  [](void* self, dGeomID a, dGeomID b) { static_cast<World*>(self)->collide(a, b); });
    dWorldQuickStep(world_, dReal{dt});
    dJointGroupEmpty(contact_joints_);
  }

  // The velocities that lead there within one step.
  void move_kinematic(std::uint32_t body, const Pose& target, float dt) {
    const dBodyID id = bodies_[body].id;
    const dReal* p = dBodyGetPosition(id);
    const Eigen::Vector3d way = to_double(target.position) - Eigen::Vector3d(p[0], p[1], p[2]);
    const Eigen::AngleAxisd turn(to_double(target.rotation) * rotation_of(id).conjugate());
    const double wrapped = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
    const Eigen::Vector3d velocity = way / double{dt};
    const Eigen::Vector3d spin = turn.axis() * (wrapped / double{dt});
    dBodySetLinearVel(id, velocity.x(), velocity.y(), velocity.z());
    dBodySetAngularVel(id, spin.x(), spin.y(), spin.z());
  }

  void read(std::vector<BodyState>& states) const {
    states.clear();
    for (const Body& body : bodies_) {
      if (body.id == nullptr) {
        states.push_back({body.pose, {}, {}});
        continue;
      }
      const dReal* p = dBodyGetPosition(body.id);
      const Eigen::Quaterniond q = rotation_of(body.id);
      const Eigen::Vector3f origin = (Eigen::Vector3d(p[0], p[1], p[2]) - q * body.center).cast<float>();
      const Quat rotation{static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                          static_cast<float>(q.w())};
      states.push_back({{{origin.x(), origin.y(), origin.z()}, rotation},
                        from_ode(dBodyGetLinearVel(body.id)),
                        from_ode(dBodyGetAngularVel(body.id))});
    }
  }

  std::int64_t awake() const {
    return std::count_if(bodies_.begin(), bodies_.end(), [](const Body& body) {
      return body.id != nullptr && dBodyIsKinematic(body.id) == 0 && dBodyIsEnabled(body.id) != 0;
    });
  }
  std::int64_t contacts() const { return contacts_; }

 private:
  struct Body {
    dBodyID id;  // null for a fixed one
    Pose pose;
    Eigen::Vector3d center;  // of mass in the body's frame: where ODE has its own origin
  };
  // A hull in the form that ODE keeps pointers to.
  struct Convex {
    std::vector<dReal> planes;
    std::vector<dReal> points;
    std::vector<unsigned> polygons;
  };

  struct Mesh {
    std::vector<float> vertices;
    std::vector<dTriIndex> indices;
    dTriMeshDataID data;
  };

  static Eigen::Quaterniond rotation_of(dBodyID id) {
    const dReal* q = dBodyGetQuaternion(id);
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }

  dGeomID make_convex(const Polytope& polytope) {
    Convex& convex = convexes_[&polytope];
    if (convex.points.empty()) {
      for (const Eigen::Vector3d& vertex : polytope.vertices) {
        convex.points.insert(convex.points.end(), {vertex.x(), vertex.y(), vertex.z()});
      }
      for (std::size_t face = 0; face < polytope.loops.size(); ++face) {
        const Eigen::Vector3d& n = polytope.normals[face];
        convex.planes.insert(convex.planes.end(), {n.x(), n.y(), n.z(), polytope.offsets[face]});
        convex.polygons.push_back(static_cast<unsigned>(polytope.loops[face].size()));
        for (const int vertex : polytope.loops[face])
          convex.polygons.push_back(static_cast<unsigned>(vertex));
      }
    }
    return dCreateConvex(space_, convex.planes.data(), static_cast<unsigned>(polytope.loops.size()),
                         convex.points.data(), static_cast<unsigned>(polytope.vertices.size()),
                         convex.polygons.data());
  }

  dGeomID make_mesh(const TriangleMesh& mesh) {
    refuse_mesh_materials("ODE", mesh);
    Mesh& kept = meshes_.emplace_back(Mesh{{}, {}, dGeomTriMeshDataCreate()});
    for (const Vec3 v : mesh.vertices()) kept.vertices.insert(kept.vertices.end(), {v.x, v.y, v.z});
    for (const MeshTriangle& t : triangles_of(mesh)) kept.indices.insert(kept.indices.end(), {t.a, t.b, t.c});
    dGeomTriMeshDataBuildSingle(kept.data, kept.vertices.data(), 3 * sizeof(float),
                                static_cast<int>(kept.vertices.size() / 3), kept.indices.data(),
                                static_cast<int>(kept.indices.size()), 3 * sizeof(dTriIndex));
    // Its hulls need the angles between triangles.
    dGeomTriMeshDataPreprocess2(kept.data, 1u << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr);
    return dCreateTriMesh(space_, kept.data, nullptr, nullptr, nullptr);
  }

  void collide(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    if (body_a == body_b) return;
    dContact contacts[kContactsPerPair];
    const int count = dCollide(a, b, kContactsPerPair, &contacts[0].geom, sizeof(dContact));
    if (count > 0) ++contacts_;
    const auto& finish_a = *static_cast<const Finish*>(dGeomGetData(a));
    const auto& finish_b = *static_cast<const Finish*>(dGeomGetData(b));
    for (int i = 0; i < count; ++i) {
      contacts[i].surface.mode = dContactApprox1 | dContactBounce;
      contacts[i].surface.mu =
          dReal{mixed_friction(finish_a.friction, finish_a.mix, finish_b.friction, finish_b.mix)};
      contacts[i].surface.bounce =
          dReal{mixed_restitution(finish_a.restitution, finish_a.mix, finish_b.restitution, finish_b.mix)};
      contacts[i].surface.bounce_vel = 1.0;
      dJointAttach(dJointCreateContact(world_, contact_joints_, &contacts[i]), body_a, body_b);
    }
  }

  static void check(const scenes::SceneShape& shape) {
    const Filter& filter = shape.options.filter;
    if (filter.category != 1 || filter.mask != 0xffffffffu || filter.group != 0)
      unsupported("ODE", "filters");
    if (shape.material.rolling_resistance != 0.0f) unsupported("ODE", "rolling resistance");
    if (shape.material.surface_velocity != Vec3{}) unsupported("ODE", "surface velocity");
  }

  dGeomID make_geom(const scenes::SceneShape& shape, const Polytope* polytope) {
    dGeomID geom = nullptr;
    if (polytope != nullptr) {
      geom = make_convex(*polytope);
    } else if (const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry)) {
      geom = make_mesh(*mesh);
    } else if (const auto* box = std::get_if<Box>(&shape.geometry)) {
      const Vec3 h = box->half_extents;
      geom = dCreateBox(space_, 2 * dReal{h.x}, 2 * dReal{h.y}, 2 * dReal{h.z});
    } else if (const auto* capsule = std::get_if<Capsule>(&shape.geometry)) {
      geom = dCreateCapsule(space_, dReal{capsule->radius}, 2 * dReal{capsule->half_height});
    } else {
      geom = dCreateSphere(space_, dReal{std::get<Sphere>(shape.geometry).radius});
    }
    keep(geom, shape);
    return geom;
  }

  void keep(dGeomID geom, const scenes::SceneShape& shape) {
    finishes_.push_back({shape.material.friction, shape.material.restitution, mix_code(shape.material)});
    dGeomSetData(geom, &finishes_.back());
  }

  // ODE's planes have no pose.
  void add_plane(const scenes::SceneShape& shape, const Eigen::Vector3d& position,
                 const Eigen::Quaterniond& rotation) {
    const Eigen::Vector3d normal =
        rotation * to_double(shape.options.local_pose.rotation) * Eigen::Vector3d::UnitY();
    const Eigen::Vector3d place = position + rotation * to_double(shape.options.local_pose.position);
    keep(dCreatePlane(space_, normal.x(), normal.y(), normal.z(), normal.dot(place)), shape);
  }

  // The geom's pose in the body; ODE's capsules lie along z, the scene's along y, and a hull's origin is its
  // centroid.
  static void shape_pose(const scenes::SceneShape& shape, const Polytope* polytope, Eigen::Vector3d& position,
                         Eigen::Quaterniond& rotation) {
    position = to_double(shape.options.local_pose.position);
    rotation = to_double(shape.options.local_pose.rotation);
    if (polytope != nullptr) position += rotation * polytope->centroid;
    if (std::holds_alternative<Capsule>(shape.geometry)) {
      rotation =
          rotation * Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY());
    }
  }

  void add_body(const scenes::Scene& scene, const scenes::SceneBody& body) {
    const BodyDef& def = body.def;
    if (def.locks != AxisLocks::none) unsupported("ODE", "axis locks");
    const Eigen::Vector3d position = to_double(def.position);
    const Eigen::Quaterniond rotation = to_double(def.rotation);
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    const dBodyID id =
        def.type == BodyType::fixed ? nullptr : make_body(scene, body, position, rotation, center);
    for (std::uint32_t s = 0; s < body.shape_count; ++s) {
      const scenes::SceneShape& shape = scene.shapes[body.first_shape + s];
      const Polytope* polytope = polytopes_[body.first_shape + s].get();
      check(shape);
      if (std::holds_alternative<HalfSpace>(shape.geometry)) {
        if (id != nullptr) unsupported("ODE", "half-spaces of kinematic bodies");
        add_plane(shape, position, rotation);
        continue;
      }
      const dGeomID geom = make_geom(shape, polytope);
      Eigen::Vector3d p;
      Eigen::Quaterniond q;
      shape_pose(shape, polytope, p, q);
      if (id == nullptr) {
        p = position + rotation * p;
        q = rotation * q;
      }
      const dQuaternion quaternion = {q.w(), q.x(), q.y(), q.z()};
      if (id != nullptr) {
        p -= center;
        dGeomSetBody(geom, id);
        dGeomSetOffsetPosition(geom, p.x(), p.y(), p.z());
        dGeomSetOffsetQuaternion(geom, quaternion);
      } else {
        dGeomSetPosition(geom, p.x(), p.y(), p.z());
        dGeomSetQuaternion(geom, quaternion);
      }
    }
    bodies_.push_back({id, {def.position, def.rotation}, center});
  }

  dBodyID make_body(const scenes::Scene& scene, const scenes::SceneBody& body,
                    const Eigen::Vector3d& position, const Eigen::Quaterniond& rotation,
                    Eigen::Vector3d& center) {
    const BodyDef& def = body.def;
    const dBodyID id = dBodyCreate(world_);
    if (def.type == BodyType::kinematic) {
      dBodySetKinematic(id);
    } else {
      const BodyMass exact = body_mass(scene, body, polytopes_);
      center = exact.center;
      const Eigen::Matrix3d& j = exact.inertia;
      dMass mass;
      dMassSetParameters(&mass, exact.mass, 0, 0, 0, j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2), j(1, 2));
      dBodySetMass(id, &mass);
    }
    const dQuaternion quaternion = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
    const Eigen::Vector3d placed = position + rotation * center;
    dBodySetPosition(id, placed.x(), placed.y(), placed.z());
    dBodySetQuaternion(id, quaternion);
    const Vec3 v = def.linear_velocity;
    const Vec3 w = def.angular_velocity;
    dBodySetLinearVel(id, dReal{v.x}, dReal{v.y}, dReal{v.z});
    dBodySetAngularVel(id, dReal{w.x}, dReal{w.y}, dReal{w.z});
    dBodySetLinearDamping(id, dReal{def.linear_damping * scene.dt});  // ODE's is a fraction per step
    dBodySetAngularDamping(id, dReal{def.angular_damping * scene.dt});
    if (!def.can_sleep) dBodySetAutoDisableFlag(id, 0);
    if (def.gravity_factor == 0.0f) {
      dBodySetGravityMode(id, 0);
    } else if (def.gravity_factor != 1.0f) {
      unsupported("ODE", "gravity factors other than 0 and 1");
    }
    return id;
  }

  const std::vector<std::shared_ptr<const Polytope>> polytopes_;
  std::map<const Polytope*, Convex> convexes_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contact_joints_;
  std::deque<Finish> finishes_;  // geoms point into it
  std::deque<Mesh> meshes_;      // and into it
  std::vector<Body> bodies_;
  std::int64_t contacts_ = 0;
};

class OdeEngine final : public Engine {
 public:
  explicit OdeEngine(std::span<const scenes::Scene> scenes) {
    dInitODE2(0);
    for (const scenes::Scene& scene : scenes) worlds_.push_back(std::make_unique<World>(scene));
  }
  ~OdeEngine() override {
    worlds_.clear();
    dCloseODE();
  }
  OdeEngine(const OdeEngine&) = delete;
  OdeEngine& operator=(const OdeEngine&) = delete;

  void step(float dt) override {
    for (const auto& world : worlds_) world->step(dt);
  }
  void move_kinematic(std::size_t world, std::uint32_t body, const Pose& target, float dt) override {
    worlds_[world]->move_kinematic(body, target, dt);
  }
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

EngineInfo ode_engine() {
  return {
      .name = "ode",
      .title = "ODE " SCREE_BENCH_ODE,
      .settings = "QuickStep, 20 iterations (its default), collision included",
      .continuous = {},
      .multithreaded = false,
      .create = [](std::span<const scenes::Scene> scenes, const EngineOptions&) -> std::unique_ptr<Engine> {
        return std::make_unique<OdeEngine>(scenes);
      }};
}

}  // namespace scree::bench
