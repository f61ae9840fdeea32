// See player.h.
#include <tests/determinism/player.h>
#include <tests/determinism/player_values.h>
#include <tests/determinism/replay.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace scree::determinism {
namespace {

constexpr float kUnitTolerance = 1e-3f;  // of a quaternion's length
constexpr int kMostStepsPerCall = 6;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Equal bits: a zero whose sign changed counts as moved.
bool same_bits(const Pose& left, const Pose& right) { return std::memcmp(&left, &right, sizeof(Pose)) == 0; }

// A half-space with four walls on it.
void build_pit(World& world) {
  const BodyId pit = world.create_body({.type = BodyType::fixed});
  const float outer = kPitHalfWidth + 2.0f;
  const auto wall = [&](Vec3 half_extents, Vec3 position) {
    world.add_shape(pit, Box{half_extents}, {}, {.local_pose = {position, {}}});
  };
  world.add_shape(pit, HalfSpace{});
  for (const float side : {-1.0f, 1.0f}) {
    wall({1.0f, 0.5f * kPitHeight, outer}, {side * (kPitHalfWidth + 1.0f), 0.5f * kPitHeight, 0.0f});
    wall({outer, 0.5f * kPitHeight, 1.0f}, {0.0f, 0.5f * kPitHeight, side * (kPitHalfWidth + 1.0f)});
  }
}
constexpr std::size_t kPitBodies = 1;
constexpr std::size_t kDirectlySolved = 10;  // bodies at most that the direct solver solves ...
constexpr std::size_t kSolvedWhole = 12;     // ... and other methods over the whole system
constexpr std::size_t kPitShapes = 5;

}  // namespace

Player::Player(Shift& shift, bool checks, std::ostream* log) : shift_(shift), checks_(checks), log_(log) {
  used_.share_handles(world_);
  build_pit(world_);
}

void Player::fail(const std::string& promise) const {
  throw BrokenPromise(promise + " (after " + std::to_string(hashes_.size()) + " steps)");
}

Player::Slot* Player::occupied(std::uint32_t slot) {
  for (std::size_t i = 0; i < model_.slots.size(); ++i) {
    Slot& candidate = model_.slots[(slot + i) % model_.slots.size()];
    if (candidate.body != BodyId{}) return &candidate;
  }
  return nullptr;
}

void Player::make(const Call& call) {
  switch (call.kind) {
    case CallKind::step:
    case CallKind::step_worlds:
      return run_steps(call);
    case CallKind::create_body:
      return create(call);
    case CallKind::create_empty_bodies:
      return create_empty(call);
    case CallKind::create_bodies:
      return create_bulk(call);
    case CallKind::destroy_bodies:
      return destroy_bulk(call);
    case CallKind::set_settings:
      return change_settings(call);
    case CallKind::create_joint:
      return create_joint(call);
    case CallKind::create_joints:
      return create_joints(call);
    case CallKind::destroy_joint:
      return destroy_joint(call);
    case CallKind::set_joint:
      return set_joint(call);
    case CallKind::change_joint:
      return change_joint(call);
    case CallKind::wrong_call:
      return make_wrong_call(call);
    case CallKind::save:
      return save_somewhere(call);
    case CallKind::restore:
      return restore_saved(call);
    case CallKind::go_round:
      return go_round(call);
    case CallKind::branch:
      return branch_off(call);
    case CallKind::move_world: {
      tell("move_world");
      World other = std::move(world_);
      world_ = std::move(other);
      return;
    }
    default:
      break;
  }
  Slot* slot = model_.slots.empty() ? nullptr : occupied(call.slot);
  if (slot == nullptr) return;
  change_body(call, *slot);
  change_motion(call, *slot);
  change_shape(call, *slot);
}

void Player::empty_slot(Slot& slot) {
  if (slot.body == BodyId{}) return;
  const BodyId body = slot.body;
  tell("destroy_body", body);
  lose_joints(body);
  world_.destroy_body(body);
  model_.shapes -= slot.shapes.size();
  --model_.bodies;
  for (const ShapeId shape : slot.shapes) {
    if (world_.is_alive(shape)) fail("a destroyed body's shape lives on");
  }
  if (world_.is_alive(body)) fail("a destroyed body lives on");
  slot = Slot{};
}

