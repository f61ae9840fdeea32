// See picture.h.
#include <png.h>
#include <tools/render/picture.h>

#include <cstring>
#include <stdexcept>

namespace scree::render {

std::string to_png(const Picture& picture) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;  // a third of the time for files a tenth larger
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  constexpr int kAsIs = 0;       // eight bits a color, as they are
  constexpr int kTightRows = 0;  // one behind the other
  const int written = png_image_write_to_memory(&image, bytes.data(), &size, kAsIs, picture.bytes.data(),
                                                kTightRows, nullptr);
  if (written == 0) {
    const std::string reason = image.message;
    png_image_free(&image);
    throw std::runtime_error("PNG: " + reason);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace scree::render
