// Shared by the readers of a scene file's bodies, meshes and joints. Used only by scene_file.cpp,
// scene_file_meshes.cpp and scene_file_joints.cpp.
#pragma once

#include <core/world/limits.h>
#include <tools/scenes/json_node.h>
#include <tools/scenes/scene.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace scree::scenes {

// Ranges between float limits, converted to the decimal numbers in the source: 1e-4f itself is
// 9.99999975e-05.
Range between(float low, float high);
inline Range up_to(float high) { return between(0.0f, high); }
inline Range within(float limit) { return between(-limit, limit); }

// A unit quaternion, or an axis and an angle.
Quat read_rotation(const Node& node);
void read_rotation(Members& members, Quat& out);

std::string known_names(const auto& named) {
  std::string list;
  for (const auto& [name, unused] : named) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none is defined" : "defined are: " + list;
}

// Reads the meshes of shapes; what several shapes read from one file is one mesh.
class MeshReader {
 public:
  // Files are relative to the folder; without one there are none.
  explicit MeshReader(std::optional<std::string> folder) : folder_(std::move(folder)) {}
  TriangleMesh read(Members& shape);

 private:
  const TriangleMesh& read_file(const Node& file, float scale);

  std::optional<std::string> folder_;
  std::map<std::pair<std::string, float>, TriangleMesh> known_;  // by path and scale
};

// Bodies that a file has named: a single body, or the run that a repeat makes.
struct NamedBodies {
  std::uint32_t first = 0;  // into Scene::bodies
  std::int64_t count = 1;
};
using BodyNames = std::map<std::string, NamedBodies>;

// The name of the world where a joint names its bodies; no body may have it.
inline constexpr const char* kWorldName = "world";

// Adds the joints of an array to the scene, whose bodies are complete; at most `most` with their repeats.
void read_joints(const Node& array, const BodyNames& names, std::int64_t most, Scene& scene);

}  // namespace scree::scenes
