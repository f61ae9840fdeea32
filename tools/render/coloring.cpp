// See coloring.h.
#include <tools/render/coloring.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace scree::render {
namespace {

constexpr const char* kNames[] = {"body", "part", "speed", "sleep", "type"};

// The hue of each differs from those of its neighbors.
constexpr std::uint8_t kPalette[kPaletteSize][3] = {
    {226, 138, 66}, {86, 140, 196},  {206, 96, 86},  {112, 168, 92},  {232, 190, 84},  {124, 112, 176},
    {84, 168, 164}, {214, 140, 160}, {160, 122, 92}, {150, 186, 210}, {178, 196, 110}, {222, 168, 132}};

// Matplotlib's viridis at 0, 1/4, 1/2, 3/4 and 1.
constexpr std::uint8_t kViridis[][3] = {
    {68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};

Color orange() { return color_of(226, 138, 66); }
Color blue() { return color_of(86, 140, 196); }

Color speed_color(float speed) {
  constexpr float kHalf = 3.0f, kMost = 20.0f;  // m/s
  // speed / (speed + kHalf) is 1/2 at kHalf; scaled so that it is 1 at kMost.
  const float share = std::min(speed / (speed + kHalf) * (kMost + kHalf) / kMost, 1.0f) *
                      static_cast<float>(std::size(kViridis) - 1);
  const auto low = std::min(static_cast<std::size_t>(share), std::size(kViridis) - 2);
  const auto at = [](std::size_t i) { return color_of(kViridis[i][0], kViridis[i][1], kViridis[i][2]); };
  return lerp(at(low), at(low + 1), share - static_cast<float>(low));
}

Color color_body(const World& world, BodyId body, ColorBy by) {
  const BodyType type = world.body_type(body);
  if (type == BodyType::fixed) return fixed_color();
  switch (by) {
    case ColorBy::body:
    case ColorBy::part:
      return palette_color(body.index);
    case ColorBy::speed:
      return speed_color(length(world.linear_velocity(body)));
    case ColorBy::sleep:
      return world.is_awake(body) ? orange() : blue();
    case ColorBy::type:
      break;
  }
  return type == BodyType::dynamic ? orange() : blue();
}

}  // namespace

Color fixed_color() { return color_of(168, 170, 172); }

std::span<const char* const> color_names() { return kNames; }

std::vector<Color> color_bodies(const World& world, ColorBy by) {
  std::vector<Color> colors(world.poses().size());
  for (std::uint32_t i = 0; i < colors.size(); ++i) {
    const BodyId body = world.body_at(i);
    if (world.is_alive(body)) colors[i] = color_body(world, body, by);
  }
  return colors;
}

Color palette_color(std::uint32_t number) {
  constexpr std::uint32_t kStride =
      5;  // prime to the size of the palette: neighbors never have the same color
  const auto& [red, green, blue] = kPalette[kStride * (number % kPaletteSize) % kPaletteSize];
  // The shade scatters by the golden section of 2^32 (Knuth, The Art of Computer Programming 3, 6.4).
  const std::uint32_t scattered = number * 2654435769u;
  const float shade = 0.82f + 0.18f * static_cast<float>(scattered >> 24) / 255.0f;
  return shade * color_of(red, green, blue);
}

Color color_of(int red, int green, int blue) {
  const auto light = [](int byte) {
    const float share = static_cast<float>(byte) / 255.0f;
    return share * share;
  };
  return {light(red), light(green), light(blue)};
}

std::uint8_t byte_of(float light) {
  return static_cast<std::uint8_t>(255.0f * std::sqrt(std::clamp(light, 0.0f, 1.0f)) + 0.5f);
}

}  // namespace scree::render
