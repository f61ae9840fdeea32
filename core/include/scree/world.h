// The world: bodies and shapes, and the calls that create, change and read them.
//
// Every call validates before it changes anything and throws scree::Error, which names the call, the value
// and the limit.
//
// Threads: const functions, save() and clone() change nothing that another of them could see, so any number
// of threads may call them at once on one world. A call that is not const, a step and restore() must be alone
// with their world. Different worlds are independent of one another.
#pragma once

#include <scree/body.h>
#include <scree/contact_forces.h>
#include <scree/contact_hooks.h>
#include <scree/error.h>
#include <scree/events.h>
#include <scree/export.h>
#include <scree/hull.h>
#include <scree/ids.h>
#include <scree/joint.h>
#include <scree/shapes.h>
#include <scree/solver.h>
#include <scree/stats.h>
#include <scree/triangle_mesh.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>

namespace scree {

/// Tuning of a world. The defaults suit bodies of about 0.1 to 10 m at 60 steps a second.
struct WorldSettings {
  Vec3 gravity{0.0f, -9.81f, 0.0f};  ///< m/s^2, each within +-1e6
  /// Solver substeps per step, in [1, 64]; Solver::sequential_impulse takes one, whatever stands here. Joints
  /// become stiffer with them, contacts only as contact_hertz rises, too.
  int substeps = 4;
  /// Hz, in [1e-3, 1e4], the frequency f of contacts; at most 1/(8 h) is used, with h the step's dt over
  /// substeps (30 Hz with the defaults at 60 steps a second), and twice that against fixed and kinematic
  /// bodies. A contact of effective mass m overlaps by F / (m (2 pi f)^2) under the force F: m is half the
  /// mass of two equal boxes, the mass of a box on a fixed one.
  float contact_hertz = 30.0f;
  /// Of the contacts' spring, in [0, 1e4], half of it against fixed and kinematic bodies; 1 is critical. How
  /// overlap goes, not how much is left: at 1 bodies hop out of it.
  float contact_damping_ratio = 10.0f;
  /// m/s, largest speed at which overlap is pushed apart, of contacts and of joints, in [0, 1e6]. Too low for
  /// what comes in, it lets bodies sink.
  float push_speed = 3.0f;
  float restitution_threshold = 1.0f;  ///< m/s, approach speeds below do not rebound, in [0, 1e6]
  float max_linear_speed = 400.0f;     ///< m/s, speeds are clamped in each substep, in [1e-3, 1e6]
  float max_angular_speed = 400.0f;    ///< rad/s, in [1e-3, 1e6]
  /// Fast bodies do not pass through others: the step of a body ends where a ball about the center of one of
  /// its shapes, or one that fits into a corner or end of it, would go through, and the next step's contact
  /// takes it with its velocity. Where it rebounds, it makes up for the rest of its step at the end of the
  /// next one. What is thinner than the gaps between these balls may still be passed, but not by bodies with
  /// BodyDef::full_sweep.
  bool continuous = true;
  bool warm_start = true;            ///< begin each step with the impulses of the last one
  bool sleeping = true;              ///< bodies at rest may sleep; turning it off wakes all
  float sleep_linear_speed = 0.05f;  ///< m/s, a body may sleep that has come no farther than at these speeds
  float sleep_angular_speed = 0.1f;  ///< rad/s, both in [0, 1e6]; it may tremble 8 times as fast ...
  /// s, ... for this long, in [0, 1e6]. What may sleep, touches something and turns as slowly is damped.
  float sleep_time = 0.5f;
  ContactEvents contact_events = ContactEvents::none;  ///< asked for of all shapes, besides their own
  float hit_event_speed = 1.0f;       ///< m/s, slowest approach that World::contact_hits lists, in [0, 1e6]
  bool contact_forces = false;        ///< measure what World::contact_forces lists
  bool measure_residual = false;      ///< fill StepStats::residual
  bool measure_penetration = false;   ///< fill StepStats::penetration_*
  Solver solver = Solver::soft_step;  ///< of constraints
  SolverOptions solver_options{};     ///< its tuning
};

/// Memory of a world by column, as generated from its state table.
struct MemoryUse {
  std::size_t state = 0;    ///< bytes of columns that change future results
  std::size_t derived = 0;  ///< bytes of columns that can be recomputed from state
  std::size_t scratch = 0;  ///< bytes that live within one step
};

/// The form of a shape. A TriangleMesh or a HalfSpace belongs to fixed and kinematic bodies only and is no
/// sensor: calls that would put it elsewhere throw.
using Geometry = std::variant<Sphere, Capsule, Box, ConvexHull, TriangleMesh, HalfSpace, Cylinder, Cone>;

/// A shape of a list, see World::add_shapes.
struct ShapeDef {
  Geometry geometry{};     ///< its form
  Material material{};     ///< its surface and density
  ShapeOptions options{};  ///< its place, filter and events
};

struct WorldData;

/// A simulated world. It can be moved, not copied.
class SCREE_API World {
 public:
  /// An empty world. Throws on settings outside the ranges that WorldSettings states.
  explicit World(const WorldSettings& settings = {});
  ~World();
  /// A world that was moved from can only be destroyed or assigned to; its calls throw,
  /// but those that are noexcept find nothing.
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;  ///< the world that was assigned to ends

