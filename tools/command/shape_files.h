// The commands `scree hull` and `scree mass`: a file of points or triangles -> figures.
#pragma once

#include <scree/scree.h>
#include <tools/meshes/mesh_file.h>

#include <string>

namespace scree::command {

struct ShapeFileArguments {
  std::string file;
  float scale = 1.0f;
};

struct HullArguments : ShapeFileArguments {
  int max_vertices = 256;
  std::string output;  // OBJ file of the hull; empty: none
};

struct MassArguments : ShapeFileArguments {
  float density = 1000.0f;
  bool of_hull = false;  // of the convex hull instead of the mesh
};

struct HullFigures {
  std::string file;
  HullReport report;
  std::size_t vertices = 0, edges = 0, faces = 0;
  float volume = 0.0f;  // m^3
  Vec3 centroid{};      // m
  std::string obj;      // the hull as an OBJ file
};

struct MassFigures {
  std::string file;
  bool of_hull = false;
  float density = 0.0f;
  MeshReport report;
  MassProperties mass;
  PrincipalAxes axes;
};

// Throws Error, which names the file, for one that cannot be read, and for a scale out of range.
meshes::Mesh read_shape_file(const ShapeFileArguments& arguments);

// Throw Error, which names the file, for one that cannot be read or holds no solid.
HullFigures build_hull(const HullArguments& arguments);
MassFigures measure_mass(const MassArguments& arguments);

std::string to_table(const HullFigures& figures);
std::string to_table(const MassFigures& figures);
std::string to_json(const HullFigures& figures);
std::string to_json(const MassFigures& figures);

}  // namespace scree::command
