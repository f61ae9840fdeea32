// Draws a world by casting rays into it, with the queries that users call: one ray a pixel and one more from
// the sun to where it hits, and four each where colors change, so that edges are smooth.
#pragma once

#include <scree/scree.h>
#include <tools/render/camera.h>
#include <tools/render/coloring.h>
#include <tools/render/picture.h>

#include <cstdint>
#include <vector>

namespace scree::render {

inline constexpr int kSmallestSide = 16, kLargestSide = 16384;  // pixels
inline constexpr std::int64_t kMostPixels = 1 << 25;            // of a picture

struct DrawOptions {
  int width = 1280;  // pixels, each side in [kSmallestSide, kLargestSide], at most kMostPixels in all
  int height = 720;
  ColorBy color_by = ColorBy::body;
  bool smooth = true;  // draw edges by four rays a pixel
  float reach = 1.0f;  // m, of the subject: lines on the ground are as far apart as suits it, and haze begins
  std::vector<ShapeId> left_out{};  // shapes that are not drawn and throw no shadow; ascending by index
};

// Unit, towards the sun: from the left of the camera, behind it and above.
Vec3 sun_of(const Camera& camera);

struct Drawing {
  Picture picture;
  std::uint64_t rays = 0;  // that were cast, those from the sun included
};

// The same bytes for any number of threads and any instruction set.
Drawing draw(const World& world, const Camera& camera, const DrawOptions& options, Workers& workers);

}  // namespace scree::render
