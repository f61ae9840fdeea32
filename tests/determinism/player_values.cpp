// See player_values.h.
#include <core/constraints/joint_parameters.h>
#include <core/world/fp_environment.h>
#include <core/world/math.h>
#include <tests/determinism/player_values.h>

#include <algorithm>
#include <vector>

namespace scree::determinism {
namespace {

// True once in `times`.
bool once_in(Random& random, std::uint32_t times) { return random.below(times) == 0; }

template <class T, std::size_t count>
T any_of(Random& random, const T (&values)[count]) {
  return values[random.below(count)];
}

// Calls that the compiler must not inline: inlined arithmetic may move out of FpEnvironment.
[[gnu::noinline]] float draw_between(scenes::Random& random, float low, float high) {
  return random.between(low, high);
}
[[gnu::noinline]] Quat draw_rotation(scenes::Random& random) { return random.rotation(); }
[[gnu::noinline]] void set_box_inertia(MassProperties& properties, float x, float y, float z) {
  const float third = properties.mass / 3.0f;
  properties.inertia[0] = third * (y * y + z * z);
  properties.inertia[1] = third * (x * x + z * z);
  properties.inertia[2] = third * (x * x + y * y);
}

}  // namespace

float Random::between(float low, float high) {
  const FpEnvironment environment;
  return draw_between(*this, low, high);
}

Quat Random::rotation() {
  const FpEnvironment environment;
  return draw_rotation(*this);
}

Vec3 random_vector(Random& random, float limit) {
  const float x = random.between(-limit, limit);
  const float y = random.between(-limit, limit);
  const float z = random.between(-limit, limit);
  return {x, y, z};
}

Pose random_pose(Random& random) {
  Pose pose;
  pose.position = random_vector(random, 0.8f * kPitHalfWidth);
  pose.position.y = random.between(0.0f, 0.7f * kPitHeight);
  if (!once_in(random, 3)) pose.rotation = random.rotation();
  return pose;
}

namespace {

// A few different hulls, so that shapes share them, each from random numbers of its own.
Hull random_hull(std::uint32_t which) {
  Random random(which);
  std::vector<Vec3> points(4 + 9 * which);
  for (Vec3& point : points) point = random_vector(random, 0.7f);
  return Hull(points, {.max_vertices = 32});
}

ConvexHull random_convex_hull(Random& random) {
  ConvexHull convex;
  convex.hull = random_hull(random.below(6));
  if (once_in(random, 2)) return convex;
  constexpr float kScales[] = {0.5f, 0.8f, 1.3f};
  convex.scale.x = any_of(random, kScales);
  convex.scale.y = any_of(random, kScales);
  convex.scale.z = any_of(random, kScales);
  return convex;
}

}  // namespace

Geometry random_geometry(Random& random) {
  const std::uint32_t kind = random.below(8);
  switch (kind) {
    case 0:
    case 4: {
      const float x = random.between(0.1f, 0.8f);
      const float y = random.between(0.1f, 0.8f);
      const float z = random.between(0.1f, 0.8f);
      return Box{{x, y, z}, kind == 4 ? random.between(0.01f, 0.3f) : 0.0f};
    }
    case 2:
      return random_convex_hull(random);
    case 5: {
      ConvexHull convex = random_convex_hull(random);
      convex.rounding = once_in(random, 2) ? 0.125f : 0.25f;  // few, so that shapes share slots
      return convex;
    }
    case 6: {
      const float half_height = random.between(0.05f, 0.8f);
      return Cylinder{half_height, random.between(0.1f, 0.6f)};
    }
    case 7: {
      const float half_height = random.between(0.05f, 0.8f);
      return Cone{half_height, random.between(0.1f, 0.6f)};
    }
    case 1:
      return Sphere{random.between(0.1f, 0.7f)};
    default: {
      const float half_height = random.between(0.1f, 0.8f);
      const float radius = random.between(0.1f, 0.4f);
      return Capsule{half_height, radius};
    }
  }
}

// One of a few grounds with bumps, of which some have a hole, and of which some shapes share one.
TriangleMesh random_mesh(Random& random) {
  const std::uint32_t which = random.below(5);
  Random bumps(which);
  const std::uint32_t columns = 3 + which, rows = 4;
  std::vector<float> heights(columns * rows);
  for (float& height : heights) height = bumps.between(-0.3f, 0.3f);
  std::vector<std::uint8_t> holes((columns - 1) * (rows - 1), 0);
  if (which > 1) holes[which] = 1;
  return height_field_mesh({.columns = columns, .rows = rows, .heights = heights, .holes = holes});
}

Material random_material(Random& random) {
  Material material;
  constexpr MixRule kRules[] = {MixRule::minimum, MixRule::average, MixRule::product, MixRule::geometric_mean,
                                MixRule::maximum};
  material.friction = once_in(random, 5) ? 0.0f : random.between(0.0f, 1.2f);
  if (once_in(random, 3)) material.restitution = random.unit();
  if (once_in(random, 4)) material.rolling_resistance = random.between(0.0f, 0.1f);
  material.density = random.between(50.0f, 5000.0f);
  if (once_in(random, 5)) material.surface_velocity = random_vector(random, 3.0f);
  material.friction_mix = any_of(random, kRules);
  material.restitution_mix = any_of(random, kRules);
  if (material.rolling_resistance > 0.095f)
    material.patch_radius = 20.0f * (material.rolling_resistance - 0.095f);
  return material;
}

Filter random_filter(Random& random) {
  Filter filter;
  if (once_in(random, 2)) return filter;
  filter.category = 1u << random.below(3);
  filter.mask = 1 + random.below(7);
  filter.group = static_cast<std::int32_t>(random.below(5)) - 2;
  return filter;
}

ShapeOptions random_options(Random& random) {
  ShapeOptions options;
  if (once_in(random, 2)) {
    options.local_pose.position = random_vector(random, 0.6f);
    options.local_pose.rotation = random.rotation();
  }
  options.filter = random_filter(random);
  options.user_data = random.next();
  options.contact_events = static_cast<ContactEvents>(random.below(8));
  options.sensor = options.user_data % 8 == 0;
  if (options.user_data / 8 % 4 == 0)
    options.contact_hooks = static_cast<ContactHooks>(options.user_data / 32 % 4);
  return options;
}

void hook_up(World& world) {
  const auto number = [](const HookedPair& pair) { return 5 * pair.shape_a.index + 3 * pair.shape_b.index; };
  world.set_contact_filter([number](const ContactFilterBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) batch.collide[i] = number(batch.pairs[i]) % 4 != 0;
  });
  world.set_contact_rule([number](const ContactRuleBatch& batch) {
    for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
      ContactRules& rules = batch.rules[i];
      const std::uint32_t kind = number(batch.pairs[i]) % 9;
      if (kind == 0) rules.acts = batch.contacts[i].normal.y > 0.0f;
      if (kind == 1) rules.friction *= 0.5f;
      // Heaps of what rebounds take thousands of sweeps a step.
      if (number(batch.pairs[i]) % 63 == 2) rules.restitution = 0.5f;
      if (kind == 3) rules.surface_velocity = 2.0f * batch.contacts[i].normal + Vec3{0.5f, 0.0f, 1.0f};
      if (kind == 4) rules.rolling_resistance = 0.1f;
      if (kind == 5) rules = {};
      if (kind == 6) rules.restitution = -1.0f;
    }
  });
}

