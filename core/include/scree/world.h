// The world: bodies and shapes, and the calls that create, change and read them.
//
// Every call validates before it changes anything and throws scree::Error, which names the call, the value
// and the limit. Calls are made between steps, by one thread at a time for one world; different worlds are
// independent of one another.
#pragma once

#include <scree/body.h>
#include <scree/error.h>
#include <scree/export.h>
#include <scree/ids.h>
#include <scree/shapes.h>
#include <scree/stats.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>

namespace scree {

/// Tuning of a world. The defaults suit bodies of about 0.1 to 10 m at 60 steps a second.
struct WorldSettings {
  Vec3 gravity{0.0f, -9.81f, 0.0f};  ///< m/s^2
  int substeps = 4;                  ///< solver substeps per step, in [1, 64]
  float contact_hertz = 30.0f;       ///< Hz, stiffness of contacts; at most 1/(8 substep) is used; > 0
  float contact_damping_ratio = 10.0f;
  float push_speed = 3.0f;             ///< m/s, largest speed at which overlap is pushed apart
  float restitution_threshold = 1.0f;  ///< m/s, approach speeds below do not rebound
  float max_linear_speed = 400.0f;     ///< m/s, speeds are clamped in each substep
  float max_angular_speed = 400.0f;    ///< rad/s
  bool warm_start = true;
  bool sleeping = true;
  float sleep_linear_speed = 0.05f;   ///< m/s, a body may sleep when it stays below both speeds ...
  float sleep_angular_speed = 0.1f;   ///< rad/s
  float sleep_time = 0.5f;            ///< s, ... for this long
  bool measure_residual = false;      ///< fill StepStats::residual
  bool measure_penetration = false;   ///< fill StepStats::penetration_*
};

/// Memory of a world by column, as generated from its state table.
struct MemoryUse {
  std::size_t state = 0;    ///< bytes of columns that change future results
  std::size_t derived = 0;  ///< bytes of columns that can be recomputed from state
  std::size_t scratch = 0;  ///< bytes that live within one step
};

using Geometry = std::variant<Sphere, Capsule, Box>;

struct WorldData;

/// A simulated world. It can be moved, not copied.
class SCREE_API World {
 public:
  explicit World(const WorldSettings& settings = {});
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  // --- bodies ---

  /// Creates a body. Throws on values outside the ranges that BodyDef states.
  BodyId create_body(const BodyDef& def);
  /// Creates one body per definition; `ids` has the same length. All or none are created.
  void create_bodies(std::span<const BodyDef> defs, std::span<BodyId> ids);
  /// Creates one body with one shape per definition, all shapes sharing material and options.
  void create_bodies(std::span<const BodyDef> defs, std::span<const Geometry> shapes, const Material& material,
                     const ShapeOptions& options, std::span<BodyId> ids);
  /// Destroys the body and its shapes. Bodies that lay on it wake.
  void destroy_body(BodyId body);
  bool is_alive(BodyId body) const noexcept;
  std::size_t body_count() const noexcept;
  /// The living body at an index of the bulk columns, or no body.
  BodyId body_at(std::uint32_t index) const noexcept;

  BodyType body_type(BodyId body) const;
  void set_body_type(BodyId body, BodyType type);
  Pose pose(BodyId body) const;  ///< of the body's origin
  void set_pose(BodyId body, const Pose& pose);
  Vec3 linear_velocity(BodyId body) const;   ///< of the center of mass, m/s
  Vec3 angular_velocity(BodyId body) const;  ///< rad/s
  void set_linear_velocity(BodyId body, Vec3 velocity);
  void set_angular_velocity(BodyId body, Vec3 velocity);
  Vec3 center_of_mass(BodyId body) const;  ///< in world coordinates, m
  MassProperties mass_properties(BodyId body) const;
  /// Replaces what the shapes' densities gave, until reset_mass or a change of shapes by reset_mass.
  void set_mass_properties(BodyId body, const MassProperties& properties);
  void reset_mass(BodyId body);  ///< back to the shapes' densities
  float linear_damping(BodyId body) const;
  float angular_damping(BodyId body) const;
  float gravity_factor(BodyId body) const;
  AxisLocks locks(BodyId body) const;
  void set_linear_damping(BodyId body, float damping);
  void set_angular_damping(BodyId body, float damping);
  void set_gravity_factor(BodyId body, float factor);
  void set_locks(BodyId body, AxisLocks locks);
  bool can_sleep(BodyId body) const;
  void set_can_sleep(BodyId body, bool can_sleep);
  bool is_awake(BodyId body) const;
  void wake(BodyId body);
  std::uint64_t user_data(BodyId body) const;
  void set_user_data(BodyId body, std::uint64_t data);

  /// Force (N) and torque (N m) act during the next step only; both add up and wake the body.
  void add_force(BodyId body, Vec3 force);
  void add_force_at(BodyId body, Vec3 force, Vec3 world_point);
  void add_torque(BodyId body, Vec3 torque);
  /// Impulses (N s, N m s) change the velocity at once and wake the body. No effect on fixed and kinematic
  /// bodies.
  void add_impulse(BodyId body, Vec3 impulse);
  void add_impulse_at(BodyId body, Vec3 impulse, Vec3 world_point);
  void add_angular_impulse(BodyId body, Vec3 impulse);

  // --- shapes ---

  ShapeId add_shape(BodyId body, const Geometry& geometry, const Material& material = {},
                    const ShapeOptions& options = {});
  void destroy_shape(ShapeId shape);
  bool is_alive(ShapeId shape) const noexcept;
  std::size_t shape_count() const noexcept;
  BodyId body_of(ShapeId shape) const;
  Geometry geometry(ShapeId shape) const;
  void set_geometry(ShapeId shape, const Geometry& geometry);  ///< mass follows unless it was given
  Material material(ShapeId shape) const;
  void set_material(ShapeId shape, const Material& material);
  Filter filter(ShapeId shape) const;
  void set_filter(ShapeId shape, const Filter& filter);
  Pose local_pose(ShapeId shape) const;
  std::uint64_t user_data(ShapeId shape) const;
  void set_user_data(ShapeId shape, std::uint64_t data);
  /// The body's shapes, oldest first; at most `out.size()` are written. Returns how many there are.
  std::size_t shapes_of(BodyId body, std::span<ShapeId> out) const;

  // --- bulk columns, indexed by BodyId::index; entries of no living body are meaningless ---

  std::span<const Pose> poses() const noexcept;           ///< of the bodies' origins
  std::span<const Velocity> velocities() const noexcept;  ///< of the centers of mass

  // --- the world ---

  const WorldSettings& settings() const noexcept;
  void set_settings(const WorldSettings& settings);
  const StepStats& stats() const noexcept;
  MemoryUse memory_use() const noexcept;
  /// xxHash64 over index, pose and velocity of the living bodies in index order: equal for equal histories,
  /// whatever the instruction set, the thread count, the compiler or the build type.
  std::uint64_t hash() const;

 private:
  friend WorldData& internals(World& world);
  friend const WorldData& internals(const World& world);
  std::unique_ptr<WorldData> data_;
};

}  // namespace scree
