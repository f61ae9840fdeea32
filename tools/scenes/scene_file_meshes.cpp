// The triangle meshes of scene files, written out or in files of their own. README.md beside this file states
// the schema.
#include <tools/meshes/mesh_file.h>
#include <tools/scenes/scene_file_parts.h>

#include <filesystem>
#include <vector>

namespace scree::scenes {

namespace {

const Range kVertex = within(kMaxExtent);  // m

TriangleMesh build(const Node& node, const std::vector<Vec3>& vertices,
                   const std::vector<MeshTriangle>& triangles) {
  try {
    return TriangleMesh(vertices, triangles);
  } catch (const Error& error) {
    node.fail(error.what());
  }
}

std::vector<MeshTriangle> read_triangles(const Node& list, std::size_t vertices) {
  std::vector<MeshTriangle> triangles;
  const std::int64_t last = static_cast<std::int64_t>(vertices) - 1;
  for (const Node& node : list.elements()) {
    const std::vector<Node> corners = node.elements(3, "numbers of vertices");
    const auto corner = [&](std::size_t k) {
      return static_cast<std::uint32_t>(corners[k].integer(0, last));
    };
    triangles.push_back({corner(0), corner(1), corner(2)});
  }
  return triangles;
}

}  // namespace

const TriangleMesh& MeshReader::read_file(const Node& file, float scale) {
  if (!folder_) file.fail("a scene that is no file cannot name files");
  const std::string path = (std::filesystem::path(*folder_) / file.string()).string();
  const auto [known, is_new] = known_.try_emplace({path, scale});
  if (!is_new) return known->second;
  try {
    const meshes::Mesh mesh = meshes::read_mesh(path, scale);
    known->second = TriangleMesh(mesh.vertices, mesh.triangles);
  } catch (const Error& error) {
    file.fail(error.what());
  }
  return known->second;
}

TriangleMesh MeshReader::read(Members& shape) {
  if (const Node* file = shape.find("file")) {
    float scale = 1.0f;
    shape.read("scale", scale, between(kMinHullScale, kMaxHullScale));
    return read_file(*file, scale);
  }
  const Node& list = shape.require("vertices");
  std::vector<Vec3> vertices;
  for (const Node& vertex : list.elements()) vertices.push_back(vertex.vector(kVertex));
  if (vertices.empty()) list.fail("a mesh has vertices");
  const Node& triangles = shape.require("triangles");
  return build(triangles, vertices, read_triangles(triangles, vertices.size()));
}

}  // namespace scree::scenes