void Player::create(const Call& call) {
  if (model_.slots.size() <= call.slot) model_.slots.resize(call.slot + 1);
  Slot& slot = model_.slots[call.slot];
  empty_slot(slot);
  Random random(call.seed);
  const BodyDef def = random_body_def(random);
  tell("create_body", def);
  slot.body = world_.create_body(def);
  ++model_.bodies;
  for (std::uint32_t count = random.below(4); count > 0; --count) {
    const Geometry geometry = random_geometry(random);
    const Material material = random_material(random);
    const ShapeOptions options = random_options(random);
    tell("add_shape", slot.body, geometry, material, options.local_pose, options.filter,
         static_cast<int>(options.contact_events), static_cast<int>(options.contact_hooks));
    slot.shapes.push_back(world_.add_shape(slot.body, geometry, material, options));
    ++model_.shapes;
  }
}

void Player::change_body(const Call& call, Slot& slot) {
  Random random(call.seed);
  const BodyId body = slot.body;
  switch (call.kind) {
    case CallKind::destroy_body:
      return empty_slot(slot);
    case CallKind::set_body_type: {
      const auto type = static_cast<BodyType>(random.below(3));
      if (type == BodyType::dynamic && has_mesh(slot)) return;
      tell("set_body_type", body, static_cast<int>(type));
      return world_.set_body_type(body, type);
    }
    case CallKind::set_mass_properties: {
      const MassProperties properties = random_mass_properties(random);
      tell("set_mass_properties", body, properties);
      return world_.set_mass_properties(body, properties);
    }
    case CallKind::reset_mass:
      tell("reset_mass", body);
      return world_.reset_mass(body);
    case CallKind::set_damping: {
      const float linear = random.unit();
      const float angular = random.unit();
      tell("set_linear_damping", body, linear);
      world_.set_linear_damping(body, linear);
      tell("set_angular_damping", body, angular);
      return world_.set_angular_damping(body, angular);
    }
    case CallKind::set_gravity_factor: {
      const float factor = random.between(-1.0f, 2.0f);
      tell("set_gravity_factor", body, factor);
      return world_.set_gravity_factor(body, factor);
    }
    case CallKind::set_locks: {
      const AxisLocks locks = random_locks(random);
      tell("set_locks", body, static_cast<int>(locks));
      return world_.set_locks(body, locks);
    }
    case CallKind::set_can_sleep: {
      const bool can_sleep = random.below(2) == 0;
      tell("set_can_sleep", body, can_sleep);
      return world_.set_can_sleep(body, can_sleep);
    }
    case CallKind::set_full_sweep: {
      const bool full = random.below(2) == 0;
      tell("set_full_sweep", body, full);
      return world_.set_full_sweep(body, full);
    }
    case CallKind::wake:
      tell("wake", body);
      return world_.wake(body);
    case CallKind::set_user_data: {
      const std::uint64_t data = random.next();
      tell("set_user_data", body, static_cast<std::uint32_t>(data));
      world_.set_user_data(body, data);
      if (world_.user_data(body) != data) fail("a body forgets its user data");
      return;
    }
    default:
      return;
  }
}

void Player::change_motion(const Call& call, Slot& slot) {
  Random random(call.seed);
  const BodyId body = slot.body;
  switch (call.kind) {
    case CallKind::set_pose: {
      const Pose pose = random_pose(random);
      tell("set_pose", body, pose);
      return world_.set_pose(body, pose);
    }
    case CallKind::set_linear_velocity: {
      const Vec3 velocity = random_vector(random, 10.0f);
      tell("set_linear_velocity", body, velocity);
      return world_.set_linear_velocity(body, velocity);
    }
    case CallKind::set_angular_velocity: {
      const Vec3 velocity = random_vector(random, 10.0f);
      tell("set_angular_velocity", body, velocity);
      return world_.set_angular_velocity(body, velocity);
    }
    case CallKind::shoot: {
      const Vec3 velocity = random_vector(random, 300.0f);
      tell("set_linear_velocity", body, velocity);
      return world_.set_linear_velocity(body, velocity);
    }
    case CallKind::set_kinematic_target: {
      if (world_.body_type(body) != BodyType::kinematic) return;
      const Pose pose = random_pose(random);
      const float dt = random.between(0.1f, 1.0f);
      tell("set_kinematic_target", body, pose, dt);
      return world_.set_kinematic_target(body, pose, dt);
    }
    case CallKind::add_load: {
      const Vec3 load = random_vector(random, 2000.0f);
      const Vec3 point = random_pose(random).position;
      tell("add_force, add_force_at, add_torque", body, load, point);
      world_.add_force(body, load);
      world_.add_force_at(body, load, point);
      return world_.add_torque(body, load);
    }
    case CallKind::add_impulse: {
      const Vec3 impulse = random_vector(random, 20.0f);
      const Vec3 point = random_pose(random).position;
      tell("add_impulse, add_impulse_at, add_angular_impulse", body, impulse, point);
      world_.add_impulse(body, impulse);
      world_.add_impulse_at(body, impulse, point);
      return world_.add_angular_impulse(body, impulse);
    }
    default:
      return;
  }
}