  /// Makes this world and the other one give and take the same handles, as clones do: for worlds that are
  /// built by the same calls and then compared, or run in lockstep. Throws unless this world has never had
  /// anything in it. It is no part of the state: snapshots in memory carry the handles of the world that was
  /// saved.
  void share_handles(const World& other);

  // --- bodies ---

  /// Creates a body. Throws on values outside the ranges that BodyDef states.
  BodyId create_body(const BodyDef& def);
  /// Creates one body per definition; `ids` has the same length. All or none are created. Indices of
  /// destroyed bodies are used again, the latest first; without such, indices ascend.
  void create_bodies(std::span<const BodyDef> defs, std::span<BodyId> ids);
  /// Creates one body with one shape per definition, all shapes sharing material and options. This is the
  /// fastest way to make many bodies; all or none are created.
  void create_bodies(std::span<const BodyDef> defs, std::span<const Geometry> shapes,
                     const Material& material, const ShapeOptions& options, std::span<BodyId> ids);
  /// Destroys the body, its shapes and its joints, see destroyed_joints. Bodies that touched it, or that
  /// joints joined with it, wake.
  void destroy_body(BodyId body);
  /// Destroys all of the bodies, or none if a handle is dead or stands in the list twice.
  void destroy_bodies(std::span<const BodyId> bodies);
  bool is_alive(BodyId body) const noexcept;  ///< false for a handle of another world, too
  std::size_t body_count() const noexcept;    ///< living bodies of all types
  /// The living body at an index of the bulk columns, or no body.
  BodyId body_at(std::uint32_t index) const noexcept;

