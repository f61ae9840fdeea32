// See read_world.h.
#include <tools/extract/body_energy.h>
#include <tools/extract/read_world.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::extract {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool has(const Choice& choice, BodyId body) {
  return choice.all || std::binary_search(choice.indices.begin(), choice.indices.end(), body.index);
}

// By row; of no body where none lives.
std::vector<BodyId> bodies_of(const World& world, const Choice& choice) {
  std::vector<BodyId> bodies;
  if (!choice.all) {
    for (const std::uint32_t index : choice.indices) {
      if (index >= world.poses().size()) break;
      bodies.push_back(world.body_at(index));
    }
    return bodies;
  }
  bodies.resize(world.poses().size());
  for (std::uint32_t i = 0; i < bodies.size(); ++i) bodies[i] = world.body_at(i);
  return bodies;
}

// By index; of no joint where none lives or neither body is chosen.
std::vector<JointId> joints_of(const World& world, const Choice& choice) {
  std::vector<JointId> joints, own;
  for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
    const BodyId body = world.body_at(i);
    if (!world.is_alive(body) || !has(choice, body)) continue;
    own.resize(world.joints_of(body, {}));
    world.joints_of(body, own);
    for (const JointId joint : own) {
      if (joint.index >= joints.size()) joints.resize(joint.index + 1);
      joints[joint.index] = joint;
    }
  }
  return joints;
}

// What contacts did to each body in the step, by BodyId::index.
struct ContactSums {
  std::vector<Vec3> forces;   // N, means over the step
  std::vector<Vec3> torques;  // N m, about the center of mass as the step began
};

ContactSums sum_contacts(const World& world, const PlayedStep& played) {
  ContactSums sums{std::vector<Vec3>(world.poses().size()), std::vector<Vec3>(world.poses().size())};
  std::vector<ContactForces> contacts(world.contact_forces(std::span<ContactForces>{}));
  world.contact_forces(contacts);
  for (const ContactForces& contact : contacts) {
    const bool is_a_dynamic =
        world.is_alive(contact.body_a) && world.body_type(contact.body_a) == BodyType::dynamic;
    const float dt = played.awake_dt[is_a_dynamic ? contact.body_a.index : contact.body_b.index];
    const auto add = [&](BodyId body, float sign) {
      if (!world.is_alive(body)) return;
      sums.forces[body.index] += sign / dt * impulse_on_b(contact);
      if (body.index < played.centers.size())
        sums.torques[body.index] += sign / dt * moment_on_b(contact, played.centers[body.index]);
    };
    add(contact.body_a, -1.0f);
    add(contact.body_b, 1.0f);
  }
  return sums;
}

void add(Vec3 v, Values& values) {
  for (int axis = 0; axis < 3; ++axis) values.add(double{v[axis]});
}

struct Reader {
  const World& world;
  float dt;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  ContactSums contacts;

  void read_body(Signal signal, BodyId body, Values& values) const {
    switch (signal) {
      case Signal::position:
        add(world.pose(body).position, values);
        break;
      case Signal::rotation: {
        const Quat q = world.pose(body).rotation;
        for (const float part : {q.x, q.y, q.z, q.w}) values.add(double{part});
        break;
      }
      case Signal::linear_velocity:
        add(world.linear_velocity(body), values);
        break;
      case Signal::angular_velocity:
        add(world.angular_velocity(body), values);
        break;
      case Signal::awake:
        values.add(world.is_awake(body) ? 1.0 : 0.0);
        break;
      case Signal::kinetic_energy:
        values.add(kinetic_energy(world, body));
        break;
      case Signal::potential_energy:
        values.add(potential_energy(world, body));
        break;
      case Signal::contact_force:
        add(contacts.forces[body.index], values);
        break;
      case Signal::contact_torque:
        add(contacts.torques[body.index], values);
        break;
      default:
        break;
    }
  }

  double read_world(Signal signal) const {
    const StepStats& stats = world.stats();
    switch (signal) {
      case Signal::total_kinetic_energy:
        return sum(kinetic_energy);
      case Signal::total_potential_energy:
        return sum(potential_energy);
      case Signal::contacts:
        return static_cast<double>(stats.contacts);
      case Signal::awake_bodies:
        return static_cast<double>(stats.awake_bodies);
      case Signal::residual:
        return stats.residual;
      case Signal::penetration:
        return stats.penetration_max;
      default:
        return kNaN;
    }
  }

  // Of all bodies, chosen or not.
  template <class Energy>
  double sum(const Energy& energy) const {
    double total = 0.0;
    for (std::uint32_t i = 0; i < world.poses().size(); ++i) {
      const BodyId body = world.body_at(i);
      if (world.is_alive(body)) total += energy(world, body);
    }
    return total;
  }

  void read(Signal signal, Values& values) const {
    const SignalInfo& info = info_of(signal);
    const auto add_none = [&] {
      for (int i = 0; i < info.width; ++i) values.add(kNaN);
    };
    const bool is_known = !info.of_steps || dt > 0.0f;
    if (info.owner == Owner::world) {
      values.add(is_known ? read_world(signal) : kNaN);
    } else if (info.owner == Owner::body) {
      for (const BodyId body : bodies) {
        if (is_known && world.is_alive(body)) {
          read_body(signal, body, values);
        } else {
          add_none();
        }
      }
    } else {
      for (const JointId joint : joints) {
        if (!is_known || !world.is_alive(joint)) {
          add_none();
          continue;
        }
        const JointReaction reaction = world.joint_reaction(joint);
        add(signal == Signal::joint_force ? reaction.force : reaction.torque, values);
      }
    }
  }
};

