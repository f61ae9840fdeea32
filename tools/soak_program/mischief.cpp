// See mischief.h.
#include <tools/scenes/hulls.h>
#include <tools/soak_program/mischief.h>

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

namespace scree::soak {
namespace {

constexpr std::size_t kMostShapes = 8;  // of a body, looked at

const std::vector<Hull>& hulls() {
  static const std::vector<Hull> kHulls = {
      Hull(scenes::tetrahedron_points(0.4f)), Hull(scenes::prism_points(6, 0.3f, 0.5f)),
      Hull(scenes::random_sphere_points(24, 0.4f, 3)), Hull(scenes::fibonacci_points(60, 0.35f))};
  return kHulls;
}

}  // namespace

void Mischief::before_step(World& world) {
  if (random_.below(pause_) != 0) return;
  const std::uint32_t count = 1 + random_.below(3);
  for (std::uint32_t i = 0; i < count; ++i) {
    ++calls_;
    try {
      make_call(world);
    } catch (const Error&) {
      // A refused call has changed nothing, and the recording must not hold it either.
    }
  }
}

void Mischief::make_call(World& world) {
  const std::uint32_t kind = random_.below(16);
  if (kind < 4) return create(world);
  if (kind == 4) return create_many(world);
  if (kind == 5) return destroy(world);
  if (kind == 6) return change_settings(world);
  if (kind == 7) return keep_or_restore(world);
  const BodyId body = random_body(world);
  if (!world.is_alive(body)) return;
  if (kind < 11) return push(world, body);
  if (kind < 13) return change_body(world, body);
  if (kind < 15) return change_shape(world, body);
  make_wrong_call(world, body);
}

Vec3 Mischief::random_vector(float reach) {
  const float x = random_.between(-reach, reach), y = random_.between(-reach, reach);
  return {x, y, random_.between(-reach, reach)};
}

Geometry Mischief::random_geometry() {
  switch (random_.below(8)) {
    case 0:
      return Sphere{random_.between(0.05f, 0.6f)};
    case 1: {
      const float half_height = random_.between(0.05f, 0.8f);
      return Capsule{half_height, random_.between(0.05f, 0.4f)};
    }
    case 2: {
      const float x = random_.between(0.03f, 0.8f), y = random_.between(0.03f, 0.8f);
      return Box{{x, y, random_.between(0.03f, 0.8f)}};
    }
    case 3: {
      const float x = random_.between(0.03f, 0.6f), y = random_.between(0.03f, 0.6f);
      const float z = random_.between(0.03f, 0.6f);
      return Box{{x, y, z}, random_.between(0.01f, 0.2f)};
    }
    case 4: {
      const float half_height = random_.between(0.03f, 0.8f);
      return Cylinder{half_height, random_.between(0.05f, 0.6f)};
    }
    case 5: {
      const float half_height = random_.between(0.03f, 0.8f);
      return Cone{half_height, random_.between(0.05f, 0.6f)};
    }
    case 6:
      return ConvexHull{
          hulls()[random_.below(static_cast<std::uint32_t>(hulls().size()))], {1.0f, 1.0f, 1.0f}, 0.125f};
    default: {
      const float scale = random_.between(0.5f, 2.0f);
      return ConvexHull{hulls()[random_.below(static_cast<std::uint32_t>(hulls().size()))],
                        {scale, random_.between(0.5f, 2.0f), scale}};
    }
  }
}

// From above or from the side, some of them fast enough to be swept.
BodyDef Mischief::random_def() {
  BodyDef def;
  def.position = random_vector(6.0f);
  def.position.y = random_.between(1.0f, 12.0f);
  def.rotation = random_.rotation();
  def.linear_velocity = random_vector(random_.below(4) == 0 ? 120.0f : 15.0f);
  def.angular_velocity = random_vector(8.0f);
  def.user_data = random_.next();
  return def;
}

BodyId Mischief::random_body(const World& world) {
  const auto reach = static_cast<std::uint32_t>(world.body_count()) + 8;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const BodyId body = world.body_at(random_.below(reach));
    if (world.is_alive(body) && world.body_type(body) == BodyType::dynamic) return body;
  }
  return {};
}

void Mischief::create(World& world) {
  const BodyId body = world.create_body(random_def());
  Material material;
  material.friction = random_.between(0.0f, 1.2f);
  material.restitution = random_.between(0.0f, 0.9f);
  material.density = random_.between(50.0f, 5000.0f);
  const std::uint32_t shapes = 1 + random_.below(2);
  for (std::uint32_t i = 0; i < shapes; ++i) {
    ShapeOptions options;
    options.local_pose.position = random_vector(0.3f);
    options.contact_events = random_.below(4) == 0 ? ContactEvents::all : ContactEvents::none;
    world.add_shape(body, random_geometry(), material, options);
  }
}

