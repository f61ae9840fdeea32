// The list of the cases: what happens, what should, where that is from, and what is measured.
#include <tools/accuracy/cases.h>

namespace scree::accuracy {
namespace {

const char* const kSimBenchmark =
    "Kang and Hwangbo, SimBenchmark (2018), github.com/leggedrobotics/SimBenchmark";

std::vector<Case> impact_cases() {
  return {
      {"bouncing",
       "49 elastic balls of 10 kg and radius 0.1 m fall from 5 m for 20 s",
       "the energy stays as it is",
       kSimBenchmark,
       {{"energy", "J^2", "mean over the steps of the squared deviation of the energy", 0.02}},
       measure_bouncing},
      {"height",
       "an elastic ball falls from 1 m and bounces 100 times",
       "it comes back to 1 m",
       "conservation of energy",
       {{"height", "1", "largest deviation of a height from the first", 0.01}},
       measure_height},
      {"rebound",
       "balls with e = 0.3, 0.6, 0.8 and 0.9 fall from 2 m and bounce up to ten times, while they come well "
       "above 1 m/s",
       "each height is e^2 of the one before",
       "Newton's law of impact",
       {{"e 0.3", "1", "largest deviation of the ratio of two heights from e^2", 0.01},
        {"e 0.6", "1", "as above", 0.01},
        {"e 0.8", "1", "as above", 0.01},
        {"e 0.9", "1", "as above", 0.01}},
       measure_rebound},
      {"cradle",
       "one ball or two hit a row, five equal elastic balls in all, with gaps of 0, 0.1, 1 and 10 mm; in "
       "free space and "
       "on a plane without friction",
       "as many leave at the speed with which they came, and the others rest",
       "momentum and energy of impacts in pairs, from the first to the last",
       {{"last", "1", "one in: error of the last ball's speed over the speed, worst gap", 0.01},
        {"others", "1", "one in: largest speed of the others over the speed, worst gap", 0.01},
        {"two", "1", "two in: the larger one of both, worst gap", 0.01},
        {"energy", "1", "largest change of the energy over the energy, worst of all"},
        {"plane last", "1", "as above, on a plane", 0.01},
        {"plane others", "1", "as above, on a plane", 0.01},
        {"plane two", "1", "as above, on a plane", 0.01},
        {"plane energy", "1", "as above, on a plane"}},
       measure_cradle},
      {"666",
       "6 x 6 x 6 balls of 10 kg and radius 0.1 m without friction fall apart on a plane, 10 s",
       "nothing overlaps",
       kSimBenchmark,
       {{"overlap", "m^2", "mean over the steps of the sum of the squared overlaps", 1e-5}},
       measure_666},
      {"elastic_666",
       "the same from 1.1 m with e = 1",
       "the energy stays as it is",
       kSimBenchmark,
       {{"energy", "J^2", "mean over the steps of the squared deviation of the energy", 8.4},
        {"change", "1", "change of the energy at the end over the energy"}},
       measure_elastic_666},
  };
}

std::vector<Case> friction_cases() {
  return {
      {"rolling",
       "150 N push a sliding plate of 10 kg at 60 degrees to its sides, with 25 rolling balls of 1 kg on it, "
       "4 s",
       "plate and balls have constant accelerations, the balls 2/7 of the plate's",
       kSimBenchmark,
       {{"velocity", "(m/s)^2",
         "mean over the steps of the squared errors of the plate's and a ball's velocity", 1e-5}},
       measure_rolling},
      {"slide_to_roll",
       "a ball slides at 5 m/s with a friction of 0.3",
       "after 2 v / (7 mu g) it rolls with 5/7 of its speed",
       "Coulomb's law; Coriolis, Theorie mathematique des effets du jeu de billard (1835)",
       {{"speed", "1", "error of the speed after 1 s over it"},
        {"way", "1", "error of the way after 1 s over it"}},
       measure_slide_to_roll},
      {"turntable",
       "a ball rolls on a table that turns at 1.75 rad/s, for two circles",
       "its velocity turns at 2/7 of the table's rate: it goes round in a circle of any radius and center",
       "Weltner, Stable circular orbits of freely moving balls on rotating discs, Am. J. Phys. 47 (1979) 984",
       {{"rate", "1", "error of the velocity's mean rate over it"},
        {"place", "1", "distance from the true place at the end over the circle's radius"},
        {"speed", "1", "change of the speed over it"},
        {"height", "1", "largest change of the height over the ball's radius"}},
       measure_turntable},
      {"slip_onset",
       "a box on slopes that are bisected, 2 s each; friction 0.5",
       "it slips where the slope's tangent exceeds mu",
       "Coulomb's law",
       {{"tangent", "1", "error of the tangent at which the box comes 5 mm far, over mu"},
        {"creep", "mm/s", "speed on a slope of 0.95 mu, over 10 s"}},
       measure_slip_onset},
  };
}

std::vector<Case> rotation_cases() {
  return {
      {"top",
       "a top on a ball joint spins at 40 rad/s, leaning by 30 degrees, 3 s: once in steady precession, once "
       "released",
       "steady precession at the root of I1 cos p^2 - I3 w3 p + m g l; nutation between the roots of the "
       "cubic",
       "Goldstein, Classical Mechanics, 5.7; Klein and Sommerfeld, Theory of the Top",
       {{"precession", "1", "error of the mean rate over it"},
        {"lean", "deg", "largest deviation of the inclination in steady precession"},
        {"depth", "1", "largest error of a nutation's depth over it"},
        {"nutation", "1", "error of the nutation's mean period over it"}},
       measure_top},
      {"t_handle",
       "a T-handle turns freely about its middle axis, disturbed by 1 %, for ten flips",
       "it flips with half the period of its elliptic functions; energy and angular momentum stay",
       "Landau and Lifshitz, Mechanics, 37; Ashbaugh, Chicone and Cushman, J. Dyn. Diff. Eq. 3 (1991) 67",
       {{"flip", "1", "error of the mean time from flip to flip over it"},
        {"energy", "1", "largest change of the energy over it"},
        {"momentum", "1", "largest change of the angular momentum over it"}},
       measure_t_handle},
      {"pendulum",
       "a bar on a hinge is released at 10, 90 and 170 degrees and swings 20 times",
       "the period is 4 / w K(sin^2(a / 2)); the energy stays",
       "Landau and Lifshitz, Mechanics, 11",
       {{"10 deg", "1", "error of the mean period over it"},
        {"90 deg", "1", "as above"},
        {"170 deg", "1", "as above"},
        {"energy", "1", "largest change of the energy over that of the swing"}},
       measure_pendulum},
  };
}

std::vector<Case> structure_cases() {
  return {
      {"dominoes",
       "32 dominoes on hinges at their front edges, without friction or rebound",
       "a wave whose speed the energy of the leaning train and its shared momentum give",
       "van Leeuwen, The domino effect, Am. J. Phys. 78 (2010) 721, without friction",
       {{"speed", "1", "error of the speed from the 11th to the 31st domino over it"},
        {"arrival", "1", "error of the time at which the 11th falls over it"}},
       measure_dominoes},
      {"arch",
       "semicircular arches of 17 voussoirs on the ground, their thickness bisected, 10 s each; friction 0.9",
       "it stands where a line of thrust fits into its joints; half the weight and a thrust from that range "
       "at each end",
       "Heyman, The Masonry Arch (1982); for many voussoirs Milankovitch's 0.1075 of the radius",
       {{"thickness", "1", "error of the least thickness over it, bisected to 0.5 %"},
        {"thrust", "1", "how far the thrust lies outside the range, 1.5 times as thick as needed, over it"},
        {"weight", "1", "error of the force down at an end over half the weight"}},
       measure_arch},
      {"kapla",
       "towers of 60 and 240 planks, four a layer, stand for 20 s",
       "nothing moves",
       "statics: each layer's center lies over the middle of the one below",
       {{"60 sideways", "mm", "how far a plank of 60 has gone sideways at most"},
        {"60 height", "1", "change of the height of 60 over it"},
        {"240 sideways", "mm", "as above, of 240"},
        {"240 height", "1", "as above, of 240"}},
       measure_kapla},
  };
}

}  // namespace

const std::vector<Case>& catalog() {
  static const std::vector<Case> kCases = [] {
    std::vector<Case> all;
    for (const auto& group : {impact_cases(), friction_cases(), rotation_cases(), structure_cases()}) {
      all.insert(all.end(), group.begin(), group.end());
    }
    return all;
  }();
  return kCases;
}

const Case& find_case(const std::string& name) {
  std::string names;
  for (const Case& one : catalog()) {
    if (one.name == name) return one;
    names += (names.empty() ? "" : ", ") + one.name;
  }
  throw Error("--cases " + name + ": unknown case; there are: " + names);
}

}  // namespace scree::accuracy
