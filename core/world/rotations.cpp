// Makes rotations from angles. Sines and arcs are sums of our own in double precision, because results of the
// platforms' functions differ: a program that places bodies by them gets the same scene everywhere.
#include <core/world/fp_environment.h>
#include <core/world/math.h>
#include <scree/math.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace scree {

namespace {

constexpr double kPi = std::numbers::pi;

struct SineCosine {
  double sine, cosine;
};

// Within 1e-12 for angles up to 1e6.
SineCosine sine_cosine(double angle) {
  const double quarter = std::floor(angle * (2.0 / kPi) + 0.5);
  // pi / 2 in two parts, the first of few bits: its products with whole numbers are exact.
  const double x = (angle - quarter * 1.5707963109016418) - quarter * 1.5893254773528196e-8;
  const double s = x * x;
  double sine = 0.0, cosine = 0.0;  // Taylor's series within pi / 4, from the last term on
  for (int k = 7; k >= 1; --k) {
    sine = -(1.0 + sine) * s / (2 * k * (2 * k + 1));
    cosine = -(1.0 + cosine) * s / ((2 * k - 1) * 2 * k);
  }
  sine = x * (1.0 + sine);
  cosine = 1.0 + cosine;
  switch (static_cast<long long>(quarter) & 3) {
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

struct Numbers {
  double x, y, z, w;
};

Numbers in_double(Quat q) {
  return {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z),
          static_cast<double>(q.w)};
}

Quat unit(const Numbers& n) {
  const double size = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z + n.w * n.w);
  return {static_cast<float>(n.x / size), static_cast<float>(n.y / size), static_cast<float>(n.z / size),
          static_cast<float>(n.w / size)};
}

double sine_of_half(const Numbers& n) { return std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z); }

}  // namespace

double arc_of(double y, double x) {
  const bool steep = y > x;
  if (steep) std::swap(x, y);
  // Turned by pi / 8, what is left is within that: tan(pi / 8) = sqrt(2) - 1.
  const double tangent = std::numbers::sqrt2 - 1.0;
  const double t = (y - tangent * x) / (x + tangent * y), s = t * t;
  double sum = 0.0;
  for (int k = 12; k >= 0; --k) sum = 1.0 / (2 * k + 1) - s * sum;
  const double angle = kPi / 8.0 + t * sum;
  return steep ? kPi / 2.0 - angle : angle;
}

Quat from_axis_angle(Vec3 axis, float angle) {
  const FpEnvironment environment;
  const double x = static_cast<double>(axis.x), y = static_cast<double>(axis.y),
               z = static_cast<double>(axis.z);
  const double size = std::sqrt(x * x + y * y + z * z);
  if (!(size > 0.0)) return {};
  const SineCosine half = sine_cosine(0.5 * static_cast<double>(angle));
  const double scale = half.sine / size;
  return unit({x * scale, y * scale, z * scale, half.cosine});
}

AxisAngle to_axis_angle(Quat q) {
  const FpEnvironment environment;
  const Numbers n = in_double(q);
  const double sine = sine_of_half(n);
  if (!(sine > 0.0)) return {};
  const double scale = (n.w < 0.0 ? -1.0 : 1.0) / sine;
  return {{static_cast<float>(n.x * scale), static_cast<float>(n.y * scale), static_cast<float>(n.z * scale)},
          static_cast<float>(2.0 * arc_of(sine, std::abs(n.w)))};
}

float angle_of(Quat q) {
  const FpEnvironment environment;
  const Numbers n = in_double(q);
  const double sine = sine_of_half(n);
  return sine > 0.0 ? static_cast<float>(2.0 * arc_of(sine, std::abs(n.w))) : 0.0f;
}

Quat slerp(Quat a, Quat b, float t) {
  const FpEnvironment environment;
  const Numbers p = in_double(a);
  Numbers q = in_double(b);
  if (p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w < 0.0) q = {-q.x, -q.y, -q.z, -q.w};
  const Numbers way{q.x - p.x, q.y - p.y, q.z - p.z, q.w - p.w};
  const Numbers sum{q.x + p.x, q.y + p.y, q.z + p.z, q.w + p.w};
  const double angle = 2.0 * arc_of(std::sqrt(sine_of_half(way) * sine_of_half(way) + way.w * way.w),
                                    std::sqrt(sine_of_half(sum) * sine_of_half(sum) + sum.w * sum.w));
  double from = 1.0 - static_cast<double>(t), to = static_cast<double>(t);
  if (angle > 1e-6) {  // below, the arc is its chord to the last bit
    const double sine = sine_cosine(angle).sine;
    from = sine_cosine(from * angle).sine / sine;
    to = sine_cosine(to * angle).sine / sine;
  }
  return unit({from * p.x + to * q.x, from * p.y + to * q.y, from * p.z + to * q.z, from * p.w + to * q.w});
}

}  // namespace scree
