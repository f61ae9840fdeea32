// Exact sums of the moments of mass. A body of many shapes keeps them, so that adding or removing a shape
// costs the same for any number of shapes.
//
// A sum is not rounded. So it does not depend on the order of its parts, and removing a part leaves what was
// there before: a body's mass depends on its present shapes alone.
#pragma once

#include <cstdint>

namespace scree {

// Entries of a symmetric matrix, in the order of InertiaRow.
enum { XX, XY, XZ, YY, YZ, ZZ };

struct Symmetric {
  double m[6]{};
};

// Mass, center and inertia about the center, of one part or of many.
struct MassSum {
  double mass = 0.0;   // kg
  double center[3]{};  // m, in the body's frame
  Symmetric inertia;   // kg m^2, about the center in the body's axes
};

// An unevaluated sum of two doubles, of which the second is within the rounding of the first.
struct Twofold {
  double high = 0.0, low = 0.0;
};

// A sum of doubles, exact to 2^-280, as a whole number of 512 bits. Terms and sums stay below 2^168: those of
// the heaviest world, 2^31 shapes of 1e26 kg at 1e5 m, stay below 2^152.
class ExactSum {
 public:
  void add(double value);
  void add(Twofold value) { add(value.high), add(value.low); }
  Twofold value() const;  // to 100 bits at least

 private:
  static constexpr int kWords = 8;
  static constexpr int kLowestExponent = -280;
  std::uint64_t word_[kWords]{};  // two's complement, the lowest first
};

// Of parts in a body's frame.
class MassMoments {
 public:
  void add(const MassSum& part) { change(part, 1.0); }
  void remove(const MassSum& part) { change(part, -1.0); }  // which has been added
  std::int64_t parts() const { return parts_; }
  MassSum sum() const;

 private:
  void change(const MassSum& part, double sign);

  std::int64_t parts_ = 0;
  ExactSum mass_;            // kg
  ExactSum first_[3];        // kg m, about the body's origin
  ExactSum second_[6];       // kg m^2, of the parts' centers about the body's origin
  ExactSum own_inertia_[6];  // kg m^2, of the parts about their centers
};

}  // namespace scree
