// Figures as text. See fclib.h.
#include <tools/fclib/fclib.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace scree::fclib {

std::string to_table(const FclibFigures& figures) {
  std::ostringstream out;
  out << figures.scene << " after " << figures.at << " steps, written to " << figures.file << "\n"
      << "substep            " << figures.substep << " s\n"
      << "contact points     " << figures.points << "\n"
      << "held rows          " << figures.held_rows << "\n"
      << "direct solver      " << figures.iterations << " iterations, residual " << figures.residual
      << " m/s, natural map " << figures.natural_error << "\n";
  return out.str();
}

std::string to_json(const FclibFigures& figures) {
  const nlohmann::ordered_json json{{"scene", figures.scene},
                                    {"file", figures.file},
                                    {"at", figures.at},
                                    {"substep", figures.substep},
                                    {"points", figures.points},
                                    {"held_rows", figures.held_rows},
                                    {"iterations", figures.iterations},
                                    {"residual", figures.residual},
                                    {"natural_error", figures.natural_error}};
  return json.dump(2) + "\n";
}

}  // namespace scree::fclib