  BodyType body_type(BodyId body) const;  ///< fixed, kinematic or dynamic
  /// A body that becomes fixed loses its velocity, one that becomes dynamic gets its mass. What touches it
  /// wakes.
  void set_body_type(BodyId body, BodyType type);
  Pose pose(BodyId body) const;  ///< of the body's origin
  /// Puts the body elsewhere at once, keeping its velocity. Wakes it and what touched it. Position within
  /// +-1e7 m, rotation of unit length within 1e-3.
  void set_pose(BodyId body, const Pose& pose);
  Vec3 linear_velocity(BodyId body) const;   ///< of the center of mass, m/s
  Vec3 angular_velocity(BodyId body) const;  ///< rad/s
  Vec3 velocity_at(BodyId body,
                   Vec3 world_point) const;  ///< of the body's matter at a point of the world, m/s
  /// Components within +-1e9 (the step clamps speeds to the world's limits); locked axes stay at zero. No
  /// effect on fixed bodies. Wakes the body; if it is kinematic, what rests on it, unless its velocity stays
  /// the same.
  void set_linear_velocity(BodyId body, Vec3 velocity);
  void set_angular_velocity(BodyId body, Vec3 velocity);  ///< as set_linear_velocity
  /// Gives a kinematic body the velocities that bring its origin to `target` in one step of `dt` with the
  /// present number of substeps, along a straight line and by the shorter turn. It goes on with them after
  /// that step: set the next target, or zero velocities. Wakes what rests on the body unless its velocities
  /// stay the same. Throws for other bodies, for dt outside (0, 1] and where a velocity would leave the range
  /// of set_linear_velocity, as it would for half a turn in a single substep.
  void set_kinematic_target(BodyId body, const Pose& target, float dt);
  /// In world coordinates, m. Fixed and kinematic bodies turn about their origin unless set_mass_properties
  /// gave them a center.
  Vec3 center_of_mass(BodyId body) const;
  /// Of a fixed or kinematic body: what it would have as a dynamic one.
  MassProperties mass_properties(BodyId body) const;
  /// Replaces what the shapes' densities and BodyDef::mass gave, until reset_mass; changes of the shapes do
  /// not matter meanwhile. The inertia must be that of some solid: positive definite, no principal moment
  /// above the sum of the others (within 0.1 %). The body's matter moves on as it did: linear_velocity
  /// becomes that of the new center.
  void set_mass_properties(BodyId body, const MassProperties& properties);
  /// Back to the shapes' densities: forgets set_mass_properties and BodyDef::mass.
  void reset_mass(BodyId body);
  float linear_damping(BodyId body) const;               ///< 1/s
  float angular_damping(BodyId body) const;              ///< 1/s
  float gravity_factor(BodyId body) const;               ///< multiplies the world's gravity
  AxisLocks locks(BodyId body) const;                    ///< degrees of freedom taken from the body
  void set_linear_damping(BodyId body, float damping);   ///< 1/s, in [0, 1e6]; wakes the body
  void set_angular_damping(BodyId body, float damping);  ///< as set_linear_damping
  /// Multiplies the world's gravity, within +-1e6. Wakes the body.
  void set_gravity_factor(BodyId body, float factor);
  /// Takes degrees of freedom from the body, and the velocity along them. Wakes the body.
  void set_locks(BodyId body, AxisLocks locks);
  bool can_sleep(BodyId body) const;                ///< whether the body may sleep
  void set_can_sleep(BodyId body, bool can_sleep);  ///< forbidding it wakes the body
  bool full_sweep(BodyId body) const;               ///< whether its shapes are swept as they are
  void set_full_sweep(BodyId body, bool full);      ///< see BodyDef::full_sweep
  /// Kinematic bodies are always awake, fixed and quarantined ones never. A sleeper whose neighbor a call has
  /// changed counts as awake if the next step would wake it.
  bool is_awake(BodyId body) const;
  /// Wakes a dynamic body at once; what it leans on follows in the next step. Ends its quarantine, too.
  void wake(BodyId body);
  /// A dynamic or kinematic body whose motion became non-finite in a step (see quarantined_bodies) is
  /// quarantined: it stays where it is like a fixed one, and forces and impulses have no effect on it, until
  /// set_pose, set_linear_velocity, set_angular_velocity, set_kinematic_target, set_body_type or wake ends
  /// that, or it is destroyed. All else that it was given it keeps, and changes of that end no quarantine.
  bool is_quarantined(BodyId body) const;
  std::uint64_t user_data(BodyId body) const;           ///< as given by BodyDef or set_user_data
  void set_user_data(BodyId body, std::uint64_t data);  ///< changes nothing else

  /// Force (N) and torque (N m) act during the next step only; both add up and wake the body. No effect on
  /// fixed and kinematic bodies. Throws where the sum would accelerate the body by more than 1e15 m/s^2 or
  /// rad/s^2.
  void add_force(BodyId body, Vec3 force);
  /// As add_force, at a point of the world: adds the torque about the center of mass, too.
  void add_force_at(BodyId body, Vec3 force, Vec3 world_point);
  /// As add_force.
  void add_torque(BodyId body, Vec3 torque);
  /// Impulses (N s, N m s) change the velocity at once and wake the body. No effect on fixed and kinematic
  /// bodies. Throws where the velocity would leave the range of set_linear_velocity.
  void add_impulse(BodyId body, Vec3 impulse);
  /// As add_impulse, at a point of the world: changes the angular velocity, too.
  void add_impulse_at(BodyId body, Vec3 impulse, Vec3 world_point);
  /// As add_impulse.
  void add_angular_impulse(BodyId body, Vec3 impulse);

  // --- shapes ---

