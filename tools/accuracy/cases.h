// The cases of the accuracy suite: for each, the scene, the truth, its source, and the errors measured.
//
// cases_impact.cpp, cases_friction.cpp, cases_rotation.cpp and cases_structure.cpp hold the scenes and the
// evaluation, catalog.cpp the list. A case sees an engine only through Trial, so that one scene and one
// evaluation serve all.
#pragma once

#include <tools/accuracy/simulation.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace scree::accuracy {

inline constexpr double kGravity = 9.81;  ///< m/s^2
inline constexpr double kNone =
    std::numeric_limits<double>::quiet_NaN();  ///< a figure that a run did not give

/// What a case measures: the smaller, the better; 0 is the truth.
struct Measure {
  std::string name;
  std::string unit;  ///< "1" for a share
  std::string meaning;
  std::optional<double> limit = std::nullopt;  ///< stated as one; only then there is a verdict
};

struct Case {
  std::string name;
  std::string scene;   ///< what happens, in a line
  std::string truth;   ///< what should happen: the formula
  std::string source;  ///< where it comes from
  std::vector<Measure> measures;
  /// An error per measure; not a number where the engine shows no such thing (a top that never nutates).
  std::vector<double> (*measure)(Run& run) = nullptr;
};

/// All cases in the order in which they are listed.
const std::vector<Case>& catalog();

/// Throws scree::Error with the known names.
const Case& find_case(const std::string& name);

// --- the cases, in their files ---

std::vector<double> measure_bouncing(Run& run);
std::vector<double> measure_height(Run& run);
std::vector<double> measure_rebound(Run& run);
std::vector<double> measure_cradle(Run& run);
std::vector<double> measure_666(Run& run);
std::vector<double> measure_elastic_666(Run& run);
std::vector<double> measure_rolling(Run& run);
std::vector<double> measure_slide_to_roll(Run& run);
std::vector<double> measure_turntable(Run& run);
std::vector<double> measure_slip_onset(Run& run);
std::vector<double> measure_top(Run& run);
std::vector<double> measure_t_handle(Run& run);
std::vector<double> measure_pendulum(Run& run);
std::vector<double> measure_dominoes(Run& run);
std::vector<double> measure_arch(Run& run);
std::vector<double> measure_kapla(Run& run);

}  // namespace scree::accuracy
