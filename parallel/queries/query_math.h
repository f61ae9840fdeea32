// Vectors in double precision, for queries alone: rays may be a billion times as long as the shapes that they
// meet.
#pragma once

#include <scree/math_types.h>

#include <cmath>

namespace scree::queries {

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;

  double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator-(Vector a) { return {-a.x, -a.y, -a.z}; }
inline Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
// Zero stays zero.
inline Vector normalize(Vector a) {
  const double size = length(a);
  return size > 0.0 ? (1.0 / size) * a : a;
}

inline Vector to_vector(Vec3 v) { return {v.x, v.y, v.z}; }
inline Vector to_vector(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
inline Vec3 to_vec3(Vector v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// A rotation matrix by its columns: where the axes go.
struct Axes {
  Vector x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};
};
inline Vector operator*(const Axes& axes, Vector v) { return v.x * axes.x + v.y * axes.y + v.z * axes.z; }
inline Vector turn_back(const Axes& axes, Vector v) {
  return {dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)};
}
// Of a quaternion of about unit length, which is made one of unit length.
inline Axes to_axes(Quat q) {
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  const double s = 2.0 / (x * x + y * y + z * z + w * w);
  return {{1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
          {s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)},
          {s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)}};
}

}  // namespace scree::queries