AxisLocks random_locks(Random& random) {
  constexpr AxisLocks kPlanar = AxisLocks::translation_z | AxisLocks::rotation_x | AxisLocks::rotation_y;
  switch (random.below(4)) {
    case 0:
      return kPlanar;
    case 1:
      return static_cast<AxisLocks>(random.below(64));
    default:
      return AxisLocks::none;
  }
}

BodyDef random_body_def(Random& random) {
  BodyDef def;
  constexpr BodyType kTypes[] = {BodyType::fixed,   BodyType::kinematic, BodyType::dynamic,
                                 BodyType::dynamic, BodyType::dynamic,   BodyType::dynamic,
                                 BodyType::dynamic, BodyType::dynamic};
  def.type = any_of(random, kTypes);
  const Pose pose = random_pose(random);
  def.position = pose.position;
  def.rotation = pose.rotation;
  if (once_in(random, 2)) def.linear_velocity = random_vector(random, 5.0f);
  if (once_in(random, 2)) def.angular_velocity = random_vector(random, 5.0f);
  if (once_in(random, 4)) def.linear_damping = random.unit();
  if (once_in(random, 4)) def.angular_damping = random.unit();
  if (once_in(random, 8)) def.gravity_factor = random.between(-1.0f, 2.0f);
  if (once_in(random, 4)) def.locks = random_locks(random);
  if (once_in(random, 5)) def.mass = random.between(0.1f, 1000.0f);
  def.can_sleep = !once_in(random, 6);
  def.full_sweep = once_in(random, 12);
  def.user_data = random.next();
  return def;
}

