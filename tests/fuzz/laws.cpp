// See laws.h.
#include <tests/fuzz/laws.h>

#include <cmath>

namespace scree::fuzz {

namespace {

Isa widest() {
  Isa best = Isa::scalar;
  for (const Isa isa : {Isa::sse2, Isa::avx2, Isa::avx512}) {
    if (is_supported(isa)) best = isa;
  }
  return best;
}

bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

void require_finite(const World& world) {
  const std::span<const Pose> poses = world.poses();
  for (std::uint32_t index = 0; index < poses.size(); ++index) {
    const BodyId body = world.body_at(index);
    if (!world.is_alive(body)) continue;
    const Pose pose = world.pose(body);
    const Quat q = pose.rotation;
    const double norm =
        std::sqrt(double{q.x} * q.x + double{q.y} * q.y + double{q.z} * q.z + double{q.w} * q.w);
    const std::string name = "body " + std::to_string(index);
    require(is_finite(pose.position) && std::abs(norm - 1.0) <= 1e-3, name + " is nowhere");
    require(is_finite(world.linear_velocity(body)) && is_finite(world.angular_velocity(body)),
            name + " has no velocity");
  }
}

}  // namespace

Workers& narrow_workers() {
  static Workers workers({.threads = 1, .isa = Isa::scalar});
  return workers;
}

Workers& wide_workers() {
  static Workers workers({.threads = 1, .isa = widest()});
  return workers;
}

std::vector<std::byte> bytes_of(const World& world) {
  Snapshot snapshot;
  save(world, snapshot);
  return write_snapshot(snapshot);
}

void require_laws_of_snapshots(const World& world) {
  const std::vector<std::byte> bytes = bytes_of(world);
  Snapshot snapshot;
  try {
    snapshot = read_snapshot(bytes);
  } catch (const Error& error) {
    throw BrokenLaw(std::string("the snapshot of a world is refused: ") + error.what());
  }
  require(write_snapshot(snapshot) == bytes, "a snapshot changes when it is read and written");
  World other;
  restore(other, snapshot);
  require(bytes_of(other) == bytes, "a restored world has another state");
}

void require_laws_of_steps(World& world, float dt, int steps) {
  World other = clone(world);
  for (int i = 0; i < steps; ++i) {
    step(world, dt, wide_workers());
    step(other, dt, narrow_workers());
    require(world.hash() == other.hash(), "instruction sets differ in step " + std::to_string(i + 1));
    require_finite(world);
  }
  require_laws_of_snapshots(world);
}

bool names_offset(const std::string& message, const std::string& before, const std::string& after,
                  std::size_t most) {
  if (message.rfind(before, 0) != 0) return false;
  std::size_t at = before.size(), offset = 0;
  const std::size_t digits = at;
  while (at < message.size() && message[at] >= '0' && message[at] <= '9' && offset <= most) {
    offset = 10 * offset + static_cast<std::size_t>(message[at++] - '0');
  }
  return at > digits && offset <= most && message.compare(at, after.size(), after) == 0 &&
         message.size() > at + after.size();
}

}  // namespace scree::fuzz
