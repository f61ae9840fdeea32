// See frame.h.
#include <tools/extract/body_energy.h>
#include <tools/view/frame.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

namespace scree::view {
namespace {

enum class Kind : std::uint32_t { news = 1, roster = 2, frame = 3 };

template <class Number>
void put(std::string& to, Number number) {
  to.append(reinterpret_cast<const char*>(&number), sizeof number);
}

template <class Number>
void put_all(std::string& to, const std::vector<Number>& numbers) {
  to.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
}

void put_pose(std::vector<float>& to, const Pose& pose) {
  const Vec3 p = pose.position;
  const Quat q = pose.rotation;
  to.insert(to.end(), {p.x, p.y, p.z, q.x, q.y, q.z, q.w});
}

void put_vector(std::string& to, Vec3 vector) {
  put(to, vector.x);
  put(to, vector.y);
  put(to, vector.z);
}

std::vector<ContactForces> contacts_of(const World& world) {
  if (!world.settings().contact_forces) return {};
  std::vector<ContactForces> contacts(world.contact_forces({}));
  world.contact_forces(contacts);
  return contacts;
}

// Bodies that contacts and joints connect, as trees of indices.
class Islands {
 public:
  explicit Islands(std::size_t bodies) : parent_(bodies) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t body) {
    while (parent_[body] != body) body = parent_[body] = parent_[parent_[body]];
    return body;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

bool is_pushed(const World& world, BodyId body) {
  return world.is_alive(body) && world.body_type(body) == BodyType::dynamic;
}

void shade_islands(const World& world, const std::vector<ContactForces>& contacts,
                   const std::vector<BodyId>& bodies, std::vector<float>& values) {
  Islands islands(world.poses().size());
  for (const ContactForces& contact : contacts) {
    if (is_pushed(world, contact.body_a) && is_pushed(world, contact.body_b))
      islands.join(contact.body_a.index, contact.body_b.index);
  }
  std::vector<JointId> joints;
  for (const BodyId body : bodies) {
    joints.resize(world.joints_of(body, {}));
    world.joints_of(body, joints);
    for (const JointId joint : joints) {
      const JointDef def = world.joint_def(joint);
      if (world.is_enabled(joint) && def.body_a != kWorld && def.body_b != kWorld &&
          is_pushed(world, def.body_a) && is_pushed(world, def.body_b))
        islands.join(def.body_a.index, def.body_b.index);
    }
  }
  for (std::size_t i = 0; i < bodies.size(); ++i)
    values[i] = static_cast<float>(islands.root(bodies[i].index));
}

// m/s: how fast the surfaces still come together where they press.
float approach_of(const World& world, const ContactForces& contact) {
  float fastest = 0.0f;
  for (int k = 0; k < contact.point_count; ++k) {
    const ContactForcePoint& point = contact.points[k];
    if (point.normal_impulse <= 0.0f) continue;
    const Vec3 relative =
        world.velocity_at(contact.body_b, point.position) - world.velocity_at(contact.body_a, point.position);
    fastest = std::max(fastest, -dot(relative, contact.normal));
  }
  return fastest;
}

// Values by body, in the order of `bodies`.
std::vector<float> shades_of(const World& world, Shade shade, float dt,
                             const std::vector<ContactForces>& contacts, const std::vector<BodyId>& bodies) {
  std::vector<float> values(bodies.size(), shade == Shade::color ? -1.0f : 0.0f);
  if (shade == Shade::none) return values;
  if (shade == Shade::island) {
    shade_islands(world, contacts, bodies, values);
    return values;
  }
  constexpr std::uint32_t kNowhere = 0xffffffffu;
  std::vector<std::uint32_t> place(world.poses().size(), kNowhere);
  for (std::uint32_t i = 0; i < bodies.size(); ++i) place[bodies[i].index] = i;
  for (const ContactForces& contact : contacts) {
    float value = static_cast<float>(contact.color);
    if (shade == Shade::residual) value = approach_of(world, contact);
    if (shade == Shade::force) value = dt > 0.0f ? normal_impulse(contact) / dt : 0.0f;
    for (const BodyId body : {contact.body_a, contact.body_b}) {
      if (place[body.index] == kNowhere) continue;
      float& known = values[place[body.index]];
      known = shade == Shade::force ? known + value : std::max(known, value);
    }
  }
  return values;
}

std::uint32_t append_contacts(const World& world, float dt, const std::vector<ContactForces>& contacts,
                              std::string& to) {
  std::uint32_t count = 0;
  for (const ContactForces& contact : contacts) {
    if (!world.is_alive(contact.body_a) || !world.is_alive(contact.body_b)) continue;
    for (int k = 0; k < contact.point_count; ++k) {
      const ContactForcePoint& point = contact.points[k];
      put(to, contact.body_a.index);
      put(to, contact.body_b.index);
      put_vector(to, point.position);
      put_vector(to, contact.normal);
      put(to, dt > 0.0f ? point.normal_impulse / dt : 0.0f);
      put(to, static_cast<float>(contact.color));
      put(to, point.separation);
      put(to, std::uint32_t{0});
      ++count;
    }
  }
  return count;
}

Vec3 anchor_of(const World& world, BodyId body, const Pose& frame) {
  return body == kWorld ? frame.position : (world.pose(body) * frame).position;
}

std::uint32_t append_joints(const World& world, const std::vector<BodyId>& bodies, std::string& to) {
  std::uint32_t count = 0;
  std::vector<JointId> joints;
  for (const BodyId body : bodies) {
    joints.resize(world.joints_of(body, {}));
    world.joints_of(body, joints);
    for (const JointId joint : joints) {
      const JointDef def = world.joint_def(joint);
      // Of its two bodies the one that comes last in the list writes it, or the only one that may move.
      const BodyId other = def.body_a == body ? def.body_b : def.body_a;
      if (other != kWorld && world.body_type(other) != BodyType::fixed && other.index > body.index) continue;
      if (!world.is_enabled(joint)) continue;
      const Joint now = world.joint(joint);
      const auto* mouse = std::get_if<MouseJoint>(&now);
      put_vector(to, mouse != nullptr ? mouse->target : anchor_of(world, def.body_a, def.frame_a));
      put_vector(to, anchor_of(world, def.body_b, def.frame_b));
      const JointReaction reaction = world.joint_reaction(joint);
      put(to, length(reaction.force));
      put(to, length(reaction.torque));
      constexpr std::uint32_t kTheWorld = 0xffffffffu;
      for (const BodyId end : {def.body_a, def.body_b}) put(to, end == kWorld ? kTheWorld : end.index);
      put(to, joint.index);
      put(to, static_cast<std::uint32_t>(world.joint_type(joint)));
      ++count;
    }
  }
  return count;
}

void append_energies(const World& world, const std::vector<BodyId>& bodies, std::string& to) {
  for (const BodyId body : bodies)
    put(to,
        static_cast<float>(extract::kinetic_energy(world, body) + extract::potential_energy(world, body)));
}

std::int16_t part_of(float share) {
  return static_cast<std::int16_t>(std::lround(32767.0 * std::clamp(double{share}, -1.0, 1.0)));
}

// What tells a body from all others that pages know.
std::string content_of(const World& world, BodyId body, const std::vector<exports::ActorShape>& shapes) {
  std::string content;
  const auto put_pose = [&](const Pose& pose) {
    put_vector(content, pose.position);
    for (const float part : {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w})
      put(content, part);
  };
  put(content, body.index);
  put(content, body.generation);
  put(content, world.body_type(body));
  if (world.body_type(body) == BodyType::fixed) put_pose(world.pose(body));
  for (const exports::ActorShape& shape : shapes) {
    put_pose(shape.pose);
    put_vector(content, exports::scale_of(shape.geometry));
    content += exports::key_of(shape.geometry) + "\n";
  }
  return content;
}

}  // namespace

std::uint32_t Cast::number_of(const World& world, BodyId body) {
  const std::vector<exports::ActorShape> shapes = exports::shapes_of(world, body);
  const std::string content = content_of(world, body, shapes);
  const XXH128_hash_t hash = XXH3_128bits(content.data(), content.size());
  const auto [known, is_new] =
      by_content_.try_emplace({hash.low64, hash.high64}, static_cast<std::uint32_t>(by_content_.size()));
  if (is_new) add(world, body, shapes);
  return known->second;
}

void Cast::add(const World& world, BodyId body, const std::vector<exports::ActorShape>& shapes) {
  const BodyType type = world.body_type(body);
  const Pose pose = world.pose(body);
  const Vec3 center = transform_back(pose, world.center_of_mass(body));
  const BodyPieces page = pieces_of(shapes, meshes_);
  Columns& to = new_bodies_;
  to.indices.push_back(body.index);
  to.shape_counts.push_back(static_cast<std::uint32_t>(shapes.size()));
  to.piece_counts.push_back(static_cast<std::uint32_t>(page.pieces.size()));
  to.masses.push_back(type == BodyType::dynamic ? world.mass_properties(body).mass : 0.0f);
  put_pose(to.poses, pose);
  to.centers.insert(to.centers.end(), {center.x, center.y, center.z});
  to.types.push_back(static_cast<std::uint8_t>(type));
  for (const Piece& piece : page.pieces) {
    to.meshes.push_back(static_cast<std::uint32_t>(piece.mesh));
    put_pose(to.piece_poses, piece.pose);
    to.scales.insert(to.scales.end(), {piece.scale.x, piece.scale.y, piece.scale.z});
  }
  float& size = type == BodyType::dynamic ? size_ : other_size_;
  size = std::max(size, page.reach);
}

// The message of the bodies and meshes that are new.
std::string Cast::take_new_bodies() {
  const Columns bodies = std::exchange(new_bodies_, {});
  const Json head = {{"meshes", meshes_.take_list()},
                     {"bodies", bodies.indices.size()},
                     {"pieces", bodies.meshes.size()},
                     {"columns", numbers_.size()}};
  const std::string text = head.dump();
  std::string message;
  put(message, Kind::news);
  put(message, static_cast<std::uint32_t>(text.size()));
  message += text;
  message += std::exchange(numbers_, {});
  put_all(message, bodies.indices);
  put_all(message, bodies.shape_counts);
  put_all(message, bodies.piece_counts);
  put_all(message, bodies.masses);
  put_all(message, bodies.poses);
  put_all(message, bodies.centers);
  put_all(message, bodies.meshes);
  put_all(message, bodies.piece_poses);
  put_all(message, bodies.scales);
  put_all(message, bodies.types);
  return message;
}

Cast::Present Cast::find(const World& world, Memory& memory) {
  Present present;
  std::vector<std::uint32_t> standing;
  const auto count = static_cast<std::uint32_t>(world.poses().size());
  memory.known.resize(std::max<std::size_t>(memory.known.size(), count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const BodyId body = world.body_at(i);
    if (!world.is_alive(body)) continue;
    const BodyType type = world.body_type(body);
    const std::size_t shapes = world.shapes_of(body, {});
    Memory::Known& known = memory.known[i];
    const bool is_same = known.generation == body.generation && known.type == type && known.shapes == shapes;
    if (!is_same) known = {body.generation, number_of(world, body), type, shapes, world.pose(body), false};
    if (type == BodyType::fixed && !known.has_moved) known.has_moved = known.pose != world.pose(body);
    if (type == BodyType::fixed && !known.has_moved) {
      standing.push_back(known.number);
    } else {
      present.moving.push_back(body);
      present.numbers.push_back(known.number);
    }
  }
  if (!new_bodies_.indices.empty()) say(take_new_bodies());
  if (memory.roster == 0 || standing != memory.standing) {
    memory.standing = standing;
    memory.roster = roster_of(std::move(standing));
  }
  present.roster = memory.roster;
  return present;
}

std::uint32_t Cast::roster_of(std::vector<std::uint32_t> standing) {
  const auto [known, is_new] =
      rosters_.try_emplace(std::move(standing), static_cast<std::uint32_t>(rosters_.size() + 1));
  if (is_new) {
    std::string message;
    put(message, Kind::roster);
    put(message, known->second);
    put(message, static_cast<std::uint32_t>(known->first.size()));
    put_all(message, known->first);
    say(std::move(message));
  }
  return known->second;
}

void Cast::say(std::string message) {
  news_.push_back(std::make_shared<const std::string>(std::move(message)));
  all_news_.push_back(news_.back());
}

std::vector<Bytes> Cast::take_news() { return std::exchange(news_, {}); }

std::string make_frame(const World& world, std::uint32_t track, std::uint64_t step, float dt,
                       const FrameOptions& options, Cast& cast, Cast::Memory& memory) {
  const Cast::Present present = cast.find(world, memory);
  const std::vector<BodyId>& bodies = present.moving;
  const bool looks_at_contacts = options.details || options.shade != Shade::none;
  const std::vector<ContactForces> contacts =
      looks_at_contacts ? contacts_of(world) : std::vector<ContactForces>();
  std::string details;
  const std::uint32_t contact_count = options.details ? append_contacts(world, dt, contacts, details) : 0;
  const std::uint32_t joint_count = options.details ? append_joints(world, bodies, details) : 0;
  if (options.details) append_energies(world, bodies, details);
  std::string frame;
  frame.reserve(48 + 33 * bodies.size() + details.size());
  put(frame, Kind::frame);
  put(frame, track);
  put(frame, static_cast<double>(step));
  for (const std::uint32_t number :
       {present.roster, static_cast<std::uint32_t>(bodies.size()), contact_count, joint_count,
        static_cast<std::uint32_t>(options.shade), std::uint32_t{options.details}})
    put(frame, number);
  put_all(frame, present.numbers);
  for (const BodyId body : bodies) put_vector(frame, world.pose(body).position);
  for (const BodyId body : bodies) put(frame, length(world.linear_velocity(body)));
  put_all(frame, shades_of(world, options.shade, dt, contacts, bodies));
  for (const BodyId body : bodies) {
    const Quat q = normalize(world.pose(body).rotation);
    for (const float part : {q.x, q.y, q.z, q.w}) put(frame, part_of(part));
  }
  for (const BodyId body : bodies) put(frame, std::uint8_t{world.is_awake(body)});
  while (frame.size() % 4 != 0) frame += '\0';
  return frame + details;
}

}  // namespace scree::view