// Mass properties of a solid box with its center near the origin.
MassProperties random_mass_properties(Random& random) {
  MassProperties properties;
  properties.mass = random.between(0.5f, 500.0f);
  properties.center = random_vector(random, 0.2f);
  const float x = random.between(0.2f, 1.0f);
  const float y = random.between(0.2f, 1.0f);
  const float z = random.between(0.2f, 1.0f);
  const FpEnvironment environment;
  set_box_inertia(properties, x, y, z);
  return properties;
}

float random_time_step(Random& random) {
  constexpr float kUsual = 1.0f / 60.0f;
  constexpr float kSteps[] = {kUsual,        kUsual,       kUsual, kUsual, kUsual,
                              1.0f / 240.0f, 1.0f / 30.0f, 0.1f,   0.0f};
  return once_in(random, 8) ? random.between(0.0f, 0.05f) : any_of(random, kSteps);
}

WorldSettings random_settings(Random& random) {
  WorldSettings settings;
  if (once_in(random, 3)) settings.gravity = random_vector(random, 12.0f);
  settings.substeps = 1 + static_cast<int>(random.below(6));
  if (once_in(random, 3)) settings.contact_hertz = random.between(10.0f, 120.0f);
  if (once_in(random, 4)) settings.contact_damping_ratio = random.between(0.5f, 20.0f);
  if (once_in(random, 4)) settings.push_speed = random.between(0.5f, 10.0f);
  if (once_in(random, 4)) settings.restitution_threshold = random.between(0.0f, 2.0f);
  if (once_in(random, 4)) settings.max_linear_speed = random.between(5.0f, 100.0f);
  if (once_in(random, 4)) settings.max_angular_speed = random.between(5.0f, 100.0f);
  settings.continuous = !once_in(random, 6);
  settings.warm_start = !once_in(random, 4);
  settings.sleeping = !once_in(random, 3);
  if (once_in(random, 4)) settings.sleep_linear_speed = random.between(0.0f, 0.5f);
  if (once_in(random, 4)) settings.sleep_angular_speed = random.between(0.0f, 1.0f);
  if (once_in(random, 2)) settings.sleep_time = random.between(0.0f, 0.3f);
  if (once_in(random, 2)) settings.contact_events = static_cast<ContactEvents>(random.below(8));
  if (once_in(random, 2)) settings.hit_event_speed = random.between(0.0f, 4.0f);
  settings.measure_residual = once_in(random, 2);
  settings.measure_penetration = once_in(random, 2);
  settings.contact_forces = settings.measure_residual != settings.measure_penetration;
  // Without the direct one: see Player::change_settings.
  if (once_in(random, 4)) settings.solver = static_cast<Solver>(random.below(kSolverCount - 1));
  if (once_in(random, 2)) settings.solver_options.baumgarte = random.between(0.0f, 1.0f);
  if (once_in(random, 2)) settings.solver_options.slop = random.between(0.0f, 0.02f);
  settings.solver_options.iterations = 1 + static_cast<int>(random.below(8));
  settings.solver_options.shuffle_seed = static_cast<std::uint32_t>(random.below(3));
  settings.solver_options.points_together = once_in(random, 3);
  return settings;
}