void Player::change_shape(const Call& call, Slot& slot) {
  if (call.kind == CallKind::add_mesh) return add_mesh(call, slot);
  Random random(call.seed);
  if (call.kind == CallKind::add_shape) {
    const Geometry geometry = random_geometry(random);
    const Material material = random_material(random);
    const ShapeOptions options = random_options(random);
    std::vector<ShapeDef> defs{{geometry, material, options}};
    // An eighth of the shapes in bulk, and rarely so many that the body keeps sums of them.
    const bool bulk = call.seed >> 61 == 0;
    const std::uint32_t more = !bulk ? 0 : random.below(4) != 0 ? random.below(4) : 12;
    while (defs.size() <= more) {
      defs.push_back({random_geometry(random), random_material(random), random_options(random)});
    }
    for (const ShapeDef& def : defs) {
      tell(bulk ? "add_shapes" : "add_shape", slot.body, def.geometry, def.material, def.options.local_pose,
           def.options.filter, static_cast<int>(def.options.contact_events),
           static_cast<int>(def.options.contact_hooks));
    }
    std::vector<ShapeId> ids(defs.size());
    if (bulk) {
      world_.add_shapes(slot.body, defs, ids);
    } else {
      ids[0] = world_.add_shape(slot.body, geometry, material, options);
    }
    slot.shapes.insert(slot.shapes.end(), ids.begin(), ids.end());
    model_.shapes += defs.size();
    return;
  }
  if (slot.shapes.empty()) return;
  const std::size_t which = random.below(static_cast<std::uint32_t>(slot.shapes.size()));
  const ShapeId shape = slot.shapes[which];
  switch (call.kind) {
    case CallKind::destroy_shape:
      tell("destroy_shape", shape);
      world_.destroy_shape(shape);
      slot.shapes.erase(slot.shapes.begin() + static_cast<std::ptrdiff_t>(which));
      --model_.shapes;
      if (world_.is_alive(shape)) fail("a destroyed shape lives on");
      return;
    case CallKind::set_filter: {
      const Filter filter = random_filter(random);
      tell("set_filter", shape, filter);
      return world_.set_filter(shape, filter);
    }
    case CallKind::set_material: {
      const Material material = random_material(random);
      tell("set_material", shape, material);
      return world_.set_material(shape, material);
    }
    case CallKind::set_geometry: {
      const Geometry geometry = random_geometry(random);
      tell("set_geometry", shape, geometry);
      return world_.set_geometry(shape, geometry);
    }
    case CallKind::set_local_pose: {
      const Pose pose = random_options(random).local_pose;
      tell("set_local_pose", shape, pose);
      return world_.set_local_pose(shape, pose);
    }
    case CallKind::set_user_data: {
      const std::uint64_t data = random.next();
      tell("set_user_data", shape, static_cast<std::uint32_t>(data));
      world_.set_user_data(shape, data);
      if (world_.user_data(shape) != data) fail("a shape forgets its user data");
      return;
    }
    case CallKind::set_contact_events: {
      const auto events = static_cast<ContactEvents>(random.below(8));
      tell("set_contact_events", shape, static_cast<int>(events));
      world_.set_contact_events(shape, events);
      if (random.below(2) == 0) return;
      const auto hooks = static_cast<ContactHooks>(random.below(4));
      tell("set_contact_hooks", shape, static_cast<int>(hooks));
      return world_.set_contact_hooks(shape, hooks);
    }
    default:
      return;
  }
}

// Methods over the whole system take seconds for heaps, and the direct one minutes.
void Player::spare_slow_solvers() {
  WorldSettings settings = world_.settings();
  const bool is_wide = settings.solver == Solver::soft_step || settings.solver == Solver::sequential_impulse;
  const std::size_t most = settings.solver == Solver::direct ? kDirectlySolved : kSolvedWhole;
  if (is_wide || model_.bodies <= most) return;
  settings.solver = Solver::soft_step;
  tell("set_settings", settings);
  world_.set_settings(settings);
}

void Player::change_settings(const Call& call) {
  Random random(call.seed);
  WorldSettings settings = random_settings(random);
  if (settings.solver != Solver::soft_step && model_.bodies <= kDirectlySolved && call.seed % 2 == 0)
    settings.solver = Solver::direct;
  tell("set_settings", settings);
  world_.set_settings(settings);
}

