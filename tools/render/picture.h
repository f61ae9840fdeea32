// A picture in memory, and its bytes as a PNG file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scree::render {

// Rows from the top, pixels from the left, three bytes each: red, green, blue of the color space sRGB.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bytes;

  const std::uint8_t* pixel(int x, int y) const {
    return bytes.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

// The bytes of a PNG file. Throws std::runtime_error with libpng's reason, and std::bad_alloc.
std::string to_png(const Picture& picture);

}  // namespace scree::render
