// The player's calls about meshes, which only bodies may have that nothing pushes.
#include <tests/determinism/player.h>

#include <algorithm>

namespace scree::determinism {

bool Player::has_mesh(const Slot& slot) const {
  return std::any_of(slot.shapes.begin(), slot.shapes.end(), [&](ShapeId shape) {
    return std::holds_alternative<TriangleMesh>(world_.geometry(shape));
  });
}

void Player::add_mesh(const Call& call, Slot& slot) {
  Random random(call.seed);
  if (world_.body_type(slot.body) == BodyType::dynamic) return;
  const TriangleMesh mesh = random_mesh(random);
  const Material material = random_material(random);
  ShapeOptions options = random_options(random);
  options.sensor = false;
  tell("add_shape", slot.body, Geometry{mesh}, material, options.local_pose, options.filter,
       static_cast<int>(options.contact_events), static_cast<int>(options.contact_hooks));
  slot.shapes.push_back(world_.add_shape(slot.body, mesh, material, options));
  ++model_.shapes;
  most_manifolds_ = std::max(most_manifolds_, static_cast<std::int64_t>(mesh.triangle_count()));
}

}  // namespace scree::determinism
