// Uses all arithmetic of <scree/math.h> in a user's program; see NoCopyOfArithmeticIsCompiled.
#include <scree/math.h>

float use_arithmetic(scree::Pose pose, scree::Pose other, float s);

float use_arithmetic(scree::Pose pose, scree::Pose other, float s) {
  using namespace scree;
  Vec3 a = pose.position, b = other.position;
  a += b, a -= s * b, a *= s, a /= s;
  b = -a + lerp(a, b, s) * s - normalize(a) / s;
  Quat q = pose.rotation;
  q *= conjugate(other.rotation);
  b += rotate(normalize(q), a) + rotate_back(q, cross(a, b));
  const Pose all = inverse(pose) * other;
  b[1] = length_squared(transform(all, a)) + dot(q, all.rotation);
  return dot(a, b) + length(transform_back(all, b)) + distance(a, b) + b[2];
}
