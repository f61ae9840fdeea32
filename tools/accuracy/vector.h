// Vectors in double precision for the evaluation of the accuracy suite.
#pragma once

#include <scree/math_types.h>

#include <cmath>

namespace scree::accuracy {

struct Vector {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

inline Vector to_vector(Vec3 v) { return {double{v.x}, double{v.y}, double{v.z}}; }
inline Vec3 to_float(Vector v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// By a rotation of any length but zero.
inline Vector rotate(Quat rotation, Vector v) {
  const Vector q = to_vector({rotation.x, rotation.y, rotation.z});
  const double w = double{rotation.w};
  const Vector t = 2.0 * cross(q, v);
  return v + (1.0 / (dot(q, q) + w * w)) * (w * t + cross(q, t));
}
inline Vector rotate_back(Quat rotation, Vector v) {
  return rotate({-rotation.x, -rotation.y, -rotation.z, rotation.w}, v);
}

}  // namespace scree::accuracy