namespace {

JointAxis random_axis(Random& random, float limit) {
  JointAxis axis;
  if (once_in(random, 2)) axis.lower = random.between(-limit, 0.0f);
  if (once_in(random, 2)) axis.upper = random.between(0.0f, limit);
  if (once_in(random, 8)) axis.lower = axis.upper = random.between(-limit, limit);
  axis.drive = static_cast<Drive>(random.below(3));
  axis.target = random.between(-limit, limit);
  axis.speed = random.between(-3.0f, 3.0f);
  axis.hertz = random.between(0.2f, 20.0f);
  axis.damping_ratio = random.between(0.0f, 2.0f);
  if (once_in(random, 2)) axis.max_force = random.between(0.0f, 5000.0f);
  return axis;
}

RotationDrive random_rotation_drive(Random& random) {
  RotationDrive drive;
  drive.drive = static_cast<Drive>(random.below(3));
  drive.target = random.rotation();
  drive.velocity = random_vector(random, 2.0f);
  drive.hertz = random.between(0.2f, 20.0f);
  drive.damping_ratio = random.between(0.0f, 2.0f);
  if (once_in(random, 2)) drive.max_torque = random.between(0.0f, 2000.0f);
  return drive;
}

float random_ratio(Random& random) {
  const float size = random.between(0.2f, 3.0f);
  return once_in(random, 2) ? -size : size;
}

// Every kind, as it is by default before.
void randomize(Random& random, BallJoint& joint) {
  if (once_in(random, 2)) return;
  if (once_in(random, 2)) joint.cone_limit = random.between(0.0f, 3.0f);
  if (once_in(random, 2)) joint.twist_lower = random.between(-3.0f, 0.0f);
  if (once_in(random, 2)) joint.twist_upper = random.between(0.0f, 3.0f);
  joint.drive = random_rotation_drive(random);
}
void randomize(Random& random, HingeJoint& joint) { joint.angle = random_axis(random, 3.0f); }
void randomize(Random& random, SliderJoint& joint) { joint.offset = random_axis(random, 2.0f); }
void randomize(Random& random, DistanceJoint& joint) {
  JointAxis& length = joint.length;
  length = random_axis(random, 1.0f);
  if (length.lower < 0.0f) length.lower = 0.0f;
  if (length.upper < length.lower) length.upper = length.lower;
  length.target = random.between(0.0f, 2.0f);
}
void randomize(Random& random, WeldJoint& joint) {
  if (once_in(random, 2)) joint.angular_hertz = random.between(0.5f, 30.0f);
  joint.angular_damping_ratio = random.between(0.0f, 2.0f);
}
void randomize(Random& random, SixDegreeJoint& joint) {
  for (JointAxis& axis : joint.offset) axis = random_axis(random, 1.0f);
  for (JointAxis& axis : joint.angle) axis = random_axis(random, 2.0f);
}
void randomize(Random& random, WheelJoint& joint) {
  joint.suspension = random_axis(random, 1.0f);
  joint.steering = random_axis(random, 1.5f);
  joint.spin = {.drive = random.below(2) == 0 ? Drive::motor : Drive::none,
                .speed = random.between(-20.0f, 20.0f),
                .max_force = random.between(0.0f, 500.0f)};
}
void randomize(Random& random, UniversalJoint& joint) {
  joint.first = random_axis(random, 2.0f);
  joint.second = random_axis(random, 2.0f);
}
void randomize(Random& random, PlanarJoint& joint) {
  joint.offset_y = random_axis(random, 2.0f);
  joint.offset_z = random_axis(random, 2.0f);
  joint.angle = random_axis(random, 3.0f);
}
void randomize(Random& random, GearJoint& joint) { joint.ratio = random_ratio(random); }
void randomize(Random& random, RackAndPinionJoint& joint) { joint.radius = random_ratio(random); }
void randomize(Random& random, PulleyJoint& joint) {
  joint.point_a = random_pose(random).position;
  joint.point_b = random_pose(random).position;
  joint.ratio = random.between(0.3f, 3.0f);
  joint.length = random.between(0.0f, 20.0f);
  joint.rigid = once_in(random, 2);
}
void randomize(Random& random, MotorJoint& joint) {
  joint.rotation = random_rotation_drive(random);
  joint.drive = static_cast<Drive>(random.below(3));
  joint.target = random_vector(random, 1.0f);
  joint.velocity = random_vector(random, 2.0f);
  joint.hertz = random.between(0.2f, 20.0f);
  if (once_in(random, 2)) joint.max_force = random.between(0.0f, 5000.0f);
}
void randomize(Random& random, MouseJoint& joint) {
  joint.target = random_pose(random).position;
  joint.hertz = random.between(0.5f, 10.0f);
  if (once_in(random, 2)) joint.max_force = random.between(0.0f, 5000.0f);
}

void randomize(Random& random, UserJoint& joint) {
  const std::uint32_t count = 1 + random.below(kMaxUserRows);
  for (std::uint32_t i = 0; i < count; ++i) {
    joint.rows[i] = once_in(random, 2) ? RowKind::held : static_cast<RowKind>(1 + random.below(4));
  }
}

template <class Kind>
Joint random_kind(Random& random) {
  Kind joint;
  randomize(random, joint);
  return joint;
}

Pose local_pose(const Pose& body, Vec3 anchor, Quat rotation) {
  constexpr float kFarthest =
      1e5f;  // m, that a joint may be from its body's origin; some bodies fly farther apart
  const Quat back = conjugate(body.rotation);
  const Vec3 arm = rotate(back, anchor - body.position);
  const auto within = [&](float x) { return std::clamp(x, -kFarthest, kFarthest); };
  return {{within(arm.x), within(arm.y), within(arm.z)}, normalize(back * rotation)};
}

// Where an anchor between two bodies lies.
[[gnu::noinline]] void place_frames(JointDef& def, const Pose& at_a, const Pose& at_b, Vec3 offset,
                                    Quat rotation) {
  const Vec3 anchor = 0.5f * (at_a.position + at_b.position) + offset;
  def.frame_a = local_pose(at_a, anchor, rotation);
  def.frame_b = local_pose(at_b, anchor, rotation);
}

}  // namespace

