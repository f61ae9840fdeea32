// The mass of what a closed mesh encloses; see scree/mesh.h.
#include <core/geometry/mesh/mesh_check.h>
#include <core/geometry/solid_integrals.h>
#include <core/world/limits.h>
#include <core/world/number_text.h>
#include <scree/error.h>

#include <cmath>
#include <string>

namespace scree {

namespace {

constexpr const char* kMassCall = "mesh_mass: ";

std::string digits_of(double value) { return number_text(value, 9); }

void check_closed(const MeshReport& report) {
  if (report.is_closed()) return;
  if (report.triangles == 0) throw Error(std::string(kMassCall) + "the mesh has no triangles");
  throw Error(std::string(kMassCall) + "the mesh is not closed: of " + std::to_string(report.edges) +
              " edges " + std::to_string(report.open_edges) + " are open and " +
              std::to_string(report.flipped_edges) + " are between triangles that look to different sides");
}

// About a point within the mesh's bounds: far from the origin nothing would be left of a small solid.
struct CenteredIntegrals {
  SolidIntegrals sums;
  SolidPoint middle{};
  double sizes = 0.0;  // m^3, of all tetrahedra whatever their sign
};
CenteredIntegrals integrate(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                            const MeshReport& report) {
  CenteredIntegrals integrals;
  for (int i = 0; i < 3; ++i) {
    integrals.middle[static_cast<std::size_t>(i)] =
        0.5 * (static_cast<double>(report.lower[i]) + static_cast<double>(report.upper[i]));
  }
  const auto point = [&](std::uint32_t vertex) -> SolidPoint {
    const Vec3& v = vertices[vertex];
    return {v.x - integrals.middle[0], v.y - integrals.middle[1], v.z - integrals.middle[2]};
  };
  for (const MeshTriangle& triangle : triangles) {
    integrals.sizes += std::abs(integrals.sums.add(point(triangle.a), point(triangle.b), point(triangle.c)));
  }
  return integrals;
}

}  // namespace

MassProperties mesh_mass(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                         float density) {
  check_mesh("mesh_mass", vertices, triangles);
  if (!(density >= kMinDensity && density <= kMaxDensity)) {
    throw Error(std::string(kMassCall) + "density is " + digits_of(density) + ", must lie in [" +
                digits_of(kMinDensity) + ", " + digits_of(kMaxDensity) + "]");
  }
  const MeshReport report = report_mesh(vertices, triangles);
  check_closed(report);
  const CenteredIntegrals integrals = integrate(vertices, triangles, report);
  const SolidIntegrals& sums = integrals.sums;
  // Tetrahedra that cancel leave what their sum has rounded.
  constexpr double kRounding = 1e-12;
  if (!(std::abs(sums.volume) > kRounding * integrals.sizes)) {
    throw Error(std::string(kMassCall) + "the mesh encloses no volume");
  }
  // A mesh that is inside out has all integrals with the opposite sign; the quotients have not.
  const double filling = sums.volume > 0.0 ? density : -static_cast<double>(density);
  const double mass = filling * sums.volume;
  if (!(mass >= kMinMass && mass <= kMaxMass)) {
    throw Error(std::string(kMassCall) + "the mass is " + digits_of(mass) + " kg, must lie in [" +
                digits_of(kMinMass) + ", " + digits_of(kMaxMass) + "]");
  }
  double center[3], moment[6];
  for (int i = 0; i < 3; ++i) center[i] = sums.first[i] / sums.volume;
  for (int k = 0; k < 6; ++k) {
    moment[k] = filling * (sums.second[k] - sums.volume * center[kMomentRow[k]] * center[kMomentColumn[k]]);
  }
  MassProperties properties;
  properties.mass = static_cast<float>(mass);
  for (int i = 0; i < 3; ++i) {
    properties.center[i] = static_cast<float>(center[i] + integrals.middle[static_cast<std::size_t>(i)]);
  }
  const double inertia[6] = {moment[3] + moment[5],
                             moment[0] + moment[5],
                             moment[0] + moment[3],
                             -moment[1],
                             -moment[2],
                             -moment[4]};
  for (int k = 0; k < 6; ++k) properties.inertia[k] = static_cast<float>(inertia[k] + 0.0);
  return properties;
}

}  // namespace scree
