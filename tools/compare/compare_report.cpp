// Figures of a comparison -> tables, a plot of characters, and JSON; see compare.h.
#include <tools/command/text.h>
#include <tools/compare/compare.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace scree::comparison {
namespace {

using command::format;

constexpr int kWidth = 72, kHeight = 20;  // characters of the plot
constexpr double kLeastResidual = 1e-12;  // m/s; rounding leaves less of the unit of speeds

// Of the solvers, in their order.
constexpr char kMarks[kSolverCount + 1] = "SQJGOCAD";
char mark(Solver solver) { return kMarks[static_cast<int>(solver)]; }

std::string convergence_table(const CompareFigures& figures) {
  std::vector<int> counts;
  for (const SolverFigures& each : figures.solvers) {
    if (each.solver == Solver::direct) continue;
    for (const ConvergencePoint& point : each.convergence) counts.push_back(point.iterations);
  }
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  std::string table = format("\nresidual in m/s after k iterations of step %d\n%-22s", figures.at + 1, "k");
  for (const int count : counts) table += format(" %8d", count);
  table += "\n";
  for (const SolverFigures& each : figures.solvers) {
    table += format("%c %-20s", mark(each.solver), solver_name(each.solver));
    if (each.solver == Solver::direct && !each.convergence.empty()) {
      const ConvergencePoint& point = each.convergence.front();
      table += format(" %8.1e after %d factorizations, %.3f ms", point.residual, point.iterations,
                      point.milliseconds);
    } else {
      for (const ConvergencePoint& point : each.convergence) table += format(" %8.1e", point.residual);
    }
    table += "\n";
  }
  return table;
}

std::string run_table(const CompareFigures& figures) {
  std::string table =
      format("\n%d steps of %.6g s with %d iterations\n%-22s %9s %9s %9s %9s %9s %9s %9s %10s\n",
             figures.steps, figures.dt, figures.iterations, "", "ms/step", "residual", "pen. mean",
             "pen. max", "joints", "moved", "off exact", "energy");
  table += format("%-22s %9s %9s %9s %9s %9s %9s %9s %10s\n", "", "", "m/s", "mm", "mm", "mm", "m", "m", "J");
  for (const SolverFigures& each : figures.solvers) {
    table += format("%c %-20s %9.3f %9.1e %9.3f %9.3f %9.3f %9.4f ", mark(each.solver),
                    solver_name(each.solver), each.ms_per_step, each.residual, 1000 * each.penetration_mean,
                    1000 * each.penetration_max, 1000 * each.joint_error, each.moved);
    table += each.off_exact < 0 ? format("%9s", "-") : format("%9.4f", each.off_exact);
    table += format(" %10.4g", each.energy_change);
    if (each.restored_bodies > 0)
      table += format("  %lld bodies restored", static_cast<long long>(each.restored_bodies));
    table += "\n";
  }
  return table;
}

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  int place(double value, int cells) const {
    if (!(high > low)) return 0;
    return std::clamp(static_cast<int>((value - low) / (high - low) * (cells - 1) + 0.5), 0, cells - 1);
  }
};

// Residual against time, both to their logarithms; each point the letter of its solver.
std::string plot(const CompareFigures& figures) {
  Span time, residual;
  const auto over_points = [&figures](auto&& visit) {
    for (const SolverFigures& each : figures.solvers) {
      for (const ConvergencePoint& point : each.convergence) {
        if (!std::isfinite(point.residual)) continue;
        visit(each.solver, std::log10(std::max(point.milliseconds, 1e-6)),
              std::log10(std::max(point.residual, kLeastResidual)));
      }
    }
  };
  over_points([&](Solver, double x, double y) { time.take(x), residual.take(y); });
  if (!(time.high >= time.low)) return {};
  std::vector<std::string> lines(kHeight, std::string(kWidth, ' '));
  over_points([&](Solver solver, double x, double y) {
    lines[static_cast<std::size_t>(kHeight - 1 - residual.place(y, kHeight))]
         [static_cast<std::size_t>(time.place(x, kWidth))] = mark(solver);
  });
  std::string text = "\nresidual (m/s) against the solver's time (ms), both by powers of ten\n";
  for (int line = 0; line < kHeight; ++line) {
    const bool is_end = line == 0 || line == kHeight - 1;
    const double value = line == 0 ? residual.high : residual.low;
    text += (is_end ? format("%8.1e |", std::pow(10, value)) : std::string("         |")) +
            lines[static_cast<std::size_t>(line)] + "\n";
  }
  text += "         +" + std::string(kWidth, '-') + "\n";
  const std::string right = format("%.3g", std::pow(10, time.high)),
                    left = format("%.3g", std::pow(10, time.low));
  text += "          " + left + std::string(kWidth - left.size() - right.size(), ' ') + right + "\n";
  return text;
}

}  // namespace

std::string to_table(const CompareFigures& figures) {
  std::string text = format("%s: %lld bodies, %lld joints\n", figures.scene.c_str(),
                            static_cast<long long>(figures.bodies), static_cast<long long>(figures.joints));
  text += convergence_table(figures);
  text +=
      "soft_step: k substeps, begun with the stored impulses, and the errors that its last pass met; the "
      "others\n"
      "begin without, and measure what their rows still ask for.\n";
  text += plot(figures);
  text += run_table(figures);
  return text;
}

std::string to_json(const CompareFigures& figures) {
  nlohmann::ordered_json json;
  json["scene"] = figures.scene;
  json["bodies"] = figures.bodies;
  json["joints"] = figures.joints;
  json["at"] = figures.at;
  json["steps"] = figures.steps;
  json["dt"] = figures.dt;
  json["iterations"] = figures.iterations;
  for (const SolverFigures& each : figures.solvers) {
    nlohmann::ordered_json solver;
    solver["solver"] = solver_name(each.solver);
    for (const ConvergencePoint& point : each.convergence) {
      solver["convergence"].push_back({{"iterations", point.iterations},
                                       {"residual", point.residual},
                                       {"milliseconds", point.milliseconds}});
    }
    solver["ms_per_step"] = each.ms_per_step;
    solver["residual"] = each.residual;
    solver["penetration_mean"] = each.penetration_mean;
    solver["penetration_max"] = each.penetration_max;
    solver["joint_error"] = each.joint_error;
    solver["moved"] = each.moved;
    if (each.off_exact >= 0) solver["off_exact"] = each.off_exact;
    solver["energy_change"] = each.energy_change;
    solver["restored_bodies"] = each.restored_bodies;
    json["solvers"].push_back(solver);
  }
  return json.dump(2) + "\n";
}

}  // namespace scree::comparison
