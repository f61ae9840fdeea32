// The public mesh: a shared, unchanging MeshSolid.
#include <core/geometry/mesh/mesh_build.h>
#include <scree/error.h>

#include <string>

namespace scree {

TriangleMesh::TriangleMesh() noexcept = default;
TriangleMesh::TriangleMesh(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                           const MeshMaterials& materials)
    : solid_(build_mesh("TriangleMesh", vertices, triangles, materials)) {}
TriangleMesh::TriangleMesh(const TriangleMesh&) noexcept = default;
TriangleMesh::TriangleMesh(TriangleMesh&&) noexcept = default;
TriangleMesh& TriangleMesh::operator=(const TriangleMesh&) noexcept = default;
TriangleMesh& TriangleMesh::operator=(TriangleMesh&&) noexcept = default;
TriangleMesh::~TriangleMesh() = default;

bool TriangleMesh::is_empty() const noexcept { return solid_ == nullptr; }

std::span<const Vec3> TriangleMesh::vertices() const noexcept {
  if (is_empty()) return {};
  return solid_->vertices;
}

std::size_t TriangleMesh::triangle_count() const noexcept {
  return is_empty() ? 0 : static_cast<std::size_t>(solid_->data.triangle_count);
}

MeshTriangle TriangleMesh::triangle(std::size_t given_number) const {
  const std::size_t count = report().given.triangles;
  if (given_number >= count) {
    throw Error("TriangleMesh::triangle: given_number is " + std::to_string(given_number) +
                ", but the mesh was made of " + std::to_string(count) + " triangles");
  }
  const std::int32_t row = row_of_given(*solid_, given_number);
  if (row < 0) {
    throw Error("TriangleMesh::triangle: triangle " + std::to_string(given_number) +
                " was dropped: it has no area, or the corners of an earlier one");
  }
  return given_corners(solid_->columns, row);
}

const TriangleMeshReport& TriangleMesh::report() const noexcept {
  static constexpr TriangleMeshReport kNothing;
  return is_empty() ? kNothing : solid_->report;
}

std::size_t TriangleMesh::memory() const noexcept { return is_empty() ? 0 : solid_->bytes(); }

bool operator==(const TriangleMesh& a, const TriangleMesh& b) noexcept {
  if (a.solid_ == b.solid_) return true;
  return !a.is_empty() && !b.is_empty() && equal(*a.solid_, *b.solid_);
}

}  // namespace scree
