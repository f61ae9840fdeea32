// Reads a world's contacts, as the last step left them.
#pragma once

#include <core/world/math.h>
#include <core/world/world_data.h>
#include <tests/physics/lab.h>

namespace scree::physics {

// N; what body a does to body b during the last substep. Stored impulses are those of one substep.
inline Eigen::Vector3d contact_force(const World& world, BodyId a, BodyId b) {
  const WorldData& data = internals(world);
  const ContactRows& rows = data.contacts.now;
  Eigen::Vector3d sum(0, 0, 0);
  for (const std::int32_t touching : data.contacts.active) {
    const auto row = static_cast<std::size_t>(touching);
    const Manifold& m = rows.manifold[row];
    auto first = static_cast<std::uint32_t>(data.shapes.body[static_cast<std::size_t>(rows.pair[row].a)]);
    auto second = static_cast<std::uint32_t>(data.shapes.body[static_cast<std::size_t>(rows.pair[row].b)]);
    // The normal points from the manifold's body A, which is the body that is not dynamic if there is one.
    if (static_cast<std::uint32_t>(m.row_b) != second) std::swap(first, second);
    const bool forth = first == a.index && second == b.index, back = first == b.index && second == a.index;
    if (!forth && !back) continue;
    const Eigen::Vector3d n(m.normal[0], m.normal[1], m.normal[2]);
    const Vec3 tangent = tangent_of({m.normal[0], m.normal[1], m.normal[2]});
    const Eigen::Vector3d t1 = to_eigen(tangent), t2 = n.cross(t1);
    Eigen::Vector3d impulse = m.friction_impulse[0] * t1 + m.friction_impulse[1] * t2;
    for (unsigned k = 0; k < (m.info & kManifoldPointMask); ++k) impulse += m.normal_impulse[k] * n;
    sum += forth ? impulse : -impulse;
  }
  return sum / static_cast<double>(data.last_substep);
}

}  // namespace scree::physics
