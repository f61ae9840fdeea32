// Sine and cosine for scenes: libm's differ from machine to machine in the last bit, these do not.
#pragma once

#include <scree/math_types.h>

#include <cmath>

namespace scree::scenes {

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

/// Of an angle in degrees; exact at multiples of 90 degrees, elsewhere within a few units of 1e-16.
inline SineCosine sine_cosine(double degrees) {
  const double turned = std::fmod(degrees, 360.0);  // exact by IEEE-754
  const double quarter = std::floor(turned / 90.0 + 0.5);
  const double x = (turned - quarter * 90.0) * (3.14159265358979323846 / 180.0);  // in [-pi/4, pi/4]
  const double square = x * x;
  // Taylor's series; on pi/4 the first term left out is below 1e-18.
  double sine = 1.0;
  for (int n = 18; n >= 2; n -= 2) sine = 1.0 - sine * square / static_cast<double>(n * (n + 1));
  sine *= x;
  double cosine = 1.0;
  for (int n = 18; n >= 2; n -= 2) cosine = 1.0 - cosine * square / static_cast<double>(n * (n - 1));
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

/// The rotation by an angle about an axis of any length but zero.
inline Quat rotation_about(Vec3 axis, double degrees) {
  const auto [sine, cosine] = sine_cosine(0.5 * degrees);
  const double x = axis.x;
  const double y = axis.y;
  const double z = axis.z;
  const double scale = sine / std::sqrt(x * x + y * y + z * z);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale),
          static_cast<float>(cosine)};
}

}  // namespace scree::scenes
