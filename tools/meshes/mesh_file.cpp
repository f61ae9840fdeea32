// See mesh_file.h.
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <scree/error.h>
#include <tools/meshes/mesh_file.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <unordered_map>

namespace scree::meshes {

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& problem) {
  throw Error(path + ": " + problem);
}

std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return ending;
}

// Text of the kind must end with "endsolid". Assimp reads what there is of a file that was cut off.
void check_stl_end(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char head[84]{};
  file.read(head, sizeof head);
  const std::uintmax_t size = std::filesystem::file_size(path);
  std::uint32_t count = 0;
  std::memcpy(&count, head + 80, sizeof count);
  constexpr std::uintmax_t kHead = 84, kTriangle = 50;
  if (size >= kHead && size == kHead + kTriangle * count) return;
  if (std::memcmp(head, "solid", 5) != 0) {
    fail(path, "is cut off, or no STL file: text would begin with solid, and " + std::to_string(count) +
                   " triangles would take " + std::to_string(kHead + kTriangle * count) +
                   " bytes, but there are " + std::to_string(size));
  }
  constexpr std::uintmax_t kTail = 512;
  std::string tail(static_cast<std::size_t>(std::min(size, kTail)), ' ');
  file.clear();
  file.seekg(-static_cast<std::streamoff>(tail.size()), std::ios::end);
  file.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  if (tail.find("endsolid") == std::string::npos) fail(path, "is cut off: it does not end with endsolid");
}

// Assimp gives each face corners of its own. Equal ones become one, in the order in which they come.
class Corners {
 public:
  Corners(float scale, Mesh& mesh) : scale_(scale), mesh_(mesh) {}
  std::uint32_t add(const aiVector3D& v) {
    const std::array<float, 3> place{v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};  // no negative zeros
    const auto next = static_cast<std::uint32_t>(mesh_.vertices.size());
    const auto [found, is_new] = known_.emplace(std::bit_cast<Bits>(place), next);
    if (is_new) mesh_.vertices.push_back({place[0] * scale_, place[1] * scale_, place[2] * scale_});
    return found->second;
  }

 private:
  using Bits = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Bits& bits) const {
      std::uint64_t hash = 0;
      for (const std::uint32_t word : bits) hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
      return static_cast<std::size_t>(hash >> 16);
    }
  };
  float scale_;
  Mesh& mesh_;
  std::unordered_map<Bits, std::uint32_t, Hash> known_;
};

void append(const std::string& path, const aiMesh& part, Corners& corners, Mesh& mesh) {
  std::vector<std::uint32_t> number(part.mNumVertices);
  for (unsigned i = 0; i < part.mNumVertices; ++i) number[i] = corners.add(part.mVertices[i]);
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;
    for (unsigned k = 0; k < 3; ++k) {
      if (face.mIndices[k] < number.size()) continue;
      fail(path, "face " + std::to_string(i) + " has a corner at vertex " + std::to_string(face.mIndices[k]) +
                     ", but there are " + std::to_string(number.size()));
    }
    mesh.triangles.push_back({number[face.mIndices[0]], number[face.mIndices[1]], number[face.mIndices[2]]});
  }
}

// Assimp quotes the rest of the file.
std::string brief(const std::string& message) {
  constexpr std::size_t kMost = 120;
  const std::string line = message.substr(0, message.find_first_of("\r\n"));
  return line.size() <= kMost ? line : line.substr(0, kMost) + "...";
}

void append_line(std::string& text, const char* pattern, double x, double y, double z) {
  char line[128];
  std::snprintf(line, sizeof line, pattern, x, y, z);
  text += line;
}

}  // namespace

Mesh read_mesh(const std::string& path, float scale) {
  const std::string ending = ending_of(path);
  if (ending != ".obj" && ending != ".stl") fail(path, "the name must end in .obj or .stl");
  std::error_code problem;
  if (!std::filesystem::is_regular_file(path, problem)) fail(path, "there is no such file");
  if (ending == ".stl") check_stl_end(path);
  Assimp::Importer importer;
  // Normals, colors and the like keep vertices apart that are in one place.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_MATERIALS);
  const aiScene* scene = importer.ReadFile(path, aiProcess_RemoveComponent | aiProcess_Triangulate);
  if (scene == nullptr) fail(path, brief(importer.GetErrorString()));
  Mesh mesh;
  Corners corners(scale, mesh);
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(path, *scene->mMeshes[i], corners, mesh);
  if (mesh.vertices.empty()) fail(path, "holds no points");
  return mesh;
}

namespace {

// `before`: vertices of the file so far.
void append_hull(std::string& text, const Hull& hull, std::size_t before) {
  for (const Vec3& v : hull.vertices()) append_line(text, "v %.9g %.9g %.9g\n", v.x, v.y, v.z);
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    text += "f";
    for (const std::uint8_t corner : hull.face(f)) {
      text += ' ';
      text += std::to_string(before + corner + 1);
    }
    text += '\n';
  }
}

}  // namespace

std::string to_obj(const Hull& hull) {
  std::string text;
  append_hull(text, hull, 0);
  return text;
}

std::string to_obj(std::span<const Hull> hulls) {
  std::string text;
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < hulls.size(); ++i) {
    text += "o part_" + std::to_string(i) + "\n";
    append_hull(text, hulls[i], vertices);
    vertices += hulls[i].vertices().size();
  }
  return text;
}

}  // namespace scree::meshes
