// The public hull: a shared, unchanging HullSolid.
#include <core/geometry/hull/hull_build.h>
#include <scree/error.h>
#include <scree/hull.h>

#include <algorithm>
#include <string>

namespace scree {

bool equal(const HullSolid& a, const HullSolid& b) {
  return a.content_hash == b.content_hash && a.points == b.points &&
         a.topology.vertices == b.topology.vertices && a.topology.begin == b.topology.begin &&
         a.topology.loops == b.topology.loops && std::equal(a.origin, a.origin + 3, b.origin);
}

Hull::Hull() noexcept = default;
Hull::Hull(std::span<const Vec3> points, const HullOptions& options)
    : solid_(build_hull("Hull", points, options)) {}
Hull::Hull(const Hull&) noexcept = default;
Hull::Hull(Hull&&) noexcept = default;
Hull& Hull::operator=(const Hull&) noexcept = default;
Hull& Hull::operator=(Hull&&) noexcept = default;
Hull::~Hull() = default;

bool Hull::is_empty() const noexcept { return solid_ == nullptr; }

std::span<const Vec3> Hull::vertices() const noexcept {
  if (is_empty()) return {};
  return solid_->points;
}

std::size_t Hull::edge_count() const noexcept { return is_empty() ? 0 : solid_->topology.edges.size(); }
std::size_t Hull::face_count() const noexcept { return is_empty() ? 0 : solid_->topology.planes.size(); }

std::span<const std::uint8_t> Hull::face(std::size_t index) const {
  if (index >= face_count()) {
    throw Error("Hull::face: index is " + std::to_string(index) + ", but the hull has " +
                std::to_string(face_count()) + " faces");
  }
  const HullTopology& topology = solid_->topology;
  const std::size_t first = topology.begin[index];
  return std::span(topology.loops).subspan(first, topology.begin[index + 1] - first);
}

float Hull::volume() const noexcept {
  return is_empty() ? 0.0f : static_cast<float>(solid_->integrals.volume);
}

Vec3 Hull::centroid() const noexcept {
  if (is_empty()) return {};
  const double* origin = solid_->origin;
  const double* center = solid_->integrals.center;
  return {static_cast<float>(origin[0] + center[0]), static_cast<float>(origin[1] + center[1]),
          static_cast<float>(origin[2] + center[2])};
}

const HullReport& Hull::report() const noexcept {
  static constexpr HullReport kNothing;
  return is_empty() ? kNothing : solid_->report;
}

bool operator==(const Hull& a, const Hull& b) noexcept {
  if (a.solid_ == b.solid_) return true;
  return !a.is_empty() && !b.is_empty() && equal(*a.solid_, *b.solid_);
}

}  // namespace scree
