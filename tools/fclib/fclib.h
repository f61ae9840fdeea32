// One step of a scene as a contact problem in a file of the FCLIB format (HDF5), for solvers of others; see
// core/solvers/README.md. absent.cpp stands for write.cpp where a build has no FCLIB.
#pragma once

#include <core/solvers/contact_problem.h>
#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <string>
#include <vector>

namespace scree::fclib {

struct FclibOptions {
  std::string file;
  int at = 0;  // steps before the one that is written
  float dt = 1.0f / 60.0f;
  int threads = 1;
  Isa isa = Isa::automatic;
};

struct FclibFigures {
  std::string scene, file;
  int at = 0;
  double substep = 0;  // s
  int points = 0;
  int held_rows = 0;
  // Of the direct solver:
  int iterations = 0;
  double residual = 0;       // m/s
  double natural_error = 0;  // see natural_map_error
};

struct FclibText {
  std::string title, description, math_info;
};

// Throws Error where this build has no FCLIB.
void check_available();

// Throws Error for a problem without points, std::runtime_error where the file cannot be written.
void write(const ContactProblem& problem, const FclibText& text, const std::string& file);

// Plays the scene, and writes what the first substep of the next step solves. Throws Error for a scene of
// several worlds, for one in which nothing touches, and for rows that such a problem has no place for.
FclibFigures write(const std::vector<scenes::Scene>& worlds, const FclibOptions& options);

std::string to_table(const FclibFigures& figures);
std::string to_json(const FclibFigures& figures);

}  // namespace scree::fclib