void Player::make_wrong_call(const Call& call) {
  Slot* slot = model_.slots.empty() ? nullptr : occupied(call.slot);
  const BodyId body = slot != nullptr ? slot->body : BodyId{};
  const ShapeId shape = slot != nullptr && !slot->shapes.empty() ? slot->shapes.front() : ShapeId{};
  const std::uint64_t before = world_.hash();
  const std::vector<std::byte> state = checks_ ? bytes_of(world_) : std::vector<std::byte>{};
  const std::uint32_t which = Random(call.seed).below(26);
  tell("wrong_call", which, body);
  bool thrown = false;
  try {
    const auto wrong_settings = [this](auto change) {
      WorldSettings settings = world_.settings();
      change(settings);
      world_.set_settings(settings);
    };
    BodyId ids[2] = {body, body};
    const BodyDef defs[2] = {{}, {.position = {kNan, 0.0f, 0.0f}}};
    switch (which) {
      case 0:
        step(world_, kNan, shift_.at(0));
        break;
      case 1:
        step(world_, -1.0f / 60.0f, shift_.at(0));
        break;
      case 2:
        world_.set_pose(body, {{0.0f, kNan, 0.0f}, {}});
        break;
      case 3:
        world_.set_linear_velocity({body.index, body.generation + 1}, {});
        break;
      case 4:
        world_.create_body({.mass = 0.0f});
        break;
      case 5:
        world_.add_shape(body, Sphere{-1.0f});
        break;
      case 6:
        world_.create_bodies(defs, ids);
        break;
      case 7:
        world_.destroy_bodies(ids);
        break;
      case 8:
        wrong_settings([](WorldSettings& settings) { settings.substeps = 0; });
        break;
      case 9:
        wrong_settings([](WorldSettings& settings) { settings.gravity.y = kNan; });
        break;
      case 10:
        world_.set_kinematic_target(body, {{kNan, 0.0f, 0.0f}, {}}, 0.1f);
        break;
      case 11:
        world_.set_contact_events(shape, static_cast<ContactEvents>(8));
        break;
      case 12:
        world_.add_impulse(body, {kNan, 0.0f, 0.0f});
        break;
      case 13: {
        Random random(call.seed);
        const Geometry geometries[2] = {random_geometry(random), ConvexHull{}};
        world_.create_bodies(std::vector<BodyDef>(2), geometries, {}, {}, ids);
        break;
      }
      case 14: {
        Random random(call.seed);
        if (random.below(2) != 0) {
          ShapeId ids_of_shapes[2];
          world_.add_shapes(body, std::vector<ShapeDef>{{random_geometry(random)}, {ConvexHull{}}},
                            ids_of_shapes);
        }
        world_.set_material(shape, {.friction = -1.0f});
        break;
      }
      case 15:
      case 16:
      case 17:
        make_wrong_call_of_snapshots(which - 15);
        break;
      default:
        make_wrong_call_of_joints(which - 18, body);
        break;
    }
  } catch (const Error&) {
    thrown = true;
  }
  if (!thrown) fail("wrong call " + std::to_string(which) + " did not throw");
  if (world_.hash() != before || (checks_ && bytes_of(world_) != state)) {
    fail("wrong call " + std::to_string(which) + " changed the world");
  }
}

void Player::run_steps(const Call& call) {
  Random random(call.seed);
  spare_slow_solvers();
  for (std::uint32_t count = 1 + random.below(kMostStepsPerCall); count > 0; --count) {
    const float dt = random_time_step(random);
    tell(call.kind == CallKind::step ? "step" : "step worlds", dt);
    if (checks_) check_before_step();
    if (before_step_) before_step_(world_);
    hook_up(world_), hook_up(used_);
    Workers& workers = shift_.at(static_cast<int>(hashes_.size()));
    if (call.kind == CallKind::step) {
      step(world_, dt, workers);
    } else {
      World* const worlds[] = {&used_, &world_};
      step(worlds, dt, workers);
    }
    hashes_.push_back(mixed(world_.hash(), digest_of_events(world_)));
    most_contacts_ = std::max(most_contacts_, world_.stats().contacts);
    sweep_hits_ += world_.stats().sweep_hits;
    check_lost_joints();
    if (checks_) check_after_step();
  }
}

void Player::check_before_step() {
  for (Slot& slot : model_.slots) {
    if (slot.body == BodyId{}) continue;
    slot.last_pose = world_.pose(slot.body);
    slot.last_awake = world_.is_awake(slot.body);
  }
}

