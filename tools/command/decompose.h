// The command `scree decompose`: a closed mesh in a file -> convex hulls and figures.
#pragma once

#include <scree/decompose.h>
#include <scree/scree.h>
#include <tools/command/shape_files.h>

#include <string>
#include <vector>

namespace scree::command {

struct DecomposeArguments : ShapeFileArguments {
  DecomposeOptions options;
  std::string output;  // OBJ file of the hulls; empty: none
  std::string scene;   // scene file of a body of the hulls; empty: none
};

struct DecomposeFigures {
  std::string file;
  std::size_t triangles = 0;
  Decomposition parts;
  double seconds = 0.0;  // that the call took
};

// Throws Error, which names the file, for one that cannot be read or holds no closed mesh.
DecomposeFigures decompose_file(const DecomposeArguments& arguments);

std::string to_table(const DecomposeFigures& figures);
std::string to_json(const DecomposeFigures& figures);

// The hulls as an OBJ file; and as a scene, in which a body of them falls on a floor.
std::string to_obj(const DecomposeFigures& figures);
std::string to_scene(const DecomposeFigures& figures);

}  // namespace scree::command
