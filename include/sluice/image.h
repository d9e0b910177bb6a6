// Image: a picture as it was drawn.
#pragma once

#include <sluice/error.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sluice {

// Row 0 is the top row, x grows to the right; pixels are packed.
struct Image {
  int width = 0, height = 0;
  // width * height * 4, red first, premultiplied by alpha, sRGB as shown on a screen.
  std::vector<float> rgba;
  // Empty, or width * height: distance from the eye along the view in world units, the mean of the
  // samples weighted by what each adds to the opacity; infinity where nothing is visible.
  std::vector<float> depth;
  // The share of what can be seen that had not been read by PictureOptions::time_limit_s. 0:
  // complete.
  double missing_share = 0;
  // Parts are drawn from coarser levels of resolution because their data did not come by
  // PictureOptions::time_limit_s. The next picture of this view shows more of them as they are.
  bool will_improve = false;

  // width * height * 4 bytes, red first, straight alpha. Over a background (red, green, blue, 0 to
  // 1) alpha is 255. Throws Error if rgba is not of the image's size.
  std::vector<uint8_t> toRgba8(const std::optional<std::array<float, 3>>& background = {}) const;

  // toRgba8() as a PNG file, which appears whole or not at all and replaces one that is there.
  // Throws Error, which names the file.
  void writePng(const std::string& path,
                const std::optional<std::array<float, 3>>& background = {}) const;
};

}  // namespace sluice