void Player::check_after_step() {
  if (world_.body_count() != model_.bodies + kPitBodies) fail("body_count is wrong");
  if (world_.shape_count() != model_.shapes + kPitShapes) fail("shape_count is wrong");
  const StepStats& stats = world_.stats();
  if (stats.contacts > stats.pairs * most_manifolds_) fail("there are more contacts than pairs can have");
  if (!std::isfinite(stats.kinetic_energy)) fail("the kinetic energy is not finite");
  if (stats.sweep_hits > stats.swept_bodies || stats.swept_bodies > stats.awake_bodies) {
    fail("more bodies hit than were swept, or more were swept than moved");
  }
  check_events();
  check_sleep();
  check_joints();
  for (Slot& slot : model_.slots) {
    if (slot.body != BodyId{}) check_body(slot);
  }
}

// The events of sleep alone determine which bodies sleep.
void Player::check_sleep() {
  for (const BodyId& body : world_.sleep_ends()) {
    if (model_.asleep.erase(body) == 0) fail("a body wakes that did not sleep");
  }
  for (const BodyId& body : world_.sleep_begins()) {
    if (!model_.asleep.insert(body).second) fail("a body falls asleep twice");
  }
  std::erase_if(model_.asleep, [&](const BodyId& body) {
    return !world_.is_alive(body) || world_.body_type(body) != BodyType::dynamic;
  });
  for (const Slot& slot : model_.slots) {
    if (slot.body == BodyId{} || world_.body_type(slot.body) != BodyType::dynamic) continue;
    if (world_.is_quarantined(slot.body)) continue;  // neither sleeps nor is awake
    const bool awake = world_.is_awake(slot.body);
    // Bodies that touch a body quarantined at the step's end wake in the lists of the next step.
    if (awake && !world_.quarantined_bodies().empty()) continue;
    if (awake == model_.asleep.contains(slot.body)) {
      fail("body " + std::to_string(slot.body.index) + " sleeps or wakes unheard of");
    }
  }
}

// Each begin of a contact is followed by one end, in any order of calls.
void Player::check_events() {
  for (const ContactEnd& end : world_.contact_ends()) {
    if (model_.begun.erase({end.shape_a, end.shape_b}) == 0) fail("a contact ends that has not begun");
  }
  for (const ContactEvent& event : world_.contact_begins()) {
    if (!model_.begun.insert({event.shape_a, event.shape_b}).second) fail("a contact begins twice");
    if (!world_.is_alive(event.shape_a) || world_.body_of(event.shape_b) != event.body_b) {
      fail("a contact of the dead begins");
    }
    if (!std::isfinite(event.normal_impulse) || event.point_count < 1) fail("a contact makes no sense");
  }
  const bool all_hit = contains(world_.settings().contact_events, ContactEvents::hit);
  for (const ContactEvent& event : world_.contact_hits()) {
    const bool asked = all_hit || contains(world_.contact_events(event.shape_a), ContactEvents::hit) ||
                       contains(world_.contact_events(event.shape_b), ContactEvents::hit);
    if (!asked || !(event.approach_speed >= world_.settings().hit_event_speed) ||
        !(event.normal_impulse > 0.0f)) {
      fail("a contact hits that is not asked for, too slow or not pressed");
    }
  }
  hits_ += world_.contact_hits().size();
  for (const auto& [a, b] : model_.begun) {
    if (!world_.is_alive(a) || !world_.is_alive(b)) fail("a contact outlives its shapes");
  }
  events_ += world_.contact_begins().size();
}

void Player::check_body(Slot& slot) {
  const BodyId body = slot.body;
  const std::string name = "body " + std::to_string(body.index);
  if (!world_.is_alive(body) || world_.body_at(body.index) != body) fail(name + ": the handle died");
  for (const ShapeId shape : slot.shapes) {
    if (!world_.is_alive(shape) || world_.body_of(shape) != body) fail(name + ": a shape got lost");
  }
  if (world_.shapes_of(body, {}) != slot.shapes.size()) fail(name + " has another number of shapes");
  const Pose pose = world_.pose(body);
  const Quat q = pose.rotation;
  const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!is_finite(pose.position) || !is_finite(world_.center_of_mass(body))) fail(name + " is nowhere");
  if (!(std::abs(norm - 1.0f) <= kUnitTolerance)) fail(name + ": the rotation has lost its length");
  if (!is_finite(world_.linear_velocity(body)) || !is_finite(world_.angular_velocity(body))) {
    fail(name + ": the velocity is not finite");
  }
  const bool asleep = !slot.last_awake && !world_.is_awake(body);
  const bool fixed = world_.body_type(body) == BodyType::fixed;
  if (asleep && !fixed) somebody_slept_ = true;
  if ((fixed || asleep) && !same_bits(pose, slot.last_pose)) fail(name + " is fixed or asleep, but moved");
}

}  // namespace scree::determinism