  /// Adds a shape to a body. The mass follows unless set_mass_properties gave it: with BodyDef::mass the
  /// total stays and center and inertia change.
  ShapeId add_shape(BodyId body, const Geometry& geometry, const Material& material = {},
                    const ShapeOptions& options = {});
  /// Adds one shape per definition to a body; `ids` has the same length. All or none are added. The mass
  /// follows once, as in add_shape.
  void add_shapes(BodyId body, std::span<const ShapeDef> defs, std::span<ShapeId> ids);
  void destroy_shape(ShapeId shape);  ///< the mass follows as in add_shape; what touched the shape wakes
  bool is_alive(ShapeId shape) const noexcept;                 ///< false for a handle of another world, too
  std::size_t shape_count() const noexcept;                    ///< living shapes of all bodies
  BodyId body_of(ShapeId shape) const;                         ///< the body that has the shape
  Geometry geometry(ShapeId shape) const;                      ///< as given, with its hull or mesh shared
  void set_geometry(ShapeId shape, const Geometry& geometry);  ///< the mass follows as in add_shape
  Material material(ShapeId shape) const;                      ///< surface and density
  void set_material(ShapeId shape, const Material& material);  ///< the mass follows as in add_shape
  Filter filter(ShapeId shape) const;                          ///< which shapes it collides with
  /// From the next step on. Wakes the body of the shape and what touches it.
  void set_filter(ShapeId shape, const Filter& filter);
  ContactEvents contact_events(ShapeId shape) const;  ///< the events that the shape itself asks for
  /// Takes effect in the next step. A contact that began ends when no side asks for its end any more, and
  /// begins when a side asks for the first time.
  void set_contact_events(ShapeId shape, ContactEvents events);
  ContactHooks contact_hooks(ShapeId shape) const;  ///< the hooks that the shape itself asks for
  /// From the next step on; wakes nothing.
  void set_contact_hooks(ShapeId shape, ContactHooks hooks);
  bool is_sensor(ShapeId shape) const;                    ///< as given by ShapeOptions
  Pose local_pose(ShapeId shape) const;                   ///< in the body's frame
  void set_local_pose(ShapeId shape, const Pose& pose);   ///< the mass follows as in add_shape
  std::uint64_t user_data(ShapeId shape) const;           ///< as given by ShapeOptions or set_user_data
  void set_user_data(ShapeId shape, std::uint64_t data);  ///< changes nothing else
  /// The body's shapes, oldest first; at most `out.size()` are written. Returns how many there are.
  std::size_t shapes_of(BodyId body, std::span<ShapeId> out) const;

  // --- joints ---

  /// Joins two bodies, or one with the world; both wake. Bodies of any type: what joins fixed ones does
  /// nothing until one becomes dynamic. Throws on values outside the ranges that JointDef and the kind of
  /// joint state, and for a joint of a body with itself or of the world with itself.
  JointId create_joint(const JointDef& def, const Joint& joint);
  /// Creates one joint per definition; the lists have the same length. All or none are created.
  void create_joints(std::span<const JointDef> defs, std::span<const Joint> joints, std::span<JointId> ids);
  void destroy_joint(JointId joint);            ///< wakes its bodies
  bool is_alive(JointId joint) const noexcept;  ///< false for a handle of another world, too
  std::size_t joint_count() const noexcept;     ///< living joints, disabled ones included
  JointType joint_type(JointId joint) const;    ///< the kind of the joint
  Joint joint(JointId joint) const;             ///< limits and drives as they are now
  JointDef joint_def(JointId joint) const;      ///< what the joint has whatever its kind
  /// New limits and drives, of the same kind of joint. What it has accumulated stays. Wakes its bodies unless
  /// nothing changes.
  void set_joint(JointId joint, const Joint& to);
  void set_joint_frames(JointId joint, const Pose& frame_a, const Pose& frame_b);  ///< wakes its bodies
  void set_joint_stiffness(JointId joint, float hertz, float damping_ratio);  ///< as in JointDef; wakes them
  /// N and N m, as in JointDef.
  void set_joint_strength(JointId joint, float break_force, float break_torque);
  /// N and N m, as in JointDef, from the next step on. Changes no motion and wakes nothing.
  void set_joint_event_thresholds(JointId joint, float event_force, float event_torque);
  bool is_enabled(JointId joint) const;  ///< false after set_joint_enabled and once it broke
  /// Wakes its bodies. A joint that is enabled begins without impulses.
  void set_joint_enabled(JointId joint, bool enabled);
  bool collides_connected(JointId joint) const;  ///< whether shapes of its bodies collide with each other
  /// Whether shapes of its two bodies collide with each other, from the next step on. A change wakes them.
  void set_collide_connected(JointId joint, bool collide);
  std::uint64_t user_data(JointId joint) const;           ///< as given by JointDef or set_user_data
  void set_user_data(JointId joint, std::uint64_t data);  ///< changes nothing else
  /// Frame b as seen from frame a: what limits and drives are measured in.
  Pose joint_pose(JointId joint) const;
  /// In the last step, until the next one, a call that enables or disables the joint, or a restore; of joints
  /// that slept zero. A joint that broke in it still has its own.
  JointReaction joint_reaction(JointId joint) const;

