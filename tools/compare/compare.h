// Every solver of WorldSettings::solver on one scene: what is left after so many iterations, and where a run
// ends. compare_report.cpp shows the figures.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace scree::comparison {

struct CompareOptions {
  std::vector<Solver> solvers;  // empty: all
  int steps = 0;                // of each run
  int at = 0;                   // steps after which convergence is measured
  int iterations = 30;          // of the runs
  std::vector<int> counts;      // iterations after which the residual is measured, ascending
  float dt = 1.0f / 60.0f;
  int threads = 1;
  Isa isa = Isa::automatic;
};

// One step from the same state, with so many iterations, without stored impulses.
struct ConvergencePoint {
  int iterations;
  double residual;      // m/s
  double milliseconds;  // of the solver, the least of several repeats
};

struct SolverFigures {
  Solver solver = Solver::soft_step;
  std::vector<ConvergencePoint> convergence;
  // Of the run:
  double ms_per_step = 0;
  double residual = 0;          // m/s, the mean over every tenth step
  double penetration_mean = 0;  // m, at the end
  double penetration_max = 0;
  double moved = 0;          // m, mean distance of the bodies from their places at the start
  double off_exact = -1;     // m, mean distance from where the direct solver has them; -1: it did not run
  double joint_error = 0;    // m, the largest distance of two anchors that are to be one point, at the end
  double energy_change = 0;  // J, kinetic and potential, from the start to the end
  std::int64_t restored_bodies = 0;
};

struct CompareFigures {
  std::string scene;
  std::int64_t bodies = 0;  // that can move
  std::int64_t joints = 0;
  int steps = 0, at = 0, iterations = 0;
  double dt = 0;
  std::vector<SolverFigures> solvers;
};

// Throws scree::Error on a scene of several worlds.
CompareFigures compare(const std::vector<scenes::Scene>& worlds, const CompareOptions& options);

std::string to_table(const CompareFigures& figures);  // with a plot of residual against time
std::string to_json(const CompareFigures& figures);

}  // namespace scree::comparison
