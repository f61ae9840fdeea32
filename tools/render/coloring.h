// What color a body is drawn in.
#pragma once

#include <scree/scree.h>

#include <span>
#include <string>
#include <vector>

namespace scree::render {

// A quantity that colors show. Fixed bodies are gray.
enum class ColorBy {
  body,   // a color of a palette by the body's index
  part,   // the same by the shape's
  speed,  // m/s of the center of mass, from dark violet (0) over teal (2.3) to yellow (20)
  sleep,  // awake: orange; asleep: blue
  type,   // dynamic: orange; kinematic: blue
};

// All of them, in order.
std::span<const char* const> color_names();

// Linear light: red, green and blue, each from 0 to 1.
using Color = Vec3;

// As BodyId::index counts; of bodies that do not live, any.
std::vector<Color> color_bodies(const World& world, ColorBy by);
Color fixed_color();

// By a number, so that neighbors differ. Beyond kPaletteSize colors come again in other shades.
inline constexpr std::uint32_t kPaletteSize = 12;
Color palette_color(std::uint32_t number);

// From what a file states (0 to 255, sRGB) and back. Squares and roots stand for the curve of sRGB: off by
// 0.03 at most.
Color color_of(int red, int green, int blue);
std::uint8_t byte_of(float light);

}  // namespace scree::render
