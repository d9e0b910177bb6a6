#include <sluice/image.h>

#include "io/pictures/png_file.h"
#include "src/base/error.h"

namespace sluice {
namespace {

Rgba8Picture shown(const Image& image, const std::optional<std::array<float, 3>>& background) {
  const auto width = static_cast<size_t>(image.width), height = static_cast<size_t>(image.height);
  if (image.width < 1 || image.height < 1 || image.rgba.size() != width * height * 4)
    failRequest("an image of {} x {} pixels with {} values in rgba: must be 4 a pixel", image.width,
                image.height, image.rgba.size());
  return {image.width, image.height,
          background ? rgba8Over(image.rgba, *background) : rgba8(image.rgba)};
}

}  // namespace

std::vector<uint8_t> Image::toRgba8(const std::optional<std::array<float, 3>>& background) const {
  return shown(*this, background).rgba;
}

void Image::writePng(const std::string& path,
                     const std::optional<std::array<float, 3>>& background) const {
  sluice::writePng(path, shown(*this, background));
}

}  // namespace sluice
