// Laws of meshes in scene files: written out, or in files beside the scene's.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <tests/core/geometry/mesh/meshes.h>
#include <tests/run_program.h>
#include <tools/scenes/scene.h>
#include <tools/scenes/scene_file.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace scree::scenes {
namespace {

namespace fs = std::filesystem;

class SceneFileMeshes : public scree::testing::ProgramTest {
 protected:
  std::string write(const fs::path& name, const std::string& text) {
    const fs::path path = folder_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
};

std::string obj_of(const scree::test_solids::TestMesh& mesh) {
  std::ostringstream text;
  for (const Vec3& v : mesh.vertices) text << "v " << v.x << " " << v.y << " " << v.z << "\n";
  for (const MeshTriangle& t : mesh.triangles)
    text << "f " << t.a + 1 << " " << t.b + 1 << " " << t.c + 1 << "\n";
  return text.str();
}

std::string with_shapes(const std::string& shapes, const std::string& type = "fixed") {
  return R"({"bodies": [{"type": ")" + type + R"(", "shapes": [)" + shapes + "]}]}";
}
const TriangleMesh& mesh_of(const Scene& scene, std::size_t shape) {
  return std::get<TriangleMesh>(scene.shapes[shape].geometry);
}
std::string refusal(const std::string& text) {
  try {
    parse_scene(text, "scene.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_F(SceneFileMeshes, MayBeWrittenOut) {
  const Scene scene =
      parse_scene(with_shapes(R"({"type": "mesh", "vertices": [[0, 0, 0], [0, 0, 1], [1, 0, 0],
    [1, 0.5, 1]], "triangles": [[0, 1, 2], [1, 3, 2]], "material": {"friction": 0.25}})"),
                  "scene.json");
  ASSERT_EQ(scene.shapes.size(), 1u);
  EXPECT_EQ(mesh_of(scene, 0).triangle_count(), 2u);
  EXPECT_EQ(mesh_of(scene, 0).vertices()[3], (Vec3{1, 0.5f, 1}));
  EXPECT_EQ(scene.shapes[0].material.friction, 0.25f);
  World world(scene.settings);
  populate(world, scene);
  EXPECT_EQ(world.shape_count(), 1u);
}

TEST_F(SceneFileMeshes, MayStandInFilesRelativeToTheScene) {
  const scree::test_solids::TestMesh ring = scree::test_solids::torus_mesh(2, 1, 8, 6);
  write("land/ring.obj", obj_of(ring));
  const std::string scene_file =
      write("scene.json", R"({"shapes": {"ring": {"type": "mesh", "file": "land/ring.obj"}},
        "bodies": [{"type": "fixed", "shapes": ["ring", {"type": "mesh", "file": "land/ring.obj"},
          {"type": "mesh", "file": "land/ring.obj", "scale": 2}]}, {"type": "kinematic", "shapes": ["ring"]}]})");
  const Scene scene = read_scene_file(scene_file);
  ASSERT_EQ(scene.shapes.size(), 4u);
  EXPECT_EQ(mesh_of(scene, 0).triangle_count(), 96u);
  EXPECT_EQ(mesh_of(scene, 0), mesh_of(scene, 1));
  EXPECT_EQ(mesh_of(scene, 0), mesh_of(scene, 3));
  EXPECT_EQ(mesh_of(scene, 2).vertices()[5], 2.0f * mesh_of(scene, 0).vertices()[5]);
}

TEST_F(SceneFileMeshes, MistakesAreReportedWithTheirPlace) {
  const std::string begin =
      R"({"type": "mesh", "vertices": [[0, 0, 0], [0, 0, 1], [1, 0, 0]], "triangles": )";
  const std::pair<std::string, std::string> mistakes[] = {
      {with_shapes(R"({"type": "mesh"})"), "/bodies/0/shapes/0: the key \"vertices\" is missing"},
      {with_shapes(R"({"type": "mesh", "vertices": [], "triangles": []})"),
       "/bodies/0/shapes/0/vertices: a mesh has vertices"},
      {with_shapes(R"({"type": "mesh", "vertices": [[0, 0, 1e6]]})"),
       "/bodies/0/shapes/0/vertices/0/2: 1000000 must be from -100000 to 100000"},
      {with_shapes(begin + "[]}"), "/bodies/0/shapes/0/triangles: TriangleMesh: the mesh has no triangles"},
      {with_shapes(begin + "[[0, 1]]}"),
       "/bodies/0/shapes/0/triangles/0: expected an array of 3 numbers of vertices, found 2"},
      {with_shapes(begin + "[[0, 1, 3]]}"),
       "/bodies/0/shapes/0/triangles/0/2: 3 must be a whole number from 0 to 2"},
      {with_shapes(begin + "[[0, 1, 1]]}"),
       "/bodies/0/shapes/0/triangles: TriangleMesh: none of the 1 "
       "triangles has an area: their corners lie on lines"},
      {with_shapes(R"({"type": "mesh", "file": "/etc/passwd"})"),
       "/bodies/0/shapes/0/file: a scene that is no file cannot name files"},
      {with_shapes(begin + "[[0, 1, 2]]}", "dynamic"),
       "/bodies/0: World::add_shape: a triangle mesh belongs to fixed and kinematic bodies only, but the "
       "body "
       "is dynamic"},
      {with_shapes(begin + R"([[0, 1, 2]], "sensor": true})"),
       "/bodies/0: World::add_shape: a triangle mesh is no sensor, but the shape is one"},
  };
  for (const auto& [text, message] : mistakes) EXPECT_EQ(refusal(text), "scene.json: " + message) << text;
  const std::string file = write("scene.json", with_shapes(R"({"type": "mesh", "file": "nothing.stl"})"));
  try {
    read_scene_file(file);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("nothing.stl: there is no such file"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace scree::scenes