  // --- user joints, see user_joint.h. JointReaction of one sums its rows: the force is that of linear_b ---

  /// Gives all rows of a user joint their numbers, which stay until they are given again. Wakes its bodies
  /// unless nothing changes. Throws on numbers out of the ranges that user_joint.h states, on another number
  /// of rows than the joint has, and for joints of other kinds.
  void set_user_rows(JointId joint, std::span<const UserRow> rows);
  /// The present numbers; at most `out.size()` rows are written. Returns how many there are.
  std::size_t user_rows(JointId joint, std::span<UserRow> out) const;
  /// Gives all rows of some user joints their numbers, one joint behind the other, as a callback does: a
  /// joint with any number out of range is frozen, see is_frozen, and nothing is thrown for it. Wakes the
  /// bodies of a joint that sleeps and gets other numbers than it has.
  void refresh_user_rows(std::span<const JointId> joints, std::span<const UserRow> rows);
  /// The callback gave the joint a number that is out of range or not finite, or bounds in the wrong order:
  /// it does nothing until it is given sound numbers. False for joints of other kinds.
  bool is_frozen(JointId joint) const;
  /// From now on each step that has a length calls this before it begins, for the user joints that are
  /// enabled and have an awake dynamic body; a default-constructed function ends that. A call gets some of
  /// the joints, which ascend by index. Several calls run at once, on the threads of the step, each for
  /// joints of its own; which joints come together depends on the scene alone. For results that can be
  /// repeated the numbers must depend on the batch and on what does not change meanwhile, and on nothing
  /// else.
  ///
  /// If a call throws, the world stays exactly as it was and step() throws the same; of several exceptions
  /// that of the first joints. Joints of bodies that sleep keep their numbers, and so do those whose bodies
  /// wake during the step until the next one. Recorders record the numbers that have changed: playing them
  /// needs no callback. The callback is no part of the state: snapshots, clones and recordings are without
  /// it, and restore() leaves that of the world which it writes to.
  void set_user_row_callback(UserRowCallback callback);
  bool has_user_row_callback() const noexcept;  ///< whether one is set

  /// The body's joints, latest first; at most `out.size()` are written. Returns how many there are.
  std::size_t joints_of(BodyId body, std::span<JointId> out) const;

  // --- bulk columns, indexed by BodyId::index; entries of no living body are meaningless. A column stays
  // where it is until bodies are created or the world is destroyed ---

  std::span<const Pose> poses() const noexcept;           ///< of the bodies' origins
  std::span<const Velocity> velocities() const noexcept;  ///< of the centers of mass

  // --- events of the last step, see events.h. Each list is the same for every instruction set and thread
  // count, and stays until the next step; calls in between may kill what a handle in it names ---

  /// Contacts ascend by the indices of their shapes: first shape_a's, then shape_b's.
  std::span<const ContactEvent> contact_begins() const noexcept;
  /// Contacts of awake bodies that touched before this step already.
  std::span<const ContactEvent> contact_persists() const noexcept;
  /// Contacts that ended in the step or by calls before it. Ascending as contact_begins.
  std::span<const ContactEnd> contact_ends() const noexcept;
  /// Contacts that hit: pressed in the step, with an approach_speed of at least
  /// WorldSettings::hit_event_speed, whether they touched before or not. Ascending as contact_begins.
  std::span<const ContactEvent> contact_hits() const noexcept;
  /// Shapes that entered sensors. Ascending by the indices of the sensor, then of the visitor.
  std::span<const SensorEvent> sensor_begins() const noexcept;
  /// Shapes that left sensors, in the step or by calls before it. Ascending as sensor_begins.
  std::span<const SensorEvent> sensor_ends() const noexcept;
  /// The shapes that the sensor saw at the end of the last step, ascending by index, some of which calls may
  /// have destroyed since; at most `out.size()` are written. Returns how many there are. Throws for a shape
  /// that is no sensor.
  std::size_t visitors_of(ShapeId sensor, std::span<ShapeId> out) const;
  /// Bodies whose state became non-finite in the step: they were put back to where the step found them, at
  /// rest. Also those that are quarantined because they made only others non-finite: these rest where the
  /// step has brought them. Ascending by index.
  std::span<const BodyId> restored_bodies() const noexcept;
  /// The bodies among restored_bodies() that were at fault and are quarantined now, see is_quarantined. A
  /// body is at fault if its own motion made it non-finite, before any contact acted on it. Where bodies that
  /// contacts connect became non-finite together, and none by its own motion, these are at fault: bodies
  /// whose speed at a contact an impulse of 1 N s changes by less than 1e-18 or more than 1e18 m/s; without
  /// such, bodies with joints; without such, all of them. Ascending by index.
  std::span<const BodyId> quarantined_bodies() const noexcept;
  /// Bodies that fell asleep in the step. Ascending by index.
  std::span<const BodyId> sleep_begins() const noexcept;
  /// Bodies that woke, in the step or before it by a call or next to one that was quarantined as the last
  /// step ended, unless a later call destroyed them or made them fixed or kinematic. Ascending by index.
  std::span<const BodyId> sleep_ends() const noexcept;

