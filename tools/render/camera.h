// Where a picture is taken from.
#pragma once

#include <scree/scree.h>

#include <vector>

namespace scree::render {

inline constexpr double kDefaultView = 40.0;  // degrees

// A pinhole. Its picture is upright along `up`, which need not be perpendicular to the line of sight.
struct Camera {
  Vec3 eye{0.0f, 0.0f, 1.0f};  // m
  Vec3 target{};               // m, in the middle of the picture
  Vec3 up{0.0f, 1.0f, 0.0f};   // unit
  double view = kDefaultView;  // degrees between the lower and the upper edge, in (0, 180)
};

// Right-handed: the camera looks along -backward.
struct Axes {
  Vec3 right, up, backward;  // unit
};

// Of the camera. Where it looks along `up`, any upright picture.
Axes axes_of(const Camera& camera);

// What pictures of a world are about: the shapes of its dynamic and kinematic bodies, without those that are
// far from all others, such as bodies that have fallen off. Where nothing moves, fixed bodies take their
// place, and where there are none a cube of 2 m.
struct Subject {
  static constexpr int kCorners = 8;

  std::vector<Vec3> corners;   // m, of boxes around the shapes, kCorners each; at least one box
  std::vector<BodyId> owners;  // by box: the body that has the shape
  Vec3 middle{};               // m, of the box around all corners
  float reach = 1.0f;          // m, from there to the farthest corner, above 0
  Vec3 up{0.0f, 1.0f, 0.0f};   // unit, against gravity; y where there is none
};

Subject subject_of(const World& world);
// Both together; `up` is that of the first.
Subject join(const Subject& first, const Subject& second);

// From where an automatic camera looks.
enum class Side {
  corner,  // from the right of the front, and above
  front,   // along -z, where up is y
  side,    // along -x, where up is y
  top,     // down
};

// The nearest camera that has all of the subject in its picture. `aspect`: width over height.
Camera look_from(Side side, const Subject& subject, double view, double aspect);

}  // namespace scree::render
