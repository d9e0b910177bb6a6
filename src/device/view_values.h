// Values that views and devices share.
#pragma once

namespace sluice {

enum class Projection { kOrtho, kPerspective };

struct PictureSize {
  int width = 512, height = 512;
};

}  // namespace sluice