Joint random_joint(Random& random, JointType type) {
  switch (type) {
#define SCREE_JOINT_TYPE(kind, Struct) \
  case JointType::kind:                \
    return random_kind<Struct>(random);
    SCREE_FOR_EACH_JOINT_TYPE(SCREE_JOINT_TYPE)
#undef SCREE_JOINT_TYPE
  }
  return {};
}

UserRow random_user_row(Random& random) {
  UserRow row;
  row.jacobian = {random_vector(random, 1.0f), random_vector(random, 1.0f), random_vector(random, 1.0f),
                  random_vector(random, 1.0f)};
  if (once_in(random, 2)) row.jacobian.linear_a = -1.0f * row.jacobian.linear_b;
  if (once_in(random, 8)) row.jacobian = {};
  row.target = {random.between(-0.3f, 0.3f), random.between(-1.0f, 1.0f), random.between(0.2f, 20.0f),
                random.between(0.0f, 2.0f)};
  if (once_in(random, 2)) row.bounds = {random.between(-500.0f, 0.0f), random.between(0.0f, 500.0f)};
  return row;
}

JointDef random_joint_def(Random& random, const Pose& at_a, const Pose& at_b) {
  JointDef def;
  const Vec3 offset = random_vector(random, 0.3f);
  const Quat rotation = random.rotation();
  {
    const FpEnvironment environment;
    place_frames(def, at_a, at_b, offset, rotation);
  }
  if (once_in(random, 6)) def.frame_b = {random_vector(random, 1.0f), random.rotation()};
  def.collide_connected = once_in(random, 3);
  def.enabled = !once_in(random, 8);
  if (once_in(random, 3)) {
    def.hertz = random.between(0.5f, 30.0f);
    def.damping_ratio = random.between(0.0f, 3.0f);
  }
  if (once_in(random, 6)) def.break_force = random.between(10.0f, 50000.0f);
  if (once_in(random, 6)) def.break_torque = random.between(10.0f, 50000.0f);
  if (once_in(random, 3)) def.event_force = random.between(0.0f, 20000.0f);
  if (once_in(random, 3)) def.event_torque = random.between(0.0f, 20000.0f);
  def.user_data = random.next();
  return def;
}

}  // namespace scree::determinism
