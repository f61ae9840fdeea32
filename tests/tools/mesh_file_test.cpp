// Laws of the readers of mesh files, on files that the tests write.
#include <gtest/gtest.h>
#include <scree/error.h>
#include <tests/core/geometry/mesh/meshes.h>
#include <tests/run_program.h>
#include <tools/meshes/mesh_file.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

using scree::Vec3;
using scree::meshes::Mesh;
using scree::meshes::read_mesh;
using scree::test_solids::TestMesh;

class MeshFile : public scree::testing::ProgramTest {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    const fs::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path.string();
  }
  static std::string refusal(const std::string& path) {
    try {
      read_mesh(path);
    } catch (const scree::Error& error) {
      return error.what();
    }
    return "";
  }
  void expect_refusal(const std::string& name, const std::string& bytes, const std::string& reason) {
    const std::string path = write(name, bytes), message = refusal(path);
    EXPECT_EQ(message.find(path + ": "), 0u) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
    EXPECT_LT(message.size(), path.size() + 250);
  }
};

std::string obj_of(const TestMesh& mesh) {
  std::ostringstream text;
  for (const Vec3& v : mesh.vertices) text << "v " << v.x << " " << v.y << " " << v.z << "\n";
  for (const auto& t : mesh.triangles)
    text << "f " << t.a + 1 << " " << t.b + 1 << "/7/7 " << t.c + 1 << "\n";
  return text.str();
}

std::string text_stl_of(const TestMesh& mesh) {
  std::ostringstream text;
  text << "solid some name\n";
  for (const auto& t : mesh.triangles) {
    text << " facet normal 0 0 0\n  outer loop\n";
    for (const std::uint32_t corner : {t.a, t.b, t.c}) {
      const Vec3& v = mesh.vertices[corner];
      text << "   vertex " << v.x << " " << v.y << " " << v.z << "\n";
    }
    text << "  endloop\n endfacet\n";
  }
  text << "endsolid some name\n";
  return text.str();
}

template <class Value>
void append_bytes(std::string& bytes, const Value& value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

std::string binary_stl_of(const TestMesh& mesh, const std::string& head) {
  std::string bytes = head;
  bytes.resize(80, ' ');
  append_bytes(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    append_bytes(bytes, Vec3{});
    for (const std::uint32_t corner : {t.a, t.b, t.c}) append_bytes(bytes, mesh.vertices[corner]);
    append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

void expect_torus(const Mesh& mesh, float scale = 1.0f) {
  const scree::MeshReport report = scree::inspect_mesh(mesh.vertices, mesh.triangles);
  EXPECT_EQ(mesh.vertices.size(), 60u);
  EXPECT_EQ(report.vertices, 60u);
  EXPECT_EQ(report.triangles, 120u);
  EXPECT_TRUE(report.is_closed());
  EXPECT_NEAR(report.upper.x, 2.5f * scale, 1e-5f * scale);
}

TestMesh torus() { return scree::test_solids::torus_mesh(2.0, 0.5, 10, 6); }

TEST_F(MeshFile, AllKindsOfFilesHoldTheSameMesh) {
  TestMesh mesh = torus();
  // Few digits, so that text has them all.
  mesh.map([](Vec3 v) {
    return Vec3{std::round(v.x * 1024) / 1024, std::round(v.y * 1024) / 1024, std::round(v.z * 1024) / 1024};
  });
  expect_torus(read_mesh(write("torus.obj", obj_of(mesh))));
  expect_torus(read_mesh(write("torus.STL", text_stl_of(mesh))));
  expect_torus(read_mesh(write("binary.stl", binary_stl_of(mesh, "made by a test"))));
  expect_torus(read_mesh(write("solid.stl", binary_stl_of(mesh, "solid, and binary all the same"))));
  expect_torus(read_mesh(write("scaled.obj", obj_of(mesh)), 0.001f), 0.001f);
}

TEST_F(MeshFile, FacesOfManyCornersAndNegativeIndicesAreRead) {
  const Mesh mesh =
      read_mesh(write("box.obj",
                      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                      "f -8 -5 -6 -7\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"));
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(scree::mesh_mass(mesh.vertices, mesh.triangles, 3.0f).mass, 3.0f);
}

TEST_F(MeshFile, PointsAloneAreEnoughForAHull) {
  const Mesh mesh = read_mesh(write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"));
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST_F(MeshFile, HullsAreWrittenAndReadAgain) {
  const TestMesh ball = scree::test_solids::ball_mesh(1.5f, 2);
  const scree::Hull hull(ball.vertices);
  const Mesh mesh = read_mesh(write("hull.obj", scree::meshes::to_obj(hull)));
  EXPECT_EQ(mesh.vertices.size(), hull.vertices().size());
  EXPECT_TRUE(scree::inspect_mesh(mesh.vertices, mesh.triangles).is_closed());
  EXPECT_NEAR(scree::mesh_mass(mesh.vertices, mesh.triangles, 1.0f).mass, hull.volume(),
              1e-5f * hull.volume());
}

TEST_F(MeshFile, SeveralHullsAreOneFile) {
  const TestMesh ball = scree::test_solids::ball_mesh(1.5f, 2), box = scree::test_solids::box_mesh({1, 2, 3});
  const scree::Hull hulls[] = {scree::Hull(ball.vertices), scree::Hull(box.vertices)};
  const std::string text = scree::meshes::to_obj(hulls);
  EXPECT_NE(text.find("o part_1\n"), std::string::npos);
  const Mesh mesh = read_mesh(write("hulls.obj", text));
  const scree::MeshReport report = scree::inspect_mesh(mesh.vertices, mesh.triangles);
  EXPECT_TRUE(report.is_closed());
  EXPECT_EQ(report.parts, 2u);
  EXPECT_NEAR(scree::mesh_mass(mesh.vertices, mesh.triangles, 1.0f).mass,
              hulls[0].volume() + hulls[1].volume(), 1e-3f);
}

TEST_F(MeshFile, FilesThatAreCutOffAreRefused) {
  const std::string text = text_stl_of(torus()), binary = binary_stl_of(torus(), "made by a test");
  for (const std::size_t size : {text.size() - 30, text.size() / 2, std::size_t{100}})
    expect_refusal("cut.stl", text.substr(0, size), "cut off");
  for (const std::size_t size : {binary.size() - 1, binary.size() / 2, std::size_t{84}, std::size_t{3}})
    expect_refusal("cut.stl", binary.substr(0, size), "cut off");
  expect_refusal("cut.stl", "", "cut off");
  expect_refusal("longer.stl", binary + "more", "cut off, or no STL file");
}

TEST_F(MeshFile, BadFilesAreRefusedByName) {
  EXPECT_NE(refusal(write("mesh.ply", "ply")).find("mesh.ply: the name must end in .obj or .stl"),
            std::string::npos);
  EXPECT_NE(refusal((folder_ / "none.obj").string()).find("none.obj: there is no such file"),
            std::string::npos);
  expect_refusal("empty.obj", "", "");
  expect_refusal("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "vertex index out of range");
  std::string text = text_stl_of(torus());
  text[text.find("vertex ") + 7] = 'x';
  expect_refusal("letters.stl", text, "");
}

}  // namespace