void Mischief::create_many(World& world) {
  const std::uint32_t count = 2 + random_.below(20);
  std::vector<BodyDef> defs;
  std::vector<Geometry> geometries;
  for (std::uint32_t i = 0; i < count; ++i) {
    defs.push_back(random_def());
    geometries.push_back(random_geometry());
  }
  std::vector<BodyId> ids(count);
  world.create_bodies(defs, geometries, {}, {}, ids);
}

void Mischief::destroy(World& world) {
  const BodyId one = random_body(world), other = random_body(world);
  if (!world.is_alive(one)) return;
  if (one == other || !world.is_alive(other)) return world.destroy_body(one);
  const std::array<BodyId, 2> both{one, other};
  world.destroy_bodies(both);
}

void Mischief::push(World& world, BodyId body) {
  const float mass = world.mass_properties(body).mass;
  switch (random_.below(7)) {
    case 0:
      return world.set_linear_velocity(body, random_vector(40.0f));
    case 1:
      return world.set_angular_velocity(body, random_vector(20.0f));
    case 2:
      return world.add_impulse(body, random_vector(10.0f * mass));
    case 3: {
      const Vec3 impulse = random_vector(3.0f * mass);
      return world.add_impulse_at(body, impulse, world.center_of_mass(body));
    }
    case 4:
      return world.add_force(body, random_vector(200.0f * mass));
    case 5:
      return world.add_torque(body, random_vector(20.0f * mass));
    default: {
      Pose pose = world.pose(body);
      pose.position.y += random_.between(0.0f, 3.0f);
      pose.rotation = random_.rotation();
      return world.set_pose(body, pose);
    }
  }
}

void Mischief::change_body(World& world, BodyId body) {
  switch (random_.below(8)) {
    case 0:
      return world.set_linear_damping(body, random_.between(0.0f, 2.0f));
    case 1:
      return world.set_angular_damping(body, random_.between(0.0f, 2.0f));
    case 2:
      return world.set_gravity_factor(body, random_.between(-0.5f, 2.0f));
    case 3:
      return world.set_locks(body, static_cast<AxisLocks>(random_.below(64)));
    case 4:
      return world.set_can_sleep(body, random_.below(2) == 0);
    case 5:
      return world.wake(body);
    case 6:
      return world.set_body_type(body, random_.below(2) == 0 ? BodyType::kinematic : BodyType::fixed);
    default:
      return world.set_user_data(body, random_.next());
  }
}

void Mischief::change_shape(World& world, BodyId body) {
  std::array<ShapeId, kMostShapes> shapes;
  const std::size_t count = std::min(world.shapes_of(body, shapes), kMostShapes);
  if (count == 0) return;
  const ShapeId shape = shapes[random_.below(static_cast<std::uint32_t>(count))];
  switch (random_.below(6)) {
    case 0:
      return world.set_geometry(shape, random_geometry());
    case 1: {
      Material material = world.material(shape);
      material.friction = random_.between(0.0f, 1.5f);
      material.rolling_resistance = random_.between(0.0f, 0.05f);
      if (random_.below(2) == 0) material.patch_radius = random_.between(0.0f, 0.1f);
      material.surface_velocity = random_vector(2.0f);
      return world.set_material(shape, material);
    }
    case 2: {
      Filter filter;
      filter.group = static_cast<std::int32_t>(random_.below(3)) - 1;
      return world.set_filter(shape, filter);
    }
    case 3:
      return world.set_local_pose(shape, {random_vector(0.3f), random_.rotation()});
    case 4:
      return world.set_contact_events(shape, static_cast<ContactEvents>(random_.below(8)));
    default:
      return world.destroy_shape(shape);
  }
}

void Mischief::change_settings(World& world) {
  WorldSettings settings = world.settings();
  switch (random_.below(5)) {
    case 0:
      settings.gravity = random_vector(12.0f);
      break;
    case 1:
      settings.substeps = 1 + static_cast<int>(random_.below(8));
      break;
    case 2:
      settings.sleeping = !settings.sleeping;
      break;
    case 3:
      settings.continuous = !settings.continuous;
      break;
    default:
      settings.contact_events = static_cast<ContactEvents>(random_.below(8));
      settings.hit_event_speed = random_.between(0.0f, 4.0f);
  }
  world.set_settings(settings);
}

void Mischief::make_wrong_call(World& world, BodyId body) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  try {
    if (random_.below(2) == 0) {
      world.set_pose(body, {{0.0f, kNan, 0.0f}, {}});
    } else {
      world.add_shape(body, Sphere{-1.0f});
    }
  } catch (const Error&) {
    return;
  }
  throw std::logic_error("a call with a value that is not allowed did not throw");
}

// Goes back, as a program with a history does: restores the world of some steps ago.
void Mischief::keep_or_restore(World& world) {
  if (kept_.is_empty() || random_.below(2) == 0) return save(world, kept_);
  restore(world, kept_);
}

}  // namespace scree::soak