  /// Joints whose reaction was above their strength and that are disabled now. Ascending by index.
  std::span<const JointId> broken_joints() const noexcept;
  /// Joints whose reaction was above JointDef::event_force or event_torque, those that broke included.
  /// Ascending by index.
  std::span<const JointEvent> joint_events() const noexcept;
  /// User joints that were frozen by the numbers for this step, see is_frozen. Ascending by index.
  std::span<const JointId> frozen_joints() const noexcept;
  /// Joints that were destroyed with their bodies before the step, in the order of the calls.
  std::span<const JointId> destroyed_joints() const noexcept;

  // --- hooks, see contact_hooks.h. They are no part of the state: snapshots, clones and recordings are
  // without them, and restore() leaves those of the world which it writes to ---

  /// From now on each step calls this for the candidate pairs whose shapes ask; a default-constructed
  /// function ends that.
  void set_contact_filter(ContactFilter filter);
  bool has_contact_filter() const noexcept;  ///< whether one is set
  /// From now on each step calls this for the contacts whose shapes ask; a default-constructed function ends
  /// that.
  void set_contact_rule(ContactRule rule);
  bool has_contact_rule() const noexcept;  ///< whether one is set
  /// Decides for the next step in place of both hooks, which are not called in it: all pairs that are not
  /// listed act as they are. Recorders record what hooks have changed as such a call, so playing it needs no
  /// hooks. The answers ascend strictly by shape_a, shape_b and contact. Those of pairs that no shape asks
  /// for, or that do not touch in the step, have no effect. They replace what an earlier call gave for that
  /// step; without any, hooks are called again. Throws for dead shapes, a wrong order and rules out of range.
  void answer_contact_hooks(std::span<const ContactAnswer> answers);

  // --- forces of contacts, see contact_forces.h: while WorldSettings::contact_forces is on, else these throw
  // Error. They list the contacts of the last step that bore something, or were at most 5 mm apart when it
  // began. A contact of sleeping bodies has the impulses that it bore as they fell asleep. All impulses are
  // zero in a step of no length, and from when the setting was turned on until the next step (of sleeping
  // bodies, until they wake). Contacts are left out if their shapes, or their bodies' types, have been
  // replaced since ---

  /// All contacts, ascending by the indices of their shapes: first shape_a's, then shape_b's. At most
  /// `out.size()` are written. Returns how many there are.
  std::size_t contact_forces(std::span<ContactForces> out) const;
  /// The contacts of one body or shape, which may be either of the two. The first of these calls after a step
  /// looks at all contacts, the others at those of the body or shape.
  std::size_t contact_forces_of(BodyId body, std::span<ContactForces> out) const;
  /// As contact_forces_of(BodyId).
  std::size_t contact_forces_of(ShapeId shape, std::span<ContactForces> out) const;

  // --- the world ---

  const WorldSettings& settings() const;             ///< as they are now
  void set_settings(const WorldSettings& settings);  ///< a change of gravity wakes all bodies
  const StepStats& stats() const;                    ///< figures of the last step
  MemoryUse memory_use() const;                      ///< bytes reserved by all columns
  /// Sum of the hashes (XXH3, 64 bits) of index, pose and velocity of each living body: equal for equal
  /// histories, whatever the instruction set, the thread count, the compiler or the build type.
  std::uint64_t hash() const;

 private:
  friend WorldData& internals(World& world, const char* call);
  friend const WorldData& internals(const World& world, const char* call);
  std::unique_ptr<WorldData> data_;
};

}  // namespace scree