template <class Id>
void see(const World& world, const std::vector<Id>& ids, std::vector<std::uint8_t>& seen) {
  seen.resize(std::max(seen.size(), ids.size()));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (world.is_alive(ids[i])) seen[i] = 1;
  }
}

std::int64_t number(std::uint32_t index) { return std::int64_t{index}; }

}  // namespace

void note_awake(const World& world, PlayedStep& played) {
  if (!(played.dt > 0.0f)) return;
  // Of those that slept already when the recording began nobody knows: as if with this step.
  played.awake_dt.resize(world.poses().size(), played.dt);
  for (std::uint32_t i = 0; i < played.awake_dt.size(); ++i) {
    const BodyId body = world.body_at(i);
    if (world.is_alive(body) && world.is_awake(body)) played.awake_dt[i] = played.dt;
  }
  // The step in which a body falls asleep is the last whose impulses it has.
  for (const BodyId body : world.sleep_begins()) played.awake_dt[body.index] = played.dt;
}

std::vector<Vec3> centers_of_mass(const World& world) {
  std::vector<Vec3> centers(world.poses().size());
  for (std::uint32_t i = 0; i < centers.size(); ++i) {
    const BodyId body = world.body_at(i);
    if (world.is_alive(body)) centers[i] = world.center_of_mass(body);
  }
  return centers;
}

void add_sample(const World& world, const Wanted& wanted, const Choice& choice, std::uint64_t step,
                double time, const PlayedStep& played, Samples& samples) {
  Reader reader{world, played.dt, {}, {}, {}};
  if (wanted.has(Owner::body)) reader.bodies = bodies_of(world, choice);
  if (wanted.has(Owner::joint)) reader.joints = joints_of(world, choice);
  const bool needs_contacts = wanted.has(Signal::contact_force) || wanted.has(Signal::contact_torque);
  if (needs_contacts && played.dt > 0.0f) reader.contacts = sum_contacts(world, played);
  for (const Signal signal : wanted.signals) {
    Values& values = samples.values[static_cast<std::size_t>(signal)];
    values.is_wide = info_of(signal).is_wide;
    reader.read(signal, values);
  }
  see(world, reader.bodies, samples.seen[0]);
  see(world, reader.joints, samples.seen[1]);
  samples.samples.push_back({step, time, {reader.bodies.size(), reader.joints.size()}});
}

void add_events(const World& world, const Choice& choice, std::uint64_t step, double time,
                std::vector<EventRow>& events) {
  const auto add = [&](EventKind kind, BodyId a, BodyId b, double value) -> EventRow& {
    events.push_back({step, time, kind, number(a.index), number(b.index)});
    events.back().value = value;
    return events.back();
  };
  const auto add_contact = [&](EventKind kind, const auto& contact, double value) {
    if (!has(choice, contact.body_a) && !has(choice, contact.body_b)) return;
    EventRow& row = add(kind, contact.body_a, contact.body_b, value);
    row.shape_a = number(contact.shape_a.index);
    row.shape_b = number(contact.shape_b.index);
  };
  const auto add_visit = [&](EventKind kind, const SensorEvent& visit) {
    if (!has(choice, visit.sensor_body) && !has(choice, visit.visitor_body)) return;
    EventRow& row = add(kind, visit.sensor_body, visit.visitor_body, 0.0);
    row.shape_a = number(visit.sensor.index);
    row.shape_b = number(visit.visitor.index);
  };
  const auto add_body = [&](EventKind kind, BodyId body) {
    if (has(choice, body)) add(kind, body, {}, 0.0).body_b = EventRow::kNone;
  };
  const auto add_joint = [&](EventKind kind, JointId joint, double value) {
    EventRow& row = add(kind, {}, {}, value);
    row.body_a = row.body_b = EventRow::kNone;
    row.joint = number(joint.index);
  };
  for (const ContactEvent& contact : world.contact_begins())
    add_contact(EventKind::contact_begin, contact, double{contact.approach_speed});
  for (const ContactEnd& contact : world.contact_ends()) add_contact(EventKind::contact_end, contact, 0.0);
  for (const ContactEvent& contact : world.contact_hits())
    add_contact(EventKind::contact_hit, contact, double{contact.approach_speed});
  for (const SensorEvent& visit : world.sensor_begins()) add_visit(EventKind::sensor_begin, visit);
  for (const SensorEvent& visit : world.sensor_ends()) add_visit(EventKind::sensor_end, visit);
  for (const BodyId body : world.sleep_begins()) add_body(EventKind::sleep_begin, body);
  for (const BodyId body : world.sleep_ends()) add_body(EventKind::sleep_end, body);
  for (const JointEvent& joint : world.joint_events())
    add_joint(EventKind::joint_over, joint.joint, double{joint.force});
  for (const JointId joint : world.broken_joints()) add_joint(EventKind::joint_broken, joint, 0.0);
  for (const BodyId body : world.restored_bodies()) add_body(EventKind::restored, body);
}

}  // namespace scree::extract
